"""Keep ray traces in the cache, because they take long, and many frames need the same one.

What a ray trace finds is a `survey.Survey`.
"""

import functools
import inspect
import pickle
import sys
from collections.abc import Iterable
from contextlib import suppress
from hashlib import sha256
from pathlib import Path

from povgen import limits, optics, sheets
from povgen.rendering import cache
from povgen.rendering.parallel import cores, end, python
from povgen.scene import scenes, survey, windows
from povgen.scene.scenes import Scene

EACH = 24  # a process makes at least this number of surveys: its start takes as long as about 15 of them


def found(scene: Scene, store: bool = False) -> survey.Survey | None:
    """Return the scene's survey, from the cache or from a new ray trace; None without prisms.

    With `store`, a survey from a ray trace is put into the cache, if povgen can write there.
    """
    return _of_inputs(survey.inputs(scene), store) if scene.has_prisms else None


def _of_inputs(given: survey.SurveyInputs, store: bool) -> survey.Survey:
    if values := cache.load_values(_key(given)):
        return survey.Survey(**values)
    made = survey.of_inputs(given)
    if store:
        cache.store_values(_key(given), made._asdict())
    return made


def _key(given: survey.SurveyInputs) -> str:
    return f"{_code_of_trace()}\0{given}"


def make(shown: Iterable[Scene]) -> None:
    """Put the surveys of many scenes into the cache. Several processes make those that are missing.

    If there are few scenes, if povgen cannot write in the cache, or if a process fails, some surveys stay missing:
    `found` makes them. Raises KeyboardInterrupt if povgen was asked to stop.
    """
    every = dict.fromkeys(survey.inputs(scene) for scene in shown if scene.has_prisms)
    if len(every) < 2 * EACH or cores() < 2:
        return
    missing = [given for given in every if not cache.load_values(_key(given))]
    count = min(cores(), len(missing) // EACH)
    processes = [python("povgen.rendering.surveys") for _ in range(count)] if count > 1 else []
    try:
        for number, process in enumerate(processes):
            assert process.stdin
            with suppress(OSError), process.stdin:  # the process has ended
                pickle.dump(missing[number::count], process.stdin)
        for process in processes:
            process.wait()
    finally:
        for process in processes:
            end(process)


@functools.cache
def _code_of_trace() -> str:
    """Return a checksum of the code that makes surveys. A survey that other code made is not used."""
    texts = [inspect.getsource(module) for module in (limits, scenes, survey, windows)]
    for package in (optics, sheets):
        texts += [file.read_text("utf-8") for file in sorted(Path(package.__path__[0]).glob("*.py"))]
    return sha256("\0".join(texts).encode()).hexdigest()


if __name__ == "__main__":  # a process of `make`
    with suppress(KeyboardInterrupt):
        for given in pickle.load(sys.stdin.buffer):
            _of_inputs(given, store=True)
