//! From bytes to rows: the same chunks give the same rows, whatever the machine's load.

use crate::counts::Counts;
use crate::decode::{Decoded, Decoder, Frame, LineSplitter, Piece};
use crate::doubts::Doubts;
use crate::join::{JoinedRow, Joiner, Share};
use crate::setup::{Setup, SourceSetup};
use crate::source::{Arrived, Chunk};
use crate::timing::{TimeBase, Timing};
use crate::{Error, Result};
use vibrissa_core::flow::sensor_log::Channel;
use vibrissa_core::world::Robot;
use vibrissa_io::Calibrator;

/// A word about a source, said when it happens.
#[derive(Clone, Debug, PartialEq)]
pub struct Notice {
    /// When (host, s).
    pub t: f64,
    /// The source's name.
    pub source: String,
    /// What happened and what to do, for people.
    pub text: String,
}

/// One source on its way to the join.
#[derive(Clone, Debug)]
struct Stream {
    setup: SourceSetup,
    splitter: LineSplitter,
    decoder: Decoder,
    timing: Timing,
    counts: Counts,
    doubts: Doubts,
    resets: u64,
}

/// Whether a frame holds all that a row takes from it: a device may send a number and a time alone.
fn is_joined(decoder: &Decoder, frame: &Frame) -> bool {
    frame.readings.len() == decoder.channels().len()
}

/// Chunks of bytes to rows.
#[derive(Clone, Debug)]
pub struct Pipeline {
    streams: Vec<Stream>,
    robot: Robot,
    /// What is known once every stream has said what it holds.
    joined: Option<(Joiner, Vec<Channel>, Option<Calibrator>)>,
    first: usize,
    now: f64,
    notices: Vec<Notice>,
}

impl Pipeline {
    /// A pipeline of a setup's sources for a robot.
    ///
    /// # Errors
    ///
    /// Sources that cannot be joined, a calibration that cannot be read.
    pub fn new(setup: &Setup, robot: &Robot) -> Result<Self> {
        let stream = |source: &SourceSetup| -> Result<Stream> {
            Ok(Stream {
                splitter: source.format.splitter(source.wire.may_be_torn()),
                decoder: source.decoder()?,
                timing: Timing::new(source.time, source.delay),
                setup: source.clone(),
                counts: Counts::default(),
                doubts: Doubts::default(),
                resets: 0,
            })
        };
        let mut pipeline = Self {
            streams: setup.sources.iter().map(stream).collect::<Result<_>>()?,
            robot: robot.clone(),
            joined: None,
            first: 0,
            now: f64::NEG_INFINITY,
            notices: Vec::new(),
        };
        pipeline.begin()?;
        Ok(pipeline)
    }

    /// The channels of the rows, once every stream has said what it holds.
    #[must_use]
    pub fn channels(&self) -> Option<&[Channel]> {
        self.joined.as_ref().map(|(_, channels, _)| channels.as_slice())
    }

    /// The robot with the bounds of its calibrations.
    #[must_use]
    pub fn robot(&self) -> Robot {
        match &self.joined {
            Some((_, _, Some(calibrator))) => calibrator.robot(&self.robot),
            _ => self.robot.clone(),
        }
    }

    /// The counts of each source, with its name.
    pub fn counts(&self) -> impl Iterator<Item = (&str, &Counts)> {
        self.streams.iter().map(|stream| (stream.setup.name.as_str(), &stream.counts))
    }

    /// What happened since the last call.
    pub fn take_notices(&mut self) -> Vec<Notice> {
        core::mem::take(&mut self.notices)
    }

    /// Takes a chunk and calls `told` with each row that is complete.
    ///
    /// # Errors
    ///
    /// Header lines that leave the odometry or the readings out, or a robot whose whiskers are not among them.
    pub fn push(&mut self, chunk: &Chunk, told: &mut dyn FnMut(JoinedRow)) -> Result<()> {
        self.now = self.now.max(chunk.arrival);
        match &chunk.what {
            Arrived::Opened => self.say(chunk.source, "open".to_owned()),
            Arrived::Bytes(bytes) => self.bytes(chunk.source, bytes, chunk.arrival)?,
            Arrived::Gone(reason) => {
                self.streams[chunk.source].counts.gone += 1;
                self.break_off(chunk.source);
                self.say(chunk.source, reason.clone());
            }
            Arrived::Ended => {
                self.break_off(chunk.source);
                self.say(chunk.source, "ended".to_owned());
            }
        }
        self.rows(self.now, told);
        Ok(())
    }

    /// Ends the run: rows that still wait are told or given up.
    pub fn finish(&mut self, told: &mut dyn FnMut(JoinedRow)) {
        for source in 0..self.streams.len() {
            self.break_off(source);
        }
        self.rows(f64::INFINITY, told);
    }

    fn say(&mut self, source: usize, text: String) {
        let source = self.streams[source].setup.name.clone();
        self.notices.push(Notice { t: self.now, source, text });
    }

    fn break_off(&mut self, source: usize) {
        let Self { streams, joined, now, .. } = self;
        let stream = &mut streams[source];
        stream.counts.torn += u64::from(stream.splitter.break_off(stream.setup.wire.may_be_torn()));
        stream.timing.flush(&mut |t, frame| {
            if let Some((joiner, ..)) = joined.as_mut().filter(|_| is_joined(&stream.decoder, &frame)) {
                joiner.push(source, t, *now, frame);
            }
        });
        stream.timing.break_off();
        stream.doubts.break_off(&stream.counts);
    }

    fn bytes(&mut self, source: usize, bytes: &[u8], arrival: f64) -> Result<()> {
        let mut pieces = Vec::new();
        let stream = &mut self.streams[source];
        stream.counts.bytes += bytes.len() as u64;
        stream.splitter.push(bytes, |piece| pieces.push(piece));
        for piece in pieces {
            self.piece(source, &piece, arrival)?;
        }
        self.doubts(source);
        Ok(())
    }

    fn piece(&mut self, source: usize, piece: &Piece, arrival: f64) -> Result<()> {
        let Self { streams, joined, .. } = self;
        let stream = &mut streams[source];
        let Stream { decoder, timing, counts, doubts, .. } = stream;
        counts.lines += 1;
        let was_ready = decoder.is_ready();
        let decoded = match piece {
            Piece::Line(text) => decoder.line(text, counts),
            Piece::Packet(bytes) => decoder.packet(bytes, counts),
            Piece::Noise => Decoded::Lost,
            Piece::Torn => {
                counts.torn += 1;
                timing.lost_slot();
                return Ok(());
            }
        };
        match decoded {
            Decoded::Frame(frame) => {
                counts.frames += 1;
                let silent = !frame.readings.is_empty() && frame.readings.iter().all(|value| *value == 0.0);
                doubts.frame(silent);
                counts.zeros += u64::from(silent);
                timing.push(frame, arrival, counts, &mut |t, frame| {
                    // Before every stream has said what it holds there is nothing to join it with.
                    if let Some((joiner, ..)) = joined.as_mut().filter(|_| is_joined(decoder, &frame)) {
                        joiner.push(source, t, arrival, frame);
                    }
                });
            }
            Decoded::Lost => {
                counts.damaged += 1;
                timing.lost_slot();
            }
            Decoded::Nothing => {}
        }
        if !was_ready && stream.decoder.is_ready() {
            self.begin()?;
        }
        Ok(())
    }

    /// Begins to join, once every stream has said what it holds.
    fn begin(&mut self) -> Result<()> {
        for stream in &mut self.streams {
            stream.timing.set_wraps(stream.decoder.stamp_wraps(), stream.decoder.number_wraps());
        }
        if !self.streams.iter().all(|stream| stream.decoder.is_ready()) {
            return Ok(());
        }
        let shares: Vec<Share> = self
            .streams
            .iter()
            .map(|stream| Share { pose: stream.decoder.has_pose(), readings: stream.decoder.channels().len() })
            .collect();
        let with_pose: Vec<usize> = (0..shares.len()).filter(|&i| shares[i].pose).collect();
        let first = shares.iter().position(|share| share.readings > 0);
        let names = |found: &[usize]| -> String {
            found.iter().map(|&i| self.streams[i].setup.name.as_str()).collect::<Vec<_>>().join(", ")
        };
        let ([odometry], Some(first)) = (with_pose.as_slice(), first) else {
            return Err(match with_pose.as_slice() {
                [] => Error::data("no source gives odometry")
                    .remedy("the header lines must name x, y, theta; or add a [[source]] for the robot's odometry"),
                [_] => Error::data("no source gives readings").remedy("add a [[source]] for the whisker"),
                several => Error::data("several sources give odometry")
                    .value(names(several))
                    .remedy("name the columns of one, with \"-\" for its x, y, theta"),
            });
        };
        // The rows' readings: those of the streams in order.
        let channels: Vec<Channel> =
            self.streams.iter().flat_map(|stream| stream.decoder.channels().iter().cloned()).collect();
        if let Some((index, twice)) =
            channels.iter().enumerate().find(|(index, channel)| channels[..*index].contains(channel))
        {
            return Err(Error::data("two sources give the same reading")
                .value(format!("{} (reading {})", twice.column(), index + 1))
                .remedy("say whose it is: whisker = \"NAME\" in the [[source]], NAME as in the robot file"));
        }
        let calibrator = Calibrator::new(&channels, &self.robot)?;
        let channels = calibrator.as_ref().map_or(channels.clone(), |calibrator| calibrator.channels(&channels));
        self.first = first;
        self.joined = Some((Joiner::new(shares, first, *odometry), channels, calibrator));
        Ok(())
    }

    fn rows(&mut self, now: f64, told: &mut dyn FnMut(JoinedRow)) {
        let Some((joiner, _, calibrator)) = &mut self.joined else { return };
        let (mut beyond, mut first_beyond) = (0, None);
        let given_up = joiner.rows(now, &mut |mut joined| {
            let calibrated = calibrator.as_ref().map_or(Ok(()), |calibrator| calibrator.row(&mut joined.row));
            match calibrated {
                Ok(()) => told(joined),
                Err(error) => {
                    beyond += 1;
                    first_beyond.get_or_insert(error);
                }
            }
        });
        let counts = &mut self.streams[self.first].counts;
        let first_time = counts.uncalibrated == 0;
        counts.unjoined += given_up;
        counts.uncalibrated += beyond;
        if let (true, Some(error)) = (first_time, first_beyond) {
            self.say(self.first, error.to_string().replace("\n  help: ", "; "));
        }
    }

    /// Says where a stream does not look like what it was said to be.
    fn doubts(&mut self, source: usize) {
        let stream = &mut self.streams[source];
        let Stream { setup, doubts, counts, timing, resets, .. } = stream;
        let mut words = doubts.words(counts, setup.format.as_str(), setup.wire.also_to_check());
        if counts.resets + timing.clock().resets() > *resets {
            *resets = counts.resets + timing.clock().resets();
            words.push(match setup.time {
                TimeBase::Counted(_) => "nothing came for a while; its readings are counted anew".to_owned(),
                _ => "the device's clock or count jumped; it is followed anew".to_owned(),
            });
        }
        words.into_iter().for_each(|text| self.say(source, text));
    }
}
