"""Parameters that several functions share, described once, as by SciPy's and pandas' decorators of docstrings."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any, TypeVar

_Function = TypeVar("_Function", bound=Callable[..., Any])

_PARAMETERS = {
    "format": "format : str, optional\n    The format of files that are not ours.",
    "limits": (
        "limits : MotionLimits, optional\n    What the robot can do, and how motions are judged: "
        '``limits=vibrissa.MotionLimits(footprint="15 mm")``.'
    ),
    "log": "log : SensorLog or path\n    Odometry and readings.",
    "map": "map : Map or path\n    The map: .geojson (m), .svg (mm), .dxf, .yaml or .mcap.",
    "method": (
        "method : str, Deterministic, Possibilistic or Probabilistic\n    The estimator by name, or with its options: "
        "``method=vibrissa.Possibilistic(tolerate=3)``."
    ),
    "progress": "progress : callable, optional\n    See ``Progress``.",
    "readings": "readings : Reading or sequence of Reading\n    What the sensors read.",
    "reference": (
        "reference : str, optional\n    The sensor that feels the ambient field alone and is subtracted."
    ),
    "robot": (
        "robot : Robot, Whisker, path or None\n    The robot, its file, a whisker at the robot's origin, or None for "
        "the paper's."
    ),
    "scenario": "scenario : Scenario or path\n    The scenario, or its .toml file.",
    "spacing": (
        "spacing : float, optional\n    Readings are merged into one step while the base is nearer than this to "
        "their mean (m)."
    ),
    "within": (
        "within : sequence of six floats, optional\n    Where the robot is at the first row: least and largest x, y "
        "(m) and heading (rad)."
    ),
}


def documented(function: _Function) -> _Function:
    """Puts the shared descriptions in the place of names in braces that stand alone in a line of the docstring."""

    def described(match: re.Match[str]) -> str:
        return "\n".join(match["indent"] + line for line in _PARAMETERS[match["name"]].split("\n"))

    if function.__doc__ is not None:  # none under `python -OO`
        function.__doc__ = re.sub(r"(?m)^(?P<indent> +)\{(?P<name>\w+)\}$", described, function.__doc__)
    return function
