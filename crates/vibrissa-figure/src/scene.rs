//! A figure of one panel: layers of plain geometry under a headline, with ticks and a legend of what is drawn.

use super::axes::{scale_bar, ticks};
use super::canvas::{Canvas, Frame, WorldBounds};
use super::document::Document;
use super::legend::{Entry, LINE, Sample, legend};
use super::outlines::{Outline, draw_outlines, outline_entries};
use super::places::places;
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
    /// Circles of 5 px, of true poses of 9.5 px.
    Circles(Vec<Vec2>),
    /// States: a dot with a tick along the heading.
    States(Vec<Pose2>),
    /// A disc with an arrow along the heading; the arrow's shaft has the class with `-line` behind it.
    Arrow(Pose2),
    /// Places that explain the same log, the first the likeliest: arrows with their numbers beside them. The class is that of the
    /// numbers' discs.
    Places(Vec<Pose2>),
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
            Geometry::States(states) | Geometry::Places(states) => {
                states.iter().map(|state| state.position()).collect()
            }
            Geometry::Arrow(pose) => vec![pose.position()],
        }
    }

    /// Whether any of it may lie in a piece of the world: points do or do not, lines and rings may cross it.
    pub(super) fn may_be_seen(&self, world: WorldBounds) -> bool {
        match &self.geometry {
            Geometry::Lines(lines) | Geometry::Rings(lines) => lines.iter().any(|line| {
                WorldBounds::of(line.iter().copied()).is_some_and(|b| {
                    b.min.x <= world.max.x && b.max.x >= world.min.x && b.min.y <= world.max.y && b.max.y >= world.min.y
                })
            }),
            _ => self.points().into_iter().any(|point| world.contains(point)),
        }
    }

    /// Points and lines that a number should not hide.
    fn lines(&self) -> Vec<Vec<Vec2>> {
        match &self.geometry {
            Geometry::Lines(lines) | Geometry::Rings(lines) => lines.clone(),
            _ => self.points().into_iter().map(|point| vec![point]).collect(),
        }
    }

    /// Draws the layer over `beneath`.
    pub(super) fn draw(&self, canvas: &mut Canvas, beneath: &[&Layer]) {
        match &self.geometry {
            Geometry::Lines(lines) => lines.iter().for_each(|line| canvas.polyline(line, self.class)),
            Geometry::Rings(rings) => rings.iter().for_each(|ring| canvas.polygon(ring, self.class)),
            Geometry::Dots(dots) => canvas.dots(dots.iter().copied(), self.class),
            Geometry::Circles(centres) => {
                // A true pose lies around the estimate's disc.
                let radius = if self.class == "truth-mark" { 9.5 } else { 5.0 };
                centres.iter().for_each(|centre| canvas.circle(*centre, radius, self.class));
            }
            Geometry::States(states) => {
                canvas.heading_ticks(states.iter().copied(), TICK, &format!("{}-tick", self.class));
                canvas.dots(states.iter().map(|state| state.position()), self.class);
            }
            Geometry::Arrow(pose) => {
                canvas.arrow(*pose, ARROW, &format!("{}-line", self.class), self.class);
                canvas.circle(pose.position(), 4.5, self.class);
            }
            Geometry::Places(poses) => {
                let drawn: Vec<Vec<Vec2>> = beneath.iter().flat_map(|layer| layer.lines()).collect();
                places(canvas, poses, &drawn);
            }
        }
    }

    pub(super) fn entry(&self) -> Entry {
        let sample = match &self.geometry {
            Geometry::Lines(_) => Sample::Line(self.class),
            // Only states have a heading; other ticks take a class without a stroke.
            Geometry::Dots(_) => Sample::Dots(self.class, "free"),
            Geometry::States(_) => Sample::Dots(self.class, ticks_of(self.class)),
            Geometry::Rings(_) => Sample::Patch(self.class),
            Geometry::Circles(_) => Sample::Circle(self.class),
            Geometry::Arrow(_) | Geometry::Places(_) => Sample::Heading(self.class, "estimate-line"),
        };
        Entry { sample, words: self.label.clone() }
    }
}

/// The class of the ticks of states.
fn ticks_of(class: &'static str) -> &'static str {
    match class {
        "candidate" => "candidate-tick",
        "survivor" => "survivor-tick",
        "earlier" => "earlier-tick",
        "motion-end" => "motion-end-tick",
        "decision" => "decision-tick",
        other => other,
    }
}

/// Draws `layers`, the first at the bottom, one upon the other.
pub(super) fn draw_layers(canvas: &mut Canvas, layers: &[&Layer]) {
    for (index, layer) in layers.iter().enumerate() {
        layer.draw(canvas, &layers[..index]);
    }
}

/// Draws layers, the first at the bottom; empty layers are neither drawn nor named. `frame` names the coordinates.
#[must_use]
pub fn scene_figure(title: &str, captions: &[String], frame: &str, layers: &[Layer]) -> String {
    map_figure(title, captions, frame, &[], layers)
}

/// Draws layers on a map, as [`scene_figure`] does; what bounds free space looks as it does in every other figure.
#[must_use]
pub fn map_figure(title: &str, captions: &[String], frame: &str, map: &[Outline], layers: &[Layer]) -> String {
    let layers: Vec<&Layer> = layers.iter().filter(|layer| !layer.points().is_empty()).collect();
    let corners = map.iter().flat_map(|outline| outline.points.iter().copied());
    let framed = layers.iter().filter(|layer| layer.framed).flat_map(|layer| layer.points()).chain(corners);
    let origin = WorldBounds { min: Vec2::ZERO, max: Vec2::ZERO };
    let bounds = WorldBounds::of(framed).unwrap_or(origin);
    let size = bounds.size().x.max(bounds.size().y).max(LEAST);
    let world = bounds.grown(0.06 * size);
    let width = WIDTH - LEFT - RIGHT;
    let height = (width * world.size().y / world.size().x).clamp(LOWEST, TALLEST);
    let top = 52.0 + 20.0 * captions.len() as f64;
    let legend_top = top + height + 54.0;
    let mut entries: Vec<Entry> = layers.iter().map(|layer| layer.entry()).collect();
    entries.extend(outline_entries(map));
    let rows = entries.len().div_ceil(2);
    let page = legend_top + LINE * rows as f64 + 20.0;

    let mut document = Document::new(WIDTH, page, title, &captions.join(" "));
    document.text(LEFT, 32.0, "title", title);
    for (index, caption) in captions.iter().enumerate() {
        document.text(LEFT, 54.0 + 20.0 * index as f64, "caption", caption);
    }
    let mut canvas = Canvas::new(Frame { x: LEFT, y: top, width, height }, world);
    draw_outlines(&mut canvas, map);
    draw_layers(&mut canvas, &layers);
    ticks(&mut document, &canvas, frame);
    scale_bar(&mut document, &canvas, 30.0);
    canvas.place(&mut document);
    let (left, right) = entries.split_at(rows.min(entries.len()));
    legend(&mut document, LEFT, legend_top, left);
    legend(&mut document, LEFT + 0.5 * width, legend_top, right);
    document.finish()
}
