//! The chart of the loaded tip against the searched-for bend, and its derivatives against differences of that.

#![allow(clippy::unwrap_used)]

use vibrissa_beam::beam::{TipChart, TipTable, elastica::bend, held_tip_chart, tip_chart};

#[allow(dead_code)]
#[path = "../../vibrissa/tests/data/random.rs"]
mod random;
use random::Random;

const EI: f64 = 2.8886e-4;
const L: f64 = 0.075;

/// Tip over length, slope and dimensionless moment, from the closed form of the whole bend.
fn bent(q: f64, beta: f64) -> Option<[f64; 4]> {
    let b = bend(EI, q * EI / (L * L), L, beta)?;
    Some([b.contact.x / L, b.contact.y / L, b.phi_a, b.moment * L / EI])
}

fn values(c: &TipChart) -> [f64; 4] {
    [c.position.x, c.position.y, c.slope, c.moment]
}

#[test]
fn values_and_derivatives_agree_with_the_bend() {
    let mut random = Random(3);
    let mut checked = 0;
    for i in 0..4000 {
        let q = match i % 4 {
            0 => random.signed(2e-3),
            1 => random.signed(0.3),
            _ => random.signed(9.0),
        };
        let beta = random.signed(2.9);
        if beta.cos().abs() < 0.08 {
            continue;
        }
        let Some(chart) = tip_chart(q, beta) else { continue };
        let h = 1e-4 * q.abs().max(1e-3);
        let around = [(q - h, beta), (q + h, beta), (q, beta - 1e-4), (q, beta + 1e-4)].map(|(q, b)| bent(q, b));
        let [Some(less), Some(more), Some(left), Some(right)] = around else { continue };
        checked += 1;
        let exact = bent(q, beta).unwrap();
        for k in 0..4 {
            assert!((values(&chart)[k] - exact[k]).abs() < 2e-11, "q {q} beta {beta}: {chart:?} {exact:?}");
        }
        let rates = |r: &vibrissa_beam::beam::TipRate| [r.position.x, r.position.y, r.slope, r.moment];
        for k in 0..4 {
            let by_force = (more[k] - less[k]) / (2.0 * h);
            let by_tilt = (right[k] - left[k]) / 2e-4;
            let size = 1.0 + 1.0 / beta.cos().powi(2);
            assert!(
                (rates(&chart.by_force)[k] - by_force).abs() < 3e-6 * size,
                "{k} force: q {q} beta {beta}: {chart:?} {by_force}"
            );
            assert!(
                (rates(&chart.by_tilt)[k] - by_tilt).abs() < 3e-6 * size * size,
                "{k} tilt: q {q} beta {beta}: {chart:?} {by_tilt}"
            );
        }
    }
    assert!(checked > 2500, "{checked}");
}

#[test]
fn the_chart_is_smooth_through_its_seams() {
    for beta in [-1.2, -0.4, 0.0, 0.7, 1.3, 2.6] {
        for q in [1e-4, -1e-4, 0.0625, -0.0625] {
            let (a, b) = (tip_chart(q * (1.0 - 1e-9), beta).unwrap(), tip_chart(q * (1.0 + 1e-9), beta).unwrap());
            for k in 0..4 {
                assert!((values(&a)[k] - values(&b)[k]).abs() < 3e-10, "q {q} beta {beta}: {a:?} {b:?}");
            }
        }
    }
    assert!(tip_chart(f64::NAN, 0.1).is_none() && tip_chart(0.1, f64::NAN).is_none());
    assert!(tip_chart(1e4, 0.0).is_none() && tip_chart(1.0, core::f64::consts::FRAC_PI_2).is_none());
}

#[test]
fn the_table_says_what_the_chart_says() {
    let table = TipTable::new();
    let mut random = Random(5);
    let (mut ordinary, mut steep) = (0.0_f64, 0.0_f64);
    for _ in 0..20_000 {
        let (q, beta) = (random.between(-0.25, 12.0), random.signed(3.1));
        let (Some(a), Some(b)) = (table.at(q, beta), tip_chart(q, beta)) else {
            assert_eq!(table.at(q, beta).is_none(), tip_chart(q, beta).is_none(), "q {q} beta {beta}");
            continue;
        };
        let off = (0..4).map(|k| (values(&a)[k] - values(&b)[k]).abs()).fold(0.0, f64::max);
        let rate =
            |c: &TipChart| [c.by_force, c.by_tilt].map(|r| [r.position.x, r.position.y, r.slope, r.moment]).concat();
        let off_rate = rate(&a).iter().zip(rate(&b)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        if beta.cos() > 0.5 {
            ordinary = ordinary.max(off);
            assert!(off_rate < 1e-3, "q {q} beta {beta}: {off_rate}");
        } else {
            steep = steep.max(off);
        }
    }
    println!("table off by {ordinary:.1e}, at steep tilts {steep:.1e}");
    assert!(ordinary < 1e-5 && steep < 2e-2, "{ordinary} {steep}");
}

/// The same by Runge and Kutta's method from the tip back: the loaded elastica `u'' = q cos(u + beta)`, lengths over the whisker's.
fn integrated(q: f64, beta: f64) -> [f64; 4] {
    let steps = 4000;
    let h = 1.0 / f64::from(steps);
    let rate = |[u, du, _, _]: [f64; 4]| [du, q * (u + beta).cos(), u.cos(), u.sin()];
    let mut at = [0.0; 4];
    for _ in 0..steps {
        let shifted = |by: f64, k: [f64; 4]| core::array::from_fn(|i| at[i] + by * k[i]);
        let a = rate(at);
        let b = rate(shifted(0.5 * h, a));
        let c = rate(shifted(0.5 * h, b));
        let d = rate(shifted(h, c));
        at = core::array::from_fn(|i| at[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
    }
    // Seen from the base, where the slope is 0 and the tip's is `u`.
    let [u, du, along, across] = at;
    let (sin, cos) = u.sin_cos();
    [along * cos + across * sin, along * sin - across * cos, u, du]
}

#[test]
fn shapes_with_an_inflection_agree_with_an_integration() {
    let mut random = Random(5);
    let mut beyond = 0;
    for _ in 0..600 {
        let (q, beta) = (10.0 + random.signed(9.0), random.signed(2.9));
        let Some(chart) = held_tip_chart(q, beta).filter(|_| beta.cos().abs() > 0.05) else { continue };
        beyond += usize::from(tip_chart(q, beta).is_none());
        let exact = integrated(q, beta);
        for k in 0..4 {
            assert!((values(&chart)[k] - exact[k]).abs() < 1e-8, "{k}: q {q} beta {beta}: {chart:?} {exact:?}");
        }
        let rates = |r: &vibrissa_beam::beam::TipRate| [r.position.x, r.position.y, r.slope, r.moment];
        let difference = |k: usize, dq: f64, db: f64| {
            let (more, less) = (integrated(q + dq, beta + db), integrated(q - dq, beta - db));
            (more[k] - less[k]) / (2.0 * (dq + db))
        };
        for k in 0..4 {
            let size = 1.0 + 1.0 / beta.cos().powi(2);
            assert!((rates(&chart.by_force)[k] - difference(k, 1e-4, 0.0)).abs() < 1e-6 * size, "{k} q {q} {beta}");
            assert!((rates(&chart.by_tilt)[k] - difference(k, 0.0, 1e-4)).abs() < 1e-5 * size, "{k} q {q} {beta}");
        }
    }
    println!("{beyond} beyond the first mode");
    assert!(beyond > 60, "{beyond}");
}
