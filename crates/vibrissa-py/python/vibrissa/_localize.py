"""Where the robot is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from . import _vibrissa
from ._arrays import Floats, Ints
from ._robot import RobotLike, robot_of
from ._simulate import Simulation
from ._trajectory import Trajectory, TrajectoryError, TrajectoryLike, read_trajectory
from ._types import Event, Progress
from ._vibrissa import Map
from ._world import LogLike, MapLike, arena, read_log, read_map

Method = Literal["deterministic", "possibilistic", "probabilistic"]
Status = Literal["localized", "ambiguous", "inconsistent", "no_contact"]


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """One place that explains the log, kept apart from every other: the state at the last row, map frame."""

    x: float
    """(m)"""
    y: float
    """(m)"""
    theta: float
    """(rad)"""
    weight: float
    """Its share among all hypotheses."""
    x_min: float
    """Extent of the component that it stands for (m)."""
    x_max: float
    """(m)"""
    y_min: float
    """(m)"""
    y_max: float
    """(m)"""
    theta_min: float
    """(rad)"""
    theta_max: float
    """(rad)"""
    covariance: Floats | None
    """Covariance of (x, y, theta) (m², m rad, rad²), shape (3, 3), where the method gives one."""
    ridge: Floats
    """The curve along which the readings leave the place open: states (x, y, theta) at the last row (m, m, rad; map frame) in
    order, shape (n, 3); shape (0, 3) where the method gives none or the place is short."""


@dataclass(frozen=True)
class OdometryEstimate:
    """What the readings say about the odometry: by what each of its increments has to be corrected."""

    translation_scale: float
    """The true length of an increment over the one that odometry gives; 1 where it is right."""
    translation_scale_std: float
    """Its standard deviation."""
    aside: float
    """How far increments go to the left of where odometry says (rad)."""
    aside_std: float
    """Its standard deviation (rad)."""
    rotation_scale: float
    """The true turn of an increment over the one that odometry gives; 1 where it is right."""
    rotation_scale_std: float
    """Its standard deviation."""


@dataclass(frozen=True)
class Nuisance:
    """What the readings say of a quantity that the robot bounds because it is not known exactly: true value less declared one."""

    quantity: Literal[
        "zero",
        "zero_drift",
        "mount_x",
        "mount_y",
        "mount_heading",
        "length",
        "stiffness",
        "gain",
        "delay",
        "map_scale",
    ]
    """Which quantity."""
    whisker: str | None
    """The name of its whisker, where it is of one."""
    unit: str
    """The SI unit of the numbers; empty for shares."""
    estimate: float
    """The estimate."""
    std: float
    """Its standard deviation."""
    bound: float
    """The declared bound."""


class Remedy(NamedTuple):
    """One change of log, robot or map that was tried because the readings do not fit."""

    change: str
    """What was changed, for people."""
    statistic: float
    """The consistency statistic with it; not a number where the method has none."""
    status: Status
    """The verdict with it."""


@dataclass(frozen=True)
class Consistency:
    """How well the readings fit what was declared."""

    statistic: float
    """Mean normalised innovation squared: 1 where errors are as declared, above ``most`` where the readings contradict."""
    most: float
    """The largest that errors within the declared bounds can make it."""
    correlation_time: float
    """How long the readings' errors stay alike (s), 0 where they are independent."""
    worst: tuple[float, float, float] | None
    """The stretch of the log that fits worst: from, to (s) and the statistic there."""
    remedies: list[Remedy]
    """What was tried where the readings contradict, the best first."""


@dataclass(frozen=True, eq=False)
class Steps:
    """The state set's size after each update; columns of shape (updates)."""

    t: Floats
    """When (s)."""
    components: Ints
    """How many separate components the set has."""
    area_m2: Floats
    """Area of the set's projection onto the plane (m²)."""
    volume: Floats
    """Volume of the set (m² rad)."""


class WhiskerShape(NamedTuple):
    """One reconstructed whisker shape."""

    t: float
    """When (s)."""
    points: Floats
    """Points from base to tip, robot frame (m), shape (n, 2)."""


@dataclass(frozen=True, eq=False)
class Localization:
    """What a log and a map say about the robot."""

    method: Method
    """The estimator that made this answer."""
    status: Status
    """The verdict: one place, several separate places, no state explains the log, or nothing was touched."""
    estimate: tuple[float, float, float] | None
    """The best hypothesis at the last row: x (m), y (m), theta (rad), map frame."""
    hypotheses: list[Hypothesis]
    """Every surviving place, heaviest first, never averaged over separate places."""
    trajectory: Trajectory
    """The best hypothesis over time, one pose for each log row from the first estimate on."""
    odometry: OdometryEstimate | None
    """What is said about the odometry, by the probabilistic method where the robot declares that it may be wrong."""
    nuisances: list[Nuisance]
    """What is said of quantities that the robot bounds, by methods that estimate them."""
    consistency: Consistency | None
    """How well the readings fit, by methods that tell, and what to try where nothing explains the log."""
    unsure: Floats
    """Stretches in which the trajectory is not sure: from, to (s); shape (stretches, 2)."""
    states: Floats
    """The final state set as boxes x_min, x_max, y_min, y_max (m), theta_min, theta_max (rad); shape (boxes, 6)."""
    first_states: Floats
    """The candidates after the first observation; shape (candidates, 3)."""
    steps: Steps
    """The set's size after each update."""
    events: list[Event]
    """What happened along the way."""
    shapes: list[WhiskerShape]
    """Whisker shapes along the sweep, for drawing."""
    error: TrajectoryError | None = None
    """How far the trajectory is from the truth, where one was given."""

    @classmethod
    def _of(cls, fields: dict[str, Any], truth: Trajectory | None) -> Localization:
        trajectory = Trajectory(*fields["trajectory"])
        fit = fields["consistency"]
        # Where nothing explains the log there is no answer that could be off.
        known = None if fields["status"] == "inconsistent" else truth
        made = {
            **fields,
            "hypotheses": [Hypothesis(**one) for one in fields["hypotheses"]],
            "trajectory": trajectory,
            "odometry": None if fields["odometry"] is None else OdometryEstimate(**fields["odometry"]),
            "nuisances": [Nuisance(**one) for one in fields["nuisances"]],
            "consistency": None
            if fit is None
            else Consistency(**{**fit, "remedies": [Remedy(*one) for one in fit["remedies"]]}),
            "steps": Steps(**fields["steps"]),
            "events": [Event(*one) for one in fields["events"]],
            "shapes": [WhiskerShape(*one) for one in fields["shapes"]],
        }
        return cls(**made, error=None if known is None else trajectory.error(known))


def localize(
    log: LogLike,
    map: MapLike,
    robot: RobotLike = None,
    method: Method = "probabilistic",
    *,
    format: str | None = None,
    truth: TrajectoryLike | None = None,
    progress: Progress | None = None,
    tip_load: Literal["boundary-normal", "whisker-normal"] | None = None,
    boundary_spacing: float | None = None,
    history_shapes: int | None = None,
    history_travel: float | None = None,
    update_travel: float | None = None,
    tolerance: float | None = None,
    missed_share: float | None = None,
    heading_error: float | None = None,
    within: Sequence[float] | None = None,
    tolerate: int | None = None,
    largest_slope: float | None = None,
    work: int | None = None,
    last_work: int | None = None,
    two_contacts: float | None = None,
    seed_spacing: float | None = None,
    seed_turn: float | None = None,
    seed_travel: float | None = None,
    shared_gain: float | None = None,
    tolerated_share: float | None = None,
    noise_model: Literal["independent", "correlated"] | None = None,
) -> Localization:
    """Finds where the robot is from a sensor log and a map; files may stand for each of them.

    robot: a Robot, a robot file, a Whisker at the robot's origin, or None for the paper's. method: the estimator. format: of
    a log file that is not ours. truth: the true trajectory, to report errors against. progress: see ``Progress``.

    Deterministic method: tip_load, boundary_spacing (m), history_shapes (2 to 5), history_travel (m), update_travel (m),
    tolerance (standard deviations), missed_share. Possibilistic and probabilistic: heading_error (rad). All: within, where
    the robot is at the first row: least and largest x, y (m) and heading (rad), six numbers. Possibilistic: tolerate
    (readings), largest_slope (rad), work, last_work, two_contacts (m). Probabilistic: seed_spacing (m), seed_turn (rad), seed_travel (m),
    shared_gain, tolerated_share, noise_model. ``vibrissa localize --help`` explains each; None takes the default.

    Ctrl-C ends it within a second.
    """
    options = {
        "tip_load": tip_load,
        "boundary_spacing": boundary_spacing,
        "history_shapes": history_shapes,
        "history_travel": history_travel,
        "update_travel": update_travel,
        "tolerance": tolerance,
        "missed_share": missed_share,
        "heading_error": heading_error,
        "within": within,
        "tolerate": tolerate,
        "largest_slope": largest_slope,
        "work": work,
        "last_work": last_work,
        "two_contacts": two_contacts,
        "seed_spacing": seed_spacing,
        "seed_turn": seed_turn,
        "seed_travel": seed_travel,
        "shared_gain": shared_gain,
        "tolerated_share": tolerated_share,
        "noise_model": noise_model,
    }
    known = None if truth is None else read_trajectory(truth)
    found = _vibrissa.localize(read_log(log, format), read_map(map), robot_of(robot), method, options, progress)
    return Localization._of(found, known)


@dataclass(frozen=True, eq=False)
class Demo:
    """The main job on the built-in arena and sweep."""

    map: Map
    """The arena."""
    sweep: Simulation
    """The simulated sweep: log and truth."""
    answer: Localization
    """Where the robot is by its log, with the error against the truth."""


def demo(seed: int = 1, method: Method = "probabilistic") -> Demo:
    """Simulates a sweep in the built-in arena, localizes, and compares with the truth; the seed is the noise's."""
    log, fields = _vibrissa.demo_sweep(seed)
    sweep = Simulation._of(log, fields)
    return Demo(arena(), sweep, localize(log, arena(), method=method, truth=sweep.truth))
