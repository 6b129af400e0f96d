//! A request to end: what is known by then is kept and marked, and nothing of it is wrong.

use vibrissa::config::{ContactOptions, PossibilisticOptions, ProfileOptions};
use vibrissa::sim::{Scenario, SimulateOptions, SweepNoise, simulate, simulate_until};
use vibrissa::tasks::contact::{contacts, contacts_until};
use vibrissa::tasks::profile::profile_until;
use vibrissa::tasks::{demo, localize_until};
use vibrissa::{Method, Robot, Stop, localize};

#[test]
fn contacts_end_where_the_search_is_stopped() {
    let (log, robot, options) = (demo::sweep(1).unwrap().log, Robot::default(), ContactOptions::default());
    let whole = contacts(&log, &robot, &options).unwrap();
    assert!(whole.stopped_at.is_none() && whole.steps.len() > 100);
    // Asked before it begins: the first contact is missing.
    let stop = Stop::default();
    stop.ask();
    assert!(stop.is_asked());
    let none = contacts_until(&log, &robot, &options, &stop, &mut |_, _| {}).unwrap();
    assert!(none.steps.is_empty() && none.stopped_at.is_some_and(|t| t <= whole.steps[0].t), "{:?}", none.stopped_at);
    let nothing = profile_until(
        core::slice::from_ref(&log),
        &robot,
        &options,
        &ProfileOptions::default(),
        &stop,
        &mut |_, _, _| {},
    )
    .unwrap();
    assert!(nothing.outlines.is_empty() && nothing.stopped_at.is_some_and(|(index, _)| index == 0));
    // Asked after the first part, by whom it is told: what comes before is as in the whole, what follows is missing.
    stop.withdraw();
    let mut told = Vec::new();
    let some = contacts_until(&log, &robot, &options, &stop, &mut |done, all| {
        told.push((done, all));
        if done > 0 {
            stop.ask();
        }
    })
    .unwrap();
    assert_eq!(told[0].0, 0);
    assert!(told.iter().all(|(done, all)| done <= all), "{told:?}");
    assert_eq!(some.steps, whole.steps[..some.steps.len()]);
    assert_eq!(some.stopped_at.is_some(), some.steps.len() < whole.steps.len());
}

#[test]
fn a_sweep_that_is_stopped_is_the_beginning_of_the_whole() {
    let (map, path) = (demo::arena().unwrap(), demo::path().unwrap());
    let mut robot = Robot::default();
    robot.whiskers.push(robot.whiskers[0].clone());
    robot.whiskers[1].name = "second".to_owned();
    // Without noise, whose draws go with the length of the path.
    let (noise, options) = (SweepNoise::none(), SimulateOptions::default());
    let whole = simulate(&map, &robot, &path, &noise, &options).unwrap();
    // The last of them is asked for between the whiskers of a row, which is left out then.
    for (rows, between) in [(0, 0), (1, 0), (200, 0), (201, 1)] {
        let stop = Stop::default();
        let mut ask = |done: usize| {
            if done >= 2 * rows + between {
                stop.ask();
            }
        };
        if rows == 0 {
            ask(0);
        }
        let part = simulate_until(&map, &robot, &path, &noise, &options, &stop, &mut ask).unwrap();
        assert_eq!((part.truth.len(), part.exact_moments.len(), part.log.rows.len()), (rows, rows, rows));
        assert_eq!(part.exact_moments, whole.exact_moments[..rows]);
        assert_eq!(part.log.rows, whole.log.rows[..rows]);
        assert!(part.contacts.iter().all(|touch| touch.row < rows));
        assert_eq!(part.events, whole.events[..part.events.len()]);
    }
}

#[test]
fn a_scenario_that_is_stopped_is_recorded_as_far_as_it_came() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenarios/pipe.toml");
    let scenario = Scenario::read(file).unwrap();
    let stop = Stop::default();
    let sweep = scenario
        .sweep_until(&stop, &mut |done| {
            if done == 40 {
                stop.ask()
            }
        })
        .unwrap();
    let rows = sweep.truth.len();
    assert!(rows > 0 && rows < scenario.path.len(), "{rows}");
    let part = scenario.recorded(sweep).unwrap();
    let whole = scenario.simulate().unwrap();
    assert_eq!(part.sweep.exact_moments, whole.sweep.exact_moments[..rows]);
    assert!(!part.recording.log.rows.is_empty() && part.recording.log.rows.len() <= rows);
    // Before the first pose there is nothing to record: a sweep of none, and in one call an error.
    assert!(scenario.sweep_until(&stop, &mut |_| {}).unwrap().truth.is_empty());
    assert!(scenario.simulate_until(&stop, &mut |_| {}).is_err());
}

#[test]
fn a_search_that_is_stopped_at_its_end_still_holds_the_truth() {
    let (map, robot, sweep) = (demo::arena().unwrap(), Robot::default(), demo::sweep(1).unwrap());
    let method = Method::Possibilistic(PossibilisticOptions::default());
    let truth = sweep.truth.last().unwrap().map_from_robot;
    let size = |found: &vibrissa::Localization| found.steps.last().map_or(f64::INFINITY, |step| step.volume);
    let whole = localize(&sweep.log, &map, &robot, &method, &mut |_| {}).unwrap();
    let stop = Stop::default();
    let last = sweep.log.rows.len() - 1;
    let found = localize_until(&sweep.log, &map, &robot, &method, &stop, &mut |row, _| {
        if row == last {
            stop.ask();
        }
        core::ops::ControlFlow::Continue(())
    })
    .unwrap();
    assert!(found.states.iter().any(|state| {
        let [x, y, theta] = [(state.x, truth.x), (state.y, truth.y), (state.theta, truth.theta)]
            .map(|(side, value)| side.contains(value));
        x && y && theta
    }));
    assert!(size(&found) > size(&whole), "the search at the end was left out");
    // In the middle of the log: the answer is that of a shorter one.
    stop.withdraw();
    let mut rows = 0;
    let half =
        localize_until(&sweep.log, &map, &robot, &Method::named("deterministic").unwrap(), &stop, &mut |row, _| {
            rows = row + 1;
            if rows == 300 {
                stop.ask();
            }
            core::ops::ControlFlow::Continue(())
        })
        .unwrap();
    assert_eq!(rows, 300);
    assert!(half.trajectory.last().is_none_or(|pose| pose.t <= sweep.log.rows[299].t));
}

#[test]
fn a_fit_that_is_stopped_at_its_end_tells_what_the_last_row_told() {
    let (map, robot, sweep) = (demo::arena().unwrap(), Robot::default(), demo::sweep(1).unwrap());
    let method = Method::named("probabilistic").unwrap();
    let whole = localize(&sweep.log, &map, &robot, &method, &mut |_| {}).unwrap();
    let (stop, last) = (Stop::default(), sweep.log.rows.len() - 1);
    let mut told = None;
    let found = localize_until(&sweep.log, &map, &robot, &method, &stop, &mut |row, localizer| {
        if row == last {
            told = Some(localizer.estimate());
            stop.ask();
        }
        core::ops::ControlFlow::Continue(())
    })
    .unwrap();
    // Nothing is sampled any more, and how well the readings fit is not looked at.
    let told = told.unwrap();
    assert_eq!((found.status, &found.hypotheses), (told.status, &told.hypotheses));
    assert!(found.consistency.is_none() && whole.consistency.is_some());
    assert_eq!(found.estimate, told.pose());
    // The way, too, is that of the place at the last row.
    let (end, truth) = (found.trajectory.last().unwrap(), sweep.truth.last().unwrap());
    assert_eq!((end.t, found.trajectory.len()), (truth.t, whole.trajectory.len()));
    assert!(end.map_from_robot.position().distance(truth.map_from_robot.position()) < 2e-3, "{end:?}");
}
