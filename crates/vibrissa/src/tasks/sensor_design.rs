//! Where the chip of a sensor belongs: what it reads, how finely, and what that means at the whisker's tip.

use crate::beam::{Whisker, moment_per_travel};
use crate::sensing::SensingChain;
use crate::{Error, Result};

/// Distances from magnet to chip that are tried (m): a millimetre apart would miss the best one by a tenth.
const STEP: f64 = 0.1e-3;
/// Farther than this no magnet of a whisker is felt (m).
const FARTHEST: f64 = 30e-3;
/// Moments that are tried on either side of none.
const MOMENTS: i32 = 100;
/// Share of the chip's range that a design uses at most: the rest is for the field of the room and for a magnet that sits askew.
pub const LARGEST_SHARE: f64 = 0.8;

/// A sensor with its chip at one distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorDesign {
    /// From the magnet's centre to the chip (m).
    pub distance: f64,
    /// The flux without contact along the chip's axes (T).
    pub rest: [f64; 3],
    /// The largest share of the chip's range on any axis, over all moments.
    pub share: f64,
    /// The moment of one count, all axes together (N m): where the whisker is free, and at the largest moment.
    pub resolution: [f64; 2],
    /// Standard deviation of a reading (N m), where the whisker is free: of rounding to counts, and of the chip's noise where it is told.
    pub noise: f64,
    /// The same as a travel of the tip across the free whisker (m).
    pub tip_noise: f64,
}

/// The design with the chip at a distance (m) from the magnet's centre, along the whisker.
///
/// `largest` is the largest moment (N m), of either sign; `noise` the standard deviation of the chip's flux on each axis (T), 0 where
/// it is not known. The tip's travel counts the base's own rotation where the whisker has a base stiffness.
///
/// # Errors
///
/// A distance, moment or noise out of its range; a whisker that makes no sense.
pub fn sensor_design(
    chain: &SensingChain,
    whisker: &Whisker,
    distance: f64,
    largest: f64,
    noise: f64,
) -> Result<SensorDesign> {
    let named = [
        ("distance", distance, 1e-4, FARTHEST, "m"),
        ("largest moment", largest, 1e-9, 10.0, "N m"),
        ("noise", noise, 0.0, 1.0, "T"),
    ];
    for (name, value, lo, hi, unit) in named {
        if !(lo..=hi).contains(&value) {
            return Err(Error::usage(name).value(value).allowed(format!("{lo} to {hi} {unit}")));
        }
    }
    let chip_offset = [chain.magnet_offset[0] - distance, chain.magnet_offset[1], chain.magnet_offset[2]];
    let chain = SensingChain { chip_offset, ..*chain };
    let (range, step) = (chain.chip.range(), chain.chip.per_count());
    let mut share = 0.0_f64;
    for k in -MOMENTS..=MOMENTS {
        let flux = chain.flux(largest * f64::from(k) / f64::from(MOMENTS));
        share = (0..3).fold(share, |share, axis| share.max((flux[axis] / range[axis]).abs()));
    }
    // How many units of each axis a N m moves, all axes together.
    let moved = |moment: f64, unit: [f64; 3]| -> f64 {
        let h = 1e-4 * largest;
        let (below, above) = (chain.flux(moment - h), chain.flux(moment + h));
        (0..3).map(|k| ((above[k] - below[k]) / (2.0 * h * unit[k])).powi(2)).sum::<f64>().sqrt()
    };
    let deviation = step.map(|step| (step * step / 12.0 + noise * noise).sqrt());
    let noise = 1.0 / moved(0.0, deviation);
    Ok(SensorDesign {
        distance,
        rest: chain.flux(0.0),
        share,
        resolution: [1.0 / moved(0.0, step), 1.0 / moved(largest, step)],
        noise,
        tip_noise: noise / moment_per_travel(whisker, whisker.length)?,
    })
}

/// The design with the least noise among all distances (m) from `nearest` on whose fields stay within [`LARGEST_SHARE`] of the chip's range;
/// none where no distance does. A point dipole is fine from about two lengths of the magnet on.
///
/// # Errors
///
/// As [`sensor_design`].
pub fn best_sensor_design(
    chain: &SensingChain,
    whisker: &Whisker,
    nearest: f64,
    largest: f64,
    noise: f64,
) -> Result<Option<SensorDesign>> {
    let mut best: Option<SensorDesign> = None;
    let mut distance = nearest;
    while distance <= FARTHEST {
        let design = sensor_design(chain, whisker, distance, largest, noise)?;
        if design.share <= LARGEST_SHARE && best.is_none_or(|best| design.noise < best.noise) {
            best = Some(design);
        }
        distance += STEP;
    }
    Ok(best)
}
