//! Where contact sets meet: every point and every shared piece.

use super::curve::LINKS;
use super::{Contact, ContactCurve, ContactModel, ContactSet, VirtualSensor};
use crate::linear_algebra::solve;
use crate::math;
use crate::plane::{Pose2, Vec2};

/// A shared stretch shorter than this many tolerances is a point.
const POINT_LENGTHS: f64 = 20.0;
/// Newton steps to a crossing.
const STEPS: usize = 12;
/// Largest relative difference of forces, and of arc lengths, of one and the same shape.
const SAME_SHAPE: f64 = 1e-6;

/// The contact curves of one whisker, and where its base sits in a common frame.
#[derive(Clone, Copy, Debug)]
pub struct PlacedSet<'a> {
    /// The curves.
    pub set: &'a ContactSet,
    /// The whisker's base in the common frame.
    pub frame_from_whisker: Pose2,
}

impl<'a> PlacedSet<'a> {
    /// Curves in their own whisker's frame.
    #[must_use]
    pub fn at_home(set: &'a ContactSet) -> Self {
        Self { set, frame_from_whisker: Pose2::IDENTITY }
    }
}

/// One component of the intersection of two contact sets.
#[derive(Clone, Debug, PartialEq)]
pub struct Meeting {
    /// The place, common frame (m): the crossing, or the middle of a shared stretch.
    pub position: Vec2,
    /// The stretch of the first curve within the tolerance of the second (m); ends coincide for a clean crossing.
    pub stretch: [Vec2; 2],
    /// The length of that stretch (m).
    pub extent: f64,
    /// Whether the smooth curves cross at `position`: then it is exact to rounding, else to the tolerance.
    pub is_crossing: bool,
    /// The contact on the first curve.
    pub first: Contact,
    /// The contact on the second curve.
    pub second: Contact,
}

impl Meeting {
    /// Whether both contacts are one shape of one whisker: what two sensors on it must agree on.
    #[must_use]
    pub fn is_one_shape(&self) -> bool {
        let near = |a: f64, b: f64| (a - b).abs() <= SAME_SHAPE * (a.abs() + b.abs()) + 1e-12;
        near(self.first.force, self.second.force) && near(self.first.s_a, self.second.s_a)
    }
}

/// All components of the intersection of two contact sets: in order along the first.
///
/// | curves | component |
/// | --- | --- |
/// | cross | a crossing, found on the smooth curves by Newton's method |
/// | touch, or end on each other | the stretch within the tolerance, its middle as the place |
/// | share a stretch, or are the same | that stretch |
/// | apart | none |
///
/// `tolerance` (m) is how close counts as meeting. Chords leave out what the sets' own tolerances say, so that the sum of both
/// is added: no meeting is lost to flattening. Two meetings closer along the curve than the tolerance blurs are one component.
#[must_use]
pub fn intersect(a: PlacedSet<'_>, b: PlacedSet<'_>, tolerance: f64) -> Vec<Meeting> {
    let reach = tolerance.max(0.0) + a.set.tolerance + b.set.tolerance + 1e-12;
    let first_from_second = a.frame_from_whisker.inverse().compose(b.frame_from_whisker);
    let mut found = Vec::new();
    for second in &b.set.curves {
        let (sin, cos) = math::sin_cos(first_from_second.theta);
        let shift = first_from_second.position();
        let moved: Vec<Vec2> = second
            .contacts()
            .iter()
            .map(|c| {
                shift + Vec2::new(cos * c.position.x - sin * c.position.y, sin * c.position.x + cos * c.position.y)
            })
            .collect();
        for first in &a.set.curves {
            let pair = CurvePair { first, second, moved: &moved, reach };
            found.extend(pair.stretches().into_iter().map(|stretch| pair.meeting(a, b, first_from_second, &stretch)));
        }
    }
    found
}

/// All components in which every one of several sets meets the first: those of the first two, kept where the others are
/// within their tolerances too.
#[must_use]
pub fn intersect_all(sets: &[PlacedSet<'_>], tolerance: f64) -> Vec<Meeting> {
    let [a, b, rest @ ..] = sets else { return Vec::new() };
    let near = |meeting: &Meeting| {
        rest.iter().all(|c| {
            let place = c.frame_from_whisker.inverse_transform_point(meeting.position);
            c.set.distance(place) <= tolerance + c.set.tolerance + meeting.extent + 1e-12
        })
    };
    intersect(*a, *b, tolerance).into_iter().filter(near).collect()
}

/// Two curves, the second seen from the first's frame.
struct CurvePair<'a> {
    first: &'a ContactCurve,
    second: &'a ContactCurve,
    moved: &'a [Vec2],
    reach: f64,
}

/// Parameters of the first curve (link and share) that are near the second, and the parameter there.
#[derive(Clone, Copy, Debug)]
struct NearRange {
    from: f64,
    to: f64,
    /// Where the chords are closest: their distance, and the parameters on both.
    best: (f64, f64, f64),
    /// Chords that cross on the way, at most.
    crossings: usize,
}

impl CurvePair<'_> {
    /// The stretches of the first curve within reach of the second.
    fn stretches(&self) -> Vec<NearRange> {
        let p: &[Contact] = self.first.contacts();
        let mut found: Vec<NearRange> = Vec::new();
        for (run_b, from_b) in (0..self.moved.len().saturating_sub(1)).step_by(LINKS).enumerate() {
            let to_b = (from_b + LINKS).min(self.moved.len() - 1);
            debug_assert!(run_b < self.second.runs.len());
            let around = crate::plane::Bounds::of(&self.moved[from_b..=to_b]);
            let grow = Vec2::new(self.reach, self.reach);
            let around = crate::plane::Bounds { min: around.min - grow, max: around.max + grow };
            for (run_a, bounds) in self.first.runs.iter().enumerate() {
                if !bounds.overlaps(around) {
                    continue;
                }
                let to_a = ((run_a + 1) * LINKS).min(p.len() - 1);
                for i in run_a * LINKS..to_a {
                    let link = [p[i].position, p[i + 1].position];
                    if !crate::plane::Bounds::of(&link).overlaps(around) {
                        continue;
                    }
                    for j in from_b..to_b {
                        found.extend(near(link, [self.moved[j], self.moved[j + 1]], self.reach).map(|n| NearRange {
                            from: i as f64 + n.from,
                            to: i as f64 + n.to,
                            best: (n.best.0, i as f64 + n.best.1, j as f64 + n.best.2),
                            crossings: n.crossings,
                        }));
                    }
                }
            }
        }
        merged(found)
    }

    fn meeting(&self, a: PlacedSet<'_>, b: PlacedSet<'_>, first_from_second: Pose2, stretch: &NearRange) -> Meeting {
        let on_first = |t: f64| between(self.first, t);
        let (from, to) = (on_first(stretch.from), on_first(stretch.to));
        let steps = (stretch.to.floor() - stretch.from.ceil()).max(0.0) as usize;
        let chain = core::iter::once(from.position)
            .chain(
                (0..=steps)
                    .map(|k| stretch.from.ceil() + k as f64)
                    .filter(|&t| t < stretch.to)
                    .map(|t| on_first(t).position),
            )
            .chain([to.position]);
        let chain: Vec<Vec2> = chain.collect();
        let extent: f64 = chain.windows(2).map(|w| w[0].distance(w[1])).sum();
        let (_, ta, tb) = stretch.best;
        let (first, second) = (on_first(ta), between(self.second, tb));
        let refined = (stretch.crossings == 1)
            .then(|| crossing(a.set, b.set, first_from_second, first, second))
            .flatten()
            .filter(|(c, _)| c.position.distance(first.position) <= extent + POINT_LENGTHS * self.reach);
        let is_crossing = refined.is_some();
        let (first, second) = refined.unwrap_or((first, second));
        let place = |p: Vec2| a.frame_from_whisker.transform_point(p);
        let clean = is_crossing && extent <= POINT_LENGTHS * self.reach;
        let stretch = if clean { [place(first.position); 2] } else { [place(from.position), place(to.position)] };
        let extent = if clean { 0.0 } else { extent };
        Meeting { position: place(first.position), stretch, extent, is_crossing, first, second }
    }
}

/// The contact a share of the way from one node to the next, linear.
fn between(curve: &ContactCurve, t: f64) -> Contact {
    let contacts = curve.contacts();
    let i = (t.max(0.0).floor() as usize).min(contacts.len().saturating_sub(2));
    let (a, b) = (contacts[i], contacts[(i + 1).min(contacts.len() - 1)]);
    let mix = |p: f64, q: f64| p + (t - i as f64) * (q - p);
    Contact {
        force: mix(a.force, b.force),
        s_a: mix(a.s_a, b.s_a),
        phi_a: mix(a.phi_a, b.phi_a),
        position: a.position + (b.position - a.position) * (t - i as f64),
        moment: mix(a.moment, b.moment),
        tilt: mix(a.tilt, b.tilt),
    }
}

/// The part of the link `ab` that is within `reach` of the link `cd`, as shares of `ab`; none when they are apart.
fn near([a, b]: [Vec2; 2], [c, d]: [Vec2; 2], reach: f64) -> Option<NearRange> {
    let (u, v) = (b - a, d - c);
    let (uu, vv) = (u.norm_squared(), v.norm_squared());
    let on = |p: Vec2, start: Vec2, along: Vec2, square: f64| {
        if square > 0.0 { ((p - start).dot(along) / square).clamp(0.0, 1.0) } else { 0.0 }
    };
    let mut candidates = [(0.0, 0.0); 5];
    candidates[0] = (on(c, a, u, uu), 0.0);
    candidates[1] = (on(d, a, u, uu), 1.0);
    candidates[2] = (0.0, on(a, c, v, vv));
    candidates[3] = (1.0, on(b, c, v, vv));
    let turn = u.cross(v);
    let mut count = 4;
    let mut crossings = 0;
    if turn.abs() > 0.0 {
        let (t, w) = ((c - a).cross(v) / turn, (c - a).cross(u) / turn);
        if (0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&w) {
            candidates[4] = (t, w);
            (count, crossings) = (5, 1);
        }
    }
    let gap = |(t, w): (f64, f64)| (a + u * t).distance(c + v * w);
    let best = candidates[..count].iter().map(|&(t, w)| (gap((t, w)), t, w)).min_by(|x, y| x.0.total_cmp(&y.0))?;
    if best.0 > reach {
        return None;
    }
    // The links' distance is convex along ab: bisect for both ends of the near part.
    let distance = |t: f64| {
        let p = a + u * t;
        p.distance(c + v * on(p, c, v, vv))
    };
    let end = |far: f64| {
        if distance(far) <= reach {
            return far;
        }
        let (mut good, mut bad) = (best.1, far);
        for _ in 0..12 {
            let middle = 0.5 * (good + bad);
            if distance(middle) <= reach { good = middle } else { bad = middle }
        }
        bad
    };
    Some(NearRange { from: end(0.0), to: end(1.0), best, crossings })
}

/// Stretches that touch are one.
fn merged(mut found: Vec<NearRange>) -> Vec<NearRange> {
    found.sort_by(|a, b| a.from.total_cmp(&b.from));
    let mut joined: Vec<NearRange> = Vec::new();
    for next in found {
        match joined.last_mut() {
            Some(last) if next.from <= last.to + 1e-9 => {
                last.to = last.to.max(next.to);
                // A crossing at a node shows in both links.
                let twice = next.crossings > 0 && last.crossings > 0 && (next.best.1 - last.best.1).abs() < 1e-6;
                last.crossings += if twice { 0 } else { next.crossings };
                if next.best.0 < last.best.0 {
                    last.best = next.best;
                }
            }
            _ => joined.push(next),
        }
    }
    joined
}

/// One set's unknowns near a crossing.
struct CrossingSide<'a> {
    model: &'a ContactModel,
    sensor: VirtualSensor,
    value: f64,
}

impl CrossingSide<'_> {
    /// Place, and excess of the reading in its own scale, with the derivatives of all three by log-like load and arc length.
    fn linear(&self, u: f64, s: f64, scale: f64) -> Option<([f64; 3], [[f64; 3]; 2])> {
        let at = |u: f64, s: f64| {
            let c = self.model.contact(self.model.force_of(u, s), s)?;
            Some([c.position.x, c.position.y, (self.sensor.read(&c) - self.value) / scale])
        };
        let here = at(u, s)?;
        let (mut du, mut ds) = (1e-6 * u.abs().max(1e-3), 1e-6 * s);
        // One-sided steps away from the ends of whisker and first mode.
        if u > 0.0 {
            du = -du
        }
        ds = -ds;
        let (by_u, by_s) = (at(u + du, s)?, at(u, s + ds)?);
        let rate = |there: [f64; 3], step: f64| [0, 1, 2].map(|i| (there[i] - here[i]) / step);
        Some((here, [rate(by_u, du), rate(by_s, ds)]))
    }
}

/// The crossing of two smooth curves next to two contacts; `None` when Newton's method finds none.
fn crossing(
    a: &ContactSet,
    b: &ContactSet,
    a_from_b: Pose2,
    first: Contact,
    second: Contact,
) -> Option<(Contact, Contact)> {
    let sides = [a, b].map(|set| CrossingSide { model: set.model(), sensor: set.sensor, value: set.value });
    let starts = [first, second];
    let mut x = [0.0; 4];
    for k in 0..2 {
        x[2 * k] = sides[k].model.load_number(starts[k].force, starts[k].s_a);
        x[2 * k + 1] = starts[k].s_a;
    }
    let length = a.model().length();
    let scales = [0, 1].map(|k| sides[k].value.abs().max(1e-9));
    let (sin, cos) = math::sin_cos(a_from_b.theta);
    let turned = |v: [f64; 3]| [cos * v[0] - sin * v[1], sin * v[0] + cos * v[1], v[2]];
    for step in 0..STEPS {
        let (p, by_p) = sides[0].linear(x[0], x[1], scales[0])?;
        let (q, by_q) = sides[1].linear(x[2], x[3], scales[1])?;
        let q = turned(q);
        let (dx, dy) = (p[0] - q[0] - a_from_b.x, p[1] - q[1] - a_from_b.y);
        let residual = [dx / length, dy / length, p[2], q[2]];
        let size = residual.iter().fold(0.0f64, |m, r| m.max(r.abs()));
        if size <= 1e-13 || (step == STEPS - 1 && size <= 1e-10) {
            break;
        }
        if step == STEPS - 1 {
            return None;
        }
        let [qu, qs] = by_q.map(turned);
        let [pu, ps] = by_p;
        let matrix = [
            [pu[0] / length, ps[0] / length, -qu[0] / length, -qs[0] / length],
            [pu[1] / length, ps[1] / length, -qu[1] / length, -qs[1] / length],
            [pu[2], ps[2], 0.0, 0.0],
            [0.0, 0.0, qu[2], qs[2]],
        ];
        let delta = solve(&matrix, &residual)?;
        for i in 0..4 {
            x[i] -= delta[i];
        }
    }
    let end = |k: usize| {
        let model = sides[k].model;
        let s = x[2 * k + 1].min(model.length());
        let tip = x[2 * k + 1] <= model.length() * (1.0 + 1e-9) && x[2 * k + 1] >= 0.999 * model.first_arc_length();
        let contact = model.contact(model.force_of(x[2 * k], s), s)?;
        (tip && model.limits().admit(&contact)).then_some(contact)
    };
    Some((end(0)?, end(1)?))
}
