//! What is kept of the readings against the sum of squares itself.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

use super::*;
use crate::linear_algebra::dot;
use crate::plane::Pose2;

#[test]
fn a_path_that_is_too_long_leaves_the_middle_fixed() {
    // Five readings of x alone along a straight metre: the fit moves the path so that its middle is right, and the
    // last row is off by half of the stretch; y and heading are not read and stay open.
    let mut told = Belief::default();
    for row in 0..5 {
        if row > 0 {
            told.way
                .travel(Pose2::new(0.25 * f64::from(row - 1), 0.0, 0.0), Pose2::new(0.25 * f64::from(row), 0.0, 0.0));
        }
        let at_base = [1.0, 0.0, 0.0];
        told.add(at_base, told.way.slopes(0.0, Vec2::ZERO, at_base), 0.0, (0.0, 1.0));
    }
    let bounds = Odometry { translation_relative: 0.02, rotation_relative: 0.0, ..Odometry::default() };
    let added = told.covariance(CalibrationPrior::default(), [0.0, 1.0, 1.0], 0.0, Vec2::ZERO, &bounds);
    assert!((added[0][0].sqrt() - 0.01 * 0.5).abs() < 1e-12, "{added:?}");
    assert!((added[1][1].sqrt() - 0.01).abs() < 1e-12, "{added:?}");
}

/// Numbers of either sign, the same for the same index.
fn number(index: usize) -> f64 {
    (index as f64 * 12.9898).sin() * 43_758.545_3 % 1.0
}

/// A winding path, and its readings: the derivatives by the base's pose, the residual, and the derivative by a shared error.
fn readings() -> Vec<(Pose2, [f64; 3], f64, f64)> {
    let reading = |k: usize| {
        let s = k as f64 * 0.02;
        let pose = Pose2::new(s + 0.1 * (3.0 * s).sin(), 0.3 * (2.0 * s).cos(), 1.3 * (4.0 * s).sin());
        let at_base = [900.0 * number(7 * k), 900.0 * number(7 * k + 1), 60.0 * number(7 * k + 2)];
        (pose, at_base, number(7 * k + 3), 20.0 * number(7 * k + 4))
    };
    (0..60).map(reading).collect()
}

const FRAME: Pose2 = Pose2 { x: 0.2, y: -0.1, theta: 0.7 };
const PIVOT: Vec2 = Vec2 { x: 0.05, y: 0.4 };

fn arm(odom: Pose2) -> Vec2 {
    FRAME.transform_point(odom.position()) - FRAME.transform_point(PIVOT)
}

/// What the readings say, the robot's base being its origin, from a beginning.
fn said(mut told: Belief) -> Belief {
    let mut last: Option<Pose2> = None;
    for (pose, at_base, residual, by_shared) in readings() {
        if let Some(last) = last.replace(pose) {
            told.way.travel(last, pose);
        }
        let turned = arm(pose).perp();
        let by = [at_base[0], at_base[1], at_base[2] + at_base[0] * turned.x + at_base[1] * turned.y];
        told.add(by, told.way.slopes(FRAME.theta, Vec2::ZERO, at_base), by_shared, (residual, 1.0));
    }
    told
}

/// The sum of half the squares by moves, shares and a shared error, with what is believed of the last two before.
fn cost(d: [f64; 3], calibration: OdometryCalibration, gain: f64, shared: CalibrationPrior) -> f64 {
    let mut way = OdometryPath::default();
    let mut last: Option<Pose2> = None;
    let mut sum = 0.5 * (gain / shared.gain).powi(2);
    sum += (0..CALIBRATION_SIZE).map(|way| 0.5 * (calibration[way] / shared.odometry[way]).powi(2)).sum::<f64>();
    for (pose, at_base, residual, by_shared) in readings() {
        if let Some(last) = last.replace(pose) {
            way.travel(last, pose);
        }
        let errors = way.errors(FRAME.theta);
        let turned = arm(pose).perp();
        let mut base = [d[0] + d[2] * turned.x, d[1] + d[2] * turned.y, d[2]];
        (0..3).for_each(|i| base[i] += (0..CALIBRATION_SIZE).map(|way| errors[way][i] * calibration[way]).sum::<f64>());
        sum += 0.5 * (residual + dot(at_base, base) + by_shared * gain).powi(2);
    }
    sum
}

const SHARED: CalibrationPrior = CalibrationPrior { gain: 0.02, odometry: [0.005, 0.004, 0.007] };

/// The least cost over shares and gain, and these, by steps that go down along one of them after the other.
fn least(d: [f64; 3]) -> (f64, [f64; 4]) {
    let cost_at = |v: [f64; 4]| cost(d, [v[0], v[1], v[2]], v[3], SHARED);
    let mut at = [0.0; 4];
    for axis in (0..4).cycle().take(20_000) {
        let h = 1e-4;
        let side = |by: f64| cost_at(core::array::from_fn(|i| if i == axis { at[i] + by } else { at[i] }));
        let (low, middle, high) = (side(-h), side(0.0), side(h));
        at[axis] -= 0.5 * h * (high - low) / (high - 2.0 * middle + low);
    }
    (cost_at(at), at)
}

/// The cost of a move, shares and a shared error by what is kept of the readings.
fn kept(told: &Belief, d: [f64; 3], calibration: OdometryCalibration, gain: f64) -> f64 {
    let [x, y, turn] = d;
    let [long, aside, turned] = calibration;
    told.information.shifted([x, y, turn, long, aside, turned, gain]).constant
}

#[test]
fn a_random_move_and_shares_that_wander_are_at_their_best_for_every_move() {
    let before = said(Belief::default());
    let q = [[4e-6, 1e-6, 2e-6], [1e-6, 9e-6, -1e-6], [2e-6, -1e-6, 5e-5]];
    let after = before.with_process_noise(&q, SHARED.odometry);
    let precise = inverse(&q).unwrap();
    for (d, calibration, gain) in [
        ([0.0; 3], [0.0; 3], 0.0),
        ([1e-3, -2e-3, 4e-3], [0.003, -0.001, 0.002], 0.01),
        ([-2e-3, 0.0, 1e-2], [-0.004, 0.002, 0.005], -0.02),
    ] {
        let whole = |v: [f64; 6]| {
            let (off, wandered) = ([v[0], v[1], v[2]], [v[3], v[4], v[5]]);
            let likely = (0..CALIBRATION_SIZE)
                .map(|way| (wandered[way] / (CALIBRATION_WANDER * SHARED.odometry[way])).powi(2))
                .sum::<f64>();
            let less = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|i| a[i] - b[i]);
            kept(&before, less(d, off), less(calibration, wandered), gain)
                + 0.5 * (dot(off, times(&precise, off)) + likely)
        };
        let mut at = [0.0; 6];
        for axis in (0..6).cycle().take(30_000) {
            let h = 1e-4;
            let side = |by: f64| whole(core::array::from_fn(|i| if i == axis { at[i] + by } else { at[i] }));
            let (low, middle, high) = (side(-h), side(0.0), side(h));
            at[axis] -= 0.5 * h * (high - low) / (high - 2.0 * middle + low);
        }
        let (told, truth) = (kept(&after, d, calibration, gain), whole(at));
        assert!((told - truth).abs() < 1e-4 * truth.abs().max(1.0), "{told}, not {truth}");
        assert!(truth < 0.99 * kept(&before, d, calibration, gain));
    }
}

#[test]
fn what_fades_costs_the_same_here_and_less_elsewhere() {
    let before = said(Belief::default());
    let after = before.with_forgetting(0.3);
    let here = kept(&before, [0.0; 3], [0.0; 3], 0.0);
    for (d, calibration, gain) in [
        ([0.0; 3], [0.0; 3], 0.0),
        ([1e-3, -2e-3, 4e-3], [0.003, -0.001, 0.002], 0.01),
        ([-2e-3, 0.0, 1e-2], [-0.004, 0.002, 0.005], -0.02),
    ] {
        let (whole, faded) = (kept(&before, d, calibration, gain) - here, kept(&after, d, calibration, gain) - here);
        assert!((faded - 0.3 * whole).abs() < 1e-9 * (1.0 + whole.abs()), "{faded} {whole}");
    }
}

#[test]
fn place_and_shares_vary_together_as_the_whole_cost_says() {
    let told = said(Belief::default());
    let place = told.place(SHARED).covariance([0.0; 3]).unwrap();
    let told: Square<6> = told.calibration(SHARED).unwrap().joint(&place);
    // The curvature over moves, shares and the shared error, by differences of the cost, which is a parabola.
    let at = |v: [f64; 7]| cost([v[0], v[1], v[2]], [v[3], v[4], v[5]], v[6], SHARED);
    let h = 1e-3;
    let both = |i: usize, j: usize, a: f64, b: f64| {
        let mut v = [0.0; 7];
        v[i] += a;
        v[j] += b;
        at(v)
    };
    let bent = |i: usize, j: usize| {
        (both(i, j, h, h) - both(i, j, h, -h) - both(i, j, -h, h) + both(i, j, -h, -h)) / (4.0 * h * h)
    };
    for i in 0..6 {
        let row: [f64; 6] = core::array::from_fn(|k| bent(i, k) - bent(i, 6) * bent(6, k) / bent(6, 6));
        for j in 0..6 {
            let product: f64 = row.iter().zip(&told).map(|(bent, told)| bent * told[j]).sum();
            assert!((product - f64::from(u8::from(i == j))).abs() < 1e-5, "{i} {j}: {product}");
        }
    }
}

#[test]
fn the_cost_on_the_best_path_is_what_elimination_says() {
    let belief = said(Belief::default());
    let told = belief.place(SHARED).constant;
    let (_, at) = least([0.0; 3]);
    let on_path = |calibration: OdometryCalibration| {
        let belief = belief.shifted([0.0; 3], calibration);
        belief.place(SHARED).constant + belief.calibration(SHARED).unwrap().fall
    };
    let best = on_path([at[0], at[1], at[2]]);
    assert!((best - told).abs() < 1e-6, "{best}, not {told}");
    // On another path it is dearer by what the whole cost is, the shared error being at its best for each.
    let excess_cost = |calibration: OdometryCalibration| {
        let costs = [-1e-3, 0.0, 1e-3].map(|gain| cost([0.0; 3], calibration, gain, SHARED));
        let (slope, bent) = (500.0 * (costs[2] - costs[0]), 1e6 * (costs[2] - 2.0 * costs[1] + costs[0]));
        costs[1] - 0.5 * slope * slope / bent - least([0.0; 3]).0
    };
    for other in [[0.0; 3], [at[0] + 1e-3, at[1], at[2]], [at[0], at[1], at[2] - 1e-3]] {
        let (told, truth) = (on_path(other) - best, excess_cost(other));
        assert!((told - truth).abs() < 1e-5 && truth > 1e-4, "{told}, not {truth}");
    }
}

#[test]
fn shares_are_eliminated_at_their_best() {
    let belief = said(Belief::default());
    let (told, response) = (belief.place(SHARED), belief.calibration(SHARED).unwrap());
    let (still, _) = least([0.0; 3]);
    for d in [[0.0; 3], [3e-4, -2e-4, 1e-3], [-1e-3, 5e-4, -4e-3]] {
        let (cost, at) = least(d);
        let more = told.shifted(d).constant - told.constant;
        assert!((more - (cost - still)).abs() < 1e-6 * (1.0 + more.abs()), "{more} {}", cost - still);
        let calibration = response.given(d);
        (0..CALIBRATION_SIZE)
            .for_each(|way| assert!((calibration[way] - at[way]).abs() < 1e-7, "{calibration:?} {at:?}"));
    }
}

#[test]
fn what_is_told_from_the_last_row_is_what_its_own_run_tells() {
    // Said from the first row and carried on to the last, and said from the last row from the beginning.
    let poses: Vec<Pose2> = readings().iter().map(|r| r.0).collect();
    let (way, last) = (OdometryPath::along(&poses), poses[poses.len() - 1]);
    let told = said(Belief::default());
    let carried = told.carried_on(&told.way, FRAME.theta, arm(last));
    let ran = said(Belief::default().told_from_last(&way, FRAME.theta, arm(last)));
    let near = |a: f64, b: f64, scale: f64| (a - b).abs() < 1e-9 * scale;
    let scale = told.information.matrix.iter().flatten().fold(1.0, |most: f64, v| most.max(v.abs()));
    for i in 0..ALL {
        assert!(near(carried.information.vector[i], ran.information.vector[i], scale), "{carried:?} {ran:?}");
        for j in 0..ALL {
            assert!(near(carried.information.matrix[i][j], ran.information.matrix[i][j], scale), "{i} {j}");
        }
    }
    assert_eq!(carried.place_and_gain(), ran.place_and_gain());
    assert!([carried, ran].iter().all(|told| told.way.errors(0.0).iter().flatten().all(|v| v.abs() < 1e-12)));
}

#[test]
fn other_shares_are_the_same_cost_told_elsewhere() {
    let told = said(Belief::default());
    let to = [2e-3, -1e-3, 3e-3];
    let there = told.shifted([0.0; 3], to);
    let place = |told: &Belief| told.information.conditioned(PLACE);
    let (before, shifted) = (place(&told), place(&there));
    let at = |d: [f64; 3], calibration: OdometryCalibration| {
        let none = CalibrationPrior { gain: f64::INFINITY, odometry: [f64::INFINITY; 3] };
        cost(d, calibration, 0.0, none)
    };
    for d in [[0.0; 3], [1e-3, -5e-4, 2e-3]] {
        let told = shifted.shifted(d).constant - shifted.constant;
        let wanted = at(d, to) - at([0.0; 3], to);
        assert!((told - wanted).abs() < 1e-9 * (1.0 + wanted.abs()), "{told} {wanted}");
    }
    assert!((shifted.constant - before.constant - (at([0.0; 3], to) - at([0.0; 3], [0.0; 3]))).abs() < 1e-8);
    // A prior of the calibration parameters is about none, wherever they are reported.
    let [a, b] = [told, there].map(|told| told.place(SHARED));
    assert!((a.constant - b.constant).abs() < 1e-7, "{} {}", a.constant, b.constant);
    (0..3).for_each(|i| assert!((a.vector[i] - b.vector[i]).abs() < 1e-6 * (1.0 + a.vector[i].abs())));
}
