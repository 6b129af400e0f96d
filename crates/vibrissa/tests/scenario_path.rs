//! Ways of scenarios against geometry done by hand, and whisker shapes against the closed form.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

#[path = "data/random.rs"]
mod random;

use core::f64::consts::{FRAC_PI_2, PI};
use random::Random;
use vibrissa::beam::elastica;
use vibrissa::plane::{Pose2, Vec2, wrap_angle};
use vibrissa::sim::Scenario;
use vibrissa::sim::shapes;

/// A free room of 2 m with a post of 0.2 m in its middle, and this path.
fn scenario(path: &str) -> Scenario {
    let text = format!(
        "map = {{ arena = [[-1, -1], [1, -1], [1, 1], [-1, 1]], obstacle = [[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]] }}\n\
         [path]\n{path}"
    );
    Scenario::from_toml(&text, "test.toml", "").unwrap()
}

fn poses(path: &str) -> Vec<Pose2> {
    scenario(path).path.iter().map(|pose| pose.map_from_robot).collect()
}

#[test]
fn waypoints_take_the_time_of_their_way() {
    let scenario = scenario("waypoints = [[-0.5, 0.5], [0.5, 0.5]]\nspeed = \"0.25 m/s\"\nrate = 100");
    assert_eq!(scenario.path.len(), 401, "4 s at 100 Hz and the start");
    for (k, pose) in scenario.path.iter().enumerate() {
        let at = pose.map_from_robot;
        assert!((pose.t - k as f64 / 100.0).abs() < 1e-12);
        assert!((at.x + 0.5 - 0.25 * pose.t).abs() < 1e-12 && (at.y - 0.5).abs() < 1e-12 && at.theta.abs() < 1e-12);
    }
}

#[test]
fn along_the_way_the_robot_turns_at_corners() {
    let path = poses("waypoints = [[-0.5, 0.5], [0.5, 0.5], [0.5, -0.5]]\nspeed = 1\nturn_rate = 1\nrate = 1000");
    let turning: Vec<&Pose2> = path.iter().filter(|p| p.theta < -1e-9 && p.theta > -FRAC_PI_2 + 1e-9).collect();
    assert!((turning.len() as f64 - 1000.0 * FRAC_PI_2).abs() < 2.0, "{} rows at 1 rad/s", turning.len());
    assert!(turning.iter().all(|p| p.position().distance(Vec2::new(0.5, 0.5)) < 1e-9), "on the spot");
    let offset = poses("waypoints = [[-0.5, 0.5], [0.5, 0.5]]\nheading_offset = \"30 deg\"");
    assert!(offset.iter().all(|p| (p.theta - PI / 6.0).abs() < 1e-12));
    let fixed = poses("waypoints = [[-0.5, 0.5], [0.5, 0.5], [0.5, -0.5]]\nheading = \"-20 deg\"");
    assert!(fixed.iter().all(|p| (p.theta + PI / 9.0).abs() < 1e-12));
    let mixed = poses("waypoints = [[-0.5, 0.5, 0], [0.5, 0.5, \"90 deg\"]]");
    assert!(mixed.iter().all(|p| (p.theta - FRAC_PI_2 * (p.x + 0.5)).abs() < 1e-9), "turns evenly on the way");
}

#[test]
fn arcs_are_circles_at_the_speed() {
    let leg = "start = [0.5, 0]\nspeed = 0.2\nrate = 200\n[[path.leg]]\nkind = \"arc\"\ncentre = [0, 0]\nangle = ";
    for (angle, size) in [("\"450 deg\"", 2.5 * PI), ("-1.0", -1.0)] {
        let scenario = scenario(&format!("{leg}{angle}"));
        for pose in &scenario.path {
            let at = pose.map_from_robot;
            // Chords of 0.25 mm on a radius of half a metre: their middles lie 16 nm inside.
            assert!((at.position().norm() - 0.5).abs() < 2e-8, "{}", at.position().norm() - 0.5);
            let turned = size.signum() * 0.2 * pose.t / 0.5;
            assert!(wrap_angle(at.position().angle() - turned).abs() < 1e-6);
            assert!(wrap_angle(at.theta - turned - size.signum() * FRAC_PI_2).abs() < 1e-3);
        }
        let last = scenario.path.last().unwrap();
        assert!((last.t - size.abs() * 0.5 / 0.2).abs() < 1.0 / 200.0 + 1e-9);
    }
}

#[test]
fn splines_pass_their_points_smoothly() {
    let mut random = Random(4);
    for _ in 0..10 {
        let points: Vec<Vec2> =
            (0..6).map(|k| Vec2::new(-0.8 + 0.3 * f64::from(k), 0.5 + random.signed(0.2))).collect();
        let list: Vec<String> = points.iter().skip(1).map(|p| format!("[{}, {}]", p.x, p.y)).collect();
        let path = format!(
            "start = [{}, {}]\n[[path.leg]]\nkind = \"spline\"\nthrough = [{}]",
            points[0].x,
            points[0].y,
            list.join(", ")
        );
        let poses = poses(&path);
        for point in points {
            let nearest = poses.iter().map(|p| p.position().distance(point)).fold(f64::INFINITY, f64::min);
            assert!(nearest < 0.51e-3, "{nearest}: within a row of half a millimetre");
        }
        for pair in poses.windows(2) {
            let (step, direction) = (pair[1].position() - pair[0].position(), pair[0].theta);
            assert!(wrap_angle(pair[1].theta - direction).abs() < 0.05, "no corner");
            assert!(step.norm() < 0.51e-3 && wrap_angle(step.angle() - direction).abs() < 0.05, "it points along");
        }
    }
}

/// The distance to the walls of `scenario`'s world by brute force.
fn distance(p: Vec2) -> f64 {
    let room = 1.0 - p.x.abs().max(p.y.abs());
    let (dx, dy) = (p.x.abs() - 0.1, p.y.abs() - 0.1);
    room.min(Vec2::new(dx.max(0.0), dy.max(0.0)).norm())
}

#[test]
fn walls_are_followed_at_the_standoff_on_the_asked_side() {
    for (start, side, sign) in
        [("[0, -0.25]", "left", 1.0), ("[0, -0.25]", "right", -1.0), ("[0.5, -0.85]", "right", 1.0)]
    {
        let path = format!(
            "start = {start}\n[[path.leg]]\nkind = \"wall\"\nside = \"{side}\"\nstandoff = \"0.12 m\"\nlength = 1.8"
        );
        let scenario = scenario(&path);
        let poses: Vec<Pose2> = scenario.path.iter().map(|p| p.map_from_robot).collect();
        let settled: Vec<&Pose2> = poses.iter().skip_while(|p| (distance(p.position()) - 0.12).abs() > 1e-6).collect();
        assert!(settled.len() > 1000, "{}", settled.len());
        for pose in &settled {
            assert!((distance(pose.position()) - 0.12).abs() < 2e-6, "{pose:?}: {}", distance(pose.position()));
        }
        assert!((settled[10].x - settled[0].x) * sign > 0.0, "{side}: {:?}", settled[10]);
        let way: f64 = settled.windows(2).map(|w| w[0].position().distance(w[1].position())).sum();
        assert!((way - 1.8).abs() < 2e-3, "{way}");
    }
}

#[test]
fn a_wall_is_followed_through_an_acute_corner() {
    // A right triangle with angles of 90, 45 and 45 degrees, once round on the inside.
    let text = "map = { arena = [[0, 0], [1, 0], [0, 1]] }\n[path]\nstart = [0.3, 0.1, 0]\n[[path.leg]]\nkind = \"wall\"\n\
                side = \"right\"\nstandoff = 0.1\nlength = 2.2\n";
    let scenario = Scenario::from_toml(text, "test.toml", "").unwrap();
    // The triangle within: legs of 1 - 0.1 (2 + sqrt 2), so once round is (2 + sqrt 2) times that.
    let leg = 1.0 - 0.1 * (2.0 + 2f64.sqrt());
    let round = leg * (2.0 + 2f64.sqrt());
    let end = scenario.path.last().unwrap().map_from_robot.position();
    let expected = Vec2::new(0.3 + 2.2 - round, 0.1);
    assert!(end.distance(expected) < 2e-3, "{end:?} and {expected:?}");
    for pose in &scenario.path {
        let p = pose.map_from_robot.position();
        let distance = p.x.min(p.y).min((1.0 - p.x - p.y) / 2f64.sqrt());
        assert!((distance - 0.1).abs() < 1e-6, "{distance}");
    }
}

#[test]
fn turns_and_waits_keep_the_place() {
    let scenario = scenario(
        "start = [0.5, 0.5, 0]\nrate = 100\nturn_rate = 2\n[[path.leg]]\nkind = \"turn\"\nby = \"-270 deg\"\n\
         [[path.leg]]\nkind = \"wait\"\ntime = \"1 s\"",
    );
    let last = scenario.path.last().unwrap();
    assert!((last.t - (0.75 * PI + 1.0)).abs() < 0.011, "{}", last.t);
    assert!((last.map_from_robot.theta - FRAC_PI_2).abs() < 1e-9);
    assert!(scenario.path.iter().all(|p| p.map_from_robot.position().distance(Vec2::new(0.5, 0.5)) < 1e-12));
    let quarter = scenario.path.iter().find(|p| p.t >= 0.25 * PI).unwrap();
    assert!((quarter.map_from_robot.theta + 2.0 * quarter.t).abs() < 1e-9, "clockwise");
}

#[test]
fn a_start_without_heading_looks_along_the_first_leg() {
    let path = poses("start = [-0.5, 0.5]\n[[path.leg]]\nkind = \"line\"\nto = [-0.5, -0.5]");
    assert!(path.iter().all(|p| (p.theta + FRAC_PI_2).abs() < 1e-12));
}

#[test]
fn shapes_are_the_closed_forms() {
    let text = "map = { arena = [[0, 0], [0.6, 0], [0.6, 0.4], [0, 0.4]] }\n[[whisker]]\nmount = [0, 0, \"128 deg\"]\n\
                [path]\nwaypoints = [[0.15, 0.335, 0], [0.2, 0.355, 0], [0.25, 0.355, 0]]\n";
    let scenario = Scenario::from_toml(text, "test.toml", "").unwrap();
    let sweep = scenario.simulate().unwrap().sweep;
    let shapes = shapes(&scenario.robot, &sweep, 1);
    assert_eq!(shapes.len(), sweep.truth.len(), "straight ones too");
    let whisker = scenario.robot.whiskers[0].clone();
    for touch in &sweep.contacts {
        let drawn = &shapes[touch.row];
        let base = sweep.truth[touch.row].map_from_robot.compose(whisker.robot_from_whisker);
        assert!(drawn.points.last().unwrap().distance(touch.position) < 1e-7, "it ends at its touch");
        // The tilt of the load from force and closed form: the one whose tip is where the touch is.
        let force = touch.force.rotated(-base.theta);
        let bends = |phi: f64| {
            let beta = wrap_angle(force.angle() - phi - FRAC_PI_2);
            elastica::bend(whisker.beam.flexural_rigidity, force.norm(), whisker.beam.length, beta)
        };
        let mut slope = 0.3;
        for _ in 0..200 {
            slope = 0.5 * (slope + bends(slope).unwrap().phi_a);
        }
        let bend = bends(slope).unwrap();
        for (k, point) in drawn.points.iter().enumerate() {
            let exact = base.transform_point(bend.point_at(0.075 * k as f64 / 64.0).position);
            assert!(exact.distance(*point) < 1e-6, "point {k}: {} m off", exact.distance(*point));
        }
    }
    assert!(sweep.contacts.len() > 100);
}

/// A drag along the wall of a room, with these sections behind it.
fn dragged(sections: &str) -> Scenario {
    let text = format!(
        "map = {{ arena = [[0, 0], [0.6, 0], [0.6, 0.4], [0, 0.4]] }}\n[[whisker]]\nmount = [0, 0, \"128 deg\"]\n\
         [path]\nwaypoints = [[0.2, 0.32, 0], [0.25, 0.35, 0], [0.4, 0.35, 0]]\n{sections}"
    );
    Scenario::from_toml(&text, "test.toml", "").unwrap()
}

#[test]
fn the_robot_that_is_simulated_has_the_errors_and_the_one_that_is_declared_has_not() {
    let exact = "[noise]\nlaw = \"none\"\n[errors]\n";
    let readings = |sections: &str| -> Vec<f64> {
        let simulation = dragged(sections).simulate().unwrap();
        simulation.recording.log.rows.iter().map(|row| row.readings[0]).collect()
    };
    let plain = readings(exact);
    let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
    let zero: Vec<f64> = plain.iter().map(|m| 1.08 * m + 2e-4).collect();
    assert!(near(&readings(&format!("{exact}zero = \"0.2 mN m\"\ngain = \"8 %\"")), &zero));
    // A whisker twice as stiff in the same shape reads twice as much.
    let stiff: Vec<f64> = plain.iter().map(|m| 2.0 * m).collect();
    let twice = readings(&format!("{exact}stiffness = \"100 %\""));
    assert!(twice.iter().zip(&stiff).all(|(a, b)| (a - b).abs() < 1e-8 * b.abs() + 1e-12));
    let mounted = dragged(&format!("{exact}mount = [0, 0, \"2 deg\"]\nlength = \"1 mm\""));
    let declared = mounted.robot.whiskers[0].clone();
    assert!((declared.robot_from_whisker.theta - 128.0_f64.to_radians()).abs() < 1e-15);
    let truth = mounted.simulate().unwrap().robot.whiskers[0].clone();
    assert!((truth.robot_from_whisker.theta - 130.0_f64.to_radians()).abs() < 1e-12);
    assert!((truth.beam.length - declared.beam.length - 1e-3).abs() < 1e-15);
    let late = readings(&format!("{exact}delay = \"-20 ms\""));
    assert!(near(&late[6..], &plain[..plain.len() - 6]) && late[5].abs() < 1e-15, "six rows of 300 Hz");
}

#[test]
fn a_world_larger_than_its_map_is_gone_through_on_the_map() {
    let plain = dragged("[noise]\nlaw = \"none\"\n").simulate().unwrap();
    let large = dragged("[noise]\nlaw = \"none\"\n[errors]\nmap_scale = \"3 %\"\n").simulate().unwrap();
    for (a, b) in plain.sweep.truth.iter().zip(&large.sweep.truth) {
        assert!(a.map_from_robot.position().distance(b.map_from_robot.position()) < 1e-12, "truth on the map");
    }
    let way = |simulation: &vibrissa::sim::Simulation| {
        simulation.recording.log.rows.last().map(|row| row.odom_from_robot.position().norm()).unwrap()
    };
    assert!((way(&large) / way(&plain) - 1.03).abs() < 1e-12, "odometry counts the metres of the world");
    let wall = large.sweep.contacts.iter().map(|touch| (touch.position.y - 0.4).abs()).fold(0.0, f64::max);
    assert!(wall < 1e-9, "touches lie on the map's wall: {wall}");
}

#[test]
fn laws_of_noise_are_read_with_their_parameters() {
    use vibrissa::sim::recorder::NoiseLaw;
    let law = |text: &str| dragged(&format!("[noise]\n{text}\n")).recorder.law;
    assert_eq!(law("law = \"ar1\""), NoiseLaw::Autoregressive { time_constant: 0.5 });
    assert_eq!(law("law = \"ar1\"\ntime_constant = \"100 ms\""), NoiseLaw::Autoregressive { time_constant: 0.1 });
    assert_eq!(law("law = \"sine\"\nperiods = 3"), NoiseLaw::Sine { periods: 3.0 });
    assert_eq!(law("law = \"quantised\"\nbits = 10"), NoiseLaw::Quantised { bits: 10 });
    assert_eq!(law("moment_relative = 0.01"), NoiseLaw::Uniform);
}

#[test]
fn scenarios_declare_what_robots_declare() {
    let text = "map = { arena = [[0, 0], [0.6, 0], [0.6, 0.4], [0, 0.4]], scale_error = \"1 %\" }\n\
                [[whisker]]\nzero_error = \"0.2 mN m\"\n[odometry]\ndelay_error = \"20 ms\"\n\
                [path]\nwaypoints = [[0.2, 0.2, 0], [0.3, 0.2, 0]]\n";
    let robot = Scenario::from_toml(text, "test.toml", "").unwrap().robot;
    assert!((robot.map_scale - 0.01).abs() < 1e-15 && (robot.odometry.delay - 0.02).abs() < 1e-15);
    assert!((robot.whiskers[0].errors.zero - 2e-4).abs() < 1e-18);
    let maps = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenarios/maps");
    let text =
        "map = { file = \"room.svg\", scale_error = 0.02 }\n[path]\nwaypoints = [[0.1, 0.5, 0], [0.2, 0.5, 0]]\n";
    let scenario = Scenario::from_toml(text, "test.toml", maps).unwrap();
    assert!((scenario.robot.map_scale - 0.02).abs() < 1e-15);
    assert!(scenario.map_file.is_some_and(|file| file.ends_with("room.svg")));
    let both =
        "map = { file = \"room.svg\", arena = [[0, 0], [1, 0], [1, 1]] }\n[path]\nwaypoints = [[0, 0], [1, 0]]\n";
    assert!(Scenario::from_toml(both, "test.toml", maps).unwrap_err().to_string().contains("unknown key: map.arena"));
}
