//! What viewers see of a run.

use crate::output::warn;
use serde_json::json;
use vibrissa::Result;
use vibrissa::flow::pose::Status;
use vibrissa::io::recording::parts::{STATES, STATES_HEIGHT, arrow, in_map, map_lines};
use vibrissa::io::ros::{Kind, encode_cloud, encode_lines, encode_pose};
use vibrissa::world::Map;
use vibrissa_live::estimate::Told;
use vibrissa_live::run::Health;
use vibrissa_live::view::{Encoding, ViewTopic, Viewer};

/// The topics by their index.
const POSE: usize = 0;
const STATES_TOPIC: usize = 1;
const LINES: usize = 2;
const ESTIMATE: usize = 3;
const HEALTH: usize = 4;
/// Length of a place's tail (m).
const TAIL: f64 = 0.02;

/// The socket.
pub(super) struct View(Viewer);

impl View {
    /// Listens on this machine only.
    pub(super) fn start(port: u16, map: &Map, quiet: bool) -> Result<Self> {
        let ros =
            |name: &str, kind, latched| ViewTopic { name: name.to_owned(), encoding: Encoding::Ros(kind), latched };
        let text = |name: &str| ViewTopic { name: name.to_owned(), encoding: Encoding::Json, latched: true };
        let topics = vec![
            ros("/vibrissa/pose", Kind::PoseWithCovariance, true),
            ros("/vibrissa/states", Kind::Cloud, true),
            ros("/vibrissa/lines", Kind::Markers, true),
            text("/vibrissa/estimate"),
            text("/vibrissa/health"),
        ];
        let viewer = Viewer::start(&format!("127.0.0.1:{port}"), topics)?;
        if !quiet {
            warn(&format!("viewers may open ws://{} (in Foxglove: open connection)", viewer.address()));
        }
        viewer.publish(LINES, 0.0, encode_lines(in_map(0.0), &[map_lines(map)]));
        Ok(Self(viewer))
    }

    /// Shows an estimate; it never waits for a viewer.
    pub(super) fn show(&self, told: &Told, health: &Health) {
        if self.0.viewers() == 0 {
            return;
        }
        let header = in_map(told.t);
        let places =
            if told.estimate.status == Status::Inconsistent { &[] } else { told.estimate.hypotheses.as_slice() };
        if let Some(best) = places.first() {
            let covariance = best.covariance.unwrap_or([[0.0; 3]; 3]);
            self.0.publish(POSE, told.t, encode_pose(header, best.pose, Some(&covariance)));
        }
        let dots = places.iter().flat_map(|place| arrow(&place.pose, TAIL)).map(|p| (p, STATES_HEIGHT, STATES));
        self.0.publish(STATES_TOPIC, told.t, encode_cloud(header, dots));
        self.0.publish(ESTIMATE, told.t, told.line.clone().into_bytes());
        let missing: u64 = health.sources.iter().map(|(_, counts)| counts.missing()).sum();
        let health = json!({
            "rows": health.rows, "merged": health.merged, "missing": missing, "not_recorded": health.dropped,
            "latency_p99": health.latency.quantile(0.99), "disk": health.disk,
        });
        self.0.publish(HEALTH, told.t, health.to_string().into_bytes());
    }
}
