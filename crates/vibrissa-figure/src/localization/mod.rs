//! The answer to "where is the robot", drawn so that it explains itself.

pub(super) mod layers;
mod readout;
pub(super) mod words;

use super::axes::{scale_bar, ticks};
use super::canvas::{Canvas, Frame, WorldBounds};
use super::document::Document;
use super::legend::{Entry, LINE, legend};
use super::outlines::draw_outlines;
use crate::flow::pose::{Localization, StampedPose, Status};
pub use crate::outlines::{Outline, OutlineRole};
use crate::plane::{Pose2, Vec2};
pub use words::{verdict, wrapped};

/// All that a localization figure shows.
#[derive(Clone, Copy, Debug)]
pub struct LocalizationScene<'a> {
    /// The headline: usually the names of the log and the map.
    pub title: &'a str,
    /// The map.
    pub map: &'a [Outline],
    /// The answer.
    pub answer: &'a Localization,
    /// The true trajectory in the map frame, where known.
    pub truth: Option<&'a [StampedPose]>,
    /// The robot's outline in its own frame (m); empty when it has none.
    pub robot: &'a [Vec2],
}

const PAGE_WIDTH: f64 = 840.0;
const MARGIN: f64 = 20.0;
const MAP_LEFT: f64 = 62.0;
const MAP_WIDTH: f64 = 470.0;
const MAP_HEIGHT: (f64, f64) = (280.0, 620.0);
const SIDE_LEFT: f64 = 560.0;
/// The map's width where nothing stands beside it.
const WIDE_MAP: f64 = PAGE_WIDTH - MARGIN - MAP_LEFT;
const DETAIL_SIZE: f64 = 200.0;
/// A close-up appears when it shows less than this share of the map.
const DETAIL_SHARE: f64 = 0.3;
/// The least that the close-up of the estimate shows (m).
const DETAIL_LEAST: f64 = 4e-3;
const CAPTION_CHARACTERS: usize = 104;
/// Where the second column of the legend starts, from the first.
const LEGEND_COLUMN: f64 = 380.0;

/// The figure as SVG text: map, path, whisker shapes, all candidates, the survivors, the estimate and how wide it is.
///
/// The legend names exactly what is drawn and stands in its own margin. The same scene gives the same bytes.
#[must_use]
pub fn localization_figure(scene: &LocalizationScene<'_>) -> String {
    let caption = verdict(scene.answer);
    let caption_lines = wrapped(&caption, CAPTION_CHARACTERS);
    let top = 78.0 + 19.0 * caption_lines.len() as f64;
    let map = map_canvas(scene, top);
    let side = readout::lines(scene);
    let close_up = detail_canvas(scene, &map, top).is_some() || sweep_canvas(scene, &map, top).is_some();
    // Without a close-up the column beside the map would be all but empty.
    let map = if close_up { map } else { map_canvas_of(scene, top, WIDE_MAP) };
    let detail = detail_canvas(scene, &map, top);
    let entries = layers::legend_entries(scene, &map);

    let legend_top = map.frame().y + map.frame().height + 52.0;
    let side_left = if close_up { SIDE_LEFT } else { MAP_LEFT + LEGEND_COLUMN };
    let side_top = match &detail {
        _ if !close_up => legend_top,
        Some(canvas) => canvas.frame().y + DETAIL_SIZE + 36.0,
        None => top - 4.0,
    };
    let side_bottom = side_top + LINE * side.len() as f64;
    let sweep = sweep_canvas(scene, &map, side_bottom + 34.0);
    let side_bottom = sweep.as_ref().map_or(side_bottom, |canvas| canvas.frame().y + DETAIL_SIZE + 24.0);
    // The second column would run under the side: beside a long side the legend is one column.
    let crowded = side_bottom > legend_top;
    let (left, right) = entries.split_at(if crowded { entries.len() } else { entries.len().div_ceil(2) });
    let height = (legend_top + LINE * left.len() as f64).max(side_bottom) + MARGIN;

    let mut document = Document::new(PAGE_WIDTH, height, scene.title, &caption);
    document.text(MARGIN, 34.0, "title", scene.title);
    for (index, line) in caption_lines.iter().enumerate() {
        document.text(MARGIN, 58.0 + 19.0 * index as f64, "caption", line);
    }
    draw_map(&mut document, scene, map, detail.as_ref());
    if let Some(canvas) = detail {
        draw_detail(&mut document, scene, canvas);
    }
    if let Some(canvas) = sweep {
        draw_sweep(&mut document, scene, canvas);
    }
    readout::draw(&mut document, side_left, side_top, &side);
    legend(&mut document, MAP_LEFT, legend_top, left);
    legend(&mut document, MAP_LEFT + LEGEND_COLUMN, legend_top, right);
    document.finish()
}

fn draw_sweep(document: &mut Document, scene: &LocalizationScene<'_>, mut canvas: Canvas) {
    draw_outlines(&mut canvas, scene.map);
    layers::truth(&mut canvas, scene, 22.0);
    layers::whiskers(&mut canvas, scene.answer);
    layers::path(&mut canvas, scene.answer);
    layers::estimate(&mut canvas, scene, false);
    let frame = canvas.frame();
    document.text(frame.x, frame.y - 8.0, "heading", "Close up: the sweep");
    scale_bar(document, &canvas, 16.0);
    canvas.place(document);
}

fn draw_map(document: &mut Document, scene: &LocalizationScene<'_>, mut canvas: Canvas, detail: Option<&Canvas>) {
    draw_outlines(&mut canvas, scene.map);
    layers::candidates(&mut canvas, scene.answer, 5.0);
    layers::truth(&mut canvas, scene, 22.0);
    layers::whiskers(&mut canvas, scene.answer);
    layers::path(&mut canvas, scene.answer);
    layers::survivors(&mut canvas, scene.answer, 9.0);
    if let Some(detail) = detail {
        layers::zoomed(&mut canvas, detail.world());
    }
    layers::estimate(&mut canvas, scene, false);
    ticks(document, &canvas, "map frame");
    scale_bar(document, &canvas, 30.0);
    canvas.place(document);
}

fn draw_detail(document: &mut Document, scene: &LocalizationScene<'_>, mut canvas: Canvas) {
    draw_outlines(&mut canvas, scene.map);
    layers::candidates(&mut canvas, scene.answer, 9.0);
    layers::path(&mut canvas, scene.answer);
    layers::survivors(&mut canvas, scene.answer, 14.0);
    // Over the survivors, which may cover all of the close-up.
    layers::truth(&mut canvas, scene, 46.0);
    layers::estimate(&mut canvas, scene, true);
    let frame = canvas.frame();
    let heading = if scene.answer.hypotheses.len() > 1 { "Close up: place 1" } else { "Close up: the estimate" };
    document.text(frame.x, frame.y - 8.0, "heading", heading);
    scale_bar(document, &canvas, 16.0);
    canvas.place(document);
}

pub(super) fn map_canvas(scene: &LocalizationScene<'_>, top: f64) -> Canvas {
    map_canvas_of(scene, top, MAP_WIDTH)
}

fn map_canvas_of(scene: &LocalizationScene<'_>, top: f64, width: f64) -> Canvas {
    let answer = scene.answer;
    let path = answer.trajectory.iter().chain(scene.truth.unwrap_or_default()).map(|row| row.map_from_robot);
    let poses = path.chain(answer.hypotheses.iter().map(|hypothesis| hypothesis.pose)).chain(answer.estimate);
    let corners = scene.map.iter().flat_map(|outline| outline.points.iter().copied());
    let shapes = layers::placed_shapes(answer).flatten();
    let bounds = WorldBounds::of(corners.chain(poses.map(Pose2::position)).chain(shapes))
        .unwrap_or(WorldBounds { min: Vec2::ZERO, max: Vec2::new(1.0, 1.0) });
    let size = bounds.size();
    // Room for the arrow of an estimate at the rim.
    let bounds = bounds.grown((0.07 * size.x.max(size.y)).max(1e-3));
    let size = bounds.size();
    let height = (width * size.y / size.x).clamp(MAP_HEIGHT.0, MAP_HEIGHT.1);
    Canvas::new(Frame { x: MAP_LEFT, y: top, width, height }, bounds)
}

/// A square around the path and the whisker shapes, where that is small against the map.
fn sweep_canvas(scene: &LocalizationScene<'_>, map: &Canvas, top: f64) -> Option<Canvas> {
    let path = scene.answer.trajectory.iter().map(|row| row.map_from_robot.position());
    let bounds = WorldBounds::of(path.chain(layers::placed_shapes(scene.answer).flatten()))?;
    let (size, shown) = (bounds.size(), map.world().size());
    let half = 0.58 * size.x.max(size.y);
    if half <= 0.0 || 2.0 * half > DETAIL_SHARE * shown.x.max(shown.y) {
        return None;
    }
    let world = WorldBounds { min: bounds.centre(), max: bounds.centre() }.grown(half);
    let frame = Frame { x: SIDE_LEFT, y: top, width: DETAIL_SIZE, height: DETAIL_SIZE };
    Some(Canvas::new(frame, world))
}

/// A square around the first hypothesis and the true end, where that is small against the map.
fn detail_canvas(scene: &LocalizationScene<'_>, map: &Canvas, top: f64) -> Option<Canvas> {
    if scene.answer.status == Status::Inconsistent {
        return None;
    }
    let estimate = scene.answer.estimate?.position();
    let mut points = vec![estimate];
    if let Some(first) = scene.answer.hypotheses.first() {
        let (x, y) = (first.extent.x, first.extent.y);
        points.extend([Vec2::new(x.lo(), y.lo()), Vec2::new(x.hi(), y.hi())]);
    }
    let bounds = WorldBounds::of(points.iter().copied())?;
    let shown = map.world().size();
    let limit = DETAIL_SHARE * shown.x.max(shown.y);
    // A true end far from the estimate would shrink the estimate to nothing: leave it out then.
    let with_truth = WorldBounds::of(points.into_iter().chain(scene.true_end().map(Pose2::position)))?;
    let bounds = if with_truth.size().x.max(with_truth.size().y) < 0.4 * limit { with_truth } else { bounds };
    let half = (0.75 * bounds.size().x.max(bounds.size().y)).max(0.5 * DETAIL_LEAST);
    if 2.0 * half > limit {
        return None;
    }
    let centre = bounds.centre();
    let world = WorldBounds { min: centre, max: centre }.grown(half);
    let frame = Frame { x: SIDE_LEFT, y: top, width: DETAIL_SIZE, height: DETAIL_SIZE };
    Some(Canvas::new(frame, world))
}

impl LocalizationScene<'_> {
    /// The true pose at the time of the last estimate.
    fn true_end(&self) -> Option<Pose2> {
        let last = self.answer.trajectory.last()?;
        crate::flow::trajectory::pose_at(self.truth?, last.t)
    }
}

/// A count with its noun, which takes an `s` for all but one.
fn counted(count: usize, noun: &str) -> String {
    if count == 1 { format!("1 {noun}") } else { format!("{count} {noun}s") }
}

fn entry(sample: super::Sample, words: impl Into<String>) -> Entry {
    Entry { sample, words: words.into() }
}
