"""How errors of building a pair of sheets change what is seen: sensitivities, and a simulation of many random builds.

All is found by the exact ray trace, on the designed path (`scene.quantities.traced_image`). The errors are those of
`sheets.prisms.ERRORS`, without those of lenses.
"""

from collections.abc import Sequence
from contextlib import suppress
from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field, model_validator

from povgen.errors import InputError
from povgen.measure.results import results
from povgen.objects.sheet_fields import as_table
from povgen.scene.presets import AxialScene
from povgen.sheets.prisms import ERRORS, OF_LENSES, RANDOM, PrismPair
from povgen.validation import Model

# By how much `sensitivities` changes each error. The steps are large for this reason: if a sheet moves, other rays take
# the designed path. The angle by which the object appears turned is found by a fit to these rays, and changes by about
# 0.01 degrees because they are others. A large step changes it by much more. `facets` and `pitches` have no step,
# because the blur that they cause is not proportional to them.
STEPS = {
    name: {"tiles": 0.1, "": 0.05}.get(allowed.unit, 1.0)
    for name, allowed in ERRORS.items()
    if name not in (*RANDOM, "seed", *OF_LENSES)
}
# The errors whose effects are shown: degrees, tiles, or differences of an index. A whole tile would be far too much.
SHOWN = {name: 0.01 if ERRORS[name].unit in ("tiles", "") else 1.0 for name in STEPS}
DEVIATIONS = (*STEPS, *RANDOM)
PERCENTILES = (50, 90, 95, 99)
ARCMINUTE = np.pi / 180 / 60
SPREADS = ("seen_x", "seen_y", "seen_nu", "seen_M", "blur")

Floats = NDArray[np.float64]
Seen = Floats  # the SPREADS of several scenes, (5, n), or of one scene


def shown(name: str) -> str:
    """Return the size of the error whose effect is shown, with its unit in words."""
    size = SHOWN[name]
    return {"tiles": f"{size:g} tiles", "": f"{size:g}"}.get(ERRORS[name].unit, f"{size:g} degree")


class Spread(Model):
    """How far builds are from a scene. The errors are drawn independently, from normal distributions.

    `facets` and `pitches` are not drawn: they are themselves the standard deviations of prisms.
    """

    deviation: Annotated[
        dict[Literal[DEVIATIONS], Annotated[float, Field(gt=0)]],  # type: ignore[valid-type]
        BeforeValidator(as_table),
    ] = Field(
        default={},
        description="standard deviation of an error, such as turn=0.05: at most a quarter of what the error can be, "
        "and at most 1; facets up to 1 and pitches up to 0.05; a drawn separation below 0 is made positive; "
        "if facets or pitches is given, each build has random prisms of its own",
    )
    builds: Annotated[int, Field(ge=1, le=100_000)] = Field(default=200, description="random builds, 1 to 100000")
    seed: Annotated[int, Field(ge=0, lt=2**32)] = Field(default=1, description="seed of random numbers, 0 to 2^32 - 1")

    @model_validator(mode="after")
    def _check_deviation(self) -> Self:
        for name, value in self.deviation.items():
            # few builds have an error of more than four standard deviations
            most = min(1.0, ERRORS[name].most / (1 if name in RANDOM else 4))
            if value > most:
                raise ValueError(f"deviation: {name} = {value:g}; allowed: greater than 0, up to {most:g}")
        return self


class Change(NamedTuple):
    """How differently the first object appears: arrays, or single numbers."""

    displaced: Any  # arcminutes, as the eye sees it
    turned: Any  # degrees, counter-clockwise
    magnified: Any  # percent
    blurred: Any  # change of the RMS blur, arcminutes


def sensitivities(scene: AxialScene, workers: int | None = None, scheduler: str | None = None) -> dict[str, Change]:
    """Return, for each error, by how much one unit of it changes what is seen.

    The unit is a degree; for `separation` it is a tile, and for an index a difference of 1. Two scenes are compared:
    the error is less by its step of `STEPS` in one, and greater in the other. If the scene does not allow the whole
    step, a part of it is used; if it allows no part, the error stays as it is. The difference in what is seen is
    divided by the difference between the two errors. `displaced` has no sign. If a tilt can be both less and greater,
    each of the two scenes is compared with the given one: `_tilted`. `workers` and `scheduler` are as for
    `measure.results.results`. Raises InputError for sheets other than one pair of prisms, and for an error that can
    be neither less nor greater.
    """
    _check(scene)
    ends = {name: (_moved(scene, name, -step), _moved(scene, name, step)) for name, step in STEPS.items()}
    seen = _seen([scene, *(end for both in ends.values() for end in both)], workers, scheduler)
    found = {}
    for number, (name, both) in enumerate(ends.items()):
        less, more = (end.error.get(name, 0.0) - scene.error.get(name, 0.0) for end in both)
        if less == more:
            raise InputError(f"error: {name}: the scene allows neither less nor more of it")
        before, after = seen[:, 2 * number + 1], seen[:, 2 * number + 2]
        if "tilt" in name and less and more:
            sides = [_change(scene, seen[:, 0], end) for end in (before, after)]
            found[name] = _tilted(np.divide(sides[0], -less), np.divide(sides[1], more))
        else:
            found[name] = Change(*(each / (more - less) for each in _change(scene, before, after)))
    return found


def _tilted(less: Floats, more: Floats) -> Change:
    """Return the greater of the changes by one degree less and by one degree more of a tilt.

    `less` and `more` (4,) are the fields of `Change` for one degree. A tilt either way moves a sheet away from the
    other sheet. In the difference between the two scenes, the effect of this would cancel. The sign is that of the
    change by one degree more.
    """
    displaced, *others = np.copysign(np.maximum(abs(less), abs(more)), more)
    return Change(abs(displaced), *others)


def _moved(scene: AxialScene, name: str, step: float) -> AxialScene:
    """Return the scene with an error changed by a step, by 1/2 to 1/16 of it if the scene allows no more, or by 0."""
    for part in (1, 1 / 2, 1 / 4, 1 / 8, 1 / 16):
        with suppress(InputError):
            return scene.replace(error={**scene.error, name: scene.error.get(name, 0.0) + part * step})
    return scene


def random_builds(scene: AxialScene, spread: Spread) -> list[AxialScene]:
    """Return random builds of a scene.

    The drawn errors are added to the scene's own. `facets` and `pitches` replace the scene's, and each build has
    another `seed`. Raises InputError for other sheets than one pair of prisms, and for an error outside its range.
    """
    _check(scene)
    # in one order, however the user gave them: else a seed would stand for several builds
    deviation = {name: spread.deviation[name] for name in STEPS if name in spread.deviation}
    random = {name: value for name, value in spread.deviation.items() if name in RANDOM}
    normal = np.random.default_rng(spread.seed).normal(size=(spread.builds, len(deviation)))
    seeds = np.random.default_rng([spread.seed, 1]).integers(10**9, size=spread.builds).tolist()
    scenes = []
    for number, errors in enumerate((normal * list(deviation.values())).tolist()):
        added = dict(zip(deviation, errors, strict=True))
        error = {name: scene.error.get(name, 0.0) + added.get(name, 0.0) for name in ERRORS}
        if random:  # each build has prisms of its own
            error |= random | {"seed": seeds[number]}
        try:
            scenes.append(scene.replace(error=error | {"separation": abs(error["separation"])}))
        except InputError as problem:
            raise InputError(f"random build {number + 1}: {problem}") from None
    return scenes


def builds(
    scene: AxialScene, made: Sequence[AxialScene], workers: int | None = None, scheduler: str | None = None
) -> Change:
    """Return the changes, without signs, from the scene to each of `made`, the result of `random_builds`: (builds,).

    `workers` and `scheduler` are as for `measure.results.results`.
    """
    seen = _seen([scene, *made], workers, scheduler)
    change = _change(scene, seen[:, :1], seen[:, 1:])
    return Change(*map(abs, change))


def percentile(changes: Floats, share: float) -> float:
    """Return the change that `share` percent of the builds do not exceed.

    If a build does not show the object, its change counts as infinite.
    """
    return float(np.percentile(np.nan_to_num(changes, nan=np.inf, posinf=np.inf), share, method="higher"))


def _check(scene: AxialScene) -> None:
    if not isinstance(scene.sheets[0], PrismPair) or scene.window:
        raise InputError(
            f"windows: {1 + len(scene.window)}, sheet = {scene.sheet!r}; allowed: one window, sheet = 'detailed'"
        )
    if np.isnan(results([scene], "seen_x", progress=False)["seen_x"][0]):
        raise InputError(
            "the eye does not see the object on the designed path, or sees it at infinity; allowed: another place "
            "of the object or the eye, or another alpha"
        )


def _seen(scenes: list[AxialScene], workers: int | None, scheduler: str | None) -> Seen:
    table = results(scenes, *SPREADS, workers=workers, scheduler=scheduler)
    return np.stack([table[name] for name in SPREADS])


def _change(scene: AxialScene, before: Seen, after: Seen) -> Change:
    """Return how differently an object appears."""
    (x, y, nu, M, _), (x1, y1, nu1, M1, _) = before, after
    there, here = (scene.camera.through(position).direction for position in (x1 + 1j * y1, x + 1j * y))
    angle = 2 * np.arcsin(np.linalg.norm(there - here, axis=-1) / 2)
    blurred = _blur_angle(scene, after) - _blur_angle(scene, before)
    return Change(angle / ARCMINUTE, (nu1 - nu + 180) % 360 - 180, 100 * (M1 / M - 1), blurred / ARCMINUTE)


def _blur_angle(scene: AxialScene, seen: Seen) -> Floats:
    """Return the RMS blur as the eye sees it, radians.

    D is the distance from the eye to the position. From the eye, a unit of length in the plane z = 0 is seen at an
    angle: z2/D^2 along the plane that contains the line of sight and the normal, and 1/D perpendicular to that plane.
    The blur is taken as equal in all directions.
    """
    x, y, _, _, blur = seen
    square = scene.z2**2 + abs(x + 1j * y - scene.E) ** 2
    return np.asarray(blur * np.sqrt((1 / square + scene.z2**2 / square**2) / 2))
