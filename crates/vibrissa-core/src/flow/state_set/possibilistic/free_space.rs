//! Free-space constraint on a cell: where the whisker or its base cannot be.

use super::contractor::{BaseView, size};
use super::errors::RestShape;
use super::thick_piece::{PieceIndex, ThickEdge, ThickPiece};
use crate::plane::{Bounds, Vec2};
use crate::world::Map;

/// What rounding and flattening may add (m).
const MARGIN: f64 = 5e-6;

/// Whether the whisker's base can be in free space in some state of the cell.
pub(super) fn base_may_be_free(view: &BaseView, map: &Map) -> bool {
    let reach = size(view.reach) + MARGIN;
    map.is_free(view.base)
        || map.nearest_within(view.base, reach + map.widest_bound()).is_some()
        || map.unknown().may_hold(view.base, reach)
}

/// Whether the whisker at rest can lie in free space in some state of the cell.
pub(super) fn whisker_may_be_free(view: &BaseView, rest: &RestShape, pieces: &PieceIndex) -> bool {
    let chord_may_be_free = |ends: &[Vec2]| {
        let [a, b] = [ends[0], ends[1]].map(|p| view.base + p.rotated(view.heading));
        let far = size(ends[0]).max(size(ends[1]));
        let off = size(view.reach) + far * (view.turn + view.slop_turn) + MARGIN + rest.off;
        let mut free = true;
        pieces.near(Bounds::of(&[a, b]), |piece, _| {
            if let ThickPiece::Edge(edge) = piece {
                free &= !surely_crosses(a, b, off, edge);
            }
            !free
        });
        free
    };
    rest.points.windows(2).all(chord_may_be_free)
}

/// Whether every segment with ends within `off` of `a` and `b` crosses the edge from its free side.
fn surely_crosses(a: Vec2, b: Vec2, off: f64, edge: &ThickEdge) -> bool {
    let normal = edge.along.perp();
    let off = off + edge.sagitta;
    let (before, behind) = (normal.dot(a - edge.start), normal.dot(b - edge.start));
    if before <= off || behind >= -off {
        return false;
    }
    // Where it crosses, the unmoved segment is within `off` of the edge's line.
    let at = |distance: f64| {
        let share = ((before - distance) / (before - behind)).clamp(0.0, 1.0);
        edge.along.dot(a + (b - a) * share - edge.start)
    };
    let (p, q) = (at(off), at(-off));
    p.min(q) - off > 0.0 && p.max(q) + off < edge.length
}
