//! What a page needs to draw a run, as JSON: every whisker as the map bends it, all readings, what was lost. docs/live.md lists the
//! fields.

use crate::config::{SHAPE_DIGIT, SHAPE_POINTS};
use crate::estimate::Told;
use crate::join::JoinedRow;
use crate::run::Health;
use serde_json::{Value, json};
use vibrissa_core::contact::BentWhisker;
use vibrissa_core::flow::pose::Status;
use vibrissa_core::flow::sensor_log::{Channel, LogRow, Quantity};
use vibrissa_core::math;
use vibrissa_core::plane::{Pose2, Vec2};
use vibrissa_core::world::{Map, MountedWhisker, ReadingNoise, Robot};

/// The whiskers of a robot on a map, from estimate to estimate.
#[derive(Debug)]
pub struct Scene<'a> {
    robot: &'a Robot,
    channels: &'a [Channel],
    /// None of whiskers that are curved at rest or lean.
    bent: Vec<Option<BentWhisker<'a>>>,
}

impl<'a> Scene<'a> {
    /// The scene of rows with these channels.
    #[must_use]
    pub fn new(map: &'a Map, robot: &'a Robot, channels: &'a [Channel]) -> Self {
        let bent = |whisker: &MountedWhisker| {
            whisker.lean.is_level().then(|| BentWhisker::new(map, &whisker.beam).ok()).flatten()
        };
        let bent = robot.whiskers.iter().map(bent).collect();
        Self { robot, channels, bent }
    }

    /// The message of `/vibrissa/whiskers`: an estimate, and the row that it is of.
    #[must_use]
    pub fn whiskers(&mut self, told: &Told, row: &LogRow) -> Value {
        let best = told.estimate.hypotheses.first().filter(|_| told.estimate.status != Status::Inconsistent);
        let pose = best.map(|place| place.pose);
        let whiskers: Vec<Value> = (0..self.robot.whiskers.len()).map(|index| self.whisker(index, pose, row)).collect();
        json!({ "t": told.t, "pose": pose.map(pose_value), "carried": told.carried, "whiskers": whiskers })
    }

    fn whisker(&mut self, index: usize, map_from_robot: Option<Pose2>, row: &LogRow) -> Value {
        let whisker = &self.robot.whiskers[index];
        let read: Vec<(&Channel, f64)> = self
            .channels
            .iter()
            .zip(&row.readings)
            .filter(|(channel, _)| unit(channel.quantity).is_some())
            .filter(|(channel, _)| channel.whisker.is_empty() || channel.whisker == whisker.name)
            .map(|(channel, value)| (channel, *value))
            .collect();
        let mount = whisker.robot_from_whisker;
        let bending = match (&mut self.bent[index], map_from_robot) {
            (Some(bent), Some(pose)) => Some(bent.at(pose.compose(mount), SHAPE_POINTS)),
            _ => None,
        };
        let expected = bending.as_ref().and_then(|bending| bending.moment);
        let touching = read.iter().any(|(channel, value)| {
            noise_of(channel.quantity, whisker)
                .is_some_and(|noise| value.abs() * (1.0 - noise.relative) > noise.absolute)
        });
        let moment = read.iter().find(|(channel, _)| channel.quantity == Quantity::Moment).map(|(_, value)| *value);
        let seen = bending.as_ref().filter(|bending| bending.shape.len() > 2);
        let (from, shape) = match (seen, moment.filter(|_| touching), &self.bent[index]) {
            (Some(bending), ..) => ("map", bending.shape.clone()),
            (None, Some(moment), Some(bent)) => ("reading", bent.by_moment(moment, SHAPE_POINTS)),
            _ => ("rest", vec![Vec2::ZERO, Vec2::new(whisker.beam.length * math::cos(whisker.lean.elevation), 0.0)]),
        };
        let contact = seen.and_then(|bending| bending.contact);
        let readings: Vec<Value> =
            read.iter().map(|(channel, value)| reading(channel, *value, whisker, expected)).collect();
        json!({
            "name": whisker.name, "mount": pose_value(mount), "length": whisker.beam.length, "touching": touching,
            "readings": readings, "from": from,
            "shape": shape.iter().map(|point| point_value(mount.transform_point(*point))).collect::<Vec<_>>(),
            "contact": contact.map(|point| point_value(mount.transform_point(point))),
        })
    }

    /// The message of `/vibrissa/readings`: rows, oldest first.
    #[must_use]
    pub fn readings<'r>(&self, rows: impl Iterator<Item = &'r JoinedRow> + Clone) -> Value {
        let told: Vec<usize> =
            (0..self.channels.len()).filter(|&index| unit(self.channels[index].quantity).is_some()).collect();
        let of = |index: usize| -> Vec<Option<f64>> {
            rows.clone().map(|row| row.row.readings.get(index).copied().filter(|value| value.is_finite())).collect()
        };
        let channels = || told.iter().map(|&index| &self.channels[index]);
        json!({
            "columns": channels().map(Channel::column).collect::<Vec<_>>(),
            "units": channels().map(|channel| unit(channel.quantity)).collect::<Vec<_>>(),
            "t": rows.clone().map(|row| row.row.t).collect::<Vec<_>>(),
            "values": told.iter().map(|&index| of(index)).collect::<Vec<_>>(),
        })
    }
}

/// The message of `/vibrissa/health`.
#[must_use]
pub fn health(health: &Health) -> Value {
    let sources: Vec<Value> = health
        .sources
        .iter()
        .map(|(name, counts)| {
            let mut source: serde_json::Map<String, Value> =
                counts.all().into_iter().map(|(word, count)| (word.to_owned(), json!(count))).collect();
            source.insert("name".to_owned(), json!(name));
            source.insert("missing".to_owned(), json!(counts.missing()));
            Value::Object(source)
        })
        .collect();
    json!({
        "rows": health.rows, "merged": health.merged, "refused": health.refused, "carried": health.carried,
        "missing": health.sources.iter().map(|(_, counts)| counts.missing()).sum::<u64>(),
        "not_recorded": health.dropped, "latency_p99": health.latency.quantile(0.99),
        "estimate_p99": health.taken.quantile(0.99), "disk": health.disk, "sources": sources,
    })
}

fn reading(channel: &Channel, value: f64, whisker: &MountedWhisker, expected: Option<f64>) -> Value {
    let bound = noise_of(channel.quantity, whisker).map(|noise| noise.relative * value.abs() + noise.absolute);
    let expected = expected.filter(|_| channel.quantity == Quantity::Moment);
    json!({
        "column": channel.column(), "unit": unit(channel.quantity), "value": value, "bound": bound, "expected": expected,
    })
}

fn noise_of(quantity: Quantity, whisker: &MountedWhisker) -> Option<ReadingNoise> {
    match quantity {
        Quantity::Moment | Quantity::Across => Some(whisker.noise.into()),
        Quantity::Force => Some(whisker.force_noise),
        Quantity::Slope => Some(whisker.slope_noise),
        _ => None,
    }
}

/// The unit of what is told; none of flux and counts, of which moments were made.
fn unit(quantity: Quantity) -> Option<&'static str> {
    match quantity {
        Quantity::Moment | Quantity::Across => Some("N m"),
        Quantity::Force => Some("N"),
        Quantity::Slope => Some("rad"),
        Quantity::StripLo | Quantity::StripHi => Some("m"),
        Quantity::FluxX
        | Quantity::FluxY
        | Quantity::FluxZ
        | Quantity::CountX
        | Quantity::CountY
        | Quantity::CountZ => None,
    }
}

fn pose_value(pose: Pose2) -> Value {
    json!({ "x": pose.x, "y": pose.y, "theta": pose.theta })
}

/// A point to what can be seen.
fn point_value(point: Vec2) -> Value {
    let short = |value: f64| (value / SHAPE_DIGIT).round() * SHAPE_DIGIT;
    json!([short(point.x), short(point.y)])
}
