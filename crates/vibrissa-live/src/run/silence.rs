//! Sources that are open and send nothing: a word about each, and again once it has sent something.

use crate::source::{Arrived, Chunk};

/// A source that has sent nothing for so long (s) is told of: a robot's odometry and its whiskers send many times a second.
const SILENT: f64 = 3.0;
/// A chunk that is older (s) has waited: so may others behind it.
const FRESH: f64 = 1.0;

/// What is known of one source.
#[derive(Clone, Copy, Debug)]
struct Source {
    /// Since when it has sent nothing (host, s).
    since: f64,
    has_sent: bool,
    /// Whether nothing is expected of it, since it is gone, has ended, or was told of.
    is_known: bool,
}

/// When each source was heard last.
#[derive(Clone, Debug)]
pub(super) struct Silence {
    sources: Vec<Source>,
    /// Whether chunks wait to be taken, so that nobody knows who is silent.
    is_behind: bool,
}

impl Silence {
    /// So many sources from `now` (host, s) on.
    pub(super) fn new(sources: usize, now: f64) -> Self {
        Self { sources: vec![Source { since: now, has_sent: false, is_known: false }; sources], is_behind: false }
    }

    /// Something came of a source, or happened to it, and is taken at `now` (host, s).
    pub(super) fn heard(&mut self, chunk: &Chunk, now: f64) {
        self.is_behind = now > chunk.arrival + FRESH;
        let source = &mut self.sources[chunk.source];
        source.since = chunk.arrival;
        source.is_known = matches!(chunk.what, Arrived::Gone(_) | Arrived::Ended);
        source.has_sent |= matches!(chunk.what, Arrived::Bytes(_));
    }

    /// All chunks have been taken.
    pub(super) fn all_heard(&mut self) {
        self.is_behind = false;
    }

    /// The sources that have been silent for too long at `now` (host, s), with a word about each.
    pub(super) fn words(&mut self, now: f64) -> Vec<(usize, String)> {
        let mut words = Vec::new();
        for (index, source) in self.sources.iter_mut().enumerate() {
            if self.is_behind || source.is_known || now < source.since + SILENT {
                continue;
            }
            source.is_known = true;
            words.push((
                index,
                match source.has_sent {
                    false => "no bytes yet: is the device switched on, and the cable in?".to_owned(),
                    true => format!("nothing has come for {SILENT} s: has the device stopped?"),
                },
            ));
        }
        words
    }
}

#[cfg(test)]
mod tests {
    use super::Silence;
    use crate::source::{Arrived, Chunk};

    #[test]
    fn a_source_that_falls_silent_is_told_of_each_time_but_not_one_that_is_gone() {
        let mut silence = Silence::new(2, 10.0);
        let heard =
            |silence: &mut Silence, source, arrival, what| silence.heard(&Chunk { source, arrival, what }, arrival);
        let bytes = || Arrived::Bytes(vec![b'1']);
        assert!(silence.words(12.9).is_empty());
        heard(&mut silence, 0, 12.5, bytes());
        let said = silence.words(13.1);
        assert!(said.len() == 1 && said[0].0 == 1 && said[0].1.starts_with("no bytes yet"), "{said:?}");
        assert!(silence.words(13.2).is_empty());
        let said = silence.words(16.0);
        assert!(said.len() == 1 && said[0].0 == 0 && said[0].1.starts_with("nothing has come for 3 s"), "{said:?}");
        for arrival in [17.0, 21.0] {
            heard(&mut silence, 0, arrival, bytes());
            assert!(silence.words(arrival + 2.0).is_empty());
            assert_eq!(silence.words(arrival + 3.5).len(), 1);
        }
        heard(&mut silence, 0, 30.0, bytes());
        heard(&mut silence, 0, 30.1, Arrived::Gone("unplugged".to_owned()));
        assert!(silence.words(60.0).is_empty());
        heard(&mut silence, 0, 60.0, Arrived::Opened);
        assert_eq!(silence.words(64.0).len(), 1);
        heard(&mut silence, 0, 65.0, Arrived::Ended);
        assert!(silence.words(100.0).is_empty());
    }

    #[test]
    fn nobody_is_silent_while_chunks_wait() {
        let mut silence = Silence::new(2, 0.0);
        silence.heard(&Chunk { source: 0, arrival: 5.0, what: Arrived::Bytes(vec![b'1']) }, 9.0);
        assert!(silence.words(9.0).is_empty());
        silence.all_heard();
        assert_eq!(silence.words(9.0).len(), 2);
    }
}
