//! A motion as seen from the robot that begins it.

use crate::plane::{Pose2, Twist2, Vec2, wrap_angle};

/// Travel (m) and turn (rad) between two poses at which readings are predicted.
pub(super) const STEP: f64 = 8e-3;
const STEP_TURN: f64 = 0.08;
/// Turn between two waypoints of an arc (rad).
const ARC_TURN: f64 = 0.1;

/// A motion: poses seen from where it begins.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    name: &'static str,
    waypoints: Vec<Pose2>,
}

impl Motion {
    /// Through these poses, seen from the robot where it begins.
    #[must_use]
    pub fn new(name: &'static str, waypoints: &[Pose2]) -> Self {
        Self { name, waypoints: core::iter::once(Pose2::IDENTITY).chain(waypoints.iter().copied()).collect() }
    }

    /// A straight leg without turning.
    pub(super) fn leg(name: &'static str, leg: Vec2) -> Self {
        Self::new(name, &[Pose2::new(leg.x, leg.y, 0.0)])
    }

    /// Ahead along an arc of this curvature (1/m), after a turn on the spot.
    pub(super) fn arc(name: &'static str, turn: f64, length: f64, curvature: f64) -> Self {
        let parts = (length * curvature / ARC_TURN).abs().ceil().max(1.0);
        let turned = Pose2::new(0.0, 0.0, turn);
        let at = |k: usize| {
            let s = length * k as f64 / parts;
            turned.compose(Pose2::exp(Twist2 { x: s, y: 0.0, theta: s * curvature }))
        };
        let mut waypoints = Self::turned(name, turn).waypoints;
        waypoints.extend((1..=parts as usize).map(at));
        Self { name, waypoints }
    }

    /// A turn on the spot.
    pub(super) fn turned(name: &'static str, by: f64) -> Self {
        // No leg turns half a turn or more: which way would be open.
        let parts = by.abs().ceil().max(1.0);
        let poses: Vec<Pose2> = (1..=parts as usize).map(|k| Pose2::new(0.0, 0.0, by * k as f64 / parts)).collect();
        Self::new(name, if by.abs() > 0.0 { &poses } else { &[] })
    }

    /// What kind of motion it is, in a few words.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// The waypoints with headings, seen from the robot where it begins: the first is where it is. In between it goes straight
    /// and turns evenly, the shorter way.
    #[must_use]
    pub fn waypoints(&self) -> &[Pose2] {
        &self.waypoints
    }

    /// Where it ends, seen from where it begins.
    #[must_use]
    pub fn end(&self) -> Pose2 {
        self.waypoints.last().copied().unwrap_or_default()
    }

    /// Length of the way (m).
    #[must_use]
    pub fn way(&self) -> f64 {
        self.waypoints.windows(2).fold(0.0, |sum, w| sum + w[0].position().distance(w[1].position()))
    }

    /// How far the robot turns in all (rad).
    #[must_use]
    pub fn turn(&self) -> f64 {
        self.waypoints.windows(2).fold(0.0, |sum, w| sum + wrap_angle(w[1].theta - w[0].theta).abs())
    }

    /// Poses along it, no further apart than 8 mm and 0.08 rad, the first left out.
    pub(super) fn steps(&self) -> Vec<Step> {
        let mut steps = Vec::new();
        let (mut gone, mut turned) = (0.0, 0.0);
        for (leg, w) in self.waypoints.windows(2).enumerate() {
            let (way, turn) = (w[1].position() - w[0].position(), wrap_angle(w[1].theta - w[0].theta));
            let parts = (way.norm() / STEP).max(turn.abs() / STEP_TURN).ceil().clamp(1.0, 1e5);
            steps.extend((1..=parts as usize).map(|k| {
                let share = k as f64 / parts;
                let at = w[0].position() + way * share;
                Step {
                    pose: Pose2::new(at.x, at.y, w[0].theta + share * turn),
                    leg,
                    way: gone + share * way.norm(),
                    turn: turned + share * turn.abs(),
                }
            }));
            (gone, turned) = (gone + way.norm(), turned + turn.abs());
        }
        steps
    }

    /// The first part of the motion, so large a share of its steps.
    #[must_use]
    pub fn share(&self, share: f64) -> Self {
        let steps = self.steps();
        let last = (steps.len() as f64 * share.clamp(0.0, 1.0)).ceil().max(1.0) as usize;
        steps.get(last.min(steps.len()).wrapping_sub(1)).map_or_else(|| self.clone(), |step| self.up_to(step))
    }

    /// The motion up to one of its steps.
    pub(super) fn up_to(&self, step: &Step) -> Self {
        let mut waypoints: Vec<Pose2> = self.waypoints.iter().take(step.leg + 1).copied().collect();
        waypoints.push(step.pose);
        Self { name: self.name, waypoints }
    }
}

/// A pose on a motion, seen from where it begins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub(super) pose: Pose2,
    leg: usize,
    /// Way (m) and turn (rad) up to here.
    pub(super) way: f64,
    pub(super) turn: f64,
}
