//! The paper's table of contact points, simulated: pegs at its five distances, base steps of 1 mm, many seeds.
//!
//! Usage: `contact_table [SEEDS] [FIGURE.svg]`

#![allow(clippy::print_stdout, reason = "an example prints")]

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use vibrissa::beam::{Load, SmallAngle, Whisker, point_mode};
use vibrissa::figure::Document;
use vibrissa::plane::{Pose2, Vec2};
use vibrissa::tasks::contact::{ContactReading, fixed_point};
use vibrissa::world::MomentNoise;

/// The table's distances (m), moments (N m), and the error that the paper prints (%).
const CASES: [(f64, f64, f64); 5] =
    [(0.070, 0.19e-3, 2.1), (0.065, 0.20e-3, 0.6), (0.055, 0.28e-3, 1.4), (0.045, 0.42e-3, 1.1), (0.035, 0.63e-3, 0.3)];
/// Errors of a reading: 5 % and 2 µN m, independent from row to row.
const NOISE: MomentNoise = MomentNoise { moment_relative: 0.05, moment_absolute: 2e-6 };
/// Rows a second of the sensor (Hz), speed of the stage (m/s), base step (m).
const RATE: f64 = 300.0;
const SPEED: f64 = 5e-3;
const STEP: f64 = 1e-3;

/// The errors (relative) of one way to measure, over all cases and seeds.
struct Column {
    name: String,
    errors: Vec<Vec<f64>>,
}

impl Column {
    fn row(&self) -> String {
        let mut all: Vec<f64> = self.errors.concat();
        all.sort_by(f64::total_cmp);
        let at = |share: f64| 100.0 * all[((all.len() - 1) as f64 * share).round() as usize];
        let mean = 100.0 * all.iter().sum::<f64>() / all.len() as f64;
        format!("| {} | {mean:.2} | {:.2} | {:.2} | {:.2} | {:.2} |", self.name, at(0.5), at(0.9), at(0.99), at(1.0))
    }

    fn cases(&self) -> String {
        let mean = |errors: &Vec<f64>| 100.0 * errors.iter().sum::<f64>() / errors.len() as f64;
        let worst = |errors: &Vec<f64>| 100.0 * errors.iter().copied().fold(0.0, f64::max);
        let cells: Vec<String> = self.errors.iter().map(|e| format!("{:.2} / {:.2}", mean(e), worst(e))).collect();
        format!("| {} | {} |", self.name, cells.join(" | "))
    }
}

/// The relative error of the contact's distance: a peg at `distance`, the base moved by `steps` mm while it is felt.
///
/// The readings begin with the touch, but that is not told: both coordinates of the peg are unknown.
fn error(distance: f64, steps: usize, gain_bound: f64, dice: &mut ChaCha8Rng) -> (f64, f64) {
    let whisker = Whisker::default();
    let peg = Vec2::new(distance, 0.0);
    let gain = 1.0 + gain_bound * dice.random_range(-1.0..=1.0);
    let rows = (steps as f64 * STEP / SPEED * RATE).round() as usize;
    let mut readings = Vec::new();
    for i in 1..=rows {
        let base = Pose2::new(0.0, -SPEED / RATE * i as f64, 0.0);
        let bend = point_mode(&whisker, base.inverse_transform_point(peg), Load::Normal).unwrap_or_default();
        let Some(exact) = bend.first().map(|b| gain * b.moment) else { continue };
        let bound = NOISE.moment_relative * exact.abs() + NOISE.moment_absolute;
        let moment = exact + bound * dice.random_range(-1.0..=1.0);
        readings.push(ContactReading {
            t: i as f64 / RATE,
            whisker,
            odom_from_whisker: base,
            moment,
            noise: NOISE,
            count: 1,
        });
    }
    let start = Vec2::new(0.05, 0.0);
    let ours = fixed_point(&readings, start).map_or(f64::INFINITY, |p| (p.position.x / distance - 1.0).abs());
    let last = readings.last().map_or(0.0, |r| r.moment);
    let theirs = SmallAngle::from_moment_and_deflection(whisker.flexural_rigidity, last, steps as f64 * STEP);
    (ours, theirs.map_or(f64::INFINITY, |b| (b.s_a / distance - 1.0).abs()))
}

fn column(name: &str, steps: usize, gain: f64, seeds: u64, theirs: bool) -> Column {
    let errors = CASES
        .iter()
        .enumerate()
        .map(|(case, (distance, ..))| {
            let one = |seed| error(*distance, steps, gain, &mut ChaCha8Rng::seed_from_u64(1000 * case as u64 + seed));
            (0..seeds).map(one).map(|(o, t)| if theirs { t } else { o }).collect()
        })
        .collect();
    Column { name: name.to_owned(), errors }
}

fn main() {
    let mut args = std::env::args().skip(1);
    let seeds: u64 = args.next().and_then(|n| n.parse().ok()).unwrap_or(200);
    println!("The paper's closed form, from its moments:");
    println!("| p_x (mm) | M0 (mN m) | d = sqrt(3 EI t_y / M0) (mm) |\n| --- | --- | --- |");
    let mut printed = 0.0;
    for (distance, moment, error) in CASES {
        let d = SmallAngle::from_moment_and_deflection(Whisker::default().flexural_rigidity, moment, STEP);
        println!("| {:.0} | {:.2} | {:.1} |", 1e3 * distance, 1e3 * moment, 1e3 * d.map_or(f64::NAN, |d| d.s_a));
        printed += error / CASES.len() as f64;
    }
    println!("\nThe paper's errors: mean {printed:.2} %, worst 2.1 %. Simulated, {seeds} seeds a distance:\n");
    let columns = [
        column("closed form, last reading, 1 mm, gain ±1 %", 1, 0.01, seeds, true),
        column("1 mm, no gain error", 1, 0.0, seeds, false),
        column("1 mm, gain ±1 %", 1, 0.01, seeds, false),
        column("2 mm, gain ±1 %", 2, 0.01, seeds, false),
        column("4 mm, no gain error", 4, 0.0, seeds, false),
        column("4 mm, gain ±1 %", 4, 0.01, seeds, false),
        column("4 mm, gain ±2 %", 4, 0.02, seeds, false),
    ];
    println!("| relative error of the distance (%) | mean | median | 90th | 99th | worst |");
    println!("| --- | --- | --- | --- | --- | --- |");
    columns.iter().for_each(|c| println!("{}", c.row()));
    println!("\n| mean / worst (%) | 70 mm | 65 mm | 55 mm | 45 mm | 35 mm |\n| --- | --- | --- | --- | --- | --- |");
    columns.iter().for_each(|c| println!("{}", c.cases()));
    if let Some(path) = args.next()
        && let Err(error) = std::fs::write(&path, figure(&columns))
    {
        eprintln!("cannot write {path}: {error}");
        std::process::exit(1);
    }
    let main = &columns[5].errors.concat();
    let mean = 100.0 * main.iter().sum::<f64>() / main.len() as f64;
    let worst = 100.0 * main.iter().copied().fold(0.0, f64::max);
    println!("\nheadline: 4 mm in 1 mm steps, gain ±1 %: mean {mean:.2} %, worst {worst:.2} % (paper 1.12 %, 2.1 %)");
}

/// The share of trials below each error, one line for each way to measure.
fn figure(columns: &[Column]) -> String {
    let mut page = Document::new(
        880.0,
        440.0,
        "Error of the contact distance",
        "Share of trials with an error below the one on the axis, for several base motions and gain errors",
    );
    let (left, top, width, height, most) = (60.0, 50.0, 480.0, 320.0, 4.0);
    page.text(20.0, 28.0, "title", "Share of trials below an error of the contact distance");
    page.rectangle((left, top), (width, height), "panel");
    for i in 0..=5 {
        let x = left + width * 0.2 * f64::from(i);
        page.line((x, top + height), (x, top + height + 4.0), "tick");
        page.text(x, top + height + 18.0, "small middle", &format!("{:.1}", 0.2 * most * f64::from(i)));
        let y = top + height * (1.0 - 0.2 * f64::from(i));
        page.line((left - 4.0, y), (left, y), "tick");
        page.text(left - 8.0, y + 4.0, "small end", &format!("{}", 20 * i));
    }
    page.text(left + 0.5 * width, top + height + 38.0, "small middle", "error of the distance (%)");
    page.text(left, top - 6.0, "small", "share (%)");
    let drawn = [(0, "wall"), (1, "path"), (2, "whisker-last"), (5, "truth-mark"), (6, "survivor-tick")];
    for (i, (index, class)) in drawn.into_iter().enumerate() {
        let column = &columns[index];
        let mut all: Vec<f64> = column.errors.concat();
        all.sort_by(f64::total_cmp);
        let place = |k: usize| {
            let x = left + width * (100.0 * all[k] / most).min(1.0);
            (x, top + height * (1.0 - (k + 1) as f64 / all.len() as f64))
        };
        let stride = (all.len() / 80).max(1);
        let ks: Vec<usize> = (0..all.len()).step_by(stride).chain([all.len() - 1]).collect();
        ks.windows(2).for_each(|k| page.line(place(k[0]), place(k[1]), class));
        let y = top + 16.0 + 22.0 * i as f64;
        page.line((left + width + 16.0, y - 4.0), (left + width + 38.0, y - 4.0), class);
        page.text(left + width + 44.0, y, "small", &column.name);
    }
    page.finish()
}
