//! Finely cut stretches of boundary, taken together for cells that are wider than the detail.
//!
//! A stretch of a few millimetres that is cut into many pieces is enclosed by one disc with all of its normals: what
//! touches a piece touches the disc. So the search costs in proportion to the boundary's length, however finely it is cut.

use super::piece::{Piece, Vertex};
use crate::plane::{Bounds, wrap_angle};

/// Largest extent of a stretch that is taken together (m), and its widest range of normals (rad).
const EXTENT: f64 = 0.03;
const NORMALS: f64 = 1.6;
/// So many pieces within that are worth it.
const FEWEST: usize = 20;

/// The pieces in their order, runs of many short ones as one vertex each.
pub(super) fn bundled(pieces: &[Piece]) -> Vec<Piece> {
    let mut all = Vec::new();
    let mut start = 0;
    while start < pieces.len() {
        let run = Run::from(&pieces[start..]);
        if run.count >= FEWEST {
            all.push(Piece::Vertex(run.vertex()));
            start += run.count;
        } else {
            all.push(pieces[start]);
            start += 1;
        }
    }
    all
}

/// Consecutive pieces, and what encloses them.
struct Run {
    count: usize,
    bounds: Bounds,
    bow: f64,
    /// Where normals are counted from, and how far they turn to the right and left of it (rad).
    normal: f64,
    turned: (f64, f64),
    hollow: f64,
}

impl Run {
    /// As many of these pieces, from the first on, as stay near each other.
    fn from(pieces: &[Piece]) -> Self {
        let (normal, ..) = normals(&pieces[0]);
        let mut run = Self {
            count: 0,
            bounds: Bounds::EMPTY,
            bow: 0.0,
            normal,
            turned: (f64::INFINITY, f64::NEG_INFINITY),
            hollow: 0.0,
        };
        for piece in pieces {
            let longer = run.with(piece);
            let size = longer.bounds.size();
            if size.x.hypot(size.y) > EXTENT || longer.turned.1 - longer.turned.0 > NORMALS {
                break;
            }
            run = longer;
        }
        run
    }

    fn with(&self, piece: &Piece) -> Self {
        let [a, b] = piece.chord();
        let (normal, slack, bow, hollow) = normals(piece);
        let turn = wrap_angle(normal - self.normal);
        Self {
            count: self.count + 1,
            bounds: self.bounds.including(a).including(b),
            bow: self.bow.max(bow),
            normal: self.normal,
            turned: (self.turned.0.min(turn - slack), self.turned.1.max(turn + slack)),
            hollow: self.hollow.max(hollow),
        }
    }

    fn vertex(&self) -> Vertex {
        let (lo, hi) = self.turned;
        Vertex {
            point: (self.bounds.min + self.bounds.max) * 0.5,
            spread: 0.5 * self.bounds.size().norm() + self.bow,
            normal: wrap_angle(self.normal + 0.5 * (lo + hi)),
            slack: 0.5 * (hi - lo) + 1e-9,
            hollow: self.hollow,
        }
    }
}

/// A piece's normal, how far its normals differ from that (rad), how far it leaves its chord (m), and its curvature.
fn normals(piece: &Piece) -> (f64, f64, f64, f64) {
    match piece {
        Piece::Edge(e) => (e.normal, e.slack, e.bow, e.hollow),
        Piece::Vertex(v) => (v.normal, v.slack, v.spread, v.hollow),
    }
}
