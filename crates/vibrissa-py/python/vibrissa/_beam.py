"""One loaded whisker, or a million."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt

from . import _vibrissa
from ._arrays import column
from ._errors import UsageError
from ._robot import Whisker
from ._vibrissa import Bend, Bends

Load = Literal["normal", "vertical", "tilted", "directed"]
"""Direction of a positive force: along the whisker's normal at the contact; across the undeflected whisker; turned from the
normal by ``angle`` (rad); in the direction ``angle`` of the whisker frame (rad)."""
Faults = Literal["raise", "skip"]


def _solve(
    given: str,
    first: npt.ArrayLike,
    second: npt.ArrayLike,
    load: str,
    angle: npt.ArrayLike | None,
    whisker: Whisker | Sequence[Whisker] | None,
    errors: Faults,
    threads: int | None,
) -> Bends:
    if errors not in ("raise", "skip"):
        raise UsageError(f"errors: {errors!r} (allowed: 'raise', 'skip')")
    whiskers = [whisker or Whisker()] if whisker is None or isinstance(whisker, Whisker) else list(whisker)
    columns = [np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)]
    if angle is not None:
        columns.append(np.asarray(angle, dtype=np.float64))
    shapes = [values.shape for values in columns]
    if len(whiskers) != 1:
        shapes.append((len(whiskers),))
    try:
        shape = np.broadcast_shapes(*shapes)
    except ValueError as fault:
        raise UsageError(f"the arguments' shapes do not fit together: {fault}") from None
    count = math.prod(shape)
    if len(whiskers) not in (1, count):
        raise UsageError(f"number of whiskers: {len(whiskers)} (allowed: 1 or {count}, one for each problem)")
    # One number for all problems crosses as one.
    a, b, *angles = (column(v if v.size == 1 else np.broadcast_to(v, shape)) for v in columns)
    return _vibrissa.bends(
        given, count, a, b, load, angles[0] if angles else None, whiskers, errors == "skip", threads
    )


def force_mode(
    force: npt.ArrayLike,
    s_a: npt.ArrayLike,
    *,
    load: Load = "normal",
    angle: npt.ArrayLike | None = None,
    whisker: Whisker | Sequence[Whisker] | None = None,
    errors: Faults = "raise",
    threads: int | None = None,
) -> Bends:
    """The equilibria of whiskers under known forces (N) at known arc lengths ``s_a`` (m).

    ``force``, ``s_a`` and ``angle`` (rad, of the loads "tilted" and "directed") broadcast; problems are counted from 0 in
    the order of the flattened result. ``whisker``: one for all, or one for each problem. ``errors="skip"`` leaves problems that
    make no sense without a solution and lists them in ``Bends.faults``. ``threads``: None for all cores; the answer is the
    same to the bit.
    """
    return _solve("force", force, s_a, load, angle, whisker, errors, threads)


def moment_mode(
    moment: npt.ArrayLike,
    s_a: npt.ArrayLike,
    *,
    load: Load = "normal",
    angle: npt.ArrayLike | None = None,
    whisker: Whisker | Sequence[Whisker] | None = None,
    errors: Faults = "raise",
    threads: int | None = None,
) -> Bends:
    """The equilibria of whiskers with known moments about the base (N m) and arc lengths ``s_a`` (m), every branch.

    The other arguments are those of ``force_mode``.
    """
    return _solve("moment", moment, s_a, load, angle, whisker, errors, threads)


def point_mode(
    x: npt.ArrayLike,
    y: npt.ArrayLike,
    *,
    load: Load = "normal",
    angle: npt.ArrayLike | None = None,
    whisker: Whisker | Sequence[Whisker] | None = None,
    errors: Faults = "raise",
    threads: int | None = None,
) -> Bends:
    """The equilibria of whiskers touched at known points (m) of their own frame, every branch.

    The other arguments are those of ``force_mode``.
    """
    return _solve("point", x, y, load, angle, whisker, errors, threads)


def tip_mode(
    x: npt.ArrayLike,
    y: npt.ArrayLike,
    *,
    whisker: Whisker | Sequence[Whisker] | None = None,
    errors: Faults = "raise",
    threads: int | None = None,
) -> Bends:
    """The equilibria of whiskers whose tips are held at known points (m), least energy first: force and its direction.

    The other arguments are those of ``force_mode``.
    """
    return _solve("tip", x, y, "normal", None, whisker, errors, threads)


__all__ = ["Bend", "Bends", "Load", "force_mode", "moment_mode", "point_mode", "tip_mode"]
