//! Starts of a trace, and how they grow.

use super::node::{NodePrediction, UNKNOWNS};
use super::problem::{TraceProblem, Unknowns, Way};
use super::{FEWEST, TIP_ALONE, TraceNode, TraceOptions};
use crate::beam::{Bend, Load, moment_mode};
use core::f64::consts::FRAC_PI_2;

/// Leans of the first node to start from: tilts of the force at the tip (rad), and shares of the whisker beyond a side.
const STARTS: [f64; 6] = [0.0, 0.3, 0.7, 1.1, -0.05, -0.15];
/// A start is solved each time it has grown by this many nodes,
const GROWTH: usize = 5;
/// over this many of its last ones, and over more where that tears the way. A short window is quick; but where the whisker is
/// strongly bent, windows that are free at their beginning slide off, each a little, to another shape.
const WINDOWS: [usize; 3] = [30, 90, 270];
/// A step of the contact that misses the wall's direction by more standard deviations tears the way: where all is well none misses
/// by one, and where the way changes from one shape to another, hundreds do.
const TORN: f64 = 5.0;
/// Mean square of the newest residuals from which on the contact is taken to have jumped.
const JUMP: f64 = 6.0;
/// Largest residual of a new node, in standard deviations, before the contact is taken to have jumped.
const LARGEST_FAULT: f64 = 4.0;
/// How straight, in units of [`TraceOptions::turn`], the wall is first taken to be on the way around local minima.
const STRAIGHT: f64 = 0.3;

/// Starts whose windows differ by less in every unknown grow on together.
const TOGETHER: f64 = 1e-5;
/// Ways that are nowhere farther apart are one (m).
pub(super) const SAME: f64 = 1e-4;

/// How far two ways through the same nodes are apart (m).
pub(super) fn apart(a: &Way, b: &Way) -> f64 {
    a.state.iter().zip(&b.state).map(|(a, b)| a.position.distance(b.position)).fold(0.0, f64::max)
}

/// A start as it grew: its unknowns, and each of the windows that were solved, by its first node.
struct Grown {
    side: bool,
    unknowns: Unknowns,
    windows: Vec<(usize, Unknowns)>,
}

impl Grown {
    /// Whether another start's newest window is the one that this had at the same time: they grow on together.
    fn became(&self, other: &Self, (from, newest): &(usize, Unknowns)) -> bool {
        let near = |(a, b): (&f64, &f64)| (a - b).abs() < TOGETHER;
        let same = |(first, window): &(usize, Unknowns)| {
            first == from && window.len() == newest.len() && window.iter().zip(newest).all(near)
        };
        self.side == other.side && self.windows.get(other.windows.len()).is_some_and(same)
    }
}

impl TraceProblem<'_> {
    /// The longest ways, the cheapest first, from every start on one branch of the first reading.
    pub(super) fn best(&self, branch: usize) -> Vec<Way> {
        self.best_beside(branch, &[])
    }

    /// The same, where ways with the tip alone are known that explain all readings.
    pub(super) fn best_beside(&self, branch: usize, tips: &[Way]) -> Vec<Way> {
        let mut best = Vec::new();
        for window in WINDOWS {
            best = self.best_by(branch, window, tips);
            if best.first().is_none_or(|best| self.torn(&best.state).is_none()) {
                break;
            }
        }
        best
    }

    fn best_by(&self, branch: usize, window: usize, tips: &[Way]) -> Vec<Way> {
        let open = |lean: &f64| if *lean >= 0.0 { tips.is_empty() } else { self.side_std > TIP_ALONE };
        let mut grown: Vec<Grown> = Vec::new();
        for lean in STARTS.into_iter().filter(open) {
            let next = self.grown(branch, lean, window, &grown);
            grown.push(next);
        }
        let starts = tips.iter().map(|way| way.unknowns.clone()).chain(grown.into_iter().map(|g| g.unknowns));
        let mut starts: Vec<Unknowns> = starts.collect();
        // What grew together settles together.
        starts.dedup();
        let longest = starts.iter().map(Vec::len).max().unwrap_or(0);
        let long = |start: &Unknowns| start.len() == longest && longest >= FEWEST * UNKNOWNS;
        let settled = starts.into_iter().filter(long).flat_map(|start| self.part(0, longest / UNKNOWNS).settled(start));
        let mut all: Vec<Way> = settled.collect();
        all.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let mut ways: Vec<Way> = Vec::new();
        for way in all {
            if ways.iter().all(|other| apart(other, &way) > SAME) {
                ways.push(way);
            }
        }
        ways
    }

    /// The first node after which the contact takes a step that no wall explains.
    pub(super) fn torn(&self, felt: &[NodePrediction]) -> Option<usize> {
        let misses = |i: &usize| self.miss(felt, *i).abs() > TORN;
        (0..felt.len().saturating_sub(1)).find(misses)
    }

    /// A way up to where it is torn, settled anew; as it is where it is whole.
    pub(super) fn until_torn(&self, way: Way) -> Way {
        let Some(torn) = self.torn(&way.state) else { return way };
        let first = way.unknowns[..UNKNOWNS * (torn + 1)].to_vec();
        self.part(0, torn + 1).settle(first).unwrap_or(way)
    }

    /// Where a start settles: directly, and by way of a wall that is all but straight.
    fn settled(&self, start: Unknowns) -> Vec<Way> {
        let straight = TraceOptions { turn: STRAIGHT * self.options.turn, ..self.options };
        let around = TraceProblem { options: straight, ..*self }.descend(start.clone());
        let around = around.and_then(|way| self.settle(way.unknowns));
        self.settle(start).into_iter().chain(around).collect()
    }

    /// A start, grown node by node from the first on until the readings jump, or until it has become one of those before.
    fn grown(&self, branch: usize, lean: f64, window: usize, before: &[Grown]) -> Grown {
        let mut grown =
            Grown { side: lean < 0.0, unknowns: Vec::with_capacity(UNKNOWNS * self.nodes.len()), windows: Vec::new() };
        for i in 0..self.nodes.len() {
            if self.stop.is_asked() {
                break;
            }
            let Some(next) = self.guess(i, &grown.unknowns, branch, lean) else { break };
            grown.unknowns.extend(next);
            let last = i + 1 == self.nodes.len();
            if i % GROWTH == GROWTH - 1 || last {
                let from = (i + 1).saturating_sub(window);
                let newest = GROWTH.min(i + 1);
                let part = self.part(from, i + 1);
                let solved = part.descend(grown.unknowns[UNKNOWNS * from..].to_vec());
                // A tip may find its way back in a wider window; a side that tears is none.
                let holds = |way: &Way| lean >= 0.0 || part.torn(&way.state).is_none();
                let Some(solved) = solved.filter(|s| part.newest_fault(s, newest) < JUMP && holds(s)) else {
                    grown.unknowns.truncate(UNKNOWNS * (i + 1 - newest));
                    break;
                };
                grown.unknowns.truncate(UNKNOWNS * from);
                let here = (from, solved.unknowns);
                if let Some(same) = before.iter().find(|other| other.became(&grown, &here)) {
                    grown.unknowns.extend(same.unknowns.iter().skip(UNKNOWNS * from));
                    return grown;
                }
                grown.unknowns.extend(&here.1);
                grown.windows.push(here);
            }
        }
        grown
    }

    /// Mean square of the last residuals of the moment; infinite when one alone is beyond chance.
    fn newest_fault(&self, way: &Way, count: usize) -> f64 {
        let square =
            |(node, here): (&TraceNode, &NodePrediction)| ((here.bend.moment - node.moment) / node.std).powi(2);
        let squares = self.nodes.iter().zip(&way.state).rev().take(count).map(square);
        let (sum, largest) = squares.fold((0.0, 0.0_f64), |(sum, largest), s| (sum + s, largest.max(s)));
        if largest > LARGEST_FAULT * LARGEST_FAULT { f64::INFINITY } else { sum / count as f64 }
    }

    /// Where a node begins: the wall goes on as it was at the node before.
    fn guess(&self, i: usize, unknowns: &[f64], branch: usize, lean: f64) -> Option<[f64; UNKNOWNS]> {
        let (node, bender) = (&self.nodes[i], &self.bender);
        let solve = |(s_a, load)| moment_mode(bender.whisker, node.moment, s_a, load).unwrap_or_default();
        let Some(last) = i.checked_sub(1) else {
            let bends = solve(bender.contact(lean)?);
            return bends.get(branch).and_then(|bend| bender.unknowns(bend));
        };
        let last = self.bender.felt(&self.nodes[last], &unknowns[UNKNOWNS * last..], f64::INFINITY)?;
        let whole = bender.whisker.length;
        let ahead = (whole, Load::Directed(last.along - node.odom_from_whisker.theta + FRAC_PI_2));
        let as_before = bender.contact(bender.unknowns(&last.bend)?[1])?;
        let tries = if last.bend.s_a < whole { [as_before; 3] } else { [ahead, as_before, (whole, Load::Normal)] };
        let near = |b: &Bend| (node.odom_from_whisker.transform_point(b.contact) - last.position).norm();
        tries.into_iter().find_map(|contact| {
            let bends = solve(contact);
            let known = bends.iter().filter_map(|bend| Some((near(bend), bender.unknowns(bend)?)));
            known.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, unknowns)| unknowns)
        })
    }
}
