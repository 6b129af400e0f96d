//! Preimages, drawn as the paper draws them: the strip of places around the boundary.

use super::axes::{scale_bar, ticks};
use super::canvas::{Canvas, Frame, WorldBounds};
use super::document::Document;
use super::legend::{Entry, LINE, Sample, legend};
use super::outlines::{Outline, OutlineRole, draw_outlines, outline_entries};
use crate::flow::preimage::StateGrid;
use crate::plane::{Pose2, Vec2};

/// What a figure of a preimage shows, map frame.
#[derive(Clone, Debug)]
pub struct PreimageFigure<'a> {
    /// The headline.
    pub title: String,
    /// The map.
    pub map: &'a [Outline],
    /// The states.
    pub states: &'a StateGrid,
    /// A heading whose slice is shown, too (rad).
    pub heading: Option<f64>,
}

const WIDTH: f64 = 620.0;

/// The figure as SVG text; the same states give the same bytes.
#[must_use]
pub fn preimage_figure(figure: &PreimageFigure<'_>) -> String {
    let corners = figure.map.iter().flat_map(|o| o.points.iter().copied());
    let size = WorldBounds::of(corners).map_or(Vec2::new(1.0, 1.0), |b| b.size());
    let height = (WIDTH * size.y / size.x.max(1e-6)).clamp(220.0, 720.0);
    let entries = preimage_legend(figure);
    let page = 64.0 + height + 60.0 + LINE * entries.len() as f64 + 16.0;
    let description = format!("{:.2} cm² of places", figure.states.area() * 1e4);
    let mut document = Document::new(WIDTH + 90.0, page, &figure.title, &description);
    document.text(20.0, 32.0, "heading", &figure.title);
    preimage_panel(&mut document, Frame { x: 64.0, y: 50.0, width: WIDTH, height }, figure);
    legend(&mut document, 64.0, 50.0 + height + 48.0, &entries);
    document.finish()
}

/// Draws the map and the states into a panel of a page, with axes.
pub fn preimage_panel(document: &mut Document, frame: Frame, figure: &PreimageFigure<'_>) {
    let states = figure.states;
    let raster = *states.raster();
    let rectangle = |run: &(usize, usize, usize)| {
        let (lo, hi) = (raster.corner(run.1, run.0), raster.corner(run.2, run.0 + 1));
        [lo, Vec2::new(hi.x, lo.y), hi, Vec2::new(lo.x, hi.y)]
    };
    let strip: Vec<[Vec2; 4]> = states.runs(None).iter().map(rectangle).collect();
    let shades = shades(states);
    let corners = figure.map.iter().flat_map(|o| o.points.iter().copied());
    let Some(bounds) = WorldBounds::of(corners.chain(strip.iter().flatten().copied())) else { return };
    let mut canvas = Canvas::new(frame, bounds.grown(0.02 * bounds.size().x.max(bounds.size().y)));
    draw_outlines(&mut canvas, figure.map);
    for (runs, class) in shades.iter().zip(SHADES) {
        canvas.polygons(&runs.iter().map(rectangle).collect::<Vec<_>>(), class);
    }
    let slice: Vec<[Vec2; 4]> = figure
        .heading
        .map_or_else(Vec::new, |theta| states.runs(Some(states.bin(theta))).iter().map(rectangle).collect());
    canvas.polygons(&slice, "slice");
    // Over the strips, which begin at the boundary.
    for outline in figure.map {
        let mut points = outline.points.clone();
        points.extend(outline.points.first().filter(|_| outline.closed));
        canvas.polyline(&points, if outline.role == OutlineRole::Wall { "wall" } else { "edge" });
    }
    if let (Some(theta), Some(place)) = (figure.heading, amid(&slice)) {
        canvas.arrow(Pose2::new(place.x, place.y, theta), 30.0, "estimate-line", "estimate");
    }
    ticks(document, &canvas, "map frame");
    scale_bar(document, &canvas, 30.0);
    canvas.place(document);
}

/// A place within the slice, where an arrow is seen: the middle of its longest run of cells.
fn amid(slice: &[[Vec2; 4]]) -> Option<Vec2> {
    let longest = slice.iter().max_by(|a, b| a[0].distance(a[1]).total_cmp(&b[0].distance(b[1])))?;
    Some((longest[0] + longest[2]) * 0.5)
}

/// Stylesheet classes of places, from few headings to many.
const SHADES: [&str; 4] = ["strip-1", "strip-2", "strip-3", "strip"];

/// Runs of cells along x whose share of headings is up to an eighth, a quarter, a half and all of the largest.
fn shades(states: &StateGrid) -> [Vec<(usize, usize, usize)>; 4] {
    let raster = states.raster();
    let headings = |row, column| states.heading_runs(column, row).iter().map(|(a, b)| b - a).sum::<usize>();
    let counts: Vec<Vec<usize>> =
        (0..raster.rows).map(|row| (0..raster.columns).map(|column| headings(row, column)).collect()).collect();
    let most = counts.iter().flatten().copied().max().unwrap_or(0);
    let shade = |count: usize| match count {
        0 => None,
        _ => Some([8, 4, 2].iter().take_while(|part| count * **part > most).count()),
    };
    let mut runs: [Vec<(usize, usize, usize)>; 4] = Default::default();
    for (row, counts) in counts.iter().enumerate() {
        let mut start = 0;
        for cells in counts.chunk_by(|&a, &b| shade(a) == shade(b)) {
            if let Some(shade) = shade(cells[0]) {
                runs[shade].push((row, start, start + cells.len()));
            }
            start += cells.len();
        }
    }
    runs
}

/// What the panel shows, in words.
#[must_use]
pub fn preimage_legend(figure: &PreimageFigure<'_>) -> Vec<Entry> {
    let mut entries = Vec::new();
    if !figure.states.is_empty() {
        let area = figure.states.area() * 1e4;
        let words = format!("places, darker with more headings: {area:.1} cm²");
        entries.push(Entry { sample: Sample::Patch("strip"), words });
    }
    if let Some(theta) = figure.heading {
        let area = figure.states.slice_area(theta) * 1e4;
        let words = format!("places with the arrow's heading, {:.0} degrees: {area:.1} cm²", theta.to_degrees());
        entries.push(Entry { sample: Sample::Patch("slice"), words });
    }
    entries.extend(outline_entries(figure.map));
    entries
}
