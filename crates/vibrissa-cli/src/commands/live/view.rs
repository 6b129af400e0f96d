//! What viewers see of a run. Messages are made on a thread of their own: a run never waits for them.

use crate::output::warn;
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use vibrissa::Result;
use vibrissa::flow::pose::Status;
use vibrissa::flow::sensor_log::Channel;
use vibrissa::io::recording::parts::{STATES, STATES_HEIGHT, arrow, in_map, map_lines};
use vibrissa::io::ros::{Kind, encode_cloud, encode_lines, encode_pose};
use vibrissa::world::{Map, Robot};
use vibrissa_live::config::{ROWS_WAITING, VIEW_WAITING};
use vibrissa_live::estimate::Told;
use vibrissa_live::join::JoinedRow;
use vibrissa_live::run::{Health, Update};
use vibrissa_live::scene::{Scene, health};
use vibrissa_live::view::{Encoding, ViewTopic, Viewer};

/// The topics by their index.
const POSE: usize = 0;
const STATES_TOPIC: usize = 1;
const LINES: usize = 2;
const ESTIMATE: usize = 3;
const WHISKERS: usize = 4;
const READINGS: usize = 5;
const HEALTH: usize = 6;
/// Length of a place's tail (m).
const TAIL: f64 = 0.02;

/// What is made ready for viewers.
enum Seen {
    Began(Vec<Channel>, Robot),
    Row(JoinedRow),
    Estimate(Box<(Told, Health)>),
}

/// The socket, and the way to the thread that feeds it.
pub(super) struct View {
    viewer: Arc<Viewer>,
    sender: SyncSender<Seen>,
}

impl View {
    /// Listens on this machine only.
    pub(super) fn start(port: u16, map: &Map, quiet: bool) -> Result<Self> {
        let ros =
            |name: &str, kind, latched| ViewTopic { name: name.to_owned(), encoding: Encoding::Ros(kind), latched };
        let text = |name: &str, latched| ViewTopic { name: name.to_owned(), encoding: Encoding::Json, latched };
        let topics = vec![
            ros("/vibrissa/pose", Kind::PoseWithCovariance, true),
            ros("/vibrissa/states", Kind::Cloud, true),
            ros("/vibrissa/lines", Kind::Markers, true),
            text("/vibrissa/estimate", true),
            text("/vibrissa/whiskers", true),
            text("/vibrissa/readings", false),
            text("/vibrissa/health", true),
        ];
        let viewer = Arc::new(Viewer::start(&format!("127.0.0.1:{port}"), topics)?);
        if !quiet {
            warn(&format!(
                "viewers may open ws://{}: the tab Live of `vibrissa studio`, or Foxglove (open connection)",
                viewer.address()
            ));
        }
        viewer.publish(LINES, 0.0, encode_lines(in_map(0.0), &[map_lines(map)]));
        let (sender, receiver) = sync_channel(VIEW_WAITING);
        let (theirs, map) = (Arc::clone(&viewer), map.clone());
        // It ends with the sender.
        std::thread::spawn(move || feed(&theirs, &map, &receiver));
        Ok(Self { viewer, sender })
    }

    /// Shows what is new; it never waits: what is too much is left out.
    pub(super) fn show(&self, update: &Update<'_>) {
        let seen = match update {
            Update::Began(channels, robot) => Seen::Began(channels.to_vec(), Robot::clone(robot)),
            _ if self.viewer.viewers() == 0 => return,
            Update::Row(row) => Seen::Row(JoinedRow::clone(row)),
            Update::Estimate(told, health) => Seen::Estimate(Box::new((Told::clone(told), Health::clone(health)))),
            Update::Notice(_) | Update::Idle(_) => return,
        };
        let _ = self.sender.try_send(seen);
    }
}

/// Makes messages of what is seen until the run is over.
fn feed(viewer: &Viewer, map: &Map, receiver: &Receiver<Seen>) {
    // Nothing is seen before the sources have said what they hold.
    let Some((channels, robot)) = receiver.iter().find_map(|seen| match seen {
        Seen::Began(channels, robot) => Some((channels, robot)),
        _ => None,
    }) else {
        return;
    };
    let mut scene = Scene::new(map, &robot, &channels);
    let mut rows: VecDeque<JoinedRow> = VecDeque::new();
    for seen in receiver {
        match seen {
            Seen::Began(..) => {}
            Seen::Row(row) => {
                if rows.len() >= ROWS_WAITING {
                    rows.pop_front();
                }
                rows.push_back(row);
            }
            Seen::Estimate(seen) => {
                let (told, counts) = *seen;
                publish_places(viewer, &told);
                let json = |topic: usize, text: String| viewer.publish(topic, told.t, text.into_bytes());
                json(ESTIMATE, told.line.clone());
                let row = rows.iter().rev().find(|row| row.row.line as u64 <= told.row).or(rows.back());
                if let Some(row) = row {
                    json(WHISKERS, scene.whiskers(&told, &row.row).to_string());
                }
                json(READINGS, scene.readings(rows.iter()).to_string());
                rows.clear();
                json(HEALTH, health(&counts).to_string());
            }
        }
    }
}

/// The best place, and all of them.
fn publish_places(viewer: &Viewer, told: &Told) {
    let header = in_map(told.t);
    let places = if told.estimate.status == Status::Inconsistent { &[] } else { told.estimate.hypotheses.as_slice() };
    if let Some(best) = places.first() {
        let covariance = best.covariance.unwrap_or([[0.0; 3]; 3]);
        viewer.publish(POSE, told.t, encode_pose(header, best.pose, Some(&covariance)));
    }
    let dots = places.iter().flat_map(|place| arrow(&place.pose, TAIL)).map(|p| (p, STATES_HEIGHT, STATES));
    viewer.publish(STATES_TOPIC, told.t, encode_cloud(header, dots));
}
