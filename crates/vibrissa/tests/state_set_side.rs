//! The probabilistic method's forward model where the whisker's side touches, against the simulator, which solves such
//! contacts with equations of its own and two at once with a discrete rod.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

#[path = "data/random.rs"]
mod random;
#[path = "data/random_arena.rs"]
mod random_arena;
#[path = "data/shared.rs"]
mod shared;

use random::Random;
use shared::shared;
use std::path::Path;
use vibrissa::beam::TipModel;
use vibrissa::flow::state_set::probabilistic::{PredictedMoment, predicted_moments, predicted_moments_by_readings};
use vibrissa::plane::{Curve, Pose2, Vec2};
use vibrissa::sim::{
    Pace, Part, Scenario, SimulateOptions, Sweep, SweepNoise, path_through, simulate, simulate_tip_sweep,
};
use vibrissa::world::{Boundary, Map, MomentNoise, Robot, Role};

fn predicted(map: &Map, robot: &Robot, sweep: &Sweep, moved: [f64; 3]) -> Vec<PredictedMoment> {
    let whisker = &robot.whiskers[0];
    let center = sweep.truth[sweep.truth.len() / 2].map_from_robot.position();
    let place = |pose: Pose2| {
        let arm = (pose.position() - center).rotated(moved[2]);
        let at = center + arm + Vec2::new(moved[0], moved[1]);
        Pose2::new(at.x, at.y, pose.theta + moved[2]).compose(whisker.robot_from_whisker)
    };
    let path: Vec<Pose2> = sweep.truth.iter().map(|p| place(p.map_from_robot)).collect();
    predicted_moments(map, &TipModel::new(&whisker.beam).unwrap(), &path)
}

/// Rows with a contact of the side, and those of them that are off by more than this share of the declared noise.
fn side_rows(robot: &Robot, sweep: &Sweep, ours: &[PredictedMoment], share: f64) -> (Vec<usize>, usize) {
    let noise = &robot.whiskers[0].noise;
    let mut rows: Vec<usize> = sweep.contacts.iter().filter(|c| c.part == Part::Side).map(|c| c.row).collect();
    rows.dedup();
    let far = |&&row: &&usize| {
        let exact = sweep.exact_moments[row][0];
        let bound = noise.moment_relative * exact.abs() + noise.moment_absolute;
        (ours[row].moment - exact).abs() > share * bound
    };
    let odd = rows.iter().filter(far).count();
    (rows, odd)
}

/// A sweep during which a bump rises under the whisker while its tip is in a bay.
fn bump(seed: u64) -> (Map, Sweep) {
    let mut draw = Random(seed.wrapping_mul(0x9e37_79b9));
    let map = random_arena::arena(&mut draw).unwrap();
    let sweep = random_arena::sweep(&map, &mut draw, seed).unwrap();
    (map, sweep)
}

/// Derivatives against differences over the whole path, relative to a scale, sorted.
fn derivative_errors(map: &Map, robot: &Robot, sweep: &Sweep, rows: &[usize]) -> Vec<f64> {
    let ours = predicted(map, robot, sweep, [0.0; 3]);
    let center = sweep.truth[sweep.truth.len() / 2].map_from_robot.position();
    let mut errors = Vec::new();
    for axis in 0..3 {
        let size = if axis < 2 { 1e-6 } else { 1e-5 };
        let mut d = [0.0; 3];
        d[axis] = size;
        let (more, less) = (predicted(map, robot, sweep, d), predicted(map, robot, sweep, d.map(|v| -v)));
        for &row in rows {
            let difference = (more[row].moment - less[row].moment) / (2.0 * size);
            let base = sweep.truth[row].map_from_robot.compose(robot.whiskers[0].robot_from_whisker).position();
            let (arm, g) = ((base - center).perp(), ours[row].gradient);
            let own = if axis < 2 { g[axis] } else { g[2] + g[0] * arm.x + g[1] * arm.y };
            errors.push((own - difference).abs() / (if axis < 2 { 0.2 } else { 0.02 } + difference.abs()));
        }
    }
    errors.sort_by(f64::total_cmp);
    errors
}

#[test]
fn a_side_that_passes_a_post_is_followed() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/side_contact.toml");
    let scenario = Scenario::read(path).unwrap();
    let sweep = scenario.simulate().unwrap().sweep;
    let ours = predicted(&scenario.map, &scenario.robot, &sweep, [0.0; 3]);
    let (rows, odd) = side_rows(&scenario.robot, &sweep, &ours, 1e-3);
    println!("{odd} odd rows of {} with side contact", rows.len());
    assert!(rows.len() > 30 && odd * 20 <= rows.len(), "{odd} of {}", rows.len());
    let errors = derivative_errors(&scenario.map, &scenario.robot, &sweep, &rows);
    println!("derivatives: {:?} of {}", &errors[errors.len() - 5..], errors.len());
    assert!(errors[errors.len() * 9 / 10] < 1e-3, "{:?}", &errors[errors.len() * 8 / 10..]);
}

#[test]
fn tip_and_side_at_once_are_followed() {
    let robot = Robot::default();
    for seed in [1018, 1090, 1106, 1286, 1471] {
        let (map, sweep) = bump(seed);
        let ours = predicted(&map, &robot, &sweep, [0.0; 3]);
        let (rows, odd) = side_rows(&robot, &sweep, &ours, 0.2);
        println!("{seed}: {odd} odd rows of {} with side contact", rows.len());
        assert!(rows.len() > 15 && odd * 10 <= rows.len(), "{seed}: {odd} of {}", rows.len());
    }
    let (map, sweep) = bump(1090);
    let ours = predicted(&map, &robot, &sweep, [0.0; 3]);
    let rows: Vec<usize> = side_rows(&robot, &sweep, &ours, 0.2).0;
    let errors = derivative_errors(&map, &robot, &sweep, &rows);
    println!("derivatives: {:?} of {}", &errors[errors.len() * 8 / 10..], errors.len());
    assert!(errors[errors.len() * 8 / 10] < 1e-2, "{:?}", &errors[errors.len() * 7 / 10..]);
}

/// A floor with a block on it, whose corner is at the origin and stands so high above the floor.
fn step(height: f64) -> Map {
    let corners = [[-0.4, 0.0], [0.0, 0.0], [0.0, -height], [0.4, -height], [0.4, 0.4], [-0.4, 0.4]];
    let outline = Curve::polyline(&corners.map(|[x, y]| Vec2::new(x, y)), true).unwrap();
    Map::new(vec![Boundary::new(Role::Arena, outline, None).unwrap()]).unwrap()
}

#[test]
fn a_corner_that_rises_anywhere_under_a_whisker_with_its_tip_on_a_wall_is_felt() {
    let robot = Robot::default();
    let mut draw = Random(7);
    let (mut tried, mut both) = (0, 0);
    for _ in 0..60 {
        let map = step(draw.between(0.008, 0.02));
        // The tip comes down on the floor beyond the corner, then the base goes down behind it.
        let from = Pose2::new(draw.between(-0.03, -0.01), 0.052, draw.between(-1.05, -0.85));
        let down = draw.between(0.004, 0.01);
        let way = [
            from,
            Pose2::new(from.x, from.y - down, from.theta),
            Pose2::new(from.x - 0.02, from.y - down - 0.006, from.theta + draw.between(0.05, 0.15)),
        ];
        let path = path_through(&way, &Pace { speed: 0.1, turn_rate: 1.0, rate: 300.0 }).unwrap();
        let Ok(sweep) = simulate_tip_sweep(&map, &robot, &path, &SweepNoise::seeded(1)) else { continue };
        let ours = predicted(&map, &robot, &sweep, [0.0; 3]);
        let (rows, odd) = side_rows(&robot, &sweep, &ours, 0.2);
        if rows.len() > 15 {
            tried += 1;
            both += usize::from(sweep.contacts.iter().any(|c| c.part == Part::Tip));
            assert!(odd * 10 <= rows.len(), "{odd} of {}: {way:?}", rows.len());
        }
    }
    println!("{tried} sweeps over the corner, {both} with the tip on the floor first");
    assert!(tried >= 10 && both >= 5, "{tried} {both}");
}

/// Rows of contact with any number of contacts, and rows that are off by more than half of the declared noise.
fn all_rows(map: &Map, robot: &Robot, way: &[Pose2]) -> Option<[usize; 2]> {
    let path = path_through(way, &Pace { speed: 0.1, turn_rate: 1.0, rate: 200.0 }).unwrap();
    let sweep = simulate(map, robot, &path, &SweepNoise::none(), &SimulateOptions::default()).ok()?;
    if sweep.events.iter().any(|event| matches!(event.kind, "unsolved" | "lost")) {
        return None;
    }
    let mut touching: Vec<usize> = sweep.contacts.iter().map(|touch| touch.row).collect();
    touching.dedup();
    let noise = &robot.whiskers[0].noise;
    let ours = predicted(map, robot, &sweep, [0.0; 3]);
    let off = ours.iter().zip(&sweep.exact_moments).filter(|(ours, exact)| {
        (ours.moment - exact[0]).abs() > 0.5 * (noise.moment_relative * exact[0].abs() + noise.moment_absolute)
    });
    Some([touching.len(), off.count()])
}

#[test]
fn the_end_of_a_thin_wall_is_brushed_by_the_side() {
    let robot = Robot::default();
    let corners = [(0.0, 0.0), (0.5, 0.0), (0.5, 0.5), (0.0, 0.5)].map(|(x, y)| Vec2::new(x, y));
    let room = Boundary::new(Role::Arena, Curve::polyline(&corners, true).unwrap(), None).unwrap();
    let mut draw = Random(31);
    let (mut rows, mut odd) = (0, 0);
    for _ in 0..24 {
        // The base goes by beside the wall, in its direction, with the whisker across it.
        let (end, tilt) = (Vec2::new(0.25, 0.25), draw.signed(0.4));
        let wall = [end, end + Vec2::from_angle(tilt) * draw.between(0.05, 0.12)];
        let wall = Boundary::new(Role::Wall, Curve::polyline(&wall, false).unwrap(), None).unwrap();
        let map = Map::new(vec![room.clone(), wall]).unwrap();
        let (off, lean) = (draw.between(0.02, 0.06), draw.signed(0.4));
        let at = |s: f64| {
            let base = end + Vec2::from_angle(tilt) * s - Vec2::from_angle(tilt).perp() * off;
            Pose2::new(base.x, base.y, tilt + core::f64::consts::FRAC_PI_2 + lean)
        };
        let Some([touching, off]) = all_rows(&map, &robot, &[at(-0.06), at(0.03)]) else { continue };
        (rows, odd) = (rows + touching, odd + off);
    }
    println!("{rows} rows, {odd} odd");
    assert!(rows > 500 && odd * 50 < rows, "{odd} of {rows} rows");
}

#[test]
fn a_whisker_bent_around_two_posts_is_followed() {
    let robot = Robot::default();
    let (length, mount) = (robot.whiskers[0].beam.length, robot.whiskers[0].robot_from_whisker);
    let corners = [(-0.3, -0.3), (0.3, -0.3), (0.3, 0.3), (-0.3, 0.3)].map(|(x, y)| Vec2::new(x, y));
    let room = Boundary::new(Role::Arena, Curve::polyline(&corners, true).unwrap(), None).unwrap();
    let mut draw = Random(83);
    let (mut odd, mut twice, mut sweeps, mut errors) = (0, 0, 0, Vec::new());
    for index in 0..32 {
        // The base goes up, so that first the outer post presses the whisker down, then the inner one too; either has a blunt or a flat
        // end. It turns and goes along with both on it.
        let mut post = |x: f64, y: f64| {
            let (wide, at) = (draw.between(0.02, 0.1) * length, Vec2::new(x, y) * length);
            let outline = if draw.unit() < 0.5 {
                vec![at, at + Vec2::new(wide, 0.2 * length), at + Vec2::new(-wide, 0.2 * length)]
            } else {
                let (across, tall) = (Vec2::from_angle(draw.signed(0.3)) * wide, Vec2::new(0.0, 0.2 * length));
                vec![at - across, at + across, at + across + tall, at - across + tall]
            };
            Boundary::new(Role::Obstacle, Curve::polyline(&outline, true).unwrap(), None).unwrap()
        };
        let posts = [post(0.3 + 0.01 * f64::from(index % 12), 0.1), post(0.75 + 0.006 * f64::from(index % 10), 0.0)];
        let map = Map::new([vec![room.clone()], posts.to_vec()].concat()).unwrap();
        let height = draw.between(0.2, 0.4);
        let at = |x: f64, y: f64, turn: f64| Pose2::new(x * length, y * length, turn).compose(mount.inverse());
        let (turn, along) = (draw.signed(0.3), draw.signed(0.15));
        let way = [
            at(0.0, -0.1, 0.0),
            at(0.0, height, 0.0),
            at(0.0, height, turn),
            at(along, height, turn),
            at(along, -0.2, turn),
        ];
        let path = path_through(&way, &Pace { speed: 0.1, turn_rate: 1.0, rate: 600.0 }).unwrap();
        let Ok(sweep) = simulate(&map, &robot, &path, &SweepNoise::none(), &SimulateOptions::default()) else {
            continue;
        };
        if sweep.events.iter().any(|event| matches!(event.kind, "unsolved" | "lost")) {
            continue;
        }
        let sides: Vec<usize> = sweep.contacts.iter().filter(|c| c.part == Part::Side).map(|c| c.row).collect();
        let both: Vec<usize> = sides.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| pair[0]).collect();
        let ours = predicted(&map, &robot, &sweep, [0.0; 3]);
        let noise = &robot.whiskers[0].noise;
        let off = ours.iter().zip(&sweep.exact_moments).filter(|(ours, exact)| {
            (ours.moment - exact[0]).abs() > 0.2 * (noise.moment_relative * exact[0].abs() + noise.moment_absolute)
        });
        (odd, twice, sweeps) = (odd + off.count(), twice + both.len(), sweeps + 1);
        errors.extend(derivative_errors(&map, &robot, &sweep, &both));
    }
    errors.sort_by(f64::total_cmp);
    println!("{sweeps} sweeps, {twice} rows with the side at two places, {odd} odd of all");
    println!("derivatives: {:?} of {}", &errors[errors.len() - 30..], errors.len());
    assert!(sweeps > 20 && twice > 300 && odd * 15 < twice, "{odd} of {twice} rows in {sweeps} sweeps");
    // Beside rows in which one of the contacts begins or ends within the difference.
    assert!(errors[errors.len() * 9 / 10] < 1e-2, "{:?}", &errors[errors.len() * 8 / 10..]);
}

#[test]
fn a_whisker_that_lies_along_a_wall_buckles_in_a_corner() {
    let robot = Robot::default();
    let length = robot.whiskers[0].beam.length;
    let mut draw = Random(57);
    let (mut rows, mut odd, mut sweeps) = (0, 0, 0);
    for _ in 0..24 {
        let lean = draw.signed(0.15);
        let corners = [(0.0, 0.0), (0.5, 0.0), (0.5 + lean, 0.5), (0.0, 0.5)].map(|(x, y)| Vec2::new(x, y));
        let room = Boundary::new(Role::Arena, Curve::polyline(&corners, true).unwrap(), None).unwrap();
        let map = Map::new(vec![room]).unwrap();
        // The whisker turns down onto the floor and lies along it; then the base goes on towards the wall.
        let height = draw.between(0.35, 0.6) * length;
        let (before, down) = (0.5 - 1.3 * length, draw.between(0.7, 1.1));
        let at = |x: f64, turn: f64| Pose2::new(x, height, turn);
        let end = 0.5 - draw.between(0.4, 0.65) * length;
        let way = [at(before, 0.0), at(before, -down), at(end, -down), at(before, -down)];
        let Some([touching, off]) = all_rows(&map, &robot, &way) else { continue };
        (rows, odd, sweeps) = (rows + touching, odd + off, sweeps + 1);
    }
    println!("{sweeps} sweeps, {rows} rows, {odd} odd");
    assert!(sweeps > 12 && odd * 50 < rows, "{odd} of {rows} rows in {sweeps} sweeps");
}

#[test]
fn logs_of_robots_that_turn_near_corners_are_felt_as_another_simulation_made_them() {
    let Some(folder) = shared("corners") else { return };
    let robot = Robot::default();
    let whisker = &robot.whiskers[0];
    // The last two end in shapes that buckle.
    for (name, most) in [("seed16-active", 0), ("seed16-random", 0), ("seed13-active", 10), ("seed8-active", 2)] {
        let map = vibrissa::read_map(folder.join(name).join("map.geojson")).unwrap();
        let rows = |file: &str| std::fs::read_to_string(folder.join(name).join(file)).unwrap();
        let pose = |line: &str| {
            let v: Vec<f64> = line.split_whitespace().map(|word| word.parse().unwrap()).collect();
            Pose2::new(v[1], v[2], 2.0 * v[6].atan2(v[7])).compose(whisker.robot_from_whisker)
        };
        let path: Vec<Pose2> = rows("truth.tum").lines().map(pose).collect();
        let moment = |line: &str| -> f64 { line.rsplit(',').next().unwrap().parse().unwrap() };
        let read: Vec<f64> = rows("log.csv").lines().skip(1).map(moment).collect();
        let ours = predicted_moments(&map, &TipModel::new(&whisker.beam).unwrap(), &path);
        let off = |(ours, z): &(&PredictedMoment, &f64)| (ours.moment - *z).abs() > 0.06 * z.abs() + 3e-5;
        let odd = ours.iter().zip(&read).filter(off).count();
        println!("{name}: {odd} odd rows of {}", read.len());
        assert!(odd <= most && ours.len() == read.len(), "{name}: {odd} of {}", read.len());
    }
}

/// A whisker whose tip goes over a corner between two rows is caught there, although the straight one would be past it: long rows agree with short ones.
#[test]
fn a_corner_that_the_tip_goes_over_between_two_rows_catches_it() {
    let mut draw = Random(0x0c07_4e75);
    let length = 0.07;
    let beam = vibrissa::beam::Whisker { length, flexural_rigidity: 3e-4, ..Default::default() };
    let tip = TipModel::new(&beam).unwrap();
    let (mut caught, mut past) = (0, 0);
    for case in 0..200 {
        // A square thing that points at the base with one corner, off by up to 30 degrees, in a large room.
        let square = |half: f64, turn: f64, middle: Vec2| {
            let points: Vec<Vec2> = (0..4)
                .map(|k| middle + Vec2::from_angle(turn + f64::from(k) * std::f64::consts::FRAC_PI_2) * half)
                .collect();
            Curve::polyline(&points, true).unwrap()
        };
        let turn = draw.signed(0.5);
        let corner = Vec2::from_angle(draw.signed(3.0)) * 0.05;
        let thing =
            square(0.03, std::f64::consts::PI + turn, corner - Vec2::from_angle(std::f64::consts::PI + turn) * 0.03);
        let map = Map::new(vec![
            Boundary::new(Role::Arena, square(0.6, 0.3, Vec2::ZERO), None).unwrap(),
            Boundary::new(Role::Obstacle, thing, None).unwrap(),
        ])
        .unwrap();
        // The tip reaches over the corner by up to 0.3 mm and goes by it in steps of 4 mm, somewhat towards it or away.
        let (over, side) = (draw.between(5e-5, 3e-4), draw.sign());
        let step = Vec2::from_angle(side * (std::f64::consts::FRAC_PI_2 - draw.signed(0.5))) * 4e-3;
        let begin = corner + Vec2::new(over - length, 0.0) - step * draw.between(1.1, 1.9);
        let row = |share: f64| {
            let at = begin + step * share;
            Pose2::new(at.x, at.y, 0.0)
        };
        const SHORT: usize = 500;
        let long: Vec<Pose2> = (0..6).map(|k| row(f64::from(k))).collect();
        let short: Vec<Pose2> = (0..=5 * SHORT).map(|k| row(k as f64 / SHORT as f64)).collect();
        let (long, short) = (predicted_moments(&map, &tip, &long), predicted_moments(&map, &tip, &short));
        for (k, one) in long.iter().enumerate() {
            let exact = &short[k * SHORT];
            assert_eq!(one.touching, exact.touching, "case {case}, row {k}: {one:?} {exact:?}");
            assert!((one.moment - exact.moment).abs() < 1e-6 * beam.flexural_rigidity / length, "case {case}, row {k}");
        }
        if long.iter().any(|one| one.touching) { caught += 1 } else { past += 1 }
    }
    println!("{caught} caught, {past} past");
    assert!(caught >= 40 && past >= 40);
}

#[test]
fn readings_tell_on_which_branch_of_equilibria_a_whisker_is() {
    let mut draw = Random(29);
    let beam = Robot::default().whiskers[0].beam;
    let (length, tip) = (beam.length, TipModel::new(&beam).unwrap());
    let noise = MomentNoise { moment_relative: 0.01, moment_absolute: 1e-3 * beam.flexural_rigidity / length };
    for case in 0..30 {
        // Head-on against a wall a whisker bends to either side; which one it is depends on how it came there.
        let (turn, at) = (draw.signed(3.0), Vec2::new(draw.signed(0.2), draw.signed(0.2)));
        let ends = [-0.3, 0.3].map(|x| at + Vec2::new(x, 0.0).rotated(turn));
        let map =
            Map::new(vec![Boundary::new(Role::Wall, Curve::polyline(&ends, false).unwrap(), None).unwrap()]).unwrap();
        let pose = |depth: f64, tilt: f64| {
            let base = at + Vec2::new(0.0, length * (1.0 - depth)).rotated(turn);
            Pose2::new(base.x, base.y, turn + tilt - std::f64::consts::FRAC_PI_2)
        };
        let (depth, tilt) = (draw.between(0.15, 0.3), draw.sign() * draw.between(0.08, 0.12));
        let steps = |from: (f64, f64), to: (f64, f64)| {
            let way = move |k: i32| {
                pose(from.0 + (to.0 - from.0) * f64::from(k) / 40.0, from.1 + (to.1 - from.1) * f64::from(k) / 40.0)
            };
            (0..=40).map(way)
        };
        let end = |tilt: f64| steps((depth, tilt), (depth - 0.03, tilt));
        // There on this branch, and there on the other one, tilted over while it is pressed.
        let straight: Vec<Pose2> = steps((-0.02, tilt), (depth, tilt)).chain(end(tilt)).collect();
        let other: Vec<Pose2> = steps((-0.02, -tilt), (depth, -tilt))
            .chain(steps((depth, -tilt), (depth, tilt)))
            .chain(end(tilt))
            .collect();
        let (ours, theirs) = (predicted_moments(&map, &tip, &straight), predicted_moments(&map, &tip, &other));
        let (ours, theirs) = (&ours[ours.len() - 41..], &theirs[theirs.len() - 41..]);
        assert!(ours[0].moment * theirs[0].moment < 0.0, "case {case}: {:?} {:?}", ours[0], theirs[0]);
        // The readings of the one, and from some row on those of the other.
        let path: Vec<Pose2> = straight.iter().copied().chain(end(tilt)).collect();
        let all = predicted_moments(&map, &tip, &straight);
        let readings: Vec<f64> = all.iter().chain(theirs).map(|one| one.moment).collect();
        let told = predicted_moments_by_readings(&map, &tip, &path, &readings, noise);
        // Without readings, or as long as there are some, it is the branch that is followed.
        let plain = predicted_moments(&map, &tip, &path);
        for count in [0, 50] {
            assert_eq!(predicted_moments_by_readings(&map, &tip, &path, &readings[..count], noise), plain);
        }
        for (row, (one, exact)) in told.iter().zip(&readings).enumerate() {
            // Two readings that contradict are not yet another branch.
            let is_first = (82..84).contains(&row);
            let off = (one.moment - exact).abs() * length / beam.flexural_rigidity;
            assert!(is_first || off < 1e-6, "case {case}, row {row}: {one:?}, not {exact}");
        }
    }
}

#[test]
fn a_whisker_that_meets_a_wall_head_on_between_two_rows_bends_to_the_side_on_which_it_leans() {
    let mut draw = Random(31);
    let beam = Robot::default().whiskers[0].beam;
    let (length, tip) = (beam.length, TipModel::new(&beam).unwrap());
    for case in 0..60 {
        let (turn, at) = (draw.signed(3.0), Vec2::new(draw.signed(0.2), draw.signed(0.2)));
        let ends = [-0.3, 0.3].map(|x| at + Vec2::new(x, 0.0).rotated(turn));
        let map =
            Map::new(vec![Boundary::new(Role::Wall, Curve::polyline(&ends, false).unwrap(), None).unwrap()]).unwrap();
        // A row ends before the wall, the next one pressed against it; then the robot turns past the wall's normal.
        let (tilt, depth) = (draw.sign() * draw.between(0.01, 0.06), draw.between(0.02, 0.05));
        let pose = |depth: f64, tilt: f64| {
            let base = at + Vec2::new(0.0, length * (1.0 - depth)).rotated(turn);
            Pose2::new(base.x, base.y, turn + tilt - std::f64::consts::FRAC_PI_2)
        };
        let path = [pose(-0.02, tilt), pose(depth, tilt), pose(depth, 0.5 * tilt), pose(depth, -0.3 * tilt)];
        let told = predicted_moments(&map, &tip, &path);
        for (row, one) in told.iter().enumerate().skip(1) {
            assert!(one.touching && one.moment * told[1].moment > 0.0, "case {case}, tilt {tilt}, row {row}: {told:?}");
        }
        // As one that leans so far on the same side that nothing is open, pressed slowly.
        let oblique = 0.16 * tilt.signum();
        let slow: Vec<Pose2> =
            (0..=400).map(|k| pose(-0.02 + (depth + 0.02) * f64::from(k) / 400.0, oblique)).collect();
        let sign = predicted_moments(&map, &tip, &slow).last().unwrap().moment;
        assert!(told[1].moment * sign > 0.0, "case {case}, tilt {tilt}: {told:?}, not as {sign}");
    }
}
