//! What one reading says about where the wall is, whatever its shape.

use super::options::unit;
use super::{FollowOptions, Side};
use crate::config::wall_following::{RETREAT_AT, TOUCH};
use crate::math;
use crate::plane::Vec2;
use crate::world::{MountedWhisker, Robot};

/// Whiskers that point ahead by less than this (cosine) trail or point to the side: a wall pushes them either way.
const LEADS: f64 = 0.2;
/// Whiskers that point to a side by less than this (sine) point ahead.
const ASIDE: f64 = 0.43;

/// What a whisker is there for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    /// On the wall's side, ahead: the wall is followed by it.
    Wall,
    /// On the other side, ahead.
    Other,
    /// Straight ahead.
    Ahead,
    /// What it touches only has to be gentle.
    Trailing,
}

/// A whisker as the controller sees it: the wall is on the robot's right; on the left all is mirrored.
#[derive(Clone, Debug)]
pub(super) struct Feeler {
    role: Role,
    mirror: f64,
    touch: f64,
    low: f64,
    kept: f64,
    retreat_at: f64,
    /// Metres that the wall is nearer for each N m: the small deflection of a cantilever whose tip slides on the wall.
    pub(super) compliance: f64,
    /// The straight whisker's tip, mirrored.
    pub(super) tip: Vec2,
}

/// What all whiskers say.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Felt {
    /// How much too near the wall is (m), if it is touched.
    pub(super) too_near: Option<f64>,
    /// Largest moment over that at which the robot goes back.
    pub(super) hardest: f64,
    /// A whisker on the wall is bent as far as its band wants, or further.
    pub(super) is_firm: bool,
    /// The other side is touched as a wall beside is.
    pub(super) is_other: bool,
    /// Something is ahead, and how far the tip that feels it leads (m).
    pub(super) ahead: Option<f64>,
}

impl Feeler {
    pub(super) fn all(robot: &Robot, options: &FollowOptions) -> Vec<Self> {
        let mirror = if options.side_of(robot) == Side::Right { 1.0 } else { -1.0 };
        robot.whiskers.iter().map(|whisker| Self::new(whisker, mirror, options)).collect()
    }

    fn new(whisker: &MountedWhisker, mirror: f64, options: &FollowOptions) -> Self {
        let mount = whisker.robot_from_whisker;
        let (sin, cos) = (mirror * math::sin(mount.theta), math::cos(mount.theta));
        let length = whisker.beam.length;
        let tip = Vec2::new(mount.x + length * cos, mirror * mount.y + length * sin);
        let role = match (cos, sin) {
            (cos, _) if cos < LEADS => Role::Trailing,
            (_, sin) if sin <= -ASIDE => Role::Wall,
            (_, sin) if sin >= ASIDE => Role::Other,
            _ => Role::Ahead,
        };
        let [low, high] = options.band_of(whisker);
        Self {
            role,
            mirror,
            touch: (TOUCH * unit(whisker)).min(0.5 * low),
            low,
            kept: 0.5 * (low + high),
            retreat_at: RETREAT_AT * options.most_of(whisker),
            compliance: length * cos / (3.0 * unit(whisker)),
            tip,
        }
    }

    pub(super) fn is_on_wall(&self) -> bool {
        self.role == Role::Wall
    }

    /// How far the robot's origin is off the wall that is kept (m).
    pub(super) fn distance(&self) -> f64 {
        -self.tip.y - self.kept * self.compliance
    }

    /// What the wall's side presses with (N m), where a whisker leads and the wall is on its side; what catches the tip is below 0.
    fn press(&self, reading: f64) -> f64 {
        let moment = self.mirror * reading;
        if self.role == Role::Other { -moment } else { moment }
    }

    fn feels_ahead(&self, press: f64) -> bool {
        match self.role {
            Role::Wall | Role::Other => press < -self.touch,
            Role::Ahead => press.abs() > self.touch,
            Role::Trailing => false,
        }
    }
}

/// What all whiskers say together: the nearest wall counts.
pub(super) fn felt(feelers: &[Feeler], readings: &[f64]) -> Felt {
    let mut felt = Felt::default();
    let mut other: f64 = 0.0;
    for (feeler, &reading) in feelers.iter().zip(readings) {
        let press = feeler.press(reading);
        felt.hardest = felt.hardest.max(press.abs() / feeler.retreat_at);
        if feeler.feels_ahead(press) {
            felt.ahead = Some(felt.ahead.map_or(feeler.tip.x, |lead: f64| lead.min(feeler.tip.x)));
        }
        let too_near = (press - feeler.kept) * feeler.compliance;
        match feeler.role {
            Role::Wall if press > feeler.touch => {
                felt.too_near = Some(felt.too_near.map_or(too_near, |most: f64| most.max(too_near)));
                felt.is_firm |= press >= feeler.low;
            }
            Role::Other => {
                other = other.max(too_near);
                felt.is_other |= press > feeler.touch;
            }
            _ => {}
        }
    }
    // Between two walls: in the middle of both.
    felt.too_near = felt.too_near.map(|near| near - other);
    felt
}
