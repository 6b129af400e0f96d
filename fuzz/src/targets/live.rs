//! Live runs: setups, decoders and the way from bytes to rows, as they come from wires, cut anywhere.

use super::{Verdict, clean, promise, read, refused, size};
use crate::random::Random;
use std::path::PathBuf;
use vibrissa::Robot;
use vibrissa_head::command::{Command, Inbox};
use vibrissa_live::counts::Counts;
use vibrissa_live::decode::{Decoded, Decoder, Piece, WireFormat};
use vibrissa_live::pipeline::Pipeline;
use vibrissa_live::setup::{Setup, from_toml};
use vibrissa_live::source::{Arrived, Chunk};

/// The first byte chooses the format, the second where the stream is cut into pieces.
pub(crate) fn lines(bytes: &[u8]) -> Verdict {
    let (&[choice, cut], rest) = bytes.split_first_chunk().unwrap_or((&[0, 0], &[]));
    let format = WireFormat::ALL[usize::from(choice) % WireFormat::ALL.len()];
    let whisker = if format == WireFormat::Serial2 { "left,right" } else { "left" };
    let made =
        Decoder::new(format, None, whisker).or_else(|_| Decoder::new(format, Some(&["moment".to_owned()]), whisker));
    let mut decoder = made.map_err(|error| format!("{}: no decoder ({error})", format.as_str()))?;
    let (mut splitter, mut counts) = (format.splitter(cut % 2 == 1), Counts::default());
    let (mut frames, mut lost, mut longest) = (0, 0, 0);
    let mut fault = None;
    for piece in rest.chunks(usize::from(cut) + 1) {
        splitter.push(piece, |found| {
            let (length, decoded) = match &found {
                Piece::Line(text) => (text.len(), decoder.line(text, &mut counts)),
                Piece::Packet(bytes) => (bytes.len(), decoder.packet(bytes, &mut counts)),
                Piece::Noise | Piece::Torn => (0, Decoded::Lost),
            };
            longest = longest.max(length);
            let Decoded::Frame(frame) = decoded else { return lost += 1 };
            frames += 1;
            let finite = frame.readings.iter().chain(&frame.stamp).all(|value| value.is_finite());
            let whole = frame.readings.len() == decoder.channels().len();
            if !finite || !(whole || format == WireFormat::Head && frame.readings.is_empty()) {
                fault.get_or_insert(format!("{}: a frame with gaps of {found:?}", format.as_str()));
            }
        });
    }
    promise(fault.is_none(), || fault.unwrap_or_default())?;
    promise(longest <= 4096, || format!("a line of {longest} bytes was put together"))?;
    read((format.as_str(), frames.min(20), lost.min(20), decoder.channels().len(), decoder.has_pose()))
}

/// Keys and words of setups.
pub(crate) const SETUP_WORDS: &[&str] = &[
    "[[source]]",
    "map = ",
    "robot = ",
    "method = ",
    "estimates = ",
    "name = ",
    "serial = ",
    "tcp = ",
    "udp = ",
    "unix = ",
    "pipe = ",
    "baud = ",
    "format = ",
    "columns = ",
    "whisker = ",
    "rate = ",
    "time = ",
    "delay = ",
    "checksums = true",
    "\"serial2\"",
    "\"plotter\"",
    "\"openwhisker\"",
    "\"ratatouille\"",
    "\"tum\"",
    "\"count\"",
    "\"arrival\"",
    "\"own\"",
    "seq16",
    "t_us",
    "---\n",
    "@0\n",
    "@1\n",
];

/// A `live.toml`.
pub(crate) fn setup(bytes: &[u8]) -> Verdict {
    match from_toml(&String::from_utf8_lossy(bytes), "live.toml") {
        Ok(setup) => read((setup.method.name(), size(setup.sources.len()), setup.robot.is_some())),
        Err(error) => refused(&error),
    }
}

/// Most rows of an input: each takes a byte at least.
const MOST_ROWS: usize = 1 << 16;
/// Time between two pieces of a stream (s).
const BETWEEN: f64 = 0.01;

/// A setup, a line `---`, and what comes: a line `@N` says that what follows is of source N, up to the next such line.
pub(crate) fn pipeline(bytes: &[u8]) -> Verdict {
    let text = String::from_utf8_lossy(bytes);
    let (head, body) = text.split_once("---\n").unwrap_or((&text, ""));
    let setup = match from_toml(head, "live.toml") {
        Ok(setup) => setup,
        Err(error) => return refused(&error),
    };
    let mut pipeline = match Pipeline::new(&setup, &Robot::default()) {
        Ok(pipeline) => pipeline,
        Err(error) => return refused(&error),
    };
    let mut rows = Vec::new();
    let mut notices = 0;
    for chunk in chunks(&setup, body) {
        let pushed = pipeline.push(&chunk, &mut |joined| rows.push(joined.row));
        for notice in pipeline.take_notices() {
            notices += 1;
            clean(&notice.text)?;
        }
        if let Err(error) = pushed {
            return refused(&error);
        }
    }
    promise(rows.len() <= MOST_ROWS, || format!("{} rows of {} bytes", rows.len(), bytes.len()))?;
    let whole = rows.iter().all(|row| {
        row.t.is_finite() && row.odom_from_robot.x.is_finite() && row.readings.iter().all(|value| value.is_finite())
    });
    promise(whole, || "a row with gaps".to_owned())?;
    let width = pipeline.channels().map_or(0, <[_]>::len);
    promise(rows.iter().all(|row| row.readings.len() == width), || "a row of another width".to_owned())?;
    read((size(rows.len()), size(notices), width, setup.sources.len().min(4)))
}

/// The pieces of a body, with their sources; some are cut in the middle of a line.
fn chunks(setup: &Setup, body: &str) -> Vec<Chunk> {
    let (mut source, mut arrival, mut all) = (0, 0.0, Vec::new());
    for (index, line) in body.split_inclusive('\n').enumerate() {
        if let Some(number) = line.strip_prefix('@') {
            source = number.trim().parse().unwrap_or(0_usize) % setup.sources.len().max(1);
            continue;
        }
        arrival += BETWEEN;
        let (first, second) = line.as_bytes().split_at(if index % 3 == 0 { line.len() / 2 } else { line.len() });
        for part in [first, second].into_iter().filter(|part| !part.is_empty()) {
            all.push(Chunk { source, arrival, what: Arrived::Bytes(part.to_vec()) });
        }
    }
    all
}

/// Longest packet of a command (bytes).
const PACKET: usize = 1024;

/// Packets of commands to a sensor head, whole or of any bytes.
pub(crate) fn draw_commands(random: &mut Random) -> Vec<u8> {
    let mut bytes = Vec::new();
    for _ in 0..1 + random.below(4) {
        let packet: Vec<u8> = (0..random.below(40)).map(|_| random.bits() as u8).collect();
        // Of any bytes few are a command; what is one is written again as the host does.
        match Command::read(&packet) {
            Ok(command) => {
                let mut out = [0; PACKET];
                bytes.extend(command.write(&mut out).and_then(|length| out.get(..length)).unwrap_or_default());
            }
            Err(_) => bytes.extend(packet),
        }
        bytes.push(0);
    }
    bytes
}

/// What a sensor head reads from its line: a command is the same when it is written and read again.
pub(crate) fn commands(bytes: &[u8]) -> Verdict {
    let (mut inbox, mut done, mut damaged) = (Inbox::default(), 0, 0);
    for &byte in bytes {
        match inbox.push(byte) {
            None => {}
            Some(Err(_)) => damaged += 1,
            Some(Ok(command)) => {
                done += 1;
                let mut out = [0; PACKET];
                let length = command.write(&mut out).unwrap_or_default();
                promise(length > 1, || format!("{command:?} cannot be written"))?;
                // Bits that are no number are written as they are, but are not equal.
                let again = Command::read(&out[..length - 1]).map(|command| format!("{command:?}"));
                let same = again.as_ref().is_ok_and(|again| *again == format!("{command:?}"));
                promise(same, || format!("{command:?} is read back as {again:?}"))?;
            }
        }
    }
    read((size(done), size(damaged)))
}

/// A recording of a live run, as a replay reads it.
pub(crate) fn journal(bytes: &[u8]) -> Verdict {
    let path = scratch();
    std::fs::write(&path, bytes).map_err(|error| format!("cannot write {} ({error})", path.display()))?;
    let recorded = match vibrissa_live::journal::read(&path) {
        Ok(recorded) => recorded,
        Err(error) => return refused(&error),
    };
    recorded.warnings.iter().try_for_each(|warning| clean(warning))?;
    let (mut chunks, mut total, mut fault) = (0_u64, 0, false);
    let told = vibrissa_live::journal::chunks(&recorded, |chunk| {
        chunks += 1;
        fault |= !chunk.arrival.is_finite() || chunk.source >= recorded.setup.sources.len();
        if let Arrived::Bytes(bytes) = chunk.what {
            total += bytes.len();
        }
        Ok(())
    });
    if let Err(error) = told {
        return refused(&error);
    }
    promise(!fault, || "a piece of no source or time".into())?;
    read((
        size(chunks as usize),
        size(total),
        size(recorded.used.len()),
        size(recorded.lines.len()),
        recorded.warnings.len(),
    ))
}

/// A file of this process for what is read by its path.
fn scratch() -> PathBuf {
    std::env::temp_dir().join(format!("vibrissa-fuzz-{}.mcap", std::process::id()))
}
