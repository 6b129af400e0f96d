//! What is said before the end: for every method it changes nothing, agrees with the answer, and keeps its promises on
//! the way.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

use vibrissa::flow::pose::{Estimate, Localization, Status};
use vibrissa::localizer::Localizer;
use vibrissa::plane::{Pose2, wrap_angle};
use vibrissa::sim::Sweep;
use vibrissa::tasks::demo;
use vibrissa::world::Robot;
use vibrissa::{Method, localize};

/// The answer after an estimate at every row, and these estimates.
fn watched(sweep: &Sweep, method: &Method) -> (Localization, Vec<Estimate>) {
    let (map, robot) = (demo::arena().unwrap(), Robot::default());
    let mut localizer = Localizer::new(&map, &robot, &sweep.log.channels, method).unwrap();
    assert_eq!(localizer.estimate(), Estimate::default());
    let mut estimates = Vec::new();
    for row in &sweep.log.rows {
        localizer.step(row).unwrap();
        estimates.push(localizer.estimate());
        assert_eq!(estimates.last(), Some(&localizer.estimate()));
    }
    (localizer.finish(), estimates)
}

/// Method by method on one sweep: the answer, the estimates, and the true poses.
fn each(seed: u64, mut check: impl FnMut(&Method, &Localization, &[Estimate], &[Pose2])) {
    let sweep = demo::sweep(seed).unwrap();
    let truth: Vec<Pose2> = sweep.truth.iter().map(|stamped| stamped.map_from_robot).collect();
    for method in Method::all() {
        let (answer, estimates) = watched(&sweep, &method);
        check(&method, &answer, &estimates, &truth);
    }
}

#[test]
fn asking_changes_no_bit_of_the_answer() {
    let (map, sweep) = (demo::arena().unwrap(), demo::sweep(1).unwrap());
    for method in Method::all() {
        let (watched, _) = watched(&sweep, &method);
        let alone = localize(&sweep.log, &map, &Robot::default(), &method, &mut |_| {}).unwrap();
        // Debug output has every digit, the sign of zero and what is not a number.
        assert_eq!(format!("{watched:?}"), format!("{alone:?}"), "{method}");
        assert_eq!(watched.method, method.name());
    }
}

#[test]
fn the_last_estimate_is_near_the_answer_and_the_truth() {
    each(2, |method, answer, estimates, truth| {
        let last = estimates.last().unwrap();
        let (now, truth) = (last.pose().unwrap(), truth.last().unwrap());
        let (off, turn) = (now.position().distance(truth.position()), wrap_angle(now.theta - truth.theta).abs());
        let end = now.position().distance(answer.estimate.unwrap().position());
        println!("{method}: {} {} {:.3} mm, {:.3} mm", last.status, answer.status, 1e3 * off, 1e3 * end);
        assert_eq!(answer.status, Status::Localized, "{method}");
        // What encloses every possible state shrinks in the last effort, and is one large place before.
        if !answer.encloses {
            assert_eq!(last.status, Status::Localized, "{method}");
            assert!(off < 2e-3 && turn < 0.03 && end < 2e-3, "{method}: {off} {turn} {end}");
        }
        assert_eq!(last.rows, estimates.len());
    });
}

#[test]
fn verdicts_and_weights_make_sense_at_every_row() {
    each(3, |method, answer, estimates, _| {
        assert_eq!(estimates[0].status, Status::NoContact, "{method}");
        for (row, estimate) in estimates.iter().enumerate() {
            let total: f64 = estimate.hypotheses.iter().map(|h| h.weight).sum();
            assert!(estimate.hypotheses.is_empty() || (total - 1.0).abs() < 1e-9, "{method}, row {row}: {total}");
            assert!(estimate.hypotheses.windows(2).all(|w| w[0].weight >= w[1].weight), "{method}, row {row}");
            assert!(estimate.hypotheses.iter().all(|h| h.ridge.is_empty()), "{method}, row {row}");
            assert_ne!(estimate.status, Status::Inconsistent, "{method}, row {row}");
        }
        let known = estimates.iter().filter(|e| e.status == Status::Localized).count();
        println!("{method}: localized after {} of {} rows", estimates.len() - known, estimates.len());
        assert!(answer.encloses || known > 10, "{method}");
    });
}

#[test]
fn what_bounds_allow_is_never_left_out_on_the_way() {
    let sweep = demo::sweep(1).unwrap();
    let (_, estimates) = watched(&sweep, &Method::Possibilistic(Default::default()));
    let mut held = 0;
    for (estimate, truth) in estimates.iter().zip(&sweep.truth) {
        let truth = truth.map_from_robot;
        let inside = estimate.hypotheses.iter().any(|h| {
            let e = &h.extent;
            let middle = 0.5 * (e.theta.lo() + e.theta.hi());
            let theta = middle + wrap_angle(truth.theta - middle);
            e.x.contains(truth.x) && e.y.contains(truth.y) && e.theta.contains(theta)
        });
        assert!(inside || estimate.hypotheses.is_empty(), "row {}", estimate.rows);
        held += usize::from(inside);
    }
    assert!(held > 200, "{held}");
}
