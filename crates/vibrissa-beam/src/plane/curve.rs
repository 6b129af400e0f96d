//! Curves: chains of lines and Béziers, measured by arc length.

use super::{Bounds, Segment, Vec2, arc_to_cubics};
use crate::config::ARC_TOLERANCE;
use crate::platform::rem_euclid;
use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::TAU;
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// A point of a curve with its place along it and its direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePoint {
    /// Arc length from the curve's start (m).
    pub arc_length: f64,
    /// The point (m).
    pub position: Vec2,
    /// Direction of travel in (-pi, pi] (rad).
    pub tangent: f64,
    /// Signed curvature (1/m), positive when the curve turns left; 0 on lines.
    pub curvature: f64,
}

/// A chain of lines and Béziers, each starting where the one before ended; never empty and of positive length.
///
/// Lines keep their own direction: a polyline's tangent jumps at its corners.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    segments: Vec<Segment>,
    /// Arc length at the end of each segment (m).
    ends: Vec<f64>,
    closed: bool,
}

/// Of coordinates beyond this (m) no number holds the powers that lengths are made of.
const LARGEST: f64 = 1e70;

impl Curve {
    /// The polyline through `points` (m), closed back to the first point if asked.
    ///
    /// Repeated points are dropped, and so is a repeated first point at the end of a closed line. None when fewer than
    /// two distinct points remain or a coordinate is not finite or beyond 1e70 m.
    #[must_use]
    pub fn polyline(points: &[Vec2], closed: bool) -> Option<Self> {
        let mut distinct = points.to_vec();
        distinct.dedup();
        if let (true, Some(&first)) = (closed, distinct.first()) {
            distinct.push(first);
        }
        let lines = distinct.windows(2).map(|w| Segment::Line([w[0], w[1]]));
        Self::from_segments(lines.collect(), closed)
    }

    /// The curve made of `segments`, each starting where the one before ended.
    ///
    /// Segments whose control points all coincide are dropped. A closed curve must end where it starts. None when
    /// nothing remains, when a coordinate is not finite or beyond 1e70 m, or when there is a gap of more than 1e-9 of the
    /// curve's size.
    #[must_use]
    pub fn from_segments(mut segments: Vec<Segment>, closed: bool) -> Option<Self> {
        let holds = |p: &Vec2| p.is_finite() && p.x.abs().max(p.y.abs()) <= LARGEST;
        if !segments.iter().flat_map(Segment::control_points).all(holds) {
            return None;
        }
        segments.retain(|s| s.control_points().iter().any(|&p| p != s.start()));
        let bounds = segments.iter().fold(Bounds::EMPTY, |b, s| b.hull(s.bounds()));
        let gap = 1e-9 * bounds.size().norm();
        let joins = |a: &Segment, b: &Segment| a.end().distance(b.start()) <= gap;
        let (first, last) = (segments.first()?, segments.last()?);
        if !segments.windows(2).all(|w| joins(&w[0], &w[1])) || (closed && !joins(last, first)) {
            return None;
        }
        let mut total = 0.0;
        let ends = segments
            .iter()
            .map(|s| {
                total += s.length();
                total
            })
            .collect();
        (total > 0.0 && total.is_finite()).then_some(Self { segments, ends, closed })
    }

    /// The circle around `center` with the given `radius` (m), counter-clockwise from its rightmost point, as cubics
    /// within 1e-9 m of it (their curvature is right to about 1e-4 of it).
    ///
    /// None unless the radius is positive and all is finite.
    #[must_use]
    pub fn circle(center: Vec2, radius: f64) -> Option<Self> {
        let cubics = arc_to_cubics(center, Vec2::new(radius, radius), 0.0, 0.0, TAU, ARC_TOLERANCE);
        if radius > 0.0 { Self::from_segments(cubics, true) } else { None }
    }

    /// The pieces, in the direction of travel.
    #[must_use]
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Whether the curve ends where it starts.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// The arc length (m).
    #[must_use]
    pub fn length(&self) -> f64 {
        self.ends.last().copied().unwrap_or(0.0)
    }

    /// The arc length at which a segment starts (m).
    #[must_use]
    pub fn segment_start(&self, segment: usize) -> f64 {
        if segment == 0 { 0.0 } else { self.ends[segment - 1] }
    }

    /// The segment on which an arc length (m) lies; where two meet the later one.
    #[must_use]
    pub fn segment_at(&self, s: f64) -> usize {
        self.ends.partition_point(|&end| end <= s).min(self.segments.len() - 1)
    }

    /// The rectangle around all control points, which holds the curve.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        self.segments.iter().fold(Bounds::EMPTY, |b, s| b.hull(s.bounds()))
    }

    /// The point at the arc length `s` (m), taken round the curve when it is closed and clamped to its ends when not.
    #[must_use]
    pub fn at(&self, s: f64) -> CurvePoint {
        let total = self.length();
        let inside =
            if self.closed && !(0.0..=total).contains(&s) { rem_euclid(s, total) } else { s.clamp(0.0, total) };
        let index = self.ends.partition_point(|&end| end < inside).min(self.segments.len() - 1);
        let t = self.segments[index].parameter_at(inside - self.segment_start(index));
        self.on_segment(index, t, inside)
    }

    fn on_segment(&self, index: usize, t: f64, arc_length: f64) -> CurvePoint {
        let segment = &self.segments[index];
        CurvePoint {
            arc_length,
            position: segment.point(t),
            tangent: segment.tangent(t),
            curvature: segment.curvature(t),
        }
    }

    /// Points along the curve at most `spacing` (m) apart within each segment, in order.
    ///
    /// Each segment is cut into equal cells no longer than `spacing` (up to a rounding) and gives their midpoints, so no sample sits on a
    /// corner and every segment has at least one. A spacing that is not positive gives one sample a segment;
    /// no segment gives more than a million.
    #[must_use]
    pub fn samples(&self, spacing: f64) -> Vec<CurvePoint> {
        self.samples_of(spacing, |_| true)
    }

    /// The same on the segments that `wanted` admits only.
    pub fn samples_of(&self, spacing: f64, wanted: impl Fn(&Segment) -> bool) -> Vec<CurvePoint> {
        let mut samples = Vec::new();
        for (index, segment) in self.segments.iter().enumerate().filter(|(_, segment)| wanted(segment)) {
            let start = self.segment_start(index);
            let length = self.ends[index] - start;
            let cells = if spacing > 0.0 { (length / spacing - 1e-9).ceil().clamp(1.0, 1e6) } else { 1.0 };
            for k in 0..cells as usize {
                let s = (k as f64 + 0.5) * length / cells;
                samples.push(self.on_segment(index, segment.parameter_at(s), start + s));
            }
        }
        samples
    }

    /// The point of the curve nearest to `p` (the first one among equals).
    #[must_use]
    pub fn nearest(&self, p: Vec2) -> CurvePoint {
        let (mut best, mut best_distance) = (self.at(0.0), f64::INFINITY);
        for (index, segment) in self.segments.iter().enumerate() {
            if segment.bounds().distance_squared(p) >= best_distance * best_distance {
                continue;
            }
            let point = self.nearest_on_segment(index, p);
            let distance = point.position.distance(p);
            if distance < best_distance {
                (best, best_distance) = (point, distance);
            }
        }
        best
    }

    /// The point nearest to `p` of one segment, or of its neighbour where that segment ends.
    #[must_use]
    pub fn nearest_near_segment(&self, index: usize, p: Vec2) -> CurvePoint {
        let count = self.segments.len();
        let here = self.nearest_on_segment(index, p);
        let neighbour = if here.position == self.segments[index].start() {
            index.checked_sub(1).or(self.closed.then_some(count - 1))
        } else if here.position == self.segments[index].end() {
            if index + 1 < count { Some(index + 1) } else { self.closed.then_some(0) }
        } else {
            None
        };
        match neighbour.map(|n| self.nearest_on_segment(n, p)) {
            Some(there) if there.position.distance(p) < here.position.distance(p) => there,
            _ => here,
        }
    }

    /// The point of one segment nearest to `p`.
    fn nearest_on_segment(&self, index: usize, p: Vec2) -> CurvePoint {
        let segment = &self.segments[index];
        let t = segment.nearest(p);
        self.on_segment(index, t, self.segment_start(index) + segment.length_to(t))
    }

    /// The corners of a polyline within `tolerance` (m) of the curve; for a closed curve the first is repeated at the end.
    #[must_use]
    pub fn flatten(&self, tolerance: f64) -> Vec<Vec2> {
        let mut points = vec![self.segments[0].start()];
        for segment in &self.segments {
            let parts = segment.flat_parts(tolerance);
            points.extend((1..parts).map(|k| segment.point(k as f64 / parts as f64)));
            points.push(segment.end());
        }
        if let (true, Some(last)) = (self.closed, points.last().copied()) {
            // The ends of a closed curve may differ by a rounding.
            points[0] = last;
        }
        points
    }

    /// The area enclosed by the closed curve (m²), positive when it is travelled counter-clockwise.
    ///
    /// An open curve is closed by a straight line.
    #[must_use]
    pub fn signed_area(&self) -> f64 {
        let start = self.segments[0].start();
        // Relative to the start, so that far-away curves lose no digits.
        // The closing line then passes through the origin and adds nothing.
        self.segments.iter().map(|s| shifted(s, start).area_share()).sum()
    }

    /// The same curve travelled the other way.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let segments: Vec<Segment> = self.segments.iter().rev().map(Segment::reversed).collect();
        let total = self.length();
        let mut ends: Vec<f64> = self.ends.iter().rev().skip(1).map(|end| total - end).collect();
        ends.push(total);
        Self { segments, ends, closed: self.closed }
    }
}

fn shifted(segment: &Segment, origin: Vec2) -> Segment {
    match *segment {
        Segment::Line(p) => Segment::Line(p.map(|q| q - origin)),
        Segment::Quadratic(p) => Segment::Quadratic(p.map(|q| q - origin)),
        Segment::Cubic(p) => Segment::Cubic(p.map(|q| q - origin)),
    }
}
