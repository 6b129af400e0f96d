//! A region for the first pose: it decides between places, and opens maps that are too large to search.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

use vibrissa::config::{Region, SettingValue};
use vibrissa::flow::pose::Localization;
use vibrissa::plane::{Curve, Pose2, Vec2};
use vibrissa::tasks::demo;
use vibrissa::world::{Boundary, Map, Robot, Role};
use vibrissa::{Method, Result, localize};

/// The demo's arena, and boxes far away with so much boundary (m).
fn town(boundary: f64) -> Map {
    let mut boundaries = demo::arena().unwrap().boundaries().to_vec();
    for k in 0..(boundary / 4.0).ceil() as usize {
        let corner = Vec2::new(5.0 + 2.0 * (k % 20) as f64, 5.0 + 2.0 * (k / 20) as f64);
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| corner + Vec2::new(x, y));
        let curve = Curve::polyline(&corners, true).unwrap();
        boundaries.push(Boundary::new(Role::Arena, curve, None).unwrap());
    }
    Map::new(boundaries).unwrap()
}

fn run(map: &Map, method: &str, prior: Option<Region>) -> (Pose2, Result<Localization>) {
    let mut sweep = demo::sweep(1).unwrap();
    sweep.log.rows.truncate(240);
    let truth = sweep.truth[0].map_from_robot;
    let mut method = Method::named(method).unwrap();
    if method.has("last_work") {
        method.set("last_work", SettingValue::Count(0)).unwrap();
    }
    if let Some(region) = prior {
        method.set("within", SettingValue::Region(region)).unwrap();
    }
    (truth, localize(&sweep.log, map, &Robot::default(), &method, &mut |_| {}))
}

fn around(pose: Pose2, place: f64, turn: f64) -> [[f64; 2]; 3] {
    [[pose.x - place, pose.x + place], [pose.y - place, pose.y + place], [pose.theta - turn, pose.theta + turn]]
}

const METHODS: [&str; 3] = ["deterministic", "possibilistic", "probabilistic"];

#[test]
fn maps_too_large_to_search_say_what_helps() {
    for method in METHODS {
        let (_, answer) = run(&town(4000.0), method, None);
        let message = answer.unwrap_err().to_string();
        assert!(message.contains("--within") && message.contains("too much boundary"), "{method:?}: {message}");
    }
}

#[test]
fn a_region_gives_the_answer_of_a_small_map_on_a_large_one() {
    let truth = demo::sweep(1).unwrap().truth[0].map_from_robot;
    let region = around(truth, 0.02, 0.2);
    for method in METHODS {
        let small = run(&town(0.0), method, Some(region)).1.unwrap();
        let large = run(&town(400.0), method, Some(region)).1.unwrap();
        assert_eq!(small.status, large.status, "{method:?}");
        let (a, b) = (small.estimate.unwrap(), large.estimate.unwrap());
        assert!(a.position().distance(b.position()) < 1e-3, "{method:?}: {a:?} {b:?}");
    }
}

#[test]
fn the_deterministic_method_stays_in_the_region() {
    let truth = demo::sweep(1).unwrap().truth[0].map_from_robot;
    let region = around(truth, 0.03, 0.3);
    let map = town(0.0);
    let everywhere = run(&map, "deterministic", None).1.unwrap();
    let within = run(&map, "deterministic", Some(region)).1.unwrap();
    assert!(!within.first_states.is_empty() && 2 * within.first_states.len() < everywhere.first_states.len());
    // What entered in the region is what entered there without one.
    let same = |a: &Pose2| everywhere.first_states.iter().any(|b| a.position().distance(b.position()) < 1e-12);
    assert!(within.first_states.iter().filter(|a| same(a)).count() * 10 >= within.first_states.len() * 9);
    // A region that the robot is not in has no answer, or another one.
    let wrong = run(&map, "deterministic", Some(around(Pose2::new(9.0, 9.0, 0.0), 0.01, 0.1))).1.unwrap();
    assert!(wrong.first_states.is_empty() && wrong.estimate.is_none());
}
