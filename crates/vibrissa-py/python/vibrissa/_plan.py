"""The next motion that tells places apart, and a simulated robot that makes it."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from . import _vibrissa
from ._arrays import Floats
from ._docs import documented
from ._errors import one_of
from ._localize import Localization, MethodLike, method_of
from ._methods import Options
from ._robot import RobotLike, number, quantities, robot_of
from ._show import Shown, axes, draw_map, plane
from ._trajectory import Trajectory
from ._vibrissa import Map, Scenario, SensorLog
from ._world import LogLike, MapLike, read_log, read_map

if TYPE_CHECKING:
    from typing_extensions import Unpack

Criterion = Literal["expected", "worst"]
Verdict = Literal["parts", "alike", "known", "symmetric", "confined"]
Ended = Literal["localized", "symmetric", "inconsistent", "gave_up", "confined", "no_place"]
Strategy = Literal["planned", "wall"]


@dataclass(frozen=True)
class MotionLimits:
    """What a robot can do, and how its motions are judged; None takes the default.

    Numbers are SI; a text carries its unit: ``MotionLimits(footprint="15 mm")``.
    """

    longest: float | None = None
    """The longest motion (m)."""
    footprint: float | None = None
    """The radius around the robot's origin that must stay clear of all boundaries (m)."""
    sideways: bool | None = None
    """Whether the robot goes in any direction without turning; else ahead, back and along arcs."""
    turns: bool | None = None
    """Whether it turns on the spot."""
    largest_moment: float | None = None
    """The largest moment that a whisker may feel (N m)."""
    criterion: Criterion = "expected"
    """What motions are judged by: the information that is expected, or the extent that is left at worst."""
    budget: int | None = None
    """Readings of the forward model that may be taken: the plan is the best of these, whatever the machine."""

    if TYPE_CHECKING:

        def __init__(
            self,
            longest: float | str | None = ...,
            footprint: float | str | None = ...,
            sideways: bool | None = ...,
            turns: bool | None = ...,
            largest_moment: float | str | None = ...,
            criterion: Criterion = ...,
            budget: int | None = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        quantities(self, {"longest": "length", "footprint": "length", "largest_moment": "moment"})
        one_of("criterion", self.criterion, ("expected", "worst"))


class PlanOptions(Options, total=False):
    """The fields of ``MotionLimits`` and the options of all methods by name, for calls without a group."""

    longest: float | str | None
    footprint: float | str | None
    sideways: bool | None
    turns: bool | None
    largest_moment: float | str | None
    criterion: Criterion
    budget: int | None


def _told(limits: MotionLimits | None, options: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """What the robot can do, and the options of the method; limits by name come before those of the group."""
    names = [one.name for one in fields(MotionLimits)]
    group = limits or MotionLimits()
    mine = replace(group, **{name: options[name] for name in names if options.get(name) is not None})
    told = {name: getattr(mine, name) for name in names if name != "criterion"}
    rest = {name: value for name, value in options.items() if name not in names}
    return {**told, "worst": mine.criterion == "worst"}, rest


@dataclass(frozen=True, eq=False, repr=False)
class Motion(Shown):
    """A motion, and what is expected of it. A robot that obeys ends it where a whisker feels ``stop_at``."""

    name: str
    """What kind of motion."""
    waypoints: Floats
    """x (m), y (m), theta (rad) seen from the robot where it begins, shape (n, 3); in between it goes straight and turns evenly."""
    stop_at: list[float]
    """For each whisker the size of the reading at which the robot has to end the motion (N m)."""
    places: tuple[int, int]
    """Places that are left, at best and at worst."""
    extent: tuple[float, float]
    """Mean distance of the states that are left, expected, and the largest at worst (m)."""
    information: float
    """The entropy of the states that is expected to be taken away (nats)."""
    way: float
    """Length of the way (m)."""
    turn: float
    """How far the robot turns in all (rad)."""


@dataclass(frozen=True, eq=False, repr=False)
class Plan(Shown):
    """The next motion, or why there is none."""

    verdict: Verdict
    """Whether the motion parts the places, or why none does."""
    words: str
    """The answer in a sentence."""
    motion: Motion | None
    """The motion, where one is worth it."""
    places: int
    """Places before it."""
    extent: tuple[float, float]
    """Mean distance of the states before it, and the largest (m)."""
    looked_at: tuple[int, int]
    """Motions that were looked at, and those that are free of collision and gentle for all states."""
    readings: int
    """Readings of the forward model that were taken."""
    answer: Localization
    """Where the robot may be by its log."""

    def plot(self, ax: Any = None) -> Any:
        """Draws the places and the motion from each of them, map frame (m), into axes of matplotlib, and gives them."""
        ax = self.answer.plot(ax)
        way = np.zeros((0, 2)) if self.motion is None else self.motion.waypoints[:, :2]
        for place in self.answer.hypotheses[: self.places]:
            sin, cos = np.sin(place.theta), np.cos(place.theta)
            x, y = place.x + way @ (cos, -sin), place.y + way @ (sin, cos)
            ax.plot(x, y, "o-", markersize=3.0, color="#0072b2")
        ax.set_title(self.words, fontsize="small", wrap=True)
        return ax

    @classmethod
    def _of(cls, found: dict[str, Any], map: Map) -> Plan:
        motion = found["motion"]
        made = {**found, "motion": None if motion is None else Motion(**motion)}
        return cls(**{**made, "answer": Localization._of(found["answer"], None, map)})


class MadeMotion(NamedTuple):
    """A motion that a robot made."""

    words: str
    """What it was, and what it was expected to bring."""
    row: int
    """The row of the log with which it began."""
    places: Floats
    """The places before it, map frame, shape (places, 3)."""
    stopped: bool
    """Whether a whisker ended it."""


@dataclass(frozen=True, eq=False, repr=False)
class Exploration(Shown):
    """What became of a simulated robot that found out where it is by its own motion."""

    ended: Ended
    """Why it ended."""
    way: float
    """Way after the first motion (m)."""
    turn: float
    """Turn after the first motion (rad)."""
    motions: list[MadeMotion]
    """The motions after the first."""
    log: SensorLog
    """What it recorded."""
    truth: Trajectory
    """Where it was, map frame."""
    answer: Localization
    """What it knows at the end."""
    collided: bool
    """Whether footprint or a whisker's base came to a boundary."""
    hardest: float
    """The largest moment at a whisker's base after the first motion, over what is gentle."""
    since: int = 0
    """The row from which on the answer is of: no place explained what came before, and the robot began anew."""
    _map: Map | None = None

    def plot(self, ax: Any = None) -> Any:
        """Draws map, way and where it planned, map frame (m), into axes of matplotlib, and gives them."""
        ax = axes(ax)
        if self._map is not None:
            draw_map(ax, self._map)
        poses = self.truth.poses
        ax.plot(poses[:, 0], poses[:, 1], color="#0072b2", label="way")
        begins = [poses[min(one.row, len(poses)) - 1] for one in self.motions]
        ax.plot([pose[0] for pose in begins], [pose[1] for pose in begins], "o", color="#d55e00", label="planned here")
        ax.set_title(self.ended)
        ax.legend(fontsize="small")
        plane(ax)
        return ax


@documented
def plan(
    log: LogLike,
    map: MapLike,
    robot: RobotLike = None,
    method: MethodLike = "probabilistic",
    *,
    limits: MotionLimits | None = None,
    format: str | None = None,
    within: Sequence[float] | None = None,
    **options: Unpack[PlanOptions],
) -> Plan:
    """Finds the next motion that tells the places apart which a log leaves open.

    Parameters
    ----------
    {log}
    {map}
    {robot}
    {method}
    {limits}
    {format}
    {within}
    **options
        The fields of ``MotionLimits``, and the options of the method, by name.

    Returns
    -------
    Plan
        The motion, what it is expected to bring, and the places.

    Raises
    ------
    DataError
        A fault in log, map or robot; a log that tells no place yet.
    UsageError
        An option that is out of range.

    Examples
    --------
    >>> plan = vibrissa.plan("short.csv", "arena.svg", footprint="15 mm")
    >>> print(plan.words)
    """
    told, rest = _told(limits, options)
    name, given = method_of(method, rest)
    if within is not None:
        given["within"] = within
    shape = read_map(map)
    return Plan._of(_vibrissa.plan(read_log(log, format), shape, robot_of(robot), name, given, told), shape)


@documented
def explore(
    scenario: Scenario | str | os.PathLike[str],
    method: MethodLike = "probabilistic",
    *,
    begin: float | str = 0.08,
    most_way: float | str = 2.0,
    seed: int = 1,
    strategy: Strategy = "planned",
    tested: bool = True,
    limits: MotionLimits | None = None,
    **options: Unpack[PlanOptions],
) -> Exploration:
    """Lets a simulated robot find out where it is by its own motion.

    Map, robot and the first motion are those of the scenario. Readings have the noise that the robot declares.

    Parameters
    ----------
    {scenario}
    {method}
    begin : float or str
        How much of the scenario's path is the first motion (m).
    most_way : float or str
        The way after which the robot gives up (m).
    seed : int
        Of the noise.
    strategy : str
        How motions are chosen: as ``plan`` tells, or along the wall by touch.
    tested : bool
        Whether the place is tested before the robot stops: by the guaranteed set, or by one more motion where that says nothing.
    {limits}
    **options
        The fields of ``MotionLimits``, and the options of the method, by name.

    Returns
    -------
    Exploration
        How it ended, the motions, the log and the truth; SI, map frame.

    Raises
    ------
    DataError
        A fault in the scenario or its files.
    UsageError
        An option that is out of range; a first motion that begins in contact.
    """
    one_of("strategy", strategy, ("planned", "wall"))
    read = scenario if isinstance(scenario, Scenario) else Scenario.read(scenario)
    told, rest = _told(limits, options)
    name, given = method_of(method, rest)
    first, whole = number("begin", begin, "length"), number("most_way", most_way, "length")
    log, found = _vibrissa.explore(read, first, whole, seed, strategy, tested, name, given, told)
    made = {
        **found,
        "motions": [MadeMotion(**one) for one in found["motions"]],
        "truth": Trajectory(*found["truth"]),
        "answer": Localization._of(found["answer"], None, read.map),
    }
    return Exploration(log=log, **made, _map=read.map)
