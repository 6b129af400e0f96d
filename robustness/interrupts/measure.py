#!/usr/bin/env python3
"""Interrupts every command of `vibrissa` while it works, and measures what becomes of it.

    robustness/interrupts/measure.py target/release/vibrissa [--only WORD] [--markdown FILE]

Each command gets work of many seconds, and SIGINT at several moments; told are the longest time until the work has ended (the terminal
says so, or the process ends), until the process ends, which may have results to write, whether the terminal shows what goes on after a
second, and what is left: nothing, or results that are marked. The exit code is 1 where the work ends later than 0.2 s beside what the
machine lets a process wait, nothing is shown, or results are left without a mark. Times are the wall's: a busy machine shows in them.
Needs Python 3.9 alone.
"""

import argparse
import json
import math
import os
import pty
import select
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

#: A scenario whose exploration takes seconds.
ROOM = Path(__file__).resolve().parents[2] / "scenarios" / "cluttered_room.toml"
#: Longest time from the signal to the end of the process (s).
LONGEST = 0.2
#: When the signal comes (s after the start).
MOMENTS = [0.15, 0.6, 1.6, 3.1]
#: Within this time something has to be shown (s): it is drawn after a second.
SHOWN = 1.5


def wheel(path, count, radius=9.0):
    """An arena of so many edges, which takes long to search."""
    turn = 2 * math.pi / count
    ring = [[radius * math.cos(i * turn), radius * math.sin(i * turn)] for i in range(count)]
    feature = {"type": "Feature", "properties": {"role": "arena"}, "geometry": {"type": "Polygon", "coordinates": [ring + ring[:1]]}}
    path.write_text(json.dumps(feature))


def prepare(folder, binary):
    """The inputs: some large, some that belong to another robot."""
    subprocess.run([binary, "demo", "--out", "demo"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    wheel(folder / "ring.geojson", 60_000)
    wheel(folder / "large.geojson", 1_000_000, 100.0)
    (folder / "soft.toml").write_text("[[whisker]]\nbase_stiffness = 0.002\ntip_ratio = 0.05\n")
    (folder / "taper.toml").write_text("[[whisker]]\ntip_ratio = 0.01\n")
    head, *rows = (folder / "demo" / "log.csv").read_text().splitlines()
    # The same sweep again and again, three seconds later each time.
    t = head.split(",").index("t")
    for name, turns in [("short.csv", 60), ("long.csv", 600)]:
        with open(folder / name, "w") as log:
            log.write(head + "\n")
            for turn in range(turns):
                for row in rows:
                    cells = row.split(",")
                    cells[t] = f"{float(cells[t]) + 3.0 * turn:.6f}"
                    log.write(",".join(cells) + "\n")
    (folder / "batch.csv").write_text("s_a,F,r_tip\n" + "".join(f"0.07,{0.01 + i * 1e-7:.7f},0.3\n" for i in range(300_000)))
    # To and fro along a wall, a tapered whisker bent by it: each row takes an integration.
    points = "[0.4, 0.22, 0.6], " + ", ".join(f"[0.428, {0.19 + 0.06 * (i % 2):.2f}, 0.6]" for i in range(200))
    (folder / "scenario.toml").write_text(
        f'map = "demo/map.svg"\n[[whisker]]\ntip_ratio = 0.5\n[path]\nspeed = "20 mm/s"\nrate = "1000 Hz"\nwaypoints = [{points}]\n'
    )


def commands():
    """Name, words, and what of the results tells the mark: a file and a word in it, or none where nothing may be left."""
    localize = ["localize", "demo/log.csv", "--map"]
    for method in ["deterministic", "possibilistic", "probabilistic"]:
        marked = ("result.json", '"interrupted": true')
        yield f"localize, ring of 57 m, {method}", [*localize, "ring.geojson", "--method", method], marked
        yield f"localize, 300,000 rows, {method}", ["localize", "long.csv", "--map", "demo/map.svg", "--method", method], marked
    yield "localize, 10^6 vertices", [*localize, "large.geojson", "--within", "0 1 0 1 0 1", "--method", "deterministic"], marked
    yield "localize, tapered whisker", ["localize", "demo/log.csv", "--map", "demo/map.svg", "--method", "possibilistic", "--robot", "taper.toml"], marked
    yield "contact, another whisker", ["contact", "short.csv", "--robot", "soft.toml"], ("contacts.svg", "interrupted at")
    yield "contact, long log", ["contact", "long.csv"], ("contacts.svg", "interrupted at")
    yield "contact --filter", ["contact", "long.csv", "--filter", "--readings", "9"], None
    yield "profile, another whisker", ["profile", "short.csv", "--robot", "soft.toml"], ("profile.svg", "interrupted")
    yield "preimage", ["preimage", "--map", "ring.geojson", "--sensor", "moment", "--value", "3 mN m", "--cell", "12 mm", "--heading-step", "1 deg"], None
    yield "contact-set, tapered whisker", ["contact-set", "--sensor", "moment", "--value", "3 mN m..4 mN m", "--robot", "soft.toml"], None
    yield "beam --batch", ["beam", "force", "--batch", "batch.csv"], ("beam.csv", "")
    yield "simulate", ["simulate", "scenario.toml"], ("truth.tum", "")
    yield "plan", ["plan", "demo/log.csv", "--map", "ring.geojson"], None
    yield "explore", ["explore", str(ROOM), "--begin", "150 mm", "--animate"], ("explore.json", '"interrupted": true')
    yield "reproduce", ["reproduce"], None


def interrupted(binary, words, folder, moment):
    """Exit code, seconds from the signal until the work's end is told and until the process ends, what the terminal showed before the
    signal and after it, the folder of the results."""
    master, slave = pty.openpty()
    out = tempfile.mkdtemp(dir=folder)
    child = subprocess.Popen(
        [binary, *words, "--out", out], cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=slave
    )
    os.close(slave)
    shown, begin, asked, told = b"", time.monotonic(), None, None
    while True:
        now = time.monotonic()
        if asked is None and now - begin >= moment:
            before = len(shown)
            asked = time.monotonic()
            os.kill(child.pid, signal.SIGINT)
        try:
            if select.select([master], [], [], 0.005)[0]:
                shown += os.read(master, 65536)
        except OSError:
            pass
        if asked is not None and told is None and b"interrupted" in shown[before:]:
            told = time.monotonic() - asked
        if child.poll() is not None:
            break
    ended = time.monotonic()
    try:
        while select.select([master], [], [], 0)[0]:
            shown += os.read(master, 65536)
    except OSError:
        pass
    os.close(master)
    if asked is None:
        return child.returncode, None, None, shown, b"", Path(out)
    ended -= asked
    return child.returncode, ended if told is None else told, ended, shown[:before], shown[before:], Path(out)


def waits():
    """How long this machine lets a process wait that only starts and ends (s): the longest of some."""
    longest = 0.0
    for _ in range(8):
        begin = time.monotonic()
        subprocess.run(["true"], check=True)
        longest = max(longest, time.monotonic() - begin)
    return longest


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("binary", type=Path)
    parser.add_argument("--only", default="", help="commands whose name holds this word")
    parser.add_argument("--markdown", type=Path, help="write the table there")
    args = parser.parse_args()
    binary = str(args.binary.resolve())
    table = ["| command | work ends (s) | process ends (s) | shown after 1 s | leaves |", "| --- | --- | --- | --- | --- |"]
    faults = 0
    with tempfile.TemporaryDirectory(prefix="interrupts-") as folder:
        folder = Path(folder)
        prepare(folder, binary)
        print("\n".join(table), flush=True)
        for name, words, mark in commands():
            if args.only not in name:
                continue
            times, ends, left, shows, unmarked = [], [], set(), None, False
            for moment in MOMENTS:
                code, seconds, end, before, last, out = interrupted(binary, words, folder, moment)
                names = sorted(path.name for path in out.iterdir())
                # What is left under a temporary name the next run removes.
                files = [name for name in names if not name.startswith(".")]
                if seconds is None:
                    left.add("done before" if code == 0 else f"failed before: {before[-80:]!r}")
                    unmarked |= code != 0
                    continue
                if code == 0:
                    left.add("done before")
                    continue
                times.append(seconds)
                ends.append(end)
                if moment > SHOWN:
                    shows = bool(shows is not False and before.strip())
                if code != 130:
                    left.add(f"exit code {code}")
                    unmarked = True
                if not files:
                    left.add("nothing")
                elif b"results are whole" in last:
                    left.add("whole results")
                elif mark is None or mark[1] not in (out / mark[0]).read_text() or b"interrupted" not in last:
                    left.add("UNMARKED results")
                    unmarked = True
                else:
                    left.add("marked results")
                if len(names) > len(files):
                    left.add("temporary files")
            slack = waits()
            slow = bool(times) and max(times) > LONGEST + slack
            fault = slow or shows is False or unmarked
            faults += fault
            worst = f"{max(times):.2f} (median {sorted(times)[len(times) // 2]:.2f})" if times else "-"
            most = f"{max(ends):.2f}" if ends else "-"
            line = f"| {'**' + name + '**' if fault else name} | {worst} | {most} | {'-' if shows is None else 'yes' if shows else 'NO'} | {', '.join(sorted(left))} |"
            table.append(line)
            print(line, flush=True)
    print(f"{len(table) - 2} commands, {faults} at fault", flush=True)
    if args.markdown:
        args.markdown.write_text("\n".join(table) + "\n")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
