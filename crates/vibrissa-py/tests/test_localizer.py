"""Row by row: the answers of whole logs, the example node, and what cannot be."""

from __future__ import annotations

import importlib.util
import math
import sys
import types
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vibrissa

METHODS: list[vibrissa.Method] = ["deterministic", "possibilistic", "probabilistic"]


@pytest.mark.parametrize("method", METHODS)
def test_rows_one_by_one_give_the_answer_of_the_whole_log(method: vibrissa.Method) -> None:
    demo = vibrissa.demo(seed=3, method=method)
    log = demo.sweep.log
    localizer = vibrissa.Localizer(vibrissa.arena(), method=method)
    assert localizer.columns == ("moment",) and localizer.estimate().status == "no_contact"
    moments = log.readings["moment"]
    for t, pose, moment in zip(log.t, log.odometry, moments, strict=True):
        localizer.step(float(t), pose, float(moment))
    now = localizer.estimate()
    assert now.rows == len(moments) and now.pose is not None
    x, y, _ = demo.sweep.truth.poses[-1]
    # The guaranteed set keeps what it cannot rule out until the end.
    assert now.status == ("ambiguous" if method == "possibilistic" else "localized")
    assert any(h.x_min - 1e-3 <= x <= h.x_max + 1e-3 and h.y_min - 1e-3 <= y <= h.y_max + 1e-3 for h in now.hypotheses)
    assert (now.hypotheses[0].covariance is not None) == (method == "probabilistic")
    answer = localizer.finish()
    assert answer.status == demo.answer.status and answer.estimate == demo.answer.estimate
    assert np.array_equal(answer.states, demo.answer.states)
    with pytest.raises(RuntimeError, match="has finished"):
        localizer.estimate()


def test_rows_that_cannot_be_are_refused_and_the_next_may_follow() -> None:
    localizer = vibrissa.Localizer(vibrissa.arena(), columns=["moment"], options={"within": (0, 0.5, 0, 0.4, -3.2, 3.2)})
    localizer.step(0.0, (0, 0, 0), 0.0)
    with pytest.raises(vibrissa.DataError, match="t does not increase"):
        localizer.step(0.0, (0, 0, 0), 0.0)
    with pytest.raises(vibrissa.DataError, match="no number"):
        localizer.step(1.0, (0, math.nan, 0), 0.0)
    with pytest.raises(vibrissa.UsageError, match="number of readings: 2"):
        localizer.step(1.0, (0, 0, 0), (0.0, 0.0))
    localizer.step(1.0, (0, 0, 0), [0.0], heading=0.1)
    assert localizer.estimate().rows == 2
    with pytest.raises(vibrissa.UsageError, match="unknown column"):
        vibrissa.Localizer(vibrissa.arena(), columns=["momentum"])
    with pytest.raises(vibrissa.UsageError, match="options? "):
        vibrissa.Localizer(vibrissa.arena(), options={"tolerance": 1.0})
    with pytest.raises(vibrissa.DataError, match="bx"):
        vibrissa.Localizer(vibrissa.arena(), columns=["bx"])


def test_the_example_node_publishes_where_the_robot_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """By stand-ins for rclpy and the messages: there is no ROS here."""
    published: list[Any] = []
    subscribed: dict[str, Any] = {}

    class Node:
        def __init__(self, name: str) -> None:
            self.name = name

        def declare_parameter(self, name: str, default: Any) -> Any:
            given = {"map": vibrissa.arena()}.get(name, default)
            return types.SimpleNamespace(value=given)

        def create_subscription(self, kind: type, topic: str, callback: Any, qos: Any) -> None:
            subscribed[topic] = callback

        def create_publisher(self, kind: type, topic: str, qos: Any) -> Any:
            return types.SimpleNamespace(publish=published.append)

        def get_logger(self) -> Any:
            return types.SimpleNamespace(warning=print, info=print)

    def message(**fields: Any) -> Any:
        return types.SimpleNamespace(**fields)

    class Pose(types.SimpleNamespace):
        def __init__(self) -> None:
            position, orientation = message(x=0.0, y=0.0), message(x=0.0, y=0.0, z=0.0, w=1.0)
            pose = message(position=position, orientation=orientation)
            super().__init__(header=message(frame_id="", stamp=None), pose=message(pose=pose, covariance=[0.0] * 36))

    modules: dict[str, dict[str, Any]] = {
        "rclpy": {"init": None, "spin": None},
        "rclpy.node": {"Node": Node},
        "rclpy.qos": {"qos_profile_sensor_data": 10},
        "geometry_msgs": {},
        "geometry_msgs.msg": {"PoseWithCovarianceStamped": Pose, "WrenchStamped": object},
        "nav_msgs": {},
        "nav_msgs.msg": {"Odometry": object},
    }
    for name, content in modules.items():
        module = types.ModuleType(name)
        vars(module).update(content)
        monkeypatch.setitem(sys.modules, name, module)
    path = Path(__file__).parents[1] / "examples" / "localizer_node.py"
    spec = importlib.util.spec_from_file_location("localizer_node", path)
    assert spec is not None and spec.loader is not None
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    example.LocalizerNode()
    code = [line for line in path.read_text().splitlines() if line.strip() and not line.strip().startswith(("import ", "from ", '"""'))]
    assert len(code) <= 40, len(code)
    sweep = vibrissa.demo(seed=1).sweep

    def stamp(t: float) -> Any:
        return message(sec=int(t), nanosec=int((t - int(t)) * 1e9))

    moments = sweep.log.readings["moment"]
    for row, (t, pose, moment) in enumerate(zip(sweep.log.t, sweep.log.odometry, moments, strict=True)):
        if row % 6 == 0:
            x, y, theta = pose
            orientation = message(x=0.0, y=0.0, z=math.sin(theta / 2), w=math.cos(theta / 2))
            inner = message(position=message(x=x, y=y), orientation=orientation)
            subscribed["odom"](message(header=message(stamp=stamp(t)), pose=message(pose=inner)))
        wrench = message(torque=message(z=moment))
        subscribed["whisker/wrench"](message(header=message(stamp=stamp(t)), wrench=wrench))
    last = published[-1].pose.pose.position
    assert published[-1].header.frame_id == "map"
    assert math.hypot(last.x - sweep.truth.poses[-1][0], last.y - sweep.truth.poses[-1][1]) < 5e-3
