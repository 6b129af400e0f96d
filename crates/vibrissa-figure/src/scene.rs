//! A figure of one panel: layers of plain geometry under a headline, with ticks and a legend of what is drawn.

use super::axes::{scale_bar, ticks};
use super::canvas::{Canvas, Frame, WorldBounds};
use super::document::Document;
use super::legend::{Entry, LINE, Sample, legend};
use crate::plane::{Pose2, Vec2};

const WIDTH: f64 = 900.0;
const LEFT: f64 = 64.0;
const RIGHT: f64 = 24.0;
/// Largest height of the panel.
const TALLEST: f64 = 760.0;
/// Smallest height of the panel.
const LOWEST: f64 = 220.0;
/// Least that a panel shows (m).
const LEAST: f64 = 5e-3;
/// Length of a state's tick and of an arrow (px).
const TICK: f64 = 6.0;
const ARROW: f64 = 24.0;

/// What a layer holds (m).
#[derive(Clone, Debug, PartialEq)]
pub enum Geometry {
    /// Open lines.
    Lines(Vec<Vec<Vec2>>),
    /// Closed rings.
    Rings(Vec<Vec<Vec2>>),
    /// Dots; the class's stroke width is the diameter.
    Dots(Vec<Vec2>),
    /// Circles of 5 px.
    Circles(Vec<Vec2>),
    /// States: a dot with a tick along the heading.
    States(Vec<Pose2>),
    /// A disc with an arrow along the heading; the arrow's shaft has the class with `-line` behind it.
    Arrow(Pose2),
}

/// Geometry of one kind in one style.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// What is drawn.
    pub geometry: Geometry,
    /// The stylesheet's class.
    pub class: &'static str,
    /// Its words in the legend.
    pub label: String,
    /// Whether the panel is made large enough for it; else it is cut off.
    pub framed: bool,
}

impl Layer {
    pub(super) fn points(&self) -> Vec<Vec2> {
        match &self.geometry {
            Geometry::Lines(lines) | Geometry::Rings(lines) => lines.concat(),
            Geometry::Dots(dots) | Geometry::Circles(dots) => dots.clone(),
            Geometry::States(states) => states.iter().map(|state| state.position()).collect(),
            Geometry::Arrow(pose) => vec![pose.position()],
        }
    }

    pub(super) fn draw(&self, canvas: &mut Canvas) {
        match &self.geometry {
            Geometry::Lines(lines) => lines.iter().for_each(|line| canvas.polyline(line, self.class)),
            Geometry::Rings(rings) => rings.iter().for_each(|ring| canvas.polygon(ring, self.class)),
            Geometry::Dots(dots) => canvas.dots(dots.iter().copied(), self.class),
            Geometry::Circles(centres) => centres.iter().for_each(|centre| canvas.circle(*centre, 5.0, self.class)),
            Geometry::States(states) => {
                canvas.heading_ticks(states.iter().copied(), TICK, &format!("{}-tick", self.class));
                canvas.dots(states.iter().map(|state| state.position()), self.class);
            }
            Geometry::Arrow(pose) => {
                canvas.arrow(*pose, ARROW, &format!("{}-line", self.class), self.class);
                canvas.circle(pose.position(), 4.5, self.class);
            }
        }
    }

    pub(super) fn entry(&self) -> Entry {
        let sample = match &self.geometry {
            Geometry::Lines(_) => Sample::Line(self.class),
            // Only states have a heading; other ticks take a class without a stroke.
            Geometry::Dots(_) => Sample::Dots(self.class, "free"),
            Geometry::States(_) => Sample::Dots(self.class, self.class),
            Geometry::Rings(_) => Sample::Patch(self.class),
            Geometry::Circles(_) | Geometry::Arrow(_) => Sample::Circle(self.class),
        };
        Entry { sample, words: self.label.clone() }
    }
}

/// Draws layers, the first at the bottom; empty layers are neither drawn nor named. `frame` names the coordinates.
#[must_use]
pub fn scene_figure(title: &str, captions: &[String], frame: &str, layers: &[Layer]) -> String {
    let layers: Vec<&Layer> = layers.iter().filter(|layer| !layer.points().is_empty()).collect();
    let framed = layers.iter().filter(|layer| layer.framed).flat_map(|layer| layer.points());
    let origin = WorldBounds { min: Vec2::ZERO, max: Vec2::ZERO };
    let bounds = WorldBounds::of(framed).unwrap_or(origin);
    let size = bounds.size().x.max(bounds.size().y).max(LEAST);
    let world = bounds.grown(0.06 * size);
    let width = WIDTH - LEFT - RIGHT;
    let height = (width * world.size().y / world.size().x).clamp(LOWEST, TALLEST);
    let top = 52.0 + 20.0 * captions.len() as f64;
    let legend_top = top + height + 54.0;
    let rows = layers.len().div_ceil(2);
    let page = legend_top + LINE * rows as f64 + 20.0;

    let mut document = Document::new(WIDTH, page, title, &captions.join(" "));
    document.text(LEFT, 32.0, "title", title);
    for (index, caption) in captions.iter().enumerate() {
        document.text(LEFT, 54.0 + 20.0 * index as f64, "caption", caption);
    }
    let mut canvas = Canvas::new(Frame { x: LEFT, y: top, width, height }, world);
    layers.iter().for_each(|layer| layer.draw(&mut canvas));
    ticks(&mut document, &canvas, frame);
    scale_bar(&mut document, &canvas, 30.0);
    canvas.place(&mut document);
    let entries: Vec<Entry> = layers.iter().map(|layer| layer.entry()).collect();
    let (left, right) = entries.split_at(rows.min(entries.len()));
    legend(&mut document, LEFT, legend_top, left);
    legend(&mut document, LEFT + 0.5 * width, legend_top, right);
    document.finish()
}
