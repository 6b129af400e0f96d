//! What the other virtual sensors read: contact force, slope at the contact, the touched cells of a contact strip
//! \[routray, section "Virtual Sensor Models"\].

use super::super::{Sweep, Touch};
use super::{Columns, Stream, signed, stream};
use crate::plane::wrap_angle;
use crate::world::{MountedWhisker, ReadingNoise, Robot};
use chacha20::ChaCha8Rng;

/// The sensors of one whisker along a sweep.
pub(super) struct Senses<'a> {
    sweep: &'a Sweep,
    whisker: &'a MountedWhisker,
    index: usize,
    /// Length of a strip's cell (m).
    cell: f64,
    /// The touch that comes next.
    next: usize,
    dice: ChaCha8Rng,
}

impl<'a> Senses<'a> {
    /// Those of all whiskers, before the first row.
    pub(super) fn of(robot: &'a Robot, sweep: &'a Sweep, cell: f64, seed: u64) -> Vec<Self> {
        let whiskers = robot.whiskers.iter().enumerate();
        whiskers
            .map(|(index, whisker)| {
                let dice = stream(seed, Stream::Senses, index);
                Self { sweep, whisker, index, cell, next: 0, dice }
            })
            .collect()
    }

    /// The readings of one column at a row; rows come in order.
    pub(super) fn read(&mut self, column: Columns, row: usize) -> Vec<f64> {
        let contacts = &self.sweep.contacts;
        self.next += contacts[self.next..].iter().take_while(|touch| touch.row < row).count();
        let now = contacts[self.next..].iter().take_while(|touch| touch.row == row);
        let touches: Vec<&Touch> = now.filter(|touch| touch.whisker == self.index).collect();
        match column {
            Columns::Force => {
                let force = touches.iter().fold(crate::plane::Vec2::new(0.0, 0.0), |sum, touch| sum + touch.force);
                let size = force.norm().copysign(self.sweep.exact_moments[row][self.index]);
                vec![within(size, self.whisker.force_noise, &mut self.dice)]
            }
            Columns::Slope => {
                let base = self.sweep.truth[row].map_from_robot.compose(self.whisker.robot_from_whisker);
                let slope = touches.last().map_or(0.0, |touch| wrap_angle(touch.tangent - base.theta));
                vec![within(slope, self.whisker.slope_noise, &mut self.dice)]
            }
            Columns::Strip => match (touches.first(), touches.last()) {
                (Some(first), Some(last)) => {
                    vec![
                        (first.s_a / self.cell).floor() * self.cell,
                        (last.s_a / self.cell).floor() * self.cell + self.cell,
                    ]
                }
                _ => vec![0.0, 0.0],
            },
            Columns::Moment | Columns::Flux | Columns::Counts => Vec::new(),
        }
    }
}

/// A reading `z` anywhere where `|h - z| <= relative |z| + absolute`.
fn within(h: f64, noise: ReadingNoise, dice: &mut ChaCha8Rng) -> f64 {
    let share = signed(dice);
    (h + share * noise.absolute) / (1.0 - share * noise.relative * h.signum())
}
