//! Contact sets, drawn as the paper draws them: where contacts can be, and the shapes that the whisker has there.

use super::axes::ticks;
use super::canvas::{Canvas, Frame, WorldBounds};
use super::document::Document;
use super::legend::{Entry, LINE, Sample, legend};
use crate::plane::Vec2;

/// What a figure of contacts shows, all in the frame of the whisker (m).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactFigure {
    /// The headline.
    pub title: String,
    /// The whisker's length (m).
    pub length: f64,
    /// Whisker shapes from base to tip.
    pub shapes: Vec<Vec<Vec2>>,
    /// Curves of contacts with what they explain; curves of one reading share their words.
    pub curves: Vec<(String, Vec<Vec2>)>,
    /// Polygons that cover a region of contacts.
    pub region: Vec<Vec<Vec2>>,
    /// Points at which curves meet.
    pub points: Vec<Vec2>,
}

/// Stylesheet classes of the readings' curves, in order.
const CURVES: [&str; 4] = ["contact-a", "contact-b", "contact-c", "contact-d"];
const SIZE: f64 = 460.0;

/// The figure as SVG text; the same contacts give the same bytes.
#[must_use]
pub fn contact_figure(figure: &ContactFigure) -> String {
    let entries = contact_legend(figure).len() as f64;
    let height = 64.0 + SIZE + 60.0 + LINE * entries + 16.0;
    let mut document =
        Document::new(SIZE + 90.0, height, &figure.title, "contact points and whisker shapes in the whisker frame");
    document.text(20.0, 32.0, "heading", &figure.title);
    contact_panel(&mut document, Frame { x: 64.0, y: 50.0, width: SIZE, height: SIZE }, figure);
    legend(&mut document, 64.0, 50.0 + SIZE + 48.0, &contact_legend(figure));
    document.finish()
}

/// Draws the contacts into a panel of a page, with axes.
pub fn contact_panel(document: &mut Document, frame: Frame, figure: &ContactFigure) {
    let all = figure.shapes.iter().chain(figure.curves.iter().map(|(_, c)| c)).chain(&figure.region).flatten().copied();
    let rest = [Vec2::ZERO, Vec2::new(figure.length, 0.0)];
    let Some(bounds) = WorldBounds::of(all.chain(figure.points.iter().copied()).chain(rest)) else { return };
    let mut canvas = Canvas::new(frame, bounds.grown(0.06 * bounds.size().x.max(bounds.size().y)));
    canvas.polyline(&rest, "undeflected");
    for shape in &figure.shapes {
        canvas.polyline(shape, "shape");
    }
    for (i, (_, curve)) in named(figure) {
        canvas.polyline(curve, CURVES[i % CURVES.len()]);
    }
    for polygon in &figure.region {
        canvas.polygon(polygon, region_class(figure));
    }
    for &point in &figure.points {
        canvas.circle(point, 5.0, "meeting");
    }
    canvas.circle(Vec2::ZERO, 4.0, "base");
    ticks(document, &canvas, "whisker frame");
    canvas.place(document);
}

/// What the panel shows, in words.
#[must_use]
pub fn contact_legend(figure: &ContactFigure) -> Vec<Entry> {
    let entry = |sample: Sample, words: &str| Entry { sample, words: words.into() };
    let mut entries = Vec::new();
    let mut seen = Vec::new();
    for (i, (words, _)) in named(figure) {
        if !seen.contains(&i) {
            seen.push(i);
            entries.push(entry(Sample::Line(CURVES[i % CURVES.len()]), &format!("contacts: {words}")));
        }
    }
    if !figure.region.is_empty() {
        entries.push(entry(Sample::Patch(region_class(figure)), "contacts that explain all readings"));
    }
    if !figure.shapes.is_empty() {
        entries.push(entry(Sample::Line("shape"), "whisker shapes"));
    }
    if !figure.points.is_empty() {
        entries.push(entry(Sample::Circle("meeting"), "where the curves meet"));
    }
    entries.push(entry(Sample::Line("undeflected"), "the whisker without contact"));
    entries
}

/// A region that lies on a curve is drawn darker than it: it may be as thin.
fn region_class(figure: &ContactFigure) -> &'static str {
    if figure.curves.is_empty() { "region" } else { "shared" }
}

/// The curves with a number for each distinct wording.
fn named(figure: &ContactFigure) -> impl Iterator<Item = (usize, &(String, Vec<Vec2>))> {
    let mut words: Vec<&str> = Vec::new();
    figure.curves.iter().map(move |curve| {
        let index = words.iter().position(|w| *w == curve.0).unwrap_or_else(|| {
            words.push(&curve.0);
            words.len() - 1
        });
        (index, curve)
    })
}
