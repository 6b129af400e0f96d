//! The table of contact points: the closed form's column to the digit, ours on the same five distances, simulated.

use super::report::line;
use super::{Cell, Section, Table};
use crate::Result;
use crate::beam::{Load, SmallAngle, Whisker, point_mode};
use crate::figure::chart_plate;
use crate::plane::{Pose2, Vec2};
use crate::tasks::batch;
use crate::tasks::contact::{ContactReading, fixed_point};
use crate::world::MomentNoise;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A row of the paper's table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    /// True distance (mm).
    pub distance: f64,
    /// Moment (mN m).
    pub moment: f64,
    /// The paper's estimate (mm) and its error (%).
    pub paper: [f64; 2],
    /// The closed form's estimate (mm) and its error (%).
    pub closed_form: [f64; 2],
}

/// The paper's table.
pub const CASES: [Case; 5] = [
    Case { distance: 70.0, moment: 0.19, paper: [71.5, 2.1], closed_form: [67.5, 3.5] },
    Case { distance: 65.0, moment: 0.20, paper: [65.4, 0.6], closed_form: [65.8, 1.3] },
    Case { distance: 55.0, moment: 0.28, paper: [55.8, 1.4], closed_form: [55.6, 1.1] },
    Case { distance: 45.0, moment: 0.42, paper: [44.5, 1.1], closed_form: [45.4, 0.9] },
    Case { distance: 35.0, moment: 0.63, paper: [34.9, 0.3], closed_form: [37.1, 5.9] },
];

/// Base step (m), speed of the stage (m/s), rows a second (Hz).
const STEP: f64 = 1e-3;
const SPEED: f64 = 5e-3;
const RATE: f64 = 300.0;
/// Errors of a reading, independent from row to row: the paper's 5 %, and 2 µN m well above the sensor's resolution.
const NOISE: MomentNoise = MomentNoise { moment_relative: 0.05, moment_absolute: 2e-6 };
/// Bound on the gain error of a trial, which all its readings share.
const GAIN: f64 = 0.01;
/// Where the search starts (m): in the middle of the whisker.
const START: Vec2 = Vec2::new(0.05, 0.0);

/// One simulated trial: ours and the closed form's distance (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// From all readings.
    pub ours: f64,
    /// From the last reading alone.
    pub closed_form: f64,
}

/// Presses the paper's whisker against a peg at `distance` (m) while the base moves by `steps` mm, with errors from `seed`.
///
/// Readings come from the exact shape with the side on the peg; both coordinates of the peg are unknown to the estimate.
/// A distance is not a number where nothing is found.
#[must_use]
pub fn trial(distance: f64, steps: usize, seed: u64) -> Trial {
    let mut dice = ChaCha8Rng::seed_from_u64(seed);
    let whisker = Whisker::default();
    let gain = 1.0 + GAIN * dice.random_range(-1.0..=1.0);
    let rows = (steps as f64 * STEP / SPEED * RATE).round() as usize;
    let mut readings = Vec::with_capacity(rows);
    for row in 1..=rows {
        let base = Pose2::new(0.0, -SPEED / RATE * row as f64, 0.0);
        let place = base.inverse_transform_point(Vec2::new(distance, 0.0));
        let bends = point_mode(&whisker, place, Load::Normal).unwrap_or_default();
        let Some(exact) = bends.first().map(|bend| gain * bend.moment) else { continue };
        let bound = NOISE.moment_relative * exact.abs() + NOISE.moment_absolute;
        let moment = exact + bound * dice.random_range(-1.0..=1.0);
        readings.push(ContactReading {
            t: row as f64 / RATE,
            whisker,
            odom_from_whisker: base,
            moment,
            noise: NOISE,
            count: 1,
        });
    }
    let ours = fixed_point(&readings, START).map_or(f64::NAN, |point| point.position.x);
    let last = readings.last().map_or(0.0, |reading| reading.moment);
    let closed = SmallAngle::from_moment_and_deflection(whisker.flexural_rigidity, last, steps as f64 * STEP);
    Trial { ours, closed_form: closed.map_or(f64::NAN, |bend| bend.s_a) }
}

/// Relative errors (%) of many trials, sorted; what was not found counts as infinite.
struct Errors(Vec<f64>);

impl Errors {
    fn of(trials: &[(f64, Trial)], pick: fn(&Trial) -> f64) -> Self {
        let error = |(distance, trial): &(f64, Trial)| 100.0 * (pick(trial) / distance - 1.0).abs();
        let mut all: Vec<f64> = trials.iter().map(error).map(|e| if e.is_nan() { f64::INFINITY } else { e }).collect();
        all.sort_by(f64::total_cmp);
        Self(all)
    }

    fn mean(&self) -> f64 {
        self.0.iter().sum::<f64>() / self.0.len() as f64
    }

    fn worst(&self) -> f64 {
        self.0.last().copied().unwrap_or(f64::NAN)
    }

    /// The share (%) of trials below each error, for drawing.
    fn curve(&self) -> Vec<(f64, f64)> {
        let count = self.0.len();
        let stride = (count / 100).max(1);
        (0..count).step_by(stride).map(|i| (self.0[i], 100.0 * (i + 1) as f64 / count as f64)).collect()
    }
}

pub(super) fn section(trials: usize, threads: usize) -> Result<Section> {
    let mut section = Section::new("contact-table", "Table: contact points along the whisker");
    let run = |steps: usize| -> Vec<Vec<(f64, Trial)>> {
        let one = |case: usize, seed: usize| {
            let distance = 1e-3 * CASES[case].distance;
            (distance, trial(distance, steps, (1000 * case + seed) as u64))
        };
        let jobs: Vec<(usize, usize)> = (0..CASES.len()).flat_map(|c| (0..trials).map(move |s| (c, s))).collect();
        let all = batch::map(&jobs, threads, |(case, seed)| one(*case, *seed));
        all.chunks(trials).map(<[(f64, Trial)]>::to_vec).collect()
    };
    let (short, long) = (run(1), run(4));
    let table = table(&section, &short, &long);
    section.tables.push(table);
    let all = |of: &[Vec<(f64, Trial)>], pick| Errors::of(&of.concat(), pick);
    let (ours, closed, ours_long) = (all(&short, |t| t.ours), all(&short, |t| t.closed_form), all(&long, |t| t.ours));
    section.show(
        "errors",
        [
            "No figure in the paper: its table has one measurement a distance.",
            "The share of simulated trials below an error.",
            "Trials and noise are ours.",
        ],
        vec![chart_plate(
            "Trials below an error of the distance",
            "error of the distance, %",
            "share of trials, %",
            &[
                line("ours, base moved by 1 mm", "series hue1", ours.curve()),
                line("ours, base moved by 4 mm", "series hue2", ours_long.curve()),
                line("closed form, last reading, 1 mm", "series hue6", closed.curve()),
            ],
        )],
    );
    section.tell("trials", trials as f64, 0, "");
    section.say(
        "The column of the earlier method is nothing else than d = √(3 E I t_y / M(0)); computed from the table's moments it \
         comes out to the digit. The readings behind the paper's own column are not public, so ours are simulated: \
         {contact-table.trials} trials a distance, 300 readings a second at 5 mm/s, errors of up to 5 % and 2 µN m, \
         independent, and a gain error of up to 1 % that a whole trial shares.",
    );
    let count = CASES.len() as f64;
    let mean = |pick: fn(&Case) -> f64| CASES.iter().map(pick).sum::<f64>() / count;
    let most = |pick: fn(&Case) -> f64| CASES.iter().map(pick).fold(0.0, f64::max);
    section.compare(
        "Our column: mean error, base moved by 1 mm",
        "ours.mean",
        (mean(|c| c.paper[1]), ours.mean()),
        (2, "%"),
        "Theirs measured, ours simulated. We fit all readings of the step at once, they intersect pairs.",
    );
    section.compare(
        "Our column: worst error, base moved by 1 mm",
        "ours.worst",
        (most(|c| c.paper[1]), ours.worst()),
        (2, "%"),
        "Theirs is the worst of five, ours of all trials; the gain error limits it.",
    );
    section.find(
        "The same, base moved by 4 mm: worst error",
        "ours.long_worst",
        "1 mm only",
        (ours_long.worst(), 2, "%"),
        "A longer step tells distance and gain apart better.",
    );
    section.compare(
        "Closed form: mean error",
        "closed_form.mean",
        (mean(|c| c.closed_form[1]), closed.mean()),
        (2, "%"),
        "One reading, with its 5 %, decides.",
    );
    Ok(section)
}

fn table(section: &Section, short: &[Vec<(f64, Trial)>], long: &[Vec<(f64, Trial)>]) -> Table {
    let rigidity = Whisker::default().flexural_rigidity;
    let row = |(index, case): (usize, &Case)| -> Vec<Cell> {
        let number = |name: &str, value: f64, digits: usize, unit| {
            Cell::Number(section.named(&format!("{:.0}.{name}", case.distance), value, digits, unit))
        };
        let closed = SmallAngle::from_moment_and_deflection(rigidity, 1e-3 * case.moment, STEP);
        let exact =
            point_mode(&Whisker::default(), Vec2::new(1e-3 * case.distance, STEP), Load::Normal).unwrap_or_default();
        let (ours, ours_long) = (Errors::of(&short[index], |t| t.ours), Errors::of(&long[index], |t| t.ours));
        let mean = short[index].iter().map(|(_, t)| 1e3 * t.ours).sum::<f64>() / short[index].len() as f64;
        vec![
            number("distance", case.distance, 0, "mm"),
            number("moment.paper", case.moment, 2, "mN m"),
            number("moment.exact", exact.first().map_or(f64::NAN, |b| 1e3 * b.moment), 3, "mN m"),
            number("closed_form.paper", case.closed_form[0], 1, "mm"),
            number("closed_form.ours", closed.map_or(f64::NAN, |b| 1e3 * b.s_a), 1, "mm"),
            number("paper", case.paper[0], 1, "mm"),
            number("paper_error", case.paper[1], 1, "%"),
            number("ours", mean, 2, "mm"),
            number("ours_error", ours.mean(), 2, "%"),
            number("ours_worst", ours.worst(), 2, "%"),
            number("ours_long_error", ours_long.mean(), 2, "%"),
        ]
    };
    let head = [
        "true distance, mm",
        "M(0) in the paper, mN m",
        "M(0) exact for 1 mm, mN m",
        "closed form, paper, mm",
        "closed form, ours, mm",
        "paper's method, mm",
        "its error, %",
        "ours, mean, mm",
        "ours, mean error, %",
        "ours, worst, %",
        "ours over 4 mm, mean error, %",
    ];
    Table {
        key: "contact-table",
        title: "Table “contactResults”: contact distance from base steps of 1 mm".into(),
        head: head.map(str::to_owned).to_vec(),
        rows: CASES.iter().enumerate().map(row).collect(),
    }
}
