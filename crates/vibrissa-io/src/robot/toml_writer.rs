//! A robot as the text of its file.

use crate::beam::Whisker;
use crate::world::Robot;
use std::fmt::Write;

/// The robot as a TOML text in SI units that [`super::from_toml`] reads back the same.
#[must_use]
pub fn to_toml(robot: &Robot) -> String {
    let mut text = String::new();
    for whisker in &robot.whiskers {
        let (mount, noise) = (whisker.robot_from_whisker, whisker.noise);
        let (force, slope, errors) = (whisker.force_noise, whisker.slope_noise, whisker.errors);
        // Writing into a string cannot fail.
        let _ = write!(
            text,
            "[[whisker]]\nname = {}\n{}mount = [{:?}, {:?}, {:?}]\nfriction = {:?}\n\
             noise = {{ moment_relative = {:?}, moment_absolute = {:?}, force_relative = {:?}, force_absolute = {:?}, \
             slope_relative = {:?}, slope_absolute = {:?} }}\n\
             zero_error = {:?}\nzero_drift_error = {:?}\nmount_error = {:?}\nlength_error = {:?}\n\
             stiffness_error = {:?}\ngain_error = {:?}\n",
            quoted(&whisker.name),
            beam(&whisker.beam),
            mount.x,
            mount.y,
            mount.theta,
            whisker.friction,
            noise.moment_relative,
            noise.moment_absolute,
            force.relative,
            force.absolute,
            slope.relative,
            slope.absolute,
            errors.zero,
            errors.zero_drift,
            errors.mount,
            errors.length,
            errors.rigidity,
            errors.gain,
        );
        if let Some(calibration) = &whisker.calibration {
            let _ = writeln!(text, "calibration = {}", quoted(&calibration.to_string_lossy()));
        }
        if !whisker.lean.is_level() {
            let _ = writeln!(text, "elevation = {:?}\nroll = {:?}", whisker.lean.elevation, whisker.lean.roll);
        }
        text.push('\n');
    }
    let _ = write!(
        text,
        "[odometry]\ntranslation_relative = {:?}\nrotation_relative = {:?}\ndelay_error = {:?}\n\n[map]\nscale_error = {:?}\n",
        robot.odometry.translation_relative, robot.odometry.rotation_relative, robot.odometry.delay, robot.map_scale
    );
    text
}

/// The keys of a beam, a line each.
fn beam(beam: &Whisker) -> String {
    let mut text = String::new();
    let wires = beam.stretches.as_slice();
    if wires.is_empty() {
        let _ = write!(
            text,
            "length = {:?}\nflexural_rigidity = {:?}\ntip_ratio = {:?}\n",
            beam.length, beam.flexural_rigidity, beam.tip_ratio
        );
        if let Some(diameter) = beam.diameter {
            let _ = writeln!(text, "diameter = {diameter:?}");
        }
    } else {
        text.push_str("segments = [\n");
        for wire in wires {
            let diameter = wire.diameter.map_or_else(String::new, |d| format!(", diameter = {d:?}"));
            let _ = writeln!(
                text,
                "  {{ length = {:?}, flexural_rigidity = {:?}, tip_ratio = {:?}{diameter} }},",
                wire.length, wire.flexural_rigidity, wire.tip_ratio
            );
        }
        text.push_str("]\n");
    }
    let terms = beam.curvature_terms().map(|term| format!("{term:?}"));
    let _ = write!(
        text,
        "curvature = [{}]\nbase_stiffness = {:?}\nstrain_limit = {:?}\n",
        terms.join(", "),
        beam.base_stiffness,
        beam.strain_limit
    );
    text
}

/// A TOML basic string.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c.is_control() => {
                let _ = write!(out, "\\u{:04X}", c as u32);
            }
            c => out.push(c),
        }
    }
    out.push('"');
    out
}
