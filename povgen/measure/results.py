"""A table of many scenes: their parameters and `scene.quantities`, computed on all cores, or on a cluster."""

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import chain, islice, product
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from povgen.errors import InputError, shown
from povgen.inputs.fields import as_tuple
from povgen.measure.table import Table
from povgen.progress import bar
from povgen.record import recorded_call
from povgen.rendering.parallel import checked_scheduler, computed, cores, worker_count
from povgen.scene.presets import SCENES, AxialScene
from povgen.scene.quantities import QUANTITIES, STACKED, parameters, stacked
from povgen.scene.scene import Scene, checked_scene, checked_scenes, classes
from povgen.validation import as_flag, is_several

PATIENCE = 0.5  # seconds after which other processes are started, which takes about as long
MOST = 200_000  # scenes of a table
PARTS = 4  # of the scenes, for each of a cluster's calls at once: AHEAD calls for each thread of its workers

Done = Callable[[], object]
Lists = Mapping[str, list[Any]]  # the values of each parameter that is swept


@recorded_call
def results(
    scenes: Scene | Iterable[Scene],
    *quantities: str,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: bool = True,
    **swept: Iterable[Any],
) -> Table:
    """Return a table with a row for each scene: a dictionary of arrays (n,), such as pandas.DataFrame takes.

    `results(scene, "nu", alpha=range(180), z1=(1, 2))` is for the scene with all combinations of these values. The last
    parameter's value changes first. For a room: `results(room, "x", **{"left.alpha": range(180)})`. For a window behind
    the first one: `results(scene, "x", window2_alpha=range(180))`. The columns are the parameters in which the scenes
    differ, by names such as alpha, eye_x, window2_z and z1_2, and the quantities. `povgen.scene.quantities` says what
    they are. Two columns cannot have one name: beside the quantity x, the parameter x is the column scene_x.
    Lengths are in tiles, angles in degrees. A number that does not exist is NaN, a missing text is empty.
    `Table.to_xarray` returns the table as a dataset.

    Predictions for lists of alpha, z1 and z2 are computed together, in this process. `workers` processes compute the
    rest, by default one for each core. With `scheduler`, the address of a Dask scheduler, its workers compute all.
    `progress=False` shows no progress bar. Raises InputError for what is no scene or no quantity, if no quantity is
    given, for a quantity that a room does not have, for values that are not allowed or no lists, and for `workers` or a
    `scheduler` that is not allowed. Raises PovrayError if the cluster fails.
    """
    wrong = [name for name in quantities if not isinstance(name, str) or name not in QUANTITIES]
    if wrong or not quantities:
        what = f"quantity = {shown(wrong[0])}" if wrong else "no quantity"
        raise InputError(f"{what}; allowed: {', '.join(QUANTITIES)}")
    count, scheduler = worker_count(workers) or cores(), checked_scheduler(scheduler)
    hidden = not as_flag("progress", progress)
    lists = _lists(swept)
    if lists:
        scene = _checked(scenes, quantities)
        at_once = scheduler is None and all(QUANTITIES[name].stacks for name in quantities)
        if at_once and (table := _of_sweep(scene, lists, quantities)) is not None:
            return table
        scenes = [_with(scene, dict(zip(lists, values, strict=True))) for values in product(*lists.values())]
    given = checked_scenes(scenes if is_several(scenes) else [scenes], MOST)
    for each in given:
        _checked(each, quantities)
    found = np.zeros((len(given), len(quantities)))
    if given:
        with bar("results", len(given), hidden, "scenes") as done:
            if scheduler is None:
                found[:] = _computed(given, quantities, count, done)
            else:
                found[:] = _on_cluster(given, quantities, scheduler, done)
    columns = _columns(given, lists)
    lengths = {name: len(values) for name, values in lists.items()}
    return Table(columns, dict(zip(quantities, found.T, strict=True)), given[0] if given else None, lengths)


def values_of(scenes: Sequence[Scene], quantities: Sequence[str]) -> list[list[float]]:
    """Return the quantities of each scene."""
    return [[float(QUANTITIES[name].of(scene)) for name in quantities] for scene in scenes]


def _lists(swept: Mapping[str, Iterable[Any]]) -> Lists:
    """Return the values of each parameter. Raises InputError for one value that is no list, and for too many."""
    for name, values in swept.items():
        if not is_several(values):
            raise InputError(f"{name} = {shown(values)}: should be a list of values; allowed: such as {name}=[...]")
    lists = {name: [*islice(values, MOST + 1)] for name, values in swept.items()}
    if empty := [name for name, values in lists.items() if not values]:
        raise InputError(f"{empty[0]}: no values; allowed: one or more")
    if (count := prod(map(len, lists.values()))) > MOST:
        raise InputError(f"{', '.join(lists)}: {count} scenes or more; allowed: up to {MOST}")
    return lists


def _checked(scene: object, quantities: Sequence[str]) -> Scene:
    """Return the scene. Raises InputError if it is none, and for a room's quantities that only others have."""
    found = checked_scene(scene)
    if isinstance(found, AxialScene):
        return found
    if wrong := [name for name in quantities if not QUANTITIES[name].in_rooms]:
        allowed = ", ".join(name for name, each in QUANTITIES.items() if each.in_rooms)
        raise InputError(f"quantity = {wrong[0]!r}: not for a room; allowed: {allowed}, or {classes(AxialScene)}")
    return found


def _with(scene: Scene, values: dict[str, Any]) -> Scene:
    """Return a copy with these values. Numbers of a room's things have names such as left.alpha."""
    if isinstance(scene, AxialScene):
        return scene.with_numbers(values)
    inside = {name: x for name, x in values.items() if "." in name}
    made = scene.replace(**{name: value for name, value in values.items() if name not in inside})
    return made.with_numbers(inside) if inside else made


def _of_sweep(scene: Scene, lists: Lists, quantities: Sequence[str]) -> Table | None:
    """Return the table of predictions for all combinations of parameters of STACKED; None if they take no arrays.

    Only scenes with the least and the greatest values are made and checked: what is allowed is a range of each.
    """
    if not isinstance(scene, AxialScene) or type(scene) not in SCENES.values():
        return None
    if not lists.keys() <= {*STACKED} or any(map(is_several, chain(*lists.values()))):
        return None
    values = {name: np.asarray(each) for name, each in lists.items()}
    plain = all(each.dtype.kind in "iuf" for each in values.values())
    outlined = getattr(scene, "predicted_image", False)  # not allowed at the pole
    moving = "z2" in lists and "z1" not in lists and getattr(scene, "z1", None) is None  # spheres, with the eye
    if not plain or outlined or moving:
        return None
    for ends in product(*((each.min().item(), each.max().item()) for each in values.values())):
        scene.replace(**dict(zip(lists, ends, strict=True)))
    grid = [each.astype(float).ravel() for each in np.meshgrid(*values.values(), indexing="ij")]
    columns = {name: grid[[*lists].index(name)] for name in type(scene).model_fields if name in lists}
    own = {"alpha": scene.alpha, "z1": _first_z1(scene), "z2": scene.z2}
    stack = stacked(scene, {name: np.full(len(grid[0]), value, float) for name, value in own.items()} | columns)
    if stack is None:
        return None
    found = {name: np.array(np.broadcast_to(QUANTITIES[name].of(stack), len(grid[0])), float) for name in quantities}
    return Table(columns, found, scene, {name: len(each) for name, each in lists.items()})


def _first_z1(scene: AxialScene) -> float:
    given = getattr(scene, "z1", None)
    return scene.distances[0] if given is None else as_tuple(given)[0]


def _differing(scenes: Sequence[Scene]) -> list[str]:
    """Return the names of the fields in which the scenes differ."""
    kinds: dict[type[Scene], None] = dict.fromkeys(map(type, scenes))
    names = dict.fromkeys(name for kind in kinds for name in kind.model_fields)
    firsts = {name: getattr(scenes[0], name, None) for name in names}
    return [name for name, first in firsts.items() if any(getattr(each, name, None) != first for each in scenes)]


def _columns(scenes: Sequence[Scene], swept: Lists) -> dict[str, NDArray[Any]]:
    """Return the columns of the parameters that are swept, or else of all in which the scenes differ."""
    fields = swept or _differing(scenes)
    given = [parameters(scene, fields) for scene in scenes]
    names = dict.fromkeys(name for each in given for name in each)
    shown = [name for name in names if (swept and name != "scene") or len({each.get(name) for each in given}) > 1]
    return {name: _column([each.get(name) for each in given]) for name in shown}


def _column(values: list[Any]) -> NDArray[Any]:
    """Return a column: numbers, with NaN for those that are missing, or texts."""
    if any(isinstance(value, str) for value in values):
        return np.array(["" if value is None else str(value) for value in values])
    return np.array([np.nan if value is None else value for value in values])


def _computed(scenes: list[Scene], quantities: Sequence[str], workers: int, done: Done) -> list[list[float]]:
    """Return the quantities of each scene. What is left after PATIENCE seconds is computed by other processes."""
    rows: list[list[float]] = []
    # other processes know povgen's own scenes only
    alone = workers == 1 or any(type(scene) not in SCENES.values() for scene in scenes)
    start = time.monotonic()
    while len(rows) < len(scenes) and (alone or time.monotonic() - start < PATIENCE):
        rows.append(_row(quantities, scenes[len(rows)]))
        done()
    left = scenes[len(rows) :]
    later = computed(partial(_row, quantities), left, min(workers, len(left)), done) if left else {}
    return rows + [later[n] if n in later else _row(quantities, scene) for n, scene in enumerate(left)]


def _row(quantities: Sequence[str], scene: Scene) -> list[float]:
    return values_of([scene], quantities)[0]


def _on_cluster(scenes: list[Scene], quantities: Sequence[str], scheduler: str, done: Done) -> list[list[float]]:
    """Return the quantities of each scene, computed by a cluster's workers."""
    from povgen.rendering.cluster import Cluster

    rows: list[list[float]] = []
    with Cluster(scheduler, None) as cluster, ThreadPoolExecutor(cluster.frames) as pool:
        size = max(1, len(scenes) // (PARTS * cluster.frames))
        parts = [scenes[start : start + size] for start in range(0, len(scenes), size)]
        try:
            answers = pool.map(lambda part: cluster.call(values_of, part, quantities), parts)
            for answer in answers:
                rows += answer
                for _ in answer:
                    done()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            cluster.stop()
            raise
    return rows
