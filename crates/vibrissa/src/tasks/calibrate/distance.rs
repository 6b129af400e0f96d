//! From slopes at known distances to the constants of the shaft.

use crate::beam::{Whisker, deflection_per_force};
use crate::least_squares::covariance as covariance_of;
use crate::linear_algebra::Cholesky;
use crate::world::calibration::{DistanceModel, Motion};
use crate::{Error, Result};

/// The slopes measured at one distance.
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceSet {
    /// The file that they came from, for messages.
    pub source: String,
    /// True radial distance (m) and slope of each contact.
    pub samples: Vec<(f64, f64)>,
}

/// What is known of the shaft before the fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shaft {
    /// How the base moves.
    pub motion: Motion,
    /// Length from base to tip (m).
    pub length: f64,
    /// Tip radius over base radius; fitted when not given.
    pub tip_ratio: Option<f64>,
    /// Whether the base is clamped; otherwise its compliance is fitted.
    pub clamped: bool,
}

/// A fit of [`DistanceModel`].
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceFit {
    /// The fitted model.
    pub model: DistanceModel,
    /// The constants that were fitted, in the order of the covariance: `ln_gain`, `base_compliance`, `tip_ratio`.
    pub free: Vec<&'static str>,
    /// Their covariance, from how far the medians of the sets lie from the model; empty when nothing is left to tell it.
    pub covariance: Vec<Vec<f64>>,
}

/// A contact whose distance was found by a model that was fitted without its set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeftOut {
    /// The index of its set.
    pub set: usize,
    /// True distance (m).
    pub truth: f64,
    /// Distance found (m); none where the slope fits no distance on the shaft.
    pub found: Option<f64>,
}

/// Fits the shaft to the median slope of each set, all sets with the same relative weight.
///
/// With the compliance `C(D)` of the shaft, `1 / slope = (C(D) + b D²) / (gain D²)` for a turn (`D` for a travel): linear in
/// `1 / gain` and `b / gain`, and the taper is searched for where it is free.
///
/// # Errors
///
/// Data: fewer sets than free constants, a slope of zero, slopes that do not fall with distance. Usage: a distance off
/// the shaft.
pub fn fit_distance(sets: &[DistanceSet], shaft: Shaft) -> Result<DistanceFit> {
    let medians = medians(sets)?;
    let free = free(shaft);
    if medians.len() < free.len() {
        return Err(Error::data("too few known distances")
            .value(medians.len())
            .allowed(format!("{} or more: {} are fitted", free.len(), free.join(", ")))
            .remedy("record contacts at more distances, or give --tip-ratio"));
    }
    let best = match shaft.tip_ratio {
        Some(tip_ratio) => solve(&medians, shaft, tip_ratio)?,
        None => search(&medians, shaft)?,
    };
    let (mut model, _) = best;
    model.scatter = scatter(&model, sets, free.len())?;
    model.check()?;
    let covariance = covariance(&model, &medians, &free);
    Ok(DistanceFit { model, free, covariance })
}

/// Each contact's distance by a model fitted to all other sets; empty when there are too few.
///
/// # Errors
///
/// As [`fit_distance`].
pub fn leave_one_out(sets: &[DistanceSet], shaft: Shaft) -> Result<Vec<LeftOut>> {
    let mut answers = Vec::new();
    if sets.len() <= free(shaft).len() {
        return Ok(answers);
    }
    for (index, set) in sets.iter().enumerate() {
        let others: Vec<DistanceSet> =
            sets.iter().enumerate().filter(|(i, _)| *i != index).map(|(_, set)| set.clone()).collect();
        let model = fit_distance(&others, shaft)?.model;
        let found = |slope| model.distance(slope).map(|d| d.distance);
        answers.extend(set.samples.iter().map(|&(truth, slope)| LeftOut { set: index, truth, found: found(slope) }));
    }
    Ok(answers)
}

fn free(shaft: Shaft) -> Vec<&'static str> {
    let mut free = vec!["ln_gain"];
    if !shaft.clamped {
        free.push("base_compliance");
    }
    if shaft.tip_ratio.is_none() {
        free.push("tip_ratio");
    }
    free
}

/// Mean distance and median slope of each set.
fn medians(sets: &[DistanceSet]) -> Result<Vec<(f64, f64)>> {
    let one = |set: &DistanceSet| {
        let mut slopes: Vec<f64> = set.samples.iter().map(|s| s.1.abs()).collect();
        slopes.sort_by(f64::total_cmp);
        let (Some(low), Some(high)) = (slopes.get((slopes.len().max(1) - 1) / 2), slopes.get(slopes.len() / 2)) else {
            return Err(Error::data("no contact was found in the recording").in_file(&set.source).remedy(
                "check --format and --channel; a tap stands out from the noise and has 0.2 s of rest before it",
            ));
        };
        let slope = 0.5 * (low + high);
        if slope.is_nan() || slope <= 0.0 {
            return Err(Error::data("the reading does not change with the contact").in_file(&set.source));
        }
        Ok((set.samples.iter().map(|s| s.0).sum::<f64>() / set.samples.len() as f64, slope))
    };
    sets.iter().map(one).collect()
}

/// The model for a given taper, and its sum of squared relative errors.
fn solve(medians: &[(f64, f64)], shaft: Shaft, tip_ratio: f64) -> Result<(DistanceModel, f64)> {
    let clamped = Whisker { length: shaft.length, flexural_rigidity: 1.0, tip_ratio, ..Whisker::default() };
    let mut rows = Vec::with_capacity(medians.len());
    for &(distance, slope) in medians {
        let lever = match shaft.motion {
            Motion::Turn => distance * distance,
            Motion::Travel => distance,
        };
        let compliance = deflection_per_force(&clamped, distance)?;
        rows.push([slope * compliance / lever, slope * distance * distance / lever]);
    }
    let sum = |f: &dyn Fn(&[f64; 2]) -> f64| rows.iter().map(f).sum::<f64>();
    let (aa, ab, bb) = (sum(&|r| r[0] * r[0]), sum(&|r| r[0] * r[1]), sum(&|r| r[1] * r[1]));
    let (a, b) = (sum(&|r| r[0]), sum(&|r| r[1]));
    let free = Cholesky::regular(&[[aa, ab], [ab, bb]]).filter(|_| !shaft.clamped).map(|normal| normal.solve(&[a, b]));
    // A base cannot be stiffer than clamped.
    let solution = free.filter(|solution| solution[1] >= 0.0).unwrap_or([a / aa, 0.0]);
    if solution[0].is_nan() || solution[0] <= 0.0 {
        return Err(Error::data("the slopes do not fall with distance as those of a shaft do")
            .remedy("check the distances, and that each is from the base"));
    }
    let cost = rows.iter().map(|r| (r[0] * solution[0] + r[1] * solution[1] - 1.0).powi(2)).sum();
    let distances = medians.iter().map(|m| m.0);
    let model = DistanceModel {
        motion: shaft.motion,
        gain: 1.0 / solution[0],
        length: shaft.length,
        tip_ratio,
        base_compliance: solution[1] / solution[0],
        scatter: 0.0,
        fitted: [distances.clone().fold(f64::INFINITY, f64::min), distances.fold(0.0, f64::max)],
    };
    Ok((model, cost))
}

/// The best taper: a grid, then golden sections around its best point.
fn search(medians: &[(f64, f64)], shaft: Shaft) -> Result<(DistanceModel, f64)> {
    const GRID: usize = 60;
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let (first, last) = (0.02, 1.0);
    let ratio = |i: usize| first + (last - first) * i as f64 / GRID as f64;
    let cost = |tip_ratio: f64| solve(medians, shaft, tip_ratio).map_or(f64::INFINITY, |(_, cost)| cost);
    let best = (0..=GRID).min_by(|&a, &b| cost(ratio(a)).total_cmp(&cost(ratio(b)))).unwrap_or(GRID);
    let (mut lo, mut hi) = (ratio(best.saturating_sub(1)), ratio((best + 1).min(GRID)));
    for _ in 0..60 {
        let (left, right) = (hi - GOLDEN * (hi - lo), lo + GOLDEN * (hi - lo));
        if cost(left) < cost(right) { hi = right } else { lo = left }
    }
    let inner = 0.5 * (lo + hi);
    let tip_ratio = if cost(inner) <= cost(ratio(best)) { inner } else { ratio(best) };
    solve(medians, shaft, tip_ratio)
}

/// Root mean square of the relative errors of all contacts.
fn scatter(model: &DistanceModel, sets: &[DistanceSet], free: usize) -> Result<f64> {
    let (mut sum, mut count) = (0.0, 0);
    for &(distance, slope) in sets.iter().flat_map(|set| &set.samples) {
        sum += (slope.abs() / model.slope(distance)?).ln().powi(2);
        count += 1;
    }
    Ok((sum / (count.max(free + 1) - free) as f64).sqrt())
}

/// Covariance of the free constants from the medians' scatter about the model.
fn covariance(model: &DistanceModel, medians: &[(f64, f64)], free: &[&'static str]) -> Vec<Vec<f64>> {
    let spare = medians.len() - free.len();
    if spare == 0 {
        return Vec::new();
    }
    let moved = |name: &str, step: f64| {
        let mut model = *model;
        match name {
            "ln_gain" => model.gain *= step.exp(),
            "base_compliance" => model.base_compliance = (model.base_compliance + step).max(0.0),
            _ => model.tip_ratio = (model.tip_ratio + step).clamp(1e-3, 1.0),
        }
        model
    };
    let log = |model: &DistanceModel, distance: f64| model.slope(distance).unwrap_or(f64::NAN).ln();
    let derivative = |name: &str, distance: f64| {
        let (up, down) = (moved(name, 1e-6), moved(name, -1e-6));
        let width =
            (up.gain / down.gain).ln() + (up.base_compliance - down.base_compliance) + (up.tip_ratio - down.tip_ratio);
        (log(&up, distance) - log(&down, distance)) / width
    };
    let jacobian: Vec<Vec<f64>> =
        medians.iter().map(|(distance, _)| free.iter().map(|name| derivative(name, *distance)).collect()).collect();
    let residual: f64 = medians.iter().map(|(distance, slope)| (slope.ln() - log(model, *distance)).powi(2)).sum();
    covariance_of(&jacobian, residual / spare as f64)
}
