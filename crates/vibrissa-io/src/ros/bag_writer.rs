//! The container, written.

use super::container::{Container, NewTopic};
use super::definition::Kind;
use super::message::Stamp;
use crate::{Error, Result};

/// A topic of a recording that is being written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TopicId(usize);

/// Collects messages and makes an MCAP recording of them, in order of time.
#[derive(Clone, Debug, Default)]
pub struct BagWriter {
    topics: Vec<NewTopic>,
    messages: Vec<(Stamp, TopicId, Vec<u8>)>,
}

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
        if self.topics.len() > usize::from(u16::MAX) {
            return Err(Error::data("cannot make an MCAP recording")
                .value(format!("{} topics", self.topics.len()))
                .allowed(format!("up to {}", u16::MAX))
                .remedy("leave out some whiskers"));
        }
        Ok(self.write())
    }

    fn write(&self) -> Vec<u8> {
        let mut file = Container::begin();
        let channels: Vec<u16> = self.topics.iter().map(|topic| file.channel(topic)).collect();
        let mut sequences = vec![0; channels.len()];
        for (stamp, topic, message) in &self.messages {
            file.message(channels[topic.0], sequences[topic.0], stamp.nanoseconds(), message);
            sequences[topic.0] += 1;
        }
        file.finish()
    }
}
