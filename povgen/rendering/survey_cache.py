"""Keep the results of ray traces in the cache: a ray trace takes long, and many frames need the same one.

If many are missing, several processes make them. The result of a ray trace is a `survey.Survey`.
"""

import functools
import inspect
from collections.abc import Iterable
from hashlib import sha256
from pathlib import Path

from povgen import limits, optics, sheets
from povgen.rendering import cache
from povgen.rendering.parallel import computed, cores
from povgen.scene import survey
from povgen.scene.scene import Scene

MOST = 16  # processes that make surveys at once
EACH = 24  # surveys, at least, for each process: its start takes as long as about 15 surveys


def found(scene: Scene, store: bool = False) -> survey.Survey | None:
    """Return the scene's survey; None without prisms. If neither the cache nor this process has it, rays are traced.

    With `store`, a survey that was not in the cache is put there, if povgen can write there.
    """
    if not scene.has_prisms:
        return None
    given = survey.inputs(scene)
    if values := cache.load_values(_key(given)):
        return survey.Survey(**values)
    made = survey.of_inputs(given)
    if store:
        cache.store_values(_key(given), made._asdict())
    return made


def _key(given: survey.Inputs) -> str:
    return f"{_code_of_trace()}\0{given}"


def make(shown: Iterable[Scene]) -> None:
    """Make the surveys of many scenes by several processes. Those that are known, or in the cache, are not made again.

    If fewer than 2 * EACH are missing, no process is started. `found` makes these later, and also those of a process
    that fails.
    """
    every = dict.fromkeys(survey.inputs(scene) for scene in shown if scene.has_prisms)
    missing = [given for given in every if given not in survey.known and not cache.load_values(_key(given))]
    count = min(cores(), MOST, len(missing) // EACH)
    if count >= 2:
        for number, made in computed(survey.of_inputs, missing, count).items():
            survey.keep(missing[number], made)


@functools.cache
def _code_of_trace() -> str:
    """Return a checksum of the code that makes surveys. A survey that other code made is not used."""
    texts = [inspect.getsource(module) for module in (limits, survey)]
    for package in (optics, sheets):
        texts += [file.read_text("utf-8") for file in sorted(Path(package.__path__[0]).glob("*.py"))]
    return sha256("\0".join(texts).encode()).hexdigest()
