"""Maps and sensor logs."""

from __future__ import annotations

import os

from ._vibrissa import Map, SensorLog

MapLike = Map | str | os.PathLike[str]
LogLike = SensorLog | str | os.PathLike[str]


def arena() -> Map:
    """Gives the built-in arena of the demo.

    Returns
    -------
    Map
        460 mm by 320 mm with curved and straight walls and two obstacles.
    """
    return Map.demo()


def read_map(source: MapLike) -> Map:
    """A map, or the file of one."""
    return source if isinstance(source, Map) else Map.read(source)


def read_log(source: LogLike, format: str | None = None) -> SensorLog:
    """A log, or the file of one."""
    return source if isinstance(source, SensorLog) else SensorLog.read(source, format)
