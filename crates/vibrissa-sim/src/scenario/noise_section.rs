//! The errors of readings and odometry.

use crate::Result;
use crate::io::Dimension;
use crate::io::toml_section::{Allowed, FINITE, FRACTION, NOT_NEGATIVE, Section};
use crate::simulate::SweepNoise;
use crate::simulate::recorder::{Disturbances, OdometryErrors, Recorder, Slip, Stamps};
use crate::world::MomentNoise;

const KEYS: [&str; 14] = [
    "moment_relative",
    "moment_absolute",
    "hysteresis",
    "gain_error",
    "offset",
    "drift",
    "gaussian_relative",
    "gaussian_absolute",
    "outlier_share",
    "outlier_size",
    "dropped_share",
    "late_share",
    "late_by",
    "odometry",
];
const SLIP: Allowed =
    Allowed { holds: |v| v > -1.0 && v.is_finite(), text: "above -1", remedy: "1 counts every way twice" };

/// The recorder with the errors of a `[noise]` section.
pub(super) fn recorder(section: &Section<'_>) -> Result<Recorder> {
    section.only(&KEYS)?;
    let number = |key, dimension, allowed: &Allowed| section.number(key, dimension, allowed);
    let fraction = |key| Ok::<_, crate::Error>(number(key, Dimension::Ratio, &FRACTION)?.unwrap_or(0.0));
    let moment = |key| Ok::<_, crate::Error>(number(key, Dimension::Moment, &NOT_NEGATIVE)?.unwrap_or(0.0));
    let relative = number("moment_relative", Dimension::Ratio, &FRACTION)?;
    let absolute = number("moment_absolute", Dimension::Moment, &NOT_NEGATIVE)?;
    // One of the two alone leaves the other off: who writes 1 % means 1 %, not 1 % and a default.
    let bounded = (relative.is_some() || absolute.is_some())
        .then(|| MomentNoise { moment_relative: relative.unwrap_or(0.0), moment_absolute: absolute.unwrap_or(0.0) });
    let disturbances = Disturbances {
        hysteresis: moment("hysteresis")?,
        gain_error: fraction("gain_error")?,
        offset: moment("offset")?,
        drift: number("drift", Dimension::MomentRate, &NOT_NEGATIVE)?.unwrap_or(0.0),
        gaussian_relative: number("gaussian_relative", Dimension::Ratio, &NOT_NEGATIVE)?.unwrap_or(0.0),
        gaussian_absolute: moment("gaussian_absolute")?,
        outlier_share: fraction("outlier_share")?,
        outlier_size: moment("outlier_size")?,
    };
    let stamps = Stamps {
        dropped_share: fraction("dropped_share")?,
        late_share: fraction("late_share")?,
        late_by: number("late_by", Dimension::Time, &NOT_NEGATIVE)?.unwrap_or(0.0),
    };
    let mut noise = SweepNoise { moment: bounded, ..SweepNoise::default() };
    let odometry = match section.section("odometry")? {
        Some(section) => odometry(&section, &mut noise)?,
        None => OdometryErrors::default(),
    };
    Ok(Recorder { noise, disturbances, odometry, stamps, ..Recorder::default() })
}

fn odometry(section: &Section<'_>, noise: &mut SweepNoise) -> Result<OdometryErrors> {
    section.only(&["translation_relative", "rotation_relative", "scale_error", "heading_drift", "slip"])?;
    let fraction = |key| Ok::<_, crate::Error>(section.number(key, Dimension::Ratio, &FRACTION)?.unwrap_or(0.0));
    noise.translation_relative = fraction("translation_relative")?;
    noise.rotation_relative = fraction("rotation_relative")?;
    Ok(OdometryErrors {
        scale_error: fraction("scale_error")?,
        heading_drift: section.number("heading_drift", Dimension::TurnPerLength, &NOT_NEGATIVE)?.unwrap_or(0.0),
        slips: section.entries("slip")?.iter().map(slip).collect::<Result<_>>()?,
    })
}

fn slip(section: &Section<'_>) -> Result<Slip> {
    section.only(&["t", "duration", "share"])?;
    Ok(Slip {
        t: section.number("t", Dimension::Time, &FINITE)?.unwrap_or(0.0),
        duration: section.number("duration", Dimension::Time, &NOT_NEGATIVE)?.unwrap_or(f64::MAX),
        share: section.number("share", Dimension::Ratio, &SLIP)?.unwrap_or(0.0),
    })
}
