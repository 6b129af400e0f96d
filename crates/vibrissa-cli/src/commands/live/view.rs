//! What viewers see of a run. Messages are made on a thread of their own: a run never waits for them.

use super::monitor::plan_json;
use super::planning::Answer;
use crate::commands::studio::page;
use crate::commands::studio::server::Server;
use crate::interrupt::stopped;
use crate::output::warn;
use std::collections::VecDeque;
use std::io::IsTerminal;
use std::process::{Command, Stdio};
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
const PLAN: usize = 7;
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
            text("/vibrissa/plan", true),
        ];
        let viewer = Arc::new(Viewer::start(&format!("127.0.0.1:{port}"), topics)?);
        let page = served_page(viewer.address().port());
        if !quiet {
            warn(&match &page {
                Some(address) => {
                    format!("the run is at {address} in the browser; Foxglove may open ws://{}", viewer.address())
                }
                None => format!(
                    "viewers such as Foxglove may open ws://{}; for our own page run `studio/build` in the repository once",
                    viewer.address()
                ),
            });
        }
        // A person at this machine sees it at once.
        if let Some(address) = page.filter(|_| !quiet && std::io::stderr().is_terminal()) {
            open_in_browser(&address);
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

    /// Shows the next motion.
    pub(super) fn plan(&self, answer: &Answer) {
        if let Some(plan) = &answer.plan {
            self.viewer.publish(PLAN, answer.t, plan_json(answer.t, plan).into_bytes());
        }
    }
}

/// The address of the page that shows the run, served until the process ends; none where it is not built, or cannot be served.
fn served_page(port: u16) -> Option<String> {
    let page = page::read(None).ok()?;
    let server = Server::start(0).ok()?;
    let address = format!("{}#live?port={port}", server.address());
    std::thread::spawn(move || server.serve(&page, &stopped));
    Some(address)
}

/// Opens an address where there is a desktop.
fn open_in_browser(address: &str) {
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    let program = match std::env::consts::OS {
        "macos" => "open",
        "windows" => "explorer",
        _ if is_set("DISPLAY") || is_set("WAYLAND_DISPLAY") => "xdg-open",
        _ => return,
    };
    let mut command = Command::new(program);
    command.arg(address).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    // Who has no browser reads the address in the terminal.
    if let Ok(mut child) = command.spawn() {
        std::thread::spawn(move || child.wait());
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
