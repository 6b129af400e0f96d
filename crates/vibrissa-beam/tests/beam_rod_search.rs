//! The inverse modes of the rod find what the force mode made, next to folds and in rare places, too.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/extrapolation.rs"]
mod extrapolation;
#[path = "../../vibrissa/tests/data/random.rs"]
mod random;
#[path = "data/wire.rs"]
mod wire;

use random::Random;
use std::f64::consts::PI;
use vibrissa_beam::beam::{Bend, Load, Rod, Whisker, force_mode, moment_mode, point_mode};
use wire::{EI, Wire, balanced, random_whisker, softness};

#[test]
fn moment_and_point_mode_find_what_force_mode_made() {
    let mut random = Random(29);
    let (mut worst, mut count, mut lost) = (0.0_f64, 0, Vec::new());
    for i in 0..240 {
        let whisker = random_whisker(&mut random);
        let wire = Wire::whisker(&whisker);
        let s_a = random.between(0.01, 0.075);
        let force = random.sign() * random.between(0.01, 4.0) / softness(&whisker, s_a);
        let load = match i % 3 {
            0 => Load::Normal,
            1 => Load::Vertical,
            _ => Load::Tilted(random.between(-1.2, 1.2)),
        };
        for b in force_mode(&whisker, force, s_a, load).unwrap() {
            // The inverse modes take pushes only.
            if matches!(load, Load::Vertical) && b.moment * force < 0.0 {
                continue;
            }
            let by_moment = moment_mode(&whisker, b.moment, s_a, load).unwrap();
            let by_point = point_mode(&whisker, b.contact, load).unwrap();
            for (name, list) in [("moment", by_moment), ("point", by_point)] {
                count += 1;
                if !list.iter().any(|c| (c.phi_a - b.phi_a).abs() < 1e-6 && (c.force / b.force - 1.0).abs() < 1e-5) {
                    lost.push(format!("{name} {load:?} {whisker:?} {:?} {:?} {:?}", b.phi_a, b.force, b.s_a));
                }
                for c in list {
                    // Integration from the base multiplies errors by exp(t): strong pulls are not judged by it.
                    let strong = c.force.abs() * softness(&whisker, c.s_a) > 30.0;
                    let miss = if strong { 0.0 } else { wire.miss(&c) };
                    assert!(miss < 1e-7 && balanced(&c), "{name} {miss:e} {whisker:?} {load:?} {c:?}");
                    worst = worst.max(miss);
                }
            }
        }
    }
    println!("{count} looked for, {} lost, worst miss {worst:.1e}", lost.len());
    lost.iter().take(8).for_each(|l| println!("lost {l}"));
    assert!(count > 300 && lost.is_empty());
}

/// Shapes that grid searches without starts at folds lost, from a search of thousands: their load, base, taper and curvature.
#[test]
fn shapes_next_to_folds_are_found_again() {
    let cases = [
        (Load::Normal, -0.1332, 0.0687, 0.502, 0.0, 0.0, 1.3808),
        (Load::Normal, -0.1560, 0.0514, 0.271, 0.02, 0.0, 0.0033),
        (Load::Normal, 0.4591, 0.0580, 1.0, 0.0, 0.0, 0.0059),
        (Load::Normal, 0.0217, 0.0749, 0.272, -7.19, 60.0, 0.0045),
        (Load::Normal, -0.4116, 0.0387, 0.086, -6.82, 0.0, f64::INFINITY),
        (Load::Normal, 2.0479, 0.0374, 1.0, 0.0, 179.6, 0.0046),
        (Load::Tilted(-1.6480035), -0.2118, 0.0562, 0.152, -9.64, 0.0, f64::INFINITY),
        (Load::Tilted(3.0911191), -0.1318, 0.0693, 0.487, 2.14, 0.0, f64::INFINITY),
        (Load::Tilted(-2.0228048), 0.6363, 0.0528, 0.573, -5.0, 0.0, 1.4006),
        (Load::Tilted(1.4019555), 0.3541, 0.0484, 0.386, -5.15, 0.0, 0.0115),
        (Load::Tilted(1.6854274), 0.1858, 0.0586, 0.423, 0.0, 0.0, 0.3068),
    ];
    for (load, force, s_a, tip_ratio, curvature, rise, base_stiffness) in cases {
        let mut whisker = Whisker { tip_ratio, curvature, base_stiffness, ..Whisker::default() };
        whisker.curvature_rise[0] = rise;
        let shapes = force_mode(&whisker, force, s_a, load).unwrap();
        assert_eq!(shapes.len(), 1, "{load:?} {force}");
        let same = |b: &Bend| (b.phi_a - shapes[0].phi_a).abs() < 1e-6 && (b.s_a / s_a - 1.0).abs() < 1e-6;
        let by_point = point_mode(&whisker, shapes[0].contact, load).unwrap();
        let by_moment = moment_mode(&whisker, shapes[0].moment, s_a, load).unwrap();
        assert!(by_point.iter().any(same) && by_moment.iter().any(same), "{load:?} {force}");
    }
}

/// Taper, curvature, its rise, base stiffness, force, arc length, tilt, load.
type Rare = (f64, f64, f64, f64, f64, f64, f64, Load);

#[test]
fn rare_branches_are_found_from_their_contact() {
    let inf = f64::INFINITY;
    let directed = Load::Directed;
    let cases: [Rare; 6] = [
        // The line of the force meets the rod twice before the contact.
        (0.09163966533, 2.9870771419, 0.0, inf, -0.024867390538, 0.07268681818, -1.223971433, directed(0.144737994708)),
        (
            0.22610316107,
            -2.5178624895,
            -36.65298667,
            0.01087415952,
            -0.0801773552,
            0.07402372121,
            -1.81878824,
            directed(-0.0972),
        ),
        // A soft base turns the whisker by radians from one force of the grid to the next.
        (
            0.64324810026,
            5.19413394357,
            -87.6155118593,
            0.00343078548,
            -28.514115184,
            0.01052816474,
            -2.8870979,
            Load::Tilted(-2.8870979),
        ),
        (0.69240733638, 4.24699718678, -2.89484676728, 0.00355452661, 14.6551578787, 0.01484511865, 0.0, Load::Normal),
        // Many equilibria of higher modes and beyond the tip surround this one.
        (
            0.2969465740450612,
            -5.3966389,
            0.0,
            inf,
            0.0094006256623,
            0.0730765787905,
            -0.752759569511,
            Load::Tilted(-0.752759569511),
        ),
        // The search ends beyond the tip.
        (0.7748283532820007, 0.0, 0.0, 1.2628488803, -0.25350884769, 0.07433248049, 0.0, Load::Normal),
    ];
    for (tip_ratio, curvature, rise, base_stiffness, force, s_a, beta, load) in cases {
        let whisker = Whisker {
            tip_ratio,
            curvature,
            curvature_rise: [rise, 0.0, 0.0, 0.0, 0.0],
            base_stiffness,
            flexural_rigidity: EI,
            ..Whisker::default()
        };
        let rod = Rod::new(&whisker).unwrap();
        let made = rod.force_mode(force, s_a, Load::Tilted(beta)).unwrap().remove(0);
        // The load that has the tilt: the direction comes from the shape.
        let load = match load {
            Load::Directed(_) => Load::Directed(made.phi_a + beta + PI / 2.0),
            _ => Load::Tilted(beta),
        };
        let found = rod.point_mode(made.contact, load).unwrap();
        let near = |b: &Bend| (b.phi_a - made.phi_a).abs() < 1e-6 && (b.s_a / made.s_a - 1.0).abs() < 1e-6;
        assert!(found.iter().any(near), "{whisker:?} {made:?}");
    }
}
