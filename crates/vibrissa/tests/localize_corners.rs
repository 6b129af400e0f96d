//! Sweeps around the corners of rooms, out of which the whisker snaps.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

#[path = "data/long_sweep.rs"]
mod long_sweep;
#[path = "data/mistaken.rs"]
mod mistaken;
#[path = "data/random.rs"]
mod random;

use long_sweep::long_sweep;
use mistaken::mistaken;
use vibrissa::beam::{TipModel, Whisker};
use vibrissa::config::{PossibilisticOptions, ProbabilisticOptions};
use vibrissa::flow::pose::{StampedPose, Status};
use vibrissa::flow::state_set::probabilistic::predicted_moments;
use vibrissa::plane::{Curve, Pose2, Vec2, wrap_angle};
use vibrissa::sets::StateBox;
use vibrissa::sim::Sweep;
use vibrissa::world::{Boundary, Map, Robot, Role};
use vibrissa::{Method, localize};

/// A room of this half width and height (m) with a post where no turn of the room takes it onto itself.
fn room(x: f64, y: f64) -> Map {
    let corners = [Vec2::new(-x, -y), Vec2::new(x, -y), Vec2::new(x, y), Vec2::new(-x, y)];
    let walls = Boundary::new(Role::Arena, Curve::polyline(&corners, true).unwrap(), None).unwrap();
    let post = Boundary::new(Role::Obstacle, Curve::circle(Vec2::new(0.03, -0.01), 0.01).unwrap(), None).unwrap();
    Map::new(vec![walls, post]).unwrap()
}

fn snaps(sweep: &Sweep) -> usize {
    sweep.events.iter().filter(|event| event.kind == "snap").count()
}

/// The first sweeps of these seeds in which the whisker snaps.
fn snapping(map: &Map, seeds: core::ops::Range<u64>, most: usize) -> Vec<Sweep> {
    seeds.filter_map(|seed| long_sweep(map, seed)).filter(|sweep| snaps(sweep) > 0).take(most).collect()
}

#[test]
fn after_a_snap_the_whisker_rests_where_the_simulator_says() {
    let (mut rows, mut odd, mut snapped) = (0, 0, 0);
    for (map, seeds) in [(room(0.2, 0.2), 1..40), (room(0.35, 0.25), 100..140)] {
        for sweep in snapping(&map, seeds, 4) {
            let path: Vec<Pose2> = sweep.truth.iter().map(|pose| pose.map_from_robot).collect();
            let ours = predicted_moments(&map, &TipModel::new(&Whisker::default()).unwrap(), &path);
            // A fifth of the declared noise.
            let far = |(ours, exact): (f64, f64)| (ours - exact).abs() > 0.01 * exact.abs() + 4e-6;
            let pairs = ours.iter().map(|moment| moment.moment).zip(sweep.exact_moments.iter().map(|row| row[0]));
            let these = pairs.filter(|&pair| far(pair)).count();
            println!("{} rows, {} snaps, {these} odd", path.len(), snaps(&sweep));
            (rows, odd, snapped) = (rows + path.len(), odd + these, snapped + snaps(&sweep));
        }
    }
    println!("{odd} of {rows} rows, {snapped} snaps");
    assert!(snapped >= 8 && odd * 200 < rows, "{odd} of {rows} rows with {snapped} snaps");
}

#[test]
fn a_robot_that_goes_around_corners_is_told_where_it_is() {
    let options = Method::Probabilistic(ProbabilisticOptions::exact());
    let map = room(0.35, 0.25);
    let sweeps = snapping(&map, 100..140, 3);
    assert_eq!(sweeps.len(), 3);
    for sweep in sweeps {
        let answer = localize(&sweep.log, &map, &Robot::default(), &options, &mut |_| {}).unwrap();
        let truth = sweep.truth.last().unwrap().map_from_robot;
        let near = answer.hypotheses.iter().map(|h| {
            (h.pose.position().distance(truth.position()), wrap_angle(h.pose.theta - truth.theta).abs(), h.weight)
        });
        let near = near.min_by(|a, b| a.0.total_cmp(&b.0));
        println!("{} rows, {} snaps: {}, {near:?}", sweep.truth.len(), snaps(&sweep), answer.status);
        assert!(matches!(answer.status, Status::Localized | Status::Ambiguous), "{:?}", answer.events.last());
        let (off, turned, weight) = near.unwrap();
        assert!(off < 3e-4 && turned < 5e-3 && weight > 0.05, "{:.2} mm, weight {weight}", 1e3 * off);
    }
}

/// A room of straight walls of 0.5 to 1.2 m in the shape of an L, with a post of three corners.
fn long_room() -> Map {
    let walls = [(0.0, 0.0), (1.2, 0.0), (1.2, 0.5), (0.6, 0.5), (0.6, 1.1), (0.0, 1.1)];
    let post = [(0.15, 0.2), (0.27, 0.24), (0.22, 0.34)];
    let outline = |role: Role, corners: &[(f64, f64)]| {
        let corners: Vec<Vec2> = corners.iter().map(|&(x, y)| Vec2::new(x, y)).collect();
        Boundary::new(role, Curve::polyline(&corners, true).unwrap(), None).unwrap()
    };
    Map::new(vec![outline(Role::Arena, &walls), outline(Role::Obstacle, &post)]).unwrap()
}

/// A room in the shape of a star, no two of whose fourteen corners are alike.
fn star() -> Map {
    let corner = |k: u32| {
        let n = f64::from(k);
        let radius = if k % 2 == 1 { 0.55 } else { 0.33 } * (1.0 + 0.12 * (2.3 * n).sin());
        Vec2::from_angle(n * core::f64::consts::PI / 7.0 + 0.1 * (1.7 * n).cos()) * radius
    };
    let corners: Vec<Vec2> = (0..14).map(corner).collect();
    Map::new(vec![Boundary::new(Role::Arena, Curve::polyline(&corners, true).unwrap(), None).unwrap()]).unwrap()
}

#[test]
fn of_long_straight_walls_the_true_one_outlives_its_corner() {
    // Along these walls hypotheses stand millimetres apart when the corner comes, which one at another corner meets better by chance.
    let options = Method::Probabilistic(ProbabilisticOptions::exact());
    for (map, seed) in [(long_room(), 10), (star(), 147), (star(), 21), (star(), 107)] {
        let sweep = long_sweep(&map, seed).unwrap();
        let answer = localize(&sweep.log, &map, &Robot::default(), &options, &mut |_| {}).unwrap();
        let truth = sweep.truth.last().unwrap().map_from_robot;
        println!("{} rows, {} snaps: {}", sweep.truth.len(), snaps(&sweep), answer.status);
        assert_eq!(answer.status, Status::Localized, "{:?}", answer.events.last());
        let off = answer.hypotheses[0].pose.position().distance(truth.position());
        assert!(off < 2e-4, "{:.2} mm", 1e3 * off);
    }
}

#[test]
fn along_long_straight_walls_odometry_that_is_wrong_is_found_out() {
    let options = Method::Probabilistic(ProbabilisticOptions::exact());
    let mut robot = Robot::default();
    (robot.odometry.translation_relative, robot.odometry.rotation_relative) = (0.01, 0.01);
    for (map, seed) in [(long_room(), 10), (star(), 147)] {
        let sweep = long_sweep(&map, seed).unwrap();
        let log = mistaken(&sweep.log, [0.009, 0.0, 0.009]);
        let answer = localize(&log, &map, &robot, &options, &mut |_| {}).unwrap();
        let truth = sweep.truth.last().unwrap().map_from_robot;
        let off = answer.hypotheses.iter().map(|h| h.pose.position().distance(truth.position()));
        let off = off.fold(f64::INFINITY, f64::min);
        println!("{} rows: {}, {:.2} mm, {:?}", log.rows.len(), answer.status, 1e3 * off, answer.odometry);
        assert!(matches!(answer.status, Status::Localized | Status::Ambiguous), "{:?}", answer.events.last());
        assert!(off < 1.5e-3, "{:.2} mm", 1e3 * off);
    }
}

#[test]
fn odometry_that_is_wrong_by_a_share_is_found_out() {
    let options = Method::Probabilistic(ProbabilisticOptions::exact());
    let map = room(0.35, 0.25);
    let mut robot = Robot::default();
    (robot.odometry.translation_relative, robot.odometry.rotation_relative) = (0.01, 0.01);
    for (sweep, (long, turn)) in
        snapping(&map, 100..140, 3).iter().zip([(0.009, 0.009), (-0.009, 0.009), (0.006, -0.009)])
    {
        let log = mistaken(&sweep.log, [long, 0.0, turn]);
        let answer = localize(&log, &map, &robot, &options, &mut |_| {}).unwrap();
        let truth = sweep.truth.last().unwrap().map_from_robot;
        let places = answer.hypotheses.iter().map(|h| h.pose.position().distance(truth.position()));
        let off = places.fold(f64::INFINITY, f64::min);
        let blind = log.rows[0].odom_from_robot.between(log.rows.last().unwrap().odom_from_robot);
        let blind = sweep.truth[0].map_from_robot.compose(blind).position().distance(truth.position());
        let told = answer.odometry.unwrap();
        println!(
            "{} rows, {}: {:.2} mm, {:.1} by odometry, {told:?}",
            log.rows.len(),
            answer.status,
            1e3 * off,
            1e3 * blind
        );
        assert!(matches!(answer.status, Status::Localized | Status::Ambiguous), "{:?}", answer.events.last());
        assert!(off < 2e-3 && blind > 4.0 * off, "{:.2} mm", 1e3 * off);
        // They say by what increments are to be corrected.
        for (value, std, truth) in [
            (told.translation_scale, told.translation_scale_std, 1.0 / (1.0 + long)),
            (told.aside, told.aside_std, 0.0),
            (told.rotation_scale, told.rotation_scale_std, 1.0 / (1.0 + turn)),
        ] {
            assert!((value - truth).abs() < 3.0 * std && std < 3e-3, "{value} ± {std}, not {truth}");
        }
        // The path goes back from the last row by corrected increments.
        let way = |a: &[StampedPose]| {
            a.windows(2).map(|w| w[0].map_from_robot.position().distance(w[1].map_from_robot.position())).sum::<f64>()
        };
        let (ours, gone) = (way(&answer.trajectory), way(&sweep.truth[sweep.truth.len() - answer.trajectory.len()..]));
        assert!((ours / gone - 1.0).abs() < 4e-3, "{ours} m, not {gone}");
    }
}

/// A round room whose wall has waves of centimetres, in pieces of a millimetre.
fn rough_room() -> Map {
    let mut draw = random::Random(3);
    let waves: Vec<(f64, f64, f64)> = (2..40)
        .map(|k| (f64::from(k), 0.02 * draw.unit() / f64::from(k), draw.between(0.0, core::f64::consts::TAU)))
        .collect();
    let corner = |k: u32| {
        let angle = core::f64::consts::TAU * f64::from(k) / 1400.0;
        let wave: f64 = waves.iter().map(|(n, size, phase)| size * (n * angle + phase).cos()).sum();
        Vec2::from_angle(angle) * (0.25 + wave)
    };
    let corners: Vec<Vec2> = (0..1400).map(corner).collect();
    Map::new(vec![Boundary::new(Role::Arena, Curve::polyline(&corners, true).unwrap(), None).unwrap()]).unwrap()
}

#[test]
fn along_a_rough_wall_odometry_that_is_wrong_is_found_out() {
    let options = Method::Probabilistic(ProbabilisticOptions::exact());
    let map = rough_room();
    let mut robot = Robot::default();
    (robot.odometry.translation_relative, robot.odometry.rotation_relative) = (0.01, 0.01);
    let sweeps: Vec<Sweep> = (30..38).filter_map(|seed| long_sweep(&map, seed)).collect();
    assert!(sweeps.len() > 3);
    let mut errors = Vec::new();
    for sweep in sweeps {
        let log = mistaken(&sweep.log, [0.008, 0.0, -0.008]);
        let answer = localize(&log, &map, &robot, &options, &mut |_| {}).unwrap();
        let truth = sweep.truth.last().unwrap().map_from_robot;
        let off = answer.hypotheses[0].pose.position().distance(truth.position());
        let told = answer.odometry.unwrap();
        println!("{} rows, {}: {:.2} mm, {told:?}", log.rows.len(), answer.status, 1e3 * off);
        assert!(answer.status == Status::Localized && off < 6e-4, "{:.2} mm", 1e3 * off);
        errors.push(off);
        let shares = [
            (told.translation_scale, told.translation_scale_std, 1.0 / 1.008),
            (told.rotation_scale, told.rotation_scale_std, 1.0 / 0.992),
        ];
        assert!(shares.iter().all(|(value, std, truth)| (value - truth).abs() < 3.5 * std), "{told:?}");
    }
    assert!(errors.iter().sum::<f64>() < 3e-4 * errors.len() as f64, "{errors:?} m");
}

#[test]
fn turns_are_corrected_where_only_these_are_declared_wrong() {
    let options = Method::Probabilistic(ProbabilisticOptions::exact());
    let map = room(0.35, 0.25);
    let mut robot = Robot::default();
    robot.odometry.rotation_relative = 0.01;
    let sweep = &snapping(&map, 100..140, 1)[0];
    let log = mistaken(&sweep.log, [0.0, 0.0, 0.008]);
    let answer = localize(&log, &map, &robot, &options, &mut |_| {}).unwrap();
    let truth = sweep.truth.last().unwrap().map_from_robot;
    let off =
        answer.hypotheses.iter().map(|h| h.pose.position().distance(truth.position())).fold(f64::INFINITY, f64::min);
    let told = answer.odometry.unwrap();
    println!("{}: {:.2} mm, {told:?}", answer.status, 1e3 * off);
    assert!(off < 1e-3 && (told.rotation_scale - 1.0 / 1.008).abs() < 3.0 * told.rotation_scale_std);
    assert!((told.translation_scale - 1.0).abs() < 1e-5 && told.aside.abs() < 1e-5 && told.rotation_scale_std < 3e-3);
}

#[test]
fn odometry_that_is_declared_right_is_not_estimated() {
    let options = Method::Probabilistic(ProbabilisticOptions::exact());
    let map = room(0.35, 0.25);
    let sweep = &snapping(&map, 100..140, 1)[0];
    assert!(localize(&sweep.log, &map, &Robot::default(), &options, &mut |_| {}).unwrap().odometry.is_none());
}

#[test]
fn a_set_that_rules_nothing_out_wrongly_goes_around_corners_too() {
    let map = room(0.35, 0.25);
    let kept = |sweep: &Sweep, largest_slope: f64| {
        let possibilistic =
            PossibilisticOptions { largest_slope, last_work: 100_000, ..PossibilisticOptions::default() };
        let options = Method::Possibilistic(possibilistic);
        let answer = localize(&sweep.log, &map, &Robot::default(), &options, &mut |_| {}).unwrap();
        let truth = sweep.truth.last().unwrap().map_from_robot;
        let holds = |b: &StateBox| {
            let middle = 0.5 * (b.theta.lo() + b.theta.hi());
            let turned = middle + wrap_angle(truth.theta - middle);
            b.x.contains(truth.x) && b.y.contains(truth.y) && b.theta.contains(turned)
        };
        println!("{} rows, slopes to {largest_slope}: {}", sweep.truth.len(), answer.status);
        answer.states.iter().any(holds)
    };
    let sweeps = snapping(&map, 100..140, 4);
    let default = PossibilisticOptions::default().largest_slope;
    assert!(sweeps.iter().all(|sweep| kept(sweep, default)));
    // In the corner the robot turns until its whisker curls back along the wall: most of these sweeps need steep slopes.
    assert!(sweeps.iter().filter(|sweep| !kept(sweep, 2.2)).count() >= 2);
}

#[test]
fn moments_beyond_those_of_the_tip_do_not_end_the_deterministic_method() {
    let options = Method::Deterministic(Default::default());
    let map = room(0.35, 0.25);
    let largest = TipModel::new(&Whisker::default()).unwrap().largest_moment(f64::INFINITY);
    let mut beyond = 0;
    for sweep in snapping(&map, 100..140, 4) {
        let most = sweep.exact_moments.iter().map(|row| row[0].abs()).fold(0.0, f64::max);
        beyond += usize::from(most > 1.1 * largest);
        let answer = localize(&sweep.log, &map, &Robot::default(), &options, &mut |_| {}).unwrap();
        let noted = answer.events.iter().any(|event| event.kind == "not_tip");
        println!("{:.2} of the largest moment: {}, {noted}", most / largest, answer.status);
        assert!(noted || most <= 1.1 * largest, "{:?}", answer.events);
    }
    assert!(beyond > 0);
}
