//! Point mode of the rod.

use super::super::bend::Bend;
use super::super::load::{Line, Load};
use super::super::root::root;
use super::super::{check_contact, sorted};
use super::Rod;
use super::follow::Status;
use super::march::{RodState, march};
use super::newton::{Goal, ModeProblem, refine};
use super::scan::{dips, geometric, roots};
use super::shot::{Shot, Trial, gap_of};
use crate::error::Result;
use crate::plane::Vec2;
use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::PI;
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// Largest ratio of neighbouring arc lengths of the grid, and of the softnesses there.
const RATIOS: [f64; 2] = [1.12, 1.5];
/// Shares of a force from which the partner of a shape beyond a fold is looked for.
const FOLD_STEPS: [f64; 4] = [0.8, 0.95, 1.05, 1.2];
/// After so many equilibria, ours or not, no more are looked for beside them.
const MOST_MET: usize = 40;
/// As far out on the whisker's continuation, as a share of its length, equilibria lead to others.
const FARTHEST: f64 = 1.1;
/// Cells of the grid whose image is larger than this share of the contact's distance are quartered, at most so often.
const LARGEST_CELL: f64 = 0.4;
const MOST_QUARTERED: usize = 3;
/// How often a rod that is curved at rest may meet the line of the force, the contact included.
const MOST_CROSSINGS: usize = 4;
/// Turn of the base (rad) beyond which a trial of the grid leads nowhere: shapes whose base turns by more than half a turn are left out. Of 1112
/// equilibria of 800 whiskers drawn at random, curved ones and soft bases among them, 36 are missed with four turns, and 73 with one in 0.3 of
/// the time.
const FARTHEST_TURN: f64 = 8.0 * PI;
/// Slope (rad) beyond which a march from the base is given up.
pub(super) const MOST_TURNING: f64 = 9.0;
/// A contact this far beyond the tip, relative to the length, is the tip.
const TIP_ROUNDING: f64 = 1e-9;

impl Rod {
    /// Every first-mode equilibrium whose contact is at `contact` (m, whisker frame), least slope first; as
    /// [`point_mode`](super::super::point_mode).
    ///
    /// # Errors
    /// Usage: a contact that is not finite or at the base.
    pub fn point_mode(&self, contact: Vec2, load: Load) -> Result<Vec<Bend>> {
        check_contact(contact)?;
        let line = load.line()?;
        if contact.norm() > self.length * (1.0 + TIP_ROUNDING) {
            return Ok(Vec::new());
        }
        let starts = match line {
            Line::Following(beta) => self.starts_on_grid(contact, beta),
            Line::Fixed(psi) => self.starts_on_line(contact, psi),
        };
        let problem = ModeProblem { rod: self, line, goal: Goal::Point(contact) };
        let mut met: Vec<Shot> = Vec::new();
        let mut waiting = starts;
        while let Some(start) = waiting.pop() {
            let refined = refine(&problem, start);
            let Some(shot) = refined.shot.filter(|_| refined.status == Status::Converged) else { continue };
            if !met.iter().any(|s| same(s, &shot)) {
                met.push(shot);
                // Where equilibria that are none of ours lie densely, one would lead to the next without end.
                if met.len() < MOST_MET && shot.trial.s_a < FARTHEST * self.length {
                    waiting.extend(self.beside(&shot.trial));
                }
            }
        }
        met.retain(|shot| self.is_first_mode(shot));
        sorted(self.bends(met, line))
    }

    /// Whether the contact is beyond the tip, and not far.
    fn is_just_beyond(&self, trial: &Trial) -> bool {
        trial.s_a > self.length * (1.0 + TIP_ROUNDING) && trial.s_a < FARTHEST * self.length
    }

    /// Where to look from beside a shape: next to a fold lies a second one in the same cell of the grid, and one whose contact is
    /// beyond the tip may hide one on the whisker.
    fn beside(&self, trial: &Trial) -> impl Iterator<Item = Trial> + use<> {
        let (trial, beyond) = (*trial, self.is_just_beyond(trial));
        let arcs = if beyond { vec![trial.s_a, 2.0 * self.length - trial.s_a] } else { vec![trial.s_a] };
        arcs.into_iter().flat_map(move |s_a| FOLD_STEPS.map(|step| Trial { force: trial.force * step, s_a, ..trial }))
    }

    fn is_first_mode(&self, shot: &Shot) -> bool {
        let on_whisker = shot.trial.s_a > 0.0 && shot.trial.s_a <= self.length * (1.0 + TIP_ROUNDING);
        // A force that is rounding bends nothing.
        on_whisker
            && (shot.trial.force.abs() * self.softness(shot.trial.s_a) < 1e-14 || shot.trial.shoot(self).is_some())
    }

    /// Triangles of a grid over force and arc length whose image holds the contact.
    fn starts_on_grid(&self, contact: Vec2, beta: f64) -> Vec<Trial> {
        let mut forces = vec![0.0];
        forces.extend(geometric(0.35, 1.14, 14.0));
        let sides: Vec<f64> = forces.iter().rev().map(|q| -q).chain(forces[1..].iter().copied()).collect();
        let first = 0.97 * contact.norm().min(self.length);
        let last = self.length * (1.0 + self.beyond_tip(0.02));
        let row = |s_a: f64| -> Vec<TrialNode> {
            let unit = 1.0 / self.softness(s_a);
            let node = move |q: &f64| Trial { force: q * unit, s_a, gap: gap_of(beta) };
            sides.iter().map(node).map(|trial| self.node(trial, contact)).collect()
        };
        let mut rows: Vec<Vec<TrialNode>> = vec![row(first)];
        rows.extend(self.arc_lengths(first, last).into_iter().map(row));
        let mut starts = nearest(&rows);
        for pair in rows.windows(2) {
            let (below, above) = (&pair[0], &pair[1]);
            for j in 1..sides.len() {
                self.starts_in_cell(
                    [below[j - 1], below[j], above[j], above[j - 1]],
                    contact,
                    MOST_QUARTERED,
                    &mut starts,
                );
            }
        }
        starts
    }

    /// Triangles of a cell, given by its corners in turn, whose image holds the contact.
    ///
    /// A soft base turns the whole whisker by radians from one node to the next, and the image of a cell is no triangle any more:
    /// such cells are quartered, unless the contact is far from them.
    fn starts_in_cell(&self, cell: [TrialNode; 4], contact: Vec2, left: usize, starts: &mut Vec<Trial>) {
        let [a, b, c, d] = cell;
        let [Some(pa), Some(pb), Some(pc), Some(pd)] = cell.map(|node| node.1) else {
            // On a base that gives way at once only the weakest forces of a cell bend the whisker.
            if left > 0 && self.base_compliance > 0.0 && cell.iter().any(|node| node.1.is_some()) {
                return self.starts_in_quarters(cell, contact, left, starts);
            }
            starts.extend(inside([a, b, c]));
            starts.extend(inside([a, c, d]));
            return;
        };
        let reach = [pb, pc, pd].into_iter().map(|p| (p - pa).norm()).fold(0.0, f64::max);
        let nearest = [pa, pb, pc, pd].into_iter().map(Vec2::norm).fold(f64::INFINITY, f64::min);
        // As seen from the base, whose distance from the contact is the yardstick of a turn.
        if left == 0 || reach < LARGEST_CELL * contact.norm() || nearest > 2.0 * reach {
            starts.extend(inside([a, b, c]));
            starts.extend(inside([a, c, d]));
            return;
        }
        self.starts_in_quarters(cell, contact, left, starts);
    }

    /// A trial of the grid; without a place where the base turns so far that no shape of the first mode is near.
    fn node(&self, trial: Trial, contact: Vec2) -> TrialNode {
        let shot = trial.shoot_on(self).filter(|shot| self.base_angle(shot.moment).abs() <= FARTHEST_TURN);
        (trial, shot.map(|shot| shot.contact - contact))
    }

    fn starts_in_quarters(&self, [a, b, c, d]: [TrialNode; 4], contact: Vec2, left: usize, starts: &mut Vec<Trial>) {
        let node = |p: &TrialNode, q: &TrialNode| {
            let (p, q) = (&p.0, &q.0);
            let trial =
                Trial { force: 0.5 * (p.force + q.force), s_a: 0.5 * (p.s_a + q.s_a), gap: 0.5 * (p.gap + q.gap) };
            self.node(trial, contact)
        };
        let (ab, bc, cd, da) = (node(&a, &b), node(&b, &c), node(&c, &d), node(&d, &a));
        let middle = node(&ab, &cd);
        for part in [[a, ab, middle, da], [ab, b, bc, middle], [middle, bc, c, cd], [da, middle, cd, d]] {
            self.starts_in_cell(part, contact, left - 1, starts);
        }
    }

    /// Arc lengths from after `first` to `last`, dense where the rod is soft.
    fn arc_lengths(&self, first: f64, last: f64) -> Vec<f64> {
        let mut list = Vec::new();
        let mut s = first;
        while s < last && list.len() < 200 {
            let softness = self.softness(s);
            let mut ratio = RATIOS[0];
            while ratio > 1.005 && self.softness(s * ratio) > RATIOS[1] * softness {
                ratio = ratio.sqrt();
            }
            s *= ratio;
            list.push(s.min(last));
        }
        list
    }

    /// The force's line through the contact is known, so the force alone tells the base moment, and from there on the shape;
    /// where it meets the line it must meet the contact.
    fn starts_on_line(&self, contact: Vec2, psi: f64) -> Vec<Trial> {
        let direction = Vec2::from_angle(psi);
        let lever = contact.cross(direction);
        let unit = 1.0 / self.softness(contact.norm().min(self.length));
        if direction.y * lever < -1e-12 * contact.norm() {
            return Vec::new();
        }
        let up = geometric(0.02, if self.curvature.is_empty() { 1.15 } else { 1.03 }, 300.0);
        let grid: Vec<f64> = up.iter().rev().map(|q| -q).chain([0.0]).chain(up.iter().copied()).collect();
        // A rod that is curved at rest may cross the line before it ends there.
        let crossings = if self.curvature.is_empty() { 1..=1 } else { 1..=MOST_CROSSINGS };
        let on_crossing = |crossing: usize| {
            let meet = |q: f64| self.meet_line(contact, q * unit * direction, direction, crossing);
            let residual = |q: f64| meet(q).map_or(f64::NAN, |state| (state.position - contact).dot(direction));
            let trial = |q: f64| meet(q).map(|state| Trial { force: q * unit, s_a: state.s, gap: psi - state.phi });
            let found = roots(residual, &grid);
            // Where the march meets the line elsewhere from one force to the next, a root may show as a dip only.
            let dips = if self.curvature.is_empty() { Vec::new() } else { dips(residual, &grid) };
            found.into_iter().chain(dips).filter_map(trial).collect::<Vec<_>>()
        };
        crossings.flat_map(on_crossing).collect()
    }

    /// Where a march from the base meets the line through `contact` along `direction` for the given time.
    fn meet_line(&self, contact: Vec2, force: Vec2, direction: Vec2, crossing: usize) -> Option<RodState> {
        let moment = contact.cross(force);
        let base = RodState { s: 0.0, phi: self.base_angle(moment), moment, position: Vec2::ZERO };
        let lever = |state: &RodState| (contact - state.position).cross(direction);
        // How fast the lever falls along the rod.
        let approach = |state: &RodState| Vec2::from_angle(state.phi).cross(direction);
        let (mut sign, mut left, mut met) = (lever(&base).signum(), crossing, None);
        let last = self.length * (1.0 + self.beyond_tip(0.4));
        let _ = march(self, base, force, last, |step, end| {
            // A step may touch the line and turn back: it is looked at where it is nearest, too.
            let turn = if approach(&step.start) * approach(end) < 0.0 {
                root(|tau| approach(&step.at(tau)), 0.0, step.h).unwrap_or(step.h)
            } else {
                step.h
            };
            for (from, to) in [(0.0, turn), (turn, step.h)] {
                if sign * lever(&step.at(to)) > 0.0 {
                    continue;
                }
                (sign, left) = (-sign, left - 1);
                if left == 0 {
                    met = root(|tau| lever(&step.at(tau)), from, to).map(|tau| step.at(tau));
                    return false;
                }
            }
            // A rod that has wound up is none.
            end.phi.abs() < MOST_TURNING
        });
        met
    }

    /// How far beyond the tip a search reaches, at `most`, so that contacts at the tip lie inside it; as a share of the length.
    fn beyond_tip(&self, most: f64) -> f64 {
        let last = self.pieces[self.pieces.len() - 1];
        let narrowing = last.narrowing * self.length;
        if narrowing > 0.0 { (0.3 * last.radius(self.length) / narrowing).min(most) } else { most }
    }
}

/// A trial of a grid, and where its contact lies seen from the one that is looked for.
type TrialNode = (Trial, Option<Vec2>);

/// The nodes that no neighbour is nearer than: where the image of the grid folds over the contact, no triangle holds it.
fn nearest(rows: &[Vec<TrialNode>]) -> Vec<Trial> {
    let off = |i: usize, j: usize| rows.get(i).and_then(|row| row.get(j)?.1).map_or(f64::INFINITY, Vec2::norm);
    let is_nearest = |i: usize, j: usize| {
        let here = off(i, j);
        let around = (0..9).map(|k| off((i + k / 3).wrapping_sub(1), (j + k % 3).wrapping_sub(1)));
        here.is_finite() && around.into_iter().all(|there| here <= there)
    };
    let mut list = Vec::new();
    for (i, row) in rows.iter().enumerate() {
        let chosen = row.iter().enumerate().filter(|(j, _)| is_nearest(i, *j));
        list.extend(chosen.map(|(_, node)| node.0));
    }
    list
}

/// The trial between three nodes whose linear image is the origin, when it lies inside the triangle.
pub(super) fn inside(nodes: [TrialNode; 3]) -> Option<Trial> {
    let [(a, Some(p)), (b, Some(q)), (c, Some(r))] = nodes else { return None };
    let weights = [q.cross(r), r.cross(p), p.cross(q)];
    let sum = weights[0] + weights[1] + weights[2];
    // Some slack: the true image of a triangle has curved sides.
    if !weights.iter().all(|w| w / sum >= -0.15) {
        return None;
    }
    let mean = |x: f64, y: f64, z: f64| (weights[0] * x + weights[1] * y + weights[2] * z) / sum;
    Some(Trial {
        force: mean(a.force, b.force, c.force),
        s_a: mean(a.s_a, b.s_a, c.s_a),
        gap: mean(a.gap, b.gap, c.gap),
    })
}

fn same(a: &Shot, b: &Shot) -> bool {
    let near = |x: f64, y: f64| (x - y).abs() <= 1e-6 * (x.abs() + y.abs()) + 1e-13;
    near(a.phi_a, b.phi_a) && near(a.trial.s_a, b.trial.s_a)
}
