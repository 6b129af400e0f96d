"""Arrays on their way into the extension: contiguous float64."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]


def column(values: npt.ArrayLike) -> Floats:
    """One contiguous axis of float64."""
    return np.ascontiguousarray(values, dtype=np.float64).reshape(-1)


def rows(values: npt.ArrayLike, width: int) -> Floats:
    """A contiguous (n, width) array of float64; a single row may come as (width,)."""
    array = np.ascontiguousarray(values, dtype=np.float64)
    if array.size == 0:
        return array.reshape(0, width)
    return np.atleast_2d(array)
