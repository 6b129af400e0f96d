//! Fast look-up among many straight segments.

use super::intersect::{orientation, segment_contact};
use super::segment::nearest_on_line;
use super::{Bounds, Vec2};
use alloc::vec::Vec;
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// How many edges a leaf holds at most: few enough that testing all is cheaper than another level.
const LEAF_EDGES: usize = 4;

/// The point of the stored edges nearest to a query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestEdge {
    /// Index of the edge in the order given to [`SegmentTree::new`].
    pub edge: usize,
    /// Place along the edge, 0 at its start and 1 at its end.
    pub t: f64,
    /// The nearest point (m).
    pub point: Vec2,
    /// Its distance from the query (m).
    pub distance: f64,
}

/// A common point of two stored edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intersection {
    /// The edge with the lower index.
    pub first: usize,
    /// The edge with the higher index.
    pub second: usize,
    /// A common point (m).
    pub point: Vec2,
}

/// A node: its edges are in the rectangle. An inner node's left child follows it directly.
#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Bounds,
    /// Leaf: the first slot of its edges. Inner: the index of the right child.
    first: u32,
    /// Leaf: how many edges. Inner: 0.
    count: u32,
}

/// A bounding-volume hierarchy over straight segments, packed into flat arrays: build O(n log n), look-up O(log n) as
/// long as the edges are spread out.
///
/// Edges must be finite; at most 2³² - 1 of them.
#[derive(Clone, Debug, Default)]
pub struct SegmentTree {
    nodes: Vec<Node>,
    /// The edges in leaf order.
    edges: Vec<[Vec2; 2]>,
    /// The original index of each edge.
    ids: Vec<u32>,
}

impl SegmentTree {
    /// The tree over `edges`, each given by its two ends (m).
    #[must_use]
    pub fn new(edges: &[[Vec2; 2]]) -> Self {
        let mut order: Vec<u32> = (0..u32::try_from(edges.len()).unwrap_or(u32::MAX)).collect();
        let mut nodes = Vec::with_capacity(edges.len() / 2 + 1);
        if !order.is_empty() {
            build(edges, &mut order, 0, &mut nodes);
        }
        Self { nodes, edges: order.iter().map(|&i| edges[i as usize]).collect(), ids: order }
    }

    /// How many edges are stored.
    #[must_use]
    pub fn len(&self) -> usize {
        self.edges.len()
    }

    /// Whether no edge is stored.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.edges.is_empty()
    }

    /// The rectangle around all edges.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        self.nodes.first().map_or(Bounds::EMPTY, |n| n.bounds)
    }

    /// The nearest point of all edges; none for an empty tree or a query that is not finite.
    #[must_use]
    pub fn nearest(&self, p: Vec2) -> Option<NearestEdge> {
        self.nearest_within(p, f64::INFINITY)
    }

    /// The nearest point of all edges that is no further than `reach`; the smaller the reach the faster the answer.
    #[must_use]
    pub fn nearest_within(&self, p: Vec2, reach: f64) -> Option<NearestEdge> {
        if !p.is_finite() {
            return None;
        }
        let mut best: Option<(usize, f64, Vec2)> = None;
        let mut limit = reach * reach;
        let mut stack = Stack::new(self.nodes.len());
        let mut farther = [0.0; Stack::DEPTH];
        farther[0] = self.nodes.first().map_or(0.0, |root| root.bounds.distance_squared(p));
        while let Some(mut index) = stack.pop() {
            // The way down to the nearer children; the others wait with their distance.
            let mut distance = farther[stack.len];
            while distance <= limit {
                let node = &self.nodes[index];
                if node.count == 0 {
                    let (left, right) = (index + 1, node.first as usize);
                    let (dl, dr) = (self.box_distance(left, p), self.box_distance(right, p));
                    let (far, near) = if dl <= dr { (right, left) } else { (left, right) };
                    farther[stack.len] = dl.max(dr);
                    if dl.max(dr) <= limit {
                        stack.push(far);
                    }
                    (index, distance) = (near, dl.min(dr));
                    continue;
                }
                for slot in node.first as usize..(node.first + node.count) as usize {
                    let [a, b] = self.edges[slot];
                    let t = nearest_on_line(a, b, p);
                    let point = a + (b - a) * t;
                    let squared = (point - p).norm_squared();
                    if squared < limit || (best.is_none() && squared <= limit) {
                        limit = squared;
                        best = Some((slot, t, point));
                    }
                }
                break;
            }
        }
        best.map(|(slot, t, point)| NearestEdge { edge: self.ids[slot] as usize, t, point, distance: limit.sqrt() })
    }

    fn box_distance(&self, node: usize, p: Vec2) -> f64 {
        self.nodes[node].bounds.distance_squared(p)
    }

    /// Whether the closed segment `ab` has a point in common with any edge; touching counts.
    #[must_use]
    pub fn crosses(&self, a: Vec2, b: Vec2) -> bool {
        let bounds = Bounds::of(&[a, b]);
        let mut hit = false;
        self.visit(
            |node| node.overlaps(bounds) && !line_misses(a, b, *node),
            |slot| {
                let [c, d] = self.edges[slot];
                hit = segment_contact(a, b, c, d).is_some();
                hit
            },
        );
        hit
    }

    /// Calls `visit(edge, ends)` for each edge whose own rectangle overlaps `bounds`, until it answers true.
    pub fn for_each_in(&self, bounds: Bounds, mut visit: impl FnMut(usize, [Vec2; 2]) -> bool) {
        self.visit(
            |node| node.overlaps(bounds),
            |slot| {
                let ends = self.edges[slot];
                Bounds::of(&ends).overlaps(bounds) && visit(self.ids[slot] as usize, ends)
            },
        );
    }

    /// How many edges the ray from `p` towards +x crosses; odd inside a closed polygon.
    ///
    /// An edge counts when exactly one of its ends lies above the ray, so a corner on the ray counts once.
    #[must_use]
    pub fn ray_crossings(&self, p: Vec2) -> usize {
        let mut count = 0;
        self.for_each_ray_crossing(p, |_, _| count += 1);
        count
    }

    /// Calls `visit(edge, turn)` for each edge that the ray from `p` towards +x crosses: `turn` is 1 for an edge that
    /// goes up and -1 for one that goes down.
    ///
    /// The turns of a closed polygon sum to its winding number around `p`.
    pub fn for_each_ray_crossing(&self, p: Vec2, mut visit: impl FnMut(usize, i32)) {
        self.visit(
            |b| b.min.y <= p.y && p.y <= b.max.y && p.x <= b.max.x,
            |slot| {
                let [a, b] = self.edges[slot];
                let side = orientation(a, b, p);
                if a.y <= p.y && p.y < b.y && side > 0.0 {
                    visit(self.ids[slot] as usize, 1);
                } else if b.y <= p.y && p.y < a.y && side < 0.0 {
                    visit(self.ids[slot] as usize, -1);
                }
                false
            },
        );
    }

    /// Every pair of edges that meet elsewhere than at a common end, sorted by index.
    #[must_use]
    pub fn self_intersections(&self) -> Vec<Intersection> {
        let mut found = Vec::new();
        for slot in 0..self.edges.len() {
            let [a, b] = self.edges[slot];
            let bounds = Bounds::of(&[a, b]);
            self.visit(
                |node| node.overlaps(bounds),
                |other| {
                    let [c, d] = self.edges[other];
                    if self.ids[slot] < self.ids[other]
                        && let Some(point) = segment_contact(a, b, c, d)
                        && !((point == a || point == b) && (point == c || point == d))
                    {
                        found.push(Intersection {
                            first: self.ids[slot] as usize,
                            second: self.ids[other] as usize,
                            point,
                        });
                    }
                    false
                },
            );
        }
        found.sort_unstable_by_key(|i| (i.first, i.second));
        found
    }

    /// Calls `leaf(slot)` for every edge below nodes that `enter` admits, until it answers true.
    fn visit(&self, enter: impl Fn(&Bounds) -> bool, mut leaf: impl FnMut(usize) -> bool) {
        let mut stack = Stack::new(self.nodes.len());
        while let Some(index) = stack.pop() {
            let node = self.nodes[index];
            if !enter(&node.bounds) {
                continue;
            }
            if node.count == 0 {
                stack.push(node.first as usize);
                stack.push(index + 1);
                continue;
            }
            for slot in node.first as usize..(node.first + node.count) as usize {
                if leaf(slot) {
                    return;
                }
            }
        }
    }
}

/// Whether the line through `a` and `b` passes the rectangle by, for certain.
fn line_misses(a: Vec2, b: Vec2, bounds: Bounds) -> bool {
    let (center, half) = ((bounds.min + bounds.max) * 0.5, (bounds.max - bounds.min) * 0.5);
    let along = b - a;
    let reach = half.x * along.y.abs() + half.y * along.x.abs();
    let off = center - a;
    // No less than the product of the lengths, in which rounding is counted.
    let scale = (along.x.abs() + along.y.abs()) * (off.x.abs() + off.y.abs());
    along.cross(off).abs() > reach + 1e-12 * scale
}

/// The nodes still to visit; a balanced tree over 2³² edges is less than 40 deep.
pub(super) struct Stack {
    nodes: [u32; Self::DEPTH],
    len: usize,
}

impl Stack {
    const DEPTH: usize = 40;

    /// A stack that holds the root, if there is one.
    pub(super) fn new(nodes: usize) -> Self {
        Self { nodes: [0; Self::DEPTH], len: usize::from(nodes > 0) }
    }

    pub(super) fn push(&mut self, node: usize) {
        self.nodes[self.len] = node as u32;
        self.len += 1;
    }

    pub(super) fn pop(&mut self) -> Option<usize> {
        self.len = self.len.checked_sub(1)?;
        Some(self.nodes[self.len] as usize)
    }
}

/// Appends the nodes over the edges `order`, whose first slot is `first`; splits at the median of the longer axis.
fn build(edges: &[[Vec2; 2]], order: &mut [u32], first: u32, nodes: &mut Vec<Node>) {
    let bounds = order.iter().fold(Bounds::EMPTY, |b, &i| {
        let [p, q] = edges[i as usize];
        b.including(p).including(q)
    });
    let me = nodes.len();
    nodes.push(Node { bounds, first, count: order.len() as u32 });
    if order.len() <= LEAF_EDGES {
        return;
    }
    let wide = bounds.size().x >= bounds.size().y;
    let key = |i: u32| {
        let [p, q] = edges[i as usize];
        if wide { p.x + q.x } else { p.y + q.y }
    };
    let half = order.len() / 2;
    order.select_nth_unstable_by(half, |&i, &j| key(i).total_cmp(&key(j)));
    let (left, right) = order.split_at_mut(half);
    build(edges, left, first, nodes);
    let second = nodes.len() as u32;
    build(edges, right, first + half as u32, nodes);
    nodes[me].first = second;
    nodes[me].count = 0;
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::cell::Cell;
    use core::f64::consts::TAU;

    /// Nodes that look-ups must enter: those within the distance of the nearest edge, and those that meet a small box.
    fn entered(count: usize) -> [f64; 2] {
        let star = |angle: f64| Vec2::from_angle(angle) * (1.0 + 0.3 * (7.0 * angle).sin());
        let corner = |k: usize| star(TAU * (k % count) as f64 / count as f64);
        let tree = SegmentTree::new(&(0..count).map(|k| [corner(k), corner(k + 1)]).collect::<Vec<_>>());
        let (seen, queries) = (Cell::new([0, 0]), 500);
        for n in 0..queries {
            // Golden angles, now inside and now outside.
            let p = star(2.399_963_229_728_653 * n as f64) * (0.96 + 0.02 * (n % 5) as f64);
            let reach = tree.nearest(p).map_or(0.0, |found| found.distance * (1.0 + 1e-9));
            let near = |b: &Bounds| b.distance_squared(p) <= reach * reach;
            let corners = Bounds::of(&[p, p + Vec2::new(0.5, 0.25) * (1.0 / count as f64)]);
            let counted = |kind: usize, yes: bool| {
                let mut now = seen.get();
                now[kind] += 1;
                seen.set(now);
                yes
            };
            tree.visit(|b| counted(0, near(b)), |_| false);
            tree.visit(|b| counted(1, b.overlaps(corners)), |_| false);
        }
        seen.get().map(|nodes| f64::from(nodes) / queries as f64)
    }

    /// A hundred times as many edges are seven more levels: the work of a look-up must grow far less than the edges.
    #[test]
    fn look_ups_enter_few_nodes() {
        let (few, many) = (entered(1_000), entered(100_000));
        for (few, many) in few.into_iter().zip(many) {
            std::println!("{few} nodes, then {many}");
            assert!(many < 10.0 * few, "{few} nodes, then {many}");
        }
    }
}
