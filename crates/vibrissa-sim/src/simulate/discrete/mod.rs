//! The discrete rod: a chain of links and torsional springs pressed against a map, by minimising its energy.
//!
//! It knows nothing of the elastica: no shape is assumed, any number of contacts may act, and taper, rest curvature and an
//! elastic base are just springs. So it solves what one contact cannot describe, and it is the oracle of what one
//! contact can. Its error falls with the square of the number of links.
//!
//! Nodes and links keep off the map by a barrier that acts within [`REACH`] of a boundary and turns infinite on it; every
//! step is cut before a node would pass an edge or a link a vertex \[li2020ipc\]. A whisker can therefore never be on the wrong
//! side of a boundary, however thin, pointed or tangled the map is. Links are kept at their length by multipliers.
//!
//! | file | what it knows |
//! | --- | --- |
//! | `near` | distances of points and segments, and when moving ones meet |
//! | `energy` | energy, gradient, Hessian |
//! | `banded` | the solution of the linear equations |
//! | `relax` | Newton's method with line search |

mod banded;
mod energy;
mod near;
mod relax;

use crate::beam::Whisker;
use crate::plane::{Bounds, Pose2, Vec2};
use crate::world::Map;
use crate::{Error, Result};
use energy::{Barrier, Base, Springs};
use near::{Pair, distance};

/// Distance from boundaries at which contact forces act at last, over the whisker's length.
pub const REACH: f64 = 1e-6;
/// Stiffness of the links against stretching, over `EI / L²`; multipliers take the rest of the force.
const STRETCH: f64 = 1e6;
/// Stiffness that holds the first node at the base, over that of a link.
const ANCHOR: f64 = 1e4;
/// Turn of the whole rod at rest that lets a whisker pushed along its axis choose a side (rad).
const IMPERFECTION: f64 = 1e-6;
/// Presses closer along the whisker than so many links are one contact.
const ONE_CONTACT: f64 = 1.5;

/// How a search for the nearest equilibrium ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relaxed {
    /// At a minimum of the energy.
    Converged,
    /// Still moving after the most steps: the shape is the best one reached.
    Unfinished,
    /// The base could not follow: it runs into a boundary.
    Blocked,
}

/// One contact of the discrete rod.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Press {
    /// Arc length from the base to the contact (m).
    pub s_a: f64,
    /// The place on the whisker, map frame (m).
    pub position: Vec2,
    /// The force on the whisker, map frame (N).
    pub force: Vec2,
}

/// The rigidity of the joint at arc length `s` between links of length `h`: where wires of different stiffness meet, that
/// of both in a row.
fn rigidity_around(whisker: &Whisker, s: f64, h: f64) -> f64 {
    if whisker.stretches.as_slice().is_empty() {
        return whisker.rigidity_at(s);
    }
    let part = |k: u32| 1.0 / whisker.rigidity_at(s + h * ((f64::from(k) + 0.5) / 8.0 - 0.5));
    8.0 / (0..8).map(part).sum::<f64>()
}

/// A chain of links in a map.
#[derive(Clone, Debug)]
pub struct DiscreteRod {
    springs: Springs,
    length: f64,
    /// `EI / L²` (N): the scale of forces.
    unit: f64,
    base: Base,
    nodes: Vec<Vec2>,
    pairs: Vec<Pair>,
    /// Steps of Newton's method that are not asked for yet.
    steps: u64,
}

impl DiscreteRod {
    /// The unloaded rod of so many links.
    ///
    /// # Errors
    ///
    /// Usage: fewer than 4 or more than 2000 links. Data: a length, rigidity or base stiffness that is not positive, a tip
    /// ratio outside (0, 1], a curvature that is not finite.
    pub fn new(whisker: &Whisker, links: usize, map_from_whisker: Pose2) -> Result<Self> {
        if !(4..=2000).contains(&links) {
            return Err(Error::usage("links of the discrete rod").value(links).allowed("4 to 2000"));
        }
        let Whisker { length, flexural_rigidity, tip_ratio, curvature, base_stiffness, .. } = *whisker;
        let sound = length > 0.0 && flexural_rigidity > 0.0 && base_stiffness > 0.0 && tip_ratio > 0.0;
        if !(sound && tip_ratio <= 1.0 && curvature.is_finite() && (length * flexural_rigidity).is_finite()) {
            return Err(Error::data("whisker").value(format!("{whisker:?}")).allowed("positive, finite numbers"));
        }
        let h = length / links as f64;
        let joint = |i: usize| match i {
            0 => 1.0 / (0.5 * h / whisker.rigidity_at(0.25 * h) + 1.0 / base_stiffness),
            _ => rigidity_around(whisker, i as f64 * h, h) / h,
        };
        let curvature = |i: usize| whisker.curvature_at(if i == 0 { 0.25 * h } else { i as f64 * h });
        let rest = |i: usize| (curvature(i) * h + IMPERFECTION / links as f64) * if i == 0 { 0.5 } else { 1.0 };
        let unit = flexural_rigidity / (length * length);
        let stretch = STRETCH * unit / h;
        let springs = Springs {
            h,
            joints: (0..links).map(joint).collect(),
            rest: (0..links).map(rest).collect(),
            stretch,
            tension: vec![0.0; links],
            anchor: ANCHOR * stretch,
        };
        let base = Base { position: map_from_whisker.position(), heading: map_from_whisker.theta };
        let mut rod = Self { springs, length, unit, base, nodes: Vec::new(), pairs: Vec::new(), steps: 0 };
        rod.straighten(map_from_whisker);
        Ok(rod)
    }

    /// Takes the shape without load.
    fn straighten(&mut self, map_from_whisker: Pose2) {
        self.base = Base { position: map_from_whisker.position(), heading: map_from_whisker.theta };
        let mut nodes = vec![self.base.position];
        let mut heading = self.base.heading;
        let mut place = self.base.position;
        for rest in &self.springs.rest {
            heading += rest;
            place += Vec2::from_angle(heading) * self.springs.h;
            nodes.push(place);
        }
        self.nodes = nodes;
        self.springs.tension.fill(0.0);
    }

    /// Takes the shape of these points (map frame), one for each node from the base on, at this base.
    pub(super) fn pose(&mut self, map_from_whisker: Pose2, nodes: Vec<Vec2>) {
        self.base = Base { position: map_from_whisker.position(), heading: map_from_whisker.theta };
        if nodes.len() == self.nodes.len() {
            self.nodes = nodes;
        }
        self.springs.tension.fill(0.0);
    }

    /// The nodes from base to tip, map frame (m).
    #[must_use]
    pub fn nodes(&self) -> &[Vec2] {
        &self.nodes
    }

    /// The moment of the contact forces about the base (N m), counter-clockwise.
    #[must_use]
    pub fn moment(&self) -> f64 {
        self.springs.base_moment(self.base, &self.nodes)
    }

    /// The elastic energy, the base's included (J).
    #[must_use]
    pub fn energy(&self) -> f64 {
        self.springs.bending(self.base, &self.nodes)
    }

    /// The contacts from base to tip; what touches within a link and a half is one.
    #[must_use]
    pub fn presses(&self) -> Vec<Press> {
        let barrier = self.barrier(REACH);
        let mut all: Vec<Push> = self.pairs.iter().filter_map(|pair| self.push(pair, barrier)).collect();
        all.sort_by(|a, b| a.s_a.total_cmp(&b.s_a));
        let groups = all.chunk_by(|a, b| b.s_a - a.s_a < ONE_CONTACT * self.springs.h);
        let mut presses: Vec<Press> = groups.map(together).collect();
        presses.retain(|press| press.force.norm() > 1e-9 * self.unit);
        presses
    }

    /// What one pair contributes.
    fn push(&self, pair: &Pair, barrier: Barrier) -> Option<Push> {
        let figure = pair.figure(&self.nodes);
        let (d, at, n) = distance(figure);
        let size = -barrier.slopes(d).0 * pair.weight();
        if size.abs() <= 0.0 {
            return None;
        }
        let push = match *pair {
            Pair::Node { node, .. } | Pair::Corner { node, .. } => {
                Push { size, s_a: node as f64 * self.springs.h, position: figure.0, force: n * size }
            }
            Pair::Vertex { link, .. } => Push {
                size,
                s_a: (link as f64 + at) * self.springs.h,
                position: figure.1 + (figure.2 - figure.1) * at,
                force: n * -size,
            },
        };
        Some(push)
    }

    fn barrier(&self, reach: f64) -> Barrier {
        let reach = reach * self.length;
        Barrier { reach, scale: self.unit / reach }
    }

    /// The least distance between rod and map (m), if it is below `margin` (m); else infinite or some larger number.
    pub(super) fn clearance(&mut self, map: &Map, margin: f64) -> f64 {
        self.gather(map, margin);
        self.pairs.iter().map(|pair| distance(pair.figure(&self.nodes)).0).fold(f64::INFINITY, f64::min)
    }

    /// Whether no link meets a boundary.
    pub(super) fn is_clear(&self, map: &Map) -> bool {
        !self.nodes.windows(2).any(|link| map.crosses(link[0], link[1]))
    }

    /// Pairs of rod and map that are within `margin` (m) of each other, or nearly so.
    fn gather(&mut self, map: &Map, margin: f64) {
        self.pairs.clear();
        let links = self.nodes.len() - 1;
        let (mut edges, mut vertices) = (Vec::new(), Vec::new());
        for link in 0..links {
            let ends = [self.nodes[link], self.nodes[link + 1]];
            edges.clear();
            map.for_each_edge_in(Bounds::of(&ends).inflated(margin), |edge| {
                // An edge without length is its neighbours' vertex.
                if edge[0] != edge[1] {
                    edges.push(edge);
                }
                false
            });
            vertices.clear();
            vertices.extend(edges.iter().flatten().copied());
            vertices.sort_by(|a: &Vec2, b: &Vec2| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
            let nodes = if link == 0 { 0..2 } else { link + 1..link + 2 };
            for node in nodes {
                self.pairs.extend(edges.iter().map(|&edge| Pair::Node { node, edge }));
                let inside = if node == 0 || node == links { 0.0 } else { 1.0 };
                let corner = |same: &[Vec2]| Pair::Corner { node, vertex: same[0], excess: same.len() as f64 + inside };
                self.pairs.extend(vertices.chunk_by(|a, b| a == b).map(corner));
            }
            self.pairs.extend(vertices.chunk_by(|a, b| a == b).map(|same| Pair::Vertex { vertex: same[0], link }));
        }
    }
}

/// The share of one pair in a contact.
struct Push {
    size: f64,
    s_a: f64,
    position: Vec2,
    force: Vec2,
}

/// Pushes that are one contact.
fn together(pushes: &[Push]) -> Press {
    let total: f64 = pushes.iter().map(|push| push.size).sum();
    let mut press = Press { s_a: 0.0, position: Vec2::ZERO, force: Vec2::ZERO };
    let mut strongest = 0.0;
    for push in pushes {
        press.s_a += push.s_a * push.size / total;
        press.force += push.force;
        // The place is one that does touch; the middle of two may not.
        if push.size > strongest {
            (strongest, press.position) = (push.size, push.position);
        }
    }
    press
}
