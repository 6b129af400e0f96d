//! The virtual sensor family: what each reads from a contact.

use super::Contact;
use crate::sets::Interval;
use crate::{Error, Result};

/// Which model a moment is read by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MomentRegime {
    /// Small-angle when no contact with this moment moves the tip by a tenth of the length, large-angle otherwise, and
    /// always for whiskers that are curved at rest \[routray, section "Brief Review of Beam Theory"\].
    #[default]
    Auto,
    /// `M0 = F s_a` \[routray, eq. "momentSmallAngle"\].
    SmallAngle,
    /// The elastica \[routray, eq. "momentLargeAngle"\].
    LargeAngle,
}

/// A virtual whisker sensor: a function `h` of the contact \[routray, models 1 to 4\].
///
/// As in the paper, `h(q, alpha)` depends on the robot's state `q` only through the shape `alpha`, so that the forward map takes
/// the contact alone.
///
/// | sensor | reads | model |
/// | --- | --- | --- |
/// | `Load` | the force `F` (N) | "load-sensor" |
/// | `Strip` | the arc length `s_a` of the contact (m) | "contact-detectorStrip" |
/// | `Slope` | the slope `phi_a` at the contact (rad) | "`end_slope`" |
/// | `Moment` | the moment about the base `M(0)` (N m) | "moment-sensor" |
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VirtualSensor {
    /// The force at the contact.
    Load,
    /// Where along the whisker the contact is.
    Strip,
    /// The slope at the contact, which the whisker keeps from there to the tip.
    Slope,
    /// The bending moment at the base.
    Moment(MomentRegime),
}

impl VirtualSensor {
    /// The words that name the sensors.
    pub const WORDS: [&'static str; 4] = ["load", "strip", "slope", "moment"];

    /// The sensor of a word; moments by the regime that suits them.
    ///
    /// # Errors
    /// Usage: another word.
    pub fn from_word(word: &str) -> Result<Self> {
        match word {
            "load" => Ok(Self::Load),
            "strip" => Ok(Self::Strip),
            "slope" => Ok(Self::Slope),
            "moment" => Ok(Self::Moment(MomentRegime::Auto)),
            _ => Err(Error::usage("the sensor").value(word).allowed(Self::WORDS.join(", "))),
        }
    }

    /// The word that names the sensor.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Load => "load",
            Self::Strip => "strip",
            Self::Slope => "slope",
            Self::Moment(_) => "moment",
        }
    }

    /// The unit of what the sensor reads.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Load => "N",
            Self::Strip => "m",
            Self::Slope => "rad",
            Self::Moment(_) => "N m",
        }
    }

    /// The forward map `h`: what the sensor reads from a contact (SI).
    #[must_use]
    pub fn read(self, contact: &Contact) -> f64 {
        match self {
            Self::Load => contact.force,
            Self::Strip => contact.s_a,
            Self::Slope => contact.phi_a,
            Self::Moment(_) => contact.moment,
        }
    }
}

/// A reading with a bound: the true value lies in the interval (SI).
///
/// A noise bound `eps` makes `[z - eps, z + eps]`, a cell of a contact strip is one as it stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Which sensor read.
    pub sensor: VirtualSensor,
    /// The values that the true one may have.
    pub value: Interval,
}

impl Reading {
    /// An exact reading.
    #[must_use]
    pub fn exact(sensor: VirtualSensor, value: f64) -> Self {
        Self { sensor, value: Interval::point(value) }
    }

    /// Checks that the reading is a finite number or interval.
    ///
    /// # Errors
    /// Usage: a value that is not a number, not finite, or an interval that is turned round.
    pub fn check(&self) -> Result<()> {
        if self.value.lo().is_finite() && self.value.hi().is_finite() {
            return Ok(());
        }
        let unit = self.sensor.unit();
        Err(Error::usage(format!("the {} reading", self.sensor.word()))
            .value(format!("{}..{}", self.value.lo(), self.value.hi()))
            .allowed(format!("a finite number of {unit}, or an interval lo..hi with lo not above hi")))
    }
}
