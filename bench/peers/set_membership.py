"""The set of poses that explain the touches, by Codac's contractors: time, boxes, and whether the truth is inside.

Prints `name <tab> median s <tab> least <tab> largest <tab> remark`.
"""

import math
import statistics
import sys
import time

import codac
from room import ERROR, TRUTH, edges, touches

# Headings in metres, so that one precision serves 4 mm and 2 degrees.
TURN = math.radians(2.0) / 0.004


def contractor(points):
    wall = None
    for a, b in edges():
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


def main():
    start = codac.IntervalVector([[0, 0.9], [0, 0.7], [-math.pi / TURN, math.pi / TURN]])
    truth = (TRUTH[0], TRUTH[1], TRUTH[2] / TURN)
    for count in (8, 5, 3)[: 1 if "--short" in sys.argv else 3]:
        times = []
        for _ in range(3):
            contract = contractor(touches(count))
            begin = time.process_time()
            paving = codac.pave(start, contract, 4e-3)
            times.append(time.process_time() - begin)
        boxes = paving.boxes(codac.PavingOut.outer)
        held = any(all(box[i].contains(truth[i]) for i in range(3)) for box in boxes)
        remark = f"all at once, 4 mm and 2 deg; {len(boxes)} boxes, truth {'inside' if held else 'LOST'}"
        print(f"Codac: {count} touches", statistics.median(times), min(times), max(times), remark, sep="\t")


if __name__ == "__main__":
    main()
