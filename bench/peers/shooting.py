"""One bent whisker with SciPy and NumPy: closed form, march, shooting, a boundary value solver, a first-order march."""

import sys

import numpy as np
from beam_case import EI, FORCE, S_A, TABLE, by_jacobi, by_march, error
from scipy.integrate import solve_bvp, solve_ivp
from scipy.optimize import fsolve
from timing import batches, row


def shot():
    """From the base: curvature and slope at the contact are unknown, and the contact carries no moment."""

    def flight(unknown):
        curvature, phi_a = unknown
        pull = FORCE / EI

        def right_side(_, v):
            return [np.cos(v[2]), np.sin(v[2]), v[3], -pull * np.cos(v[2] - phi_a)]

        return solve_ivp(right_side, (0.0, S_A), [0.0, 0.0, 0.0, curvature], method="DOP853", rtol=1e-8, atol=1e-10).y[:, -1]

    def miss(unknown):
        end = flight(unknown)
        return [end[2] - unknown[1], end[3] * S_A]

    found = fsolve(miss, [40.0, 1.4], xtol=1e-10)
    return flight(found)[:2]


def boundary_values():
    """The same as a boundary value problem, lengths in s_a."""
    pull = FORCE * S_A**2 / EI

    def right_side(_, v, p):
        return np.vstack([np.cos(v[2]), np.sin(v[2]), v[3], -pull * np.cos(v[2] - p[0])])

    def ends(a, b, p):
        return np.array([a[0], a[1], a[2], b[3], b[2] - p[0]])

    s = np.linspace(0.0, 1.0, 11)
    guess = np.vstack([s, 0.4 * s**2, 1.2 * s, 1.2 * (1.0 - s)])
    end = solve_bvp(right_side, ends, s, guess, p=[1.2], tol=1e-5).sol(1.0)
    return S_A * end[0], S_A * end[1]


def first_order(nodes=101):
    """Steps of equal length from the contact back to the base, each with the moment where it begins."""
    h = S_A / (nodes - 1)
    x = y = u = 0.0
    for _ in range(nodes - 1):
        # In the frame of the contact the force acts across, so that the moment is the force times the way along.
        step = FORCE * x / EI * h
        x, y, u = x + h * np.cos(u), y + h * np.sin(u), u + step
    return x * np.cos(u) + y * np.sin(u), x * np.sin(u) - y * np.cos(u)


def main():
    peers = [
        ("SciPy, elliptic functions", lambda: by_jacobi(FORCE, S_A)[:2]),
        ("SciPy, march from the contact (DOP853)", lambda: by_march(FORCE, S_A)[:2]),
        ("SciPy, shooting (fsolve, DOP853)", shot),
        ("SciPy, solve_bvp", boundary_values),
        ("NumPy, first-order march, 101 nodes", first_order),
    ]
    for name, solve in peers:
        row(TABLE, name, batches(solve, count=3 if "--short" in sys.argv else 7), error(*solve()))


if __name__ == "__main__":
    main()
