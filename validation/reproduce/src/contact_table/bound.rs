//! What errors of a given size allow.

use super::chain::{NOISE, RATE, SPEED, STEP};
use vibrissa::beam::{Load, Whisker, point_mode};
use vibrissa::plane::Vec2;

/// Standard deviation of the instant of touch (m): between two rows, or lost in the noise a little before; and of a
/// stage's position.
const TOUCH_STD: f64 = 14e-6;

/// The bound of Cramér and Rao on the relative standard deviation of a peg's distance (m), for normal errors of the variance
/// of uniform ones: place across, and a gain within ±`gain`, are unknowns beside it.
#[must_use]
pub fn bound(distance: f64, steps: usize, gain: f64) -> f64 {
    let whisker = Whisker::default();
    let moment = |x: f64, y: f64| {
        let bends = point_mode(&whisker, Vec2::new(x, y), Load::Normal).unwrap_or_default();
        bends.first().map_or(0.0, |bend| bend.moment)
    };
    let mut f = [[0.0; 3]; 3];
    f[1][1] = 1.0 / (TOUCH_STD * TOUCH_STD);
    f[2][2] = 3.0 / (gain * gain).max(1e-16);
    for i in 1..=(steps as f64 * STEP / SPEED * RATE).round() as usize {
        let (y, h) = (SPEED / RATE * i as f64, 1e-7);
        let m = moment(distance, y);
        let std = (NOISE.moment_relative * m + NOISE.moment_absolute) / 3f64.sqrt();
        let by_x = (moment(distance + h, y) - moment(distance - h, y)) / (2.0 * h);
        let by_y = (moment(distance, y + h) - moment(distance, y - h)) / (2.0 * h);
        let row = [by_x / std, by_y / std, m / std];
        (0..3).for_each(|a| (0..3).for_each(|b| f[a][b] += row[a] * row[b]));
    }
    // The first entry of the inverse, by its Schur complement.
    let det = f[1][1] * f[2][2] - f[1][2] * f[1][2];
    let (b, c) = (f[0][1], f[0][2]);
    let rest = f[0][0] - (b * (f[2][2] * b - f[1][2] * c) + c * (f[1][1] * c - f[1][2] * b)) / det;
    1.0 / rest.sqrt() / distance
}

/// The chance that normal errors of these standard deviations, `seeds` of each, on top of a common offset that is uniform
/// within ±`offset`, are all below `limit`; each trial has an offset of its own.
#[must_use]
pub fn chance_of_all_below(limit: f64, stds: &[f64], offset: f64, seeds: u64) -> f64 {
    let one = |std: f64| {
        let below = |k: i32| {
            let by = offset * f64::from(k) / 50.0;
            0.5 * (within((limit - by) / std) + within((limit + by) / std))
        };
        (-50..=50).map(below).sum::<f64>() / 101.0
    };
    stds.iter().map(|std| one(*std).powi(seeds as i32)).product()
}

/// The share of a normal law within `x` standard deviations, by Simpson's rule.
fn within(x: f64) -> f64 {
    let (n, density) = (400, |u: f64| (-0.5 * u * u).exp() * (2.0 / core::f64::consts::PI).sqrt());
    let h = x / f64::from(n);
    let weight = |k: i32| if k == 0 || k == n { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
    (0..=n).map(|k| weight(k) * density(h * f64::from(k))).sum::<f64>() * h / 3.0
}
