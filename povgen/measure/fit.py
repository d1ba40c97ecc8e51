"""Parameters of a scene from points that were marked in a photograph: least squares, with standard errors."""

from __future__ import annotations  # help() then says ArrayLike

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from povgen.errors import InputError, input_errors, shown
from povgen.optics.equations import Floats, real
from povgen.optics.values import Values
from povgen.scene.scenes import AxialScene, checked_axial

STEPS = 60  # of the search, at most
_STEP = 1e-6  # of a parameter for derivatives, as a part of its size, or of 1
SAME = 1e-4  # singular values below this part of the greatest one count as 0
Off = Callable[[Floats], Floats]  # from parameters to the residuals: predicted minus marked coordinates
PARTS = {"eye_x": ("eye", 0), "eye_y": ("eye", 1), "look_x": ("look", 0), "look_y": ("look", 1)}


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Values):
    """Parameters that fit best."""

    scene: AxialScene  # with these parameters
    values: Mapping[str, float]
    errors: Mapping[str, float]  # standard errors
    covariance: Floats  # (parameters, parameters); infinite variances where the points do not determine a parameter
    rms: float  # of the distances between marked and predicted points, tiles
    warning: str  # which parameters the points do not determine; empty if they determine all

    def __repr__(self) -> str:
        found = ", ".join(f"{name} = {value:.4g} ± {self.errors[name]:.2g}" for name, value in self.values.items())
        return f"<Fit: {found}; rms {self.rms:.2g} tiles>"


@input_errors()
def fit(
    scene: AxialScene,
    places: ArrayLike,
    seen: ArrayLike,
    free: Sequence[str] = ("alpha", "z1"),
    noise: float | None = None,
) -> Fit:
    """Return the parameters `free` for which the points are predicted nearest to where they are `seen`: least squares.

    `places` (n, 2) are the x and y of points at the scene's z1, or (n, 3) with z1 of each point: its distance behind
    the last window. `seen` (n, 2) is where the eye sees them in the plane of the first window. All are in tiles, from
    the window's centre, to the right and up. The other parameters are the scene's, which also says where the search
    starts. `noise` is the standard deviation of a marked coordinate, tiles; without it, it follows from the residuals
    (so there must be more coordinates than parameters). The prediction is `apparent_position`. Raises InputError for
    parameters that are no numbers of the scene, for too few points, and if the search finds nothing.
    """
    scene, names = checked_axial(scene, "fit"), [*free]
    start = np.array([_value(scene, name) for name in names])
    points, marked = real("places", places), real("seen", seen)
    if points.ndim != 2 or points.shape[1] not in (2, 3) or marked.shape != (len(points), 2):
        raise InputError(
            f"places, seen: arrays of the shapes {points.shape} and {marked.shape}; allowed: (n, 2) or (n, 3), (n, 2)"
        )
    most = marked.size - (noise is None)
    if not 1 <= len(names) <= most:
        raise InputError(f"free: {len(names)} for {marked.size} coordinates; allowed: 1 to {most}")
    if "z1" in names and points.shape[1] == 3:
        raise InputError("free: z1, which places state; allowed: one of them")

    def named(values: Floats) -> dict[str, float]:
        return dict(zip(names, values.tolist(), strict=True))

    def off(values: Floats) -> Floats:
        changed = _with(scene, named(values))
        z1 = points[:, 2] if points.shape[1] == 3 else changed.distances[0]
        found = np.asarray(changed.apparent_position(points[:, 0] + 1j * points[:, 1], z1))
        return np.stack((found.real, found.imag), -1).ravel() - marked.ravel()

    values, left, slopes = _found(off, start)
    # each parameter in units of its size, so that their accuracies can be compared
    size = np.maximum(abs(values), 1)
    _, accuracy, combinations = np.linalg.svd(slopes * size, full_matrices=False)
    unknown = accuracy < SAME * accuracy.max()
    variance = noise**2 if noise is not None else left @ left / (left.size - len(names))
    spread = size[:, None] * combinations.T / np.where(unknown, np.inf, accuracy)
    covariance = variance * spread @ spread.T
    lost = (abs(combinations[unknown]) > 0.1).any(0)
    covariance[lost] = covariance[:, lost] = np.nan
    covariance[lost, lost] = np.inf
    alike = ", ".join(name for name, is_lost in zip(names, lost, strict=True) if is_lost)
    return Fit(
        _with(scene, named(values)),
        named(values),
        named(np.sqrt(np.diag(covariance))),
        covariance,
        float(np.sqrt(2 * np.mean(left**2))),
        alike and f"the points do not determine: {alike}",
    )


def _found(off: Off, start: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the parameters of least squares, the residuals and their derivatives: the Levenberg-Marquardt method."""
    values, left, damping = start, off(start), 1e-3
    if not np.isfinite(left).all():
        raise InputError("seen: for the scene's own parameters a point appears nowhere; allowed: other parameters")
    for _ in range(STEPS):
        slopes = _slopes(off, values)
        normal, size = slopes.T @ slopes, np.diag(slopes.T @ slopes)
        step = np.linalg.lstsq(normal + damping * np.diag(size + 1e-12 * size.max()), -slopes.T @ left, rcond=None)[0]
        try:
            after = off(values + step)
        except InputError:  # outside a parameter's range
            after = np.full_like(left, np.nan)
        if after @ after <= left @ left:
            small = abs(step).max() < 1e-9 * (1 + abs(values).max())
            values, left, damping = values + step, after, damping / 10
            if small:
                break
        else:
            damping *= 10
            if damping > 1e12:
                break
    return values, left, _slopes(off, values)


def _slopes(off: Off, values: Floats) -> Floats:
    """Return the derivatives by each parameter, (coordinates, parameters)."""
    steps = np.diag(_STEP * np.maximum(abs(values), 1))
    return np.stack([(off(values + step) - off(values - step)) / (2 * step.sum()) for step in steps], -1)


def _value(scene: AxialScene, name: str) -> float:
    field, part = PARTS.get(name, (name, None))
    value: Any = getattr(scene, field, None) if field in type(scene).model_fields else None
    value = value if part is None else value[part]
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise InputError(
            f"free = {shown(name)}: no number of the scene; allowed: alpha, z1, z2, {', '.join(PARTS)}, ..."
        )
    return float(value)


def _with(scene: AxialScene, values: Mapping[str, float]) -> AxialScene:
    """Return the scene with other numbers. Its picture's height stays."""
    changes: dict[str, Any] = {"view": scene.view}
    for name, value in values.items():
        field, part = PARTS.get(name, (name, None))
        given = changes.get(field, getattr(scene, field))
        changes[field] = value if part is None else (*given[:part], value, *given[part + 1 :])
    changed: AxialScene = scene.replace(**changes)
    return changed
