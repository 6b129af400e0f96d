"""The next motion and the closed loop: the answers of the command."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import Command

import vibrissa

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="module")
def short(demo_files: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short touch in the demo's arena, which leaves some places."""
    lines = (demo_files / "log.csv").read_text().splitlines()[:140]
    file = tmp_path_factory.mktemp("plan") / "short.csv"
    file.write_text("\n".join(lines) + "\n")
    return file


def test_plans_are_those_of_the_command(command: Command, short: Path, demo_files: Path) -> None:
    told = command("plan", short, "--map", demo_files / "map.svg", "--footprint", "15 mm")
    plan = vibrissa.plan(short, demo_files / "map.svg", footprint=0.015)
    assert (plan.verdict, plan.words, plan.places) == (told["verdict"], told["words"], told["places"])
    assert (plan.readings, list(plan.looked_at)) == (told["readings"], told["looked_at"])
    motion, theirs = plan.motion, told["next"]
    assert motion is not None and motion.way == theirs["way"] and motion.stop_at == theirs["stop_at"]
    waypoints = [[one["x"], one["y"], one["theta"]] for one in theirs["waypoints"]]
    assert np.array_equal(motion.waypoints, waypoints)
    assert plan.answer.status == "ambiguous" and len(plan.answer.hypotheses) >= plan.places
    # The group of limits says the same, with units; what is given by name comes first.
    grouped = vibrissa.MotionLimits(footprint="15 mm", longest="100 mm")
    again = vibrissa.plan(short, demo_files / "map.svg", limits=grouped, longest=0.24)
    assert again.words == plan.words and again.readings == plan.readings
    # Ahead only, by what is left at worst, within a budget: another plan, and the limits are kept.
    other = vibrissa.plan(short, demo_files / "map.svg", sideways=False, criterion="worst", budget=3000)
    assert other.readings <= 3000 + 64 and other.words != plan.words


def test_what_makes_no_sense_is_refused(short: Path, demo_files: Path) -> None:
    arena = demo_files / "map.svg"
    with pytest.raises(vibrissa.UsageError, match="footprint"):
        vibrissa.plan(short, arena, footprint=-1.0)
    with pytest.raises(vibrissa.UsageError, match="criterion"):
        vibrissa.plan(short, arena, criterion="best")  # type: ignore[arg-type]
    with pytest.raises(vibrissa.UsageError, match="footprint: .*N"):
        vibrissa.MotionLimits(footprint="15 N")
    with pytest.raises(vibrissa.UsageError, match="strategy"):
        vibrissa.explore(ROOT / "scenarios/square.toml", strategy="home")  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="colour"):
        vibrissa.plan(short, arena, colour=3)  # type: ignore[call-arg]


def test_a_robot_finds_out_that_its_room_is_symmetric(command: Command) -> None:
    scenario = ROOT / "scenarios/square.toml"
    told = command("explore", scenario)
    found = vibrissa.explore(scenario)
    assert (found.ended, found.way, found.turn) == (told["ended"], told["way"], told["turn"])
    assert found.ended == "symmetric" and not found.collided
    assert [one.row for one in found.motions] == [one["row"] for one in told["motions"]]
    assert [len(one.places) for one in found.motions] == [one["places"] for one in told["motions"]]
    assert len(found.truth.t) == len(found.log.t)
    assert "symmetric" in repr(found)


WALL = """
title = "Along the lower wall, whisker ahead to the right"
seed = 1

[map]
arena = [[0, 0], [0.5, 0], [0.5, 0.4], [0, 0.4]]

[[whisker]]
mount = [0, 0, "-46 deg"]

[path]
start = ["60 mm", "57 mm", 0]

[[path.leg]]
kind = "line"
to = [["130 mm", "46 mm"]]
heading = "keep"
"""


def test_walls_are_followed_by_touch(tmp_path: Path) -> None:
    scenario = tmp_path / "wall.toml"
    scenario.write_text(WALL)
    found = vibrissa.explore(scenario, strategy="wall", most_way=0.3)
    words = {one.words for one in found.motions}
    assert "along the wall, by touch" in words <= {"along the wall, by touch", "a test of the place"}
    assert found.hardest < 1.0 and not found.collided
    # One that stops as soon as a place is told tests none.
    untested = vibrissa.explore(scenario, strategy="wall", most_way=0.3, tested=False)
    assert all(one.words != "a test of the place" for one in untested.motions)
    # Whiskers that trail cannot lead along a wall.
    with pytest.raises(vibrissa.UsageError, match="points 12 to 78 deg off"):
        vibrissa.explore(ROOT / "scenarios/square.toml", strategy="wall")
