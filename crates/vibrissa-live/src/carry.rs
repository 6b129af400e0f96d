//! An estimate carried on by odometry: where the robot is while the estimator still works on earlier rows.

use crate::estimate::Told;
use crate::join::JoinedRow;
use crate::output::json_line;
use vibrissa_core::flow::pose::{Estimate, Hypothesis};
use vibrissa_core::plane::{Pose2, Vec2};
use vibrissa_core::sets::{Interval, StateBox};
use vibrissa_core::world::Odometry;

/// The estimate `told` moved by the odometry between its row and `row`. Verdict, weights and the count of rows stay: of the
/// readings since nothing is taken in. Extents and covariances grow by the declared errors of the odometry.
#[must_use]
pub fn carried(told: &Told, row: &JoinedRow, odometry: &Odometry) -> Told {
    let step = told.odom_from_robot.between(row.row.odom_from_robot);
    let travelled = |index: usize| (row.travel[index] - told.travel[index]).max(0.0);
    let slip =
        Slip { along: odometry.translation_relative * travelled(0), turn: odometry.rotation_relative * travelled(1) };
    let estimate = Estimate {
        status: told.estimate.status,
        hypotheses: told.estimate.hypotheses.iter().map(|place| moved(place, step, &slip)).collect(),
        rows: told.estimate.rows,
    };
    let behind = row.row.t - told.t;
    Told {
        t: row.row.t,
        line: json_line(row.row.t, behind, &estimate),
        estimate,
        row: row.row.line as u64,
        from: told.from,
        carried: behind,
        odom_from_robot: row.row.odom_from_robot,
        travel: row.travel,
    }
}

/// Bounds on what odometry may be off by (m, rad).
struct Slip {
    along: f64,
    turn: f64,
}

/// A place after a motion in the robot's own frame.
fn moved(place: &Hypothesis, step: Pose2, slip: &Slip) -> Hypothesis {
    let (before, after) = (place.pose, place.pose.compose(step));
    let shift = after.position() - before.position();
    let way = shift.norm();
    let StateBox { x, y, theta } = place.extent;
    // Another heading within the extent carries the place elsewhere, by a chord at most.
    let lean = (theta.hi() - before.theta).abs().max((before.theta - theta.lo()).abs()) + slip.turn;
    let aside = way * lean.min(2.0) + slip.along;
    let grown =
        |interval: Interval, by: f64, more: f64| Interval::new(interval.lo() + by - more, interval.hi() + by + more);
    let extent = StateBox {
        x: grown(x, shift.x, aside),
        y: grown(y, shift.y, aside),
        theta: grown(theta, after.theta - before.theta, slip.turn),
    };
    Hypothesis {
        pose: after,
        weight: place.weight,
        extent,
        covariance: place.covariance.map(|covariance| propagated(&covariance, shift, slip)),
        ridge: place.ridge.iter().map(|pose| pose.compose(step)).collect(),
    }
}

/// The covariance after a shift (map frame) of a robot whose heading is not known exactly; an error anywhere within its bound
/// has a third of the bound's square as its variance.
fn propagated(covariance: &[[f64; 3]; 3], shift: Vec2, slip: &Slip) -> [[f64; 3]; 3] {
    let jacobian = [[1.0, 0.0, -shift.y], [0.0, 1.0, shift.x], [0.0, 0.0, 1.0]];
    let product = |a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]| {
        let mut out = [[0.0; 3]; 3];
        for (i, row) in out.iter_mut().enumerate() {
            for (k, value) in row.iter_mut().enumerate() {
                *value = (0..3).map(|n| a[i][n] * b[n][k]).sum();
            }
        }
        out
    };
    let mut transposed = [[0.0; 3]; 3];
    for (i, row) in transposed.iter_mut().enumerate() {
        for (k, value) in row.iter_mut().enumerate() {
            *value = jacobian[k][i];
        }
    }
    let mut out = product(&product(&jacobian, covariance), &transposed);
    for (axis, bound) in [slip.along, slip.along, slip.turn].into_iter().enumerate() {
        out[axis][axis] += bound * bound / 3.0;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::{Slip, moved};
    use vibrissa_core::flow::pose::Hypothesis;
    use vibrissa_core::plane::Pose2;
    use vibrissa_core::sets::{Interval, StateBox};

    /// States drawn from a place and moved one by one stay in the carried extent, and their scatter is the carried covariance.
    #[test]
    fn a_carried_place_holds_what_each_of_its_states_becomes() {
        let pose = Pose2::new(0.3, -0.2, 2.0);
        let half = [2e-3, 3e-3, 0.05];
        let box_of = |middle: f64, half: f64| Interval::new(middle - half, middle + half);
        let place = Hypothesis {
            pose,
            weight: 1.0,
            extent: StateBox { x: box_of(0.3, half[0]), y: box_of(-0.2, half[1]), theta: box_of(2.0, half[2]) },
            covariance: Some([
                [half[0].powi(2) / 3.0, 0.0, 0.0],
                [0.0, half[1].powi(2) / 3.0, 0.0],
                [0.0, 0.0, half[2].powi(2) / 3.0],
            ]),
            ridge: vec![pose],
        };
        let step = Pose2::new(0.04, -0.01, 0.3);
        let slip = Slip { along: 1e-3, turn: 0.02 };
        let carried = moved(&place, step, &slip);
        assert_eq!(carried.ridge, [pose.compose(step)]);
        let (mut sums, mut squares, mut count) = ([0.0; 3], [[0.0; 3]; 3], 0.0);
        let grid = |k: u32| -1.0 + (f64::from(k) + 0.5) / 4.0;
        for n in 0..8_u32.pow(6) {
            let u = [0, 1, 2, 3, 4, 5].map(|axis| grid(n / 8_u32.pow(axis) % 8));
            let state = Pose2::new(pose.x + u[0] * half[0], pose.y + u[1] * half[1], pose.theta + u[2] * half[2]);
            let end = state.compose(step);
            // Odometry may be off by its bounds in any direction.
            let bound = slip.along / 2.0_f64.sqrt();
            let end = [end.x + u[3] * bound, end.y + u[4] * bound, end.theta + u[5] * slip.turn];
            let extent = &carried.extent;
            assert!(extent.x.contains(end[0]) && extent.y.contains(end[1]) && extent.theta.contains(end[2]), "{end:?}");
            for i in 0..3 {
                sums[i] += end[i];
                (0..3).for_each(|k| squares[i][k] += end[i] * end[k]);
            }
            count += 1.0;
        }
        let told = carried.covariance.unwrap_or_default();
        for i in 0..3 {
            for k in 0..3 {
                let scatter = squares[i][k] / count - sums[i] / count * (sums[k] / count);
                let scale = (told[i][i] * told[k][k]).sqrt();
                // The bounds on x and y are told for each, not for both.
                assert!((told[i][k] - scatter).abs() < 0.12 * scale, "{i} {k}: {} for {scatter}", told[i][k]);
            }
        }
    }
}
