"""Numbers of a scene that need no picture: what the equations predict, and what the ray trace finds.

They are for the scene's first object, seen through all windows; those of a room are for the first object that has an
image. A quantity that does not exist, such as nu at the pole, is NaN.
"""

from __future__ import annotations  # help() then says ArrayLike

import re
from collections.abc import Callable, Collection, Iterator, Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from povgen.errors import input_errors
from povgen.optics import apparent, uncertainty
from povgen.optics.equations import Booleans, Complexes, Floats, real
from povgen.optics.rays import Bundle, Convergence
from povgen.optics.shares import Shares, shares
from povgen.scene import pupil
from povgen.scene.presets import AxialScene, checked_axial, components
from povgen.scene.scene import Scene
from povgen.scene.windows import WINDOW_NUMBER
from povgen.sheets import PARAMETERS
from povgen.sheets.prisms import ERRORS
from povgen.sheets.sheet import Said

MIN_RAYS = 100  # with fewer rays on the designed path, the object counts as not seen
ARCMINUTE = np.radians(1 / 60)
RAYS = 10_000  # traced rays: the standard error of a share is then at most 0.005
MTF_RAYS = 100_000  # traced rays for the modulation transfer function, whose values for fine stripes are small
MOST_X = 1000  # where a disc's modulation transfer function, 2 J1(x) / x, is below 6e-5

# How captions write names of parameters and quantities, where they do not use a sheet's `Parameter.said`. Others are
# written as they are.
SYMBOLS = {"alpha": "α", "nu": "ν", "z1": "z₁", "z2": "z₂", "index": "n"}
# Units of parameters that have no `Parameter.unit`.
LENGTHS = "z", "z1", "z2", "x", "eye", "look", "line", "aperture", "view", "pedestal", "pupil", "focus"
OF_THINGS = "y", "width", "height", "depth", "length", "radius", "aside", "above"  # in a room
UNITS = {"wavelength": "nm"} | dict.fromkeys(("yaw", "pitch", "roll", "polariser", "analyser"), "degrees")
UNITS |= dict.fromkeys((*LENGTHS, *OF_THINGS), "tiles")
# How captions state z1: behind a single window, and behind several.
BEHIND, BEHIND_LAST = (Said(f"z₁ = {{}} behind the {window}", full="z₁ = {}") for window in ("window", "last window"))
# How captions state the place of a window behind the first one: of two windows, and of more than two.
SECOND, LATER = Said("windows {} apart"), Said("window {number} at {}")


class Quantity(NamedTuple):
    """A number of a scene."""

    of: Callable[[Any], Any]  # of a scene: a number; of a scene of `stacked`, an array
    unit: str
    text: str
    stacks: bool = False  # whether it is found for a scene of `stacked`: by equations alone
    in_rooms: bool = False


@lru_cache(1)  # one trace for all quantities
def _shares(scene: AxialScene) -> Shares:
    """Return what becomes of rays from the eye to random points of the front opening of the first window's frame."""
    x, y = scene.aperture * (np.random.default_rng(1).uniform(size=(2, RAYS)) - 0.5)
    P = scene.E + (x + 1j * y - scene.E) / (1 - scene.depth / 2 / scene.z2)
    partial = np.random.default_rng(2) if scene.fresnel else None
    return shares(scene.trace(scene.camera.through(P), partial=partial))


class TracedImage(NamedTuple):
    """The first object as the eye sees it through the windows, by the ray trace."""

    position: complex  # in the plane z = 0, tiles
    nu: float  # the angle by which it appears turned, degrees; NaN if it appears mirrored
    # its size in the plane z = 0, divided by its true size: the mean of the greatest and the least magnification, as in
    # `apparent.nu_and_M`
    M: float
    blur: float  # RMS distance of a point's images by the single prisms from their mean, in the plane z = 0, tiles


NOT_SEEN = TracedImage(complex(np.nan, np.nan), np.nan, np.nan, np.nan)


@lru_cache(1)
def traced_image(scene: AxialScene) -> TracedImage:
    """Return the first object as the eye sees it: NaN if too little light on the designed path shows it.

    If it appears at infinity, M is infinite. Rays from the eye pass random points of a disc around the object's
    predicted position. The place where a ray crosses the object's plane is a linear function of the ray's point, plus a
    remainder that depends on where the ray meets its prisms. The remainder is the blur.
    """
    L, z1 = scene.objects[0]
    centre = complex(scene.apparent_position(L, z1))
    if not np.isfinite(centre):
        return NOT_SEEN._replace(M=np.inf if np.isinf(centre) else np.nan)
    radius, turn = np.random.default_rng(1).uniform(size=(2, RAYS))
    step = _spread(scene) * np.sqrt(radius) * np.exp(2j * np.pi * turn)
    light = scene.trace(scene.camera.through(centre + step))
    step, place = step[light.designed], light[light.designed].at(scene.places[-1] + z1) - L
    if len(step) < MIN_RAYS:
        return NOT_SEEN
    basis = np.column_stack((np.ones(len(step)), step, step.conj()))
    (there, a, b), *_ = np.linalg.lstsq(basis, place, rcond=None)
    if abs(abs(a) - abs(b)) <= 1e-9 * (abs(a) + abs(b)):  # at the pole
        return NOT_SEEN._replace(M=np.inf)
    # the inverse of the linear function: a step d on the object is seen as right*d + other*conj(d)
    size = abs(a) ** 2 - abs(b) ** 2
    right, other = a.conjugate() / size, -b / size
    off = place - basis @ (there, a, b)
    blur = np.sqrt(np.mean(abs(right * off + other * off.conj()) ** 2))
    return TracedImage(
        complex(centre - right * there - other * there.conjugate()),
        float(np.degrees(np.angle(right))) if size > 0 else np.nan,
        float(max(abs(right), abs(other))),
        float(blur),
    )


class Entering(NamedTuple):
    """Light of a point of the first object that enters the pupil on the designed path, by the ray trace.

    Both are errors of the directions of single rays, x + iy, radians, for the focused eye.
    """

    by_pupil: Complexes  # linear in the position in the pupil, as defocus is; all of it if there are no prisms
    by_prisms: Complexes  # the remainder, from the finite size of the prisms


@lru_cache(2)
def entering(scene: AxialScene, rays: int = RAYS) -> Entering:
    """Return the light that enters the scene's pupil, focused as the scene says. Empty if too little is traced.

    Rays from random places in the pupil pass random points of a disc around the object's predicted position. The place
    where a ray crosses the object's plane is a linear function of the place in the pupil and of the ray's slope, plus a
    remainder. This function says with which slope a ray from a place in the pupil meets the point.
    """
    L, z1 = scene.objects[0]
    centre, nothing = complex(scene.apparent_position(L, z1)), np.zeros(0, complex)
    if not np.isfinite(centre):
        return Entering(nothing, nothing)
    radius, turn = np.random.default_rng(1).uniform(size=(2, 2, rays))
    aside, step = np.sqrt(radius) * np.exp(2j * np.pi * turn)
    aside, slope = scene.pupil / 2 * aside, (centre - scene.E) / scene.z2 + _spread(scene) / scene.z2 * step
    start = np.stack((aside.real + scene.E.real, aside.imag + scene.E.imag, np.full(rays, -scene.z2)), -1)
    light = scene.trace(Bundle(start, np.stack((slope.real, slope.imag, np.ones(rays)), -1)))
    seen = light.designed
    if seen.sum() < MIN_RAYS:
        return Entering(nothing, nothing)
    place, aside, slope = light[seen].at(scene.places[-1] + z1) - L, aside[seen], (slope - slope.mean())[seen]
    parts = [np.ones(len(place)), slope, slope.conj(), *((aside, aside.conj()) if scene.pupil else ())]
    basis = np.column_stack(parts)
    fitted, *_ = np.linalg.lstsq(basis, place, rcond=None)
    _, a, b = fitted[:3]
    size = abs(a) ** 2 - abs(b) ** 2

    turns = pupil.turns_by_slope((centre - scene.E) / scene.z2)

    def missed(places: Complexes, focus: Complexes | float = 0) -> Complexes:
        """Return the angles that make up for places beside the point, and for the slopes of the focus."""
        slopes = (b * places.conj() - a.conjugate() * places) / size + focus
        return np.asarray((1, 1j) @ turns @ (slopes.real, slopes.imag))

    by_pupil = missed(basis[:, 3:] @ fitted[3:], aside * pupil.inverse_focus(scene))
    rest = missed(place - basis @ fitted)
    return Entering(by_pupil, rest) if scene.has_prisms else Entering(by_pupil + rest, 0 * rest)


@input_errors()
def mtf(scene: AxialScene, frequencies: ArrayLike, direction: float = 0) -> Floats:
    """Return the modulation transfer function for light of the scene's first object: 1 if sharp, 0 without contrast.

    `frequencies` are in cycles per degree as the eye sees them, of stripes that are perpendicular to `direction`,
    degrees counter-clockwise from x. The pupil and the prisms count; the diffraction of light does not. If all ideal
    sheets have ray-transfer matrices, and the window hides no light, it is abs(2 J1(x) / x) of a disc: for sheets that
    rotate light, and an object straight ahead, x = pi * pupil * abs(1/f - 1/Z) * the frequency in cycles per radian
    (`povgen.scene.pupil`). Where x exceeds MOST_X, and the function is below 6e-5, it is 0. Otherwise it is the mean of
    MTF_RAYS traced rays, of which n take the designed path: its standard error is below 1 / sqrt(n), mostly 0.005. NaN
    if too little light on the designed path shows the object. Raises InputError for other scenes than Chess and
    Spheres, for frequencies that are negative or not finite, and for a direction that is not one finite number.
    """
    scene, along = checked_axial(scene, "mtf"), np.radians(real("direction", direction))
    with np.errstate(over="ignore"):
        cycles = np.degrees(real("frequencies", frequencies, 0))[..., None]  # per radian
    if not np.isfinite(cycles).all():
        raise ValueError("frequencies: NaN or infinite; allowed: finite numbers")
    if along.ndim or not np.isfinite(along):
        raise ValueError("direction: allowed: one finite number, degrees")
    linear = not scene.has_prisms and apparent.matrix(scene.elements) is not None
    if linear and len(entering(scene).by_pupil) == RAYS:
        x = np.pi * scene.pupil * cycles * np.linalg.norm((np.cos(along), np.sin(along)) @ pupil.blur(scene))
        # the part of a disc at the distance cos(angle) from a diameter goes as sin(angle): Gauss and Chebyshev
        angle = np.pi * np.arange(1, MOST_X) / MOST_X
        found = 2 / MOST_X * (np.sin(angle) ** 2 * np.cos(x * np.cos(angle))).sum(-1)
        return np.asarray(np.where(x[..., 0] < MOST_X, abs(found), 0))
    turned = sum(entering(scene, MTF_RAYS)) * np.exp(-1j * along)
    if not len(turned):
        return np.full(np.shape(frequencies), np.nan)
    return np.asarray(abs(np.exp(2j * np.pi * cycles * turned.real).mean(-1)))


def _rms_arcmin(angles: Complexes) -> float:
    return float(np.sqrt(np.mean(abs(angles) ** 2)) / ARCMINUTE) if len(angles) else np.nan


def _spread(scene: AxialScene) -> float:
    """Return the radius of the disc in the plane z = 0 through which rays to an object are traced, tiles.

    It covers several prisms. Without prisms it is so small that no law differs from a linear function of the place.
    """
    if not scene.has_prisms:
        return 1e-4
    pitch = max((layer.shape.pitch for sheet in scene.sheets for layer in sheet.glass), default=0.0)
    return max(0.1, 8 * pitch)


@lru_cache(1)
def _convergence(scene: AxialScene) -> Convergence:
    """Return where the first object's light that takes the designed path through the windows is closest together."""
    L, z1 = scene.objects[0]
    light = scene.trace(scene.pencil((L.real, L.imag, scene.places[-1] + z1), RAYS))
    light = light[light.designed]
    return light.convergence() if len(light.end) > 1 else Convergence(*[np.nan] * 4)


def _position(scene: Scene) -> Complexes:
    """Return where the first object appears. At infinity it has no place: NaN.

    In a room this is the first image, in the picture's plane, from the picture's middle and along its sides.
    """
    if not isinstance(scene, AxialScene):
        seen = pupil.first_image(scene)
        return np.asarray(complex(np.nan, np.nan) if seen is None else seen[1])
    found = np.asarray(scene.apparent_position(*scene.objects[0]))
    return np.where(np.isfinite(found), found, complex(np.nan, np.nan))


def _visible(scene: Scene) -> Booleans:
    """Return whether the eye sees the first object, or, in a room, whether it sees one."""
    if isinstance(scene, AxialScene):
        return scene.visible(*scene.objects[0])
    return np.asarray(pupil.first_image(scene) is not None)


def _uncertainty(scene: AxialScene) -> float:
    """Return the possible error of the predicted position; at infinity infinite, or NaN for ideal sheets."""
    if not scene.has_prisms:
        return 0.0 if np.isfinite(_position(scene)) else np.nan
    (L, z1), radius = scene.objects[0], scene.radii[0]
    P = complex(scene.apparent_position(L, z1, near=radius))
    return uncertainty.possible_error(P, scene.E, z1, radius, scene.elements)


QUANTITIES = {
    "x": Quantity(
        lambda scene: _position(scene).real,
        "tiles",
        "where the eye sees the object, in the plane z = 0; in a room in the picture's plane, from its middle",
        stacks=True,
        in_rooms=True,
    ),
    "y": Quantity(lambda scene: _position(scene).imag, "tiles", "the same, upwards", stacks=True, in_rooms=True),
    "nu": Quantity(
        lambda scene: scene.nu_and_M(scene.distances[0])[0],
        "degrees",
        "angle by which it appears turned; NaN unless all sheets only rotate light",
        stacks=True,
    ),
    "M": Quantity(
        lambda scene: scene.nu_and_M(scene.distances[0])[1], "", "its magnification; NaN likewise", stacks=True
    ),
    "uncertainty": Quantity(_uncertainty, "tiles", "possible error of x and y through prisms or lenses"),
    "visible": Quantity(_visible, "", "1 if the eye sees it, otherwise 0", stacks=True, in_rooms=True),
    "seen_x": Quantity(
        lambda scene: traced_image(scene).position.real, "tiles", "x by the ray trace, on the designed path"
    ),
    "seen_y": Quantity(lambda scene: traced_image(scene).position.imag, "tiles", "the same for y"),
    "seen_nu": Quantity(lambda scene: traced_image(scene).nu, "degrees", "nu by the ray trace, from -180 to 180"),
    "seen_M": Quantity(lambda scene: traced_image(scene).M, "", "M by the ray trace"),
    "blur": Quantity(
        lambda scene: traced_image(scene).blur,
        "tiles",
        "RMS spread, in the plane z = 0, of a point's images by the single prisms",
    ),
    "designed": Quantity(
        lambda scene: _shares(scene).designed, "", "share of the eye's rays to the window on the designed path, 0 to 1"
    ),
    "stray": Quantity(
        lambda scene: _shares(scene).stray,
        "",
        "share of the eye's rays that leave the far side on other paths",
    ),
    "best_focus": Quantity(
        pupil.best_focus,
        "tiles",
        "distance of the focus for which a pupil blurs the object least",
        in_rooms=True,
    ),
    "pupil_blur": Quantity(
        lambda scene: pupil.rms(scene) / ARCMINUTE,
        "arcminutes",
        "predicted RMS radius of a point's blur by the pupil, at the parameter focus",
        in_rooms=True,
    ),
    "prism_blur": Quantity(
        lambda scene: _rms_arcmin(entering(scene).by_prisms),
        "arcminutes",
        "the same because of the prisms' finite size, ray-traced",
    ),
    "seen_blur": Quantity(
        lambda scene: _rms_arcmin(sum(entering(scene))),
        "arcminutes",
        "the same because of pupil and prisms together, ray-traced",
    ),
    "closest": Quantity(
        lambda scene: _convergence(scene).z, "tiles", "z of the plane where the object's light is closest together"
    ),
    "spot": Quantity(lambda scene: _convergence(scene).rms, "tiles", "RMS radius of the spot of its light there"),
}


SHARES = {"designed", "stray"}  # quantities that are shares of RAYS traced rays
STACKED = ("alpha", "z1", "z2")  # parameters that are arrays in a scene of `stacked`


def stacked(scene: AxialScene, values: Mapping[str, Floats]) -> AxialScene | None:
    """Return a scene for n scenes that differ in parameters of STACKED alone: these are arrays (n,).

    z1 is that of the first object. Quantities that stack are found for all at once. Nothing is checked. Return None if
    a sheet has no ray-transfer matrix: then predictions are searched for, one by one.
    """
    made = scene.model_copy()
    for found in ("sheets", "contents"):
        made.__dict__.pop(found, None)
    made.__dict__.update(values)
    return made if apparent.matrix(made.elements) is not None else None


def unit(name: str) -> str:
    """Return the unit of a parameter with a name of `parameters`, such as tiles or degrees; empty without one."""
    name = re.sub("^(scene|window[0-9]+)_", "", name)
    if name.startswith("error_"):
        return ERRORS[name.removeprefix("error_")].unit
    own = re.sub("_([0-9]+|[xyz])$", "", name)  # one of several, or a component
    units = {each.unit for each in PARAMETERS.get(own, ())} - {""}
    found = UNITS.get(own) or (units.pop() if len(units) == 1 else "")
    if found or own in PARAMETERS or name.startswith("parameter_"):
        return found
    return unit(name.partition("_")[2]) if "_" in name else ""  # of a thing in a room: left_alpha


def parameters(scene: Scene, names: Collection[str] | None = None) -> dict[str, object]:
    """Return a scene's parameters by names such as alpha, eye_x, window2_z and z1_2, which is z1 of the second object.

    The values are numbers, texts, True and False. Parameters that are None are left out. If fields of the scene's
    class are named, the others are left out, too. Numbers of a room's things have names such as left_alpha, for the
    name left.alpha.
    """
    found: dict[str, object] = {"scene": scene.name}

    def add(name: str, value: object) -> None:
        if isinstance(value, dict):
            for part, each in value.items():
                add(f"{name}_{part}", each)
        elif isinstance(value, (tuple, list)):
            parts = components(name.rpartition("_")[2], len(value))  # of axis, or window2_axis
            for part, each in zip(parts, value, strict=True):
                add(f"{name}_{part}", each)
        elif value is not None:
            found[name] = value if isinstance(value, (bool, int, float)) else str(value)

    for name, value in _stated(scene, names):
        add(name, value)
    return found


def _stated(scene: Scene, names: Collection[str] | None) -> Iterator[tuple[str, object]]:
    """Yield the values of a scene's fields and, by their own names, components, further windows and a room's things."""
    inside = {"object", "window", "eye"} if scene.parts else set()
    for part, model in scene.parts.items():
        for name, value in model.model_dump().items():
            if names is None or f"{part}.{name}" in names or not inside.isdisjoint(names):
                yield f"{part}_{name}", value
    for name in names or ():
        if isinstance(scene, AxialScene) and (match := WINDOW_NUMBER.fullmatch(name)):
            yield name, getattr(scene.window[int(match[1]) - 2], match[2])
        elif isinstance(scene, AxialScene) and (component := scene.component(name)):
            yield name, getattr(scene, component[0])[component[1]]
    for name, value in scene.model_dump(include=None if names is None else {*names}, exclude=inside).items():
        if name == "window":
            yield from ((f"window{number}", window) for number, window in enumerate(value, 2))
        else:
            yield name, value
