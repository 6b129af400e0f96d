"""The same jobs with Shapely: two curves of 200 points meet, and the strip of places around a boundary of two metres."""

import timeit

import numpy as np
from shapely import LineString, Polygon

EI, LENGTH, N = 2.8886e-4, 0.075, 200


def contact(force, s_a):
    """A contact under a normal load, by quadrature of the elastica: only to have the same curves."""
    t = np.linspace(0.0, s_a * np.sqrt(force / EI), 2001)
    u, du = np.zeros_like(t), 0.0
    h = t[1] - t[0]
    x = y = 0.0
    for i in range(1, t.size):
        middle = u[i - 1] + 0.5 * h * du
        du += h * np.cos(middle)
        u[i] = u[i - 1] + h * du
        x, y = x + h * np.cos(middle), y + h * np.sin(middle)
    phi = u[-1]
    scale = s_a / t[-1]
    return scale * (x * np.cos(phi) + y * np.sin(phi)), scale * (x * np.sin(phi) - y * np.cos(phi))


def per_call(job):
    count, total = timeit.Timer(job).autorange()
    return total / count


load = LineString([contact(0.1, s) for s in np.linspace(1e-3 * LENGTH, LENGTH, N)])
strip = LineString([contact(f, 0.06) for f in np.linspace(1e-4, 0.5, N)])
print(f"intersection of two curves of {N} points: {per_call(lambda: load.intersection(strip)) * 1e6:.1f} us")
room = Polygon([(0, 0), (0.5, 0), (0.5, 0.5), (0, 0.5)])
reach = max(np.hypot(x, y) for x, y in load.coords)
print(f"strip of places, no headings, no collisions: {per_call(lambda: room.exterior.buffer(reach).intersection(room)) * 1e3:.3f} ms")
