//! What must hold of every localization: verdicts on clear cases, and symmetries of the world that change nothing.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

use vibrissa::config::DeterministicOptions;
use vibrissa::flow::pose::{Localization, StampedPose, Status};
use vibrissa::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
use vibrissa::plane::{Curve, Pose2, Segment, Vec2, wrap_angle};
use vibrissa::sim::{Pace, Sweep, SweepNoise, path_through, simulate_tip_sweep};
use vibrissa::tasks::demo;
use vibrissa::world::{Boundary, Map, Robot, Role};
use vibrissa::{Method, localize};

fn answer(log: &SensorLog, map: &Map) -> Localization {
    localize(log, map, &Robot::default(), &Method::Deterministic(Default::default()), &mut |_| {}).unwrap()
}

fn demo_answer(seed: u64) -> (Sweep, Localization) {
    let sweep = demo::sweep(seed).unwrap();
    let found = answer(&sweep.log, &demo::arena().unwrap());
    (sweep, found)
}

/// Distance (m) and turn (rad) between two poses.
fn apart(a: Pose2, b: Pose2) -> (f64, f64) {
    (a.position().distance(b.position()), wrap_angle(a.theta - b.theta).abs())
}

/// The map with every point moved by `place`.
fn moved(map: &Map, place: impl Fn(Vec2) -> Vec2) -> Map {
    let boundary = |b: &Boundary| {
        let segment = |s: &Segment| match *s {
            Segment::Line(p) => Segment::Line(p.map(&place)),
            Segment::Quadratic(p) => Segment::Quadratic(p.map(&place)),
            Segment::Cubic(p) => Segment::Cubic(p.map(&place)),
        };
        let segments = b.curve().segments().iter().map(segment).collect();
        let curve = Curve::from_segments(segments, b.curve().is_closed()).unwrap();
        Boundary::new(b.role(), curve, None).unwrap()
    };
    Map::new(map.boundaries().iter().map(boundary).collect()).unwrap()
}

fn log(rows: impl IntoIterator<Item = (f64, Pose2, f64)>) -> SensorLog {
    let row =
        |(t, odom_from_robot, moment)| LogRow { t, odom_from_robot, readings: vec![moment], heading: None, line: 7 };
    SensorLog {
        channels: vec![Channel { whisker: String::new(), quantity: Quantity::Moment }],
        rows: rows.into_iter().map(row).collect(),
        ..SensorLog::default()
    }
}

#[test]
fn the_demo_is_localized_whatever_the_noise() {
    for seed in [1, 2, 3, 1000] {
        let (sweep, found) = demo_answer(seed);
        let (distance, turn) = apart(found.estimate.unwrap(), sweep.truth.last().unwrap().map_from_robot);
        assert_eq!(found.status, Status::Localized, "seed {seed}: {:?}", found.hypotheses);
        assert!(distance < 2e-3 && turn < 1.0_f64.to_radians(), "seed {seed}: {distance} m, {turn} rad");
        let extent = found.hypotheses[0].extent;
        let truth = sweep.truth.last().unwrap().map_from_robot;
        assert!(extent.x.contains(truth.x) && extent.y.contains(truth.y), "seed {seed}: {extent:?} {truth:?}");
    }
}

#[test]
fn nobody_stands_outside_the_room() {
    // Along a straight wall the place is open up to the corners, where observations may be missed. (6 mm, and 2 mm to the last row.)
    let corners = [(0.0, 0.0), (0.5, 0.0), (0.5, 0.3), (0.0, 0.3)].map(|(x, y)| Vec2::new(x, y));
    let room = Boundary::new(Role::Arena, Curve::polyline(&corners, true).unwrap(), None).unwrap();
    let map = Map::new(vec![room]).unwrap();
    let heading = 128.0_f64.to_radians();
    let way = [(0.385, 0.225), (0.405, 0.25), (0.478, 0.25)].map(|(x, y)| Pose2::new(x, y, heading));
    let path = path_through(&way, &Pace { speed: 0.15, turn_rate: 1.0, rate: 300.0 }).unwrap();
    let noise = SweepNoise { seed: 3, ..SweepNoise::default() };
    let sweep = simulate_tip_sweep(&map, &Robot::default(), &path, &noise).unwrap();
    let found = answer(&sweep.log, &map);
    let far_out = |p: Vec2| !map.is_free(p) && map.nearest_within(p, 9e-3).is_none();
    let places: Vec<Vec2> = found.states.iter().map(|b| Vec2::new(b.x.lo(), b.y.lo())).collect();
    assert!(found.status == Status::Ambiguous && places.len() > 100, "{} {}", found.status, places.len());
    assert_eq!(places.iter().filter(|p| far_out(**p)).count(), 0);
    // The first states, too.
    assert!(found.first_states.len() > 100 && !found.first_states.iter().any(|p| far_out(p.position())));
    let truth = sweep.truth.last().unwrap().map_from_robot;
    let holds = |e: &vibrissa::sets::StateBox| e.x.contains(truth.x) && e.y.contains(truth.y);
    assert!(found.hypotheses.iter().any(|h| holds(&h.extent)));
}

#[test]
fn the_same_log_gives_the_same_answer() {
    let (_, first) = demo_answer(5);
    let (_, again) = demo_answer(5);
    assert_eq!(first, again);
}

#[test]
fn the_odometry_frame_does_not_matter() {
    let (sweep, found) = demo_answer(2);
    let elsewhere = Pose2::new(-13.0, 4.5, 2.6);
    let rows = sweep.log.rows.iter().map(|r| (r.t, elsewhere.compose(r.odom_from_robot), r.readings[0]));
    let other = answer(&log(rows), &demo::arena().unwrap());
    let (distance, turn) = apart(found.estimate.unwrap(), other.estimate.unwrap());
    // Rounding decides which of two candidates survives a merger; both are within the answer's uncertainty.
    assert!(distance < 0.5e-3 && turn < 5e-3, "{distance} {turn}");
    assert_eq!(found.status, other.status);
}

#[test]
fn a_moved_world_moves_the_answer() {
    let (sweep, found) = demo_answer(2);
    for motion in [Pose2::new(0.3, -2.0, 0.7), Pose2::new(-5.0, 1.0, -2.9)] {
        let map = moved(&demo::arena().unwrap(), |p| motion.transform_point(p));
        let other = answer(&sweep.log, &map);
        let (distance, turn) = apart(motion.compose(found.estimate.unwrap()), other.estimate.unwrap());
        // Where candidates merge depends on the frame; the answer may differ by a fraction of its own uncertainty.
        assert!(distance < 0.5e-3 && turn < 5e-3, "{distance} {turn}");
        assert_eq!(found.status, other.status);
    }
}

#[test]
fn a_mirrored_world_mirrors_the_answer() {
    let (sweep, found) = demo_answer(3);
    let map = moved(&demo::arena().unwrap(), |p| Vec2::new(p.x, -p.y));
    let mirror = |p: Pose2| Pose2::new(p.x, -p.y, -p.theta);
    let rows = sweep.log.rows.iter().map(|r| (r.t, mirror(r.odom_from_robot), -r.readings[0]));
    let other = answer(&log(rows), &map);
    let (distance, turn) = apart(mirror(found.estimate.unwrap()), other.estimate.unwrap());
    assert!(distance < 0.5e-3 && turn < 5e-3, "{distance} {turn}");
    assert_eq!(found.status, other.status);
}

/// The options for a world in which every length is `k` times as long.
fn scaled_options(k: f64) -> Method {
    let mut lengths = DeterministicOptions::default();
    lengths.boundary_spacing *= k;
    lengths.history_travel *= k;
    lengths.update_travel *= k;
    lengths.position_floor *= k;
    Method::Deterministic(lengths)
}

#[test]
fn a_world_of_another_size_gives_the_answer_in_that_size() {
    let (sweep, found) = demo_answer(2);
    // M L / EI has no unit: with EI as many times larger as lengths are, moments stay.
    for k in [2.0, 10.0] {
        let mut robot = Robot::default();
        robot.whiskers[0].beam.length *= k;
        robot.whiskers[0].beam.flexural_rigidity *= k;
        let larger = |p: Pose2| Pose2::new(k * p.x, k * p.y, p.theta);
        let rows = sweep.log.rows.iter().map(|r| (r.t, larger(r.odom_from_robot), r.readings[0]));
        let map = moved(&demo::arena().unwrap(), |p| p * k);
        let other = localize(&log(rows), &map, &robot, &scaled_options(k), &mut |_| {}).unwrap();
        let (distance, turn) = apart(larger(found.estimate.unwrap()), other.estimate.unwrap());
        // What counts as one place is 20 mm, whatever the whisker; the errors of ten times its length leave more open.
        let alike = found.status == other.status || (k > 2.0 && other.hypotheses.len() == 1);
        assert!(alike, "{k}: {}", other.status);
        assert!(distance < 0.5e-3 * k && turn < 5e-3, "{k}: {distance} {turn}");
    }
}

#[test]
fn a_log_played_backwards_ends_where_it_began() {
    // Nothing rubs and nothing slips, so that readings depend on places alone, whichever way time runs.
    let (sweep, _) = demo_answer(2);
    let rows = &sweep.log.rows;
    let end = rows[rows.len() - 1].t;
    let back = log(rows.iter().rev().map(|r| (end - r.t, r.odom_from_robot, r.readings[0])));
    let found = answer(&back, &demo::arena().unwrap());
    let (distance, turn) = apart(found.estimate.unwrap(), sweep.truth[0].map_from_robot);
    assert_eq!(found.status, Status::Localized, "{:?}", found.hypotheses);
    assert!(distance < 2e-3 && turn < 1.0_f64.to_radians(), "{distance} m, {turn} rad");
}

#[test]
fn where_an_outline_starts_and_which_way_it_is_drawn_does_not_matter() {
    let (sweep, found) = demo_answer(2);
    let arena = demo::arena().unwrap();
    let mut boundaries: Vec<Boundary> = arena.boundaries().iter().rev().cloned().collect();
    for (index, boundary) in boundaries.iter_mut().enumerate() {
        let mut segments = boundary.curve().segments().to_vec();
        if boundary.curve().is_closed() {
            let third = segments.len() / 3;
            segments.rotate_left(third);
        }
        if index % 2 == 0 {
            segments = segments.iter().rev().map(Segment::reversed).collect();
        }
        let curve = Curve::from_segments(segments, boundary.curve().is_closed()).unwrap();
        *boundary = Boundary::new(boundary.role(), curve, None).unwrap();
    }
    let other = answer(&sweep.log, &Map::new(boundaries).unwrap());
    let (distance, turn) = apart(found.estimate.unwrap(), other.estimate.unwrap());
    assert_eq!(found.status, other.status);
    assert!(distance < 0.5e-3 && turn < 5e-3, "{distance} {turn}");
}

#[test]
fn the_order_of_whiskers_and_columns_does_not_matter() {
    let mut sweep = demo::sweep(2).unwrap();
    sweep.log.rows.truncate(250);
    let mut robot = Robot::default();
    let mut idle = robot.whiskers[0].clone();
    robot.whiskers[0].name = "feels".into();
    idle.name = "idle".into();
    robot.whiskers.push(idle);
    let two = |names: [&str; 2]| {
        let channel = |name: &str| Channel { whisker: name.into(), quantity: Quantity::Moment };
        let mut log = log(sweep.log.rows.iter().map(|r| (r.t, r.odom_from_robot, r.readings[0])));
        log.channels = names.map(channel).to_vec();
        for row in &mut log.rows {
            let moment = row.readings[0];
            row.readings = names.map(|name| if name == "feels" { moment } else { 0.0 }).to_vec();
        }
        log
    };
    let arena = demo::arena().unwrap();
    let run = |log: &SensorLog, robot: &Robot| {
        localize(log, &arena, robot, &Method::Deterministic(Default::default()), &mut |_| {}).unwrap()
    };
    let first = run(&two(["feels", "idle"]), &robot);
    assert_eq!(first, run(&two(["idle", "feels"]), &robot));
    robot.whiskers.reverse();
    let mut reversed = run(&two(["feels", "idle"]), &robot);
    reversed.shapes.iter_mut().for_each(|shape| shape.whisker = 1 - shape.whisker);
    assert_eq!(first, reversed);
    let alone = answer(&sweep.log, &arena);
    assert_eq!(first.estimate, alone.estimate, "a whisker that touches nothing tells nothing");
}

fn square_room() -> Map {
    let corners = [(-0.25, -0.25), (0.25, -0.25), (0.25, 0.25), (-0.25, 0.25)].map(|(x, y)| Vec2::new(x, y));
    Map::new(vec![Boundary::new(Role::Arena, Curve::polyline(&corners, true).unwrap(), None).unwrap()]).unwrap()
}

#[test]
fn congruent_places_are_kept_apart() {
    // Along the upper wall, then a turn: position along the wall and which wall stay open.
    let way = [Pose2::new(-0.05, 0.18, 2.2), Pose2::new(-0.05, 0.2, 2.2), Pose2::new(0.1, 0.2, 2.2)];
    let path: Vec<StampedPose> = path_through(&way, &Pace { speed: 0.15, turn_rate: 1.0, rate: 300.0 }).unwrap();
    let sweep = simulate_tip_sweep(&square_room(), &Robot::default(), &path, &SweepNoise::seeded(4)).unwrap();
    let found = answer(&sweep.log, &square_room());
    assert_eq!(found.status, Status::Ambiguous);
    assert_eq!(found.hypotheses.len(), 4, "{:?}", found.hypotheses);
    for place in &found.hypotheses {
        assert!((place.weight - 0.25).abs() < 0.1, "{place:?}");
        let quarter_turns = (place.pose.theta - 2.2) / std::f64::consts::FRAC_PI_2;
        assert!((quarter_turns - quarter_turns.round()).abs() < 0.02, "{place:?}");
    }
    let truth = sweep.truth.last().unwrap().map_from_robot;
    assert!(found.hypotheses.iter().any(|h| h.extent.x.contains(truth.x) && h.extent.y.contains(truth.y)));
}

#[test]
fn a_wrong_map_is_inconsistent() {
    let sweep = demo::sweep(1).unwrap();
    let found = answer(&sweep.log, &square_room());
    assert_eq!(found.status, Status::Inconsistent, "{:?}", found.hypotheses);
    assert!(found.hypotheses.is_empty() && found.estimate.is_none() && found.states.is_empty());
    let event = found.events.iter().find(|e| e.kind == "inconsistent").expect("the step is named");
    assert!(event.t > 0.0 && event.t < sweep.log.rows.last().unwrap().t);
    assert!(found.trajectory.last().unwrap().t < sweep.log.rows.last().unwrap().t);
}

#[test]
fn nothing_touched_is_no_contact() {
    let rows = (0..300).map(|k| (f64::from(k) * 1e-2, Pose2::new(f64::from(k) * 1e-3, 0.0, 0.0), 1.5e-5));
    let found = answer(&log(rows), &square_room());
    assert_eq!(found.status, Status::NoContact);
    assert!(found.trajectory.is_empty() && found.steps.is_empty() && found.events.is_empty());
}

#[test]
fn a_touch_that_is_too_short_says_so() {
    let rows = (0..100).map(|k| {
        let moment = if (50..53).contains(&k) { 1e-3 } else { 0.0 };
        (f64::from(k) * 1e-2, Pose2::new(f64::from(k) * 1e-3, 0.0, 0.0), moment)
    });
    let found = answer(&log(rows), &square_room());
    assert_eq!(found.status, Status::Ambiguous);
    assert!(found.hypotheses.is_empty() && found.estimate.is_none());
    let kinds: Vec<&str> = found.events.iter().map(|e| e.kind).collect();
    assert_eq!(kinds, ["contact", "lift_off", "too_short"]);
}

#[test]
fn a_moment_beyond_any_shape_is_refused_with_its_line() {
    let rows = [(0.0, Pose2::IDENTITY, 0.0), (0.1, Pose2::IDENTITY, 0.19)];
    let error = localize(
        &log(rows),
        &square_room(),
        &Robot::default(),
        &Method::Deterministic(Default::default()),
        &mut |_| {},
    )
    .unwrap_err();
    assert!(error.is_data() && error.line() == Some(7));
    let text = error.to_string();
    assert!(text.contains("0.19 N m") && text.contains("allowed: at most") && text.contains("mN m"), "{text}");
}
