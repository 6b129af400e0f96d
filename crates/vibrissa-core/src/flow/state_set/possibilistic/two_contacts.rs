//! Where a whisker may touch in two places at once, which the contractor of single contacts \[chabert2009contractor\] must leave
//! alone.
//!
//! Of several contacts the one nearest to the base, `A`, is a side contact: the whisker is tangent to the boundary there,
//! which pushes it to its left, say. Let `C` be another contact, farther along the whisker.
//!
//! * No whisker is longer than it is: `|A - base| + |C - A| <= length`.
//! * What is beyond `A` bends the whisker at `A` to the left, too, or to the right. To the left: `C` lies on the free side of
//!   the boundary at `A`, and `A` on that at `C`; convex obstacles and straight walls alone never do this. To the right: the
//!   force at `C` pushes to the right of `A`.
//! * As long as the forces beyond push to the left of the heading, too, the curvature falls from the base to `A`
//!   (`EI k' = -n · R` for the force `R` beyond). So the slope at `A` is at most `k(base) length`, and `A` is seen from the base at
//!   an angle of half that slope at least, and of two thirds at most.
//! * Where one of them pushes to the right of the heading, head-on or beyond that, the curvature is still a concave function of
//!   the arc length where no force pulls (`EI k'' = k t · R`, `t · R <= 0`): the angle is `(slope + k(base) |A| / 2) / 3` at least.
//! * Where the whisker bends to the right at its base and to the left at `A`, the forces beyond `A` turn about base and `A` in
//!   opposite senses: one of them points from `C` between the two.

use super::contractor::{BaseView, size};
use super::record::ReadingContacts;
use super::thick_piece::{PieceIndex, ThickPiece};
use crate::config::two_contacts::{
    ANGLE_SHARE, LONGEST_STRETCH, LOWEST_CORNER, RELAXED_SHARE, SMOOTH, STRAIGHT, SWEPT_BACK, UPPER_SHARE,
};
use crate::math;
use crate::plane::{Bounds, SegmentTree, Vec2, wrap_angle};
use core::f64::consts::{FRAC_PI_2, PI};

/// A short stretch of boundary: all points within `spread` of the segment, all normals within `slack` of one.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    ends: [Vec2; 2],
    point: Vec2,
    spread: f64,
    normal: f64,
    slack: f64,
    /// How far it may leave the line between its ends (m).
    sagitta: f64,
    /// Whether a side can touch it: not where it is nothing but a concave corner.
    takes_sides: bool,
    /// Whether it is straight: what is beyond it cannot push the whisker into it.
    is_straight: bool,
    /// Whether it may be anything: two places as well as one.
    is_unknown: bool,
}

/// A stretch on which the first of two contacts can be, and what the others can be, with a push to the left and to the right.
#[derive(Clone, Copy, Debug)]
struct FirstContact {
    stretch: Stretch,
    partners: [Partners; 2],
    /// From and to before, among the pairs.
    pairs: (u32, u32),
}

/// What can be touched beyond a first contact.
#[derive(Clone, Copy, Debug)]
struct Partner {
    index: u32,
    /// No more than the distance between the two (m).
    gap: f32,
    /// Whether it can bend the whisker on, and back, with a push of the first to the left and to the right.
    on: [bool; 2],
    back: [bool; 2],
}

/// What whiskers can touch beyond a first contact.
#[derive(Clone, Copy, Debug, Default)]
struct Partners {
    /// Whether something can bend the whisker back.
    bend_back: bool,
    /// The normals of what can bend it on: the middle and half of their range (rad).
    bend_on: Option<(f64, f64)>,
}

/// Stretches of boundary, and those of them that a whisker can touch while it touches another.
#[derive(Clone, Debug)]
pub(super) struct TwoContacts {
    all: Vec<Stretch>,
    tree: SegmentTree,
    first: Vec<FirstContact>,
    first_tree: SegmentTree,
    pairs: Vec<Partner>,
    /// Largest extent of a stretch beside its ends (m).
    margin: f64,
}

/// What a whisker feels, mirrored so that the boundary at the first contact pushes it to its left.
struct Felt<'a> {
    view: &'a BaseView,
    length: f64,
    friction: f64,
    /// Least and largest curvature at the base (1/m).
    bent: (f64, f64),
    side: f64,
    /// How far base and heading may be from the view's middle.
    off: f64,
    turn: f64,
}

/// To the left and to the right.
const SIDES: [f64; 2] = [1.0, -1.0];

impl TwoContacts {
    /// The stretches of a map's pieces for whiskers no longer than this (m), and forces that lean so far from normals (rad).
    pub(super) fn new(pieces: &PieceIndex, length: f64, friction: f64) -> Self {
        let all: Vec<Stretch> = pieces.all.iter().flat_map(stretches).collect();
        let (tree, margin) = (tree(all.iter()), all.iter().map(|one| one.sagitta).fold(0.0, f64::max));
        let (first, first_tree, pairs) = (Vec::new(), SegmentTree::default(), Vec::new());
        let mut whole = Self { all, tree, first, first_tree, pairs, margin };
        for index in 0..whole.all.len() {
            whole.add_first(index, length, friction);
        }
        whole.first_tree = self::tree(whole.first.iter().map(|first| &first.stretch));
        whole
    }

    /// Whether a state of any cell can have two contacts.
    pub(super) fn is_possible(&self) -> bool {
        !self.first.is_empty()
    }

    /// The rectangles around all places where the first of two contacts can be.
    pub(super) fn places(&self) -> impl Iterator<Item = Bounds> {
        self.first.iter().map(|first| first.stretch.bounds())
    }

    /// Adds a stretch with what the whisker can touch together with its side contact there, wherever its base is.
    fn add_first(&mut self, index: usize, length: f64, friction: f64) {
        let stretch = self.all[index];
        if !stretch.takes_sides {
            return;
        }
        let (mut partners, mut pairs) = ([Partners::default(); 2], Vec::new());
        let bounds = stretch.bounds().inflated(length + self.margin);
        self.tree.for_each_in(bounds, |index, _| {
            let other = &self.all[index];
            let pair = SIDES.map(|side| Pair::new(&stretch, other, friction, side));
            let gap = pair[0].gap;
            if gap <= length && is_another_place(&stretch, other) {
                let (on, back) = (pair.each_ref().map(Pair::bends_on), pair.each_ref().map(Pair::bends_back));
                for (side, partners) in partners.iter_mut().enumerate() {
                    partners.bend_back |= back[side];
                    if on[side] {
                        partners.add(other.normal, other.slack);
                    }
                }
                if on.iter().chain(&back).any(|&can| can) {
                    // A little less, as the shorter number is rounded.
                    let gap = (gap * (1.0 - 1e-6)) as f32;
                    pairs.push(Partner { index: index as u32, gap, on, back });
                }
            }
            false
        });
        if !pairs.is_empty() {
            let from = self.pairs.len() as u32;
            self.pairs.append(&mut pairs);
            self.first.push(FirstContact { stretch, partners, pairs: (from, self.pairs.len() as u32) });
        }
    }

    /// Whether nothing tells that the whisker has one contact in every state of the cell but that corners are out of reach; of
    /// whiskers that are curved at rest even that tells nothing.
    pub(super) fn may_be_near(&self, view: &BaseView, touch: &ReadingContacts) -> bool {
        !touch.rest.is_straight || self.is_near(view, touch.length)
    }

    /// Whether the first of two contacts is within reach in some state of the cell.
    pub(super) fn is_near(&self, view: &BaseView, length: f64) -> bool {
        let mut found = false;
        self.first_tree.for_each_in(self.around(view, length), |_, _| {
            found = true;
            true
        });
        found
    }

    fn around(&self, view: &BaseView, length: f64) -> Bounds {
        let reach = view.reach + Vec2::new(1.0, 1.0) * (length + self.margin);
        Bounds { min: view.base - reach, max: view.base + reach }
    }

    /// Whether a whisker may read this with more than one contact in some state of the cell; looks are counted.
    pub(super) fn may_explain(&self, view: &BaseView, touch: &ReadingContacts, comparisons: &mut usize) -> bool {
        if !touch.is_uniform {
            return self.may_be_near(view, touch);
        }
        if self.first.is_empty() {
            return false;
        }
        let (off, around) = (size(view.reach), self.around(view, touch.length));
        let felt = SIDES.map(|side| Felt {
            view,
            length: touch.length,
            friction: touch.friction_angle,
            bent: if side > 0.0 { touch.curvature } else { (-touch.curvature.1, -touch.curvature.0) },
            side,
            off,
            turn: view.turn + view.slop_turn,
        });
        let mut found = false;
        self.first_tree.for_each_in(around, |index, _| {
            let first = &self.first[index];
            *comparisons += 1;
            found = (0..2).any(|side| self.may_touch_first(&felt[side], first, side, comparisons));
            found
        });
        found
    }

    /// Whether `first` may be the contact nearest to the base, with another beyond it.
    fn may_touch_first(&self, felt: &Felt, first: &FirstContact, side: usize, comparisons: &mut usize) -> bool {
        let (stretch, partners) = (&first.stretch, &first.partners[side]);
        let Some(seen) = Seen::new(felt, stretch) else { return false };
        let on = partners.bend_on.is_some_and(|(normal, slack)| seen.relaxes || felt.pushes_back(&seen, normal, slack));
        if !on && !partners.bend_back {
            return false;
        }
        let rest = (felt.length - seen.nearest).max(0.0);
        self.pairs[first.pairs.0 as usize..first.pairs.1 as usize].iter().any(|partner| {
            *comparisons += 1;
            let other = &self.all[partner.index as usize];
            f64::from(partner.gap) <= rest
                && ((on && partner.on[side] && felt.bends_on(&seen, stretch, other)) || partner.back[side])
        })
    }
}

impl Partners {
    /// Adds the normals within `slack` of one (rad).
    fn add(&mut self, normal: f64, slack: f64) {
        let (middle, half) = *self.bend_on.get_or_insert((normal, slack));
        let turn = wrap_angle(normal - middle);
        let (lo, hi) = ((-half).min(turn - slack), half.max(turn + slack));
        self.bend_on = Some((middle + 0.5 * (lo + hi), 0.5 * (hi - lo)));
    }
}

fn tree<'a>(stretches: impl Iterator<Item = &'a Stretch>) -> SegmentTree {
    SegmentTree::new(&stretches.map(|one| one.ends).collect::<Vec<_>>())
}

/// A piece in short stretches.
fn stretches(piece: &ThickPiece) -> Vec<Stretch> {
    match piece {
        ThickPiece::Vertex(v) => vec![Stretch {
            ends: [v.point; 2],
            point: v.point,
            spread: v.spread,
            normal: v.normal,
            slack: v.slack,
            sagitta: v.spread,
            takes_sides: v.spread > 0.0 || v.concavity <= 0.0,
            is_straight: false,
            is_unknown: v.slack >= PI,
        }],
        ThickPiece::Edge(e) => {
            let count = (e.length / LONGEST_STRETCH).ceil().max(1.0);
            let half = 0.5 * e.length / count;
            let one = |k: usize| {
                let from = e.start + e.along * (2.0 * half * k as f64);
                Stretch {
                    ends: [from, from + e.along * (2.0 * half)],
                    point: from + e.along * half,
                    spread: half + e.sagitta,
                    normal: e.normal,
                    slack: e.slack,
                    sagitta: e.sagitta,
                    takes_sides: true,
                    is_straight: e.slack < STRAIGHT,
                    is_unknown: false,
                }
            };
            (0..count as usize).map(one).collect()
        }
    }
}

impl Stretch {
    fn bounds(&self) -> Bounds {
        Bounds::of(&self.ends).inflated(self.sagitta)
    }
}

/// Whether two stretches are two places: one smooth wall is one place.
fn is_another_place(a: &Stretch, b: &Stretch) -> bool {
    let is_unknown = a.is_unknown || b.is_unknown;
    is_unknown
        || a.point.distance(b.point) > LOWEST_CORNER
            && wrap_angle(a.normal - b.normal).abs() + a.slack + b.slack > SMOOTH
}

/// Two stretches, mirrored so that the first pushes the whisker to its left.
struct Pair<'a> {
    first: &'a Stretch,
    other: &'a Stretch,
    side: f64,
    friction: f64,
    /// No more than the distance between them (m).
    gap: f64,
}

impl<'a> Pair<'a> {
    fn new(first: &'a Stretch, other: &'a Stretch, friction: f64, side: f64) -> Self {
        let gap = (first.point.distance(other.point) - first.spread - other.spread).max(0.0);
        Self { first, other, side, friction, gap }
    }

    /// Whether the other can bend the whisker on: each lies on the free side of the other.
    fn bends_on(&self) -> bool {
        let (a, b) = (self.first, self.other);
        let turn = self.side * wrap_angle(b.normal - a.normal);
        let slack = a.slack + b.slack + self.friction;
        // The slope grows from one to the other, by half a turn at most.
        (turn >= -slack || turn <= -PI + slack) && is_before(a, b) && is_before(b, a)
    }

    /// Whether the other can bend the whisker back, which a straight wall would not let it be.
    fn bends_back(&self) -> bool {
        let (a, b) = (self.first, self.other);
        if a.is_straight && self.friction <= 0.0 {
            return false;
        }
        // The whisker goes on along the boundary, which is a quarter turn to the right of the normal.
        let tangent = a.normal - self.side * FRAC_PI_2;
        let (way, wide) = direction(a, b, self.side);
        let ahead = self.side * wrap_angle(way - tangent);
        let pushes = self.side * wrap_angle(b.normal - way);
        let slack = wide + b.slack + self.friction;
        ahead.abs() <= SWEPT_BACK + wide + a.slack && (pushes <= slack || pushes >= PI - slack) && is_before(b, a)
    }
}

/// Whether some point of `b` lies on the free side of `a`, for some of its points and normals.
fn is_before(a: &Stretch, b: &Stretch) -> bool {
    let ahead = |off: Vec2| {
        let turn = wrap_angle(off.angle() - a.normal).abs();
        size(off) * math::cos((turn - a.slack).max(0.0))
    };
    let most = ways(a, b).map(ahead).fold(0.0, f64::max);
    most + a.sagitta + b.sagitta > LOWEST_CORNER
}

/// From the ends of one stretch to those of the other.
fn ways(a: &Stretch, b: &Stretch) -> impl Iterator<Item = Vec2> {
    let (a, b) = (a.ends, b.ends);
    [b[0] - a[0], b[1] - a[0], b[0] - a[1], b[1] - a[1]].into_iter()
}

/// The direction from one stretch to the other (rad), and how far it may be off.
fn direction(a: &Stretch, b: &Stretch, side: f64) -> (f64, f64) {
    let way = b.point - a.point;
    let distance = size(way);
    if distance <= LOWEST_CORNER {
        // Along itself; which way is told by the tangent.
        return (a.normal - side * FRAC_PI_2, a.slack);
    }
    let middle = way.angle();
    let turns = ways(a, b).filter(|way| size(*way) > LOWEST_CORNER).map(|way| wrap_angle(way.angle() - middle).abs());
    let bowed = math::asin(((a.sagitta + b.sagitta) / distance).min(1.0));
    (middle, turns.fold(0.0, f64::max) + bowed)
}

/// A stretch as the base sees it, mirrored.
struct Seen {
    /// Least and largest distance of any place where it can be touched (m).
    nearest: f64,
    farthest: f64,
    /// Angle from the heading (rad), and how far it may be off.
    angle: f64,
    wide: f64,
    /// Slope of the whisker there (rad), least and largest, about half a turn either way.
    slope: (f64, f64),
    /// Whether the whisker may be bent to the left all along and ever less, and whether it may be bent to the left at both ends.
    relaxes: bool,
    bends: bool,
}

impl Seen {
    fn new(felt: &Felt, first: &Stretch) -> Option<Self> {
        let way = first.point - felt.view.base;
        let (distance, spread) = (size(way), first.spread + felt.off);
        let nearest = (distance - spread).max(0.0);
        if nearest > felt.length {
            return None;
        }
        let wide = if distance <= spread { PI } else { math::asin(spread / distance) + felt.turn };
        let angle = felt.side * wrap_angle(way.angle() - felt.view.heading);
        let middle = felt.side * wrap_angle(first.normal - felt.side * FRAC_PI_2 - felt.view.heading);
        let lean = first.slack + felt.turn;
        let slope = (middle - lean, middle + lean);
        let farthest = (distance + spread).min(felt.length);
        let seen = Self { nearest, farthest, angle, wide, slope, relaxes: false, bends: false };
        let bends = seen.may_bend(felt);
        Some(Self { relaxes: bends && seen.may_relax(felt), bends, ..seen })
    }

    /// Whether slopes near half a turn may be told as less than minus that, or angles are not known at all.
    fn is_anywhere(&self) -> bool {
        self.slope.0 < -PI || self.slope.1 > PI || self.wide >= PI
    }

    /// Whether the whisker can turn as far as the first contact needs, with forces that point back along the heading to within
    /// `beyond` (rad, to the right) at most.
    ///
    /// `k² = k(base)² + 2/EI sum of F (n · t(base) - n · t)` is not negative at the contact. So, where each `n · t` grows from base to
    /// contact, the forces are bounded by `k(base)²`, and so is the curvature in between.
    fn may_turn(&self, felt: &Felt, beyond: f64) -> bool {
        let (least, most) = self.slope;
        if self.is_anywhere() || least <= 0.0 {
            return true;
        }
        let growth = |beyond: f64, slope: f64| {
            let (rise, fall) = (1.0 - math::cos(beyond.max(0.0)), math::cos(beyond) - math::cos(slope - beyond));
            if rise <= 0.0 {
                0.0
            } else if fall > 0.0 {
                rise / fall
            } else {
                f64::INFINITY
            }
        };
        let own = growth(most - FRAC_PI_2, most).max(growth(least - FRAC_PI_2, least));
        let all = own.max(growth(beyond, least));
        let bent = felt.bent.0.abs().max(felt.bent.1.abs()) * (1.0 + all).sqrt();
        // An arc that turns by so much is no longer than two legs that meet at that angle.
        let longest = (self.farthest / math::cos(0.5 * least.min(2.8))).min(felt.length);
        least <= bent * if felt.bent.0 > 0.0 { longest } else { felt.length }
    }

    /// Whether the whisker may be bent to the left at its base and at the contact.
    fn may_bend(&self, felt: &Felt) -> bool {
        let (least, most) = (self.slope.0.max(0.0), self.slope.1);
        let bent = felt.bent.0.max(0.0) * self.nearest;
        if felt.bent.1 < 0.0 {
            return false;
        }
        if self.is_anywhere() {
            return true;
        }
        let lowest = ANGLE_SHARE / (1.0 + math::tan(felt.friction)) * (least + 0.5 * bent);
        let in_between = self.angle + self.wide >= lowest && self.angle - self.wide <= UPPER_SHARE * most;
        most >= 0.5 * bent && in_between
    }

    /// Whether the curvature may fall from the base to the contact.
    fn may_relax(&self, felt: &Felt) -> bool {
        if self.is_anywhere() || felt.friction > 0.0 {
            return true;
        }
        let (least, most) = (self.slope.0.max(0.0), self.slope.1);
        let steep = most > FRAC_PI_2;
        self.may_turn(felt, 0.0) && (steep || self.angle + self.wide >= RELAXED_SHARE * least)
    }
}

impl Felt<'_> {
    /// Whether the whisker may be bent on by `other` behind the first contact.
    fn bends_on(&self, seen: &Seen, first: &Stretch, other: &Stretch) -> bool {
        seen.relaxes
            || (self.pushes_back(seen, other.normal, other.slack)
                && (seen.bends || self.bends_away(seen, first, other)))
    }

    /// Whether a force within `slack` of `normal` may push to the right of the heading so far that the curvature grows on the way to
    /// the slope at the first contact: `k² - k(base)² = 2/EI (R · t(base) - R · t)` is not positive beyond twice its angle.
    fn pushes_back(&self, seen: &Seen, normal: f64, slack: f64) -> bool {
        let turn = self.side * wrap_angle(normal - self.view.heading);
        let slack = slack + self.friction + self.turn;
        let beyond = if turn >= PI - slack {
            turn + slack - PI
        } else if turn <= seen.slope.1.max(0.0) - FRAC_PI_2 + slack {
            turn + slack + PI
        } else {
            return false;
        };
        let pulls = beyond > FRAC_PI_2;
        seen.may_turn(self, beyond) && (pulls || seen.bends || self.bent.0 <= 0.0)
    }

    /// Whether the whisker may be bent to the right at its base: a force at `other` points between base and first contact.
    fn bends_away(&self, seen: &Seen, first: &Stretch, other: &Stretch) -> bool {
        if self.bent.0 > 0.0 {
            return false;
        }
        if !seen.is_anywhere() && seen.angle - seen.wide > seen.slope.1.max(0.0) {
            return false;
        }
        let base = self.view.base - other.point;
        let (to_base, (to_first, wide)) = (base.angle(), direction(other, first, -self.side));
        let (distance, spread) = (size(base), other.spread + self.off);
        let around = if distance <= spread { PI } else { math::asin(spread / distance) };
        let slack = other.slack + self.friction + around.max(wide);
        let between = wrap_angle(to_first - to_base);
        let middle = to_base + 0.5 * between;
        wrap_angle(other.normal - middle).abs() <= 0.5 * between.abs() + slack
    }
}
