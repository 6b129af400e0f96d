//! A panel of the page that shows a piece of the world.

use super::document::{Document, escaped_line, number};
use crate::plane::{Pose2, Vec2};
use std::collections::HashSet;
use std::fmt::Write;

/// A rectangle of the page: upper left corner and size in page units, y down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Left edge.
    pub x: f64,
    /// Upper edge.
    pub y: f64,
    /// Width.
    pub width: f64,
    /// Height.
    pub height: f64,
}

/// The smallest axis-parallel rectangle of the world around some points (m); points that are not finite are ignored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldBounds {
    /// Lower left corner (m).
    pub min: Vec2,
    /// Upper right corner (m).
    pub max: Vec2,
}

impl WorldBounds {
    /// The bounds of `points`; none when no point is finite.
    #[must_use]
    pub fn of(points: impl IntoIterator<Item = Vec2>) -> Option<Self> {
        points.into_iter().filter(|point| point.is_finite()).fold(None, |bounds, point| {
            let Self { min, max } = bounds.unwrap_or(Self { min: point, max: point });
            Some(Self {
                min: Vec2::new(min.x.min(point.x), min.y.min(point.y)),
                max: Vec2::new(max.x.max(point.x), max.y.max(point.y)),
            })
        })
    }

    /// The width and the height (m).
    #[must_use]
    pub fn size(&self) -> Vec2 {
        self.max - self.min
    }

    /// The middle (m).
    #[must_use]
    pub fn centre(&self) -> Vec2 {
        (self.min + self.max) * 0.5
    }

    /// Whether a place is within it.
    #[must_use]
    pub fn contains(&self, place: Vec2) -> bool {
        (self.min.x..=self.max.x).contains(&place.x) && (self.min.y..=self.max.y).contains(&place.y)
    }

    /// The bounds with `margin` (m) added on every side.
    #[must_use]
    pub fn grown(&self, margin: f64) -> Self {
        let corner = Vec2::new(margin, margin);
        Self { min: self.min - corner, max: self.max + corner }
    }
}

/// A panel: the world at equal scale in both directions, y up, centred in its frame.
///
/// Drawing never fails; whatever is not finite is left out.
#[derive(Clone, Debug)]
pub struct Canvas {
    frame: Frame,
    centre: Vec2,
    scale: f64,
    body: String,
}

impl Canvas {
    /// A panel in `frame` that shows at least `world`.
    #[must_use]
    pub fn new(frame: Frame, world: WorldBounds) -> Self {
        let size = world.size();
        let scale = (frame.width / size.x.max(1e-6)).min(frame.height / size.y.max(1e-6));
        Self { frame, centre: world.centre(), scale, body: String::new() }
    }

    /// The panel's place on the page.
    #[must_use]
    pub fn frame(&self) -> Frame {
        self.frame
    }

    /// Page units per metre.
    #[must_use]
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Where a point of the world lies on the page.
    #[must_use]
    pub fn page(&self, point: Vec2) -> Vec2 {
        let offset = (point - self.centre) * self.scale;
        Vec2::new(self.frame.x + 0.5 * self.frame.width + offset.x, self.frame.y + 0.5 * self.frame.height - offset.y)
    }

    /// The piece of the world that the frame shows (m).
    #[must_use]
    pub fn world(&self) -> WorldBounds {
        let half = Vec2::new(self.frame.width, self.frame.height) * (0.5 / self.scale);
        WorldBounds { min: self.centre - half, max: self.centre + half }
    }

    /// Whether a point of the world is inside the frame.
    #[must_use]
    pub fn shows(&self, point: Vec2) -> bool {
        let WorldBounds { min, max } = self.world();
        (min.x..=max.x).contains(&point.x) && (min.y..=max.y).contains(&point.y)
    }

    /// Draws an open chain of points.
    pub fn polyline(&mut self, points: &[Vec2], class: &str) {
        let data = self.path_data(points, false);
        self.path(&data, class);
    }

    /// Draws the way of something that moves, as [`Canvas::polyline`] does.
    ///
    /// What cannot be seen, since it is outside the frame or lies on an earlier part to half a page unit, is left out: the
    /// picture of a long way is no larger than its piece of the world.
    pub fn trail(&mut self, points: &[Vec2], class: &str) {
        let half_units = |p: Vec2| ((2.0 * p.x).round() as i64, (2.0 * p.y).round() as i64);
        let mut drawn = HashSet::new();
        let (mut data, mut before, mut pen) = (String::new(), None, None);
        for point in points.iter().filter(|point| point.is_finite()) {
            let here = self.page(*point);
            let Some(from) = before.filter(|&from| half_units(from) != half_units(here)) else {
                before = before.or(Some(here));
                continue;
            };
            before = Some(here);
            let ends = [half_units(from), half_units(here)];
            let way = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            if self.misses(from, here) || !drawn.insert(way) {
                continue;
            }
            if pen != Some(from) {
                let _ = write!(data, "M{} {}", number(from.x), number(from.y));
            }
            let _ = write!(data, "L{} {}", number(here.x), number(here.y));
            pen = Some(here);
        }
        self.path(&data, class);
    }

    /// Whether a line of the page is beyond one and the same edge of the frame with both its ends.
    fn misses(&self, a: Vec2, b: Vec2) -> bool {
        let Frame { x, y, width, height } = self.frame;
        let both = |beyond: &dyn Fn(Vec2) -> bool| beyond(a) && beyond(b);
        both(&|p| p.x < x) || both(&|p| p.x > x + width) || both(&|p| p.y < y) || both(&|p| p.y > y + height)
    }

    /// Draws a closed ring.
    pub fn polygon(&mut self, points: &[Vec2], class: &str) {
        let data = self.path_data(points, true);
        self.path(&data, class);
    }

    /// Draws many closed rings as one shape.
    pub fn polygons(&mut self, rings: &[[Vec2; 4]], class: &str) {
        let data: String = rings.iter().map(|ring| self.path_data(ring, true)).collect();
        self.path(&data, class);
    }

    /// Draws a round dot at each visible point; the class's stroke width is the diameter.
    pub fn dots(&mut self, points: impl IntoIterator<Item = Vec2>, class: &str) {
        let mut data = String::new();
        for point in points {
            if self.shows(point) {
                let p = self.page(point);
                let _ = write!(data, "M{} {}h0", number(p.x), number(p.y));
            }
        }
        self.path(&data, class);
    }

    /// Draws a round dot at each visible point, as [`Canvas::dots`] does, but one alone for those within half a page unit.
    pub fn marks(&mut self, points: &[Vec2], class: &str) {
        let mut drawn = HashSet::new();
        let half_units = |p: Vec2| ((2.0 * p.x).round() as i64, (2.0 * p.y).round() as i64);
        let apart: Vec<Vec2> = points.iter().copied().filter(|&p| drawn.insert(half_units(self.page(p)))).collect();
        self.dots(apart, class);
    }

    /// Draws a tick of `length` page units from each visible pose along its heading.
    pub fn heading_ticks(&mut self, poses: impl IntoIterator<Item = Pose2>, length: f64, class: &str) {
        let mut data = String::new();
        for pose in poses {
            if self.shows(pose.position()) && pose.theta.is_finite() {
                let (p, tick) = (self.page(pose.position()), Vec2::from_angle(pose.theta) * length);
                let _ = write!(data, "M{} {}l{} {}", number(p.x), number(p.y), number(tick.x), number(-tick.y));
            }
        }
        self.path(&data, class);
    }

    /// Draws a circle of `radius` page units.
    pub fn circle(&mut self, centre: Vec2, radius: f64, class: &str) {
        if centre.is_finite() {
            let p = self.page(centre);
            let (x, y, r) = (number(p.x), number(p.y), number(radius));
            let _ = writeln!(self.body, r#"<circle cx="{x}" cy="{y}" r="{r}" class="{class}"/>"#);
        }
    }

    /// Draws an arrow of `length` page units from a pose along its heading: a `line_class` shaft, a `head_class` head.
    pub fn arrow(&mut self, pose: Pose2, length: f64, line_class: &str, head_class: &str) {
        let reach = |along: f64, left: f64| {
            let local = Vec2::new(along, left) * (1.0 / self.scale);
            pose.transform_point(local)
        };
        let shaft = [reach(0.0, 0.0), reach(length - 6.0, 0.0)];
        let head = [reach(length, 0.0), reach(length - 9.0, 4.5), reach(length - 9.0, -4.5)];
        self.polyline(&shaft, line_class);
        self.polygon(&head, head_class);
    }

    /// Writes text `offset` page units right and below of a point.
    pub fn text(&mut self, point: Vec2, offset: (f64, f64), text: &str, class: &str) {
        if point.is_finite() {
            let p = self.page(point);
            let (x, y) = (number(p.x + offset.0), number(p.y + offset.1));
            let _ = writeln!(self.body, r#"<text x="{x}" y="{y}" class="{class}">{}</text>"#, escaped_line(text));
        }
    }

    /// Puts ready-made elements into the panel.
    pub(crate) fn raw(&mut self, elements: &str) {
        self.body.push_str(elements);
    }

    /// Puts the panel on the page, cut off at its frame, with a thin border.
    pub fn place(self, document: &mut Document) {
        let Frame { x, y, width, height } = self.frame;
        document.clipped((x, y), (width, height), &self.body);
        document.rectangle((x, y), (width, height), "panel");
    }

    fn path_data(&self, points: &[Vec2], closed: bool) -> String {
        let mut data = String::new();
        for point in points.iter().filter(|point| point.is_finite()) {
            let (p, command) = (self.page(*point), if data.is_empty() { 'M' } else { 'L' });
            let _ = write!(data, "{command}{} {}", number(p.x), number(p.y));
        }
        if closed && !data.is_empty() {
            data.push('Z');
        }
        data
    }

    fn path(&mut self, data: &str, class: &str) {
        if !data.is_empty() {
            let _ = writeln!(self.body, r#"<path d="{data}" class="{class}"/>"#);
        }
    }
}
