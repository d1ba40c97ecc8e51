"""A drawing of a scene in space: its windows, its objects, the eye, and rays of light."""

from pathlib import Path

import numpy as np

from povgen.errors import input_errors
from povgen.files import checked_output
from povgen.measure.plotting import GREY, IDEAL, PRISMS, AutoLocator, Axes, drawn, withStroke
from povgen.objects.scene_object import SceneObject
from povgen.optics.equations import Floats
from povgen.optics.faces import sections
from povgen.optics.rays import Traced
from povgen.optics.trace import End
from povgen.record import DRAWINGS, recorded_call, saved_with
from povgen.scene.scene import Scene, checked_scene
from povgen.settings import Print
from povgen.sheets.prisms import Prisms
from povgen.video.side import named_windows
from povgen.video.still import record_of

WIDTH, HEIGHTS = 9, (3, 9)  # inches
RAYS = (11, 8)  # from the eye, across the picture and upwards
OBJECT, DESIGNED, STRAY = "#b58900", IDEAL, GREY
FARTHEST = 4  # what is farther from the eye than this multiple of the windows' distance is left out
FEW = 12  # prisms across a window, whose sections can be told apart
EDGE = 0.02  # between what is seen and the edge of the drawing, as a part of its width or height
Line = tuple[Floats, str, float]  # points (n, 3), a colour, a width
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
) -> Path:
    """Draw the scene in space with rays of light, to scale, and write it to a .png, .svg or .pdf file. Return its path.

    `traced` are rays whose paths were kept: `scene.trace(rays, path=True)`. Without them, they are rays from the eye
    through a grid of points of the picture. Rays on the designed path are red, others grey. Rays that leave go on to
    the edge of the drawing, also past objects. Names say what is an eye, a window or an object. Of sheets with up to 12
    prisms, the prisms' middle sections are drawn. The drawing is seen from far away at this azimuth and elevation,
    degrees: -90 and 0 are a side view, with z to the right, and -90 and 90 a view from above. Views along x, y or z
    have axes with numbers. Others have an arrow along each axis. `dpi`, dots an inch from 50 to 1200, and `width`,
    millimetres from 40 to 300, are those of the file. Raises InputError for a file that cannot be written, for rays
    without paths, and without matplotlib.
    """
    scene, target = checked_scene(scene), checked_output(output, DRAWINGS)
    printed = Print(dpi=dpi, width=width)
    if traced is not None and not traced.corners.shape[-2]:
        raise ValueError("traced: the paths were not kept; allowed: rays of trace(..., path=True)")
    eye, solid = np.array([scene.camera.eye]), _solid(scene)
    rays = _rays(scene.trace(scene.rays(RAYS), path=True) if traced is None else traced)
    size = float(np.linalg.norm(np.ptp(np.concatenate([eye, *(points for points, _, _ in solid)]), axis=0))) or 1.0

    def lines(farther: float) -> list[Line]:
        far = farther * size
        return [*solid, *((np.vstack((path, path[-1] + far * way)), colour, 0.8) for path, way, colour in rays)]

    sides = _sides(azimuth, elevation)
    straight = bool((abs(sides).max(1) == 1).all())
    ways = sides.sum(1) if straight else np.ones(2)  # an axis with numbers may run to the left or down
    sides *= ways[:, None]
    seen = np.concatenate([eye, *(points for points, _, _ in lines(MARGIN))]) @ sides.T
    across, up = np.ptp(seen, axis=0)
    edge = EDGE * max(across, up)
    low_high = np.stack((seen.min(0) - edge, seen.max(0) + edge))
    height = np.clip(WIDTH * up / across, *HEIGHTS)
    with saved_with(record_of([scene])), drawn(WIDTH, height, target, printed=printed, roomy=True) as figure:
        axes = figure.add_subplot()
        axes.set_aspect("equal", adjustable="datalim")
        names = {DESIGNED: "designed path", STRAY: "other rays"}
        for points, colour, thick in lines(BEYOND):
            axes.plot(*(points @ sides.T).T, color=colour, linewidth=thick, label=names.pop(colour, None))
        axes.plot(*(eye @ sides.T).T, "o", color="black")
        for name, points, colour in _names(scene):
            _write(axes, name, points @ sides.T, colour)
        if rays:
            axes.legend(frameon=True, framealpha=0.9)
        axes.set_xlim(*low_high[:, 0], auto=True)  # True: one of the axes may be longer
        axes.set_ylim(*low_high[:, 1], auto=True)
        if straight:
            _number(axes, sides, ways)
        else:
            _add_arrows(axes, sides, low_high[0])
    return target


def _solid(scene: Scene) -> list[Line]:
    """Return the outlines of objects and windows, and the sections of few prisms, across their middle."""
    lines: list[Line] = [(each.edges, OBJECT, 1.0) for each in _near(scene)]
    for opening in scene.openings:
        lines.append((opening.edge, PRISMS, 2.0))
        sheet, pose = opening.sheet, opening.pose
        few = isinstance(sheet, Prisms) and sheet.values["prisms"] <= FEW
        for glass in sheet.glass if few else ():
            across = np.array([[-np.sin(glass.angle), np.cos(glass.angle), 0], [0, 0, 1]]) @ glass.axes
            for corners in sections(glass, sheet.aperture):
                if abs(corners[:, 0]).max() <= sheet.aperture / 2:
                    own = corners[[0, 1, 2, 3, 0]] @ across + (0, 0, glass.centre)
                    lines.append((own @ pose.axes + pose.place, PRISMS, 0.8))
    return lines


def _near(scene: Scene) -> list[SceneObject]:
    """Return the objects that take room, without those that are too far away."""
    eye, edges = np.array(scene.camera.eye), [opening.edge for opening in scene.openings]
    far = FARTHEST * max((float(np.linalg.norm(edge.mean(0) - eye)) for edge in edges), default=10.0)
    return [each for each in scene.contents if np.ptp(each.box) and np.linalg.norm(each.pose.place - eye) < far]


def _names(scene: Scene) -> list[tuple[str, Floats, str]]:
    """Return what is written in the drawing: a name, the points (n, 3) that it is for, and its colour."""
    objects = [(each.name or each.called, each.edges, OBJECT) for each in _near(scene) if each.point is not None]
    windows = [(name, edge, PRISMS) for name, edge in named_windows(scene)]
    return [("eye", np.array([scene.camera.eye]), "black"), *windows, *objects]


def _write(axes: Axes, name: str, points: Floats, colour: str) -> None:
    """Write a name above points (n, 2) of the drawing."""
    above = (points[:, 0].min() + points[:, 0].max()) / 2, points[:, 1].max()
    text = axes.annotate(name, above, (0, 6), textcoords="offset points", ha="center", va="bottom", color=colour)
    text.set_path_effects([withStroke(linewidth=3, foreground="white")])


def _rays(found: Traced) -> list[tuple[Floats, Floats, str]]:
    """Return the path of each ray, its direction behind the path, which is 0 for a ray that ends, and its colour.

    Those on the designed path are last, on top.
    """
    corners, ways = found.corners.reshape(-1, *found.corners.shape[-2:]), found.direction.reshape(-1, 3)
    leaves = np.isin(found.end, (End.THROUGH, End.BACK, End.BESIDE)).reshape(-1, 1)
    colours = np.where(found.designed, DESIGNED, STRAY).flat
    paths = (path[np.isfinite(path[:, 0])] for path in corners)
    rays = zip(paths, leaves * np.nan_to_num(ways), colours, strict=True)
    return sorted(rays, key=lambda ray: ray[2] == DESIGNED)


def _sides(azimuth: float, elevation: float) -> Floats:
    """Return the directions to the right and up in the drawing, (2, 3)."""
    a, e = np.radians((azimuth, elevation))
    up = np.sin(e) * np.sin(a), np.cos(e), -np.sin(e) * np.cos(a)
    return np.array([(-np.cos(a), 0, -np.sin(a)), up]).round(12)


def _number(axes: Axes, sides: Floats, ways: Floats) -> None:
    """Write numbers at the axes of a drawing along x, y or z. An axis with the way -1 runs to the left or down."""
    for axis, side, way in zip((axes.xaxis, axes.yaxis), sides, ways, strict=True):
        axis.set_label_text(f"{'xyz'[side.argmax()]}, tiles")
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
