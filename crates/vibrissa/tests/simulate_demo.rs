//! The whole corridor on a simulated sweep: the demo finds itself, whatever the noise.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

use vibrissa::flow::pose::Status;
use vibrissa::flow::trajectory::trajectory_error;
use vibrissa::tasks::demo;
use vibrissa::world::Robot;
use vibrissa::{Method, localize};

#[test]
fn the_demo_is_localized_for_several_seeds() {
    let map = demo::arena().unwrap();
    for seed in [1, 2, 3] {
        let sweep = demo::sweep(seed).unwrap();
        let answer = localize(&sweep.log, &map, &Robot::default(), &Method::default(), &mut |_row| ()).unwrap();
        let error = trajectory_error(&answer.trajectory, &sweep.truth).unwrap();
        println!("seed {seed}: {:?}, {:.3} mm", answer.status, error.final_position * 1e3);
        assert_eq!(answer.status, Status::Localized, "seed {seed}");
        assert!(error.final_position < 2e-3, "seed {seed}: {} m", error.final_position);
        assert!(error.final_heading < 1.0_f64.to_radians(), "seed {seed}: {} rad", error.final_heading);
    }
}

#[test]
fn the_demos_whisker_stays_on_the_upper_wall() {
    let sweep = demo::sweep(1).unwrap();
    let kinds: Vec<&str> = sweep.events.iter().map(|event| event.kind).collect();
    assert_eq!(kinds, ["onset"], "one touch, no snap");
    assert!(sweep.contacts.iter().all(|touch| touch.position.y > 0.28));
    let strongest = sweep.exact_moments.iter().map(|m| m[0]).fold(0.0, f64::max);
    assert!(strongest > 2e-3 && strongest < 5e-3, "{strongest} N m");
}
