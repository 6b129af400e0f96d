//! Shape error and absolute error against a map.

use crate::least_squares::{Scale, minimise};
use crate::plane::{Pose2, Vec2};
use crate::world::Map;

/// How far points are from where they should be (m).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Misfit {
    /// Mean of the distances.
    pub mean: f64,
    /// Root of the mean square.
    pub rms: f64,
    /// The 95th percentile.
    pub p95: f64,
    /// The largest.
    pub max: f64,
}

impl Misfit {
    /// The misfit of these signed distances.
    #[must_use]
    pub fn of(distances: Vec<f64>) -> Self {
        let mut sizes: Vec<f64> = distances.into_iter().map(f64::abs).collect();
        sizes.sort_by(f64::total_cmp);
        let count = sizes.len().max(1) as f64;
        let at = |share: f64| sizes.get((share * (sizes.len().max(1) - 1) as f64).round() as usize).copied();
        Self {
            mean: sizes.iter().sum::<f64>() / count,
            rms: (sizes.iter().map(|d| d * d).sum::<f64>() / count).sqrt(),
            p95: at(0.95).unwrap_or(0.0),
            max: at(1.0).unwrap_or(0.0),
        }
    }
}

/// Points against a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alignment {
    /// As they are: the absolute error.
    pub absolute: Misfit,
    /// After the best rigid motion: the shape error.
    pub shape: Misfit,
    /// That motion: `map_from_outline`.
    pub map_from_outline: Pose2,
    /// After the best motion and scale, and the scale; only when asked for.
    pub scaled: Option<(Misfit, f64)>,
}

/// A scale between a half and three halves: a short arc shrunk to a point would fit anything.
fn scale(unknown: f64) -> f64 {
    1.0 + 0.5 * unknown.tanh()
}

/// Points that judge a start.
const FEW: usize = 40;
/// Starts that are refined.
const REFINED: usize = 12;
/// Places along the map's boundaries where a start is laid.
const PLACES: f64 = 400.0;
/// Densest spacing of these places (m).
const DENSEST: f64 = 1e-3;

/// A fit must be better by this factor than the one from where the points are,
const CLEARLY: f64 = 0.9;
/// and by more than this sum of squares (m²): a micrometre on every point.
const EQUAL: f64 = 40.0 * 1e-12;

/// At most so many of the points, evenly picked.
fn thinned(points: &[Vec2], count: usize) -> Vec<Vec2> {
    points.iter().step_by(points.len().div_ceil(count).max(1)).copied().collect()
}

/// Motions about `middle` that lay the points along the map's boundaries, wherever and either way round: a quarter, the
/// half and three quarters of the way along the points are put onto places of the boundaries with the same direction.
fn starts(points: &[Vec2], middle: Vec2, map: &Map) -> Vec<[f64; 3]> {
    let reach = points.len() / 8;
    let mut starts = Vec::new();
    if reach == 0 {
        return starts;
    }
    let places = map.samples((map.total_length() / PLACES).max(DENSEST));
    for anchor in [1, 2, 3].map(|quarter| quarter * points.len() / 4) {
        let along = points[(anchor + reach).min(points.len() - 1)] - points[anchor - reach];
        for place in &places {
            for half_turn in [0.0, core::f64::consts::PI] {
                let turn = place.tangent + half_turn - along.angle();
                let shift = place.position - (middle + (points[anchor] - middle).rotated(turn));
                starts.push([shift.x, shift.y, turn]);
            }
        }
    }
    starts
}

/// Compares points (odometry frame, taken for the map's) with a map's boundaries; a free scale only when asked for.
///
/// The rigid motion is the best of all: starts are laid everywhere along the boundaries, so that the frames need not agree.
///
/// None without points or boundaries.
#[must_use]
pub fn compare(points: &[Vec2], map: &Map, free_scale: bool) -> Option<Alignment> {
    map.nearest(*points.first()?)?;
    let middle = points.iter().fold(Vec2::ZERO, |sum, p| sum + *p) * (1.0 / points.len() as f64);
    let moved = |x: &[f64], p: Vec2| {
        let scale = x.get(3).map_or(1.0, |s| scale(*s));
        middle + Vec2::new(x[0], x[1]) + (scale * (p - middle)).rotated(x[2])
    };
    let signed = |p: Vec2| {
        let foot = map.nearest(p).map_or((p, 0.0), |foot| (foot.position, foot.tangent));
        (p - foot.0).norm().copysign(Vec2::from_angle(foot.1).cross(p - foot.0))
    };
    let residuals = |x: &[f64]| -> Vec<f64> { points.iter().map(|p| signed(moved(x, *p))).collect() };
    let sizes = [0.01, 0.01, 0.1, 0.1].map(Scale::free);
    let fit = |start: &[f64], residuals: &dyn Fn(&[f64]) -> Vec<f64>| -> Vec<f64> {
        let minimum = minimise(|x| Some(residuals(x)), start, &sizes[..start.len()]);
        minimum.map_or_else(|_| start.to_vec(), |minimum| minimum.parameters)
    };
    let few = thinned(points, FEW);
    let coarse = |x: &[f64]| -> Vec<f64> { few.iter().map(|p| signed(moved(x, *p))).collect() };
    let square = |x: &[f64]| coarse(x).iter().map(|d| d * d).sum::<f64>();
    let mut starts: Vec<(f64, [f64; 3])> =
        starts(points, middle, map).into_iter().map(|start| (square(&start), start)).collect();
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let refined = |(_, start): &(f64, [f64; 3])| fit(start, &coarse);
    let near = fit(&[0.0; 3], &coarse);
    let best = starts.iter().take(REFINED).map(refined).min_by(|a, b| square(a).total_cmp(&square(b)));
    // Of equal fits the nearest motion: a square's outline fits four ways.
    let clear = |x: &Vec<f64>| square(x) + EQUAL < CLEARLY * (square(&near) + EQUAL);
    let rigid = fit(&best.filter(clear).unwrap_or_else(|| near.clone()), &residuals);
    let scaled = free_scale.then(|| {
        let x = fit(&[rigid[0], rigid[1], rigid[2], 0.0], &residuals);
        (Misfit::of(residuals(&x)), scale(x[3]))
    });
    let origin = moved(&rigid, Vec2::ZERO);
    Some(Alignment {
        absolute: Misfit::of(residuals(&[0.0; 3])),
        shape: Misfit::of(residuals(&rigid)),
        map_from_outline: Pose2::new(origin.x, origin.y, rigid[2]),
        scaled,
    })
}
