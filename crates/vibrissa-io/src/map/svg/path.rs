//! Path data, command by command.

use crate::config::budgets::MOST_PIECES;
use crate::config::limits::ARC_TOLERANCE;
use crate::math;
use crate::plane::{Segment, Vec2, arc_to_cubics};
use crate::text::beyond;
use crate::{Error, Result};
use core::f64::consts::TAU;
use kurbo::{Affine, Arc, Point, SvgArc};
use svgtypes::{PathParser, PathSegment};

/// A subpath's segments, in metres, and whether it is closed.
pub(super) type Subpath = (Vec<Segment>, bool);

/// Collects subpaths given in user units.
pub(super) struct Builder {
    map_from_user: Affine,
    /// How much one user unit is at most (m).
    stretch: f64,
    done: Vec<Subpath>,
    /// How many pieces are done.
    pieces: usize,
    open: Vec<Segment>,
    start: Vec2,
    here: Vec2,
}

impl Builder {
    pub(super) fn new(map_from_user: Affine) -> Self {
        let [a, b, c, d, ..] = map_from_user.as_coeffs();
        let stretch = math::hypot(math::hypot(a, b), math::hypot(c, d));
        Self {
            map_from_user,
            stretch,
            done: Vec::new(),
            pieces: 0,
            open: Vec::new(),
            start: Vec2::ZERO,
            here: Vec2::ZERO,
        }
    }

    fn place(&self, p: Vec2) -> Vec2 {
        let q = self.map_from_user * Point::new(p.x, p.y);
        Vec2::new(q.x + 0.0, q.y + 0.0)
    }

    /// Ends the current subpath; one that returns to its start within a nanometre is closed.
    fn end(&mut self, mut closed: bool) {
        let mut segments = std::mem::take(&mut self.open);
        let (Some(first), Some(last)) = (segments.first(), segments.last()) else { return };
        let (start, end) = (first.start(), last.end());
        let gap = start.distance(end);
        if gap > ARC_TOLERANCE && closed {
            segments.push(Segment::Line([end, start]));
        } else if gap <= ARC_TOLERANCE {
            closed = true;
            if let Some(last) = segments.last_mut() {
                *last = ending_at(*last, start);
            }
        }
        self.pieces += segments.len();
        self.done.push((segments, closed));
    }

    /// Refuses more pieces than a map may have, before memory is taken for further ones.
    pub(super) fn check(&self) -> Result<()> {
        let pieces = self.pieces + self.open.len();
        if pieces <= MOST_PIECES {
            return Ok(());
        }
        let remedy = "simplify it (in Inkscape: Path > Simplify), or draw a part of it";
        Err(beyond("has too many pieces of lines and curves", format!("{pieces} or more"), MOST_PIECES, remedy))
    }

    pub(super) fn finish(mut self) -> Vec<Subpath> {
        self.end(false);
        self.done
    }

    pub(super) fn move_to(&mut self, p: Vec2) {
        self.end(false);
        (self.start, self.here) = (p, p);
    }

    pub(super) fn line_to(&mut self, p: Vec2) {
        self.open.push(Segment::Line([self.place(self.here), self.place(p)]));
        self.here = p;
    }

    fn quadratic_to(&mut self, p1: Vec2, p: Vec2) {
        self.open.push(Segment::Quadratic([self.here, p1, p].map(|q| self.place(q))));
        self.here = p;
    }

    fn cubic_to(&mut self, p1: Vec2, p2: Vec2, p: Vec2) {
        self.open.push(Segment::Cubic([self.here, p1, p2, p].map(|q| self.place(q))));
        self.here = p;
    }

    pub(super) fn close(&mut self) {
        self.end(true);
        self.here = self.start;
    }

    /// An arc of an ellipse around `center`, from where the path is (a line leads to the arc's start if need be).
    pub(super) fn arc(&mut self, center: Vec2, radii: Vec2, rotation: f64, start: f64, sweep: f64) {
        let tolerance = ARC_TOLERANCE / self.stretch.max(f64::MIN_POSITIVE);
        let cubics = arc_to_cubics(center, radii, rotation, start, sweep, tolerance);
        if let Some(first) = cubics.first()
            && first.start().distance(self.here) > 1e-9 * radii.norm()
        {
            self.line_to(first.start());
        }
        for cubic in cubics {
            if let Segment::Cubic([_, p1, p2, p3]) = cubic {
                self.cubic_to(p1, p2, p3);
            }
        }
    }

    /// A whole ellipse.
    pub(super) fn ellipse(&mut self, center: Vec2, radii: Vec2) {
        self.move_to(center + Vec2::new(radii.x, 0.0));
        self.arc(center, radii, 0.0, 0.0, TAU);
        self.close();
    }

    /// An arc as path data writes it, by its two ends.
    fn arc_to(&mut self, radii: Vec2, rotation: f64, large_arc: bool, sweep: bool, p: Vec2) {
        let arc = SvgArc {
            from: Point::new(self.here.x, self.here.y),
            to: Point::new(p.x, p.y),
            radii: kurbo::Vec2::new(radii.x, radii.y),
            x_rotation: rotation,
            large_arc,
            sweep,
        };
        match Arc::from_svg_arc(&arc) {
            Some(arc) => {
                let center = Vec2::new(arc.center.x, arc.center.y);
                let radii = Vec2::new(arc.radii.x, arc.radii.y);
                self.arc(center, radii, arc.x_rotation, arc.start_angle, arc.sweep_angle);
                let end = self.place(p);
                if let Some(last) = self.open.last_mut() {
                    *last = ending_at(*last, end);
                }
                self.here = p;
            }
            None => self.line_to(p),
        }
    }
}

/// The same piece with its last control point moved.
fn ending_at(segment: Segment, end: Vec2) -> Segment {
    match segment {
        Segment::Line([a, _]) => Segment::Line([a, end]),
        Segment::Quadratic([a, b, _]) => Segment::Quadratic([a, b, end]),
        Segment::Cubic([a, b, c, _]) => Segment::Cubic([a, b, c, end]),
    }
}

/// Reads path data into the builder.
pub(super) fn path(data: &str, builder: &mut Builder) -> Result<()> {
    // The last control point, for the smooth commands.
    let (mut cubic, mut quadratic) = (None, None);
    for segment in PathParser::from(data) {
        let segment =
            segment.map_err(|e| Error::data("the path data cannot be read").value(e).remedy("redraw the path"))?;
        let here = builder.here;
        let at = |abs: bool, x: f64, y: f64| if abs { Vec2::new(x, y) } else { here + Vec2::new(x, y) };
        let mirrored = |control: Option<Vec2>| control.map_or(here, |c: Vec2| here * 2.0 - c);
        let (mut next_cubic, mut next_quadratic) = (None, None);
        match segment {
            PathSegment::MoveTo { abs, x, y } => builder.move_to(at(abs, x, y)),
            PathSegment::LineTo { abs, x, y } => builder.line_to(at(abs, x, y)),
            PathSegment::HorizontalLineTo { abs, x } => builder.line_to(Vec2::new(at(abs, x, 0.0).x, here.y)),
            PathSegment::VerticalLineTo { abs, y } => builder.line_to(Vec2::new(here.x, at(abs, 0.0, y).y)),
            PathSegment::CurveTo { abs, x1, y1, x2, y2, x, y } => {
                next_cubic = Some(at(abs, x2, y2));
                builder.cubic_to(at(abs, x1, y1), at(abs, x2, y2), at(abs, x, y));
            }
            PathSegment::SmoothCurveTo { abs, x2, y2, x, y } => {
                next_cubic = Some(at(abs, x2, y2));
                builder.cubic_to(mirrored(cubic), at(abs, x2, y2), at(abs, x, y));
            }
            PathSegment::Quadratic { abs, x1, y1, x, y } => {
                next_quadratic = Some(at(abs, x1, y1));
                builder.quadratic_to(at(abs, x1, y1), at(abs, x, y));
            }
            PathSegment::SmoothQuadratic { abs, x, y } => {
                let control = mirrored(quadratic);
                next_quadratic = Some(control);
                builder.quadratic_to(control, at(abs, x, y));
            }
            PathSegment::EllipticalArc { abs, rx, ry, x_axis_rotation, large_arc, sweep, x, y } => {
                builder.arc_to(Vec2::new(rx, ry), x_axis_rotation.to_radians(), large_arc, sweep, at(abs, x, y));
            }
            PathSegment::ClosePath { .. } => builder.close(),
        }
        (cubic, quadratic) = (next_cubic, next_quadratic);
        builder.check()?;
    }
    Ok(())
}
