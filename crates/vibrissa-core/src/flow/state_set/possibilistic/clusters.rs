//! Clusters of short boundary pieces, enclosed together for cells that are wider than the detail.
//!
//! A stretch of a few millimetres that is cut into many pieces is enclosed by one disc with all of its normals: what
//! touches a piece touches the disc. So the search costs in proportion to the boundary's length, however finely it is cut.

use super::thick_piece::{ThickPiece, ThickVertex};
use crate::math;
use crate::plane::{Bounds, wrap_angle};

/// Largest extent of a stretch that is taken together (m), and its widest range of normals (rad).
const EXTENT: f64 = 0.03;
const NORMALS: f64 = 1.6;
/// So many pieces within that are worth it.
const FEWEST: usize = 20;

/// The pieces in their order, runs of many short ones as one vertex each.
pub(super) fn clustered(pieces: &[ThickPiece]) -> Vec<ThickPiece> {
    let mut all = Vec::new();
    let mut start = 0;
    while start < pieces.len() {
        let run = PieceRun::from(&pieces[start..]);
        if run.count >= FEWEST {
            all.push(ThickPiece::Vertex(run.vertex()));
            start += run.count;
        } else {
            all.push(pieces[start]);
            start += 1;
        }
    }
    all
}

/// Consecutive pieces, and what encloses them.
struct PieceRun {
    count: usize,
    bounds: Bounds,
    sagitta: f64,
    /// Where normals are counted from, and how far they turn to the right and left of it (rad).
    normal: f64,
    turned: (f64, f64),
    concavity: f64,
}

impl PieceRun {
    /// As many of these pieces, from the first on, as stay near each other.
    fn from(pieces: &[ThickPiece]) -> Self {
        let (normal, ..) = normals(&pieces[0]);
        let mut run = Self {
            count: 0,
            bounds: Bounds::EMPTY,
            sagitta: 0.0,
            normal,
            turned: (f64::INFINITY, f64::NEG_INFINITY),
            concavity: 0.0,
        };
        for piece in pieces {
            let longer = run.with(piece);
            let size = longer.bounds.size();
            if math::hypot(size.x, size.y) > EXTENT || longer.turned.1 - longer.turned.0 > NORMALS {
                break;
            }
            run = longer;
        }
        run
    }

    fn with(&self, piece: &ThickPiece) -> Self {
        let [a, b] = piece.chord();
        let (normal, slack, sagitta, concavity) = normals(piece);
        let turn = wrap_angle(normal - self.normal);
        Self {
            count: self.count + 1,
            bounds: self.bounds.including(a).including(b),
            sagitta: self.sagitta.max(sagitta),
            normal: self.normal,
            turned: (self.turned.0.min(turn - slack), self.turned.1.max(turn + slack)),
            concavity: self.concavity.max(concavity),
        }
    }

    fn vertex(&self) -> ThickVertex {
        let (lo, hi) = self.turned;
        ThickVertex {
            point: (self.bounds.min + self.bounds.max) * 0.5,
            spread: 0.5 * self.bounds.size().norm() + self.sagitta,
            normal: wrap_angle(self.normal + 0.5 * (lo + hi)),
            slack: 0.5 * (hi - lo) + 1e-9,
            concavity: self.concavity,
        }
    }
}

/// A piece's normal, how far its normals differ from that (rad), how far it leaves its chord (m), and its curvature.
fn normals(piece: &ThickPiece) -> (f64, f64, f64, f64) {
    match piece {
        ThickPiece::Edge(e) => (e.normal, e.slack, e.sagitta, e.concavity),
        ThickPiece::Vertex(v) => (v.normal, v.slack, v.spread, v.concavity),
    }
}
