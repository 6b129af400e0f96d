//! Following a branch: the equilibrium next to a known one, in a few marches and with a status.

use super::super::bend::Bend;
use super::super::load::Load;
use super::super::{check_arc_length, check_contact, finite};
use super::Rod;
use super::newton::{Goal, ModeProblem, Refined, refine};
use super::shot::{Trial, gap_of};
use crate::error::Result;
use crate::plane::Vec2;
use alloc::vec;

/// How a search from a known equilibrium ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// An equilibrium of the first mode, to rounding.
    Converged,
    /// An equilibrium, but its contact lies beyond the tip.
    BeyondTip,
    /// An equilibrium, but the moment changes sign between base and contact.
    BeyondFirstMode,
    /// Nothing nearer can be reached: the branch has probably ended, and the whisker snaps.
    OutOfReach,
    /// The equations are degenerate here: a fold.
    Singular,
    /// Still moving after 30 steps.
    IterationLimit,
}

/// What was found from a known equilibrium.
#[derive(Clone, Debug, PartialEq)]
pub struct Followed {
    /// The last shape reached; an equilibrium when the status says so, none when not even the start can be bent.
    pub bend: Option<Bend>,
    /// How the search ended.
    pub status: Status,
    /// Newton steps taken, at most 30.
    pub iterations: usize,
}

impl Rod {
    /// The equilibrium under `force` (N) at `s_a` (m) on the branch of `start`.
    ///
    /// # Errors
    /// Usage: a number that is not finite or off the whisker.
    pub fn force_from(&self, force: f64, s_a: f64, load: Load, start: &Bend) -> Result<Followed> {
        finite("force", force, "N")?;
        check_arc_length(self.length, s_a)?;
        self.follow(Goal::Force, Trial { force, s_a, gap: gap_of(start.beta) }, load)
    }

    /// The equilibrium with `moment` (N m) about the base and contact at `s_a` (m) on the branch of `start`.
    ///
    /// # Errors
    /// Usage: a number that is not finite or off the whisker, a moment of zero.
    pub fn moment_from(&self, moment: f64, s_a: f64, load: Load, start: &Bend) -> Result<Followed> {
        finite("moment", moment, "N m")?;
        check_arc_length(self.length, s_a)?;
        if moment.abs() <= 0.0 {
            let bend = self.at_rest(s_a, load.line()?);
            return Ok(Followed { bend: Some(bend), status: Status::Converged, iterations: 0 });
        }
        self.follow(Goal::Moment(moment), Trial { force: start.force, s_a, gap: gap_of(start.beta) }, load)
    }

    /// The equilibrium whose contact is at `contact` (m) on the branch of `start`.
    ///
    /// # Errors
    /// Usage: a contact that is not finite or at the base.
    pub fn point_from(&self, contact: Vec2, load: Load, start: &Bend) -> Result<Followed> {
        check_contact(contact)?;
        let trial = Trial { force: start.force, s_a: start.s_a.min(self.length), gap: gap_of(start.beta) };
        self.follow(Goal::Point(contact), trial, load)
    }

    fn follow(&self, goal: Goal, mut start: Trial, load: Load) -> Result<Followed> {
        use super::super::load::Line;
        let line = load.line()?;
        if let Line::Following(beta) = line {
            start.gap = gap_of(beta);
        }
        let Refined { shot, mut status, iterations } = refine(&ModeProblem { rod: self, line, goal }, start);
        if let Some(shot) = shot.filter(|_| status == Status::Converged) {
            if shot.trial.s_a > self.length * (1.0 + 1e-9) {
                status = Status::BeyondTip;
            } else if shot.trial.shoot(self).is_none() {
                status = Status::BeyondFirstMode;
            }
        }
        let bend = shot.map(|shot| self.bends(vec![shot], line)).and_then(|mut bends| bends.pop());
        Ok(Followed { bend, status, iterations })
    }
}
