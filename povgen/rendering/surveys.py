"""Keep ray traces in the cache, because they take long, and many frames need the same one.

What a ray trace finds is a `survey.Survey`.
"""

import functools
import inspect
from hashlib import sha256
from pathlib import Path

from povgen import limits, optics, sheets
from povgen.rendering import cache
from povgen.scene import scenes, survey, windows
from povgen.scene.scenes import Scene


def found(scene: Scene, store: bool = False) -> survey.Survey | None:
    """Return the scene's survey, from the cache or from a new ray trace; None without prisms.

    With `store`, a survey from a ray trace is put into the cache, if povgen can write there.
    """
    if not scene.has_prisms:
        return None
    key = f"{_code_of_trace()}\0{survey.inputs(scene)}"
    if values := cache.load_values(key):
        return survey.Survey(**values)
    made = survey.survey(scene)
    if store:
        cache.store_values(key, made._asdict())
    return made


@functools.cache
def _code_of_trace() -> str:
    """Return a checksum of the code that makes surveys. A survey that other code made is not used."""
    texts = [inspect.getsource(module) for module in (limits, scenes, survey, windows)]
    for package in (optics, sheets):
        texts += [file.read_text("utf-8") for file in sorted(Path(package.__path__[0]).glob("*.py"))]
    return sha256("\0".join(texts).encode()).hexdigest()
