"""Localization: the answers of the command, progress, and Ctrl-C."""

from __future__ import annotations

import dataclasses
import inspect
import json
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from conftest import Command, numbers, table

import vibrissa
from vibrissa import _methods, _vibrissa

METHODS = ["deterministic", "possibilistic", "probabilistic"]


@pytest.mark.parametrize("method", METHODS)
def test_answers_are_those_of_the_command_to_the_bit(
    method: vibrissa.Method, demo_files: Path, tmp_path: Path, command: Command
) -> None:
    log, arena, truth = (demo_files / name for name in ("log.csv", "map.svg", "truth.tum"))
    told = command("localize", log, "--map", arena, "--truth", truth, "--method", method, "--out", tmp_path)
    answer = vibrissa.localize(log, arena, method=method, truth=truth)
    assert answer.status == told["status"] == "localized" and answer.method == method
    assert answer.estimate == tuple(told["estimate"][key] for key in ("x", "y", "theta"))
    assert len(answer.hypotheses) == len(told["hypotheses"])
    for mine, theirs in zip(answer.hypotheses, told["hypotheses"], strict=True):
        for key in ("x", "y", "theta", "weight", "x_min", "x_max", "theta_min", "theta_max"):
            assert getattr(mine, key) == theirs[key], key
        if mine.covariance is not None:
            assert mine.covariance.tolist() == theirs["covariance"]
        assert mine.ridge.tolist() == theirs.get("ridge", [])
    # Errors that no one declared are estimated along.
    assert (answer.odometry is None) == ("odometry" not in told) == (method != "probabilistic")
    assert answer.odometry is None or dataclasses.asdict(answer.odometry) == told["odometry"]
    assert [(e.t, e.kind, e.detail) for e in answer.events] == [(e["t"], e["kind"], e["detail"]) for e in told["events"]]
    assert answer.error is not None and answer.error.final_position == told["truth"]["final_position_m"]
    states, steps = table(tmp_path / "states.csv"), table(tmp_path / "steps.csv")
    assert np.array_equal(answer.states, np.column_stack([numbers(cells) for cells in states.values()]))
    assert np.array_equal(answer.steps.t, numbers(steps["t"]))
    assert np.array_equal(answer.steps.volume, numbers(steps["volume"]))
    answer.trajectory.write(tmp_path / "mine.tum")
    assert (tmp_path / "mine.tum").read_text() == (tmp_path / "trajectory.tum").read_text()
    # The truth is where the answer says, by the truth's own file.
    last = vibrissa.Trajectory.read(truth).poses[-1]
    assert answer.estimate is not None and np.hypot(*(np.array(answer.estimate) - last)[:2]) < 1e-3


def test_odometry_that_may_be_wrong_is_estimated(demo_files: Path, tmp_path: Path, command: Command) -> None:
    log, arena = demo_files / "log.csv", demo_files / "map.svg"
    robot = tmp_path / "robot.toml"
    robot.write_text("[odometry]\ntranslation_relative = 0.01\nrotation_relative = 0.01\n[[whisker]]\nname = 'w0'\n")
    told = command("localize", log, "--map", arena, "--robot", robot, "--method", "probabilistic")
    answer = vibrissa.localize(log, arena, robot, method="probabilistic")
    assert answer.odometry is not None and dataclasses.asdict(answer.odometry) == told["odometry"]
    # The demo's odometry is right.
    assert abs(answer.odometry.translation_scale - 1) < 3 * answer.odometry.translation_scale_std < 0.02
    assert abs(answer.odometry.rotation_scale - 1) < 3 * answer.odometry.rotation_scale_std < 0.02


def test_what_is_said_of_errors_fit_and_doubts_is_the_commands(demo_files: Path, command: Command) -> None:
    log, arena = demo_files / "log.csv", demo_files / "map.svg"
    told = command("localize", log, "--map", arena)
    answer = vibrissa.localize(log, arena)
    assert [dataclasses.asdict(one) for one in answer.nuisances] == told["nuisances"]
    assert answer.unsure.tolist() == [[one["from"], one["to"]] for one in told["unsure"]]
    assert answer.unsure.shape[1] == 2
    assert (answer.consistency is None) == (told["consistency"] is None)


def test_an_inconsistent_answer_has_no_pose(demo_files: Path) -> None:
    log = vibrissa.SensorLog.read(demo_files / "log.csv")
    mirrored = vibrissa.SensorLog(log.t, log.odometry, -log.readings["moment"])
    answer = vibrissa.localize(mirrored, demo_files / "map.svg", truth=demo_files / "truth.tum")
    assert answer.status == "inconsistent"
    assert answer.estimate is None and answer.hypotheses == [] and answer.error is None
    assert answer.consistency is not None
    best = answer.consistency.remedies[0]
    assert "the sign of w0.moment" in best.change and best.status == "localized"


def test_a_place_along_a_straight_wall_is_a_curve(tmp_path: Path, command: Command) -> None:
    corners = [(-0.25, -0.25), (0.25, -0.25), (0.25, 0.25), (-0.25, 0.25), (-0.25, -0.25)]
    room = tmp_path / "room.geojson"
    outline = {"type": "Polygon", "coordinates": [corners]}
    feature = {"type": "Feature", "properties": {"role": "arena"}, "geometry": outline}
    room.write_text(json.dumps({"type": "FeatureCollection", "features": [feature]}))
    way = [(-0.05, 0.18, 2.2), (-0.05, 0.2, 2.2), (0.1, 0.2, 2.2)]
    scenario = tmp_path / "sweep.toml"
    scenario.write_text(f'seed = 4\nmap = "room.geojson"\n[path]\nwaypoints = {[list(pose) for pose in way]}\n')
    command("simulate", scenario, "--out", tmp_path)
    told = command("localize", tmp_path / "log.csv", "--map", room, "--method", "probabilistic")
    answer = vibrissa.localize(tmp_path / "log.csv", room, method="probabilistic")
    assert len(answer.hypotheses) == 4
    for mine, theirs in zip(answer.hypotheses, told["hypotheses"], strict=True):
        assert mine.ridge.shape[0] > 5 and mine.ridge.tolist() == theirs["ridge"]
    # One of the four straight lines goes through the truth.
    x, y, theta = vibrissa.Trajectory.read(tmp_path / "truth.tum").poses[-1]
    near = [
        np.abs(ridge[:, 1] - y).max() < 1e-3
        and np.abs(ridge[:, 2] - theta).max() < 0.01
        and ridge[:, 0].min() < x < ridge[:, 0].max()
        for ridge in (place.ridge for place in answer.hypotheses)
    ]
    assert near.count(True) == 1


def test_arrays_in_memory_give_the_same_answer(demo: vibrissa.Demo, demo_files: Path) -> None:
    from_files = vibrissa.localize(demo_files / "log.csv", demo_files / "map.svg")
    assert demo.answer.estimate == from_files.estimate
    log = demo.sweep.log
    again = vibrissa.SensorLog(log.t, log.odometry, log.readings)
    assert vibrissa.localize(again, demo.map, vibrissa.Whisker()).estimate == from_files.estimate
    assert demo.answer.trajectory.poses.shape == (len(demo.answer.trajectory), 3)
    assert demo.answer.first_states.shape[1] == 3 and demo.answer.states.shape[1] == 6


def test_options_reach_the_method_and_strangers_are_refused(demo: vibrissa.Demo) -> None:
    coarse = vibrissa.localize(demo.sweep.log, demo.map, method="deterministic", boundary_spacing=0.01)
    assert len(coarse.first_states) < len(vibrissa.localize(demo.sweep.log, demo.map, method="deterministic").first_states) / 2
    x, y, _ = demo.sweep.truth.poses[0]
    near = (x - 0.02, x + 0.02, y - 0.02, y + 0.02, -3.2, 3.2)
    boxed = vibrissa.localize(demo.sweep.log, demo.map, method="possibilistic", within=near, work=20, last_work=0)
    inside = boxed.states
    last = demo.sweep.truth.poses[-1]
    assert boxed.status != "inconsistent"
    assert ((inside[:, 0] <= last[0]) & (last[0] <= inside[:, 1]) & (inside[:, 2] <= last[1]) & (last[1] <= inside[:, 3])).any()
    refused: list[tuple[Callable[[], object], str]] = [
        (lambda: vibrissa.localize(demo.sweep.log, demo.map, tolerate=1), "tolerate is none of the method probabilistic"),
        (lambda: vibrissa.localize(demo.sweep.log, demo.map, method="deterministic", history_shapes=9), "history_shapes"),
        (lambda: vibrissa.localize(demo.sweep.log, demo.map, method="probabilistic", tolerated_share=0.9), "tolerated_share"),
        (lambda: vibrissa.localize(demo.sweep.log, demo.map, method="magic"), "allowed: deterministic"),  # type: ignore[arg-type]
        (lambda: vibrissa.localize(demo.sweep.log, demo.map, method="deterministic", tip_load="x"), "boundary-normal"),  # type: ignore[arg-type]
    ]
    for call, words in refused:
        with pytest.raises(vibrissa.UsageError, match=words):
            call()


def test_methods_and_their_default_are_the_librarys() -> None:
    names = _vibrissa.methods()
    assert sorted(names) == sorted(METHODS) == sorted(get_args(vibrissa.Method))
    for function in (vibrissa.localize, vibrissa.demo):
        assert inspect.signature(function).parameters["method"].default == names[0]


def test_every_option_of_the_command_is_an_argument() -> None:
    told = subprocess.run([sys.executable, "-m", "vibrissa", "localize", "--help"], capture_output=True, text=True, check=True)
    options = {name.replace("-", "_") for name in re.findall(r"^ +(?:-\w, )?--([a-z-]+)", told.stdout, re.M)}
    arguments = set(inspect.signature(vibrissa.localize).parameters) | set(_methods.Options.__annotations__)
    groups = (vibrissa.Deterministic, vibrissa.Possibilistic, vibrissa.Probabilistic)
    assert {one.name for group in groups for one in dataclasses.fields(group)} == set(_methods.Options.__annotations__)
    # What is written where is the command's own business; what a recording is read for, that of `SensorLog.read`.
    read = {"headings", "yaw_rates"}
    assert read <= set(inspect.signature(vibrissa.SensorLog.read).parameters)
    written = {"out", "json", "mcap", "pictures", "animate", "help"}
    assert len(options) > 20 and options - arguments == written | read, options - arguments


def test_progress_is_told_in_this_thread_and_rises_to_the_end(demo: vibrissa.Demo) -> None:
    seen: list[tuple[int, int]] = []
    threads = set()

    def progress(done: int, total: int) -> None:
        seen.append((done, total))
        threads.add(threading.get_ident())

    vibrissa.localize(demo.sweep.log, demo.map, method="probabilistic", progress=progress)
    rows = len(demo.sweep.log)
    assert seen[-1] == (rows, rows) and [done for done, _ in seen] == sorted(done for done, _ in seen)
    assert threads == {threading.get_ident()}


def test_a_fault_of_the_callback_ends_the_work(demo: vibrissa.Demo) -> None:
    def progress(done: int, total: int) -> None:
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        vibrissa.localize(demo.sweep.log, demo.map, method="possibilistic", progress=progress)


def test_simulations_tell_their_progress_and_end_with_the_callback(demo: vibrissa.Demo) -> None:
    seen: list[tuple[int, int]] = []
    path = demo.sweep.truth

    def progress(done: int, total: int) -> None:
        seen.append((done, total))
        if len(seen) == 3:
            raise LookupError("enough")

    began = time.monotonic()
    with pytest.raises(LookupError, match="enough"):
        vibrissa.sweep(demo.map, path, discrete_rod=True, progress=progress)
    # The whole takes minutes.
    assert time.monotonic() - began < 20.0
    assert len(seen) == 3 and all(total == len(path.t) and 0 < done < total for done, total in seen)


def test_other_threads_run_on_meanwhile(demo: vibrissa.Demo) -> None:
    counted = 0
    over = threading.Event()

    def count() -> None:
        nonlocal counted
        while not over.is_set():
            counted += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    vibrissa.localize(demo.sweep.log, demo.map, method="possibilistic")
    over.set()
    thread.join()
    assert counted > 5


INTERRUPTED = """
import signal, sys, vibrissa, numpy as np
# Jobs in the background inherit that interrupts are ignored.
signal.signal(signal.SIGINT, signal.default_int_handler)
demo = vibrissa.demo()
work = {
    "localize": lambda: vibrissa.localize(demo.sweep.log, demo.map, method="possibilistic", work=10**6),
    "beam": lambda: vibrissa.point_mode(np.full(10**6, 0.05), 0.02, whisker=vibrissa.Whisker(tip_ratio=0.3)),
    "sweep": lambda: vibrissa.sweep(demo.map, demo.sweep.truth, discrete_rod=True),
    "preimage": lambda: vibrissa.preimage(demo.map, vibrissa.Reading("moment", 5e-3, 2e-4), cell=1e-4),
}[sys.argv[1]]
print("ready", flush=True)
try:
    work()
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals are sent otherwise there")
@pytest.mark.parametrize("work", ["localize", "beam", "sweep", "preimage"])
def test_ctrl_c_ends_long_work(work: str) -> None:
    process = subprocess.Popen([sys.executable, "-c", INTERRUPTED, work], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    try:
        assert process.stdout.readline() == "ready\n"
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        # Each of these would take minutes.
        output, _ = process.communicate(timeout=20)
    finally:
        process.kill()
    assert output == "interrupted\n" and process.returncode == 0
