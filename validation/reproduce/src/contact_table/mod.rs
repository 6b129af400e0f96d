//! The table of contact points: the closed form's column to the digit, ours on the same five distances, simulated.

mod bound;
mod chain;

pub use bound::{bound, chance_of_all_below};
pub use chain::{Chain, Experiment, Gain, Law, Outcome};

use super::report::line;
use super::{Cell, Section, Table};
use chain::STEP;
use vibrissa::Result;
use vibrissa::beam::{Load, SmallAngle, Whisker, point_mode};
use vibrissa::figure::chart_plate;
use vibrissa::plane::Vec2;
use vibrissa::tasks::batch;

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

/// Relative errors (%) of many trials, sorted; what was not found counts as infinite.
struct Errors(Vec<f64>);

impl Errors {
    fn of(outcomes: &[Outcome], pick: fn(&Outcome) -> f64) -> Self {
        let mut all: Vec<f64> = outcomes.iter().map(|outcome| 100.0 * pick(outcome).abs()).collect();
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

/// The same experiment at each of the table's distances, `trials` of each, by distance.
#[must_use]
pub fn trials_of(chain: &Chain, experiment: Experiment, trials: usize, threads: usize) -> Vec<Vec<Outcome>> {
    let jobs: Vec<(usize, usize)> =
        (0..CASES.len()).flat_map(|case| (0..trials).map(move |seed| (case, seed))).collect();
    let one = |&(case, seed): &(usize, usize)| {
        chain.trial(experiment, 1e-3 * CASES[case].distance, (1000 * case + seed) as u64, seed)
    };
    batch::map(&jobs, threads, one).chunks(trials.max(1)).map(<[Outcome]>::to_vec).collect()
}

pub(super) fn section(trials: usize, threads: usize) -> Result<Section> {
    let mut section = Section::new("contact-table", "Table: contact points along the whisker");
    let chain = Chain::new(trials, threads)?;
    let run = |steps: usize| {
        trials_of(&chain, Experiment { steps, gain: Gain::Calibrated, law: Law::Uniform }, trials, threads)
    };
    let (short, long) = (run(1), run(4));
    let table = table(&section, &short, &long);
    section.tables.push(table);
    let all = |of: &[Vec<Outcome>], pick| Errors::of(&of.concat(), pick);
    let (ours, closed, ours_long) =
        (all(&short, |t| t.contact), all(&short, |t| t.closed_form), all(&long, |t| t.contact));
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
         {contact-table.trials} trials a distance, each with a sensor of its own that 1000 labelled contacts calibrated, 300 \
         readings a second at 5 mm/s, independent errors of up to 5 % and 2 µN m, places rounded to 10 µm. The answer is that \
         of `vibrissa contact` to the log.",
    );
    let count = CASES.len() as f64;
    let mean = |pick: fn(&Case) -> f64| CASES.iter().map(pick).sum::<f64>() / count;
    let most = |pick: fn(&Case) -> f64| CASES.iter().map(pick).fold(0.0, f64::max);
    section.compare(
        "Our column: mean error, base moved by 1 mm",
        "ours.mean",
        (mean(|c| c.paper[1]), ours.mean()),
        (2, "%"),
        "Theirs measured, ours simulated. All readings of the step count at once; they intersect pairs.",
    );
    section.compare(
        "Our column: worst error, base moved by 1 mm",
        "ours.worst",
        (most(|c| c.paper[1]), ours.worst()),
        (2, "%"),
        "Theirs is the worst of five, ours of all trials.",
    );
    section.find(
        "The same, base moved by 4 mm: worst error",
        "ours.long_worst",
        "1 mm only",
        (ours_long.worst(), 2, "%"),
        "A longer step tells distance and gain apart better.",
    );
    let cramer_rao = CASES.map(|case| 100.0 * bound(1e-3 * case.distance, 1, 0.0)).iter().sum::<f64>() / count;
    section.find(
        "Bound of Cramér and Rao, mean of the five standard deviations, 1 mm",
        "ours.bound",
        "none given",
        (cramer_rao, 2, "%"),
        "For normal errors of the same variance and an exact calibration. Errors that fill a bound may be smaller.",
    );
    let told: f64 =
        short.concat().iter().map(|t| (t.contact / t.std).powi(2)).sum::<f64>() / short.concat().len() as f64;
    section.find(
        "Root of the mean square of error over told standard deviation, 1 mm",
        "ours.told",
        "no deviation is told",
        (told.sqrt(), 2, ""),
        "1 where deviations are told rightly, less where they are told too large. The readings' errors are those of `vibrissa simulate`.",
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

fn table(section: &Section, short: &[Vec<Outcome>], long: &[Vec<Outcome>]) -> Table {
    let rigidity = Whisker::default().flexural_rigidity;
    let row = |(index, case): (usize, &Case)| -> Vec<Cell> {
        let number = |name: &str, value: f64, digits: usize, unit| {
            Cell::Number(section.named(&format!("{:.0}.{name}", case.distance), value, digits, unit))
        };
        let closed = SmallAngle::from_moment_and_deflection(rigidity, 1e-3 * case.moment, STEP);
        let exact =
            point_mode(&Whisker::default(), Vec2::new(1e-3 * case.distance, STEP), Load::Normal).unwrap_or_default();
        let (ours, ours_long) = (Errors::of(&short[index], |t| t.contact), Errors::of(&long[index], |t| t.contact));
        let ratio = short[index].iter().map(|t| 1.0 + t.contact).sum::<f64>() / short[index].len() as f64;
        let mean = case.distance * ratio;
        vec![
            number("distance", case.distance, 0, "mm"),
            number("moment.paper", case.moment, 2, "mN m"),
            number("moment.exact", exact.first().map_or(f64::NAN, |b| 1e3 * b.moment), 3, "mN m"),
            number("closed_form.paper", case.closed_form[0], 1, "mm"),
            number("closed_form.ours", closed.map_or(f64::NAN, |b| 1e3 * b.s_a), 1, "mm"),
            number("closed_form.paper_error", case.closed_form[1], 1, "%"),
            number(
                "closed_form.ours_error",
                closed.map_or(f64::NAN, |b| 100.0 * (1e3 * b.s_a / case.distance - 1.0).abs()),
                1,
                "%",
            ),
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
        "its error in the paper (SOTA), %",
        "its error, ours, %",
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
