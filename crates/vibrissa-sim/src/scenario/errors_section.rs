//! How robot, map and readings are other than declared.

use super::points::Value;
use crate::Result;
use crate::io::Dimension;
use crate::io::toml_section::{Allowed, FINITE, HEADING, MOUNT, Section};
use crate::simulate::recorder::TrueErrors;
use crate::world::Robot;

const KEYS: [&str; 11] = [
    "zero",
    "zero_drift",
    "mount",
    "length",
    "stiffness",
    "gain",
    "delay",
    "odometry_translation",
    "odometry_rotation",
    "map_scale",
    "heading",
];
const SHARE: Allowed = Allowed {
    holds: |v| v > -0.9 && v <= 9.0,
    text: "above -0.9, up to 9",
    remedy: "the true value over the declared one, less 1: 5 % more is 0.05 or \"5 %\"",
};
const DELAY: Allowed = Allowed {
    holds: |v| v.abs() <= 10.0,
    text: "-10 to 10 s",
    remedy: "a bare number is in seconds; write \"20 ms\" for milliseconds",
};

/// The true values less the declared ones, of an `[errors]` section.
pub(super) fn truth(section: &Section<'_>, robot: &Robot, has_heading: bool) -> Result<TrueErrors> {
    section.only(&KEYS)?;
    let number = |key, dimension, allowed: &Allowed| {
        Ok::<_, crate::Error>(section.number(key, dimension, allowed)?.unwrap_or(0.0))
    };
    let truth = TrueErrors {
        zero: number("zero", Dimension::Moment, &FINITE)?,
        zero_drift: number("zero_drift", Dimension::MomentRate, &FINITE)?,
        mount: mount(section)?,
        length: number("length", Dimension::Length, &FINITE)?,
        rigidity: number("stiffness", Dimension::Ratio, &SHARE)?,
        gain: number("gain", Dimension::Ratio, &SHARE)?,
        delay: number("delay", Dimension::Time, &DELAY)?,
        odometry_translation: number("odometry_translation", Dimension::Ratio, &SHARE)?,
        odometry_rotation: number("odometry_rotation", Dimension::Ratio, &SHARE)?,
        map_scale: number("map_scale", Dimension::Ratio, &SHARE)?,
        heading: number("heading", Dimension::Angle, &HEADING)?,
    };
    if truth.heading.abs() > 0.0 && !has_heading {
        return Err(section
            .source
            .fault(&section.span_of("heading"), "errors.heading without a heading in the log")
            .remedy("add heading_noise to [sensing]: the log then holds an absolute heading"));
    }
    truth.true_robot(robot).map_err(|error| {
        let error = error.in_file(section.source.name).at_line(section.line_of("length"));
        error.or_remedy("the true length is the declared one plus errors.length, in metres unless it carries a unit")
    })?;
    Ok(truth)
}

fn mount(section: &Section<'_>) -> Result<[f64; 3]> {
    let Some(value) = section.get("mount") else { return Ok([0.0; 3]) };
    let key = section.key("mount");
    let parts: &[Value<'_>] = value.get_ref().as_array().map_or(&[], |a| a);
    let [x, y, theta] = parts else {
        return Err(section
            .source
            .fault(&value.span(), format!("{key} must be three values: x, y, theta"))
            .allowed("[5e-4, 0.0, 0.0175] or [\"0.5 mm\", 0, \"1 deg\"]"));
    };
    let length = |v, part| section.quantity(&format!("{key} {part}"), v, Dimension::Length, &MOUNT);
    let heading = section.quantity(&format!("{key} theta"), theta, Dimension::Angle, &HEADING)?;
    Ok([length(x, "x")?, length(y, "y")?, heading])
}
