"""Maps from logs alone: the outline of what whiskers touched, and the robot's way."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Any, Literal, NamedTuple

from . import _vibrissa
from ._arrays import Floats
from ._contact import Alignment
from ._docs import documented
from ._robot import RobotLike, number, robot_of
from ._show import Shown, axes, draw_map, plane
from ._trajectory import Trajectory
from ._vibrissa import Map, SensorLog
from ._world import LogLike, MapLike, read_log, read_map


class Closure(NamedTuple):
    """A place to which the robot came back, or may have."""

    later: float
    """When it was there later (s)."""
    earlier: float
    """When it was there earlier (s)."""
    verdict: Literal["proved", "hypothesis", "contradiction", "unfinished"]
    """Whether no other place within the declared bounds of the odometry explains what was felt."""
    places: int
    """Separate places that do."""
    extent: tuple[float, float, float]
    """Half of their extent: x, y (m) and heading (rad)."""
    logs: tuple[int, int] = (0, 0)
    """The logs of both times, by their number from 0, the later first."""


class Share(NamedTuple):
    """A quantity with its standard deviation."""

    value: float
    """The value."""
    std: float
    """Its standard deviation."""


@dataclass(frozen=True, eq=False, repr=False)
class Visit(Shown):
    """One of the logs of a map."""

    placed: Literal["proved", "hypothesis", "contradiction", "unfinished"]
    """Whether it is known where the log begins; proved for the first one. Without a proof it adds nothing to the map."""
    places: int
    """How many places in the map are left for it."""
    trajectory: Trajectory
    """The robot at every row."""
    covariance_t: Floats
    """When the covariances hold (s), shape (keys)."""
    covariances: Floats
    """Of the robot's pose relative to the first log's first row, by x, y (m) and heading (rad), shape (keys, 3, 3)."""


@dataclass(frozen=True, eq=False, repr=False)
class WallChange(Shown):
    """A stretch of wall that is not where an earlier log felt it."""

    log: int
    """The log that tells, by its number from 0."""
    kind: Literal["moved", "gone"]
    """Whether it was felt elsewhere, or the robot passed where it was."""
    moved: Share | None
    """How far it moved towards the robot's side (m)."""
    length: float
    """Its length along the wall (m)."""
    points: Floats
    """Where that log felt it, or where it was before (m), shape (points, 2)."""


@dataclass(frozen=True, eq=False, repr=False)
class MappedLog(Shown):
    """A map made by touch, in the odometry frame of the first log's first row."""

    map: Map
    """Boundaries with bands and unknown stretches; ``localize`` takes it, ``map.to_geojson()`` is its file."""
    known: float
    """Length of wall that is known (m)."""
    unknown: float
    """Length that is not (m)."""
    points: Floats
    """Points along what is known, 1 mm apart (m), shape (points, 2)."""
    corners: Floats
    """Corners that were found: x, y, standard deviation (m), shape (corners, 3)."""
    trajectory: Trajectory
    """The robot at every row of the first log."""
    covariance_t: Floats
    """When the covariances hold (s), shape (keys)."""
    covariances: Floats
    """Of the robot's pose relative to the first row, by x, y (m) and heading (rad), shape (keys, 3, 3)."""
    visits: list[Visit]
    """All logs, in their order."""
    changes: list[WallChange]
    """Walls that are not where an earlier log felt them."""
    scale: Share
    """Ways are longer than the odometry tells by this share."""
    turn: Share
    """Turns are larger than it tells by this share."""
    drift: Share
    """The heading turns by so much more along the way (rad/m)."""
    closures: list[Closure]
    """Where the robot came back, or may have."""
    graph: dict[str, Any]
    """The factor graph that was solved, as in ``graph.json``."""
    alignment: Alignment | None
    """Against the truth, where one was given."""

    def plot(self, ax: Any = None) -> Any:
        """Draws the map with its bands, the corners and the robot's way (m) into axes of matplotlib, and gives them."""
        ax = axes(ax)
        draw_map(ax, self.map)
        for k, visit in enumerate(self.visits):
            if visit.placed == "proved":
                way = visit.trajectory.poses
                ax.plot(way[:, 0], way[:, 1], color="#0072b2", linewidth=1.0, label="way" if k == 0 else None)
        for change in self.changes:
            ax.plot(change.points[:, 0], change.points[:, 1], color="#d55e00", linewidth=2.0)
        ax.plot(self.corners[:, 0], self.corners[:, 1], "o", color="#d55e00", fillstyle="none", label="corners")
        ax.legend(fontsize="small")
        plane(ax)
        return ax


@documented
def map_log(
    log: LogLike | Sequence[LogLike],
    robot: RobotLike = None,
    *,
    truth: MapLike | None = None,
    drift: float | None = None,
    body_radius: float | str | None = None,
    same_start: tuple[float | str, float | str] | None = None,
    format: str | None = None,
) -> MappedLog:
    """Makes a map from logs: the outline of what the whiskers touched, and the robot's way.

    Where the robot provably came back, its way and the outline are corrected. The robot bounds the odometry's errors. Further logs of the
    same place may begin anywhere: each is placed in the outline of those before, and tells where walls have moved.

    Parameters
    ----------
    log : SensorLog, path, or sequence of these
        The log, or several of one robot in one place, the oldest first.
    {robot}
    truth : Map or path, optional
        The true shape in any frame, to report errors against.
    drift : float, optional
        Bound on the drift of the odometry's heading with the way (rad/m).
    body_radius : float or str, optional
        Radius of a disc around the robot's origin that its body fills (m): no wall is where it was.
    same_start : (float or str, float or str), optional
        Every log begins within so much of where the first one does (m, rad), as at a dock.
    {format}

    Returns
    -------
    MappedLog
        The map with bands, corners, way, covariances and closures; SI.

    Raises
    ------
    DataError
        A fault in log or robot; a log in which nothing was felt that makes an outline.
    UsageError
        An option that is out of range.

    Examples
    --------
    >>> found = vibrissa.map_log("lap.csv", "robot.toml", body_radius="35 mm")
    >>> answer = vibrissa.localize("drive.csv", found.map, "robot.toml")
    >>> later = vibrissa.map_log(["lap.csv", "next_day.csv"], "robot.toml")
    >>> [(change.moved.value, change.length) for change in later.changes]
    """
    shape = None if truth is None else read_map(truth)
    radius = None if body_radius is None else number("body_radius", body_radius, "length")
    start = None
    if same_start is not None:
        start = (number("same_start", same_start[0], "length"), number("same_start", same_start[1], "angle"))
    several = [log] if isinstance(log, (str, PathLike, SensorLog)) else list(log)
    logs = [read_log(one, format) for one in several]
    made, found = _vibrissa.map_log(logs, robot_of(robot), shape, drift, radius, start)
    alignment = found["alignment"]
    visits = [Visit(**{**one, "trajectory": Trajectory(*one["trajectory"])}) for one in found["visits"]]
    changes = [
        WallChange(**{**one, "moved": None if one["moved"] is None else Share(*one["moved"])})
        for one in found["changes"]
    ]
    first = visits[0]
    fields = {
        **found,
        "trajectory": first.trajectory,
        "covariance_t": first.covariance_t,
        "covariances": first.covariances,
        "visits": visits,
        "graph": json.loads(found["graph"]),
        "changes": changes,
        "closures": [Closure(*one) for one in found["closures"]],
        "alignment": None if alignment is None else Alignment._of(alignment),
        **{name: Share(*found[name]) for name in ("scale", "turn", "drift")},
    }
    return MappedLog(map=made, **fields)
