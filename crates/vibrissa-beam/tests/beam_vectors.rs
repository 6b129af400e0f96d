//! The beam against 30-digit quadrature, from 1e-8 rad to 2.6 rad.

// A test helper that fails fails its test, and numbers that went through text unchanged are equal.
#![allow(clippy::unwrap_used, clippy::float_cmp, clippy::panic)]

#[path = "../../vibrissa/tests/data/shared.rs"]
mod shared;

use shared::shared;
use std::collections::BTreeMap;
use vibrissa_beam::beam::{Bend, Load, Whisker, force_mode, moment_mode, point_mode};
use vibrissa_beam::plane::Vec2;

struct Row {
    load: String,
    beta: f64,
    whisker: Whisker,
    s_a: f64,
    force: f64,
    phi_a: f64,
    contact: Vec2,
    moment: f64,
}

fn rows() -> Option<Vec<Row>> {
    let text = std::fs::read_to_string(shared("vectors/elastica.csv")?).unwrap();
    let parse = |line: &str| {
        let f: Vec<&str> = line.split(',').collect();
        let n = |i: usize| f[i].parse::<f64>().unwrap();
        Row {
            load: f[1].into(),
            beta: n(2),
            whisker: Whisker {
                tip_ratio: n(3),
                curvature: n(4),
                base_stiffness: n(5),
                flexural_rigidity: n(6),
                length: n(7),
                ..Whisker::default()
            },
            s_a: n(8),
            force: n(9),
            phi_a: n(10),
            contact: Vec2::new(n(11), n(12)),
            moment: n(13),
        }
    };
    Some(text.lines().skip(1).map(parse).collect())
}

fn load(row: &Row) -> Load {
    match row.load.as_str() {
        "normal" => Load::Normal,
        "vertical" => Load::Vertical,
        _ => Load::Tilted(row.beta),
    }
}

/// Relative to the number itself, except where x or y passes through zero: then to 1e-3 of the contact's distance.
fn errors(row: &Row, bend: &Bend) -> [f64; 5] {
    let r = row.contact.norm();
    [
        bend.phi_a / row.phi_a - 1.0,
        (bend.contact.x - row.contact.x) / row.contact.x.abs(),
        (bend.contact.y - row.contact.y) / row.contact.y.abs().min(r),
        bend.moment / row.moment - 1.0,
        bend.force / row.force - 1.0,
    ]
    .map(f64::abs)
}

/// The worst errors of each group over the three modes, for the rows that `take` chooses; and how many these are.
fn worst(rows: &[Row], take: impl Fn(&Row) -> bool) -> (BTreeMap<String, [f64; 5]>, usize) {
    let mut worst: BTreeMap<String, [f64; 5]> = BTreeMap::new();
    let mut count = 0;
    for row in rows.iter().filter(|row| take(row)) {
        count += 1;
        let modes = [
            ("force", force_mode(&row.whisker, row.force, row.s_a, load(row))),
            ("moment", moment_mode(&row.whisker, row.moment, row.s_a, load(row))),
            ("point", point_mode(&row.whisker, row.contact, load(row))),
        ];
        for (mode, bends) in modes {
            let best = bends
                .unwrap()
                .iter()
                .map(|b| errors(row, b))
                .min_by(|a, b| a.iter().sum::<f64>().total_cmp(&b.iter().sum()))
                .unwrap_or_else(|| panic!("{mode} mode finds nothing at phi_a = {} s_a = {}", row.phi_a, row.s_a));
            let slot = worst.entry(format!("{mode} {}", row.load)).or_default();
            for (s, e) in slot.iter_mut().zip(best) {
                *s = s.max(e);
            }
        }
    }
    println!("worst relative errors      phi_a      x        y        M0       F");
    for (group, errors) in &worst {
        println!("{group:24} {}", errors.map(|e| format!("{e:8.1e}")).join(" "));
    }
    (worst, count)
}

#[test]
fn every_uniform_vector_in_every_mode() {
    let Some(rows) = rows() else { return };
    let (worst, count) = worst(&rows, |row| row.whisker.is_uniform());
    assert_eq!(count, 125);
    for (group, errors) in &worst {
        // The last five rows carry 1e-12 of an ODE solver; printed inputs of 16 digits limit the inverse modes near a fold.
        let limit = if group.starts_with("force") { 1e-11 } else { 1e-10 };
        for e in errors {
            assert!(*e < limit, "{group}: {e:e}");
        }
    }
}

#[test]
fn every_tapered_curved_and_elastically_held_vector_in_every_mode() {
    let Some(rows) = rows() else { return };
    let (worst, count) = worst(&rows, |row| !row.whisker.is_uniform());
    assert_eq!(count, 25);
    for (group, errors) in &worst {
        let limit = if group.starts_with("force") { 1e-10 } else { 1e-9 };
        for e in errors {
            assert!(*e < limit, "{group}: {e:e}");
        }
    }
}
