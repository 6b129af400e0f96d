"""Global localization from touches with the particle filter of `particles`: time of an update and the error at the end.

Prints `name <tab> median s <tab> least <tab> largest <tab> remark`.
"""

import math
import statistics
import sys
import time

import numpy as np
import particles
from room import ERROR, TRUTH, edges, inside, touches

CELL = 0.004
COLUMNS, ROWS = 235, 185


def field():
    """Distance to the walls and free cells on a grid."""
    y, x = np.mgrid[0:ROWS, 0:COLUMNS]
    x, y = -0.02 + (x + 0.5) * CELL, -0.02 + (y + 0.5) * CELL
    far = np.full(x.shape, 9.0)
    for (ax, ay), (bx, by) in edges():
        ex, ey = bx - ax, by - ay
        t = np.clip(((x - ax) * ex + (y - ay) * ey) / (ex * ex + ey * ey), 0, 1)
        far = np.minimum(far, np.hypot(x - ax - t * ex, y - ay - t * ey))
    free = [k for k, (u, v) in enumerate(zip(x.ravel(), y.ravel())) if inside(u, v)]
    return far.ravel(), x.ravel(), y.ravel(), np.array(free)


FAR, X, Y, FREE = field()


class Touched(particles.FeynmanKac):
    def __init__(self, points):
        super().__init__(T=len(points))
        self.points = points

    def M0(self, N):
        k = np.random.choice(FREE, N)
        shift = np.random.uniform(-0.5, 0.5, (2, N)) * CELL
        return np.c_[X[k] + shift[0], Y[k] + shift[1], np.random.uniform(-np.pi, np.pi, N)]

    def M(self, t, xp):
        return xp + np.random.normal(size=xp.shape) * [1e-3, 1e-3, 0.02]

    def logG(self, t, xp, x):
        u, v = self.points[t]
        cos, sin = np.cos(x[:, 2]), np.sin(x[:, 2])
        column = np.clip(((x[:, 0] + cos * u - sin * v + 0.02) / CELL).astype(int), 0, COLUMNS - 1)
        row = np.clip(((x[:, 1] + sin * u + cos * v + 0.02) / CELL).astype(int), 0, ROWS - 1)
        return -0.5 * (FAR[row * COLUMNS + column] / (2 * ERROR)) ** 2


def main():
    points = touches()
    for count in (1000, 10_000, 100_000)[: 2 if "--short" in sys.argv else 3]:
        times, errors = [], []
        for trial in range(5):
            np.random.seed(trial)
            smc = particles.SMC(fk=Touched(points), N=count, resampling="systematic", ESSrmin=0.5)
            begin = time.process_time()
            smc.run()
            times.append((time.process_time() - begin) / len(points))
            mean = np.average(smc.X[:, :2], weights=smc.W, axis=0)
            errors.append(1e3 * math.hypot(mean[0] - TRUTH[0], mean[1] - TRUTH[1]))
        remark = f"an update; error of the mean {statistics.median(errors):.1f} mm (median), {max(errors):.1f} mm (worst)"
        print(f"particles: {count} particles", statistics.median(times), min(times), max(times), remark, sep="\t")


if __name__ == "__main__":
    main()
