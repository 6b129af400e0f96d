//! The container, written.

use super::definition::Kind;
use super::message::Stamp;
use crate::{Error, Result};
use mcap::records::MessageHeader;
use mcap::{McapError, WriteOptions, Writer};
use std::collections::BTreeMap;
use std::io::Cursor;

/// A topic of a recording that is being written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TopicId(usize);

/// Collects messages and makes an MCAP recording of them, in order of time.
#[derive(Clone, Debug, Default)]
pub struct BagWriter {
    topics: Vec<(String, Kind, bool)>,
    messages: Vec<(Stamp, TopicId, Vec<u8>)>,
}

/// What ROS 2 tells late subscribers of: the last message of a topic that is said once.
const LATCHED: &str = "- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n  deadline:\n    sec: 9223372036\n    \
                       nsec: 854775807\n  lifespan:\n    sec: 9223372036\n    nsec: 854775807\n  liveliness: 1\n  \
                       liveliness_lease_duration:\n    sec: 9223372036\n    nsec: 854775807\n  \
                       avoid_ros_namespace_conventions: false";

impl BagWriter {
    /// Adds a topic; `latched` ones are said once and hold until they are said again.
    pub fn topic(&mut self, name: impl Into<String>, kind: Kind, latched: bool) -> TopicId {
        self.topics.push((name.into(), kind, latched));
        TopicId(self.topics.len() - 1)
    }

    /// Adds a message.
    pub fn push(&mut self, topic: TopicId, stamp: Stamp, message: Vec<u8>) {
        self.messages.push((stamp, topic, message));
    }

    /// The bytes of the file: indexed, in chunks, not compressed; the same messages give the same bytes.
    ///
    /// # Errors
    ///
    /// More topics than a recording holds.
    pub fn finish(mut self) -> Result<Vec<u8>> {
        self.messages.sort_by_key(|(stamp, ..)| *stamp);
        self.write()
            .map_err(|e| Error::data("cannot make an MCAP recording").value(e).remedy("leave out some whiskers"))
    }

    fn write(&self) -> core::result::Result<Vec<u8>, McapError> {
        let mut bytes = Cursor::new(Vec::new());
        let options = WriteOptions::new().profile("ros2").library("vibrissa").compression(None);
        let mut writer = Writer::with_options(&mut bytes, options)?;
        let mut channels = Vec::new();
        for (name, kind, latched) in &self.topics {
            let schema = writer.add_schema(kind.name(), "ros2msg", kind.definition().as_bytes())?;
            let qos = if *latched { LATCHED } else { "" };
            let metadata = BTreeMap::from([("offered_qos_profiles".to_owned(), qos.to_owned())]);
            channels.push((writer.add_channel(schema, name, "cdr", &metadata)?, 0));
        }
        for (stamp, topic, message) in &self.messages {
            let (channel_id, sequence) = &mut channels[topic.0];
            let time = stamp.nanoseconds();
            let header =
                MessageHeader { channel_id: *channel_id, sequence: *sequence, log_time: time, publish_time: time };
            *sequence += 1;
            writer.write_to_known_channel(&header, message)?;
        }
        writer.finish()?;
        drop(writer);
        Ok(bytes.into_inner())
    }
}
