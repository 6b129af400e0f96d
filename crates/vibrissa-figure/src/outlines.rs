//! The map under a figure: the same ground, lines, bands and words in all of them.

use super::canvas::{Canvas, WorldBounds};
use super::legend::{Entry, Sample};
use crate::plane::Vec2;

/// What a line of the map bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutlineRole {
    /// Free space is inside.
    Arena,
    /// Free space is outside.
    Obstacle,
    /// A thin wall, solid on both sides.
    Wall,
}

/// One line of the map, flattened, map frame (m).
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// The corners, in order; a closed line does not repeat its first.
    pub points: Vec<Vec2>,
    /// What it bounds.
    pub role: OutlineRole,
    /// Whether the last corner is joined to the first.
    pub closed: bool,
    /// Parts of the band within which it is known to lie (m), one for each piece; none where it is exact.
    pub band: Vec<[Vec2; 4]>,
    /// Lines along the stretches of which nothing is known.
    pub unknown: Vec<Vec<Vec2>>,
}

impl Outline {
    /// A line that is known exactly.
    #[must_use]
    pub fn exact(points: Vec<Vec2>, role: OutlineRole, closed: bool) -> Self {
        Self { points, role, closed, band: Vec::new(), unknown: Vec::new() }
    }
}

/// Draws solid ground, arenas, obstacles and walls.
pub(crate) fn draw_outlines(canvas: &mut Canvas, outlines: &[Outline]) {
    let of = |role: OutlineRole| outlines.iter().filter(move |outline| outline.role == role);
    if of(OutlineRole::Arena).next().is_some() {
        let WorldBounds { min, max } = canvas.world();
        canvas.polygon(&[min, Vec2::new(max.x, min.y), max, Vec2::new(min.x, max.y)], "solid");
    }
    for (role, class) in
        [(OutlineRole::Arena, "arena"), (OutlineRole::Obstacle, "obstacle"), (OutlineRole::Wall, "wall")]
    {
        for outline in of(role) {
            if outline.closed {
                canvas.polygon(&outline.points, class);
            } else {
                canvas.polyline(&outline.points, class);
            }
        }
    }
    for outline in outlines {
        canvas.polygons(&outline.band, "map-band");
        for line in &outline.unknown {
            // The drawn line makes way for a dashed one.
            canvas.polyline(line, "unknown-gap");
            canvas.polyline(line, "unknown");
        }
    }
}

/// What [`draw_outlines`] draws, in words.
pub(crate) fn outline_entries(outlines: &[Outline]) -> Vec<Entry> {
    let has = |role: OutlineRole| outlines.iter().any(|outline| outline.role == role);
    let samples = [
        (has(OutlineRole::Wall), Sample::Line("wall"), "wall"),
        (has(OutlineRole::Obstacle), Sample::Patch("obstacle"), "obstacle"),
        (has(OutlineRole::Arena), Sample::Patch("arena"), "free space"),
        (
            outlines.iter().any(|outline| !outline.band.is_empty()),
            Sample::Patch("map-band"),
            "band that holds the wall",
        ),
        (outlines.iter().any(|outline| !outline.unknown.is_empty()), Sample::Line("unknown"), "unknown stretch"),
    ];
    let there = samples.into_iter().filter(|(there, ..)| *there);
    there.map(|(_, sample, words)| Entry { sample, words: words.into() }).collect()
}
