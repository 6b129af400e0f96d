//! The table of localization errors: the paper's method and ours on the same simulated logs.

use super::ground::{self, SWEEPS, SweepPlan, layer, mean_and_std};
use super::{Cell, Section, Table, paper_method};
use vibrissa::Result;
use vibrissa::config::{DeterministicOptions, PossibilisticOptions, ProbabilisticOptions, Region, TipLoad};
use vibrissa::figure::{Geometry, Layer, MapPlate, Outline, WorldBounds, map_plate};
use vibrissa::flow::pose::{Hypothesis, Localization, Status};
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::localize;
use vibrissa::localizer::Method;
use vibrissa::plane::{Pose2, Vec2, wrap_angle};
use vibrissa::sim::{Sweep, SweepNoise};
use vibrissa::tasks::batch;
use vibrissa::world::{Map, Robot};

/// The paper's table: average error and standard deviation of each sweep (mm).
const PAPER: [[f64; 2]; 5] = [[2.79, 1.09], [6.20, 1.67], [3.60, 0.02], [5.50, 0.65], [7.30, 0.44]];
/// How well the start is known: half the side of a region in x and y (m), half its headings (rad); the paper's start is
/// “a known location”, how well known is not told.
const START: [f64; 2] = [0.03, 0.26];
/// How far the middle of that region is from the true start, by the number of the noise (m).
const OFF: [Vec2; 4] =
    [Vec2::new(0.012, -0.009), Vec2::new(-0.014, 0.006), Vec2::new(-0.005, -0.013), Vec2::new(0.010, 0.011)];

/// Travel of the base over the shapes of a plain intersection (m).
const HISTORY: f64 = 2e-3;
/// Rows between two observations of the paper's method: the base moves by 0.5 mm in a row, and by less than 1 mm in a step of the paper.
const EVERY: usize = 1;

/// Half of what the pictures of the methods show (m).
const WINDOW: Vec2 = Vec2::new(1.8e-3, 1.1e-3);

/// A method with its key and its words.
#[derive(Clone, Copy)]
struct Contender {
    key: &'static str,
    words: &'static str,
    estimator: Estimator,
    start_known: bool,
}

/// Who estimates.
#[derive(Clone, Copy)]
enum Estimator {
    /// The paper's method as we read it, from readings without errors or with them.
    Paper { exact: bool },
    /// One of ours, with the region of the first pose where that is known.
    Ours(fn(Option<Region>) -> Method),
}

const CONTENDERS: [Contender; 8] = [
    Contender {
        key: "paper_exact",
        words: "the paper's method as we read it, readings without errors",
        estimator: Estimator::Paper { exact: true },
        start_known: true,
    },
    Contender {
        key: "paper_method",
        words: "the paper's method as we read it, readings off by up to 5 %",
        estimator: Estimator::Paper { exact: false },
        start_known: true,
    },
    Contender {
        key: "plain",
        words: "our deterministic method as a plain intersection: no misses, 1 mm grid, the paper's load",
        estimator: Estimator::Ours(|prior| {
            Method::Deterministic(DeterministicOptions {
                missed_share: 0.0,
                boundary_spacing: 1e-3,
                history_travel: HISTORY,
                tip_load: TipLoad::WhiskerNormal,
                prior,
                ..DeterministicOptions::default()
            })
        }),
        start_known: true,
    },
    Contender {
        key: "paper_load",
        words: "our deterministic method with the paper's load, normal to the whisker",
        estimator: Estimator::Ours(|prior| deterministic(TipLoad::WhiskerNormal, prior)),
        start_known: true,
    },
    Contender {
        key: "deterministic",
        words: "our deterministic method, load normal to the wall",
        estimator: Estimator::Ours(|prior| deterministic(TipLoad::BoundaryNormal, prior)),
        start_known: true,
    },
    Contender {
        key: "possibilistic",
        words: "possibilistic (guaranteed)",
        estimator: Estimator::Ours(|prior| {
            Method::Possibilistic(PossibilisticOptions { prior, ..PossibilisticOptions::default() })
        }),
        start_known: true,
    },
    Contender {
        key: "probabilistic",
        words: "probabilistic",
        estimator: Estimator::Ours(probabilistic),
        start_known: true,
    },
    Contender {
        key: "no_prior",
        words: "probabilistic, start unknown, where one place is left",
        estimator: Estimator::Ours(probabilistic),
        start_known: false,
    },
];

fn deterministic(tip_load: TipLoad, prior: Option<Region>) -> Method {
    Method::Deterministic(DeterministicOptions { tip_load, prior, ..DeterministicOptions::default() })
}

fn probabilistic(prior: Option<Region>) -> Method {
    Method::Probabilistic(ProbabilisticOptions { prior, ..ProbabilisticOptions::default() })
}

/// What one run came to.
#[derive(Clone, Copy, Debug)]
struct Outcome {
    /// Position error at the end (m) and heading error (rad); none where no place is left.
    error: Option<[f64; 2]>,
    localized: bool,
    /// Share of the observations until the paper's intersection was empty.
    lasted: f64,
}

/// One sweep with one noise, and its log without any.
struct Run {
    sweep: Sweep,
    exact: SensorLog,
    seed: usize,
}

pub(super) fn section(seeds: usize, sweeps: usize, threads: usize, observer: &mut dyn FnMut(f64)) -> Result<Section> {
    let mut section = Section::new("localization-table", "Table: localization error, all methods on the same logs");
    let (map, robot) = (ground::arena()?, ground::robot(1.0));
    let mut outcomes: Vec<Vec<Vec<Outcome>>> = Vec::new();
    let mut pictures = Vec::new();
    let plans = &SWEEPS[..sweeps.clamp(1, SWEEPS.len())];
    for (index, plan) in plans.iter().enumerate() {
        let runs = (0..seeds).map(|seed| run(&map, plan, seed)).collect::<Result<Vec<Run>>>()?;
        let jobs: Vec<(usize, usize)> = (0..CONTENDERS.len()).flat_map(|c| (0..seeds).map(move |s| (c, s))).collect();
        let answers = batch::map(&jobs, threads, |&(c, s)| answer(&map, &robot, &CONTENDERS[c], &runs[s]));
        let mut by_method: Vec<Vec<Outcome>> = Vec::new();
        for (&(c, s), answer) in jobs.iter().zip(answers) {
            let (outcome, answer) = answer?;
            let drawn = ["deterministic", "possibilistic", "probabilistic"].contains(&CONTENDERS[c].key);
            pictures.extend(
                answer
                    .filter(|_| index == 0 && s == 0 && drawn)
                    .map(|answer| picture(&map, &CONTENDERS[c], &answer, &runs[s])),
            );
            by_method.resize(c + 1, Vec::new());
            by_method[c].push(outcome);
        }
        outcomes.push(by_method);
        observer((index + 1) as f64 / plans.len() as f64);
    }
    let tables = [errors(&section, plans, &outcomes), headings(&section, plans, &outcomes)];
    section.tables.extend(tables);
    words(&mut section, seeds, &outcomes);
    section.show(
        "methods",
        [
            "No figure in the paper compares methods.",
            "The first sweep by the three methods: what is left at the end, the estimate and the truth, with the start known to 30 mm.",
            "",
        ],
        pictures,
    );
    Ok(section)
}

fn run(map: &Map, plan: &SweepPlan, seed: usize) -> Result<Run> {
    let noise = SweepNoise::seeded(100 * plan.id as u64 + seed as u64);
    let exact = ground::arena_sweep(map, plan.way, &SweepNoise::none())?.log;
    Ok(Run { sweep: ground::arena_sweep(map, plan.way, &noise)?, exact, seed })
}

/// The region that holds the first pose: x, y (m), heading (rad).
fn region(run: &Run) -> [[f64; 2]; 3] {
    let truth = run.sweep.truth.first().map_or(Pose2::IDENTITY, |row| row.map_from_robot);
    let middle = truth.position() + OFF[run.seed % OFF.len()];
    let around = |value: f64, half: f64| [value - half, value + half];
    [around(middle.x, START[0]), around(middle.y, START[0]), around(truth.theta, START[1])]
}

/// What a contender makes of a run, with the whole answer where it is one of ours.
fn answer(map: &Map, robot: &Robot, contender: &Contender, run: &Run) -> Result<(Outcome, Option<Localization>)> {
    let prior = contender.start_known.then(|| region(run));
    match contender.estimator {
        Estimator::Paper { exact } => {
            let log = if exact { &run.exact } else { &run.sweep.log };
            let found = paper_method::localize(log, map, robot, region(run), EVERY)?;
            Ok((Outcome { lasted: found.lasted, ..average(&found.left, run) }, None))
        }
        Estimator::Ours(method) => {
            let answer = localize(&run.sweep.log, map, robot, &method(prior), &mut |_row| {})?;
            Ok((outcome(&answer, contender, run), Some(answer)))
        }
    }
}

/// The average error of all states that are left, as the paper's table has it.
fn average(left: &[Pose2], run: &Run) -> Outcome {
    let truth = run.sweep.truth.last().map_or(Pose2::IDENTITY, |row| row.map_from_robot);
    let mean = |of: &dyn Fn(&Pose2) -> f64| left.iter().map(of).sum::<f64>() / left.len() as f64;
    let error = [
        mean(&|state| state.position().distance(truth.position())),
        mean(&|state| wrap_angle(state.theta - truth.theta).abs()),
    ];
    Outcome { error: (!left.is_empty()).then_some(error), localized: left.len() == 1, lasted: 1.0 }
}

/// The place that is taken: the heaviest; with a known start the heaviest of those that started there.
fn taken<'a>(answer: &'a Localization, contender: &Contender, run: &Run) -> Option<&'a Hypothesis> {
    let [x, y, theta] = region(run);
    let last = run.sweep.log.rows.last().map_or(Pose2::IDENTITY, |row| row.odom_from_robot);
    let within = |value: f64, [lo, hi]: [f64; 2]| value >= lo && value <= hi;
    let from_region = |place: &&Hypothesis| {
        let start = place.pose.compose(last.inverse());
        within(start.x, x)
            && within(start.y, y)
            && wrap_angle(start.theta - 0.5 * (theta[0] + theta[1])).abs() <= START[1]
    };
    answer.hypotheses.iter().find(|place| !contender.start_known || from_region(place))
}

fn outcome(answer: &Localization, contender: &Contender, run: &Run) -> Outcome {
    let truth = run.sweep.truth.last().map_or(Pose2::IDENTITY, |row| row.map_from_robot);
    let localized = answer.status == Status::Localized;
    // Without a start, rivals stay rivals: an ambiguous answer claims no single place.
    let claimed = taken(answer, contender, run).filter(|_| contender.start_known || localized);
    let off = |place: &Hypothesis| {
        [place.pose.position().distance(truth.position()), wrap_angle(place.pose.theta - truth.theta).abs()]
    };
    Outcome { error: claimed.map(off), localized, lasted: 1.0 }
}

/// All errors of some outcomes (mm or degrees).
fn all(outcomes: &[Outcome], which: usize) -> Vec<f64> {
    let scale = [1e3, 1f64.to_degrees()][which];
    outcomes.iter().filter_map(|outcome| outcome.error).map(|error| scale * error[which]).collect()
}

fn errors(section: &Section, plans: &[SweepPlan], outcomes: &[Vec<Vec<Outcome>>]) -> Table {
    let mut rows = vec![
        paper_row(section, plans, 0, "paper, measured: average error"),
        paper_row(section, plans, 1, "paper, measured: standard deviation"),
    ];
    for (c, contender) in CONTENDERS.iter().enumerate() {
        for (statistic, what) in [("mean", "mean"), ("std", "standard deviation")] {
            let mut row = vec![Cell::from(format!("{}: {what}", contender.words))];
            for (plan, by_method) in plans.iter().zip(outcomes) {
                let (mean, std) = mean_and_std(&all(&by_method[c], 0));
                let value = if statistic == "mean" { mean } else { std };
                row.push(section.named(&format!("{}.{}.{statistic}", contender.key, plan.id), value, 2, "mm").into());
            }
            rows.push(row);
        }
    }
    Table {
        key: "localization-table",
        title: "Table “localizationError”: position error of each sweep, mm".into(),
        head: head(plans),
        rows,
    }
}

fn headings(section: &Section, plans: &[SweepPlan], outcomes: &[Vec<Vec<Outcome>>]) -> Table {
    let mut nothing = vec![Cell::from("paper: announced, no number")];
    nothing.extend(plans.iter().map(|_| Cell::from("—")));
    let mut rows = vec![nothing];
    for (c, contender) in CONTENDERS.iter().enumerate() {
        let mut row = vec![Cell::from(format!("{}: mean", contender.words))];
        for (plan, by_method) in plans.iter().zip(outcomes) {
            let (mean, _) = mean_and_std(&all(&by_method[c], 1));
            row.push(section.named(&format!("{}.{}.heading", contender.key, plan.id), mean, 3, "°").into());
        }
        rows.push(row);
    }
    Table { key: "heading-table", title: "Heading error of each sweep, degrees".into(), head: head(plans), rows }
}

fn head(plans: &[SweepPlan]) -> Vec<String> {
    core::iter::once("sweep".to_owned())
        .chain(plans.iter().map(|plan| format!("{:02}: {}", plan.id, plan.what)))
        .collect()
}

fn paper_row(section: &Section, plans: &[SweepPlan], which: usize, words: &str) -> Vec<Cell> {
    let name = ["mean", "std"][which];
    let number = |plan: &SweepPlan| {
        section.named(&format!("paper.{}.{name}", plan.id), PAPER[plan.id - 1][which], 2, "mm").into()
    };
    core::iter::once(words.into()).chain(plans.iter().map(number)).collect()
}

fn words(section: &mut Section, seeds: usize, outcomes: &[Vec<Vec<Outcome>>]) {
    section.tell("seeds", seeds as f64, 0, "");
    section.say(
        "The paper's sweeps were measured on a stage and are not public: the walls they ran along, their lengths and what its \
         average is taken over are not told. Ours are five simulated sweeps along the arena's upper wall, each with \
         {localization-table.seeds} draws of readings that are off by up to 5 % and 20 µN m, the tip without friction, exact odometry; \
         the error is that of the last row, mean and standard deviation are over the draws. The start is known to a region of \
         60 mm by 60 mm by 30°, off its middle, except in the last rows (`--within`).",
    );
    section.compare(
        "Linear motion of the base in one step, at most",
        "step",
        (1.0, 1e3 * ground::PACE.speed / ground::PACE.rate),
        (1, "mm"),
        "One row of the log.",
    );
    let paper = PAPER.iter().map(|p| p[0]).sum::<f64>() / PAPER.len() as f64;
    let of = |c: usize| -> Vec<f64> { outcomes.iter().flat_map(|by_method| all(&by_method[c], 0)).collect() };
    for (c, contender) in CONTENDERS.iter().enumerate() {
        let (mean, _) = mean_and_std(&of(c));
        let reason = match contender.key {
            "paper_exact" => {
                "The average over all states that are left; an em dash where none is. The boundary's slope is that of the shapes at t and \
                 t + 2, and a state stays that the next curve passes within the grid's 1 mm. The force normal to the whisker puts the \
                 tip a millimetre off by itself, and at corners two shapes show no wall's slope. How near is near enough is not told."
            }
            "paper_method" => {
                "The same with errors. Shapes 1 mm apart give the slope to some tens of degrees (section on the angle to the boundary), so the next curve misses the truth."
            }
            "plain" => {
                "Over the runs in which it leaves a place: a reading that is off empties a plain intersection, and the run ends \
                 `inconsistent`. Readings are smoothed over 2 mm, and states have a tolerance of four standard deviations."
            }
            "paper_load" => {
                "With our tolerance: a quarter of the observations may be missed, shapes over 10 mm of travel. Simulated readings \
                 have no calibration error and the map is exact."
            }
            "deterministic" => "Without friction a wall pushes a tip along its own normal.",
            "possibilistic" => "The middle of a set that holds the truth: not the likeliest place.",
            "probabilistic" => "All readings fitted at once.",
            _ => {
                "No prior at all. Two equal bays cannot be told apart by touch: those sweeps stay ambiguous, and are left out."
            }
        };
        section.compare(
            &format!("Mean error over all sweeps: {}", contender.words),
            &format!("{}.mean", contender.key),
            (paper, mean),
            (2, "mm"),
            reason,
        );
    }
    let worst = |c: usize| of(c).into_iter().fold(0.0, f64::max);
    let best = CONTENDERS.iter().position(|contender| contender.key == "probabilistic").unwrap_or_default();
    section.compare(
        "Worst error of the probabilistic method against the paper's worst average",
        "worst",
        (7.30, worst(best)),
        (2, "mm"),
        "Over all sweeps and draws.",
    );
    for (c, contender) in CONTENDERS.iter().enumerate() {
        let runs: Vec<&Outcome> = outcomes.iter().flat_map(|by_method| &by_method[c]).collect();
        let found = runs.iter().filter(|outcome| outcome.error.is_some()).count();
        let sure = runs.iter().filter(|outcome| outcome.localized).count();
        section.tell(&format!("{}.found", contender.key), found as f64, 0, "");
        section.tell(&format!("{}.localized", contender.key), sure as f64, 0, "");
        let lasted = runs.iter().map(|outcome| outcome.lasted).sum::<f64>() / runs.len() as f64;
        section.tell(&format!("{}.lasted", contender.key), 100.0 * lasted, 0, "%");
    }
    section.tell("runs", outcomes.iter().map(|by_method| by_method[0].len()).sum::<usize>() as f64, 0, "");
    section.say(
        "Of {localization-table.runs} runs a place is left in: the paper's method as we read it \
         {localization-table.paper_exact.found} with exact readings and {localization-table.paper_method.found} with errors; a plain \
         intersection {localization-table.plain.found}; the paper's load {localization-table.paper_load.found}; deterministic \
         {localization-table.deterministic.found}; possibilistic {localization-table.possibilistic.found}; probabilistic \
         {localization-table.probabilistic.found}; without a prior {localization-table.no_prior.found}. A run without a place is \
         `inconsistent`: the paper's method explains {localization-table.paper_exact.lasted} % of the observations on average with exact \
         readings, and {localization-table.paper_method.lasted} % with errors, before nothing is left.",
    );
    section.say(
        "One place alone (verdict “localized”) is left in {localization-table.plain.localized} of the plain intersection's runs, \
         {localization-table.paper_load.localized} with the paper's load, {localization-table.deterministic.localized} \
         (deterministic), {localization-table.possibilistic.localized} (possibilistic), \
         {localization-table.probabilistic.localized} (probabilistic) and {localization-table.no_prior.localized} (without a \
         prior).",
    );
}

/// The end of a sweep by one method.
fn picture(map: &Map, contender: &Contender, answer: &Localization, run: &Run) -> String {
    let outlines: Vec<Outline> = ground::outlines(map);
    let truth = run.sweep.truth.last().map_or(Pose2::IDENTITY, |row| row.map_from_robot);
    let ring = |s: &vibrissa::sets::StateBox| {
        vec![
            Vec2::new(s.x.lo(), s.y.lo()),
            Vec2::new(s.x.hi(), s.y.lo()),
            Vec2::new(s.x.hi(), s.y.hi()),
            Vec2::new(s.x.lo(), s.y.hi()),
        ]
    };
    let (points, boxes): (Vec<_>, Vec<_>) =
        answer.states.iter().partition(|s| s.x.width() <= 0.0 && s.y.width() <= 0.0);
    let middle = |s: &&vibrissa::sets::StateBox| Pose2::new(s.x.lo(), s.y.lo(), s.theta.lo());
    let mut layers: Vec<Layer> = vec![
        layer(Geometry::Rings(boxes.into_iter().map(ring).collect()), "survivor-box", "boxes left at the end"),
        layer(Geometry::States(points.iter().map(middle).collect()), "survivor", "states left at the end"),
        layer(Geometry::Lines(vec![ground::positions(&run.sweep.truth)]), "truth", "true way"),
        layer(Geometry::Lines(vec![ground::positions(&answer.trajectory)]), "path", "estimated way"),
        layer(Geometry::Circles(vec![truth.position()]), "truth-mark", "true state at the end"),
    ];
    layers
        .extend(taken(answer, contender, run).map(|place| layer(Geometry::Arrow(place.pose), "estimate", "estimate")));
    let around = WorldBounds { min: truth.position() - WINDOW, max: truth.position() + WINDOW };
    map_plate(&MapPlate {
        title: contender.words,
        map: &outlines,
        layers: &layers,
        window: Some(around),
        frame: "map frame",
    })
}
