"""Draw the charts of docs/beyond.md about the field of rays: `python docs/ray_field.py`.

The directions of light before a sheet have a curl, so that light has no wave fronts there. Lengths are in tiles, but in
the panel about prisms in metres and micrometres.
"""

from math import pi, radians
from pathlib import Path

import numpy as np
from lines import save_lines
from numpy.typing import NDArray

from povgen.measure.plotting import COLOURS, GREY, IDEAL, PRISMS, Axes, drawn, name_lines
from povgen.optics import equations
from povgen.optics.rays import Traced
from povgen.scene.presets import Chess
from povgen.scene.scene import Scene

ALPHA, Z1 = 66, 2.0  # degrees, tiles
PITCH, DISTANCE, RADIUS = 1e-3, 1.0, 5e-3  # of real prisms: their pitch, the object's distance, a circle; metres
START = 1.0  # of paths, tiles before the sheet
# circles, tiles: how many rays are drawn, dashes, colour, and where their name is
CIRCLES = {0.2: (8, "--", COLOURS[3], -0.33), 0.6: (18, "-", IDEAL, 0.53)}

Floats = NDArray[np.float64]


def save_charts(folder: Path) -> None:
    """Write field.png, jumps.png and curl.png into a folder, and the lines of paths and of the curl into .csv files."""
    with drawn(12, 5.2, folder / "field.png") as figure:
        rays, wave_front = figure.subplots(1, 2)
        draw_rays(rays)
        draw_wave_front(wave_front)
        save_lines(folder / "field.csv", wave_front)
    with drawn(9, 6.4, folder / "jumps.png") as figure:
        draw_pieces(*figure.subplots(2, 1, sharex=True, height_ratios=(3, 2)))
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


def wave_front(radius: float, turns: Floats) -> Floats:
    """Return how far before the ideal sheet a path round the axis is that is perpendicular to the rays, in tiles.

    It begins START tiles before the sheet, and follows a circle of this radius, tiles, through the angles `turns`,
    radians. At the place r, a complex number, the path is w tiles before the sheet, and light has the slope s = r/Z
    towards the eye. A step of the path is perpendicular to this light if dw = -Re(conj(s) dr). The midpoint method
    integrates it.
    """

    def rate(w: float) -> float:
        return -(radius**2) * complex(1 / equations.depth(Z1, w, radians(ALPHA))).imag

    w = [START]
    for step in np.diff(turns):
        w.append(w[-1] + rate(w[-1] + rate(w[-1]) * step / 2) * step)
    return np.array(w)


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
    for radius, (count, dashes, colour, y) in CIRCLES.items():
        ax.plot(*(radius * np.array([f(np.linspace(0, 2 * pi, 100)) for f in (np.cos, np.sin)])), dashes, color=colour)
        at_sheet = radius * np.exp(2j * pi * np.arange(count) / count)
        before = at_sheet * (1 + 1.5 / equations.depth(Z1, 0, radians(ALPHA)))
        ax.text(0, y, f"radius {radius:g}", color=colour, ha="center", va="center")
        for P, Q in zip(at_sheet, before, strict=True):
            look = {"arrowstyle": "-|>", "color": colour, "shrinkA": 0, "shrinkB": 0}
            ax.annotate("", (Q.real, Q.imag), (P.real, P.imag), arrowprops=look)
    ax.plot(0, 0, "o", color="black", markersize=9)
    text = f"ideal sheet, α = {ALPHA}°, as the eye sees it; arrows: from the sheet\n"
    text += f"to 1.5 tiles before it; black: the point, {Z1:g} tiles behind it"
    ax.annotate(text, (0.5, 0), (0, -45), "axes fraction", "offset points", ha="center", va="top")
    ticks = (-1, -0.5, 0, 0.5, 1)
    ax.set(
        xlim=(-1, 1), ylim=(-1, 1), aspect="equal", xlabel="x (tiles)", ylabel="y (tiles)", xticks=ticks, yticks=ticks
    )
    ax.set_title("Light of a point runs round its axis")


def draw_wave_front(ax: Axes) -> None:
    """Draw paths round the axis that are perpendicular to the rays: after a turn they are not where they began."""
    turns = np.linspace(0, 2 * pi, 97)
    for x, (radius, (_, dashes, colour, _)) in zip((365, 374), CIRCLES.items(), strict=True):
        w = wave_front(radius, turns)
        label = f"radius {radius:g} tiles: {START - w[-1]:.2f}\nnearer after a turn"
        ax.plot(np.degrees(turns), w, dashes, color=colour, linewidth=2, label=label)
        look = {"arrowstyle": "<->", "color": colour, "shrinkA": 0, "shrinkB": 0}
        ax.annotate("", (x, w[-1]), (x, START), arrowprops=look)
    ax.axhline(START, color=GREY, linestyle=":")
    ax.text(180, 1.02, "a wave front would come back to where it began", color=GREY, ha="center", va="bottom")
    ax.set(xlabel="angle on the circle (degrees)", ylabel="distance from the sheet (tiles)")
    ax.set(xlim=(0, 379), ylim=(0, 1.1), xticks=range(0, 361, 60))
    ax.set_title("No wave front: a path perpendicular to rays does not close")
    name_lines(ax)


def draw_pieces(ax: Axes, enlarged: Axes) -> None:
    """Draw the optical path on a circle round the axis: what the ideal sheet's rays demand, and what prisms do."""
    turns = np.linspace(0, 2 * pi, 60001)
    demanded = RADIUS**2 * equations.curl(DISTANCE, 0, radians(ALPHA)) / 2 * turns
    path = path_through_prisms(RADIUS * np.exp(1j * turns))
    jumps = np.where(abs(np.diff(path)) > 1e-7, np.diff(path), 0)  # between prisms
    path[1:][jumps != 0] = np.nan
    degrees = np.degrees(turns)
    ax.plot(degrees, 1e6 * demanded, color=IDEAL, linewidth=2)
    ax.text(138, 58, "what the ideal sheet's\nrays demand", color=IDEAL, ha="right", va="bottom")
    most = 1e6 * demanded[-1]
    ax.annotate("", (360, most), (360, 0), arrowprops={"arrowstyle": "<->", "color": IDEAL, "shrinkA": 0, "shrinkB": 0})
    ax.annotate(f"{most:.0f} µm", (360, most / 2), (6, 0), textcoords="offset points", color=IDEAL, va="center")
    for each in (ax, enlarged):
        each.plot(degrees, 1e6 * (path - np.nanmean(path)), color=PRISMS, linewidth=2)
    text = f"prisms: {np.count_nonzero(jumps)} jumps between pieces,\ntogether {1e6 * jumps.sum():.0f} µm"
    ax.text(200, 14, text.replace("-", "−"), color=PRISMS, va="bottom")
    enlarged.vlines(degrees[1:][jumps != 0], -9, 9, color=PRISMS, alpha=0.2, linewidth=1)
    circle = f"circle on the sheet: radius {1e3 * RADIUS:g} mm\n"
    ax.text(5, 125, f"{circle}pitch {1e3 * PITCH:g} mm, z₁ = {DISTANCE:g} m, α = {ALPHA}°", color=GREY)
    ax.set_ylabel("optical path from the point (µm)")
    enlarged.set(xlabel="angle on the circle (degrees)", ylabel="prisms, enlarged (µm)")
    enlarged.set(xlim=(0, 360), ylim=(-12, 14), xticks=range(0, 361, 60))
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
    ax.set(
        xlabel="α (degrees)",
        xticks=range(0, 181, 30),
        ylabel="curl of the rays' slopes, on the axis (1/tile)",
        xlim=(0, 180),
        ylim=(0, 1.75),
    )
    ax.set_title("The field of rays has a curl, except at α = 0° and 180°")


if __name__ == "__main__":
    save_charts(Path(__file__).parent / "chart")
