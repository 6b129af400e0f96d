//! The residuals of a stretch of contact, and what they leave open.

use super::node::{Bender, NodePrediction, UNKNOWNS};
use super::{TILT_STD, TIP_ALONE, Trace, TraceNode, TraceOptions, TracePoint};
use crate::Stop;
use crate::beam::Whisker;
use crate::least_squares::{Band, Descent, Factor, Normal, Rules, descend, unbounded};
use crate::plane::Vec2;

/// Most rounds, and a gain that is none: the wall's turns settle slowly.
const RULES: Rules = Rules { rounds: 60, gain: 1e-6, damping: 1e-3 };
/// Where a wall turns between two nodes is not known: the mean direction of its ends misses the way between them by this share
/// of the way times the turn (standard deviation). 0.29 were right for a corner anywhere on the way; most walls turn smoothly.
const TURN_SHARE: f64 = 0.1;
/// How seldom walls turn much: the chance of a turn falls with this power of its square.
const TAIL: f64 = 1.0;
/// Rounds in which what the wall's turns leave open is taken from the way before.
const LOOSENINGS: usize = 2;
/// Travel of the base over which a lean is asked to be moderate once (m): readings may be as dense as they are.
const LEAN_TRAVEL: f64 = 0.8e-3;
/// How far a side slides along the whisker, over the travel of the base (standard deviation): a corner's contact keeps up with it.
const SLIDE: f64 = 1.5;

/// The unknowns of all nodes: force over its unit, lean.
pub(super) type Unknowns = Vec<f64>;
/// A way through the nodes, settled.
pub(super) type Way = Descent<Vec<NodePrediction>>;

/// A trace to be solved.
#[derive(Clone, Copy)]
pub(super) struct TraceProblem<'a> {
    pub(super) bender: Bender<'a>,
    pub(super) nodes: &'a [TraceNode],
    pub(super) options: TraceOptions,
    /// Largest slope at the contact (rad).
    pub(super) largest_slope: f64,
    /// Standard deviation of the share of the whisker beyond a side.
    pub(super) side_std: f64,
    /// Who asks for an end: no contact is found from then on.
    pub(super) stop: &'a Stop,
}

/// A step of the contact: across the mean direction of its ends (m), and along it (m).
#[derive(Clone, Copy)]
pub(super) struct NodeStep {
    pub(super) across: f64,
    along: f64,
    tangent: Vec2,
    /// What the turn leaves open (m).
    open: f64,
}

impl<'a> TraceProblem<'a> {
    pub(super) fn new(
        whisker: &'a Whisker,
        nodes: &'a [TraceNode],
        options: TraceOptions,
        largest_slope: f64,
        stop: &'a Stop,
    ) -> Self {
        let unit = whisker.flexural_rigidity / (whisker.length * whisker.length);
        let side = nodes.first().map_or(1.0, |node| node.moment.signum());
        TraceProblem {
            bender: Bender { whisker, unit, side },
            nodes,
            options,
            largest_slope,
            side_std: TIP_ALONE,
            stop,
        }
    }

    /// A part of the trace.
    pub(super) fn part(&self, from: usize, to: usize) -> TraceProblem<'a> {
        TraceProblem { nodes: &self.nodes[from..to], ..*self }
    }

    fn felt(&self, unknowns: &[f64]) -> Option<Vec<NodePrediction>> {
        let one = |(node, u): (&TraceNode, &[f64])| {
            if self.stop.is_asked() { None } else { self.bender.felt(node, u, self.largest_slope) }
        };
        self.nodes.iter().zip(unknowns.chunks(UNKNOWNS)).map(one).collect()
    }

    /// How far the base moves between two nodes; a turn counts at the tip (m).
    fn travel(&self, i: usize) -> f64 {
        let [Some(a), Some(b)] = [self.nodes.get(i), self.nodes.get(i + 1)] else { return 1e-5 };
        let step = a.odom_from_whisker.between(b.odom_from_whisker);
        (step.position().norm() + self.bender.whisker.length * step.theta.abs()).max(1e-5)
    }

    /// What a node's lean is worth.
    fn lean_weight(&self, i: usize, lean: f64) -> f64 {
        let travel = self.travel(i.min(self.nodes.len().saturating_sub(2)));
        (travel / LEAN_TRAVEL).min(1.0).sqrt() / if lean > 0.0 { TILT_STD } else { self.side_std }
    }

    /// How far the wall may turn between two nodes (rad).
    pub(super) fn turn_std(&self, i: usize) -> f64 {
        self.options.turn * self.travel(i).sqrt()
    }

    fn step(felt: &[NodePrediction], i: usize) -> NodeStep {
        let (a, b) = (&felt[i], &felt[i + 1]);
        let tangent = Vec2::from_angle(0.5 * (a.along + b.along));
        let way = b.position - a.position;
        let open = TURN_SHARE * way.norm() * (b.along - a.along);
        NodeStep { across: way.dot(tangent.perp()), along: way.dot(tangent), tangent, open }
    }

    /// How far each step of the contact may miss the wall's direction (m).
    fn step_stds(&self, felt: &[NodePrediction]) -> Vec<f64> {
        (1..felt.len()).map(|i| self.options.step_std.hypot(Self::step(felt, i - 1).open)).collect()
    }

    /// By how many standard deviations a step misses the wall's direction.
    pub(super) fn miss(&self, felt: &[NodePrediction], i: usize) -> f64 {
        let step = Self::step(felt, i);
        step.across / self.options.step_std.hypot(step.open)
    }

    /// A side lies on what curves away from it: how far a step goes the other way, and where it is counted.
    fn hollow(&self, i: usize, felt: &[NodePrediction], leans: [f64; 2], step: NodeStep) -> f64 {
        if leans[0].max(leans[1]) >= 0.0 {
            return 0.0;
        }
        let turn = (felt[i + 1].along - felt[i].along) / self.turn_std(i);
        (self.bender.side * turn * step.along / self.travel(i)).max(0.0)
    }

    /// How far a side slides along the whisker in a step, in standard deviations; a tip does not.
    fn slide(&self, i: usize, leans: [f64; 2]) -> f64 {
        (leans[1].min(0.0) - leans[0].min(0.0)) * self.slide_weight(i)
    }

    fn slide_weight(&self, i: usize) -> f64 {
        self.bender.whisker.length / (SLIDE * self.travel(i))
    }

    /// Half the sum of the squares, robust where the wall turns; the steps may miss the wall's direction by `stds` (m).
    fn cost(&self, felt: &[NodePrediction], unknowns: &[f64], stds: &[f64]) -> f64 {
        let mut cost = 0.0;
        for (i, (node, here)) in self.nodes.iter().zip(felt).enumerate() {
            let lean = unknowns[UNKNOWNS * i + 1];
            cost += 0.5 * ((here.bend.moment - node.moment) / node.std).powi(2);
            cost += 0.5 * (lean * self.lean_weight(i, lean)).powi(2);
            if i + 1 < felt.len() {
                let step = Self::step(felt, i);
                let leans = [lean, unknowns[UNKNOWNS * i + 3]];
                cost += 0.5 * (step.across / stds[i]).powi(2) + (stds[i] / self.options.step_std).ln();
                cost += 0.5 * self.hollow(i, felt, leans, step).powi(2) + 0.5 * self.slide(i, leans).powi(2);
                let turn = (felt[i + 1].along - here.along) / self.turn_std(i);
                cost += seldom(turn);
            }
        }
        cost
    }

    /// The cost of the first nodes of a way.
    pub(super) fn cost_of(&self, way: &Way, nodes: usize) -> f64 {
        let felt = &way.state[..nodes];
        self.part(0, nodes).cost(felt, &way.unknowns[..UNKNOWNS * nodes], &self.step_stds(felt))
    }

    /// Normal matrix and gradient.
    fn normal_equations(&self, felt: &[NodePrediction], unknowns: &[f64], stds: &[f64]) -> Normal {
        let mut band = Band::zeros(unknowns.len(), 2 * UNKNOWNS - 1);
        let mut gradient = vec![0.0; unknowns.len()];
        let mut add = |first: usize, row: &[f64], residual: f64| {
            band.add_square(first, row);
            row.iter().enumerate().for_each(|(k, d)| gradient[first + k] += d * residual);
        };
        for (i, (node, here)) in self.nodes.iter().zip(felt).enumerate() {
            let first = UNKNOWNS * i;
            let weight = 1.0 / node.std;
            add(first, &here.moment_by.map(|d| d * weight), (here.bend.moment - node.moment) * weight);
            let lean = unknowns[first + 1];
            let weight = self.lean_weight(i, lean);
            add(first + 1, &[weight], lean * weight);
            if i + 1 < felt.len() {
                let next = &felt[i + 1];
                let step = Self::step(felt, i);
                let rows = Rows::new(here, next, step);
                let weight = 1.0 / stds[i];
                add(first, &rows.across.map(|d| d * weight), step.across * weight);
                let std = self.turn_std(i);
                let turn = (next.along - here.along) / std;
                let robust = seldom_weight(turn).sqrt();
                add(first, &rows.turning.map(|d| d * robust / std), turn * robust);
                let leans = [lean, unknowns[first + 3]];
                self.side_rows(i, felt, leans, step, &rows, &mut add);
            }
        }
        Normal { matrix: band, gradient }
    }

    /// What is asked of sides alone.
    fn side_rows(
        &self,
        i: usize,
        felt: &[NodePrediction],
        leans: [f64; 2],
        step: NodeStep,
        rows: &Rows,
        add: &mut impl FnMut(usize, &[f64], f64),
    ) {
        let first = UNKNOWNS * i;
        let hollow = self.hollow(i, felt, leans, step);
        if hollow > 0.0 {
            let turn = felt[i + 1].along - felt[i].along;
            let weight = self.bender.side / (self.turn_std(i) * self.travel(i));
            let by = |k: usize| weight * (rows.turning[k] * step.along + turn * rows.along[k]);
            add(first, &[by(0), by(1), by(2), by(3)], hollow);
        }
        if leans[0].min(leans[1]) < 0.0 {
            let weight = |lean: f64| if lean < 0.0 { self.slide_weight(i) } else { 0.0 };
            add(first + 1, &[-weight(leans[0]), 0.0, weight(leans[1])], self.slide(i, leans));
        }
    }

    /// Down from `unknowns`, steps missing the wall's direction by no more than where walls do not turn.
    pub(super) fn descend(&self, unknowns: Unknowns) -> Option<Way> {
        let stds = vec![self.options.step_std; self.nodes.len()];
        self.descend_with(unknowns, &stds)
    }

    /// The same, and on with what the wall's turns leave open.
    pub(super) fn settle(&self, unknowns: Unknowns) -> Option<Way> {
        let mut way = self.descend(unknowns)?;
        for _ in 0..LOOSENINGS {
            let stds = self.step_stds(&way.state);
            way = self.descend_with(way.unknowns, &stds)?;
        }
        Some(way)
    }

    fn descend_with(&self, unknowns: Unknowns, stds: &[f64]) -> Option<Way> {
        let evaluate = |unknowns: &[f64]| {
            let felt = self.felt(unknowns)?;
            let cost = self.cost(&felt, unknowns, stds);
            Some((felt, cost))
        };
        let normal = |unknowns: &[f64], felt: &Vec<NodePrediction>| Some(self.normal_equations(felt, unknowns, stds));
        descend(unknowns, RULES, evaluate, normal, unbounded)
    }

    /// The factor of the normal equations about a way.
    pub(super) fn factor(&self, way: &Way) -> Option<Factor> {
        self.normal_equations(&way.state, &way.unknowns, &self.step_stds(&way.state)).matrix.factor()
    }

    /// How the wall's turn in a step goes with the unknowns of its ends.
    pub(super) fn turning(felt: &[NodePrediction], i: usize) -> [f64; 2 * UNKNOWNS] {
        Rows::new(&felt[i], &felt[i + 1], Self::step(felt, i)).turning
    }

    /// The trace along a way; `rivals` are other ways through the same nodes and beyond.
    pub(super) fn trace(&self, way: &Way, rivals: &[Way]) -> Option<Trace> {
        let factor = self.factor(way)?;
        let open = self.open(way, &factor);
        let mut doubts = self.doubts(way, rivals);
        doubts.iter_mut().zip(&open).for_each(|(doubt, open)| doubt.x = doubt.x.hypot(open.sqrt()));
        let points = self.points(&way.state, &factor, &doubts);
        let square: f64 = doubts.iter().map(|d| d.dot(*d)).sum();
        Some(Trace { points, doubt: (square / doubts.len().max(1) as f64).sqrt() })
    }

    /// How far the rivals are from a way at each node, weighted by how likely they are beside it: root of the mean squares
    /// across and along the wall (m).
    fn doubts(&self, way: &Way, rivals: &[Way]) -> Vec<Vec2> {
        let nodes = way.state.len();
        let rivals: Vec<&Way> = rivals.iter().filter(|rival| rival.state.len() >= nodes).collect();
        let own = self.cost_of(way, nodes);
        let weights: Vec<f64> = rivals.iter().map(|rival| (own - self.cost_of(rival, nodes)).min(0.0).exp()).collect();
        let total = 1.0 + weights.iter().sum::<f64>();
        let at = |(i, here): (usize, &NodePrediction)| {
            let tangent = Vec2::from_angle(here.along);
            let off = |(rival, weight): (&&Way, &f64)| {
                let off = rival.state[i].position - here.position;
                Vec2::new(off.dot(tangent.perp()).powi(2), off.dot(tangent).powi(2)) * (weight / total)
            };
            let sum = rivals.iter().zip(&weights).map(off).fold(Vec2::ZERO, |a, b| a + b);
            Vec2::new(sum.x.sqrt(), sum.y.sqrt())
        };
        way.state.iter().enumerate().map(at).collect()
    }

    fn points(&self, felt: &[NodePrediction], factor: &Factor, doubts: &[Vec2]) -> Vec<TracePoint> {
        let one = |(i, (node, here)): (usize, (&TraceNode, &NodePrediction))| {
            let normal = Vec2::from_angle(here.along).perp();
            let mut unit = vec![0.0; UNKNOWNS * felt.len()];
            for k in 0..UNKNOWNS {
                unit[UNKNOWNS * i + k] = here.position_by[k].dot(normal);
            }
            let spread = factor.solve(unit);
            let variance: f64 = (0..UNKNOWNS).map(|k| spread[UNKNOWNS * i + k] * here.position_by[k].dot(normal)).sum();
            TracePoint {
                t: node.t,
                position: here.position,
                normal: here.bend.force_vector().rotated(node.odom_from_whisker.theta).angle(),
                std: variance.max(0.0).sqrt().hypot(doubts[i].x),
                residual: (here.bend.moment - node.moment) / node.std,
                bend: here.bend.clone(),
            }
        };
        self.nodes.iter().zip(felt).enumerate().map(one).collect()
    }
}

/// What a turn costs (half a sum of squares) that is so many standard deviations large: Student's law.
fn seldom(turn: f64) -> f64 {
    TAIL * (turn * turn / (2.0 * TAIL)).ln_1p()
}

/// The weight of its square.
pub(super) fn seldom_weight(turn: f64) -> f64 {
    1.0 / (1.0 + turn * turn / (2.0 * TAIL))
}

/// How likely a turn is beside none.
pub(super) fn seldom_share(turn: f64) -> f64 {
    (-seldom(turn)).exp()
}

/// How a step across and along the wall and the wall's turn change with the unknowns of both ends.
struct Rows {
    across: [f64; 2 * UNKNOWNS],
    along: [f64; 2 * UNKNOWNS],
    turning: [f64; 2 * UNKNOWNS],
}

impl Rows {
    fn new(here: &NodePrediction, next: &NodePrediction, step: NodeStep) -> Self {
        let (mut across, mut along, mut turning) = ([0.0; 2 * UNKNOWNS], [0.0; 2 * UNKNOWNS], [0.0; 2 * UNKNOWNS]);
        let normal = step.tangent.perp();
        for (first, end, sign) in [(0, here, -1.0), (UNKNOWNS, next, 1.0)] {
            for k in 0..UNKNOWNS {
                across[first + k] = sign * end.position_by[k].dot(normal) - 0.5 * end.along_by[k] * step.along;
                along[first + k] = sign * end.position_by[k].dot(step.tangent) + 0.5 * end.along_by[k] * step.across;
                turning[first + k] = sign * end.along_by[k];
            }
        }
        Self { across, along, turning }
    }
}
