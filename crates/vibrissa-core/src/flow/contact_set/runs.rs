//! Cells along a curve of contacts, where a region is one.

use super::family::along;
use super::paving::Chart;
use super::{Contact, ContactCell, ContactCurve, ContactModel, Resolution};
use crate::plane::{ConvexPolygon, Vec2};
use crate::sets::Interval;
use core::f64::consts::FRAC_PI_2;

/// Tilts at which the tip's contacts of one load are looked for first; then so many to a cell, and at most so many in all.
const TIP_NODES: usize = 192;
const NODES_OF_CELL: f64 = 5.0;
const MOST_TIP_NODES: f64 = 2e4;

fn span(contacts: &[Contact], quantity: &dyn Fn(&Contact) -> f64) -> Interval {
    contacts.iter().map(|c| Interval::point(quantity(c))).fold(Interval::EMPTY, Interval::hull)
}

/// The cells of a curve: runs of its nodes that are as long and turn as far as the resolution lets them.
pub(super) fn run_cells(
    contacts: &[Contact],
    tolerance: f64,
    chart: Chart,
    resolution: &Resolution,
) -> Vec<ContactCell> {
    let (mut cells, mut start) = (Vec::new(), 0);
    while start < contacts.len() {
        let fits = |end: usize| {
            let run = &contacts[start..=end];
            let chord: f64 = run.windows(2).map(|w| w[0].position.distance(w[1].position)).sum();
            chord <= resolution.rim && span(run, &chart.wall()).width() <= 0.98 * resolution.slope
        };
        let mut end = (start + 1).min(contacts.len() - 1);
        while end + 1 < contacts.len() && fits(end + 1) {
            end += 1;
        }
        cells.extend(run_cell(&contacts[start..=end], tolerance, chart));
        // The next run begins with the node at which this one ends, so that nothing is left between them.
        start = if end + 1 < contacts.len() { end } else { contacts.len() };
    }
    cells
}

/// The cells of the tip's contacts under one force: a curve over the tilts at which the whisker leaves the wall on its free side.
pub(super) fn tips_of_load(model: &ContactModel, force: f64, resolution: &Resolution) -> Vec<ContactCell> {
    let at = |tilt: f64| {
        let contact = model.tip_contact(force, tilt)?;
        model.limits().admit(&contact).then_some(contact)
    };
    let tilts = if force > 0.0 { [0.0, FRAC_PI_2] } else { [-FRAC_PI_2, 0.0] };
    let cost = |w: &[Contact]| {
        let turned = (Chart::Tip.wall()(&w[1]) - Chart::Tip.wall()(&w[0])).abs();
        w[0].position.distance(w[1].position) / resolution.rim + turned / resolution.slope
    };
    let mut cells = Vec::new();
    for coarse in along(tilts, &[], TIP_NODES, &at) {
        if coarse.len() < 2 {
            cells.extend(run_cells(&coarse, 0.0, Chart::Tip, resolution));
            continue;
        }
        // Contacts at equal parts of a cell, a few for each.
        let mut way = vec![0.0];
        for w in coarse.windows(2) {
            way.push(way[way.len() - 1] + cost(w));
        }
        let whole = way[way.len() - 1];
        let count = (NODES_OF_CELL * whole).ceil().clamp(8.0, MOST_TIP_NODES);
        let tilt = |k: usize| {
            let on = whole * k as f64 / count;
            let i = way.partition_point(|w| *w <= on).clamp(1, way.len() - 1);
            let share = (on - way[i - 1]) / (way[i] - way[i - 1]).max(f64::MIN_POSITIVE);
            coarse[i - 1].tilt + share.min(1.0) * (coarse[i].tilt - coarse[i - 1].tilt)
        };
        let curve = ContactCurve::new((0..=count as usize).filter_map(|k| at(tilt(k))).collect());
        cells.extend(run_cells(curve.contacts(), curve.sag(), Chart::Tip, resolution));
    }
    cells
}

/// The cell of a run of nodes along a curve.
fn run_cell(run: &[Contact], tolerance: f64, chart: Chart) -> Option<ContactCell> {
    let places: Vec<Vec2> = run.iter().map(|c| c.position).collect();
    let cover = ConvexPolygon::hull(&places)?.grown(tolerance + 1e-12);
    let contact = run[run.len() / 2];
    // Between nodes a slope may pass its ends by a second difference: a hundredth is ample for hundreds of nodes.
    let widened = |quantity: &dyn Fn(&Contact) -> f64| {
        let range = span(run, quantity);
        let slack = 0.01 * range.width() + 1e-12;
        Interval::new(range.lo() - slack, range.hi() + slack)
    };
    Some(ContactCell {
        contact,
        radius: cover.corners().iter().map(|p| p.distance(contact.position)).fold(0.0, f64::max),
        slope: widened(&|c| c.phi_a),
        wall: widened(&chart.wall()),
        is_tip: chart == Chart::Tip,
        arc_length: span(run, &|c| c.s_a),
        force: span(run, &|c| c.force),
        bounds: cover.bounds(),
        cover,
    })
}
