//! The sensing chain against physics and data sheets: the field as the gradient of a potential, known values on the
//! axes, published sensitivities and conversion times, bits counted by hand.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

#[path = "../../vibrissa/tests/data/random.rs"]
mod random;

use random::Random;
use vibrissa_beam::sensing::{Chip, Mlx90393, SensingChain, Tle493d, Vec3, dipole_field};

/// The scalar potential of a dipole times the vacuum permeability (T m).
fn potential(m: Vec3, r: Vec3) -> f64 {
    let squared: f64 = r.iter().map(|v| v * v).sum();
    1e-7 * (m[0] * r[0] + m[1] * r[1] + m[2] * r[2]) / squared.powf(1.5)
}

#[test]
fn the_field_is_minus_the_gradient_of_the_potential() {
    let mut random = Random(3);
    for _ in 0..500 {
        let m = [0; 3].map(|_| random.signed(0.05));
        let r = [0; 3].map(|_| random.sign() * random.between(0.002, 0.02));
        let field = dipole_field(m, r);
        let size = field.iter().map(|b| b * b).sum::<f64>().sqrt();
        let h = 1e-6;
        for k in 0..3 {
            let moved = |by: f64| {
                let mut p = r;
                p[k] += by;
                potential(m, p)
            };
            let slope = (8.0 * (moved(h) - moved(-h)) - (moved(2.0 * h) - moved(-2.0 * h))) / (12.0 * h);
            assert!((field[k] + slope).abs() < 1e-7 * size + 1e-14, "{} and {}", field[k], -slope);
        }
    }
}

#[test]
fn the_field_on_the_axes_is_the_textbooks() {
    // 1 A m² at 0.1 m: 0.2 mT along the axis, 0.1 mT the other way beside it.
    let m = [0.0, 0.0, 1.0];
    assert!((dipole_field(m, [0.0, 0.0, 0.1])[2] - 2e-4).abs() < 1e-18);
    assert!((dipole_field(m, [0.0, 0.0, -0.1])[2] - 2e-4).abs() < 1e-18);
    assert!((dipole_field(m, [0.1, 0.0, 0.0])[2] + 1e-4).abs() < 1e-18);
    assert!(dipole_field(m, [0.1, 0.0, 0.0])[0].abs() < 1e-18);
}

#[test]
fn a_push_tilts_the_field_the_way_the_magnet_goes() {
    let chain = SensingChain::default();
    let rest = chain.flux(0.0);
    // 2e-7 * 3.6e-3 / 0.005³ along the whisker, the chip's third axis, and nothing across.
    assert!((rest[2] - 5.76e-3).abs() < 1e-9 && rest[0].abs() < 1e-15 && rest[1].abs() < 1e-15, "{rest:?}");
    // To first order a turn by a shifts the magnet by -3 mm a, so that the chip lies r = (-5 mm, 3 mm a) from it, and
    // tilts its moment to m (1, a). Across that is 1e-7 (3 (m·r) r_y / r⁵ - m_y / r³) = -1e-7 m a (3 · 3/5 + 1) / r³.
    let a = chain.rotation(1e-5);
    let expected = 1e-7 * 3.6e-3 * (-3.0 * 3.0 / 5.0 - 1.0) * a / 0.005f64.powi(3);
    let exact = chain.flux(1e-5)[1];
    assert!((exact - expected).abs() < 1e-4 * expected.abs(), "{exact} and {expected}");
    let (left, right) = (chain.flux(2e-3), chain.flux(-2e-3));
    assert!((left[1] + right[1]).abs() < 1e-15 && (left[2] - right[2]).abs() < 1e-15, "odd across, even along");
    assert!(left[0].abs() < 1e-15, "the magnet stays in its plane");
}

/// The MLX90393 data sheet's sensitivities (µT a count) for HALLCONF 0xC, by gain and resolution: across, along.
const SENSITIVITY: [[(f64, f64); 4]; 8] = [
    [(0.751, 1.210), (1.502, 2.420), (3.004, 4.840), (6.009, 9.680)],
    [(0.601, 0.968), (1.202, 1.936), (2.403, 3.872), (4.807, 7.744)],
    [(0.451, 0.726), (0.901, 1.452), (1.803, 2.904), (3.605, 5.808)],
    [(0.376, 0.605), (0.751, 1.210), (1.502, 2.420), (3.004, 4.840)],
    [(0.300, 0.484), (0.601, 0.968), (1.202, 1.936), (2.403, 3.872)],
    [(0.250, 0.403), (0.501, 0.807), (1.001, 1.613), (2.003, 3.227)],
    [(0.200, 0.323), (0.401, 0.645), (0.801, 1.291), (1.602, 2.581)],
    [(0.150, 0.242), (0.300, 0.484), (0.601, 0.968), (1.202, 1.936)],
];

/// The data sheet's time for all three axes and the temperature (ms), by filter and oversampling.
const CONVERSION: [[f64; 4]; 8] = [
    [1.27, 1.84, 3.00, 5.30],
    [1.46, 2.23, 3.76, 6.84],
    [1.84, 3.00, 5.30, 9.91],
    [2.61, 4.53, 8.37, 16.05],
    [4.15, 7.60, 14.52, 28.34],
    [7.22, 13.75, 26.80, 52.92],
    [13.36, 26.04, 51.38, 102.07],
    [25.65, 50.61, 100.53, 200.37],
];

#[test]
fn sensitivities_and_times_are_the_data_sheets() {
    for (gain, row) in (0u8..).zip(SENSITIVITY) {
        for (resolution, (across, along)) in (0u8..).zip(row) {
            let [x, y, z] = Chip::Mlx90393(Mlx90393 { gain, resolution, ..Mlx90393::default() }).per_count();
            for (found, told) in [(x, across), (y, across), (z, along)] {
                assert!(
                    (found * 1e6 - told).abs() < 0.0008,
                    "gain {gain}, resolution {resolution}: {found} and {told}"
                );
            }
        }
    }
    for (filter, row) in (0u8..).zip(CONVERSION) {
        for (oversampling, told) in (0u8..).zip(row) {
            let chip = Chip::Mlx90393(Mlx90393 { filter, oversampling, ..Mlx90393::default() });
            let found = chip.conversion_time().unwrap() * 1e3;
            assert!(
                (found - told).abs() < 0.006,
                "filter {filter}, oversampling {oversampling}: {found} and {told} ms"
            );
        }
    }
}

#[test]
fn the_mlx_wraps_at_16_bits_and_saturates_before_19() {
    let chip = |resolution| Chip::Mlx90393(Mlx90393 { gain: 7, resolution, ..Mlx90393::default() });
    let per = 0.150_22e-6;
    let x = |resolution, adc: f64| chip(resolution).counts([adc * per, 0.0, 0.0])[0];
    assert_eq!([x(0, 32767.0), x(0, 32768.0), x(0, 40000.0)], [32767, -32768, 40000 - 65536]);
    assert_eq!([x(0, -32768.0), x(0, -32769.0)], [-32768, 32767]);
    assert_eq!([x(1, 65534.0), x(1, 65536.0), x(1, 3.0), x(1, -3.0)], [32767, -32768, 1, -2], "low bits are cut off");
    assert_eq!([x(2, 0.0), x(2, 4000.0), x(2, 1e6), x(2, -1e6)], [32768, 33768, 54768, 10768]);
    assert_eq!([x(3, 0.0), x(3, 8000.0), x(3, 1e6), x(3, -1e6)], [16384, 17384, 27384, 5384]);
    let mut random = Random(8);
    for resolution in 0..4 {
        let (chip, range) = (chip(resolution), chip(resolution).range());
        for _ in 0..200 {
            let flux = range.map(|r| random.signed(r));
            let back = chip.flux(chip.counts(flux));
            for k in 0..3 {
                assert!((back[k] - flux[k]).abs() <= chip.per_count()[k], "{} and {}", back[k], flux[k]);
            }
        }
    }
}

#[test]
fn the_tle_has_12_bits() {
    let full = Chip::Tle493d(Tle493d::default());
    let short = Chip::Tle493d(Tle493d { short_range: true });
    // 7.7 and 15.4 counts a mT.
    assert_eq!(full.counts([0.160, -0.160, 0.0]), [1232, -1232, 0]);
    assert_eq!(short.counts([0.100, -0.0500, 0.0]), [1540, -770, 0]);
    assert_eq!(full.counts([1.0, -1.0, 0.0]), [2047, -2048, 0]);
    assert!((full.range()[0] - 0.160).abs() < 1e-15);
    assert!((full.flux([77, 0, 0])[0] - 0.010).abs() < 1e-15);
}
