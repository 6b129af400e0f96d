//! The hot paths: what is prepared, and what is counted.

use std::hint::black_box;
use vibrissa::beam::field::TipField;
use vibrissa::beam::normal::{Branch, by_moment, by_point};
use vibrissa::beam::{Load, Whisker, force_mode};
use vibrissa::config::{DeterministicOptions, PossibilisticOptions, ProbabilisticOptions};
use vibrissa::io::log::to_csv;
use vibrissa::plane::Vec2;
use vibrissa::sim::{SweepNoise, simulate_tip_sweep};
use vibrissa::tasks::demo;
use vibrissa::world::Robot;
use vibrissa::{Method, Result, localize};

type Prepare = fn() -> Result<()>;

const PATHS: [(&str, Prepare); 10] = [
    ("beam: contacts of moments", contacts_of_moments),
    ("beam: loads of contact points", loads_of_points),
    ("beam: shapes of tapered whiskers", tapered),
    ("beam: look-ups in the tip field", look_ups),
    ("map: nearest boundary points", nearest),
    ("log: rows of CSV", rows),
    ("simulate: rows of a sweep", sweep),
    ("localize: deterministic rows", || method(&deterministic(), 150)),
    ("localize: possibilistic rows", || method(&possibilistic(), 45)),
    ("localize: probabilistic rows", || method(&probabilistic(), 150)),
];

pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    PATHS.iter().map(|(name, _)| *name)
}

/// Prepares a path and goes along it once.
pub(crate) fn run(name: &str) -> core::result::Result<(), String> {
    let (_, path) = PATHS.iter().find(|(known, _)| *known == name).ok_or(format!("no path is called {name}"))?;
    path().map_err(|error| error.to_string())
}

/// What is counted; callgrind knows this function by its name.
#[inline(never)]
fn collected(work: &mut dyn FnMut()) {
    work();
}

/// Numbers evenly over an interval.
fn over(lo: f64, hi: f64, count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |k| lo + (hi - lo) * (k as f64 + 0.5) / count as f64)
}

fn contacts_of_moments() -> Result<()> {
    let w = Whisker::default();
    collected(&mut || {
        for moment in over(1e-4, 8e-3, 10_000) {
            black_box(by_moment(w.flexural_rigidity, black_box(moment), w.length, Branch::Least));
        }
    });
    Ok(())
}

fn loads_of_points() -> Result<()> {
    let w = Whisker::default();
    collected(&mut || {
        for y in over(1e-3, 4e-2, 10_000) {
            black_box(by_point(w.flexural_rigidity, w.length, black_box(Vec2::new(0.045, y)), Branch::Least));
        }
    });
    Ok(())
}

fn tapered() -> Result<()> {
    let whisker = Whisker { tip_ratio: 0.3, ..Whisker::default() };
    collected(&mut || {
        for force in over(1e-4, 1e-2, 50) {
            let _ = black_box(force_mode(&whisker, black_box(force), 0.06, Load::Normal));
        }
    });
    Ok(())
}

fn look_ups() -> Result<()> {
    let field = TipField::new(&Whisker::default())?;
    collected(&mut || {
        for tilt in over(-0.7, 0.7, 10_000) {
            black_box(field.at(black_box(tilt), 0.05));
        }
    });
    Ok(())
}

fn nearest() -> Result<()> {
    let arena = demo::arena()?;
    let (bounds, size) = (arena.bounds(), arena.bounds().size());
    collected(&mut || {
        for share in over(0.0, 1.0, 5_000) {
            let place = bounds.min + Vec2::new(size.x * share, size.y * (97.0 * share).fract());
            black_box(arena.nearest(black_box(place)));
        }
    });
    Ok(())
}

fn rows() -> Result<()> {
    let text = to_csv(&demo::sweep(1)?.log);
    collected(&mut || {
        let _ = black_box(vibrissa::io::log::from_csv(black_box(&text), "log.csv"));
    });
    Ok(())
}

fn sweep() -> Result<()> {
    let (arena, path) = (demo::arena()?, demo::path()?);
    let part = &path[..path.len().min(200)];
    collected(&mut || {
        let _ = black_box(simulate_tip_sweep(&arena, &Robot::default(), black_box(part), &SweepNoise::seeded(1)));
    });
    Ok(())
}

fn deterministic() -> Method {
    Method::Deterministic(DeterministicOptions { boundary_spacing: 1e-2, ..DeterministicOptions::default() })
}

fn possibilistic() -> Method {
    Method::Possibilistic(PossibilisticOptions { work: 20, last_work: 0, ..PossibilisticOptions::default() })
}

fn probabilistic() -> Method {
    Method::Probabilistic(ProbabilisticOptions {
        seed_spacing: 0.02,
        seed_turn: 0.2,
        ..ProbabilisticOptions::default()
    })
}

/// So many rows of the demo from where the whisker touches, with coarse options: what counts is the kind of work.
fn method(method: &Method, rows: usize) -> Result<()> {
    let (arena, mut log) = (demo::arena()?, demo::sweep(1)?.log);
    let touched = log.rows.iter().position(|row| row.readings[0].abs() > 2e-4).unwrap_or(0);
    log.rows.drain(..touched);
    log.rows.truncate(rows);
    let robot = Robot::default();
    let mut updates = 0;
    collected(&mut || {
        updates = localize(&log, &arena, &robot, method, &mut |_| {}).map_or(0, |answer| answer.steps.len());
    });
    println!("{updates} updates");
    Ok(())
}
