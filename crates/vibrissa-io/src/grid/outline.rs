//! Few straight lines through the many points of a loop. Lengths are in cells.

use super::trace::Crossing;
use crate::config::GridOptions;
use crate::math;
use crate::plane::Vec2;

/// Longest piece of a loop that is split as one: the time of splitting grows with its square at worst.
const PIECE: usize = 4096;
/// A line this long is a wall (cells): it knows its direction better than its ends know their place.
const WALL: f64 = 4.0;
/// The points of a wall this near to its ends may belong to the corner (cells).
const END: f64 = 2.0;
/// Longest way between two walls that is taken for a corner cut off by the cells,
const CUT: f64 = 8.0;
/// and how far from this way the corner may be.
const CORNER: f64 = 1.2;
/// How far the corner between two lines that follow each other may be from where they were split (cells).
const VERTEX: f64 = 0.9;
/// How many times longer than this way both walls are, and least turn between them (rad): others are pieces of a curve.
const LONGER: f64 = 1.5;
const SHARP: f64 = 0.35;
/// How much better a line must fit without its ends for these to be left out, where it is short.
const BETTER: f64 = 0.3;
/// How far one line may miss the crests of the stairs of a slanting wall (cells).
const JOINT: f64 = 0.75;
/// Least turn between lines that meet (rad): nearly parallel ones meet anywhere.
const LEAST_TURN: f64 = 0.15;

/// A line through some of a loop's points.
#[derive(Clone, Copy, Debug)]
struct Fitted {
    /// Its ends among the points.
    from: Vec2,
    to: Vec2,
    /// A point and the direction of the line that misses the points least.
    middle: Vec2,
    along: Vec2,
}

/// The corners of a closed chain of lines through the crossings of a loop.
pub(super) fn fit(crossings: &[Crossing], options: &GridOptions) -> Vec<Vec2> {
    let grey = crossings.iter().filter(|c| c.is_grey).count() * 5 >= crossings.len();
    let points: Vec<Vec2> = if grey {
        crossings.iter().filter(|c| c.is_across).map(|c| c.fine).collect()
    } else {
        crossings.iter().map(|c| c.side).collect()
    };
    if points.len() < 4 {
        return points;
    }
    let (tolerance, joint) =
        if grey { (options.grey_tolerance, options.grey_tolerance) } else { (options.sharp_tolerance, JOINT) };
    let points = from_extreme(points);
    let marks = joined(&points, split(&points, tolerance), joint);
    let lines: Vec<Fitted> = marks.windows(2).map(|w| Fitted::through(&points[w[0]..=w[1]])).collect();
    corners(&without_cuts(lines))
}

/// The marks without those between which one line fits all points to `tolerance` as well.
fn joined(points: &[Vec2], marks: Vec<usize>, tolerance: f64) -> Vec<usize> {
    let mut kept = vec![marks[0]];
    let mut from = marks[0];
    for w in marks.windows(2).skip(1) {
        let both = &points[from..=w[1]];
        let fits = both.len() <= PIECE && {
            let line = Fitted::best(both);
            both.iter().all(|p| line.misses(*p) <= tolerance)
        };
        if !fits {
            kept.push(w[0]);
            from = w[0];
        }
    }
    kept.extend(marks.last());
    kept
}

/// The same closed chain, begun at the point farthest from its middle and ended there: surely at a corner.
fn from_extreme(mut points: Vec<Vec2>) -> Vec<Vec2> {
    let middle = points.iter().fold(Vec2::ZERO, |sum, p| sum + *p) * (1.0 / points.len() as f64);
    let far = (0..points.len()).max_by(|&a, &b| points[a].distance(middle).total_cmp(&points[b].distance(middle)));
    points.rotate_left(far.unwrap_or(0));
    points.push(points[0]);
    points
}

/// The indices at which a closed chain bends, first and last included: between them no point is further than `tolerance`
/// from the straight way [Ramer, Douglas, Peucker].
fn split(points: &[Vec2], tolerance: f64) -> Vec<usize> {
    let last = points.len() - 1;
    let far = (1..last).max_by(|&a, &b| points[a].distance(points[0]).total_cmp(&points[b].distance(points[0])));
    let mut marks = vec![0, far.unwrap_or(1), last];
    marks.extend((0..last).step_by(PIECE));
    marks.sort_unstable();
    marks.dedup();
    let mut open: Vec<(usize, usize)> = marks.windows(2).map(|w| (w[0], w[1])).collect();
    while let Some((a, b)) = open.pop() {
        let worst = (a + 1..b)
            .map(|i| (distance(points[i], points[a], points[b]), i))
            .max_by(|one, other| one.0.total_cmp(&other.0));
        if let Some((_, at)) = worst.filter(|(miss, _)| *miss > tolerance) {
            marks.push(at);
            open.extend([(a, at), (at, b)]);
        }
    }
    marks.sort_unstable();
    marks
}

/// The distance of a point from the segment between two others.
fn distance(p: Vec2, a: Vec2, b: Vec2) -> f64 {
    let way = b - a;
    let length = way.norm_squared();
    let share = if length > 0.0 { ((p - a).dot(way) / length).clamp(0.0, 1.0) } else { 0.0 };
    p.distance(a + way * share)
}

impl Fitted {
    /// The line through a wall's points away from its ends; for short lines through all of them, unless those at the ends
    /// plainly belong to something else.
    fn through(points: &[Vec2]) -> Self {
        let (from, to) = (points[0], points[points.len() - 1]);
        let all = Self::best(points);
        let inner: Vec<Vec2> =
            points.iter().filter(|p| p.distance(from) >= END && p.distance(to) >= END).copied().collect();
        if inner.len() > 2 && inner.len() * 2 >= points.len() {
            return Self { from, to, ..Self::best(&inner) };
        }
        let worst = |line: &Self, points: &[Vec2]| points.iter().map(|p| line.misses(*p)).fold(0.0, f64::max);
        match points {
            [_, inner @ .., _] if inner.len() > 1 => {
                let core = Self { from, to, ..Self::best(inner) };
                if worst(&core, inner) < BETTER * worst(&all, points) { core } else { all }
            }
            _ => all,
        }
    }

    /// The line with the least squares of distances.
    fn best(points: &[Vec2]) -> Self {
        let (from, to) = (points[0], points[points.len() - 1]);
        let middle = points.iter().fold(Vec2::ZERO, |sum, p| sum + *p) * (1.0 / points.len() as f64);
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for p in points {
            let d = *p - middle;
            (xx, xy, yy) = (xx + d.x * d.x, xy + d.x * d.y, yy + d.y * d.y);
        }
        let along = Vec2::from_angle(0.5 * math::atan2(2.0 * xy, xx - yy));
        Self { from, to, middle, along: if along.dot(to - from) < 0.0 { -along } else { along } }
    }

    fn misses(&self, p: Vec2) -> f64 {
        self.along.cross(p - self.middle).abs()
    }

    fn length(&self) -> f64 {
        self.from.distance(self.to)
    }

    /// Where two lines meet; none where they are nearly parallel.
    fn meets(&self, other: &Self) -> Option<Vec2> {
        let sine = self.along.cross(other.along);
        (sine.abs() >= math::sin(LEAST_TURN)).then(|| {
            let share = (other.middle - self.middle).cross(other.along) / sine;
            self.middle + self.along * share
        })
    }

    fn nearest(&self, p: Vec2) -> Vec2 {
        self.middle + self.along * (p - self.middle).dot(self.along)
    }
}

/// Leaves out what lies between two walls whose corner the cells cut off.
fn without_cuts(mut lines: Vec<Fitted>) -> Vec<Fitted> {
    let walls: Vec<usize> = (0..lines.len()).filter(|&i| lines[i].length() >= WALL).collect();
    let count = lines.len();
    let mut keep = vec![true; count];
    for (index, &wall) in walls.iter().enumerate() {
        let next = walls[(index + 1) % walls.len()];
        let between: Vec<usize> = (1..count).map(|k| (wall + k) % count).take_while(|&k| k != next).collect();
        let way: f64 = between.iter().map(|&k| lines[k].length()).sum();
        let shorter = lines[wall].length().min(lines[next].length());
        if between.is_empty() || way > CUT || shorter < LONGER * way || wall == next {
            continue;
        }
        let (one, other) = (lines[wall], lines[next]);
        let is_sharp = math::atan2(one.along.cross(other.along), one.along.dot(other.along)).abs() >= SHARP;
        let near = |corner: &Vec2| between.iter().any(|&k| distance(*corner, lines[k].from, lines[k].to) <= CORNER);
        if let Some(corner) = one.meets(&other).filter(|corner| is_sharp && near(corner)) {
            between.iter().for_each(|&k| keep[k] = false);
            (lines[wall].to, lines[next].from) = (corner, corner);
        }
    }
    lines.into_iter().zip(keep).filter(|(_, keep)| *keep).map(|(line, _)| line).collect()
}

/// The corners between lines that follow each other.
fn corners(lines: &[Fitted]) -> Vec<Vec2> {
    let corner = |i: usize| {
        let (one, next) = (&lines[i], &lines[(i + 1) % lines.len()]);
        match one.meets(next).filter(|p| distance(*p, one.to, next.from) <= VERTEX) {
            Some(p) => p,
            None => (one.nearest(one.to) + next.nearest(next.from)) * 0.5,
        }
    };
    (0..lines.len()).map(corner).collect()
}
