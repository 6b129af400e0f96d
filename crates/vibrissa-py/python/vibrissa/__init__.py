"""Where a robot is, by touch: whisker mechanics and localization on NumPy arrays.

SI everywhere: m, rad, s, N, N m. Frames are right-handed, x forward, y left, angles counter-clockwise. The undeflected
whisker points along +x of its own frame; a push towards +y is a positive moment.

    answer = vibrissa.localize("sweep.csv", "arena.svg", method="possibilistic")
    bends = vibrissa.force_mode(force=[0.05, 0.1, 0.2], s_a=0.06)

Defaults are the library's own: None, or an argument left out, takes them. Every fault is a ``vibrissa.Error`` whose text
names thing, value, allowed range and the next step.
"""

from ._beam import Bend, Bends, Load, force_mode, moment_mode, point_mode, tip_mode
from ._calibrate import CalibrationReport, Taps, calibrate, taps
from ._command import run
from ._contact import (
    Alignment,
    Contacts,
    FilteredContacts,
    Misfit,
    Outline,
    Profile,
    SpaceContacts,
    contact,
    contact_in_space,
    profile,
    temporal_filter,
)
from ._errors import DataError, DataWarning, Error, MissingFileError, UsageError
from ._localize import (
    Consistency,
    Demo,
    Hypothesis,
    Localization,
    Method,
    Nuisance,
    OdometryEstimate,
    Remedy,
    Status,
    Steps,
    demo,
    localize,
)
from ._localizer import Estimate, Localizer
from ._mapping import Closure, MappedLog, Share, Visit, WallChange, map_log
from ._methods import Deterministic, Possibilistic, Probabilistic
from ._plan import Exploration, MadeMotion, Motion, MotionLimits, Plan, explore, plan
from ._readings import ContactCurves, ContactSets, Meeting, Preimage, Reading, contact_set, preimage
from ._robot import MountedWhisker, Robot, Segment, Whisker
from ._simulate import Simulation, Touches, simulate, sweep, waypoints
from ._trajectory import Trajectory, TrajectoryError
from ._types import Event, Progress
from ._vibrissa import Calibration, Map, Scenario, SensorLog, __version__
from ._world import arena

__all__ = [
    "Alignment",
    "Bend",
    "Bends",
    "Calibration",
    "CalibrationReport",
    "Closure",
    "Consistency",
    "ContactCurves",
    "ContactSets",
    "Contacts",
    "DataError",
    "DataWarning",
    "Demo",
    "Deterministic",
    "Error",
    "Estimate",
    "Event",
    "Exploration",
    "FilteredContacts",
    "Hypothesis",
    "Load",
    "Localization",
    "Localizer",
    "MadeMotion",
    "Map",
    "MappedLog",
    "Meeting",
    "Method",
    "Misfit",
    "MissingFileError",
    "Motion",
    "MotionLimits",
    "MountedWhisker",
    "Nuisance",
    "OdometryEstimate",
    "Outline",
    "Plan",
    "Possibilistic",
    "Preimage",
    "Probabilistic",
    "Profile",
    "Progress",
    "Reading",
    "Remedy",
    "Robot",
    "Scenario",
    "Segment",
    "SensorLog",
    "Share",
    "Simulation",
    "SpaceContacts",
    "Status",
    "Steps",
    "Taps",
    "Touches",
    "Trajectory",
    "TrajectoryError",
    "UsageError",
    "Visit",
    "WallChange",
    "Whisker",
    "__version__",
    "arena",
    "calibrate",
    "contact",
    "contact_in_space",
    "contact_set",
    "demo",
    "explore",
    "force_mode",
    "localize",
    "map_log",
    "moment_mode",
    "plan",
    "point_mode",
    "preimage",
    "profile",
    "run",
    "simulate",
    "sweep",
    "taps",
    "temporal_filter",
    "tip_mode",
    "waypoints",
]
