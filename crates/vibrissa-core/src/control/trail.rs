//! The last of the way, to go back on it: there the robot was already.

use crate::config::wall_following::{PIECE, TRAIL};
use crate::math;
use crate::plane::Twist2;
use std::collections::VecDeque;

/// A piece of the way: what was moved, and how long it took (s).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Piece {
    moved: Twist2,
    time: f64,
}

/// The last of the way, the newest piece at the back.
#[derive(Clone, Debug, Default)]
pub(super) struct Trail {
    pieces: VecDeque<Piece>,
    way: f64,
}

impl Trail {
    /// The robot moved with a twist (per second) for some time.
    pub(super) fn add(&mut self, twist: Twist2, time: f64) {
        let moved = scaled(twist, time);
        self.way += length(moved);
        match self.pieces.back_mut() {
            Some(last)
                if length(last.moved) < PIECE[0]
                    && last.moved.theta.abs() < PIECE[1]
                    && is_turn(last.moved) == is_turn(moved) =>
            {
                last.moved = Twist2 {
                    x: last.moved.x + moved.x,
                    y: last.moved.y + moved.y,
                    theta: last.moved.theta + moved.theta,
                };
                last.time += time;
            }
            _ if time > 0.0 => self.pieces.push_back(Piece { moved, time }),
            _ => {}
        }
        while self.way > TRAIL || self.pieces.len() > MOST {
            let Some(first) = self.pieces.pop_front() else { break };
            self.way -= length(first.moved);
        }
    }

    /// The robot went back on it for some time: what is left is what is still behind it.
    pub(super) fn take(&mut self, mut time: f64) {
        while time > 0.0 {
            let Some(last) = self.pieces.back_mut() else { break };
            if last.time > time {
                let left = 1.0 - time / last.time;
                self.way -= (1.0 - left) * length(last.moved);
                *last = Piece { moved: scaled(last.moved, left), time: last.time - time };
                break;
            }
            time -= last.time;
            self.way -= length(last.moved);
            self.pieces.pop_back();
        }
    }

    /// The twist (per second) by which the robot goes back now, as fast as it came, and whether that is a turn on the spot; none where
    /// nothing is remembered.
    pub(super) fn back(&self) -> Option<(Twist2, bool)> {
        let last = self.pieces.back()?;
        Some((scaled(last.moved, -1.0 / last.time), is_turn(last.moved)))
    }
}

fn is_turn(moved: Twist2) -> bool {
    length(moved) < 1e-9
}

/// Most pieces: turns on the spot have no length.
const MOST: usize = 1024;

/// How far a twist goes (m).
pub(super) fn length(twist: Twist2) -> f64 {
    math::hypot(twist.x, twist.y)
}

/// A twist so many times.
fn scaled(twist: Twist2, by: f64) -> Twist2 {
    Twist2 { x: by * twist.x, y: by * twist.y, theta: by * twist.theta }
}
