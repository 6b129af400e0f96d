//! Bounds on what a lab cannot know exactly of a whisker.

use crate::Result;
use crate::toml_section::{Allowed, FRACTION, NOT_NEGATIVE, Section};
use crate::units::Dimension;
use crate::world::WhiskerErrors;
use core::f64::consts::PI;

/// Times between readings and odometry (s).
pub(super) const DELAY: Allowed = Allowed {
    holds: |v| (0.0..=10.0).contains(&v),
    text: "0 to 10 s",
    remedy: "a bare number is in seconds; write \"20 ms\" for milliseconds",
};
const PLACE: Allowed = Allowed {
    holds: |v| (0.0..=0.1).contains(&v),
    text: "0 to 0.1 m",
    remedy: "a bare number is in metres; write \"0.5 mm\" for millimetres",
};
const TURN: Allowed = Allowed {
    holds: |v| (0.0..=PI).contains(&v),
    text: "0 to pi rad",
    remedy: "a bare number is in radians; write \"1 deg\" for degrees",
};

/// The errors of a `[[whisker]]` of this length (m).
pub(super) fn whisker_errors(section: &Section<'_>, length: f64) -> Result<WhiskerErrors> {
    let default = WhiskerErrors::default();
    let number = |key, dimension, allowed: &Allowed| section.number(key, dimension, allowed);
    let length_error = number("length_error", Dimension::Length, &NOT_NEGATIVE)?;
    if let Some(error) = length_error.filter(|error| *error >= length) {
        return Err(section
            .source
            .fault(&section.span_of("length_error"), format!("{} is out of range", section.key("length_error")))
            .value(format!("{error} m"))
            .allowed(format!("0 or more, below the length of {length} m"))
            .remedy("a bare number is in metres; write \"0.5 mm\" for millimetres"));
    }
    Ok(WhiskerErrors {
        zero: number("zero_error", Dimension::Moment, &NOT_NEGATIVE)?.unwrap_or(default.zero),
        zero_drift: number("zero_drift_error", Dimension::MomentRate, &NOT_NEGATIVE)?.unwrap_or(default.zero_drift),
        mount: mount(section)?.unwrap_or(default.mount),
        // The default is for whiskers as long as the paper's.
        length: length_error.unwrap_or(default.length.min(0.5 * length)),
        rigidity: number("stiffness_error", Dimension::Ratio, &FRACTION)?.unwrap_or(default.rigidity),
        gain: number("gain_error", Dimension::Ratio, &FRACTION)?.unwrap_or(default.gain),
    })
}

fn mount(section: &Section<'_>) -> Result<Option<[f64; 3]>> {
    let Some(value) = section.get("mount_error") else { return Ok(None) };
    let key = section.key("mount_error");
    let parts: &[_] = value.get_ref().as_array().map_or(&[], |a| a);
    let [x, y, theta] = parts else {
        return Err(section
            .source
            .fault(&value.span(), format!("{key} must be three values: x, y, theta"))
            .allowed("[5e-4, 5e-4, 0.0175] or [\"0.5 mm\", \"0.5 mm\", \"1 deg\"]"));
    };
    let length = |v, part| section.quantity(&format!("{key} {part}"), v, Dimension::Length, &PLACE);
    let turn = section.quantity(&format!("{key} theta"), theta, Dimension::Angle, &TURN)?;
    Ok(Some([length(x, "x")?, length(y, "y")?, turn]))
}
