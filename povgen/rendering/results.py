"""A table of many scenes: their parameters and `scene.quantities`, computed on all cores, or on a cluster."""

import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from povgen.errors import InputError, shown
from povgen.progress import bar
from povgen.rendering.parallel import checked_scheduler, computed, cores, worker_count
from povgen.scene.quantities import QUANTITIES, parameters
from povgen.scene.scene import Scene, checked_scenes
from povgen.scene.scenes import SCENES, AxialScene, checked_axial
from povgen.validation import as_flag, is_several

PATIENCE = 0.5  # seconds after which other processes are started, which takes about as long
MOST = 200_000  # scenes of a table
PARTS = 4  # of the scenes, for each of a cluster's calls at once: AHEAD calls for each thread of its workers

Done = Callable[[], object]


def results(
    scenes: Scene | Iterable[Scene],
    *quantities: str,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: bool = True,
) -> dict[str, NDArray[Any]]:
    """Return a table with a row for each scene, as a dictionary of arrays (n,), such as pandas.DataFrame takes.

    Its columns are the parameters in which the scenes differ, by names such as alpha, eye_x, window2_z and z1_2, and
    the quantities. `povgen.scene.quantities` says what they are. A parameter with the name of one of these quantities
    gets the prefix scene_: beside the quantity x, the parameter x is the column scene_x.
    Lengths are in tiles, angles in degrees. A number that does not exist is NaN, a missing text is empty.

    `workers` processes compute at once, by default one for each core. With `scheduler`, the address of a Dask
    scheduler, its workers compute instead. `progress=False` shows no progress bar. Raises InputError for what is no
    scene or no quantity, for a room, if no quantity is given, and for `workers` or a `scheduler` that is not allowed.
    Raises PovrayError if the cluster fails.
    """
    checked = checked_scenes(scenes if is_several(scenes) else [scenes], MOST)
    axial = [checked_axial(scene, "a table of quantities") for scene in checked]
    wrong = [name for name in quantities if not isinstance(name, str) or name not in QUANTITIES]
    if wrong or not quantities:
        what = f"quantity = {shown(wrong[0])}" if wrong else "no quantity"
        raise InputError(f"{what}; allowed: {', '.join(QUANTITIES)}")
    count, scheduler = worker_count(workers) or cores(), checked_scheduler(scheduler)
    with bar("results", len(axial), not as_flag("progress", progress), "scenes") as done:
        if scheduler is None:
            rows = _computed(axial, quantities, count, done)
        else:
            rows = _on_cluster(axial, quantities, scheduler, done)
    given = [parameters(scene) for scene in axial]
    names = list(dict.fromkeys(name for each in given for name in each))
    differ = [name for name in names if len({each.get(name) for each in given}) > 1]
    columns = [f"scene_{name}" if name in quantities else name for name in differ]
    table = {column: _column([each.get(name) for each in given]) for column, name in zip(columns, differ, strict=True)}
    return table | {name: np.array([row[n] for row in rows], float) for n, name in enumerate(quantities)}


def values_of(scenes: Sequence[AxialScene], quantities: Sequence[str]) -> list[list[float]]:
    """Return the quantities of each scene."""
    return [[QUANTITIES[name].of(scene) for name in quantities] for scene in scenes]


def _column(values: list[Any]) -> NDArray[Any]:
    """Return a column: numbers, with NaN for those that are missing, or texts."""
    if any(isinstance(value, str) for value in values):
        return np.array(["" if value is None else str(value) for value in values])
    return np.array([np.nan if value is None else value for value in values])


def _computed(scenes: list[AxialScene], quantities: Sequence[str], workers: int, done: Done) -> list[list[float]]:
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


def _row(quantities: Sequence[str], scene: AxialScene) -> list[float]:
    return values_of([scene], quantities)[0]


def _on_cluster(scenes: list[AxialScene], quantities: Sequence[str], scheduler: str, done: Done) -> list[list[float]]:
    """Return the quantities of each scene, computed by a cluster's workers."""
    from povgen.rendering.cluster import Cluster

    rows: list[list[float]] = []
    with Cluster(scheduler, None) as cluster, ThreadPoolExecutor(cluster.frames) as pool:
        size = max(1, len(scenes) // (PARTS * cluster.frames))
        parts = [scenes[start : start + size] for start in range(0, len(scenes), size)]
        try:
            answers = pool.map(lambda part: cluster.call(values_of, part, quantities), parts)
            for part, answer in zip(parts, answers, strict=True):
                if not _is_table(answer, len(part), len(quantities)):
                    raise cluster.other_code(answer)
                rows += answer
                for _ in part:
                    done()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            cluster.stop()
            raise
    return rows


def _is_table(answer: Any, height: int, width: int) -> bool:  # noqa: ANN401  (any object)
    """Return whether an answer of a worker is a list of rows of numbers."""
    try:
        return isinstance(answer, list) and np.asarray(answer, float).shape == (height, width)
    except (TypeError, ValueError):
        return False
