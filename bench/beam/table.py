"""Prints the tables from criterion's files and the output of scipy_beam.py. Usage: table.py CRITERION START SCIPY"""

import json
import pathlib
import sys

SINGLE, BATCH = "single/baseline: elliptic functions, force mode", "batch/baseline: elliptic functions, force mode"
CLOSED = "general/baseline: closed form, force mode, tilted"
AT = "field/{}: at, with derivatives, {}"
# Ours, shapes an iteration, the baseline of the same run, SciPy's row.
ROWS = [
    (SINGLE, 1, None, "force single"),
    ("single/force: contact, slope, moment, tip", 1, SINGLE, "force single"),
    ("single/moment: contact, slope, force, tip", 1, SINGLE, "moment single"),
    ("single/point: force, arc length, slope, tip", 1, SINGLE, "point single"),
    (BATCH, 1024, None, "force batch"),
    ("batch/force: contact, slope, moment, tip", 1024, BATCH, "force batch"),
    ("batch/moment: contact, slope, force, tip", 1024, BATCH, "moment single"),
    ("batch/point: force, arc length, slope, tip", 1024, BATCH, "point single"),
    (CLOSED, 1, None, None),
    ("general/tapered to one half: force mode", 1, CLOSED, "taper single"),
    ("general/tapered to one tenth: force mode", 1, CLOSED, "taper 0.1 single"),
    ("general/tapered to one twentieth: force mode", 1, CLOSED, "taper 0.05 single"),
    ("general/curved: force mode", 1, CLOSED, None),
    ("general/on an elastic base: force mode", 1, CLOSED, None),
    ("general/all three: force mode", 1, CLOSED, "all three single"),
    ("general/tip of a whisker tapered to one tenth", 1, CLOSED, "taper 0.1 tip"),
    ("general/tip of a whisker tapered to one twentieth", 1, CLOSED, "taper 0.05 tip"),
    ("general/tip of a whisker tapered to one twentieth, curved, on an elastic base", 1, CLOSED, "all three tip"),
    ("general/tapered to one half: point mode, from a neighbour", 1, CLOSED, "taper point"),
    ("general/tapered to one half: moment mode, every branch", 1, CLOSED, "taper moment"),
    ("field/baseline: closed form, no derivatives", 1, None, "force single"),
]
for whisker in ["uniform", "tapered, curved, elastic base"]:
    rod = f"field/{whisker}: baseline: rod, no derivatives"
    ROWS.append((rod, 1, None, None))
    ROWS += [(AT.format(whisker, place), 1, rod, "field batch") for place in ["all over the field", "around one place"]]
    for what in ["direction and moment, from a neighbour", "position, from a neighbour"]:
        ROWS.append((f"field/{whisker}: {what}", 1, rod, None))
    for what in ["direction and moment, every branch", "position, every branch"]:
        ROWS.append((f"field/{whisker}: {what}", 1, rod, None))
for what, shapes, peer in [("a million normal loads", 1_000_000, "force batch"), ("20000 tapered rods", 20_000, "taper 0.1 single")]:
    one = f"cores/baseline: one thread: {what}"
    ROWS += [(one, shapes, None, peer), (f"cores/two threads: {what}", shapes, one, peer)]


def measured(folder, start):
    """Median, spread and least (ns an iteration) of each bench that ran since `start`."""
    found = {}
    for path in pathlib.Path(folder).rglob("new/benchmark.json"):
        if path.stat().st_mtime < pathlib.Path(start).stat().st_mtime:
            continue
        estimates = json.loads((path.parent / "estimates.json").read_text())
        sample = json.loads((path.parent / "sample.json").read_text())
        least = min(time / count for time, count in zip(sample["times"], sample["iters"]))
        spread = estimates["median_abs_dev"]["point_estimate"]
        found[json.loads(path.read_text())["full_id"]] = (estimates["median"]["point_estimate"], spread, least)
    return found


def main():
    ours = measured(sys.argv[1], sys.argv[2])
    scipy = {}
    for line in open(sys.argv[3], encoding="utf-8"):
        name, median, least = line.rstrip("\n").split("\t")
        scipy[name] = (float(median), float(least))
    print("Nanoseconds a shape: least of all batches, median, median deviation; how many times as long the baseline (the last row")
    print("named so) and SciPy take, least by least. Ours is wall time, SciPy's processor time.\n")
    print("| bench | least | median | +/- | baseline takes | SciPy least | SciPy takes |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: |")
    for name, shapes, baseline, peer in ROWS:
        if name not in ours:
            raise SystemExit(f"the benches did not measure {name!r}; they measured {sorted(ours)}")
        median, spread, least = (value / shapes for value in ours[name])
        base = f"{ours[baseline][2] / shapes_of(baseline) / least:.3g}x" if baseline else ""
        peers = (f"{scipy[peer][1]:.0f}", f"{scipy[peer][1] / least:.0f}x") if peer else ("", "")
        print(f"| {name} | {least:.1f} | {median:.1f} | {spread:.1f} | {base} | {peers[0]} | {peers[1]} |")


def shapes_of(name):
    return next(shapes for other, shapes, _, _ in ROWS if other == name)


if __name__ == "__main__":
    main()
