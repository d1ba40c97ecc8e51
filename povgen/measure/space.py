"""A drawing of a scene in space: its windows, its objects, the eye, and rays of light."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from povgen.errors import input_errors
from povgen.files import checked_output
from povgen.measure.plotting import GREY, IDEAL, PRISMS, AutoLocator, Axes, drawn, name_lines, withStroke
from povgen.objects.scene_object import SceneObject
from povgen.optics import faces
from povgen.optics.equations import Floats, real
from povgen.optics.opening import Opening
from povgen.optics.rays import Traced
from povgen.optics.trace import End
from povgen.record import DRAWINGS, recorded_call, saved_with
from povgen.scene.presets import input_files
from povgen.scene.scene import Scene, checked_scene
from povgen.settings import Print
from povgen.sheets.prisms import Prisms
from povgen.video.side import named_windows
from povgen.video.still import record_of

Look = dict[str, Any]  # of a line, for matplotlib
Line = tuple[Floats, Look]  # points (n, 3), and their look
Ray = tuple[Floats, Floats, Look]  # its path (n, 3), its direction behind the path, which is 0 if it ends, and its look
WIDTH, HEIGHTS = 9, (3, 9)  # inches
RAYS = (11, 8)  # from the eye, across the picture and upwards
OBJECT = "#8a6800"
DESIGNED: Look = {"label": "designed path", "color": IDEAL}
STRAY: Look = {"label": "other rays", "color": GREY, "linestyle": (0, (6, 3))}
FARTHEST = 4  # what is farther from the eye than this multiple of the windows' distance is left out
THICK = 0.8, 1.5  # of rays, points: few are thicker
FEW = 12  # prisms across a window, whose sections can be told apart
EDGE = np.array((0.02, 0.06))  # from what is seen to the drawing's sides, and up and down, where names stand
MARGIN, BEYOND = 0.3, 100  # how far a ray that leaves is seen, at least, and drawn, as multiples of the scene's size


@recorded_call
@input_errors()
def draw(
    scene: Scene,
    output: str | Path,
    traced: Traced | None = None,
    *,
    azimuth: float = -65,
    elevation: float = 20,
    dpi: float | None = None,
    width: float | None = None,
    title: str = "",
) -> Path:
    """Draw the scene in space with rays of light, to scale, and write it to a .png, .svg or .pdf file. Return its path.

    `traced` are rays whose paths were kept: `scene.trace(rays, path=True)`. Without them, they are rays from the eye
    through a grid of points of the picture. Rays on the designed path are orange, others grey and dashed. Rays that
    leave go on to the edge of the drawing, also past objects; crosses are where others end. Names say what is a window
    or an object, and what is the eye, or the point from which all rays come. Of sheets with up to 12 prisms, the
    prisms' middle sections are drawn. The drawing is seen from far away at this azimuth and elevation, degrees: -90 and
    0 are a side view, with z to the right, and -90 and 90 a view from above. Views along x, y or z have axes with
    numbers. Others have an arrow along each axis. `title` is written above it. The file has `dpi` dots an inch, 50 to
    1200, and is `width` millimetres wide, 40 to 300. Raises InputError for a file that cannot be written, for rays
    without paths, and without matplotlib.
    """
    scene = checked_scene(scene)
    target = checked_output(output, DRAWINGS, inputs=input_files([scene]))
    printed = Print(dpi=dpi, width=width)
    if traced is not None and not (isinstance(traced, Traced) and traced.corners.shape[-2]):
        raise ValueError("traced: the paths were not kept; allowed: rays of trace(..., path=True)")
    if not np.isfinite(real("azimuth, elevation", (azimuth, elevation))).all():
        raise ValueError(f"azimuth, elevation = {azimuth:g}, {elevation:g}: allowed: finite numbers, degrees")
    sides = _sides(azimuth, elevation)
    straight = bool((abs(sides).max(1) == 1).all())
    ways = sides.sum(1) if straight else np.ones(2)  # an axis with numbers may run to the left or down
    sides *= ways[:, None]
    sections, solid = _sections(scene), _solid(scene, straight)
    rays = _rays(scene.trace(scene.rays(RAYS), path=True) if traced is None else traced)
    names = _names(scene, rays)
    whole = np.concatenate([*(points for _, points, _ in names), *(points for points, _ in solid), *sections])
    size = float(np.linalg.norm(np.ptp(whole, axis=0))) or 1.0
    # stray light may go anywhere
    near = [_extended(ray, MARGIN * size) for ray in rays if ray[2] is DESIGNED or traced is None]
    low_high = _corners(np.concatenate([whole, *near]) @ sides.T)
    across, up = np.ptp(low_high, axis=0)
    height = np.clip(WIDTH * up / across, *HEIGHTS)
    with saved_with(record_of([scene])), drawn(WIDTH, height, target, printed=printed, roomy=True) as figure:
        axes = figure.add_subplot()
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_title(title, parse_math=False)
        _plot_things(axes, sections, solid, sides)
        _plot(axes, rays, sides, BEYOND * size)
        for name, points, colour in names:
            _write(axes, name, points @ sides.T, colour)
        axes.set_xlim(*low_high[:, 0], auto=True)  # True: one of the axes may be longer
        axes.set_ylim(*low_high[:, 1], auto=True)
        if straight:
            _number(axes, sides, ways)
        else:
            _add_arrows(axes, sides, low_high[0])
        _name_rays(axes, rays, sides, MARGIN * size)
    return target


def _corners(seen: Floats) -> Floats:
    """Return the lower left and the upper right corner of a drawing (2, 2) in which points (n, 2) are seen."""
    edge = EDGE * np.ptp(seen, axis=0).max()
    return np.stack((seen.min(0) - edge, seen.max(0) + edge))


def _plot_things(axes: Axes, sections: Sequence[Floats], solid: Sequence[Line], sides: Floats) -> None:
    """Draw sections of prisms, and outlines."""
    for corners in sections:
        axes.fill(*(corners @ sides.T).T, facecolor=(PRISMS, 0.12), edgecolor=PRISMS, linewidth=0.8)
    for points, look in solid:
        axes.plot(*(points @ sides.T).T, **look)


def _solid(scene: Scene, straight: bool) -> list[Line]:
    """Return the outlines of objects and windows. In a straight view, sections of prisms stand for their window."""
    lines: list[Line] = [(each.edges, {"color": OBJECT, "linewidth": 1}) for each in _near(scene)]
    shown = (opening for opening in scene.openings if not (straight and _few(opening)))
    return [*lines, *((opening.edge, {"color": PRISMS, "linewidth": 2}) for opening in shown)]


def _few(opening: Opening) -> bool:
    return isinstance(opening.sheet, Prisms) and opening.sheet.values["prisms"] <= FEW


def _sections(scene: Scene) -> list[Floats]:
    """Return the sections of few prisms, across their middle: corners (5, 3)."""
    found = []
    for opening in filter(_few, scene.openings):
        sheet, pose = opening.sheet, opening.pose
        for glass in sheet.glass:
            across = np.array([[-np.sin(glass.angle), np.cos(glass.angle), 0], [0, 0, 1]]) @ glass.axes
            for corners in faces.sections(glass, sheet.aperture):
                if abs(corners[:, 0]).max() <= sheet.aperture / 2:
                    own = corners[[0, 1, 2, 3, 0]] @ across + (0, 0, glass.centre)
                    found.append(own @ pose.axes + pose.place)
    return found


def _near(scene: Scene) -> list[SceneObject]:
    """Return the objects that take room, without those that are too far away."""
    eye, edges = np.array(scene.camera.eye), [opening.edge for opening in scene.openings]
    far = FARTHEST * max((float(np.linalg.norm(edge.mean(0) - eye)) for edge in edges), default=10.0)
    return [each for each in scene.contents if np.ptp(each.box) and np.linalg.norm(each.pose.place - eye) < far]


def _names(scene: Scene, rays: Sequence[Ray]) -> list[tuple[str, Floats, str]]:
    """Return what is written in the drawing: a name, the points (n, 3) that it is for, and its colour."""
    eye = np.array([scene.camera.eye])
    starts = np.array([path[0] for path, _, _ in rays])
    is_source = len(rays) > 1 and np.ptp(starts, axis=0).max() < 1e-9 < abs(starts[0] - eye).max()
    objects = [(each.name or each.called, each.edges, OBJECT) for each in _near(scene) if each.point is not None]
    windows = [(name, edge, PRISMS) for name, edge in named_windows(scene)]
    return [("point", starts[:1], "black") if is_source else ("eye", eye, "black"), *windows, *objects]


def _write(axes: Axes, name: str, points: Floats, colour: str) -> None:
    """Write a name above points (n, 2) of the drawing. Draw a single point, and write its name below it."""
    if len(points) == 1:
        axes.plot(*points.T, "o", color=colour, zorder=3)
    above = (points[:, 0].min() + points[:, 0].max()) / 2, points[:, 1].max()
    up, va = (6, "bottom") if len(points) > 1 else (-6, "top")
    text = axes.annotate(name, above, (0, up), textcoords="offset points", ha="center", va=va, color=colour)
    text.set_path_effects([withStroke(linewidth=3, foreground="white")])


def _rays(found: Traced) -> list[Ray]:
    """Return the rays. Those on the designed path are last, on top."""
    corners, ways = found.corners.reshape(-1, *found.corners.shape[-2:]), found.direction.reshape(-1, 3)
    leaves = np.isin(found.end, (End.THROUGH, End.BACK, End.BESIDE)).reshape(-1, 1)
    looks = [DESIGNED if designed else STRAY for designed in found.designed.flat]
    paths = (path[np.isfinite(path[:, 0])] for path in corners)
    rays = zip(paths, leaves * np.nan_to_num(ways), looks, strict=True)
    return sorted(rays, key=lambda ray: ray[2] is DESIGNED)


def _plot(axes: Axes, rays: Sequence[Ray], sides: Floats, far: float) -> None:
    """Draw the rays."""
    thick = float(np.clip(30 / max(len(rays), 1), *THICK))
    for ray in rays:
        end: Look = {} if ray[1].any() else {"marker": "x", "markevery": [-1], "markersize": 5}
        axes.plot(*(_extended(ray, far) @ sides.T).T, linewidth=thick, **ray[2] | {"label": "_"}, **end)


def _name_rays(axes: Axes, rays: Sequence[Ray], sides: Floats, far: float) -> None:
    """Write what rays are beside one of each kind."""
    found: dict[str, tuple[Floats, Look]] = {}
    for ray in rays:
        corners = _extended(ray, far) @ sides.T
        n = np.linspace(0, len(corners) - 1, 20 * len(corners))
        found[ray[2]["label"]] = np.stack([np.interp(n, range(len(corners)), each) for each in corners.T], 1), ray[2]
    name_lines(axes, *((name, points, look["color"]) for name, (points, look) in found.items()))


def _extended(ray: Ray, far: float) -> Floats:
    path, way, _ = ray
    return np.vstack((path, path[-1] + far * way))


def _sides(azimuth: float, elevation: float) -> Floats:
    """Return the directions to the right and up in the drawing, (2, 3)."""
    a, e = np.radians((azimuth, elevation))
    up = np.sin(e) * np.sin(a), np.cos(e), -np.sin(e) * np.cos(a)
    return np.array([(-np.cos(a), 0, -np.sin(a)), up]).round(12)


def _number(axes: Axes, sides: Floats, ways: Floats) -> None:
    """Write numbers at the axes of a drawing along x, y or z. An axis with the way -1 runs to the left or down."""
    for axis, side, way in zip((axes.xaxis, axes.yaxis), sides, ways, strict=True):
        axis.set_label_text(f"{'xyz'[side.argmax()]} (tiles)")
        axis.set_inverted(way < 0)
    axes.spines[:].set_visible(True)


def _add_arrows(axes: Axes, sides: Floats, corner: Floats) -> None:
    """Draw an arrow along x, y and z at the lower left corner of a drawing, and write how long they are."""
    across = float(np.ptp(axes.get_xlim()))
    length = float(AutoLocator().tick_values(0, across / 2)[1])
    tips = length * sides.T
    start = corner + (0, 0.05 * across) - 1.3 * tips.clip(max=0).min(0)
    for name, tip in zip("xyz", tips, strict=True):
        axes.annotate("", start + tip, start, arrowprops={"arrowstyle": "->", "shrinkA": 0, "shrinkB": 0})
        axes.annotate(name, start + 1.2 * tip, ha="center", va="center")
    axes.annotate(f"arrows: {length:g} tile{'s' * (length != 1)}", corner)
    axes.set_axis_off()
