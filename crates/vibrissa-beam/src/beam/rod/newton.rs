//! Newton's method from the contact, for up to three unknowns: it refines what a search has found, and follows a branch.

use super::super::load::Line;
use super::Rod;
use super::follow::Status;
use super::shot::{Shot, Trial};
use crate::linear_algebra::solve;
use crate::plane::{Vec2, wrap_angle};

/// Most Newton steps; four are usual.
const MOST_STEPS: usize = 30;

/// What is known.
#[derive(Clone, Copy, Debug)]
pub(super) enum Goal {
    /// The force and the contact's arc length.
    Force,
    /// The moment about the base (N m) and the contact's arc length.
    Moment(f64),
    /// The contact point, whisker frame (m).
    Point(Vec2),
    /// The contact point (m, whisker frame) and its arc length, under a force of any direction.
    Tip(Vec2),
}

/// A mode with its numbers.
pub(super) struct ModeProblem<'a> {
    pub(super) rod: &'a Rod,
    pub(super) line: Line,
    pub(super) goal: Goal,
}

/// Where Newton's method ended.
pub(super) struct Refined {
    pub(super) shot: Option<Shot>,
    pub(super) status: Status,
    pub(super) iterations: usize,
}

/// Residuals or unknowns; those not in use stay zero.
type Triple = [f64; 3];

impl ModeProblem<'_> {
    /// Which of force, arc length and tilt are unknown.
    fn unknowns(&self) -> [bool; 3] {
        let fixed = matches!(self.line, Line::Fixed(_));
        match self.goal {
            Goal::Force => [false, false, fixed],
            Goal::Moment(_) => [true, false, fixed],
            Goal::Point(_) => [true, true, fixed],
            Goal::Tip(_) => [true, false, true],
        }
    }

    /// What the shot misses, dimensionless; as many entries as there are unknowns, in the same places.
    fn residual(&self, shot: &Shot) -> Triple {
        let tilt = match self.line {
            Line::Fixed(psi) => wrap_angle(shot.direction() - psi),
            Line::Following(_) => 0.0,
        };
        match self.goal {
            Goal::Force => [0.0, 0.0, tilt],
            Goal::Moment(moment) => [shot.moment / moment - 1.0, 0.0, tilt],
            Goal::Point(point) => {
                let off = (shot.contact - point) * (1.0 / point.norm());
                [off.y, off.x, tilt]
            }
            Goal::Tip(point) => {
                let off = (shot.contact - point) * (1.0 / point.norm());
                [off.y, 0.0, off.x]
            }
        }
    }
}

/// Newton's method from `start`, with derivatives by differences and steps cut where the residual would grow.
pub(super) fn refine(problem: &ModeProblem<'_>, start: Trial) -> Refined {
    let active = problem.unknowns();
    let unit = 1.0 / problem.rod.softness(start.s_a);
    let shoot = |trial: &Trial| trial.shoot_on(problem.rod).map(|shot| (shot, problem.residual(&shot)));
    let norm = |r: &Triple| r[0].abs().max(r[1].abs()).max(r[2].abs());
    let Some((mut shot, mut residual)) = shoot(&start) else {
        return Refined { shot: None, status: Status::OutOfReach, iterations: 0 };
    };
    for iteration in 1..=MOST_STEPS {
        let Some(step) = newton_step(problem, &shot, &residual, active, unit) else {
            return Refined { shot: Some(shot), status: Status::Singular, iterations: iteration };
        };
        let small = is_small(&shot.trial, &step, unit);
        let mut cut = longest(&shot.trial, &step, unit);
        let mut moved = None;
        for _ in 0..8 {
            moved = shoot(&moved_by(&shot.trial, &step, cut)).filter(|(_, r)| small || norm(r) < norm(&residual));
            if moved.is_some() {
                break;
            }
            cut *= 0.5;
        }
        let Some((next, r)) = moved else {
            // Rounding: no step is better. Converged when the residual is as small as rounding leaves it.
            let status = if norm(&residual) < 1e-11 { Status::Converged } else { Status::OutOfReach };
            return Refined { shot: Some(shot), status, iterations: iteration };
        };
        (shot, residual) = (next, r);
        if small || norm(&residual) <= 0.0 {
            return Refined { shot: Some(shot), status: Status::Converged, iterations: iteration };
        }
    }
    Refined { shot: Some(shot), status: Status::IterationLimit, iterations: MOST_STEPS }
}

fn moved_by(trial: &Trial, step: &Triple, cut: f64) -> Trial {
    Trial { force: trial.force + cut * step[0], s_a: trial.s_a + cut * step[1], gap: trial.gap + cut * step[2] }
}

/// Whether the step is too small to matter.
fn is_small(trial: &Trial, step: &Triple, unit: f64) -> bool {
    step[0].abs() <= 1e-11 * trial.force.abs() + 1e-16 * unit
        && step[1].abs() <= 1e-11 * trial.s_a
        && step[2].abs() <= 1e-11 * trial.gap.abs()
}

/// The share of the step that keeps the unknowns where the linear picture may hold.
fn longest(trial: &Trial, step: &Triple, unit: f64) -> f64 {
    let force = 0.5 * (trial.force.abs() + unit) / step[0].abs();
    let s_a = 0.1 * trial.s_a / step[1].abs();
    let gap = 0.5 / step[2].abs();
    // Division by a zero step gives infinity or no number, both of which leave 1.
    1.0_f64.min(force).min(s_a).min(gap)
}

/// The solution of the linearized problem.
fn newton_step(
    problem: &ModeProblem<'_>,
    shot: &Shot,
    residual: &Triple,
    active: [bool; 3],
    unit: f64,
) -> Option<Triple> {
    let trial = shot.trial;
    let sizes = [1e-7 * (trial.force.abs() + unit), 1e-7 * trial.s_a, 1e-6 * trial.gap.abs().max(1e-9)];
    let mut matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for column in 0..3 {
        if !active[column] {
            continue;
        }
        let mut unit_step = [0.0; 3];
        unit_step[column] = sizes[column];
        let ahead = problem.residual(&moved_by(&trial, &unit_step, 1.0).shoot_on(problem.rod)?);
        for row in 0..3 {
            matrix[row][column] = ahead[row] - residual[row];
        }
    }
    let scaled = solve(&matrix, &residual.map(|r| -r))?;
    let step = [0, 1, 2].map(|i| if active[i] { scaled[i] * sizes[i] } else { 0.0 });
    step.iter().all(|v| v.is_finite()).then_some(step)
}
