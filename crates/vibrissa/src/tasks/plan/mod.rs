//! Active sensing: the next motion that tells the remaining places apart.
//!
//! Each of some motions is followed for every state that is left, places and samples of their ridges alike, by the estimators' own
//! forward model, as far as all of them may go: footprint and whisker bases clear of all boundaries, whiskers bent no further than is gentle.
//! A robot that obeys ends the motion where a whisker feels [`PlannedMotion::stop_at`], a guarded move \[will1975guarded\], so that a
//! state near a wall stops where its whisker meets it and others go on. Two states stay together where their
//! readings agree within the declared bounds and what is not known of either state. The motion is the one that takes away most of the states'
//! entropy for its way, two motions deep, as in active localization \[burgard1997active\]; that states which read alike are cut off as a whole, and that gain
//! is weighed against cost, is the greedy hypothesis pruning of \[javdani2013touch\]. Work is counted in readings of the forward model: the
//! answer is that of the budget, whatever the machine.

mod candidates;
mod json;
mod motion;
mod options;
mod past;
mod planner;
mod predict;
mod score;
mod states;
mod symmetry;

pub use json::to_json;
pub use motion::Motion;
pub use options::{Criterion, PlanOptions};
pub use past::{Past, history, plan_from};
pub use planner::Planner;
pub use states::{RemainingState, remaining};

use crate::plane::Pose2;
use crate::world::{Map, Robot};
use crate::{Error, Result};
use predict::{Felt, Predictor, Rollout};
use score::{Alike, Table, Worth};

/// Motions that are looked at two motions deep, and most second motions for each of them.
const DEEP: usize = 4;
const SECOND: usize = 5;
/// Gains (nats) below this are none: a motion is not made for them.
const LEAST_GAIN: f64 = 0.05;

/// What is expected of a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedMotion {
    /// Where it goes.
    pub motion: Motion,
    /// For each whisker the size of the reading (N m) at which the robot has to end the motion.
    pub stop_at: Vec<f64>,
    /// Places that are left at best and at worst.
    pub places: [usize; 2],
    /// The mean distance of states that stay together (m; a radian counts 50 mm): expected, and the largest at worst.
    pub extent: [f64; 2],
    /// What is expected to be learned (nats): the entropy of the states that it takes away.
    pub information: f64,
}

/// Why there is a motion, or none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlanVerdict {
    /// The motion tells some of the states apart.
    Parts,
    /// No motion that was looked at does; the motion goes furthest, to where others may.
    Alike,
    /// One place is left, and no motion makes it smaller.
    Known,
    /// Readings of all motions agree at all places, and the map's symmetry takes the places onto each other.
    Symmetric,
    /// No motion is free of collision and gentle for all states.
    Confined,
}

impl PlanVerdict {
    /// The word for it: `parts`, `alike`, `known`, `symmetric` or `confined`.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Parts => "parts",
            Self::Alike => "alike",
            Self::Known => "known",
            Self::Symmetric => "symmetric",
            Self::Confined => "confined",
        }
    }
}

/// The answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Why there is a motion, or none.
    pub verdict: PlanVerdict,
    /// The next motion, where one is worth it.
    pub next: Option<PlannedMotion>,
    /// Places before it.
    pub places: usize,
    /// Extent before it, expected and at worst, as of [`PlannedMotion::extent`].
    pub extent: [f64; 2],
    /// Motions that were looked at, and those among them that are admissible for all states.
    pub looked_at: [usize; 2],
    /// Readings of the forward model that were taken.
    pub readings: usize,
}

impl Plan {
    /// The answer in a sentence.
    #[must_use]
    pub fn words(&self) -> String {
        let Some(next) = &self.next else {
            return match self.verdict {
                PlanVerdict::Symmetric => "no motion tells them apart: the map is symmetric".to_owned(),
                PlanVerdict::Known => "one place is left, and no motion makes it smaller".to_owned(),
                _ => "no motion is free of collision and gentle at all places that are left".to_owned(),
            };
        };
        let way = 1e3 * next.motion.way();
        let way = if way < 0.5 { String::new() } else { format!("; a way of {way:.0} mm") };
        if self.verdict == PlanVerdict::Alike {
            return format!(
                "{}: no motion within reach tells them apart; this one goes on to see more{way}",
                next.motion.name()
            );
        }
        let [least, most] = next.places;
        let into = if least == most { format!("{most}") } else { format!("{least} to {most}") };
        let what = match self.places {
            1 => "narrows the place".to_owned(),
            places if most == 1 => format!("parts all {places} places"),
            places if least == places => format!("narrows the {places} places without parting them"),
            places => format!("parts {places} places into {into}, worst case {most}"),
        };
        let [from, to] = [self.extent[0], next.extent[0]].map(|m| 1e3 * m);
        format!("{}: {what}; extent {from:.0} to {to:.0} mm{way}", next.motion.name())
    }
}

/// A motion that all states may make, as far as they may.
struct Admissible {
    motion: Motion,
    felt: Felt,
    worth: Option<Worth>,
    rate: f64,
}

/// The next motion that tells `states` apart.
///
/// States in which the robot cannot be, since it would be inside something, are left out. What `past` does not know it may leave empty.
///
/// # Errors
///
/// Usage: no state, states that are not finite, options out of range; whiskers that are curved at rest or lean.
pub fn plan(
    map: &Map,
    robot: &Robot,
    states: &[RemainingState],
    past: &Past<'_>,
    options: &PlanOptions,
) -> Result<Plan> {
    plan_by(map, robot, states, past, options, None)
}

/// As [`plan`], by one who knows where the robot is: what a motion brings is what it brings if that is the truth. No robot can do so; it is what
/// plans are compared with.
///
/// # Errors
///
/// As [`plan`].
pub fn plan_knowing(
    map: &Map,
    robot: &Robot,
    states: &[RemainingState],
    past: &Past<'_>,
    options: &PlanOptions,
    truth: Pose2,
) -> Result<Plan> {
    plan_by(map, robot, states, past, options, Some(truth))
}

fn plan_by(
    map: &Map,
    robot: &Robot,
    states: &[RemainingState],
    past: &Past<'_>,
    options: &PlanOptions,
    truth: Option<Pose2>,
) -> Result<Plan> {
    options.check()?;
    robot.require_level("plan")?;
    check(states)?;
    let (states, weighty) = states::weighty_first(&states::possible(map, robot, states, options.footprint));
    let mut predictor = Predictor::new(map, robot, &states, past, options)?;
    let stop_at = predictor.stop_at().to_vec();
    // What weighs nothing is only kept from harm.
    let states = &states[..weighty];
    let table = Table::new(states, options, truth);
    let together = table.together();
    let before = table.judge(&together);
    let (mut found, looked_at) = first(&mut predictor, &table, &together, candidates::all(map, robot, states, options));
    let admissible = found.len();
    deepen(&mut predictor, &table, &mut found);
    let parts = found.iter().any(|one| one.worth.is_some());
    found.sort_by(|a, b| b.rate.total_cmp(&a.rate));
    let places = table.places();
    let none = |verdict| (verdict, None);
    let chosen = |one: &Admissible| {
        let cut = one.worth.as_ref().and_then(|worth| one.felt.steps.get(worth.step)).or(one.felt.steps.last());
        let judged = table.judge(one.worth.as_ref().map_or(&together, |worth| &worth.alike));
        PlannedMotion {
            motion: cut.map_or_else(|| one.motion.clone(), |step| one.motion.up_to(step)),
            stop_at: stop_at.clone(),
            places: judged.places,
            extent: judged.extent,
            information: one.worth.as_ref().map_or(0.0, |worth| worth.gain),
        }
    };
    let (verdict, next) = match found.first() {
        None => none(PlanVerdict::Confined),
        Some(_) if symmetry::leaves_nothing(map, states) => none(PlanVerdict::Symmetric),
        Some(one) if parts => (PlanVerdict::Parts, Some(chosen(one))),
        Some(_) if places == 1 => none(PlanVerdict::Known),
        Some(_) if symmetry::takes_places(map, states) => none(PlanVerdict::Symmetric),
        Some(_) => {
            let way = |one: &&Admissible| one.felt.steps.last().map_or(0.0, |step| step.way);
            let furthest = found.iter().max_by(|a, b| way(a).total_cmp(&way(b)));
            (PlanVerdict::Alike, furthest.map(chosen))
        }
    };
    let looked_at = [looked_at, admissible];
    Ok(Plan { verdict, next, places, extent: before.extent, looked_at, readings: predictor.taken() })
}

/// The motions that [`plan`] would look at, each as far as all states may go, and the sizes of readings at which the robot has to end
/// them: what it may do without asking which is best.
///
/// # Errors
///
/// As [`plan`].
pub fn admissible(
    map: &Map,
    robot: &Robot,
    states: &[RemainingState],
    past: &Past<'_>,
    options: &PlanOptions,
) -> Result<(Vec<Motion>, Vec<f64>)> {
    options.check()?;
    robot.require_level("plan")?;
    check(states)?;
    let states = &states::possible(map, robot, states, options.footprint)[..];
    let mut predictor = Predictor::new(map, robot, states, past, options)?;
    let mut all = Vec::new();
    for motion in candidates::all(map, robot, states, options) {
        match predictor.roll(&motion, None) {
            Rollout::Spent => break,
            Rollout::Refused => {}
            Rollout::Felt(felt) => all.extend(felt.steps.last().map(|step| motion.up_to(step))),
        }
    }
    Ok((all, predictor.stop_at().to_vec()))
}

/// The motion that tests whether the robot is at the place of the first of these states: along it the readings that the place expects change most,
/// beyond their bands. Where it is elsewhere other readings come. At most so long (m; a turn may take as long as it takes), and what ends it; none
/// where no motion is admissible for all states or nothing would be felt along any.
///
/// # Errors
///
/// As [`plan`].
pub fn test_of(
    map: &Map,
    robot: &Robot,
    states: &[RemainingState],
    past: &Past<'_>,
    options: &PlanOptions,
    longest: f64,
) -> Result<Option<(Motion, Vec<f64>)>> {
    options.check()?;
    robot.require_level("plan")?;
    check(states)?;
    let states = &states::possible(map, robot, states, options.footprint)[..];
    let mut predictor = Predictor::new(map, robot, states, past, options)?;
    let tested = states.iter().take_while(|state| state.place == states[0].place).count();
    let mut best: Option<(f64, Motion)> = None;
    for motion in candidates::all(map, robot, states, options) {
        match predictor.roll(&motion, None) {
            Rollout::Spent => break,
            Rollout::Refused => {}
            Rollout::Felt(felt) => {
                let Some((change, step)) = felt.most_change(longest, tested) else { continue };
                if best.as_ref().is_none_or(|(most, _)| change > *most) {
                    best = Some((change, motion.up_to(step)));
                }
            }
        }
    }
    Ok(best.map(|(_, motion)| (motion, predictor.stop_at().to_vec())))
}

fn check(states: &[RemainingState]) -> Result<()> {
    let is_sound = |s: &RemainingState| {
        let finite = s.pose.position().is_finite() && s.pose.theta.is_finite();
        finite && s.weight >= 0.0 && s.weight.is_finite() && s.covariance.iter().flatten().all(|c| c.is_finite())
    };
    if states.is_empty() || !states.iter().all(is_sound) {
        return Err(Error::usage("the states to tell apart").allowed("at least one, of finite numbers"));
    }
    Ok(())
}

/// All motions that all states may make, and how many were looked at.
fn first(
    predictor: &mut Predictor<'_>,
    table: &Table<'_>,
    together: &Alike,
    motions: Vec<Motion>,
) -> (Vec<Admissible>, usize) {
    let (mut found, mut looked_at) = (Vec::new(), 0);
    for motion in motions {
        match predictor.roll(&motion, None) {
            Rollout::Spent => break,
            Rollout::Refused => looked_at += 1,
            Rollout::Felt(felt) => {
                looked_at += 1;
                let worth = table.best(together, &felt, LEAST_GAIN);
                let rate = worth.as_ref().map_or(0.0, Worth::rate);
                found.push(Admissible { motion, felt, worth, rate });
            }
        }
    }
    (found, looked_at)
}

/// Looks at the best motions two motions deep.
fn deepen(predictor: &mut Predictor<'_>, table: &Table<'_>, found: &mut [Admissible]) {
    found.sort_by(|a, b| b.rate.total_cmp(&a.rate));
    let seconds: Vec<Motion> = found.iter().take(SECOND).map(|one| one.motion.clone()).collect();
    for one in found.iter_mut().take(DEEP) {
        let Some(worth) = &one.worth else { break };
        let Rollout::Felt(felt) = predictor.roll(&one.motion.up_to(&one.felt.steps[worth.step]), None) else { break };
        let mut then = Vec::new();
        for second in &seconds {
            match predictor.roll(second, Some(&felt)) {
                Rollout::Spent => break,
                Rollout::Refused => {}
                Rollout::Felt(felt) => then.extend(table.best(&worth.alike, &felt, LEAST_GAIN)),
            }
        }
        one.rate = one.rate.max(table.deep(worth, &then));
    }
}
