//! The delay between readings and odometry, and how well it is told.

use crate::flow::pose::StampedPose;
use crate::plane::{Pose2, Twist2, wrap_angle};
use crate::{Error, Result};

/// Fewest readings.
const FEWEST: usize = 50;
/// What a radian counts for beside a metre of way (m): the length of a whisker.
const LEVER: f64 = 0.1;
/// Length of a window (s), and its fewest readings.
const WINDOW: f64 = 0.25;
const WINDOW_READINGS: usize = 10;
/// What a window costs beyond its misfit (nats) where no pose tells the way: that the motion is uniform there is a guess.
const UNKNOWN: f64 = 2.0;
/// How far the fine search may go (s) until windows lose their poses.
const NEAR: f64 = 2.0 * COARSE_STEP;
/// Parts of a recording of which each is left out once.
const PARTS: usize = 8;
/// Most readings in the coarse search, and its step (s).
const COARSE_READINGS: usize = 1500;
const COARSE_STEP: f64 = 0.02;
/// Standard deviation of a nominal rate's error, the largest, and most rates in the coarse search.
const USUAL_RATE_ERROR: f64 = 0.01;
const RATE_ERROR: f64 = 0.03;
const MOST_RATES: f64 = 41.0;
/// Finest steps: of the delay (s) and of the rate.
const FINEST: f64 = 2e-5;
/// Step of the differences that derivatives are made of (s).
const DIFFERENCE: f64 = 5e-3;
/// Another delay, farther away than this (s), is a rival when the logarithm of its likelihood is no farther below by so much.
const APART: f64 = 0.3;
const RIVAL: f64 = 6.0;

/// The delay with which poses explain readings best.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DelayEstimate {
    /// Odometry time of the first reading, less that of the first pose (s).
    pub delay: f64,
    /// Its standard deviation in the middle of the recording (s).
    pub delay_std: f64,
    /// Odometry seconds for each second of the readings' clock; 1 where that is not to be estimated.
    pub rate: f64,
    /// Its standard deviation.
    pub rate_std: f64,
    /// Whether another delay explains the readings about as well, one beyond the search may, or none does.
    pub rival: bool,
}

/// Estimates the delay of readings at the times `t` (s, from 0 on) behind odometry, up to `most` (s) on either side of recordings
/// that begin together; `free_rate` where their clock's rate is to be estimated, too.
///
/// The standard deviation is the larger one of the sandwich formula over windows and of the jackknife over eight parts of the
/// recording, with the uncertainty of a uniform distribution between two poses.
///
/// # Errors
///
/// Fewer than 50 readings, or none that changes.
pub fn estimate_delay(
    t: &[f64],
    columns: &[&[f64]],
    odometry: &[StampedPose],
    most: f64,
    free_rate: bool,
) -> Result<DelayEstimate> {
    if t.len() < FEWEST || odometry.len() < 2 {
        return Err(Error::data("too few readings or poses to estimate a delay")
            .value(format!("{} readings, {} poses", t.len(), odometry.len()))
            .allowed(format!("at least {FEWEST} and 2"))
            .remedy("give the delay (--delay)"));
    }
    let start = odometry[0].t;
    let poses: Vec<(f64, Pose2)> = odometry.iter().map(|pose| (pose.t - start, pose.map_from_robot)).collect();
    let thin = t.len().div_ceil(COARSE_READINGS).max(1);
    let coarse = Problem::new(t, columns, &poses, thin);
    let mut fine = Problem::new(t, columns, &poses, 1);
    if fine.scales.iter().all(|scale| *scale <= 0.0) {
        return Err(
            Error::data("the readings do not change").remedy("is the sensor connected? give the delay (--delay)")
        );
    }
    let half = 0.5 * (t[t.len() - 1] - t[0]);
    let rates: Vec<f64> = if free_rate {
        let count = (2.0 * RATE_ERROR * half / COARSE_STEP).ceil().clamp(2.0, MOST_RATES - 1.0);
        (0..=count as usize).map(|i| 1.0 + RATE_ERROR * (2.0 * i as f64 / count - 1.0)).collect()
    } else {
        vec![1.0]
    };
    let steps = (most / COARSE_STEP).ceil() as i64;
    // For each delay the best rate.
    let mut profile: Vec<(f64, f64, f64)> = Vec::new();
    for step in -steps..=steps {
        let delay = step as f64 * COARSE_STEP;
        let best = rates.iter().map(|&rate| (coarse.cost(delay, rate), rate)).min_by(|a, b| a.0.total_cmp(&b.0));
        profile.extend(best.map(|(cost, rate)| (cost, delay, rate)));
    }
    let Some(&(_, delay, rate)) = profile.iter().min_by(|a, b| a.0.total_cmp(&b.0)) else {
        return Err(Error::data("no delay to look for").value(most).allowed("above 0 s"));
    };
    // From here on the same windows count, so that the cost has no steps.
    fine.keep_covered(delay, rate);
    let (delay, rate) = refined(&fine, delay, rate, free_rate.then_some(half));
    // The coarse problem has fewer readings, so that its costs count for more.
    let here = coarse.cost(delay, rate);
    let at_end = delay.abs() > most - COARSE_STEP;
    // Poses of another time explain readings worse than no poses at all.
    let explained = fine.cost(delay, rate) < (0..fine.windows.len()).map(|w| fine.uniform_cost(w)).sum::<f64>();
    let rival = at_end
        || !explained
        || profile
            .iter()
            .any(|&(cost, other, _)| (other - delay).abs() > APART && (cost - here) * thin as f64 <= RIVAL);
    let (delay_std, rate_std) = fine.deviations(delay, rate, free_rate.then_some(half));
    let (by_parts, rate_by_parts) = jackknife(&fine, delay, rate, free_rate.then_some(half));
    let (delay_std, rate_std) =
        (delay_std.max(by_parts).hypot(spacing(odometry) / 12.0_f64.sqrt()), rate_std.max(rate_by_parts));
    // In the middle of the recording the delay is told best; the first reading lies half of it before.
    let first = delay + fine.middle - rate * (fine.middle - t[0]) - t[0];
    Ok(DelayEstimate { delay: first, delay_std, rate, rate_std, rival })
}

/// The usual time between poses (s): where between two poses the robot starts they do not tell.
fn spacing(odometry: &[StampedPose]) -> f64 {
    let mut steps: Vec<f64> = odometry.windows(2).map(|pair| pair[1].t - pair[0].t).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or_default()
}

/// Standard deviations of delay and rate by the jackknife over parts of the recording: what the windows' model gets wrong differs
/// from part to part \[efron1982jackknife\].
fn jackknife(problem: &Problem, delay: f64, rate: f64, half: Option<f64>) -> (f64, f64) {
    let windows = &problem.windows;
    let found: Vec<(f64, f64)> = (0..PARTS)
        .map(|part| {
            let kept = windows.iter().enumerate().filter(|(window, _)| window * PARTS / windows.len().max(1) != part);
            let rest = Problem { windows: kept.map(|(_, ends)| *ends).collect(), ..problem.clone() };
            refined(&rest, delay, rate, half)
        })
        .collect();
    let count = PARTS as f64;
    let std = |of: &dyn Fn(&(f64, f64)) -> f64| {
        let mean = found.iter().map(of).sum::<f64>() / count;
        ((count - 1.0) / count * found.iter().map(|one| (of(one) - mean).powi(2)).sum::<f64>()).sqrt()
    };
    (std(&|one| one.0), std(&|one| one.1))
}

/// Steps along either axis as long as they help, then half of them.
fn refined(problem: &Problem, delay: f64, rate: f64, half: Option<f64>) -> (f64, f64) {
    let (mut at, mut step) = ([delay, rate], COARSE_STEP);
    let mut cost = problem.cost(at[0], at[1]);
    while step > FINEST {
        let rate_step = half.map_or(0.0, |half| step / half.max(1.0));
        let tries = [[step, 0.0], [-step, 0.0], [0.0, rate_step], [0.0, -rate_step]];
        let count = if half.is_some() { 4 } else { 2 };
        let best = tries[..count]
            .iter()
            .map(|by| ([at[0] + by[0], at[1] + by[1]], problem.cost(at[0] + by[0], at[1] + by[1])))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        match best {
            Some((there, less)) if less < cost => (at, cost) = (there, less),
            _ => step *= 0.5,
        }
    }
    (at[0], at[1])
}

/// Readings in windows, and the poses that are to explain them.
#[derive(Clone)]
struct Problem<'a> {
    t: Vec<f64>,
    columns: Vec<Vec<f64>>,
    /// Noise of each column, from its second differences.
    scales: Vec<f64>,
    poses: &'a [(f64, Pose2)],
    /// First and last of each window.
    windows: Vec<(usize, usize)>,
    middle: f64,
}

impl<'a> Problem<'a> {
    fn new(t: &[f64], columns: &[&[f64]], poses: &'a [(f64, Pose2)], thin: usize) -> Self {
        let thinned = |values: &[f64]| values.iter().step_by(thin).copied().collect::<Vec<f64>>();
        let times = thinned(t);
        let mut windows = Vec::new();
        let mut first = 0;
        for index in 0..times.len() {
            let long = times[index] - times[first] >= WINDOW && index + 1 - first >= WINDOW_READINGS;
            if long || index + 1 == times.len() {
                if index + 1 - first >= WINDOW_READINGS {
                    windows.push((first, index + 1));
                }
                first = index + 1;
            }
        }
        Self {
            middle: 0.5 * (t[0] + t[t.len() - 1]),
            scales: columns.iter().map(|values| noise(values)).collect(),
            columns: columns.iter().map(|values| thinned(values)).collect(),
            t: times,
            poses,
            windows,
        }
    }

    /// Negative logarithm of the likelihood, and of what is known of rates; `delay` is that of the middle of the readings.
    fn cost(&self, delay: f64, rate: f64) -> f64 {
        let usual = (rate - 1.0) / USUAL_RATE_ERROR;
        0.5 * usual * usual + (0..self.windows.len()).map(|w| self.window_cost(w, delay, rate)).sum::<f64>()
    }

    fn window_cost(&self, window: usize, delay: f64, rate: f64) -> f64 {
        let (from, to) = self.windows[window];
        if !self.is_covered(window, delay, rate) {
            return UNKNOWN + self.uniform_cost(window);
        }
        let at = |index: usize| self.pose(self.time(index, delay, rate));
        let origin = at((from + to) / 2);
        let offsets: Vec<[f64; 3]> = (from..to)
            .map(|index| {
                let pose = origin.between(at(index));
                [pose.x, pose.y, LEVER * wrap_angle(pose.theta)]
            })
            .collect();
        let way = main_direction(&offsets);
        self.cost_on((from, to), offsets.iter().map(|offset| offset.iter().zip(way).map(|(a, b)| a * b).sum()))
    }

    /// What a window costs where the motion in it is taken for uniform.
    fn uniform_cost(&self, window: usize) -> f64 {
        let (from, to) = self.windows[window];
        self.cost_on((from, to), (from..to).map(|index| self.t[index] - self.t[(from + to) / 2]))
    }

    /// The odometry's time of a reading (s since its first pose).
    fn time(&self, index: usize, delay: f64, rate: f64) -> f64 {
        delay + self.middle + rate * (self.t[index] - self.middle)
    }

    /// Whether there are poses all along a window.
    fn is_covered(&self, window: usize, delay: f64, rate: f64) -> bool {
        let (from, to) = self.windows[window];
        let end = self.poses.last().map_or(0.0, |pose| pose.0);
        self.time(from, delay, rate) >= 0.0 && self.time(to - 1, delay, rate) <= end
    }

    /// Keeps the windows that have poses, also with a delay that is a little other.
    fn keep_covered(&mut self, delay: f64, rate: f64) {
        let is_kept = |window: &usize| [-NEAR, NEAR].iter().all(|by| self.is_covered(*window, delay + by, rate));
        self.windows = (0..self.windows.len()).filter(is_kept).map(|window| self.windows[window]).collect();
    }

    /// What a window costs whose readings are to be a smooth function of a way; where no pose tells the way, it is taken for uniform.
    fn cost_on(&self, (from, to): (usize, usize), way: impl Iterator<Item = f64>) -> f64 {
        let mut basis: [Vec<f64>; 3] = core::array::from_fn(|_| Vec::with_capacity(to - from));
        for along in way {
            let values = [1.0, along, along * along];
            basis.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        }
        orthonormalise(&mut basis);
        let count = (to - from) as f64;
        let of = |(values, scale): (&Vec<f64>, &f64)| {
            if *scale <= 0.0 {
                return 0.0;
            }
            let mut rest: Vec<f64> = values[from..to].to_vec();
            for column in &basis {
                let part: f64 = column.iter().zip(&rest).map(|(a, b)| a * b).sum();
                rest.iter_mut().zip(column).for_each(|(r, c)| *r -= part * c);
            }
            let square: f64 = rest.iter().map(|r| r * r).sum();
            0.5 * count * (square / (count * scale * scale) + 1.0).ln()
        };
        self.columns.iter().zip(&self.scales).map(of).sum()
    }

    /// The pose at a time; before the first and after the last one the robot stands.
    fn pose(&self, t: f64) -> Pose2 {
        let after = self.poses.partition_point(|pose| pose.0 < t);
        match (self.poses.get(after.wrapping_sub(1)), self.poses.get(after)) {
            (Some(&(before, from)), Some(&(next, to))) => {
                let share = (t - before) / (next - before);
                let step = from.between(to).log();
                from.compose(Pose2::exp(Twist2 { x: share * step.x, y: share * step.y, theta: share * step.theta }))
            }
            (Some(last), None) => last.1,
            (None, _) => self.poses[0].1,
        }
    }

    /// Standard deviations of delay and rate: curvature of the cost around its minimum, and the scatter of the windows' slopes.
    fn deviations(&self, delay: f64, rate: f64, half: Option<f64>) -> (f64, f64) {
        let steps = [DIFFERENCE, DIFFERENCE / half.unwrap_or(1.0).max(1.0)];
        let count = if half.is_some() { 2 } else { 1 };
        let (mut curvature, mut scatter) = ([[0.0; 2]; 2], [[0.0; 2]; 2]);
        for window in 0..self.windows.len() {
            let cost = |i: f64, k: f64| self.window_cost(window, delay + i * steps[0], rate + k * steps[1]);
            let here = cost(0.0, 0.0);
            let [right, left, up, down] = [cost(1.0, 0.0), cost(-1.0, 0.0), cost(0.0, 1.0), cost(0.0, -1.0)];
            let slope = [0.5 * (right - left), 0.5 * (up - down)];
            curvature[0][0] += right - 2.0 * here + left;
            curvature[1][1] += up - 2.0 * here + down;
            let mixed = 0.25 * (cost(1.0, 1.0) - cost(1.0, -1.0) - cost(-1.0, 1.0) + cost(-1.0, -1.0));
            curvature[0][1] += mixed;
            curvature[1][0] += mixed;
            for i in 0..2 {
                for k in 0..2 {
                    scatter[i][k] += slope[i] * slope[k];
                }
            }
        }
        if count == 1 {
            let std = if curvature[0][0] > 0.0 {
                (scatter[0][0].sqrt() / curvature[0][0]).max(1.0 / curvature[0][0].sqrt())
            } else {
                f64::INFINITY
            };
            return (std * steps[0], 0.0);
        }
        let [[a, b], [_, d]] = curvature;
        let d = d + (steps[1] / USUAL_RATE_ERROR).powi(2);
        let determinant = a * d - b * b;
        if !(a > 0.0 && determinant > 0.0) {
            return (f64::INFINITY, f64::INFINITY);
        }
        let inverse = [[d / determinant, -b / determinant], [-b / determinant, a / determinant]];
        let variance = |i: usize| -> f64 {
            let sandwich: f64 =
                (0..2).map(|k| (0..2).map(|m| inverse[i][k] * scatter[k][m] * inverse[i][m]).sum::<f64>()).sum();
            sandwich.max(inverse[i][i])
        };
        (variance(0).max(0.0).sqrt() * steps[0], variance(1).max(0.0).sqrt() * steps[1])
    }
}

/// Standard deviation of white noise on a smooth curve: from the median size of second differences.
fn noise(values: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = values.windows(3).map(|w| (w[2] - 2.0 * w[1] + w[0]).abs()).collect();
    if sizes.is_empty() {
        return 0.0;
    }
    sizes.sort_by(f64::total_cmp);
    let range = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| (lo.min(*v), hi.max(*v)));
    // Six is the variance of a second difference; what is coarsely rounded has differences of zero.
    (sizes[sizes.len() / 2] / (0.6745 * 6.0_f64.sqrt())).max(1e-4 * (range.1 - range.0))
}

/// The direction along which the robot moves most.
fn main_direction(offsets: &[[f64; 3]]) -> [f64; 3] {
    let mut spread = [[0.0; 3]; 3];
    for offset in offsets {
        for i in 0..3 {
            for k in 0..3 {
                spread[i][k] += offset[i] * offset[k];
            }
        }
    }
    // Power iteration: a robot moves along a line in a quarter of a second, so that it converges at once.
    let largest = (0..3).max_by(|&a, &b| spread[a][a].total_cmp(&spread[b][b])).unwrap_or(0);
    let mut way = spread[largest];
    for _ in 0..8 {
        let length = way.iter().map(|v| v * v).sum::<f64>().sqrt();
        if length <= 0.0 {
            return [0.0; 3];
        }
        let unit = way.map(|v| v / length);
        way = core::array::from_fn(|i| spread[i].iter().zip(unit).map(|(a, b)| a * b).sum());
    }
    let length = way.iter().map(|v| v * v).sum::<f64>().sqrt();
    if length > 0.0 { way.map(|v| v / length) } else { way }
}

/// Makes the columns orthogonal and of length 1; those that depend on others become zero.
fn orthonormalise(basis: &mut [Vec<f64>; 3]) {
    for k in 0..basis.len() {
        let (before, rest) = basis.split_at_mut(k);
        let column = &mut rest[0];
        let long: f64 = column.iter().map(|v| v * v).sum();
        for _ in 0..2 {
            for other in before.iter() {
                let part: f64 = other.iter().zip(column.iter()).map(|(a, b)| a * b).sum();
                column.iter_mut().zip(other).for_each(|(c, o)| *c -= part * o);
            }
        }
        let left: f64 = column.iter().map(|v| v * v).sum();
        // A nanometre of way is rounding.
        let scale = if left > 1e-10 * long && left > 1e-18 { 1.0 / left.sqrt() } else { 0.0 };
        column.iter_mut().for_each(|v| *v *= scale);
    }
}
