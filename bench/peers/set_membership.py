"""The poses that explain K touches, with guarantees: our possibilistic method and Codac's contractors, on the same readings.

Codac is told the places touched within 2 mm and paves to 2 mm and 1 degree; ours gets the moments and its defaults. Codac
bounds the pose at the first touch, ours the one at the last: known motion lies between them, so that areas compare.
"""

import csv
import math
import sys

import codac
import numpy as np
from room import BOX, ERROR, Sweep, edges, run
from timing import once, point, row

# Headings in metres, so that one precision serves 2 mm and 1 degree.
TURN = math.radians(1.0) / 0.002
TABLE = "Localization with guarantees"


def contractor(points, split):
    wall = None
    for a, b in edges(split):
        corner = [codac.IntervalVector([[p[0], p[0]], [p[1], p[1]]]) for p in (a, b)]
        one = codac.CtcSegment(*corner)
        wall = one if wall is None else wall | one
    everything = None
    for u, v in points:
        x = codac.VectorVar(3)
        p, q = codac.Interval(u - ERROR, u + ERROR), codac.Interval(v - ERROR, v + ERROR)
        cos, sin = codac.cos(TURN * x[2]), codac.sin(TURN * x[2])
        place = codac.AnalyticFunction([x], [x[0] + cos * p - sin * q, x[1] + sin * p + cos * q])
        one = codac.CtcInverse(place, wall)
        everything = one if everything is None else everything & one
    return everything


def area(boxes):
    """The area that boxes (x, y, theta, six numbers each) cover on the plane (m²), counted in cells of half a millimetre."""
    cell = 0.5e-3
    low = boxes[:, [0, 2]].min(axis=0)
    size = np.ceil((boxes[:, [1, 3]].max(axis=0) - low) / cell).astype(int) + 1
    covered = np.zeros(size, bool)
    i0, i1 = (np.floor((boxes[:, k] - low[0]) / cell).astype(int) for k in (0, 1))
    j0, j1 = (np.floor((boxes[:, k] - low[1]) / cell).astype(int) for k in (2, 3))
    for a, b, c, d in zip(i0, i1, j0, j1):
        covered[a : b + 1, c : d + 1] = True
    return covered.sum() * cell * cell


def told(boxes, truth, size=None):
    """How large a set is and whether it holds the truth; `size` is what was told of its area and volume, if the boxes only enclose it."""
    span = boxes[:, 1::2] - boxes[:, 0::2]
    square, volume = size or (area(boxes), np.prod(span, axis=1).sum())
    turn = (truth[2] + math.pi) % (2 * math.pi) - math.pi
    held = any(
        np.any((boxes[:, 0] <= truth[0]) & (truth[0] <= boxes[:, 1]) & (boxes[:, 2] <= truth[1]) & (truth[1] <= boxes[:, 3])
               & (boxes[:, 4] <= turn + whole) & (turn + whole <= boxes[:, 5]))
        for whole in (-2 * math.pi, 0.0, 2 * math.pi)
    )
    return (f"{len(boxes)} boxes, {1e4 * square:.3g} cm² of the plane, volume {volume:.3g} m² rad, "
            f"truth {'inside' if held else 'LOST'}")


def paved(sweep, count, precision, split=1, repeat=1):
    """Codac's boxes and its processor times."""
    start = codac.IntervalVector([*BOX, [-math.pi / TURN, math.pi / TURN]])
    times = []
    for _ in range(repeat):
        contract = contractor(sweep.points(count), split)
        paving, time = once(lambda: codac.pave(start, contract, precision))
        times.append(time)
    boxes = [[side for i in range(3) for side in (b[i].lb(), b[i].ub())] for b in paving.boxes(codac.PavingOut.outer)]
    return np.array(boxes) * [1, 1, 1, 1, TURN, TURN], times


def ours(sweep, count, split=1, repeat=1):
    """Boxes around our slanted cells, the cells' area and volume, and the processor times of the whole command."""
    out = sweep.folder / "ours"
    inputs = [sweep.short_log(count), "--map", sweep.map(split), "--robot", sweep.folder / "robot.toml"]
    times = [run("localize", *inputs, "--method", "possibilistic", "--out", out) for _ in range(repeat)]
    with open(out / "states.csv", encoding="utf-8") as file:
        boxes = [[float(v) for v in list(line.values())[:6]] for line in csv.DictReader(file)]
    with open(out / "steps.csv", encoding="utf-8") as file:
        last = list(csv.DictReader(file))[-1]
    return np.array(boxes), (float(last["area_m2"]), float(last["volume"])), times


def main():
    short, sweep = "--short" in sys.argv, Sweep()
    repeat = 1 if short else 3
    for count in (4, 8) if short else (1, 2, 4, 8):
        last = sweep.poses[sweep.chosen(count)[-1][0]]
        boxes, size, times = ours(sweep, count, repeat=max(3, repeat))
        row(TABLE, f"vibrissa: K = {count}", times, f"the whole command; {told(boxes, last, size)}")
        point("contacts", "vibrissa, possibilistic", count, min(times))
        # One touch at 2 mm makes millions of boxes.
        precision = 10e-3 if count == 1 else 2e-3
        boxes, times = paved(sweep, count, precision, repeat=repeat if count > 2 else 1)
        grain = f"{1e3 * precision:.0f} mm, {math.degrees(TURN * precision):.0f} deg"
        row(TABLE, f"Codac: K = {count}, {grain}", times, told(boxes, sweep.truth(count)))
        point("contacts", "Codac, 2 mm (K = 1: 10 mm)", count, min(times))
    for split in (1, 4) if short else (1, 4, 16, 64):
        many = len(edges(split))
        point("edges", "vibrissa, possibilistic, K = 8", many, min(ours(sweep, 8, split)[-1]))
        if split <= 16:
            point("edges", "Codac, K = 8, 2 mm", many, min(paved(sweep, 8, 2e-3, split)[1]))


if __name__ == "__main__":
    main()
