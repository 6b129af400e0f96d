//! What the robot does next: as a plan says, or what helps where a plan leads nowhere.

use super::Ended;
use crate::Result;
use crate::flow::pose::Hypothesis;
use crate::plane::{Pose2, wrap_angle};
use crate::tasks::plan::{
    Motion, Past, Plan, PlanOptions, PlanVerdict, RemainingState, admissible, plan, plan_knowing, remaining, test_of,
};
use crate::world::{Map, MountedWhisker, Robot};

/// So many motions on the spot on end without a place less are enough.
const STUCK: usize = 3;
/// A whisker that is bent by this share of what is gentle is let go first.
const PRESSED: f64 = 0.9;
/// How often on end a robot goes back the way it came where nothing else is admissible, and how far (m).
const MOST_BACK: usize = 3;
const BACK: f64 = 0.05;
/// Longest way (m) of the motion that tests a place.
const LONGEST_TEST: f64 = 0.06;
/// Poses no further from each other than this (m; a radian counts as `BACK`) are one on a way back, and the most that are looked at.
const THERE: f64 = 3e-3;
const MOST_POSES: usize = 1000;
/// Shortest motion (m, rad) that is chosen without a plan.
const SHORTEST: f64 = 0.02;
const SHORTEST_TURN: f64 = 0.2;
/// What is less is no motion.
const LEAST: f64 = 2e-3;
const LEAST_TURN: f64 = 0.03;

/// Who chooses a motion.
pub(super) enum Chooser<'a> {
    /// A plan.
    Plan,
    /// A plan by one who knows where the robot is.
    Hindsight(Pose2),
    /// Somebody, among the admissible ones.
    Other(&'a mut dyn FnMut(&[Motion]) -> Option<Motion>),
}

/// What the robot does next.
#[derive(Clone, Debug, PartialEq)]
pub enum Order {
    /// A motion, ended where a whisker feels as much as `stop_at` (N m, in the order of the whiskers).
    Go {
        /// Where it goes.
        motion: Motion,
        /// The sizes of the readings.
        stop_at: Vec<f64>,
    },
    /// Back the way it came, as [`way_back`] tells: nothing was there.
    Back,
    /// It ends.
    End(Ended),
}

/// A motion that was ordered, as far as the next orders depend on it.
#[derive(Clone, Debug)]
struct Ordered {
    /// Places before it.
    places: usize,
    /// Whether a plan told it, and it was on the spot.
    on_the_spot: bool,
    /// Whether it was to lead elsewhere.
    leads_on: bool,
    /// Whether it was to leave as many places as there were.
    narrows: bool,
    /// Where no motion tells the places apart, the kind that was chosen to see more.
    sees_more: Option<&'static str>,
}

/// Chooses motion after motion until the robot knows where it is.
#[derive(Clone, Debug)]
pub struct Pilot {
    options: PlanOptions,
    ordered: Vec<Ordered>,
    backs: usize,
    /// Kinds of motions that were to see more and left as many places, since there were fewer.
    vain: Vec<&'static str>,
}

impl Pilot {
    /// Before the first motion.
    ///
    /// # Errors
    ///
    /// As [`PlanOptions::check`].
    pub fn new(options: PlanOptions) -> Result<Self> {
        options.check()?;
        Ok(Self { options, ordered: Vec::new(), backs: 0, vain: Vec::new() })
    }

    /// What the robot does next that may be at these places, at least one; the plan, where one was made.
    ///
    /// # Errors
    ///
    /// As [`plan`].
    pub fn next(
        &mut self,
        map: &Map,
        robot: &Robot,
        places: &[Hypothesis],
        past: &Past<'_>,
    ) -> Result<(Order, Option<Plan>)> {
        self.next_by(map, robot, places, past, Chooser::Plan)
    }

    /// What a robot does that seems to know its place: the motion that tests whether it is there, see [`test_of`], where it can make one; else back
    /// the way it came. It ends where that has been tried as often as it may be.
    ///
    /// # Errors
    ///
    /// As [`plan`].
    pub fn test(&mut self, map: &Map, robot: &Robot, places: &[Hypothesis], past: &Past<'_>) -> Result<Order> {
        let motion = if self.is_pressed(robot, past.readings) {
            None
        } else {
            let states = remaining(places, self.options.states);
            test_of(map, robot, &states, past, &self.options, LONGEST_TEST)?
        };
        Ok(match motion {
            Some((motion, stop_at)) => self.order(Some(motion), stop_at, None, places),
            None if self.backs < MOST_BACK => self.back(places),
            None => Order::End(Ended::Localized),
        })
    }

    pub(super) fn next_by(
        &mut self,
        map: &Map,
        robot: &Robot,
        places: &[Hypothesis],
        past: &Past<'_>,
        chooser: Chooser<'_>,
    ) -> Result<(Order, Option<Plan>)> {
        self.learn(places);
        if self.is_pressed(robot, past.readings) && self.backs < MOST_BACK {
            return Ok((self.back(places), None));
        }
        let states = remaining(places, self.options.states);
        let all = || worth_a_name(map, robot, &states, past, &self.options);
        let truth = match chooser {
            Chooser::Plan => None,
            Chooser::Hindsight(truth) => Some(truth),
            Chooser::Other(choose) => {
                let (all, stop_at) = all()?;
                let motion = if all.is_empty() { None } else { choose(&all) };
                return Ok((self.order(motion, stop_at, None, places), None));
            }
        };
        let options = &PlanOptions { places_only: self.narrowed_in_vain(places), ..self.options };
        let plan = match truth {
            Some(truth) => plan_knowing(map, robot, &states, past, options, truth)?,
            None => plan(map, robot, &states, past, options)?,
        };
        let (motion, stop_at) = match plan.verdict {
            PlanVerdict::Symmetric => return Ok((Order::End(Ended::Symmetric), Some(plan))),
            PlanVerdict::Known | PlanVerdict::Parts if plan.verdict == PlanVerdict::Known || self.is_stuck(places) => {
                // The verdict wants more of the same, or what was promised did not come true: the longest way there is.
                let (all, stop_at) = all()?;
                (furthest(all), stop_at)
            }
            PlanVerdict::Alike => {
                let (mut all, stop_at) = all()?;
                all.retain(|motion| !self.vain.contains(&motion.name()));
                if all.is_empty() {
                    self.vain.clear();
                }
                // A small motion is better than none.
                let is_some = |one: &Motion| one.way() >= LEAST || one.turn() >= LEAST_TURN;
                let small = plan.next.as_ref().map(|next| next.motion.clone()).filter(is_some);
                let chosen = furthest(all).or(small);
                // Turns alone, again: it leaves this place.
                let is_turn = |one: &Motion| one.way() < SHORTEST;
                (chosen.filter(|one| !is_turn(one) || !self.turns_in_vain(places)), stop_at)
            }
            _ => {
                plan.next.as_ref().map_or((None, Vec::new()), |next| (Some(next.motion.clone()), next.stop_at.clone()))
            }
        };
        Ok((self.order(motion, stop_at, Some(&plan), places), Some(plan)))
    }

    fn order(
        &mut self,
        motion: Option<Motion>,
        stop_at: Vec<f64>,
        plan: Option<&Plan>,
        places: &[Hypothesis],
    ) -> Order {
        let Some(motion) = motion else {
            return if self.backs < MOST_BACK { self.back(places) } else { Order::End(Ended::Confined) };
        };
        let leads_on = motion.way() >= SHORTEST;
        if leads_on {
            self.backs = 0;
        }
        let next = plan.and_then(|plan| plan.next.as_ref().map(|next| (plan, next)));
        let sees_more = plan.is_some_and(|plan| plan.verdict == PlanVerdict::Alike);
        self.ordered.push(Ordered {
            sees_more: sees_more.then(|| motion.name()),
            places: places.len(),
            leads_on,
            on_the_spot: next.is_some_and(|(_, next)| next.motion.way() < SHORTEST),
            narrows: next.is_some_and(|(plan, next)| next.places[0] >= plan.places),
        });
        Order::Go { motion, stop_at }
    }

    fn back(&mut self, places: &[Hypothesis]) -> Order {
        self.backs += 1;
        self.ordered.push(Ordered {
            places: places.len(),
            on_the_spot: false,
            leads_on: false,
            narrows: false,
            sees_more: None,
        });
        Order::Back
    }

    /// What the last motion came to.
    fn learn(&mut self, places: &[Hypothesis]) {
        let Some(last) = self.ordered.last() else { return };
        if places.len() < last.places {
            self.vain.clear();
        } else if let Some(kind) = last.sees_more {
            self.vain.push(kind);
        }
    }

    /// Whether the last motions, all on the spot, left as many places as there were.
    fn is_stuck(&self, places: &[Hypothesis]) -> bool {
        let last = &self.ordered[self.ordered.len().saturating_sub(STUCK)..];
        last.len() == STUCK && last.iter().all(|one| one.on_the_spot && one.places <= places.len())
    }

    /// Whether a motion that did not lead elsewhere, a turn or a way back, left as many places as there were since the last that did.
    fn turns_in_vain(&self, places: &[Hypothesis]) -> bool {
        let since = self.ordered.iter().rev().take_while(|one| !one.leads_on);
        since.map(|one| one.places).max().is_some_and(|before| before <= places.len())
    }

    /// Whether the last motion was to narrow several places, and left as many: what it promised again would not come either.
    fn narrowed_in_vain(&self, places: &[Hypothesis]) -> bool {
        self.ordered.last().is_some_and(|last| last.narrows && places.len() > 1 && places.len() >= last.places)
    }

    /// Whether a whisker is bent nearly as far as is gentle.
    fn is_pressed(&self, robot: &Robot, readings: &[f64]) -> bool {
        let pressed = |(z, w): (&f64, &MountedWhisker)| z.abs() >= PRESSED * self.options.most(w);
        readings.iter().zip(&robot.whiskers).any(pressed)
    }
}

/// The motion of the longest way, the first of several.
fn furthest(all: Vec<Motion>) -> Option<Motion> {
    all.into_iter().reduce(|best, one| if one.way() > best.way() { one } else { best })
}

/// All admissible motions that are worth a name, and the sizes of readings at which they end.
fn worth_a_name(
    map: &Map,
    robot: &Robot,
    states: &[RemainingState],
    past: &Past<'_>,
    options: &PlanOptions,
) -> Result<(Vec<Motion>, Vec<f64>)> {
    let (mut all, stop_at) = admissible(map, robot, states, past, options)?;
    all.retain(|motion| motion.way() >= SHORTEST || motion.turn() >= SHORTEST_TURN);
    Ok((all, stop_at))
}

/// The way that led here as far back as [`Order::Back`] goes (50 mm; a radian counts as much), the newest pose first: loops that ended where they
/// began are left out, and so is what the robot went back before. Where it has gone back all the way it is what the robot did last.
#[must_use]
pub fn way_back(newest_first: impl Iterator<Item = Pose2>) -> Vec<Pose2> {
    let far = |a: Pose2, b: Pose2| a.position().distance(b.position()) + BACK * wrap_angle(a.theta - b.theta).abs();
    let mut newest_first = newest_first.peekable();
    let Some(here) = newest_first.peek().copied() else { return Vec::new() };
    let way: Vec<Pose2> = newest_first.take(MOST_POSES).collect();
    let mut led_here: Vec<Pose2> = Vec::new();
    for &pose in way.iter().rev() {
        match led_here.iter().position(|&before| far(before, pose) < THERE) {
            Some(before) => led_here.truncate(before + 1),
            None => led_here.push(pose),
        }
    }
    led_here.reverse();
    let is_elsewhere = |pose: &Pose2| far(*pose, here) >= THERE;
    let all = if led_here.iter().any(is_elsewhere) { led_here } else { way };
    let (mut poses, mut gone) = (vec![here], 0.0);
    for pose in all.into_iter().skip_while(|pose| !is_elsewhere(pose)) {
        gone += poses.last().map_or(0.0, |&last| far(last, pose));
        if gone > BACK {
            break;
        }
        poses.push(pose);
    }
    poses
}
