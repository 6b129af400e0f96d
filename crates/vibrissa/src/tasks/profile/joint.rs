//! What the end of one felt line and the start of another have to do with each other: one wall, a corner, or a stretch that nobody felt.
//!
//! An end goes on as the straight line through as long a stretch before it as is straight within its errors.

use super::assembly::{FeltLine, FeltPoint, FoundCorner};
use crate::config::MapAssemblyOptions;
use crate::plane::Vec2;
use crate::world::Band;

/// What joins the end of a line and the start of another.
#[derive(Clone, Copy, Debug)]
pub(super) enum Joint {
    Corner(FoundCorner),
    Unknown(f64),
    /// So near that they are one line.
    Touching,
}

/// How the end of a line and the start of another belong together, if they do, and how far apart they are (m).
pub(super) fn joint(from: &Ends, to: &Ends, is_same: bool, options: &MapAssemblyOptions) -> Option<(f64, Joint)> {
    let (end, start) = (from.end.as_ref()?, to.start.as_ref()?);
    let gap = end.tip.distance(start.tip);
    if gap > options.largest_gap || (is_same && from.length < 3.0 * gap) {
        return None;
    }
    if let Some(corner) = corner(end, start, options) {
        return Some((gap, Joint::Corner(corner)));
    }
    let step = start.tip - end.tip;
    if (gap <= options.touching && end.ahead.dot(start.ahead) < 0.0) || is_one_wall(end, start, options) {
        return Some((gap, Joint::Touching));
    }
    // What lies behind the end, or runs the other way beside it, is another wall's.
    let goes_on = step.dot(end.ahead) > -0.5 * gap && step.dot(start.ahead) < 0.5 * gap;
    goes_on.then_some((gap, Joint::Unknown(gap)))
}

/// Whether two ends are of one straight wall of which a part was not felt that is no longer than what was.
fn is_one_wall(end: &EndLine, start: &EndLine, options: &MapAssemblyOptions) -> bool {
    let step = start.tip - end.tip;
    let way = step.dot(end.ahead);
    let turns = end.ahead.cross(start.ahead).abs() > options.sharpest_flat.sin() || end.ahead.dot(start.ahead) > 0.0;
    let open = end.beyond(way).bound + start.beyond(way).bound;
    end.is_straight
        && start.is_straight
        && !turns
        && way <= end.base.min(start.base)
        && way >= 0.0
        && end.ahead.cross(step).abs() <= open
        && start.ahead.cross(step).abs() <= open
}

/// How a line starts and ends, and its length (m); a closed one does neither.
pub(super) struct Ends {
    start: Option<EndLine>,
    end: Option<EndLine>,
    length: f64,
}

impl Ends {
    pub(super) fn of(line: &FeltLine, options: &MapAssemblyOptions) -> Self {
        let end = |at_end| if line.closed { None } else { EndLine::of(line, at_end, options) };
        Self { start: end(false), end: end(true), length: length(line) }
    }
}

/// The end of a line: its last point, the direction in which it goes on beyond that, and how well that is known.
struct EndLine {
    tip: Vec2,
    ahead: Vec2,
    band: Band,
    /// Length over which it is straight (m).
    base: f64,
    /// Whether it is straight within its band at all.
    is_straight: bool,
}

impl EndLine {
    /// Of the line's end or start, over as long a stretch as is straight; none of lines that are too short to have a direction.
    fn of(line: &FeltLine, at_end: bool, options: &MapAssemblyOptions) -> Option<Self> {
        let count = line.points.len();
        let from_tip = |k: usize| &line.points[if at_end { count - 1 - k } else { k }];
        let tip = from_tip(0).position;
        let within =
            |reach: f64| (0..count).take_while(|&k| from_tip(k).position.distance(tip) <= reach).count().max(2);
        let mut best = StraightFit::of((0..within(options.corner_fit).min(count)).map(from_tip))?;
        let is_fit = |fit: &StraightFit| {
            let within = |stds: f64| options.straight.max(stds * fit.band.std);
            fit.rms <= within(RMS_OF_STRAIGHT) && fit.worst <= within(WORST_OF_STRAIGHT)
        };
        let is_straight = is_fit(&best) && best.length >= 0.5 * options.corner_fit;
        let mut reach = options.corner_fit;
        while is_straight && within(reach) < count {
            reach *= LONGER;
            let Some(next) = StraightFit::of((0..within(reach).min(count)).map(from_tip)) else { break };
            if !is_fit(&next) {
                break;
            }
            best = next;
        }
        let StraightFit { middle, along, band, length: base, .. } = best;
        let ahead = if along.dot(tip - middle) >= 0.0 { along } else { along * -1.0 };
        Some(Self { tip: middle + ahead * ahead.dot(tip - middle), ahead, band, base: base.max(1e-6), is_straight })
    }

    /// What is not known of the line a way beyond its end (m).
    fn beyond(&self, way: f64) -> Band {
        // The ends of the stretch from which the direction is known may be off in opposite ways.
        let lever = 1.0 + 2.0 * way.max(0.0) / self.base;
        Band { std: self.band.std * lever, bound: self.band.bound * lever }
    }
}

/// A straight line through felt points.
struct StraightFit {
    middle: Vec2,
    along: Vec2,
    band: Band,
    length: f64,
    /// Root of the mean square of the points' distances from it, and the largest (m).
    rms: f64,
    worst: f64,
}

impl StraightFit {
    fn of<'a>(points: impl Iterator<Item = &'a FeltPoint>) -> Option<Self> {
        let points: Vec<&FeltPoint> = points.collect();
        let places: Vec<Vec2> = points.iter().map(|point| point.position).collect();
        let (middle, along) = direction(&places)?;
        let off = |p: &Vec2| along.cross(*p - middle);
        let worst = places.iter().map(|p| off(p).abs()).fold(0.0, f64::max);
        let rms = (places.iter().map(|p| off(p) * off(p)).sum::<f64>() / places.len() as f64).sqrt();
        let band = points.iter().fold(Band::default(), |all, point| widest(all, point.band));
        Some(Self { middle, along, band, length: places[0].distance(places[places.len() - 1]), rms, worst })
    }
}

/// How far points may lie from a straight wall, root mean square and at most, in standard deviations told, and by what the stretch that
/// may be one grows.
const RMS_OF_STRAIGHT: f64 = 1.5;
const WORST_OF_STRAIGHT: f64 = 8.0;
const LONGER: f64 = 1.3;

/// The middle of some points and the direction of the line through them.
fn direction(points: &[Vec2]) -> Option<(Vec2, Vec2)> {
    let count = points.len() as f64;
    let middle = points.iter().fold(Vec2::ZERO, |sum, p| sum + *p) * (1.0 / count.max(1.0));
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for d in points.iter().map(|p| *p - middle) {
        (xx, xy, yy) = (xx + d.x * d.x, xy + d.x * d.y, yy + d.y * d.y);
    }
    (xx + yy > 0.0).then(|| (middle, Vec2::from_angle(0.5 * (2.0 * xy).atan2(xx - yy))))
}

/// Where two straight ends meet ahead of both.
fn corner(end: &EndLine, start: &EndLine, options: &MapAssemblyOptions) -> Option<FoundCorner> {
    let cross = end.ahead.cross(start.ahead);
    if !end.is_straight || !start.is_straight || cross.abs() < options.sharpest_flat.sin() {
        return None;
    }
    let between = start.tip - end.tip;
    let (out, back) = (between.cross(start.ahead) / cross, between.cross(end.ahead) / cross);
    // No farther ahead than it was felt to be straight.
    let reach = |way: f64, base: f64| way >= -options.overshoot && way <= options.corner_reach.min(base);
    if !reach(out, end.base) || !reach(back, start.base) {
        return None;
    }
    let (a, b) = (end.beyond(out.max(0.0)), start.beyond(back.max(0.0)));
    // Both lines move the corner, each along the other.
    let per = 1.0 / cross.abs();
    let band = Band { std: per * a.std.hypot(b.std), bound: per * (a.bound + b.bound) };
    (band.bound <= options.widest_corner).then_some(FoundCorner { position: end.tip + end.ahead * out, band })
}

fn length(line: &FeltLine) -> f64 {
    line.points.windows(2).map(|pair| pair[0].position.distance(pair[1].position)).sum()
}

pub(super) fn widest(a: Band, b: Band) -> Band {
    Band { std: a.std.max(b.std), bound: a.bound.max(b.bound) }
}
