//! Distances from real recordings, each found by a shaft that was fitted without its own distance.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/shared.rs"]
mod shared;

use shared::shared;
use std::path::PathBuf;
use vibrissa::config::{StaircaseOptions, TapOptions};
use vibrissa::flow::taps::taps;
use vibrissa::io::log::foreign::{Format, Recording};
use vibrissa::tasks::calibrate::{DistanceSet, LeftOut, Shaft, fit_distance, leave_one_out, staircase};
use vibrissa::world::calibration::Motion;

fn data(path: &str) -> Option<PathBuf> {
    shared(&format!("data/{path}"))
}

/// Mean, root mean square and largest error (mm).
fn errors(answers: &[LeftOut]) -> [f64; 3] {
    let errors: Vec<f64> = answers.iter().map(|a| 1e3 * (a.found.unwrap() - a.truth).abs()).collect();
    let n = errors.len() as f64;
    let square: f64 = errors.iter().map(|e| e * e).sum();
    [errors.iter().sum::<f64>() / n, (square / n).sqrt(), errors.iter().copied().fold(0.0, f64::max)]
}

#[test]
fn taps_of_a_turning_cone_tell_their_distance() {
    let mut sets = Vec::new();
    for mm in [65, 85, 105, 125, 145, 165] {
        let Some(path) = data(&format!("ratatouille/deflection_{mm}.csv")) else { return };
        let recording = Recording::read(&path, Format::Ratatouille).unwrap();
        let found = taps(&recording.t, recording.column("ax").unwrap(), &TapOptions::default());
        let distance = f64::from(mm) * 1e-3;
        assert!((20..=30).contains(&found.len()), "{mm} mm: {} taps", found.len());
        println!("{mm} mm: {} taps, first {:?}", found.len(), found[0]);
        sets.push(DistanceSet {
            source: path.display().to_string(),
            samples: found.iter().map(|tap| (distance, tap.slope)).collect(),
        });
    }
    let shaft = Shaft { motion: Motion::Turn, length: 0.18, tip_ratio: Some(1.0 / 3.0), clamped: false };
    println!("{:?}", fit_distance(&sets, shaft).unwrap());
    let [mean, rms, worst] = errors(&leave_one_out(&sets, shaft).unwrap());
    println!("left out: mean {mean:.2} mm, RMS {rms:.2} mm, worst {worst:.2} mm");
    assert!(mean < 0.85 && rms < 1.05 && worst < 2.6, "{mean} {rms} {worst}");
    // What a cylinder makes of the same slopes: taper is what matters.
    let cylinder = Shaft { tip_ratio: Some(1.0), ..shaft };
    let [mean, ..] = errors(&leave_one_out(&sets[..5], cylinder).unwrap());
    assert!(mean > 3.0, "{mean}");
}

#[test]
fn staircases_tell_their_distance() {
    let Some(path) = data("openwhisker/staircase.csv") else { return };
    let recording = Recording::read(path, Format::Openwhisker).unwrap();
    let sets = staircase(&recording, "ay", 0.15, &StaircaseOptions::default()).unwrap();
    for set in &sets {
        println!("{:?}", set.samples);
    }
    let shaft = Shaft { motion: Motion::Travel, length: 0.15, tip_ratio: None, clamped: true };
    println!("{:?}", fit_distance(&sets, shaft).unwrap());
    let [mean, rms, worst] = errors(&leave_one_out(&sets, shaft).unwrap());
    println!("left out: mean {mean:.2} mm, RMS {rms:.2} mm, worst {worst:.2} mm");
    assert!(mean < 0.9 && rms < 1.05 && worst < 2.4, "{mean} {rms} {worst}");
}
