//! Headings that go with another angle as degrees go with radians: both are told by least squares over the whole log.
//!
//! Headings within one turn look like radians whatever their unit. But a robot that drives turns its course by as much as its heading, and
//! an absolute heading turns by as much as the odometry's. Where one turns by a sixtieth of the other along the whole log, one is in degrees.

use crate::plane::{Pose2, Vec2, wrap_angle};

/// Way of the robot over which a course is taken (m): errors of odometry, some tenths of a millimetre, turn it by a few hundredths of a
/// radian, and what sweeps along a wall turn by is more.
const CHORD: f64 = 0.01;
/// Fewest courses, or rows with an absolute heading, that a slope is fitted to.
const FEWEST: f64 = 8.0;
/// Smallest spread of what may be in degrees (standard deviation): one of 0.3 rad is a robot that turns by a radian.
const LEAST_SPREAD: f64 = 0.3;
/// How far the slope may be from that of degrees, as a share of it. A heading and a course are fixed to each other on a robot that does
/// not drive sideways; on others their slope is any number, seldom this one.
const SLACK: f64 = 0.2;
/// Least square of the correlation: of two angles that have nothing in common it is small.
const LEAST_CORRELATION: f64 = 0.9;

/// The slope of one angle over another, row by row.
#[derive(Clone, Debug, Default)]
struct Slope {
    count: f64,
    mean: [f64; 2],
    /// Sums of squares about the means: of the first, of the second, of their products.
    sums: [f64; 3],
}

impl Slope {
    fn add(&mut self, values: [f64; 2]) {
        self.count += 1.0;
        let before = [values[0] - self.mean[0], values[1] - self.mean[1]];
        for (mean, off) in self.mean.iter_mut().zip(before) {
            *mean += off / self.count;
        }
        let after = [values[0] - self.mean[0], values[1] - self.mean[1]];
        self.sums[0] += before[0] * after[0];
        self.sums[1] += before[1] * after[1];
        self.sums[2] += before[0] * after[1];
    }

    /// Whether the second angle is the first in radians, where the first is in degrees.
    fn first_is_in_degrees(&self) -> bool {
        let [first, second, both] = self.sums;
        let spread = (first / self.count).sqrt();
        let slope = both / first;
        self.count >= FEWEST
            && spread > LEAST_SPREAD
            && (slope.to_degrees() - 1.0).abs() < SLACK
            && both * both > LEAST_CORRELATION * first * second
    }

    fn swapped(&self) -> Self {
        let ([a, b], [aa, bb, ab]) = (self.mean, self.sums);
        Self { mean: [b, a], sums: [bb, aa, ab], ..*self }
    }
}

/// What is compared along a log.
#[derive(Clone, Debug, Default)]
pub(super) struct Degrees {
    /// The odometry's heading as written, and the course.
    course: Slope,
    /// Where the present chord began, with the heading as written.
    chord: Option<(Vec2, f64)>,
    /// The course of the chord before, without jumps.
    last_course: f64,
    /// The odometry's heading and the absolute one, both without jumps by whole turns, and both of the row before.
    heading: Slope,
    turned: [f64; 2],
    before: Option<[f64; 2]>,
}

impl Degrees {
    /// Looks at the next row: its pose with the heading as written, and its absolute heading.
    pub(super) fn look(&mut self, pose: Pose2, theta: f64, heading: Option<f64>) {
        self.look_at_course(pose.position(), theta);
        let Some(heading) = heading else { return };
        if let Some(before) = self.before {
            self.turned[0] += wrap_angle(theta - before[0]);
            self.turned[1] += wrap_angle(heading - before[1]);
        }
        self.before = Some([theta, heading]);
        self.heading.add(self.turned);
    }

    fn look_at_course(&mut self, place: Vec2, theta: f64) {
        let Some((from, began)) = self.chord else {
            self.chord = Some((place, theta));
            return;
        };
        let way = place - from;
        if way.norm() < CHORD {
            return;
        }
        // The nearest to that of the chord before; a robot that drives backwards has the same course.
        self.last_course += wrap_angle(2.0 * (way.y.atan2(way.x) - self.last_course)) / 2.0;
        self.course.add([(began + theta) / 2.0, self.last_course]);
        self.chord = Some((place, theta));
    }

    /// What seems to be in degrees, and why.
    pub(super) fn warnings(&self) -> impl Iterator<Item = &'static str> {
        let told = [
            (
                self.course.first_is_in_degrees(),
                "theta turns 57 times as much as the robot's way does; is it in degrees?",
            ),
            (
                self.heading.first_is_in_degrees(),
                "theta turns 57 times as much as the column heading does; is theta in degrees?",
            ),
            (
                self.heading.swapped().first_is_in_degrees(),
                "heading turns 57 times as much as theta does; is it in degrees?",
            ),
        ];
        told.into_iter().filter_map(|(holds, words)| holds.then_some(words))
    }
}

#[cfg(test)]
mod tests {
    use super::Degrees;
    use crate::plane::{Pose2, wrap_angle};

    /// What is told of a robot whose course, heading and absolute heading (rad) are these at each millimetre of its way, with the factors by
    /// which the two headings are written too large.
    fn told(
        course: impl Fn(f64) -> f64,
        heading: impl Fn(f64) -> f64,
        [theta, absolute]: [f64; 2],
    ) -> Vec<&'static str> {
        let (mut degrees, mut place) = (Degrees::default(), Pose2::new(0.2, 0.1, 0.0));
        for row in 0..400 {
            let way = 1e-3 * f64::from(row);
            // Odometry errs by a tenth of a millimetre.
            let error = 1e-4 * (f64::from(row * 7919 % 13) / 6.5 - 1.0);
            let written = theta * heading(way);
            let pose = Pose2::new(place.x, place.y + error, wrap_angle(written));
            degrees.look(pose, written, Some(wrap_angle(absolute * heading(way) + 0.3)));
            place = Pose2::new(place.x + 1e-3 * course(way).cos(), place.y + 1e-3 * course(way).sin(), 0.0);
        }
        degrees.warnings().collect()
    }

    const DEGREES: f64 = 180.0 / core::f64::consts::PI;

    #[test]
    fn headings_in_degrees_are_told_of_robots_that_turn_with_their_way() {
        let arc = |way: f64| 0.25 * way - 0.02;
        assert_eq!(
            told(arc, arc, [DEGREES; 2]),
            ["theta turns 57 times as much as the robot's way does; is it in degrees?"]
        );
        let two = told(arc, arc, [DEGREES, 1.0]);
        assert!(two.len() == 2 && two[1].contains("column heading"), "{two:?}");
        assert_eq!(told(arc, arc, [1.0, DEGREES]), ["heading turns 57 times as much as theta does; is it in degrees?"]);
        // Drives backwards half of the way, and sideways all of it.
        let crab = |way: f64| arc(way) + 1.3 + if way > 0.2 { core::f64::consts::PI } else { 0.0 };
        assert_eq!(told(crab, arc, [DEGREES; 2]).len(), 1);
    }

    #[test]
    fn nothing_is_told_of_radians() {
        let none: [&str; 0] = [];
        for turn in [0.0, 0.25, 1.0, 6.0, -15.0] {
            let arc = |way: f64| turn * way;
            assert_eq!(told(arc, arc, [1.0; 2]), none, "{turn}");
            // A stage that turns the robot while it goes straight or to and fro, and one that does not turn it.
            assert_eq!(told(|_| 0.4, arc, [1.0; 2]), none, "{turn}");
            assert_eq!(told(|way| 0.1 * (40.0 * way).sin(), arc, [1.0; 2]), none, "{turn}");
            assert_eq!(told(arc, |_| 1.0, [1.0; 2]), none, "{turn}");
        }
    }
}
