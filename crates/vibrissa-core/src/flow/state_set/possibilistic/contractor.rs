//! Contractor of one reading \[jaulin2001applied, ch. 4; chabert2009contractor\]: which part of a cell can explain it.
//!
//! A piece of boundary with normal `n` explains the reading if the whisker touches it there with the force along `n`: on
//! an edge, base and contact differ along the normal by the whisker's reach `u(psi) · p(psi)` with `psi = n - heading`;
//! at a vertex they differ by the contact itself. Both are linear over a small cell up to bounds, so that each piece and
//! each entry of the reading's slice cut a slanted strip out of the cell. What the strips leave together is kept.

use super::contraction::{Contraction, is_whole};
use super::edge_contractor::{may_touch, on_edge};
use super::errors::PoseSlack;
use super::parallelotope::{LinearForm, Parallelotope};
use super::record::{ReadingContacts, SideContacts};
use super::thick_piece::{COARSE, FINE, PieceIndex, ThickPiece};
use super::vertex_contractor::at_vertex;
use crate::beam::press::{PressEntry, PressSlice};
use crate::config::two_contacts;
use crate::math;
use crate::plane::{Bounds, Pose2, Vec2};
use crate::world::Map;
use core::f64::consts::{PI, TAU};

/// Cells wider than this in heading (rad) or place (m) are compared with the coarse pieces,
const WIDE_TURN: f64 = 0.02;
const WIDE_REACH: f64 = 8e-3;
/// and those wider than this with bundles of pieces.
const WIDEST_TURN: f64 = 0.12;
const WIDEST_REACH: f64 = 0.03;
/// Cells no wider than this are compared with the parts of pieces.
const SMALL_TURN: f64 = 0.012;
const SMALL_REACH: f64 = 2.5e-3;
/// Cells whose bases lie in a larger rectangle (m, half of its sides together) are hardly ever whole by one piece.
const LAST_PIECE_REACH: f64 = 6e-3;

/// The map's pieces, from fine to coarse.
#[derive(Clone, Debug)]
pub(super) struct BoundaryLevels {
    pub(super) fine: BoundaryLevel,
    pub(super) coarse: BoundaryLevel,
    pub(super) clustered: BoundaryLevel,
}

/// All pieces, and those that curve towards free space.
#[derive(Clone, Debug)]
pub(super) struct BoundaryLevel {
    pub(super) all: PieceIndex,
    pub(super) concavity: PieceIndex,
}

impl BoundaryLevel {
    fn new(all: PieceIndex) -> Self {
        Self { concavity: all.concavity(), all }
    }

    /// The pieces on which these contacts can be.
    pub(super) fn pieces(&self, touch: &ReadingContacts, bending: &SideContacts) -> &PieceIndex {
        if bending.all_inflected && touch.holding > 0.0 { &self.concavity } else { &self.all }
    }
}

impl BoundaryLevels {
    pub(super) fn new(map: &Map) -> Self {
        let coarse = PieceIndex::new(map, COARSE);
        Self {
            fine: BoundaryLevel::new(PieceIndex::with_leaves(map, FINE)),
            clustered: BoundaryLevel::new(coarse.clustered()),
            coarse: BoundaryLevel::new(coarse),
        }
    }

    /// The level for a cell, and its number: a wide one gains nothing from fine detail.
    fn level(&self, view: &BaseView) -> (usize, &BoundaryLevel) {
        let reach = view.reach.x + view.reach.y;
        if view.turn > WIDEST_TURN || reach > WIDEST_REACH {
            (2, &self.clustered)
        } else if view.turn > WIDE_TURN || reach > WIDE_REACH {
            (1, &self.coarse)
        } else {
            (0, &self.fine)
        }
    }
}

/// The angle brought within half a turn of the half turn (rad).
pub(super) fn around_half_turn(angle: f64) -> f64 {
    let turns = (angle - PI) * (1.0 / TAU);
    // To the nearest, ties away from zero; a cast is cheaper than a call.
    angle - TAU * (turns + 0.5_f64.copysign(turns)) as i64 as f64
}

/// The length of a vector, without the care for overflow that maps do not need.
pub(super) fn size(v: Vec2) -> f64 {
    v.norm_squared().sqrt()
}

/// A cell as a whisker's base at one record.
pub(super) struct BaseView {
    /// The base, map frame, and the whisker's heading.
    pub(super) base: Vec2,
    pub(super) heading: f64,
    /// Sine and cosine of the heading.
    pub(super) sin: f64,
    pub(super) cos: f64,
    /// How base and heading depend on the cell's sides.
    pub(super) moves: [Vec2; 3],
    pub(super) turns: LinearForm,
    /// Half the range of headings, and half the rectangle around the bases.
    pub(super) turn: f64,
    pub(super) reach: Vec2,
    /// What place and heading may be off beyond that: odometry, and what the linear model leaves.
    pub(super) slop: f64,
    pub(super) slop_turn: f64,
}

impl BaseView {
    /// The cell seen after the robot moved by `step` (known to `place` m and `turn` rad) for a whisker mounted so.
    pub(super) fn new(cell: &Parallelotope, step: Pose2, (place, off): (f64, f64), robot_from_whisker: Pose2) -> Self {
        let to_base = step.compose(robot_from_whisker);
        let arm = to_base.position().rotated(cell.center.theta);
        let lever = arm.perp();
        let moves = cell.sides.map(|s| Vec2::new(s[0], s[1]) + lever * s[2]);
        let turns = cell.sides.map(|s| s[2]);
        let turn = turns.iter().map(|t| t.abs()).sum::<f64>();
        let slop = place + off * size(robot_from_whisker.position()) + 0.5 * size(arm) * turn * turn + 1e-9;
        let heading = cell.center.theta + to_base.theta;
        let (sin, cos) = math::sin_cos(heading);
        let wide = moves.iter().fold(Vec2::ZERO, |sum, m| sum + Vec2::new(m.x.abs(), m.y.abs()));
        Self {
            base: cell.place() + arm,
            heading,
            sin,
            cos,
            moves,
            turns,
            turn,
            reach: wide + Vec2::new(slop, slop),
            slop,
            slop_turn: off,
        }
    }

    /// The same with the base off by as much as it may.
    pub(super) fn with_base(mut self, base: PoseSlack) -> Self {
        self.slop += base.place;
        self.slop_turn += base.turn;
        self.reach += Vec2::new(base.place, base.place);
        self
    }

    /// Whether it is too wide to be told that corners are out of play.
    pub(super) fn is_wide(&self) -> bool {
        self.turn + self.slop_turn > two_contacts::WIDE_TURN || self.reach.x + self.reach.y > two_contacts::WIDE_REACH
    }

    /// A direction of the map in the whisker frame.
    pub(super) fn to_whisker(&self, v: Vec2) -> Vec2 {
        Vec2::new(self.cos * v.x + self.sin * v.y, self.cos * v.y - self.sin * v.x)
    }

    /// The form of a displacement along `direction` plus `by_turn` times the turn.
    pub(super) fn form(&self, direction: Vec2, by_turn: f64) -> LinearForm {
        let of = |j: usize| direction.dot(self.moves[j]) + by_turn * self.turns[j];
        [of(0), of(1), of(2)]
    }
}

/// What of the cell explains the reading by some contact; none if nothing does. Pieces and entries looked at are counted.
pub(super) fn contract(
    view: &BaseView,
    touch: &ReadingContacts,
    ground: &BoundaryLevels,
    comparisons: &mut usize,
) -> Option<Contraction> {
    let (grade, level) = ground.level(view);
    let is_small = view.turn < SMALL_TURN && view.reach.x + view.reach.y < SMALL_REACH;
    if view.reach.x + view.reach.y < LAST_PIECE_REACH
        && let Some(left) = contract_by_last_piece(view, touch, (grade, level, is_small), comparisons)
    {
        return Some(left);
    }
    let mut left = None;
    for bending in &touch.sides {
        let pieces = level.pieces(touch, bending);
        let bounds = rectangle(view, bending);
        pieces.near(bounds, |piece, index| {
            *comparisons += with_leaves(view, touch, bending, (piece, pieces, is_small), &mut left);
            let is_whole = is_whole(&left);
            if is_whole {
                bending.last_piece.note(grade, index);
            }
            is_whole
        });
        if is_whole(&left) {
            break;
        }
    }
    left
}

/// What the piece alone leaves on which the whisker last stood in all of a cell: often that is all of this one, too; none if not.
fn contract_by_last_piece(
    view: &BaseView,
    touch: &ReadingContacts,
    (grade, level, is_small): (usize, &BoundaryLevel, bool),
    comparisons: &mut usize,
) -> Option<Contraction> {
    for bending in &touch.sides {
        let pieces = level.pieces(touch, bending);
        let Some(piece) = bending.last_piece.of(grade).and_then(|index| pieces.all.get(index)) else { continue };
        let mut left = None;
        *comparisons += with_leaves(view, touch, bending, (piece, pieces, is_small), &mut left);
        if is_whole(&left) {
            return left;
        }
    }
    None
}

/// Contacts on a piece, for small cells on its leaves; how many pieces and entries were looked at.
fn with_leaves(
    view: &BaseView,
    touch: &ReadingContacts,
    bending: &SideContacts,
    (piece, pieces, is_small): (&ThickPiece, &PieceIndex, bool),
    left: &mut Option<Contraction>,
) -> usize {
    let mut comparisons = 1;
    match piece {
        ThickPiece::Edge(edge) if is_small && edge.leaves.0 < edge.leaves.1 => {
            if may_touch(view, touch, bending, edge) {
                for leaf in &pieces.leaves[edge.leaves.0 as usize..edge.leaves.1 as usize] {
                    comparisons += 1 + on_piece(view, touch, bending, leaf, left);
                    if is_whole(left) {
                        break;
                    }
                }
            }
        }
        _ => comparisons += on_piece(view, touch, bending, piece, left),
    }
    comparisons
}

/// The rectangle in the map around all places where the whisker can touch.
fn rectangle(view: &BaseView, bending: &SideContacts) -> Bounds {
    let Bounds { min, max } = bending.bounds;
    let (center, half) = ((min + max) * 0.5, (max - min) * 0.5);
    let (sin, cos) = (view.sin, view.cos);
    let swing = (view.turn + view.slop_turn) * bending.farthest;
    let wide = Vec2::new(
        cos.abs() * half.x + sin.abs() * half.y + swing + view.reach.x,
        sin.abs() * half.x + cos.abs() * half.y + swing + view.reach.y,
    );
    let middle = view.base + Vec2::new(cos * center.x - sin * center.y, sin * center.x + cos * center.y);
    Bounds { min: middle - wide, max: middle + wide }
}

/// An entry of a slice as it is, mirrored where the whisker bends to the right.
#[derive(Clone, Copy)]
pub(super) struct ContactEntry {
    /// From the direction asked for to the entry's middle (rad).
    pub(super) ahead: f64,
    pub(super) half: f64,
    pub(super) center: Vec2,
    pub(super) by_direction: Vec2,
    pub(super) by_moment: Vec2,
    pub(super) radius: f64,
    /// No less than the lengths of the three vectors.
    pub(super) sizes: [f64; 3],
    pub(super) inflected: bool,
}

/// Calls `visit` for each entry that meets the directions within `wide` of `psi` (rad, whisker frame, any turn).
pub(super) fn contacts(side: f64, slice: &PressSlice, psi: f64, wide: f64, mut visit: impl FnMut(&ContactEntry)) {
    // The table's directions lie around the half turn.
    let asked = around_half_turn(side * psi);
    let known = slice.directions();
    for asked in [asked - TAU, asked, asked + TAU] {
        if asked + wide < known.lo() || asked - wide > known.hi() {
            continue;
        }
        for entry in slice.between(asked - wide, asked + wide) {
            visit(&mirrored(entry, side, asked));
        }
    }
}

impl ContactEntry {
    /// The part of the entry's range, counted from its middle, within `wide` of the direction asked for (rad).
    pub(super) fn within(&self, wide: f64) -> (f64, f64) {
        let from = (-self.ahead - wide).clamp(-self.half, self.half);
        (from, (-self.ahead + wide).clamp(from, self.half))
    }
}

/// The entry seen from the direction `asked`, on its side.
pub(super) fn mirrored(entry: &PressEntry, side: f64, asked: f64) -> ContactEntry {
    ContactEntry {
        ahead: side * (entry.middle - asked),
        half: entry.half,
        center: Vec2::new(entry.center.x, side * entry.center.y),
        by_direction: Vec2::new(side * entry.by_direction.x, entry.by_direction.y),
        by_moment: Vec2::new(entry.by_moment.x, side * entry.by_moment.y),
        radius: entry.radius,
        sizes: [about(entry.center), about(entry.by_direction), about(entry.by_moment)],
        inflected: entry.inflected,
    }
}

/// No less than the length of a vector, and at most a twelfth more: the octagon around its circle.
fn about(v: Vec2) -> f64 {
    let (x, y) = (v.x.abs(), v.y.abs());
    x.max(y) + 0.415 * x.min(y)
}

fn on_piece(
    view: &BaseView,
    touch: &ReadingContacts,
    bending: &SideContacts,
    piece: &ThickPiece,
    left: &mut Option<Contraction>,
) -> usize {
    match piece {
        ThickPiece::Edge(edge) => on_edge(view, touch, bending, edge, left),
        ThickPiece::Vertex(vertex) => at_vertex(view, touch, bending, vertex, left),
    }
}

/// Most and least of a linear form over the states that matter.
pub(super) struct Strip {
    pub(super) form: LinearForm,
    pub(super) range: (f64, f64),
}
