//! Small figures for a page that holds many: one panel, no wider than a phone, with its legend below.

use super::axes::ticks;
use super::canvas::{Canvas, Frame, WorldBounds};
use super::chart::Chart;
use super::contacts::{ContactFigure, contact_legend, contact_panel};
use super::document::Document;
use super::legend::{Entry, LINE, Sample, legend};
use super::localization::words::wrapped;
use super::outlines::{Outline, draw_outlines, outline_entries};
use super::scene::{Layer, draw_layers};
use super::states::{PreimageFigure, preimage_legend, preimage_panel};

/// Width of every plate (px).
pub const PLATE_WIDTH: f64 = 420.0;

const LEFT: f64 = 48.0;
/// Room for half of a tick's label.
const RIGHT: f64 = 20.0;
const PANEL: f64 = PLATE_WIDTH - LEFT - RIGHT;
const TITLE_CHARACTERS: usize = 54;
const LEGEND_CHARACTERS: usize = 56;
const TITLE_LINE: f64 = 18.0;
/// Room under a panel for ticks and the words of its axes.
const AXIS: f64 = 44.0;
/// Heights of a panel that shows a piece of a map.
const MAP_HEIGHT: (f64, f64) = (150.0, 420.0);
const CHART_HEIGHT: f64 = 210.0;

/// A piece of a map with layers of plain geometry on it, map frame.
#[derive(Clone, Debug)]
pub struct MapPlate<'a> {
    /// The headline.
    pub title: &'a str,
    /// The map.
    pub map: &'a [Outline],
    /// What is drawn on it, the first at the bottom; empty layers are neither drawn nor named.
    pub layers: &'a [Layer],
    /// What is shown (m); none shows the map and all framed layers.
    pub window: Option<WorldBounds>,
    /// Names the coordinates.
    pub frame: &'a str,
}

/// One line or cloud of dots of a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct ChartSeries {
    /// Its words in the legend.
    pub label: String,
    /// The stylesheet's class.
    pub class: &'static str,
    /// Its points, in the units of the axes.
    pub points: Vec<(f64, f64)>,
    /// Whether the points are joined.
    pub joined: bool,
}

impl ChartSeries {
    fn sample(&self) -> Sample {
        // Dots of a chart have no heading: their ticks take a class without a stroke.
        if self.joined { Sample::Line(self.class) } else { Sample::Dots(self.class, "free") }
    }
}

/// A contact set as a plate.
#[must_use]
pub fn contact_plate(figure: &ContactFigure) -> String {
    let points = figure.shapes.iter().chain(figure.curves.iter().map(|(_, c)| c)).flatten().copied();
    let size = WorldBounds::of(points).map_or(1.0, |b| b.size().y / b.size().x.max(1e-9));
    let height = (PANEL * size).clamp(190.0, 330.0);
    plate(&figure.title, height, &contact_legend(figure), |document, frame| contact_panel(document, frame, figure))
}

/// A preimage as a plate.
#[must_use]
pub fn preimage_plate(figure: &PreimageFigure<'_>) -> String {
    let corners = figure.map.iter().flat_map(|o| o.points.iter().copied());
    let ratio = WorldBounds::of(corners).map_or(1.0, |b| b.size().y / b.size().x.max(1e-9));
    let height = (PANEL * ratio).clamp(MAP_HEIGHT.0, MAP_HEIGHT.1);
    plate(&figure.title, height, &preimage_legend(figure), |document, frame| preimage_panel(document, frame, figure))
}

/// A piece of a map as a plate; the same geometry gives the same bytes.
#[must_use]
pub fn map_plate(figure: &MapPlate<'_>) -> String {
    let all: Vec<&Layer> = figure.layers.iter().filter(|layer| !layer.points().is_empty()).collect();
    let corners = figure.map.iter().flat_map(|o| o.points.iter().copied());
    let framed = all.iter().filter(|layer| layer.framed).flat_map(|layer| layer.points());
    let whole = || {
        let bounds = WorldBounds::of(corners.chain(framed))?;
        Some(bounds.grown(0.04 * bounds.size().x.max(bounds.size().y)))
    };
    let origin = WorldBounds { min: crate::plane::Vec2::ZERO, max: crate::plane::Vec2::new(1.0, 1.0) };
    let world = figure.window.or_else(whole).unwrap_or(origin);
    let height = (PANEL * world.size().y / world.size().x.max(1e-9)).clamp(MAP_HEIGHT.0, MAP_HEIGHT.1);
    // What lies outside of the window is not named.
    let layers: Vec<&Layer> = all.into_iter().filter(|layer| layer.may_be_seen(world)).collect();
    let mut entries: Vec<Entry> = layers.iter().map(|layer| layer.entry()).collect();
    entries.extend(outline_entries(figure.map));
    plate(figure.title, height, &entries, |document, frame| {
        let mut canvas = Canvas::new(frame, world);
        draw_outlines(&mut canvas, figure.map);
        draw_layers(&mut canvas, &layers);
        ticks(document, &canvas, figure.frame);
        canvas.place(document);
    })
}

/// A chart as a plate.
#[must_use]
pub fn chart_plate(title: &str, x_words: &str, y_words: &str, series: &[ChartSeries]) -> String {
    let entries: Vec<Entry> = series.iter().map(|s| Entry { sample: s.sample(), words: s.label.clone() }).collect();
    let range = |pick: fn(&(f64, f64)) -> f64, air: f64| {
        let values = series.iter().flat_map(|s| &s.points).map(pick).filter(|v| v.is_finite());
        let (lo, hi) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| (lo.min(v), hi.max(v)));
        (lo - air * (hi - lo), hi + air * (hi - lo))
    };
    // The words of the upright axis stand above the panel.
    plate(title, CHART_HEIGHT + TITLE_LINE, &entries, |document, frame| {
        let inner = Frame { y: frame.y + TITLE_LINE, height: frame.height - TITLE_LINE, ..frame };
        let mut chart = Chart::new(inner, range(|p| p.0, 0.02), range(|p| p.1, 0.06));
        for one in series {
            if one.joined {
                chart.line(&one.points, one.class);
            } else {
                chart.dots(&one.points, one.class);
            }
        }
        chart.place(document, x_words, y_words);
    })
}

/// Title, panel, legend.
fn plate(title: &str, height: f64, entries: &[Entry], draw: impl FnOnce(&mut Document, Frame)) -> String {
    let lines = wrapped(title, TITLE_CHARACTERS);
    let top = 14.0 + TITLE_LINE * lines.len().max(1) as f64;
    let entries: Vec<Entry> = entries.iter().map(shortened).collect();
    let legend_top = top + height + AXIS;
    let page = legend_top + LINE * entries.len() as f64 + 6.0;
    let mut document = Document::new(PLATE_WIDTH, page, title, title);
    for (index, line) in lines.iter().enumerate() {
        document.text(6.0, 18.0 + TITLE_LINE * index as f64, "heading", line);
    }
    draw(&mut document, Frame { x: LEFT, y: top, width: PANEL, height });
    legend(&mut document, 6.0, legend_top, &entries);
    document.finish()
}

/// An entry whose words fit beside its sample.
fn shortened(entry: &Entry) -> Entry {
    let words = wrapped(&entry.words, LEGEND_CHARACTERS);
    let words = match words.as_slice() {
        [first, _, ..] => format!("{first} …"),
        _ => entry.words.clone(),
    };
    Entry { sample: entry.sample, words }
}
