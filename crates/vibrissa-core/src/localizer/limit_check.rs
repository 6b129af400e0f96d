//! What no whisker can feel is refused with the line that says it.

use crate::beam::TipModel;
use crate::flow::sensor_log::LogRow;
use crate::world::{MomentNoise, MountedWhisker};
use crate::{Error, Result};

/// The largest moment that a whisker can feel at its tip.
pub(super) struct LimitCheck {
    whisker: String,
    noise: MomentNoise,
    limit: f64,
    /// Where the contact is that causes it.
    place: &'static str,
}

impl LimitCheck {
    /// With the contact anywhere from a tenth of the whisker on, which multiplies the moment by ten.
    pub(super) fn any_place(whisker: &MountedWhisker, tip: &TipModel) -> Self {
        let tip = Self::any_tilt(whisker, tip);
        Self { limit: 10.0 * tip.limit, place: "a tenth of the whisker from its base", ..tip }
    }

    /// Whatever the tilt of the load.
    pub(super) fn any_tilt(whisker: &MountedWhisker, tip: &TipModel) -> Self {
        Self::new(whisker, tip, f64::INFINITY)
    }

    pub(super) fn new(whisker: &MountedWhisker, tip: &TipModel, steepest: f64) -> Self {
        let limit = tip.largest_moment(steepest);
        Self { whisker: whisker.name.clone(), noise: whisker.noise, limit, place: "at its tip" }
    }

    /// Whether a contact can cause this moment (N m), at least at the edge of the declared noise.
    pub(super) fn allows(&self, moment: f64) -> bool {
        moment.abs() * (1.0 - self.noise.moment_relative) - self.noise.moment_absolute <= self.limit
    }

    /// Refuses what no shape of this whisker can cause, even at the edge of the declared noise.
    pub(super) fn check(&self, moment: f64, row: &LogRow) -> Result<()> {
        if self.allows(moment) {
            return Ok(());
        }
        let error = Error::data(format!("a moment that no shape of the whisker {} causes", self.whisker))
            .value(format!("{moment} N m"))
            .allowed(format!("at most {:.3e} N m with the contact {}", self.limit, self.place))
            .remedy("check the unit (N m, not mN m), and the whisker's length and stiffness in the robot file");
        Err(if row.line > 0 { error.at_line(row.line) } else { error })
    }
}
