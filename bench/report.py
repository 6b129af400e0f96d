"""Writes bench/reports/DATE.md and its pictures from criterion's files and the peers' lines.

Usage: report.py CRITERION START PEERS FOLDER [--short]
"""

import datetime
import json
import os
import pathlib
import platform
import subprocess
import sys

from pictures import dots, scaling

# The bench of ours that does a peer's work, by the table's name.
OURS = {
    "One bent whisker": ("single/force: contact, slope, moment, tip", "vibrissa, force mode"),
    "Intersection of two": ("intersection of two curves of 200 points/ours, refined to the smooth crossing", "vibrissa, refined to the smooth crossing"),
    "Where a robot may be": ("preimage at 1 mm and 1 degree/2 m boundary, aligned, collision-free", "vibrissa, preimage at 1 mm and 1 degree with headings and collisions"),
}
SCALING = {
    "contacts": ("Localization with guarantees, by the number of touches", "touches"),
    "edges": ("Time by the size of the map", "edges of the map"),
}


def machine():
    model = "unknown processor"
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as info:
            model = next((line.split(":")[1].strip() for line in info if line.startswith("model name")), model)
    except OSError:
        pass
    told = lambda *words: subprocess.run(words, capture_output=True, text=True, check=False).stdout.strip()
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else float("nan")
    cores = os.cpu_count() or 1
    busy = " The machine was busy with other work: medians are long, the least of many batches hardly." if load > cores else ""
    return (f"{model}, {cores} cores, {platform.system()}, Python {platform.python_version()}; {told('rustc', '--version')}; "
            f"commit {told('git', 'rev-parse', '--short', 'HEAD')}; load {load:.1f} at the end.{busy}")


def measured(folder, start):
    """{bench: (median, least, largest)} in seconds an iteration, of what ran since `start`."""
    begun, found = pathlib.Path(start).stat().st_mtime, {}
    for path in pathlib.Path(folder).rglob("new/benchmark.json"):
        if path.stat().st_mtime >= begun:
            sample = json.loads((path.parent / "sample.json").read_text(encoding="utf-8"))
            each = sorted(1e-9 * time / count for time, count in zip(sample["times"], sample["iters"]))
            found[json.loads(path.read_text(encoding="utf-8"))["full_id"]] = (each[len(each) // 2], each[0], each[-1])
    return dict(sorted(found.items()))


def shown(seconds):
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds * 1e9:.3g} ns"


def read_peers(path):
    """Tables {name: [(peer, times, remark)]}, pictures {name: {series: [(x, seconds)]}}, and what was skipped."""
    tables, pictures, skipped = {}, {}, []
    for line in open(path, encoding="utf-8"):
        cells = line.rstrip("\n").split("\t")
        if cells[0] == "row" and len(cells) == 7:
            tables.setdefault(cells[1], []).append((cells[2], tuple(map(float, cells[3:6])), cells[6]))
        elif cells[0] == "point" and len(cells) == 5:
            pictures.setdefault(cells[1], {}).setdefault(cells[2], []).append((float(cells[3]), float(cells[4])))
        elif line.startswith("SKIPPED"):
            skipped.append(line.strip())
    return tables, pictures, skipped


def peer_table(name, rows, benches):
    """One table; ratios are of the least, to our row above."""
    for start, (bench, called) in OURS.items():
        if name.startswith(start) and bench in benches:
            rows = [(called, benches[bench], "wall time")] + rows
    text = [f"## {name}", "", "| who | median | least | largest | takes | remark |", "| --- | ---: | ---: | ---: | ---: | --- |"]
    own = None
    for who, (median, least, largest), remark in rows:
        if who.startswith("vibrissa"):
            own, ratio = least, ""
        else:
            ratio = f"{least / own:.3g}x" if own else ""
        text.append(f"| {who} | {shown(median)} | {shown(least)} | {shown(largest)} | {ratio} | {remark} |")
    return text + [""]


def bench_table(benches):
    base = {name.split("/")[0]: least for name, (_, least, _) in benches.items() if "baseline" in name}
    text = ["## Our benches", "", "Wall time of an iteration; the ratio is the group's baseline over it, least by least.", "",
            "| bench | median | least | largest | ratio |", "| --- | ---: | ---: | ---: | ---: |"]
    for name, (median, least, largest) in benches.items():
        ratio = base.get(name.split("/")[0])
        told = f"{ratio / least:.3g}" if ratio and "baseline" not in name else ""
        text.append(f"| {name} | {shown(median)} | {shown(least)} | {shown(largest)} | {told} |")
    return text


def page(date, benches, peers, short):
    tables, pictures, skipped = peers
    text = [f"# Ours and its peers, {date}", "", machine(), ""]
    if short:
        text += ["The short form: few samples, so read orders of magnitude only.", ""]
    text += ["Peers' times, and those of our whole command, are processor times of one thread; our benches are wall times. A peer",
             "*takes* so many times as long as the row of ours above it, least by least.", ""]
    for name, rows in tables.items():
        text += peer_table(name, rows, benches)
        if name.startswith("Localization with guarantees"):
            text += ["Codac bounds the pose at the first touch from places told within 2 mm, ours the one at the last from moments with",
                     "their bounds (5 % and 0.02 mN m).", ""]
    for name in pictures:
        text += [f"![{SCALING[name][0]}]({date}-{name}.svg)", ""]
    if skipped:
        text += ["Skipped:", ""] + [f"* {line}" for line in skipped] + [""]
    text += bench_table(benches) + ["", f"![Times of every bench]({date}.svg)"]
    return "\n".join(text) + "\n"


def main():
    short = "--short" in sys.argv
    benches, peers = measured(sys.argv[1], sys.argv[2]), read_peers(sys.argv[3])
    if not benches:
        raise SystemExit("the benches measured nothing")
    folder, date = pathlib.Path(sys.argv[4]), datetime.date.today().isoformat()
    folder.mkdir(parents=True, exist_ok=True)
    files = {f"{date}.md": page(date, benches, peers, short), f"{date}.svg": dots(benches, f"Time of an iteration, {date}", shown)}
    for name, series in peers[1].items():
        files[f"{date}-{name}.svg"] = scaling(series, *SCALING[name], shown)
    for name, content in files.items():
        (folder / name).write_text(content, encoding="utf-8")
        print(f"wrote {folder / name}")


if __name__ == "__main__":
    main()
