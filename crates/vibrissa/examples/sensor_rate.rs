//! How fast a localizer takes rows, and where it is slow: the search for the start, updates after it, the final fit.
//!
//! `cargo run --release --example sensor_rate -- FOLDER [METHOD] [ONLY]` localizes every `NAME.csv` of a folder with its
//! `NAME.truth.tum` on the map `MAP.geojson` (`MAP` up to the first `-`), those of names that begin with `ONLY`, by the
//! deterministic, possibilistic or probabilistic METHOD (the last unless said). One line
//! for each: rows; milliseconds for all of it, for the longest row before one second of contact has passed, for the median and
//! the 99th percentile of the rows after that, and for the final fit; how many components there
//! were at each quarter of the updates; verdict, error of the nearest place, that of the nearest place or its ridge,
//! least squared distance of the truth from a place in its standard deviations (95 % lie below 7.8), area of the set (mm²) and
//! the longest side of the rectangle around a place (mm), weights of all.

#[path = "../tests/data/region.rs"]
mod region;
#[path = "../tests/data/ridge.rs"]
mod ridge;

use region::{CHI2_95, distance};
use ridge::off_ridge;
use std::path::Path;
use std::time::Instant;
use vibrissa::config::ProbabilisticOptions;
use vibrissa::flow::pose::{Hypothesis, Localization};
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::io::read_tum;
use vibrissa::localizer::Localizer;
use vibrissa::plane::{Pose2, wrap_angle};
use vibrissa::world::{Map, Robot};
use vibrissa::{Error, Method, Result};

/// Rows of contact in a second, at the paper's rate.
const SECOND: usize = 300;

/// How long each row and the end took (ms), and the answer.
struct Run {
    rows: Vec<f64>,
    end: f64,
    answer: Localization,
}

fn ms(since: Instant) -> f64 {
    1e3 * since.elapsed().as_secs_f64()
}

fn run(log: &SensorLog, map: &Map, robot: &Robot, method: &Method) -> Result<Run> {
    let mut localizer = Localizer::new(map, robot, &log.channels, method)?;
    let mut rows = Vec::with_capacity(log.rows.len());
    for row in &log.rows {
        let begun = Instant::now();
        localizer.step(row)?;
        rows.push(ms(begun));
    }
    let begun = Instant::now();
    let answer = localizer.finish();
    Ok(Run { rows, end: ms(begun), answer })
}

fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get((share * sorted.len() as f64) as usize).copied().unwrap_or(f64::NAN)
}

/// The declared errors of biased sweeps: a gain of 2 % and odometry of 1 % on top of the noise.
fn robot(name: &str) -> Robot {
    let mut robot = Robot::default();
    if name.ends_with("-bias") {
        robot.whiskers[0].noise.moment_relative = 0.055;
        robot.odometry.translation_relative = 0.0101;
        robot.odometry.rotation_relative = 0.0101;
    }
    robot
}

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().ok_or_else(|| Error::usage("a folder of sweeps is missing"))?;
    let method = arguments
        .next()
        .map_or(Ok(Method::Probabilistic(ProbabilisticOptions::exact())), |name| Method::named(&name))?;
    let only = arguments.next().unwrap_or_default();
    let files = std::fs::read_dir(&folder).map_err(|e| Error::data(e.to_string()))?;
    let mut names: Vec<String> = files
        .filter_map(|f| f.ok()?.file_name().into_string().ok()?.strip_suffix(".truth.tum").map(str::to_owned))
        .filter(|name| name.starts_with(&only))
        .collect();
    names.sort();
    println!(
        "{:18}{:>6}{:>9}{:>9}{:>8}{:>8}{:>8}{:>24}  verdict, mm, deg, mm, deg with ridges, their vertices, chi2, mm2, long mm, weights",
        "sweep", "rows", "all", "longest", "p50", "p99", "end", "alive"
    );
    let (mut rows, mut all, mut late_all, mut held) = (0, 0.0, Vec::new(), 0);
    for name in names {
        let map = vibrissa::read_map(
            Path::new(&folder).join(format!("{}.geojson", name.split('-').next().unwrap_or_default())),
        )?;
        let log = vibrissa::read_log(Path::new(&folder).join(format!("{name}.csv")))?;
        let truth = read_tum(Path::new(&folder).join(format!("{name}.truth.tum")))?;
        let truth = truth.last().map_or(Pose2::IDENTITY, |t| t.map_from_robot);
        let run = run(&log, &map, &robot(&name), &method)?;
        let touched = log.rows.iter().position(|row| row.readings[0].abs() > 1e-4).unwrap_or(0);
        let settled = (touched + SECOND).min(run.rows.len() / 2);
        let (early, late) = run.rows.split_at(settled);
        let total = run.rows.iter().sum::<f64>() + run.end;
        let off = |p: Pose2| {
            (1e3 * p.position().distance(truth.position()), wrap_angle(p.theta - truth.theta).abs().to_degrees())
        };
        let best = run.answer.hypotheses.iter().map(|h| off(h.pose)).min_by(|a, b| a.0.total_cmp(&b.0));
        let along = |h: &Hypothesis| {
            let ridge = off_ridge(&h.ridge, truth).map(|(m, rad)| (1e3 * m, rad.to_degrees()));
            ridge.into_iter().chain([off(h.pose)]).min_by(|a, b| a.0.total_cmp(&b.0))
        };
        let nearest = run.answer.hypotheses.iter().filter_map(along).min_by(|a, b| a.0.total_cmp(&b.0));
        let vertices: Vec<usize> = run.answer.hypotheses.iter().map(|h| h.ridge.len()).collect();
        let chi2 = run.answer.hypotheses.iter().map(|h| distance(h, truth)).fold(f64::INFINITY, f64::min);
        // Places without a covariance tell their extent.
        let inside = |h: &Hypothesis| match h.covariance {
            Some(_) => distance(h, truth) <= CHI2_95,
            None => {
                let e = h.extent;
                let middle = 0.5 * (e.theta.lo() + e.theta.hi());
                let theta = middle + wrap_angle(truth.theta - middle);
                e.x.contains(truth.x) && e.y.contains(truth.y) && e.theta.contains(theta)
            }
        };
        held += usize::from(run.answer.hypotheses.iter().any(inside));
        let steps = &run.answer.steps;
        let alive =
            |part: usize| steps.get((steps.len() * part / 4).min(steps.len().max(1) - 1)).map_or(0, |s| s.components);
        let wide = |h: &Hypothesis| 1e3 * h.extent.x.width().max(h.extent.y.width());
        let longest = run.answer.hypotheses.iter().map(wide).fold(0.0, f64::max);
        let told: Vec<String> = run.answer.hypotheses.iter().map(|h| format!("{:.3}", h.weight)).collect();
        let (mm, deg) = best.unwrap_or((f64::NAN, f64::NAN));
        let (near_mm, near_deg) = nearest.unwrap_or((f64::NAN, f64::NAN));
        println!(
            "{name:18}{:6}{total:9.1}{:9.1}{:8.3}{:8.3}{:8.1}{:>24}  {} {mm:.3} {deg:.3} {near_mm:.3} {near_deg:.3} {vertices:?} {chi2:.1} {:.2} {longest:.2} {}",
            run.rows.len(),
            early.iter().copied().fold(0.0, f64::max),
            quantile(late, 0.5),
            quantile(late, 0.99),
            run.end,
            format!("{:?}", [alive(0), alive(1), alive(2), alive(3), alive(4)]).replace(", ", " "),
            run.answer.status,
            1e6 * steps.last().map_or(0.0, |s| s.area_m2),
            told.join(" ")
        );
        rows += run.rows.len();
        all += total;
        late_all.extend_from_slice(late);
    }
    println!(
        "{rows} rows in {all:.0} ms: {:.0} rows/s; rows after the first second: p50 {:.3} ms, p99 {:.3} ms; truth in a region {held} times",
        1e3 * rows as f64 / all,
        quantile(&late_all, 0.5),
        quantile(&late_all, 0.99)
    );
    Ok(())
}
