"""Writes bench/reports/DATE.md and DATE.svg from what the benches (bencher format) and the peers printed."""

import datetime
import math
import os
import platform
import re
import subprocess
import sys

LINE = re.compile(r"test (.*?)\s+\.\.\. bench:\s+([\d,.]+) ns/iter \(\+/- ([\d,.]+)\)")


def machine():
    model = "unknown processor"
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as info:
            model = next((line.split(":")[1].strip() for line in info if line.startswith("model name")), model)
    except OSError:
        pass
    rustc = subprocess.run(["rustc", "--version"], capture_output=True, text=True, check=False).stdout.strip()
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=False).stdout.strip()
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else float("nan")
    return f"{model}, {os.cpu_count()} cores, {platform.system()}; {rustc}; commit {commit}; load {load:.1f} at the end"


def ours(path):
    """[(bench, name, ns, spread)]"""
    bench, rows = "", []
    for line in open(path, encoding="utf-8"):
        if line.startswith("bench: "):
            bench = line[7:].strip()
        elif found := LINE.match(line):
            rows.append((bench, found[1], *(float(found[i].replace(",", "")) for i in (2, 3))))
    return rows


def shown(ns):
    for unit, size in (("s", 1e9), ("ms", 1e6), ("µs", 1e3)):
        if ns >= size:
            return f"{ns / size:.3g} {unit}"
    return f"{ns:.3g} ns"


def baselines(rows):
    """The baseline of each group: the row whose name says so."""
    return {(bench, name.split("/")[0]): ns for bench, name, ns, _ in rows if "baseline" in name}


def page(rows, peers, date, short):
    text = [f"# Benches of {date}", "", machine() + ".", ""]
    if short:
        text += ["The short form: few samples, so read orders of magnitude only.", ""]
    text += [f"![Times of every bench]({date}.svg)", "", "Median and spread of an iteration; the ratio is to the group's",
             "baseline in the same run (above 1: that many times as fast as the baseline).", "",
             "| bench | what | median | +/- | ratio |", "| --- | --- | --- | --- | --- |"]
    base = baselines(rows)
    for bench, name, ns, spread in rows:
        ratio = base.get((bench, name.split("/")[0]))
        told = f"{ratio / ns:.3g}" if ratio and ns and "baseline" not in name else ""
        text.append(f"| {bench} | {name} | {shown(ns)} | {shown(spread)} | {told} |")
    text += ["", "## Peers, in the same run", "", "They are told where the whisker was touched, which ours finds from moments.", "",
             "| peer | median | least | largest | remark |", "| --- | --- | --- | --- | --- |"]
    for line in peers:
        cells = line.rstrip("\n").split("\t")
        if len(cells) == 5:
            text.append("| " + " | ".join([cells[0], *(shown(1e9 * float(c)) for c in cells[1:4]), cells[4]]) + " |")
        elif len(cells) == 2:
            text.append(f"| SciPy: {cells[0]} | {shown(float(cells[1]))} | | | a shape |")
    skipped = [line.strip() for line in peers if line.startswith("SKIPPED")]
    text += [""] + [f"* {line}" for line in skipped]
    return "\n".join(text).rstrip() + "\n"


def picture(rows, date):
    """Every bench as a dot on a logarithmic axis of time, with its spread."""
    left, width, step, top = 470, 560, 17, 62
    values = [ns for *_, ns, _ in rows]
    lo, hi = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))
    place = lambda ns: left + width * (math.log10(max(ns, 10.0**lo)) - lo) / max(1, hi - lo)
    height = top + step * len(rows) + 20
    svg = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{left + width + 60}" height="{height}" font-family="sans-serif" font-size="11">',
           '<rect width="100%" height="100%" fill="white"/>',
           f'<text x="12" y="20" font-size="14">Time of an iteration, {date} (median, spread as a bar; logarithmic)</text>']
    for decade in range(lo, hi + 1):
        x = place(10.0**decade)
        svg.append(f'<line x1="{x:.1f}" y1="{top - 14}" x2="{x:.1f}" y2="{height - 14}" stroke="#ddd"/>')
        svg.append(f'<text x="{x:.1f}" y="{top - 20}" text-anchor="middle">{shown(10.0**decade)}</text>')
    for index, (bench, name, ns, spread) in enumerate(rows):
        y = top + step * index
        label = f"{bench}: {name}"
        label = (label if len(label) < 78 else label[:76] + "…").replace("&", "&amp;").replace("<", "&lt;")
        color = "#888" if "baseline" in name else "#1f5fa8"
        a, b = place(max(ns - spread, ns * 0.01)), place(ns + spread)
        svg.append(f'<text x="{left - 10}" y="{y + 4}" text-anchor="end">{label}</text>')
        svg.append(f'<line x1="{a:.1f}" y1="{y}" x2="{b:.1f}" y2="{y}" stroke="{color}" stroke-width="2"/>')
        svg.append(f'<circle cx="{place(ns):.1f}" cy="{y}" r="3.5" fill="{color}"/>')
    return "\n".join(svg + ["</svg>"]) + "\n"


def main():
    rows, folder, short = ours(sys.argv[1]), sys.argv[3], "--short" in sys.argv
    if not rows:
        raise SystemExit("the benches printed nothing")
    peers = open(sys.argv[2], encoding="utf-8").readlines()
    date = datetime.date.today().isoformat()
    os.makedirs(folder, exist_ok=True)
    for name, content in ((f"{date}.md", page(rows, peers, date, short)), (f"{date}.svg", picture(rows, date))):
        with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
            file.write(content)
        print(f"wrote {os.path.join(folder, name)}")


if __name__ == "__main__":
    main()
