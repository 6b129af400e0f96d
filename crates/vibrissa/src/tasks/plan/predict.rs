//! What every state would feel along a motion, and how far all of them may go.

use super::motion::Step;
use super::{Motion, Past, PlanOptions, RemainingState};
use crate::Result;
use crate::contact::{BentWhisker, FeltMoment, Followed};
use crate::plane::{Pose2, Vec2};
use crate::world::{Map, MountedWhisker, Robot};

/// How far off a place may be (standard deviations).
const SIGMAS: f64 = 2.0;
/// What a state has to explain of what is read now: within so many standard deviations, and this share of the largest moment.
const EXPLAINED: f64 = 4.0;
const SLACK: f64 = 0.05;
/// A robot whose whisker is bent already ends the motion where it is bent by this much more, short of this share of the largest moment.
const FURTHER: f64 = 1.15;
const STOP_SHORT: f64 = 0.9;
/// What is kept between footprint and boundaries besides (m).
const CLEAR: f64 = 1e-3;

/// What a whisker reads at a step of one state: between these (N m), and whether that ends the motion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Band {
    pub(super) low: f64,
    pub(super) high: f64,
}

/// A state at a step.
#[derive(Clone, Debug)]
pub(super) enum At {
    /// It goes on; what its whiskers read.
    Runs(Vec<Band>),
    /// It may have stopped here or before, or not.
    May(Vec<Band>),
    /// What it feels is not known.
    Blind,
    /// It has stopped.
    Stopped,
}

/// What the states feel along a motion.
pub(super) struct Felt {
    pub(super) steps: Vec<Step>,
    /// For each step each state.
    pub(super) at: Vec<Vec<At>>,
    /// For each state: where it is at the end.
    ends: Vec<Now>,
}

impl Felt {
    /// By how much in all the readings of the first `states` change on the way, in half widths of their bands, in the mean, and the step up to which
    /// they do; no way longer than so (m). None where they do not change beyond their bands.
    pub(super) fn most_change(&self, longest: f64, states: usize) -> Option<(f64, &Step)> {
        let (mut sum, mut last) = (0.0, None);
        for (k, step) in self.steps.iter().enumerate().skip(1).take_while(|(_, step)| step.way <= longest) {
            let mut more = 0.0;
            for (before, now) in self.at[k - 1].iter().zip(&self.at[k]).take(states) {
                if let (At::Runs(before), At::Runs(now) | At::May(now)) = (before, now) {
                    more += before.iter().zip(now).map(|(a, b)| a.change_to(b)).sum::<f64>();
                }
            }
            if more > 0.0 {
                (sum, last) = (sum + more / states.max(1) as f64, Some(step));
            }
        }
        last.map(|step| (sum, step))
    }
}

impl Band {
    /// By how much it moves beyond its width, in half widths.
    fn change_to(&self, next: &Self) -> f64 {
        let middle = |band: &Self| 0.5 * (band.low + band.high);
        let half = 0.5 * (self.high - self.low).max(next.high - next.low);
        ((middle(self) - middle(next)).abs() / half.max(f64::MIN_POSITIVE) - 1.0).max(0.0)
    }
}

pub(super) enum Rollout {
    Felt(Felt),
    /// Some state cannot make even a little of it.
    Refused,
    /// The budget does not reach.
    Spent,
}

pub(super) struct Predictor<'a> {
    map: &'a Map,
    robot: &'a Robot,
    states: &'a [RemainingState],
    whiskers: Vec<BentWhisker<'a>>,
    /// For each state: where it is now.
    now: Vec<Now>,
    most: Vec<f64>,
    stop_at: Vec<f64>,
    footprint: f64,
    left: usize,
    taken: usize,
}

/// Where a state is.
#[derive(Clone)]
struct Now {
    whiskers: Vec<Followed>,
    pose: Pose2,
    /// Whether what its whiskers feel is not known.
    is_blind: bool,
}

/// A state on its way.
struct Under {
    now: Now,
    begin: Pose2,
    may_have_stopped: bool,
    has_stopped: bool,
}

impl<'a> Predictor<'a> {
    pub(super) fn new(
        map: &'a Map,
        robot: &'a Robot,
        states: &'a [RemainingState],
        past: &Past<'_>,
        options: &PlanOptions,
    ) -> Result<Self> {
        let whiskers = robot.whiskers.iter().map(|w| BentWhisker::new(map, &w.beam)).collect::<Result<Vec<_>>>()?;
        let most: Vec<f64> = robot.whiskers.iter().map(|w| options.most(w)).collect();
        let (footprint, left, stop_at) = (options.footprint, options.budget, options.stop_at(robot));
        let mut all = Self { map, robot, states, whiskers, now: Vec::new(), most, stop_at, footprint, left, taken: 0 };
        for state in states {
            let own = all.come(state, past);
            all.now.push(own);
        }
        all.left = all.left.saturating_sub(all.taken);
        for (k, most) in all.most.iter().enumerate() {
            // A whisker that is bent already may stay so.
            let now = past.readings.get(k).map_or(0.0, |z| z.abs());
            all.stop_at[k] = all.stop_at[k].max(FURTHER * now).min(STOP_SHORT * most);
        }
        Ok(all)
    }

    /// For each whisker the size of the reading at which motions end.
    pub(super) fn stop_at(&self) -> &[f64] {
        &self.stop_at
    }

    /// A state that came here: blind where that does not explain what is read.
    fn come(&mut self, state: &RemainingState, past: &Past<'_>) -> Now {
        let mut now = Now { whiskers: Vec::new(), pose: state.pose, is_blind: false };
        for (k, (whisker, mounted)) in self.whiskers.iter_mut().zip(&self.robot.whiskers).enumerate() {
            whisker.lift();
            let mut felt = None;
            for before in past.history.iter().copied().chain([Pose2::IDENTITY]) {
                felt = whisker.felt_at(state.pose.compose(before).compose(mounted.robot_from_whisker));
                self.taken += 1;
            }
            let explains = |felt: FeltMoment, z: f64| {
                let [low, high] = mounted.noise.readings(felt.moment);
                let lever = state.pose.compose(mounted.robot_from_whisker).position() - state.pose.position();
                let slack = EXPLAINED * deviation(&felt, lever, state) + SLACK * self.most[k];
                (low - slack..=high + slack).contains(&z)
            };
            let reading = past.readings.get(k).copied();
            now.is_blind |= felt.is_none_or(|felt| reading.is_some_and(|z| !explains(felt, z)));
            now.whiskers.push(whisker.followed());
        }
        now
    }

    pub(super) fn taken(&self) -> usize {
        self.taken
    }

    /// The motion for every state as far as all may go, from now on or after another.
    pub(super) fn roll(&mut self, motion: &Motion, after: Option<&Felt>) -> Rollout {
        let mut steps = motion.steps();
        let from = after.map_or(&self.now, |first| &first.ends);
        let begins =
            |now: &Now| Under { now: now.clone(), begin: now.pose, may_have_stopped: false, has_stopped: false };
        let mut under: Vec<Under> = from.iter().map(begins).collect();
        let (mut all, mut ends) = (Vec::new(), None);
        'steps: for step in &steps {
            if self.states.len() * self.whiskers.len() > self.left {
                return Rollout::Spent;
            }
            let mut now = Vec::with_capacity(under.len());
            for (state, own) in self.states.iter().zip(&mut under) {
                match self.step(state, own, step) {
                    Some(at) => now.push(at),
                    None => break 'steps,
                }
            }
            all.push(now);
            ends = Some(under.iter().map(|u| u.now.clone()).collect());
        }
        steps.truncate(all.len());
        ends.map_or(Rollout::Refused, |ends| Rollout::Felt(Felt { steps, at: all, ends }))
    }

    /// One state one step on; none where it must not go there.
    fn step(&mut self, state: &RemainingState, under: &mut Under, step: &Step) -> Option<At> {
        if under.has_stopped {
            return Some(At::Stopped);
        }
        let pose = under.begin.compose(step.pose);
        if !self.is_free(under.now.pose, pose, self.margin(state, step)) {
            return None;
        }
        under.now.pose = pose;
        if under.now.is_blind {
            return Some(At::Blind);
        }
        let mut bands = Vec::with_capacity(self.whiskers.len());
        let (mut may, mut must) = (false, false);
        for (k, (whisker, mounted)) in self.whiskers.iter_mut().zip(&self.robot.whiskers).enumerate() {
            let base = pose.compose(mounted.robot_from_whisker);
            whisker.go_on_from(under.now.whiskers[k]);
            let felt = whisker.felt_at(base);
            under.now.whiskers[k] = whisker.followed();
            (self.left, self.taken) = (self.left.saturating_sub(1), self.taken + 1);
            let Some(felt) = felt else {
                under.now.is_blind = true;
                return Some(At::Blind);
            };
            if felt.moment.abs() > self.most[k] {
                return None;
            }
            let slack = SIGMAS * deviation(&felt, base.position() - state.pose.position(), state);
            let [low, high] = mounted.noise.readings(felt.moment);
            let band = Band { low: low - slack, high: high + slack };
            may |= band.high >= self.stop_at[k] || band.low <= -self.stop_at[k];
            must |= low >= self.stop_at[k] || high <= -self.stop_at[k];
            bands.push(band);
        }
        under.may_have_stopped |= may;
        under.has_stopped = must;
        Some(if under.may_have_stopped { At::May(bands) } else { At::Runs(bands) })
    }

    /// How far the robot may be from where a state has it (m).
    fn margin(&self, state: &RemainingState, step: &Step) -> f64 {
        let c = &state.covariance;
        let place = (c[0][0] + c[1][1]).max(0.0).sqrt();
        let odometry = &self.robot.odometry;
        CLEAR
            + SIGMAS * (place + c[2][2].max(0.0).sqrt() * step.way)
            + odometry.translation_relative * step.way
            + odometry.rotation_relative * step.turn * step.way
    }

    /// Whether footprint and whisker bases come to no boundary between two poses; what is too near already may go away.
    fn is_free(&self, from: Pose2, to: Pose2, margin: f64) -> bool {
        let clear = |from: Vec2, to: Vec2, least: f64| {
            let off = |p: Vec2| self.map.nearest_within(p, least + margin).map(|near| near.distance);
            self.map.is_free(to)
                && !self.map.crosses(from, to)
                && off(to).is_none_or(|now| now > least && off(from).is_some_and(|before| before <= now))
        };
        let base = |p: Pose2, w: &MountedWhisker| p.compose(w.robot_from_whisker).position();
        clear(from.position(), to.position(), self.footprint)
            && self.robot.whiskers.iter().all(|w| clear(base(from, w), base(to, w), 0.0))
    }
}

/// Standard deviation of what a whisker feels (N m) by that of the state; `lever` is its base seen from the robot now, map frame.
fn deviation(felt: &FeltMoment, lever: Vec2, state: &RemainingState) -> f64 {
    let [gx, gy, gt] = felt.gradient;
    let g = [gx, gy, gt + gx * -lever.y + gy * lever.x];
    let c = &state.covariance;
    let variance: f64 = (0..3).map(|i| (0..3).map(|j| g[i] * c[i][j] * g[j]).sum::<f64>()).sum();
    variance.max(0.0).sqrt()
}
