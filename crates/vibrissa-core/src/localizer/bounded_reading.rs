//! Bounded-error readings \[jaulin2001applied, ch. 3\]: which moments a reading allows, and where the robot may have read it.

use crate::plane::Pose2;
use crate::sets::Interval;
use crate::world::{MountedWhisker, Odometry, Robot};
use crate::{Error, Result};
use std::collections::VecDeque;

/// Roundings on the way from a moment to its reading and back, at most.
const ROUNDINGS: f64 = 8.0;

/// The interval that holds the true moment (N m) of a reading `z`, so many seconds after the first row.
///
/// A reading is `(1 + gain) h + zero` but for the noise, whose bound is relative to the reading with its zero or without.
pub(super) fn moment(whisker: &MountedWhisker, z: f64, elapsed: f64) -> Interval {
    let (noise, errors) = (&whisker.noise, &whisker.errors);
    let zero = errors.zero + errors.zero_drift * elapsed.abs();
    let relative = |edge: f64| noise.moment_relative * z.abs().max(edge.abs());
    // Noise may stand before the gain, too.
    let absolute = noise.moment_absolute * (1.0 + errors.gain);
    let (lo, hi) = (z - zero, z + zero);
    let (below, above) = (relative(lo) + absolute, relative(hi) + absolute);
    // Outward, so that a reading at the end of its bound is within it however its sums are rounded.
    let rounding = ROUNDINGS * f64::EPSILON * (z.abs() + zero + below.max(above));
    let (lo, hi) = (lo - below - rounding, hi + above + rounding);
    let gain = |edge: f64, most: bool| edge / if most { 1.0 - errors.gain } else { 1.0 + errors.gain };
    Interval::new(gain(lo, lo < 0.0), gain(hi, hi > 0.0))
}

/// Checks that a robot's error bounds leave something: no length, stiffness, gain or map may be nothing at all.
pub(super) fn check(robot: &Robot) -> Result<()> {
    let share = |what: &str, value: f64, unit: f64, allowed: &str| {
        if (0.0..0.9 * unit).contains(&value) {
            Ok(())
        } else {
            Err(Error::data(what.to_owned()).value(value).allowed(allowed.to_owned()))
        }
    };
    for whisker in &robot.whiskers {
        let of = |what: &str| format!("the bound on the error of {what} of the whisker {}", whisker.name);
        let errors = &whisker.errors;
        share(&of("the length"), errors.length, whisker.beam.length, "from 0 to below 0.9 times its length, in m")?;
        share(&of("the flexural rigidity"), errors.rigidity, 1.0, "from 0 to below 0.9, relative to it")?;
        share(&of("the gain"), errors.gain, 1.0, "from 0 to below 0.9, relative to it")?;
        let [x, y, theta] = errors.mount;
        for (what, value) in
            [("the zero", errors.zero), ("the zero's drift", errors.zero_drift), ("the mount", x + y + theta)]
        {
            share(&of(what), value, f64::MAX, "no less than 0")?;
        }
    }
    share("the bound on the delay of readings", robot.odometry.delay, f64::MAX, "no less than 0 s")?;
    share("the bound on the error of the map's scale", robot.map_scale, 1.0, "from 0 to below 0.9, relative to it")
}

/// The readings of one row.
#[derive(Debug)]
pub(super) struct RowReadings {
    pub(super) moments: Vec<Interval>,
    pub(super) heading: Option<Interval>,
}

/// Rows whose readings wait until it is known where the robot may have taken them.
#[derive(Debug, Default)]
pub(super) struct LateReadings {
    delay: f64,
    /// Index of the earliest row that waits, and the readings from there on.
    first: usize,
    waiting: VecDeque<RowReadings>,
}

/// What is known of a row that has waited.
pub(super) struct ReadRow {
    pub(super) readings: RowReadings,
    /// Way (m) and turn (rad) by odometry from the row to any time at which its readings may have been taken; none where the
    /// log does not reach so far.
    pub(super) late: Option<(f64, f64)>,
}

impl LateReadings {
    pub(super) fn new(odometry: &Odometry) -> Self {
        Self { delay: odometry.delay, ..Self::default() }
    }

    pub(super) fn push(&mut self, readings: RowReadings) {
        self.waiting.push_back(readings);
    }

    /// The next row whose readings were taken within the log so far, or any one where no more rows come.
    ///
    /// Between two rows a robot is no farther from either than the odometry's way from one to the other.
    pub(super) fn pop(&mut self, rows: &[(f64, Pose2)], is_over: bool) -> Option<ReadRow> {
        let t = rows.get(self.first)?.0;
        let end = rows[self.first..].iter().position(|row| row.0 >= t + self.delay).map(|ahead| self.first + ahead);
        if end.is_none() && !is_over {
            return None;
        }
        let begin = rows[..=self.first].iter().rposition(|row| row.0 <= t - self.delay);
        let readings = self.waiting.pop_front()?;
        let here = self.first;
        self.first += 1;
        let late = begin.zip(end).map(|(begin, end)| {
            let (before, after) = (way(&rows[begin..=here]), way(&rows[here..=end]));
            (before.0.max(after.0), before.1.max(after.1))
        });
        Some(ReadRow { readings, late })
    }
}

/// Way (m) and turn (rad) along some rows.
fn way(rows: &[(f64, Pose2)]) -> (f64, f64) {
    rows.windows(2).fold((0.0, 0.0), |(way, turn), row| {
        let step = row[0].1.between(row[1].1);
        (way + step.position().norm(), turn + step.theta.abs())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::MomentNoise;

    #[test]
    fn a_moment_is_within_what_its_reading_allows() {
        let noise = MomentNoise { moment_relative: 0.05, moment_absolute: 2e-5 };
        let mut whisker = MountedWhisker { noise, ..MountedWhisker::default() };
        let exact = moment(&whisker, 4e-4, 3.0);
        let most = 0.05 * 4e-4 + 2e-5;
        assert!((exact.lo() - (4e-4 - most)).abs() < 1e-18 && (exact.hi() - (4e-4 + most)).abs() < 1e-18, "{exact:?}");
        whisker.errors.zero = 1e-4;
        whisker.errors.zero_drift = 2e-5;
        whisker.errors.gain = 0.1;
        let signs = [-1.0, 0.0, 1.0];
        for h in [-1e-3, -1e-4, 0.0, 3e-5, 2e-4] {
            for (gain, zero) in signs.iter().flat_map(|gain| signs.map(|zero| (1.0 + 0.1 * gain, 1.6e-4 * zero))) {
                for noise in signs {
                    // The noise after gain and zero, and before.
                    let clean: f64 = gain * h + zero;
                    let after = clean + noise * 0.999 * (0.05 * clean.abs() + 2e-5) / 1.05;
                    let read = h + noise * 0.999 * (0.05 * f64::abs(h) + 2e-5) / 1.05;
                    for z in [after, gain * read + zero] {
                        assert!(moment(&whisker, z, 3.0).contains(h), "{h} {gain} {zero} {noise}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_reading_at_the_end_of_its_bound_may_be_that_of_a_free_whisker() {
        // Sums and products of the bound are rounded this way and that.
        for k in 1..2000 {
            let noise = MomentNoise { moment_relative: 0.0, moment_absolute: 1e-8 * f64::from(k) };
            let mut whisker = MountedWhisker { noise, ..MountedWhisker::default() };
            whisker.errors.zero = 0.1 * noise.moment_absolute;
            let bound = noise.moment_absolute + whisker.errors.zero;
            for z in [bound, -bound, (1.0 / 3.0) * bound * 3.0] {
                assert!(moment(&whisker, z, 0.0).contains(0.0), "{z} of {bound}");
            }
        }
    }

    #[test]
    fn readings_wait_for_the_odometry_around_them() {
        let rows: Vec<(f64, Pose2)> =
            (0..10).map(|k| (0.1 * f64::from(k), Pose2::new(0.01 * f64::from(k), 0.0, 0.02 * f64::from(k)))).collect();
        let odometry = Odometry { delay: 0.15, ..Odometry::default() };
        let mut late = LateReadings::new(&odometry);
        let mut told = Vec::new();
        for count in 1..=rows.len() {
            late.push(RowReadings { moments: Vec::new(), heading: None });
            while let Some(row) = late.pop(&rows[..count], false) {
                told.push((count, row.late));
            }
        }
        while let Some(row) = late.pop(&rows, true) {
            told.push((rows.len() + 1, row.late));
        }
        assert_eq!(told.len(), rows.len());
        for (row, (count, late)) in told.into_iter().enumerate() {
            // Two rows before and after hold all times at which the reading may have been taken.
            assert_eq!(count, if row < 8 { row + 3 } else { 11 });
            assert_eq!(late.is_some(), (2..8).contains(&row));
            if let Some((way, turn)) = late {
                assert!((way - 0.02).abs() < 1e-4 && (turn - 0.04).abs() < 1e-12, "{way} {turn}");
            }
        }
    }

    #[test]
    fn bounds_that_leave_nothing_are_refused() {
        let mut robot = Robot::default();
        assert!(check(&robot).is_ok());
        robot.map_scale = 1.0;
        assert!(check(&robot).is_err());
        robot.map_scale = 0.0;
        robot.whiskers[0].errors.length = 0.075;
        assert!(check(&robot).is_err());
        robot.whiskers[0].errors.length = 0.0;
        robot.whiskers[0].errors.mount[1] = f64::NAN;
        assert!(check(&robot).is_err());
    }
}
