//! Where a contact sheet ends along the loads, and what its chart is made of.
use super::bicubic::powers;
use crate::beam::rod::Rod;
use crate::math;
use alloc::vec::Vec;

/// Ends of the panels along the whisker, as shares of its length: a base that turns changes everything on a short way.
const BREAKS: [f64; 9] = [0.001, 0.004, 0.016, 0.064, 0.2, 0.4, 0.6, 0.8, 1.0];
/// A panel over which the compliance changes more than this is halved, down to this share of the length.
const MOST_CHANGE: f64 = 16.0;
const NARROWEST: f64 = 0.02;
/// Loads that are tried for the end of the first mode, on one side.
const TRIED: usize = 48;

/// Where along the loads a sheet ends, by the place: a cubic over each panel, once continuously differentiable.
pub(super) struct LoadEnd {
    pub(super) breaks: Vec<f64>,
    values: Vec<f64>,
}

impl LoadEnd {
    /// The panels, broken at joints and where the rod becomes thin, with ends as far as there are first-mode shapes from rest on.
    pub(super) fn new(rod: &Rod, tilt: f64, most: f64) -> Option<Self> {
        let (length, step) = (rod.length(), most / TRIED as f64);
        let last = |u: f64| {
            let (s, gain) = (u * length, gain(rod, u * length));
            let inside = |v: f64| rod.keeps_one_sign(force(gain, s, v), s, tilt);
            let side = |sign: f64| (1..=TRIED).take_while(|k| inside(sign * *k as f64 * step)).last().unwrap_or(0);
            // Where the step was too long, one more holds it.
            (side(1.0).max(side(-1.0)) + 1) as f64 * step
        };
        let breaks = panels(rod);
        let mut ends = Self { values: breaks.iter().map(|u| last(*u)).collect(), breaks };
        for _ in 0..3 {
            for k in 0..ends.values.len() - 1 {
                for share in [0.25, 0.5, 0.75] {
                    let u = ends.breaks[k] + share * (ends.breaks[k + 1] - ends.breaks[k]);
                    let missing = (last(u) - ends.at(u)[0]).max(0.0);
                    ends.values[k] += missing;
                    ends.values[k + 1] += missing;
                }
            }
        }
        ends.values.iter().all(|v| v.is_finite() && *v > step).then_some(ends)
    }

    /// The end and its derivative by `u`. Between breaks it neither rises beyond both nor falls below.
    pub(super) fn at(&self, u: f64) -> [f64; 2] {
        let k = self.breaks.partition_point(|b| *b <= u).clamp(1, self.breaks.len() - 1) - 1;
        let width = self.breaks[k + 1] - self.breaks[k];
        let [[a, da], [b, db]] = [k, k + 1].map(|k| [self.values[k], self.slope(k) * width]);
        let ([c0, c1, c2, c3], x) = (powers([a, da, b, db]), (u - self.breaks[k]) / width);
        [c0 + x * (c1 + x * (c2 + x * c3)), (c1 + x * (2.0 * c2 + x * 3.0 * c3)) / width]
    }

    /// The slope at a break: none at the ends and where the values turn, else the harmonic mean of both sides'.
    fn slope(&self, k: usize) -> f64 {
        if k == 0 || k + 1 == self.breaks.len() {
            return 0.0;
        }
        let side = |k: usize| (self.values[k + 1] - self.values[k]) / (self.breaks[k + 1] - self.breaks[k]);
        let (a, b) = (side(k - 1), side(k));
        if a * b > 0.0 { 2.0 * a * b / (a + b) } else { 0.0 }
    }
}

/// The ends of the panels along a rod, as shares of its length.
fn panels(rod: &Rod) -> Vec<f64> {
    let length = rod.length();
    let mut breaks = BREAKS.to_vec();
    for joint in rod.joints().map(|s| s / length).filter(|u| *u > BREAKS[0] && *u < 1.0) {
        breaks.retain(|u| *u <= BREAKS[0] || *u >= 1.0 || (u - joint).abs() > NARROWEST);
        breaks.push(joint);
    }
    breaks.sort_by(f64::total_cmp);
    let mut i = 0;
    while i + 1 < breaks.len() {
        let (a, b) = (breaks[i], breaks[i + 1]);
        let inside = [a + 1e-6 * (b - a), b - 1e-6 * (b - a)].map(|u| rod.compliance(u * length));
        if inside[1] > MOST_CHANGE * inside[0] && b - a > NARROWEST {
            breaks.insert(i + 1, 0.5 * (a + b));
        } else {
            i += 1;
        }
    }
    breaks
}

/// The force (N) at a place along the loads.
#[inline(always)]
pub(super) fn force(gain: f64, s: f64, v: f64) -> f64 {
    // The difference of the two exponentials is known to one unit in the last place of one, which is what a load counts by.
    let grown = math::exp(v);
    0.25 * (grown * grown - 1.0) / (grown * gain * s)
}

pub(super) fn gain(rod: &Rod, s: f64) -> f64 {
    rod.slope_compliance(s) / s
}

/// The gain at a share of the length, and its derivative by that share.
pub(super) fn gain_and_rate(rod: &Rod, u: f64) -> [f64; 2] {
    // Smooth but for jumps of the second derivative at joints: before these and at the tip from one side.
    let (length, h) = (rod.length(), 2e-3 * u);
    let at = |k: f64| gain(rod, (u + k * h) * length);
    let mut joints = rod.joints().map(|s| s / length);
    let beyond = u + 2.0 * h > 1.0 || joints.any(|joint| joint >= u - 1e-9 && joint < u + 2.0 * h);
    let rate = if beyond {
        (25.0 * at(0.0) - 48.0 * at(-1.0) + 36.0 * at(-2.0) - 16.0 * at(-3.0) + 3.0 * at(-4.0)) / (12.0 * h)
    } else {
        (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * h)
    };
    [at(0.0), rate]
}
