"""One line for each sweep: verdict, error of the best place, the place that holds the truth, updates until one is left."""

import csv
import json
import math
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

BIASED = """[[whisker]]
noise = { moment_relative = 0.055, moment_absolute = 2e-5 }
[odometry]
translation_relative = 0.0101
rotation_relative = 0.0101
"""


def last_pose(tum: Path) -> tuple[float, float, float]:
    """x, y, heading (m, m, rad) of the last line of a trajectory."""
    lines = [line for line in tum.read_text().splitlines() if line.strip() and not line.startswith("#")]
    row = [float(v) for v in lines[-1].split()]
    return row[1], row[2], 2.0 * math.atan2(row[6], row[7])


def error(pose: dict, truth: tuple[float, float, float]) -> tuple[float, float]:
    """Distance (mm) and turn (deg) of a pose from the truth."""
    turn = (math.degrees(pose["theta"] - truth[2]) + 180.0) % 360.0 - 180.0
    return 1e3 * math.hypot(pose["x"] - truth[0], pose["y"] - truth[1]), abs(turn)


def inside(place: dict, truth: tuple[float, float, float]) -> bool:
    """Whether a place's extent holds the truth, in all three coordinates."""
    middle = 0.5 * (place["theta_min"] + place["theta_max"])
    turned = middle + (truth[2] - middle + math.pi) % (2.0 * math.pi) - math.pi
    values = (truth[0], truth[1], turned)
    return all(place[f"{k}_min"] <= v <= place[f"{k}_max"] for k, v in zip(("x", "y", "theta"), values))


def alone(steps: Path) -> str:
    """After how many updates the set came down to one component for good."""
    with steps.open() as file:
        counts = [int(row["components"]) for row in csv.DictReader(file)]
    if not counts or counts[-1] != 1:
        return "never"
    return str(max((i + 1 for i, count in enumerate(counts) if count != 1), default=0) + 1)


def main(vibrissa: str, folder: Path, options: list[str]) -> None:
    """Prints the table."""
    print(f"{'sweep':18}{'unique':8}{'verdict':14}{'best, mm':>10}{'deg':>8}{'places':>8}{'truth in':>10}{'alone after':>13}{'time, s':>9}")
    unique = []
    with tempfile.TemporaryDirectory() as scratch:
        robot = Path(scratch, "biased.toml")
        robot.write_text(BIASED)
        for file in sorted(folder.glob("*.truth.tum")):
            name = file.name.removesuffix(".truth.tum")
            log, about = folder / f"{name}.csv", folder / f"{name}.json"
            facts = json.loads(about.read_text()) if about.exists() else {}
            map_file = folder / f"{facts.get('map', name.split('-')[0])}.geojson"
            call = [vibrissa, "localize", str(log), "--map", str(map_file), "--json", "--out", scratch, *options]
            if name.endswith("-bias"):
                call += ["--robot", str(robot)]
            done = subprocess.run(call, capture_output=True, text=True, check=False)
            if done.returncode != 0:
                print(f"{name:18}{done.stderr.strip()}")
                continue
            answer, truth = json.loads(done.stdout), last_pose(file)
            places = answer["hypotheses"]
            holding = [str(i + 1) for i, p in enumerate(places) if inside(p, truth)]
            best = error(answer["estimate"], truth) if answer["estimate"] else (math.nan, math.nan)
            if facts.get("unique"):
                unique.append(best)
            print(
                f"{name:18}{str(facts.get('unique')):8}{answer['status']:14}{best[0]:10.2f}{best[1]:8.2f}"
                f"{len(places):8}{','.join(holding) or 'none':>10}"
                f"{alone(Path(scratch, 'steps.csv')):>13}{answer['runtime']['total_s']:9.2f}"
            )
    if unique:
        mm, deg = zip(*unique)
        print(f"unique sweeps: median {statistics.median(mm):.2f} mm, {statistics.median(deg):.2f} deg; worst {max(mm):.2f} mm")


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), sys.argv[3:])
