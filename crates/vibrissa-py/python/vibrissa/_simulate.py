"""Sweeps: what a robot would record."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy.typing as npt

from . import _vibrissa
from ._arrays import Floats, Ints, column, rows
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


def simulate(
    scenario: Scenario | str | os.PathLike[str], seed: int | None = None, *, progress: Progress | None = None
) -> Simulation:
    """Simulates a scenario (.toml): a robot with whiskers along a path through a map, with the errors of its senses.

    seed: of all noise, instead of the scenario's. The same seed gives the same numbers everywhere.
    progress: see ``Progress``; of the poses, as many for each whisker as the path has.
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
    """The path through waypoints x (m), y (m), theta (rad), shape (n, 3), map frame: straight, turning evenly.

    speed (m/s), turn_rate (rad/s) and rate (rows a second) default to those of scenarios.
    """
    return Trajectory(*_vibrissa.path(rows(points, 3), speed, turn_rate, rate))


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
    """Sweeps a robot along a path (map frame) and records what it feels.

    seed: of the noise; None for exact readings. moment_noise: bounds relative to the reading and at zero (N m); None for
    what each whisker declares. The odometry's increments err by up to the relative bounds. discrete_rod: solve by the
    independent discrete rod, slowly. progress: as in ``simulate``.
    """
    odometry = (translation_relative, rotation_relative)
    stamps, poses = column(path.t), rows(path.poses, 3)
    log, fields = _vibrissa.sweep(
        read_map(map), robot_of(robot), stamps, poses, seed, moment_noise, odometry, discrete_rod, progress
    )
    return Simulation._of(log, fields)
