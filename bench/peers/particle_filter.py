"""Global localization from touches: the particle filter of `particles` beside our probabilistic method, on the same sweep."""

import json
import math
import statistics
import sys

import numpy as np
import particles
from room import ERROR, Sweep, edges, inside, run
from timing import once, row

TABLE = "Localization with weights"
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


class Touched(particles.FeynmanKac):
    """The state is the pose at the first touch; every touch is a point of the walls.

    The touches are sharp for so few particles, so that likelihood and jitter are wide at first and narrow as touches come in.
    """

    def __init__(self, points, walls):
        super().__init__(T=len(points))
        self.points = points
        self.far, self.x, self.y, self.free = walls

    def M0(self, N):
        k = np.random.choice(self.free, N)
        shift = np.random.uniform(-0.5, 0.5, (2, N)) * CELL
        return np.c_[self.x[k] + shift[0], self.y[k] + shift[1], np.random.uniform(-np.pi, np.pi, N)]

    def M(self, t, xp):
        return xp + np.random.normal(size=xp.shape) * 0.2 * self.width(t) * [1.0, 1.0, 5.0]

    def logG(self, t, xp, x):
        u, v = self.points[t]
        cos, sin = np.cos(x[:, 2]), np.sin(x[:, 2])
        column = np.clip(((x[:, 0] + cos * u - sin * v + 0.02) / CELL).astype(int), 0, COLUMNS - 1)
        row = np.clip(((x[:, 1] + sin * u + cos * v + 0.02) / CELL).astype(int), 0, ROWS - 1)
        return -0.5 * (self.far[row * COLUMNS + column] / self.width(t)) ** 2

    def width(self, t):
        """Standard deviation of a touch (m)."""
        return max(2 * ERROR, 0.03 * 0.97**t)


def ours(sweep, count):
    """Our probabilistic method on as many rows: processor time a row, and the error at the last one (m)."""
    out = sweep.folder / "probabilistic"
    log = sweep.short_log(count)
    time = run("localize", log, "--map", sweep.map(), "--robot", sweep.folder / "robot.toml", "--method", "probabilistic", "--out", out)
    found = json.loads((out / "result.json").read_text(encoding="utf-8"))
    x, y, _ = sweep.poses[sweep.chosen(count)[-1][0]]
    estimate = found["estimate"]
    return time / count, math.hypot(estimate["x"] - x, estimate["y"] - y) if estimate else math.nan, found["status"]


def main():
    short, sweep = "--short" in sys.argv, Sweep()
    count = 200
    answers = [ours(sweep, count) for _ in range(1 if short else 3)]
    remark = f"the whole command by its {count} rows; {answers[0][2]}, error {1e3 * answers[0][1]:.2f} mm"
    row(TABLE, "vibrissa: probabilistic, a row", [time for time, *_ in answers], remark)
    walls, points, truth = field(), sweep.points(count), sweep.truth(count)
    for size in (1000, 10_000, 100_000)[: 2 if short else 3]:
        times, errors = [], []
        for trial in range(2 if short else 5):
            np.random.seed(trial)
            smc = particles.SMC(fk=Touched(points, walls), N=size, resampling="systematic", ESSrmin=0.5)
            times.append(once(smc.run)[1] / len(points))
            mean = np.average(smc.X[:, :2], weights=smc.W, axis=0)
            errors.append(1e3 * math.hypot(mean[0] - truth[0], mean[1] - truth[1]))
        remark = f"told the places touched; error of the mean {statistics.median(errors):.1f} mm (median), {max(errors):.1f} mm (worst)"
        row(TABLE, f"particles: {size} particles, a row", times, remark)


if __name__ == "__main__":
    main()
