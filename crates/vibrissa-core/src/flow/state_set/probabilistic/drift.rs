//! What errors of the odometry do to the readings, and what the readings say about them.
//!
//! Each increment may be off by a share of itself. What does not average out is one share for all: the path stretched, sheared
//! aside or turned too far. These three are unknowns beside the place, of the standard deviations that the declared bounds
//! have: their lines of the normal equations are kept here, and they are eliminated from those of the place.

use super::normal::{Line, Matrix, Normal, add, congruent, determinant, dot, inverse, times};
use super::shares::{Shared, Shares, WAYS, stds};
use crate::plane::{Pose2, Vec2};
use crate::world::Odometry;

/// How far the shares may wander each time that rows are summed up (of their standard deviations).
const WANDER: f64 = 0.2;

/// The path so far, and what its errors do to the readings.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Drift {
    /// Way from the first row (odometry frame, m), turn since then (rad), and where turning too far by its own amount
    /// would have taken it (m).
    reach: Vec2,
    turned: f64,
    swept: Vec2,
    /// The shares that the path has been corrected by.
    at: Shares,
    /// Whether they leave the robot where it is at the last row, not at the first.
    from_last: bool,
    /// For each way: the mixed part of the normal equations, with moves and with a shared relative error.
    mixed: [[f64; 3]; WAYS],
    by_shared: [f64; WAYS],
    /// Their own part, and their gradient.
    own: Matrix,
    pull: [f64; WAYS],
}

/// What a hypothesis says of the shares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Response {
    /// How far they are from those that the path has been corrected by where the hypothesis stands,
    pub(super) here: Shares,
    /// how much less for a unit of each move (rows are ways),
    pub(super) by_move: Matrix,
    /// their covariance where it is fixed,
    pub(super) covariance: Matrix,
    /// and by how much the cost falls where it is fixed and they go there.
    pub(super) promise: f64,
}

impl Response {
    /// The shares' distance once the hypothesis has moved.
    pub(super) fn after(&self, d: [f64; 3]) -> Shares {
        let less = times(&self.by_move, d);
        [0, 1, 2].map(|way| self.here[way] - less[way])
    }

    /// The shares' covariance where the place is not fixed, but has this one.
    pub(super) fn wherever(&self, place: &Matrix) -> Matrix {
        let mut own = congruent(&self.by_move, place);
        add(&mut own, &self.covariance);
        own
    }

    /// The covariance of place and shares together, where that of the place is this one.
    pub(super) fn with_place(&self, place: &Matrix) -> [[f64; 3 + WAYS]; 3 + WAYS] {
        let own = self.wherever(place);
        // Columns are ways.
        let mixed = place.map(|row| times(&self.by_move, row).map(|v| -v));
        core::array::from_fn(|i| {
            core::array::from_fn(|j| match (i.checked_sub(3), j.checked_sub(3)) {
                (None, None) => place[i][j],
                (Some(way), None) => mixed[j][way],
                (None, Some(way)) => mixed[i][way],
                (Some(way), Some(other)) => own[way][other],
            })
        })
    }

    /// The shares that the odometry has to be corrected by, each with its standard deviation, where the path has been corrected by these
    /// and the hypothesis' place has this covariance.
    pub(super) fn estimates(&self, at: Shares, place: &Matrix) -> [[f64; 2]; WAYS] {
        let covariance = self.wherever(place);
        [0, 1, 2].map(|way| [at[way] + self.here[way], covariance[way][way].max(0.0).sqrt()])
    }
}

impl Drift {
    /// The shares that the path has been corrected by.
    pub(super) fn at(&self) -> Shares {
        self.at
    }

    /// Whether the shares leave the robot where it is at the last row, not at the first.
    pub(super) fn is_from_last(&self) -> bool {
        self.from_last
    }

    /// The robot's way along these odometry poses.
    pub(super) fn along(poses: &[Pose2]) -> Self {
        let mut way = Self::default();
        poses.windows(2).for_each(|pair| way.travel(pair[0], pair[1]));
        way
    }

    /// How far a change of the shares moves one end of the way against the other (m, rad).
    pub(super) fn moves(&self, by: Shares) -> [f64; 2] {
        let errors = self.errors(0.0);
        let sum = |i: usize| (0..WAYS).map(|way| errors[way][i] * by[way]).sum::<f64>();
        [sum(0).hypot(sum(1)), sum(2).abs()]
    }

    /// Both with the robot's place at the last row in the place of that at the first, before any row has been taken; `way` is the
    /// whole path.
    pub(super) fn told_from_last(&self, normal: &Normal, way: &Self, theta: f64, arm: Vec2) -> (Normal, Self) {
        let (normal, drift) = self.carried_on(normal, way, theta, arm);
        (normal, Self { from_last: true, ..drift })
    }

    /// Goes on from one odometry pose to the next.
    pub(super) fn travel(&mut self, from: Pose2, to: Pose2) {
        let step = to.position() - from.position();
        let turn = from.between(to).theta;
        self.swept += step.perp() * (self.turned + 0.5 * turn);
        self.reach += step;
        self.turned += turn;
    }

    /// The error of the robot's pose (x, y, heading; map frame), for a unit of each way, in a frame turned by `theta`.
    pub(super) fn errors(&self, theta: f64) -> [[f64; 3]; WAYS] {
        let (along, swept) = (self.reach.rotated(theta), self.swept.rotated(theta));
        [[along.x, along.y, 0.0], [-along.y, along.x, 0.0], [swept.x, swept.y, self.turned]]
    }

    /// How the frame moves for a unit of each way if the robot stays where it is now; it is `arm` from the pivot.
    pub(super) fn holding(&self, theta: f64, arm: Vec2) -> [[f64; 3]; WAYS] {
        let turned = arm.perp();
        self.errors(theta).map(|e| [e[2] * turned.x - e[0], e[2] * turned.y - e[1], -e[2]])
    }

    /// Adds a reading: its residual, its derivatives by the whisker base's pose (`at_base`; the base is `arm` from the robot, map
    /// frame), by a move, and by a shared relative error.
    pub(super) fn add(&mut self, theta: f64, arm: Vec2, at_base: [f64; 3], line: Line) {
        let turned = arm.perp();
        let by = self
            .errors(theta)
            .map(|error| dot(at_base, [error[0] + error[2] * turned.x, error[1] + error[2] * turned.y, error[2]]));
        for way in 0..WAYS {
            let change = line.weight * by[way];
            (0..3).for_each(|i| self.mixed[way][i] += line.by[i] * change);
            (0..WAYS).for_each(|other| self.own[way][other] += by[other] * change);
            self.by_shared[way] += line.by_shared * change;
            self.pull[way] += line.residual * change;
        }
    }

    /// The same around a place that has been moved by `d`.
    pub(super) fn moved(&self, d: [f64; 3]) -> Self {
        Self { pull: [0, 1, 2].map(|way| self.pull[way] + dot(self.mixed[way], d)), ..*self }
    }

    /// The same in a map that is turned by this angle.
    pub(super) fn turned(&self, angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { mixed: self.mixed.map(|v| [cos * v[0] - sin * v[1], sin * v[0] + cos * v[1], v[2]]), ..*self }
    }

    /// Both around other shares.
    pub(super) fn shifted(&self, normal: &Normal, to: Shares) -> (Normal, Self) {
        let by = [0, 1, 2].map(|way| to[way] - self.at[way]);
        let along = times(&self.own, by);
        let mut out = *normal;
        out.cost += dot(self.pull, by) + 0.5 * dot(along, by);
        out.shared[1] += dot(self.by_shared, by);
        (0..3).for_each(|i| out.gradient[i] += (0..WAYS).map(|way| self.mixed[way][i] * by[way]).sum::<f64>());
        (out, Self { at: to, pull: [0, 1, 2].map(|way| self.pull[way] + along[way]), ..*self })
    }

    /// Both with the robot's place at a later row in the place of that at the first: `reached` is the path until there, and `arm` goes
    /// from the pivot to the robot there, in a frame turned by `theta`.
    pub(super) fn carried_on(&self, normal: &Normal, reached: &Self, theta: f64, arm: Vec2) -> (Normal, Self) {
        // What was a move is the move there less what the shares do until then.
        let by = reached.holding(theta, arm);
        let mut out = *self;
        for way in 0..WAYS {
            let along = times(&normal.curvature, by[way]);
            out.pull[way] += dot(normal.gradient, by[way]);
            out.by_shared[way] += dot(normal.mixed, by[way]);
            (0..3).for_each(|i| out.mixed[way][i] += along[i]);
            for other in 0..WAYS {
                out.own[way][other] +=
                    dot(self.mixed[other], by[way]) + dot(self.mixed[way], by[other]) + dot(along, by[other]);
            }
        }
        let reach = self.reach - reached.reach;
        out.swept = self.swept - reached.swept - reach.perp() * reached.turned;
        (out.reach, out.turned) = (reach, self.turned - reached.turned);
        (*normal, out)
    }

    /// What the readings say with this share of its weight.
    pub(super) fn faded(&self, share: f64) -> Self {
        Self {
            mixed: self.mixed.map(|row| row.map(|v| share * v)),
            by_shared: self.by_shared.map(|v| share * v),
            own: self.own.map(|row| row.map(|v| share * v)),
            pull: self.pull.map(|v| share * v),
            ..*self
        }
    }

    /// Both after the robot has made a random move of this covariance, and the shares have wandered on a little.
    pub(super) fn loosened(&self, normal: &Normal, covariance: &Matrix, stds: Shares) -> (Normal, Self) {
        let (mut out, mut drift) = (normal.loosened(covariance), *self);
        if let Some(w) = normal.leeway(covariance) {
            let moved = self.mixed.map(|mixed| times(&w, mixed));
            for (way, moved) in moved.into_iter().enumerate() {
                let along = times(&normal.curvature, moved);
                (0..3).for_each(|i| drift.mixed[way][i] -= along[i]);
                (0..WAYS).for_each(|other| drift.own[way][other] -= dot(self.mixed[other], moved));
                drift.by_shared[way] -= dot(normal.mixed, moved);
                drift.pull[way] -= dot(normal.gradient, moved);
            }
        }
        let before = drift;
        let mut precise = before.own;
        for (way, std) in stds.into_iter().enumerate() {
            if std <= 0.0 {
                return (out, drift);
            }
            precise[way][way] += (WANDER * std).powi(-2);
        }
        let Some(w) = inverse(&precise) else { return (out, drift) };
        let column = |i: usize| [0, 1, 2].map(|way: usize| before.mixed[way][i]);
        let (to_pull, to_shared) = (times(&w, before.pull), times(&w, before.by_shared));
        out.cost -= 0.5 * dot(before.pull, to_pull);
        out.shared[0] -= dot(before.by_shared, to_shared);
        out.shared[1] -= dot(before.by_shared, to_pull);
        for i in 0..3 {
            let along = times(&w, column(i));
            out.gradient[i] -= dot(column(i), to_pull);
            out.mixed[i] -= dot(column(i), to_shared);
            (0..3).for_each(|j| out.curvature[i][j] -= dot(along, column(j)));
            let less = times(&before.own, along);
            (0..WAYS).for_each(|way| drift.mixed[way][i] -= less[way]);
        }
        let (pull, by_shared) = (times(&before.own, to_pull), times(&before.own, to_shared));
        for way in 0..WAYS {
            drift.pull[way] -= pull[way];
            drift.by_shared[way] -= by_shared[way];
            let along = times(&before.own, times(&w, before.own[way]));
            (0..WAYS).for_each(|other| drift.own[way][other] -= along[other]);
        }
        (out, drift)
    }

    /// The normal equations of moves alone: the shares are at their best for every move, as if what they do to the readings were a
    /// correlated part of the noise.
    pub(super) fn eliminated(&self, normal: &Normal, stds: Shares) -> Normal {
        if !stds.iter().any(|&std| std > 0.0) {
            return *normal;
        }
        let mut scaled = [[0.0; WAYS]; WAYS];
        (0..WAYS).for_each(|i| (0..WAYS).for_each(|j| scaled[i][j] = stds[i] * stds[j] * self.own[i][j]));
        (0..WAYS).for_each(|i| scaled[i][i] += 1.0);
        let Some(inverse) = inverse(&scaled) else { return *normal };
        let before = [0, 1, 2].map(|i| if stds[i] > 0.0 { self.at[i] / stds[i] } else { 0.0 });
        let pull = [0, 1, 2].map(|i| stds[i] * self.pull[i] + before[i]);
        let by_shared = [0, 1, 2].map(|i| stds[i] * self.by_shared[i]);
        let mixed = [0, 1, 2].map(|k| [0, 1, 2].map(|i: usize| stds[i] * self.mixed[i][k]));
        let (to_pull, to_shared) = (times(&inverse, pull), times(&inverse, by_shared));
        let mut out = *normal;
        out.cost += 0.5 * (determinant(&scaled).max(1.0).ln() + dot(before, before) - dot(pull, to_pull));
        out.shared[0] -= dot(by_shared, to_shared);
        out.shared[1] -= dot(by_shared, to_pull);
        for i in 0..3 {
            let along = times(&inverse, mixed[i]);
            out.gradient[i] -= dot(mixed[i], to_pull);
            out.mixed[i] -= dot(mixed[i], to_shared);
            (0..3).for_each(|j| out.curvature[i][j] -= dot(along, mixed[j]));
        }
        out
    }

    /// What the readings say of the shares; nothing where they are not looked for.
    pub(super) fn response(&self, normal: &Normal, shared: Shared) -> Option<Response> {
        let per = if shared.gain > 0.0 { 1.0 / (normal.shared[0] + shared.gain.powi(-2)) } else { 0.0 };
        let stds = shared.odometry;
        let mut precise = self.own;
        let (mut pull, mut mixed) = (self.pull, self.mixed);
        for way in 0..WAYS {
            if stds[way] <= 0.0 {
                return None;
            }
            let by = self.by_shared[way] * per;
            (0..WAYS).for_each(|other| precise[way][other] -= by * self.by_shared[other]);
            precise[way][way] += stds[way].powi(-2);
            pull[way] += self.at[way] * stds[way].powi(-2) - by * normal.shared[1];
            (0..3).for_each(|i| mixed[way][i] -= by * normal.mixed[i]);
        }
        let covariance = inverse(&precise)?;
        let columns = [0, 1, 2].map(|i| times(&covariance, [0, 1, 2].map(|way: usize| mixed[way][i])));
        let by_move = [0, 1, 2].map(|way| [0, 1, 2].map(|i: usize| columns[i][way]));
        let here = times(&covariance, pull).map(|v| -v);
        Some(Response { here, by_move, covariance, promise: -0.5 * dot(here, pull) })
    }

    /// The sum of squares, in standard deviations of the readings' noise, that the declared bounds may add to the residuals.
    pub(super) fn squares(&self, bounds: &Odometry) -> f64 {
        let std = stds(bounds);
        (0..WAYS).map(|way| std[way] * std[way] * self.own[way][way]).sum()
    }

    /// What the declared bounds add to the covariance of the robot's pose at the last row; `arm` goes from the pivot to
    /// the robot, map frame.
    pub(super) fn covariance(
        &self,
        normal: &Normal,
        shared: Shared,
        open: [f64; 3],
        theta: f64,
        arm: Vec2,
        bounds: &Odometry,
    ) -> Matrix {
        let per = if shared.gain > 0.0 { 1.0 / (normal.shared[0] + shared.gain.powi(-2)) } else { 0.0 };
        let inverse = inverse(&normal.marginal(shared.gain).damped(open)).unwrap_or_default();
        let std = stds(bounds);
        let mut out = [[0.0; 3]; 3];
        for (way, error) in self.errors(theta).into_iter().enumerate() {
            let pull = [0, 1, 2].map(|i| self.mixed[way][i] - normal.mixed[i] * self.by_shared[way] * per);
            let d = times(&inverse, pull).map(|v| -v);
            let turned = arm.perp();
            let off = [error[0] + d[0] + d[2] * turned.x, error[1] + d[1] + d[2] * turned.y, error[2] + d[2]];
            let variance = std[way] * std[way];
            (0..3).for_each(|i| (0..3).for_each(|j| out[i][j] += variance * off[i] * off[j]));
        }
        out
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

    use super::*;

    #[test]
    fn a_path_that_is_too_long_leaves_the_middle_fixed() {
        // Five readings of x alone along a straight metre: the fit moves the path so that its middle is right, and the
        // last row is off by half of the stretch; y and heading are not read and stay open.
        let (mut drift, mut normal) = (Drift::default(), Normal::default());
        for row in 0..5 {
            if row > 0 {
                drift.travel(
                    Pose2::new(0.25 * f64::from(row - 1), 0.0, 0.0),
                    Pose2::new(0.25 * f64::from(row), 0.0, 0.0),
                );
            }
            let line = Line { residual: 0.0, by: [1.0, 0.0, 0.0], by_shared: 0.0, weight: 1.0 };
            normal.add(line);
            drift.add(0.0, Vec2::ZERO, [1.0, 0.0, 0.0], line);
        }
        let bounds = Odometry { translation_relative: 0.02, rotation_relative: 0.0 };
        let added = drift.covariance(&normal, Shared::default(), [0.0, 1.0, 1.0], 0.0, Vec2::ZERO, &bounds);
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
    fn said(mut normal: Normal, mut drift: Drift) -> (Normal, Drift) {
        let mut last: Option<Pose2> = None;
        for (pose, at_base, residual, by_shared) in readings() {
            if let Some(last) = last.replace(pose) {
                drift.travel(last, pose);
            }
            let turned = arm(pose).perp();
            let by = [at_base[0], at_base[1], at_base[2] + at_base[0] * turned.x + at_base[1] * turned.y];
            let line = Line { residual, by, by_shared, weight: 1.0 };
            normal.add(line);
            drift.add(FRAME.theta, Vec2::ZERO, at_base, line);
        }
        (normal, drift)
    }

    /// The sum of half the squares by moves, shares and a shared error, with what is believed of the last two before.
    fn cost(d: [f64; 3], shares: Shares, gain: f64, shared: Shared) -> f64 {
        let mut way = Drift::default();
        let mut last: Option<Pose2> = None;
        let mut sum = 0.5 * (gain / shared.gain).powi(2);
        sum += (0..WAYS).map(|way| 0.5 * (shares[way] / shared.odometry[way]).powi(2)).sum::<f64>();
        for (pose, at_base, residual, by_shared) in readings() {
            if let Some(last) = last.replace(pose) {
                way.travel(last, pose);
            }
            let errors = way.errors(FRAME.theta);
            let turned = arm(pose).perp();
            let mut base = [d[0] + d[2] * turned.x, d[1] + d[2] * turned.y, d[2]];
            (0..3).for_each(|i| base[i] += (0..WAYS).map(|way| errors[way][i] * shares[way]).sum::<f64>());
            sum += 0.5 * (residual + dot(at_base, base) + by_shared * gain).powi(2);
        }
        sum
    }

    const SHARED: Shared = Shared { gain: 0.02, odometry: [0.005, 0.004, 0.007] };

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
    fn kept((normal, drift): &(Normal, Drift), d: [f64; 3], shares: Shares, gain: f64) -> f64 {
        let (normal, _) = drift.moved(d).shifted(&normal.moved(d), shares);
        normal.cost + normal.shared[1] * gain + 0.5 * normal.shared[0] * gain * gain
    }

    #[test]
    fn a_random_move_and_shares_that_wander_are_at_their_best_for_every_move() {
        let before = said(Normal::default(), Drift::default());
        let q = [[4e-6, 1e-6, 2e-6], [1e-6, 9e-6, -1e-6], [2e-6, -1e-6, 5e-5]];
        let after = before.1.loosened(&before.0, &q, SHARED.odometry);
        let precise = inverse(&q).unwrap();
        for (d, shares, gain) in [
            ([0.0; 3], [0.0; 3], 0.0),
            ([1e-3, -2e-3, 4e-3], [0.003, -0.001, 0.002], 0.01),
            ([-2e-3, 0.0, 1e-2], [-0.004, 0.002, 0.005], -0.02),
        ] {
            let whole = |v: [f64; 6]| {
                let (off, wandered) = ([v[0], v[1], v[2]], [v[3], v[4], v[5]]);
                let likely =
                    (0..WAYS).map(|way| (wandered[way] / (WANDER * SHARED.odometry[way])).powi(2)).sum::<f64>();
                let less = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|i| a[i] - b[i]);
                kept(&before, less(d, off), less(shares, wandered), gain)
                    + 0.5 * (dot(off, times(&precise, off)) + likely)
            };
            let mut at = [0.0; 6];
            for axis in (0..6).cycle().take(30_000) {
                let h = 1e-4;
                let side = |by: f64| whole(core::array::from_fn(|i| if i == axis { at[i] + by } else { at[i] }));
                let (low, middle, high) = (side(-h), side(0.0), side(h));
                at[axis] -= 0.5 * h * (high - low) / (high - 2.0 * middle + low);
            }
            let (told, truth) = (kept(&after, d, shares, gain), whole(at));
            assert!((told - truth).abs() < 1e-4 * truth.abs().max(1.0), "{told}, not {truth}");
            assert!(truth < 0.99 * kept(&before, d, shares, gain));
        }
    }

    #[test]
    fn what_fades_costs_the_same_here_and_less_elsewhere() {
        let before = said(Normal::default(), Drift::default());
        let after = (before.0.faded(0.3), before.1.faded(0.3));
        let here = kept(&before, [0.0; 3], [0.0; 3], 0.0);
        for (d, shares, gain) in [
            ([0.0; 3], [0.0; 3], 0.0),
            ([1e-3, -2e-3, 4e-3], [0.003, -0.001, 0.002], 0.01),
            ([-2e-3, 0.0, 1e-2], [-0.004, 0.002, 0.005], -0.02),
        ] {
            let (whole, faded) = (kept(&before, d, shares, gain) - here, kept(&after, d, shares, gain) - here);
            assert!((faded - 0.3 * whole).abs() < 1e-9 * (1.0 + whole.abs()), "{faded} {whole}");
        }
    }

    #[test]
    fn place_and_shares_vary_together_as_the_whole_cost_says() {
        let (normal, drift) = said(Normal::default(), Drift::default());
        let place = inverse(&drift.eliminated(&normal, SHARED.odometry).marginal(SHARED.gain).curvature).unwrap();
        let told = drift.response(&normal, SHARED).unwrap().with_place(&place);
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
        let (normal, drift) = said(Normal::default(), Drift::default());
        let told = drift.eliminated(&normal, SHARED.odometry).marginal(SHARED.gain).cost;
        let (_, at) = least([0.0; 3]);
        let on_path = |shares: Shares| {
            let (normal, drift) = drift.shifted(&normal, shares);
            let promise = drift.response(&normal, SHARED).unwrap().promise;
            drift.eliminated(&normal, SHARED.odometry).marginal(SHARED.gain).cost + promise
        };
        let best = on_path([at[0], at[1], at[2]]);
        assert!((best - told).abs() < 1e-6, "{best}, not {told}");
        // On another path it is dearer by what the whole cost is, the shared error being at its best for each.
        let dearer = |shares: Shares| {
            let costs = [-1e-3, 0.0, 1e-3].map(|gain| cost([0.0; 3], shares, gain, SHARED));
            let (slope, bent) = (500.0 * (costs[2] - costs[0]), 1e6 * (costs[2] - 2.0 * costs[1] + costs[0]));
            costs[1] - 0.5 * slope * slope / bent - least([0.0; 3]).0
        };
        for other in [[0.0; 3], [at[0] + 1e-3, at[1], at[2]], [at[0], at[1], at[2] - 1e-3]] {
            let (told, truth) = (on_path(other) - best, dearer(other));
            assert!((told - truth).abs() < 1e-5 && truth > 1e-4, "{told}, not {truth}");
        }
    }

    #[test]
    fn shares_are_eliminated_at_their_best() {
        let (normal, drift) = said(Normal::default(), Drift::default());
        let told = drift.eliminated(&normal, SHARED.odometry).marginal(SHARED.gain);
        let response = drift.response(&normal, SHARED).unwrap();
        let (still, _) = least([0.0; 3]);
        for d in [[0.0; 3], [3e-4, -2e-4, 1e-3], [-1e-3, 5e-4, -4e-3]] {
            let (cost, at) = least(d);
            let more = told.moved(d).cost - told.cost;
            assert!((more - (cost - still)).abs() < 1e-6 * (1.0 + more.abs()), "{more} {}", cost - still);
            let shares = response.after(d);
            (0..WAYS).for_each(|way| assert!((shares[way] - at[way]).abs() < 1e-7, "{shares:?} {at:?}"));
        }
    }

    #[test]
    fn what_is_told_from_the_last_row_is_what_its_own_run_tells() {
        // Said from the first row and carried on to the last, and said from the last row from the beginning.
        let poses: Vec<Pose2> = readings().iter().map(|r| r.0).collect();
        let (way, last) = (Drift::along(&poses), poses[poses.len() - 1]);
        let (normal, drift) = said(Normal::default(), Drift::default());
        let (normal, carried) = drift.carried_on(&normal, &drift, FRAME.theta, arm(last));
        let (before, began) = Drift::default().told_from_last(&Normal::default(), &way, FRAME.theta, arm(last));
        let (own, ran) = said(before, began);
        let near = |a: f64, b: f64, scale: f64| (a - b).abs() < 1e-9 * scale;
        assert_eq!(normal, own);
        let scale = drift.own.iter().flatten().fold(1.0, |most: f64, v| most.max(v.abs()));
        for way in 0..WAYS {
            assert!(near(carried.pull[way], ran.pull[way], scale), "{carried:?} {ran:?}");
            assert!(near(carried.by_shared[way], ran.by_shared[way], scale));
            for i in 0..3 {
                assert!(near(carried.mixed[way][i], ran.mixed[way][i], scale));
                assert!(near(carried.own[way][i], ran.own[way][i], scale));
            }
        }
        assert!(carried.reach.norm() < 1e-12 && ran.reach.norm() < 1e-12 && ran.swept.norm() < 1e-12);
    }

    #[test]
    fn other_shares_are_the_same_cost_told_elsewhere() {
        let (normal, drift) = said(Normal::default(), Drift::default());
        let to = [2e-3, -1e-3, 3e-3];
        let (shifted, there) = drift.shifted(&normal, to);
        let at = |d: [f64; 3], shares: Shares| {
            let none = Shared { gain: f64::INFINITY, odometry: [f64::INFINITY; 3] };
            cost(d, shares, 0.0, none)
        };
        for d in [[0.0; 3], [1e-3, -5e-4, 2e-3]] {
            let told = shifted.moved(d).cost - shifted.cost;
            let wanted = at(d, to) - at([0.0; 3], to);
            assert!((told - wanted).abs() < 1e-9 * (1.0 + wanted.abs()), "{told} {wanted}");
        }
        assert!((shifted.cost - normal.cost - (at([0.0; 3], to) - at([0.0; 3], [0.0; 3]))).abs() < 1e-8);
        // A prior of the shares is about none, wherever they are told.
        let (a, b) = (drift.eliminated(&normal, SHARED.odometry), there.eliminated(&shifted, SHARED.odometry));
        assert!((a.cost - b.cost).abs() < 1e-7, "{} {}", a.cost, b.cost);
        (0..3).for_each(|i| assert!((a.gradient[i] - b.gradient[i]).abs() < 1e-6 * (1.0 + a.gradient[i].abs())));
    }
}
