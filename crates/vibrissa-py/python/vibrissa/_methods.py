"""The methods of localization with their options."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypedDict


@dataclass(frozen=True)
class Deterministic:
    """The paper's intersection of discretised preimages; None takes the default."""

    tip_load: Literal["boundary-normal", "whisker-normal"] | None = None
    """Which way the force acts at the tip."""
    boundary_spacing: float | None = None
    """Spacing of the points along the boundary at which the whisker is aligned (m)."""
    history_shapes: int | None = None
    """Whisker shapes that estimate the boundary's slope, 2 to 5."""
    history_travel: float | None = None
    """Travel of the whisker's base from the first to the last of these shapes (m)."""
    update_travel: float | None = None
    """Travel of the whisker's base between two updates (m)."""
    tolerance: float | None = None
    """How far a candidate may lie from an observation (standard deviations)."""
    missed_share: float | None = None
    """Share of observations that a candidate may miss."""


@dataclass(frozen=True)
class Possibilistic:
    """Guaranteed bounds on the state: what is outside is ruled out; None takes the default."""

    heading_error: float | None = None
    """Bound on the error of absolute headings (rad)."""
    tolerate: int | None = None
    """How many readings may break their bounds."""
    largest_slope: float | None = None
    """Largest slope of the whisker at its contact (rad)."""
    work: int | None = None
    """Cells that are looked at for each row."""
    last_work: int | None = None
    """The same once more at the end of the log."""
    two_contacts: float | None = None
    """Reckon with two contacts where the whisker is within this of a second boundary (m)."""


@dataclass(frozen=True)
class Probabilistic:
    """Least squares over all readings without a prior; None takes the default."""

    heading_error: float | None = None
    """Bound on the error of absolute headings (rad)."""
    seed_spacing: float | None = None
    """Spacing along the boundary of the first hypotheses (m)."""
    seed_turn: float | None = None
    """Spacing of their headings (rad)."""
    seed_travel: float | None = None
    """Travel of the whisker's base in contact before the first hypotheses (m)."""
    shared_gain: float | None = None
    """Standard deviation of a relative error that all readings share."""
    tolerated_share: float | None = None
    """Share of readings that may be false."""
    noise_model: Literal["independent", "correlated"] | None = None
    """How the readings' errors hang together."""
    undeclared: Literal["typical", "none"] | None = None
    """What is taken for errors that the robot does not bound."""


METHODS: dict[type, str] = {
    Deterministic: "deterministic",
    Possibilistic: "possibilistic",
    Probabilistic: "probabilistic",
}
"""The word of each."""


class Options(TypedDict, total=False):
    """The options of all methods by name, for calls without a group; ``vibrissa localize --help`` explains each."""

    tip_load: Literal["boundary-normal", "whisker-normal"] | None
    boundary_spacing: float | None
    history_shapes: int | None
    history_travel: float | None
    update_travel: float | None
    tolerance: float | None
    missed_share: float | None
    heading_error: float | None
    tolerate: int | None
    largest_slope: float | None
    work: int | None
    last_work: int | None
    two_contacts: float | None
    seed_spacing: float | None
    seed_turn: float | None
    seed_travel: float | None
    shared_gain: float | None
    tolerated_share: float | None
    noise_model: Literal["independent", "correlated"] | None
    undeclared: Literal["typical", "none"] | None
