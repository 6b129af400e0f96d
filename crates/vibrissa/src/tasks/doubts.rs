//! What looks wrong where log, robot and map meet, without being impossible: most often a wrong unit.

use crate::config::limits::{FARTHEST_MAP, FARTHEST_MOUNT, SMALLEST_MAP};
use crate::flow::sensor_log::{LogRow, Quantity, SensorLog};
use crate::plane::Vec2;
use crate::world::{Map, MountedWhisker, Robot, Role};

/// What looks wrong, in words for people; `map` where there is one.
///
/// The files' own doubts are in [`Map::warnings`] and [`SensorLog::warnings`].
#[must_use]
pub fn doubts(log: Option<&SensorLog>, robot: &Robot, map: Option<&Map>) -> Vec<String> {
    let mounts = robot.whiskers.iter().filter_map(far_mount);
    let starts =
        log.into_iter().flat_map(|log| robot.whiskers.iter().filter_map(|whisker| touches_first(log, whisker)));
    let same =
        log.into_iter().flat_map(|log| robot.whiskers.iter().filter_map(|whisker| stuck_or_saturated(log, whisker)));
    let maps = map.into_iter().flat_map(|map| of_map(map, robot));
    mounts.chain(starts).chain(same).chain(maps).chain(log.and_then(of_way)).collect()
}

/// A way of less than this (m) that begins farther from the origin than this (m) may be counted in degrees on the globe.
const SHORT_WAY: f64 = 2e-3;
const FAR_BEGINNING: f64 = 1.0;

/// Whether the log's poses are longitude and latitude.
fn of_way(log: &SensorLog) -> Option<String> {
    let first = log.rows.first()?.odom_from_robot.position();
    let farthest = log.rows.iter().map(|row| row.odom_from_robot.position().distance(first)).fold(0.0, f64::max);
    let on_globe = first.norm() >= FAR_BEGINNING && first.x.abs() <= 180.0 && first.y.abs() <= 180.0;
    (on_globe && farthest > 0.0 && farthest < SHORT_WAY).then(|| {
        format!(
            "the robot goes no farther than {:.3} mm from where the log begins, at ({:.4}, {:.4}); are x and y longitude \
             and latitude? They have to be metres in a plane",
            farthest * 1e3,
            first.x,
            first.y
        )
    })
}

fn far_mount(whisker: &MountedWhisker) -> Option<String> {
    let distance = whisker.robot_from_whisker.position().norm();
    (distance > FARTHEST_MOUNT).then(|| {
        format!(
            "the whisker {} is mounted {distance:.3} m from the robot's origin; are these millimetres where metres are \
             due? Strings carry their unit: \"20 mm\"",
            whisker.name
        )
    })
}

/// The column of a whisker's moments.
fn moments_of(log: &SensorLog, whisker: &MountedWhisker) -> Option<usize> {
    let alone = |name: &str| name.is_empty() || name == whisker.name;
    log.channels.iter().position(|c| c.quantity == Quantity::Moment && alone(&c.whisker))
}

/// Fewest rows, their share of all, and shortest way (m) over which readings that are the same to the last bit are doubted: a
/// sensor has noise.
const SAME_ROWS: usize = 100;
const SAME_SHARE: f64 = 0.25;
const SAME_WAY: f64 = 0.01;

/// The largest moment of a whisker (N m), and in how many rows it reads just that while the robot moves, where these are too many:
/// a sensor that is saturated, or stuck.
pub(super) fn same_largest(log: &SensorLog, whisker: &MountedWhisker) -> Option<(f64, usize)> {
    let channel = moments_of(log, whisker)?;
    let reading = |row: &LogRow| row.readings.get(channel).map_or(0.0, |reading| reading.abs());
    let largest = log.rows.iter().map(reading).fold(0.0, f64::max);
    let (mut rows, mut way, mut before) = (0, 0.0, None);
    for row in &log.rows {
        let is_same = reading(row).to_bits() == largest.to_bits();
        let place = row.odom_from_robot.position();
        if let Some(before) = before.filter(|_| is_same) {
            way += place.distance(before);
        }
        rows += usize::from(is_same);
        before = is_same.then_some(place);
    }
    let many = rows >= SAME_ROWS && rows as f64 >= SAME_SHARE * log.rows.len() as f64;
    (largest > 0.0 && many && way >= SAME_WAY).then_some((largest, rows))
}

fn stuck_or_saturated(log: &SensorLog, whisker: &MountedWhisker) -> Option<String> {
    let (largest, rows) = same_largest(log, whisker)?;
    let (name, all) = (&whisker.name, log.rows.len());
    Some(if rows == all {
        format!("{name} reads the same in all {all} rows while the robot moves: is the sensor stuck, or not connected?")
    } else {
        format!(
            "{name} reads {:.4} mN m, its largest, in {rows} of {all} rows while the robot moves: is the sensor saturated?",
            largest * 1e3
        )
    })
}

/// A contact in the first row, where nothing tells a contact from a zero that is off.
fn touches_first(log: &SensorLog, whisker: &MountedWhisker) -> Option<String> {
    let moment = *log.rows.first()?.readings.get(moments_of(log, whisker)?)?;
    let limit = whisker.noise.largest_free_reading() + whisker.errors.zero;
    (moment.abs() > limit).then(|| {
        format!(
            "{} touches in the first row ({:.4} mN m): begin the log while the whisker is free, or see that its zero is \
             not off",
            whisker.name,
            moment * 1e3
        )
    })
}

fn of_map(map: &Map, robot: &Robot) -> Vec<String> {
    let mut doubts = Vec::new();
    let (bounds, longest) = (map.bounds(), robot.whiskers.iter().map(|w| w.beam.length).fold(0.0, f64::max));
    let size = bounds.size().x.max(bounds.size().y);
    let centre = (bounds.min + bounds.max) * 0.5;
    let from_origin = centre.norm();
    if size < SMALLEST_MAP * longest {
        doubts.push(format!(
            "the map is {:.3} mm wide, less than a whisker is long; is it in another unit than its format has?",
            size * 1e3
        ));
    }
    if from_origin > FARTHEST_MAP * size && centre.x.abs() <= 180.0 && centre.y.abs() <= 90.0 {
        doubts.push(format!(
            "the map is around ({:.4}, {:.4}) and {size:.4} wide; are its coordinates longitude and latitude? They have \
             to be metres in a plane",
            centre.x, centre.y
        ));
    }
    let has_arena = map.boundaries().iter().any(|boundary| boundary.role() == Role::Arena);
    let outside = |points: &[Vec2]| points.iter().all(|&point| !inside_arena(map, point));
    let obstacles = map.boundaries().iter().filter(|boundary| boundary.role() == Role::Obstacle && has_arena);
    let lost: Vec<Vec2> = obstacles
        .map(|obstacle| obstacle.curve().flatten(OBSTACLE_TOLERANCE))
        .filter(|points| outside(points))
        .filter_map(|points| points.first().copied())
        .collect();
    if let Some(first) = lost.first() {
        doubts.push(format!(
            "obstacles lie outside of the arena, where nothing can touch them: {} of them, one at ({:.3}, {:.3}) m",
            lost.len(),
            first.x,
            first.y
        ));
    }
    doubts
}

/// How closely obstacles are looked at (m).
const OBSTACLE_TOLERANCE: f64 = 1e-3;

/// Whether a point is inside an arena's outline, by the crossings of a ray to the right.
fn inside_arena(map: &Map, point: Vec2) -> bool {
    let arenas = map.boundaries().iter().filter(|boundary| boundary.role() == Role::Arena);
    arenas.map(|arena| arena.curve().flatten(OBSTACLE_TOLERANCE)).any(|ring| {
        let next = ring.iter().cycle().skip(1);
        let crossings = ring.iter().zip(next).filter(|(a, b)| {
            (a.y > point.y) != (b.y > point.y) && point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x)
        });
        crossings.count() % 2 == 1
    })
}
