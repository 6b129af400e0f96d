//! What the node knows as messages.

use crate::config::{BOND_PERIOD, BOND_TIMEOUT, MOST_PLACES, STALE};
use crate::engine::{Pulse, Report};
use crate::lifecycle::Lifecycle;
use crate::messages::{
    BondStatus, DiagnosticArray, DiagnosticStatus, Header, KeyValue, Pose, PoseArray, PoseWithCovariance,
    PoseWithCovarianceStamped, TFMessage, Time, Transform, TransformStamped, covariance_of_plane,
};
use vibrissa_core::flow::pose::{Hypothesis, Status};

fn header(t: f64, frame: &str) -> Header {
    Header { stamp: Time::from_seconds(t), frame_id: frame.to_owned() }
}

/// The pose with its covariance; none unless one place is known: a covariance cannot tell of several.
#[must_use]
pub fn pose(report: &Report, frame: &str) -> Option<PoseWithCovarianceStamped> {
    let best = report.estimate.hypotheses.first().filter(|_| report.estimate.status == Status::Localized)?;
    let covariance = covariance_of_plane(&best.covariance.unwrap_or_else(|| of_extent(best)));
    Some(PoseWithCovarianceStamped {
        header: header(report.t, frame),
        pose: PoseWithCovariance { pose: best.pose.into(), covariance },
    })
}

/// The covariance of a state anywhere in a place's extent, where the method gives none.
fn of_extent(place: &Hypothesis) -> [[f64; 3]; 3] {
    let mut covariance = [[0.0; 3]; 3];
    let extent = &place.extent;
    for (index, width) in [extent.x.width(), extent.y.width(), extent.theta.width()].into_iter().enumerate() {
        covariance[index][index] = width * width / 12.0;
    }
    covariance
}

/// Every place that may be the true one; none where nothing explains the readings.
#[must_use]
pub fn places(report: &Report, frame: &str) -> PoseArray {
    let told = if report.estimate.status == Status::Inconsistent { &[] } else { report.estimate.hypotheses.as_slice() };
    let poses = told.iter().take(MOST_PLACES).map(|place| Pose::from(place.pose)).collect();
    PoseArray { header: header(report.t, frame), poses }
}

/// `map -> odom`, dated ahead.
#[must_use]
pub fn transform(pulse: &Pulse, map: &str, odom: &str, ahead: f64) -> Option<TFMessage> {
    let (t, pose) = pulse.map_from_odom?;
    let Pose { position, orientation } = pose.into();
    let transform = Transform { translation: position, rotation: orientation };
    Some(TFMessage {
        transforms: vec![TransformStamped {
            header: header(t + ahead, map),
            child_frame_id: odom.to_owned(),
            transform,
        }],
    })
}

/// A sign of life.
#[must_use]
pub fn bond(now: f64, node: &str, instance: &str, active: bool) -> BondStatus {
    BondStatus {
        header: header(now, ""),
        id: node.to_owned(),
        instance_id: instance.to_owned(),
        active,
        heartbeat_timeout: BOND_TIMEOUT as f32,
        heartbeat_period: BOND_PERIOD as f32,
    }
}

/// How the node does, for `/diagnostics`.
#[must_use]
pub fn diagnostics(pulse: &Pulse, now: f64, node: &str) -> DiagnosticArray {
    let mut values = vec![("state", pulse.state.message().label)];
    if let Some(status) = pulse.status {
        values.push(("status", status.as_str().to_owned()));
        values.push(("places", pulse.places.to_string()));
    }
    let [rows, merged, refused] = pulse.rows.map(|count| count.to_string());
    values.extend([("rows", rows), ("merged", merged), ("refused", refused)]);
    values.push(("restarts", pulse.restarts.to_string()));
    let mut level = 0;
    let mut words =
        pulse.status.map_or_else(|| pulse.state.message().label, |status| status.as_str().replace('_', " "));
    if pulse.status == Some(Status::Inconsistent) {
        level = 1;
        words.push_str(": no place on the map explains the readings; check map, robot file and initialpose");
    }
    let mut keyed: Vec<KeyValue> =
        values.into_iter().map(|(key, value)| KeyValue { key: key.to_owned(), value }).collect();
    for (name, counts, age) in &pulse.sources {
        let mut push = |key: &str, value: String| keyed.push(KeyValue { key: format!("{name}.{key}"), value });
        push("frames", counts.frames.to_string());
        push("missing", counts.missing().to_string());
        push("seconds since the last", age.map_or("none came".to_owned(), |age| format!("{age:.1}")));
        if age.is_none_or(|age| age > STALE) {
            level = level.max(1);
            words = format!(
                "no {name} for {}; check topic, type and quality of service",
                match age {
                    None => "ever".to_owned(),
                    Some(age) => format!("{age:.0} s"),
                }
            );
        }
    }
    if let Some(fault) = &pulse.fault {
        (level, words) = (2, fault.clone());
    }
    if pulse.state != Lifecycle::Active && pulse.fault.is_none() {
        level = 0;
    }
    DiagnosticArray {
        header: header(now, ""),
        status: vec![DiagnosticStatus {
            level,
            name: format!("{node}: localization"),
            message: words,
            hardware_id: "whiskers".to_owned(),
            values: keyed,
        }],
    }
}
