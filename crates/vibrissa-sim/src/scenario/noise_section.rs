//! The errors of readings and odometry.

use crate::Result;
use crate::io::Dimension;
use crate::io::text::did_you_mean;
use crate::io::toml_section::{Allowed, FINITE, FRACTION, NOT_NEGATIVE, POSITIVE, Section};
use crate::simulate::SweepNoise;
use crate::simulate::recorder::{Disturbances, NoiseLaw, OdometryErrors, Recorder, Slip, Stamps};
use crate::world::MomentNoise;

const KEYS: [&str; 18] = [
    "law",
    "time_constant",
    "periods",
    "bits",
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
    Ok(Recorder { noise, law: law(section)?, disturbances, odometry, stamps, ..Recorder::default() })
}

/// Bits of a reading.
const BITS: Allowed = Allowed {
    holds: |v| (2.0..=24.0).contains(&v) && v.fract().abs() <= 0.0,
    text: "a whole number, 2 to 24",
    remedy: "8 bits make 256 steps of twice the largest moment",
};

/// The law of the bounded noise.
fn law(section: &Section<'_>) -> Result<NoiseLaw> {
    let word = section.text("law")?.unwrap_or(NoiseLaw::WORDS[0]);
    let Some(mut law) = NoiseLaw::from_word(word) else {
        return Err(section
            .source
            .fault(&section.span_of("law"), format!("{}: unknown law", section.key("law")))
            .value(format!("\"{word}\""))
            .allowed(NoiseLaw::WORDS.join(", "))
            .remedy(did_you_mean(word, &NoiseLaw::WORDS)));
    };
    let number = |key, dimension, allowed: &Allowed| section.number(key, dimension, allowed);
    let (time, periods) =
        (number("time_constant", Dimension::Time, &POSITIVE)?, number("periods", Dimension::Ratio, &POSITIVE)?);
    let bits = number("bits", Dimension::Ratio, &BITS)?;
    match &mut law {
        NoiseLaw::Autoregressive { time_constant } => *time_constant = time.unwrap_or(*time_constant),
        NoiseLaw::Sine { periods: count } => *count = periods.unwrap_or(*count),
        NoiseLaw::Quantised { bits: count } => *count = bits.map_or(*count, |bits| bits as u32),
        _ => {}
    }
    for (key, of) in [("time_constant", "ar1"), ("periods", "sine"), ("bits", "quantised")] {
        if section.get(key).is_some() && word != of {
            return Err(section
                .source
                .fault(&section.span_of(key), format!("{} belongs to another law", section.key(key)))
                .value(format!("law = \"{word}\""))
                .remedy(format!("remove it, or write law = \"{of}\"")));
        }
    }
    Ok(law)
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
