"""A drawing of a scene in space: its windows, its objects, the eye, and rays of light."""

from itertools import combinations
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from povgen.errors import input_errors
from povgen.files import checked_output
from povgen.inputs.fields import PictureSize
from povgen.measure.plotting import GREY, IDEAL, PRISMS, drawn
from povgen.optics.rays import Traced
from povgen.optics.trace import End
from povgen.scene.scene import Scene, checked_scene

SIZE = (9, 6)  # inches
RAYS = (11, 8)  # from the eye, across the picture and upwards
OBJECT, DESIGNED, STRAY = "#b58900", IDEAL, GREY
FARTHEST = 4  # what is farther from the eye than this multiple of the windows' distance is left out


@input_errors()
def draw(
    scene: Scene, output: str | Path, traced: Traced | None = None, *, azimuth: float = -65, elevation: float = 20
) -> Path:
    """Draw the scene in space with rays of light, to scale, and write it to a .png or .svg file. Return its path.

    `traced` are rays whose paths were kept: `scene.trace(rays, path=True)`. Without them, they are rays from the eye
    through a grid of points of the picture. Rays on the designed path are red, others grey. A ray that leaves goes on
    for a while. The drawing is seen from this azimuth and elevation, degrees: -90 and 0 are from the side, with z to
    the right. Raises InputError for a file that cannot be written, for rays without paths, and without matplotlib.
    """
    target = checked_output(output, [".png", ".svg"])
    if traced is not None and not traced.corners.shape[-2]:
        raise ValueError("traced: the paths were not kept; allowed: rays of trace(..., path=True)")
    found = checked_scene(scene).trace(scene.rays(PictureSize(size=RAYS).size), path=True) if traced is None else traced
    eye = np.array(scene.camera.eye)
    edges = [opening.edge for opening in scene.openings]
    far = FARTHEST * max((float(np.linalg.norm(edge.mean(0) - eye)) for edge in edges), default=10.0)
    solids = [
        each.corners for each in scene.contents if np.linalg.norm(each.pose.place - eye) < far and np.ptp(each.box)
    ]
    everything = np.concatenate([eye[None], *edges, *solids])
    low, high = everything.min(0), everything.max(0)
    with drawn(*SIZE, target) as figure:
        axes = figure.add_subplot(projection="3d")

        def line(points: NDArray[np.float64], colour: str, width: float = 1) -> None:
            axes.plot(points[:, 2], -points[:, 0], points[:, 1], color=colour, linewidth=width)

        for corners in solids:
            for a, b in combinations(range(8), 2):
                if (a ^ b).bit_count() == 1:
                    line(corners[[a, b]], OBJECT)
        for edge in edges:
            line(edge, PRISMS, 2)
        length = 0.3 * float(np.linalg.norm(high - low))
        corners, ways = found.corners.reshape(-1, *found.corners.shape[-2:]), found.direction.reshape(-1, 3)
        for path, way, designed, end in zip(corners, ways, found.designed.flat, found.end.flat, strict=True):
            path = path[np.isfinite(path[:, 0])]
            goes_on = end in (End.THROUGH, End.BACK, End.BESIDE)
            line(
                np.vstack((path, *([path[-1] + length * way] if goes_on else []))), DESIGNED if designed else STRAY, 0.8
            )
        axes.plot(*eye[[2]], *-eye[[0]], *eye[[1]], "o", color="black")
        axes.set(xlabel="z, tiles", ylabel="−x, tiles", zlabel="y, tiles")
        axes.set_aspect("equal")
        axes.locator_params(axis="y", nbins=4)
        axes.view_init(elevation, azimuth)
    return target
