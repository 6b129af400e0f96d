//! What the readings say of a place, of the odometry's calibration and of the readings' gain.
//!
//! Each increment of the odometry may be off by a share of itself. What does not average out is one share for all: the path stretched,
//! sheared aside or turned too far. These three are unknowns beside the place, and so is a relative error that all readings share:
//! seven, in one information matrix. Before any reading calibration and gain have the standard deviations of the declared bounds.

use super::information::{Conditional, Information, Prior};
use super::shares::{Shared, Shares, WAYS, stds};
use crate::linear_algebra::{Cholesky, Square, add, dot, inverse, times};
use crate::plane::{Pose2, Vec2};
use crate::world::Odometry;

/// A symmetric matrix over (x, y, theta).
pub(super) type Matrix = Square<3>;

/// The unknowns: the move of the odometry frame (x, y, heading), the odometry's calibration, the gain.
const PLACE: [usize; 3] = [0, 1, 2];
const CALIBRATION: [usize; WAYS] = [3, 4, 5];
const GAIN: usize = 6;
const ALL: usize = 7;

/// How far the calibration may wander each time that rows are summed up (of its standard deviations).
const WANDER: f64 = 0.2;
/// Variances of a frame that does not move at all (m², rad²).
const STILL: [f64; 3] = [1e-14, 1e-14, 1e-12];

/// A path by odometry, as far as its errors depend on it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Way {
    /// From its first row (odometry frame, m), the turn since then (rad), and where turning too far by its own amount would have taken
    /// it (m).
    reach: Vec2,
    turned: f64,
    swept: Vec2,
}

/// What the readings so far say.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Belief {
    /// The information around the place, the calibration and the gain where it is linearised.
    pub(super) information: Information<ALL>,
    pub(super) way: Way,
    /// The calibration that the path has been corrected by.
    at: Shares,
    /// Whether the calibration leaves the robot where it is at the last row, not at the first.
    from_last: bool,
}

/// The calibration given the place.
pub(super) type Response = Conditional<3, WAYS>;

impl Way {
    /// The robot's way along these odometry poses.
    pub(super) fn along(poses: &[Pose2]) -> Self {
        let mut way = Self::default();
        poses.windows(2).for_each(|pair| way.travel(pair[0], pair[1]));
        way
    }

    /// Goes on from one odometry pose to the next.
    pub(super) fn travel(&mut self, from: Pose2, to: Pose2) {
        let step = to.position() - from.position();
        let turn = from.between(to).theta;
        self.swept += step.perp() * (self.turned + 0.5 * turn);
        self.reach += step;
        self.turned += turn;
    }

    /// How far a change of the calibration moves one end of the way against the other (m, rad).
    pub(super) fn moves(&self, by: Shares) -> [f64; 2] {
        let errors = self.errors(0.0);
        let sum = |i: usize| (0..WAYS).map(|way| errors[way][i] * by[way]).sum::<f64>();
        [sum(0).hypot(sum(1)), sum(2).abs()]
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

    /// The derivatives of a reading by the calibration, where those by the whisker base's pose are `at_base`; the base is `arm`
    /// from the robot, map frame.
    pub(super) fn slopes(&self, theta: f64, arm: Vec2, at_base: [f64; 3]) -> [f64; WAYS] {
        let turned = arm.perp();
        self.errors(theta).map(|e| dot(at_base, [e[0] + e[2] * turned.x, e[1] + e[2] * turned.y, e[2]]))
    }

    /// What is left of it after its first part.
    fn after(&self, first: &Self) -> Self {
        let reach = self.reach - first.reach;
        let swept = self.swept - first.swept - reach.perp() * first.turned;
        Self { reach, swept, turned: self.turned - first.turned }
    }
}

impl Belief {
    /// One that is told with its place alone, as a search finds it.
    pub(super) fn of_place(information: &Information<4>) -> Self {
        let unit = |i: usize| core::array::from_fn(|j| f64::from(u8::from(i == j)));
        let rows = [unit(0), unit(1), unit(2), unit(GAIN)];
        Self { information: information.transformed(&rows), ..Self::default() }
    }

    /// Place and gain, as long as the calibration stays what it is.
    pub(super) fn place_and_gain(&self) -> Information<4> {
        self.information.conditioned([0, 1, 2, GAIN])
    }

    /// The calibration that the path has been corrected by.
    pub(super) fn at(&self) -> Shares {
        self.at
    }

    /// Whether the calibration leaves the robot where it is at the last row, not at the first.
    pub(super) fn is_from_last(&self) -> bool {
        self.from_last
    }

    /// Adds a reading: its residual (standard deviations, with its weight), and its derivatives by a move, by the calibration and by
    /// the gain.
    pub(super) fn add(&mut self, by: [f64; 3], by_calibration: [f64; WAYS], by_gain: f64, residual: (f64, f64)) {
        let ([x, y, turn], [long, aside, turned]) = (by, by_calibration);
        self.information.add(&[x, y, turn, long, aside, turned, by_gain], residual.0, residual.1);
    }

    /// The same around a place that has been moved by `d`.
    pub(super) fn moved(&self, d: [f64; 3]) -> Self {
        self.shifted(d, self.at)
    }

    /// The same around a place that has been moved by `d` and another calibration.
    pub(super) fn shifted(&self, d: [f64; 3], to: Shares) -> Self {
        let by = [0, 1, 2].map(|way| to[way] - self.at[way]);
        let information = self.information.shifted([d[0], d[1], d[2], by[0], by[1], by[2], 0.0]);
        Self { information, at: to, ..*self }
    }

    /// The same in a map that is turned by this angle.
    pub(super) fn turned(&self, angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        let mut back = unit();
        (back[0][0], back[0][1], back[1][0], back[1][1]) = (cos, sin, -sin, cos);
        Self { information: self.information.transformed(&back), ..*self }
    }

    /// The same with the robot's place at a later row in the place of that at the first: `reached` is the path until there, and
    /// `arm` goes from the pivot to the robot there, in a frame turned by `theta`.
    pub(super) fn carried_on(&self, reached: &Way, theta: f64, arm: Vec2) -> Self {
        // What was a move is the move there less what the calibration does until then.
        let by = reached.holding(theta, arm);
        let mut from = unit();
        (0..3).for_each(|i| (0..WAYS).for_each(|way| from[i][CALIBRATION[way]] = by[way][i]));
        Self { information: self.information.transformed(&from), way: self.way.after(reached), ..*self }
    }

    /// The same with the robot's place at the last row in the place of that at the first, before any row has been taken; `way` is
    /// the whole path.
    pub(super) fn told_from_last(&self, way: &Way, theta: f64, arm: Vec2) -> Self {
        Self { from_last: true, ..self.carried_on(way, theta, arm) }
    }

    /// What the readings say with this share of its weight.
    pub(super) fn faded(&self, share: f64) -> Self {
        Self { information: self.information.faded(share), ..*self }
    }

    /// The same after the robot has made a random move of this covariance, and the calibration has wandered on a little.
    pub(super) fn loosened(&self, covariance: &Matrix, stds: Shares) -> Self {
        let mut own = *covariance;
        (0..3).for_each(|i| own[i][i] += STILL[i]);
        let Some(mut precision) = inverse(&own) else { return *self };
        let told = &self.information;
        add(&mut precision, &told.conditioned(PLACE).matrix);
        let information = if stds.iter().any(|&std| std <= 0.0) {
            inverse(&precision).map(|step| told.predicted(&step))
        } else {
            let mut both = told.conditioned([0, 1, 2, 3, 4, 5]).matrix;
            (0..3).for_each(|i| both[i][..3].copy_from_slice(&precision[i]));
            CALIBRATION.into_iter().zip(stds).for_each(|(i, std)| both[i][i] += (WANDER * std).powi(-2));
            Cholesky::regular(&both).map(|factor| told.predicted(&factor.inverse()))
        };
        Self { information: information.unwrap_or(*told), ..*self }
    }

    /// The place with calibration and gain marginalised: as if what they do to the readings were a correlated part of the noise.
    pub(super) fn place(&self, shared: Shared) -> Information<3> {
        if !shared.has_odometry() {
            return self.place_on_path(shared.gain);
        }
        let [long, aside, turned] = self.priors(shared);
        let priors = [long, aside, turned, Prior { mean: 0.0, std: shared.gain }];
        let told = self.information.marginal(PLACE, [3, 4, 5, GAIN], priors);
        told.unwrap_or_else(|| self.place_on_path(shared.gain))
    }

    /// The place on the path as it has been corrected, with the gain marginalised, of this standard deviation.
    pub(super) fn place_on_path(&self, gain: f64) -> Information<3> {
        self.place_and_gain().without_gain(gain)
    }

    /// The gain that the readings estimate.
    pub(super) fn gain(&self, shared: Shared) -> f64 {
        let left = self.information.marginal([GAIN], CALIBRATION, self.priors(shared));
        let left = left.unwrap_or_else(|| self.information.conditioned([GAIN]));
        if shared.gain > 0.0 { left.vector[0] / (left.matrix[0][0] + shared.gain.powi(-2)) } else { 0.0 }
    }

    /// The calibration given the place, as a distance from that which the path has been corrected by; none where it is not looked for.
    pub(super) fn calibration(&self, shared: Shared) -> Option<Response> {
        shared.odometry.iter().all(|&std| std > 0.0).then_some(())?;
        self.without_gain(shared)?.conditional(CALIBRATION, PLACE, self.priors(shared))
    }

    /// The calibration that the odometry needs, each number with its standard deviation, where the place has this covariance.
    pub(super) fn calibrated(&self, given: &Response, place: &Matrix) -> [[f64; 2]; WAYS] {
        let covariance = given.wherever(place);
        [0, 1, 2].map(|way| [self.at[way] + given.mean[way], covariance[way][way].max(0.0).sqrt()])
    }

    /// The sum of squares, in standard deviations of the readings' noise, that the declared bounds may add to the residuals.
    pub(super) fn squares(&self, bounds: &Odometry) -> f64 {
        let std = stds(bounds);
        (0..WAYS).map(|way| std[way] * std[way] * self.information.matrix[CALIBRATION[way]][CALIBRATION[way]]).sum()
    }

    /// What the declared bounds add to the covariance of the robot's pose at the last row; `arm` goes from the pivot to the robot,
    /// map frame.
    pub(super) fn covariance(
        &self,
        shared: Shared,
        open: [f64; 3],
        theta: f64,
        arm: Vec2,
        bounds: &Odometry,
    ) -> Matrix {
        let told = self.without_gain(shared).unwrap_or_else(|| self.information.conditioned([0, 1, 2, 3, 4, 5]));
        let place = told.conditioned(PLACE).covariance(open).unwrap_or_default();
        let (turned, std) = (arm.perp(), stds(bounds));
        let mut out = [[0.0; 3]; 3];
        for (way, error) in self.way.errors(theta).into_iter().enumerate() {
            let d = times(&place, PLACE.map(|i| told.matrix[i][CALIBRATION[way]])).map(|v| -v);
            let off = [error[0] + d[0] + d[2] * turned.x, error[1] + d[1] + d[2] * turned.y, error[2] + d[2]];
            let variance = std[way] * std[way];
            (0..3).for_each(|i| (0..3).for_each(|j| out[i][j] += variance * off[i] * off[j]));
        }
        out
    }

    /// What is known of the calibration before any reading.
    fn priors(&self, shared: Shared) -> [Prior; WAYS] {
        [0, 1, 2].map(|way| Prior { mean: -self.at[way], std: shared.odometry[way] })
    }

    /// Place and calibration with the gain marginalised.
    fn without_gain(&self, shared: Shared) -> Option<Information<6>> {
        self.information.marginal([0, 1, 2, 3, 4, 5], [GAIN], [Prior { mean: 0.0, std: shared.gain }])
    }
}

fn unit() -> Square<ALL> {
    core::array::from_fn(|i| core::array::from_fn(|j| f64::from(u8::from(i == j))))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

    use super::*;

    #[test]
    fn a_path_that_is_too_long_leaves_the_middle_fixed() {
        // Five readings of x alone along a straight metre: the fit moves the path so that its middle is right, and the
        // last row is off by half of the stretch; y and heading are not read and stay open.
        let mut told = Belief::default();
        for row in 0..5 {
            if row > 0 {
                told.way.travel(
                    Pose2::new(0.25 * f64::from(row - 1), 0.0, 0.0),
                    Pose2::new(0.25 * f64::from(row), 0.0, 0.0),
                );
            }
            let at_base = [1.0, 0.0, 0.0];
            told.add(at_base, told.way.slopes(0.0, Vec2::ZERO, at_base), 0.0, (0.0, 1.0));
        }
        let bounds = Odometry { translation_relative: 0.02, rotation_relative: 0.0 };
        let added = told.covariance(Shared::default(), [0.0, 1.0, 1.0], 0.0, Vec2::ZERO, &bounds);
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
    fn cost(d: [f64; 3], shares: Shares, gain: f64, shared: Shared) -> f64 {
        let mut way = Way::default();
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
    fn kept(told: &Belief, d: [f64; 3], shares: Shares, gain: f64) -> f64 {
        let [x, y, turn] = d;
        let [long, aside, turned] = shares;
        told.information.shifted([x, y, turn, long, aside, turned, gain]).constant
    }

    #[test]
    fn a_random_move_and_shares_that_wander_are_at_their_best_for_every_move() {
        let before = said(Belief::default());
        let q = [[4e-6, 1e-6, 2e-6], [1e-6, 9e-6, -1e-6], [2e-6, -1e-6, 5e-5]];
        let after = before.loosened(&q, SHARED.odometry);
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
        let before = said(Belief::default());
        let after = before.faded(0.3);
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
        let on_path = |shares: Shares| {
            let belief = belief.shifted([0.0; 3], shares);
            belief.place(SHARED).constant + belief.calibration(SHARED).unwrap().fall
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
        let belief = said(Belief::default());
        let (told, response) = (belief.place(SHARED), belief.calibration(SHARED).unwrap());
        let (still, _) = least([0.0; 3]);
        for d in [[0.0; 3], [3e-4, -2e-4, 1e-3], [-1e-3, 5e-4, -4e-3]] {
            let (cost, at) = least(d);
            let more = told.shifted(d).constant - told.constant;
            assert!((more - (cost - still)).abs() < 1e-6 * (1.0 + more.abs()), "{more} {}", cost - still);
            let shares = response.given(d);
            (0..WAYS).for_each(|way| assert!((shares[way] - at[way]).abs() < 1e-7, "{shares:?} {at:?}"));
        }
    }

    #[test]
    fn what_is_told_from_the_last_row_is_what_its_own_run_tells() {
        // Said from the first row and carried on to the last, and said from the last row from the beginning.
        let poses: Vec<Pose2> = readings().iter().map(|r| r.0).collect();
        let (way, last) = (Way::along(&poses), poses[poses.len() - 1]);
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
        assert!(carried.way.reach.norm() < 1e-12 && ran.way.reach.norm() < 1e-12 && ran.way.swept.norm() < 1e-12);
    }

    #[test]
    fn other_shares_are_the_same_cost_told_elsewhere() {
        let told = said(Belief::default());
        let to = [2e-3, -1e-3, 3e-3];
        let there = told.shifted([0.0; 3], to);
        let place = |told: &Belief| told.information.conditioned(PLACE);
        let (before, shifted) = (place(&told), place(&there));
        let at = |d: [f64; 3], shares: Shares| {
            let none = Shared { gain: f64::INFINITY, odometry: [f64::INFINITY; 3] };
            cost(d, shares, 0.0, none)
        };
        for d in [[0.0; 3], [1e-3, -5e-4, 2e-3]] {
            let told = shifted.shifted(d).constant - shifted.constant;
            let wanted = at(d, to) - at([0.0; 3], to);
            assert!((told - wanted).abs() < 1e-9 * (1.0 + wanted.abs()), "{told} {wanted}");
        }
        assert!((shifted.constant - before.constant - (at([0.0; 3], to) - at([0.0; 3], [0.0; 3]))).abs() < 1e-8);
        // A prior of the shares is about none, wherever they are told.
        let [a, b] = [told, there].map(|told| told.place(SHARED));
        assert!((a.constant - b.constant).abs() < 1e-7, "{} {}", a.constant, b.constant);
        (0..3).for_each(|i| assert!((a.vector[i] - b.vector[i]).abs() < 1e-6 * (1.0 + a.vector[i].abs())));
    }
}
