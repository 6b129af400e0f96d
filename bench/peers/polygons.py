"""Two curves of 200 points meet, and the strip of places around a boundary of two metres, with Shapely."""

import pathlib
import sys

import numpy as np
import shapely
from beam_case import EI, LENGTH, by_jacobi
from shapely import LineString, Polygon
from timing import batches, point, row

N = 200
CROSSING, STRIP = "Intersection of two contact curves of 200 points", "Where a robot may be that touches a boundary of 2 m"


def curves():
    """The contacts of a load of 0.1 N, and those at 60 mm."""
    load = [by_jacobi(0.1, s)[:2] for s in np.linspace(1e-3 * LENGTH, LENGTH, N)]
    strip = [by_jacobi(f, 0.06)[:2] for f in np.linspace(1e-4, 0.5, N)]
    return load, strip


def main():
    count = 3 if "--short" in sys.argv else 7
    load, strip = curves()
    if "--curves" in sys.argv:
        for x, y in load + strip:
            print(f"{x!r} {y!r}".replace("np.float64(", "").replace(")", ""))
        return
    name = f"Shapely {shapely.__version__}"
    a, b = LineString(load), LineString(strip)
    row(CROSSING, name, batches(lambda: a.intersection(b), count), "chords only; curves ready")
    row(CROSSING, f"{name}, from coordinates", batches(lambda: LineString(load).intersection(LineString(strip)), count), "chords only")
    reach = max(np.hypot(x, y) for x, y in load)
    for walls in (4, 64, 1024):
        # A square whose sides are cut: the same room with more edges.
        cut = walls // 4
        along = np.arange(cut) / cut * 0.5
        ring = [*((s, 0.0) for s in along), *((0.5, s) for s in along), *((0.5 - s, 0.5) for s in along), *((0.0, 0.5 - s) for s in along)]
        room = Polygon(ring)
        times = batches(lambda: room.exterior.buffer(reach).intersection(room), count)
        if walls == 4:
            row(STRIP, name, times, "the strip alone: no headings, no collisions")
        point("edges", "Shapely, strip of places", walls, min(times))


if __name__ == "__main__":
    main()
