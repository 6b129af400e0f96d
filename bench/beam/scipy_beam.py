"""The same loaded whiskers with SciPy: what a user would write today. Prints `name<TAB>median<TAB>least` lines, ns a shape.

Each function returns contact and slope of a uniform whisker under a normal load; `check` holds them against one another.
"""

import time

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import RectBivariateSpline
from scipy.optimize import brentq, fsolve
from scipy.special import ellipeinc, ellipj, ellipk

EI, LENGTH = 2.8886e-4, 0.075
QUARTER = float(ellipk(0.5))


def by_jacobi(force, s_a):
    """Jacobi functions of parameter 1/2 over the pendulum u'' = cos u, let go at u = 0."""
    t = s_a * np.sqrt(force / EI)
    sn, cn, dn, am = ellipj(t, 0.5)
    phi = 2.0 * np.arctan2(0.5 * (1.0 - cn), 0.5 * (1.0 + cn))
    along = sn / dn
    across = 2.0 * ellipeinc(am, 0.5) - t - sn * cn / dn
    c, s, r = np.cos(phi), np.sin(phi), s_a / t
    return r * (along * c + across * s), r * (along * s - across * c), phi


def by_march(force, s_a, rtol=1e-8, tip_ratio=1.0, curvature=0.0, base=np.inf):
    """The differential equation from the contact back to the base; any taper, rest curvature, elastic base."""

    def right_side(t, v):
        radius = 1.0 - (1.0 - tip_ratio) * (s_a - t) / LENGTH
        return [v[1] / (EI * radius**4) + curvature, force * np.cos(v[0]), np.cos(v[0]), np.sin(v[0])]

    u, m, a, b = solve_ivp(right_side, (0.0, s_a), [0.0] * 4, method="DOP853", rtol=rtol, atol=rtol * 1e-3).y[:, -1]
    u += m / base
    c, s = np.cos(u), np.sin(u)
    return a * c + b * s, a * s - b * c, u


def point(x, y):
    """Force and arc length by a root search over `by_jacobi`, from the small-angle guess."""
    start = [3.0 * EI * y / x**3, np.hypot(x, y) * 1.02]

    def miss(v):
        px, py, _ = by_jacobi(abs(v[0]), v[1])
        return [(px - x) / LENGTH, (py - y) / LENGTH]

    return fsolve(miss, start, xtol=1e-13)


def moment(m, s_a):
    """The force of the less bent shape, by a bracketed root."""
    scaled = m * s_a / EI

    def miss(t):
        sn, _, dn, _ = ellipj(t, 0.5)
        return t * sn / dn - scaled

    return EI * (brentq(miss, 1e-9, 2.3, xtol=1e-14) / s_a) ** 2


def tapered_point(x, y, start, tip_ratio):
    """Shooting: force and arc length of a tapered whisker from a neighbour's, by a root search over the march."""

    def miss(v):
        px, py, _ = by_march(v[0], v[1], 1e-8, tip_ratio)
        return [(px - x) / LENGTH, (py - y) / LENGTH]

    return fsolve(miss, start, xtol=1e-8)


def tapered_moment(m, s_a, tip_ratio, most):
    """Shooting: the force of the less bent shape, by a bracketed root over the march; it is below `most`."""

    def miss(force):
        x, y, phi = by_march(force, s_a, 1e-8, tip_ratio)
        return force * (x * np.cos(phi) + y * np.sin(phi)) - m

    return brentq(miss, 1e-9, most, xtol=1e-10)


def splines():
    """Five smooth quantities over a grid of 97 by 97, and places to read them at: values and both derivatives."""
    grid = np.linspace(0.0, 1.0, 97)
    u, v = np.meshgrid(grid, grid, indexing="ij")
    tables = [RectBivariateSpline(grid, grid, np.sin(k + 2.0 * u) * np.exp(v)) for k in range(5)]
    a, b = np.random.default_rng(2).uniform(0.0, 1.0, (2, 1024))
    return lambda: [table.ev(a, b, dx, dy) for table in tables for dx, dy in ((0, 0), (1, 0), (0, 1))]


def nanoseconds(call, shapes=1):
    """Median and least processor time of nine batches, each of at least 50 ms."""
    repeat = 1
    while True:
        start = time.process_time()
        for _ in range(repeat):
            call()
        if time.process_time() - start > 0.05:
            break
        repeat *= 2
    times = []
    for _ in range(9):
        start = time.process_time()
        for _ in range(repeat):
            call()
        times.append(time.process_time() - start)
    return [float(value) / repeat / shapes * 1e9 for value in (np.median(times), min(times))]


def check():
    a, b = by_jacobi(0.1, 0.06), by_march(0.1, 0.06, 1e-12)
    assert np.allclose(a, b, rtol=1e-9), (a, b)
    found = point(a[0], a[1])
    assert np.allclose(found, [0.1, 0.06], rtol=1e-9), found
    m = 0.1 * (a[0] * np.cos(a[2]) + a[1] * np.sin(a[2]))
    assert np.isclose(moment(m, 0.06), 0.1, rtol=1e-9)


def main():
    check()
    rng = np.random.default_rng(1)
    s_a = rng.uniform(0.02, 0.075, 100_000)
    force = 2.0 * EI * rng.uniform(0.0, 3.2, 100_000) / s_a**2
    x, y, phi = by_jacobi(0.1, 0.06)
    m = 0.1 * (x * np.cos(phi) + y * np.sin(phi))
    half = by_march(0.05, 0.06, 1e-8, 0.5)
    half_moment = 0.05 * (half[0] * np.cos(half[2]) + half[1] * np.sin(half[2]))
    assert np.isclose(tapered_moment(half_moment, 0.06, 0.5, 0.08), 0.05, rtol=1e-6)
    rows = {
        "force single": nanoseconds(lambda: by_jacobi(0.1, 0.06)),
        "force batch": nanoseconds(lambda: by_jacobi(force, s_a), 100_000),
        "moment single": nanoseconds(lambda: moment(m, 0.06)),
        "point single": nanoseconds(lambda: point(x, y)),
        "taper single": nanoseconds(lambda: by_march(0.05, 0.06, 1e-8, 0.5)),
        "taper 0.1 single": nanoseconds(lambda: by_march(0.01, 0.06, 1e-8, 0.1)),
        "taper 0.05 single": nanoseconds(lambda: by_march(0.008, 0.06, 1e-8, 0.05)),
        "taper 0.1 tip": nanoseconds(lambda: by_march(0.003, LENGTH, 1e-8, 0.1)),
        "taper 0.05 tip": nanoseconds(lambda: by_march(0.0008, LENGTH, 1e-8, 0.05)),
        "all three single": nanoseconds(lambda: by_march(0.04, 0.06, 1e-8, 0.4, 6.0, 0.3)),
        "all three tip": nanoseconds(lambda: by_march(0.0008, LENGTH, 1e-8, 0.05, 6.0, 0.3)),
        "taper point": nanoseconds(lambda: tapered_point(half[0] + 1e-4, half[1] - 1e-4, [0.05, 0.06], 0.5)),
        "taper moment": nanoseconds(lambda: tapered_moment(half_moment, 0.06, 0.5, 0.08)),
        "field batch": nanoseconds(splines(), 1024),
    }
    for name, (median, least) in rows.items():
        print(f"{name}\t{median:.1f}\t{least:.1f}")


if __name__ == "__main__":
    main()
