//! One smooth piece of a curve: a line or a Bézier.

use super::{Bounds, Vec2};
use kurbo::{CubicBez, Line, ParamCurve, ParamCurveArclen, ParamCurveArea, ParamCurveNearest, PathSeg, Point, QuadBez};
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// Arc lengths and nearest points of Béziers are found to this fraction of the control polygon's length.
const RELATIVE_ACCURACY: f64 = 1e-11;

/// A line or a Bézier of degree two or three, given by its control points (m) and travelled from t = 0 to t = 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Segment {
    /// A straight line.
    Line([Vec2; 2]),
    /// A quadratic Bézier.
    Quadratic([Vec2; 3]),
    /// A cubic Bézier.
    Cubic([Vec2; 4]),
}

fn point(p: Vec2) -> Point {
    Point::new(p.x, p.y)
}

impl Segment {
    /// The control points (m).
    #[must_use]
    pub fn control_points(&self) -> &[Vec2] {
        match self {
            Self::Line(p) => p,
            Self::Quadratic(p) => p,
            Self::Cubic(p) => p,
        }
    }

    fn to_kurbo(self) -> PathSeg {
        match self {
            Self::Line([a, b]) => PathSeg::Line(Line::new(point(a), point(b))),
            Self::Quadratic([a, b, c]) => PathSeg::Quad(QuadBez::new(point(a), point(b), point(c))),
            Self::Cubic([a, b, c, d]) => PathSeg::Cubic(CubicBez::new(point(a), point(b), point(c), point(d))),
        }
    }

    /// The first point (m).
    #[must_use]
    pub fn start(&self) -> Vec2 {
        match *self {
            Self::Line([a, ..]) | Self::Quadratic([a, ..]) | Self::Cubic([a, ..]) => a,
        }
    }

    /// The last point (m).
    #[must_use]
    pub fn end(&self) -> Vec2 {
        match *self {
            Self::Line([.., b]) | Self::Quadratic([.., b]) | Self::Cubic([.., b]) => b,
        }
    }

    /// The same piece travelled the other way.
    #[must_use]
    pub fn reversed(&self) -> Self {
        match *self {
            Self::Line([a, b]) => Self::Line([b, a]),
            Self::Quadratic([a, b, c]) => Self::Quadratic([c, b, a]),
            Self::Cubic([a, b, c, d]) => Self::Cubic([d, c, b, a]),
        }
    }

    /// The rectangle around the control points, which holds the whole piece.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        Bounds::of(self.control_points())
    }

    /// The point at the parameter `t` in [0, 1] (m).
    #[must_use]
    pub fn point(&self, t: f64) -> Vec2 {
        let p = self.to_kurbo().eval(t);
        Vec2::new(p.x, p.y)
    }

    /// The first and second derivatives with respect to the parameter at `t` (m).
    #[must_use]
    pub fn derivatives(&self, t: f64) -> (Vec2, Vec2) {
        let r = 1.0 - t;
        match *self {
            Self::Line([a, b]) => (b - a, Vec2::ZERO),
            Self::Quadratic([a, b, c]) => {
                let (u, v) = (b - a, c - b);
                (2.0 * (r * u + t * v), 2.0 * (v - u))
            }
            Self::Cubic([a, b, c, d]) => {
                let (u, v, w) = (b - a, c - b, d - c);
                (3.0 * (r * r * u + 2.0 * r * t * v + t * t * w), 6.0 * (r * (v - u) + t * (w - v)))
            }
        }
    }

    /// The direction of travel at `t` as an angle in (-pi, pi] (rad).
    ///
    /// Where control points coincide and the derivative vanishes, it is the limit from inside the piece.
    #[must_use]
    pub fn tangent(&self, t: f64) -> f64 {
        let (first, second) = self.derivatives(t);
        let small = 1e-9 * self.polygon_length();
        if first.norm() > small {
            return first.angle();
        }
        let inward = if t > 0.5 { -second } else { second };
        if inward.norm() > small { inward.angle() } else { (self.end() - self.start()).angle() }
    }

    /// The signed curvature at `t` (1/m), positive when the piece turns left; 0 where the derivative vanishes.
    #[must_use]
    pub fn curvature(&self, t: f64) -> f64 {
        let (first, second) = self.derivatives(t);
        let speed = first.norm();
        if speed > 1e-9 * self.polygon_length() { first.cross(second) / (speed * speed * speed) } else { 0.0 }
    }

    fn polygon_length(&self) -> f64 {
        self.control_points().windows(2).map(|w| w[0].distance(w[1])).sum()
    }

    /// The piece with its start at the origin: far from the origin, differences of points would have no digits left for
    /// the accuracy that is asked of them, and the subdivision for it would hardly end.
    fn at_origin(self) -> PathSeg {
        let start = self.start();
        match self {
            Self::Line(p) => Self::Line(p.map(|q| q - start)),
            Self::Quadratic(p) => Self::Quadratic(p.map(|q| q - start)),
            Self::Cubic(p) => Self::Cubic(p.map(|q| q - start)),
        }
        .to_kurbo()
    }

    fn accuracy(&self) -> f64 {
        (RELATIVE_ACCURACY * self.polygon_length()).max(f64::MIN_POSITIVE)
    }

    /// The arc length (m): exact for lines, to 1e-11 of it for Béziers.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.length_to(1.0)
    }

    /// The arc length from the start to the parameter `t` in [0, 1] (m).
    #[must_use]
    pub fn length_to(&self, t: f64) -> f64 {
        match *self {
            Self::Line([a, b]) => t * a.distance(b),
            _ if t <= 0.0 || self.polygon_length() <= 0.0 => 0.0,
            _ => self.at_origin().subsegment(0.0..t.min(1.0)).arclen(self.accuracy()),
        }
    }

    /// The parameter in [0, 1] at the arc length `s` from the start (m).
    #[must_use]
    pub fn parameter_at(&self, s: f64) -> f64 {
        let polygon = self.polygon_length();
        if s <= 0.0 || polygon <= 0.0 {
            return 0.0;
        }
        let t = match self {
            Self::Line(_) => s / polygon,
            _ if s >= polygon => 1.0,
            _ => self.at_origin().inv_arclen(s, self.accuracy()),
        };
        t.clamp(0.0, 1.0)
    }

    /// The parameter in [0, 1] of the point nearest to `p`.
    #[must_use]
    pub fn nearest(&self, p: Vec2) -> f64 {
        match *self {
            Self::Line([a, b]) => nearest_on_line(a, b, p),
            _ => {
                let found = self.at_origin().nearest(point(p - self.start()), self.accuracy()).t.clamp(0.0, 1.0);
                // That holds to some 1e-5 of the piece; next to its ends they may be nearer.
                let off = |t: f64| self.point(t).distance(p);
                [0.0, 1.0].into_iter().fold(found, |best, end| if off(end) < off(best) { end } else { best })
            }
        }
    }

    /// Half the integral of x dy - y dx along the piece (m²): its share of a closed curve's signed area.
    #[must_use]
    pub fn area_share(&self) -> f64 {
        self.to_kurbo().signed_area()
    }

    /// Into how many parts of equal parameter the piece must be cut so that chords stay within `tolerance` (m) of it.
    ///
    /// A chord over a parameter step h is off by at most h²/8 times the largest second derivative, which a Bézier
    /// takes at most at a difference of its control points. At most 65536 parts.
    #[must_use]
    pub fn flat_parts(&self, tolerance: f64) -> usize {
        let bend = |a: Vec2, b: Vec2, c: Vec2| (a - 2.0 * b + c).norm();
        let largest_second = match *self {
            Self::Line(_) => return 1,
            Self::Quadratic([a, b, c]) => 2.0 * bend(a, b, c),
            Self::Cubic([a, b, c, d]) => 6.0 * bend(a, b, c).max(bend(b, c, d)),
        };
        // The cast saturates, and turns not-a-number into 0.
        ((largest_second / (8.0 * tolerance)).sqrt().ceil() as usize).clamp(1, 65536)
    }
}

/// The parameter in [0, 1] of the point of the segment `ab` nearest to `p`.
pub(super) fn nearest_on_line(a: Vec2, b: Vec2, p: Vec2) -> f64 {
    let along = b - a;
    let squared = along.norm_squared();
    if squared > 0.0 { ((p - a).dot(along) / squared).clamp(0.0, 1.0) } else { 0.0 }
}
