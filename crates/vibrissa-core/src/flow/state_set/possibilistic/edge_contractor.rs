//! Contractor of contacts on an edge \[chabert2009contractor\]: base and edge differ along its normal by the whisker's reach.

use super::contraction::{Contraction, SubBox, WHOLE, is_whole};
use super::contractor::{BaseView, ContactEntry, Strip, around_half_turn, mirrored};
use super::parallelotope::contract_box;
use super::record::{ReadingContacts, SideContacts};
use super::thick_piece::ThickEdge;
use crate::beam::press::Span;
use crate::plane::Vec2;
use core::f64::consts::TAU;

/// A quick look whether the whisker can touch an edge.
pub(super) fn may_touch(view: &BaseView, touch: &ReadingContacts, bending: &SideContacts, edge: &ThickEdge) -> bool {
    let held = edge.concavity >= touch.holding;
    if bending.all_inflected && !held {
        return false;
    }
    let Some(facing) = EdgeView::new(view, touch.length, edge) else { return false };
    let lean = edge.slack + touch.friction_angle;
    let wide = view.turn + view.slop_turn + lean;
    let slice = bending.level(wide.min(0.2));
    let asked = around_half_turn(bending.side * (edge.normal - view.heading));
    [asked - TAU, asked, asked + TAU]
        .into_iter()
        .any(|asked| facing.may_touch(slice.span(asked - wide, asked + wide), bending.side, touch.length * lean))
}

/// Friction spreads directions over many buckets: a table as fine as this share of its angle.
const LEAN_SHARE: f64 = 0.6;

/// Contacts on an edge; how many entries were looked at.
pub(super) fn on_edge(
    view: &BaseView,
    touch: &ReadingContacts,
    bending: &SideContacts,
    edge: &ThickEdge,
    left: &mut Option<Contraction>,
) -> usize {
    let held = edge.concavity >= touch.holding;
    if bending.all_inflected && !held {
        return 0;
    }
    let Some(facing) = EdgeView::new(view, touch.length, edge) else { return 0 };
    let mut comparisons = 0;
    let psi = edge.normal - view.heading;
    let lean = edge.slack + touch.friction_angle;
    let wide = view.turn + view.slop_turn + lean;
    let slice = bending.level(wide - (1.0 - LEAN_SHARE) * touch.friction_angle);
    let asked = around_half_turn(bending.side * psi);
    let known = slice.directions();
    for asked in [asked - TAU, asked, asked + TAU] {
        if asked + wide < known.lo() || asked - wide > known.hi() {
            continue;
        }
        let span = slice.span(asked - wide, asked + wide);
        // The force leans from the normal along which the distance is counted.
        if !facing.may_touch(span, bending.side, touch.length * lean) {
            continue;
        }
        for entry in slice.between(asked - wide, asked + wide) {
            if entry.inflected && !held {
                continue;
            }
            comparisons += 1;
            if let Some((part, across)) = facing.part(&mirrored(entry, bending.side, asked), lean) {
                Contraction::join(left, part, across.form, across.range);
                if is_whole(left) {
                    return comparisons;
                }
            }
        }
    }
    comparisons
}

/// An edge as a cell's base sees it.
struct EdgeView<'a> {
    view: &'a BaseView,
    edge: &'a ThickEdge,
    /// The edge's normal and direction in the whisker frame.
    normal: Vec2,
    along: Vec2,
    /// Where the base stands: above the edge's line, and along it from the start (m); how far it may be off.
    distance: f64,
    ahead: f64,
    across: f64,
    beside: f64,
}

impl<'a> EdgeView<'a> {
    /// None if the edge is out of reach.
    fn new(view: &'a BaseView, length: f64, edge: &'a ThickEdge) -> Option<Self> {
        let normal = edge.along.perp();
        let offset = view.base - edge.start;
        let distance = normal.dot(offset);
        let across = normal.x.abs() * view.reach.x + normal.y.abs() * view.reach.y + edge.sagitta;
        if distance - across > length || distance + across < -length {
            return None;
        }
        let ahead = edge.along.dot(offset);
        let beside = edge.along.x.abs() * view.reach.x + edge.along.y.abs() * view.reach.y + edge.sagitta;
        if ahead - beside > edge.length + length || ahead + beside < -length {
            return None;
        }
        let (normal, along) = (view.to_whisker(normal), view.to_whisker(edge.along));
        Some(Self { view, edge, normal, along, distance, ahead, across, beside })
    }

    /// A quick look whether base and edge can be as far apart, along the normal and along the edge, as contacts are.
    fn may_touch(&self, span: Span, side: f64, more: f64) -> bool {
        let place = if side > 0.0 { span.place } else { (-span.place.1, -span.place.0) };
        self.distance + span.reach.0 - self.across - more <= 0.0
            && self.distance + span.reach.1 + self.across + more >= 0.0
            && self.ahead + place.0 - self.beside - more <= self.edge.length
            && self.ahead + place.1 + self.beside + more >= 0.0
    }

    /// The part of the cell in which one entry explains the reading, with the strip across the edge.
    fn part(&self, contact: &ContactEntry, lean: f64) -> Option<(SubBox, Strip)> {
        let view = self.view;
        // The headings that this entry serves: psi falls as the heading grows.
        let serves = contact.half + lean + view.slop_turn;
        let turns = (-contact.ahead - serves, -contact.ahead + serves);
        if turns.0 > view.turn || turns.1 < -view.turn {
            return None;
        }
        let [arm, slope, thick] = contact.sizes;
        let turn = view.turn.min(contact.ahead.abs() + contact.half + lean);
        let wide = turn + view.slop_turn;
        let leans = lean > contact.half;
        // The contact at psi itself, by the entry's own line; or, where the force leans by more than the entry is wide,
        // anywhere on that line.
        let (p, lean, follows) = if leans {
            let (from, to) = contact.within(wide + lean);
            (contact.center + contact.by_direction * (0.5 * (from + to)), 0.5 * (to - from).max(0.0), 0.0)
        } else {
            (contact.center - contact.by_direction * contact.ahead, lean, 1.0)
        };
        let arm = arm + slope * if leans { contact.half } else { contact.ahead.abs() };
        let second = wide * (0.5 * arm * wide + slope * (follows * wide + lean) + thick + contact.radius);
        let error = contact.radius + second + self.edge.sagitta + view.slop;
        let half = |direction: Vec2, leaning: f64, by_turn: f64| {
            error + direction.dot(contact.by_moment).abs() + leaning.abs() * lean + by_turn.abs() * view.slop_turn
        };
        let (u, side) = (self.normal, self.along);
        let leaning = u.dot(contact.by_direction);
        let by_turn = -side.dot(p) + follows * leaning;
        let (gap, off) = (self.distance + u.dot(p), half(u, leaning, by_turn));
        if gap.abs() > off + self.across + by_turn.abs() * view.turn {
            return None;
        }
        let form = view.form(self.edge.along.perp(), -by_turn);
        let across = Strip { form, range: (-gap - off, -gap + off) };
        let mut part = WHOLE;
        if !contract_box(&mut part, &across.form, across.range) {
            return None;
        }
        let leaning = side.dot(contact.by_direction);
        let by_turn = u.dot(p) + follows * leaning;
        let (place, off) = (self.ahead + side.dot(p), half(side, leaning, by_turn));
        let form = view.form(self.edge.along, -by_turn);
        let kept = contract_box(&mut part, &form, (-place - off, self.edge.length - place + off))
            && contract_box(&mut part, &view.turns, turns);
        kept.then_some((part, across))
    }
}
