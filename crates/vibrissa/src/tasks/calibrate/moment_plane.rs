//! From raw readings to the moments about both transverse axes.

use super::labelled::{Explained, Labelled};
use super::scatter::{Scatter, by_labels, hysteresis, is_as_good, parts, rms};
use crate::config::CurveOptions;
use crate::least_squares::linear;
use crate::sensing::{SURFACE_TERMS, excursion, surface_terms};
use crate::world::calibration::MomentPlane;
use crate::{Error, Result};
use core::f64::consts::TAU;
use vibrissa_core::math;

/// How many products of two signals there are up to each degree.
const TERMS: [usize; 3] = [3, 6, SURFACE_TERMS];
/// Widest gap between the directions of strong contacts (rad): eight directions, evenly apart, leave 45°. Fewer would not tell the third
/// degree from nothing.
const WIDEST_GAP: f64 = 50.0 / 360.0 * TAU;
/// Contacts of at least this share of the strongest tell a direction.
const STRONG: f64 = 0.4;
/// Readings whose slopes by both moments are nearer to one line than this tell only one of them (sine of the angle between).
const LEAST_SINE: f64 = 1e-2;

/// One labelled contact on its way to a surface: signals from -1 to 1, and moments (N m), in the order of recording.
#[derive(Clone, Copy, Debug)]
struct Pair {
    signals: [f64; 2],
    moments: [f64; 2],
}

impl Pair {
    fn size(&self) -> f64 {
        math::hypot(self.moments[0], self.moments[1])
    }
}

/// The coefficients of both moments.
type Surfaces = [[f64; SURFACE_TERMS]; 2];

/// Fits the moments about both transverse axes as polynomials of two signals, up to the third degree with all products.
///
/// Straight lines of all readings by both moments tell how a contact moves the readings; the signals undo that, so that the cross-talk of axes
/// that stand askew is gone to first order and the polynomials hold what is bent. Scatter, labels and the choice of the degree are as in
/// [`fit_moment_curve`](super::fit_moment_curve), with one degree for both moments; a surface that folds within the calibrated range is none.
///
/// # Errors
///
/// Data: fewer than two raw readings, fewer contacts than twice [`CurveOptions::fewest_contacts`], strong contacts that leave more than 50°
/// about the axis without any, readings that do not tell the moments apart.
pub fn fit_moment_plane(labelled: &Labelled, explained: &[Explained], options: &CurveOptions) -> Result<MomentPlane> {
    let fault = |what: &str| Error::data(what.to_owned()).in_file(&labelled.source);
    if labelled.inputs.len() < 2 {
        return Err(fault("one reading does not tell two moments")
            .value(labelled.inputs.join(","))
            .allowed("two or more of bx,by,bz (T) or ax,ay,az (counts)")
            .remedy("for a calibration in the x-y plane leave out the column z, and contacts out of this plane"));
    }
    let fewest = 2 * options.fewest_contacts;
    if explained.len() < fewest {
        return Err(fault("too few contacts that the whisker can reach")
            .value(explained.len())
            .allowed(format!("{fewest} or more; 1000 represent a sensor well"))
            .remedy("check that x,y,z are in m in the whisker frame, and the whisker's length"));
    }
    let gap = widest_gap(explained);
    if gap > WIDEST_GAP {
        return Err(fault("the strong contacts do not lie all around the whisker's axis")
            .value(format!("a gap of {:.0} deg", gap * 360.0 / TAU))
            .allowed("50 deg or less")
            .remedy("press from eight directions or more, 45 deg apart"));
    }
    let (rest, directions) = directions(labelled, explained).ok_or_else(|| {
        fault("the readings do not tell the two moments apart")
            .value(labelled.inputs.join(","))
            .remedy("add the chip's third column, and check the columns' order and units")
    })?;
    let raw = |e: &Explained| [0, 1].map(|k| excursion(&labelled.readings[e.row], &rest, &directions[k]));
    let raw: Vec<[f64; 2]> = explained.iter().map(raw).collect();
    let ranges = [0, 1].map(|k| {
        let (lo, hi) = raw.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), s| (lo.min(s[k]), hi.max(s[k])));
        [0.5 * (lo + hi), 0.5 * (hi - lo)]
    });
    let pair = |(e, raw): (&Explained, &[f64; 2])| Pair {
        signals: [0, 1].map(|k| (raw[k] - ranges[k][0]) / ranges[k][1]),
        moments: [e.moment, e.across],
    };
    let pairs: Vec<Pair> = explained.iter().zip(&raw).map(pair).collect();
    let reach = pairs.iter().map(|p| math::hypot(p.signals[0], p.signals[1])).fold(0.0, f64::max);
    let sizes: Vec<f64> = pairs.iter().map(Pair::size).collect();
    let fit = |scatter: &Scatter| chosen(&pairs, reach, scatter);
    // The first fit tells how readings scatter, the second one heeds it.
    let one_of_two = |errors: &[f64; 2]| math::hypot(errors[0], errors[1]) * core::f64::consts::FRAC_1_SQRT_2;
    let first = fit(&Scatter::EVEN).map(|(surfaces, _)| residuals(&pairs, &surfaces));
    let scatter = first
        .map_or(Scatter::EVEN, |residuals| Scatter::of(&sizes, &residuals.iter().map(one_of_two).collect::<Vec<_>>()));
    let Some((coefficients, errors)) = fit(&scatter) else {
        return Err(fault("no surface without a fold fits the readings"));
    };
    let residuals = residuals(&pairs, &coefficients);
    let radial = |(pair, r): (&Pair, &[f64; 2])| {
        let size = pair.size();
        if size > 0.0 { (r[0] * pair.moments[0] + r[1] * pair.moments[1]) / size } else { 0.0 }
    };
    let radial: Vec<f64> = pairs.iter().zip(&residuals).map(radial).collect();
    Ok(MomentPlane {
        inputs: labelled.inputs.clone(),
        rest,
        directions,
        ranges,
        reach,
        coefficients,
        residual_rms: [0, 1].map(|k| rms(&residuals.iter().map(|r| r[k]).collect::<Vec<_>>())),
        hysteresis: hysteresis(&sizes, &radial),
        bound: [0, 1].map(|k| errors.iter().fold(0.0, |most, e| e[k].abs().max(most))),
        samples: pairs.len(),
    })
}

/// The widest angle about the axis in which no strong contact lies (rad).
fn widest_gap(explained: &[Explained]) -> f64 {
    let strongest = explained.iter().map(Explained::size).fold(0.0, f64::max);
    let strong = explained.iter().filter(|e| e.size() >= STRONG * strongest && e.size() > 0.0);
    let mut angles: Vec<f64> = strong.map(|e| math::atan2(e.across, e.moment)).collect();
    angles.sort_by(f64::total_cmp);
    let (Some(first), Some(last)) = (angles.first(), angles.last()) else { return TAU };
    let around = first + TAU - last;
    angles.windows(2).map(|pair| pair[1] - pair[0]).fold(around, f64::max)
}

/// Readings at zero moment, and the sums of readings that are the moments to first order.
fn directions(labelled: &Labelled, explained: &[Explained]) -> Option<(Vec<f64>, [Vec<f64>; 2])> {
    let scale = explained.iter().map(Explained::size).fold(0.0, f64::max);
    let rows: Vec<Vec<f64>> = explained.iter().map(|e| vec![1.0, e.moment / scale, e.across / scale]).collect();
    let fit = |input: usize| {
        let targets: Vec<f64> = explained.iter().map(|e| labelled.readings[e.row][input]).collect();
        linear(&rows, &targets)
    };
    let lines: Vec<Vec<f64>> = (0..labelled.inputs.len()).map(fit).collect::<Option<_>>()?;
    let product = |i: usize, j: usize| lines.iter().map(|line| line[i] * line[j]).sum::<f64>();
    let (aa, ab, bb) = (product(1, 1), product(1, 2), product(2, 2));
    let determinant = aa * bb - ab * ab;
    if !(determinant.is_finite() && determinant > LEAST_SINE * LEAST_SINE * aa * bb) {
        return None;
    }
    // The pseudo-inverse of the slopes.
    let sum = |a: f64, b: f64| lines.iter().map(|line| scale * (a * line[1] + b * line[2]) / determinant).collect();
    Some((lines.iter().map(|line| line[0]).collect(), [sum(bb, -ab), sum(-ab, aa)]))
}

/// The surfaces of the least degree that will do, and their errors on rows left out.
fn chosen(pairs: &[Pair], reach: f64, scatter: &Scatter) -> Option<(Surfaces, Vec<[f64; 2]>)> {
    let tried: Vec<(Surfaces, Vec<[f64; 2]>)> = TERMS
        .into_iter()
        .filter_map(|terms| Some((surfaces(pairs, scatter, terms)?, left_out(pairs, scatter, terms)?)))
        .filter(|(surfaces, _)| !folds(surfaces, reach))
        .collect();
    let square = |(pair, e): (&Pair, &[f64; 2])| (e[0] * e[0] + e[1] * e[1]) / scatter.variance(pair.size());
    let squares: Vec<Vec<f64>> =
        tried.iter().map(|(_, errors)| pairs.iter().zip(errors).map(square).collect()).collect();
    let best = squares.iter().min_by(|a, b| a.iter().sum::<f64>().total_cmp(&b.iter().sum()))?;
    let chosen = squares.iter().position(|own| is_as_good(own, best))?;
    tried.into_iter().nth(chosen)
}

/// Both surfaces of so many terms, each pair weighed by its scatter.
fn surfaces(pairs: &[Pair], scatter: &Scatter, terms: usize) -> Option<Surfaces> {
    let weights: Vec<f64> = pairs.iter().map(|p| 1.0 / scatter.std(p.size())).collect();
    let scale = pairs.iter().map(Pair::size).fold(0.0, f64::max);
    let of = |z: [f64; 2]| surface_terms(z)[..terms].to_vec();
    let labels: Vec<Vec<f64>> = pairs.iter().map(|p| of(p.moments.map(|m| m / scale))).collect();
    let readings: Vec<Vec<f64>> = pairs.iter().map(|p| of(p.signals)).collect();
    let mut surfaces = [[0.0; SURFACE_TERMS]; 2];
    for (k, coefficients) in surfaces.iter_mut().enumerate() {
        let targets: Vec<f64> = pairs.iter().map(|p| p.moments[k]).collect();
        let fitted = by_labels(&labels, &readings, &targets, &weights)?;
        coefficients.iter_mut().zip(fitted).for_each(|(place, value)| *place = value);
    }
    Some(surfaces)
}

fn residuals(pairs: &[Pair], surfaces: &Surfaces) -> Vec<[f64; 2]> {
    let of = |p: &Pair| [0, 1].map(|k| p.moments[k] - crate::sensing::surface(&surfaces[k], p.signals));
    pairs.iter().map(of).collect()
}

/// Errors of all rows, each by surfaces without its block and every tenth of the others.
fn left_out(pairs: &[Pair], scatter: &Scatter, terms: usize) -> Option<Vec<[f64; 2]>> {
    let mut errors = vec![[0.0; 2]; pairs.len()];
    for (out, others) in parts(pairs.len()) {
        let others: Vec<Pair> = others.into_iter().map(|row| pairs[row]).collect();
        let fitted = surfaces(&others, scatter, terms)?;
        let left: Vec<Pair> = out.iter().map(|&row| pairs[row]).collect();
        for (row, error) in out.into_iter().zip(residuals(&left, &fitted)) {
            errors[row] = error;
        }
    }
    Some(errors)
}

/// Whether two signals within reach may mean the same moments: the surfaces turn over somewhere.
fn folds(surfaces: &Surfaces, reach: f64) -> bool {
    let steps = 24;
    let at = |k: i32| reach * f64::from(k) / f64::from(steps);
    let inside = |u: f64, v: f64| math::hypot(u, v) <= reach && u.abs() <= 1.0 && v.abs() <= 1.0;
    let turned = |u: f64, v: f64| {
        let slope = |c: &[f64; SURFACE_TERMS]| {
            let by_u = c[1] + 2.0 * c[3] * u + c[4] * v + 3.0 * c[6] * u * u + 2.0 * c[7] * u * v + c[8] * v * v;
            let by_v = c[2] + c[4] * u + 2.0 * c[5] * v + c[7] * u * u + 2.0 * c[8] * u * v + 3.0 * c[9] * v * v;
            [by_u, by_v]
        };
        let [a, b] = [slope(&surfaces[0]), slope(&surfaces[1])];
        a[0] * b[1] - a[1] * b[0] <= 0.0
    };
    let places = (-steps..=steps).flat_map(|i| (-steps..=steps).map(move |j| (i, j)));
    places.map(|(i, j)| (at(i), at(j))).any(|(u, v)| inside(u, v) && turned(u, v))
}
