//! A socket that viewers open while the robot drives: the WebSocket protocol of Foxglove (`foxglove.sdk.v1`, and the older
//! `foxglove.websocket.v1`, which begins alike).
//!
//! The server says what it is and which topics there are; a viewer subscribes; each message goes out as the byte 1, the
//! subscription's number (u32), the time (ns, u64), little-endian, and the message. A viewer that is too slow misses messages, and
//! nobody waits for it.

use crate::{Error, Result};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tungstenite::handshake::server::{ErrorResponse, Request, Response};
use tungstenite::http::{HeaderValue, StatusCode};
use tungstenite::{Message, WebSocket};
use vibrissa_io::ros::Kind;

/// The protocols, the newer one first.
const PROTOCOLS: [&str; 2] = ["foxglove.sdk.v1", "foxglove.websocket.v1"];
/// Messages that wait for one viewer; with more it misses some.
const BACKLOG: usize = 256;
/// Viewers at once.
const MOST_VIEWERS: usize = 16;
/// How long a viewer is listened to before messages go out again.
const TURN: Duration = Duration::from_millis(5);
/// How long a viewer may take for the greeting, and for a message.
const PATIENCE: Duration = Duration::from_secs(2);
/// The byte in front of a message of data.
const DATA: u8 = 1;

/// What a topic's messages are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// A ROS 2 message.
    Ros(Kind),
    /// A line of JSON.
    Json,
}

/// A topic for viewers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ViewTopic {
    /// Its name.
    pub name: String,
    /// What its messages are.
    pub encoding: Encoding,
    /// Whether the last message is said again to those who come later.
    pub latched: bool,
}

/// One message on its way to a viewer: topic, time (ns), bytes.
type Outgoing = (usize, u64, Arc<Vec<u8>>);

#[derive(Debug)]
struct Shared {
    topics: Vec<ViewTopic>,
    /// The last message of each latched topic.
    latched: Mutex<BTreeMap<usize, Outgoing>>,
    viewers: Mutex<Vec<SyncSender<Outgoing>>>,
    missed: AtomicU64,
    stop: AtomicBool,
}

/// The server. It ends when it is dropped.
#[derive(Debug)]
pub struct Viewer {
    shared: Arc<Shared>,
    address: SocketAddr,
}

impl Viewer {
    /// Listens at an address such as `127.0.0.1:8765`; port 0 is any that is free.
    ///
    /// # Errors
    ///
    /// An address that is in use.
    pub fn start(address: &str, topics: Vec<ViewTopic>) -> Result<Self> {
        let fault = |error: std::io::Error| {
            Error::data(format!("cannot listen for viewers ({error})"))
                .value(address)
                .remedy("choose another port: --view 8766")
        };
        let listener = TcpListener::bind(address).map_err(fault)?;
        let address = listener.local_addr().map_err(fault)?;
        listener.set_nonblocking(true).map_err(fault)?;
        let shared = Arc::new(Shared {
            topics,
            latched: Mutex::default(),
            viewers: Mutex::default(),
            missed: AtomicU64::new(0),
            stop: AtomicBool::new(false),
        });
        let theirs = Arc::clone(&shared);
        std::thread::spawn(move || accept(&listener, &theirs));
        Ok(Self { shared, address })
    }

    /// Where it listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Sends a message of a topic (its index), of the time `t` (s), to every viewer that wants it. It never waits.
    pub fn publish(&self, topic: usize, t: f64, message: Vec<u8>) {
        let time = vibrissa_io::ros::Stamp::from_seconds(t).nanoseconds();
        let outgoing = (topic, time, Arc::new(message));
        if self.shared.topics[topic].latched {
            let mut latched = self.shared.latched.lock().unwrap_or_else(PoisonError::into_inner);
            latched.insert(topic, outgoing.clone());
        }
        let mut viewers = self.shared.viewers.lock().unwrap_or_else(PoisonError::into_inner);
        viewers.retain(|viewer| match viewer.try_send(outgoing.clone()) {
            Ok(()) => true,
            Err(TrySendError::Full(_)) => {
                self.shared.missed.fetch_add(1, Ordering::Relaxed);
                true
            }
            Err(TrySendError::Disconnected(_)) => false,
        });
    }

    /// How many viewers there are.
    #[must_use]
    pub fn viewers(&self) -> usize {
        self.shared.viewers.lock().unwrap_or_else(PoisonError::into_inner).len()
    }

    /// Messages that viewers missed because they were too slow.
    #[must_use]
    pub fn missed(&self) -> u64 {
        self.shared.missed.load(Ordering::Relaxed)
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
    }
}

fn accept(listener: &TcpListener, shared: &Arc<Shared>) {
    while !shared.stop.load(Ordering::Relaxed) {
        let Ok((stream, _)) = listener.accept() else {
            std::thread::sleep(Duration::from_millis(20));
            continue;
        };
        let shared = Arc::clone(shared);
        std::thread::spawn(move || {
            // Whoever does not speak the protocol is hung up on.
            let _ = serve(stream, &shared);
        });
    }
}

/// Speaks with one viewer until it leaves.
fn serve(stream: TcpStream, shared: &Shared) -> tungstenite::Result<()> {
    stream.set_nonblocking(false)?;
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    #[allow(clippy::result_large_err, reason = "the type is the library's")]
    let greet = |request: &Request, mut response: Response| -> core::result::Result<Response, ErrorResponse> {
        let asked = request.headers().get_all("Sec-WebSocket-Protocol").iter().filter_map(|value| value.to_str().ok());
        let asked: Vec<&str> = asked.flat_map(|value| value.split(',')).map(str::trim).collect();
        match PROTOCOLS.into_iter().find(|protocol| asked.contains(protocol)) {
            Some(protocol) => {
                response.headers_mut().insert("Sec-WebSocket-Protocol", HeaderValue::from_static(protocol));
                Ok(response)
            }
            None => {
                let mut refusal =
                    ErrorResponse::new(Some("this socket is for Foxglove and viewers like it".to_owned()));
                *refusal.status_mut() = StatusCode::BAD_REQUEST;
                Err(refusal)
            }
        }
    };
    let Ok(mut socket) = tungstenite::accept_hdr(stream, greet) else { return Ok(()) };
    socket.get_ref().set_read_timeout(Some(TURN))?;
    socket.send(Message::text(server_info().to_string()))?;
    socket.send(Message::text(advertisement(&shared.topics).to_string()))?;
    let (sender, inbox) = sync_channel(BACKLOG);
    {
        let mut viewers = shared.viewers.lock().unwrap_or_else(PoisonError::into_inner);
        if viewers.len() >= MOST_VIEWERS {
            return socket.close(None);
        }
        viewers.push(sender);
    }
    converse(&mut socket, shared, &inbox)
}

fn converse(socket: &mut WebSocket<TcpStream>, shared: &Shared, inbox: &Receiver<Outgoing>) -> tungstenite::Result<()> {
    // By topic the number of the viewer's subscription.
    let mut subscribed: BTreeMap<usize, u32> = BTreeMap::new();
    while !shared.stop.load(Ordering::Relaxed) {
        for message in inbox.try_iter() {
            if let Some(&subscription) = subscribed.get(&message.0) {
                socket.send(data(subscription, &message))?;
            }
        }
        let text = match socket.read() {
            Ok(Message::Text(text)) => text,
            Ok(Message::Close(_)) => return Ok(()),
            Ok(_) => continue,
            Err(tungstenite::Error::Io(error))
                if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) =>
            {
                continue;
            }
            Err(error) => return Err(error),
        };
        for (topic, subscription) in asked(&text, &mut subscribed) {
            let latched = shared.latched.lock().unwrap_or_else(PoisonError::into_inner).get(&topic).cloned();
            if let Some(message) = latched {
                socket.send(data(subscription, &message))?;
            }
        }
    }
    socket.close(None)
}

/// Heeds what a viewer says; its new subscriptions.
fn asked(text: &str, subscribed: &mut BTreeMap<usize, u32>) -> Vec<(usize, u32)> {
    let Ok(value) = serde_json::from_str::<Value>(text) else { return Vec::new() };
    let number = |value: &Value| value.as_u64().and_then(|number| u32::try_from(number).ok());
    let list = |key: &str| value[key].as_array().cloned().unwrap_or_default();
    match value["op"].as_str() {
        Some("subscribe") => {
            let new: Vec<(usize, u32)> = list("subscriptions")
                .iter()
                .filter_map(|one| Some(((number(&one["channelId"])?).checked_sub(1)? as usize, number(&one["id"])?)))
                .collect();
            subscribed.extend(new.iter().copied());
            new
        }
        Some("unsubscribe") => {
            let gone: Vec<u32> = list("subscriptionIds").iter().filter_map(number).collect();
            subscribed.retain(|_, subscription| !gone.contains(subscription));
            Vec::new()
        }
        _ => Vec::new(),
    }
}

fn data(subscription: u32, (_, time, message): &Outgoing) -> Message {
    let mut bytes = vec![DATA];
    bytes.extend(subscription.to_le_bytes());
    bytes.extend(time.to_le_bytes());
    bytes.extend(message.as_slice());
    Message::binary(bytes)
}

fn server_info() -> Value {
    json!({
        "op": "serverInfo", "name": concat!("vibrissa ", env!("CARGO_PKG_VERSION")), "capabilities": [],
        "supportedEncodings": [], "metadata": {},
    })
}

/// What topics there are; their numbers count from 1.
fn advertisement(topics: &[ViewTopic]) -> Value {
    let channel = |(index, topic): (usize, &ViewTopic)| match topic.encoding {
        Encoding::Ros(kind) => json!({
            "id": index + 1, "topic": topic.name, "encoding": "cdr", "schemaName": kind.name(), "schema": kind.definition(),
            "schemaEncoding": "ros2msg",
        }),
        Encoding::Json => json!({
            "id": index + 1, "topic": topic.name, "encoding": "json", "schemaName": "vibrissa", "schemaEncoding": "jsonschema",
            "schema": "{\"type\":\"object\"}",
        }),
    };
    json!({ "op": "advertise", "channels": topics.iter().enumerate().map(channel).collect::<Vec<_>>() })
}
