//! What looks wrong in a log without being impossible: most often a wrong unit.

use super::degrees::Degrees;
use crate::config::limits::{FASTEST_ROBOT, HEADING_JUMP, LARGEST_MOMENT, LATEST_TIME, POSITION_JUMP, SLOW_SAMPLING};
use crate::flow::sensor_log::{Channel, LogRow, Quantity};
use crate::plane::wrap_angle;
use core::f64::consts::TAU;

/// One kind of doubt: where it first arose, and how often.
#[derive(Clone, Debug, Default)]
struct Doubt {
    first: Option<(usize, f64)>,
    count: usize,
}

impl Doubt {
    fn note(&mut self, line: usize, value: f64) {
        self.first.get_or_insert((line, value));
        self.count += 1;
    }
}

/// Fewer rows than this say nothing of how often one sampled.
const FEWEST: usize = 10;

/// Collects doubts row by row.
#[derive(Clone, Debug, Default)]
pub(super) struct Doubts {
    turn: Doubt,
    heading_turn: Doubt,
    degrees: Degrees,
    large_angle: Doubt,
    jump: Doubt,
    moment: Doubt,
    epoch: Doubt,
    /// How many rows are further apart than one would sample, and how many there are.
    slow: [usize; 2],
    /// How many rows move faster than robots with whiskers do.
    fast: usize,
}

impl Doubts {
    /// Looks at a row, its heading as written (not wrapped), and the row before it.
    pub(super) fn look(
        &mut self,
        line: usize,
        row: &LogRow,
        theta: f64,
        previous: Option<&LogRow>,
        channels: &[Channel],
    ) {
        if theta.abs() > TAU {
            self.large_angle.note(line, theta);
        }
        for (reading, channel) in row.readings.iter().zip(channels) {
            if channel.quantity == Quantity::Moment && reading.abs() > LARGEST_MOMENT {
                self.moment.note(line, *reading);
            }
        }
        if row.t.abs() > LATEST_TIME {
            self.epoch.note(line, row.t);
        }
        self.degrees.look(row.odom_from_robot, theta, row.heading);
        let Some(before) = previous else { return };
        let (time, way) = (row.t - before.t, row.odom_from_robot.position() - before.odom_from_robot.position());
        self.slow[0] += usize::from(time > SLOW_SAMPLING);
        self.slow[1] += 1;
        self.fast += usize::from(way.norm() > FASTEST_ROBOT * time);
        let turn = wrap_angle(row.odom_from_robot.theta - before.odom_from_robot.theta);
        if turn.abs() > HEADING_JUMP {
            self.turn.note(line, turn);
        }
        let distance = row.odom_from_robot.position().distance(before.odom_from_robot.position());
        if distance > POSITION_JUMP {
            self.jump.note(line, distance);
        }
        if let (Some(now), Some(then)) = (row.heading, before.heading) {
            let turn = wrap_angle(now - then);
            if turn.abs() > HEADING_JUMP {
                self.heading_turn.note(line, turn);
            }
        }
    }

    /// The doubts in words.
    pub(super) fn warnings(&self, name: &str) -> Vec<String> {
        let say = |doubt: &Doubt, what: &str, unit: &str, hint: &str| {
            let (line, value) = doubt.first?;
            let more = if doubt.count > 1 { format!(", and {} more like it", doubt.count - 1) } else { String::new() };
            Some(format!("{name}:{line}: {what} {} {unit}{more}; {hint}", (value * 1e6).round() / 1e6))
        };
        let most = |count: usize| self.slow[1] >= FEWEST && 2 * count > self.slow[1];
        let mostly = [
            (most(self.slow[0]), format!("most rows are more than {SLOW_SAMPLING} s apart; is t in milliseconds?")),
            (
                most(self.fast) && self.jump.first.is_none(),
                format!("the robot is faster than {FASTEST_ROBOT} m/s; are x and y in millimetres?"),
            ),
        ];
        let mostly = mostly.into_iter().filter(|(holds, _)| *holds).map(|(_, words)| format!("{name}: {words}"));
        let told = [&self.large_angle, &self.turn, &self.heading_turn].iter().any(|doubt| doubt.first.is_some());
        let slopes = self.degrees.warnings().filter(|_| !told).map(|words| format!("{name}: {words}"));
        let degrees = "are these degrees where radians are due?";
        [
            say(&self.large_angle, "theta is", "rad, more than a full turn", degrees),
            say(&self.turn, "theta jumps by", "rad between two rows", degrees),
            say(&self.heading_turn, "heading jumps by", "rad between two rows", degrees),
            say(&self.jump, "the robot jumps by", "m between two rows", "are these millimetres where metres are due?"),
            say(&self.moment, "the moment is", "N m", "are these mN m where N m are due?"),
            say(&self.epoch, "t is", "s", "is it in milliseconds or nanoseconds?"),
        ]
        .into_iter()
        .flatten()
        .chain(mostly)
        .chain(slopes)
        .collect()
    }
}
