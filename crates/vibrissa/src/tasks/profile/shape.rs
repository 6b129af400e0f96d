//! Circles and regular polygons with rounded corners, fitted to points.

use super::alignment::Misfit;
use crate::least_squares::{Scale, minimise};
use crate::plane::{Pose2, Vec2};
use core::f64::consts::PI;

/// A regular polygon with rounded corners about its centre, a face's normal along +x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoundedPolygon {
    /// Number of sides, at least 3; 0 for a circle.
    pub sides: usize,
    /// Distance of the faces from the centre (m); for a circle its radius.
    pub apothem: f64,
    /// Radius of the corners (m), at most the apothem; for a circle its radius.
    pub corner_radius: f64,
}

/// Which sizes of a shape are fitted beside its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FreeSize {
    /// None: the shape is known.
    None,
    /// One common scale.
    Scale,
    /// One common distance of the points from the outline: what felt it was not a point.
    Offset,
    /// Apothem and corner radius, each by itself.
    All,
}

/// A shape where it fits best.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedShape {
    /// The shape with its fitted sizes.
    pub shape: RoundedPolygon,
    /// Its centre and orientation in the frame of the points.
    pub place: Pose2,
    /// How far the points are from it.
    pub misfit: Misfit,
}

impl RoundedPolygon {
    /// A circle of this radius (m).
    #[must_use]
    pub fn circle(radius: f64) -> Self {
        Self { sides: 0, apothem: radius, corner_radius: radius }
    }

    /// The signed distance of a point (m, the shape's frame) from the outline, negative inside.
    #[must_use]
    pub fn distance(&self, point: Vec2) -> f64 {
        if self.sides == 0 {
            return point.norm() - self.apothem;
        }
        let sector = 2.0 * PI / self.sides as f64;
        let turn = (point.angle() / sector).round() * sector;
        let seen = point.rotated(-turn);
        // The outline is a smaller polygon grown by the corner radius.
        let inner = (self.apothem - self.corner_radius).max(0.0);
        let (out, beyond) = (seen.x - inner, seen.y.abs() - inner * (0.5 * sector).tan());
        let distance = if beyond > 0.0 && out > 0.0 { out.hypot(beyond) } else { out };
        distance - self.corner_radius
    }
}

/// The place, and as far as they are free the sizes, at which a shape fits the points (m) best: least squares of the
/// distances, from several orientations.
///
/// None with fewer than three points.
#[must_use]
pub fn fit_shape(points: &[Vec2], shape: RoundedPolygon, free: FreeSize) -> Option<FittedShape> {
    if points.len() < 3 {
        return None;
    }
    let middle = points.iter().fold(Vec2::ZERO, |sum, p| sum + *p) * (1.0 / points.len() as f64);
    let sized = |x: &[f64]| match free {
        FreeSize::None => shape,
        FreeSize::Scale => {
            let scale = x[3].exp();
            RoundedPolygon { apothem: scale * shape.apothem, corner_radius: scale * shape.corner_radius, ..shape }
        }
        FreeSize::Offset => {
            let grown = |size: f64| (size + shape.apothem * x[3]).max(0.0);
            RoundedPolygon { apothem: grown(shape.apothem), corner_radius: grown(shape.corner_radius), ..shape }
        }
        FreeSize::All if shape.sides == 0 => RoundedPolygon::circle(shape.apothem * x[3].exp()),
        FreeSize::All => {
            let apothem = shape.apothem * x[3].exp();
            RoundedPolygon { apothem, corner_radius: (shape.corner_radius * x[4].exp()).min(apothem), ..shape }
        }
    };
    let place = |x: &[f64]| Pose2::new(middle.x + x[0], middle.y + x[1], x[2]);
    let residuals = |x: &[f64]| -> Vec<f64> {
        let (sized, place) = (sized(x), place(x));
        points.iter().map(|p| sized.distance(place.inverse_transform_point(*p))).collect()
    };
    let unknowns = match free {
        FreeSize::None => 3,
        FreeSize::Scale | FreeSize::Offset => 4,
        FreeSize::All => 5,
    };
    let sizes = [0.01, 0.01, 0.1, 0.1, 0.1].map(Scale::free);
    let starts = starts(points, middle, shape, free);
    let best = starts
        .into_iter()
        .map(|start| start[..unknowns].to_vec())
        .filter_map(|start| minimise(|x| Some(residuals(x)), &start, &sizes[..unknowns]).ok())
        .map(|minimum| (minimum.residuals.iter().map(|r| r * r).sum::<f64>(), minimum.parameters))
        .min_by(|a, b| a.0.total_cmp(&b.0))?;
    let x = best.1;
    Some(FittedShape { shape: sized(&x), place: place(&x), misfit: Misfit::of(residuals(&x)) })
}

/// Orientations to start from, as parts of a polygon's symmetry.
const TURNS: u32 = 6;
/// Corner radii over the apothem to start from where both are free: a corner as round as the polygon itself does not find back.
const CORNERS: [f64; 2] = [0.3, 0.8];

/// Where the search starts: place, turn, and the logarithms of both sizes over the shape's.
fn starts(points: &[Vec2], middle: Vec2, shape: RoundedPolygon, free: FreeSize) -> Vec<[f64; 5]> {
    let radius = points.iter().map(|p| p.distance(middle)).sum::<f64>() / points.len() as f64;
    let scale = (radius / shape.apothem).max(1e-3).ln();
    let turns = if shape.sides == 0 { 1 } else { TURNS };
    let turn = |i: u32| 2.0 * PI / shape.sides.max(1) as f64 * f64::from(i) / f64::from(turns);
    let corner = |share: f64| (share * radius / shape.corner_radius).max(1e-3).ln();
    let corners: &[f64] = if free == FreeSize::All && shape.sides > 0 { &CORNERS } else { &CORNERS[..1] };
    let one = |i: u32, share: f64| match free {
        FreeSize::All => [0.0, 0.0, turn(i), scale, corner(share)],
        _ => [0.0, 0.0, turn(i), 0.0, 0.0],
    };
    (0..turns).flat_map(|i| corners.iter().map(move |share| one(i, *share)).collect::<Vec<_>>()).collect()
}
