"""A room and eight touches along its walls, seen from the first pose: the easier question that the peers get.

They are told where the whisker was touched, within 2 mm, which ours finds from moments.
"""

import math
import random

WALLS = [(0.0, 0.0), (0.36, 0.0), (0.36, 0.09), (0.5, 0.09), (0.5, 0.0), (0.9, 0.0), (0.9, 0.3), (0.8, 0.38),
         (0.9, 0.5), (0.9, 0.7), (0.55, 0.7), (0.5, 0.6), (0.25, 0.6), (0.2, 0.7), (0.0, 0.7)]
TRUTH = (0.33, 0.05, 0.2)
ERROR = 2e-3


def edges():
    return list(zip(WALLS, WALLS[1:] + WALLS[:1]))


def nearest(x, y):
    """The nearest point of the walls."""
    best = None
    for (ax, ay), (bx, by) in edges():
        ex, ey = bx - ax, by - ay
        t = min(1.0, max(0.0, ((x - ax) * ex + (y - ay) * ey) / (ex * ex + ey * ey)))
        p = (ax + t * ex, ay + t * ey)
        d = math.hypot(p[0] - x, p[1] - y)
        best = min(best or (d, p), (d, p))
    return best


def inside(x, y):
    odd = False
    for (ax, ay), (bx, by) in edges():
        if (ay > y) != (by > y) and x < (bx - ax) * (y - ay) / (by - ay) + ax:
            odd = not odd
    return odd


def touches(count=8, seed=1):
    """Contact points in the frame of the first pose (m): round the pillar of the lower wall."""
    draw = random.Random(seed)
    way = [(0.33, 0.05), (0.32, 0.03), (0.33, 0.08), (0.35, 0.12), (0.4, 0.13), (0.46, 0.13), (0.52, 0.1), (0.55, 0.04)]
    cos, sin = math.cos(TRUTH[2]), math.sin(TRUTH[2])
    points = []
    for x, y in way[:count]:
        _, (px, py) = nearest(x, y)
        dx, dy = px - TRUTH[0] + draw.uniform(-1e-3, 1e-3), py - TRUTH[1] + draw.uniform(-1e-3, 1e-3)
        points.append((cos * dx + sin * dy, -sin * dx + cos * dy))
    return points
