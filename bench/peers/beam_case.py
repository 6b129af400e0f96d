"""The whisker and the load of the beam's peers, and the exact answer: `scipy_beam.py`'s closed form."""

import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "beam"))
from scipy_beam import EI, LENGTH, by_jacobi, by_march  # noqa: E402, F401

YOUNG, FORCE, S_A = 52e9, 0.25, 0.06
RADIUS = (4 * EI / YOUNG / np.pi) ** 0.25
DENSITY = 6450.0
TABLE = "One bent whisker (normal load of 0.25 N at 60 mm of 75 mm)"


def error(x, y):
    """How far a contact point is from the true one, told for people."""
    true_x, true_y, _ = by_jacobi(FORCE, S_A)
    return f"contact off by {np.hypot(x - true_x, y - true_y) / LENGTH:.1e} of the length"
