"""Parameters of a scene from points that were marked in a photograph: least squares, with standard errors."""

from __future__ import annotations  # help() then says ArrayLike

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import sqrt
from numbers import Real
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from povgen.errors import InputError, input_errors, shown
from povgen.optics.equations import Booleans, Floats, real
from povgen.optics.profile import Profile
from povgen.optics.values import Values
from povgen.scene.presets import AxialScene, checked_axial
from povgen.scene.windows import WINDOW_NUMBER

STEPS = 60  # of the search, at most
EDGE = 1e-3  # of a parameter, in the same unit: so near it is at an edge
_STEP = 1e-6  # of a parameter for derivatives, as a part of its size, or of 1
# The same for sheets of a profile. While it changes, predictions jump by about ROUGH, in tiles, where one of the
# rays behind it leaves the designed path.
_WIDE_STEP, ROUGH = 0.02, 3e-4
TINY = 1e-9  # tiles: a parameter that changes predictions by less, and a change of residuals, are none
POOR = 0.05  # the part of the marked points' variance that is more than noise, where this is not stated
SAME = 1e-4  # singular values below this part of the greatest one count as 0
Off = Callable[[Floats], Floats]  # from parameters to the residuals: predicted minus marked coordinates


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Values):
    """Parameters that fit best."""

    scene: AxialScene | None  # with these parameters; None if povgen cannot draw it: the warning says why
    values: Mapping[str, float]
    errors: Mapping[str, float]  # standard errors
    covariance: Floats  # (parameters, parameters); infinite variances where the points do not determine a parameter
    rms: float  # of the distances between marked and predicted points, tiles
    warning: str  # why not to trust the values; empty without a reason

    def __repr__(self) -> str:
        found = ", ".join(f"{name} = {value:.4g} ± {self.errors[name]:.2g}" for name, value in self.values.items())
        return f"<Fit: {found}; rms {self.rms:.2g} tiles>"


class _Windows(AxialScene):
    """The eye and the windows of a scene, without objects: a fit does not depend on where these could stand."""

    name: ClassVar[str] = "windows"


class _Found(NamedTuple):
    """Where a search ended."""

    values: Floats
    left: Floats  # the residuals
    slopes: Floats  # their derivatives by each parameter, (coordinates, parameters)

    @property
    def squares(self) -> float:
        return float(self.left @ self.left)


@input_errors()
def fit(
    scene: AxialScene,
    places: ArrayLike,
    seen: ArrayLike,
    free: str | Sequence[str] = ("alpha", "z1"),
    noise: float | None = None,
) -> Fit:
    """Return the values of the parameters `free` whose predictions are nearest to `seen` (least squares).

    `places` (n, 2) are the x and y of points at the scene's z1, or (n, 3) with z1 of each point: its distance behind
    the last window. `seen` (n, 2) is where the eye sees them in the plane of the first window. All are in tiles, from
    the window's centre, to the right and up. `free` may name numbers of a further window, such as window2_z. The other
    parameters are the scene's, which also says where the search starts; a search for alpha also starts 90, 180 and 270
    degrees from there. `noise` is the standard deviation of a marked coordinate, tiles. Without it, it follows from the
    residuals (so there must be more coordinates than parameters); intervals are then those of Student's t. The
    prediction is `apparent_position`. The result has a `warning` if the points do not determine a parameter, if the
    search ends at the edge of what is allowed or at no minimum, if the points are far from where the best parameters
    show them, and if the scene cannot be drawn. Raises InputError for parameters that are no numbers of the scene, for
    what is not finite, for too few points, and if a point appears nowhere where the search starts.
    """
    scene, names = checked_axial(scene, "fit"), [free] if isinstance(free, str) else free
    if not (isinstance(names, Sequence) and all(isinstance(name, str) for name in names)):
        raise InputError(f"free = {shown(free)}: allowed: names of the scene's numbers")
    start = np.array([_value(scene, name) for name in names])
    points, marked = _checked(names, places, seen, noise)
    off = _residuals(scene, names, points, marked)
    is_rough = any(isinstance(glass.shape, Profile) for sheet in scene.layered for glass in sheet.glass)
    best = _best(off, names, start, noise, _WIDE_STEP if is_rough else _STEP)
    # each parameter in units of its size, so that their accuracies can be compared
    size = np.maximum(abs(best.values), 1)
    ways, accuracy, combinations = np.linalg.svd(best.slopes * size, full_matrices=False)
    unknown = accuracy <= max(SAME * accuracy.max(), TINY)
    variance = noise**2 if noise is not None else best.squares / (marked.size - len(names))
    spread = size[:, None] * combinations.T / np.where(unknown, np.inf, accuracy)
    covariance = variance * spread @ spread.T
    lost = (abs(combinations[unknown]) > 0.1).any(0)
    covariance[lost] = covariance[:, lost] = np.nan
    covariance[lost, lost] = np.inf
    values = dict(zip(names, best.values.tolist(), strict=True))
    width = np.sum((marked - marked.mean(0)) ** 2)  # 0 for one point
    far = _is_far(best, noise) if noise is not None else width > 0 and best.squares > POOR * width
    least = ROUGH * sqrt(marked.size) if is_rough else TINY
    slow = np.linalg.norm(best.left @ ways[:, ~unknown]) > 1e-3 * best.squares**0.5 + least
    edge = np.array([len(sides) < 2 for _, sides in _sides(off, best.values, EDGE)])
    rms = float(np.sqrt(2 * np.mean(best.left**2)))
    said = {
        "the points do not determine: " + _joined(names, lost): lost.any(),
        "at the edge of what is allowed: " + _joined(names, edge): slow and edge.any(),
        "the search ended at no minimum: start nearer": slow and not edge.any(),
        f"the points are {rms:.2g} tiles from where these values show them: more than noise": far,
    }
    try:
        drawn, problem = _with(scene, values), []
    except InputError as error:
        drawn, problem = None, [f"no scene: {error}"]
    warning = "; ".join([text for text, holds in said.items() if holds] + problem)
    errors = dict(zip(names, np.sqrt(np.diag(covariance)).tolist(), strict=True))
    return Fit(drawn, values, errors, covariance, rms, warning)


def _checked(names: Sequence[str], places: ArrayLike, seen: ArrayLike, noise: float | None) -> tuple[Floats, Floats]:
    """Return the places and the marked points. Raises InputError."""
    points, marked = real("places", places), real("seen", seen)
    if points.ndim != 2 or points.shape[1] not in (2, 3) or marked.shape != (len(points), 2):
        raise InputError(
            f"places, seen: arrays of the shapes {points.shape} and {marked.shape}; allowed: (n, 2) or (n, 3), (n, 2)"
        )
    if not (np.isfinite(points).all() and np.isfinite(marked).all() and (points[:, 2:] >= 0).all()):
        raise InputError("places, seen: NaN, infinite, or a z1 below 0; allowed: finite numbers, tiles")
    if noise is not None and not (isinstance(noise, Real) and 0 < noise < np.inf):
        raise InputError(f"noise = {shown(noise)}: allowed: above 0, tiles; or None")
    if len({*names}) < len(names):
        raise InputError(f"free = {', '.join(names)}: a name twice; allowed: each once")
    most = marked.size - (noise is None)
    if not 1 <= len(names) <= most:
        raise InputError(f"free: {len(names)} for {marked.size} coordinates; allowed: 1 to {most}")
    if "z1" in names and points.shape[1] == 3:
        raise InputError("free: z1, which places state; allowed: one of them")
    return points, marked


def _residuals(scene: AxialScene, names: Sequence[str], points: Floats, marked: Floats) -> Off:
    """Return the function from parameters to residuals, which are NaN for parameters that are not allowed."""
    given = {name: getattr(scene, name) for name in scene.model_fields_set & _Windows.model_fields.keys()}
    windows, z1 = _Windows(**given), points[:, 2] if points.shape[1] == 3 else scene.distances[0]

    def off(values: Floats) -> Floats:
        changes = dict(zip(names, _allowed(names, values).tolist(), strict=True))
        at = changes.pop("z1", z1)
        try:
            found = np.asarray(_with(windows, changes).apparent_position(points[:, 0] + 1j * points[:, 1], at))
        except InputError:
            return np.full(marked.size, np.nan)
        return np.stack((found.real, found.imag), -1).ravel() - marked.ravel()

    return off


def _best(off: Off, names: Sequence[str], start: Floats, noise: float | None, reach: float) -> _Found:
    """Return the end of the best search. Others than the first one are made if it leaves more than noise."""
    best: _Found | None = None
    for turn in (0, 90, 180, 270) if "alpha" in names else (0,):
        found = _search(off, start + turn * np.array([name == "alpha" for name in names]), reach)
        if found and (best is None or found.squares < 0.999 * best.squares):
            best = found
        if best and noise is not None and not _is_far(best, noise):
            break
    if best is None:
        raise InputError("seen: for the scene's own parameters a point appears nowhere; allowed: other parameters")
    return best._replace(values=_allowed(names, best.values))


def _allowed(names: Sequence[str], values: Floats) -> Floats:
    """Return the values with an alpha within 360 degrees of 0: alpha is periodic."""
    return np.array(
        [np.fmod(x, 360) if name == "alpha" and abs(x) > 360 else x for name, x in zip(names, values, strict=True)]
    )


def _is_far(found: _Found, noise: float) -> bool:
    """Return whether noise leaves such residuals in less than one case of 1000.

    The bound of chi-squared is that of Laurent and Massart, Annals of Statistics 28, 1302 (2000), lemma 1.
    """
    freedom = found.left.size - len(found.values)
    return bool(found.squares / noise**2 > freedom + 2 * sqrt(7 * freedom) + 14)


def _joined(names: Sequence[str], chosen: Booleans) -> str:
    return ", ".join(name for name, is_chosen in zip(names, chosen, strict=True) if is_chosen)


def _search(off: Off, start: Floats, reach: float) -> _Found | None:
    """Return the parameters of least squares, by the Levenberg-Marquardt method; None without a prediction at start."""
    values, left, damping = start, off(start), 1e-3
    if not np.isfinite(left).all():
        return None
    for _ in range(STEPS):
        slopes = _slopes(off, values, left, reach)
        normal, size = slopes.T @ slopes, np.diag(slopes.T @ slopes)
        step = np.linalg.lstsq(normal + damping * np.diag(size + 1e-12 * size.max()), -slopes.T @ left, rcond=None)[0]
        after = off(values + step)
        if after @ after <= left @ left:
            small = abs(step).max() < 1e-9 * (1 + abs(values).max())
            values, left, damping = values + step, after, damping / 10
            if small:
                break
        else:
            damping *= 10
            if damping > 1e12:
                break
    return _Found(values, left, _slopes(off, values, left, reach))


def _slopes(off: Off, values: Floats, left: Floats, reach: float) -> Floats:
    """Return the derivatives by each parameter, (coordinates, parameters): at an edge, those to the allowed side."""
    slopes = []
    for step, sides in _sides(off, values, reach):
        change = sum((sign * (after - left) for sign, after in sides), 0 * left)
        slopes.append(change / (max(len(sides), 1) * step))
    return np.stack(slopes, -1)


def _sides(off: Off, values: Floats, reach: float) -> Iterator[tuple[float, list[tuple[int, Floats]]]]:
    """Yield, for each parameter, a step and the residuals on each side, +1 and -1, that is allowed."""
    for step in np.diag(reach * np.maximum(abs(values), 1)):
        yield (
            step.sum(),
            [(sign, after) for sign in (1, -1) if np.isfinite(after := off(values + sign * step)).all()],
        )


def _value(scene: AxialScene, name: str) -> float:
    """Return a number of the scene: where the search starts. Raises InputError."""
    field, place = scene.component(name) or (name, None)
    value: Any = getattr(scene, field) if name == "z1" or field in _Windows.model_fields else None
    if (match := WINDOW_NUMBER.fullmatch(name)) and (number := int(match[1])) <= len(scene.sheets):
        field = match[2]
        value = {**scene.sheets[number - 1].values, "z": scene.places[number - 1]}.get(field)
    value = value if place is None or value is None else value[place]
    fields = type(scene).model_fields
    whole = field in fields and fields[field].annotation is int
    if whole or isinstance(value, bool) or not isinstance(value, (int, float)):
        allowed = "alpha, z1, z2, eye_x, look_y, ..., or, of a further window, such as window2_alpha"
        raise InputError(f"free = {shown(name)}: no number of eye and windows, or a whole one; allowed: {allowed}")
    return float(value)


def _with(scene: AxialScene, values: Mapping[str, float]) -> AxialScene:
    """Return the scene with other numbers. Its picture's height stays."""
    return scene.with_numbers({"view": scene.view, **values})
