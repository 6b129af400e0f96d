//! The design of a sensor against the dipole's formula on its axis, worked out by hand, and against a search by brute force.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

use vibrissa::beam::Whisker;
use vibrissa::sensing::{Chip, SensingChain, Tle493d};
use vibrissa::tasks::sensor_design::{LARGEST_SHARE, best_sensor_design, sensor_design};

#[test]
fn field_resolution_and_tip_are_those_of_the_formulas() {
    let (chain, whisker) = (SensingChain::default(), Whisker::default());
    for distance in [4e-3, 5e-3, 9e-3] {
        let design = sensor_design(&chain, &whisker, distance, 1e-3, 0.0).unwrap();
        // On the axis B = 2e-7 m / d³. A turn by a small angle a about the pivot, which is `depth` before the magnet, turns the field
        // across by 1e-7 m a / d³, and carries the magnet to the side, by depth a: 3e-7 m depth a / d⁴.
        let (m, depth) = (3.6e-3, 3e-3);
        assert!((design.rest[2].abs() - 2e-7 * m / distance.powi(3)).abs() < 1e-9, "{design:?}");
        let turn = 1e-7 * m / distance.powi(3);
        let shift = 3e-7 * m * depth / distance.powi(4);
        let by_moment = [(turn + shift) / 0.05, (turn - shift).abs() / 0.05];
        let wanted = by_moment.map(|slope| chain.chip.per_count()[1] / slope);
        let near = |want: f64| (design.resolution[0] - want).abs() < 1e-5 * want;
        assert!(wanted.into_iter().any(near), "{distance}: {:?} not one of {wanted:?}", design.resolution);
        assert!((design.noise - design.resolution[0] / 12f64.sqrt()).abs() < 1e-9 * design.noise);
        // A clamped cantilever: 3 E I / L² of moment for a travel of the tip.
        let stiff = 3.0 * whisker.flexural_rigidity / whisker.length.powi(2);
        assert!((design.tip_noise - design.noise / stiff).abs() < 1e-6 * design.tip_noise);
    }
}

#[test]
fn the_best_distance_is_that_of_a_search_and_keeps_to_the_range() {
    let whisker = Whisker::default();
    let weak = SensingChain::default();
    let tle = SensingChain { chip: Chip::Tle493d(Tle493d::default()), ..weak };
    for (chain, nearest) in [(weak, 4e-3), (weak, 6e-3), (tle, 2e-3)] {
        let best = best_sensor_design(&chain, &whisker, nearest, 20e-3, 1e-6).unwrap().unwrap();
        assert!(best.share <= LARGEST_SHARE && best.distance >= nearest, "{best:?}");
        for k in 0..60 {
            let distance = nearest + 0.37e-3 * f64::from(k);
            let Ok(other) = sensor_design(&chain, &whisker, distance, 20e-3, 1e-6) else { continue };
            assert!(other.share > LARGEST_SHARE || other.noise >= 0.93 * best.noise, "{other:?} beats {best:?}");
        }
    }
    // A magnet as strong as a fridge's is too much everywhere.
    let strong = SensingChain { magnet_moment: [30.0, 0.0, 0.0], ..weak };
    assert_eq!(best_sensor_design(&strong, &whisker, 4e-3, 20e-3, 0.0).unwrap(), None);
    let error = sensor_design(&weak, &whisker, 0.0, 20e-3, 0.0).unwrap_err().to_string();
    assert!(error.contains("distance") && error.contains("0.0001 to 0.03 m"), "{error}");
}
