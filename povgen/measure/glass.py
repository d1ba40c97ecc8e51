"""Charts of what real glass does to light on the designed path: polarisation and diffraction. Nothing is rendered."""

from pathlib import Path

import numpy as np

from povgen.measure.plotting import Axes, drawn
from povgen.optics.diffraction import best_pitch, blur
from povgen.optics.polarisation import jones, transmission
from povgen.optics.prism import Prism

WAVELENGTHS = {"450 nm": 450e-9, "550 nm": 550e-9, "650 nm": 650e-9}
Z2 = 1.0  # metres
ALPHA = 66  # degrees


def save_charts(folder: Path) -> None:
    """Write polarisation.png and diffraction.png into a folder."""
    with drawn(7, 4.5, folder / "polarisation.png") as figure:
        draw_polarisation(figure.subplots())
    with drawn(12, 4.5, folder / "diffraction.png") as figure:
        left, right = figure.subplots(1, 2)
        draw_blur(left)
        draw_best_pitch(right)


def draw_polarisation(ax: Axes) -> None:
    """Draw the share of linearly polarised light that passes two sheets, against its angle, for light along z."""
    angle = np.arange(181)
    for alpha in (0, 66, 120, 180):
        J = jones([0, 0, -1], [0, np.radians(alpha) / 2], Prism(1.0))
        ax.plot(angle, transmission(J, np.radians(angle)), label=f"α = {alpha}°")
    ax.set(xlabel="polarisation, degrees from the far sheet's ridges", ylabel="share that passes")
    ax.set(xlim=(0, 180), ylim=(0.6, 1.02), title="Two sheets, n = 1.5, 45°")
    ax.legend(ncols=4, loc="upper center")


def draw_blur(ax: Axes) -> None:
    """Draw blur against pitch, for several distances of the object."""
    pitch = np.geomspace(0.03e-3, 10e-3, 300)
    for z1 in (0.3, 1.0, 3.0, 10.0):
        (line,) = ax.loglog(1e3 * pitch, minutes(pitch, z1), label=f"z₁ = {z1:g} m")
        best = float(best_pitch(550e-9, z1))
        ax.plot(1e3 * best, minutes(best, z1), "o", color=line.get_color())
    ax.axhline(1, color="#999999", linestyle=":", label="what an eye resolves")
    ax.set(xlabel="pitch, mm", ylabel="RMS blur, minutes of arc", ylim=(0.3, 30), xlim=(0.03, 10))
    _plain_numbers(ax)
    ax.set_title(f"Blur for 550 nm, z₂ = {Z2:g} m, α = {ALPHA}°; dots: least")
    ax.legend()


def minutes(pitch: float | np.ndarray, z1: float) -> np.ndarray:
    """Return the blur for 550 nm, minutes of arc. Lengths are in metres."""
    return np.asarray(60 * np.degrees(blur(pitch, 550e-9, z1, Z2, np.radians(ALPHA))))


def draw_best_pitch(ax: Axes) -> None:
    """Draw the pitch of least blur against the distance of the object, for several wavelengths."""
    z1 = np.geomspace(0.1, 100, 100)
    for name, wavelength in WAVELENGTHS.items():
        ax.loglog(z1, 1e3 * best_pitch(wavelength, z1), label=name)
    ax.fill_between(z1, 0.1, 1, color="#dddddd", label="the paper's 100 µm to 1 mm")
    ax.set(xlabel="distance of the object z₁, m", ylabel="pitch of least blur, mm", xlim=(0.1, 100))
    _plain_numbers(ax)
    ax.set_title("The pitch of least blur")
    ax.legend()


def _plain_numbers(ax: Axes) -> None:
    """Write 0.1, 1 and 10 on logarithmic axes."""
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter("")
