"""A room and a whisker's sweep along its lower wall (room.toml), simulated by our command: the same readings for all.

Our methods get moments; the peers are told where the whisker was touched, within 2 mm, which ours finds from moments.
"""

import ast
import csv
import json
import math
import os
import pathlib
import re
import resource
import subprocess
import tempfile

HERE = pathlib.Path(__file__).parent
ERROR = 2e-3
# Bounds of the room, x and y (m).
BOX = [[0.0, 0.9], [0.0, 0.7]]
WALLS = ast.literal_eval(re.search(r"arena = (\[.*?\]\])", (HERE / "room.toml").read_text(encoding="utf-8"), re.S)[1])
COMMAND = os.environ.get("VIBRISSA", "vibrissa")


def edges(split=1):
    """The walls; each cut into `split` edges."""
    found = []
    for (ax, ay), (bx, by) in zip(WALLS, WALLS[1:] + WALLS[:1]):
        at = [(ax + k / split * (bx - ax), ay + k / split * (by - ay)) for k in range(split + 1)]
        found += list(zip(at, at[1:]))
    return found


def inside(x, y):
    odd = False
    for (ax, ay), (bx, by) in edges():
        if (ay > y) != (by > y) and x < (bx - ax) * (y - ay) / (by - ay) + ax:
            odd = not odd
    return odd


def run(*args):
    """Runs our command; gives the processor time of all of it, files and figures among it."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([COMMAND, *map(str, args)], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def rows(path):
    with open(path, encoding="utf-8") as file:
        return list(csv.DictReader(file))


class Sweep:
    """The simulated sweep: the rows in contact, and where they touched."""

    def __init__(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        run("simulate", HERE / "room.toml", "--out", self.folder)
        self.log = rows(self.folder / "log.csv")
        lines = [line.split() for line in open(self.folder / "truth.tum", encoding="utf-8")]
        poses = [(float(w[1]), float(w[2]), 2 * math.atan2(float(w[6]), float(w[7]))) for w in lines]
        touched = {round(float(c["t"]), 6): (float(c["x"]), float(c["y"])) for c in rows(self.folder / "contacts.csv")}
        at = [(i, touched[round(float(row["t"]), 6)]) for i, row in enumerate(self.log) if round(float(row["t"]), 6) in touched]
        # The onset's first rows hardly bend the whisker.
        self.touches = at[3:]
        self.poses = poses

    def chosen(self, count):
        """So many touches, evenly over the sweep: rows of the log with the places touched."""
        step = (len(self.touches) - 1) / max(1, count - 1)
        return [self.touches[round(k * step)] for k in range(count)]

    def truth(self, count):
        """The robot at the first of these touches."""
        return self.poses[self.chosen(count)[0][0]]

    def points(self, count):
        """These touches in the frame of the robot at the first of them (m)."""
        x, y, theta = self.truth(count)
        cos, sin = math.cos(theta), math.sin(theta)
        seen = [(px - x, py - y) for _, (px, py) in self.chosen(count)]
        return [(cos * dx + sin * dy, -sin * dx + cos * dy) for dx, dy in seen]

    def short_log(self, count):
        """A log of these touches alone."""
        path = self.folder / f"log_{count}.csv"
        with open(path, "w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, self.log[0].keys())
            writer.writeheader()
            writer.writerows(self.log[i] for i, _ in self.chosen(count))
        return path

    def map(self, split=1):
        """The room as a map whose walls are cut into `split` edges each."""
        path = self.folder / f"map_{split}.geojson"
        ring = [list(a) for a, _ in edges(split)]
        shape = {"type": "Polygon", "coordinates": [ring + ring[:1]]}
        path.write_text(json.dumps({"type": "Feature", "properties": {"role": "arena"}, "geometry": shape}), encoding="utf-8")
        return path
