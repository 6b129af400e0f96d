//! Every scenario in the repository reads and runs, keeps to its noise, and is listed with a picture.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

use std::fs;
use std::path::{Path, PathBuf};
use vibrissa::flow::pose::Status;
use vibrissa::flow::trajectory::trajectory_error;
use vibrissa::sim::Part;
use vibrissa::sim::recorder::{Columns, SerialLayout, serial_text};
use vibrissa::sim::{Scenario, Simulation};
use vibrissa::{Method, localize};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios")
}

fn files() -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = fs::read_dir(folder()).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    files.sort();
    files
}

fn read(name: &str) -> Scenario {
    Scenario::read(folder().join(name)).unwrap()
}

/// The checks that hold for any simulation.
fn check(name: &str, scenario: &Scenario, simulation: &Simulation) {
    let (sweep, log) = (&simulation.sweep, &simulation.recording.log);
    assert!(simulation.warnings.is_empty(), "{name}: {:?}", simulation.warnings);
    assert_eq!(sweep.truth, scenario.path, "{name}");
    assert!(sweep.contacts.len() > 80, "{name}: {} touches", sweep.contacts.len());
    for touch in &sweep.contacts {
        let near = scenario.map.nearest(touch.position).unwrap();
        assert!(near.distance < 1e-6, "{name}: a touch is {} m off the boundary", near.distance);
    }
    let touched = (0..scenario.robot.whiskers.len()).filter(|w| sweep.contacts.iter().any(|t| t.whisker == *w)).count();
    assert_eq!(touched, scenario.robot.whiskers.len(), "{name}: every whisker touches something");
    assert_eq!(log.rows.len(), simulation.recording.rows.len(), "{name}");
    assert!(log.rows.iter().all(|row| row.readings.iter().all(|r| r.is_finite())), "{name}");
}

#[test]
fn every_scenario_runs() {
    let mut ran = 0;
    for path in files() {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let scenario = Scenario::read(&path).unwrap();
        let simulation = scenario.simulate().unwrap();
        check(&name, &scenario, &simulation);
        if name == "side_contact.toml" {
            assert!(simulation.sweep.contacts.iter().any(|touch| touch.part == Part::Side), "{name}");
        }
        ran += 1;
    }
    assert!(ran >= 10, "{ran}");
}

#[test]
fn every_scenario_is_listed_with_its_picture() {
    let list = fs::read_to_string(folder().join("README.md")).unwrap();
    for path in files() {
        let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
        assert!(list.contains(&format!("{stem}.toml")), "{stem} is not in scenarios/README.md");
        assert!(list.contains(&format!("figures/{stem}.svg")), "{stem} has no picture in scenarios/README.md");
        let picture = fs::read_to_string(folder().join(format!("figures/{stem}.svg"))).unwrap();
        assert!(picture.contains("</svg>"), "{stem}");
    }
}

#[test]
fn the_same_seed_gives_the_same_recording() {
    let scenario = read("round_array.toml");
    let (a, b) = (scenario.simulate().unwrap(), scenario.simulate().unwrap());
    assert_eq!(a.recording, b.recording);
    let other = scenario.with_seed(2).simulate().unwrap();
    assert_eq!(a.sweep.exact_moments, other.sweep.exact_moments);
    assert_ne!(a.recording.log, other.recording.log);
}

/// The verdict on a scenario's own log and how far the estimate ends from the truth (m).
fn localized(name: &str) -> (Status, usize, f64) {
    let scenario = read(name);
    let simulation = scenario.simulate().unwrap();
    let log = &simulation.recording.log;
    let answer =
        localize(log, &scenario.map, &scenario.robot, &Method::Deterministic(Default::default()), &mut |_row| ())
            .unwrap();
    let error = trajectory_error(&answer.trajectory, &simulation.sweep.truth).unwrap();
    (answer.status, answer.hypotheses.len(), error.final_position)
}

#[test]
fn a_concave_bay_tells_the_place() {
    let (status, _, error) = localized("arena_concave.toml");
    assert_eq!(status, Status::Localized);
    assert!(error < 1e-3, "{error}");
}

#[test]
fn an_obstacles_outline_tells_the_place() {
    let (status, _, error) = localized("obstacle_sweep.toml");
    assert_eq!(status, Status::Localized);
    assert!(error < 1e-3, "{error}");
}

#[test]
fn equal_bays_stay_two_places() {
    let (status, places, _) = localized("arena_symmetric.toml");
    assert_eq!((status, places), (Status::Ambiguous, 2));
}

#[test]
fn two_sensors_take_turns_on_the_serial_line() {
    let mut scenario = read("pipe.toml");
    scenario.serial = Some(SerialLayout::Interleaved);
    scenario.recorder.columns = vec![Columns::Counts];
    let simulation = scenario.simulate().unwrap();
    let text = simulation.serial.unwrap();
    assert_eq!(text, serial_text(&simulation.recording, SerialLayout::Interleaved).unwrap());
    for (row, line) in text.lines().enumerate().skip(600).take(100) {
        let y: f64 = line.split(',').nth(1).unwrap().parse().unwrap();
        // A push to the left of the whisker, as the outer wall's, tilts the field the other way than the inner's.
        let exact = simulation.sweep.exact_moments[row][row % 2];
        assert!(y * exact < 0.0, "row {row}: {y} µT, {exact} N m");
    }
}
