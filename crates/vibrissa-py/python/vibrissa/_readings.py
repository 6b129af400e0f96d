"""What readings of virtual sensors can mean: contacts, and robot states on a map."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

from . import _vibrissa
from ._arrays import Floats
from ._robot import RobotLike, robot_of
from ._show import Shown
from ._world import MapLike, read_map

Sensor = Literal["load", "strip", "slope", "moment"]
Regime = Literal["auto", "small", "large"]


@dataclass(frozen=True)
class Reading:
    """A reading of a virtual sensor: load (N), strip (m), slope (rad) or moment (N m)."""

    sensor: Sensor
    """Which sensor read."""
    value: float | tuple[float, float]
    """What it read, or the least and largest value that the true one may have."""
    tolerance: float = 0.0
    """Bound on the error of a value that is one number."""
    whisker: str | None = None
    """The whisker by name; None for the robot's first."""

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


def _model(
    load: str, regime: str, max_force: float | None, max_moment: float | None, max_slope: float | None
) -> Model:
    limits = [math.inf if limit is None else limit for limit in (max_force, max_moment, max_slope)]
    return Model(load, regime, *limits)


def contact_set(
    readings: Reading | Sequence[Reading],
    robot: RobotLike = None,
    *,
    load: Literal["normal", "vertical"] = "normal",
    regime: Regime = "auto",
    max_force: float | None = None,
    max_moment: float | None = None,
    max_slope: float | None = None,
) -> ContactSets:
    """Tells which contacts explain a reading, or several readings at once.

    regime: how moments are read. max_force (N), max_moment (N m), max_slope (rad): what the whisker bears; None for no limit.
    """
    given = [readings] if isinstance(readings, Reading) else list(readings)
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


def preimage(
    map: MapLike,
    readings: Reading | Sequence[Reading],
    robot: RobotLike = None,
    *,
    construction: Literal["alignment", "distance"] = "alignment",
    contacts: Literal["side", "tip", "all"] = "all",
    collision_free: bool = True,
    cell: float | None = None,
    heading_step: float | None = None,
    load: Literal["normal", "vertical"] = "normal",
    regime: Regime = "auto",
    max_force: float | None = None,
    max_moment: float | None = None,
    max_slope: float | None = None,
) -> Preimage:
    """Tells which robot states explain a reading, or several at once, on a map; the heading is unknown.

    construction: "alignment" lays the whisker against the boundary, "distance" takes every heading. contacts: which parts of
    the whisker may touch. cell (m) and heading_step (rad): the grid; None for a millimetre and a degree. The other
    arguments are those of ``contact_set``.
    """
    given = [readings] if isinstance(readings, Reading) else list(readings)
    model = _model(load, regime, max_force, max_moment, max_slope)
    found = _vibrissa.preimage(
        read_map(map), given, robot_of(robot), model, construction, contacts, collision_free, cell, heading_step
    )
    return Preimage(**found)
