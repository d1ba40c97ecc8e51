"""The base class of results that contain arrays."""

from typing import Any

import numpy as np


class Values:
    """Two results of one class are equal if all their values are. NaN is equal to NaN."""

    __hash__ = None  # type: ignore[assignment]  # arrays have none

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and all(_same(each, vars(other)[name]) for name, each in vars(self).items())


def _same(one: Any, other: Any) -> bool:  # noqa: ANN401  (a value of any kind)
    if isinstance(one, (np.ndarray, float, complex)):
        return np.array_equal(one, other, equal_nan=True)
    return bool(one == other)
