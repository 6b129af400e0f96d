//! Pieces that were drawn one by one, joined to outlines.

use crate::config::budgets::MOST_MEETING;
use crate::config::limits::FLATTEN_TOLERANCE;
use crate::plane::{Curve, Segment, SegmentTree, Vec2};
use crate::text::beyond;
use crate::{Error, Result};
use std::collections::BTreeMap;

/// How near two ends are taken to be one (m).
const MEETING: f64 = 1e-6;

/// Segments in a row, and the line of the file at which they begin.
pub(super) struct Piece {
    pub(super) segments: Vec<Segment>,
    pub(super) closed: bool,
    pub(super) line: usize,
}

/// The pieces as outlines; walls stay as drawn, other pieces are joined end to end until they close.
pub(super) fn joined(pieces: Vec<Piece>, walls: bool) -> Result<Vec<Piece>> {
    let mut done = Vec::new();
    let mut ends = Ends::default();
    for mut piece in pieces {
        piece.close();
        if piece.closed || walls {
            done.push(piece);
        } else {
            ends.add(piece)?;
        }
    }
    while let Some(mut chain) = ends.take_any() {
        while !chain.closed {
            let Some(next) = ends.take_at(chain.end()) else { return Err(open(&chain, &ends)) };
            chain.append(next);
            chain.close();
        }
        done.push(chain);
    }
    Ok(done)
}

fn open(chain: &Piece, ends: &Ends) -> Error {
    let (at, start) = (chain.end(), chain.start());
    let others = ends.open.iter().flatten().flat_map(|piece| [piece.start(), piece.end()]);
    let nearest = others.chain([start]).map(|p| p.distance(at)).fold(f64::INFINITY, f64::min);
    Error::data("the outline is open")
        .at_line(chain.line)
        .value(format!("it ends at ({:.6}, {:.6}) m, {nearest:.2e} m from the nearest other end", at.x, at.y))
        .remedy("draw it to the end with object snap, or put it on a layer wall… if it is a thin line")
}

impl Piece {
    fn start(&self) -> Vec2 {
        self.segments.first().map_or(Vec2::ZERO, Segment::start)
    }

    fn end(&self) -> Vec2 {
        self.segments.last().map_or(Vec2::ZERO, Segment::end)
    }

    /// Closes what ends where it starts.
    fn close(&mut self) {
        let (start, end) = (self.start(), self.end());
        let turns = self.segments.len() > 1 || matches!(self.segments[..], [Segment::Cubic(_)]);
        if self.closed && start.distance(end) > MEETING {
            self.segments.push(Segment::Line([end, start]));
        } else if self.closed || (turns && start.distance(end) <= MEETING) {
            self.closed = true;
            if let Some(last) = self.segments.last_mut() {
                *last = ending_at(*last, start);
            }
        }
    }

    /// Adds a piece that begins or ends where this one ends.
    fn append(&mut self, next: Self) {
        let at = self.end();
        let ahead = next.start().distance(at) <= next.end().distance(at);
        let mut segments = next.segments;
        if !ahead {
            segments = segments.iter().rev().map(Segment::reversed).collect();
        }
        if let Some(first) = segments.first_mut() {
            *first = ending_at(first.reversed(), at).reversed();
        }
        self.segments.append(&mut segments);
    }
}

/// The same piece with its last point moved.
fn ending_at(segment: Segment, end: Vec2) -> Segment {
    match segment {
        Segment::Line([a, _]) => Segment::Line([a, end]),
        Segment::Quadratic([a, b, _]) => Segment::Quadratic([a, b, end]),
        Segment::Cubic([a, b, c, _]) => Segment::Cubic([a, b, c, end]),
    }
}

/// Open pieces by the places of their ends.
#[derive(Default)]
struct Ends {
    open: Vec<Option<Piece>>,
    /// Pieces with an end in a square of the size of a meeting.
    at: BTreeMap<(i64, i64), Vec<usize>>,
    next: usize,
}

fn square(p: Vec2) -> (i64, i64) {
    ((p.x / MEETING).floor() as i64, (p.y / MEETING).floor() as i64)
}

impl Ends {
    fn add(&mut self, piece: Piece) -> Result<()> {
        for end in [piece.start(), piece.end()] {
            let here = self.at.entry(square(end)).or_default();
            if here.len() >= MOST_MEETING {
                let remedy = "remove lines that were drawn twice (in CAD programs: OVERKILL), or lines without length";
                let error = beyond("too many lines end in one point", here.len() + 1, MOST_MEETING, remedy);
                return Err(error.at_line(piece.line));
            }
            here.push(self.open.len());
        }
        self.open.push(Some(piece));
        Ok(())
    }

    /// The first piece that is still there.
    fn take_any(&mut self) -> Option<Piece> {
        while let Some(slot) = self.open.get_mut(self.next) {
            self.next += 1;
            if let Some(piece) = slot.take() {
                return Some(piece);
            }
        }
        None
    }

    /// A piece with an end at `p`.
    fn take_at(&mut self, p: Vec2) -> Option<Piece> {
        let (x, y) = square(p);
        for key in (-1..=1).flat_map(|i| (-1..=1).map(move |j| (x.saturating_add(i), y.saturating_add(j)))) {
            let Some(here) = self.at.get_mut(&key) else { continue };
            here.retain(|&i| self.open[i].is_some());
            let meets = |piece: &Piece| piece.start().distance(p).min(piece.end().distance(p)) <= MEETING;
            if let Some(&i) = here.iter().find(|&&i| self.open[i].as_ref().is_some_and(meets)) {
                return self.open[i].take();
            }
        }
        None
    }
}

/// In how many of the other closed curves each one lies wholly.
pub(super) fn depths(curves: &[(Curve, usize)]) -> Vec<usize> {
    let chains: Vec<Vec<[Vec2; 2]>> = curves
        .iter()
        .map(|(curve, _)| curve.flatten(FLATTEN_TOLERANCE).windows(2).map(|pair| [pair[0], pair[1]]).collect())
        .collect();
    let trees: Vec<SegmentTree> = chains.iter().map(|chain| SegmentTree::new(chain)).collect();
    let inside = |i: usize, j: usize| {
        let (inner, outer) = (trees[i].bounds(), trees[j].bounds());
        let fits = inner.min.x >= outer.min.x
            && inner.min.y >= outer.min.y
            && inner.max.x <= outer.max.x
            && inner.max.y <= outer.max.y;
        i != j
            && fits
            && trees[j].ray_crossings(chains[i][0][0]) % 2 == 1
            && !chains[i].iter().any(|[a, b]| trees[j].crosses(*a, *b))
    };
    (0..curves.len()).map(|i| (0..curves.len()).filter(|&j| inside(i, j)).count()).collect()
}
