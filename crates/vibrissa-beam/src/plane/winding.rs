//! How often closed outlines wind around a point.

use super::intersect::orientation;
use super::segment_tree::Stack;
use super::{Bounds, Vec2};
use alloc::vec::Vec;

/// How many edges a leaf holds at most.
const LEAF_EDGES: usize = 4;

/// A node over neighbouring edges of one outline, or over whole outlines. An inner node's left child follows it directly.
#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Bounds,
    /// Where its chain of edges starts and ends (m); the same for whole outlines, which end where they start.
    from_y: f64,
    to_y: f64,
    /// Leaf: its first edge. Inner: the index of the right child.
    first: u32,
    /// Leaf: how many edges. Inner: 0.
    count: u32,
}

/// Closed outlines, to ask how often they wind around a point: build O(n log n), look-up O(log n) as long as the
/// outlines are spread out.
///
/// A ray from the point towards +x counts the edges that it crosses. Of a chain that lies to the right of the point the
/// ends alone tell by how much its ways up outnumber its ways down, and of whole outlines there nothing is left over; so
/// only what the point's own place is entangled with is entered. Points must be finite; at most 2³² - 1 edges.
#[derive(Clone, Debug, Default)]
pub struct WindingTree {
    nodes: Vec<Node>,
    edges: Vec<[Vec2; 2]>,
}

impl WindingTree {
    /// The tree over closed outlines, each a chain of corners (m) whose last one repeats the first.
    #[must_use]
    pub fn new(outlines: &[Vec<Vec2>]) -> Self {
        let mut order: Vec<(Bounds, &[Vec2])> = outlines.iter().map(|o| (Bounds::of(o), o.as_slice())).collect();
        order.retain(|(_, outline)| outline.len() > 1);
        let mut tree = Self::default();
        if !order.is_empty() {
            tree.add_outlines(&mut order);
        }
        tree
    }

    /// How often the outlines wind around `p` (m), counter-clockwise positive: their sum.
    ///
    /// Of two sides of an edge `p` may be judged to lie on either when it lies on the edge.
    #[must_use]
    pub fn winding(&self, p: Vec2) -> i32 {
        let mut turns = 0;
        let mut stack = Stack::new(self.nodes.len());
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index];
            let Bounds { min, max } = node.bounds;
            if p.y < min.y || p.y > max.y || p.x > max.x {
                continue;
            }
            if p.x < min.x {
                turns += step(node.from_y, node.to_y, p.y);
            } else if node.count == 0 {
                stack.push(node.first as usize);
                stack.push(index + 1);
            } else {
                let edges = &self.edges[node.first as usize..(node.first + node.count) as usize];
                turns += edges.iter().map(|&edge| crossing(edge, p)).sum::<i32>();
            }
        }
        turns
    }

    /// Appends the nodes over whole outlines; splits at the median of the longer axis.
    fn add_outlines(&mut self, outlines: &mut [(Bounds, &[Vec2])]) {
        if let [(_, outline)] = outlines {
            let first = self.edges.len();
            self.edges.extend(outline.windows(2).map(|w| [w[0], w[1]]));
            return self.add_chain(first, self.edges.len());
        }
        let bounds = outlines.iter().fold(Bounds::EMPTY, |b, (own, _)| b.hull(*own));
        let wide = bounds.size().x >= bounds.size().y;
        let key = |b: &Bounds| if wide { b.min.x + b.max.x } else { b.min.y + b.max.y };
        let half = outlines.len() / 2;
        outlines.select_nth_unstable_by(half, |(a, _), (b, _)| key(a).total_cmp(&key(b)));
        let me = self.nodes.len();
        self.nodes.push(Node { bounds, from_y: 0.0, to_y: 0.0, first: 0, count: 0 });
        let (left, right) = outlines.split_at_mut(half);
        self.add_outlines(left);
        self.nodes[me].first = self.nodes.len() as u32;
        self.add_outlines(right);
    }

    /// Appends the nodes over the edges from `first` to before `end`, which are one chain.
    fn add_chain(&mut self, first: usize, end: usize) {
        let chain = &self.edges[first..end];
        let bounds = chain.iter().fold(Bounds::EMPTY, |b, edge| b.including(edge[0]).including(edge[1]));
        let (from_y, to_y) = (chain[0][0].y, chain[chain.len() - 1][1].y);
        let me = self.nodes.len();
        self.nodes.push(Node { bounds, from_y, to_y, first: first as u32, count: (end - first) as u32 });
        if end - first <= LEAF_EDGES {
            return;
        }
        let middle = usize::midpoint(first, end);
        self.add_chain(first, middle);
        let right = self.nodes.len() as u32;
        self.add_chain(middle, end);
        self.nodes[me].first = right;
        self.nodes[me].count = 0;
    }
}

/// By how much the ways up across the height `y` outnumber those down, on any way from one height to another.
fn step(from: f64, to: f64, y: f64) -> i32 {
    i32::from(from <= y && y < to) - i32::from(to <= y && y < from)
}

/// Whether the ray from `p` towards +x crosses the edge upwards (1), downwards (-1) or not (0).
fn crossing([a, b]: [Vec2; 2], p: Vec2) -> i32 {
    let up = step(a.y, b.y, p.y);
    if up != 0 && f64::from(up) * orientation(a, b, p) > 0.0 { up } else { 0 }
}
