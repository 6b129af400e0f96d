"""One loaded whisker, or a million."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt

from . import _vibrissa
from ._arrays import Floats, column
from ._errors import UsageError
from ._robot import Whisker, number
from ._vibrissa import Bend, Bends

Load = Literal["normal", "vertical", "tilted", "directed"]
"""Direction of a positive force: along the whisker's normal at the contact; across the undeflected whisker; turned from the
normal by ``angle`` (rad); in the direction ``angle`` of the whisker frame (rad)."""
Faults = Literal["raise", "skip"]


_ARGUMENTS = {
    "force": (("force", "force"), ("s_a", "length")),
    "moment": (("moment", "moment"), ("s_a", "length")),
    "point": (("x", "length"), ("y", "length")),
    "tip": (("x", "length"), ("y", "length")),
}
"""The two arguments of each problem, and the dimension of each."""


def _numbers(name: str, dimension: str, given: npt.ArrayLike) -> Floats:
    """Numbers (SI), or one text with its unit."""
    return np.asarray(number(name, given, dimension) if isinstance(given, str) else given, dtype=np.float64)


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
    names = _ARGUMENTS[given]
    columns = [_numbers(name, kind, one) for (name, kind), one in zip(names, (first, second), strict=True)]
    if angle is not None:
        columns.append(_numbers("angle", "angle", angle))
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
    """Finds the equilibria of whiskers under known forces at known arc lengths.

    Parameters
    ----------
    force : array_like
        The forces (N); one may be a text with its unit, as may all numbers here: "0.1 N".
    s_a : array_like
        The arc lengths at which they act (m).
    load : {"normal", "vertical", "tilted", "directed"}
        The direction of a positive force; see ``Load``.
    angle : array_like, optional
        The angle of the loads "tilted" and "directed" (rad).
    whisker : Whisker or sequence of Whisker, optional
        One for all problems, or one for each; None for the paper's.
    errors : {"raise", "skip"}
        What happens with a problem that makes no sense: a fault, or no solution and an entry in ``Bends.faults``.
    threads : int, optional
        None for all cores; the answer is the same to the bit.

    Returns
    -------
    Bends
        One row for each solution. ``Bends.case`` says which problem a row solves, counted from 0 in the order of the
        flattened result of broadcasting ``force``, ``s_a`` and ``angle``.

    Raises
    ------
    UsageError
        Shapes that do not fit together, or a problem that makes no sense.

    Examples
    --------
    >>> bends = vibrissa.force_mode([0.05, 0.1, 0.2], 0.06)
    >>> bends.x, bends.y, bends.moment
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
    """Finds the equilibria of whiskers with known moments about the base, every branch.

    Parameters
    ----------
    moment : array_like
        The moments (N m).
    s_a : array_like
        The arc lengths of the contacts (m).
    load, angle, whisker, errors, threads
        As in ``force_mode``.

    Returns
    -------
    Bends
        One row for each solution; see ``force_mode``.

    Raises
    ------
    UsageError
        Shapes that do not fit together, or a problem that makes no sense.
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
    """Finds the equilibria of whiskers that are touched at known points, every branch.

    Parameters
    ----------
    x, y : array_like
        The points, whisker frame (m).
    load, angle, whisker, errors, threads
        As in ``force_mode``.

    Returns
    -------
    Bends
        One row for each solution; see ``force_mode``.

    Raises
    ------
    UsageError
        Shapes that do not fit together, or a problem that makes no sense.
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
    """Finds the equilibria of whiskers whose tips are held at known points, least energy first: force and its direction.

    Parameters
    ----------
    x, y : array_like
        The points, whisker frame (m).
    whisker, errors, threads
        As in ``force_mode``.

    Returns
    -------
    Bends
        One row for each solution; see ``force_mode``.

    Raises
    ------
    UsageError
        Shapes that do not fit together, or a problem that makes no sense.
    """
    return _solve("tip", x, y, "normal", None, whisker, errors, threads)


__all__ = ["Bend", "Bends", "Load", "force_mode", "moment_mode", "point_mode", "tip_mode"]
