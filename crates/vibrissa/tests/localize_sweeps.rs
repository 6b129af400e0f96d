//! The corridor on sweeps that an independent simulator made: another physics code, 5 % noise, truth beside them.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/shared.rs"]
mod shared;

use shared::shared;
use std::path::{Path, PathBuf};
use vibrissa::config::{DeterministicOptions, TipLoad};
use vibrissa::flow::pose::{Localization, Status};
use vibrissa::io::read_tum;
use vibrissa::plane::{Pose2, wrap_angle};
use vibrissa::tasks::demo;
use vibrissa::world::Robot;
use vibrissa::{Method, localize};

/// The folder of reference data, where there is one.
fn sweeps() -> Option<PathBuf> {
    shared("sweeps")
}

struct Run {
    name: String,
    answer: Localization,
    truth: Pose2,
}

impl Run {
    fn new(folder: &Path, name: &str, robot: &Robot, options: &Method) -> Self {
        let map = vibrissa::read_map(folder.join(format!("{}.geojson", name.split('-').next().unwrap()))).unwrap();
        let log = vibrissa::read_log(folder.join(format!("{name}.csv"))).unwrap();
        let truth = read_tum(folder.join(format!("{name}.truth.tum"))).unwrap();
        let answer = localize(&log, &map, robot, options, &mut |_| {}).unwrap();
        Self { name: name.to_owned(), answer, truth: truth.last().unwrap().map_from_robot }
    }

    /// Distance (m) and turn (rad) of a pose from the truth at the last row.
    fn error(&self, pose: Pose2) -> (f64, f64) {
        (pose.position().distance(self.truth.position()), wrap_angle(pose.theta - self.truth.theta).abs())
    }

    fn check(&self) {
        let best = self.answer.estimate.map(|pose| self.error(pose));
        println!("{}: {} {best:?} m, rad", self.name, self.answer.status);
        assert!(self.holds_the_truth(), "{}: {:?}", self.name, self.answer.hypotheses);
        // A verdict of `localized` is a promise.
        if self.answer.status == Status::Localized {
            let (distance, turn) = best.unwrap();
            assert!(distance < 2e-3 && turn < 1.5_f64.to_radians(), "{}: {distance} m, {turn} rad", self.name);
        }
        assert!(self.answer.status != Status::Inconsistent && self.answer.status != Status::NoContact, "{}", self.name);
    }

    /// Whether a hypothesis' extent holds the truth.
    fn holds_the_truth(&self) -> bool {
        self.answer.hypotheses.iter().any(|h| {
            let middle = 0.5 * (h.extent.theta.lo() + h.extent.theta.hi());
            h.extent.x.contains(self.truth.x)
                && h.extent.y.contains(self.truth.y)
                && h.extent.theta.contains(middle + wrap_angle(self.truth.theta - middle))
        })
    }
}

fn biased_robot() -> Robot {
    let mut robot = Robot::default();
    robot.whiskers[0].noise.moment_relative = 0.055;
    robot.odometry.translation_relative = 0.0101;
    robot.odometry.rotation_relative = 0.0101;
    robot
}

/// One after the other on each of two threads: every test takes its own share of the sweeps.
fn check(names: &[&str], suffix: &str, robot: &Robot) {
    let Some(folder) = sweeps() else { return };
    for name in names {
        Run::new(&folder, &format!("{name}{suffix}"), robot, &Method::Deterministic(Default::default())).check();
    }
}

/// The same where no folder with other sweeps is: the demo's, with other noise each time.
#[test]
fn truth_of_the_simulator_is_among_the_hypotheses() {
    let map = demo::arena().unwrap();
    for seed in 11..=13 {
        let sweep = demo::sweep(seed).unwrap();
        let method = Method::Deterministic(Default::default());
        let answer = localize(&sweep.log, &map, &Robot::default(), &method, &mut |_| {}).unwrap();
        let run = Run { name: format!("demo {seed}"), answer, truth: sweep.truth.last().unwrap().map_from_robot };
        run.check();
        assert_eq!(run.answer.status, Status::Localized, "{}", run.name);
    }
}

#[test]
fn truth_is_among_the_hypotheses() {
    check(&["bays-00", "bays-01", "bays-02", "obstacle-01", "square-01", "square-02"], "", &Robot::default());
}

#[test]
fn truth_is_among_the_hypotheses_of_longer_sweeps() {
    check(&["obstacle-02", "rough0-01", "square-00"], "", &Robot::default());
}

#[test]
fn gain_and_odometry_errors_within_their_bounds_lose_nothing() {
    check(&["bays-01", "obstacle-00", "rough0-02", "rough0-03", "square-01"], "-bias", &biased_robot());
}

#[test]
fn unique_places_are_found() {
    let Some(folder) = sweeps() else { return };
    for name in ["obstacle-00", "rough0-02", "rough0-03"] {
        let run = Run::new(&folder, name, &Robot::default(), &Method::Deterministic(Default::default()));
        let (distance, turn) = run.error(run.answer.estimate.unwrap());
        println!("{name}: {} {:.2} mm {:.2} deg", run.answer.status, 1e3 * distance, turn.to_degrees());
        assert!(distance < 1e-3 && turn < 0.5_f64.to_radians(), "{name}: {distance} m, {turn} rad");
        assert!(run.holds_the_truth());
        // The set shrank: fewer and fewer candidates.
        let (first, last) = (run.answer.steps[0], run.answer.steps.last().unwrap());
        assert!(last.volume < first.volume, "{first:?} {last:?}");
    }
}

#[test]
fn the_papers_load_is_millimetres_off() {
    let Some(folder) = sweeps() else { return };
    let deterministic = DeterministicOptions { tip_load: TipLoad::WhiskerNormal, ..DeterministicOptions::default() };
    let paper = Method::Deterministic(deterministic);
    for name in ["rough0-02", "rough0-03"] {
        let ours = Run::new(&folder, name, &Robot::default(), &Method::Deterministic(Default::default()));
        let theirs = Run::new(&folder, name, &Robot::default(), &paper);
        let (a, _) = ours.error(ours.answer.estimate.unwrap());
        let (b, _) = theirs.error(theirs.answer.estimate.unwrap());
        println!("{name}: {:.2} mm, with the paper's load {:.2} mm", 1e3 * a, 1e3 * b);
        assert!(a < b && b < 10e-3, "{a} {b}");
    }
}
