//! The simulator against sweeps by an independent one: a discrete rod of 90 links whose energy is minimised.
//!
//! The rod's moments are right to 6e-5 of a reading (its links), its paths are rounded to 0.1 µm. The two differ by
//! more at five rows only: in the last row before a snap, where the equilibrium turns infinitely sensitive, and where the
//! tip stands at a vertex of the polygon. There our own discrete rod, which shares nothing with either, converges to us.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/shared.rs"]
mod shared;

use shared::shared;
use std::fs;
use std::path::Path;
use vibrissa::io::read_tum;
use vibrissa::plane::Vec2;
use vibrissa::sim::{SimulateOptions, Solver, simulate};
use vibrissa::sim::{Sweep, SweepNoise, simulate_tip_sweep};
use vibrissa::world::Robot;

/// Every sweep, how many of its rows may differ by more than 0.1 % and 1 µN m, and what happens in it.
const SWEEPS: [(&str, usize, &[&str]); 12] = [
    ("bays-00", 1, &["onset", "snap", "onset"]),
    ("bays-01", 1, &["onset"]),
    ("bays-02", 0, &["onset"]),
    ("obstacle-00", 0, &["onset"]),
    ("obstacle-01", 0, &["onset"]),
    ("obstacle-02", 0, &["onset"]),
    ("rough0-01", 2, &["onset"]),
    ("rough0-02", 0, &["onset"]),
    ("rough0-03", 0, &["onset"]),
    ("square-00", 1, &["onset", "snap"]),
    ("square-01", 0, &["onset", "lift_off", "onset", "lift_off", "onset"]),
    ("square-02", 0, &["onset"]),
];

/// The numbers of a CSV file, without its header.
fn rows(path: &Path) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(path).unwrap();
    text.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
}

fn sorted(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    values
}

fn simulated(folder: &Path, name: &str) -> Sweep {
    let map = vibrissa::read_map(folder.join(format!("{}.geojson", name.split('-').next().unwrap()))).unwrap();
    let path = read_tum(folder.join(format!("{name}.truth.tum"))).unwrap();
    simulate_tip_sweep(&map, &Robot::default(), &path, &SweepNoise::none()).unwrap()
}

#[test]
fn moments_agree_with_the_discrete_rod() {
    let Some(folder) = shared("sweeps") else { return };
    for (name, odd_rows, happens) in SWEEPS {
        let sweep = simulated(&folder, name);
        let exact = rows(&folder.join(format!("{name}.exact.csv")));
        assert_eq!(exact.len(), sweep.exact_moments.len());
        let pairs: Vec<(f64, f64)> = exact.iter().zip(&sweep.exact_moments).map(|(e, m)| (e[1], m[0])).collect();
        let errors: Vec<f64> = pairs.iter().map(|(rod, ours)| (rod - ours).abs()).collect();
        let odd = pairs.iter().filter(|(rod, ours)| (rod - ours).abs() > 1e-6_f64.max(1e-3 * rod.abs())).count();
        let grossly = pairs.iter().filter(|(rod, ours)| (rod - ours).abs() > 5e-3 * rod.abs().max(1e-4)).count();
        let relative = sorted(pairs.iter().filter(|p| p.0.abs() > 1e-4).map(|(r, o)| (o / r - 1.0).abs()).collect());
        let errors = sorted(errors);
        let (median, most, worst) =
            (relative[relative.len() / 2], relative[relative.len() * 95 / 100], relative[relative.len() - 1]);
        println!(
            "{name}: moment off by {:.1e} N m at worst; relative {median:.1e} median, {most:.1e} 95 %, {worst:.1e} worst; {odd} odd rows",
            errors[errors.len() - 1],
        );
        assert!(odd <= odd_rows, "{name}: {odd} rows differ");
        assert_eq!(grossly, 0, "{name}");
        assert!(median < 7e-5 && most < 2e-4, "{name}: {median:e}, {most:e}");
        let events: Vec<&str> = sweep.events.iter().map(|event| event.kind).collect();
        assert_eq!(events, happens, "{name}");
    }
}

#[test]
fn tips_agree_with_the_discrete_rod() {
    let Some(folder) = shared("sweeps") else { return };
    for (name, ..) in SWEEPS {
        let sweep = simulated(&folder, name);
        let places = rows(&folder.join(format!("{name}.contacts.csv")));
        let mut missing = 0;
        let mut errors = Vec::new();
        for place in &places {
            match sweep.contacts.iter().find(|touch| (touch.t - place[0]).abs() < 1e-4) {
                Some(touch) => errors.push(touch.position.distance(Vec2::new(place[1], place[2]))),
                None => missing += 1,
            }
        }
        let errors = sorted(errors);
        let (median, worst) = (errors[errors.len() / 2], errors[errors.len() - 1]);
        println!("{name}: tip off by {median:.1e} m median, {worst:.1e} m worst over {} rows", errors.len());
        assert!(median < 1e-6 && worst < 3e-5, "{name}: {median:e}, {worst:e}");
        // A graze at the very onset may fall to either side of a row.
        assert!(missing <= 1 && sweep.contacts.len().abs_diff(places.len()) <= 1, "{name}: {missing}");
    }
}

/// The rows in which the two simulators differ: next to a snap, and where the tip stands at a vertex of the polygon.
const ODD_ROWS: [(&str, usize); 5] =
    [("bays-00", 151), ("bays-01", 159), ("rough0-01", 64), ("rough0-01", 263), ("square-00", 197)];

#[test]
fn in_the_odd_rows_our_own_discrete_rod_converges_to_the_elastica() {
    let Some(folder) = shared("sweeps") else { return };
    for (name, row) in ODD_ROWS {
        let map = vibrissa::read_map(folder.join(format!("{}.geojson", name.split('-').next().unwrap()))).unwrap();
        let path = read_tum(folder.join(format!("{name}.truth.tum"))).unwrap();
        let moment = |solver, links| {
            let options = SimulateOptions { solver, links, shape_points: 0 };
            let sweep = simulate(&map, &Robot::default(), &path[..=row], &SweepNoise::none(), &options).unwrap();
            sweep.exact_moments[row][0]
        };
        let exact = moment(Solver::Auto, 90);
        let off = [40, 80].map(|links| (moment(Solver::DiscreteRod, links) / exact - 1.0).abs());
        println!("{name} row {row}: {exact}, off by {off:?}");
        assert!(off[1] < 0.35 * off[0] && off[1] < 6e-3, "{name} row {row}: {off:?}");
    }
}
