//! The corridor on logs, maps and robots that nobody wants: an answer or an error, always the right one.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

use vibrissa::config::{ContactOptions, DeterministicOptions, MappingOptions};
use vibrissa::flow::pose::{Localization, Status};
use vibrissa::flow::sensor_log::{LogRow, SensorLog};
use vibrissa::plane::{Curve, Pose2, Vec2, wrap_angle};
use vibrissa::tasks::contact::contacts;
use vibrissa::tasks::demo;
use vibrissa::tasks::mapping::Mapper;
use vibrissa::world::{Boundary, Map, Robot};
use vibrissa::{Localizer, Method, Result, localize};

/// The demo's first 200 rows: enough for a few dozen updates.
fn log() -> SensorLog {
    let mut log = demo::sweep(1).unwrap().log;
    log.rows.truncate(200);
    log
}

/// A square arena, side in metres.
fn square(side: f64) -> Map {
    let text = format!(
        r#"{{"type": "FeatureCollection", "features": [{{"type": "Feature", "properties": {{"role": "arena"}},
        "geometry": {{"type": "Polygon", "coordinates":
        [[[0, 0], [{side}, 0], [{side}, {side}], [0, {side}], [0, 0]]]}}}}]}}"#
    );
    vibrissa::io::map::from_geojson(&text, "square").unwrap()
}

fn coarse(spacing: f64) -> Method {
    let deterministic = DeterministicOptions { boundary_spacing: spacing, ..DeterministicOptions::default() };
    Method::Deterministic(deterministic)
}

fn run(log: &SensorLog, map: &Map) -> Result<Localization> {
    localize(log, map, &Robot::default(), &coarse(5e-3), &mut |_| {})
}

fn kinds(answer: &Localization) -> Vec<&str> {
    answer.events.iter().map(|e| e.kind).collect()
}

#[test]
fn a_map_too_small_for_the_whisker_is_inconsistent_and_names_the_step() {
    for side in [1e-6, 1e-3, 2e-2] {
        let answer = run(&log(), &square(side)).unwrap();
        assert_eq!(answer.status, Status::Inconsistent, "{side}: {:?}", answer.events);
        assert!(kinds(&answer).contains(&"inconsistent") && answer.hypotheses.is_empty());
        assert!(answer.trajectory.is_empty() && answer.states.is_empty());
    }
}

#[test]
fn a_touch_too_short_to_align_leaves_every_place_open() {
    let mut log = log();
    let touch = log.rows.iter().position(|row| row.readings[0].abs() > 2.2e-5).unwrap();
    log.rows.truncate(touch + 4);
    let answer = run(&log, &square(0.4)).unwrap();
    assert_eq!(answer.status, Status::Ambiguous, "{:?}", answer.events);
    assert!(kinds(&answer).contains(&"too_short") && answer.hypotheses.is_empty() && answer.estimate.is_none());
}

#[test]
fn standing_still_in_contact_tells_nothing_and_ends() {
    let mut log = log();
    let touch = log.rows.iter().position(|row| row.readings[0].abs() > 1e-3).unwrap();
    let row = log.rows[touch].clone();
    log.rows = (0..100_000).map(|k| LogRow { t: f64::from(k), ..row.clone() }).collect();
    let answer = run(&log, &square(0.4)).unwrap();
    assert!(answer.status == Status::Ambiguous && answer.hypotheses.is_empty() && answer.steps.is_empty());
}

#[test]
fn the_odometrys_origin_does_not_matter() {
    let (map, robot, options) = (demo::arena().unwrap(), Robot::default(), Method::Deterministic(Default::default()));
    let here = demo::sweep(1).unwrap().log;
    let far = Pose2::new(5e5, -6e6, 2.1);
    let mut there = here.clone();
    there.rows.iter_mut().for_each(|row| row.odom_from_robot = far.compose(row.odom_from_robot));
    let [here, there] = [here, there].map(|log| localize(&log, &map, &robot, &options, &mut |_| {}).unwrap());
    assert_eq!((here.status, here.hypotheses.len()), (there.status, there.hypotheses.len()));
    let (a, b) = (here.estimate.unwrap(), there.estimate.unwrap());
    // Roundings of a nanometre choose other candidates to merge, which moves the estimate by tenths of a millimetre.
    assert!(a.position().distance(b.position()) < 1e-3 && wrap_angle(a.theta - b.theta).abs() < 1e-2, "{a:?} {b:?}");
}

#[test]
fn more_boundary_than_memory_is_refused_with_a_spacing_that_works() {
    let map = square(1000.0);
    let refused = |spacing| localize(&log(), &map, &Robot::default(), &coarse(spacing), &mut |_| {}).err();
    let message = refused(1e-3).expect("4 km at 1 mm").to_string();
    assert!(message.contains("4000") && message.contains("--boundary-spacing 0.04"), "{message}");
    assert!(refused(39e-3).is_some());
    // The spacing that the message names is accepted: a log without contact then ends at once.
    let mut free = log();
    free.rows.iter_mut().for_each(|row| row.readings[0] = 0.0);
    let answer = localize(&free, &map, &Robot::default(), &coarse(40e-3), &mut |_| {}).unwrap();
    assert_eq!(answer.status, Status::NoContact);
}

#[test]
fn several_whiskers_do_not_share_a_nameless_column() {
    let robot =
        vibrissa::io::robot::from_toml("[[whisker]]\nname = \"left\"\n[[whisker]]\nname = \"right\"\n", "robot")
            .unwrap();
    let error = localize(&log(), &square(0.4), &robot, &coarse(5e-3), &mut |_| {}).err().unwrap().to_string();
    assert!(error.contains("left.moment, right.moment"), "{error}");
}

#[test]
fn updates_at_a_standstill_are_refused() {
    for update_travel in [0.0, 9e-5, f64::NAN, 0.011] {
        let deterministic = DeterministicOptions { update_travel, ..DeterministicOptions::default() };
        assert!(deterministic.check().is_err_and(|e| e.is_usage()), "{update_travel}");
    }
}

#[test]
fn absurd_odometry_is_refused_with_its_line() {
    for value in ["1e9", "-1e300", "2e8"] {
        let text = format!("t,x,y,theta,moment\n0,0,0,0,0\n1,{value},0,0,0\n2,0,0,0,0\n");
        let error = vibrissa::io::log::from_csv(&text, "log.csv").err().unwrap();
        assert!(error.line() == Some(3) && error.to_string().contains("x is out of range"), "{error}");
    }
    assert!(vibrissa::io::log::from_csv("t,x,y,theta,moment\n0,9e7,-9e7,0,0\n", "log.csv").is_ok());
}

#[test]
fn a_drawing_of_endless_size_is_refused() {
    for shape in
        ["<ellipse id=\"arena\" rx=\"1e-7\" ry=\"1e300\"/>", "<path id=\"wall\" d=\"M0 0 C 1e200 0 0 1e200 1 1\"/>"]
    {
        let text = format!("<svg xmlns=\"http://www.w3.org/2000/svg\">\n{shape}\n</svg>\n");
        let error = vibrissa::io::map::from_svg(&text, "map.svg").err().unwrap();
        let message = error.to_string();
        assert!(error.line() == Some(2) && message.contains("out of range") && message.len() < 400, "{message}");
    }
}

#[test]
fn a_row_that_is_not_in_numbers_is_refused_by_every_method_and_task() {
    type Damage = fn(&mut LogRow);
    let bad: [(Damage, &str); 5] = [
        (|row| row.t = f64::NAN, "t of a row"),
        (|row| row.odom_from_robot.x = f64::NAN, "x of a row"),
        (|row| row.odom_from_robot.x = -1e9, "x of a row"),
        (|row| row.odom_from_robot.y = f64::INFINITY, "y of a row"),
        (|row| row.odom_from_robot.theta = f64::NAN, "theta of a row"),
    ];
    let (map, robot) = (square(0.4), Robot::default());
    for (damage, word) in bad {
        let mut log = log();
        damage(&mut log.rows[100]);
        log.rows[100].line = 102;
        for method in Method::all() {
            let mut localizer = Localizer::new(&map, &robot, &log.channels, &method).unwrap();
            let told = log.rows[99..101].iter().try_for_each(|row| localizer.step(row)).unwrap_err().to_string();
            assert!(told.contains(word) && told.contains("102"), "{told}");
            assert!(localizer.begin(&log.rows[100]).is_err() && localizer.step(&log.rows[101]).is_ok());
        }
        assert!(contacts(&log, &robot, &ContactOptions::default()).is_err_and(|e| e.to_string().contains(word)));
        let mut mapper = Mapper::new(&robot, &log, MappingOptions::default()).unwrap();
        assert!(mapper.push(&log.rows[100]).is_err_and(|e| e.to_string().contains(word)));
    }
    // A reading that is missing, or none.
    for readings in [vec![], vec![f64::NAN]] {
        let mut log = log();
        log.rows[100].readings = readings;
        let told = contacts(&log, &robot, &ContactOptions::default()).unwrap_err().to_string();
        assert!(told.contains("reading 1"), "{told}");
    }
}

/// The demo's arena in edges of a millimetre, each cut into so many.
fn arena_in_edges(cut: usize) -> Map {
    let arena = demo::arena().unwrap();
    let cut_up = |boundary: &Boundary| {
        let (curve, closed) = (boundary.curve(), boundary.curve().is_closed());
        let count = (curve.length() / 1e-3).round() as usize;
        let corner = |k: usize| curve.at(curve.length() * (k % count) as f64 / count as f64).position;
        let between = |k: usize| {
            let (a, b) = (corner(k), corner(k + 1));
            (0..cut).map(move |part| a + (b - a) * (part as f64 / cut as f64))
        };
        let corners: Vec<Vec2> = (0..count).flat_map(between).collect();
        Boundary::new(boundary.role(), Curve::polyline(&corners, closed).unwrap(), None).unwrap()
    };
    Map::new(arena.boundaries().iter().map(cut_up).collect()).unwrap()
}

#[test]
fn edges_of_twenty_micrometres_are_followed_as_those_of_a_millimetre() {
    let (log, robot, method) = (demo::sweep(1).unwrap().log, Robot::default(), Method::named("probabilistic").unwrap());
    let [coarse, fine] = [1, 50].map(|cut| {
        let map = arena_in_edges(cut);
        localize(&log, &map, &robot, &method, &mut |_| {}).unwrap()
    });
    assert_eq!((coarse.status, fine.status), (Status::Localized, Status::Localized));
    let off = coarse.estimate.unwrap().between(fine.estimate.unwrap());
    // Well within what either place leaves open.
    let [x, y] = [0, 1].map(|k| coarse.hypotheses[0].covariance.unwrap()[k][k].sqrt());
    assert!(off.position().norm() < x.hypot(y) && off.position().norm() < 3e-4 && off.theta.abs() < 1e-3, "{off:?}");
    assert_eq!(coarse.hypotheses.len(), fine.hypotheses.len());
}
