//! Magnetometer chips: what they make of a field.

use super::Vec3;
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// A three-axis magnetometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Chip {
    /// Melexis MLX90393: 16 of 19 bits \[melexis2020mlx90393\].
    Mlx90393(Mlx90393),
    /// Infineon TLE493D: 12 bits up to ±160 mT \[infineon2019tle493d\].
    Tle493d(Tle493d),
}

impl Default for Chip {
    fn default() -> Self {
        Self::Mlx90393(Mlx90393::default())
    }
}

/// The settings of an MLX90393 by the names of its registers; spinning rate HALLCONF = 0xC, no temperature compensation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mlx90393 {
    /// `GAIN_SEL`, 0 (coarsest) to 7 (finest).
    pub gain: u8,
    /// `RES`, 0 to 3: how many of the lowest bits are dropped, on all axes.
    pub resolution: u8,
    /// `OSR`, 0 to 3.
    pub oversampling: u8,
    /// `DIG_FILT`, 0 to 7.
    pub filter: u8,
}

impl Default for Mlx90393 {
    /// Half a microtesla or finer, ±9.8 mT across, and 300 readings a second with time to spare.
    fn default() -> Self {
        Self { gain: 7, resolution: 1, oversampling: 0, filter: 2 }
    }
}

/// The settings of a TLE493D.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tle493d {
    /// Twice the sensitivity for a bit more than half the range.
    pub short_range: bool,
}

/// Sensitivity of the MLX90393 at the finest gain and resolution across the chip and along its third axis (T a count).
///
/// The data sheet's table, to its last digit, is these times the gain ratio and two to the power of the resolution.
const MLX_FINEST: Vec3 = [0.150_22e-6, 0.150_22e-6, 0.242e-6];
/// How much coarser each `GAIN_SEL` is than the finest.
const MLX_GAINS: [f64; 8] = [5.0, 4.0, 3.0, 2.5, 2.0, 5.0 / 3.0, 4.0 / 3.0, 1.0];
/// Where the converter saturates, in counts of resolution 0: the data sheet's ±22000 at `RES` 2 and ±11000 at `RES` 3.
const MLX_SATURATION: f64 = 88_000.0;
/// Conversion time of the MLX90393 that depends on no setting (s): wake-up, temperature, end; from the data sheet's table.
const MLX_OVERHEAD: f64 = 492e-6;

/// Sensitivity of the TLE493D (counts a T): 7.7 a mT.
const TLE_SENSITIVITY: f64 = 7.7e3;
const TLE_LARGEST: f64 = 2047.0;
/// Range in which the data sheet promises linearity (T), full and short.
const TLE_RANGE: [f64; 2] = [0.160, 0.100];

impl Mlx90393 {
    fn per_count_at_resolution_0(self) -> Vec3 {
        MLX_FINEST.map(|finest| finest * MLX_GAINS[usize::from(self.gain.min(7))])
    }

    fn shift(self) -> u32 {
        u32::from(self.resolution.min(3))
    }

    /// The register's value in no field: the two coarser resolutions are unsigned.
    fn zero(self) -> i64 {
        [0, 0, 1 << 15, 1 << 14][self.shift() as usize]
    }

    /// One register: the converter saturates, low bits are dropped, and what does not fit into 16 bits wraps round.
    fn register(self, flux: f64, per_count: f64) -> i32 {
        let converted = (flux / per_count).round().clamp(-MLX_SATURATION, MLX_SATURATION);
        let bits = ((converted as i64) >> self.shift()) + self.zero();
        if self.zero() == 0 { i32::from(bits as i16) } else { i32::from(bits as u16) }
    }
}

impl Chip {
    /// The register values of the three axes in a field along them (T).
    ///
    /// The MLX90393 wraps at 16 bits: signed at resolutions 0 and 1, unsigned about 32768 and 16384 at 2 and 3. The
    /// TLE493D stops at its 12 bits.
    #[must_use]
    pub fn counts(&self, flux: Vec3) -> [i32; 3] {
        match self {
            Self::Mlx90393(mlx) => {
                let per_count = mlx.per_count_at_resolution_0();
                [0, 1, 2].map(|k| mlx.register(flux[k], per_count[k]))
            }
            Self::Tle493d(_) => {
                let per_count = self.per_count();
                [0, 1, 2].map(|k| (flux[k] / per_count[k]).round().clamp(-TLE_LARGEST - 1.0, TLE_LARGEST) as i32)
            }
        }
    }

    /// The field (T) that register values stand for, as a driver computes it: a wrapped value stays wrapped.
    #[must_use]
    pub fn flux(&self, counts: [i32; 3]) -> Vec3 {
        let zero = match self {
            Self::Mlx90393(mlx) => mlx.zero() as i32,
            Self::Tle493d(_) => 0,
        };
        let per_count = self.per_count();
        [0, 1, 2].map(|k| f64::from(counts[k] - zero) * per_count[k])
    }

    /// What one count means along each axis (T).
    #[must_use]
    pub fn per_count(&self) -> Vec3 {
        match self {
            Self::Mlx90393(mlx) => mlx.per_count_at_resolution_0().map(|v| v * f64::from(1 << mlx.shift())),
            Self::Tle493d(tle) => [1.0 / (TLE_SENSITIVITY * if tle.short_range { 2.0 } else { 1.0 }); 3],
        }
    }

    /// The largest field along each axis that is converted without wrap-around, saturation or loss of linearity (T).
    #[must_use]
    pub fn range(&self) -> Vec3 {
        match self {
            Self::Mlx90393(mlx) => {
                let most = if mlx.zero() == 0 { f64::from((1 << (15 + mlx.shift())) - 1) } else { MLX_SATURATION };
                mlx.per_count_at_resolution_0().map(|v| v * most.min(MLX_SATURATION))
            }
            Self::Tle493d(tle) => [TLE_RANGE[usize::from(tle.short_range)]; 3],
        }
    }

    /// After how many counts a register begins anew, where it wraps: 16 bits of the MLX90393.
    #[must_use]
    pub fn wraps(&self) -> Option<i32> {
        match self {
            Self::Mlx90393(_) => Some(1 << 16),
            Self::Tle493d(_) => None,
        }
    }

    /// Whether a count, carried on over its wraps, is where the converter ends: the field is that or more.
    #[must_use]
    pub fn is_saturated(&self, count: i32) -> bool {
        match self {
            Self::Mlx90393(mlx) => {
                let end = (MLX_SATURATION as i64) >> mlx.shift();
                let at = i64::from(count) - mlx.zero();
                at >= end || at <= -end
            }
            Self::Tle493d(_) => {
                let end = TLE_LARGEST as i32;
                count >= end || count <= -end
            }
        }
    }

    /// How long one reading of all three axes takes (s); none where we know no formula.
    ///
    /// MLX90393 in single measurements: three times `67 + 64 2^OSR (2 + 2^DIG_FILT)` µs and what comes before and after.
    #[must_use]
    pub fn conversion_time(&self) -> Option<f64> {
        match self {
            Self::Mlx90393(mlx) => {
                let (osr, filter) = (mlx.oversampling.min(3), mlx.filter.min(7));
                let axis = 67e-6 + 64e-6 * f64::from(1 << osr) * (2.0 + f64::from(1 << filter));
                Some(3.0 * axis + MLX_OVERHEAD)
            }
            Self::Tle493d(_) => None,
        }
    }
}
