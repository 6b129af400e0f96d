//! What a simulated contact is.

use crate::plane::Vec2;

/// Which part of a whisker touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Its end: without friction the force is normal to the boundary.
    Tip,
    /// A place before its end: without friction the force is normal to the whisker.
    Side,
}

impl Part {
    /// The word that names it in files.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Tip => "tip",
            Self::Side => "side",
        }
    }
}

/// How a contact holds along the boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grip {
    /// It has no friction.
    Frictionless,
    /// It sticks: the force is within the friction cone.
    Sticks,
    /// It slides: the force is on the edge of the friction cone, against the motion.
    Slips,
}

impl Grip {
    /// The word that names it in files.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Frictionless => "frictionless",
            Self::Sticks => "sticks",
            Self::Slips => "slips",
        }
    }
}

/// One contact of a whisker at one row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// When (s).
    pub t: f64,
    /// Index of the row.
    pub row: usize,
    /// Index of the whisker.
    pub whisker: usize,
    /// The contact, map frame (m).
    pub position: Vec2,
    /// The force on the whisker, map frame (N).
    pub force: Vec2,
    /// The elastic energy of the whole whisker (J).
    pub energy: f64,
    /// Arc length from the base to the contact (m).
    pub s_a: f64,
    /// Which part of the whisker touches.
    pub part: Part,
    /// The direction of a frictionless force, map frame, of length 1: the boundary's normal at the tip, the whisker's
    /// normal at a side.
    pub normal: Vec2,
    /// The direction of the whisker at the contact, from base to tip, map frame (rad).
    pub tangent: f64,
    /// How it holds along the boundary.
    pub grip: Grip,
}
