//! What the user gives: numbers, loads and the three ways to pose the problem.

pub(super) use crate::quantity::{option, quantity};
use vibrissa::beam::{Bend, Load, Whisker, force_mode, moment_mode, point_mode, tip_mode};
use vibrissa::io::Dimension;
use vibrissa::plane::Vec2;
use vibrissa::{Error, Result};

/// The value of `--load`.
pub(super) fn parse_load(text: &str) -> Result<Load> {
    match text.split_once(':') {
        None if text == "normal" => Ok(Load::Normal),
        None if text == "vertical" => Ok(Load::Vertical),
        Some(("tilted", angle)) => Ok(Load::Tilted(quantity(angle, Dimension::Angle)?)),
        Some(("directed", angle)) => Ok(Load::Directed(quantity(angle, Dimension::Angle)?)),
        _ => Err(Error::usage("the load").value(text).allowed("normal, vertical, tilted:RAD, directed:RAD")),
    }
}

/// Which quantities are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Given {
    Force,
    Point,
    Tip,
    Moment,
}

/// The known quantities of one whisker (SI), as far as they are given.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known {
    pub(super) load: Load,
    pub(super) force: Option<f64>,
    pub(super) s_a: Option<f64>,
    pub(super) x: Option<f64>,
    pub(super) y: Option<f64>,
    pub(super) moment: Option<f64>,
}

impl Default for Known {
    fn default() -> Self {
        Self { load: Load::Normal, force: None, s_a: None, x: None, y: None, moment: None }
    }
}

impl Known {
    /// The equilibria, least slope first.
    pub(super) fn solve(&self, given: Given, whisker: &Whisker) -> Result<Vec<Bend>> {
        let need = |value: Option<f64>, name: &str| {
            value.ok_or_else(|| Error::usage(format!("{name} is missing")).remedy("add the column or the option"))
        };
        match given {
            Given::Force => force_mode(whisker, need(self.force, "F")?, need(self.s_a, "s_a")?, self.load),
            Given::Point => point_mode(whisker, Vec2::new(need(self.x, "x")?, need(self.y, "y")?), self.load),
            Given::Tip => tip_mode(whisker, Vec2::new(need(self.x, "x")?, need(self.y, "y")?)),
            Given::Moment => moment_mode(whisker, need(self.moment, "M0")?, need(self.s_a, "s_a")?, self.load),
        }
    }
}

impl Given {
    /// Why there may be no equilibrium.
    pub(super) fn why_none(self) -> &'static str {
        match self {
            Self::Force => "the force is too large for a shape without an inflection between base and contact",
            Self::Point => "the whisker is too short for this point, or no shape reaches this side",
            Self::Tip => {
                "the whisker is too short for its tip to be there, or no shape without an inflection reaches it"
            }
            Self::Moment => {
                "the moment is larger than any shape with this arc length can have (2.944 EI/s_a, normal load)"
            }
        }
    }
}
