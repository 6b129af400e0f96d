//! How the contact force is directed.

use crate::error::{Error, Result};
use crate::plane::wrap_angle;
use core::f64::consts::FRAC_PI_2;

/// The direction in which a positive force pushes; a negative force acts the opposite way along the same line.
///
/// | load | direction of a positive force, whisker frame | physics |
/// | --- | --- | --- |
/// | `Normal` | `phi_a + pi/2` | frictionless contact at the side of the whisker |
/// | `Vertical` | `pi/2` | a weight; the paper's shape equations \[belendez2002large\] |
/// | `Tilted(beta)` | `phi_a + pi/2 + beta` | friction: `beta` is the rotation from the whisker's normal (rad) |
/// | `Directed(psi)` | `psi` | contact of the tip with a smooth wall of that normal (rad) |
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Load {
    /// Along the whisker's normal at the contact.
    Normal,
    /// Across the undeflected whisker.
    Vertical,
    /// Turned from the whisker's normal at the contact by this angle (rad, counter-clockwise).
    Tilted(f64),
    /// In this direction of the whisker frame (rad).
    Directed(f64),
}

/// The two kinds of load that need different mathematics.
#[derive(Clone, Copy, Debug)]
pub(super) enum Line {
    /// Turns with the whisker: the tilt from its normal (rad).
    Following(f64),
    /// Stays: the direction in the whisker frame (rad).
    Fixed(f64),
}

impl Load {
    pub(super) fn line(self) -> Result<Line> {
        let line = match self {
            Self::Normal => Line::Following(0.0),
            Self::Vertical => Line::Fixed(FRAC_PI_2),
            Self::Tilted(beta) => Line::Following(beta),
            Self::Directed(psi) => Line::Fixed(psi),
        };
        match line {
            Line::Following(angle) | Line::Fixed(angle) if !angle.is_finite() => {
                Err(Error::usage("the load's angle").value(angle).allowed("a finite number of radians"))
            }
            _ => Ok(line),
        }
    }
}

impl Line {
    /// The tilt from the whisker's normal where the slope is `phi_a`.
    pub(super) fn beta(self, phi_a: f64) -> f64 {
        match self {
            Self::Following(beta) => beta,
            Self::Fixed(psi) => wrap_angle(wrap_angle(psi) - FRAC_PI_2 - phi_a),
        }
    }
}
