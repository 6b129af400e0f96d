"""Maps from logs alone: the outline of what whiskers touched, and the robot's way."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from . import _vibrissa
from ._arrays import Floats
from ._contact import Alignment
from ._docs import documented
from ._robot import RobotLike, number, robot_of
from ._show import Shown, axes, draw_map, plane
from ._trajectory import Trajectory
from ._vibrissa import Map
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


class Share(NamedTuple):
    """A quantity with its standard deviation."""

    value: float
    """The value."""
    std: float
    """Its standard deviation."""


@dataclass(frozen=True, eq=False, repr=False)
class MappedLog(Shown):
    """A map made by touch, in the odometry frame of the log's first row."""

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
    """The robot at every row."""
    covariance_t: Floats
    """When the covariances hold (s), shape (keys)."""
    covariances: Floats
    """Of the robot's pose relative to the first row, by x, y (m) and heading (rad), shape (keys, 3, 3)."""
    scale: Share
    """Ways are longer than the odometry tells by this share."""
    turn: Share
    """Turns are larger than it tells by this share."""
    drift: Share
    """The heading turns by so much more along the way (rad/m)."""
    closures: list[Closure]
    """Where the robot came back, or may have."""
    alignment: Alignment | None
    """Against the truth, where one was given."""

    def plot(self, ax: Any = None) -> Any:
        """Draws the map with its bands, the corners and the robot's way (m) into axes of matplotlib, and gives them."""
        ax = axes(ax)
        draw_map(ax, self.map)
        ax.plot(self.trajectory.poses[:, 0], self.trajectory.poses[:, 1], color="#0072b2", linewidth=1.0, label="way")
        ax.plot(self.corners[:, 0], self.corners[:, 1], "o", color="#d55e00", fillstyle="none", label="corners")
        ax.legend(fontsize="small")
        plane(ax)
        return ax


@documented
def map_log(
    log: LogLike,
    robot: RobotLike = None,
    *,
    truth: MapLike | None = None,
    drift: float | None = None,
    body_radius: float | str | None = None,
    format: str | None = None,
) -> MappedLog:
    """Makes a map from a log: the outline of what the whiskers touched, and the robot's way.

    Where the robot provably came back, its way and the outline are corrected. The robot bounds the odometry's errors.

    Parameters
    ----------
    {log}
    {robot}
    truth : Map or path, optional
        The true shape in any frame, to report errors against.
    drift : float, optional
        Bound on the drift of the odometry's heading with the way (rad/m).
    body_radius : float or str, optional
        Radius of a disc around the robot's origin that its body fills (m): no wall is where it was.
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
    """
    shape = None if truth is None else read_map(truth)
    radius = None if body_radius is None else number("body_radius", body_radius, "length")
    made, found = _vibrissa.map_log(read_log(log, format), robot_of(robot), shape, drift, radius)
    alignment = found["alignment"]
    fields = {
        **found,
        "trajectory": Trajectory(*found["trajectory"]),
        "closures": [Closure(*one) for one in found["closures"]],
        "alignment": None if alignment is None else Alignment._of(alignment),
        **{name: Share(*found[name]) for name in ("scale", "turn", "drift")},
    }
    return MappedLog(map=made, **fields)
