"""What the guaranteed set of other whiskers costs against that of a uniform one: a table in Markdown.

Usage: VIBRISSA=target/release/vibrissa python3 bench/whisker_kinds.py [SEEDS]

Three scenarios are simulated with whiskers of much the same strength and localized by the possibilistic method: the area of the
set after the last row, the processor time of the whole process, and that of one row (median). Each is the median over seeds, and
over that of the uniform whisker in brackets. The program fails where a set does not hold the truth.
"""

import json
import math
import os
import pathlib
import resource
import statistics
import subprocess
import sys
import tempfile

COMMAND = os.environ.get("VIBRISSA", "vibrissa")
SCENARIOS = pathlib.Path(__file__).resolve().parent.parent / "scenarios"
PLACES = [("bay", "arena_concave"), ("obstacle", "obstacle_sweep"), ("straight wall", "arena_straight")]
KINDS = [
    ("uniform, 2.9e-4 N m²", ""),
    ("tapered to 0.5, 4.5e-4 at the base", "flexural_rigidity = 4.5e-4\ntip_ratio = 0.5"),
    ("the same on a base of 0.05 N m/rad", "flexural_rigidity = 4.5e-4\ntip_ratio = 0.5\nbase_stiffness = 0.05"),
    ("tapered to 0.2, 8e-4 at the base", "flexural_rigidity = 8e-4\ntip_ratio = 0.2"),
    (
        "30 mm of 4e-4 and 45 mm of 1.5e-4",
        "segments = [{ length = 0.03, flexural_rigidity = 4e-4 }, { length = 0.045, flexural_rigidity = 1.5e-4 }]",
    ),
    (
        "30 mm of 4e-4, 5 mm of 4e-5, 40 mm of 2e-4",
        "segments = [{ length = 0.03, flexural_rigidity = 4e-4 }, { length = 0.005, flexural_rigidity = 4e-5 }, "
        "{ length = 0.04, flexural_rigidity = 2e-4 }]",
    ),
    ("curved, 5 per m", "curvature = 5.0"),
]


def call(*words):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([COMMAND, *map(str, words)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, words))}: {done.stderr.strip()}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return done.stdout, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def holds(states, truth):
    x, y, theta = truth
    for line in states.read_text().split()[1:]:
        a, b, c, d, e, f = map(float, line.split(","))
        turn = math.remainder(theta - 0.5 * (e + f), math.tau)
        if a <= x <= b and c <= y <= d and abs(turn) <= 0.5 * (f - e):
            return True
    return False


def run(folder, scenario, keys, seed):
    """Area of the set (mm²), processor time (s) and median time of a row (us)."""
    text = (SCENARIOS / f"{scenario}.toml").read_text()
    text = text.replace("[[whisker]]", f"[[whisker]]\n{keys}", 1).replace('map = "maps/', f'map = "{SCENARIOS}/maps/', 1)
    file = folder / "scenario.toml"
    file.write_text(text)
    sweep, found = folder / "sweep", folder / "found"
    call("simulate", file, "--seed", seed, "--out", sweep)
    path = next(line.split('"')[1] for line in text.splitlines() if line.startswith("map ="))
    out, seconds = call(
        "localize", sweep / "log.csv", "--map", path, "--robot", sweep / "robot.toml", "--method", "possibilistic",
        "--json", "--out", found,
    )  # fmt: skip
    last = (sweep / "truth.tum").read_text().strip().splitlines()[-1].split()
    x, y, z, w = (float(last[k]) for k in (1, 2, 6, 7))
    if not holds(found / "states.csv", (x, y, 2 * math.atan2(z, w))):
        sys.exit(f"{scenario}, seed {seed}, {keys!r}: the set does not hold the truth")
    area = float((found / "steps.csv").read_text().strip().splitlines()[-1].split(",")[2])
    return 1e6 * area, seconds, json.loads(out)["runtime"]["p50_us"]


def main():
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    print("| whisker | " + " | ".join(f"{name} mm² | s | row µs" for name, _ in PLACES) + " |")
    print("| --- |" + " --- |" * (3 * len(PLACES)))
    base = {}
    for kind, keys in KINDS:
        cells = []
        for _, scenario in PLACES:
            with tempfile.TemporaryDirectory() as folder:
                runs = [run(pathlib.Path(folder), scenario, keys, seed) for seed in range(1, seeds + 1)]
            for k, digits in enumerate((2, 2, 2)):
                value = statistics.median(run[k] for run in runs)
                first = base.setdefault((scenario, k), value)
                cells.append(f"{value:.{digits}g}" if value < 100 else f"{value:.0f}")
                if keys:
                    cells[-1] += f" ({value / first:.2g})"
        print(f"| {kind} | " + " | ".join(cells) + " |", flush=True)


main()
