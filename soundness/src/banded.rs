//! Maps that are not exact: outlines drawn beside the true ones, within the band that they declare, with stretches that nobody saw.

use crate::random_sweep::random::Random;
use core::f64::consts::{PI, TAU};
use vibrissa::plane::{Curve, Vec2};
use vibrissa::world::{Band, Boundary, Course, Map, PieceCourse, Role};

/// How far curves may leave their lines (m), which the band holds, too.
const FLAT: f64 = 2e-6;
/// Points along a wall for each correlation length.
const POINTS: f64 = 10.0;

/// The map as somebody drew it who was off within bands, which are told with this share of their bounds.
pub(crate) fn drawn(map: &Map, draw: &mut Random, declared: f64) -> Option<Map> {
    Map::new(map.boundaries().iter().map(|boundary| off(boundary, draw, declared)).collect::<Option<Vec<_>>>()?).ok()
}

/// A displacement along a boundary: a wave for each axis.
struct Waves([(f64, f64, f64); 2]);

impl Waves {
    /// Waves that repeat along a ring of this length, within `bound` and no shorter than the correlation length allows.
    fn new(draw: &mut Random, (length, closed): (f64, bool), bound: f64, correlation: f64) -> Self {
        let most = length / (TAU * correlation);
        // Counted along the drawn line instead of the true one slopes are larger by a little.
        let size = 0.9 * bound * (1.0 - bound / correlation).powi(3) / f64::sqrt(2.0);
        Self([(); 2].map(|()| {
            let count = draw.between(0.0, most + 1.0).min(most);
            let count = if closed { count.floor() } else { count };
            (size * draw.between(0.5, 1.0), TAU * count / length, draw.signed(PI))
        }))
    }

    fn at(&self, s: f64) -> Vec2 {
        let [x, y] = self.0.map(|(size, per_metre, phase)| size * (per_metre * s + phase).sin());
        Vec2::new(x, y)
    }
}

fn off(boundary: &Boundary, draw: &mut Random, declared: f64) -> Option<Boundary> {
    let curve = boundary.curve();
    let (closed, length) = (curve.is_closed(), curve.length());
    let correlation = draw.between(0.02, 0.1);
    let bound = draw.between(1e-4, 0.15 * correlation).min(3e-3);
    let waves = Waves::new(draw, (length, closed), bound, correlation);
    let corners = curve.flatten(FLAT);
    let (mut truth, mut along) = (vec![(corners[0], 0.0)], 0.0);
    for pair in corners.windows(2) {
        let step = pair[0].distance(pair[1]);
        let parts = (step * POINTS / correlation).ceil().max(1.0);
        for k in 1..=parts as usize {
            let share = k as f64 / parts;
            truth.push((pair[0] + (pair[1] - pair[0]) * share, along + share * step));
        }
        along += step;
    }
    if closed {
        truth.pop();
    }
    let mut points: Vec<Vec2> = truth.iter().map(|&(p, s)| p + waves.at(s)).collect();
    let told = bound * declared + FLAT;
    let known = PieceCourse::Band([Band::even(told); 2]);
    let pieces = if closed { points.len() } else { points.len() - 1 };
    let mut courses = vec![known; pieces];
    if boundary.role() == Role::Arena && draw.unit() < 0.5 {
        hide(&truth, &mut points, &mut courses, draw, told)?;
    }
    let hole = boundary.role() == Role::Obstacle && curve.signed_area() > 0.0;
    let drawn = Boundary::checked(boundary.role(), Curve::polyline(&points, closed)?, hole, None).ok()?;
    drawn.with_course(Course::new(courses, correlation).ok()?).ok()
}

/// Leaves out a stretch of a ring, which is drawn straight and unknown as deep as the true one goes.
fn hide(
    truth: &[(Vec2, f64)],
    points: &mut Vec<Vec2>,
    courses: &mut Vec<PieceCourse>,
    draw: &mut Random,
    told: f64,
) -> Option<()> {
    let count = points.len();
    let from = 1 + (draw.unit() * 0.7 * count as f64) as usize;
    let to = (from + 2 + (draw.between(0.02, 0.15) * count as f64) as usize).min(count - 1);
    if to <= from + 1 {
        return Some(());
    }
    let (a, b) = (points[from], points[to]);
    let away = |p: Vec2| {
        let along = b - a;
        let share = ((p - a).dot(along) / along.norm_squared()).clamp(0.0, 1.0);
        p.distance(a + along * share)
    };
    let depth = truth[from..=to].iter().map(|(p, _)| away(*p)).fold(0.0, f64::max) + told;
    points.drain(from + 1..to);
    courses.drain(from + 1..to);
    courses[from] = PieceCourse::Unknown(depth);
    Some(())
}
