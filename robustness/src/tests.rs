//! The program's own parts.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

use crate::cells::{ERRORS, LAWS};
use crate::least_error::Sensitivity;
use crate::worlds::world;
use vibrissa::sim::recorder::NoiseLaw;

#[test]
fn every_law_stays_within_the_declared_bound() {
    let world = world(1).unwrap();
    let noise = world.robot.whiskers[0].noise;
    for cell in LAWS {
        let trial = cell.trial(&world, 3, NoiseLaw::Exact).unwrap();
        let mut largest = 0.0_f64;
        for (row, exact) in trial.log.rows.iter().zip(&world.sweep.exact_moments) {
            let (z, h) = (row.readings[0], exact[0]);
            let bound = noise.moment_relative * z.abs() + noise.moment_absolute;
            largest = largest.max((h - z).abs() / bound);
        }
        assert!(largest <= 1.0 + 1e-9, "{}: {largest}", cell.word);
        let exact = matches!(cell.word, "none" | "odometry");
        assert!(exact == (largest < 0.2), "{}: {largest}", cell.word);
    }
}

#[test]
fn what_nobody_declared_leaves_the_declaration_alone_and_spoils_something() {
    let world = world(2).unwrap();
    let clean = ERRORS[0].trial(&world, 3, NoiseLaw::Exact).unwrap();
    for cell in &ERRORS[1..ERRORS.len() - 1] {
        let trial = cell.trial(&world, 3, NoiseLaw::Exact).unwrap();
        assert_eq!(trial.robot.whiskers[0].noise, clean.robot.whiskers[0].noise);
        let same = trial.log == clean.log && trial.robot == clean.robot && trial.map.bounds() == clean.map.bounds();
        assert!(!same, "{}", cell.word);
        assert_eq!(trial.truth.is_none(), cell.word == "wrong_map");
    }
}

#[test]
fn the_cramer_rao_bound_grows_where_errors_stay_alike() {
    let bounds = (1..40).filter_map(|seed| {
        let sensitivity = Sensitivity::of(&world(seed)?)?;
        let of = |time_constant| sensitivity.least_error(NoiseLaw::Autoregressive { time_constant });
        Some([sensitivity.least_error(NoiseLaw::Uniform)?, of(1e-6)?, of(0.1)?])
    });
    let bounds: Vec<[f64; 3]> = bounds.collect();
    assert!(bounds.len() > 5);
    for [independent, short, long] in bounds {
        assert!((short / independent - 1.0).abs() < 1e-6, "{short} {independent}");
        assert!(long > 0.5 * independent && long.is_finite(), "{long} {independent}");
    }
}

#[test]
fn a_seed_gives_one_world() {
    for seed in [5, 6, 7, 8] {
        let (Some(a), Some(b)) = (world(seed), world(seed)) else { continue };
        assert_eq!((a.sweep, a.robot), (b.sweep, b.robot));
    }
}
