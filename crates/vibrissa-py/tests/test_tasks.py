"""Contact sets, preimages, sweeps, contacts, outlines and calibrations: the numbers of the command."""

from __future__ import annotations

import json
import os
import pickle
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import Command, numbers, table

import vibrissa

ROOT = Path(__file__).resolve().parents[3]
SHARED = ROOT.parent / "shared"


def test_contact_sets_are_those_of_the_command(command: Command) -> None:
    told = command("contact-set", "--sensor", "moment", "--value", "0.006", "--sensor", "strip", "--value", "0.06")
    found = vibrissa.contact_set([vibrissa.Reading("moment", 0.006), vibrissa.Reading("strip", 0.06)])
    assert len(found.curves) == len(told["curves"]) == 2
    keys = ("x", "y", "s_a", "phi_a", "force", "moment")
    for mine, theirs in zip(found.curves, told["curves"], strict=True):
        assert mine.sensor == theirs["sensor"] and mine.tolerance == theirs["tolerance"]
        branches = [[[node[key] for key in keys] for node in branch] for branch in theirs["branches"]]
        assert [branch.tolist() for branch in mine.branches] == branches
    assert [(m.x, m.y) for m in found.meetings] == [(m["x"], m["y"]) for m in told["meetings"]]
    assert found.area == told["region"]["area"] and len(found.components) == told["region"]["components"]
    assert found.region.tolist() == [[cell["contact"][key] for key in keys] for cell in told["region"]["cells"]]
    assert found.radius.shape == (len(found.region),) and len(found.covers) == len(found.region)
    # Where the curves meet, the beam itself has both readings.
    bend = vibrissa.force_mode(found.meetings[0].first[4], 0.06)
    assert bend.moment[0] == pytest.approx(0.006, rel=1e-9)


def test_bounded_readings_of_several_whiskers() -> None:
    pair = vibrissa.Robot((vibrissa.MountedWhisker("a"), vibrissa.MountedWhisker("b", mount=(0.0, 0.01, 0.0))))
    readings = [vibrissa.Reading("strip", (0.05, 0.052), whisker="a"), vibrissa.Reading("load", 0.1, 0.01, "b")]
    found = vibrissa.contact_set(readings, pair, max_slope=1.0)
    assert found.curves == [] and found.area > 0 and (np.abs(found.region[:, 3]) <= 1.0).all()
    with pytest.raises(vibrissa.UsageError, match="whisker: c"):
        vibrissa.contact_set(vibrissa.Reading("load", 0.1, whisker="c"), pair)
    with pytest.raises(vibrissa.UsageError, match="load"):
        vibrissa.contact_set(vibrissa.Reading("load", (0.2, 0.1)))
    with pytest.raises(vibrissa.UsageError, match="sensor"):
        vibrissa.contact_set(vibrissa.Reading("smell", 0.2))  # type: ignore[arg-type]
    with pytest.raises(vibrissa.UsageError, match="no reading"):
        vibrissa.contact_set([])


def test_preimages_are_those_of_the_command(command: Command, demo: vibrissa.Demo, demo_files: Path, tmp_path: Path) -> None:
    words = ("--sensor", "moment", "--value", "0.005", "--tolerance", "2e-4", "--cell", "0.004", "--heading-step", "0.1")
    told = command("preimage", "--map", demo_files / "map.svg", *words, "--out", tmp_path)
    reading = vibrissa.Reading("moment", 0.005, tolerance=2e-4)
    found = vibrissa.preimage(demo.map, reading, cell=0.004, heading_step=0.1)
    assert (found.area, found.volume, found.deviation) == (told["area"], told["volume"], told["deviation"])
    states = table(tmp_path / "preimage.csv")
    assert np.array_equal(found.states, np.column_stack([numbers(cells) for cells in states.values()]))
    with pytest.raises(vibrissa.UsageError, match="heading_step"):
        vibrissa.preimage(demo.map, reading, heading_step=-1.0)


def test_scenarios_give_the_files_of_the_command(tmp_path: Path) -> None:
    scenario = ROOT / "scenarios" / "pipe.toml"
    assert vibrissa.run(["simulate", scenario, "--seed", "11", "--out", tmp_path, "--dump"]) == 0
    read = vibrissa.Scenario.read(scenario)
    found = vibrissa.simulate(read, seed=11)
    assert found.log.to_csv() == (tmp_path / "log.csv").read_text()
    found.truth.write(tmp_path / "mine.tum")
    assert (tmp_path / "mine.tum").read_text() == (tmp_path / "truth.tum").read_text()
    contacts, exact = table(tmp_path / "contacts.csv"), table(tmp_path / "exact.csv")
    assert np.array_equal(found.contacts.position[:, 0], numbers(contacts["x"])) and found.contacts.part == contacts["part"]
    assert np.array_equal(found.exact_moments[:, 0], numbers(list(exact.values())[1]))
    assert vibrissa.simulate(read).log.to_csv() != found.log.to_csv() and read.seed != 11
    assert vibrissa.Robot.from_toml(read.robot_toml()).whiskers


def test_a_sweep_of_arrays_obeys_its_noise_bound(demo: vibrissa.Demo) -> None:
    exact = vibrissa.sweep(demo.map, demo.sweep.truth)
    assert np.array_equal(exact.log.readings["moment"], exact.exact_moments[:, 0])
    noisy = vibrissa.sweep(demo.map, demo.sweep.truth, seed=4, moment_noise=(0.02, 1e-5))
    z, h = noisy.log.readings["moment"], noisy.exact_moments[:, 0]
    assert (np.abs(h - z) <= 0.02 * np.abs(z) + 1e-5 + 1e-15).all() and np.abs(h - z).max() > 1e-5
    assert exact.contacts.force.shape == (len(exact.contacts.t), 2) and exact.shapes[0].points.shape[1] == 2
    way = vibrissa.waypoints([[0.1, 0.2, 0.0], [0.2, 0.2, 1.0]], speed=0.1, turn_rate=10.0, rate=100.0)
    assert way.t[-1] == pytest.approx(1.0) and np.allclose(way.poses[-1], [0.2, 0.2, 1.0])
    with pytest.raises(vibrissa.UsageError):
        vibrissa.waypoints([])


def test_contacts_and_outlines_are_those_of_the_command(command: Command, demo_files: Path, tmp_path: Path) -> None:
    log = demo_files / "log.csv"
    assert vibrissa.run(["contact", log, "--out", tmp_path]) == 0
    told, found = table(tmp_path / "contacts.csv"), vibrissa.contact(log)
    assert found.kind == told["kind"] and found.whisker == told["whisker"]
    for name in ("t", "s_a", "distance", "std", "moment", "kaneko", "solomon", "small_angle"):
        theirs = numbers(told[name])
        mine = np.where(np.isfinite(getattr(found, name)), getattr(found, name), np.nan)
        assert np.array_equal(mine, theirs, equal_nan=True), name
    assert np.array_equal(found.position[:, 0], numbers(told["x_odom"]), equal_nan=True)
    answer = command("profile", log, "--out", tmp_path)
    outlines = vibrissa.profile([log]).outlines
    assert [outline.length for outline in outlines] == pytest.approx([one["length_m"] for one in answer["outlines"]])
    features = json.loads((tmp_path / "profile.geojson").read_text())["features"]
    lines = [f["geometry"]["coordinates"] for f in features if f["properties"]["role"] == "wall"]
    assert [outline.points.tolist() for outline in outlines] == lines
    outer, inner = outlines[0].band()
    assert np.allclose(np.linalg.norm(outer - inner, axis=1), 4 * outlines[0].std)


def test_a_map_of_a_log_is_that_of_the_command(command: Command, demo_files: Path, tmp_path: Path) -> None:
    log, truth = demo_files / "log.csv", demo_files / "map.svg"
    told = command("map", log, "--truth", truth, "--body", "5", "--out", tmp_path)
    found = vibrissa.map_log(log, truth=truth, body_radius="5 mm")
    assert (found.known, found.unknown) == (told["known_m"], told["unknown_m"]) and found.known > 0.1
    assert found.map.to_geojson() == (tmp_path / "map.geojson").read_text()
    assert len(found.corners) == len(told["corners"]) and len(found.closures) == len(told["closures"])
    assert found.alignment is not None and found.alignment.shape.mean == told["truth"]["mean_m"] < 1e-3
    assert found.scale == (told["odometry"]["scale"]["value"], told["odometry"]["scale"]["std"])
    assert found.covariances.shape == (len(found.covariance_t), 3, 3)
    assert found.graph == json.loads((tmp_path / "graph.json").read_text())
    assert len(found.graph["poses"]) == len(found.graph["legs"]) + 1 == len(found.covariances)
    again = pickle.loads(pickle.dumps(found))
    assert again.map.to_geojson() == found.map.to_geojson() and "map=<vibrissa.Map" in repr(found)
    with pytest.raises(vibrissa.UsageError):
        vibrissa.map_log(log, body_radius=-1.0)


def test_a_second_log_that_begins_where_the_first_does_is_placed(demo_files: Path) -> None:
    log = demo_files / "log.csv"
    found = vibrissa.map_log([log, log], same_start=("5 mm", "2 deg"))
    first, second = found.visits
    assert (first.placed, second.placed, second.places) == ("proved", "proved", 1) and found.changes == []
    assert np.allclose(first.trajectory.poses, second.trajectory.poses, atol=1e-3)
    assert found.trajectory is first.trajectory and {closure.logs for closure in found.closures} <= {(1, 0), (0, 0)}
    with pytest.raises(vibrissa.UsageError):
        vibrissa.map_log([])


def labelled(whisker: vibrissa.Whisker, seed: int) -> dict[str, list[float]]:
    """Contacts of a whisker with the flux of a bent, noisy, made-up sensor."""
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(0.03, 0.06, 120), rng.uniform(-0.012, 0.012, 120)
    bends = vibrissa.point_mode(x, y, whisker=whisker)
    moment = bends.moment[np.unique(bends.case, return_index=True)[1]]
    u = moment / 1e-2
    flux = 1e-3 * np.outer(u + 0.2 * u**3, [0.8, -0.6, 0.0]) + 2e-7 * rng.normal(size=(120, 3))
    return {"x": x.tolist(), "y": y.tolist(), "bx": flux[:, 0].tolist(), "by": flux[:, 1].tolist(), "moment": moment.tolist()}


def test_contacts_in_space_are_those_of_the_command(tmp_path: Path) -> None:
    point, rows = np.array([0.05, 0.004, -0.003]), []
    for k in range(30):
        at = point + [0.0, 3e-4 * k, 0.0]
        r = float(np.hypot(at[1], at[2]))
        size = vibrissa.point_mode(at[0], r).moment[0]
        rows.append((0.1 * k, 0.0, -3e-4 * k, 0.0, size * at[1] / r, size * at[2] / r))
    text = "t,x,y,theta,moment,across\n" + "".join(",".join(map(repr, map(float, row))) + "\n" for row in rows)
    (tmp_path / "log.csv").write_text(text)
    assert vibrissa.run(["contact", tmp_path / "log.csv", "--space", "--out", tmp_path]) == 0
    with pytest.warns(vibrissa.DataWarning, match="across"):
        found = vibrissa.contact_in_space(tmp_path / "log.csv")
    assert len((tmp_path / "space.csv").read_text().splitlines()) == len(found.t) + 1 == 31
    assert set(found.kind) == {"side"} and np.abs(found.position - point).max() < 1e-5
    assert (found.x_bounds[:, 0] < found.x).all() and (found.angle < found.angle_bounds[:, 1]).all()
    assert [event.kind for event in found.events][:2] == ["contact", "side_contact"]
    assert len(found.to_pandas()) == 30


def test_contacts_all_around_calibrate_both_axes() -> None:
    rng = np.random.default_rng(4)
    angle, x, r = rng.uniform(-np.pi, np.pi, 200), rng.uniform(0.05, 0.07, 200), rng.uniform(1e-4, 2e-3, 200)
    size = np.array([vibrissa.point_mode(a, b).moment[0] for a, b in zip(x, r, strict=True)])
    both = np.column_stack([size * np.cos(angle), size * np.sin(angle)])
    flux = 1e-4 + both @ np.array([[0.1, -0.02], [0.03, 0.12]]).T
    columns = {"x": x, "y": r * np.cos(angle), "z": r * np.sin(angle), "bx": flux[:, 0], "by": flux[:, 1]}
    found = vibrissa.calibrate(columns).calibration
    assert found.inputs == ["bx", "by"] and found.moment_bounds is not None
    moments = found.moments(flux)
    assert moments.shape == (200, 2) and np.abs(moments - both).max() < 1e-6
    assert np.array_equal(found.moment(flux), moments[:, 0])
    with pytest.raises(vibrissa.DataError, match="beyond the calibrated range"):
        found.moments([[1.0, 1.0]])
    flat = vibrissa.calibrate({"x": x, "y": r, "bx": 0.1 * size}).calibration
    assert flat.moment_bounds is None
    with pytest.raises(vibrissa.DataError, match="column z"):
        flat.moments([[0.0]])


def test_calibrations_are_those_of_the_command_and_find_the_truth(tmp_path: Path) -> None:
    stiff = vibrissa.Whisker(flexural_rigidity=3.3e-4, base_stiffness=0.08)
    columns = labelled(stiff, 1)
    rows = zip(*columns.values(), strict=True)
    text = ",".join(columns) + "\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows)
    (tmp_path / "contacts.csv").write_text(text)
    free = ["flexural_rigidity", "base_compliance"]
    assert vibrissa.run(["calibrate", tmp_path / "contacts.csv", "--free", ",".join(free), "--out", tmp_path]) == 0
    found = vibrissa.calibrate(tmp_path / "contacts.csv", free=free)
    assert found.calibration.to_json() == (tmp_path / "cal.json").read_text()
    arrays = vibrissa.calibrate({name: np.array(values) for name, values in columns.items()}, free=free)
    told = json.loads(arrays.calibration.to_json())
    assert told["whisker"] == json.loads(found.calibration.to_json())["whisker"]
    assert told["whisker"]["flexural_rigidity"] == pytest.approx(3.3e-4, rel=1e-6)
    assert told["whisker"]["base_stiffness"] == pytest.approx(0.08, rel=1e-5)
    other = labelled(stiff, 2)
    assert arrays.calibration.inputs == ["bx", "by"] and arrays.calibration.moment_bound is not None
    readings = np.column_stack([other["bx"], other["by"]])
    inside = np.abs(other["moment"]) < 5e-3
    moments = arrays.calibration.moment(readings[inside])
    assert np.abs(moments - np.array(other["moment"])[inside]).max() <= 2 * arrays.calibration.moment_bound
    with pytest.raises(vibrissa.DataError, match="beyond the calibrated range"):
        arrays.calibration.moment([[1e-2, 0.0]])
    arrays.calibration.write(tmp_path / "again.json")
    assert vibrissa.Calibration.read(tmp_path / "again.json").to_json() == arrays.calibration.to_json()
    with pytest.raises(vibrissa.UsageError, match="number of inputs: 1"):
        arrays.calibration.moment(readings[:, :1])
    with pytest.raises(vibrissa.UsageError, match="free: stiffness"):
        vibrissa.calibrate(columns, free=["stiffness"])
    with pytest.raises(vibrissa.UsageError, match="nothing to calibrate from"):
        vibrissa.calibrate()


@pytest.mark.filterwarnings("ignore::vibrissa.DataWarning")
@pytest.mark.skipif(not SHARED.is_dir(), reason="no shared folder beside the repository")
def test_taps_are_those_of_the_command(tmp_path: Path) -> None:
    files = sorted((SHARED / "data" / "ratatouille").glob("*_*.csv"))
    known = {float(file.stem.rsplit("_", 1)[1]) * 1e-3: file for file in files if file.stem.rsplit("_", 1)[1].isdigit()}
    assert len(known) >= 4
    pairs = [f"{distance}={file}" for distance, file in known.items()]
    assert vibrissa.run(["calibrate", "--taps", *pairs, "--out", tmp_path]) == 0
    found = vibrissa.calibrate(taps=known)
    assert found.calibration.to_json() == (tmp_path / "cal.json").read_text()
    assert found.left_out is not None and np.nanmean(np.abs(np.diff(found.left_out, axis=1))) < 1.5e-3
    one = next(iter(known.values()))
    words: list[str | os.PathLike[str]] = ["contact", one, "--taps", "--calibration", tmp_path / "cal.json", "--out", tmp_path]
    assert vibrissa.run(words) == 0
    assert np.array_equal(vibrissa.taps(one, found.calibration).distance, numbers(table(tmp_path / "taps.csv")["distance"]), equal_nan=True)


def test_errors_have_the_texts_and_codes_of_the_command(capfd: pytest.CaptureFixture[str], demo_files: Path) -> None:
    log = demo_files / "log.csv"
    arena = demo_files / "map.svg"
    cases: list[tuple[list[str | os.PathLike[str]], Callable[[], object], int]] = [
        (["localize", "nowhere.csv", "--map", arena], lambda: vibrissa.localize("nowhere.csv", arena), 1),
        (["localize", log, "--map", log], lambda: vibrissa.localize(log, log), 1),
        (
            ["localize", log, "--map", arena, "--method", "deterministic", "--tolerance", "99"],
            lambda: vibrissa.localize(log, arena, method="deterministic", tolerance=99),
            2,
        ),
        (["beam", "force", "--force", "0.1", "--s-a", "0.08"], lambda: vibrissa.force_mode(0.1, 0.08), 2),
    ]
    for args, call, code in cases:
        assert vibrissa.run(args) == code
        told = capfd.readouterr().err
        with pytest.raises(vibrissa.DataError if code == 1 else vibrissa.UsageError) as fault:
            call()
        assert told.startswith("error: " + str(fault.value)), told
