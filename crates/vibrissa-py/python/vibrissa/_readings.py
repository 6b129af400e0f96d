"""What readings of virtual sensors can mean: contacts, and robot states on a map."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from . import _vibrissa
from ._arrays import Floats
from ._docs import documented
from ._errors import UsageError, one_of
from ._robot import RobotLike, number, quantity, robot_of
from ._show import Shown, axes, draw_map, plane
from ._vibrissa import Map
from ._world import MapLike, read_map

Sensor = Literal["load", "strip", "slope", "moment"]
_DIMENSIONS = {"load": "force", "strip": "length", "slope": "angle", "moment": "moment"}
Regime = Literal["auto", "small", "large"]


@dataclass(frozen=True)
class Reading:
    """A reading of a virtual sensor: load (N), strip (m), slope (rad) or moment (N m).

    Numbers are SI; a text carries its unit: ``Reading("moment", "5 mN m", "5 %")``.
    """

    sensor: Sensor
    """Which sensor read."""
    value: float | tuple[float, float]
    """What it read, or the least and largest value that the true one may have."""
    tolerance: float = 0.0
    """Bound on the error of a value that is one number; a share of it in "5 %"."""
    whisker: str | None = None
    """The whisker by name; None for the robot's first."""

    if TYPE_CHECKING:

        def __init__(
            self,
            sensor: Sensor,
            value: float | str | tuple[float | str, float | str],
            tolerance: float | str = ...,
            whisker: str | None = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        dimension = _DIMENSIONS[one_of("sensor", self.sensor, _DIMENSIONS)]
        given: object = self.value
        pair = tuple(quantity("value", one, dimension) for one in given) if isinstance(given, tuple) else None
        object.__setattr__(self, "value", pair or quantity("value", given, dimension))
        told: object = self.tolerance
        if isinstance(told, str) and told.rstrip().endswith("%") and not isinstance(self.value, tuple):
            share = quantity("tolerance", told, "ratio")
            assert isinstance(share, float)
            object.__setattr__(self, "tolerance", share * abs(self.value))
        else:
            object.__setattr__(self, "tolerance", quantity("tolerance", told, dimension))

    @property
    def interval(self) -> tuple[float, float]:
        """The values that the true one may have."""
        if isinstance(self.value, tuple):
            return self.value
        return self.value - self.tolerance, self.value + self.tolerance


@dataclass(frozen=True)
class Model:
    """How readings are explained."""

    load: str
    regime: str
    max_force: float
    max_moment: float
    max_slope: float


@dataclass(frozen=True, eq=False, repr=False)
class ContactCurves(Shown):
    """The contacts of one exact reading: one array for each branch.

    Columns of a branch: x (m), y (m), s_a (m), phi_a (rad), force (N), moment (N m); shape (nodes, 6), whisker frame.
    """

    sensor: Sensor
    """Which sensor read."""
    value: float
    """What it read (SI)."""
    tolerance: float
    """How far a true contact can be from the chords between the nodes (m)."""
    small_angle: bool
    """Whether the small-angle model was taken."""
    branches: list[Floats]
    """The branches."""


class Meeting(NamedTuple):
    """Where curves of exact readings meet."""

    x: float
    """(m)"""
    y: float
    """(m)"""
    extent: float
    """Length of the stretch that they share (m)."""
    is_crossing: bool
    """Whether they cross; then the place is exact to rounding."""
    is_one_shape: bool
    """Whether both contacts are one shape of one whisker."""
    first: list[float]
    """The contact on the first curve: x, y, s_a, phi_a, force, moment."""
    second: list[float]
    """The contact on the second curve."""


@dataclass(frozen=True, eq=False, repr=False)
class ContactSets(Shown):
    """The contacts that explain readings, in the frame of the first whisker that read."""

    curves: list[ContactCurves]
    """The curves of each exact reading, in their whisker's own frame."""
    meetings: list[Meeting]
    """Where the curves meet, when all readings are exact and there are several."""
    region: Floats
    """Middles of the cells that cover all contacts: x, y, s_a, phi_a, force, moment; shape (cells, 6)."""
    radius: Floats
    """How far each cell reaches (m), shape (cells)."""
    covers: list[Floats]
    """The corners of each cell (m), shape (corners, 2)."""
    components: list[list[int]]
    """The connected components, as indices of cells."""
    area: float
    """Area of the places (m²), at most."""

    def plot(self, ax: Any = None) -> Any:
        """Draws the contacts: curves of exact readings, cells of others, and where curves meet.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw; None for a new figure.

        Returns
        -------
        matplotlib.axes.Axes
            The axes, whisker frame (m).
        """
        ax = axes(ax)
        for number, curve in enumerate(self.curves):
            for index, branch in enumerate(curve.branches):
                label = f"{curve.sensor} {curve.value:g}" if index == 0 else None
                ax.plot(branch[:, 0], branch[:, 1], color=f"C{number}", label=label)
        for cover in self.covers:
            ax.fill(cover[:, 0], cover[:, 1], color="C0", alpha=0.4, linewidth=0)
        met = [(one.x, one.y) for one in self.meetings]
        if met:
            ax.plot(*zip(*met, strict=True), "o", color="#222222", label="meetings")
        if self.curves:
            ax.legend(fontsize="small")
        plane(ax)
        return ax


def _listed(readings: Reading | Sequence[Reading]) -> list[Reading]:
    """The readings as a list, which other things are not."""
    if isinstance(readings, Reading):
        return [readings]
    given: Any = readings
    listed: list[Any] = [given] if isinstance(given, Map) or not isinstance(given, Iterable) else list(given)
    for one in listed:
        if not isinstance(one, Reading):
            order = "\n  help: the map comes first, then the readings" if isinstance(one, Map) else ""
            example = order or '\n  help: write Reading("moment", "3 mN m")'
            raise UsageError(f"readings: {type(one).__name__} (allowed: a Reading, or a list of them){example}")
    return listed


def _model(
    load: str,
    regime: str,
    max_force: float | str | None,
    max_moment: float | str | None,
    max_slope: float | str | None,
) -> Model:
    def limit(name: str, given: float | str | None, dimension: str) -> float:
        return math.inf if given is None else number(name, given, dimension)

    force, moment = limit("max_force", max_force, "force"), limit("max_moment", max_moment, "moment")
    return Model(load, regime, force, moment, limit("max_slope", max_slope, "angle"))


@documented
def contact_set(
    readings: Reading | Sequence[Reading],
    robot: RobotLike = None,
    *,
    load: Literal["normal", "vertical"] = "normal",
    regime: Regime = "auto",
    max_force: float | str | None = None,
    max_moment: float | str | None = None,
    max_slope: float | str | None = None,
) -> ContactSets:
    """Tells which contacts explain a reading, or several readings at once.

    Parameters
    ----------
    {readings}
    {robot}
    load : {"normal", "vertical"}
        The direction of the force: along the whisker's normal at the contact, or across the undeflected whisker.
    regime : {"auto", "small", "large"}
        How moments are read.
    max_force, max_moment, max_slope : float or str, optional
        What the whisker bears (N, N m, rad); None for no limit.

    Returns
    -------
    ContactSets
        Curves of exact readings, or cells that cover the contacts of readings with bounds; whisker frame (m).

    Raises
    ------
    DataError
        Readings that no contact explains.
    UsageError
        An unknown whisker, or a value out of range.

    Examples
    --------
    >>> sets = vibrissa.contact_set([vibrissa.Reading("load", "0.1 N"), vibrissa.Reading("strip", "60 mm", "1 mm")])
    >>> sets.plot()
    """
    given = _listed(readings)
    model = _model(load, regime, max_force, max_moment, max_slope)
    found = _vibrissa.contact_set(given, robot_of(robot), model)
    curves = [ContactCurves(**one) for one in found["curves"]]
    return ContactSets(**{**found, "curves": curves, "meetings": [Meeting(*one) for one in found["meetings"]]})


@dataclass(frozen=True, eq=False, repr=False)
class Preimage(Shown):
    """The robot states that explain readings, covered by boxes; never fewer than all."""

    states: Floats
    """Boxes x_min, x_max, y_min, y_max (m), theta_min, theta_max (rad), map frame; shape (boxes, 6)."""
    area: float
    """Area of the places (m²), at most."""
    sampled_area: float
    """Area before places are grown to cover (m²)."""
    volume: float
    """Volume of the states (m² rad), at most."""
    deviation: float
    """How far a true state can be from a sampled one (m)."""
    cell: float
    """Side of the cells of places (m)."""
    headings: int
    """How many headings make a turn."""
    _map: Map | None = None

    def plot(self, ax: Any = None) -> Any:
        """Draws map and places.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw; None for a new figure.

        Returns
        -------
        matplotlib.axes.Axes
            The axes, map frame (m).
        """
        ax = axes(ax)
        if self._map is not None:
            draw_map(ax, self._map)
        places = np.unique(self.states[:, :4], axis=0)
        middle = 0.5 * (places[:, 0::2] + places[:, 1::2])
        ax.plot(middle[:, 0], middle[:, 1], ".", color="#0072b2", markersize=1.0, label="places")
        plane(ax)
        return ax


@documented
def preimage(
    map: MapLike,
    readings: Reading | Sequence[Reading],
    robot: RobotLike = None,
    *,
    construction: Literal["alignment", "distance"] = "alignment",
    contacts: Literal["side", "tip", "all"] = "all",
    collision_free: bool = True,
    cell: float | str | None = None,
    heading_step: float | str | None = None,
    load: Literal["normal", "vertical"] = "normal",
    regime: Regime = "auto",
    max_force: float | str | None = None,
    max_moment: float | str | None = None,
    max_slope: float | str | None = None,
) -> Preimage:
    """Tells which robot states explain a reading, or several at once, on a map; the heading is unknown.

    Parameters
    ----------
    {map}
    {readings}
    {robot}
    construction : {"alignment", "distance"}
        Whether the whisker is laid against the boundary, or every heading is taken.
    contacts : {"side", "tip", "all"}
        Which parts of the whisker may touch.
    collision_free : bool
        Whether states whose whisker passes through something solid are left out.
    cell : float or str, optional
        Side of the cells of places (m); None for a millimetre.
    heading_step : float or str, optional
        Spacing of the headings (rad); None for a degree.
    load, regime, max_force, max_moment, max_slope
        As in ``contact_set``.

    Returns
    -------
    Preimage
        Boxes of states, map frame (m, rad).

    Raises
    ------
    DataError
        Readings that no contact explains, or a fault in the map.
    UsageError
        A value out of range.
    """
    given = _listed(readings)
    model = _model(load, regime, max_force, max_moment, max_slope)
    shape = read_map(map)
    side = None if cell is None else number("cell", cell, "length")
    step = None if heading_step is None else number("heading_step", heading_step, "angle")
    found = _vibrissa.preimage(shape, given, robot_of(robot), model, construction, contacts, collision_free, side, step)
    return Preimage(**found, _map=shape)
