//! A map's picture in PNG.

use super::picture::{Fault, Size, eight_bits, mean, means};
use crate::config::limits::MOST_CELLS;
use png::{ColorType, Decoder, DecodingError, Limits, Transformations};
use std::io::Cursor;

fn decoder(bytes: &[u8]) -> Result<Decoder<Cursor<&[u8]>>, Fault> {
    if !bytes.starts_with(b"\x89PNG") {
        return Err("it is neither PGM nor PNG".into());
    }
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: 16 * MOST_CELLS });
    // Texts and colour profiles may be packed to a thousandth of their size, and no map needs them.
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_transformations(Transformations::EXPAND);
    Ok(decoder)
}

fn told(error: DecodingError) -> Fault {
    error.to_string().into()
}

pub(super) fn size(bytes: &[u8]) -> Result<Size, Fault> {
    let mut decoder = decoder(bytes)?;
    let header = decoder.read_header_info().map_err(told)?;
    Ok(Size { width: header.width, height: header.height })
}

pub(super) fn pixels(bytes: &[u8]) -> Result<Vec<[u8; 2]>, Fault> {
    let mut reader = decoder(bytes)?.read_info().map_err(told)?;
    let mut samples = vec![0; reader.output_buffer_size().ok_or("it is too large")?];
    let info = reader.next_frame(&mut samples).map_err(told)?;
    samples.truncate(info.buffer_size());
    if info.bit_depth == png::BitDepth::Sixteen {
        samples = samples.as_chunks::<2>().0.iter().map(|&two| eight_bits(u16::from_be_bytes(two))).collect();
    }
    let opaque = |shade: u8| [shade, u8::MAX];
    Ok(match info.color_type {
        ColorType::Grayscale => samples.into_iter().map(opaque).collect(),
        ColorType::Rgb => means(samples, 3).into_iter().map(opaque).collect(),
        ColorType::GrayscaleAlpha => samples.as_chunks::<2>().0.to_vec(),
        ColorType::Rgba => samples.as_chunks::<4>().0.iter().map(|&[r, g, b, a]| [mean([r, g, b]), a]).collect(),
        // Palettes are expanded to colours.
        ColorType::Indexed => return Err("its colours are not there".into()),
    })
}
