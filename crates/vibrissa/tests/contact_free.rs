//! A free whisker has no contacts, and a whisker that is touched has one.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

#[path = "data/free_whisker.rs"]
mod free_whisker;
#[path = "data/random.rs"]
mod random;

use free_whisker::{FreeLaw, FreeWhisker, ROWS};
use vibrissa::config::ContactOptions;
use vibrissa::flow::pose::Status;
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::tasks::contact::{ContactReport, contacts};
use vibrissa::world::Robot;
use vibrissa::{Method, localize};

fn found(law: FreeLaw, log: &SensorLog) -> ContactReport {
    contacts(log, &law.robot(), &ContactOptions::default()).unwrap()
}

#[test]
fn a_free_whisker_has_no_contacts_whatever_law_its_noise_has() {
    // `vibrissa-robustness --free 100` does so for a hundred hours of each law.
    for law in FreeLaw::ALL {
        let report = found(law, &FreeWhisker::new(law, 7).free(ROWS / 3));
        assert_eq!((report.steps.len(), report.events.len()), (0, 0), "{law:?}");
    }
}

#[test]
fn no_method_takes_a_free_whisker_for_one_that_touches() {
    let map = vibrissa::tasks::demo::arena().unwrap();
    for law in FreeLaw::ALL {
        let (log, robot) = (FreeWhisker::new(law, 5).free(600), law.robot());
        for method in Method::all() {
            let answer = localize(&log, &map, &robot, &method, &mut |_| {}).unwrap();
            // A method that says that it takes an error of the zero for none is not asked where there is one.
            if answer.events.iter().any(|event| event.kind == "unused") {
                assert!(robot.whiskers[0].errors.zero > 0.0);
                continue;
            }
            let told = || format!("{law:?} by {}: {:?}", method.name(), answer.events);
            assert_eq!(answer.status, Status::NoContact, "{}", told());
            assert!(answer.events.iter().all(|event| event.kind != "contact"), "{}", told());
        }
    }
}

#[test]
fn the_laws_fill_the_declared_bound() {
    for law in FreeLaw::ALL {
        let noise = law.robot().whiskers[0].noise.largest_free_reading();
        let off = law.robot().whiskers[0].errors.zero;
        let log = FreeWhisker::new(law, 3).free(ROWS);
        let largest = log.rows.iter().map(|row| row.readings[0].abs()).fold(0.0, f64::max);
        assert!(largest > 0.98 * (noise + off) && largest <= (noise + off) * (1.0 + 1e-12), "{law:?}: {largest}");
    }
}

#[test]
fn no_contact_above_twice_the_noise_is_missed() {
    for law in FreeLaw::ALL {
        let (log, touches) = FreeWhisker::new(law, 11).touched(ROWS / 12);
        let report = found(law, &log);
        let of = |kind: &str| report.events.iter().filter(|event| event.kind == kind).count();
        assert!(touches > 15);
        assert_eq!((of("contact"), of("lift_off")), (touches, touches), "{law:?}");
        assert!(report.events.iter().all(|event| event.kind != "contact" || event.detail == "w0 touches"));
        assert!(!report.steps.is_empty());
    }
}

#[test]
fn the_readings_of_another_whisker_are_no_contact_of_this_one() {
    // A base that turns by half a turn under a millionth of what is read.
    let mut robot = Robot::default();
    robot.whiskers[0].beam.base_stiffness = 1e-9;
    robot.whiskers[0].beam.tip_ratio = 0.02;
    let log = vibrissa::tasks::demo::sweep(1).unwrap().log;
    let report = contacts(&log, &robot, &ContactOptions::default()).unwrap();
    assert!(report.steps.len() > 100 && report.stopped_at.is_none());
    assert!(report.steps.iter().all(|step| step.contact.is_none()), "nothing that bends so is found");
    assert!(report.events.iter().any(|event| event.kind == "no_point"), "{:?}", report.events);
}
