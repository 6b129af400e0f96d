//! The field of a magnet that is small against its distance.

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// A vector in space.
pub type Vec3 = [f64; 3];

/// The vacuum permeability over 4 pi (T m/A).
const MU_0_OVER_4_PI: f64 = 1e-7;

/// The flux density (T) of a point dipole with this moment (A m²) at the place `from_dipole` (m) relative to it:
/// `(mu0 / 4 pi) (3 (m·r) r / r⁵ - m / r³)`.
///
/// Not finite at the dipole itself.
#[must_use]
pub fn dipole_field(moment: Vec3, from_dipole: Vec3) -> Vec3 {
    let dot = |a: Vec3, b: Vec3| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let squared = dot(from_dipole, from_dipole);
    let cubed = squared * squared.sqrt();
    let along = 3.0 * dot(moment, from_dipole) / squared;
    [0, 1, 2].map(|k| MU_0_OVER_4_PI * (along * from_dipole[k] - moment[k]) / cubed)
}
