//! A robot as the text of its file.

use super::Robot;
use std::fmt::Write;

impl Robot {
    /// The robot as a TOML text in SI units that [`Robot::from_toml`] reads back the same.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        for whisker in &self.whiskers {
            let (beam, mount, noise) = (&whisker.beam, whisker.robot_from_whisker, whisker.noise);
            // Writing into a string cannot fail.
            let _ = write!(
                text,
                "[[whisker]]\nname = {}\nlength = {:?}\nflexural_rigidity = {:?}\ntip_ratio = {:?}\ncurvature = {:?}\n\
                 base_stiffness = {:?}\nmount = [{:?}, {:?}, {:?}]\nfriction = {:?}\n\
                 noise = {{ moment_relative = {:?}, moment_absolute = {:?} }}\n",
                quoted(&whisker.name),
                beam.length,
                beam.flexural_rigidity,
                beam.tip_ratio,
                beam.curvature,
                beam.base_stiffness,
                mount.x,
                mount.y,
                mount.theta,
                whisker.friction,
                noise.moment_relative,
                noise.moment_absolute,
            );
            if let Some(calibration) = &whisker.calibration {
                let _ = writeln!(text, "calibration = {}", quoted(&calibration.to_string_lossy()));
            }
            text.push('\n');
        }
        let _ = write!(
            text,
            "[odometry]\ntranslation_relative = {:?}\nrotation_relative = {:?}\n",
            self.odometry.translation_relative, self.odometry.rotation_relative
        );
        text
    }
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
