//! Several logs of one room: a lap that makes the outline, and a second one that begins anywhere, after a wall has moved.
//!
//! `cargo run --release --example mapping_visits -- [ROOMS] [FIRST_SEED] [odometry]`. In two of three rooms one wall has moved by 3 to 20 mm
//! between the logs, to either side. With `odometry` ways are wrong by up to 0.5 % and the heading by up to half a degree a metre.

#[path = "../tests/data/lap.rs"]
mod lap;
#[path = "../tests/data/random.rs"]
mod random;

use lap::{Kind, Law, OdometryError, Room, record, robot, room, way};
use random::Random;
use vibrissa::Stop;
use vibrissa::config::MappingOptions;
use vibrissa::plane::{Curve, Vec2, wrap_angle};
use vibrissa::tasks::mapping::{Change, ChangeKind, map_logs};
use vibrissa::world::{Boundary, Map, Odometry, Role};

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize, default: u64| words.get(k).and_then(|w| w.parse().ok()).unwrap_or(default);
    let wrong = words.iter().any(|word| word == "odometry");
    for seed in number(1, 1)..number(1, 1) + number(0, 6) {
        match visited(seed, wrong) {
            Some(told) => println!("{told}"),
            None => println!("{seed} no lap"),
        }
    }
}

/// The room with one of its walls moved inwards (m).
fn moved(room: &Room, wall: usize, by: f64) -> Option<Room> {
    let count = room.corners.len();
    let corner = |k: usize| room.corners[k % count];
    let along = |k: usize| (corner(k + 1) - corner(k)) * (1.0 / corner(k).distance(corner(k + 1)));
    let on = corner(wall) + along(wall).perp() * by;
    // Where the moved wall meets its neighbours.
    let meet = |k: usize| {
        let (p, d) = (corner(k), along(k));
        p + d * ((on - p).cross(along(wall)) / d.cross(along(wall)))
    };
    let mut corners = room.corners.clone();
    corners[wall] = meet((wall + count - 1) % count);
    corners[(wall + 1) % count] = meet((wall + 1) % count);
    let map = Map::new(vec![Boundary::new(Role::Arena, Curve::polyline(&corners, true)?, None).ok()?]).ok()?;
    Some(Room { corners, map })
}

fn visited(seed: u64, wrong: bool) -> Option<String> {
    let mut draw = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let kind = [Kind::Rectangle, Kind::LShape, Kind::Polygon][(seed % 3) as usize];
    let law = [Law::Even, Law::Edge, Law::Normal, Law::Correlated][(seed / 3 % 4) as usize];
    let before = room(&mut draw, kind, (1.6, 3.0))?;
    let mut robot = robot(&mut draw);
    let wall = draw.between(0.0, before.corners.len() as f64) as usize;
    let by = if seed % 9 < 6 { draw.between(3e-3, 20e-3) * draw.sign() } else { 0.0 };
    let after = moved(&before, wall, by)?;
    let degree = 1f64.to_radians();
    // One robot: its odometry is wrong in the same way.
    let error = if wrong {
        OdometryError { scale: draw.signed(0.005), drift: draw.signed(0.5 * degree), noise: 5e-4 }
    } else {
        OdometryError::default()
    };
    let mut options = MappingOptions { body_radius: 0.035, ..MappingOptions::default() };
    if wrong {
        robot.odometry = Odometry { translation_relative: 0.006, rotation_relative: 0.002, ..Odometry::default() };
        options.drift = 0.55 * degree;
    }
    let length = before.map.total_length();
    let first = way(&before, &mut draw, 0.3, 1.3 * length)?;
    let (share, round) = (draw.between(0.1, 0.9), draw.between(0.8, 1.3));
    let turned = Room { corners: rotated(&after.corners, draw.between(0.0, 9.0) as usize), map: after.map.clone() };
    let second = way(&turned, &mut draw, share, round * length)?;
    let laps = [
        record(&before.map, &robot, &first, law, error, &mut draw)?,
        record(&after.map, &robot, &second, law, error, &mut draw)?,
    ];
    let logs = laps.map(|lap| lap.log);
    let started = std::time::Instant::now();
    let found = match map_logs(&logs, &robot, options, &Stop::default(), &mut |_, _| {}) {
        Ok(found) => found,
        Err(error) => return Some(format!("{seed}: {error}")),
    };
    let took = started.elapsed().as_secs_f64();
    if let Ok(folder) = std::env::var("MAPS") {
        let _ =
            std::fs::write(format!("{folder}/map{seed}.geojson"), vibrissa::io::map::to_geojson(&found.outline.map));
    }
    let map_from_first = first[0].map_from_robot.inverse();
    let off = found.visits[1].trajectory.iter().zip(&second).map(|(told, truth)| {
        let truth = map_from_first.compose(truth.map_from_robot);
        let turn = wrap_angle(told.map_from_robot.theta - truth.theta).abs();
        (told.map_from_robot.position().distance(truth.position()), turn)
    });
    let (place, turn) = off.fold((0.0_f64, 0.0_f64), |(a, b), (c, d)| (a.max(c), b.max(d)));
    let told = |change: &Change| {
        let length = 1e3 * change.length();
        match change.kind {
            ChangeKind::Moved { by, std } => format!("{length:.0} mm by {:+.2} ± {:.2} mm", 1e3 * by, 1e3 * std),
            ChangeKind::Gone => format!("{length:.0} mm gone"),
        }
    };
    let changes: Vec<String> = found.changes.iter().map(told).collect();
    let near = |p: Vec2| first[0].map_from_robot.transform_point(p);
    let corner = |p: Vec2| after.corners.iter().map(|c| c.distance(p)).fold(f64::INFINITY, f64::min);
    let worst = found.outline.corners.iter().map(|c| corner(near(c.position))).fold(0.0, f64::max);
    let count =
        |verdict: &str| found.closures.iter().filter(|c| c.logs.0 == 1 && c.verdict.as_str() == verdict).count();
    Some(format!(
        "{seed} {kind:?} {law:?} {length:.2} m {} and {} rows {took:.1} s: {} {} places; worst {:.2} mm {:.3} deg; wall of {:.0} mm moved {:+.1} mm, told {changes:?}; corners {} of {} worst {:.2} mm, {} boundaries; proved {} open {} contradicted {}",
        logs[0].rows.len(),
        logs[1].rows.len(),
        found.visits[1].placed.as_str(),
        found.visits[1].places,
        1e3 * place,
        turn.to_degrees(),
        1e3 * after.corners[wall].distance(after.corners[(wall + 1) % after.corners.len()]),
        1e3 * by,
        found.outline.corners.len(),
        after.corners.len(),
        1e3 * worst,
        found.outline.map.boundaries().len(),
        count("proved"),
        count("hypothesis") + count("unfinished"),
        count("contradiction"),
    ))
}

fn rotated(corners: &[Vec2], by: usize) -> Vec<Vec2> {
    let mut all = corners.to_vec();
    all.rotate_left(by % corners.len());
    all
}
