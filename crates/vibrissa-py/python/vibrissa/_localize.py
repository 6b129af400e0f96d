"""Where the robot is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from . import _vibrissa
from ._arrays import Floats, Ints, column, rows
from ._docs import documented
from ._errors import meant, one_of
from ._methods import METHODS, Deterministic, Options, Possibilistic, Probabilistic
from ._robot import RobotLike, robot_of
from ._show import Shown, axes, draw_map, pandas, plane
from ._simulate import Simulation
from ._trajectory import Trajectory, TrajectoryError, TrajectoryLike, read_trajectory
from ._types import Event, Progress
from ._vibrissa import Map
from ._world import LogLike, MapLike, arena, read_log, read_map

if TYPE_CHECKING:
    from typing_extensions import Unpack

Method = Literal["deterministic", "possibilistic", "probabilistic"]
MethodLike = Method | Deterministic | Possibilistic | Probabilistic
Status = Literal["localized", "ambiguous", "inconsistent", "no_contact"]


@dataclass(frozen=True, eq=False, repr=False)
class Hypothesis(Shown):
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


@dataclass(frozen=True, eq=False, repr=False)
class Steps(Shown):
    """The state set's size after each update; columns of shape (updates)."""

    t: Floats
    """When (s)."""
    components: Ints
    """How many separate components the set has."""
    area_m2: Floats
    """Area of the set's projection onto the plane (m²)."""
    volume: Floats
    """Volume of the set (m² rad)."""

    def to_pandas(self) -> Any:
        """The columns as a ``pandas.DataFrame``."""
        return pandas().DataFrame({one.name: getattr(self, one.name) for one in fields(self)})


class WhiskerShape(NamedTuple):
    """One reconstructed whisker shape."""

    t: float
    """When (s)."""
    points: Floats
    """Points from base to tip, robot frame (m), shape (n, 2)."""
    whisker: int = 0
    """Index of the whisker in the robot."""


@dataclass(frozen=True, eq=False, repr=False)
class Localization(Shown):
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
    _svg: str | None = None
    _map: Map | None = None

    def _repr_svg_(self) -> str | None:
        return self._svg

    @property
    def svg(self) -> str | None:
        """The figure of ``vibrissa localize`` as SVG text; None for answers of ``Localizer``."""
        return self._svg

    def to_pandas(self) -> Any:
        """The hypotheses as a ``pandas.DataFrame``, one row each.

        Returns
        -------
        pandas.DataFrame
            Columns x, y (m), theta (rad), weight and the extents; the trajectory and the steps have ``to_pandas`` of
            their own.
        """
        arrays = ("covariance", "ridge")
        rows = [{k: v for k, v in asdict(one).items() if k not in arrays} for one in self.hypotheses]
        names = [one.name for one in fields(Hypothesis) if one.name not in arrays]
        return pandas().DataFrame(rows, columns=names)

    def plot(self, ax: Any = None) -> Any:
        """Draws map, states, whiskers, trajectory and estimate.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw; None for a new figure.

        Returns
        -------
        matplotlib.axes.Axes
            The axes, in m.
        """
        ax = axes(ax)
        if self._map is not None:
            draw_map(ax, self._map)
        middle = self.states.reshape(-1, 6)
        ax.plot(middle[:, :2].mean(axis=1), middle[:, 2:4].mean(axis=1), ".", color="#d55e00", label="states")
        poses = self.trajectory.poses
        label: str | None = "whisker"
        for shape in self.shapes:
            at = np.searchsorted(self.trajectory.t, shape.t)
            if at < len(self.trajectory):
                x, y, theta = poses[at]
                c, s = np.cos(theta), np.sin(theta)
                placed = shape.points @ np.array([[c, s], [-s, c]]) + [x, y]
                ax.plot(placed[:, 0], placed[:, 1], color="#a64d85", linewidth=0.7, label=label)
                label = None
        ax.plot(poses[:, 0], poses[:, 1], color="#0072b2", label="trajectory")
        if self.estimate is not None:
            x, y, theta = self.estimate
            ax.quiver(x, y, np.cos(theta), np.sin(theta), color="#0072b2", angles="xy", label="estimate")
        ax.set_title(f"{self.method}: {self.status}")
        ax.legend(fontsize="small")
        plane(ax)
        return ax

    @classmethod
    def _of(cls, found: dict[str, Any], truth: Trajectory | None, map: Map | None = None) -> Localization:
        trajectory = Trajectory(*found["trajectory"])
        fit = found["consistency"]
        # Where nothing explains the log there is no answer that could be off.
        known = None if found["status"] == "inconsistent" else truth
        made = {
            **found,
            "hypotheses": [Hypothesis(**one) for one in found["hypotheses"]],
            "trajectory": trajectory,
            "odometry": None if found["odometry"] is None else OdometryEstimate(**found["odometry"]),
            "nuisances": [Nuisance(**one) for one in found["nuisances"]],
            "consistency": None
            if fit is None
            else Consistency(**{**fit, "remedies": [Remedy(*one) for one in fit["remedies"]]}),
            "steps": Steps(**found["steps"]),
            "events": [Event(*one) for one in found["events"]],
            "shapes": [WhiskerShape(*one) for one in found["shapes"]],
        }
        return cls(**made, error=None if known is None else trajectory.error(known), _map=map)


@documented
def localize(
    log: LogLike,
    map: MapLike,
    robot: RobotLike = None,
    method: MethodLike = "probabilistic",
    *,
    format: str | None = None,
    truth: TrajectoryLike | None = None,
    within: Sequence[float] | None = None,
    progress: Progress | None = None,
    **options: Unpack[Options],
) -> Localization:
    """Finds where the robot is from a sensor log and a map; files may stand for each of them.

    Ctrl-C ends it within a second.

    Parameters
    ----------
    {log}
    {map}
    {robot}
    {method}
    {format}
    truth : Trajectory or path, optional
        The true trajectory (map frame), to report errors against.
    {within}
    {progress}
    **options
        The options of the method by name, as the classes have them.

    Returns
    -------
    Localization
        Verdict, places, trajectory and states; SI, map frame.

    Raises
    ------
    DataError
        A fault in log, map or robot; ``MissingFileError`` (also a ``FileNotFoundError``) where a file is missing.
    UsageError
        An option that is out of range, or that the method has not.

    Examples
    --------
    >>> answer = vibrissa.localize("sweep.csv", "arena.svg", method=vibrissa.Possibilistic(heading_error=0.05))
    >>> answer.status, answer.estimate
    >>> answer.plot()
    """
    name, given = method_of(method, options)
    if within is not None:
        given["within"] = within
    known = None if truth is None else read_trajectory(truth)
    pair = None if known is None else (column(known.t), rows(known.poses, 3))
    shape = read_map(map)
    found = _vibrissa.localize(read_log(log, format), shape, robot_of(robot), name, given, progress, pair)
    return Localization._of(found, known, shape)


def method_of(method: MethodLike, options: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    """The name of a method and its options; those by name come before those of the group."""
    unknown = set(options) - {*Options.__annotations__, "within"}
    if unknown:
        stranger = min(unknown)
        hint = meant(stranger, Options.__annotations__)
        raise TypeError(f"there is no option {stranger!r} of any method{hint}")
    if isinstance(method, str):
        return one_of("method", method, METHODS.values()), dict(options)
    own = {one.name: getattr(method, one.name) for one in fields(method)}
    return METHODS[type(method)], {**own, **{k: v for k, v in options.items() if v is not None}}


@dataclass(frozen=True, eq=False, repr=False)
class Demo(Shown):
    """The main job on the built-in arena and sweep."""

    map: Map
    """The arena."""
    sweep: Simulation
    """The simulated sweep: log and truth."""
    answer: Localization
    """Where the robot is by its log, with the error against the truth."""

    def _repr_svg_(self) -> str | None:
        return self.answer.svg

    def plot(self, ax: Any = None) -> Any:
        """Draws the answer; see ``Localization.plot``."""
        return self.answer.plot(ax)


@documented
def demo(seed: int = 1, method: MethodLike = "probabilistic") -> Demo:
    """Simulates a sweep in the built-in arena, localizes, and compares with the truth.

    Parameters
    ----------
    seed : int
        Of the noise.
    {method}

    Returns
    -------
    Demo
        Map, sweep and answer; in a notebook it shows its figure.
    """
    log, fields = _vibrissa.demo_sweep(seed)
    sweep = Simulation._of(log, fields)
    return Demo(arena(), sweep, localize(log, arena(), method=method, truth=sweep.truth))
