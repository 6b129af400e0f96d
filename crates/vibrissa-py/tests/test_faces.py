"""How answers show themselves, and what calls take: lines, tables, figures, copies, units, groups of options."""

from __future__ import annotations

import base64
import inspect
import pickle
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import vibrissa


@pytest.fixture(scope="module")
def demo() -> vibrissa.Demo:
    return vibrissa.demo()


def test_every_answer_is_one_line(demo: vibrissa.Demo) -> None:
    contacts = vibrissa.contact(demo.sweep.log)
    shown = [demo, demo.answer, demo.answer.hypotheses[0], demo.sweep, demo.sweep.truth, demo.map, demo.sweep.log, contacts]
    for one in shown:
        assert "\n" not in repr(one) and len(repr(one)) <= 160, repr(one)[:400]
    assert "localized" in repr(demo.answer)


def test_notebooks_get_tables_and_figures(demo: vibrissa.Demo) -> None:
    assert "<table>" in demo.answer._repr_html_() and "localized" in demo.answer._repr_html_()
    figure = demo._repr_svg_()
    assert figure is not None and figure.startswith("<svg") and "true path" in figure
    # Notebooks show HTML alone where there are both, so that it holds the figure.
    for one in (demo, demo.answer):
        image = one._repr_html_().split("base64,")[1].split("'")[0]
        assert base64.b64decode(image).decode() == figure
    assert "<img" not in demo.sweep._repr_html_()


def test_a_localizer_says_what_it_is(demo: vibrissa.Demo) -> None:
    words = repr(vibrissa.Localizer(demo.map, method="possibilistic"))
    assert words == f"<vibrissa.Localizer: possibilistic, moment, {demo.map!r}>"


def test_readings_that_are_none_are_told(demo: vibrissa.Demo) -> None:
    reading = vibrissa.Reading("moment", "3 mN m")
    with pytest.raises(vibrissa.UsageError, match="readings: Map .*\n.*the map comes first"):
        vibrissa.preimage(reading, demo.map)  # type: ignore[arg-type]
    with pytest.raises(vibrissa.UsageError, match='readings: float .*\n.*Reading\\("moment", "3 mN m"\\)'):
        vibrissa.contact_set(0.003)  # type: ignore[arg-type]


def test_answers_become_data_frames(demo: vibrissa.Demo) -> None:
    pandas = pytest.importorskip("pandas")
    answer = demo.answer
    assert list(answer.trajectory.to_pandas()) == ["t", "x", "y", "theta"]
    assert answer.to_pandas().loc[0, "x"] == answer.hypotheses[0].x
    assert len(answer.steps.to_pandas()) == len(answer.steps.t)
    log = demo.sweep.log.to_pandas()
    assert isinstance(log, pandas.DataFrame) and log["moment"].tolist() == demo.sweep.log.readings["moment"].tolist()
    assert len(vibrissa.contact(demo.sweep.log).to_pandas()) > 0


def test_answers_are_drawn(demo: vibrissa.Demo) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    for one in (demo, demo.answer, demo.sweep, demo.map, demo.sweep.truth, vibrissa.contact(demo.sweep.log)):
        axes = one.plot()
        assert axes.lines or axes.patches
        assert one.plot(axes) is axes
        axes.figure.canvas.draw()
        boxes = [label.get_window_extent() for label in axes.get_xticklabels() if label.get_text()]
        assert len(boxes) >= 2 and all(a.x1 < b.x0 for a, b in zip(boxes, boxes[1:])), "numbers of ticks stand apart"
        matplotlib.pyplot.close("all")


def test_copies_in_other_processes_are_the_same(demo: vibrissa.Demo) -> None:
    arena, log = pickle.loads(pickle.dumps((demo.map, demo.sweep.log)))
    assert arena._parts() == demo.map._parts() and arena.bounds == demo.map.bounds
    assert log.to_csv() == demo.sweep.log.to_csv() and log.warnings == demo.sweep.log.warnings
    text = '''{"type": "FeatureCollection", "features": [{"type": "Feature", "properties":
        {"role": "arena", "name": "room", "band": 0.002, "unknown": [[1, 2]], "unknown_depth": 0.05},
        "geometry": {"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]]]}}]}'''
    inexact = vibrissa.Map.from_geojson(text)
    copy = pickle.loads(pickle.dumps(inexact))
    assert copy._parts() == inexact._parts() and copy.to_geojson() == inexact.to_geojson()
    bands, unknown = copy.bands()
    assert len(bands) == 3 and len(unknown) == 1 and "\"name\": \"room\"" in copy.to_geojson()
    again = vibrissa.localize(log, arena)
    assert again.estimate == demo.answer.estimate
    answer = pickle.loads(pickle.dumps(demo.answer))
    assert answer.estimate == demo.answer.estimate and np.array_equal(answer.states, demo.answer.states)
    error = pickle.loads(pickle.dumps(pytest.raises(vibrissa.DataError, vibrissa.Map.read, "none.svg").value))
    assert isinstance(error, FileNotFoundError)


def test_whiskers_in_the_wrong_place_are_told() -> None:
    paper = vibrissa.Robot()
    for whiskers in ([vibrissa.MountedWhisker()], vibrissa.MountedWhisker(), [vibrissa.Whisker()], vibrissa.Whisker()):
        assert vibrissa.Robot(whiskers) == paper  # type: ignore[arg-type]
    with pytest.raises(vibrissa.UsageError, match="beam=Whisker"):
        vibrissa.MountedWhisker(vibrissa.Whisker())  # type: ignore[arg-type]
    with pytest.raises(vibrissa.UsageError, match="MountedWhisker"):
        vibrissa.Robot(["left"])  # type: ignore[arg-type]


def test_lengths_take_units_and_have_to_be_plausible() -> None:
    assert vibrissa.Whisker(length="75 mm") == vibrissa.Whisker()
    mounted = vibrissa.MountedWhisker(mount=(0, "20 mm", "90 deg"), moment_relative="5 %")
    assert mounted.mount == pytest.approx((0, 0.02, np.pi / 2)) and mounted.moment_relative == pytest.approx(0.05)
    with pytest.raises(vibrissa.UsageError, match='"75 mm"'):
        vibrissa.Whisker(length=75)
    with pytest.raises(vibrissa.UsageError, match="length"):
        vibrissa.Whisker(length="75 mN")


def test_options_in_groups_are_the_options_by_name(demo: vibrissa.Demo) -> None:
    log, arena = demo.sweep.log, demo.map
    group = vibrissa.localize(log, arena, method=vibrissa.Possibilistic(tolerate=2))
    names = vibrissa.localize(log, arena, method="possibilistic", tolerate=2)
    assert group.method == "possibilistic" and np.array_equal(group.states, names.states)
    with pytest.raises(TypeError, match="tolerat"):
        vibrissa.localize(log, arena, tolerat=2)  # type: ignore[call-arg]


def test_misspelled_words_are_told_with_the_word_that_is_meant(demo: vibrissa.Demo) -> None:
    log, arena = demo.sweep.log, demo.map
    usage: list[tuple[Callable[[], object], str]] = [
        (lambda: vibrissa.localize(log, arena, method="posibilistic"), "possibilistic"),  # type: ignore[arg-type]
        (lambda: vibrissa.Localizer(arena, method="determinstic"), "deterministic"),  # type: ignore[arg-type]
        (lambda: vibrissa.plan(log, arena, criterion="exected"), "expected"),  # type: ignore[arg-type]
        (lambda: vibrissa.Reading("laod", 0.1), "load"),  # type: ignore[arg-type]
    ]
    for call, meant in usage:
        with pytest.raises(vibrissa.UsageError, match=f"did you mean '{meant}'"):
            call()
    with pytest.raises(TypeError, match="did you mean 'tolerate'"):
        vibrissa.localize(log, arena, method="possibilistic", tolerat=2)  # type: ignore[call-arg]


def test_a_log_and_a_map_show_themselves(demo: vibrissa.Demo) -> None:
    figure = demo.map._repr_svg_()
    assert figure.startswith("<svg") and 'class="solid"' in figure and "3 boundaries, 0.460 m by" in figure
    table = demo.sweep.log._repr_html_()
    assert "514 rows" in table and "moment (N m)" in table and f"{demo.sweep.log.t[-1]:.6g}" in table
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    axes = demo.sweep.log.plot()
    (line,) = axes.lines
    assert np.array_equal(line.get_ydata(), demo.sweep.log.readings["moment"])
    # The outside of the arena is shaded, as in the figures of the command.
    assert matplotlib.colors.to_hex(demo.map.plot().get_facecolor()) == "#e3e3e0"
    matplotlib.pyplot.close("all")


def test_log_and_map_in_the_wrong_order_are_told(demo: vibrissa.Demo) -> None:
    with pytest.raises(vibrissa.UsageError, match="map: SensorLog .*\n.*the log comes first"):
        vibrissa.localize(demo.map, demo.sweep.log)  # type: ignore[arg-type]
    with pytest.raises(vibrissa.UsageError, match="map: int"):
        vibrissa.localize(demo.sweep.log, 3)  # type: ignore[arg-type]


def test_what_is_no_robot_is_told_with_what_may_be_meant(demo: vibrissa.Demo) -> None:
    log, arena = demo.sweep.log, demo.map
    given: list[tuple[object, list[str]]] = [
        ("75 mm", ["'75 mm' is a length", "a robot file (.toml), a Robot", "robot=Whisker(length='75 mm')"]),
        (0.075, ["robot: 0.075", "robot=Whisker(length=0.075)"]),
        ([vibrissa.Whisker()], ["a Robot, a Whisker", "robot=Robot(whiskers=["]),
        (arena, ["robot: ", "a robot file (.toml)"]),
    ]
    for robot, words in given:
        with pytest.raises(vibrissa.UsageError) as caught:
            vibrissa.localize(log, arena, robot)  # type: ignore[arg-type]
        assert all(word in str(caught.value) for word in words), str(caught.value)
    # A name that is no length stays the name of a file that is missing.
    with pytest.raises(FileNotFoundError):
        vibrissa.localize(log, arena, "robt.toml")
    mounted = vibrissa.MountedWhisker(mount=(0.0, 0.0, 2.2))
    same = vibrissa.localize(log, arena, mounted), vibrissa.localize(log, arena, vibrissa.Robot(whiskers=(mounted,)))
    assert same[0].status == same[1].status and np.array_equal(same[0].states, same[1].states)


def test_a_missing_file_is_pythons_own_error(tmp_path: Path) -> None:
    kinds: dict[str, Callable[[Path], object]] = {
        "none.svg": vibrissa.Map.read,
        "none.csv": vibrissa.SensorLog.read,
        "none.toml": vibrissa.Robot.read,
    }
    for name, read in kinds.items():
        with pytest.raises(FileNotFoundError, match="no such file") as caught:
            read(tmp_path / name)
        assert isinstance(caught.value, vibrissa.DataError) and caught.value.file


def test_every_function_documents_arguments_and_answer() -> None:
    functions = [one for name in vibrissa.__all__ if inspect.isfunction(one := getattr(vibrissa, name))]
    assert len(functions) >= 16
    for function in functions:
        documentation = inspect.getdoc(function) or ""
        signature = inspect.signature(function)
        sections = ["Returns\n-------"] + (["Parameters\n----------"] if signature.parameters else [])
        assert all(section in documentation for section in sections), function.__name__
        missing = [name for name in signature.parameters if name not in documentation]
        assert not missing, f"{function.__name__}: {missing}"
        assert not re.search(r"(?m)^ *\{\w+\}$", documentation), f"{function.__name__}: a shared description is missing"


def test_readings_take_units(demo: vibrissa.Demo) -> None:
    reading = vibrissa.Reading("moment", "5 mN m", "5 %")
    assert reading.value == pytest.approx(5e-3) and reading.tolerance == pytest.approx(2.5e-4)
    assert vibrissa.Reading("strip", ("58 mm", "62 mm")).interval == pytest.approx((0.058, 0.062))
    with pytest.raises(vibrissa.UsageError, match="value"):
        vibrissa.Reading("load", "5 mm")
    with pytest.raises(vibrissa.UsageError, match="load, strip, slope, moment"):
        vibrissa.Reading("weight", 1.0)  # type: ignore[arg-type]
    with pytest.raises(vibrissa.UsageError, match="cell: `mN` is not the unit"):
        vibrissa.preimage(demo.map, reading, cell="5 mN")
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    sets = vibrissa.contact_set([vibrissa.Reading("load", "0.1 N"), vibrissa.Reading("strip", "60 mm")])
    assert len(sets.plot().lines) == 3, "two curves and where they meet"
    states = vibrissa.preimage(demo.map, reading, cell="5 mm", heading_step="10 deg", max_force="2 N")
    assert states.plot().lines[-1].get_xdata().size > 10
    matplotlib.pyplot.close("all")
