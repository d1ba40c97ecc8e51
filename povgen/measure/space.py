"""A drawing of a scene in space: its windows, its objects, the eye, and rays of light."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from povgen.errors import input_errors
from povgen.files import checked_output
from povgen.measure.plotting import GREY, IDEAL, PRISMS, drawn
from povgen.optics.rays import Traced
from povgen.optics.trace import End
from povgen.record import DRAWINGS, recorded_call, saved_with
from povgen.scene.scene import Scene, checked_scene
from povgen.settings import Print
from povgen.video.still import record_of

SIZE = (9, 6)  # inches
ZOOM = 1.2  # so that the drawing fills the picture
RAYS = (11, 8)  # from the eye, across the picture and upwards
OBJECT, DESIGNED, STRAY = "#b58900", IDEAL, GREY
FARTHEST = 4  # what is farther from the eye than this multiple of the windows' distance is left out


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
    through a grid of points of the picture. Rays on the designed path are red, others grey. A ray that leaves is
    extended by 0.3 of the scene's size. The drawing is seen from this azimuth and elevation, degrees: -90 and 0 are a
    side view, with z to the right. `dpi`, dots an inch from 50 to 1200, and `width`, millimetres from 40 to 300, are
    those of the file. Raises InputError for a file that cannot be written, for rays without paths, and
    without matplotlib.
    """
    scene, target = checked_scene(scene), checked_output(output, DRAWINGS)
    printed = Print(dpi=dpi, width=width)
    if traced is not None and not traced.corners.shape[-2]:
        raise ValueError("traced: the paths were not kept; allowed: rays of trace(..., path=True)")
    found = scene.trace(scene.rays(RAYS), path=True) if traced is None else traced
    eye = np.array(scene.camera.eye)
    edges = [opening.edge for opening in scene.openings]
    far = FARTHEST * max((float(np.linalg.norm(edge.mean(0) - eye)) for edge in edges), default=10.0)
    solid = [each for each in scene.contents if np.ptp(each.box)]
    boxes = [each.edges for each in solid if np.linalg.norm(each.pose.place - eye) < far]
    everything = np.concatenate([eye[None], *edges, *boxes])
    length = 0.3 * float(np.linalg.norm(np.ptp(everything, axis=0)))
    with saved_with(record_of([scene])), drawn(*SIZE, target, printed=printed, roomy=True) as figure:
        axes = figure.add_subplot(projection="3d")

        def line(points: NDArray[np.float64], colour: str, width: float = 1) -> None:
            axes.plot(points[:, 2], -points[:, 0], points[:, 1], color=colour, linewidth=width)

        for box in boxes:
            line(box, OBJECT)
        for edge in edges:
            line(edge, PRISMS, 2)
        corners, ways = found.corners.reshape(-1, *found.corners.shape[-2:]), found.direction.reshape(-1, 3)
        for path, way, designed, end in zip(corners, ways, found.designed.flat, found.end.flat, strict=True):
            path = path[np.isfinite(path[:, 0])]
            if end in (End.THROUGH, End.BACK, End.BESIDE):
                path = np.vstack((path, path[-1] + length * way))
            line(path, DESIGNED if designed else STRAY, 0.8)
        axes.plot(*eye[[2]], *-eye[[0]], *eye[[1]], "o", color="black")
        axes.set_xlabel("z, tiles", labelpad=12)
        axes.set(ylabel="−x, tiles", zlabel="y, tiles")
        axes.set_aspect("equal")
        axes.set_box_aspect(
            np.ptp([axes.get_xlim(), axes.get_ylim(), axes.get_zlim()], axis=1),
            zoom=ZOOM * (figure.get_figwidth() / SIZE[0]) ** 0.5,
        )
        axes.locator_params(axis="y", nbins=4)
        axes.view_init(elevation, azimuth)
        if abs(np.cos(np.radians(azimuth))) + abs(np.sin(np.radians(elevation))) < 0.1:  # the axis is seen from its end
            axes.set(yticks=[], ylabel="")
    return target
