//! How good a map is that a robot makes of its own log: simulated laps along the walls of random rooms.
//!
//! `cargo run --release --example mapping_laps -- [LAPS] [FIRST_SEED] [odometry]`. A third of the rooms each are rectangles, L-shaped and
//! polygons with any angles; errors of readings are even, at the ends of their bounds, normal or correlated. With `odometry` its ways are
//! wrong by up to 1 % and its heading by up to a degree a metre, and by independent errors of a tenth of that.

#[path = "../tests/data/lap.rs"]
mod lap;
#[path = "../tests/data/random.rs"]
mod random;

use lap::{Kind, Law, OdometryError, record, robot, room, way};
use random::Random;
use vibrissa::Stop;
use vibrissa::config::MappingOptions;
use vibrissa::plane::Vec2;
use vibrissa::tasks::mapping::{ClosureVerdict, Mapped, map_log};
use vibrissa::tasks::profile::compare;
use vibrissa::world::Odometry;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize, default: u64| words.get(k).and_then(|w| w.parse().ok()).unwrap_or(default);
    let wrong = words.iter().any(|word| word == "odometry");
    for seed in number(1, 1)..number(1, 1) + number(0, 6) {
        match mapped(seed, wrong) {
            Some(told) => println!("{told}"),
            None => println!("{seed} no lap"),
        }
    }
}

fn mapped(seed: u64, wrong: bool) -> Option<String> {
    let mut draw = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let kind = [Kind::Rectangle, Kind::LShape, Kind::Polygon][(seed % 3) as usize];
    let law = [Law::Even, Law::Edge, Law::Normal, Law::Correlated][(seed / 3 % 4) as usize];
    let room = room(&mut draw, kind, (1.6, 4.0))?;
    let mut robot = robot(&mut draw);
    let length = room.map.total_length();
    let path = way(&room, &mut draw, 0.3, 1.35 * length)?;
    let degree = 1f64.to_radians();
    let error = if wrong {
        OdometryError { scale: draw.signed(0.01), drift: draw.signed(degree), noise: 0.001 }
    } else {
        OdometryError::default()
    };
    let mut options = MappingOptions::default();
    if wrong {
        robot.odometry = Odometry { translation_relative: 0.0115, rotation_relative: 0.002, ..Odometry::default() };
        options.drift = 1.05 * degree;
        // The walls are at least 40 mm away.
        options.body_radius = 0.035;
    }
    let lap = record(&room.map, &robot, &path, law, error, &mut draw)?;
    let started = std::time::Instant::now();
    let found = match map_log(&lap.log, &robot, options, &Stop::default(), &mut |_, _| {}) {
        Ok(found) => found,
        Err(error) => return Some(format!("{seed}: {error}")),
    };
    let took = started.elapsed().as_secs_f64();
    if let Ok(folder) = std::env::var("MAPS") {
        let _ =
            std::fs::write(format!("{folder}/map{seed}.geojson"), vibrissa::io::map::to_geojson(&found.outline.map));
        let graph = vibrissa::tasks::mapping::graph_to_json(&found.graph).to_string();
        let _ = std::fs::write(format!("{folder}/graph{seed}.json"), graph);
    }
    let judged = judge(&found, &room, path[0].map_from_robot)?;
    let count = |verdict| found.closures.iter().filter(|closure| closure.verdict == verdict).count();
    let places: Vec<String> = found
        .closures
        .iter()
        .map(|c| format!("{}:{:.0},{:.0},{:.0}", c.places, 1e3 * c.extent[0], 1e3 * c.extent[1], 1e3 * c.extent[2]))
        .collect();
    Some(format!(
        "{seed} {kind:?} {law:?} {length:.2} m {} rows {took:.1} s: {} boundaries, {} points, corners {} of {}; {judged}; scale {:+.2} ± {:.2} % (true {:+.2}), drift {:+.2} ± {:.2} deg/m (true {:+.2}); closures proved {} open {} contradicted {} unfinished {} {places:?}",
        lap.log.rows.len(),
        found.outline.map.boundaries().len(),
        found.points,
        found.outline.corners.len(),
        room.corners.len(),
        1e2 * found.shares.scale.value,
        1e2 * found.shares.scale.std,
        -1e2 * error.scale,
        found.shares.drift.value / degree,
        found.shares.drift.std / degree,
        -error.drift / degree,
        count(ClosureVerdict::Proved),
        count(ClosureVerdict::Hypothesis),
        count(ClosureVerdict::Contradiction),
        count(ClosureVerdict::Unfinished),
    ))
}

/// Errors after the best rigid motion.
fn judge(found: &Mapped, room: &lap::Room, first: vibrissa::plane::Pose2) -> Option<String> {
    // The outline's frame is that of the first row: laid where the robot was.
    let first = first.compose(found.trajectory()[0].map_from_robot.inverse());
    let map = &found.outline.map;
    let is_known = |sample: &&vibrissa::world::BoundarySample| {
        let boundary = &map.boundaries()[sample.boundary];
        let piece = boundary.curve().segment_at(sample.arc_length);
        !matches!(boundary.piece_course(piece), Some(vibrissa::world::PieceCourse::Unknown(_)))
    };
    let points: Vec<Vec2> =
        map.samples(2e-3).iter().filter(is_known).map(|sample| first.transform_point(sample.position)).collect();
    let felt = points.len() as f64 * 2e-3;
    let fit = compare(&points, &room.map, true)?;
    let corner = |p: Vec2| {
        let there = fit.map_from_outline.transform_point(first.transform_point(p));
        room.corners.iter().map(|c| c.distance(there)).fold(f64::INFINITY, f64::min)
    };
    let corners: Vec<f64> = found.outline.corners.iter().map(|c| corner(c.position)).collect();
    let worst = corners.iter().copied().fold(0.0, f64::max);
    let area =
        |map: &vibrissa::world::Map| map.boundaries().iter().map(|b| b.curve().signed_area().abs()).fold(0.0, f64::max);
    let scaled = fit.scaled.map_or(f64::NAN, |(misfit, _)| misfit.mean);
    Some(format!(
        "known {felt:.2} m, mean {:.3} p95 {:.2} max {:.1} mm (scaled {:.3}), corners worst {:.2} mm, area off {:+.2} %",
        1e3 * fit.shape.mean,
        1e3 * fit.shape.p95,
        1e3 * fit.shape.max,
        1e3 * scaled,
        1e3 * worst,
        1e2 * (area(map) / area(&room.map) - 1.0)
    ))
}
