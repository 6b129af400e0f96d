//! Contractor of contacts at a vertex \[chabert2009contractor\]: base and vertex differ by the contact itself.

use super::contraction::{Contraction, SubBox, WHOLE, is_whole};
use super::contractor::{BaseView, ContactEntry, Strip, contacts, size};
use super::parallelotope::contract_box;
use super::record::{ReadingContacts, SideContacts};
use super::thick_piece::ThickVertex;
use crate::plane::Vec2;
use core::f64::consts::PI;

/// A vertex as a cell's base sees it.
struct VertexView<'a> {
    view: &'a BaseView,
    /// The point in the whisker frame, and how far it may be from the contact.
    w: Vec2,
    spread: f64,
    /// What the linear model leaves, and what the odometry's turn adds (m).
    second: f64,
    swing: f64,
}

impl<'a> VertexView<'a> {
    fn new(view: &'a BaseView, vertex: &ThickVertex) -> Self {
        let w = view.to_whisker(vertex.point - view.base);
        let (turned, moved) = (view.turn + view.slop_turn, size(view.reach));
        let second = turned * (0.5 * size(w) * turned + moved);
        Self { view, w, spread: vertex.spread, second, swing: size(w) * view.slop_turn }
    }

    /// The part of the cell in which one entry, within `wide` of the direction asked for, explains the reading: the strip
    /// across the line on which the contact moves with the direction, and the part within that along it, too.
    fn part(&self, contact: &ContactEntry, wide: f64) -> Option<(SubBox, Strip)> {
        let (from, to) = contact.within(wide);
        let (center, range) = (contact.center + contact.by_direction * (0.5 * (from + to)), 0.5 * (to - from));
        let sweep = size(contact.by_direction);
        let line = if sweep > 1e-6 {
            contact.by_direction * (1.0 / sweep)
        } else {
            let thick = contact.by_moment.norm();
            if thick > 0.0 { contact.by_moment.perp() * (1.0 / thick) } else { Vec2::new(1.0, 0.0) }
        };
        let error = contact.radius + self.second + self.view.slop + self.swing + self.spread;
        let strip = |direction: Vec2| {
            // How the point moves in the whisker frame as base and heading do.
            let (sin, cos) = (self.view.sin, self.view.cos);
            let in_map = Vec2::new(cos * direction.x - sin * direction.y, sin * direction.x + cos * direction.y);
            let at = direction.dot(self.w - center);
            let half =
                error + direction.dot(contact.by_moment).abs() + direction.dot(contact.by_direction).abs() * range;
            Strip { form: self.view.form(-in_map, -direction.dot(self.w.perp())), range: (-at - half, -at + half) }
        };
        let (mut part, across) = (WHOLE, strip(line.perp()));
        if !contract_box(&mut part, &across.form, across.range) {
            return None;
        }
        let along = strip(line);
        contract_box(&mut part, &along.form, along.range).then_some((part, across))
    }
}

/// Contacts at a vertex; how many entries were looked at.
pub(super) fn at_vertex(
    view: &BaseView,
    touch: &ReadingContacts,
    bending: &SideContacts,
    vertex: &ThickVertex,
    left: &mut Option<Contraction>,
) -> usize {
    let held = vertex.concavity >= touch.holding;
    if bending.all_inflected && !held {
        return 0;
    }
    let mut comparisons = 0;
    let lean = vertex.slack + touch.friction_angle;
    let psi = vertex.normal - view.heading;
    let aim = VertexView::new(view, vertex);
    // Cones of half a turn and more meet everything.
    let wide = (view.turn + view.slop_turn + lean).min(PI);
    contacts(bending.side, bending.level(view.turn), psi, wide, |contact| {
        if contact.inflected && !held || is_whole(left) {
            return;
        }
        comparisons += 1;
        // Out of reach of all contacts of this entry: no need for strips.
        let reach = contact.sizes.iter().sum::<f64>() + contact.radius + vertex.spread;
        if out_of_reach(view, vertex.point, reach) {
            return;
        }
        if let Some((part, across)) = aim.part(contact, wide) {
            Contraction::join(left, part, across.form, across.range);
        }
    });
    comparisons
}

/// Whether a point is farther from every base of the cell than `reach` (m).
fn out_of_reach(view: &BaseView, point: Vec2, reach: f64) -> bool {
    let off = point - view.base;
    off.x.abs() > reach + view.reach.x || off.y.abs() > reach + view.reach.y
}
