"""What a localization costs as the map grows, and as the bound on readings does: tables in Markdown.

Usage: VIBRISSA=target/release/vibrissa python3 bench/map_size.py [--write docs/which-method.md]

Wavy outlines of a given length in edges of 2 mm, drawn from a fixed seed; the whisker is dragged along 220 mm of wall (220 rows at
300 Hz) by our simulator. Processor time of one thread, the map's reading among it, and the largest memory of the process.
"""

import json
import math
import os
import pathlib
import random
import resource
import subprocess
import sys
import tempfile

COMMAND = os.environ.get("VIBRISSA", "vibrissa")
METHODS = ["deterministic", "possibilistic", "probabilistic"]
LENGTHS = [1.4, 3.0, 9.0, 28.0, 96.0]
BOUNDS = [0.01, 0.02, 0.05, 0.1]
LEAN = math.radians(45)
WHISKER = 0.075


class Outline:
    """A closed curve: a circle with waves of 60 to 200 mm on it."""

    def __init__(self, length):
        draw = random.Random(7)
        self.radius = length / (2 * math.pi)
        self.waves = []
        for _ in range(6):
            count = max(2, round(length / draw.uniform(0.06, 0.2)))
            self.waves.append((count, draw.uniform(0.5e-3, 2.5e-3), draw.uniform(0, 2 * math.pi)))

    def at(self, angle):
        radius = self.radius + sum(size * math.sin(count * angle + phase) for count, size, phase in self.waves)
        return radius * math.cos(angle), radius * math.sin(angle)

    def corners(self):
        count = round(2 * math.pi * self.radius / 2e-3)
        return [self.at(2 * math.pi * k / count) for k in range(count)]

    def waypoints(self):
        """Along the wall, the whisker pressed by 8 to 12 mm and dragged behind; from free space on."""
        found = []
        for k in range(24):
            angle = 0.01 * k / self.radius
            depth = (WHISKER * math.cos(LEAN) - 0.010 + 0.002 * math.sin(0.9 * k)) if k > 1 else WHISKER
            radius = self.radius - depth
            found.append((radius * math.cos(angle), radius * math.sin(angle), angle - LEAN))
        return found


def prepare(folder, length, bound):
    outline = Outline(length)
    ring = [list(corner) for corner in outline.corners()]
    feature = {"type": "Feature", "properties": {"role": "arena"}, "geometry": {"type": "Polygon", "coordinates": [ring + ring[:1]]}}
    (folder / "map.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": [feature]}))
    way = ",\n".join(f"[{x:.6f}, {y:.6f}, {theta:.6f}]" for x, y, theta in outline.waypoints())
    (folder / "scenario.toml").write_text(f"""title = "wall"
map = "map.geojson"
seed = 3
[[whisker]]
noise = {{ moment_relative = {bound}, moment_absolute = 2e-5 }}
[path]
speed = "300 mm/s"
rate = "300 Hz"
waypoints = [{way}]
""")
    subprocess.run([COMMAND, "simulate", "scenario.toml", "--out", "sweep"], cwd=folder, check=True, capture_output=True)


def localize(folder, method, *more):
    words = [COMMAND, "localize", "sweep/log.csv", "--map", "map.geojson", "--robot", "sweep/robot.toml", "--truth", "sweep/truth.tum",
             "--method", method, "--out", "out", *more]
    process = subprocess.Popen(words, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    message = process.stderr.read().decode()
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        return "refused" if "--within" in message else f"failed: {message[:60]}"
    result = json.loads((folder / "out" / "result.json").read_text())
    run = result["runtime"]
    seconds = usage.ru_utime + usage.ru_stime
    memory = usage.ru_maxrss / 1024
    return (f"{short(seconds)} s; {short(run['p50_us'] / 1e3)}, {short(run['p99_us'] / 1e3)} ms; {memory:.0f} MB; "
            f"{result['status']}, {len(result['hypotheses'])}")


def short(value):
    """Two digits, without an exponent."""
    return f"{float(f'{value:.2g}'):g}"


def table(title, cases):
    lines = [f"| {title} | {' | '.join(METHODS)} |", "| --- | --- | --- | --- |"]
    print("", *lines, sep="\n")
    for name, length, bound, more in cases:
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            prepare(folder, length, bound)
            lines.append(f"| {name} | {' | '.join(localize(folder, m, *more) for m in METHODS)} |")
            print(lines[-1], flush=True)
    return lines


def write(path, name, lines):
    """Puts a table between its marks in a page."""
    text = path.read_text()
    begin, end = f"<!-- {name}: written by bench/map_size.py -->\n", f"<!-- end of {name} -->"
    before, rest = text.split(begin)
    path.write_text(before + begin + "\n".join(lines) + "\n" + end + rest.split(end, 1)[1])


def main():
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    sizes = table("boundary", [(f"{length} m", length, 0.05, []) for length in LENGTHS])
    x, y, theta = Outline(96.0).waypoints()[0]
    region = [x - 0.01, x + 0.01, y - 0.015, y + 0.015, theta - 0.15, theta + 0.15]
    sizes += table("boundary", [("96 m, region", 96.0, 0.05, ["--within", ",".join(f"{v:.4f}" for v in region)])])[2:]
    bounds = table("bound on readings, 1.4 m", [(f"{100 * bound:.0f} %", 1.4, bound, []) for bound in BOUNDS])
    if sys.argv[1:2] == ["--write"]:
        page = pathlib.Path(sys.argv[2])
        write(page, "map sizes", sizes)
        write(page, "bounds", bounds)


if __name__ == "__main__":
    main()
