//! Streams that are torn, thinned, garbled and repeated at random: no frame is invented, and what is missing is told.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::float_cmp,
    reason = "a test that cannot go on must fail"
)]

mod common;

use common::{Dice, checked};
use std::collections::BTreeMap;
use vibrissa_live::counts::Counts;
use vibrissa_live::decode::{Decoded, Decoder, LineSplitter, Piece, WireFormat};
use vibrissa_live::timing::{TimeBase, Timing};

const CUTS: usize = 10_000;
const LINES: usize = 60;

fn columns() -> Vec<String> {
    ["seq16", "t_us", "-", "moment"].map(str::to_owned).to_vec()
}

/// What was sent, and what a broken line may do to it.
struct Sent {
    bytes: Vec<u8>,
    /// Readings by number and stamp.
    frames: BTreeMap<(u64, u64), f64>,
    first: u64,
}

fn sent(dice: &mut Dice) -> Sent {
    // Numbers and stamps run over their ends in the middle of the stream.
    let (first, start) = (65_536 - 30 - dice.next() % 20, 4_294_967_296 - 100_000 + dice.next() % 50_000);
    let (mut bytes, mut frames) = (Vec::new(), BTreeMap::new());
    for i in 0..LINES as u64 {
        let (number, stamp) = ((first + i) % 65_536, (start + 3333 * i) % 4_294_967_296);
        let reading = (dice.next() % 100_000) as f64 * 1e-7;
        frames.insert((number, stamp), reading);
        bytes.extend(checked(&format!("{number},{stamp},{},{reading}", dice.next() % 10)).into_bytes());
    }
    Sent { bytes, frames, first }
}

/// Cuts pieces out, repeats some, and puts noise in between.
fn broken(bytes: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut out = bytes[dice.below(40)..].to_vec();
    for _ in 0..=dice.below(4) {
        let at = dice.below(out.len());
        let end = (at + 1 + dice.below(80)).min(out.len());
        match dice.below(4) {
            0 => drop(out.drain(at..end)),
            1 => {
                let again = out[at..end].to_vec();
                out.splice(at..at, again);
            }
            2 => {
                let noise: Vec<u8> = (0..dice.below(50)).map(|_| (dice.next() >> 32) as u8).collect();
                out.splice(at..at, noise);
            }
            _ => out[at] ^= 1 << dice.below(8),
        }
    }
    out.truncate(out.len() - dice.below(20).min(out.len()));
    out
}

#[test]
fn ten_thousand_cuts_invent_no_frame_and_hide_none() {
    let mut dice = Dice::new(27);
    let (mut read, mut missing) = (0, 0);
    for cut in 0..CUTS {
        let sent = sent(&mut dice);
        let bytes = broken(&sent.bytes, &mut dice);
        let mut splitter = LineSplitter::new(true);
        let mut decoder = Decoder::new(WireFormat::Csv, Some(&columns()), "").unwrap().with_checksums();
        let mut timing = Timing::new(TimeBase::Own, 0.0);
        timing.set_wraps(decoder.stamp_wraps(), decoder.number_wraps());
        let mut counts = Counts::default();
        let (mut seen, mut last) = (Vec::new(), f64::NEG_INFINITY);
        let mut rest = bytes.as_slice();
        while !rest.is_empty() {
            let (piece, later) = rest.split_at((1 + dice.below(70)).min(rest.len()));
            rest = later;
            let mut lines = Vec::new();
            splitter.push(piece, |piece| lines.push(piece));
            for line in lines {
                let Piece::Line(text) = line else { continue };
                let Decoded::Frame(frame) = decoder.line(&text, &mut counts) else { continue };
                let key = (frame.number.unwrap(), (frame.stamp.unwrap() * 1e6).round() as u64);
                assert_eq!(sent.frames.get(&key), Some(&frame.readings[0]), "cut {cut} invents {text}");
                timing.push(frame, 0.0, &mut counts, &mut |t, frame| {
                    assert!(t > last, "cut {cut}: time goes back");
                    last = t;
                    seen.push(frame.number.unwrap());
                });
            }
        }
        // Between the first and the last frame everything is accounted for.
        let place = |number: u64| (number + 65_536 - sent.first) % 65_536;
        if let (Some(first), Some(end)) = (seen.first(), seen.last()) {
            let between = place(*end) - place(*first) + 1;
            assert_eq!(seen.len() as u64 + counts.lost + counts.late, between, "cut {cut}: {counts:?}");
            assert!(seen.windows(2).all(|w| place(w[1]) > place(w[0])), "cut {cut}: a frame came twice");
        }
        read += seen.len();
        missing += counts.lost + counts.late;
    }
    assert!(read > CUTS * LINES / 2 && missing > 0, "{read} read, {missing} missing");
}

#[test]
fn no_bytes_make_any_format_fall_over() {
    let mut dice = Dice::new(3);
    let formats: Vec<(WireFormat, Option<Vec<String>>, &str)> = WireFormat::ALL
        .into_iter()
        .map(|format| match format {
            WireFormat::Plotter => (format, Some(vec!["X:ax".to_owned(), "Y:ay".to_owned()]), "w0"),
            WireFormat::Serial2 => (format, None, "a,b"),
            _ => (format, None, "w0"),
        })
        .collect();
    let alphabet = b"0123456789.,-+eE:>XY *\r\n\t#taxybz_ms\xff\x00nif";
    for _ in 0..2000 {
        for (format, columns, whisker) in &formats {
            let mut decoder = Decoder::new(*format, columns.as_deref(), whisker).unwrap();
            let (mut splitter, mut counts) = (format.splitter(false), Counts::default());
            let mut timing = Timing::new(TimeBase::Stamps, 0.0);
            let bytes: Vec<u8> = (0..dice.below(400)).map(|_| alphabet[dice.below(alphabet.len())]).collect();
            splitter.push(&bytes, |piece| {
                let decoded = match &piece {
                    Piece::Line(text) => decoder.line(text, &mut counts),
                    Piece::Packet(bytes) => decoder.packet(bytes, &mut counts),
                    _ => return,
                };
                if let Decoded::Frame(frame) = decoded {
                    assert!(frame.readings.iter().all(|value| value.is_finite()), "{piece:?}");
                    timing.push(frame, 1.0, &mut counts, &mut |t, _| assert!(t.is_finite()));
                }
            });
        }
    }
}
