//! The sensor at a whisker's base: from the bending moment to the numbers that a magnetometer chip puts out.
//!
//! The whisker stands in a rubber disc that gives way by an angle in proportion to the moment. A magnet below the disc
//! turns with it, and a chip below the magnet feels how its field turns and shifts \[routray, section "Sensor
//! Fabrication"\].
//!
//! | file | what it knows |
//! | --- | --- |
//! | `dipole` | the field of a magnet |
//! | `chip` | counts from fields: sensitivity, bits, wrap-around, saturation, conversion time |
//! | `response` | moments from readings |

mod chip;
mod dipole;
mod response;

use crate::math;
pub use chip::{Chip, Mlx90393, Tle493d};
pub use dipole::{Vec3, dipole_field};
pub use response::{SURFACE_TERMS, excursion, polynomial, surface, surface_terms};

use crate::config::sensing as defaults;

/// A whisker's compliant element, its magnet, and the chip that feels the magnet.
///
/// Places and vectors are in the whisker frame with the third axis upwards: the pivot at the origin, the whisker along
/// +x at rest. The chip's third axis points along the whisker and its second along the whisker's +y, so that the whisker
/// bends in the chip's y-z plane, as in the paper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensingChain {
    /// Rotational stiffness of the compliant element (N m/rad), positive.
    pub stiffness: f64,
    /// The magnet's dipole moment at rest (A m²).
    pub magnet_moment: Vec3,
    /// The magnet's place at rest (m).
    pub magnet_offset: Vec3,
    /// The chip's place (m).
    pub chip_offset: Vec3,
    /// The field that is there without the magnet, along the chip's axes (T).
    pub ambient: Vec3,
    /// The chip.
    pub chip: Chip,
}

impl Default for SensingChain {
    fn default() -> Self {
        Self {
            stiffness: defaults::STIFFNESS,
            magnet_moment: [defaults::MAGNET_MOMENT, 0.0, 0.0],
            magnet_offset: [-defaults::MAGNET_DEPTH, 0.0, 0.0],
            chip_offset: [-defaults::MAGNET_DEPTH - defaults::CHIP_DISTANCE, 0.0, 0.0],
            ambient: [0.0; 3],
            chip: Chip::default(),
        }
    }
}

impl SensingChain {
    /// How far the compliant element turns under a moment (N m), counter-clockwise (rad).
    #[must_use]
    pub fn rotation(&self, moment: f64) -> f64 {
        moment / self.stiffness
    }

    /// The flux density at the chip along its axes (T) under a moment (N m).
    ///
    /// The magnet is a point dipole: fine from about two of its lengths on.
    #[must_use]
    pub fn flux(&self, moment: f64) -> Vec3 {
        let angle = self.rotation(moment);
        self.seen(turned(self.magnet_moment, angle), turned(self.magnet_offset, angle))
    }

    /// The same under moments about both transverse axes (N m): in the whisker's x-y plane, and across it, positive for a push towards +z.
    ///
    /// The compliant element is as stiff about one axis as about the other, and turns about their common one.
    #[must_use]
    pub fn flux_in_space(&self, [moment, across]: [f64; 2]) -> Vec3 {
        let angle = self.rotation(math::hypot(moment, across));
        let (sin, cos) = math::sin_cos(math::atan2(across, moment));
        // About the axis, so that the bending plane becomes the x-y plane, then the turn, and back.
        let rolled = |[x, y, z]: Vec3| [x, cos * y + sin * z, cos * z - sin * y];
        let back = |[x, y, z]: Vec3| [x, cos * y - sin * z, cos * z + sin * y];
        let turn = |v: Vec3| back(turned(rolled(v), angle));
        self.seen(turn(self.magnet_moment), turn(self.magnet_offset))
    }

    /// The flux density at the chip along its axes (T) of a magnet with this moment (A m²) at this place (m).
    fn seen(&self, magnet: Vec3, at: Vec3) -> Vec3 {
        let [x, y, z] = dipole_field(magnet, [0, 1, 2].map(|k| self.chip_offset[k] - at[k]));
        let along_chip = [-z, y, x];
        [0, 1, 2].map(|k| along_chip[k] + self.ambient[k])
    }
}

/// The vector turned about the third axis, counter-clockwise (rad).
fn turned([x, y, z]: Vec3, angle: f64) -> Vec3 {
    let (sin, cos) = math::sin_cos(angle);
    [cos * x - sin * y, sin * x + cos * y, z]
}
