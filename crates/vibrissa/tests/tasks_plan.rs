//! Motions that tell places apart, against the simulator: what is predicted is felt, and what is admissible hurts nobody.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

use vibrissa::flow::pose::{Hypothesis, StampedPose};
use vibrissa::flow::sensor_log::{Channel, LogRow, Quantity};
use vibrissa::plane::{Curve, Pose2, Vec2};
use vibrissa::sets::StateBox;
use vibrissa::sim::recorder::TrueErrors;
use vibrissa::sim::{Drive, Pace, SimulateOptions, Stage, SweepNoise, path_through};
use vibrissa::tasks::plan::{
    Criterion, Motion, Past, Plan, PlanOptions, PlanVerdict, Planner, RemainingState, admissible, history, plan,
    remaining, test_of, to_json,
};
use vibrissa::world::{Boundary, Map, MountedWhisker, Robot, Role};

/// A room that has a bay in one wall.
const BAY: [(f64, f64); 8] =
    [(0.0, 0.0), (0.25, 0.0), (0.25, -0.05), (0.32, -0.05), (0.32, 0.0), (0.5, 0.0), (0.5, 0.3), (0.0, 0.3)];
const RECTANGLE: [(f64, f64); 4] = [(0.0, 0.0), (0.5, 0.0), (0.5, 0.3), (0.0, 0.3)];

fn room(corners: &[(f64, f64)]) -> Map {
    let corners: Vec<Vec2> = corners.iter().map(|&(x, y)| Vec2::new(x, y)).collect();
    Map::new(vec![Boundary::new(Role::Arena, Curve::polyline(&corners, true).unwrap(), None).unwrap()]).unwrap()
}

/// A robot whose whisker points ahead to the right.
fn robot() -> Robot {
    let whisker = MountedWhisker { robot_from_whisker: Pose2::new(0.0, 0.0, -0.8), ..MountedWhisker::default() };
    Robot { whiskers: vec![whisker], ..Robot::default() }
}

fn state(place: usize, pose: Pose2) -> RemainingState {
    RemainingState { pose, weight: 1.0, place, covariance: [[0.0; 3]; 3] }
}

/// How far the origin is off a wall that bends the whisker by 8 mm.
fn off() -> f64 {
    0.075 * 0.8_f64.sin() - 0.008
}

/// The robot along the lower wall, whisker on it, and along the upper one.
fn two_places() -> [RemainingState; 2] {
    [state(0, Pose2::new(0.12, off(), 0.0)), state(1, Pose2::new(0.38, 0.3 - off(), core::f64::consts::PI))]
}

fn options() -> PlanOptions {
    PlanOptions { footprint: 0.015, ..PlanOptions::default() }
}

/// A robot that was brought to a state, whisker bent.
fn brought<'a>(stage: &'a Stage, state: &RemainingState) -> Drive<'a> {
    // From the side of the room, where the whisker is free.
    let lift = Vec2::from_angle(state.pose.theta + core::f64::consts::FRAC_PI_2) * 0.012;
    let above = Pose2::new(state.pose.x + lift.x, state.pose.y + lift.y, state.pose.theta);
    let mut drive = Drive::start(stage, StampedPose { t: 0.0, map_from_robot: above }, &SweepNoise::none()).unwrap();
    go(&mut drive, &[above, state.pose], &[f64::INFINITY], &mut |_, _| {});
    drive
}

/// Goes through waypoints until a whisker reads so much.
fn go(drive: &mut Drive<'_>, waypoints: &[Pose2], stop_at: &[f64], each: &mut dyn FnMut(Pose2, &[f64])) {
    let begin = drive.pose().t;
    let Ok(path) = path_through(waypoints, &Pace { speed: 0.1, turn_rate: 1.0, rate: 50.0 }) else { return };
    for pose in &path[1..] {
        let row = drive.advance(StampedPose { t: begin + pose.t, ..*pose }, &TrueErrors::default(), 0.0).unwrap();
        each(pose.map_from_robot, &row.readings);
        if row.readings.iter().zip(stop_at).any(|(z, most)| z.abs() >= *most) {
            return;
        }
    }
}

/// The readings of a place along a motion.
fn felt(map: &Map, state: &RemainingState, motion: &Motion, stop_at: &[f64]) -> Vec<f64> {
    let simulate = SimulateOptions { links: 30, ..SimulateOptions::default() };
    let stage = Stage::new(map.clone(), robot(), simulate).unwrap();
    let mut drive = brought(&stage, state);
    let mut readings = Vec::new();
    let waypoints: Vec<Pose2> = motion.waypoints().iter().map(|pose| state.pose.compose(*pose)).collect();
    go(&mut drive, &waypoints, stop_at, &mut |_, z| readings.push(z[0]));
    readings
}

fn planned(map: &Map, states: &[RemainingState], options: &PlanOptions) -> Plan {
    plan(map, &robot(), states, &Past::default(), options).unwrap()
}

#[test]
fn a_motion_that_parts_two_places_is_felt_otherwise_at_each() {
    let map = room(&BAY);
    let states = two_places();
    let plan = planned(&map, &states, &options());
    assert_eq!(plan.verdict, PlanVerdict::Parts, "{}", plan.words());
    let next = plan.next.as_ref().unwrap();
    assert_eq!(next.places, [1, 1], "{}", plan.words());
    assert!((next.information - core::f64::consts::LN_2).abs() < 1e-9 && plan.extent[0] > 0.1 && next.extent[0] < 1e-9);
    assert!(next.motion.way() <= options().longest + 0.1 && plan.words().contains("parts all 2 places"));
    // By the simulator: its readings differ by more than twice the noise at several rows.
    let [one, other] = [0, 1].map(|k| felt(&map, &states[k], &next.motion, &next.stop_at));
    let noise = robot().whiskers[0].noise;
    let differ = |(a, b): &(&f64, &f64)| {
        let ([low, high], [least, most]) = (noise.readings(**a), noise.readings(**b));
        low > most || least > high
    };
    let apart = one.iter().zip(&other).filter(differ).count() + one.len().abs_diff(other.len());
    assert!(apart >= 5, "{apart} rows of {} and {}", one.len(), other.len());
    // The places felt alike before.
    assert!((one[0] - other[0]).abs() < 1e-5, "{} {}", one[0], other[0]);
}

#[test]
fn a_symmetric_room_is_told_as_such() {
    let map = room(&RECTANGLE);
    for criterion in [Criterion::Expected, Criterion::Worst] {
        let plan = planned(&map, &two_places(), &PlanOptions { criterion, ..options() });
        assert_eq!((plan.verdict, plan.next.is_none()), (PlanVerdict::Symmetric, true), "{}", plan.words());
        assert!(plan.words().contains("the map is symmetric"));
        // Every admissible motion is felt alike at both places.
        let states = two_places();
        let (motions, stop_at) = admissible(&map, &robot(), &states, &Past::default(), &options()).unwrap();
        assert!(motions.len() > 5);
        for motion in motions.iter().step_by(4) {
            let [one, other] = [0, 1].map(|k| felt(&map, &states[k], motion, &stop_at));
            assert_eq!(one.len(), other.len());
            let most = one.iter().zip(&other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(most < 1e-5, "{}: {most}", motion.name());
        }
    }
    // A place that no turn of the room takes onto the first is not symmetric to it.
    let [first, _] = two_places();
    let beside = state(1, Pose2::new(0.30, off(), 0.0));
    assert_ne!(planned(&map, &[first, beside], &options()).verdict, PlanVerdict::Symmetric);
}

#[test]
fn admissible_motions_collide_nowhere_and_press_gently_at_all_places() {
    let map = room(&BAY);
    let mut states = two_places().to_vec();
    // Places that weigh nothing, near walls that the others are far from.
    let nothing = |place, pose| RemainingState { weight: 0.0, ..state(place, pose) };
    states.push(nothing(2, Pose2::new(0.06, off(), 0.0)));
    states.push(nothing(3, Pose2::new(0.44, 0.3 - off(), core::f64::consts::PI)));
    for sideways in [true, false] {
        let options = PlanOptions { sideways, ..options() };
        let (motions, stop_at) = admissible(&map, &robot(), &states, &Past::default(), &options).unwrap();
        assert!(motions.len() > 5, "{}", motions.len());
        let most = options.most(&robot().whiskers[0]);
        let stage =
            Stage::new(map.clone(), robot(), SimulateOptions { links: 30, ..SimulateOptions::default() }).unwrap();
        let mut ways = 0.0;
        for motion in &motions {
            for state in &states {
                let mut drive = brought(&stage, state);
                let waypoints: Vec<Pose2> = motion.waypoints().iter().map(|pose| state.pose.compose(*pose)).collect();
                let mut last = state.pose;
                go(&mut drive, &waypoints, &stop_at, &mut |pose, z| {
                    let off = map.nearest(pose.position()).unwrap().distance;
                    assert!(map.is_free(pose.position()) && off > options.footprint, "{}: {off} m", motion.name());
                    assert!(!map.crosses(last.position(), pose.position()));
                    // Between two rows it presses on.
                    assert!(z[0].abs() < 1.1 * most, "{}: {} N m", motion.name(), z[0]);
                    last = pose;
                });
                assert!(drive.events().iter().all(|event| event.kind != "lost"), "{}", motion.name());
            }
            ways += motion.way();
        }
        // They are no motions on the spot alone.
        assert!(ways > 0.5, "{ways} m");
    }
}

#[test]
fn the_plan_is_that_of_its_budget_and_better_with_more() {
    let map = room(&BAY);
    let states = two_places();
    let rate = |budget: usize| {
        let plan = planned(&map, &states, &PlanOptions { budget, ..options() });
        assert!(plan.readings <= budget + states.len(), "{} of {budget}", plan.readings);
        assert_eq!(plan, planned(&map, &states, &PlanOptions { budget, ..options() }));
        (plan.looked_at[0], plan.next.map_or(0.0, |next| next.information))
    };
    let all = [50, 200, 2_000, 100_000].map(rate);
    assert!(all.windows(2).all(|w| w[0].0 <= w[1].0), "{all:?}");
    assert!(all[3].1 > 0.69 && all[0].0 < all[3].0, "{all:?}");
}

/// By how much a reading changes in all.
fn change(readings: &[f64]) -> f64 {
    readings.windows(2).map(|w| (w[1] - w[0]).abs()).sum()
}

#[test]
fn a_test_of_a_place_is_a_short_motion_along_which_much_is_felt() {
    let (map, robot, options) = (room(&BAY), robot(), options());
    let past = Past { history: &[], readings: &[] };
    for x in [0.05, 0.12, 0.2, 0.4] {
        let place = state(0, Pose2::new(x, off(), 0.0));
        let (motion, stop_at) = test_of(&map, &robot, &[place], &past, &options, 0.06).unwrap().expect("none");
        assert!(motion.way() <= 0.06 + 1e-9, "{}", motion.way());
        let own = change(&felt(&map, &place, &motion, &stop_at));
        // The simulator knows nothing of how it was chosen.
        let (all, stop_at) = admissible(&map, &robot, &[place], &past, &options).unwrap();
        let short = all.iter().filter(|motion| motion.way() <= 0.06);
        let most = short.map(|other| change(&felt(&map, &place, other, &stop_at))).fold(0.0, f64::max);
        assert!(own > 0.5 * most && own > 1e-3, "at {x} m: {own} N m by {}, {most} at most", motion.name());
    }
    // Where nothing is within reach nothing can be tested.
    let hall = room(&[(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)]);
    let alone = state(0, Pose2::new(1.0, 1.0, 0.0));
    assert_eq!(test_of(&hall, &robot, &[alone], &past, &options, 0.06).unwrap(), None);
}

#[test]
fn one_small_place_is_known_and_a_robot_shut_in_stays() {
    let map = room(&BAY);
    let [one, _] = two_places();
    assert_eq!(planned(&map, &[one], &options()).verdict, PlanVerdict::Known);
    let shut_in = PlanOptions { footprint: 0.2, ..options() };
    let plan = planned(&map, &two_places(), &shut_in);
    assert_eq!((plan.verdict, plan.looked_at[1]), (PlanVerdict::Confined, 0));
}

#[test]
fn ridges_are_sampled_and_unlikely_places_weigh_nothing() {
    let at = |x: f64, weight: f64, ridge: &[f64]| Hypothesis {
        pose: Pose2::new(x, 0.05, 0.0),
        weight,
        extent: StateBox::EMPTY,
        covariance: Some([[1e-3, 0.0, 0.0], [0.0, 1e-8, 0.0], [0.0, 0.0, 1e-6]]),
        ridge: ridge.iter().map(|&x| Pose2::new(x, 0.05, 0.0)).collect(),
    };
    let states = remaining(&[at(0.1, 0.7, &[0.1, 0.12, 0.26]), at(0.4, 0.297, &[]), at(0.45, 0.003, &[])], 64);
    let of = |place: usize| states.iter().filter(|s| s.place == place).collect::<Vec<_>>();
    assert_eq!((of(0).len(), of(1).len(), of(2).len()), (21, 17, 1));
    assert_eq!((of(2)[0].pose.x, of(2)[0].weight), (0.45, 0.0));
    // Even steps along the ridge, and two standard deviations to both sides.
    assert!((of(0)[20].pose.x - 0.26).abs() < 1e-12 && (of(0)[10].pose.x - 0.18).abs() < 1e-12);
    assert!((of(1)[0].pose.x - of(1)[16].pose.x).abs() - 4.0 * 1e-3_f64.sqrt() < 1e-12);
    // What the samples stand for is not in their covariances.
    assert!(states.iter().all(|s| s.covariance[0][0].abs() < 1e-12));
    assert!(states.iter().all(|s| (s.covariance[1][1] > 0.0) == (s.weight > 0.0)));
    assert!((states.iter().map(|s| s.weight).sum::<f64>() - 0.997).abs() < 1e-12);
    assert!(remaining(&[at(0.1, 0.7, &[0.1, 0.12, 0.26]), at(0.4, 0.3, &[0.0, 0.3])], 20).len() <= 20);
}

#[test]
fn a_place_that_weighs_nothing_is_kept_from_harm_and_told_apart_from_none() {
    let (map, robot, past, options) = (room(&RECTANGLE), robot(), Past::default(), options());
    let likely = state(0, Pose2::new(0.12, off(), 0.0));
    // The right wall is near.
    let unlikely = RemainingState { weight: 0.0, ..state(1, Pose2::new(0.44, off(), 0.0)) };
    let both = [unlikely, likely];
    let longest = |states: &[RemainingState]| {
        let all = admissible(&map, &robot, states, &past, &options).unwrap().0;
        all.iter().map(Motion::way).fold(0.0, f64::max)
    };
    let ahead = |states: &[RemainingState]| {
        let all = admissible(&map, &robot, states, &past, &options).unwrap().0;
        all.iter().filter(|motion| motion.name() == "straight ahead").map(Motion::way).fold(0.0, f64::max)
    };
    assert!(longest(&[likely]) > 0.2 && ahead(&[likely]) > 0.2 && ahead(&both) < 0.06, "{}", ahead(&both));
    let (one, two) = (planned(&map, &[likely], &options), planned(&map, &both, &options));
    assert_eq!((one.places, two.places, one.verdict), (1, 1, two.verdict));
}

#[test]
fn what_makes_no_sense_is_refused() {
    let (map, robot, past) = (room(&BAY), robot(), Past::default());
    let refused = |states: &[RemainingState], options: &PlanOptions| {
        plan(&map, &robot, states, &past, options).err().map(|error| error.to_string()).unwrap_or_default()
    };
    assert!(refused(&[], &options()).contains("at least one"));
    let lost = state(0, Pose2 { x: f64::NAN, y: 0.0, theta: 0.0 });
    assert!(refused(&[lost], &options()).contains("finite"));
    let states = two_places();
    for (options, name) in [
        (PlanOptions { longest: 0.0, ..options() }, "longest"),
        (PlanOptions { footprint: -1.0, ..options() }, "footprint"),
        (PlanOptions { largest_moment: Some(0.0), ..options() }, "moment"),
        (PlanOptions { states: 0, ..options() }, "states"),
    ] {
        assert!(refused(&states, &options).contains(name), "{name}");
    }
}

/// A place that is known well.
fn hypothesis(pose: Pose2, weight: f64) -> Hypothesis {
    Hypothesis { pose, weight, extent: StateBox::EMPTY, covariance: Some([[0.0; 3]; 3]), ridge: Vec::new() }
}

#[test]
fn a_planner_knows_of_its_rows_what_a_plan_looks_at_and_when_the_robot_rests() {
    let channels = [Channel { whisker: String::new(), quantity: Quantity::Moment }];
    let mut planner = Planner::new(&robot(), &channels, options()).unwrap();
    assert_eq!(planner.rest(), None);
    let mut way = Vec::new();
    let mut row = |planner: &mut Planner, t: f64, x: f64, turn: f64, reading: f64| {
        let odom_from_robot = Pose2::new(x, 0.3 * x, turn);
        way.push(odom_from_robot);
        planner.row(&LogRow { t, odom_from_robot, readings: vec![reading], heading: None, line: 0 });
    };
    // A metre at 1 mm a row, turning on; then an hour of rest with odometry that trembles by 50 µm.
    for k in 0..1000 {
        let s = f64::from(k);
        row(&mut planner, 0.01 * s, 1e-3 * s, 2e-3 * s, 1e-6 * s);
        assert!(planner.rest().unwrap().0 < 1e-9);
    }
    for k in 0..36_000 {
        let tremble = if k % 2 == 0 { 0.0 } else { 5e-5 };
        row(&mut planner, 10.0 + 0.1 * f64::from(k), 0.999 + tremble, 1.998, 3e-3);
    }
    let (rested, since) = planner.rest().unwrap();
    assert!((rested - 3599.9 - 0.01).abs() < 1e-6 && (since - 9.99).abs() < 1e-9, "{rested} s from {since} s on");
    // As from the whole log, to within the poses that are left out, and no longer.
    let (kept, readings) = planner.past();
    let whole = history(way.iter().copied());
    assert_eq!(readings, [3e-3]);
    assert!(kept.len() >= 10 && kept.len().abs_diff(whole.len()) <= 2, "{} {}", kept.len(), whole.len());
    assert!(kept[0].position().distance(whole[0].position()) < 5e-3, "{:?} {:?}", kept[0], whole[0]);
    assert!(planner.way().count() < 400, "{}", planner.way().count());
    assert_eq!(planner.way().next(), way.last().copied());
    // It plans as `plan` does.
    let map = room(&BAY);
    let places: Vec<Hypothesis> = two_places().iter().map(|state| hypothesis(state.pose, 0.5)).collect();
    let planner = Planner::new(&robot(), &channels, options()).unwrap();
    let found = planner.plan(&map, &robot(), &places).unwrap();
    assert_eq!(found, planned(&map, &remaining(&places, options().states), &options()));
    let json = to_json(&found);
    assert_eq!(json["verdict"], "parts");
    assert_eq!(json["next"]["waypoints"].as_array().unwrap().len(), found.next.unwrap().motion.waypoints().len());
    assert!(Planner::new(&robot(), &channels, PlanOptions { longest: 0.0, ..options() }).is_err());
}
