"""Keep ray traces in the cache, because they take long, and many frames need the same one.

What a ray trace finds is a `prediction.Survey`.
"""

import functools
import inspect
from hashlib import sha256

from povgen.optics import polarisation, prism, rotation, series, trace
from povgen.rendering import cache
from povgen.scene import limits, prediction
from povgen.scene.models import Scene

OPTICS = (polarisation, prism, rotation, series, trace)  # all modules of povgen.optics that a survey uses


def load(scene: Scene, store: bool = False) -> None:
    """Give `prediction.survey` this scene's survey: from the cache, or from a new ray trace.

    With `store`, a survey from a ray trace is put into the cache, if povgen can write there.
    """
    if not scene.has_prisms:
        return
    rays = prediction.surveyed(scene)
    key = f"{_code_of_trace()}\0{rays}"
    if values := cache.load_values(key):
        prediction.surveys[rays] = prediction.Survey(**values)
        return
    survey = prediction.survey(scene)
    if store:
        cache.store_values(key, survey._asdict())


@functools.cache
def _code_of_trace() -> str:
    """Return a checksum of the code that makes surveys. A survey that other code made is not used."""
    texts = [inspect.getsource(module) for module in (limits, prediction, *OPTICS)]
    return sha256("\0".join(texts).encode()).hexdigest()
