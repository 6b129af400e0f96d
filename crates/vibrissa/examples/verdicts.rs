//! Whether verdicts can be trusted: the demo's arena under conditions that are and are not as declared.
//!
//! `cargo run --release --example verdicts -- [RUNS] [METHOD]` prints for each condition and method how many runs ended in
//! which verdict, and whether the truth (within 5 mm and 5°) was the one place or among the places; of the possibilistic
//! method, whether its set holds the truth. That method gets every second row and a fifth of its last work, which costs tightness
//! only; logs with false readings a second time with `tolerate` at twice their expected share of 5 %.

#[path = "../tests/data/random.rs"]
mod random;

use random::Random;
use vibrissa::config::PossibilisticOptions;
use vibrissa::flow::pose::{Localization, Status};
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::plane::{Curve, Pose2, Vec2, wrap_angle};
use vibrissa::sets::StateBox;
use vibrissa::sim::Sweep;
use vibrissa::tasks::demo;
use vibrissa::world::{Boundary, Map, Robot, Role};
use vibrissa::{Error, Method, Result, localize};

/// How near a place is to the truth to be the true one (m, rad).
const NEAR: [f64; 2] = [5e-3, 0.09];

/// The condition in which some readings are of no use.
const FALSE_READINGS: &str = "5 % false readings";

/// What is done to a clean log; gives the truth at its end.
type Change = fn(&mut SensorLog, &Sweep, &mut Random) -> Result<Pose2>;

/// The conditions: name, whether the map is the right one, and what is done.
const CONDITIONS: [(&str, bool, Change); 6] = [
    ("as declared", true, |_, sweep, _| Ok(end(sweep))),
    ("wrong map", false, |_, sweep, _| Ok(end(sweep))),
    ("gain 20 % off", true, |log, sweep, draw| {
        let gain = 1.0 + 0.2 * draw.sign();
        log.rows.iter_mut().for_each(|row| row.readings[0] *= gain);
        Ok(end(sweep))
    }),
    ("carried away in mid-log", true, carried),
    (FALSE_READINGS, true, |log, sweep, draw| {
        log.rows.iter_mut().filter(|_| draw.unit() < 0.05).for_each(|row| row.readings[0] = 0.0);
        Ok(end(sweep))
    }),
    ("no contact", true, |log, sweep, _| {
        log.rows.iter_mut().for_each(|row| row.readings[0] = 0.0);
        Ok(end(sweep))
    }),
];

fn end(sweep: &Sweep) -> Pose2 {
    sweep.truth.last().map_or(Pose2::IDENTITY, |t| t.map_from_robot)
}

/// Goes back to an earlier part of the sweep without the odometry noticing.
fn carried(log: &mut SensorLog, sweep: &Sweep, draw: &mut Random) -> Result<Pose2> {
    let count = log.rows.len();
    let part = |lo: f64, hi: f64, draw: &mut Random| (draw.between(lo, hi) * count as f64) as usize;
    let (until, from) = (part(0.5, 0.9, draw), part(0.0, 0.25, draw));
    let again = demo::sweep(1000 + from as u64)?.log;
    let (last, start) = (log.rows[until].clone(), log.rows[from].clone());
    log.rows.truncate(until + 1);
    for row in &again.rows[from + 1..] {
        let mut row = row.clone();
        row.odom_from_robot = last.odom_from_robot.compose(start.odom_from_robot.between(row.odom_from_robot));
        row.t += last.t - start.t;
        log.rows.push(row);
    }
    Ok(end(sweep))
}

/// An arena of the same size with other bays.
fn elsewhere(draw: &mut Random) -> Result<Map> {
    let waves: Vec<(f64, f64, f64)> =
        (2..8).map(|k| (f64::from(k), draw.signed(0.02) / f64::from(k).sqrt(), draw.signed(3.2))).collect();
    let point = |i: u32| {
        let angle = f64::from(i) / 720.0 * core::f64::consts::TAU;
        let r = 0.25 + waves.iter().map(|(k, a, phase)| a * (k * angle + phase).sin()).sum::<f64>();
        r * Vec2::from_angle(angle)
    };
    let points: Vec<Vec2> = (0..720).map(point).collect();
    let curve = Curve::polyline(&points, true).ok_or_else(|| Error::data("a degenerate arena"))?;
    Map::new(vec![Boundary::new(Role::Arena, curve, None)?])
}

/// The column of an answer: localized right, wrong, ambiguous with the truth, without, inconsistent, no contact.
fn column(answer: &Localization, truth: Pose2, right_map: bool) -> usize {
    let near = |p: Pose2| {
        right_map
            && p.position().distance(truth.position()) < NEAR[0]
            && wrap_angle(p.theta - truth.theta).abs() < NEAR[1]
    };
    let inside = |b: &StateBox| {
        let middle = 0.5 * (b.theta.lo() + b.theta.hi());
        b.x.contains(truth.x) && b.y.contains(truth.y) && b.theta.contains(middle + wrap_angle(truth.theta - middle))
    };
    let held = if answer.encloses {
        right_map && answer.states.iter().any(inside)
    } else {
        answer.hypotheses.iter().any(|h| near(h.pose))
    };
    match answer.status {
        Status::Localized if answer.estimate.is_some_and(near) => 0,
        Status::Localized => 1,
        Status::Ambiguous if held => 2,
        Status::Ambiguous => 3,
        Status::Inconsistent => 4,
        Status::NoContact => 5,
    }
}

/// How many readings of a log may be false where that is allowed for: twice the share drawn.
const DOUBTFUL: f64 = 0.1;

/// The method with the options that it has here, and every which row it gets.
fn options(method: Method, rows: usize, tolerate: bool) -> (Method, usize) {
    let Method::Possibilistic(options) = method else { return (method, 1) };
    let every = 2;
    let most = (DOUBTFUL * (rows / every) as f64) as usize;
    let tolerate = if tolerate { most } else { 0 };
    (Method::Possibilistic(PossibilisticOptions { last_work: 1_000_000, tolerate, ..options }), every)
}

/// How the runs of one method in one condition end, by column.
fn tried(method: Method, (right_map, change): (bool, Change), tolerate: bool, runs: u64) -> Result<[u64; 6]> {
    let arena = demo::arena()?;
    let mut counts = [0; 6];
    for seed in 1..=runs {
        let mut draw = Random(seed);
        let sweep = demo::sweep(seed)?;
        let mut log = sweep.log.clone();
        let truth = change(&mut log, &sweep, &mut draw)?;
        let other = if right_map { None } else { Some(elsewhere(&mut draw)?) };
        let (options, every) = options(method, log.rows.len(), tolerate);
        // The last row stays: the truth is meant there.
        let rows = log.rows.iter().rev().step_by(every).rev();
        let log = SensorLog { rows: rows.cloned().collect(), ..log };
        let answer = localize(&log, other.as_ref().unwrap_or(&arena), &Robot::default(), &options, &mut |_| {})?;
        counts[column(&answer, truth, right_map)] += 1;
    }
    Ok(counts)
}

fn main() -> Result<()> {
    let runs = std::env::args().nth(1).and_then(|a| a.parse().ok()).unwrap_or(20);
    let only = std::env::args().nth(2);
    println!(
        "{:14} {:24} {:>10} {:>8} {:>11} {:>10} {:>13} {:>11}",
        "method", "condition", "localized", "wrong", "amb. with", "without", "inconsistent", "no contact"
    );
    for method in Method::all().into_iter().rev() {
        if only.as_ref().is_some_and(|only| only != method.name()) {
            continue;
        }
        for (name, right_map, change) in CONDITIONS {
            let relaxed = matches!(method, Method::Possibilistic(_)) && name == FALSE_READINGS;
            for tolerate in [false, true].into_iter().filter(|tolerate| relaxed || !tolerate) {
                let [a, b, c, d, e, f] = tried(method, (right_map, change), tolerate, runs)?;
                let name = if tolerate { "the same, 10 % tolerated" } else { name };
                println!("{method:14} {name:24} {a:>10} {b:>8} {c:>11} {d:>10} {e:>13} {f:>11}");
            }
        }
    }
    Ok(())
}
