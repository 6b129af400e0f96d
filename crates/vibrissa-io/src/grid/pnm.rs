//! Portable maps of pixels (PBM, PGM and PPM), by Netpbm's specification of each.

use super::picture::{Fault, Size, eight_bits};

/// The front of a file, and what stands behind it.
struct Front<'a> {
    /// The digit of its magic number: 1 to 3 are written in digits, 4 to 6 in bytes; bits, grey, colours.
    kind: u8,
    size: Size,
    /// The sample that is white.
    most: u16,
    raster: Text<'a>,
}

/// Whether these bytes say that they are such a picture.
pub(super) fn is_pnm(bytes: &[u8]) -> bool {
    matches!(bytes, [b'P', b'1'..=b'6', ..])
}

/// Width and height.
pub(super) fn size(bytes: &[u8]) -> Result<Size, Fault> {
    Ok(Front::read(bytes)?.size)
}

/// The shade of each pixel; a colour's is the mean of red, green and blue, as `map_server` has it.
pub(super) fn shades(bytes: &[u8]) -> Result<Vec<u8>, Fault> {
    let mut front = Front::read(bytes)?;
    let per_pixel = if matches!(front.kind, 3 | 6) { 3 } else { 1 };
    let count = front.size.pixels().and_then(|count| count.checked_mul(per_pixel)).ok_or("it is too large")?;
    let samples = match front.kind {
        1 => front.raster.bits(count)?,
        4 => front.raster.packed_bits(front.size)?,
        2 | 3 => front.raster.digits(count, front.most)?,
        _ => front.raster.bytes(count, front.most)?,
    };
    Ok(super::picture::means(samples, per_pixel))
}

impl<'a> Front<'a> {
    fn read(bytes: &'a [u8]) -> Result<Self, Fault> {
        let [b'P', kind @ b'1'..=b'6', rest @ ..] = bytes else { return Err("it is no PGM".into()) };
        let (kind, mut text) = (kind - b'0', Text(rest));
        let (width, height) = (text.number(true)?, text.number(true)?);
        let most = if matches!(kind, 1 | 4) { 1 } else { text.number(true)? };
        let most = u16::try_from(most).ok().filter(|most| *most > 0).ok_or("its largest shade is not 1 to 65535")?;
        Ok(Self { kind, size: Size { width, height }, most, raster: text })
    }
}

/// Bytes that are read from the front.
struct Text<'a>(&'a [u8]);

impl Text<'_> {
    fn byte(&mut self) -> Option<u8> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }

    /// The next number, and the one space behind it; a comment counts as space where `comments` may stand.
    fn number(&mut self, comments: bool) -> Result<u32, Fault> {
        let mut value: Option<u32> = None;
        while let Some(byte) = self.byte() {
            match byte {
                b'0'..=b'9' => {
                    let larger = value.unwrap_or(0).checked_mul(10).and_then(|v| v.checked_add(u32::from(byte - b'0')));
                    value = Some(larger.ok_or("a number in it is too large")?);
                }
                _ if is_space(byte) => {
                    if value.is_some() {
                        break;
                    }
                }
                b'#' if comments => {
                    let end = self.0.iter().position(|b| matches!(b, b'\n' | b'\r')).map_or(self.0.len(), |at| at + 1);
                    self.0 = &self.0[end..];
                    if value.is_some() {
                        break;
                    }
                }
                _ => return Err("a number in it has other characters than digits".into()),
            }
        }
        value.ok_or_else(|| "it ends too early".into())
    }

    fn digits(&mut self, count: usize, most: u16) -> Result<Vec<u8>, Fault> {
        // Every sample takes at least a byte: what a damaged file promises need not be there.
        self.check(count)?;
        let sample = |_| {
            let sample = u16::try_from(self.number(false)?).map_err(|_| "a shade in it is too large")?;
            let largest = if most > 255 { u16::MAX } else { 255 };
            if sample <= largest { Ok(stretched(sample, most)) } else { Err("a shade in it is too large".into()) }
        };
        (0..count).map(sample).collect()
    }

    fn bytes(&mut self, count: usize, most: u16) -> Result<Vec<u8>, Fault> {
        if most <= 255 {
            self.check(count)?;
            return Ok(self.0[..count].iter().map(|&sample| stretched(u16::from(sample), most)).collect());
        }
        self.check(count.checked_mul(2).ok_or("it is too large")?)?;
        let (samples, _) = self.0.as_chunks::<2>();
        Ok(samples[..count].iter().map(|&sample| stretched(u16::from_be_bytes(sample), most)).collect())
    }

    fn bits(&mut self, count: usize) -> Result<Vec<u8>, Fault> {
        self.check(count)?;
        let mut bits = Vec::with_capacity(count);
        while bits.len() < count {
            match self.byte().ok_or("it ends too early")? {
                b'0' => bits.push(u8::MAX),
                b'1' => bits.push(0),
                byte if is_space(byte) => {}
                _ => return Err("a bit in it is neither 0 nor 1".into()),
            }
        }
        Ok(bits)
    }

    /// Eight in a byte, the first one highest; every row begins with a byte.
    fn packed_bits(&mut self, size: Size) -> Result<Vec<u8>, Fault> {
        let (width, row) = (size.width as usize, (size.width as usize).div_ceil(8).max(1));
        let count = row.checked_mul(size.height as usize).ok_or("it is too large")?;
        self.check(count)?;
        let bit = |row: &[u8], x: usize| if row[x / 8] >> (7 - x % 8) & 1 == 0 { u8::MAX } else { 0 };
        Ok(self.0[..count].chunks(row).flat_map(|row| (0..width).map(move |x| bit(row, x))).collect())
    }

    fn check(&self, count: usize) -> Result<(), Fault> {
        if self.0.len() >= count { Ok(()) } else { Err("it ends too early".into()) }
    }
}

fn is_space(byte: u8) -> bool {
    matches!(byte, b'\t' | b'\n' | b'\x0b' | b'\x0c' | b'\r' | b' ')
}

/// A sample of which `most` is white, in eight bits.
fn stretched(sample: u16, most: u16) -> u8 {
    let share = |white: f32| (f32::from(sample) * (white / f32::from(most))).round();
    if most > 255 { eight_bits(share(65535.0) as u16) } else { share(255.0) as u8 }
}

#[cfg(test)]
mod tests {
    use super::shades;

    #[test]
    fn every_kind_is_read() {
        let cases: [(&[u8], &[u8]); 8] = [
            (b"P1 3 2 1 0 1\n011", &[0, 255, 0, 255, 0, 0]),
            (b"P2\n# two # by one\n2 1\n15\n0 15", &[0, 255]),
            (b"P2 2 1 1000 500 1000", &[128, 255]),
            (b"P3 1 1 255 3 6 10", &[6]),
            (
                b"P4\n9 2\n\x80\x80\x01\x00",
                &[0, 255, 255, 255, 255, 255, 255, 255, 0, 255, 255, 255, 255, 255, 255, 255, 0, 255],
            ),
            (b"P5 2 1 100\n\x32\xff", &[128, 255]),
            (b"P5 2 1 65535\n\x80\x00\xff\xff", &[128, 255]),
            (b"P6 1 1 255\n\x03\x06\x0a", &[6]),
        ];
        for (bytes, want) in cases {
            assert_eq!(shades(bytes).as_deref(), Ok(want), "{}", String::from_utf8_lossy(bytes));
        }
    }

    #[test]
    fn what_is_short_or_wrong_is_refused() {
        for bytes in [
            &b"P5"[..],
            b"P5 2 2 255\n\x01\x02\x03",
            b"P5 2 1 300\n\x01\x02\x03",
            b"P5 2 1 0\n\x01\x02",
            b"P5 2 1 70000\n\x01\x02\x03\x04",
            b"P5 4294967296 1 255\n",
            b"P5 4294967295 4294967295 65535\n",
            b"P4 4294967295 4294967295\n",
            b"P2 2 1 255 1 256",
            b"P2 2 1 255 1 x",
            b"P2 2 1 255 1 # 2",
            b"P1 2 1 1 2",
            b"P7 1 1",
        ] {
            assert!(shades(bytes).is_err(), "{}", String::from_utf8_lossy(bytes));
        }
    }
}
