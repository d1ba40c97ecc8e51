"""An eye with a pupil: sample points in the pupil, the distance of its focus, and the blur.

The slope of light that enters the pupil is a linear function of the position in the pupil. The matrix A (2, 2) is the
derivative of the slope by the position, 1 / tile. For light of a point at the distance d it is -1/d times the identity.
An eye that is focused at the distance f adds 1/f times the identity. Behind sheets that rotate light by alpha, A is the
rotation and scaling by -1/Z, with the complex depth Z = z2 + exp(-i alpha) z1 of docs/beyond.md. No f makes A + 1/f
zero, unless Z is real.
"""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from povgen.optics.camera import Camera
from povgen.optics.equations import Complexes, Floats
from povgen.scene.presets import AxialScene
from povgen.scene.scene import Scene, checked_scene, object_images, paths

# Steps of numbers between 0 and 1 that fill a square evenly, however many they are: powers of the root of x^5 = x + 1
# (Roberts, 2018). view.glsl has the same.
STEPS = 0.8566748838545029, 0.733891856627126
LEAST = 1e-8  # 1 / tile: a focus whose 1 / distance is smaller counts as infinite, because of rounding
_STEP = 1e-4  # of places and slopes, for derivatives


def places(count: int) -> Complexes:
    """Return places in a pupil of radius 1, x + iy. The first one is its middle."""
    radius, turn = (np.arange(count) * step % 1 for step in STEPS)
    return np.asarray(np.sqrt(radius) * np.exp(2j * np.pi * turn))


def inverse_focus(scene: Scene) -> float:
    """Return 1 / the distance of the eye's focus, 1 / tile: 0 for infinity.

    The distance is along the normal of the picture's plane. Where there is no best focus, it is that of this plane.
    """
    found = _best(scene) if scene.focus == "best" else 1 / scene.focus
    return found if np.isfinite(found) else 1 / distance(scene.camera)


def best_focus(scene: Scene) -> float:
    """Return the distance of the focus, tiles, that blurs the first object least.

    It is along the normal of the picture's plane. An eye cannot focus light that still converges when it enters: the
    best focus is then infinite, as it is for parallel light. It is NaN if no object has an image.
    """
    found = _best(checked_scene(scene))
    return 1 / found if found else float("inf")


def _best(scene: Scene) -> float:
    turns = turns_by_slope(_slope_of_object(scene))
    found = float(-(turns * (turns @ light_of_object(scene))).sum() / (turns**2).sum())
    return 0.0 if found < LEAST else found


def distance(camera: Camera) -> float:
    """Return the distance of the eye from the picture's plane, tiles."""
    return float(np.subtract(camera.middle, camera.eye) @ np.cross(camera.right, camera.up))


def turns_by_slope(slope: complex) -> Floats:
    """Return the derivative (2, 2) of the angle by which light turns, radians, by its slope.

    The slope, x + iy, is from the normal of the picture's plane: the derivative is 1 / (1 + abs(slope)^2) along the
    slope, and the square root of this perpendicular to it.
    """
    s = np.array((slope.real, slope.imag))
    r = np.sqrt(1 + s @ s)
    return np.asarray((np.eye(2) - np.outer(s, s) / (r * (1 + r))) / r)


def blur(scene: Scene) -> Floats:
    """Return the derivative (2, 2) of a ray's angular error by its place in the pupil, radians / tile: 0 if sharp."""
    off = light_of_object(scene) + inverse_focus(scene) * np.eye(2)
    return np.asarray(turns_by_slope(_slope_of_object(scene)) @ off)


def rms(scene: Scene) -> float:
    """Return the RMS angle by which the pupil blurs a point of the first object, radians."""
    return float(scene.pupil / 4 * np.linalg.norm(blur(scene)))


@lru_cache(maxsize=256)  # a movie's frames ask several times
def light_of_object(scene: Scene) -> Floats:
    """Return A (2, 2) of the light of the scene's first object that has an image, NaN if none has.

    Prisms and lenses count by their designed light. Frames hide nothing.
    """
    seen, nothing = first_image(scene), np.full((2, 2), np.nan)
    if seen is None or not np.isfinite(seen[1]):
        return nothing
    point, _, names = seen
    camera, every, middle = scene.camera, paths(scene), _slope_of_object(scene)
    sides = np.array((camera.right, camera.up))
    # rays beside the one to the eye: other places in the pupil, and other slopes
    x, y, sx, sy = np.vstack((np.zeros(4), _STEP * np.eye(4), -_STEP * np.eye(4))).T
    start = camera.eye + np.stack((x, y), -1) @ sides
    way = np.stack((middle.real + sx, middle.imag + sy), -1) @ sides + np.cross(*sides)
    for name in names:
        start, way = every.cross(every.names.index(name), start, way, framed=False)
    # where they cross a plane through the object, perpendicular to the middle ray
    part = (np.asarray(point) - start) @ way[0] / (way @ way[0])
    end = start + part[:, None] * way
    across = (end[1:5] - end[5:]).T / (2 * _STEP)  # (3, 4): by x, y, sx and sy
    return np.asarray(-np.linalg.pinv(across[:, 2:]) @ across[:, :2]) if np.isfinite(across).all() else nothing


def _slope_of_object(scene: Scene) -> complex:
    """Return the slope of the light of `first_image`, from straight ahead; NaN if there is none."""
    if (seen := first_image(scene)) is None:
        return complex(np.nan, np.nan)
    camera, sides = scene.camera, np.array((scene.camera.right, scene.camera.up))
    return complex(seen[1] - complex(*(sides @ np.subtract(camera.eye, camera.middle)))) / distance(camera)


def first_image(scene: Scene) -> tuple[Sequence[float], complex, Sequence[str]] | None:
    """Return the point of the first object that has an image, where the eye sees it first, and through which windows.

    The position is in the picture's plane, x + iy from its middle, tiles. A preset's light passes all windows.
    """
    if isinstance(scene, AxialScene):
        if not scene.objects:
            return None
        L, z1 = scene.objects[0]
        position = complex(scene.apparent_position(L, z1)) - scene.middle
        return (L.real, L.imag, scene.places[-1] + z1), position, [*scene.named_openings]
    seen = ((each.point, images[0]) for each, images in object_images(scene) if images and each.point is not None)
    return next(((tuple(point), image.position, image.windows) for point, image in seen), None)


def eyes(scene: Scene, jitter: ArrayLike, pixel: float) -> list[Scene]:
    """Return the scene for eyes that are points, one for each place in the pupil. The picture is their light's mean.

    Each of the pictures is moved by `jitter` (n,), x + iy in pixels, to the right and up. A pixel's side is in tiles.
    """
    aside = scene.pupil / 2 * places(len(np.atleast_1d(jitter)))
    moved = aside * (1 - distance(scene.camera) * inverse_focus(scene)) + pixel * np.asarray(jitter)
    return [scene.seen_from(complex(place), complex(step)) for place, step in zip(aside, moved, strict=True)]
