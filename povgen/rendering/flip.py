"""FLIP: how different two pictures look, 0 to 1."""

from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from povgen import remedies
from povgen.errors import InputError
from povgen.rendering.light import Picture

# The sampling of the pictures that others are compared with: 81 rays in each pixel that differs from a neighbour by
# more than 0.001.
CONVERGED = "1,0.001,9"


def flip(picture: Picture, reference: Picture) -> NDArray[np.float32]:
    """Return FLIP of each pixel, (height, width). Raises InputError if flip-evaluator is not installed.

    Both pictures are sRGB bytes, (height, width, 3).
    """
    a, b = (np.ascontiguousarray(image / np.float32(255), np.float32) for image in (reference, picture))
    return np.asarray(flip_evaluator().evaluate(a, b, "LDR", applyMagma=False)[0][..., 0], np.float32)


def flip_evaluator() -> ModuleType:
    """Import the package that measures FLIP. Raises InputError if it is not installed."""
    try:
        import flip_evaluator
    except ImportError:
        text = f"FLIP is measured with flip-evaluator, which is not installed: {remedies.extra('charts')}"
        raise InputError(f"{text}; a tolerance in px needs no FLIP") from None
    evaluator: ModuleType = flip_evaluator
    return evaluator
