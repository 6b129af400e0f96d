//! How large the set is, and into which separate places it falls.

use super::cell::{ARM, Cell};
use crate::plane::{Bounds, Pose2, Vec2, wrap_angle};
use crate::sets::StateBox;
use core::f64::consts::TAU;

/// Cells nearer than this belong together (m, rad).
const LINK: f64 = 1e-4;
const LINK_TURN: f64 = 1e-3;
/// The area is counted on a raster of this many cells across.
const RASTER: usize = 256;
/// Cells are sorted into stripes and sectors before they are compared: so many for each pair of both, at most so many.
const CROWD: f64 = 8.0;
const STRIPES: f64 = 512.0;
/// Long cells are cut into pieces for their boxes: at most this many along a side.
const PIECES: usize = 8;

/// One separate place of a set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The middle of its cells, weighed by volume.
    pub pose: Pose2,
    /// Its share of the volume.
    pub share: f64,
    /// The box around it.
    pub extent: StateBox,
}

/// The boxes around the cells, long slanted ones cut.
pub(super) fn boxes(cells: &[(Cell, f64)]) -> Vec<StateBox> {
    let limit = if cells.len() > 400 { 1 } else { PIECES };
    let mut boxes = Vec::new();
    for (cell, _) in cells {
        let longest = (0..3).max_by(|&a, &b| cell.length(a).total_cmp(&cell.length(b))).unwrap_or(0);
        let others = (0..3).filter(|&j| j != longest).map(|j| cell.length(j)).fold(1e-4, f64::max);
        let pieces = ((cell.length(longest) / others).ceil() as usize).clamp(1, limit);
        let side = cell.sides[longest];
        let mut piece = *cell;
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

/// The groups of cells whose boxes touch.
pub(super) fn places(cells: &[(Cell, f64)]) -> Vec<Place> {
    let hulls: Vec<StateBox> = cells.iter().map(|(cell, _)| cell.hull()).collect();
    let mut order: Vec<usize> = (0..cells.len()).collect();
    order.sort_by(|&a, &b| hulls[a].x.lo().total_cmp(&hulls[b].x.lo()).then(a.cmp(&b)));
    let mut parent: Vec<usize> = (0..cells.len()).collect();
    let mut join = |a: usize, b: usize| {
        if touch(&cells[a].0, &hulls[a], &cells[b].0, &hulls[b]) {
            let (p, q) = (root(&mut parent, a), root(&mut parent, b));
            parent[p.max(q)] = p.min(q);
        }
    };
    for stripe in stripes(&hulls, &order) {
        for (rank, &a) in stripe.iter().enumerate() {
            let near = |&&b: &&usize| hulls[b].x.lo() <= hulls[a].x.hi() + LINK;
            stripe[rank + 1..].iter().take_while(near).for_each(|&b| join(a, b));
        }
    }
    let total: f64 = cells.iter().map(|(_, v)| v).sum();
    let (mut groups, mut group_of): (Vec<Group>, Vec<Option<usize>>) = (Vec::new(), vec![None; cells.len()]);
    for (index, (cell, volume)) in cells.iter().enumerate() {
        let root = root(&mut parent, index);
        match group_of[root] {
            Some(group) => groups[group].add(cell, *volume, &hulls[index]),
            None => {
                group_of[root] = Some(groups.len());
                groups.push(Group::new(cell, *volume, &hulls[index]));
            }
        }
    }
    let mut places: Vec<Place> = groups.iter().map(|group| group.place(total)).collect();
    places.sort_by(|a, b| b.share.total_cmp(&a.share));
    places
}

/// The cells by stripes of y and sectors of the heading, in the given order: cells that touch share one of each.
fn stripes(hulls: &[StateBox], order: &[usize]) -> Vec<Vec<usize>> {
    let (lo, hi) =
        hulls.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), h| (a.min(h.y.lo()), b.max(h.y.hi())));
    let count = (hulls.len() as f64 / CROWD).sqrt().clamp(1.0, STRIPES) as usize;
    let sectors = count as i64;
    let per_metre = count as f64 / (hi - lo + LINK).max(LINK);
    let stripe = |y: f64| (((y - lo) * per_metre).max(0.0) as usize).min(count - 1);
    let sector = |theta: f64| (theta * (sectors as f64 / TAU)).floor() as i64;
    let mut stripes = vec![Vec::new(); count * count];
    for &index in order {
        let StateBox { y, theta, .. } = hulls[index];
        let (first, last) = (sector(theta.lo() - LINK_TURN), sector(theta.hi() + LINK_TURN));
        for at in first..=last.min(first + sectors - 1) {
            let row = at.rem_euclid(sectors) as usize * count;
            (stripe(y.lo() - LINK)..=stripe(y.hi() + LINK)).for_each(|k| stripes[row + k].push(index));
        }
    }
    stripes
}

fn root(parent: &mut [usize], mut at: usize) -> usize {
    while parent[at] != at {
        parent[at] = parent[parent[at]];
        at = parent[at];
    }
    at
}

fn touch(a: &Cell, hull_a: &StateBox, b: &Cell, hull_b: &StateBox) -> bool {
    let apart = wrap_angle(a.center.theta - b.center.theta).abs();
    let turn = 0.5 * (hull_a.theta.width() + hull_b.theta.width());
    hull_a.y.lo() <= hull_b.y.hi() + LINK && hull_b.y.lo() <= hull_a.y.hi() + LINK && apart <= turn + LINK_TURN
}

struct Group {
    first: Pose2,
    sum: [f64; 3],
    weight: f64,
    volume: f64,
    extent: StateBox,
}

impl Group {
    fn new(cell: &Cell, volume: f64, hull: &StateBox) -> Self {
        let mut group = Self { first: cell.center, sum: [0.0; 3], weight: 0.0, volume: 0.0, extent: StateBox::EMPTY };
        group.add(cell, volume, hull);
        group
    }

    fn add(&mut self, cell: &Cell, volume: f64, hull: &StateBox) {
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

    fn place(&self, total: f64) -> Place {
        let [x, y, theta] = self.sum.map(|s| s / self.weight);
        let pose = Pose2::new(self.first.x + x, self.first.y + y, self.first.theta + theta);
        Place { pose, share: if total > 0.0 { self.volume / total } else { 1.0 }, extent: self.extent }
    }
}

/// Upper bounds of area (m²) and volume (m² rad).
pub(super) fn size(cells: &[(Cell, f64)]) -> (f64, f64) {
    let volume = cells.iter().map(|(_, v)| v).sum();
    let shadows: f64 = cells.iter().map(|(cell, _)| shadow(cell)).sum();
    (shadows.min(raster(cells)), volume)
}

/// The area of a cell's projection: a hexagon.
fn shadow(cell: &Cell) -> f64 {
    let [a, b, c] = cell.sides.map(|s| Vec2::new(s[0], s[1]));
    4.0 * (a.cross(b).abs() + b.cross(c).abs() + c.cross(a).abs())
}

/// The area by counting the squares of a raster that the cells' rectangles touch.
fn raster(cells: &[(Cell, f64)]) -> f64 {
    let rectangle = |cell: &Cell| {
        let [x, y, _] = cell.reach();
        let half = Vec2::new(x, y);
        Bounds { min: cell.place() - half, max: cell.place() + half }
    };
    let all = cells.iter().fold(Bounds::EMPTY, |b, (cell, _)| b.hull(rectangle(cell)));
    if all.is_empty() {
        return 0.0;
    }
    let square = (all.size().x.max(all.size().y) / RASTER as f64).max(1e-3 * ARM);
    let mut hit = vec![false; (RASTER + 1) * (RASTER + 1)];
    for (cell, _) in cells {
        let Bounds { min, max } = rectangle(cell);
        let index = |v: f64, from: f64| (((v - from) / square) as usize).min(RASTER);
        let (x0, x1) = (index(min.x, all.min.x), index(max.x, all.min.x));
        for y in index(min.y, all.min.y)..=index(max.y, all.min.y) {
            hit[y * (RASTER + 1) + x0..=y * (RASTER + 1) + x1].fill(true);
        }
    }
    hit.iter().filter(|&&h| h).count() as f64 * square * square
}
