//! The simulator against sweeps by an independent one: a discrete rod whose energy is minimised.

#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout, reason = "a test that cannot go on must fail")]

use std::fs;
use std::path::{Path, PathBuf};
use vibrissa::flow::trajectory::read_tum;
use vibrissa::plane::Vec2;
use vibrissa::tasks::{SweepNoise, simulate_tip_sweep};
use vibrissa::world::{Map, Robot};

fn shared() -> Option<PathBuf> {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/sweeps"));
    if folder.is_dir() {
        return Some(folder.to_path_buf());
    }
    println!("skipped: no shared folder at {}", folder.display());
    None
}

/// The numbers of a CSV file, without its header.
fn rows(path: &Path) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(path).unwrap();
    text.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
}

fn sorted(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    values
}

#[test]
fn report() {
    let Some(folder) = shared() else { return };
    for name in [
        "bays-00",
        "bays-01",
        "bays-02",
        "obstacle-00",
        "obstacle-01",
        "obstacle-02",
        "rough0-01",
        "rough0-02",
        "rough0-03",
        "square-00",
        "square-01",
        "square-02",
    ] {
        let map = Map::read(folder.join(format!("{}.geojson", name.split('-').next().unwrap()))).unwrap();
        let path = read_tum(folder.join(format!("{name}.truth.tum"))).unwrap();
        let sweep = match simulate_tip_sweep(&map, &Robot::default(), &path, &SweepNoise::none()) {
            Ok(s) => s,
            Err(e) => {
                println!("{name}: {e}");
                continue;
            }
        };
        let exact = rows(&folder.join(format!("{name}.exact.csv")));
        let places = rows(&folder.join(format!("{name}.contacts.csv")));
        let errors: Vec<f64> = exact.iter().zip(&sweep.exact_moments).map(|(e, m)| (m[0] - e[1]).abs()).collect();
        let rel: Vec<f64> = exact
            .iter()
            .zip(&sweep.exact_moments)
            .filter(|(e, _)| e[1].abs() > 1e-4)
            .map(|(e, m)| ((m[0] - e[1]) / e[1]).abs())
            .collect();
        let tips: Vec<f64> = places
            .iter()
            .filter_map(|p| {
                let c = sweep.contacts.iter().find(|c| (c.t - p[0]).abs() < 1e-4)?;
                Some(c.position.distance(Vec2::new(p[1], p[2])))
            })
            .collect();
        let (e, r, p) = (sorted(errors.clone()), sorted(rel), sorted(tips));
        let worst = (0..errors.len()).max_by(|&a, &b| errors[a].total_cmp(&errors[b])).unwrap();
        println!(
            "{name}: moment median {:.2e} p95 {:.2e} max {:.2e} Nm (row {worst} of {}: ref {:.3e} ours {:.3e}); rel median {:.2e} p95 {:.2e} max {:.2e}; tip n {} median {:.1e} max {:.1e} m",
            e[e.len() / 2],
            e[e.len() * 95 / 100],
            e[e.len() - 1],
            errors.len(),
            exact[worst][1],
            sweep.exact_moments[worst][0],
            r[r.len() / 2],
            r[r.len() * 95 / 100],
            r[r.len() - 1],
            p.len(),
            p[p.len() / 2],
            p[p.len() - 1]
        );
        for ev in &sweep.events {
            println!("    {:.4} {} {}", ev.t, ev.kind, ev.detail);
        }
    }
}
