"""Maps and sensor logs."""

from __future__ import annotations

import os

from ._errors import UsageError
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
    if isinstance(source, Map):
        return source
    _a_path("map", source, "a Map", SensorLog)
    return Map.read(source)


def read_log(source: LogLike, format: str | None = None) -> SensorLog:
    """A log, or the file of one."""
    if isinstance(source, SensorLog):
        return source
    _a_path("log", source, "a SensorLog", Map)
    return SensorLog.read(source, format)


def _a_path(name: str, given: object, wanted: str, other: type) -> None:
    """Refuses what is no name of a file either."""
    if isinstance(given, (str, os.PathLike)):
        return
    swapped = "\n  help: the log comes first, then the map" if isinstance(given, other) else ""
    if type(given).__name__ == "DataFrame" and name == "log":
        swapped = "\n  help: write SensorLog(t, odometry, readings), or save it with frame.to_csv(FILE, index=False)"
    raise UsageError(f"{name}: {type(given).__name__} (allowed: {wanted}, or the name of its file){swapped}")
