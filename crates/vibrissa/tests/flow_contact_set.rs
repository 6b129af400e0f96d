//! Tip contacts of a moment against the beam's own modes, which share no search with them.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/random.rs"]
mod random;

use random::Random;
use std::f64::consts::TAU;
use vibrissa::beam::{Bend, Load, TipModel, TipReading, Whisker, elastica, largest_tip_moment, moment_mode, tip_curve};
use vibrissa::config::TipLoad;
use vibrissa::flow::contact_set::{TipContact, TipContactSet};

/// The bend with exactly this moment and this direction of the force, by Newton steps from a contact.
fn polished(whisker: &Whisker, moment: f64, contact: &TipContact) -> Bend {
    let bend = |force: f64, tilt: f64| {
        elastica::bend(whisker.flexural_rigidity, force, whisker.length, tilt).expect("near the contact")
    };
    let turn = |b: &Bend| {
        let off = b.force_vector().angle() - contact.direction;
        off - TAU * (off / TAU).round()
    };
    let (mut force, mut tilt) = (contact.force, contact.tilt());
    for _ in 0..50 {
        let at = bend(force, tilt);
        let (f, g) = (at.moment / moment - 1.0, turn(&at));
        let (h, k) = (1e-6 * force, 1e-6);
        let (by_force, by_tilt) = (bend(force + h, tilt), bend(force, tilt + k));
        let [a, b] = [(by_force.moment - at.moment) / moment / h, (by_tilt.moment - at.moment) / moment / k];
        let [c, d] = [(turn(&by_force) - g) / h, (turn(&by_tilt) - g) / k];
        let det = a * d - b * c;
        // Short steps: the nearest solution is wanted, not any.
        force -= ((f * d - b * g) / det).clamp(-0.02 * force.abs(), 0.02 * force.abs());
        tilt -= ((a * g - f * c) / det).clamp(-0.02, 0.02);
    }
    let at = bend(force, tilt);
    assert!((at.moment / moment - 1.0).abs() < 1e-6 && turn(&at).abs() < 1e-6, "{at:?}");
    at
}

#[test]
fn every_contact_causes_the_moment() {
    let mut draw = Random(1);
    let (mut checked, mut worst): (usize, f64) = (0, 0.0);
    for _ in 0..400 {
        let whisker = Whisker {
            length: draw.between(0.01, 0.4),
            flexural_rigidity: 10f64.powf(draw.between(-7.0, 0.0)),
            ..Whisker::default()
        };
        let mu = 10f64.powf(draw.between(-4.0, 0.5)).min(2.9);
        let side = if draw.unit() < 0.5 { -1.0 } else { 1.0 };
        let moment = side * mu * whisker.flexural_rigidity / whisker.length;
        for set in TipContactSet::branches(
            &TipModel::new(&whisker).unwrap(),
            TipReading::Moment(moment),
            TipLoad::BoundaryNormal,
        ) {
            let range = set.directions();
            for _ in 0..if range.width() > 0.1 { 5 } else { 0 } {
                // At the ends of a branch two solutions meet and neither is defined well.
                let inside = draw.between(range.lo() + 0.04, range.hi() - 0.04);
                let direction = inside + TAU * (draw.unit() * 5.0 - 2.5).round();
                let contact = set.at_direction(direction).expect("inside the range");
                let truth = polished(&whisker, moment, &contact);
                let miss = (truth.contact - contact.position).norm();
                worst = worst.max(miss / whisker.length);
                checked += 1;
            }
            for node in set.contacts() {
                let bend = elastica::bend(whisker.flexural_rigidity, node.force, whisker.length, node.tilt()).unwrap();
                assert!((bend.moment - moment).abs() <= 1e-8 * moment.abs(), "{} {moment}", bend.moment);
                assert!((bend.contact - node.position).norm() <= 1e-9 * whisker.length);
                let pull = bend.force_vector().angle();
                assert!(((pull - node.direction) / TAU - ((pull - node.direction) / TAU).round()).abs() < 1e-9);
            }
        }
    }
    // The documented bound of linear interpolation.
    assert!(checked > 1500 && worst < 2e-4, "{checked}, {worst:e}");
}

/// The largest dimensionless moment of a load tilted by +1.45 rad.
fn largest_moment_of_pulling_load() -> f64 {
    let unit = Whisker { length: 1.0, flexural_rigidity: 1.0, ..Whisker::default() };
    let moment = |k: i32| elastica::bend(1.0, (f64::from(k) * 2e-3).powi(2), 1.0, 1.45).map_or(0.0, |b| b.moment);
    let largest = (1..5000).map(moment).fold(0.0, f64::max);
    assert!(!moment_mode(&unit, 0.999 * largest, 1.0, Load::Tilted(1.45)).unwrap().is_empty());
    largest
}

#[test]
fn no_equilibrium_is_left_out() {
    // Every bend found by the moment mode for a tilted load lies on one of the branches.
    let whisker = Whisker::default();
    let mut draw = Random(7);
    let mut found = 0;
    for _ in 0..600 {
        let tilt = draw.between(-1.3, 1.3);
        let moment = draw.between(-2.8, 2.8) * whisker.flexural_rigidity / whisker.length;
        let sets = TipContactSet::branches(
            &TipModel::new(&whisker).unwrap(),
            TipReading::Moment(moment),
            TipLoad::BoundaryNormal,
        );
        let mu = moment.abs() * whisker.length / whisker.flexural_rigidity;
        // The far side of small moments is left out, as documented.
        let whole = mu > largest_moment_of_pulling_load();
        let bends = moment_mode(&whisker, moment, whisker.length, Load::Tilted(tilt)).unwrap();
        for bend in bends.iter().take(if whole { 2 } else { 1 }).filter(|b| b.phi_a.abs() < 3.1) {
            let direction = bend.force_vector().angle();
            let near = sets
                .iter()
                .filter_map(|s| s.at_direction(direction))
                .map(|c| (c.position - bend.contact).norm())
                .fold(f64::INFINITY, f64::min);
            assert!(near < 2e-3 * whisker.length, "moment {moment}, tilt {tilt}: {bend:?}, {near:e}");
            found += 1;
        }
    }
    assert!(found > 500, "{found}");
}

#[test]
fn the_papers_load_is_the_normal_one() {
    let whisker = Whisker::default();
    for moment in [1e-6, -2e-4, 3e-3, -8e-3, 1.1e-2] {
        let sets = TipContactSet::branches(
            &TipModel::new(&whisker).unwrap(),
            TipReading::Moment(moment),
            TipLoad::WhiskerNormal,
        );
        let bends = moment_mode(&whisker, moment, whisker.length, Load::Normal).unwrap();
        assert!(sets.iter().all(TipContactSet::is_point));
        let first = sets[0].contacts()[0];
        assert!((first.position - bends[0].contact).norm() < 2e-4 * whisker.length, "{first:?} {bends:?}");
        // The one point answers for every direction that can push on it, and for no other.
        let away = first.direction;
        assert_eq!(sets[0].at_direction(away + 1.5), Some(first));
        assert_eq!(sets[0].at_direction(away + 3.0), None);
    }
}

#[test]
fn impossible_moments_have_no_contacts() {
    let whisker = Whisker::default();
    for moment in [0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.0, -1.0, 1e300] {
        assert!(
            TipContactSet::branches(
                &TipModel::new(&whisker).unwrap(),
                TipReading::Moment(moment),
                TipLoad::BoundaryNormal
            )
            .is_empty(),
            "{moment}"
        );
    }
    assert!((largest_tip_moment(0.0) - 2.944_666_7).abs() < 1e-6);
    let largest = largest_tip_moment(f64::INFINITY);
    assert!(!tip_curve(0.9 * largest).is_empty() && tip_curve(1.001 * largest).is_empty(), "{largest}");
    assert!(tip_curve(-1.0).is_empty());
}

#[test]
fn the_nearest_contact_is_the_nearest_of_many() {
    let whisker = Whisker::default();
    let mut draw = Random(3);
    for _ in 0..200 {
        let moment = draw.between(-6e-3, 6e-3);
        let Some(set) = TipContactSet::branches(
            &TipModel::new(&whisker).unwrap(),
            TipReading::Moment(moment),
            TipLoad::BoundaryNormal,
        )
        .into_iter()
        .next() else {
            continue;
        };
        let range = set.directions();
        let (from, turn) = (draw.between(range.lo(), range.hi()), draw.between(0.1, 2.0));
        let point = vibrissa::plane::Vec2::new(draw.between(-0.02, 0.1), draw.between(-0.08, 0.08));
        let scan = (0..=4000)
            .filter_map(|k| set.at_direction(from + turn * f64::from(k) / 4000.0))
            .map(|c| (c.position - point).norm())
            .fold(f64::INFINITY, f64::min);
        let near = set
            .nearest(point, from, turn)
            .unwrap_or_else(|| panic!("the cone starts on the branch: {range:?} {from} {turn}"));
        assert!(((near.position - point).norm() - scan).abs() < 2e-5, "{near:?} {scan}");
    }
}
