"""Robots and their whiskers."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _vibrissa
from ._errors import Error, UsageError

# Where numbers are lengths and the like they may be texts with their unit, such as "75 mm".
_LONGEST_WHISKER = 5.0
_FARTHEST_MOUNT = 100.0


def quantities(record: object, dimensions: Mapping[str, str | tuple[str, ...]]) -> None:
    """Turns the texts among a frozen record's fields into numbers (SI)."""
    for name, dimension in dimensions.items():
        given = getattr(record, name)
        if isinstance(dimension, tuple) and not isinstance(given, str):
            found: object = tuple(
                quantity(name, one, kind) for one, kind in zip(given, dimension, strict=True)
            )
        else:
            found = quantity(name, given, dimension if isinstance(dimension, str) else "length")
        object.__setattr__(record, name, found)


def quantity(name: str, given: object, dimension: str) -> object:
    if not isinstance(given, str):
        return given
    try:
        return _vibrissa.quantity(given, dimension)
    except Error as error:
        raise UsageError(f"{name}: {error}") from None


def number(name: str, given: float | str, dimension: str) -> float:
    """A number, or a text with its unit, as a number (SI)."""
    found = quantity(name, given, dimension)
    if not isinstance(found, (int, float, np.floating, np.integer)):
        raise TypeError(f"{name}: {given!r} is no number and no text with a unit")
    return float(found)


def _plausible(name: str, value: float, largest: float) -> None:
    """Refuses lengths (m) that are almost certainly millimetres."""
    if abs(value) > largest:
        raise UsageError(
            f"{name}: {value} m (allowed: up to {largest:g} m)\n  help: lengths are metres; write \"{value:g} mm\""
        )


_DEFAULT = _vibrissa.robot_default()
_MOUNTED: dict[str, Any] = _DEFAULT["whiskers"][0]
_BEAM: dict[str, Any] = _MOUNTED["beam"]


@dataclass(frozen=True)
class Segment:
    """A stretch of a whisker: one wire, which may narrow linearly."""

    length: float
    """Arc length (m)."""
    flexural_rigidity: float
    """Flexural rigidity E I where it begins, seen from the base (N m²)."""
    tip_ratio: float = 1.0
    """Radius at its end over radius at its beginning."""
    diameter: float | None = None
    """Diameter where it begins (m), for strains only."""

    if TYPE_CHECKING:

        def __init__(
            self,
            length: float | str,
            flexural_rigidity: float | str,
            tip_ratio: float = ...,
            diameter: float | str | None = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        quantities(self, {"length": "length", "flexural_rigidity": "rigidity", "diameter": "length"})
        _plausible("length", self.length, _LONGEST_WHISKER)


@dataclass(frozen=True)
class Whisker:
    """A thin elastic beam on a base; the default is the paper's: 75 mm of straight Nitinol wire, clamped.

    Numbers are SI; a text carries its unit: ``Whisker(length="75 mm")``.

    Raises
    ------
    UsageError
        A unit that does not fit, or a length above 5 m.
    """

    length: float = _BEAM["length"]
    """Arc length from base to tip (m)."""
    flexural_rigidity: float = _BEAM["flexural_rigidity"]
    """Flexural rigidity E I at the base (N m²)."""
    tip_ratio: float = _BEAM["tip_ratio"]
    """Tip radius over base radius, 0.001 to 1."""
    curvature: float = _BEAM["curvature"]
    """Curvature at rest at the base (1/m)."""
    curvature_rise: tuple[float, ...] = ()
    """Coefficients of s, s², … of the curvature at rest (1/m², 1/m³, …)."""
    base_stiffness: float = _BEAM["base_stiffness"]
    """Rotational stiffness of the base (N m/rad); infinite when clamped."""
    segments: tuple[Segment, ...] = ()
    """Several wires in a row; when there are any, they say length, rigidity and taper."""
    diameter: float | None = _BEAM["diameter"]
    """Diameter of the wire at the base (m), for strains only."""
    strain_limit: float = _BEAM["strain_limit"]
    """Strain of the surface up to which the whisker springs back."""

    if TYPE_CHECKING:

        def __init__(
            self,
            length: float | str = ...,
            flexural_rigidity: float | str = ...,
            tip_ratio: float = ...,
            curvature: float | str = ...,
            curvature_rise: tuple[float, ...] = ...,
            base_stiffness: float | str = ...,
            segments: tuple[Segment, ...] = ...,
            diameter: float | str | None = ...,
            strain_limit: float = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        units = {"length": "length", "flexural_rigidity": "rigidity", "base_stiffness": "stiffness"}
        quantities(self, {**units, "diameter": "length", "curvature": "curvature"})
        _plausible("length", self.length, _LONGEST_WHISKER)

    @property
    def is_uniform(self) -> bool:
        """Whether the closed form covers it: one wire, no taper, straight at rest, clamped."""
        return _vibrissa.whisker_is_uniform(self)

    @classmethod
    def _of(cls, fields: dict[str, Any]) -> Whisker:
        segments = tuple(Segment(*segment) for segment in fields["segments"])
        return cls(**{**fields, "segments": segments, "curvature_rise": tuple(fields["curvature_rise"])})


@dataclass(frozen=True)
class MountedWhisker:
    """A whisker on a robot; the default is the paper's at the robot's origin, pointing forward."""

    name: str = _MOUNTED["name"]
    """The name that prefixes the log's columns where there are several."""
    beam: Whisker = Whisker()
    """The beam."""
    mount: tuple[float, float, float] = _MOUNTED["mount"]
    """robot_from_whisker: x (m), y (m), theta (rad)."""
    elevation: float = _MOUNTED["elevation"]
    """Angle of its axis above the horizontal (rad); the deterministic and the possibilistic method take other values than 0."""
    roll: float = _MOUNTED["roll"]
    """Turn of its sensor about the axis (rad), from left towards up; likewise."""
    friction: float = _MOUNTED["friction"]
    """Bound on the Coulomb coefficient at the contact."""
    calibration: str | None = None
    """The calibration file that turns flux or counts into moments, for logs that hold those."""
    moment_relative: float = _MOUNTED["moment_relative"]
    """Bound on a moment's error relative to the reading."""
    moment_absolute: float = _MOUNTED["moment_absolute"]
    """Bound on a moment's error at zero (N m)."""
    force_relative: float = _MOUNTED["force_relative"]
    """Bound on a contact force's error relative to the reading, where one is read."""
    force_absolute: float = _MOUNTED["force_absolute"]
    """Bound on a contact force's error at zero (N)."""
    slope_relative: float = _MOUNTED["slope_relative"]
    """Bound on an end slope's error relative to the reading, where one is read."""
    slope_absolute: float = _MOUNTED["slope_absolute"]
    """Bound on an end slope's error at zero (rad)."""
    zero_error: float = _MOUNTED["zero_error"]
    """Bound on the moment that is read while the whisker is free (N m)."""
    zero_drift_error: float = _MOUNTED["zero_drift_error"]
    """Bound on how fast that changes (N m/s)."""
    mount_error: tuple[float, float, float] = _MOUNTED["mount_error"]
    """Bounds on the errors of the mount: x (m), y (m), theta (rad)."""
    length_error: float = _MOUNTED["length_error"]
    """Bound on the error of the length (m)."""
    stiffness_error: float = _MOUNTED["stiffness_error"]
    """Bound on the error of the flexural rigidity, relative to it."""
    gain_error: float = _MOUNTED["gain_error"]
    """Bound on the error of the readings' gain, relative to it."""

    if TYPE_CHECKING:

        def __init__(
            self,
            name: str = ...,
            beam: Whisker = ...,
            mount: tuple[float | str, float | str, float | str] = ...,
            elevation: float | str = ...,
            roll: float | str = ...,
            friction: float = ...,
            calibration: str | None = ...,
            moment_relative: float | str = ...,
            moment_absolute: float | str = ...,
            force_relative: float | str = ...,
            force_absolute: float | str = ...,
            slope_relative: float | str = ...,
            slope_absolute: float | str = ...,
            zero_error: float | str = ...,
            zero_drift_error: float | str = ...,
            mount_error: tuple[float | str, float | str, float | str] = ...,
            length_error: float | str = ...,
            stiffness_error: float | str = ...,
            gain_error: float | str = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        name: object = self.name
        if not isinstance(name, str):
            raise UsageError(f"name: {name!r} is no text\nhelp: name the arguments: MountedWhisker(beam=Whisker(), mount=(0, 0, 0))")
        pose = ("length", "length", "angle")
        quantities(self, {"elevation": "angle", "roll": "angle"})
        quantities(self, {"mount": pose, "mount_error": pose, "length_error": "length", "zero_error": "moment"})
        ratios = ("moment_relative", "force_relative", "slope_relative", "stiffness_error", "gain_error")
        quantities(self, {name: "ratio" for name in ratios})
        quantities(self, {"moment_absolute": "moment", "force_absolute": "force", "slope_absolute": "angle"})
        quantities(self, {"zero_drift_error": "moment_rate"})
        for value in self.mount[:2]:
            _plausible("mount", value, _FARTHEST_MOUNT)

    @classmethod
    def _of(cls, fields: dict[str, Any]) -> MountedWhisker:
        return cls(**{**fields, "beam": Whisker._of(fields["beam"])})


@dataclass(frozen=True)
class Robot:
    """A robot: whiskers, and bounds on its odometry's errors; the default is the paper's sensor on its stage."""

    whiskers: tuple[MountedWhisker, ...] = (MountedWhisker(),)
    """The whiskers, at least one."""
    translation_relative: float = _DEFAULT["translation_relative"]
    """Bound on the error of each translation increment, relative to it."""
    rotation_relative: float = _DEFAULT["rotation_relative"]
    """Bound on the error of each rotation increment, relative to it."""
    delay_error: float = _DEFAULT["delay_error"]
    """Bound on how much earlier or later than the odometry readings are taken (s)."""
    map_scale_error: float = _DEFAULT["map_scale_error"]
    """Bound on the error of the map's scale, relative to it."""

    if TYPE_CHECKING:

        def __init__(
            self,
            whiskers: tuple[MountedWhisker, ...] = ...,
            translation_relative: float | str = ...,
            rotation_relative: float | str = ...,
            delay_error: float | str = ...,
            map_scale_error: float | str = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        given: Any = self.whiskers
        listed = (given,) if isinstance(given, Whisker | MountedWhisker) else tuple(given)
        mounted = tuple(MountedWhisker(beam=one) if isinstance(one, Whisker) else one for one in listed)
        for one in mounted:
            if not isinstance(one, MountedWhisker):
                raise UsageError(f"whiskers: {one!r} is no whisker (allowed: MountedWhisker, or Whisker at the robot's origin)")
        object.__setattr__(self, "whiskers", mounted)
        ratios = ("translation_relative", "rotation_relative", "map_scale_error")
        quantities(self, {**{name: "ratio" for name in ratios}, "delay_error": "time"})

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Robot:
        """The robot of a .toml file."""
        return cls._of(_vibrissa.robot_read(path))

    @classmethod
    def from_toml(cls, text: str, name: str = "robot.toml") -> Robot:
        """The robot of a TOML text; ``name`` stands for the file in messages."""
        return cls._of(_vibrissa.robot_parse(text, name))

    def to_toml(self) -> str:
        """The robot as the text of its file, which reads back the same."""
        return _vibrissa.robot_toml(self)

    @classmethod
    def _of(cls, fields: dict[str, Any]) -> Robot:
        return cls(**{**fields, "whiskers": tuple(MountedWhisker._of(one) for one in fields["whiskers"])})


RobotLike = Robot | Whisker | MountedWhisker | str | os.PathLike[str] | None


def robot_of(robot: RobotLike) -> Robot:
    """A robot, the file of one, a whisker alone, or the paper's robot for None."""
    if robot is None:
        return Robot()
    if isinstance(robot, Robot):
        return robot
    if isinstance(robot, Whisker):
        return Robot(whiskers=(MountedWhisker(beam=robot),))
    if isinstance(robot, MountedWhisker):
        return Robot(whiskers=(robot,))
    if not isinstance(robot, (str, os.PathLike)):
        raise UsageError(f"robot: {_shown(robot)} {_ROBOTS}{_meant_by(robot)}")
    if isinstance(robot, str) and not os.path.exists(robot) and _is_length(robot):
        raise UsageError(f"robot: {robot!r} is a length {_ROBOTS}{_meant_by(robot)}")
    return Robot.read(robot)


_ROBOTS = "(allowed: the name of a robot file (.toml), a Robot, a Whisker, a MountedWhisker, or None for the paper's robot)"


def _shown(given: object) -> str:
    words = repr(given)
    return words if len(words) <= 60 else type(given).__name__


def _is_length(text: str) -> bool:
    try:
        _vibrissa.quantity(text, "length")
    except Error:
        return False
    return True


def _meant_by(given: object) -> str:
    """What a caller may have meant that gave this for a robot."""
    if isinstance(given, (str, int, float)) and not isinstance(given, bool):
        return f"\n  help: for a whisker of this length write robot=Whisker(length={given!r})"
    if isinstance(given, (list, tuple)):
        return "\n  help: for several whiskers write robot=Robot(whiskers=[MountedWhisker(…), …])"
    return ""
