"""The extension module of the package vibrissa."""

import os
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, final

import numpy.typing as npt

from ._arrays import Bools, Floats, Ints
from ._robot import Robot, Whisker

__all__ = [
    "run_command",
    "run_command_here",
    "explore",
    "map_log",
    "plan",
    "Bend",
    "Bends",
    "bends",
    "Calibration",
    "calibrate_labelled",
    "calibrate_staircase",
    "calibrate_taps",
    "find_taps",
    "contact",
    "contact_in_space",
    "profile",
    "temporal_filter",
    "quantity",
    "robot_default",
    "robot_parse",
    "robot_read",
    "robot_toml",
    "whisker_is_uniform",
    "demo_sweep",
    "localize",
    "LocalizerCore",
    "methods",
    "tum_error",
    "tum_format",
    "tum_read",
    "SensorLog",
    "contact_set",
    "preimage",
    "Scenario",
    "path",
    "sweep",
    "Map",
    "__version__",
]

__version__: str
_Path = str | os.PathLike[str]
_Poses = tuple[Floats, Floats]
_Course = tuple[Sequence[Sequence[float]], float]

@final
class Bend:
    """One loaded whisker in equilibrium; units and frame as in `Bends`."""

    @property
    def case(self) -> int:
        """Which problem it solves."""
    @property
    def branch(self) -> int:
        """Which solution of its problem it is, least slope first."""
    @property
    def force(self) -> float:
        """Force along the load's direction (N)."""
    @property
    def s_a(self) -> float:
        """Arc length from the base to the contact (m)."""
    @property
    def phi_a(self) -> float:
        """Slope at the contact (rad)."""
    @property
    def beta(self) -> float:
        """Rotation from the whisker's normal at the contact to the load (rad)."""
    @property
    def x(self) -> float:
        """The contact along the undeflected whisker (m)."""
    @property
    def y(self) -> float:
        """The contact across the undeflected whisker (m)."""
    @property
    def moment(self) -> float:
        """Moment about the base (N m)."""
    @property
    def energy(self) -> float:
        """Elastic energy (J)."""
    @property
    def tip(self) -> tuple[float, float]:
        """The tip (m)."""
    def shape(self, n: int = 101) -> Floats:
        """Points from base to tip, evenly spaced in arc length (m); shape (n, 2)."""

@final
class Bends:
    """Equilibria of loaded whiskers, one row each: every branch of every problem, in order.

    All columns have shape (rows). Whisker frame: base at the origin, undeflected along +x, a push towards +y positive.
    """

    @property
    def case(self) -> Ints:
        """Which problem each row solves, from 0 on in the order of the (flattened) inputs; int64."""
    @property
    def branch(self) -> Ints:
        """Which solution of its problem each row is, least slope first; int64."""
    @property
    def force(self) -> Floats:
        """Force along the load's direction (N)."""
    @property
    def s_a(self) -> Floats:
        """Arc length from the base to the contact (m)."""
    @property
    def phi_a(self) -> Floats:
        """Slope at the contact (rad)."""
    @property
    def beta(self) -> Floats:
        """Rotation from the whisker's normal at the contact to the load (rad)."""
    @property
    def x(self) -> Floats:
        """The contact along the undeflected whisker (m)."""
    @property
    def y(self) -> Floats:
        """The contact across the undeflected whisker (m)."""
    @property
    def moment(self) -> Floats:
        """Moment about the base (N m)."""
    @property
    def energy(self) -> Floats:
        """Elastic energy (J)."""
    @property
    def base_angle(self) -> Floats:
        """How far the base has turned (rad); 0 when it is clamped."""
    @property
    def force_vector(self) -> Floats:
        """The force as vectors (N), shape (rows, 2)."""
    @property
    def tip(self) -> Floats:
        """The tips (m), shape (rows, 2)."""
    @property
    def problems(self) -> int:
        """How many problems there were, with and without a solution."""
    @property
    def faults(self) -> list[tuple[int, str]]:
        """The problems that made no sense, with their errors' texts; filled with errors="skip"."""
    def shape(self, n: int = 101) -> Floats:
        """Points from base to tip, evenly spaced in arc length (m); shape (rows, n, 2)."""
    def shape_points(self, n: int = 101) -> Floats:
        """As `shape` with arc length, place, slope and curvature (m, m, m, rad, 1/m); shape (rows, n, 5)."""
    def largest_strain(self) -> Floats:
        """Where the surface is strained the most: arc length (m), curvature (1/m), strain; shape (rows, 3), NaN without a
        diameter."""
    def __len__(self) -> int: ...
    def __getitem__(self, index: int, /) -> Bend: ...
    def __iter__(self) -> Iterator[Bend]: ...

@final
class Map:
    """A map of the plane: arena, obstacles and walls (m), x right and y up as drawn."""

    def _parts(self) -> list[tuple[str, bool, bool, list[list[tuple[float, float]]], _Course | None, str | None]]: ...
    @staticmethod
    def _from_parts(
        parts: Sequence[
            tuple[str, bool, bool, Sequence[Sequence[tuple[float, float]]], _Course | None, str | None]
        ],
        warnings: Sequence[str],
    ) -> Map: ...
    def bands(self) -> tuple[list[Floats], list[Floats]]:
        """How exactly the boundaries are known: quadrilaterals of shape (4, 2) (m) that the true ones lie in, and lines of shape
        (n, 2) (m) along stretches of which nothing is known; none of an exact map."""
    def _repr_svg_(self) -> str: ...
    def to_geojson(self) -> str:
        """The map as a GeoJSON text (m), which `from_geojson` reads; curves become lines."""
    def __reduce__(self) -> tuple[Any, ...]: ...
    def plot(self, ax: Any = None) -> Any:
        """Draws the boundaries into axes of matplotlib (m), new ones for None, and gives them."""
    @staticmethod
    def read(path: _Path) -> Map:
        """The map of a file: .geojson (m), .svg (mm), .dxf, .yaml or .mcap."""
    @staticmethod
    def from_geojson(text: str, name: str = "map.geojson") -> Map:
        """The map of a GeoJSON text (m); `name` stands for the file in messages."""
    @staticmethod
    def from_svg(text: str, name: str = "map.svg") -> Map:
        """The map of an SVG text (mm unless it says otherwise); `name` stands for the file in messages."""
    @staticmethod
    def from_dxf(text: str, name: str = "map.dxf") -> Map:
        """The map of a DXF text (layers say the roles); `name` stands for the file in messages."""
    @staticmethod
    def from_points(
        arenas: Sequence[npt.ArrayLike] | None = None,
        obstacles: Sequence[npt.ArrayLike] | None = None,
        walls: Sequence[npt.ArrayLike] | None = None,
    ) -> Map:
        """The map of corner points (m): lists of arrays of shape (n, 2).

        Free space is inside the arenas and outside the obstacles; a wall is thin and solid on both sides.
        """
    @staticmethod
    def demo() -> Map:
        """The built-in arena of the demo."""
    @property
    def warnings(self) -> list[str]:
        """What looked wrong but could be read, for people."""
    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Least and largest x, least and largest y (m)."""
    @property
    def total_length(self) -> float:
        """Length of all boundaries together (m)."""
    def boundaries(self, tolerance: float | None = None) -> list[tuple[str, Floats]]:
        """The boundaries as polylines within `tolerance` (m) of their curves: a list of role ("arena", "obstacle" or "wall")
        and points of shape (n, 2); a closed line repeats its first point."""
    def is_free(self, points: npt.ArrayLike) -> Bools:
        """Whether each point of shape (n, 2) (m) lies in free space; shape (n)."""
    def nearest(self, points: npt.ArrayLike) -> dict[str, Floats]:
        """The boundary point nearest to each point of shape (n, 2) (m): "point" (n, 2) (m), "distance" (n) (m), "tangent"
        (n) (rad), free space on its left, and "curvature" (n) (1/m)."""

@final
class LocalizerCore:
    """A localizer that takes rows as they come."""

    def __new__(
        cls, map: Map, robot: Robot, method: str, options: dict[str, Any], columns: Sequence[str]
    ) -> LocalizerCore: ...
    def step(
        self, t: float, pose: Sequence[float], readings: Sequence[float], heading: float | None
    ) -> None:
        """Takes a row: time (s), odometry x, y, theta (m, m, rad), one reading for each column, absolute heading (rad)."""
    def estimate(self) -> dict[str, Any]:
        """What can be said now: the fields of `vibrissa.Estimate`."""
    def finish(self) -> dict[str, Any]:
        """Ends the log: the fields of `vibrissa.Localization`."""

@final
class SensorLog:
    """What a robot recorded: times, odometry and readings.

    t: time stamps (s), shape (rows). odometry: x (m), y (m), theta (rad) of the robot from any origin, shape (rows, 3).
    readings: the moments (N m) of shape (rows), or columns by name as a file's header has them ("moment", "w0.moment",
    "bx", ...). heading: absolute headings in the map frame (rad), shape (rows). The checks and warnings are those that files go
    through.
    """

    @staticmethod
    def _from_parts(text: str, source: _Path | None, warnings: Sequence[str]) -> SensorLog: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    def _repr_html_(self) -> str: ...
    def plot(self, ax: Any = None) -> Any:
        """Draws the readings over time into axes of matplotlib, new ones for None, and gives them."""
    def to_pandas(self) -> Any:
        """A `pandas.DataFrame` with the columns of the log's file: t, x, y, theta, readings and heading."""
    def __new__(
        cls,
        t: npt.ArrayLike,
        odometry: npt.ArrayLike,
        readings: Mapping[str, npt.ArrayLike] | npt.ArrayLike,
        heading: npt.ArrayLike | None = None,
    ) -> SensorLog: ...
    @staticmethod
    def read(
        path: _Path, format: str | None = None, *, headings: str | None = None, yaw_rates: str | None = None
    ) -> SensorLog:
        """Reads the log of a file.

        Parameters
        ----------
        path : path
            A .csv file, or an .mcap recording with ROS 2 messages.
        format : str, optional
            The format of a file that is neither: "rostopic", ...
        headings : str, optional
            Of a recording: the topic of `sensor_msgs/Imu` whose orientation is the robot's heading in the map frame.
        yaw_rates : str, optional
            Of a recording: the topic of `sensor_msgs/Imu` whose angular velocity about z says how the robot turns.

        Returns
        -------
        SensorLog
            The log, SI.

        Raises
        ------
        DataError
            A fault in the file; ``MissingFileError`` (also a ``FileNotFoundError``) where it is missing.
        """
    @property
    def t(self) -> Floats:
        """Time stamps (s), shape (rows)."""
    @property
    def odometry(self) -> Floats:
        """The robot in the odometry frame: x (m), y (m), theta (rad); shape (rows, 3)."""
    @property
    def readings(self) -> dict[str, Floats]:
        """The readings by column name ("moment", "w0.moment", "bx", ...), each of shape (rows), SI or counts."""
    @property
    def heading(self) -> Floats | None:
        """Absolute headings in the map frame (rad), shape (rows), NaN where there is none; None when none was logged."""
    @property
    def warnings(self) -> list[str]:
        """What looked wrong but could be read, for people."""
    def to_csv(self) -> str:
        """The log as CSV, every number with all its digits."""
    def __len__(self) -> int: ...

@final
class Scenario:
    """A scenario: map, robot, path and errors, ready to be simulated."""

    @staticmethod
    def read(path: _Path) -> Scenario:
        """The scenario of a .toml file."""
    @property
    def title(self) -> str:
        """What it is for, in a line."""
    @property
    def seed(self) -> int:
        """The seed of everything random."""
    @property
    def map(self) -> Map:
        """The map."""
    @property
    def path(self) -> _Poses:
        """The true path: t of shape (rows) and poses of shape (rows, 3), map frame (s; m, m, rad)."""
    def robot_toml(self) -> str:
        """The robot as the text of its file."""
    def _simulate(self, seed: int | None, progress: Any) -> tuple[SensorLog, dict[str, Any], str | None]: ...

@final
class Calibration:
    """A calibration: raw readings to moments, slopes of taps to distances, constants of the whisker."""

    @staticmethod
    def read(path: _Path) -> Calibration:
        """The calibration of a file (cal.json)."""
    @staticmethod
    def from_json(text: str, name: str = "cal.json") -> Calibration:
        """The calibration in a JSON text; `name` stands for the file in messages."""
    def to_json(self) -> str:
        """The calibration as the text of its file."""
    def write(self, path: _Path) -> None:
        """Writes the file (cal.json)."""
    @property
    def inputs(self) -> list[str]:
        """The columns that `moment` reads ("bx", ...), in order; none where moments are not calibrated."""
    @property
    def moment_bound(self) -> float | None:
        """Bound on the error of a moment (N m), where moments are calibrated."""
    @property
    def moment_bounds(self) -> tuple[float, float] | None:
        """Bounds on the errors of both moments (N m), where both transverse axes are calibrated."""
    def moment(self, readings: npt.ArrayLike) -> Floats:
        """Moments (N m), shape (n), of readings of shape (n, inputs)."""
    def moments(self, readings: npt.ArrayLike) -> Floats:
        """Moments about both transverse axes (N m), shape (n, 2), of readings of shape (n, inputs): in the whisker's plane,
        positive for a push towards +y, and across it, positive for a push towards +z."""
    def distance(self, slopes: npt.ArrayLike) -> tuple[Floats, Floats]:
        """Distances (m) and their standard deviations (m), shape (n), for slopes of shape (n) (readings per s of a tap, per
        m of travel); NaN where no distance fits."""

def bends(
    given: str,
    count: int,
    first: Floats,
    second: Floats,
    load: str,
    angles: Floats | None,
    whiskers: Sequence[Whisker],
    skip_faults: bool,
    threads: int | None,
) -> Bends: ...
def calibrate_labelled(
    path: _Path | None,
    columns: Mapping[str, npt.ArrayLike] | None,
    word: str | None,
    whisker: Whisker,
    free: Sequence[str],
) -> tuple[Calibration, int]: ...
def calibrate_staircase(
    path: _Path, whisker: Whisker | None, shaft: dict[str, Any]
) -> tuple[Calibration, dict[str, Any]]: ...
def calibrate_taps(
    files: Sequence[tuple[float, _Path]], word: str | None, whisker: Whisker | None, shaft: dict[str, Any]
) -> tuple[Calibration, dict[str, Any]]: ...
def contact(log: SensorLog, robot: Robot, spacing: float | None) -> dict[str, Any]: ...
def contact_in_space(log: SensorLog, robot: Robot, spacing: float | None) -> dict[str, Any]: ...
def contact_set(readings: Sequence[Any], robot: Robot, model: Any) -> dict[str, Any]: ...
def demo_sweep(seed: int) -> tuple[SensorLog, dict[str, Any]]: ...
def explore(
    scenario: Scenario,
    begin: float,
    most_way: float,
    seed: int,
    strategy: str,
    tested: bool,
    method: str,
    options: dict[str, Any],
    limits: dict[str, Any],
) -> tuple[SensorLog, dict[str, Any]]: ...
def find_taps(
    path: _Path, calibration: Calibration, word: str | None, reference: str | None
) -> dict[str, Any]: ...
def localize(
    log: SensorLog,
    map: Map,
    robot: Robot,
    method: str,
    options: dict[str, Any],
    progress: Any,
    truth: _Poses | None,
) -> dict[str, Any]: ...
def map_log(
    logs: Sequence[SensorLog],
    robot: Robot,
    truth: Map | None,
    drift: float | None,
    body_radius: float | None,
    same_start: tuple[float, float] | None,
) -> tuple[Map, dict[str, Any]]: ...
def methods() -> list[str]: ...
def path(
    waypoints: Floats, speed: float | None, turn_rate: float | None, rate: float | None
) -> _Poses: ...
def plan(
    log: SensorLog, map: Map, robot: Robot, method: str, options: dict[str, Any], limits: dict[str, Any]
) -> dict[str, Any]: ...
def preimage(
    map: Map,
    readings: Sequence[Any],
    robot: Robot,
    model: Any,
    construction: str,
    contacts: str,
    collision_free: bool,
    cell: float | None,
    heading_step: float | None,
) -> dict[str, Any]: ...
def profile(logs: Sequence[SensorLog], robot: Robot, truth: Map | None, free_scale: bool) -> dict[str, Any]: ...
def robot_default() -> dict[str, Any]: ...
def robot_parse(text: str, name: str) -> dict[str, Any]: ...
def quantity(text: str, dimension: str) -> float: ...
def robot_read(path: _Path) -> dict[str, Any]: ...
def robot_toml(robot: Robot) -> str: ...
def run_command(args: Sequence[str]) -> int: ...
def run_command_here(args: Sequence[str]) -> int: ...
def sweep(
    map: Map,
    robot: Robot,
    t: Floats,
    poses: Floats,
    seed: int | None,
    moment: tuple[float, float] | None,
    odometry: tuple[float, float],
    discrete: bool,
    progress: Any,
) -> tuple[SensorLog, dict[str, Any]]: ...
def tum_error(t: Floats, poses: Floats, true_t: Floats, true_poses: Floats) -> tuple[int, float, float, float, float] | None: ...
def tum_format(t: Floats, poses: Floats) -> str: ...
def tum_read(path: _Path) -> _Poses: ...
def whisker_is_uniform(whisker: Whisker) -> bool: ...
def temporal_filter(
    log: SensorLog, robot: Robot, readings: int | None, spacing: float | None
) -> dict[str, Any]: ...
