"""Maps and sensor logs."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping

import numpy as np
import numpy.typing as npt

from ._arrays import Floats, column, rows
from ._errors import UsageError
from ._vibrissa import Map, SensorLog

MapLike = Map | str | os.PathLike[str]
LogLike = SensorLog | str | os.PathLike[str]


def map_of(
    arenas: Iterable[npt.ArrayLike] = (),
    obstacles: Iterable[npt.ArrayLike] = (),
    walls: Iterable[npt.ArrayLike] = (),
) -> Map:
    """The map of corner points (m), each line an array of shape (n, 2).

    Free space is inside the arenas and outside the obstacles; a wall is thin and solid on both sides.
    """
    lines = ([rows(line, 2) for line in group] for group in (arenas, obstacles, walls))
    return Map._from_points(*lines)


def arena() -> Map:
    """The built-in arena of the demo: 460 mm by 320 mm with curved and straight walls and two obstacles."""
    return Map.demo()


def log(
    t: npt.ArrayLike,
    odometry: npt.ArrayLike,
    readings: Mapping[str, npt.ArrayLike] | npt.ArrayLike,
    heading: npt.ArrayLike | None = None,
) -> SensorLog:
    """The log of arrays, with the checks and warnings that files go through.

    t: time stamps (s), shape (rows). odometry: x (m), y (m), theta (rad) of the robot from any origin, shape (rows, 3).
    readings: the moments (N m) of shape (rows), or columns by name as a file's header has them ("moment", "w0.moment",
    "bx", …). heading: absolute headings in the map frame (rad).
    """
    named = readings if isinstance(readings, Mapping) else {"moment": readings}
    poses = rows(odometry, 3)
    if poses.shape[1] != 3:
        raise UsageError(f"the columns of odometry: {poses.shape[1]} (allowed: 3: x, y, theta)")
    columns: dict[str, Floats] = {"t": column(t), "x": poses[:, 0], "y": poses[:, 1], "theta": poses[:, 2]}
    columns.update({name: column(values) for name, values in named.items()})
    if heading is not None:
        columns["heading"] = column(heading)
    return SensorLog._from_columns(equal_columns(columns))


def equal_columns(columns: Mapping[str, npt.ArrayLike]) -> list[tuple[str, Floats]]:
    """Columns of one length."""
    made = [(name, np.ascontiguousarray(column(values))) for name, values in columns.items()]
    lengths = {name: values.size for name, values in made}
    if len(set(lengths.values())) > 1:
        told = ", ".join(f"{name} {size}" for name, size in lengths.items())
        raise UsageError(f"the columns have different lengths: {told}")
    return made


def read_map(source: MapLike) -> Map:
    """A map, or the file of one."""
    return source if isinstance(source, Map) else Map.read(source)


def read_log(source: LogLike, format: str | None = None) -> SensorLog:
    """A log, or the file of one."""
    return source if isinstance(source, SensorLog) else SensorLog.read(source, format)
