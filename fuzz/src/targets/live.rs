//! The live decoders: bytes as they come from a wire, cut anywhere.

use super::{Verdict, promise, read};
use vibrissa_live::counts::Counts;
use vibrissa_live::decode::{Decoded, Decoder, Piece, WireFormat};

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
