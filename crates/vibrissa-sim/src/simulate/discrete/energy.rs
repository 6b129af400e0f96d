//! The energy of the discrete rod, with its first and second derivatives.
//!
//! Where a node is nearest to a vertex, two edges, two links and their pairs all see the same distance. Pairs of node and
//! vertex take away what is counted too often, so that the repulsion is that of one pair everywhere and no vertex
//! stands out as a bump that would hold a sliding tip.

use super::banded::Banded;
use super::near::{Pair, distance};
use crate::plane::{Vec2, wrap_angle};

/// Torsional springs between stretchable links, on a base.
#[derive(Clone, Debug)]
pub(super) struct Springs {
    /// Length of a link at rest (m).
    pub(super) h: f64,
    /// Stiffness of the joint at each node but the last (N m/rad); the first is the base's.
    pub(super) joints: Vec<f64>,
    /// Turn of each joint at rest (rad).
    pub(super) rest: Vec<f64>,
    /// Stiffness of a link (N/m).
    pub(super) stretch: f64,
    /// Tension that holds each link at its length (N), positive when it pulls.
    pub(super) tension: Vec<f64>,
    /// Stiffness that holds the first node at the base (N/m).
    pub(super) anchor: f64,
}

/// The repulsion between rod and map: `-scale (d - reach)² ln(d / reach)` for distances `d` below `reach`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Barrier {
    pub(super) reach: f64,
    pub(super) scale: f64,
}

impl Barrier {
    fn energy(&self, d: f64) -> f64 {
        if d >= self.reach {
            return 0.0;
        }
        let gap = d - self.reach;
        -self.scale * gap * gap * (d / self.reach).ln()
    }

    /// First and second derivative by the distance.
    pub(super) fn slopes(&self, d: f64) -> (f64, f64) {
        if d >= self.reach {
            return (0.0, 0.0);
        }
        let (gap, log) = (d - self.reach, (d / self.reach).ln());
        let first = -self.scale * gap * (2.0 * log + gap / d);
        let second = self.scale * (-2.0 * log - 4.0 * gap / d + gap * gap / (d * d));
        (first, second)
    }
}

/// Where the base is and where it points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Base {
    pub(super) position: Vec2,
    pub(super) heading: f64,
}

impl Springs {
    /// The turn of the joint at node `i` (rad).
    fn turn(&self, base: Base, nodes: &[Vec2], i: usize) -> f64 {
        let out = nodes[i + 1] - nodes[i];
        if i == 0 {
            return wrap_angle(out.angle() - base.heading);
        }
        let back = nodes[i] - nodes[i - 1];
        back.cross(out).atan2(back.dot(out))
    }

    /// The moment that the base feels, counter-clockwise (N m).
    pub(super) fn base_moment(&self, base: Base, nodes: &[Vec2]) -> f64 {
        self.joints[0] * (self.turn(base, nodes, 0) - self.rest[0])
    }

    /// The energy of bending (J).
    pub(super) fn bending(&self, base: Base, nodes: &[Vec2]) -> f64 {
        let joint = |i: usize| {
            let off = self.turn(base, nodes, i) - self.rest[i];
            0.5 * self.joints[i] * off * off
        };
        (0..self.joints.len()).map(joint).sum()
    }

    pub(super) fn energy(&self, base: Base, nodes: &[Vec2], pairs: &[Pair], barrier: Barrier) -> f64 {
        let link = |(i, tension): (usize, &f64)| {
            let longer = nodes[i + 1].distance(nodes[i]) - self.h;
            (0.5 * self.stretch * longer + tension) * longer
        };
        let links: f64 = self.tension.iter().enumerate().map(link).sum();
        let repelled: f64 =
            pairs.iter().map(|pair| pair.weight() * barrier.energy(distance(pair.figure(nodes)).0)).sum();
        let anchored = 0.5 * self.anchor * (nodes[0] - base.position).norm_squared();
        self.bending(base, nodes) + links + repelled + anchored
    }

    /// Gradient and Hessian.
    pub(super) fn derivatives(
        &self,
        base: Base,
        nodes: &[Vec2],
        pairs: &[Pair],
        barrier: Barrier,
        out: &mut Derivatives,
    ) {
        out.gradient.fill(0.0);
        out.hessian.clear();
        let pulled = (nodes[0] - base.position) * self.anchor;
        out.push(0, pulled);
        out.hessian.add(0, 0, self.anchor);
        out.hessian.add(1, 1, self.anchor);
        for i in 0..self.tension.len() {
            self.link(nodes, i, out);
        }
        for i in 0..self.joints.len() {
            self.joint(base, nodes, i, out);
        }
        for pair in pairs {
            repulsion(pair, nodes, barrier, out);
        }
    }

    fn link(&self, nodes: &[Vec2], i: usize, out: &mut Derivatives) {
        let along = nodes[i + 1] - nodes[i];
        let length = along.norm();
        let t = along * (1.0 / length);
        let n = t.perp();
        let force = self.stretch * (length - self.h) + self.tension[i];
        out.push(i, t * -force);
        out.push(i + 1, t * force);
        let across = force / length;
        let block = |a: usize, b: usize| {
            let (t, n) = ([t.x, t.y], [n.x, n.y]);
            self.stretch * t[a] * t[b] + across * n[a] * n[b]
        };
        out.difference_block(i, block);
    }

    fn joint(&self, base: Base, nodes: &[Vec2], i: usize, out: &mut Derivatives) {
        let off = self.turn(base, nodes, i) - self.rest[i];
        let moment = self.joints[i] * off;
        // The angle of a link: first derivative by its vector, and the second one.
        let of_link = |e: Vec2| {
            let inverse = 1.0 / e.norm_squared();
            let twist = inverse * inverse;
            let (xy, xx) = (2.0 * e.x * e.y * twist, (e.y * e.y - e.x * e.x) * twist);
            (e.perp() * inverse, [xy, xx, -xy])
        };
        let (g_out, h_out) = of_link(nodes[i + 1] - nodes[i]);
        out.curved_difference(i, h_out.map(|v| moment * v));
        if i == 0 {
            out.outer(&[(0, -g_out), (1, g_out)], self.joints[0]);
            out.push(0, g_out * -moment);
            out.push(1, g_out * moment);
            return;
        }
        let (g_back, h_back) = of_link(nodes[i] - nodes[i - 1]);
        out.curved_difference(i - 1, h_back.map(|v| -moment * v));
        let parts = [(i - 1, g_back), (i, -g_back - g_out), (i + 1, g_out)];
        out.outer(&parts, self.joints[i]);
        for (node, part) in parts {
            out.push(node, part * moment);
        }
    }
}

fn repulsion(pair: &Pair, nodes: &[Vec2], barrier: Barrier, out: &mut Derivatives) {
    let figure = pair.figure(nodes);
    let (d, at, n) = distance(figure);
    if d >= barrier.reach {
        return;
    }
    let (first, second) = barrier.slopes(d);
    let (first, second) = (pair.weight() * first, pair.weight() * second);
    match *pair {
        Pair::Node { node, .. } | Pair::Corner { node, .. } => {
            out.push(node, n * first);
            out.outer(&[(node, n)], second);
            if !(at > 0.0 && at < 1.0) {
                // About a vertex the normal turns with the node: without this a pointed vertex would seem to hold it.
                out.outer(&[(node, n.perp())], first / d);
            }
        }
        Pair::Vertex { link, .. } => {
            let parts = [(link, n * (at - 1.0)), (link + 1, n * -at)];
            for (node, part) in parts {
                out.push(node, part * first);
            }
            out.outer(&parts, second);
            if at > 0.0 && at < 1.0 {
                // The normal turns with the link: d² d = (2 / l) (n·de) (t·dc) up to d itself, c the point beside the vertex.
                let along = figure.2 - figure.1;
                let (length, t) = (along.norm(), along * (1.0 / along.norm()));
                let turn = [(link, n * -1.0), (link + 1, n)];
                let slide = [(link, t * (1.0 - at)), (link + 1, t * at)];
                out.product(&turn, &slide, first / length);
            } else {
                let end = link + usize::from(at > 0.5);
                out.outer(&[(end, n.perp())], first / d);
            }
        }
    }
}

/// Gradient and Hessian of the energy by the nodes' coordinates.
#[derive(Clone, Debug)]
pub(super) struct Derivatives {
    pub(super) gradient: Vec<f64>,
    pub(super) hessian: Banded,
}

impl Derivatives {
    pub(super) fn new(nodes: usize) -> Self {
        Self { gradient: vec![0.0; 2 * nodes], hessian: Banded::zero(2 * nodes) }
    }

    #[inline]
    fn push(&mut self, node: usize, force: Vec2) {
        self.gradient[2 * node] += force.x;
        self.gradient[2 * node + 1] += force.y;
    }

    /// Adds `weight g gᵀ` where `g` has these parts, in order of nodes.
    #[inline]
    fn outer(&mut self, parts: &[(usize, Vec2)], weight: f64) {
        for (k, &(i, a)) in parts.iter().enumerate() {
            for &(j, b) in &parts[..k] {
                let scaled = b * weight;
                self.hessian.add(2 * i, 2 * j, a.x * scaled.x);
                self.hessian.add(2 * i, 2 * j + 1, a.x * scaled.y);
                self.hessian.add(2 * i + 1, 2 * j, a.y * scaled.x);
                self.hessian.add(2 * i + 1, 2 * j + 1, a.y * scaled.y);
            }
            self.hessian.add(2 * i, 2 * i, weight * a.x * a.x);
            self.hessian.add(2 * i + 1, 2 * i, weight * a.x * a.y);
            self.hessian.add(2 * i + 1, 2 * i + 1, weight * a.y * a.y);
        }
    }

    /// Adds `weight (g hᵀ + h gᵀ)`, both with parts at the same two nodes.
    fn product(&mut self, g: &[(usize, Vec2); 2], h: &[(usize, Vec2); 2], weight: f64) {
        let flat = |v: &[(usize, Vec2); 2]| [v[0].1.x, v[0].1.y, v[1].1.x, v[1].1.y];
        let (g_all, h_all, first) = (flat(g), flat(h), 2 * g[0].0);
        for i in 0..4 {
            for j in 0..=i {
                self.hessian.add(first + i, first + j, weight * (g_all[i] * h_all[j] + h_all[i] * g_all[j]));
            }
        }
    }

    /// Adds a block that acts on the difference of node `i + 1` and node `i`.
    fn difference_block(&mut self, i: usize, block: impl Fn(usize, usize) -> f64) {
        for a in 0..2 {
            for b in 0..2 {
                let value = block(a, b);
                self.hessian.add(2 * i + 2 + a, 2 * i + b, -value);
                if b <= a {
                    self.hessian.add(2 * i + a, 2 * i + b, value);
                    self.hessian.add(2 * i + 2 + a, 2 * i + 2 + b, value);
                }
            }
        }
    }

    /// The same for a symmetric block given as `[xx, xy, yy]`.
    fn curved_difference(&mut self, i: usize, [xx, xy, yy]: [f64; 3]) {
        self.difference_block(i, |a, b| match a + b {
            0 => xx,
            1 => xy,
            _ => yy,
        });
    }
}
