"""Draw the charts of docs/beyond.md about real glass, polarisation and diffraction: `python docs/real_glass.py`."""

from pathlib import Path

import numpy as np
from lines import save_lines

from povgen import Bundle, Chess
from povgen.measure.plotting import GREY, Axes, drawn, plain_ticks
from povgen.optics.equations import depth
from povgen.optics.polarisation import transmission

WAVELENGTHS = {"450 nm": 450e-9, "550 nm": 550e-9, "650 nm": 650e-9}
LIGHT = {"450 nm": "#1f4fd8", "550 nm": "#2e9e2e", "650 nm": "#d11919"}  # the light's own colours
FAR = ("#8a6800", "#c1512d", "#7b4b94", "#0b2f55")  # the darker, the farther away the object
DASHES = "-", "--", "-.", ":"  # beside colours, for eyes that do not tell them apart
BLUES = ("#0b1f3a", "#0b4a85", "#1f74c4", "#3a86c8")  # prisms, the lighter the larger alpha
Z2 = 1.0  # metres
ALPHA = 66  # degrees
SHIFT = np.sqrt(2 / 3)  # RMS displacement of rays by two sheets, in pitches
# RMS angle of the diffraction at two sheets, in wavelengths/pitch: of the Gaussian as wide as sinc^2 at half maximum
SPREAD = np.sqrt(2) * 0.8858929414 / (2 * np.sqrt(2 * np.log(2)))


def save_charts(folder: Path) -> None:
    """Write polarisation.png and diffraction.png into a folder, and a table of the lines of each panel beside them."""
    with drawn(8, 4.5, folder / "polarisation.png") as figure:
        ax = figure.subplots()
        draw_polarisation(ax)
        save_lines(folder / "polarisation.csv", ax)
    with drawn(11, 5, folder / "diffraction.png") as figure:
        left, right = figure.subplots(1, 2)
        draw_blur(left)
        draw_best_pitch(right)
        save_lines(folder / "diffraction.csv", left, right)
        conditions = f"left: 550 nm, α = {ALPHA}°, the eye {Z2:g} m before the sheets; dots: the best pitch"
        figure.supxlabel(conditions, fontsize=11)
        left.legend(fontsize=11, loc="upper center")
        handles, names = right.get_legend_handles_labels()
        right.legend(handles[::-1], names[::-1], fontsize=11, loc="upper left")  # in the order of the lines


def draw_polarisation(ax: Axes) -> None:
    """Draw the share of linearly polarised light that passes two sheets, against its angle, for light along z."""
    angle = np.arange(181)
    light = Bundle(np.column_stack((np.linspace(-0.1, 0.1, 50),) * 2 + (np.ones(50),)), (0, 0, -1))
    for alpha, colour, dashes in zip((0, 66, 120, 180), BLUES, DASHES, strict=True):
        traced = Chess(alpha=alpha).trace(light, path=True)
        J = traced.jones[traced.designed][0]  # the same for all of them
        share = transmission(J, np.radians(angle))
        ax.plot(angle, share, dashes, color=colour, linewidth=2, label=f"α = {alpha}°")
        ax.text(183, share[-1], f"α = {alpha}°", color=colour, va="center")
    ax.set(xlabel="polarisation (degrees from the far sheet's ridges)", ylabel="share of the light that passes")
    ax.set(xlim=(0, 180), ylim=(0.6, 1), title="The larger α, the less polarisation matters")
    ax.set_xticks(range(0, 181, 30))
    ax.grid(alpha=0.25)


def draw_blur(ax: Axes) -> None:
    """Draw blur against pitch, for several distances of the object."""
    pitch = np.geomspace(0.03e-3, 10e-3, 300)
    for z1, colour, dashes in zip((0.3, 1.0, 3.0, 10.0), FAR, DASHES, strict=True):
        best = float(best_pitch(550e-9, z1))
        name = f"z₁ = {z1:g} m: best {1e3 * best:.1f} mm"
        ax.loglog(1e3 * pitch, minutes(pitch, z1), dashes, color=colour, linewidth=2, label=name)
        ax.plot(1e3 * best, minutes(best, z1), "o", color=colour, markersize=9)
    ax.axhline(1, color=GREY, linestyle=":")
    ax.text(0.033, 0.93, "what an eye resolves", color=GREY, va="top")
    # along the two straight parts of the curves, which fall and rise at about 45 degrees
    ax.text(0.075, 2.6, "diffraction", color=GREY, ha="center", va="center", rotation=-45)
    ax.text(5.4, 3.3, "size of prisms", color=GREY, ha="center", va="center", rotation=45)
    ax.set(xlabel="pitch (mm)", ylabel="RMS blur (minutes of arc)", ylim=(0.3, 30), xlim=(0.03, 10))
    ax.grid(alpha=0.25)
    plain_ticks(ax.xaxis, (1,))
    plain_ticks(ax.yaxis)
    ax.set_title("Each distance has a best pitch")


def minutes(pitch: float | np.ndarray, z1: float) -> np.ndarray:
    """Return the blur for 550 nm, minutes of arc. Lengths are in metres."""
    wide = np.hypot(SHIFT * pitch, SPREAD * 550e-9 * z1 / pitch)
    return np.asarray(60 * np.degrees(wide / abs(depth(z1, Z2, np.radians(ALPHA)))))


def best_pitch(wavelength: float, z1: float | np.ndarray) -> np.ndarray:
    """Return the pitch of least blur: shift and diffraction are then equal. Lengths are in metres."""
    return np.asarray(np.sqrt(SPREAD / SHIFT * wavelength * z1))


def draw_best_pitch(ax: Axes) -> None:
    """Draw the pitch of least blur against the distance of the object, for several wavelengths."""
    z1 = np.geomspace(0.1, 100, 100)
    for (name, wavelength), dashes in zip(WAVELENGTHS.items(), ("--", "-", ":"), strict=True):
        ax.loglog(z1, 1e3 * best_pitch(wavelength, z1), dashes, color=LIGHT[name], linewidth=2, label=name)
    ax.axhspan(0.1, 1, color="#e6e6e6")
    ax.text(90, 0.105, "pitches in the paper: 0.1 to 1 mm", color=GREY, ha="right", va="bottom")
    ax.set(xlabel="distance of the object z₁ (m)", ylabel="pitch of least blur (mm)", xlim=(0.1, 100))
    ax.grid(alpha=0.25)
    plain_ticks(ax.xaxis, (1,))
    plain_ticks(ax.yaxis)
    ax.set_title("The farther the object, the wider the best prisms")


if __name__ == "__main__":
    save_charts(Path(__file__).parent / "chart")
