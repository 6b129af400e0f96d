//! A panel with values over time.

use super::axes::round_length;
use super::canvas::Frame;
use super::document::{Document, number};
use std::fmt::Write;

/// A panel whose axes have units of their own.
pub(super) struct Chart {
    frame: Frame,
    x: (f64, f64),
    y: (f64, f64),
    body: String,
}

impl Chart {
    /// A panel in `frame` that shows these ranges; a range of one value is widened, and one of none is made up.
    pub(super) fn new(frame: Frame, x: (f64, f64), y: (f64, f64)) -> Self {
        let wide = |(lo, hi): (f64, f64)| match (lo.is_finite() && hi.is_finite(), hi > lo) {
            (true, true) => (lo, hi),
            (true, false) => (lo - 0.5, lo + 0.5),
            (false, _) => (0.0, 1.0),
        };
        Self { frame, x: wide(x), y: wide(y), body: String::new() }
    }

    fn page(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let Frame { x: left, y: top, width, height } = self.frame;
        let share = |v: f64, (lo, hi): (f64, f64)| (v - lo) / (hi - lo);
        (left + width * share(x, self.x), top + height * (1.0 - share(y, self.y)))
    }

    /// Draws a chain of points.
    pub(super) fn line(&mut self, points: &[(f64, f64)], class: &str) {
        let mut data = String::new();
        for &point in points.iter().filter(|(x, y)| x.is_finite() && y.is_finite()) {
            let (x, y) = self.page(point);
            // Writing into a string cannot fail.
            let _ = write!(data, "{}{} {}", if data.is_empty() { 'M' } else { 'L' }, number(x), number(y));
        }
        let _ = writeln!(self.body, r#"<path d="{data}" class="{class}"/>"#);
    }

    /// Draws a dot for each point.
    pub(super) fn dots(&mut self, points: &[(f64, f64)], class: &str) {
        let mut data = String::new();
        for &point in points.iter().filter(|(x, y)| x.is_finite() && y.is_finite()) {
            let (x, y) = self.page(point);
            let _ = write!(data, "M{} {}h0", number(x), number(y));
        }
        let _ = writeln!(self.body, r#"<path d="{data}" class="{class}"/>"#);
    }

    /// Puts the panel on the page with ticks and the words of its axes.
    pub(super) fn place(self, document: &mut Document, x_words: &str, y_words: &str) {
        let Frame { x: left, y: top, width, height } = self.frame;
        let bottom = top + height;
        for value in ticks(self.x, 9.0) {
            let (x, _) = self.page((value, 0.0));
            document.line((x, bottom), (x, bottom + 4.0), "tick");
            document.text(x, bottom + 16.0, "small middle", &short(value));
        }
        for value in ticks(self.y, 5.0) {
            let (_, y) = self.page((0.0, value));
            document.line((left, y), (left + width, y), "grid");
            document.line((left - 4.0, y), (left, y), "tick");
            document.text(left - 7.0, y + 4.0, "small end", &short(value));
        }
        document.text(left + width, bottom + 32.0, "small end", x_words);
        document.text(left, top - 7.0, "small", y_words);
        document.clipped((left, top), (width, height), &self.body);
        document.rectangle((left, top), (width, height), "panel");
    }
}

/// About `count` round values in a range.
fn ticks((lo, hi): (f64, f64), count: f64) -> Vec<f64> {
    let step = round_length((hi - lo) / count * 1.5);
    let first = (lo / step).ceil();
    let many = ((hi / step).floor() - first).clamp(-1.0, 50.0) as i64 + 1;
    (0..many).map(|k| (first + k as f64) * step).collect()
}

fn short(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" || text.is_empty() { "0".into() } else { text.into() }
}
