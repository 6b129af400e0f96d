"""Calibrations: raw readings to moments, taps to distances, constants of the whisker."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy.typing as npt

from . import _vibrissa
from ._arrays import Floats
from ._docs import documented
from ._errors import UsageError
from ._robot import RobotLike, Whisker, robot_of
from ._show import Shown, pandas
from ._vibrissa import Calibration

PathLike = str | os.PathLike[str]


@dataclass(frozen=True, eq=False, repr=False)
class CalibrationReport(Shown):
    """A calibration, and how well it fits."""

    calibration: Calibration
    """What was found; ``calibration.write(path)`` makes the file."""
    out_of_reach: int = 0
    """Labelled contacts that the whisker cannot reach."""
    free: tuple[str, ...] = ()
    """Parameters of the distance model that were fitted."""
    covariance: tuple[tuple[float, ...], ...] = ()
    """Their covariance."""
    left_out: Floats | None = None
    """True distances and those by a fit without them (m), shape (contacts, 2), NaN where none fits."""


@documented
def calibrate(
    log: PathLike | Mapping[str, npt.ArrayLike] | None = None,
    *,
    taps: Mapping[float, PathLike] | Iterable[tuple[float, PathLike]] | None = None,
    format: str | None = None,
    robot: RobotLike = None,
    free: Sequence[str] = (),
    length: float | None = None,
    tip_ratio: float | Literal["free"] | None = None,
    clamped: bool = False,
    channel: str | None = None,
    reference: str | None = None,
) -> CalibrationReport:
    """Calibrates a whisker from labelled contacts, from taps, or from a staircase of lateral travel.

    Parameters
    ----------
    log : path or mapping of columns, optional
        Labelled contacts: the points x, y (m, whisker frame) and bx, by, bz (T), ax, ay, az (counts) or moment (N m), each of
        shape (contacts). With z, too, both transverse axes are calibrated. With ``format="openwhisker"`` a staircase.
    taps : mapping or iterable of pairs, optional
        Recordings of taps by radial distance from the base (m), of a base that turns at a constant rate.
    {format}
    {robot}
    free : sequence of str
        Constants of the whisker to fit: "flexural_rigidity", "base_compliance", "tip_ratio".
    length : float, optional
        Length of the shaft, of taps and staircases (m).
    tip_ratio : float or "free", optional
        Tip radius over base radius, likewise.
    clamped : bool
        Whether the base is stiff, likewise.
    channel : str, optional
        The channel that is read, likewise.
    {reference}

    Returns
    -------
    CalibrationReport
        The calibration, and how well it fits.

    Raises
    ------
    DataError
        Too few contacts, or readings that nothing fits.
    UsageError
        Neither log nor taps, or both.
    """
    whisker = robot_of(robot).whiskers[0].beam
    shaft = {
        "length": length,
        "tip_ratio": None if tip_ratio == "free" else tip_ratio,
        "free_taper": tip_ratio == "free",
        "clamped": clamped,
        "channel": channel,
        "reference": reference,
    }
    known: Whisker | None = None if robot is None else whisker
    if taps is not None:
        if log is not None:
            raise UsageError("give a log or taps, not both")
        files = list(taps.items() if isinstance(taps, Mapping) else taps)
        return _distances(*_vibrissa.calibrate_taps(files, format, known, shaft))
    if log is None:
        raise UsageError("nothing to calibrate from\n  help: give a log of labelled contacts, or taps")
    if isinstance(log, Mapping):
        found, lost = _vibrissa.calibrate_labelled(None, log, format, whisker, list(free))
        return CalibrationReport(found, out_of_reach=lost)
    if format == "openwhisker":
        return _distances(*_vibrissa.calibrate_staircase(log, known, shaft))
    found, lost = _vibrissa.calibrate_labelled(log, None, format, whisker, list(free))
    return CalibrationReport(found, out_of_reach=lost)


def _distances(calibration: Calibration, fit: dict[str, Any]) -> CalibrationReport:
    covariance = tuple(tuple(row) for row in fit["covariance"])
    return CalibrationReport(calibration, 0, tuple(fit["free"]), covariance, fit["left_out"])


@dataclass(frozen=True, eq=False, repr=False)
class Taps(Shown):
    """Short contacts of a turning base; columns of shape (taps)."""

    t: Floats
    """When (s)."""
    distance: Floats
    """Radial distance from the base (m), NaN where none fits."""
    distance_std: Floats
    """Its standard deviation (m)."""
    slope: Floats
    """Slope of the reading (per s)."""

    def to_pandas(self) -> Any:
        """A ``pandas.DataFrame``, one row for each tap."""
        columns = {"t": self.t, "distance": self.distance, "distance_std": self.distance_std, "slope": self.slope}
        return pandas().DataFrame(columns)


@documented
def taps(
    log: PathLike, calibration: Calibration | PathLike, *, format: str | None = None, reference: str | None = None
) -> Taps:
    """Finds the taps of a recording and their radial distances.

    Parameters
    ----------
    log : path
        The recording.
    calibration : Calibration or path
        The calibration that ``calibrate`` made of taps.
    {format}
    {reference}

    Returns
    -------
    Taps
        One entry for each tap; SI.

    Raises
    ------
    DataError
        A recording without the calibration's channel.
    """
    known = calibration if isinstance(calibration, Calibration) else Calibration.read(calibration)
    return Taps(**_vibrissa.find_taps(log, known, format, reference))
