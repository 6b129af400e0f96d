//! Packets of a sensor head: numbered, stamped and with a checksum.

use super::{Decoded, Frame};
use crate::counts::Counts;
use crate::{Error, Result};
use vibrissa_core::flow::sensor_log::Quantity;
use vibrissa_head::frame::{Message, Reading, State};
use vibrissa_io::text::did_you_mean;

/// After how much stamps (s) and numbers begin anew.
pub(super) const STAMP_WRAPS: f64 = 4_294.967_296;
pub(super) const NUMBER_WRAPS: u64 = 1 << 32;

/// What a head can say of a reading.
const SAID: [Quantity; 5] = [Quantity::Moment, Quantity::Across, Quantity::FluxX, Quantity::FluxY, Quantity::FluxZ];

/// Which readings are taken from the packets of a head.
#[derive(Clone, Debug)]
pub(super) struct HeadPackets {
    taken: Vec<usize>,
}

impl HeadPackets {
    /// The readings of these names; the moment where none are given.
    pub(super) fn new(columns: Option<&[String]>) -> Result<Self> {
        let Some(names) = columns else { return Ok(Self { taken: vec![0] }) };
        let known = SAID.map(Quantity::word);
        let index = |name: &String| {
            known.iter().position(|word| word == name).ok_or_else(|| {
                let error = Error::data("a sensor head does not send this").value(format!("\"{name}\""));
                error.allowed(known.join(", ")).remedy(did_you_mean(name, &known))
            })
        };
        let taken: Vec<usize> = names.iter().map(index).collect::<Result<_>>()?;
        if taken.is_empty() || (1..taken.len()).any(|k| taken[..k].contains(&taken[k])) {
            return Err(Error::data("columns of a sensor head are at least one, each once").allowed(known.join(", ")));
        }
        Ok(Self { taken })
    }

    pub(super) fn quantities(&self) -> Vec<Quantity> {
        self.taken.iter().map(|&index| SAID[index]).collect()
    }

    pub(super) fn packet(&self, bytes: &[u8], counts: &mut Counts) -> Decoded {
        match Message::read(bytes) {
            Ok(Message::Reading(reading)) => Decoded::Frame(self.frame(&reading, counts)),
            Ok(_) => Decoded::Nothing,
            Err(_) => Decoded::Lost,
        }
    }

    fn frame(&self, reading: &Reading, counts: &mut Counts) -> Frame {
        counts.saturated += u64::from(reading.state.has(State::SATURATED));
        counts.wrapped += u64::from(reading.state.has(State::WRAPPED));
        let [x, y, z] = reading.flux.map(f64::from);
        let said = [reading.moment, reading.across, Some(x), Some(y), Some(z)];
        let readings: Option<Vec<f64>> =
            self.taken.iter().map(|&index| said[index].filter(|value| value.is_finite())).collect();
        // A head without a calibration, beyond its range, or at the end of its converter.
        counts.uncalibrated += u64::from(readings.is_none());
        Frame {
            stamp: Some(f64::from(reading.stamp_us) * 1e-6),
            number: Some(u64::from(reading.number)),
            readings: readings.unwrap_or_default(),
            ..Frame::default()
        }
    }
}
