//! Felt lines put together to a map with bands: corners where two straight lines meet, unknown stretches where nothing was felt.
//!
//! Lines are travelled with free space on the left. The end of one and the start of the nearest one ahead belong together. Where both are
//! straight there and meet a little ahead of both, the corner between them is drawn: a whisker snaps across it and feels it as the
//! end of two walls. Its band holds what the two directions leave open, and what the walls' measured curvature adds over the way to
//! the corner. Elsewhere the stretch between them is unknown.

use super::joint::{Ends, Joint, joint, widest};
use crate::config::MapAssemblyOptions;
use crate::plane::{Curve, Vec2};
use crate::world::{Band, Boundary, BoundarySample, Course, Map, PieceCourse, Role};
use crate::{Error, Result};

/// A felt point of a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeltPoint {
    /// Where (m).
    pub position: Vec2,
    /// How exactly, across the wall (m).
    pub band: Band,
    /// How far the whole neighbourhood may be off beside that (m): what is alike over [`MapAssemblyOptions::drift_length`].
    pub drift: Band,
}

/// A wall as it was felt: points in order, free space on the left.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FeltLine {
    /// Its points.
    pub points: Vec<FeltPoint>,
    /// Whether its last point comes before its first.
    pub closed: bool,
}

/// A corner at which two felt walls meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoundCorner {
    /// Where (m).
    pub position: Vec2,
    /// How exactly (m).
    pub band: Band,
}

impl FeltPoint {
    /// Both errors together.
    fn whole(&self) -> Band {
        Band { std: self.band.std.hypot(self.drift.std), bound: self.band.bound + self.drift.bound }
    }
}

/// The length over which both errors of points together have the slope that they have one by one (m).
fn correlation_length(points: &[FeltPoint], options: &MapAssemblyOptions) -> f64 {
    let own = points.iter().map(|point| point.band.bound).fold(0.0, f64::max);
    let drift = points.iter().map(|point| point.drift.bound).fold(0.0, f64::max);
    let slope = own / options.correlation_length + drift / options.drift_length;
    if slope > 0.0 { (own + drift) / slope } else { options.correlation_length }
}

/// What felt lines make together.
#[derive(Clone, Debug)]
pub struct AssembledMap {
    /// The map; each boundary is known within its band.
    pub map: Map,
    /// The corners that were drawn.
    pub corners: Vec<FoundCorner>,
}

impl AssembledMap {
    /// Points so far apart (m) along all that is known of the outline.
    #[must_use]
    pub fn known_points(&self, spacing: f64) -> Vec<Vec2> {
        let is_known = |sample: &&BoundarySample| {
            let boundary = &self.map.boundaries()[sample.boundary];
            let piece = boundary.curve().segment_at(sample.arc_length);
            !matches!(boundary.piece_course(piece), Some(PieceCourse::Unknown(_)))
        };
        self.map.samples(spacing).iter().filter(is_known).map(|sample| sample.position).collect()
    }

    /// Lengths of what is known and of what is unknown (m).
    #[must_use]
    pub fn lengths(&self) -> (f64, f64) {
        let pieces = self.map.boundaries().iter().flat_map(|boundary| {
            let segments = boundary.curve().segments().iter().enumerate();
            segments.map(|(k, segment)| {
                (segment.length(), matches!(boundary.piece_course(k), Some(PieceCourse::Unknown(_))))
            })
        });
        pieces.fold(
            (0.0, 0.0),
            |(known, not), (length, is_unknown)| {
                if is_unknown { (known, not + length) } else { (known + length, not) }
            },
        )
    }
}

/// A chain of lines, and what joins each to the next; a ring has one joint more.
struct Chain {
    lines: Vec<usize>,
    joints: Vec<Joint>,
    is_ring: bool,
}

/// The map that felt lines make.
///
/// # Errors
///
/// No line of two points.
pub fn assemble(lines: &[FeltLine], options: &MapAssemblyOptions) -> Result<AssembledMap> {
    let lines: Vec<FeltLine> = lines.iter().filter(|line| line.points.len() > 1).cloned().collect();
    if lines.is_empty() {
        return Err(Error::data("nothing was felt that makes a map")
            .remedy("press the whisker against the wall and slide along it for at least a few millimetres"));
    }
    let lines = joined(lines, options);
    let mut corners = Vec::new();
    let mut boundaries = Vec::new();
    for chain in chains(&lines, options) {
        let found = chain.joints.iter().filter_map(|joint| match joint {
            Joint::Corner(corner) => Some(*corner),
            _ => None,
        });
        corners.extend(found);
        boundaries.push(boundary(&lines, &chain, options)?);
    }
    Ok(AssembledMap { map: Map::new(boundaries)?, corners })
}

/// Lines that go on as one another made one: a wall that was felt in parts is straight over all of them, and a corner may lie as far
/// ahead as that.
fn joined(mut lines: Vec<FeltLine>, options: &MapAssemblyOptions) -> Vec<FeltLine> {
    let mut ends: Vec<Ends> = lines.iter().map(|line| Ends::of(line, options)).collect();
    while let Some((from, to)) = nearest_touching(&ends, options) {
        let rest = core::mem::take(&mut lines[to].points);
        lines[from].points.extend(rest);
        lines.swap_remove(to);
        ends.swap_remove(to);
        // The last line may have taken the place of the one that is gone.
        let whole = if from == lines.len() { to } else { from };
        ends[whole] = Ends::of(&lines[whole], options);
    }
    lines
}

/// The two of the lines that are nearest to each other of those that touch: the one that ends there, and the one that starts.
fn nearest_touching(ends: &[Ends], options: &MapAssemblyOptions) -> Option<(usize, usize)> {
    let pairs =
        (0..ends.len()).flat_map(|from| (0..ends.len()).map(move |to| (from, to))).filter(|(from, to)| from != to);
    let touching = pairs.filter_map(|(from, to)| match joint(&ends[from], &ends[to], false, options)? {
        (gap, Joint::Touching) => Some((gap, from, to)),
        _ => None,
    });
    touching.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, from, to)| (from, to))
}

/// Lines joined end to start, the nearest first.
fn chains(lines: &[FeltLine], options: &MapAssemblyOptions) -> Vec<Chain> {
    let open: Vec<usize> = (0..lines.len()).filter(|&k| !lines[k].closed).collect();
    let ends: Vec<Ends> = lines.iter().map(|line| Ends::of(line, options)).collect();
    let mut pairs: Vec<(f64, usize, usize, Joint)> = Vec::new();
    for &from in &open {
        for &to in &open {
            if let Some((gap, joint)) = joint(&ends[from], &ends[to], from == to, options) {
                pairs.push((gap, from, to, joint));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let (mut next, mut before) = (vec![None; lines.len()], vec![None; lines.len()]);
    for (_, from, to, joint) in pairs {
        if next[from].is_none() && before[to].is_none() {
            (next[from], before[to]) = (Some((to, joint)), Some(from));
        }
    }
    let mut used = vec![false; lines.len()];
    let mut found = Vec::new();
    // Chains with a beginning first, then rings.
    let starts = open.iter().filter(|&&k| before[k].is_none()).chain(&open).copied();
    for start in starts {
        let mut chain = Chain { lines: Vec::new(), joints: Vec::new(), is_ring: false };
        let mut at = start;
        while !used[at] {
            used[at] = true;
            chain.lines.push(at);
            let Some((to, joint)) = next[at] else { break };
            chain.joints.push(joint);
            chain.is_ring = to == start;
            at = to;
        }
        if !chain.lines.is_empty() {
            found.push(chain);
        }
    }
    let closed = (0..lines.len()).filter(|&k| lines[k].closed);
    found.extend(closed.map(|k| Chain { lines: vec![k], joints: vec![Joint::Touching], is_ring: true }));
    found
}

/// What is no shape of a wall, over the middle standard deviation of its points.
const STDS_LEFT_OUT: f64 = 2.0;

/// Points before and after by which a line's direction is told.
const NEIGHBOURS: usize = 6;

/// One boundary in the making: its points, and what is known of the piece after each.
#[derive(Default)]
struct Drawn {
    points: Vec<FeltPoint>,
    unknown: Vec<Option<f64>>,
}

impl Drawn {
    fn push(&mut self, point: FeltPoint, unknown: Option<f64>) {
        self.points.push(point);
        self.unknown.push(unknown);
    }

    /// Without points that nearly repeat one before, or lie beyond a corner.
    fn add_line(&mut self, line: &FeltLine, (first, last): (Option<Vec2>, Option<Vec2>)) {
        // A tip that slid into a corner leaves points beside it.
        let beyond = |p: &FeltPoint, corner: Option<Vec2>, towards: f64| {
            corner.is_some_and(|corner| {
                let count = line.points.len();
                let (a, b) = (line.points[0].position, line.points[count - 1].position);
                ((p.position - corner).dot(b - a)) * towards > 0.0 && p.position.distance(corner) < a.distance(b)
            })
        };
        let count = line.points.len();
        let mut kept: Option<Vec2> = None;
        for (k, point) in line.points.iter().enumerate() {
            // Runs that were joined may go back by a point or two.
            let (from, to) = (k.saturating_sub(NEIGHBOURS), (k + NEIGHBOURS).min(count - 1));
            let along = line.points[to].position - line.points[from].position;
            let goes_back = kept.is_some_and(|kept| (point.position - kept).dot(along) <= 0.0);
            if !goes_back && !beyond(point, first, -1.0) && !beyond(point, last, 1.0) {
                kept = Some(point.position);
                self.push(*point, None);
            }
        }
    }
}

fn boundary(lines: &[FeltLine], chain: &Chain, options: &MapAssemblyOptions) -> Result<Boundary> {
    let corner_at = |k: usize| match chain.joints.get(k) {
        Some(Joint::Corner(corner)) => Some(*corner),
        _ => None,
    };
    let mut drawn = Drawn::default();
    let count = chain.lines.len();
    for (k, &index) in chain.lines.iter().enumerate() {
        let before = if k > 0 {
            corner_at(k - 1)
        } else if chain.is_ring {
            corner_at(count - 1)
        } else {
            None
        };
        let after = if k + 1 < count || chain.is_ring { corner_at(k) } else { None };
        drawn.add_line(&lines[index], (before.map(|c| c.position), after.map(|c| c.position)));
        match chain.joints.get(k) {
            Some(Joint::Corner(FoundCorner { position, band })) => {
                let drift = drawn.points.last().map_or(Band::default(), |point| point.drift);
                drawn.push(FeltPoint { position: *position, band: *band, drift }, None);
            }
            Some(Joint::Unknown(depth)) => drawn.unknown.last_mut().into_iter().for_each(|last| *last = Some(*depth)),
            _ => {}
        }
    }
    finished(drawn, chain.is_ring, options)
}

/// The boundary: a ring encloses free space or something solid; a line is a wall with an unknown stretch at either end.
fn finished(mut drawn: Drawn, is_ring: bool, options: &MapAssemblyOptions) -> Result<Boundary> {
    if !is_ring {
        add_ends(&mut drawn, options);
    }
    let mut stds: Vec<f64> = drawn.points.iter().map(|point| point.band.std).collect();
    stds.sort_by(f64::total_cmp);
    // What is less than the points' own errors is no shape of the wall.
    let middle = stds.get(stds.len() / 2).copied().unwrap_or(0.0);
    simplify(&mut drawn, options.simplified.max(STDS_LEFT_OUT * middle));
    let points: Vec<Vec2> = drawn.points.iter().map(|point| point.position).collect();
    let degenerate = || Error::data("a felt line without length");
    let curve = Curve::polyline(&points, is_ring).ok_or_else(degenerate)?;
    let pieces = if is_ring { points.len() } else { points.len() - 1 };
    let course = (0..pieces).map(|k| match drawn.unknown[k] {
        Some(depth) => PieceCourse::Unknown(depth),
        None => PieceCourse::Band([drawn.points[k].whole(), drawn.points[(k + 1) % points.len()].whole()]),
    });
    let length = correlation_length(&drawn.points, options);
    let course = Course::new(course.collect(), length)?;
    let role = match (is_ring, curve.signed_area() > 0.0) {
        (false, _) => Role::Wall,
        (true, true) => Role::Arena,
        (true, false) => Role::Obstacle,
    };
    match Boundary::new(role, curve, None) {
        Ok(boundary) => boundary.with_course(course),
        // A ring that crosses itself bounds nothing; it is still where the whisker touched.
        Err(_) => {
            let open = Curve::polyline(&points, false).ok_or_else(degenerate)?;
            let course = Course::new(course.pieces()[..points.len() - 1].to_vec(), length)?;
            Boundary::new(Role::Wall, open, None)?.with_course(course)
        }
    }
}

/// Where a wall ends that was felt no further: nothing is known of what comes next.
fn add_ends(drawn: &mut Drawn, options: &MapAssemblyOptions) {
    let Some((first, last)) = drawn.points.first().copied().zip(drawn.points.last().copied()) else { return };
    let ahead = |from: Vec2, to: Vec2| (to - from) * (options.end_reach / (to - from).norm().max(1e-9));
    let count = drawn.points.len();
    let (second, before) = (drawn.points[1].position, drawn.points[count - 2].position);
    if let Some(end) = drawn.unknown.last_mut() {
        *end = Some(options.end_reach);
    }
    drawn.push(FeltPoint { position: last.position + ahead(before, last.position), ..last }, None);
    let start = FeltPoint { position: first.position + ahead(second, first.position), ..first };
    drawn.points.insert(0, start);
    drawn.unknown.insert(0, Some(options.end_reach));
}

/// Leaves out points that lie within `tolerance` (m) of the line between those that stay \[douglas1973algorithms\]; bands hold what was
/// left out.
fn simplify(drawn: &mut Drawn, tolerance: f64) {
    let count = drawn.points.len();
    let fixed = |k: usize| k == 0 || k + 1 == count || drawn.unknown[k].is_some() || drawn.unknown[k - 1].is_some();
    let mut keep = vec![false; count];
    let mut ends: Vec<usize> = (0..count).filter(|&k| fixed(k)).collect();
    ends.dedup();
    ends.iter().for_each(|&k| keep[k] = true);
    let mut stack: Vec<(usize, usize)> = ends.windows(2).map(|pair| (pair[0], pair[1])).collect();
    while let Some((from, to)) = stack.pop() {
        let (a, b) = (drawn.points[from].position, drawn.points[to].position);
        let along = b - a;
        let size = along.norm().max(1e-12);
        let off = |k: usize| along.cross(drawn.points[k].position - a).abs() / size;
        let Some(worst) = (from + 1..to).max_by(|&i, &j| off(i).total_cmp(&off(j))) else { continue };
        if off(worst) > tolerance {
            keep[worst] = true;
            stack.extend([(from, worst), (worst, to)]);
        }
    }
    let mut widened: Vec<FeltPoint> = Vec::new();
    let mut unknown = Vec::new();
    let mut pending = Band::default();
    for (k, stays) in keep.into_iter().enumerate() {
        let mut point = drawn.points[k];
        pending = widest(pending, point.band);
        if stays {
            point.band = pending;
            point.band.bound += tolerance;
            if let Some(last) = widened.last_mut() {
                last.band = widest(last.band, point.band);
            }
            widened.push(point);
            unknown.push(drawn.unknown[k]);
            pending = Band::default();
        }
    }
    *drawn = Drawn { points: widened, unknown };
}
