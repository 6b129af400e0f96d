//! A simulated sweep: the map, the way, the whiskers, and what they feel over time.

use super::axes::{scale_bar, ticks};
use super::canvas::{Canvas, Frame, WorldBounds};
use super::chart::Chart;
use super::document::Document;
use super::legend::{Entry, LINE, Sample, legend};
use super::localization::words::wrapped;
use super::outlines::{Outline, draw_outlines, outline_entries};
use crate::flow::pose::StampedPose;
use crate::plane::Vec2;

/// Readings of one whisker over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// The whisker's name.
    pub name: String,
    /// What was recorded: time (s) and value.
    pub read: Vec<(f64, f64)>,
    /// What is true, where it has the same unit.
    pub exact: Vec<(f64, f64)>,
}

/// All that the figure of a simulation shows.
#[derive(Clone, Copy, Debug)]
pub struct SimulationScene<'a> {
    /// The headline.
    pub title: &'a str,
    /// One line below it.
    pub caption: &'a str,
    /// The map.
    pub map: &'a [Outline],
    /// The true way, map frame.
    pub path: &'a [StampedPose],
    /// The robot's outline in its own frame (m); empty when it has none.
    pub robot: &'a [Vec2],
    /// Whisker shapes along the way, map frame (m).
    pub shapes: &'a [Vec<Vec2>],
    /// Touched points, map frame (m).
    pub touches: &'a [Vec2],
    /// The readings.
    pub series: &'a [Series],
    /// What the readings are, with their unit.
    pub quantity: &'a str,
}

const PAGE_WIDTH: f64 = 840.0;
const MARGIN: f64 = 20.0;
const LEFT: f64 = 62.0;
const WIDTH: f64 = 748.0;
const MAP_HEIGHT: (f64, f64) = (150.0, 560.0);
const CHART_HEIGHT: f64 = 170.0;
const TOP: f64 = 78.0;
const TITLE_CHARACTERS: usize = 70;
const TITLE_LINE: f64 = 24.0;
/// At most this many readings of all series together are drawn; of more, every n-th of each.
const READINGS: usize = 3000;
/// The classes of lines that are told apart by their colour; of more, they repeat.
pub const HUES: [&str; 8] = [
    "series hue0",
    "series hue1",
    "series hue2",
    "series hue3",
    "series hue4",
    "series hue5",
    "series hue6",
    "series hue7",
];
const LEGEND_COLUMN: f64 = 380.0;

/// The figure as SVG text; the same scene gives the same bytes.
#[must_use]
pub fn simulation_figure(scene: &SimulationScene<'_>) -> String {
    let title = wrapped(scene.title, TITLE_CHARACTERS);
    let top = TOP + TITLE_LINE * (title.len().max(1) - 1) as f64;
    let mut canvas = map_canvas(scene, top);
    let chart_top = top + canvas.frame().height + 74.0;
    let entries = entries(scene);
    let (left, right) = entries.split_at(entries.len().div_ceil(2));
    let legend_top = chart_top + CHART_HEIGHT + 46.0;
    let height = legend_top + LINE * left.len() as f64 + MARGIN;
    let mut document = Document::new(PAGE_WIDTH, height, scene.title, scene.caption);
    for (index, line) in title.iter().enumerate() {
        document.text(MARGIN, 34.0 + TITLE_LINE * index as f64, "title", line);
    }
    document.text(MARGIN, top - 20.0, "caption", scene.caption);
    draw_world(&mut canvas, scene);
    ticks(&mut document, &canvas, "map frame");
    scale_bar(&mut document, &canvas, 30.0);
    canvas.place(&mut document);
    let frame = Frame { x: LEFT, y: chart_top, width: WIDTH, height: CHART_HEIGHT };
    draw_chart(&mut document, scene, frame);
    legend(&mut document, LEFT, legend_top, left);
    legend(&mut document, LEFT + LEGEND_COLUMN, legend_top, right);
    document.finish()
}

fn map_canvas(scene: &SimulationScene<'_>, top: f64) -> Canvas {
    let map = scene.map.iter().flat_map(|outline| outline.points.iter().copied());
    let way = scene.path.iter().map(|pose| pose.map_from_robot.position());
    let bounds = WorldBounds::of(map.chain(way).chain(scene.shapes.iter().flatten().copied()));
    let bounds = bounds.unwrap_or(WorldBounds { min: Vec2::ZERO, max: Vec2::new(1.0, 1.0) });
    let size = bounds.size();
    let bounds = bounds.grown((0.02 * size.x.max(size.y)).max(1e-3));
    let size = bounds.size();
    let height = (WIDTH * size.y / size.x).clamp(MAP_HEIGHT.0, MAP_HEIGHT.1);
    Canvas::new(Frame { x: LEFT, y: top, width: WIDTH, height }, bounds)
}

fn draw_world(canvas: &mut Canvas, scene: &SimulationScene<'_>) {
    draw_outlines(canvas, scene.map);
    canvas.marks(scene.touches, "touch");
    for shape in scene.shapes {
        canvas.polyline(shape, "whisker");
    }
    let way: Vec<Vec2> = scene.path.iter().map(|pose| pose.map_from_robot.position()).collect();
    canvas.trail(&way, "path");
    for pose in scene.path.first().into_iter().chain(scene.path.last()) {
        let outline: Vec<Vec2> = scene.robot.iter().map(|&p| pose.map_from_robot.transform_point(p)).collect();
        canvas.polygon(&outline, "robot");
    }
    if let (Some(first), Some(last)) = (scene.path.first(), scene.path.last()) {
        canvas.circle(first.map_from_robot.position(), 4.0, "start");
        canvas.arrow(last.map_from_robot, 24.0, "estimate-line", "estimate");
    }
}

fn draw_chart(document: &mut Document, scene: &SimulationScene<'_>, frame: Frame) {
    let all = || scene.series.iter().flat_map(|series| series.read.iter().chain(&series.exact));
    let range = |pick: fn(&(f64, f64)) -> f64| {
        let values = all().map(pick).filter(|v| v.is_finite());
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| (lo.min(v), hi.max(v)))
    };
    let (time, (lo, hi)) = (range(|p| p.0), range(|p| p.1));
    let margin = 0.06 * (hi - lo);
    let mut chart = Chart::new(frame, time, (lo - margin, hi + margin));
    for (index, series) in scene.series.iter().enumerate() {
        let hue = index % HUES.len();
        let most = READINGS / scene.series.len();
        chart.dots(&thinned(&series.read, most), &format!("reading hue{hue}"));
        chart.line(&thinned(&series.exact, most), &format!("series hue{hue}"));
    }
    chart.place(document, "time, s", scene.quantity);
}

fn thinned(points: &[(f64, f64)], most: usize) -> Vec<(f64, f64)> {
    points.iter().step_by(points.len().div_ceil(most.max(1)).max(1)).copied().collect()
}

fn entries(scene: &SimulationScene<'_>) -> Vec<Entry> {
    let entry = |sample: Sample, words: &str| Entry { sample, words: words.to_owned() };
    let mut entries = vec![entry(Sample::Line("path"), "the robot's way, from the circle to the arrow")];
    if !scene.shapes.is_empty() {
        entries.push(entry(Sample::Line("whisker"), "whiskers along the way"));
    }
    if !scene.touches.is_empty() {
        entries.push(entry(Sample::Line("touch"), "touched points"));
    }
    for (index, series) in scene.series.iter().enumerate() {
        let words = if series.exact.is_empty() {
            format!("{}: recorded (dots)", series.name)
        } else {
            format!("{}: recorded (dots), exact (line)", series.name)
        };
        entries.push(entry(Sample::Line(HUES[index % HUES.len()]), &words));
    }
    entries.extend(outline_entries(scene.map));
    entries
}
