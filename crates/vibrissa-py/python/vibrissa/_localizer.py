"""Where the robot is, row by row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from . import _vibrissa
from ._docs import documented
from ._localize import Hypothesis, Localization, MethodLike, Status, method_of
from ._robot import RobotLike, robot_of
from ._show import Shown
from ._world import MapLike, read_map


@dataclass(frozen=True, eq=False, repr=False)
class Estimate(Shown):
    """What can be said before the log has ended; less exact than the answer at the end."""

    status: Status
    """The verdict on the rows so far."""
    rows: int
    """How many rows have been taken."""
    pose: tuple[float, float, float] | None
    """The best place at the last row: x (m), y (m), theta (rad), map frame; None as long as no place is known."""
    hypotheses: list[Hypothesis]
    """Every surviving place at the last row, heaviest first; without ``ridge``."""


@documented
class Localizer:
    """A robot that is being localized while it drives: rows in, what is known now at any row.

    ``step`` and ``estimate`` let other threads of Python run. The same rows give the same answers, whatever the machine's load.

    Parameters
    ----------
    {map}
    {robot}
    {method}
    columns : sequence of str, optional
        The names of the readings, in the order in which ``step`` gets them. None: "moment" for a robot with one whisker,
        "NAME.moment" for each of several. Raw readings ("bx", "by", "bz") go through the robot's calibration.
    options : mapping, optional
        The method's options by name, such as ``{"within": (0, 1, 0, 1, -3.2, 3.2)}``.

    Raises
    ------
    DataError
        A fault in map or robot.
    UsageError
        An option that the method has not.

    Examples
    --------
    >>> localizer = vibrissa.Localizer("arena.svg", "robot.toml")
    >>> localizer.step(t, (x, y, theta), moment)        # s; odometry in m, m, rad; N m
    >>> now = localizer.estimate()                      # now.status, now.pose, now.hypotheses
    >>> answer = localizer.finish()                     # as of vibrissa.localize
    """

    def __init__(
        self,
        map: MapLike,
        robot: RobotLike = None,
        method: MethodLike = "probabilistic",
        *,
        columns: Sequence[str] | None = None,
        options: Mapping[str, Any] | None = None,
    ) -> None:
        known = robot_of(robot)
        if columns is None:
            names = [whisker.name for whisker in known.whiskers]
            columns = ["moment"] if len(names) == 1 else [f"{name}.moment" for name in names]
        self.columns: tuple[str, ...] = tuple(columns)
        """The names of the readings that ``step`` takes."""
        name, given = method_of(method, options or {})
        self._map = read_map(map)
        self._name = name
        self._core = _vibrissa.LocalizerCore(self._map, known, name, given, list(columns))

    def __repr__(self) -> str:
        return f"<vibrissa.Localizer: {self._name}, {', '.join(self.columns)}, {self._map!r}>"

    def step(
        self, t: float, pose: Sequence[float], readings: float | Sequence[float], heading: float | None = None
    ) -> None:
        """Takes a row.

        Parameters
        ----------
        t : float
            When (s); it increases.
        pose : sequence of three floats
            The robot in the odometry frame: x (m), y (m), theta (rad).
        readings : float or sequence of float
            One reading, or one for each of ``columns`` (N m for moments).
        heading : float, optional
            The absolute heading in the map frame (rad), where it is measured.

        Raises
        ------
        DataError
            A row that cannot be; it is left out, and the next one may follow.
        """
        x, y, theta = (float(value) for value in pose)
        values = [float(readings)] if isinstance(readings, int | float) else [float(value) for value in readings]
        self._core.step(float(t), [x, y, theta], values, heading)

    def estimate(self) -> Estimate:
        """What can be said at the last row; it changes nothing."""
        fields = self._core.estimate()
        return Estimate(**{**fields, "hypotheses": [Hypothesis(**one) for one in fields["hypotheses"]]})

    def finish(self) -> Localization:
        """Ends the log and chooses; no row may follow."""
        return Localization._of(self._core.finish(), None, self._map)
