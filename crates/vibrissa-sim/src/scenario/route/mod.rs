//! The robot's way: legs one after another, each from where the one before ended.
//!
//! | file | what it knows |
//! | --- | --- |
//! | `walk` | poses with times: going, turning, waiting |
//! | `curves` | arcs and splines as chains of chords |
//! | `wall` | the line at a standoff from the map's boundary |

mod curves;
mod walk;
mod wall;

pub(super) use walk::Walk;

use crate::plane::{Pose2, Vec2};
use crate::world::Map;
use crate::{Error, Result};

/// One stretch of the way.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Leg {
    pub(super) kind: LegKind,
    /// Speed (m/s), positive.
    pub(super) speed: f64,
    pub(super) heading: Heading,
    /// The line of the file that it stands on, for messages.
    pub(super) line: usize,
}

/// Where a leg goes.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum LegKind {
    /// Straight to each point in turn, where given with the heading there (rad).
    Line(Vec<(Vec2, Option<f64>)>),
    /// Round a centre by an angle, counter-clockwise positive (rad).
    Arc { centre: Vec2, angle: f64 },
    /// Smoothly through points.
    Spline(Vec<Vec2>),
    /// Along the nearest boundary at a standoff (m), for a length of way (m).
    Wall { on_left: bool, standoff: f64, length: f64 },
    /// On the spot by an angle (rad).
    Turn(f64),
    /// Standing still (s).
    Wait(f64),
}

/// Which way the robot points while it goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Heading {
    /// As the points say; evenly between them.
    Interpolate,
    /// Along the way, turned by an angle (rad).
    Along(f64),
    /// At an angle in the map frame (rad).
    Fixed(f64),
    /// As at the start of the leg.
    Keep,
}

impl Leg {
    /// Goes the leg.
    ///
    /// # Errors
    ///
    /// A leg without length, one without boundary, or one that takes too many rows; the caller adds the line.
    pub(super) fn go(&self, map: &Map, walk: &mut Walk) -> Result<()> {
        walk.pace.speed = self.speed;
        let start = walk.pose().theta;
        let heading = |along: f64| match self.heading {
            Heading::Along(offset) => along + offset,
            Heading::Fixed(theta) => theta,
            Heading::Keep | Heading::Interpolate => start,
        };
        match &self.kind {
            LegKind::Line(points) => self.line(points, walk),
            LegKind::Arc { centre, angle } => {
                let radius = walk.pose().position().distance(*centre);
                if radius <= 0.0 {
                    return Err(Error::data("an arc around the robot itself").remedy("move the centre, or use a turn"));
                }
                walk.follow(&curves::arc(walk.pose().position(), *centre, *angle), heading)
            }
            LegKind::Spline(points) => walk.follow(&curves::spline(walk.pose().position(), points)?, heading),
            LegKind::Wall { on_left, standoff, length } => {
                let line = wall::at_standoff(map, walk.pose().position(), *on_left, *standoff, *length)?;
                walk.follow(&line, heading)
            }
            LegKind::Turn(by) => walk.turn_by(*by),
            LegKind::Wait(time) => walk.wait(*time),
        }
    }

    fn line(&self, points: &[(Vec2, Option<f64>)], walk: &mut Walk) -> Result<()> {
        if let Heading::Fixed(theta) = self.heading {
            walk.turn_to(theta)?;
        }
        for &(point, theta) in points {
            let from = walk.pose();
            if let (Heading::Along(offset), true) = (self.heading, from.position().distance(point) > 0.0) {
                walk.turn_to((point - from.position()).angle() + offset)?;
            }
            let theta = match self.heading {
                Heading::Interpolate => theta.unwrap_or(walk.pose().theta),
                _ => walk.pose().theta,
            };
            walk.go(Pose2::new(point.x, point.y, theta))?;
        }
        Ok(())
    }
}
