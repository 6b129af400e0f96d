#!/usr/bin/env python3
"""A live run for a long time at ten times the sensor's rate: memory and latency over time, as a table and a figure.

Usage: robustness/live/soak.py [--seconds 3600] [--rate 3000] [--whiskers 1] [--out FOLDER] [--draw FILE.csv]

Builds and runs the example `endurance` of vibrissa-live (Linux), which records the whole run; writes soak.csv while it runs and
soak.svg at the end. --draw only draws and judges what a run has written.

What is allocated tells whether something grows: it is judged by a line fitted to the last half of the run. The memory of the process
does not: where the machine is busy, rows and bytes wait for a moment, and the allocator keeps the pages that they took. Those steps end
where what may wait is bounded, so that the memory of the process is held against a limit.

Exit 1 where what is allocated grew by more than 0.5 MB by the line, the process took more than 64 MB, or something was not recorded.
"""

import argparse
import csv
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
# Growth of what is allocated over the last half of a run (MB). The estimate's number of places alone moves it by 0.3 MB to and fro; in half an
# hour at 3 kHz a tenth of a byte lost at each row is more.
GROWTH = 0.5
# Most memory of the process (MB): 16 for the search at the start and 10 for the program and the allocator's pages, as measured, and 32 that
# may wait for the disk (`RECORD_WAITING`).
MOST = 64.0
COLOURS = ("#1f6fb2", "#c2571a", "#3a8a4d")
WIDTH, PANEL, LEFT, RIGHT, TOP, GAP = 720, 150, 70, 20, 20, 42


def read(path):
    with open(path) as file:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]


def ticks(largest, count=4):
    """Round numbers from 0 to just above the largest."""
    raw = max(largest, 1e-9) / count
    step = next(m * 10.0**e for e in range(-6, 10) for m in (1, 2, 5) if m * 10.0**e >= raw)
    return [step * k for k in range(int(largest / step + 0.999) + 1)]


def panel(rows, keys, words, top, scale=1.0):
    """One graph: the given columns over minutes."""
    end = rows[-1]["t_s"] / 60
    largest = max(row[key] * scale for row in rows for key in keys)
    marks = ticks(largest)
    x = lambda minutes: LEFT + (WIDTH - LEFT - RIGHT) * minutes / end  # noqa: E731
    y = lambda value: top + PANEL * (1 - value / marks[-1])  # noqa: E731
    out = [f'<text x="{LEFT}" y="{top - 6}" class="t">{words}</text>']
    for mark in marks:
        out.append(f'<line x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{y(mark):.1f}" y2="{y(mark):.1f}" class="g"/>')
        out.append(f'<text x="{LEFT - 6}" y="{y(mark) + 4:.1f}" text-anchor="end">{mark:g}</text>')
    for mark in ticks(end, 6):
        if mark <= end:
            out.append(f'<text x="{x(mark):.1f}" y="{top + PANEL + 16}" text-anchor="middle">{mark:g}</text>')
    for key, colour in zip(keys, COLOURS):
        points = " ".join(f"{x(row['t_s'] / 60):.1f},{y(scale * row[key]):.1f}" for row in rows)
        out.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="1.5"/>')
    return out


def draw(rows, path):
    tops = [TOP + 10 + k * (PANEL + GAP) for k in range(3)]
    body = panel(
        rows,
        ["heap_mb", "heap_most_mb", "memory_mb"],
        "Memory: allocated (blue), at most in each ten seconds (orange), of the process (green), MB",
        tops[0],
    )
    body += panel(rows, ["p50_ms", "p99_ms"], "Last byte of a row to its pose, in each ten seconds: median (blue) and 99 % (orange), ms", tops[1])
    body += panel(rows, ["rows"], "Rows estimated (millions), over minutes", tops[2], 1e-6)
    height = tops[2] + PANEL + 30
    style = "text{font:12px sans-serif;fill:#333}.t{font-weight:bold}.g{stroke:#ddd}"
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" role="img"><title>A live run over time</title>'
    path.write_text("\n".join([head, f"<style>{style}</style>", f'<rect width="{WIDTH}" height="{height}" fill="#fff"/>', *body, "</svg>", ""]))


def slope(rows, key):
    """The slope of a line fitted by least squares to a column over time (1/s)."""
    times, values = [row["t_s"] for row in rows], [row[key] for row in rows]
    middle, mean = sum(times) / len(times), sum(values) / len(values)
    return sum((t - middle) * (v - mean) for t, v in zip(times, values)) / sum((t - middle) ** 2 for t in times)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seconds", type=float, default=3600.0)
    parser.add_argument("--rate", type=float, default=3000.0)
    parser.add_argument("--whiskers", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("."))
    parser.add_argument("--draw", type=Path)
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    table = args.draw or args.out / "soak.csv"
    if not args.draw:
        run = ["cargo", "run", "--release", "-q", "-p", "vibrissa-live", "--example", "endurance", "--"]
        subprocess.run([*run, str(args.seconds), str(args.rate), str(args.whiskers), str(table.resolve())], cwd=ROOT, check=True)
    rows = read(table)
    if len(rows) < 10:
        sys.exit(f"{table}: {len(rows)} lines are too few to tell anything; run for two minutes or more")
    draw(rows, args.out / "soak.svg")
    last = rows[-1]
    # When the sender has ended, which is within the last ten seconds that brought rows, less is allocated.
    driven = [row for row, before in zip(rows[1:], rows) if row["rows"] > before["rows"]][:-1]
    half = driven[len(driven) // 2 :]
    growth = slope(half, "heap_mb") * (half[-1]["t_s"] - half[0]["t_s"])
    most = max(row["memory_mb"] for row in rows)
    between = sorted(row["heap_mb"] for row in half)
    print(
        f"{last['t_s'] / 60:.0f} minutes, {last['rows'] / 1e6:.2f} million rows, {last['missing']:.0f} frames missing, "
        f"{last['not_recorded']:.0f} messages not recorded; in the last half {between[0]:.2f} to {between[-1]:.2f} MB allocated, "
        f"{growth:+.2f} MB by a fitted line; the process took {most:.1f} MB at most; longest wait {last['largest_ms']:.1f} ms"
    )
    faults = {
        f"what is allocated grows by more than {GROWTH} MB": growth > GROWTH,
        f"the process takes more than {MOST:.0f} MB": most > MOST,
        "something was not recorded": last["not_recorded"] > 0,
    }
    if any(faults.values()):
        sys.exit("FAILED: " + "; ".join(words for words, failed in faults.items() if failed))


main()
