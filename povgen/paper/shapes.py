"""Shapes and labels for the figures: in space, as a parallel projection, and in the complex plane."""

from collections.abc import Iterable, Sequence
from math import cos, radians, sin
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from povgen.measure.plotting import Axes

RAY, SHEET, GREY = "#c1272d", "#0b5fa5", "#777777"
SIDE, ABOVE = radians(32), radians(16)  # the directions of view onto space: from the side, and from above

Reals = NDArray[np.float64]
Place = tuple[float, float]
Point = Sequence[float] | Reals  # (x, y, z) in space

# ---- In the drawing's own coordinates ----


def write(ax: Axes, place: Iterable[float], text: str, **look: Any) -> None:  # noqa: ANN401  (passed on to matplotlib)
    """Write a text, centred on a place unless `look` says otherwise."""
    x, y = place
    ax.text(x, y, text, **{"ha": "center", "va": "center", **look})


def entitle(ax: Axes, number: int, title: str = "", size: float = 9) -> None:
    """Write (a) for number 0, (b) for 1, ... at the left above a panel, and a title beside it."""
    high = size // 2  # points from the axes up to the title, more for larger letters, because some hang below the line
    ax.set_title(f"({chr(97 + number)})", loc="left", fontweight="bold", pad=high, fontsize=size + 1)
    ax.annotate(title, (0, 1), (2.2 * size, high), "axes fraction", "offset points", va="baseline", fontsize=size)


def point_at(ax: Axes, place: Place, text: str, text_place: Place, colour: str = "black", size: float = 9) -> None:
    """Write a text on white, with an arrow to a place in the picture under it."""
    look = {"arrowstyle": "-|>", "color": colour, "linewidth": 1.2, "shrinkB": 0}
    box = {"facecolor": "white", "edgecolor": "none", "pad": 2, "alpha": 0.9}
    drawn = ax.annotate(text, place, text_place, arrowprops=look, bbox=box, color=colour, fontsize=size)
    drawn.set(ha="center", va="center")


def arrow(ax: Axes, start: Place, end: Place, colour: str, width: float) -> None:
    """Draw an arrow from start to end."""
    shape = {"arrowstyle": "-|>,head_length=0.5,head_width=0.22", "color": colour, "linewidth": width}
    ax.annotate("", end, start, arrowprops=shape | {"shrinkA": 0, "shrinkB": 0, "mutation_scale": 14})


# ---- In the complex plane ----


def xy(points: ArrayLike) -> tuple[Any, Any]:  # arrays, or numbers if `points` is one
    """Return the real and the imaginary parts of complex numbers."""
    return np.real(points), np.imag(points)


def arc(ax: Axes, centre: complex, radius: float, start: float, end: float, name: str, room: float) -> None:
    """Draw an arc between two angles, radians, and write its name at a radius that is larger by `room`."""
    ax.plot(*xy(centre + radius * np.exp(1j * np.linspace(start, end, 60))), color="black", linewidth=1)
    write(ax, xy(centre + (radius + room) * np.exp(0.5j * (start + end))), name)


def plane(ax: Axes, x: tuple[float, float], y: tuple[float, float]) -> None:
    """Draw the axes xi and psi through the origin, with the same scale on both."""
    ax.set(xlim=x, ylim=y, aspect="equal")
    ax.axis("off")
    for start, end, name, offset in (
        ((x[0], 0), (x[1], 0), r"$\xi$", (-4, -9)),
        ((0, y[0]), (0, y[1]), r"$\psi$", (9, -4)),
    ):
        arrow(ax, start, end, GREY, 0.9)
        ax.annotate(name, end, xytext=offset, textcoords="offset points", ha="center", va="center")


# ---- In space ----


def space(ax: Axes) -> Axes:
    """Prepare axes for drawings in space."""
    ax.set_aspect("equal")
    ax.axis("off")
    return ax


def projected(point: Point) -> Reals:
    """Return where a point (x, y, z) lies in a drawing: a parallel projection with z to the left, x into the page."""
    x, y, z = point
    right, depth = x * sin(SIDE) - z * cos(SIDE), x * cos(SIDE) + z * sin(SIDE)
    return np.array([right, y * cos(ABOVE) + depth * sin(ABOVE)])


def faces(ax: Axes, corners_of_each: Iterable[Sequence[Point]], colour: str, opacity: float, edge: str = SHEET) -> None:
    """Draw translucent polygons in space. List the farthest first."""
    for corners in corners_of_each:
        outline = np.transpose([projected(corner) for corner in corners])
        ax.fill(*outline, facecolor=colour, alpha=opacity, linewidth=0)
        ax.fill(*outline, fill=False, edgecolor=edge, linewidth=0.7)


def path(ax: Axes, points: Iterable[Point], colour: str, width: float, dashes: str = "-", head: bool = False) -> None:
    """Draw a line through points of space, with an arrowhead at its end if `head`."""
    drawn = np.array([projected(point) for point in points])
    if head:
        *_, start, end = drawn
        ax.update_datalim(drawn)  # it does not know arrows
        if dashes == "-":
            drawn = drawn[:-1]  # the arrow is the last part of the line, which would reach beyond its tip
        else:
            start = end - 1e-3 * (end - start)  # the arrow is a head alone, which has no dashes
        arrow(ax, (start[0], start[1]), (end[0], end[1]), colour, width)
    ax.plot(*drawn.T, dashes, color=colour, linewidth=width, solid_joinstyle="round")


def coordinate_axes(ax: Axes, origin: tuple[float, float, float], size: float = 0.9) -> None:
    """Draw arrows along x, y and z."""
    for n, name in enumerate("xyz"):
        end = np.array(origin, float)
        end[n] += size
        path(ax, [origin, end], "black", 1, head=True)
        end[n] += 0.28 * size
        write(ax, projected(end), f"${name}$", fontsize=11)
