//! Tip mode of the rod: contact at the tip, force of any direction.

use super::super::bend::Bend;
use super::super::load::Line;
use super::super::{check_contact, representable};
use super::Rod;
use super::follow::Status;
use super::newton::{Goal, ModeProblem, refine};
use super::point::inside;
use super::scan::geometric;
use super::shot::{Shot, Trial};
use crate::error::Result;
use crate::plane::Vec2;
use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::{FRAC_PI_2, TAU};

/// Directions of the grid.
const DIRECTIONS: usize = 72;
/// Nodes of the grid from which a search starts because they are near.
const NEAREST: usize = 40;

impl Rod {
    /// Every first-mode equilibrium whose tip is at `tip` (m, whisker frame), least energy first; as
    /// [`tip_mode`](super::super::tip_mode).
    ///
    /// # Errors
    /// Usage: a tip that is not finite or at the base.
    pub fn tip_mode(&self, tip: Vec2) -> Result<Vec<Bend>> {
        check_contact(tip)?;
        if tip.norm() >= self.length {
            return Ok(Vec::new());
        }
        let any = Line::Following(0.0);
        let problem = ModeProblem { rod: self, line: any, goal: Goal::Tip(tip) };
        let mut shots: Vec<Shot> = Vec::new();
        for start in self.starts_for_tip(tip) {
            let refined = refine(&problem, Trial { s_a: self.length, ..start });
            let Some(shot) = refined.shot.filter(|_| refined.status == Status::Converged) else { continue };
            // One force along one line, whichever sign the search gave it.
            let near = |s: &Shot| (s.phi_a - shot.phi_a).abs() < 1e-6 && (s.moment / shot.moment - 1.0).abs() < 1e-5;
            if shot.trial.shoot(self).is_some() && !shots.iter().any(near) {
                shots.push(shot);
            }
        }
        let bend = |shot: Shot| self.bends(vec![shot], Line::Following(shot.trial.gap - FRAC_PI_2)).pop();
        let mut bends: Vec<Bend> = shots.into_iter().filter_map(bend).collect();
        bends.sort_by(|a, b| a.energy().total_cmp(&b.energy()));
        representable(bends)
    }

    /// Triangles of a grid over force and direction whose image holds the tip.
    fn starts_for_tip(&self, tip: Vec2) -> Vec<Trial> {
        let unit = 1.0 / self.softness(self.length);
        let row = |q: f64| -> Vec<(Trial, Option<Vec2>)> {
            let trial = |i: usize| Trial {
                force: q * unit,
                s_a: self.length,
                gap: TAU * (i as f64 + 0.5) / DIRECTIONS as f64 - FRAC_PI_2,
            };
            let node = |i: usize| (trial(i), trial(i).shoot(self).map(|shot| shot.contact - tip));
            (0..=DIRECTIONS).map(node).collect()
        };
        let mut starts = Vec::new();
        let mut below = row(1e-6);
        let mut nodes = below.clone();
        for q in geometric(1e-4, 1.5, 0.02).into_iter().chain(geometric(0.024, 1.2, 40.0)) {
            let above = row(q);
            for j in 1..=DIRECTIONS {
                starts.extend(inside([below[j - 1], below[j], above[j]]));
                starts.extend(inside([below[j - 1], above[j], above[j - 1]]));
            }
            nodes.extend_from_slice(&above);
            below = above;
        }
        // Close to the rest shape the image is all but folded flat, and triangles miss: the nearest nodes start, too.
        let off = |node: &(Trial, Option<Vec2>)| node.1.map_or(f64::INFINITY, Vec2::norm);
        nodes.sort_by(|a, b| off(a).total_cmp(&off(b)));
        starts.extend(nodes.iter().take(NEAREST).map(|node| node.0));
        starts
    }
}
