"""Prints the ratio table from the output of the benches (bencher format) and of scipy_beam.py."""

import re
import sys

# Ours, shapes an iteration, SciPy's row.
ROWS = [
    ("single/force: contact, slope, moment, tip", 1, "force single"),
    ("batch/force: contact, slope, moment, tip", 1024, "force batch"),
    ("single/moment: contact, slope, force, tip", 1, "moment single"),
    ("batch/moment: contact, slope, force, tip", 1024, "moment single"),
    ("single/point: force, arc length, slope, tip", 1, "point single"),
    ("batch/point: force, arc length, slope, tip", 1024, "point single"),
    ("single/baseline: elliptic functions, force mode", 1, "force single"),
    ("general/tapered to one half: force mode", 1, "taper single"),
    ("general/tapered to one tenth: force mode", 1, "taper 0.1 single"),
    ("general/tapered to one twentieth: force mode", 1, "taper 0.05 single"),
    ("general/tip of a whisker tapered to one tenth", 1, "taper 0.1 tip"),
    ("general/tip of a whisker tapered to one twentieth", 1, "taper 0.05 tip"),
    ("field/uniform: at, with derivatives, all over the field", 1, "force single"),
    ("field/uniform: at, with derivatives, around one place", 1, "force single"),
    ("field/uniform: position, from a neighbour", 1, "point single"),
    ("field/uniform: direction and moment, from a neighbour", 1, "moment single"),
    ("cores/baseline: one thread: a million normal loads", 1_000_000, "force batch"),
    ("cores/two threads: a million normal loads", 1_000_000, "force batch"),
    ("cores/baseline: one thread: 20000 tapered rods", 20_000, "taper 0.1 single"),
    ("cores/two threads: 20000 tapered rods", 20_000, "taper 0.1 single"),
]


def main():
    ours, scipy = {}, {}
    for line in open(sys.argv[1], encoding="utf-8"):
        found = re.match(r"test (.*?)\s+\.\.\. bench:\s+([\d,.]+) ns/iter \(\+/- ([\d,.]+)\)", line)
        if found:
            ours[found[1]] = [float(found[i].replace(",", "")) for i in (2, 3)]
    for line in open(sys.argv[2], encoding="utf-8"):
        name, value = line.rstrip("\n").split("\t")
        scipy[name] = float(value)
    print(f"{'ns a shape':52} {'ours':>9} {'+/-':>8} {'SciPy':>10} {'ratio':>8}")
    for name, shapes, peer in ROWS:
        if name not in ours:
            raise SystemExit(f"the benches did not print {name!r}")
        value, spread = (v / shapes for v in ours[name])
        print(f"{name:52} {value:9.1f} {spread:8.1f} {scipy[peer]:10.0f} {scipy[peer] / value:7.0f}x")


if __name__ == "__main__":
    main()
