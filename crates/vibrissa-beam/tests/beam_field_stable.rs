//! Which shapes of the tip field are stable, against a chain of rigid links.

// A test helper that fails fails its test.
#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "data/fields.rs"]
mod fields;
#[path = "../../vibrissa/tests/data/random.rs"]
mod random;

use fields::{load, plain, uniform};
use random::Random;
use vibrissa_beam::beam::Whisker;
use vibrissa_beam::beam::field::TipField;
use vibrissa_beam::plane::Vec2;

/// Rigid links with springs between them: how many ways there are, with both ends of the chain held in place, to lower the energy.
fn falling_ways(angles: &[f64], (tip_ratio, base): (f64, f64), force: Vec2) -> usize {
    let n = angles.len();
    // The spring between link i - 1 and link i; the first joins half a link to the base, which is itself a spring.
    let spring = |i: usize| match i {
        0 => 1.0 / (0.5 / n as f64 + 1.0 / base),
        _ => (1.0 - (1.0 - tip_ratio) * i as f64 / n as f64).powi(4) * n as f64,
    };
    let h = 1.0 / n as f64;
    // The second variation, bordered by the two constraints that hold the tip.
    let size = n + 2;
    let mut m = vec![vec![0.0; size]; size];
    for i in 0..n {
        m[i][i] += spring(i) + if i + 1 < n { spring(i + 1) } else { 0.0 };
        if i + 1 < n {
            m[i][i + 1] -= spring(i + 1);
            m[i + 1][i] -= spring(i + 1);
        }
        let along = Vec2::from_angle(angles[i]);
        m[i][i] += h * force.dot(along);
        let across = h * along.perp();
        for (k, c) in [across.x, across.y].into_iter().enumerate() {
            m[i][n + k] = c;
            m[n + k][i] = c;
        }
    }
    negative(m) - 2
}

/// Negative eigenvalues of a symmetric matrix, by Jacobi's rotations.
#[allow(clippy::needless_range_loop, reason = "two columns, then two rows, of one matrix")]
fn negative(mut a: Vec<Vec<f64>>) -> usize {
    let n = a.len();
    for _ in 0..12 {
        for p in 0..n {
            for q in p + 1..n {
                if a[p][q].abs() < 1e-14 {
                    continue;
                }
                let theta = 0.5 * (a[q][q] - a[p][p]) / a[p][q];
                let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
                let c = 1.0 / t.hypot(1.0);
                let s = t * c;
                for k in 0..n {
                    let (x, y) = (a[k][p], a[k][q]);
                    (a[k][p], a[k][q]) = (c * x - s * y, s * x + c * y);
                }
                for k in 0..n {
                    let (x, y) = (a[p][k], a[q][k]);
                    (a[p][k], a[q][k]) = (c * x - s * y, s * x + c * y);
                }
            }
        }
    }
    (0..n).filter(|&i| a[i][i] < 0.0).count()
}

/// Slopes at the middles of `links` links, from the tip back by Runge and Kutta's method; lengths and base rigidity one.
fn slopes(tilt: f64, force: f64, (tip_ratio, base): (f64, f64), links: usize) -> Vec<f64> {
    const STEPS: usize = 40;
    let h = 0.5 / (links * STEPS) as f64;
    let rigidity = |s: f64| (1.0 - (1.0 - tip_ratio) * s).powi(4);
    // Back along the whisker: the slope less that at the tip, and the moment.
    let rate = |s: f64, (phi, m): (f64, f64)| (-m / rigidity(s), force * (tilt - phi).cos());
    let ahead = |a: (f64, f64), k: (f64, f64), h: f64| (a.0 + h * k.0, a.1 + h * k.1);
    let (mut s, mut at, mut middles) = (1.0, (0.0, 0.0), Vec::new());
    for step in 0..2 * links * STEPS {
        if step % (2 * STEPS) == STEPS {
            middles.push(at.0);
        }
        let k1 = rate(s, at);
        let k2 = rate(s - 0.5 * h, ahead(at, k1, 0.5 * h));
        let k3 = rate(s - 0.5 * h, ahead(at, k2, 0.5 * h));
        let k4 = rate(s - h, ahead(at, k3, h));
        let mean = |a: f64, b: f64, c: f64, d: f64| (a + 2.0 * b + 2.0 * c + d) / 6.0;
        at = ahead(at, (mean(k1.0, k2.0, k3.0, k4.0), mean(k1.1, k2.1, k3.1, k4.1)), h);
        s -= h;
    }
    middles.reverse();
    middles.iter().map(|phi| phi - at.0 + at.1 / base).collect()
}

#[test]
fn stable_is_what_a_chain_of_links_calls_stable() {
    const LINKS: usize = 40;
    let tapered = TipField::new(&Whisker { tip_ratio: 0.3, ..plain() }).unwrap();
    let soft = TipField::new(&Whisker { base_stiffness: 0.004, ..plain() }).unwrap();
    let base = 0.004 * plain().length / plain().flexural_rigidity;
    for (field, kind) in [(uniform(), (1.0, f64::INFINITY)), (&tapered, (0.3, f64::INFINITY)), (&soft, (1.0, base))] {
        let (mut random, mut stable, mut not) = (Random(11), 0, 0);
        for _ in 0..120 {
            let (tilt, force) = load(field, &mut random);
            let at = field.at(tilt, force).unwrap();
            // Close to the fold itself a chain of so few links cannot tell.
            let sine = at.by_tilt.position.cross(at.by_force.position)
                / (at.by_tilt.position.norm() * at.by_force.position.norm());
            if sine.abs() < 0.02 {
                continue;
            }
            let scaled = force * plain().length.powi(2) / plain().flexural_rigidity;
            let angles = slopes(tilt, scaled, kind, LINKS);
            assert!((angles[LINKS - 1] - at.slope).abs() < 0.1, "{angles:?} {}", at.slope);
            let ways = falling_ways(&angles, kind, scaled * Vec2::from_angle(at.direction()) * force.signum());
            assert_eq!(at.is_stable(), ways == 0, "{ways} {tilt} {force} {}", at.slope);
            if at.is_stable() { stable += 1 } else { not += 1 }
        }
        println!("{kind:?}: {stable} stable, {not} not");
        assert!(stable > 40);
    }
}
