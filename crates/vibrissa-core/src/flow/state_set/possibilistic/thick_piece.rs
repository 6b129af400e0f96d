//! The map as thick pieces: chords with a sagitta, and points with a cone of normals.

use super::band_blur::{Blur, discs};
use super::clusters;
use crate::plane::{Bounds, Segment, SegmentTree, Vec2, wrap_angle};
use crate::world::{Boundary, Map, PieceCourse};
use core::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

/// How coarsely the map is cut: the largest turn within an edge (rad), and how far it may leave its chord (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PieceResolution {
    turn: f64,
    sagitta: f64,
}

/// For cells that are small already.
pub(super) const FINE: PieceResolution = PieceResolution { turn: 0.04, sagitta: 3e-5 };
/// For cells that are wider than what it leaves open.
pub(super) const COARSE: PieceResolution = PieceResolution { turn: 0.1, sagitta: 1.5e-4 };
/// Edges no longer than this (m) may turn and leave their chord by more: tight curves are not cut any finer.
const SHORT: f64 = 1.5e-3;
const SHORT_TURN: f64 = 0.4;
const SHORT_SAGITTA: f64 = 1e-4;
/// A turn between edges beyond this makes a vertex (rad).
const CORNER: f64 = 0.06;
/// Turns smaller than this are rounding (rad).
const NO_TURN: f64 = 1e-6;
/// What rounding and the readers' tolerance for arcs may add (m).
const ROUNDING: f64 = 1e-8;

/// A stretch of boundary that a whisker can touch, map frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ThickPiece {
    Edge(ThickEdge),
    Vertex(ThickVertex),
}

/// All points within `sagitta` of a chord, with normals within `slack` of the chord's; free space on the left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ThickEdge {
    pub(super) start: Vec2,
    pub(super) along: Vec2,
    pub(super) length: f64,
    /// Direction of the normal towards free space (rad).
    pub(super) normal: f64,
    pub(super) slack: f64,
    pub(super) sagitta: f64,
    /// Curvature towards free space (1/m), which can hold a tip; infinite where a vertex was smoothed.
    pub(super) concavity: f64,
    /// Its parts where it is made of several: from and to before, among the leaves.
    pub(super) leaves: (u32, u32),
}

/// Every point within `spread` of one, with every normal within `slack` of `normal`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ThickVertex {
    pub(super) point: Vec2,
    pub(super) spread: f64,
    pub(super) normal: f64,
    pub(super) slack: f64,
    pub(super) concavity: f64,
}

/// A link of a chain: its ends, how far the curve leaves the chord, and the range of tangents (rad, unrolled).
#[derive(Clone, Copy, Debug)]
struct ChainLink {
    from: Vec2,
    to: Vec2,
    sagitta: f64,
    tangent: (f64, f64),
    /// Its tangents at the ends (rad).
    ends: (f64, f64),
    /// No less than its curvature to the left and to the right (1/m).
    curvature: (f64, f64),
    /// How far the wall may be from it.
    blur: Blur,
}

/// The pieces with a tree over their chords.
#[derive(Clone, Debug)]
pub(super) struct PieceIndex {
    pub(super) all: Vec<ThickPiece>,
    /// Edges and turns one by one, which the edges of `all` take together.
    pub(super) leaves: Arc<[ThickPiece]>,
    tree: SegmentTree,
    /// No piece leaves its chord by more (m).
    margin: f64,
}

impl PieceIndex {
    pub(super) fn new(map: &Map, grain: PieceResolution) -> Self {
        Self::laid(map, grain, None)
    }

    /// The pieces with their leaves.
    pub(super) fn with_leaves(map: &Map, grain: PieceResolution) -> Self {
        Self::laid(map, grain, Some(Vec::new()))
    }

    fn laid(map: &Map, grain: PieceResolution, mut leaves: Option<Vec<ThickPiece>>) -> Self {
        let mut all = Vec::new();
        for boundary in map.boundaries() {
            add_boundary(boundary, grain, &mut all, &mut leaves);
        }
        Self::of(all, leaves.unwrap_or_default().into())
    }

    /// The same, with finely cut stretches taken together.
    pub(super) fn clustered(&self) -> Self {
        Self::of(clusters::clustered(&self.all), Arc::default())
    }

    /// Those of them that curve towards free space anywhere.
    pub(super) fn concavity(&self) -> Self {
        let curves = |piece: &&ThickPiece| match piece {
            ThickPiece::Edge(e) => e.concavity > 0.0,
            ThickPiece::Vertex(v) => v.concavity > 0.0,
        };
        Self::of(self.all.iter().filter(curves).copied().collect(), Arc::clone(&self.leaves))
    }

    fn of(mut all: Vec<ThickPiece>, leaves: Arc<[ThickPiece]>) -> Self {
        all.shrink_to_fit();
        let chords: Vec<_> = all.iter().map(ThickPiece::chord).collect();
        let sagitta = |piece: &ThickPiece| match piece {
            ThickPiece::Edge(e) => e.sagitta,
            ThickPiece::Vertex(v) => v.spread,
        };
        Self { tree: SegmentTree::new(&chords), margin: all.iter().map(sagitta).fold(0.0, f64::max), all, leaves }
    }

    /// Calls `visit` with every piece that may have a point in the rectangle, and its index, until it answers true.
    pub(super) fn near(&self, bounds: Bounds, mut visit: impl FnMut(&ThickPiece, usize) -> bool) {
        let margin = Vec2::new(self.margin, self.margin);
        let grown = Bounds { min: bounds.min - margin, max: bounds.max + margin };
        self.tree.for_each_in(grown, |edge, _| visit(&self.all[edge], edge));
    }
}

impl ThickPiece {
    /// Its ends.
    pub(super) fn chord(&self) -> [Vec2; 2] {
        match self {
            Self::Edge(e) => [e.start, e.start + e.along * e.length],
            Self::Vertex(v) => [v.point; 2],
        }
    }
}

fn add_boundary(
    boundary: &Boundary,
    grain: PieceResolution,
    all: &mut Vec<ThickPiece>,
    leaves: &mut Option<Vec<ThickPiece>>,
) {
    for run in known_runs(boundary, all) {
        let (links, closed) = (&run.links, run.closed);
        add_side(links, closed, grain, all, leaves);
        if boundary.is_two_sided() {
            let back: Vec<ChainLink> = links.iter().rev().map(ChainLink::reversed).collect();
            add_side(&back, closed, grain, all, leaves);
            if let (false, Some(first), Some(last)) = (closed, links.first(), links.last()) {
                let mut end = |point, normal, blur: Blur| {
                    let end = ThickVertex { point, spread: 0.0, normal, slack: FRAC_PI_2, concavity: 0.0 };
                    all.push(ThickPiece::Vertex(blur.vertex(end, PI)));
                };
                end(first.from, wrap_angle(first.tangent.0 + PI), first.blur);
                end(last.to, wrap_angle(last.tangent.1), last.blur);
            }
        }
    }
}

/// Links of which something is known, one after the other.
#[derive(Default)]
struct KnownRun {
    links: Vec<ChainLink>,
    closed: bool,
}

/// The runs of a boundary between its unknown stretches, which are enclosed by discs.
fn known_runs(boundary: &Boundary, all: &mut Vec<ThickPiece>) -> Vec<KnownRun> {
    let bands = boundary.course().into_iter().flat_map(|course| course.pieces());
    let widest = bands.filter_map(|piece| piece.widest()).map(|band| band.bound).fold(0.0, f64::max);
    let closed = boundary.curve().is_closed();
    let mut runs = vec![KnownRun { links: Vec::new(), closed }];
    for (index, segment) in boundary.curve().segments().iter().enumerate() {
        let blur = Blur::of(boundary, index);
        let depth = match boundary.piece_course(index) {
            Some(PieceCourse::Unknown(depth)) => Some(depth),
            // A wall that may run in any direction.
            _ => blur.is_shapeless().then_some(blur.bound),
        };
        let mut links = Vec::new();
        add_links(segment, blur, &mut links);
        match depth {
            Some(depth) => {
                for link in &links {
                    all.extend(discs([link.from, link.to], depth + widest + link.sagitta).map(ThickPiece::Vertex));
                }
                runs.push(KnownRun::default());
            }
            None => runs.last_mut().into_iter().for_each(|run| run.links.append(&mut links)),
        }
    }
    // Where a ring has a gap, its last run goes on with its first.
    if runs.len() > 1 && closed {
        let first = core::mem::take(&mut runs[0]);
        runs.last_mut().into_iter().for_each(|last| last.links.extend(first.links.iter().copied()));
    }
    runs.retain(|run| !run.links.is_empty());
    runs
}

impl ChainLink {
    fn reversed(&self) -> Self {
        let back = |(a, b): (f64, f64)| (a + PI, b + PI);
        let (first, last) = self.ends;
        let (left, right) = self.curvature;
        Self {
            from: self.to,
            to: self.from,
            tangent: back(self.tangent),
            ends: back((last, first)),
            curvature: (right, left),
            ..*self
        }
    }
}

/// A smooth piece as links; Béziers are bisected until their control polygon bounds them well enough.
fn add_links(segment: &Segment, blur: Blur, links: &mut Vec<ChainLink>) {
    let mut stack = vec![segment.control_points().to_vec()];
    while let Some(points) = stack.pop() {
        let (from, to) = (points[0], points[points.len() - 1]);
        let legs: Vec<Vec2> = points.windows(2).map(|w| w[1] - w[0]).filter(|l| l.norm() > 0.0).collect();
        let chord = to - from;
        let Some(first) = legs.first() else { continue };
        let middle = if chord.norm() > 0.0 { chord.angle() } else { first.angle() };
        let turns = legs.iter().map(|l| wrap_angle(l.angle() - middle));
        let (lo, hi) = turns.fold((0.0_f64, 0.0_f64), |(lo, hi), t| (lo.min(t), hi.max(t)));
        let away = |p: &Vec2| if chord.norm() > 0.0 { chord.cross(*p - from).abs() / chord.norm() } else { 0.0 };
        let sagitta = points.iter().map(away).fold(0.0, f64::max);
        let size = legs.iter().map(|l| l.norm()).sum::<f64>();
        let fine = hi - lo <= 0.5 * FINE.turn && sagitta <= 0.3 * FINE.sagitta;
        if points.len() == 2 || fine || size < 1e-5 {
            links.push(ChainLink {
                from,
                to,
                sagitta: sagitta + ROUNDING,
                tangent: (middle + lo, middle + hi),
                ends: (first.angle(), legs[legs.len() - 1].angle()),
                curvature: curvature_range(&legs, (hi - lo) / size),
                blur,
            });
        } else {
            let (left, right) = subdivided(&points);
            stack.push(right);
            stack.push(left);
        }
    }
}

/// How sharply a fine link turns to the left and to the right (1/m), at most: twice its mean where it does at all.
fn curvature_range(legs: &[Vec2], mean: f64) -> (f64, f64) {
    let turns = || legs.windows(2).map(|w| wrap_angle(w[1].angle() - w[0].angle()));
    let if_any = |any: bool| if any { 2.0 * mean } else { 0.0 };
    (if_any(turns().any(|t| t > NO_TURN)), if_any(turns().any(|t| t < -NO_TURN)))
}

/// The two halves of a Bézier by de Casteljau.
fn subdivided(points: &[Vec2]) -> (Vec<Vec2>, Vec<Vec2>) {
    let (mut left, mut right) = (vec![points[0]], vec![points[points.len() - 1]]);
    let mut level = points.to_vec();
    while level.len() > 1 {
        level = level.windows(2).map(|w| (w[0] + w[1]) * 0.5).collect();
        left.push(level[0]);
        right.push(level[level.len() - 1]);
    }
    right.reverse();
    (left, right)
}

/// An edge of more links than this grows by more than one at a time.
const MANY: usize = 64;

/// Groups the links of one side into edges, with vertices where they turn sharply.
fn add_side(
    links: &[ChainLink],
    closed: bool,
    grain: PieceResolution,
    all: &mut Vec<ThickPiece>,
    leaves: &mut Option<Vec<ThickPiece>>,
) {
    let mut start = 0;
    let mut entering = match (closed, links.first(), links.last()) {
        (true, Some(first), Some(last)) => joint(last, first, all),
        _ => None,
    };
    while start < links.len() {
        let mut edge = chord(&links[start..=start], entering);
        let mut end = start + 1;
        while end < links.len() && is_smooth(&links[end - 1], &links[end]) {
            let longer = chord(&links[start..=end], entering);
            if !is_fine(&longer, grain) {
                break;
            }
            edge = longer;
            end += 1;
            // A chord looks at all its links: over very many they are taken by the share.
            let more = (end - start) / MANY;
            let ahead = (end..(end + more).min(links.len())).find(|&k| !is_smooth(&links[k - 1], &links[k]));
            let far = ahead.unwrap_or((end + more).min(links.len()));
            if far > end {
                let longer = chord(&links[start..far], entering);
                if is_fine(&longer, grain) {
                    (edge, end) = (longer, far);
                }
            }
        }
        if let Some(leaves) = leaves {
            let before = entering.and_then(|_| if start > 0 { links.get(start - 1) } else { links.last() });
            edge.leaves = add_leaves(&links[start..end], before, leaves);
        }
        let blur = links[start..end].iter().fold(Blur::default(), |all, link| all.largest(link.blur));
        all.push(ThickPiece::Edge(blur.edge(edge)));
        if end < links.len() {
            entering = joint(&links[end - 1], &links[end], all);
        }
        start = end;
    }
}

/// The links and the turns between them one by one, and where they stand; nowhere if that is the edge itself.
fn add_leaves(links: &[ChainLink], before: Option<&ChainLink>, leaves: &mut Vec<ThickPiece>) -> (u32, u32) {
    let first = leaves.len() as u32;
    if links.len() < 2 && before.is_none() {
        return (first, first);
    }
    let mut last = before;
    for link in links {
        leaves.extend(last.and_then(|last| leaf_turn(last, link)).map(ThickPiece::Vertex));
        let mut edge = chord(core::slice::from_ref(link), None);
        edge.slack += 2.0 * NO_TURN;
        leaves.push(ThickPiece::Edge(link.blur.edge(edge)));
        last = Some(link);
    }
    (first, leaves.len() as u32)
}

/// The point between two links with the normals between them, if they turn.
fn leaf_turn(before: &ChainLink, after: &ChainLink) -> Option<ThickVertex> {
    let turn = wrap_angle(after.ends.0 - before.ends.1);
    (turn.abs() > NO_TURN).then(|| {
        let vertex = ThickVertex {
            point: after.from,
            spread: ROUNDING,
            normal: wrap_angle(before.ends.1 + 0.5 * turn + FRAC_PI_2),
            slack: 0.5 * turn.abs() + NO_TURN,
            concavity: joint_concavity(before, after),
        };
        before.blur.largest(after.blur).vertex(vertex, turn)
    })
}

fn turn(before: &ChainLink, after: &ChainLink) -> f64 {
    wrap_angle(after.tangent.0 - before.tangent.1)
}

fn is_smooth(before: &ChainLink, after: &ChainLink) -> bool {
    turn(before, after).abs() <= CORNER
}

fn is_fine(edge: &ThickEdge, grain: PieceResolution) -> bool {
    let (slack, sagitta) =
        if edge.length <= SHORT { (SHORT_TURN, SHORT_SAGITTA.max(grain.sagitta)) } else { (grain.turn, grain.sagitta) };
    edge.slack <= 0.5 * slack && edge.sagitta <= sagitta
}

/// What an edge takes over from the link before it, across a joint that is no vertex.
#[derive(Clone, Copy, Debug)]
struct SmoothedVertex {
    tangents: (f64, f64),
    concavity: f64,
}

/// The curvature of a joint towards free space: none or infinite.
fn joint_concavity(before: &ChainLink, after: &ChainLink) -> f64 {
    if wrap_angle(after.ends.0 - before.ends.1) > NO_TURN { f64::INFINITY } else { 0.0 }
}

/// What stands between two links: a vertex, or the last tangents for the next edge to include.
fn joint(before: &ChainLink, after: &ChainLink, all: &mut Vec<ThickPiece>) -> Option<SmoothedVertex> {
    let turn = turn(before, after);
    if turn.abs() <= CORNER {
        return Some(SmoothedVertex { tangents: before.tangent, concavity: joint_concavity(before, after) });
    }
    let spread = (before.tangent.1 - before.tangent.0).abs() + (after.tangent.1 - after.tangent.0).abs();
    let normal = wrap_angle(before.tangent.1 + 0.5 * turn + FRAC_PI_2);
    let concavity = joint_concavity(before, after);
    let slack = 0.5 * turn.abs() + spread;
    let vertex = ThickVertex { point: after.from, spread: 0.0, normal, slack, concavity };
    all.push(ThickPiece::Vertex(before.blur.largest(after.blur).vertex(vertex, turn)));
    None
}

/// One edge over some links.
fn chord(links: &[ChainLink], entering: Option<SmoothedVertex>) -> ThickEdge {
    let (start, end) = (links[0].from, links[links.len() - 1].to);
    let length = start.distance(end);
    let direction = if length > 0.0 { (end - start).angle() } else { links[0].tangent.0 };
    let along = Vec2::from_angle(direction);
    let off = |tangent: f64| wrap_angle(tangent - direction).abs();
    let mut slack = entering.map_or(0.0, |e| off(e.tangents.0).max(off(e.tangents.1)));
    let concavity = links.iter().map(|link| link.curvature.0).fold(entering.map_or(0.0, |e| e.concavity), f64::max);
    let concavity = links.windows(2).map(|w| joint_concavity(&w[0], &w[1])).fold(concavity, f64::max);
    let mut sagitta = 0.0_f64;
    for link in links {
        slack = slack.max(off(link.tangent.0)).max(off(link.tangent.1));
        let away = |p: Vec2| {
            let rest = p - start;
            let ahead = rest.dot(along);
            along.cross(rest).abs().max(-ahead).max(ahead - length)
        };
        sagitta = sagitta.max(link.sagitta + away(link.from).max(away(link.to)));
    }
    ThickEdge {
        start,
        along,
        length,
        normal: wrap_angle(direction + FRAC_PI_2),
        slack: slack + 1e-9,
        sagitta,
        concavity,
        leaves: (0, 0),
    }
}
