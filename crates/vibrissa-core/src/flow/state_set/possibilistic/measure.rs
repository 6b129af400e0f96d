//! Size of the set, and its connected components.

use super::parallelotope::{HEADING_ARM, Parallelotope};
use crate::plane::{Bounds, Pose2, Vec2, wrap_angle};
use crate::sets::{Interval, StateBox};
use crate::{WorkBudget, math};
use core::f64::consts::TAU;

/// Cells nearer than this belong together (m, rad).
const LINK: f64 = 1e-3;
const LINK_TURN: f64 = 1e-2;
/// The area is counted on a raster of this many cells across.
const RASTER: usize = 256;
/// And on this one when it matters, with squares no smaller than this (m).
const SHARP_RASTER: usize = 1024;
const LEAST_SQUARE: f64 = 1e-6;
/// More cells than this are not compared one by one, but joined where they share a bin: so many for each axis.
const CROWD: usize = 1000;
const BINS: usize = 64;
/// Long cells are cut into pieces for their boxes: at most this many along a side.
const PIECES: usize = 8;

/// One separate place of a set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnclosedPlace {
    /// The middle of its cells, weighed by volume.
    pub pose: Pose2,
    /// Its share of the volume.
    pub share: f64,
    /// The box around it.
    pub extent: StateBox,
}

/// A place after the robot has made this step, which may be off by so much in place (m) and turn (rad): nothing is lost.
pub(super) fn carried(place: &EnclosedPlace, step: Pose2, (off, turn): (f64, f64)) -> EnclosedPlace {
    let StateBox { x, y, theta } = place.extent;
    let middle = 0.5 * (theta.lo() + theta.hi());
    let way = step.position().rotated(middle);
    // The way at any heading of the place ends no further from the way at the middle one than the chord between them.
    let slack = off + 2.0 * way.norm() * math::sin(0.25 * theta.width().min(TAU));
    let transport =
        |range: Interval, by: f64, slack: f64| Interval::new(range.lo() + by - slack, range.hi() + by + slack);
    let extent = StateBox {
        x: transport(x, way.x, slack),
        y: transport(y, way.y, slack),
        theta: transport(theta, step.theta, turn),
    };
    EnclosedPlace { pose: place.pose.compose(step), extent, ..*place }
}

/// The boxes around the cells, long slanted ones cut.
pub(super) fn boxes(cells: impl ExactSizeIterator<Item = Parallelotope>) -> Vec<StateBox> {
    let limit = if cells.len() > 400 { 1 } else { PIECES };
    let mut boxes = Vec::with_capacity(cells.len());
    for cell in cells {
        let longest = (0..3).max_by(|&a, &b| cell.length(a).total_cmp(&cell.length(b))).unwrap_or(0);
        let others = (0..3).filter(|&j| j != longest).map(|j| cell.length(j)).fold(1e-4, f64::max);
        let pieces = ((cell.length(longest) / others).ceil() as usize).clamp(1, limit);
        let side = cell.sides[longest];
        let mut piece = cell;
        piece.sides[longest] = side.map(|v| v / pieces as f64);
        for k in 0..pieces {
            let at = (2 * k + 1) as f64 / pieces as f64 - 1.0;
            let Pose2 { x, y, theta } = cell.center;
            piece.center = Pose2::new(x + at * side[0], y + at * side[1], theta + at * side[2]);
            boxes.push(piece.hull());
        }
    }
    boxes
}

/// The groups of cells whose boxes touch; of many cells also those that nearly do, within a 64th of the set.
pub(super) fn places(cells: impl Iterator<Item = Parallelotope>) -> Vec<EnclosedPlace> {
    let cells: Vec<Parallelotope> = cells.collect();
    let mut joining = Joining::new(&cells);
    joining.advance(&mut WorkBudget::unlimited());
    joining.places(&cells)
}

/// Cells on their way into groups.
#[derive(Clone, Debug)]
struct Joining {
    hulls: Vec<StateBox>,
    parent: Vec<u32>,
    /// How many have been compared with the others.
    at: usize,
    /// The order in which they are compared, by x; or the first of each bin.
    order: Vec<u32>,
    bins: Option<Bins>,
}

impl Joining {
    fn new(cells: &[Parallelotope]) -> Self {
        let hulls: Vec<StateBox> = cells.iter().map(Parallelotope::hull).collect();
        let parent: Vec<u32> = (0..hulls.len() as u32).collect();
        let crowded = hulls.len() > CROWD;
        let mut order = if crowded { Vec::new() } else { parent.clone() };
        order.sort_by(|&a, &b| hulls[a as usize].x.lo().total_cmp(&hulls[b as usize].x.lo()).then(a.cmp(&b)));
        Self { bins: crowded.then(|| Bins::new(&hulls)), hulls, parent, at: 0, order }
    }

    /// Joins the next cells with those that they touch; whether no cell is left.
    fn advance(&mut self, budget: &mut WorkBudget) -> bool {
        while self.at < self.hulls.len() {
            if budget.is_spent() {
                return false;
            }
            let looked_at = match &mut self.bins {
                Some(bins) => bins.join(&self.hulls, &mut self.parent, self.at),
                None => join_pairs(&self.hulls, &self.order, &mut self.parent, self.at),
            };
            self.at += 1;
            budget.spend(1 + looked_at / LOOKS_PER_UNIT);
        }
        true
    }

    /// The groups, the largest share of the volume first.
    fn places(&mut self, cells: &[Parallelotope]) -> Vec<EnclosedPlace> {
        let Self { hulls, parent, .. } = self;
        let (mut groups, mut group_of): (Vec<CellGroup>, Vec<u32>) = (Vec::new(), vec![u32::MAX; hulls.len()]);
        for (index, cell) in cells.iter().enumerate() {
            let root = root(parent, index);
            if group_of[root] == u32::MAX {
                group_of[root] = groups.len() as u32;
                groups.push(CellGroup::new(cell));
            }
            groups[group_of[root] as usize].add(cell, &hulls[index]);
        }
        let total: f64 = groups.iter().map(|group| group.volume).sum();
        let mut places: Vec<EnclosedPlace> = groups.iter().map(|group| group.place(total)).collect();
        places.sort_by(|a, b| b.share.total_cmp(&a.share));
        places
    }
}

/// Boxes that are compared, or bins, for a unit of work.
const LOOKS_PER_UNIT: usize = 64;

fn join(parent: &mut [u32], a: usize, b: usize) {
    let (p, q) = (root(parent, a), root(parent, b));
    parent[p.max(q)] = p.min(q) as u32;
}

/// Joins a box with those that touch it and come later by x; how many it looked at.
fn join_pairs(hulls: &[StateBox], order: &[u32], parent: &mut [u32], rank: usize) -> usize {
    let a = order[rank] as usize;
    let near = |&&b: &&u32| hulls[b as usize].x.lo() <= hulls[a].x.hi() + LINK;
    let mut looked_at = 0;
    for &b in order[rank + 1..].iter().take_while(near) {
        looked_at += 1;
        if touch(&hulls[a], &hulls[b as usize]) {
            join(parent, a, b as usize);
        }
    }
    looked_at
}

/// A raster over the set: what touches shares a bin, and what is nearer than a bin may.
#[derive(Clone, Debug)]
struct Bins {
    /// Where the axes x and y begin (m), and bins for each metre.
    axes: [(f64, f64); 2],
    /// The first box of each.
    first: Vec<u32>,
}

impl Bins {
    fn new(hulls: &[StateBox]) -> Self {
        let axis = |of: &dyn Fn(&StateBox) -> (f64, f64)| {
            let (lo, hi) =
                hulls.iter().map(of).fold((f64::INFINITY, f64::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1)));
            (lo, BINS as f64 / (hi - lo + LINK))
        };
        let axes = [axis(&|h| (h.x.lo(), h.x.hi())), axis(&|h| (h.y.lo(), h.y.hi()))];
        Self { axes, first: vec![u32::MAX; BINS * BINS * BINS] }
    }

    /// Joins a box with the first of each of its bins; how many bins these are.
    fn join(&mut self, hulls: &[StateBox], parent: &mut [u32], index: usize) -> usize {
        let hull = &hulls[index];
        let range = |(lo, per_metre): (f64, f64), a: f64, b: f64| {
            let bin = |v: f64| (((v - lo) * per_metre).max(0.0) as usize).min(BINS - 1);
            bin(a - LINK)..=bin(b + LINK)
        };
        let sector = |theta: f64| (theta * (BINS as f64 / TAU)).floor() as i64;
        let (lo, hi) = (sector(hull.theta.lo() - LINK_TURN), sector(hull.theta.hi() + LINK_TURN));
        let mut looked_at = 0;
        for at in lo..=hi.min(lo + BINS as i64 - 1) {
            let layer = at.rem_euclid(BINS as i64) as usize * BINS;
            for row in range(self.axes[1], hull.y.lo(), hull.y.hi()) {
                for column in range(self.axes[0], hull.x.lo(), hull.x.hi()) {
                    let bin = &mut self.first[(layer + row) * BINS + column];
                    if *bin == u32::MAX {
                        *bin = index as u32
                    } else {
                        join(parent, *bin as usize, index)
                    }
                    looked_at += 1;
                }
            }
        }
        looked_at
    }
}

fn root(parent: &mut [u32], mut at: usize) -> usize {
    while parent[at] as usize != at {
        parent[at] = parent[parent[at] as usize];
        at = parent[at] as usize;
    }
    at
}

/// Whether two boxes whose ranges of x touch do so in y and heading as well.
fn touch(a: &StateBox, b: &StateBox) -> bool {
    let middle = |hull: &StateBox| 0.5 * (hull.theta.lo() + hull.theta.hi());
    let apart = wrap_angle(middle(a) - middle(b)).abs();
    let turn = 0.5 * (a.theta.width() + b.theta.width());
    a.y.lo() <= b.y.hi() + LINK && b.y.lo() <= a.y.hi() + LINK && apart <= turn + LINK_TURN
}

struct CellGroup {
    first: Pose2,
    sum: [f64; 3],
    weight: f64,
    volume: f64,
    extent: StateBox,
}

impl CellGroup {
    fn new(cell: &Parallelotope) -> Self {
        Self { first: cell.center, sum: [0.0; 3], weight: 0.0, volume: 0.0, extent: StateBox::EMPTY }
    }

    fn add(&mut self, cell: &Parallelotope, hull: &StateBox) {
        let volume = cell.volume();
        // Places without any volume have a middle as well.
        let weight = volume + 1e-300;
        let off = [
            cell.center.x - self.first.x,
            cell.center.y - self.first.y,
            wrap_angle(cell.center.theta - self.first.theta),
        ];
        (0..3).for_each(|i| self.sum[i] += weight * off[i]);
        self.weight += weight;
        self.volume += volume;
        self.extent = self.extent.hull(hull);
    }

    fn place(&self, total: f64) -> EnclosedPlace {
        let [x, y, theta] = self.sum.map(|s| s / self.weight);
        let pose = Pose2::new(self.first.x + x, self.first.y + y, self.first.theta + theta);
        EnclosedPlace { pose, share: if total > 0.0 { self.volume / total } else { 1.0 }, extent: self.extent }
    }
}

/// Upper bounds of area (m²) and volume (m² rad); `sharp` takes longer and counts less beside the cells.
pub(super) fn size(cells: impl Iterator<Item = Parallelotope>, sharp: bool) -> (f64, f64) {
    let cells: Vec<Parallelotope> = cells.collect();
    let mut size = Size::new(&cells, sharp);
    size.advance(&cells, &mut WorkBudget::unlimited());
    size.told()
}

/// The size of a set in the making.
#[derive(Clone, Debug)]
struct Size {
    /// The sum of the projections' areas (m²), and of the cells' volumes (m² rad).
    shadows: f64,
    volume: f64,
    raster: Raster,
    counted: usize,
}

impl Size {
    fn new(cells: &[Parallelotope], sharp: bool) -> Self {
        let add = |(shadows, volume): (f64, f64), cell: &Parallelotope| {
            (shadows + projected_area(cell), volume + cell.volume())
        };
        let (shadows, volume) = cells.iter().fold((0.0, 0.0), add);
        Self { shadows, volume, raster: Raster::new(cells, sharp), counted: 0 }
    }

    /// Counts the squares of the next cells; whether no cell is left.
    fn advance(&mut self, cells: &[Parallelotope], budget: &mut WorkBudget) -> bool {
        while let Some(cell) = cells.get(self.counted) {
            if budget.is_spent() {
                return false;
            }
            self.counted += 1;
            budget.spend(1 + self.raster.count(cell));
        }
        true
    }

    /// Upper bounds of area (m²) and volume (m² rad).
    fn told(&self) -> (f64, f64) {
        (self.shadows.min(self.raster.area()), self.volume)
    }
}

/// The size of the set and its places in the making.
#[derive(Clone, Debug)]
pub(crate) struct Measurement {
    /// The cells, at the newest row.
    cells: Vec<Parallelotope>,
    size: Size,
    joining: Joining,
    places: Option<Vec<EnclosedPlace>>,
}

impl Measurement {
    pub(super) fn new(cells: impl Iterator<Item = Parallelotope>, sharp: bool) -> Self {
        let cells: Vec<Parallelotope> = cells.collect();
        Self { size: Size::new(&cells, sharp), joining: Joining::new(&cells), cells, places: None }
    }

    /// Goes on; whether all is measured.
    pub(crate) fn advance(&mut self, budget: &mut WorkBudget) -> bool {
        if self.places.is_none() {
            if !self.joining.advance(budget) {
                return false;
            }
            self.places = Some(self.joining.places(&self.cells));
            budget.spend(PLACE_COST * self.cells.len());
        }
        self.size.advance(&self.cells, budget)
    }

    /// The places, the largest first, and upper bounds of area (m²) and volume (m² rad), once all is measured.
    pub(crate) fn told(mut self) -> (Vec<EnclosedPlace>, (f64, f64)) {
        self.advance(&mut WorkBudget::unlimited());
        (self.places.unwrap_or_default(), self.size.told())
    }
}

/// What a cell costs where places are told.
const PLACE_COST: usize = 2;

/// The area of a cell's projection: a hexagon.
fn projected_area(cell: &Parallelotope) -> f64 {
    let [a, b, c] = cell.sides.map(|s| Vec2::new(s[0], s[1]));
    4.0 * (a.cross(b).abs() + b.cross(c).abs() + c.cross(a).abs())
}

/// The corners of that hexagon.
fn hexagon(cell: &Parallelotope) -> [Vec2; 6] {
    let upward = |v: Vec2| if v.y < 0.0 || (v.y == 0.0 && v.x < 0.0) { -v } else { v };
    let mut sides = cell.sides.map(|s| upward(Vec2::new(s[0], s[1])));
    sides.sort_by(|a, b| b.cross(*a).total_cmp(&0.0));
    let [a, b, c] = sides;
    let first = -(a + b + c);
    let (second, third) = (first + a * 2.0, first + (a + b) * 2.0);
    [first, second, third, -first, -second, -third].map(|corner| cell.place() + corner)
}

/// The least and largest x that a polygon has between two heights; none where it has no point there.
fn between(polygon: &[Vec2; 6], low: f64, high: f64) -> Option<(f64, f64)> {
    let mut range: Option<(f64, f64)> = None;
    for k in 0..6 {
        let (p, q) = (polygon[k], polygon[(k + 1) % 6]);
        let (bottom, top) = if p.y <= q.y { (p, q) } else { (q, p) };
        if top.y < low || bottom.y > high {
            continue;
        }
        let rise = top.y - bottom.y;
        let at = |y: f64| if rise > 0.0 { bottom.x + (top.x - bottom.x) * ((y - bottom.y) / rise) } else { top.x };
        let ends = (at(low.max(bottom.y)), if rise > 0.0 { at(high.min(top.y)) } else { bottom.x });
        let own = (ends.0.min(ends.1), ends.0.max(ends.1));
        range = Some(range.map_or(own, |all| (all.0.min(own.0), all.1.max(own.1))));
    }
    range
}

/// The rectangle around a cell's projection.
fn rectangle(cell: &Parallelotope) -> Bounds {
    let [x, y, _] = cell.reach();
    let half = Vec2::new(x, y);
    Bounds { min: cell.place() - half, max: cell.place() + half }
}

/// The area by counting the squares of a raster that the cells' projections touch, or the rectangles around these.
#[derive(Clone, Debug)]
struct Raster {
    from: Vec2,
    across: usize,
    /// The side of a square (m).
    square: f64,
    hit: Vec<bool>,
    sharp: bool,
}

impl Raster {
    fn new(cells: &[Parallelotope], sharp: bool) -> Self {
        let all = cells.iter().fold(Bounds::EMPTY, |b, cell| b.hull(rectangle(cell)));
        let across = if sharp { SHARP_RASTER } else { RASTER };
        if all.is_empty() {
            return Self { from: Vec2::ZERO, across: 0, square: 0.0, hit: Vec::new(), sharp };
        }
        let least = if sharp { LEAST_SQUARE } else { 1e-3 * HEADING_ARM };
        let square = (all.size().x.max(all.size().y) / across as f64).max(least);
        Self { from: all.min, across, square, hit: vec![false; (across + 1) * (across + 1)], sharp }
    }

    /// Counts the squares of a cell; how many it looked at.
    fn count(&mut self, cell: &Parallelotope) -> usize {
        let Self { from, across, square, sharp, .. } = *self;
        let Bounds { min, max } = rectangle(cell);
        let corners = hexagon(cell);
        let index = |v: f64, from: f64| (((v - from) / square) as usize).min(across);
        let mut looked_at = 0;
        for y in index(min.y, from.y)..=index(max.y, from.y) {
            let low = from.y + y as f64 * square;
            // A little more than the row, for rounding.
            let touched = || between(&corners, low - 1e-6 * square, low + square * (1.0 + 1e-6));
            let Some((left, right)) = (if sharp { touched() } else { Some((min.x, max.x)) }) else { continue };
            let (x0, x1) = (index(left, from.x), index(right, from.x));
            self.hit[y * (across + 1) + x0..=y * (across + 1) + x1].fill(true);
            looked_at += 1;
        }
        looked_at
    }

    /// The area of the squares so far (m²).
    fn area(&self) -> f64 {
        self.hit.iter().filter(|&&h| h).count() as f64 * self.square * self.square
    }
}
