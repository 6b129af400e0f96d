"""Poses over time."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from . import _vibrissa
from ._arrays import Floats, column, rows
from ._show import Shown, axes, pandas, plane


class TrajectoryError(NamedTuple):
    """How far an estimated trajectory is from the truth, over the rows that both cover."""

    rows: int
    """Rows compared."""
    final_position: float
    """Distance at the last compared row (m)."""
    final_heading: float
    """Size of the heading error at the last compared row (rad)."""
    mean_position: float
    """Mean distance (m)."""
    mean_heading: float
    """Mean size of the heading error (rad)."""


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(Shown):
    """The robot over time, map frame."""

    t: Floats
    """Time stamps (s), shape (rows)."""
    poses: Floats
    """x (m), y (m), theta (rad), shape (rows, 3)."""

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Trajectory:
        """The trajectory of a file of lines ``timestamp tx ty tz qx qy qz qw``."""
        return cls(*_vibrissa.tum_read(path))

    def write(self, path: str | os.PathLike[str]) -> None:
        """Writes lines ``timestamp tx ty tz qx qy qz qw``: microseconds, nanometres, quaternion to 1e-9."""
        Path(path).write_text(_vibrissa.tum_format(column(self.t), rows(self.poses, 3)))

    def error(self, truth: Trajectory) -> TrajectoryError | None:
        """The error against ``truth``, which is interpolated; None when no row lies in its span of time."""
        mine, other = (column(self.t), rows(self.poses, 3)), (column(truth.t), rows(truth.poses, 3))
        found = _vibrissa.tum_error(*mine, *other)
        return None if found is None else TrajectoryError(*found)

    def to_pandas(self) -> Any:
        """A ``pandas.DataFrame`` of t (s), x, y (m) and theta (rad)."""
        x, y, theta = self.poses.reshape(-1, 3).T
        return pandas().DataFrame({"t": self.t, "x": x, "y": y, "theta": theta})

    def plot(self, ax: Any = None) -> Any:
        """Draws the way into axes of matplotlib (m), new ones for None, and gives them."""
        ax = axes(ax)
        ax.plot(self.poses[:, 0], self.poses[:, 1])
        plane(ax)
        return ax

    def __len__(self) -> int:
        return int(self.t.size)


TrajectoryLike = Trajectory | str | os.PathLike[str]


def read_trajectory(source: TrajectoryLike) -> Trajectory:
    """A trajectory, or the file of one."""
    return source if isinstance(source, Trajectory) else Trajectory.read(source)
