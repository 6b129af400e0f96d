//! The back end: key poses and what the odometry shares, by least squares \[grisetti2010tutorial; dellaert2017factor\].
//!
//! Unknowns are the key poses, the first of them fixed, and the odometry's shares. A leg ties two neighbours; an overlap ties a felt
//! point to the line through an earlier one. In an order that keeps ties near \[cuthill1969reducing\] the normal matrix is a band with a
//! border, of the shares.

use super::odometry::{Leg, SHARES};
use super::told::{ContactFactor, FactorGraph, LegFactor, Share};
use crate::least_squares::{Bordered, BorderedFactor, reverse_cuthill_mckee};
use crate::plane::{Pose2, Vec2, wrap_angle};

/// Numbers of a pose.
const POSE: usize = 3;
/// Rounds of Levenberg and Marquardt's method, and the damping of the first.
const ROUNDS: usize = 30;
const DAMPING: f64 = 1e-6;
const MOST_DAMPING: f64 = 1e6;
/// A round that lowers the cost by less than this share ends.
const GAIN: f64 = 1e-9;

/// A felt point on the line through an earlier one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Overlap {
    /// Key poses, the later first, each with a point in its frame (m).
    pub(super) later: (usize, Vec2),
    pub(super) earlier: (usize, Vec2),
    /// The earlier one's normal, in its frame.
    pub(super) normal: Vec2,
    /// Standard deviation of their distance (m).
    pub(super) std: f64,
}

/// Standard deviations of a leg: place (m) and turn (rad), beside the shares.
#[derive(Clone, Copy, Debug)]
pub(super) struct LegNoise {
    pub(super) place: f64,
    pub(super) turn: f64,
}

/// The problem.
pub(super) struct Graph<'a> {
    pub(super) legs: &'a [(Leg, LegNoise)],
    pub(super) overlaps: &'a [Overlap],
    /// Standard deviations of the shares before any overlap.
    pub(super) shares: [f64; SHARES],
}

/// Where everything is.
#[derive(Clone, Debug)]
pub(super) struct Solution {
    pub(super) poses: Vec<Pose2>,
    pub(super) shares: [f64; SHARES],
    pub(super) cost: f64,
}

/// How each unknown is known.
pub(super) struct Marginals {
    pub(super) poses: Vec<[[f64; 3]; 3]>,
    pub(super) shares: [f64; SHARES],
    factor: BorderedFactor,
    order: Order,
}

impl Marginals {
    /// Standard deviation of the distance across a wall between places that are rigid on two key poses (m): a place and the wall's normal,
    /// in the map.
    pub(super) fn between(&self, at: &Solution, (a, b): (usize, usize), place: Vec2, normal: Vec2) -> f64 {
        let mut row = vec![0.0; self.order.size()];
        for (key, sign) in [(a, 1.0), (b, -1.0)] {
            let lever = normal.dot((place - at.poses[key].position()).perp());
            for (axis, value) in [normal.x, normal.y, lever].into_iter().enumerate() {
                if let Some(at) = self.order.place(Unknown::Pose(key, axis)) {
                    row[at] += sign * value;
                }
            }
        }
        let solved = self.factor.solve(&row);
        row.iter().zip(&solved).map(|(a, b)| a * b).sum::<f64>().max(0.0).sqrt()
    }
}

/// A row of the Jacobian: key pose and coordinate, or a share.
type Derivatives = Vec<(Unknown, f64)>;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unknown {
    Pose(usize, usize),
    Share(usize),
}

/// Where each unknown stands in the system: key poses but for the first, then the shares.
struct Order {
    places: Vec<usize>,
    /// Unknowns of the band, and how far apart those of one residual are at most.
    chain: usize,
    width: usize,
}

impl Order {
    fn new(graph: &Graph<'_>, count: usize) -> Self {
        let mut neighbours = vec![Vec::new(); count.saturating_sub(1)];
        let along = (2..count).map(|k| (k - 1, k));
        let ties = graph.overlaps.iter().map(|overlap| (overlap.earlier.0, overlap.later.0));
        for (a, b) in along.chain(ties).filter(|(a, b)| a != b && *a > 0 && *b > 0) {
            neighbours[a - 1].push(b - 1);
            neighbours[b - 1].push(a - 1);
        }
        for all in &mut neighbours {
            all.sort_unstable();
            all.dedup();
        }
        let mut places = vec![0; count];
        for (at, key) in reverse_cuthill_mckee(&neighbours).into_iter().enumerate() {
            places[key + 1] = POSE * at;
        }
        let own = |(k, all): (usize, &Vec<usize>)| all.iter().map(|n| places[k + 1].abs_diff(places[n + 1])).max();
        let width = neighbours.iter().enumerate().filter_map(own).max().unwrap_or(0) + POSE - 1;
        Self { places, chain: POSE * neighbours.len(), width }
    }

    /// None for the first pose, which is fixed.
    fn place(&self, unknown: Unknown) -> Option<usize> {
        match unknown {
            Unknown::Pose(0, _) => None,
            Unknown::Pose(key, axis) => Some(self.places[key] + axis),
            Unknown::Share(share) => Some(self.chain + share),
        }
    }

    fn size(&self) -> usize {
        self.chain + SHARES
    }
}

impl Graph<'_> {
    /// The key poses where the odometry puts them.
    pub(super) fn dead_reckoned(&self, first: Pose2) -> Solution {
        let mut poses = vec![first];
        for (leg, _) in self.legs {
            let last = poses[poses.len() - 1];
            poses.push(last.compose(leg.step));
        }
        let mut start = Solution { poses, shares: [0.0; SHARES], cost: 0.0 };
        start.cost = self.cost(&start);
        start
    }

    /// The least cost from a start on.
    pub(super) fn solve(&self, start: Solution) -> Solution {
        let order = Order::new(self, start.poses.len());
        let mut best = Solution { cost: self.cost(&start), ..start };
        let mut damping = DAMPING;
        for _ in 0..ROUNDS {
            let (matrix, gradient) = self.normal(&best, &order);
            let mut next = None;
            while damping < MOST_DAMPING {
                let factor = matrix.clone().damped(damping).factor();
                let tried = factor.map(|factor| self.moved(&best, &order, &factor.solve(&gradient)));
                next = tried.filter(|tried| tried.cost <= best.cost);
                if next.is_some() {
                    break;
                }
                damping *= 10.0;
            }
            let Some(next) = next else { break };
            let gain = best.cost - next.cost;
            best = next;
            damping = (0.1 * damping).max(1e-12);
            if gain <= GAIN * best.cost {
                break;
            }
        }
        best
    }

    /// Covariances of the key poses, relative to the first, and standard deviations of the shares.
    pub(super) fn marginals(&self, at: &Solution) -> Option<Marginals> {
        let order = Order::new(self, at.poses.len());
        // Shares that are known exactly have no entry.
        let factor = self.normal(at, &order).0.damped(0.0).factor()?;
        // Of the first pose nothing is open.
        let mut poses = vec![[[0.0; POSE]; POSE]];
        poses.extend(factor.inverse_blocks(&order.places[1..]));
        let column = |place: usize| {
            let mut unit = vec![0.0; order.size()];
            unit[place] = 1.0;
            factor.solve(&unit)
        };
        let free = |k: usize| self.shares[k] > 0.0;
        let shares = [0, 1, 2].map(|k| {
            if !free(k) { 0.0 } else { order.place(Unknown::Share(k)).map_or(0.0, |p| column(p)[p].max(0.0).sqrt()) }
        });
        Some(Marginals { poses, shares, factor, order })
    }

    /// The problem and its solution, for others.
    pub(super) fn told(&self, at: &Solution, marginals: &Marginals) -> FactorGraph {
        let leg = |(leg, noise): &(Leg, LegNoise)| LegFactor {
            step: leg.step,
            by_share: leg.by_share,
            place_std: noise.place,
            turn_std: noise.turn,
        };
        let contact =
            |&Overlap { later, earlier, normal, std }: &Overlap| ContactFactor { later, earlier, normal, std };
        FactorGraph {
            poses: at.poses.clone(),
            covariances: marginals.poses.clone(),
            shares: [0, 1, 2].map(|k| Share { value: at.shares[k], std: marginals.shares[k] }),
            share_stds: self.shares,
            legs: self.legs.iter().map(leg).collect(),
            contacts: self.overlaps.iter().map(contact).collect(),
            cost: self.cost(at),
        }
    }

    fn moved(&self, from: &Solution, order: &Order, step: &[f64]) -> Solution {
        let mut next = from.clone();
        for (key, pose) in next.poses.iter_mut().enumerate().skip(1) {
            let at = order.places[key];
            let theta = pose.theta - step[at + 2];
            *pose = Pose2 { x: pose.x - step[at], y: pose.y - step[at + 1], theta };
        }
        let shares = order.size() - SHARES;
        next.shares.iter_mut().zip(&step[shares..]).for_each(|(share, step)| *share -= step);
        next.cost = self.cost(&next);
        next
    }

    fn cost(&self, at: &Solution) -> f64 {
        let mut sum = 0.0;
        self.each_residual(at, |residual, _| sum += residual * residual);
        0.5 * sum
    }

    fn normal(&self, at: &Solution, order: &Order) -> (Bordered, Vec<f64>) {
        let mut matrix = Bordered::zeros(order.chain, order.width.min(order.chain.saturating_sub(1)), SHARES);
        let mut gradient = vec![0.0; order.size()];
        self.each_residual(at, |residual, derivatives| {
            let row: Vec<(usize, f64)> = derivatives.iter().filter_map(|(u, d)| Some((order.place(*u)?, *d))).collect();
            row.iter().for_each(|(place, d)| gradient[*place] += d * residual);
            matrix.add_square(&row);
        });
        (matrix, gradient)
    }

    /// Calls `visit` with each residual, in standard deviations, and its derivatives.
    fn each_residual(&self, at: &Solution, mut visit: impl FnMut(f64, &Derivatives)) {
        for (k, std) in self.shares.iter().enumerate().filter(|(_, std)| **std > 0.0) {
            visit(at.shares[k] / std, &vec![(Unknown::Share(k), 1.0 / std)]);
        }
        for (key, (leg, noise)) in self.legs.iter().enumerate() {
            self.leg_residuals(at, (key, leg, *noise), &mut visit);
        }
        for overlap in self.overlaps {
            overlap_residual(at, overlap, &mut visit);
        }
    }

    fn leg_residuals(
        &self,
        at: &Solution,
        (key, leg, noise): (usize, &Leg, LegNoise),
        visit: &mut impl FnMut(f64, &Derivatives),
    ) {
        let (from, to) = (at.poses[key], at.poses[key + 1]);
        let told = leg.corrected(&at.shares);
        let between = to.position() - from.position();
        let off = between.rotated(-from.theta) - told.position();
        let turned = wrap_angle(to.theta - from.theta - told.theta);
        let free = |k: usize| self.shares[k] > 0.0;
        for (axis, unit) in [Vec2::new(1.0, 0.0), Vec2::new(0.0, 1.0)].into_iter().enumerate() {
            // A unit of the earlier frame, in the map.
            let across = unit.rotated(from.theta);
            let per = 1.0 / noise.place;
            let by_turn = -unit.dot(between.rotated(-from.theta).perp());
            let mut row = vec![
                (Unknown::Pose(key, 0), -across.x * per),
                (Unknown::Pose(key, 1), -across.y * per),
                (Unknown::Pose(key, 2), by_turn * per),
                (Unknown::Pose(key + 1, 0), across.x * per),
                (Unknown::Pose(key + 1, 1), across.y * per),
            ];
            let by = |k: usize| (Unknown::Share(k), -unit.dot(leg.by_share[k].0) * per);
            row.extend((0..SHARES).filter(|&k| free(k)).map(by));
            visit([off.x, off.y][axis] * per, &row);
        }
        let per = 1.0 / noise.turn;
        let mut row = vec![(Unknown::Pose(key, 2), -per), (Unknown::Pose(key + 1, 2), per)];
        row.extend((0..SHARES).filter(|&k| free(k)).map(|k| (Unknown::Share(k), -leg.by_share[k].1 * per)));
        visit(turned * per, &row);
    }
}

fn overlap_residual(at: &Solution, overlap: &Overlap, visit: &mut impl FnMut(f64, &Derivatives)) {
    let ((later, p), (earlier, q)) = (overlap.later, overlap.earlier);
    let (from, to) = (at.poses[later], at.poses[earlier]);
    let normal = overlap.normal.rotated(to.theta);
    let (p, q) = (p.rotated(from.theta), q.rotated(to.theta));
    let gap = from.position() + p - to.position() - q;
    let per = 1.0 / overlap.std;
    let row = vec![
        (Unknown::Pose(later, 0), normal.x * per),
        (Unknown::Pose(later, 1), normal.y * per),
        (Unknown::Pose(later, 2), normal.dot(p.perp()) * per),
        (Unknown::Pose(earlier, 0), -normal.x * per),
        (Unknown::Pose(earlier, 1), -normal.y * per),
        (Unknown::Pose(earlier, 2), (normal.perp().dot(gap) - normal.dot(q.perp())) * per),
    ];
    visit(normal.dot(gap) * per, &row);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> (Vec<(Leg, LegNoise)>, Vec<Overlap>) {
        let noise = LegNoise { place: 1e-3, turn: 2e-3 };
        let legs: Vec<(Leg, LegNoise)> = (0..9)
            .map(|k| {
                let mut leg = Leg::default();
                let turn = if k % 2 == 1 { 1.6 } else { 0.02 };
                (0..20).for_each(|_| leg.add(Pose2::new(0.01, 1e-4, turn / 20.0)));
                (leg, noise)
            })
            .collect();
        let overlap = |k: usize, p: Vec2, q: Vec2, turn: f64| Overlap {
            later: (7 + k % 3, p),
            earlier: (k % 3, q),
            normal: Vec2::from_angle(turn),
            std: 2e-4,
        };
        let overlaps = (0..9)
            .map(|k| {
                let f = k as f64;
                overlap(k, Vec2::new(0.02 * f, 0.05), Vec2::new(0.02 * f - 0.03, 0.052), 1.4 + 0.2 * f)
            })
            .collect();
        (legs, overlaps)
    }

    #[test]
    fn derivatives_are_those_of_the_residuals() {
        let (legs, overlaps) = square();
        let graph = Graph { legs: &legs, overlaps: &overlaps, shares: [0.01, 0.01, 0.02] };
        let mut at = graph.dead_reckoned(Pose2::new(0.1, 0.2, 0.3));
        at.shares = [2e-3, -1e-3, 3e-3];
        at.poses.iter_mut().enumerate().for_each(|(k, pose)| pose.theta += 0.003 * k as f64);
        let residuals = |at: &Solution| {
            let mut all = Vec::new();
            graph.each_residual(at, |r, row| all.push((r, row.clone())));
            all
        };
        let here = residuals(&at);
        let step = 1e-7;
        for unknown in (0..10).flat_map(|k| (0..3).map(move |a| Unknown::Pose(k, a))).chain((0..3).map(Unknown::Share))
        {
            let mut there = at.clone();
            match unknown {
                Unknown::Pose(k, 0) => there.poses[k].x += step,
                Unknown::Pose(k, 1) => there.poses[k].y += step,
                Unknown::Pose(k, _) => there.poses[k].theta += step,
                Unknown::Share(k) => there.shares[k] += step,
            }
            for ((before, row), (after, _)) in here.iter().zip(residuals(&there)) {
                let told: f64 = row.iter().filter(|(u, _)| *u == unknown).map(|(_, d)| d).sum();
                let seen = (after - before) / step;
                assert!((told - seen).abs() < 1e-3 * told.abs().max(1.0), "{unknown:?}: {told} {seen}");
            }
        }
    }

    /// The cost by what is told to others, in their words.
    #[test]
    fn the_problem_that_is_told_has_the_cost_of_the_solution() {
        let (legs, overlaps) = square();
        let graph = Graph { legs: &legs, overlaps: &overlaps, shares: [0.01, 0.01, 0.02] };
        let found = graph.solve(graph.dead_reckoned(Pose2::new(0.1, -0.2, 0.5)));
        let told = graph.told(&found, &graph.marginals(&found).unwrap());
        let mut sum: f64 =
            told.shares.iter().zip(told.share_stds).map(|(share, std)| (share.value / std).powi(2)).sum();
        for (pair, leg) in told.poses.windows(2).zip(&told.legs) {
            let between = pair[0].between(pair[1]);
            let (mut place, mut turn) = (leg.step.position(), leg.step.theta);
            for (share, (by, turned)) in told.shares.iter().zip(leg.by_share) {
                (place, turn) = (place + by * share.value, turn + turned * share.value);
            }
            sum += ((between.position() - place) * (1.0 / leg.place_std)).norm_squared();
            sum += (wrap_angle(between.theta - turn) / leg.turn_std).powi(2);
        }
        for contact in &told.contacts {
            let at = |(key, point): (usize, Vec2)| told.poses[key].transform_point(point);
            let normal = contact.normal.rotated(told.poses[contact.earlier.0].theta);
            sum += (normal.dot(at(contact.later) - at(contact.earlier)) / contact.std).powi(2);
        }
        assert!((0.5 * sum - told.cost).abs() < 1e-9 * told.cost, "{} {}", 0.5 * sum, told.cost);
        assert_eq!((told.legs.len() + 1, told.covariances.len()), (told.poses.len(), told.poses.len()));
    }

    #[test]
    fn no_step_from_the_solution_leads_down() {
        let (legs, overlaps) = square();
        let graph = Graph { legs: &legs, overlaps: &overlaps, shares: [0.01, 0.01, 0.02] };
        let start = graph.dead_reckoned(Pose2::IDENTITY);
        let found = graph.solve(start.clone());
        assert!(found.cost < 0.5 * start.cost);
        for (key, axis) in (1..10).flat_map(|k| (0..3).map(move |a| (k, a))) {
            for by in [1e-5, -1e-5] {
                let mut there = found.clone();
                match axis {
                    0 => there.poses[key].x += by,
                    1 => there.poses[key].y += by,
                    _ => there.poses[key].theta += by,
                }
                assert!(graph.cost(&there) > found.cost - 1e-9);
            }
        }
    }
}
