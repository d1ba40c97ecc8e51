"""Compare sheets of Dove prisms with lenticular arrays: `python docs/lenticulars.py` prints the table of
docs/lenticulars.md and writes its chart. A tile is 10 cm: the window's side is 30 cm, the eye 1 m before it."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from lines import save_lines

from povgen.measure.plotting import COLOURS, GREY, PRISMS, Axes, drawn, name_lines, plain_ticks
from povgen.optics.faces import GlassSheet
from povgen.optics.ghosts import field
from povgen.optics.prism import Prism
from povgen.optics.profile import Profile, confocal, lenticulars
from povgen.optics.shares import shares
from povgen.optics.trace import Rays, pair, trace

CHART = Path(__file__).parent / "chart" / "lenticulars.png"
SIDE, EYE, OBJECT = 3.0, 10.0, 10.0  # of the window; distances of eye and object, tiles of 10 cm
PITCH = 0.02  # 2 mm
ALPHA = np.radians(66)
F, C = 1.5224, 1.5143  # refractive indices of BK7 at 486 and 656 nm; 1.5168 at 588 nm
N = 1.5168
KINDS = {
    "Dove prisms, base angle 45°": Prism(PITCH, N),
    "Dove prisms, base angle 40°, n = 1.7": Prism(PITCH, 1.7, 40),
    "confocal lenses, f-number 3": confocal(1, 3, N).scaled(PITCH),
    "confocal lenses, f-number 4": confocal(1, 4, N).scaled(PITCH),
    "confocal lenses, f-number 6": confocal(1, 6, N).scaled(PITCH),
    "thin lenticulars, f-number 2 in air": lenticulars(1, 2, N).scaled(PITCH),
}
DRAWN = [name for name in KINDS if not name.endswith(("n = 1.7", "f-number 4"))]  # in the chart


def rays(shape: Prism | Profile, n: int = 200_000) -> tuple[Rays, np.ndarray]:
    """Return what becomes of rays from the eye to the front opening of the window's frame, and their directions."""
    place = np.random.default_rng(1).uniform(-0.5, 0.5, (n, 2)) * SIDE
    depth = max(SIDE / 10, 1.02 * shape.thickness(2))  # of the frame, as in scenes
    direction = np.column_stack((place, np.full(n, EYE - depth / 2)))
    return trace([[0, 0, -EYE]], direction, pair(ALPHA, shape), SIDE, frame=depth), direction


def slopes(found: Rays) -> np.ndarray:
    return found.direction[:, :2] @ np.array([1, 1j]) / found.direction[:, 2]


def seen(length: float) -> float:
    """Return the angle, minutes of arc, in which the eye sees a displacement at the object."""
    return float(60 * np.degrees(length / abs(EYE + OBJECT * np.exp(-1j * ALPHA))))


def blur(found: Rays, direction: np.ndarray) -> float:
    """Return the RMS distance, at the object, of designed rays from a linear function of their direction."""
    on = found.designed
    s = (direction[:, 0] + 1j * direction[:, 1])[on] / EYE
    slope = slopes(found)[on]
    at = found.position[on, :2] @ np.array([1, 1j]) + (OBJECT - found.position[on, 2]) * slope
    basis = np.column_stack((np.ones(on.sum()), s, s.conj()))
    fit, *_ = np.linalg.lstsq(basis, at, rcond=None)
    return float(np.sqrt(np.mean(abs(at - basis @ fit) ** 2)))


def changed(shape: Prism | Profile, other: Prism | Profile) -> float:
    """Return by how much, RMS in minutes of arc, the direction of the same rays differs behind two pairs of sheets."""
    (one, _), (two, _) = rays(shape, 50_000), rays(other, 50_000)
    both = one.designed & two.designed
    return float(60 * np.degrees(np.sqrt(np.mean(abs(slopes(one)[both] - slopes(two)[both]) ** 2))))


def coloured(shape: Prism | Profile, n: float) -> Prism | Profile:
    """Return the shape with its index for light of another colour."""
    return shape.with_length_kept(index=n) if isinstance(shape, Prism) else replace(shape, index=n)


def thicker(shape: Prism | Profile, part: float) -> Prism | Profile:
    """Return the shape with its faces farther apart by a part of its thickness: lenses are then out of focus."""
    if isinstance(shape, Prism):
        return replace(shape, aspect=shape.aspect * (1 + part))
    aside = part * shape.half
    moved = [
        edge._replace(
            start=(edge.start[0], edge.start[1] + np.sign(edge.start[1]) * aside),
            end=(edge.end[0], edge.end[1] + np.sign(edge.end[1]) * aside),
        )
        for edge in shape.edges
    ]
    return replace(shape, edges=tuple(moved))


def table() -> None:
    """Print a row for each kind of sheet."""
    for name, shape in KINDS.items():
        found, direction = rays(shape)
        part = shares(found)
        limit = field(shape) if isinstance(shape, Profile) else np.nan
        values = (
            f"{100 * part.designed:.0f} %",
            f"{100 * part.stray:.0f} %",
            "–" if np.isnan(limit) else f"±{np.degrees(np.arctan(limit)):.1f}°",
            f"{seen(blur(found, direction)):.1f}′",
            f"{changed(*(coloured(shape, n) for n in (F, C))):.1f}′",
            f"{changed(shape, thicker(shape, 0.01)):.1f}′",
            f"{100 * shape.thickness(2):.1f} mm",
        )
        print(f"| {name} | {' | '.join(values)} |", flush=True)


def chart() -> None:
    """Draw the share of light on the designed path of one sheet against the field angle, and blur against the pitch."""
    with drawn(11.5, 5, CHART, CHART.with_suffix(".svg")) as figure:
        left, right = figure.subplots(1, 2)
        angles = np.arange(0, 31)
        n = 40_000
        for name in DRAWN:
            shape, found = KINDS[name], []
            for angle in np.radians(angles):
                u = np.random.default_rng(1).uniform(-0.5, 0.5, n) * PITCH
                turn = np.random.default_rng(2).uniform(0, 2 * np.pi, n)  # the field angle is in any plane
                direction = np.column_stack(
                    (np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), np.full(n, np.cos(angle)))
                )
                origin = np.column_stack((np.zeros(n), u, np.zeros(n))) - direction
                found.append(100 * trace(origin, direction, (GlassSheet(0.0, 0.0, shape),), 61 * PITCH).designed.mean())
            draw(left, angles, found, name)
        left.set(xlabel="field angle (degrees)", ylabel="light on the designed path of one sheet (%)")
        left.set(xlim=(0, 30), ylim=(0, 100), title="Dove prisms keep more light on the designed path")
        pitches = np.geomspace(0.1, 10, 15)  # mm
        for name in DRAWN:
            shape, blurs = KINDS[name], []
            for pitch in pitches:
                made = replace(shape, pitch=pitch / 100)
                blurs.append(np.hypot(seen(blur(*rays(made, 20_000))), seen(0.532 * 550e-9 * OBJECT / (pitch * 1e-3))))
            draw(right, pitches, blurs, name)
        right.set(xscale="log", yscale="log", xlim=(0.1, 10), ylim=(1, 100))
        right.set(xlabel="pitch (mm)", ylabel="RMS blur (minutes of arc)")
        right.set_title("Up to a pitch of 5 mm, prisms are sharper than lenses")
        right.axvline(5, color=GREY, linestyle=":")
        right.text(5.2, 1.05, "5 mm", color=GREY, va="bottom")
        conditions = "index 1.517; right: a point 1 m behind the window, the eye 1 m before it"
        figure.supxlabel(conditions, fontsize=11)
        for axis in (right.xaxis, right.yaxis):
            plain_ticks(axis)
        for ax in (left, right):
            ax.grid(alpha=0.25)
        save_lines(CHART.with_suffix(".csv"), left, right)
        left.legend(fontsize=11, loc="upper right")
        name_lines(right, short=lambda name: name.split(", ")[-1 if "confocal" in name else 0])


def draw(ax: Axes, x: Sequence[float], y: Sequence[float], name: str) -> None:
    """Draw a line: prisms thick and blue, lenses in other colours and dashes."""
    n = DRAWN.index(name)
    ax.plot(x, y, ("-", "-", "-.", "--")[n], color=(PRISMS, COLOURS[2], COLOURS[4], GREY)[n], linewidth=1.5, label=name)


if __name__ == "__main__":
    table()
    chart()
