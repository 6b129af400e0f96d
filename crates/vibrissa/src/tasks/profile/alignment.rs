//! Shape error and absolute error against a map.

use super::least_squares::least_squares;
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

/// Compares points (odometry frame, taken for the map's) with a map's boundaries; a free scale only when asked for.
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
    let steps = [0.01, 0.01, 0.1, 0.1];
    let rigid = least_squares(&[0.0; 3], &steps[..3], &residuals);
    let scaled = free_scale.then(|| {
        let x = least_squares(&[rigid[0], rigid[1], rigid[2], 0.0], &steps, &residuals);
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
