//! What the controller that follows walls by touch is set to.
//!
//! Moments are told over `EI / L` of their whisker, which makes them those of one shape of the bent beam, whatever its length.

/// The moment that is kept, from and to: bent enough to feel bumps of a tenth of the whisker's length, and by half of what is gentle.
pub const BAND: [f64; 2] = [0.3, 0.9];
/// Largest moment unless said otherwise: it bends the whisker by a right angle or so.
pub const GENTLE: f64 = 2.0;
/// The robot goes back where a whisker reads this share of the largest moment: until the next reading it goes on to press.
pub const RETREAT_AT: f64 = 0.75;
/// A robot that goes back stands where a whisker reads so many times that: it is held.
pub const HELD: f64 = 1.2;
/// A whisker touches from this moment on: several times what noise and a shifted zero amount to.
pub const TOUCH: f64 = 0.15;
/// Way between two readings (m), which bounds the speed of slow sensors: a caught whisker bends by a third of `EI / L` on it.
pub const STRIDE: f64 = 2.5e-3;
/// Steering by the tip's lead, which damps it \[lamperski2005dynamical\]: curvature is this times the distance's error over the lead's square, and
/// 4 is critically damped. At 2.5 the moment is within its band in 57 % of the rows of 36 random rooms, at 4 in 82 %.
pub const STEERING: f64 = 4.0;
/// How fast a robot that goes sideways takes back an error of the distance (1/s).
pub const SIDEWAYS: f64 = 3.0;
/// Speed of a robot whose whisker is bent nearly as far as it may be (share of its speed).
pub const SLOWEST: f64 = 0.15;
/// Way without touch (m) after which the wall has ended: tips leap over bumps.
pub const LOST: f64 = 4e-3;
/// What is kept between footprint and a corner that the robot goes around (m).
pub const CLEARANCE: f64 = 8e-3;
/// How much further than it needs to turn freely the robot goes back from a wall ahead (m).
pub const ROOM: f64 = 8e-3;
/// How much further than the whisker's own direction the robot turns away from a wall ahead (rad): it has to meet the wall leaning back.
pub const LEAN: f64 = 0.4;
/// Turn where the wall is on the other side, or there is no room to turn off it (rad): it comes to be on the right side.
pub const ABOUT: f64 = 2.6;
/// Turn where a whisker is only bent too far (rad).
pub const RELIEF: f64 = 0.5;
/// The way back that is remembered (m), and its pieces (m, rad).
pub const TRAIL: f64 = 0.4;
/// As above.
pub const PIECE: [f64; 2] = [2e-3, 0.05];
/// So many walls ahead with less than so much way (m) between them are a dead end.
pub const ATTEMPTS: usize = 10;
/// As above.
pub const AGAIN: f64 = 0.1;
/// A turn around a corner by so much finds nothing any more (rad).
pub const LOST_TURN: f64 = 7.0;
/// How far (reaches of its whiskers) the robot goes straight on after a turn off a wall ahead: it comes to it at a small angle.
pub const AFTER_TURN: f64 = 1.5;
/// How much wider than around a corner it turns to it then.
pub const WIDER: f64 = 4.0;
