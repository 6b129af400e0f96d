"""How long a million force problems take in one call, with three columns of answers: milliseconds, the median of five."""

import statistics
import time

import numpy as np

import vibrissa

share = np.arange(1_000_000) / 999_999
force, s_a = -0.3 + 0.6 * share, 0.02 + 0.055 * share


def once() -> float:
    start = time.perf_counter()
    bends = vibrissa.force_mode(force, s_a)
    columns = bends.x, bends.y, bends.moment
    assert all(column.size == len(bends) for column in columns)
    return (time.perf_counter() - start) * 1e3


print(f"{statistics.median(once() for _ in range(5)):.1f}")
