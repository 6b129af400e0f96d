//! From raw readings to moments, and from moments to the tip's retreat.

use super::labelled::{Explained, Labelled};
use super::scatter::{Scatter, by_labels, hysteresis, is_as_good, parts, rms};
use crate::config::CurveOptions;
use crate::least_squares::linear;
use crate::world::calibration::{MomentCurve, TipDeflection};
use crate::{Error, Result};

/// One labelled contact on its way to a curve: signal and moment, in the order of recording.
type Pair = (f64, f64);

/// Fits the moment as a polynomial of the readings' excursion along the direction in which contact moves them.
///
/// Sensors err by a share of what they read as well as by a floor, so that strong contacts scatter most. How much they
/// do is estimated from the residuals, and each contact counts by it: weak contacts are as exact, relative to what they
/// are, as strong ones. The degree is the least whose errors on rows left out, by the same measure, are within one standard
/// error of the best ones, row by row, up to [`CurveOptions::most_degree`], among those that are monotone over the range.
///
/// # Errors
///
/// Data: no raw readings, fewer contacts than [`CurveOptions::fewest_contacts`], readings that do not follow the moment.
pub fn fit_moment_curve(labelled: &Labelled, explained: &[Explained], options: &CurveOptions) -> Result<MomentCurve> {
    let fault = |what: &str| Error::data(what.to_owned()).in_file(&labelled.source);
    let inputs = labelled.inputs.len();
    if inputs == 0 {
        return Err(fault("there are no raw readings to calibrate").allowed("bx,by,bz (T) or ax,ay,az (counts)"));
    }
    if explained.len() < options.fewest_contacts {
        return Err(fault("too few contacts that the whisker can reach")
            .value(explained.len())
            .allowed(format!("{} or more; 1000 represent a sensor well", options.fewest_contacts))
            .remedy("check that x,y are in m in the whisker frame, and the whisker's length"));
    }
    let (rest, direction) = direction(labelled, explained).ok_or_else(|| {
        fault("the readings do not change with the moment").remedy("check the columns' order and units")
    })?;
    let signal = |row: usize| -> f64 {
        labelled.readings[row].iter().zip(&rest).zip(&direction).map(|((b, rest), d)| (b - rest) * d).sum()
    };
    let pairs: Vec<Pair> = explained.iter().map(|e| (signal(e.row), e.moment)).collect();
    let (lo, hi) = pairs.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), p| (lo.min(p.0), hi.max(p.0)));
    let range = [0.5 * (lo + hi), 0.5 * (hi - lo)];
    let mut curve = MomentCurve {
        inputs: labelled.inputs.clone(),
        rest,
        direction,
        range,
        coefficients: Vec::new(),
        residual_rms: 0.0,
        hysteresis: 0.0,
        bound: 0.0,
        samples: pairs.len(),
    };
    let fit = |scatter: &Scatter| chosen(&pairs, range, scatter, options.most_degree);
    // The first fit tells how readings scatter, the second one heeds it.
    let first = fit(&Scatter::EVEN).map(|(coefficients, _)| residuals(&pairs, range, &coefficients));
    let scatter = first.map_or(Scatter::EVEN, |residuals| Scatter::of(&moments(&pairs), &residuals));
    let Some((coefficients, errors)) = fit(&scatter) else {
        return Err(fault("no monotone curve fits the readings"));
    };
    curve.coefficients = coefficients;
    let residuals: Vec<f64> = pairs.iter().map(|&(s, m)| m - curve.at(s)).collect();
    curve.residual_rms = rms(&residuals);
    curve.bound = errors.iter().fold(0.0, |most, e| e.abs().max(most));
    curve.hysteresis = hysteresis(&moments(&pairs), &residuals);
    Ok(curve)
}

/// Readings at zero moment, and the unit vector along which they move with it: a straight line for each input.
fn direction(labelled: &Labelled, explained: &[Explained]) -> Option<(Vec<f64>, Vec<f64>)> {
    let scale = explained.iter().map(|e| e.moment.abs()).fold(0.0, f64::max);
    let rows: Vec<Vec<f64>> = explained.iter().map(|e| vec![1.0, e.moment / scale]).collect();
    let fit = |input: usize| {
        let targets: Vec<f64> = explained.iter().map(|e| labelled.readings[e.row][input]).collect();
        linear(&rows, &targets)
    };
    let lines: Vec<Vec<f64>> = (0..labelled.inputs.len()).map(fit).collect::<Option<_>>()?;
    let norm = lines.iter().map(|line| line[1] * line[1]).sum::<f64>().sqrt();
    (norm > 0.0 && norm.is_finite())
        .then(|| (lines.iter().map(|line| line[0]).collect(), lines.iter().map(|line| line[1] / norm).collect()))
}

/// The coefficients of the least degree that will do, and its errors on rows left out.
fn chosen(pairs: &[Pair], range: [f64; 2], scatter: &Scatter, most_degree: usize) -> Option<(Vec<f64>, Vec<f64>)> {
    let tried: Vec<(Vec<f64>, Vec<f64>)> = (1..=most_degree)
        .filter_map(|degree| {
            Some((polynomial(pairs, range, scatter, degree)?, left_out(pairs, range, scatter, degree)?))
        })
        .filter(|(coefficients, _)| monotone(coefficients))
        .collect();
    let squares = |errors: &[f64]| pairs.iter().zip(errors).map(|(p, e)| e * e / scatter.variance(p.1)).collect();
    let squares: Vec<Vec<f64>> = tried.iter().map(|(_, errors)| squares(errors)).collect();
    let best = squares.iter().min_by(|a, b| a.iter().sum::<f64>().total_cmp(&b.iter().sum()))?;
    let chosen = squares.iter().position(|own| is_as_good(own, best))?;
    tried.into_iter().nth(chosen)
}

fn residuals(pairs: &[Pair], range: [f64; 2], coefficients: &[f64]) -> Vec<f64> {
    pairs.iter().map(|&(s, m)| m - value(coefficients, (s - range[0]) / range[1])).collect()
}

/// Coefficients of the polynomial in `(signal - middle) / half width`, each pair weighed by its scatter.
fn polynomial(pairs: &[Pair], range: [f64; 2], scatter: &Scatter, degree: usize) -> Option<Vec<f64>> {
    let weights: Vec<f64> = pairs.iter().map(|p| 1.0 / scatter.std(p.1)).collect();
    let powers = |z: f64| -> Vec<f64> { (0..=degree).map(|k| z.powi(k as i32)).collect() };
    let scale = pairs.iter().fold(0.0, |most: f64, p| most.max(p.1.abs()));
    let labels: Vec<Vec<f64>> = pairs.iter().map(|p| powers(p.1 / scale)).collect();
    let readings: Vec<Vec<f64>> = pairs.iter().map(|p| powers((p.0 - range[0]) / range[1])).collect();
    by_labels(&labels, &readings, &moments(pairs), &weights)
}

fn moments(pairs: &[Pair]) -> Vec<f64> {
    pairs.iter().map(|pair| pair.1).collect()
}

fn value(coefficients: &[f64], z: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * z + c)
}

fn monotone(coefficients: &[f64]) -> bool {
    let values: Vec<f64> = (0..=200).map(|i| value(coefficients, f64::from(i) * 0.01 - 1.0)).collect();
    values.windows(2).all(|w| w[1] > w[0]) || values.windows(2).all(|w| w[1] < w[0])
}

/// Errors of all rows, each by a curve without its block and every tenth of the others.
fn left_out(pairs: &[Pair], range: [f64; 2], scatter: &Scatter, degree: usize) -> Option<Vec<f64>> {
    let mut errors = vec![0.0; pairs.len()];
    for (out, others) in parts(pairs.len()) {
        let others: Vec<Pair> = others.into_iter().map(|row| pairs[row]).collect();
        let coefficients = polynomial(&others, range, scatter, degree)?;
        for row in out {
            errors[row] = pairs[row].1 - value(&coefficients, (pairs[row].0 - range[0]) / range[1]);
        }
    }
    Some(errors)
}

/// Fits the tip's retreat as an even polynomial of the moment \[routray, section "Sensor Calibration"\]; none when fewer
/// than two contacts bend the whisker.
#[must_use]
pub fn fit_tip_deflection(explained: &[Explained]) -> Option<TipDeflection> {
    let largest = explained.iter().map(Explained::size).fold(0.0, f64::max);
    let bent: Vec<&Explained> = explained.iter().filter(|e| e.size() > 1e-6 * largest).collect();
    let rows: Vec<Vec<f64>> = bent.iter().map(|e| (e.size() / largest).powi(2)).map(|z| vec![z, z * z]).collect();
    let targets: Vec<f64> = bent.iter().map(|e| e.retreat).collect();
    let fitted = linear(&rows, &targets)?;
    let residuals: Vec<f64> =
        rows.iter().zip(&targets).map(|(row, y)| y - row[0] * fitted[0] - row[1] * fitted[1]).collect();
    Some(TipDeflection {
        coefficients: [fitted[0] / largest.powi(2), fitted[1] / largest.powi(4)],
        largest_moment: largest,
        residual_rms: rms(&residuals),
    })
}
