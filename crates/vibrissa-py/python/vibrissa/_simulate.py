"""Sweeps: what a robot would record."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy.typing as npt

from . import _vibrissa
from ._arrays import Floats, Ints, column, rows
from ._docs import documented
from ._robot import RobotLike, robot_of
from ._show import Shown, axes, plane
from ._trajectory import Trajectory
from ._types import Event, Progress
from ._vibrissa import Scenario, SensorLog
from ._world import MapLike, read_map


@dataclass(frozen=True, eq=False, repr=False)
class Touches(Shown):
    """Every touch of a sweep, in order of rows, whiskers and from base to tip; columns of shape (touches)."""

    t: Floats
    """When (s)."""
    row: Ints
    """Index of the row."""
    whisker: Ints
    """Index of the whisker."""
    position: Floats
    """The contact, map frame (m), shape (touches, 2)."""
    force: Floats
    """The force on the whisker, map frame (N), shape (touches, 2)."""
    s_a: Floats
    """Arc length from the base to the contact (m)."""
    energy: Floats
    """Elastic energy of the whole whisker (J)."""
    part: list[str]
    """Which part touches: "tip" or "side"."""
    grip: list[str]
    """How it holds along the boundary: "frictionless", "sticks" or "slips"."""


class SweptShape(NamedTuple):
    """The shape of a whisker at one row."""

    row: int
    """Index of the row."""
    whisker: int
    """Index of the whisker."""
    points: Floats
    """Points from base to tip, map frame (m), shape (n, 2)."""


@dataclass(frozen=True, eq=False, repr=False)
class Simulation(Shown):
    """A simulated sweep: what the robot records, and the truth behind it."""

    log: SensorLog
    """What is recorded."""
    truth: Trajectory
    """The robot in the map frame."""
    exact_moments: Floats
    """The moments without noise (N m), shape (rows, whiskers)."""
    contacts: Touches
    """Every touch."""
    events: list[Event]
    """What happened to the whiskers."""
    shapes: list[SweptShape]
    """Some of the whiskers' shapes, for drawing; of ``sweep`` only."""
    serial: str | None = None
    """The serial line's text, where the scenario asks for one."""

    def plot(self, ax: Any = None) -> Any:
        """Draws way, whiskers and touches, map frame (m), into axes of matplotlib, and gives them."""
        ax = self.truth.plot(axes(ax))
        for shape in self.shapes:
            ax.plot(shape.points[:, 0], shape.points[:, 1], color="#a64d85", linewidth=0.6)
        ax.plot(self.contacts.position[:, 0], self.contacts.position[:, 1], ".", color="#d55e00")
        plane(ax)
        return ax

    @classmethod
    def _of(cls, log: SensorLog, fields: dict[str, Any], serial: str | None = None) -> Simulation:
        made = {
            **fields,
            "truth": Trajectory(*fields["truth"]),
            "contacts": Touches(**fields["contacts"]),
            "events": [Event(*one) for one in fields["events"]],
            "shapes": [SweptShape(*one) for one in fields["shapes"]],
        }
        return cls(log=log, **made, serial=serial)


@documented
def simulate(
    scenario: Scenario | str | os.PathLike[str], seed: int | None = None, *, progress: Progress | None = None
) -> Simulation:
    """Simulates a scenario: a robot with whiskers along a path through a map, with the errors of its senses.

    Parameters
    ----------
    {scenario}
    seed : int, optional
        Of all noise, instead of the scenario's. The same seed gives the same numbers everywhere.
    progress : callable, optional
        See ``Progress``; of the poses, as many for each whisker as the path has.

    Returns
    -------
    Simulation
        The log, and the truth behind it; SI.

    Raises
    ------
    DataError
        A fault in the scenario or its files.
    """
    read = scenario if isinstance(scenario, Scenario) else Scenario.read(scenario)
    return Simulation._of(*read._simulate(seed, progress))


def waypoints(
    points: npt.ArrayLike,
    *,
    speed: float | None = None,
    turn_rate: float | None = None,
    rate: float | None = None,
) -> Trajectory:
    """Makes the path through waypoints: straight lines, turning evenly.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        The waypoints: x (m), y (m), theta (rad), map frame.
    speed : float, optional
        Speed (m/s); None for that of scenarios.
    turn_rate : float, optional
        How fast it turns (rad/s); None for that of scenarios.
    rate : float, optional
        Rows a second (Hz); None for that of scenarios.

    Returns
    -------
    Trajectory
        The poses over time, map frame.

    Raises
    ------
    UsageError
        A number out of range.
    """
    return Trajectory(*_vibrissa.path(rows(points, 3), speed, turn_rate, rate))


@documented
def sweep(
    map: MapLike,
    path: Trajectory,
    robot: RobotLike = None,
    *,
    seed: int | None = None,
    moment_noise: tuple[float, float] | None = None,
    translation_relative: float = 0.0,
    rotation_relative: float = 0.0,
    discrete_rod: bool = False,
    progress: Progress | None = None,
) -> Simulation:
    """Sweeps a robot along a path and records what it feels.

    Parameters
    ----------
    {map}
    path : Trajectory
        The robot's way, map frame.
    {robot}
    seed : int, optional
        Of the noise; None for exact readings.
    moment_noise : tuple of two floats, optional
        Bounds of a moment's error, relative to the reading and at zero (N m); None for what each whisker declares.
    translation_relative, rotation_relative : float
        Bounds on the errors of the odometry's increments, relative to them.
    discrete_rod : bool
        Whether the independent discrete rod solves, slowly.
    {progress}

    Returns
    -------
    Simulation
        The log, and the truth behind it; SI.

    Raises
    ------
    DataError
        A fault in map, robot or path.
    """
    odometry = (translation_relative, rotation_relative)
    stamps, poses = column(path.t), rows(path.poses, 3)
    log, fields = _vibrissa.sweep(
        read_map(map), robot_of(robot), stamps, poses, seed, moment_noise, odometry, discrete_rod, progress
    )
    return Simulation._of(log, fields)
