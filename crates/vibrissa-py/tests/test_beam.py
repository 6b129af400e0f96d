"""Loaded whiskers: shapes, types and strides of arrays, faults, and the numbers of the command."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import Command

import vibrissa

NAMES = ["force", "s_a", "phi_a", "beta", "x", "y", "moment", "energy"]


def test_numbers_are_those_of_the_command_to_the_bit(command: Command) -> None:
    answer = command("beam", "moment", "--moment=-0.008", "--s-a", "0.075")["solutions"]
    bends = vibrissa.moment_mode(-0.008, 0.075)
    assert len(bends) == len(answer) == 2
    for name in NAMES:
        assert getattr(bends, name).tolist() == [one[name] for one in answer], name
    assert bends.shape().tolist() == [one["shape"] for one in answer]
    assert bends.tip.tolist() == [one["tip"] for one in answer]
    assert bends.force_vector.tolist() == [one["force_vector"] for one in answer]
    strain = [[one["largest_strain"][key] for key in ("s", "curvature", "strain")] for one in answer]
    assert bends.largest_strain().tolist() == strain


def test_batches_are_those_of_the_command_to_the_bit(tmp_path: Path) -> None:
    rng = np.random.default_rng(20261121)
    n = 60
    x, y = rng.uniform(0.02, 0.07, n), rng.uniform(-0.03, 0.03, n)
    kinds = [rng.choice(values, n).tolist() for values in ([1.0, 0.3], [0.0, -4.0], [np.inf, 0.02])]
    whiskers = [
        vibrissa.Whisker(tip_ratio=r, curvature=k, base_stiffness=b) for r, k, b in zip(*kinds, strict=True)
    ]
    rows = [",".join(map(repr, row)) for row in zip(x.tolist(), y.tolist(), *kinds, strict=True)]
    (tmp_path / "batch.csv").write_text("x,y,r_tip,kappa0,k_base\n" + "\n".join(rows) + "\n")
    assert vibrissa.run(["beam", "point", "--batch", tmp_path / "batch.csv", "--out", tmp_path]) == 0
    bends = vibrissa.point_mode(x, y, whisker=whiskers)
    # The answers follow the input's five columns; a line without a solution has none.
    lines = [line.split(",")[5:] for line in (tmp_path / "beam.csv").read_text().splitlines()[1:]]
    found = np.array([[float(cell) for cell in line] for line in lines if line[0]])
    mine = np.column_stack([bends.phi_a, bends.x, bends.y, bends.moment, bends.force, bends.s_a])
    assert len(bends) > n // 2
    assert np.array_equal(mine, found)


def test_statics_hold_for_random_loads_of_either_sign() -> None:
    rng = np.random.default_rng(5)
    force, s_a, beta = rng.uniform(-0.3, 0.3, 500), rng.uniform(0.01, 0.075, 500), rng.uniform(-0.5, 0.5, 500)
    bends = vibrissa.force_mode(force, s_a, load="tilted", angle=beta)
    f = bends.force_vector
    assert np.allclose(bends.moment, bends.x * f[:, 1] - bends.y * f[:, 0], rtol=1e-9, atol=1e-12)
    assert np.array_equal(bends.force, force[bends.case])
    # The shape passes through the contact, and its length is the whisker's.
    shape = bends.shape(2001)
    lengths = np.linalg.norm(np.diff(shape, axis=1), axis=2).sum(axis=1)
    assert np.allclose(lengths, 0.075, rtol=2e-6)
    small = vibrissa.force_mode(1e-4, 0.05)
    stiffness = vibrissa.Whisker().flexural_rigidity
    assert small.y[0] == pytest.approx(1e-4 * 0.05**3 / (3 * stiffness), rel=1e-5)


def test_shapes_types_and_branches() -> None:
    bends = vibrissa.moment_mode([[0.004], [0.008]], [0.05, 0.06, 0.5e-1])
    assert bends.problems == 6
    assert bends.case.dtype == np.int64 and bends.case.shape == (len(bends),)
    assert set(bends.case.tolist()) == set(range(6)) and bends.branch.max() == 1
    for name in NAMES:
        column = getattr(bends, name)
        assert column.dtype == np.float64 and column.shape == (len(bends),), name
    assert bends.shape(7).shape == (len(bends), 7, 2)
    assert bends.shape(1).shape == (len(bends), 0, 2)
    assert bends.shape_points(5).shape == (len(bends), 5, 5)
    last = bends[-1]
    assert (last.case, last.branch, last.x) == (bends.case[-1], bends.branch[-1], bends.x[-1])
    assert [bend.moment for bend in bends] == bends.moment.tolist()
    with pytest.raises(IndexError):
        bends[len(bends)]


@pytest.mark.parametrize("make", [lambda v: v[::-3], lambda v: v[::2].astype(np.float64, order="F"), lambda v: np.broadcast_to(v[0], 9), list])
def test_strides_do_not_matter(make: object) -> None:
    force = np.linspace(0.01, 0.3, 40)
    given = make(force)  # type: ignore[operator]
    strided, copied = vibrissa.force_mode(given, 0.06), vibrissa.force_mode(np.array(given, copy=True), 0.06)
    assert np.array_equal(strided.x, copied.x) and len(strided) == np.size(given)


def test_single_precision_and_integers_are_taken_at_their_value() -> None:
    single = np.array([0.1, 0.2], dtype=np.float32)
    assert np.array_equal(vibrissa.force_mode(single, 0.05).force, single.astype(np.float64))
    assert vibrissa.moment_mode(0, 0.05).x.tolist() == vibrissa.moment_mode(0.0, 0.05).x.tolist()


def test_many_problems_give_the_bits_of_one_whatever_the_threads() -> None:
    rng = np.random.default_rng(7)
    force, s_a = rng.uniform(-0.3, 0.3, 3000), rng.uniform(0.01, 0.075, 3000)
    one, two = (vibrissa.force_mode(force, s_a, threads=n) for n in (1, 2))
    singly = [vibrissa.force_mode(f, s).x.tolist() for f, s in zip(force[:100], s_a[:100], strict=True)]
    assert np.array_equal(one.x, two.x) and np.array_equal(one.moment, two.moment)
    assert sum(singly, []) == one.x[one.case < 100].tolist()


def test_nothing_in_nothing_out() -> None:
    bends = vibrissa.force_mode([], 0.05)
    assert len(bends) == 0 and bends.x.shape == (0,) and bends.shape().shape == (0, 101, 2)
    assert len(vibrissa.moment_mode(1.0, 0.05)) == 0


def test_faults_name_the_problem_or_are_listed() -> None:
    with pytest.raises(vibrissa.UsageError, match=r"problem 1: force: NaN \(allowed: a finite number of N\)"):
        vibrissa.force_mode([0.1, np.nan], 0.05)
    bends = vibrissa.force_mode([0.1, np.nan, np.inf, 0.2], [0.05, 0.05, 0.05, 0.09], errors="skip")
    assert bends.case.tolist() == [0] and [case for case, _ in bends.faults] == [1, 2, 3]
    assert bends.faults[2][1].startswith("s_a: 0.09 (allowed: above 0 and up to the whisker's length 0.075 m)")
    with pytest.raises(vibrissa.DataError, match="tip_ratio"):
        vibrissa.force_mode(0.1, 0.05, whisker=vibrissa.Whisker(tip_ratio=0.0))
    refused: list[Callable[[], object]] = [
        lambda: vibrissa.force_mode(0.1, 0.05, load="diagonal"),  # type: ignore[arg-type]
        lambda: vibrissa.force_mode(0.1, 0.05, load="tilted"),
        lambda: vibrissa.force_mode(0.1, 0.05, angle=0.1),
        lambda: vibrissa.force_mode([0.1, 0.2], [0.05, 0.06, 0.07]),
        lambda: vibrissa.force_mode([0.1, 0.2, 0.3], 0.05, whisker=[vibrissa.Whisker(), vibrissa.Whisker()]),
        lambda: vibrissa.force_mode(0.1, 0.05, errors="ignore"),  # type: ignore[arg-type]
    ]
    for call in refused:
        with pytest.raises(vibrissa.UsageError):
            call()


def test_tips_and_jointed_whiskers(command: Command, tmp_path: Path) -> None:
    wire = vibrissa.Segment(0.04, 3e-4, 0.8, 5e-4)
    jointed = vibrissa.Whisker(length=0.07, segments=(wire, vibrissa.Segment(0.03, 1e-4)), curvature=2.0)
    (tmp_path / "robot.toml").write_text(vibrissa.Robot((vibrissa.MountedWhisker(beam=jointed),)).to_toml())
    answer = command("beam", "force", "--force", "0.05", "--s-a", "0.06", "--robot", tmp_path / "robot.toml")
    assert vibrissa.force_mode(0.05, 0.06, whisker=jointed).x.tolist() == [s["x"] for s in answer["solutions"]]
    assert vibrissa.Robot.read(tmp_path / "robot.toml").whiskers[0].beam.segments == jointed.segments
    pushed = vibrissa.force_mode([0.05, -0.08], 0.075, load="tilted", angle=[0.2, 0.1])
    held = vibrissa.tip_mode(*pushed.tip.T)
    assert np.allclose(held.tip[held.branch == 0], pushed.tip, atol=1e-10)
    assert np.allclose(held.force_vector[held.branch == 0], pushed.force_vector, rtol=1e-7, atol=1e-10)


def test_one_number_may_be_a_text_with_its_unit() -> None:
    bare, told = vibrissa.force_mode([0.1, 0.2], 0.06), vibrissa.force_mode([0.1, 0.2], "60 mm")
    assert np.array_equal(bare.moment, told.moment)
    assert vibrissa.point_mode("58 mm", "12 mm").force.tolist() == vibrissa.point_mode(0.058, 0.012).force.tolist()
    with pytest.raises(vibrissa.UsageError, match="moment: `mN` is not the unit of a moment"):
        vibrissa.moment_mode("8 mN", "60 mm")


def test_small_forces_are_told_with_their_digits() -> None:
    bends = vibrissa.force_mode("1e-7 N", 0.06)
    assert "F 1.0e-7 N" in repr(bends[0]) and "M(0) 6.0e-6 mN m" in repr(bends[0])
    assert repr(bends) == "<vibrissa.Bends: 1 equilibrium of 1 problem>"
