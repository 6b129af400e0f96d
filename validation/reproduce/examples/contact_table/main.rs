//! The paper's table of contact points, simulated: pegs at its five distances, base steps of 1 mm, many seeds.
//!
//! Usage: `contact_table [SEEDS] [FIGURE.svg]`

#![allow(clippy::print_stdout, reason = "an example prints")]

use vibrissa::beam::{SmallAngle, Whisker};
use vibrissa::figure::Document;
use vibrissa::tasks::batch::all_cores;
use vibrissa_reproduce::contact_table::{
    CASES, Chain, Experiment, Gain, Law, Outcome, bound, chance_of_all_below, trials_of,
};

/// Which of the answers of a trial is judged.
#[derive(Clone, Copy)]
enum Way {
    ClosedForm,
    LeastSquares,
    Contact,
}

/// The errors (relative) of one way to measure, over all cases and seeds.
struct Column {
    name: String,
    errors: Vec<Vec<f64>>,
    /// Root of the mean square of the errors in standard deviations as told.
    honesty: f64,
}

impl Column {
    fn row(&self) -> String {
        let mut all: Vec<f64> = self.errors.concat();
        all.sort_by(f64::total_cmp);
        let at = |share: f64| 100.0 * all[((all.len() - 1) as f64 * share).round() as usize];
        let mean = 100.0 * all.iter().sum::<f64>() / all.len() as f64;
        let told = if self.honesty.is_nan() { "".to_owned() } else { format!("{:.1}", self.honesty) };
        let (half, most, nearly) = (at(0.5), at(0.9), at(0.99));
        format!("| {} | {mean:.2} | {half:.2} | {most:.2} | {nearly:.2} | {:.2} | {told} |", self.name, at(1.0))
    }

    fn cases(&self) -> String {
        let mean = |errors: &Vec<f64>| 100.0 * errors.iter().sum::<f64>() / errors.len() as f64;
        let worst = |errors: &Vec<f64>| 100.0 * errors.iter().copied().fold(0.0, f64::max);
        let cells: Vec<String> = self.errors.iter().map(|e| format!("{:.2} / {:.2}", mean(e), worst(e))).collect();
        format!("| {} | {} |", self.name, cells.join(" | "))
    }
}

/// The errors of one experiment, judged three ways; a contact that is not found counts as an infinite error.
fn columns(chain: &Chain, experiment: Experiment, seeds: usize, ways: &[(Way, &str)]) -> Vec<Column> {
    let outcomes = trials_of(chain, experiment, seeds, all_cores());
    let column = |&(way, name): &(Way, &str)| {
        let error = |outcome: &Outcome| match way {
            Way::ClosedForm => outcome.closed_form,
            Way::LeastSquares => outcome.least_squares,
            Way::Contact => outcome.contact,
        };
        let squares: Vec<f64> = outcomes.iter().flatten().map(|o| (o.contact / o.std).powi(2)).collect();
        let honesty = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
        Column {
            name: name.to_owned(),
            errors: outcomes.iter().map(|case| case.iter().map(|o| error(o).abs()).collect()).collect(),
            honesty: if matches!(way, Way::Contact) { honesty } else { f64::NAN },
        }
    };
    ways.iter().map(column).collect()
}

fn closed_forms() {
    println!("The paper's closed form, from its moments:");
    println!("| p_x (mm) | M0 (mN m) | d = sqrt(3 EI t_y / M0) (mm) |\n| --- | --- | --- |");
    for case in CASES {
        let d = SmallAngle::from_moment_and_deflection(Whisker::default().flexural_rigidity, 1e-3 * case.moment, 1e-3);
        println!("| {:.0} | {:.2} | {:.1} |", case.distance, case.moment, 1e3 * d.map_or(f64::NAN, |d| d.s_a));
    }
}

/// What normal errors of the same variance would allow any unbiased estimator.
fn bounds(seeds: usize) {
    println!(
        "\nBound of Cramér and Rao for normal errors of the same variance, standard deviation of the distance (%):"
    );
    println!(
        "| base motion, gain | 70 mm | 65 mm | 55 mm | 45 mm | 35 mm | chance that all {} are below 1 % |",
        5 * seeds
    );
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    for steps in [1, 2, 4] {
        for gain in [0.0, 0.01] {
            let all = |gain: f64| CASES.map(|case| 100.0 * bound(1e-3 * case.distance, steps, gain));
            let cells = all(gain).map(|std| format!("{std:.2}")).join(" | ");
            let chance = chance_of_all_below(1.0, &all(0.0), 50.0 * gain, seeds as u64);
            println!("| {steps} mm, gain ±{:.0} % | {cells} | {:.3} |", 100.0 * gain, chance);
        }
    }
}

fn main() {
    let mut args = std::env::args().skip(1);
    let seeds: usize = args.next().and_then(|n| n.parse().ok()).unwrap_or(200).max(1);
    closed_forms();
    bounds(seeds);
    let chain = match Chain::new(seeds, all_cores()) {
        Ok(chain) => chain,
        Err(error) => {
            eprintln!("the simulated calibration failed: {error}");
            std::process::exit(1);
        }
    };
    println!("\n{}", chain.summary());
    let printed = CASES.iter().map(|case| case.paper[1]).sum::<f64>() / CASES.len() as f64;
    println!("\nThe paper's errors: mean {printed:.2} %, worst 2.1 %. Simulated, {seeds} seeds a distance:\n");
    println!("| relative error of the distance (%) | mean | median | 90th | 99th | worst | RMS in stds told |");
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    let experiment = |steps, gain, law| Experiment { steps, gain, law };
    let calibrated = experiment(1, Gain::Calibrated, Law::Uniform);
    let mut all = columns(
        &chain,
        calibrated,
        seeds,
        &[
            (Way::ClosedForm, "closed form, last reading, 1 mm, calibrated"),
            (Way::LeastSquares, "1 mm, calibrated, least squares alone"),
            (Way::Contact, "1 mm, calibrated"),
        ],
    );
    all.iter().for_each(|c| println!("{}", c.row()));
    for (steps, gain, law, name) in [
        (1, Gain::Within(0.0), Law::Uniform, "1 mm, no gain error"),
        (1, Gain::Within(0.01), Law::Uniform, "1 mm, gain ±1 %"),
        (4, Gain::Calibrated, Law::Uniform, "4 mm, calibrated"),
        (4, Gain::Within(0.01), Law::Uniform, "4 mm, gain ±1 %"),
        (1, Gain::Calibrated, Law::Normal, "1 mm, calibrated, normal errors"),
    ] {
        let more = columns(&chain, experiment(steps, gain, law), seeds, &[(Way::Contact, name)]);
        more.iter().for_each(|c| println!("{}", c.row()));
        all.extend(more);
    }
    println!("\n| mean / worst (%) | 70 mm | 65 mm | 55 mm | 45 mm | 35 mm |\n| --- | --- | --- | --- | --- | --- |");
    all.iter().for_each(|c| println!("{}", c.cases()));
    if let Some(path) = args.next()
        && let Err(error) = std::fs::write(&path, figure(&all))
    {
        eprintln!("cannot write {path}: {error}");
        std::process::exit(1);
    }
    let main = &all[2].errors.concat();
    let mean = 100.0 * main.iter().sum::<f64>() / main.len() as f64;
    let worst = 100.0 * main.iter().copied().fold(0.0, f64::max);
    println!("\nheadline: one step of 1 mm, calibrated: mean {mean:.2} %, worst {worst:.2} % (paper 1.10 %, 2.1 %)");
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
    let drawn = [(0, "wall"), (1, "path"), (2, "whisker-last"), (4, "truth-mark"), (7, "survivor-tick")];
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
