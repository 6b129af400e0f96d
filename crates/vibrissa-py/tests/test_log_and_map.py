"""Logs, maps and robots: arrays in, the same arrays out, and the faults of files."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vibrissa


def columns(n: int = 20) -> tuple[Any, Any, Any]:
    rng = np.random.default_rng(3)
    return np.arange(n) / 300.0, rng.normal(size=(n, 3)) * 1e-3, rng.normal(size=n) * 1e-3


def test_a_log_gives_back_its_arrays_to_the_bit() -> None:
    t, odometry, moment = columns()
    log = vibrissa.SensorLog(t, odometry, moment, heading=odometry[:, 2])
    assert len(log) == 20 and list(log.readings) == ["moment"]
    assert np.array_equal(log.t, t) and np.array_equal(log.readings["moment"], moment)
    assert np.array_equal(log.odometry, odometry) and log.odometry.shape == (20, 3)
    assert log.heading is not None and np.array_equal(log.heading, odometry[:, 2])
    assert log.t.dtype == log.odometry.dtype == np.float64


def test_strides_types_and_lists_do_not_matter(tmp_path: Path) -> None:
    t, odometry, moment = columns()
    wide = np.zeros((20, 7))
    wide[:, 1::2] = odometry
    table = np.asfortranarray(np.column_stack([t, moment]))
    log = vibrissa.SensorLog(table[:, 0], wide[:, 1::2], {"w0.moment": table[:, 1], "w1.moment": moment[::-1]})
    assert np.array_equal(log.odometry, odometry)
    assert np.array_equal(log.readings["w1.moment"], moment[::-1])
    lists = vibrissa.SensorLog(t.tolist(), odometry.tolist(), moment.astype(np.float32))
    assert np.array_equal(lists.readings["moment"], moment.astype(np.float32).astype(np.float64))
    (tmp_path / "log.csv").write_text(log.to_csv())
    again = vibrissa.SensorLog.read(tmp_path / "log.csv")
    assert again.to_csv() == log.to_csv() and np.array_equal(again.odometry, odometry)


def test_faults_of_arrays_name_the_row() -> None:
    t, odometry, moment = columns()
    bad = moment.copy()
    bad[7] = np.nan
    with pytest.raises(vibrissa.DataError, match="^row 7: .*moment") as fault:
        vibrissa.SensorLog(t, odometry, bad)
    assert fault.value.file is None and fault.value.line is None
    with pytest.raises(vibrissa.DataError, match="^row 3: t does not increase"):
        vibrissa.SensorLog(np.where(np.arange(20) == 3, 0.0, t), odometry, moment)
    with pytest.raises(vibrissa.UsageError, match="different lengths: t 20, x 20, y 20, theta 20, moment 19"):
        vibrissa.SensorLog(t, odometry, moment[1:])
    with pytest.raises(vibrissa.UsageError, match="number of columns: 2"):
        vibrissa.SensorLog(t, odometry[:, :2], moment)
    with pytest.raises(vibrissa.DataError, match="^columns: .*"):
        vibrissa.SensorLog(t, odometry, {"momentum": moment, "moment": moment, "t": t})
    with pytest.raises(TypeError):
        vibrissa.SensorLog(t, odometry, moment.reshape(4, 5))


def test_doubts_are_warnings() -> None:
    t, odometry, moment = columns()
    with pytest.warns(vibrissa.DataWarning):
        log = vibrissa.SensorLog(t, odometry, moment * 1e4)
    assert log.warnings
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        vibrissa.SensorLog(t, odometry, moment)


def test_files_at_fault_name_file_and_line(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("t,x,y,theta,moment\n0,0,0,0,0\n1,0,0,0,oops\n2,0,0,0,0\n")
    with pytest.raises(vibrissa.DataError) as fault:
        vibrissa.SensorLog.read(path)
    assert fault.value.file == str(path) and fault.value.line == 3
    assert isinstance(fault.value, vibrissa.Error) and isinstance(fault.value, ValueError)
    assert str(fault.value).startswith(f"{path}:3: ") and "\n  help: " in str(fault.value)


def test_a_map_of_points_knows_free_space() -> None:
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    post = 0.5 + 0.1 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    room = vibrissa.Map.from_points([square], [post], [[[0.2, 0.1], [0.2, 0.3]]])
    grid = np.stack(np.meshgrid(np.linspace(-0.19, 1.19, 24), np.linspace(-0.17, 1.17, 31)), axis=-1).reshape(-1, 2)
    inside = (grid > 0).all(axis=1) & (grid < 1).all(axis=1) & (np.abs(grid - 0.5) > 0.1).any(axis=1)
    assert np.array_equal(room.is_free(grid), inside)
    near = room.nearest([[0.5, 0.25], [0.21, 0.2]])
    assert np.allclose(near["distance"], [0.15, 0.01]) and near["point"].shape == (2, 2)
    assert room.bounds == (0.0, 1.0, 0.0, 1.0) and room.total_length == pytest.approx(4 + 0.8 + 0.2)
    roles = [role for role, _ in room.boundaries()]
    assert sorted(roles) == ["arena", "obstacle", "wall"]
    closed = dict(room.boundaries())["arena"]
    assert closed.shape == (5, 2) and np.array_equal(closed[0], closed[-1])
    with pytest.raises(vibrissa.DataError, match="encloses no area"):
        vibrissa.Map.from_points([square[:2]])
    with pytest.raises(vibrissa.UsageError, match="corners of a wall"):
        vibrissa.Map.from_points([square], walls=[[[0.5, 0.5]]])
    with pytest.raises(vibrissa.UsageError, match="number of columns: 3"):
        room.is_free(np.zeros((4, 3)))


def test_robots_read_back_the_same_and_are_checked(tmp_path: Path) -> None:
    whisker = vibrissa.Whisker(length=0.1, tip_ratio=0.4, curvature=1.5, curvature_rise=(3.0,), base_stiffness=0.2)
    mounted = vibrissa.MountedWhisker(
        "left",
        whisker,
        (0.1, 0.02, 1.0),
        0.3,
        zero_error=2e-4,
        zero_drift_error=2e-6,
        mount_error=(5e-4, 4e-4, 0.02),
        length_error=1e-3,
        stiffness_error=0.02,
        gain_error=0.03,
    )
    robot = vibrissa.Robot((mounted,), 0.01, 0.02, delay_error=0.02, map_scale_error=0.01)
    (tmp_path / "robot.toml").write_text(robot.to_toml())
    assert vibrissa.Robot.read(tmp_path / "robot.toml") == robot
    assert vibrissa.Robot.from_toml(vibrissa.Robot().to_toml()) == vibrissa.Robot()
    with pytest.raises(vibrissa.DataError, match="^whisker.friction is out of range: -1"):
        vibrissa.Robot((vibrissa.MountedWhisker(friction=-1.0),)).to_toml()
    with pytest.raises(vibrissa.DataError, match="^whisker.length_error is out of range: 1 m"):
        vibrissa.Robot((vibrissa.MountedWhisker(length_error=1.0),)).to_toml()
    with pytest.raises(vibrissa.UsageError, match="curvature_rise"):
        vibrissa.Robot((vibrissa.MountedWhisker(beam=vibrissa.Whisker(curvature_rise=(1.0,) * 9)),)).to_toml()


def test_the_default_whisker_is_the_papers() -> None:
    whisker = vibrissa.Whisker()
    assert (whisker.length, whisker.flexural_rigidity, whisker.is_uniform) == (0.075, 2.8886e-4, True)
    assert not vibrissa.Whisker(tip_ratio=0.5).is_uniform
