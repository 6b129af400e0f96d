//! How far `contact` is off, and whether it says so: scenarios, random sweeps and sweeps of another simulator.
//!
//! `cargo run --release --example contact_traces -- [TRIALS] [FIRST_SEED] [--steps] [--turn RAD]`. Random sweeps are those of the soundness
//! tests (arenas with posts, boxes, thin walls) without friction, their odometry exact, their moments read with independent
//! uniform errors within the declared bounds. `--steps` prints every step of each sweep as well,
//! `--turn` says how much walls turn (rad per root of a metre).

#![allow(dead_code, reason = "what the tests share is more than is used here")]

#[path = "../../tests/data/random_sweep.rs"]
mod random_sweep;
mod tally;

use random_sweep::random_sweep;
use std::path::Path;
use tally::{Tally, True};
use vibrissa::config::ContactOptions;
use vibrissa::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
use vibrissa::io::read_tum;
use vibrissa::plane::Vec2;
use vibrissa::sim::Scenario;
use vibrissa::sim::{Part, Touch};
use vibrissa::tasks::contact::{ContactReport, contacts};
use vibrissa::world::{MomentNoise, MountedWhisker, Robot};
use vibrissa::{Error, Result};

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let show = arguments.iter().any(|a| a == "--steps");
    let turn = arguments.iter().skip_while(|a| *a != "--turn").nth(1).and_then(|a| a.parse().ok());
    let default = ContactOptions::default();
    let options = ContactOptions { turn: turn.unwrap_or(default.turn), ..default };
    let mut numbers = arguments.iter().map_while(|a| a.parse::<u64>().ok());
    let (trials, first) = (numbers.next().unwrap_or(200), numbers.next().unwrap_or(1));
    println!("{}", Tally::HEAD);
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for name in ["side_contact", "pipe", "obstacle_sweep"] {
        let tally = scenario(&root.join(format!("../../scenarios/{name}.toml")), &options, show)?;
        println!("{}", tally.row(name));
    }
    for folder in
        std::env::var_os("VIBRISSA_SWEEPS").into_iter().chain([root.join("../../../shared/sweeps").into()]).take(1)
    {
        given(Path::new(&folder), &options, show)?;
    }
    if trials > 0 {
        random(trials, first, &options, show)?;
    }
    Ok(())
}

/// A scenario's sweep: its report beside its contacts.
fn scenario(path: &Path, options: &ContactOptions, show: bool) -> Result<Tally> {
    let scenario = Scenario::read(path)?;
    let simulation = scenario.simulate()?;
    let mut log = simulation.recording.log;
    for (row, index) in log.rows.iter_mut().zip(&simulation.recording.rows) {
        row.odom_from_robot = scenario.path[*index].map_from_robot;
    }
    let report = contacts(&log, &scenario.robot, options)?;
    let mut tally = Tally::default();
    tally.add(&report, &truths(&simulation.sweep.contacts), show);
    Ok(tally)
}

fn truths(touches: &[Touch]) -> Vec<True> {
    let one = |t: &Touch| True { t: t.t, whisker: t.whisker, position: t.position, side: t.part == Part::Side };
    touches.iter().map(one).collect()
}

/// Sweeps of an independent rod, with the tip of every row.
fn given(folder: &Path, options: &ContactOptions, show: bool) -> Result<()> {
    if !folder.is_dir() {
        println!("skipped: no folder with sweeps at {}; set VIBRISSA_SWEEPS", folder.display());
        return Ok(());
    }
    let noise = MomentNoise { moment_relative: 0.05, moment_absolute: 1e-6 };
    let robot = Robot { whiskers: vec![MountedWhisker { noise, ..MountedWhisker::default() }], ..Robot::default() };
    let mut all = Tally::default();
    for group in ["bays", "obstacle", "rough0", "square"] {
        for number in 0..4 {
            let name = format!("{group}-{number:02}");
            let Ok(mut log) = vibrissa::read_log(folder.join(format!("{name}.csv"))) else { continue };
            let truth = read_tum(folder.join(format!("{name}.truth.tum")))?;
            for (row, pose) in log.rows.iter_mut().zip(&truth) {
                row.odom_from_robot = pose.map_from_robot;
            }
            let text = std::fs::read_to_string(folder.join(format!("{name}.contacts.csv")))
                .map_err(|error| Error::data(format!("cannot read the contacts of {name} ({error})")))?;
            let number = |line: &str| line.split(',').filter_map(|cell| cell.parse().ok()).collect::<Vec<f64>>();
            let tips = text.lines().skip(1).map(number).filter(|cells| cells.len() == 3);
            let tips = tips.map(|c| True { t: c[0], whisker: 0, position: Vec2::new(c[1], c[2]), side: false });
            let report = contacts(&log, &robot, options)?;
            let mut tally = Tally::default();
            tally.add(&report, &tips.collect::<Vec<True>>(), show);
            println!("{}", tally.row(&name));
            all.join(tally);
        }
    }
    println!("{}", all.row("given sweeps"));
    Ok(())
}

/// Random sweeps without friction, whether or not sides touch.
fn random(trials: u64, first: u64, options: &ContactOptions, show: bool) -> Result<()> {
    let [mut tips, mut sides] = [Tally::default(), Tally::default()];
    let (mut seed, mut done) = (first, 0);
    while done < trials {
        let number = seed;
        seed += 1;
        let Some(trial) = random_sweep(number).filter(|t| t.robot.whiskers[0].friction <= 0.0) else { continue };
        done += 1;
        let mut draw = random_sweep::random::Random(number);
        let whisker = &trial.robot.whiskers[0];
        let mut exact = vec![0.0; trial.path.len()];
        for touch in &trial.touches {
            let base = trial.path[touch.row].compose(whisker.robot_from_whisker);
            exact[touch.row] += (touch.position - base.position()).cross(touch.force);
        }
        let noise = whisker.noise;
        let row = |(k, (pose, exact)): (usize, (&_, &f64))| LogRow {
            t: trial.log.rows[k].t,
            odom_from_robot: *pose,
            readings: vec![exact + draw.signed(0.95) * (noise.moment_relative * exact.abs() + noise.moment_absolute)],
            heading: None,
            line: k + 2,
        };
        let rows = trial.path.iter().zip(&exact).enumerate().map(row).collect();
        let channels = vec![Channel { whisker: String::new(), quantity: Quantity::Moment }];
        let log = SensorLog { channels, rows, ..SensorLog::default() };
        let report: ContactReport = contacts(&log, &trial.robot, options)?;
        let truths = truths(&trial.touches);
        let mut tally = Tally::default();
        if show {
            println!("seed {number}");
        }
        tally.add(&report, &truths, show);
        if show || tally.worst() > 2e-3 {
            println!("{}", tally.row(&format!("seed {number}")));
        }
        if truths.iter().any(|t| t.side) { sides.join(tally) } else { tips.join(tally) }
    }
    println!("{}", tips.row("random, tips alone"));
    println!("{}", sides.row("random, with sides"));
    tips.join(sides);
    println!("{}", tips.row("random, all"));
    Ok(())
}
