"""Where whiskers were touched, and the outline of what they swept along."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _vibrissa
from ._arrays import Floats, Ints
from ._docs import documented
from ._robot import RobotLike, robot_of
from ._show import Shown, axes, pandas, plane
from ._types import Event
from ._vibrissa import SensorLog
from ._world import LogLike, MapLike, read_log, read_map


@dataclass(frozen=True, eq=False, repr=False)
class Contacts(Shown):
    """The contacts of a log, one step each; columns of shape (steps), NaN where a number is not known."""

    t: Floats
    """When (s)."""
    whisker: list[str]
    """The whisker's name."""
    kind: list[str]
    """"side": a point that stands still; "tip": it slides; "none": no point is found."""
    contact: Floats
    """The contact, whisker frame (m), shape (steps, 2)."""
    position: Floats
    """The contact, odometry frame (m), shape (steps, 2)."""
    odom_from_whisker: Floats
    """The whisker's base, odometry frame: x (m), y (m), theta (rad), shape (steps, 3)."""
    s_a: Floats
    """Arc length of the contact (m)."""
    distance: Floats
    """Distance from the base (m)."""
    std: Floats
    """Standard deviation of the contact (m): of its distance (side), across the wall (tip)."""
    distance_bounds: Floats
    """Bounds of the distance if the declared error bounds hold (m), shape (steps, 2)."""
    moment: Floats
    """The moment (N m), mean of the step's readings."""
    piece: Ints
    """Number of the uninterrupted piece that the step belongs to."""
    kaneko: Floats
    """Distance by an earlier closed form, from rotation (m)."""
    solomon: Floats
    """Distance by an earlier closed form, from translation (m)."""
    small_angle: Floats
    """Distance by the small-angle form of both (m)."""
    events: list[Event]
    """contact, lift_off, tip_contact, slip_whisker, slip_obstacle, jump, no_point."""

    def kind_is(self, kind: str) -> npt.NDArray[np.bool_]:
        """Which steps are of a kind: a mask of shape (steps)."""
        return np.array([one == kind for one in self.kind], dtype=bool)

    def to_pandas(self) -> Any:
        """A ``pandas.DataFrame``, one row for each step; points are columns of x and y."""
        columns: dict[str, Any] = {"t": self.t, "whisker": self.whisker, "kind": self.kind}
        for name in ("contact", "position"):
            columns.update({f"{name}_{axis}": getattr(self, name)[:, k] for k, axis in enumerate("xy")})
        names = ("s_a", "distance", "std", "moment", "piece", "kaneko", "solomon", "small_angle")
        columns.update({name: getattr(self, name) for name in names})
        return pandas().DataFrame(columns)

    def plot(self, ax: Any = None) -> Any:
        """Draws the contacts, odometry frame (m), a colour for each whisker, into axes of matplotlib, and gives them."""
        return _draw_by_whisker(axes(ax), self.whisker, self.position)


def _draw_by_whisker(ax: Any, whiskers: list[str], points: Floats) -> Any:
    """Points of shape (n, 2) or (n, 3) seen from above, a colour for each whisker."""
    for name in dict.fromkeys(whiskers):
        mine = np.array([one == name for one in whiskers], dtype=bool)
        ax.plot(points[mine, 0], points[mine, 1], ".", label=name)
    ax.legend(fontsize="small")
    plane(ax)
    return ax


@documented
def contact(
    log: LogLike, robot: RobotLike = None, *, format: str | None = None, spacing: float | None = None
) -> Contacts:
    """Finds where a whisker was touched, step by step.

    Parameters
    ----------
    {log}
    {robot}
    {format}
    {spacing}

    Returns
    -------
    Contacts
        One step for each place of the base, with standard deviations and bounds; SI.

    Raises
    ------
    DataError
        A fault in log or robot.

    Examples
    --------
    >>> found = vibrissa.contact("sweep.csv")
    >>> found.position[found.kind_is("tip")]
    """
    found = _vibrissa.contact(read_log(log, format), robot_of(robot), spacing)
    return Contacts(**{**found, "events": [Event(*one) for one in found["events"]]})


@dataclass(frozen=True, eq=False, repr=False)
class SpaceContacts(Shown):
    """The contacts of a log in space, one step each; columns of shape (steps), NaN where a number is not known.

    Whisker frame: x forward along the undeflected whisker, y left, z up; the odometry frame has z above the whisker's base.
    """

    t: Floats
    """When (s)."""
    whisker: list[str]
    """The whisker's name."""
    kind: list[str]
    """"side": a point that stands still; "tip": none does, the tip is taken; "none": no tip explains the moments either."""
    moments: Floats
    """In the whisker's plane x-y and across it (N m), mean of the step's readings, shape (steps, 2)."""
    plane: Floats
    """Size of both (N m), and angle of the bending plane about the whisker's axis (rad), shape (steps, 2)."""
    plane_errors: Floats
    """Half widths of their bands from the declared errors, shape (steps, 2)."""
    x: Floats
    """The contact along the undeflected whisker (m)."""
    x_bounds: Floats
    """Its band, shape (steps, 2)."""
    r: Floats
    """Distance of the contact from the axis (m)."""
    r_bounds: Floats
    """Its band, shape (steps, 2)."""
    angle: Floats
    """Angle of the contact about the axis (rad), from +y towards +z."""
    angle_bounds: Floats
    """Its band, shape (steps, 2); an end may lie beyond pi."""
    s_a: Floats
    """Arc length of the contact (m)."""
    contact: Floats
    """The contact, whisker frame (m), shape (steps, 3)."""
    position: Floats
    """The contact, odometry frame (m), shape (steps, 3)."""
    odom_from_whisker: Floats
    """The whisker's base, odometry frame: x (m), y (m), theta (rad), shape (steps, 3)."""
    events: list[Event]
    """contact, lift_off, side_contact, out_of_plane, slides_around, no_point."""

    def to_pandas(self) -> Any:
        """A ``pandas.DataFrame``, one row for each step; bands are columns of min and max."""
        columns: dict[str, Any] = {"t": self.t, "whisker": self.whisker, "kind": self.kind}
        for name in ("x", "r", "angle"):
            columns[name] = getattr(self, name)
            columns.update({f"{name}_{end}": getattr(self, f"{name}_bounds")[:, k] for k, end in enumerate(("min", "max"))})
        columns.update({f"position_{axis}": self.position[:, k] for k, axis in enumerate("xyz")})
        columns.update({"moment": self.moments[:, 0], "across": self.moments[:, 1]})
        return pandas().DataFrame(columns)

    def plot(self, ax: Any = None) -> Any:
        """Draws the contacts from above, odometry frame (m), a colour for each whisker, into axes of matplotlib, and gives them."""
        return _draw_by_whisker(axes(ax), self.whisker, self.position)


@documented
def contact_in_space(
    log: LogLike, robot: RobotLike = None, *, format: str | None = None, spacing: float | None = None
) -> SpaceContacts:
    """Finds where straight round whiskers were touched in space, from the moments about both transverse axes.

    Parameters
    ----------
    log : SensorLog or path
        Odometry with columns moment and across (N m), or flux with a calibration of both axes.
    {robot}
    {format}
    {spacing}

    Returns
    -------
    SpaceContacts
        One step for each place of the base, with bands from the declared errors of both moments; SI.

    Raises
    ------
    DataError
        A log without both moments, a curved whisker.
    """
    found = _vibrissa.contact_in_space(read_log(log, format), robot_of(robot), spacing)
    return SpaceContacts(**{**found, "events": [Event(*one) for one in found["events"]]})


@dataclass(frozen=True, eq=False, repr=False)
class FilteredContacts(Shown):
    """Contact sets of several readings, intersected; columns of shape (sets)."""

    t: Floats
    """When (s)."""
    whisker: list[str]
    """The whisker's name."""
    readings: Ints
    """How many readings were intersected; 1 where the contact has moved."""
    components: Ints
    """How many separate pieces the set has."""
    area: Floats
    """Area of the set (m²)."""
    contact: Floats
    """Middle of the set's extent, whisker frame (m), shape (sets, 2)."""
    position: Floats
    """The same, odometry frame (m), shape (sets, 2)."""
    extent: Floats
    """x_min, x_max, y_min, y_max of the set, whisker frame (m), shape (sets, 4)."""

    def to_pandas(self) -> Any:
        """A ``pandas.DataFrame``, one row for each set."""
        columns: dict[str, Any] = {"t": self.t, "whisker": self.whisker, "readings": self.readings, "area": self.area}
        columns.update({f"position_{axis}": self.position[:, k] for k, axis in enumerate("xy")})
        sides = ("x_min", "x_max", "y_min", "y_max")
        columns.update({name: self.extent[:, k] for k, name in enumerate(sides)})
        return pandas().DataFrame(columns)

    def plot(self, ax: Any = None) -> Any:
        """Draws the middles of the sets, odometry frame (m), a colour for each whisker, into axes of matplotlib, and gives them."""
        return _draw_by_whisker(axes(ax), self.whisker, self.position)


@documented
def temporal_filter(
    log: LogLike,
    robot: RobotLike = None,
    *,
    readings: int | None = None,
    spacing: float | None = None,
    format: str | None = None,
) -> FilteredContacts:
    """Intersects the contact sets of several readings while the base moves and the contact stands still.

    Parameters
    ----------
    log : SensorLog or path
        With columns force (N), slope (rad), strip_lo and strip_hi (m) or moment (N m), alone or together.
    {robot}
    readings : int, optional
        How many readings are intersected.
    spacing : float, optional
        How far the base moves between two of them (m).
    {format}

    Returns
    -------
    FilteredContacts
        The sets in order of time.

    Raises
    ------
    DataError
        A log without such columns.
    """
    return FilteredContacts(**_vibrissa.temporal_filter(read_log(log, format), robot_of(robot), readings, spacing))


@dataclass(frozen=True, eq=False, repr=False)
class Outline(Shown):
    """A line along a wall, odometry frame; columns of shape (points)."""

    points: Floats
    """Its points, evenly spaced (m), shape (points, 2)."""
    normals: Floats
    """Unit normals, away from the wall, shape (points, 2)."""
    std: Floats
    """Standard deviation across the wall (m)."""
    runs: Ints
    """How many runs each point is from."""
    closed: bool
    """Whether the last point comes before the first."""

    @property
    def length(self) -> float:
        """Length of the line (m)."""
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())

    def band(self, width: float = 2.0) -> tuple[Floats, Floats]:
        """The edges of the band of ``width`` standard deviations on either side (m): outer, inner; (points, 2) each."""
        offset = self.normals * (width * self.std)[:, None]
        return self.points + offset, self.points - offset


class Misfit(NamedTuple):
    """Distances of an outline's points from the true shape (m)."""

    mean: float
    rms: float
    p95: float
    max: float


@dataclass(frozen=True, eq=False, repr=False)
class Alignment(Shown):
    """An outline against a known shape."""

    absolute: Misfit
    """As it lies."""
    shape: Misfit
    """After the best rigid motion."""
    map_from_outline: tuple[float, float, float]
    """That motion: x (m), y (m), theta (rad)."""
    scaled: tuple[Misfit, float] | None
    """With the best scale, too, and that scale, when asked for."""

    @classmethod
    def _of(cls, fields: dict[str, Any]) -> Alignment:
        scaled = fields["scaled"]
        free = None if scaled is None else (Misfit(*scaled[0]), scaled[1])
        return cls(Misfit(*fields["absolute"]), Misfit(*fields["shape"]), fields["map_from_outline"], free)


@dataclass(frozen=True, eq=False, repr=False)
class Profile(Shown):
    """What sweeps found of the shapes that they touched."""

    outlines: list[Outline]
    """Lines that tips slid along, the longest first."""
    pegs: Floats
    """Points that sides leant on and their standard deviations: x, y, std (m), shape (pegs, 3)."""
    steps: int
    """Steps in contact."""
    left_out: int
    """How many of them are on no outline."""
    events: list[list[Event]]
    """What happened in each log."""
    alignment: Alignment | None
    """Against the truth, where one was given."""

    def plot(self, ax: Any = None) -> Any:
        """Draws the outlines with bands of two standard deviations, odometry frame (m), and gives the axes."""
        ax = axes(ax)
        for outline in self.outlines:
            outer, inner = outline.band()
            ring = np.concatenate([outer, inner[::-1]])
            ax.fill(ring[:, 0], ring[:, 1], alpha=0.3)
            ax.plot(outline.points[:, 0], outline.points[:, 1])
        ax.plot(self.pegs[:, 0], self.pegs[:, 1], "o")
        plane(ax)
        return ax


@documented
def profile(
    logs: LogLike | Sequence[LogLike],
    robot: RobotLike = None,
    *,
    truth: MapLike | None = None,
    free_scale: bool = False,
    format: str | None = None,
) -> Profile:
    """Finds the outline of what one or more sweeps touched, all in one odometry frame.

    Parameters
    ----------
    logs : SensorLog, path, or sequence of these
        The sweeps.
    {robot}
    truth : Map or path, optional
        The true shape in that frame, to report errors against.
    free_scale : bool
        Whether a scale is fitted, too.
    {format}

    Returns
    -------
    Profile
        Outlines with standard deviations, odometry frame (m).

    Raises
    ------
    DataError
        A fault in a log, the robot or the map.
    """
    several = [logs] if isinstance(logs, (str, PathLike, SensorLog)) else list(logs)
    read = [read_log(one, format) for one in several]
    shape = None if truth is None else read_map(truth)
    found = _vibrissa.profile(read, robot_of(robot), shape, free_scale)
    alignment = found["alignment"]
    made = {
        **found,
        "outlines": [Outline(**one) for one in found["outlines"]],
        "events": [[Event(*one) for one in events] for events in found["events"]],
        "alignment": None if alignment is None else Alignment._of(alignment),
    }
    return Profile(**made)
