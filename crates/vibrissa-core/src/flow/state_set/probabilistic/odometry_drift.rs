//! Random walk of the odometry: errors of its increments that are independent of each other \[barfoot2017state, ch. 3; thrun2005probabilistic, ch. 5\].
//!
//! An error of a turn swings all that follows around, so that place and heading of a row are off together. How far, as seen from another row, follows
//! from sums over the increments between, which are kept for each row. In the odometry frame; errors of errors are neglected.

use crate::linear_algebra::{Square, inverse};
use crate::plane::{Pose2, Vec2};

/// Sums over increments: of the variance of their places (m²), and of that of their turns (rad²) with the first and the second moment of where they turn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct DriftSums {
    place: f64,
    turn: f64,
    first: Vec2,
    second: [f64; 3],
}

impl DriftSums {
    /// With one increment more, which leads to a pose; its errors are even over a disc and between two bounds, relative to it.
    pub(super) fn with(self, increment: Pose2, to: Pose2, [way, turn]: [f64; 2]) -> Self {
        let (place, q) =
            ((way * way) * increment.position().norm_squared() / 4.0, (turn * increment.theta).powi(2) / 3.0);
        let r = to.position();
        let [xx, xy, yy] = self.second;
        Self {
            place: self.place + place,
            turn: self.turn + q,
            first: self.first + r * q,
            second: [xx + q * r.x * r.x, xy + q * r.x * r.y, yy + q * r.y * r.y],
        }
    }

    fn without(self, other: Self) -> Self {
        Self {
            place: self.place - other.place,
            turn: self.turn - other.turn,
            first: self.first - other.first,
            second: core::array::from_fn(|k| self.second[k] - other.second[k]),
        }
    }

    /// The covariance of the pose at a place (x, y, heading) by the errors of these increments.
    fn covariance_at(&self, r: Vec2) -> Square<3> {
        let (q, s) = (self.turn, self.first);
        let [xx, xy, yy] = self.second;
        let d = r * q - s;
        let [dxx, dxy, dyy] = [
            q * r.x * r.x - 2.0 * r.x * s.x + xx,
            q * r.x * r.y - r.x * s.y - r.y * s.x + xy,
            q * r.y * r.y - 2.0 * r.y * s.y + yy,
        ];
        [[self.place + dyy.max(0.0), -dxy, -d.y], [-dxy, self.place + dxx.max(0.0), d.x], [-d.y, d.x, q]]
    }
}

/// Where a row is on the walk, as seen from the row that is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OnWalk {
    place: Vec2,
    sums: DriftSums,
    held: DriftSums,
    is_after: bool,
}

/// How the error of a pose goes over into that of another one: what it keeps of it, and the covariance of what is new.
pub(super) struct Transition {
    pub(super) keeps: Square<3>,
    pub(super) fresh: Square<3>,
}

impl OnWalk {
    pub(super) fn new(place: Vec2, sums: DriftSums, held: DriftSums, is_after: bool) -> Self {
        Self { place, sums, held, is_after }
    }

    /// The covariance of the pose here (x, y, heading) where that of the held row is exact.
    pub(super) fn covariance(&self) -> Square<3> {
        let between = if self.is_after { self.sums.without(self.held) } else { self.held.without(self.sums) };
        between.covariance_at(self.place)
    }

    /// To a later row, or the same.
    pub(super) fn transition(&self, to: &Self) -> Transition {
        if self.is_after {
            return Transition {
                keeps: carried(self.place, to.place),
                fresh: to.sums.without(self.sums).covariance_at(to.place),
            };
        }
        let there = to.covariance();
        if to.is_after {
            return Transition { keeps: [[0.0; 3]; 3], fresh: there };
        }
        // The walk leads from the held row to the nearer one and on to this one: it is followed backwards.
        let with = product(&there, &transposed(&carried(to.place, self.place)));
        let Some(precise) = inverse(&self.covariance()) else {
            return Transition { keeps: [[0.0; 3]; 3], fresh: there };
        };
        let keeps = product(&with, &precise);
        let told = product(&keeps, &transposed(&with));
        let fresh = core::array::from_fn(|i| core::array::from_fn(|j| there[i][j] - 0.5 * (told[i][j] + told[j][i])));
        Transition { keeps, fresh }
    }
}

/// How a reading depends on the error of the robot's pose there, and where it is on the odometry's random walk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Drift {
    pub(super) by: [f64; 3],
    pub(super) on_walk: OnWalk,
}

impl Drift {
    /// The variance of the reading by errors of increments, before any reading.
    pub(super) fn variance(&self) -> f64 {
        let covariance = self.on_walk.covariance();
        (0..3).map(|i| (0..3).map(|j| self.by[i] * covariance[i][j] * self.by[j]).sum::<f64>()).sum::<f64>().max(0.0)
    }
}

/// What an error of the pose at one place is at another one.
fn carried(from: Vec2, to: Vec2) -> Square<3> {
    let arm = (to - from).perp();
    [[1.0, 0.0, arm.x], [0.0, 1.0, arm.y], [0.0, 0.0, 1.0]]
}

pub(super) fn transposed(a: &Square<3>) -> Square<3> {
    core::array::from_fn(|i| core::array::from_fn(|j| a[j][i]))
}

pub(super) fn product(a: &Square<3>, b: &Square<3>) -> Square<3> {
    core::array::from_fn(|i| core::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: [f64; 2] = [0.05, 0.03];

    /// Numbers between -1 and 1 that repeat nothing.
    fn number(k: usize) -> f64 {
        (1.7 * k as f64 + 0.3 * (k * k) as f64).sin()
    }

    fn way() -> (Vec<Pose2>, Vec<Pose2>) {
        let increments: Vec<Pose2> =
            (0..20).map(|k| Pose2::new(0.02 + 0.01 * number(k), 0.01 * number(k + 50), 0.3 * number(k + 90))).collect();
        let mut here = Pose2::new(2.0, -1.0, 0.4);
        let along = |step: &Pose2| {
            here = here.compose(*step);
            here
        };
        let poses = increments.iter().map(along).collect();
        (increments, poses)
    }

    /// Covariance of the poses at two rows where a third is held, increment by increment.
    fn directly(increments: &[Pose2], poses: &[Pose2], held: usize, rows: [usize; 2]) -> Square<3> {
        let mut sum = [[0.0; 3]; 3];
        for l in 1..poses.len() {
            let moved = rows.map(|row| (held < l && l <= row) || (row < l && l <= held));
            // The two sides of the held row have no increment in common.
            if !moved[0] || !moved[1] {
                continue;
            }
            let place = (BOUNDS[0] * increments[l].position().norm()).powi(2) / 4.0;
            let turn = (BOUNDS[1] * increments[l].theta).powi(2) / 3.0;
            let column = |row: usize| {
                let arm = (poses[row].position() - poses[l].position()).perp();
                [arm.x, arm.y, 1.0]
            };
            let (a, b) = (column(rows[0]), column(rows[1]));
            (0..3).for_each(|i| (0..3).for_each(|j| sum[i][j] += turn * a[i] * b[j]));
            (sum[0][0], sum[1][1]) = (sum[0][0] + place, sum[1][1] + place);
        }
        sum
    }

    #[test]
    fn the_walk_has_the_covariances_of_its_increments() {
        let (increments, poses) = way();
        let mut sums = Vec::new();
        for (&increment, &pose) in increments.iter().zip(&poses) {
            sums.push(sums.last().copied().unwrap_or_else(DriftSums::default).with(increment, pose, BOUNDS));
        }
        let near = |a: &Square<3>, b: &Square<3>| {
            (0..3).all(|i| (0..3).all(|j| (a[i][j] - b[i][j]).abs() <= 1e-9 * (b[i][i] * b[j][j]).sqrt() + 1e-16))
        };
        for held in [0, 7, 19] {
            let at = |row: usize| OnWalk::new(poses[row].position(), sums[row], sums[held], row >= held);
            for i in 0..20 {
                let own = directly(&increments, &poses, held, [i, i]);
                assert!(near(&at(i).covariance(), &own), "{held} {i}: {:?} {own:?}", at(i).covariance());
                for j in i..20 {
                    let Transition { keeps, fresh } = at(i).transition(&at(j));
                    let with = product(&keeps, &own);
                    let direct = directly(&increments, &poses, held, [j, i]);
                    let there = directly(&increments, &poses, held, [j, j]);
                    let scale = |a: usize, b: usize| (there[a][a] * own[b][b]).sqrt();
                    for a in 0..3 {
                        for b in 0..3 {
                            let off = (with[a][b] - direct[a][b]).abs();
                            assert!(off <= 1e-6 * scale(a, b) + 1e-15, "{held} {i} {j}: {with:?} {direct:?}");
                        }
                    }
                    let all = product(&with, &transposed(&keeps));
                    let sum: Square<3> = core::array::from_fn(|a| core::array::from_fn(|b| all[a][b] + fresh[a][b]));
                    let off =
                        (0..3).map(|a| (sum[a][a] - there[a][a]).abs() / (there[a][a] + 1e-12)).fold(0.0, f64::max);
                    assert!(off < 1e-3, "{held} {i} {j}: {sum:?} {there:?}");
                }
            }
        }
    }
}
