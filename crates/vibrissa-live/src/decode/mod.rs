//! Bytes to frames: lines out of a stream that may be torn anywhere, and the numbers in them.
//!
//! | format | a line holds | time |
//! | --- | --- | --- |
//! | `serial` | the flux of the paper's sensor, `x,y,z` in µT | counted at 300 Hz |
//! | `serial2` | the same of two sensors taking turns | counted at 150 Hz each |
//! | `plotter` | `>NAME: VALUE`, one value a line, as serial plotters read | counted |
//! | `ratatouille` | host stamp and two counts | in the line |
//! | `openwhisker` | host stamp, three counts that wrap, two lengths | in the line |
//! | `csv` | named columns, by a header line or by `columns` | columns `t`, `t_ms`, `t_us`, or counted |
//! | `tum` | odometry `t x y z qx qy qz qw` | in the line |
//! | `head` | no line: a packet of a sensor head, numbered and with a checksum | in the packet |
//!
//! A line may end in a checksum of the bytes before it: `*HH`, their exclusive or, or `*HHHH`, their CRC-16 (CCITT, from FFFF), in
//! hexadecimal digits. Where it is there it must be right, and a stream that had one must have one in every line.

mod columns;
mod counter;
mod head;
mod line_splitter;
mod plotter;

pub use columns::{Column, Columns};
pub use counter::{Counter, Step};
pub use line_splitter::{LineSplitter, Piece};

use crate::counts::Counts;
use crate::{Error, Result};
use columns::Values;
use core::str::FromStr;
use head::HeadPackets;
use plotter::Plotter;
use vibrissa_core::flow::sensor_log::{Channel, Quantity};
use vibrissa_core::plane::Pose2;
use vibrissa_io::log::foreign::{CarriedCounts, TakingTurns, flux_line, host_stamp, is_saturated, number, numbers};
use vibrissa_io::parse_tum;
use vibrissa_io::text::did_you_mean;

/// The formats of lines and packets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WireFormat {
    /// `x,y,z` in µT, without time.
    Serial,
    /// The same of two sensors taking turns.
    Serial2,
    /// `>NAME: VALUE`, one value a line.
    Plotter,
    /// Host stamp and two raw counts.
    Ratatouille,
    /// Host stamp, three raw counts that wrap, two lengths in mm.
    Openwhisker,
    /// Named columns.
    Csv,
    /// Odometry `t x y z qx qy qz qw`.
    Tum,
    /// Packets of a sensor head.
    Head,
}

impl WireFormat {
    /// Every format.
    pub const ALL: [Self; 8] = [
        Self::Serial,
        Self::Serial2,
        Self::Plotter,
        Self::Ratatouille,
        Self::Openwhisker,
        Self::Csv,
        Self::Tum,
        Self::Head,
    ];

    /// The word that names it.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Serial => "serial",
            Self::Serial2 => "serial2",
            Self::Plotter => "plotter",
            Self::Ratatouille => "ratatouille",
            Self::Openwhisker => "openwhisker",
            Self::Csv => "csv",
            Self::Tum => "tum",
            Self::Head => "head",
        }
    }

    /// Puts bytes of this format together; `torn` as [`LineSplitter::new`] takes it.
    #[must_use]
    pub fn splitter(self, torn: bool) -> LineSplitter {
        if self == Self::Head { LineSplitter::of_packets(torn) } else { LineSplitter::new(torn) }
    }
}

impl FromStr for WireFormat {
    type Err = Error;

    fn from_str(word: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|format| format.as_str() == word).ok_or_else(|| {
            let known = Self::ALL.map(Self::as_str);
            Error::data("unknown format").value(word).allowed(known.join(", ")).remedy(did_you_mean(word, &known))
        })
    }
}

/// What one line, or a few that belong together, say.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// The device's or the sender's time (s), which may wrap; none where it says none.
    pub stamp: Option<f64>,
    /// The frame's number, which may wrap; none where it has none.
    pub number: Option<u64>,
    /// The robot in the odometry frame.
    pub pose: Option<Pose2>,
    /// Absolute heading (rad).
    pub heading: Option<f64>,
    /// The readings, in the order of [`Decoder::channels`]; empty where the device has sent a number and a time, but no reading that it
    /// believes.
    pub readings: Vec<f64>,
}

/// What became of a line.
#[derive(Clone, Debug, PartialEq)]
pub enum Decoded {
    /// A frame is complete.
    Frame(Frame),
    /// It holds no frame, but took the place of one.
    Lost,
    /// It says nothing by itself: a header, or a part of a frame.
    Nothing,
}

/// Lines of one stream to frames.
#[derive(Clone, Debug)]
pub struct Decoder {
    kind: Kind,
    channels: Vec<Channel>,
    /// Whether every line has a checksum.
    summed: bool,
}

#[derive(Clone, Debug)]
enum Kind {
    Serial,
    Serial2(TakingTurns),
    Plotter(Plotter),
    Ratatouille,
    Openwhisker(CarriedCounts),
    /// Without columns until the header has come.
    Csv(Option<Columns>, String),
    Tum,
    Head(HeadPackets),
}

impl Decoder {
    /// A decoder; `whisker` is whose readings those are that do not say it, of [`WireFormat::Serial2`] the first of two names
    /// with a comma between them.
    ///
    /// # Errors
    ///
    /// Columns that are none, that are due and missing, or that the format does not have.
    pub fn new(format: WireFormat, columns: Option<&[String]>, whisker: &str) -> Result<Self> {
        let takes_columns = matches!(format, WireFormat::Csv | WireFormat::Plotter | WireFormat::Head);
        if columns.is_some() && !takes_columns {
            return Err(Error::data(format!("the format {} has no columns to name", format.as_str()))
                .remedy("leave `columns` out, or write format = \"csv\""));
        }
        let flux = [Quantity::FluxX, Quantity::FluxY, Quantity::FluxZ];
        let counts = [Quantity::CountX, Quantity::CountY, Quantity::CountZ];
        let of = |whisker: &str, quantities: &[Quantity]| -> Vec<Channel> {
            quantities.iter().map(|&quantity| Channel { whisker: whisker.to_owned(), quantity }).collect()
        };
        let (kind, channels) = match format {
            WireFormat::Serial => (Kind::Serial, of(whisker, &flux)),
            WireFormat::Serial2 => {
                let (first, second) = whisker.split_once(',').ok_or_else(|| {
                    Error::data("the format serial2 has two sensors")
                        .value(format!("whisker = \"{whisker}\""))
                        .remedy("name both in the order of their lines: whisker = \"left,right\"")
                })?;
                let both = of(first.trim(), &flux).into_iter().chain(of(second.trim(), &flux));
                (Kind::Serial2(TakingTurns::default()), both.collect())
            }
            WireFormat::Plotter => {
                let plotter = Plotter::new(columns.unwrap_or_default(), whisker)?;
                let channels = plotter.columns.channels().to_vec();
                (Kind::Plotter(plotter), channels)
            }
            WireFormat::Ratatouille => (Kind::Ratatouille, of(whisker, &counts[..2])),
            WireFormat::Openwhisker => (Kind::Openwhisker(CarriedCounts::default()), of(whisker, &counts)),
            WireFormat::Csv => {
                let columns = columns.map(|names| Columns::new(names, whisker)).transpose()?;
                let channels = columns.as_ref().map(|c| c.channels().to_vec()).unwrap_or_default();
                (Kind::Csv(columns, whisker.to_owned()), channels)
            }
            WireFormat::Tum => (Kind::Tum, Vec::new()),
            WireFormat::Head => {
                let packets = HeadPackets::new(columns)?;
                let channels = of(whisker, &packets.quantities());
                (Kind::Head(packets), channels)
            }
        };
        Ok(Self { kind, channels, summed: false })
    }

    /// The same for a stream in which every line has a checksum, the first one too.
    #[must_use]
    pub fn with_checksums(mut self) -> Self {
        self.summed = true;
        self
    }

    /// The readings of a frame; of CSV without `columns` known once the header has come.
    #[must_use]
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Whether it is known what a frame holds.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        !matches!(self.kind, Kind::Csv(None, _))
    }

    /// Whether frames hold odometry.
    #[must_use]
    pub fn has_pose(&self) -> bool {
        match &self.kind {
            Kind::Tum => true,
            Kind::Csv(Some(columns), _) => columns.has_pose(),
            _ => false,
        }
    }

    /// After how much the stamps begin anew (s), where they wrap.
    #[must_use]
    pub fn stamp_wraps(&self) -> Option<f64> {
        match &self.kind {
            Kind::Csv(Some(columns), _) => columns.stamp_wraps(),
            Kind::Plotter(plotter) => plotter.columns.stamp_wraps(),
            Kind::Head(_) => Some(head::STAMP_WRAPS),
            _ => None,
        }
    }

    /// After how many frames their numbers begin anew, where they wrap.
    #[must_use]
    pub fn number_wraps(&self) -> Option<u64> {
        match &self.kind {
            Kind::Csv(Some(columns), _) => columns.number_wraps(),
            Kind::Head(_) => Some(head::NUMBER_WRAPS),
            _ => None,
        }
    }

    /// Reads a line, without its end.
    pub fn line(&mut self, text: &str, counts: &mut Counts) -> Decoded {
        let text = match checked(text) {
            Some((body, summed)) if summed || !self.summed => {
                self.summed |= summed;
                body
            }
            _ => return Decoded::Lost,
        };
        match &mut self.kind {
            Kind::Serial => match flux_line(text) {
                Some(flux) => {
                    counts.saturated += flux.iter().filter(|b| is_saturated(**b)).count() as u64;
                    frame(Frame { readings: flux.to_vec(), ..Frame::default() })
                }
                None => Decoded::Lost,
            },
            Kind::Serial2(turns) => {
                let flux = flux_line(text);
                match (turns.push(flux), flux) {
                    (Some(pair), _) => frame(Frame { readings: pair.to_vec(), ..Frame::default() }),
                    (None, Some(_)) => Decoded::Nothing,
                    (None, None) => Decoded::Lost,
                }
            }
            Kind::Plotter(plotter) => plotter.line(text),
            Kind::Ratatouille => ratatouille(text).map_or(Decoded::Lost, frame),
            Kind::Openwhisker(carried) => match numbers::<6>(text) {
                Some([t, x, y, z, _, _]) if [x, y, z].iter().all(|c| (0.0..65_536.0).contains(c)) => {
                    let readings = carried.push([x, y, z]).to_vec();
                    counts.wrapped = carried.wrapped as u64;
                    frame(Frame { stamp: Some(t), readings, ..Frame::default() })
                }
                _ => Decoded::Lost,
            },
            Kind::Csv(Some(columns), _) => columns.line(text).map_or(Decoded::Lost, |Values(values)| frame(values)),
            Kind::Csv(none, whisker) => {
                let names: Vec<String> = text.split(',').map(|name| name.trim().to_owned()).collect();
                match Columns::of_header(&names, whisker) {
                    Some(columns) => {
                        self.channels = columns.channels().to_vec();
                        *none = Some(columns);
                        Decoded::Nothing
                    }
                    None => Decoded::Lost,
                }
            }
            Kind::Tum => match parse_tum(text).ok().and_then(|poses| poses.first().copied()) {
                Some(pose) => frame(Frame { stamp: Some(pose.t), pose: Some(pose.map_from_robot), ..Frame::default() }),
                None if text.starts_with('#') => Decoded::Nothing,
                None => Decoded::Lost,
            },
            Kind::Head(_) => Decoded::Lost,
        }
    }

    /// Reads a packet, without the zero at its end. Formats of lines have none.
    pub fn packet(&mut self, bytes: &[u8], counts: &mut Counts) -> Decoded {
        match &self.kind {
            Kind::Head(packets) => packets.packet(bytes, counts),
            _ => Decoded::Lost,
        }
    }
}

fn frame(frame: Frame) -> Decoded {
    Decoded::Frame(frame)
}

fn ratatouille(text: &str) -> Option<Frame> {
    let mut fields = text.split(',').map(str::trim);
    let (stamp, x, y) = (fields.next()?, fields.next()?, fields.next()?);
    let readings = vec![number(x)?, number(y)?];
    let counts = readings.iter().all(|count| (0.0..65_536.0).contains(count));
    (fields.next().is_none() && counts).then(|| Frame { stamp: host_stamp(stamp), readings, ..Frame::default() })
}

/// The line without its checksum, and whether it has one; none where that is wrong.
fn checked(text: &str) -> Option<(&str, bool)> {
    let Some((body, sum)) = text.rsplit_once('*') else { return Some((text, false)) };
    let told = u16::from_str_radix(sum, 16).ok()?;
    let found = match sum.len() {
        2 => u16::from(body.bytes().fold(0, |sum, byte| sum ^ byte)),
        4 => crc16(body.as_bytes()),
        _ => return None,
    };
    (found == told).then_some((body, true))
}

/// CRC-16 with the polynomial 1021, most significant bit first, from FFFF.
#[must_use]
pub fn crc16(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xffff, |crc, byte| {
        (0..8).fold(
            crc ^ (u16::from(*byte) << 8),
            |crc, _| if crc & 0x8000 == 0 { crc << 1 } else { (crc << 1) ^ 0x1021 },
        )
    })
}

#[cfg(test)]
mod tests {
    use super::{Decoded, Decoder, WireFormat, crc16};
    use crate::counts::Counts;

    #[test]
    fn checksums_are_those_of_the_catalogue() {
        // The check value of CRC-16/CCITT-FALSE.
        assert_eq!(crc16(b"123456789"), 0x29b1);
        let mut decoder = Decoder::new(WireFormat::Serial, None, "w0").unwrap();
        let mut counts = Counts::default();
        let mut is_frame = |line: &str| matches!(decoder.line(line, &mut counts), Decoded::Frame(_));
        assert!(is_frame("1,2,3") && !is_frame("1,2,3*00") && !is_frame("1,2,3*1") && is_frame("1,2,3*30"));
        assert!(!is_frame("1,2,3"), "a stream with checksums has one in every line");
        assert!(is_frame(&format!("1,2,3*{:04X}", crc16(b"1,2,3"))));
    }

    #[test]
    fn lines_of_each_format_are_read_in_si() {
        let readings = |format, columns: Option<&[&str]>, whisker, lines: &[&str]| -> Vec<Vec<f64>> {
            let columns: Option<Vec<String>> = columns.map(|names| names.iter().map(|n| (*n).to_owned()).collect());
            let mut decoder = Decoder::new(format, columns.as_deref(), whisker).unwrap();
            let mut counts = Counts::default();
            let frames = lines.iter().filter_map(|line| match decoder.line(line, &mut counts) {
                Decoded::Frame(frame) => Some(frame.stamp.into_iter().chain(frame.readings).collect()),
                _ => None,
            });
            frames.collect()
        };
        let one = |found: Vec<Vec<f64>>, want: &[f64]| {
            assert_eq!(found.len(), 1, "{found:?}");
            assert!(found[0].iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        };
        one(readings(WireFormat::Serial, None, "w", &["Sensor ready", "1.5,-2,3"]), &[1.5e-6, -2e-6, 3e-6]);
        one(readings(WireFormat::Serial2, None, "a,b", &["1,2,3", "4,5,6"]), &[1e-6, 2e-6, 3e-6, 4e-6, 5e-6, 6e-6]);
        let plotter = [">X: 7", ">Z: 1", ">Y: -8.5", ">X: 9"];
        one(readings(WireFormat::Plotter, Some(&["X:ax", "Y:ay"]), "w", &plotter), &[7.0, -8.5]);
        let host = "1970-01-01_00:00:02.5,30000,31000";
        one(readings(WireFormat::Ratatouille, None, "w", &[host]), &[2.5, 30_000.0, 31_000.0]);
        let wraps = readings(WireFormat::Openwhisker, None, "w", &["1,65530,5,9,0,0", "2,4,5,9,0,0"]);
        assert_eq!(wraps[1], [2.0, 65_540.0, 5.0, 9.0]);
        let named: &[&str] = &["t_ms", "-", "moment_mNm", "b.bx_uT"];
        one(readings(WireFormat::Csv, Some(named), "w", &["1500,whatever,2,3"]), &[1.5, 2e-3, 3e-6]);
        one(readings(WireFormat::Csv, None, "w", &["garbage", "t,x,y,theta,moment,other", "1,0,0,0,4,9"]), &[1.0, 4.0]);
        one(readings(WireFormat::Tum, None, "", &["# a comment", "3 1 2 0 0 0 0 1"]), &[3.0]);
    }
}
