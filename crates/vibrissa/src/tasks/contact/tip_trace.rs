//! Where the tip went while it slid along a wall: the whole stretch of contact at once.
//!
//! With the tip in contact and no friction, a reading leaves a curve of places open, along which the direction of the
//! force runs. That force is normal to the wall, and the wall is where the tip goes: the direction of the path and the
//! direction of the force must fit at every instant. So a stretch of contact is one least-squares problem. Its unknowns
//! are the force and its tilt at each node; what it asks for:
//!
//! | residual | in units of |
//! | --- | --- |
//! | the moment is the reading | the reading's standard deviation |
//! | a step of the tip is normal to the mean force of its ends | [`TraceOptions::step_std`] |
//! | the wall turns little, and seldom much (Cauchy's loss) | [`TraceOptions::turn`] times the root of the travel |
//! | the tilt is moderate | [`TILT_STD`] |
//!
//! Neighbours alone are coupled, so the normal equations are a band, and a sweep is solved in milliseconds.

use crate::beam::{Bend, Load, Whisker, force_mode, moment_mode};
use crate::least_squares::{Band, Descent, Factor, Normal, Rules, descend, unbounded};
use crate::plane::{Pose2, Vec2};

/// Standard deviation of the force's tilt from the whisker's normal (rad): wide, it only speaks where nothing else does.
const TILT_STD: f64 = 0.8;
/// Unknowns of a node.
const UNKNOWNS: usize = 2;
/// Tilts of the force at the first node to start from (rad).
const STARTS: [f64; 5] = [0.0, -0.5, 0.5, -1.0, 1.0];
/// A start is solved each time it has grown by this many nodes,
const GROWTH: usize = 5;
/// over this many of its last ones, and over more where that tears the way. A short window is quick; but where the whisker is
/// strongly bent, windows that are free at their beginning slide off, each a little, to another shape.
const WINDOWS: [usize; 3] = [30, 90, 270];
/// A step of the tip that misses the wall's direction by more standard deviations tears the way: where all is well none misses by
/// one, and where the way changes from one shape to another, hundreds do.
const TORN: f64 = 5.0;
/// Largest tilt of the force (rad): beyond, it all but pulls or pushes along the whisker.
const STEEPEST_TILT: f64 = 1.5;
/// Fewest nodes of a trace.
const FEWEST: usize = 5;
/// Mean square of the newest residuals from which on the contact is taken to have jumped.
const JUMP: f64 = 6.0;
/// Largest residual of a new node, in standard deviations, before the contact is taken to have jumped.
const LARGEST_FAULT: f64 = 4.0;
/// A fall of the moment from one node to the next is a snap when it is beyond what the errors and this many times the
/// stiffness of a hardly bent whisker explain; onsets reach 3, but they rise.
const SNAP: f64 = 3.0;
/// Share of a curled trace's length below which one that is less bent is taken to be wrong.
const CURLED: f64 = 0.7;
/// How straight, in units of [`TraceOptions::turn`], the wall is first taken to be on the way around local minima.
const STRAIGHT: f64 = 0.3;
/// Largest slope of the tip on the branch that grows from the straight whisker (rad): near the fold, and beyond it the
/// moment alone would lead on to the curled shapes, to which a whisker comes by a snap only.
const LARGEST_SLOPE: f64 = 1.7;
/// Most rounds, and a gain that is none: the wall's turns settle slowly.
const RULES: Rules = Rules { rounds: 60, gain: 1e-6, damping: 1e-3 };

/// One node: a reading, or the mean of neighbouring ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceNode {
    /// When (s).
    pub t: f64,
    /// The whisker's base, odometry frame.
    pub odom_from_whisker: Pose2,
    /// The moment (N m), not zero; all nodes of a trace have the same sign.
    pub moment: f64,
    /// Its standard deviation (N m).
    pub std: f64,
}

/// What is known of walls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceOptions {
    /// How far a step of the tip may miss the wall's direction (m).
    pub step_std: f64,
    /// How much the wall turns along the way (rad per root of a metre).
    pub turn: f64,
}

/// A tip contact along a trace, odometry frame.
#[derive(Clone, Debug, PartialEq)]
pub struct TracePoint {
    /// When (s).
    pub t: f64,
    /// The tip (m).
    pub position: Vec2,
    /// Direction of the wall's normal, which is that of the force (rad).
    pub normal: f64,
    /// Standard deviation of the place across the wall (m).
    pub std: f64,
    /// The whisker.
    pub bend: Bend,
    /// The moment's residual, in standard deviations.
    pub residual: f64,
}

/// The state of a node while it is solved.
#[derive(Clone)]
struct Tip {
    bend: Bend,
    position: Vec2,
    /// Direction along the wall: the force's direction less a quarter turn (rad), not wrapped.
    along: f64,
    /// Derivatives by the unknowns: moment, place, direction.
    moment_by: [f64; UNKNOWNS],
    position_by: [Vec2; UNKNOWNS],
    along_by: [f64; UNKNOWNS],
}

/// A trace to be solved.
struct Problem<'a> {
    whisker: &'a Whisker,
    nodes: &'a [TraceNode],
    options: TraceOptions,
    /// The unit of the force: EI / L² (N).
    unit: f64,
    /// Largest slope of the tip (rad).
    largest_slope: f64,
}

/// The unknowns of all nodes: force over its unit, tilt (rad).
type Unknowns = Vec<f64>;

/// The tip's ways through `nodes`: one trace, or several where the contact jumps in between.
///
/// No step of a trace misses the direction of the wall: where one would, the trace ends. Nodes that fit no trace are left out; empty when there is none at all.
#[must_use]
pub fn tip_traces(whisker: &Whisker, nodes: &[TraceNode], options: TraceOptions) -> Vec<Vec<TracePoint>> {
    let mut traces = Vec::new();
    let mut from = 0;
    while from < nodes.len() {
        let snap = (from + 1..nodes.len()).find(|&i| snaps(whisker, &nodes[i - 1], &nodes[i]));
        let to = snap.unwrap_or(nodes.len());
        without_snap(whisker, &nodes[from..to], options, &mut traces);
        from = to;
    }
    traces
}

/// Whether the moment falls by more than errors and the motion of the base explain.
fn snaps(whisker: &Whisker, a: &TraceNode, b: &TraceNode) -> bool {
    let step = a.odom_from_whisker.between(b.odom_from_whisker);
    let travel = step.position().norm() + whisker.length * step.theta.abs();
    let stiffness = 3.0 * whisker.flexural_rigidity / (whisker.length * whisker.length);
    a.moment.abs() - b.moment.abs() > 2.0 * (a.std + b.std) + SNAP * stiffness * travel
}

/// The traces through nodes of one sign, added to those before.
fn without_snap(whisker: &Whisker, nodes: &[TraceNode], options: TraceOptions, traces: &mut Vec<Vec<TracePoint>>) {
    let unit = whisker.flexural_rigidity / (whisker.length * whisker.length);
    let mut rest = nodes;
    while rest.len() >= FEWEST {
        let problem = Problem { whisker, nodes: rest, options, unit, largest_slope: LARGEST_SLOPE };
        let least = problem.best(0);
        // The less bent branch, unless it ends much earlier: that the whisker is curled has to be shown.
        let curled = if traces.is_empty() { None } else { Problem { largest_slope: f64::INFINITY, ..problem }.best(1) };
        let nodes_of = |best: &Option<Descent<Vec<Tip>>>| best.as_ref().map_or(0, |descent| descent.state.len());
        let short = CURLED * (nodes_of(&curled) as f64) > nodes_of(&least) as f64;
        let (best, largest_slope) = if short { (curled, f64::INFINITY) } else { (least, LARGEST_SLOPE) };
        let best = best.map(|descent| Problem { largest_slope, ..problem.part(0, rest.len()) }.until_torn(descent));
        let used = best.as_ref().map_or(0, |descent| descent.state.len());
        let part = Problem { largest_slope: f64::INFINITY, ..problem.part(0, used) };
        let whole = best.filter(|descent| used >= FEWEST && part.torn(&descent.state).is_none());
        traces.extend(whole.and_then(|descent| part.points(&descent)));
        rest = &rest[used.max(1)..];
    }
}

impl Problem<'_> {
    /// A part of the trace.
    fn part(&self, from: usize, to: usize) -> Problem<'_> {
        Problem { nodes: &self.nodes[from..to], ..*self }
    }

    /// The longest trace, and of those the cheapest, from every tilt on one branch of the first reading.
    fn best(&self, branch: usize) -> Option<Descent<Vec<Tip>>> {
        let mut best = None;
        for window in WINDOWS {
            best = self.best_by(branch, window);
            if best.as_ref().is_none_or(|best| self.torn(&best.state).is_none()) {
                break;
            }
        }
        best
    }

    fn best_by(&self, branch: usize, window: usize) -> Option<Descent<Vec<Tip>>> {
        let starts = STARTS.map(|tilt| self.grown(branch, tilt, window));
        let longest = starts.iter().map(Vec::len).max().unwrap_or(0);
        let long = |start: &Unknowns| start.len() == longest && longest >= FEWEST * UNKNOWNS;
        let settled = starts.into_iter().filter(long).flat_map(|start| self.part(0, longest / UNKNOWNS).settled(start));
        settled.min_by(|a, b| a.cost.total_cmp(&b.cost))
    }

    /// The first node after which the tip takes a step that no wall explains.
    fn torn(&self, tips: &[Tip]) -> Option<usize> {
        let misses = |i: &usize| {
            let (step, _, normal) = Self::step(tips, *i);
            step.dot(normal).abs() > TORN * self.options.step_std
        };
        (0..tips.len().saturating_sub(1)).find(misses)
    }

    /// A way up to where it is torn, settled anew; as it is where it is whole.
    fn until_torn(&self, way: Descent<Vec<Tip>>) -> Descent<Vec<Tip>> {
        let Some(torn) = self.torn(&way.state) else { return way };
        let first = way.unknowns[..UNKNOWNS * (torn + 1)].to_vec();
        self.part(0, torn + 1).descend(first).unwrap_or(way)
    }

    /// Where a start settles: directly, and by way of a wall that is all but straight.
    fn settled(&self, start: Unknowns) -> Vec<Descent<Vec<Tip>>> {
        let straight = TraceOptions { turn: STRAIGHT * self.options.turn, ..self.options };
        let around = Problem { options: straight, ..*self }.descend(start.clone());
        let around = around.and_then(|descent| self.descend(descent.unknowns));
        self.descend(start).into_iter().chain(around).collect()
    }

    /// A start, grown node by node from the first on until the readings jump.
    fn grown(&self, branch: usize, tilt: f64, window: usize) -> Unknowns {
        let mut unknowns: Unknowns = Vec::with_capacity(UNKNOWNS * self.nodes.len());
        for i in 0..self.nodes.len() {
            let Some(next) = self.guess(i, &unknowns, branch, tilt) else { break };
            unknowns.extend(next);
            let last = i + 1 == self.nodes.len();
            if i % GROWTH == GROWTH - 1 || last {
                let from = (i + 1).saturating_sub(window);
                let newest = GROWTH.min(i + 1);
                let part = self.part(from, i + 1);
                let solved = part.descend(unknowns[UNKNOWNS * from..].to_vec());
                let Some(solved) = solved.filter(|s| part.newest_fault(s, newest) < JUMP) else {
                    unknowns.truncate(UNKNOWNS * (i + 1 - newest));
                    break;
                };
                unknowns.truncate(UNKNOWNS * from);
                unknowns.extend(solved.unknowns);
            }
        }
        unknowns
    }

    /// Mean square of the last residuals of the moment; infinite when one alone is beyond chance.
    fn newest_fault(&self, descent: &Descent<Vec<Tip>>, count: usize) -> f64 {
        let square = |(node, tip): (&TraceNode, &Tip)| ((tip.bend.moment - node.moment) / node.std).powi(2);
        let squares = self.nodes.iter().zip(&descent.state).rev().take(count).map(square);
        let (sum, largest) = squares.fold((0.0, 0.0_f64), |(sum, largest), s| (sum + s, largest.max(s)));
        if largest > LARGEST_FAULT * LARGEST_FAULT { f64::INFINITY } else { sum / count as f64 }
    }

    /// Where a node begins: the wall goes on as it was at the node before.
    fn guess(&self, i: usize, unknowns: &[f64], branch: usize, tilt: f64) -> Option<[f64; UNKNOWNS]> {
        let node = &self.nodes[i];
        let solve = |load| moment_mode(self.whisker, node.moment, self.whisker.length, load).unwrap_or_default();
        let Some(last) = i.checked_sub(1) else {
            return solve(Load::Tilted(tilt)).get(branch).map(|b| [b.force / self.unit, b.beta]);
        };
        let (force, tilt) = (unknowns[UNKNOWNS * last], unknowns[UNKNOWNS * last + 1]);
        let tip = self.tip(&self.nodes[last], force, tilt)?;
        let along = tip.along - node.odom_from_whisker.theta;
        let bends = [Load::Directed(along + core::f64::consts::FRAC_PI_2), Load::Tilted(tilt), Load::Normal].map(solve);
        let moderate = |b: &&Bend| b.beta.abs() <= STEEPEST_TILT;
        let near = |b: &&Bend| (node.odom_from_whisker.transform_point(b.contact) - tip.position).norm();
        let found = bends.iter().find_map(|b| b.iter().filter(moderate).min_by(|a, b| near(a).total_cmp(&near(b))));
        found.map(|b| [b.force / self.unit, b.beta])
    }

    fn bend(&self, force: f64, tilt: f64) -> Option<Bend> {
        if tilt.abs() > STEEPEST_TILT {
            return None;
        }
        let bends = force_mode(self.whisker, force * self.unit, self.whisker.length, Load::Tilted(tilt)).ok()?;
        bends.into_iter().next().filter(|bend| bend.phi_a.abs() <= self.largest_slope)
    }

    fn tip(&self, node: &TraceNode, force: f64, tilt: f64) -> Option<Tip> {
        let bend = self.bend(force, tilt)?;
        let steps = [1e-6 * (force.abs() + 1e-3), 1e-6];
        let mut tip = Tip {
            position: node.odom_from_whisker.transform_point(bend.contact),
            along: node.odom_from_whisker.theta + bend.phi_a + tilt,
            bend,
            moment_by: [0.0; UNKNOWNS],
            position_by: [Vec2::ZERO; UNKNOWNS],
            along_by: [0.0; UNKNOWNS],
        };
        for (k, step) in steps.into_iter().enumerate() {
            let [plus, minus] =
                [step, -step].map(|h| if k == 0 { self.bend(force + h, tilt) } else { self.bend(force, tilt + h) });
            let (plus, minus) = (plus?, minus?);
            let rate = 0.5 / step;
            tip.moment_by[k] = (plus.moment - minus.moment) * rate;
            tip.position_by[k] = ((plus.contact - minus.contact) * rate).rotated(node.odom_from_whisker.theta);
            tip.along_by[k] = (plus.phi_a - minus.phi_a) * rate + if k == 1 { 1.0 } else { 0.0 };
        }
        Some(tip)
    }

    fn tips(&self, unknowns: &[f64]) -> Option<Vec<Tip>> {
        self.nodes.iter().zip(unknowns.chunks(UNKNOWNS)).map(|(node, u)| self.tip(node, u[0], u[1])).collect()
    }

    /// How far the wall may turn between two nodes (rad).
    fn turn_std(&self, i: usize) -> f64 {
        let (a, b) = (&self.nodes[i].odom_from_whisker, &self.nodes[i + 1].odom_from_whisker);
        let travel = a.position().distance(b.position());
        self.options.turn * travel.max(1e-5).sqrt()
    }

    fn step(tips: &[Tip], i: usize) -> (Vec2, Vec2, Vec2) {
        let (a, b) = (&tips[i], &tips[i + 1]);
        let tangent = Vec2::from_angle(0.5 * (a.along + b.along));
        (b.position - a.position, tangent, tangent.perp())
    }

    /// Half the sum of the squares, robust where the wall turns.
    fn cost(&self, tips: &[Tip], unknowns: &[f64]) -> f64 {
        let mut cost = 0.0;
        for (i, (node, tip)) in self.nodes.iter().zip(tips).enumerate() {
            cost += 0.5 * ((tip.bend.moment - node.moment) / node.std).powi(2);
            cost += 0.5 * (unknowns[UNKNOWNS * i + 1] / TILT_STD).powi(2);
            if i + 1 < tips.len() {
                let (step, _, normal) = Self::step(tips, i);
                cost += 0.5 * (step.dot(normal) / self.options.step_std).powi(2);
                let turn = (tips[i + 1].along - tip.along) / self.turn_std(i);
                cost += 0.5 * (turn * turn).ln_1p();
            }
        }
        cost
    }

    /// Normal matrix and gradient.
    fn normal_equations(&self, tips: &[Tip], unknowns: &[f64]) -> Normal {
        let mut band = Band::zeros(unknowns.len(), 2 * UNKNOWNS - 1);
        let mut gradient = vec![0.0; unknowns.len()];
        let mut add = |first: usize, row: &[f64], residual: f64| {
            band.add_square(first, row);
            row.iter().enumerate().for_each(|(k, d)| gradient[first + k] += d * residual);
        };
        for (i, (node, tip)) in self.nodes.iter().zip(tips).enumerate() {
            let first = UNKNOWNS * i;
            let weight = 1.0 / node.std;
            add(first, &tip.moment_by.map(|d| d * weight), (tip.bend.moment - node.moment) * weight);
            add(first + 1, &[1.0 / TILT_STD], unknowns[first + 1] / TILT_STD);
            if i + 1 == tips.len() {
                continue;
            }
            let next = &tips[i + 1];
            let (step, tangent, normal) = Self::step(tips, i);
            let (mut across, mut turning) = ([0.0; 2 * UNKNOWNS], [0.0; 2 * UNKNOWNS]);
            for k in 0..UNKNOWNS {
                let turned = |along_by: f64| -0.5 * along_by * step.dot(tangent);
                across[k] = -tip.position_by[k].dot(normal) + turned(tip.along_by[k]);
                across[UNKNOWNS + k] = next.position_by[k].dot(normal) + turned(next.along_by[k]);
                turning[k] = -tip.along_by[k];
                turning[UNKNOWNS + k] = next.along_by[k];
            }
            let weight = 1.0 / self.options.step_std;
            add(first, &across.map(|d| d * weight), step.dot(normal) * weight);
            let std = self.turn_std(i);
            let turn = (next.along - tip.along) / std;
            let robust = 1.0 / (1.0 + turn * turn).sqrt();
            add(first, &turning.map(|d| d * robust / std), turn * robust);
        }
        Normal { matrix: band, gradient }
    }

    fn descend(&self, unknowns: Unknowns) -> Option<Descent<Vec<Tip>>> {
        let evaluate = |unknowns: &[f64]| {
            let tips = self.tips(unknowns)?;
            let cost = self.cost(&tips, unknowns);
            Some((tips, cost))
        };
        let normal = |unknowns: &[f64], tips: &Vec<Tip>| Some(self.normal_equations(tips, unknowns));
        descend(unknowns, RULES, evaluate, normal, unbounded)
    }

    fn points(&self, descent: &Descent<Vec<Tip>>) -> Option<Vec<TracePoint>> {
        let factor = self.normal_equations(&descent.state, &descent.unknowns).matrix.factor()?;
        Some(self.points_of(&descent.state, &factor))
    }

    fn points_of(&self, tips: &[Tip], factor: &Factor) -> Vec<TracePoint> {
        let one = |(i, (node, tip)): (usize, (&TraceNode, &Tip))| {
            let normal = Vec2::from_angle(tip.along).perp();
            let mut unit = vec![0.0; UNKNOWNS * tips.len()];
            for k in 0..UNKNOWNS {
                unit[UNKNOWNS * i + k] = tip.position_by[k].dot(normal);
            }
            let spread = factor.solve(unit);
            let variance: f64 = (0..UNKNOWNS).map(|k| spread[UNKNOWNS * i + k] * tip.position_by[k].dot(normal)).sum();
            TracePoint {
                t: node.t,
                position: tip.position,
                normal: tip.bend.force_vector().rotated(node.odom_from_whisker.theta).angle(),
                std: variance.max(0.0).sqrt(),
                residual: (tip.bend.moment - node.moment) / node.std,
                bend: tip.bend.clone(),
            }
        };
        self.nodes.iter().zip(tips).enumerate().map(one).collect()
    }
}
