"""Draw the charts of docs/beyond.md about the field of rays: `python docs/ray_field.py`.

The directions of light before a sheet have a curl, so that light has no wave fronts there. Lengths are in tiles, but in
the panel about prisms in metres and micrometres.
"""

from collections.abc import Callable
from math import pi, radians
from pathlib import Path
from typing import Any

import numpy as np
from lines import save_lines
from numpy.typing import NDArray

from povgen.measure.plotting import GREY, IDEAL, PRISMS, Axes, drawn
from povgen.optics import equations
from povgen.optics.rays import Traced
from povgen.scene.scene import Scene
from povgen.scene.scenes import Chess

ALPHA, Z1 = 66, 2.0  # degrees, tiles
PITCH, DISTANCE, RADIUS = 1e-3, 1.0, 5e-3  # of real prisms: their pitch, the object's distance, a circle; metres
DRAWN_RADII = {0.2: (8, "--"), 0.6: (18, "-")}  # circles on the sheet, tiles: how many rays are drawn, and dashes

Floats = NDArray[np.float64]


def save_charts(folder: Path) -> None:
    """Write field.png, jumps.png and curl.png into a folder, and the lines of paths and of the curl into .csv files."""
    with drawn(12, 5.2, folder / "field.png") as figure:
        rays, wave_front = figure.subplots(1, 2)
        draw_rays(rays)
        draw_wave_front(wave_front)
        save_lines(folder / "field.csv", wave_front)
    with drawn(9, 4.8, folder / "jumps.png") as figure:
        draw_pieces(figure.subplots())
    with drawn(9, 4.8, folder / "curl.png") as figure:
        draw_curl(curl := figure.subplots())
        save_lines(folder / "curl.csv", curl)


def light_of(scene: Scene, radius: float, count: int) -> Traced:
    """Return rays from the point (0, 0, Z1) through a disc in the middle of the window, with this radius in tiles.

    `count` rays are traced. Those on the designed path are returned.
    """
    light = scene.trace(scene.pencil((0, 0, Z1), count, radius=radius))
    return light[light.designed]


def traced_curl(light: Traced, z2: float) -> float:
    """Return the curl, per tile, of the slopes of light on the axis, z2 tiles before the window.

    A linear function of the place is fitted to the slopes of the rays, and its curl is returned. Through prisms this is
    a mean over many of them: in the light of a single prism the curl is 0.
    """
    Q, slope = light.at(-z2), -light.slope  # towards the eye
    (_, along, _), *_ = np.linalg.lstsq(np.column_stack((np.ones(len(Q)), Q, Q.conj())), slope, rcond=None)
    return 2 * float(along.imag)


def walked(start: Floats | float, steps: Floats, rate: Callable[[Floats, float], Floats]) -> Floats:
    """Integrate dw/dstep = rate(w, step) by the midpoint method. Return w at each of the places `steps`: (steps, ...).

    `start` is w at the first place: a number or, for several paths, an array.
    """
    w = [np.asarray(start, float)]
    for here, step in zip(steps, np.diff(steps), strict=False):
        middle = w[-1] + rate(w[-1], here) * step / 2
        w.append(w[-1] + rate(middle, here + step / 2) * step)
    return np.array(w)


def wave_front(radii: Floats, turns: Floats, start: float) -> Floats:
    """Return how far before the ideal sheet a surface perpendicular to the rays is, in tiles: (turns, radii).

    The surface begins on the axis, `start` tiles before the sheet. It is followed along the direction of angle 0
    through the distances `radii` from the axis, tiles. From each of these places it is followed round the axis through
    the angles `turns`, radians. Both begin with 0. At the place r, a complex number, the surface is w tiles before the
    sheet, and light has the slope s = r/Z towards the eye. A step of the surface is perpendicular to this light if
    dw = -Re(conj(s) dr).
    """

    def inverse(w: Floats) -> Any:
        return 1 / equations.depth(Z1, w, radians(ALPHA))

    along = walked(start, radii, lambda w, r: -r * inverse(w).real)
    return walked(along, turns, lambda w, _: -(radii**2) * inverse(w).imag)


def path_through_prisms(Q: NDArray[np.complex128]) -> Floats:
    """Return the optical path, metres, from a point L = 0 to points Q on the near side of two sheets of prisms.

    L is on the axis, DISTANCE behind the sheets; Q is x + iy in metres. The path is paraxial, and lacks the constant
    path in glass. Each prism mirrors light about the middle of its base. So light that passes two prisms seems to come
    from an image of L, which is different for each pair of prisms.
    """
    turn = np.exp(0.5j * radians(ALPHA))
    far, near = (PITCH * np.round(place / PITCH) for place in (Q.imag, (Q / turn).imag))
    image = 2j * (near * turn - far * turn**2)
    return np.asarray(abs(Q - image) ** 2 / (2 * DISTANCE))


def draw_rays(ax: Axes) -> None:
    """Draw, as the eye sees it, where light from a point goes before the ideal sheet: from 0 to 1.5 tiles before it."""
    for (radius, (count, dashes)), below in zip(DRAWN_RADII.items(), (-0.37, -0.56), strict=True):
        ax.plot(*(radius * np.array([f(np.linspace(0, 2 * pi, 100)) for f in (np.cos, np.sin)])), dashes, color=GREY)
        at_sheet = radius * np.exp(2j * pi * np.arange(count) / count)
        before = at_sheet * (1 + 1.5 / equations.depth(Z1, 0, radians(ALPHA)))
        ax.text(0, below, f"radius {radius:g}", color=GREY, ha="center", va="bottom")
        for P, Q in zip(at_sheet, before, strict=True):
            ax.annotate("", (Q.real, Q.imag), (P.real, P.imag), arrowprops={"arrowstyle": "-|>", "color": IDEAL})
    ax.plot(0, 0, "o", color="black", markersize=9)
    text = f"as the eye sees it; black: the point, {Z1:g} tiles behind the sheet\n"
    text += "arrows: from the sheet to 1.5 tiles before it"
    ax.text(0, -1.25, text, ha="center", va="bottom")
    ax.set(xlim=(-1.25, 1.25), ylim=(-1.25, 1.25), aspect="equal", xlabel="x, tiles", ylabel="y, tiles")
    ax.set_title(f"Light of a point runs round its axis (ideal sheet, α = {ALPHA}°)", fontsize=11)


def draw_wave_front(ax: Axes) -> None:
    """Draw paths round the axis that are perpendicular to the rays: after a turn they are not where they began."""
    turns, radii = np.linspace(0, 2 * pi, 97), np.array([0, 0.2, 0.4, 0.6])
    heights = wave_front(radii, turns, 1.0)
    for radius, height in zip(radii, heights.T, strict=True):
        if radius not in DRAWN_RADII:
            continue
        nearer = height[0] - height
        look = {"ls": DRAWN_RADII[radius][1], "color": IDEAL, "linewidth": 2}
        ax.plot(np.degrees(turns), nearer, **look, label=f"radius {radius:g} tiles")
        ax.text(364, nearer[-1], f"radius {radius:g} tiles:\n{nearer[-1]:.2f} after a turn", color=IDEAL, va="center")
    ax.text(10, 0.74, "A wave front is perpendicular to its rays.\nIt would end where it began: at 0.", color=GREY)
    ax.set(
        xlabel="angle on the circle, degrees",
        ylabel="nearer to the sheet by (tiles)",
        xlim=(0, 360),
    )
    ax.set_ylim(bottom=0)
    ax.set_title("No wave front: a path perpendicular to the rays does not close", fontsize=11)


def draw_pieces(ax: Axes) -> None:
    """Draw the optical path on a circle round the axis: what the ideal sheet's rays demand, and what prisms do."""
    turns = np.linspace(0, 2 * pi, 60001)
    demanded = RADIUS**2 * equations.curl(DISTANCE, 0, radians(ALPHA)) / 2 * turns
    path = path_through_prisms(RADIUS * np.exp(1j * turns))
    jumps = np.where(abs(np.diff(path)) > 1e-7, np.diff(path), 0)  # between prisms
    path[1:][jumps != 0] = np.nan
    degrees = np.degrees(turns)
    ax.plot(degrees, 1e6 * demanded, color=IDEAL, linewidth=2)
    ax.text(170, 84, "what the ideal sheet's\nrays demand", color=IDEAL, ha="right")
    most = 1e6 * demanded[-1]
    ax.annotate("", (360, most), (360, 0), arrowprops={"arrowstyle": "<->", "color": IDEAL, "shrinkA": 0, "shrinkB": 0})
    ax.annotate(f"{most:.0f} µm", (360, most / 2), (6, 0), textcoords="offset points", color=IDEAL, va="center")
    ax.plot(degrees, 1e6 * (path - np.nanmean(path)), color=PRISMS, linewidth=2)
    text = f"prisms: {np.count_nonzero(jumps)} jumps between pieces,\ntogether {1e6 * jumps.sum():.0f} µm"
    to = {"color": PRISMS, "arrowprops": {"arrowstyle": "->", "color": PRISMS}}
    ax.annotate(text.replace("-", "−"), (244, 5), (200, 32), **to)
    circle = f"circle on the sheet: radius {1e3 * RADIUS:g} mm\n"
    ax.text(5, 125, f"{circle}pitch {1e3 * PITCH:g} mm, z₁ = {DISTANCE:g} m, α = {ALPHA}°", color=GREY)
    ax.set(xlabel="angle on the circle, degrees", ylabel="optical path from the point (µm)", xlim=(0, 360))
    ax.set_title(f"Ideal rays demand {most:.0f} µm more in a turn; the jumps of prisms take it back")


def draw_curl(ax: Axes) -> None:
    """Draw the curl on the axis against alpha, by its formula, and as measured in the ray trace."""
    alphas = np.arange(0, 181)
    distances = {0.0: "-", 1.0: "--", 4.0: ":"}
    for z2, dashes in distances.items():
        curl = equations.curl(Z1, z2, np.radians(alphas))
        ax.plot(alphas, curl, dashes, color="#444444", linewidth=2, label=f"z₂ = {z2:g} tiles")
        highest = curl[:130].argmax()
        ax.text(alphas[highest], curl[highest] + 0.04, f"z₂ = {z2:g}", color="#444444", ha="right")
    keys = ax.lines[:1]
    for count, sheet, mark, colour in ((200, "ideal", "o", IDEAL), (3000, "detailed", "+", PRISMS)):
        for alpha in range(15, 180, 30):
            light = light_of(Chess(sheet=sheet, alpha=alpha, prisms=1000), 0.3, count)
            for z2 in distances:
                look = {"markersize": 9, "markeredgewidth": 1.8, "fillstyle": "none"}
                (marks,) = ax.plot(alpha, traced_curl(light, z2), mark, color=colour, **look)
        keys.append(marks)
    formula = f"formula; z₁ = {Z1:g} tiles, z₂: tiles before the sheet"
    ax.legend(keys, (formula, "ray trace, ideal sheet", "2 × 1000 prisms, their mean"), fontsize=11, loc="upper left")
    ax.set(xlabel="α, degrees", ylabel="curl of the rays' slopes, on the axis (1/tile)", xlim=(0, 180), ylim=(0, 1.75))
    ax.set_title("The field of rays has a curl, except at α = 0° and 180°")


if __name__ == "__main__":
    save_charts(Path(__file__).parent / "chart")
