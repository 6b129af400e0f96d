//! Contacts along one parameter: where a reading leaves a curve that can be written down.

use super::level::{contact, level};
use super::model::{LAST_NORMAL_LOAD, Mechanics};
use super::trace::traced;
use super::{Contact, ContactModel, VirtualSensor};
use crate::beam::field::{ContactSheet, Read, SheetContact};
use crate::beam::normal::{Branch, by_force, by_moment};
use crate::math;

/// Parameters that are looked at for pieces within whisker and limits.
pub(super) const PROBES: usize = 48;
/// Bisections of a piece's end: to rounding, and from one node to the next to a tenth of what a table knows.
const BISECTIONS: usize = 52;
const FINE: usize = 14;

/// The branches of an exact reading, each in order, and how far they may be from the beam's (m).
pub(super) fn exact_curves(
    model: &ContactModel,
    sensor: VirtualSensor,
    value: f64,
    nodes: usize,
) -> (Vec<Vec<Contact>>, f64) {
    match model.sheet() {
        Some(sheet) => on_sheet(model, sheet, sensor, value, nodes),
        None => (by_beam(model, sensor, value, nodes), 0.0),
    }
}

/// The branches as a sheet has them.
fn on_sheet(
    model: &ContactModel,
    sheet: &ContactSheet,
    sensor: VirtualSensor,
    value: f64,
    nodes: usize,
) -> (Vec<Vec<Contact>>, f64) {
    let (first, length) = (model.first_arc_length(), model.length());
    let admitted = |spot: Option<SheetContact>| {
        spot.map(|spot| contact(&spot, model.sheet_tilt())).filter(|contact| model.limits().admit(contact))
    };
    let by_load = |s: f64| admitted(sheet.contact(value, s));
    let by_strip = |w: f64| admitted(sheet.contact_at(value, w));
    let pieces = match sensor {
        VirtualSensor::Load => stepped([first, length], nodes, PROBES, &by_load),
        VirtualSensor::Strip if value >= first && value <= length => {
            match sheet.loads_at(value).map(|range| sampled(range, nodes, &by_strip)) {
                Some(whole) if whole.len() == nodes => vec![whole],
                _ => along([-1.0, 1.0], &[0.0], nodes, &by_strip),
            }
        }
        VirtualSensor::Strip => return (by_beam(model, sensor, value, nodes), 0.0),
        VirtualSensor::Slope => return level(model, sheet, Read::Slope, value, nodes),
        VirtualSensor::Moment(_) => return level(model, sheet, Read::Moment, value, nodes),
    };
    (pieces, sheet.position_error())
}

/// The branches by the beam itself.
fn by_beam(model: &ContactModel, sensor: VirtualSensor, value: f64, nodes: usize) -> Vec<Vec<Contact>> {
    let (first, length) = (model.first_arc_length(), model.length());
    let at_rest = value.abs() <= 0.0 && !matches!(model.mechanics, Mechanics::Rod(_));
    match (sensor, model.normal_family()) {
        (VirtualSensor::Load, _) => along([first, length], &[], nodes, &|s| model.admitted(value, s)),
        (VirtualSensor::Strip, _) if !(value > 0.0 && value <= length) => Vec::new(),
        (VirtualSensor::Strip, _) => {
            let last = math::asinh(2.0 * model.last_load_number());
            along([-last, last], &[0.0], nodes, &|v| model.admitted(model.force_of(0.5 * math::sinh(v), value), value))
        }
        // Without a force a straight whisker has neither slope nor moment.
        (VirtualSensor::Slope | VirtualSensor::Moment(_), _) if at_rest => {
            along([first, length], &[], nodes, &|s| model.admitted(0.0, s))
        }
        (VirtualSensor::Slope, Some(_)) => match load_number_of_slope(value) {
            Some(u) => along([first, length], &[], nodes, &|s| model.admitted(model.force_of(u, s), s)),
            None => Vec::new(),
        },
        (VirtualSensor::Moment(_), Some(ei)) => normal_moment(model, ei, value, nodes),
        (VirtualSensor::Moment(_), None) if model.is_small_angle() => {
            along([first, length], &[], nodes, &|s| model.admitted(value / s, s))
        }
        _ => traced(model, sensor, value, nodes),
    }
}

/// The loop through the base of all contacts with one moment: the shape fixes `M0 s_a / EI`, and so `s_a`.
fn normal_moment(model: &ContactModel, ei: f64, moment: f64, nodes: usize) -> Vec<Vec<Contact>> {
    let first = model.first_arc_length();
    let at = |u: f64| {
        let shape = by_force(0.5, u.copysign(moment), 1.0)?;
        // Twice the moment of a whisker of rigidity one half: `M0 s_a / EI`.
        let s_a = 2.0 * ei * shape.moment / moment;
        if !(s_a >= first * (1.0 - 1e-9) && s_a <= model.length() * (1.0 + 1e-9)) {
            return None;
        }
        let force = 2.0 * ei * u.copysign(moment) / (s_a * s_a);
        let contact = Contact { force, s_a, phi_a: shape.phi_a, position: s_a * shape.contact, moment, tilt: 0.0 };
        model.limits().admit(&contact).then_some(contact)
    };
    // The load numbers at which either branch is at the base, or as far out as the whisker or the fold lets it.
    let number =
        |s_a: f64, branch: Branch| by_moment(1.0, moment.abs() / ei, s_a, branch).map(|b| 0.5 * b.force * s_a * s_a);
    let inner = [Branch::Least, Branch::Curled].map(|branch| number(first, branch));
    let outer = [Branch::Least, Branch::Curled].map(|branch| number(model.length(), branch));
    let ranges = match (inner, outer) {
        ([Some(start), Some(end)], [Some(least), Some(curled)]) => vec![[start, least], [curled, end]],
        ([Some(start), Some(end)], _) => vec![[start, end]],
        _ => Vec::new(),
    };
    ranges.into_iter().flat_map(|range| along(range, &[], nodes, &at)).collect()
}

/// The load number at which a uniform whisker under a normal load has slope `phi_a`; `None` beyond half a turn.
fn load_number_of_slope(phi_a: f64) -> Option<f64> {
    let slope = |u: f64| by_force(0.5, u, 1.0).map(|shape| shape.phi_a);
    let size = phi_a.abs();
    if size > slope(LAST_NORMAL_LOAD)? {
        return None;
    }
    // The slope is the load number to first order and rises; secants between brackets.
    let (mut lo, mut hi) = (0.0, LAST_NORMAL_LOAD);
    let mut u = size.min(hi);
    for _ in 0..100 {
        let gap = slope(u)? - size;
        if gap > 0.0 {
            hi = u
        } else {
            lo = u
        }
        let step = (1e-6 * u).max(1e-12);
        let rate = slope((u - step).max(0.0)).map_or(1.0, |low| (gap + size - low) / step.min(u));
        let next = u - gap / rate;
        let next = if next > lo && next < hi { next } else { 0.5 * (lo + hi) };
        if (next - u).abs() <= 1e-15 * u {
            break;
        }
        u = next;
    }
    Some(u.copysign(phi_a))
}

/// The pieces of `at` over the range `[from, to]` on which it has a value, each sampled evenly from end to end.
///
/// Pieces and gaps narrower than a 48th of the range are found when one of the `marks` lies in them.
pub(super) fn along(
    range: [f64; 2],
    marks: &[f64],
    nodes: usize,
    at: &dyn Fn(f64) -> Option<Contact>,
) -> Vec<Vec<Contact>> {
    let [from, to] = range;
    let mut probes: Vec<f64> = (0..=PROBES).map(|i| from + (to - from) * i as f64 / PROBES as f64).collect();
    probes.extend_from_slice(marks);
    probes.sort_unstable_by(f64::total_cmp);
    let inside: Vec<bool> = probes.iter().map(|&t| at(t).is_some()).collect();
    let mut pieces = Vec::new();
    let mut start = inside[0].then_some(probes[0]);
    for i in 1..probes.len() {
        match (inside[i - 1], inside[i]) {
            (false, true) => start = Some(end_of(at, probes[i], probes[i - 1], BISECTIONS)),
            (true, false) => pieces.extend(start.take().map(|s| [s, end_of(at, probes[i - 1], probes[i], BISECTIONS)])),
            _ => {}
        }
    }
    pieces.extend(start.map(|s| [s, to]));
    pieces.into_iter().map(|piece| sampled(piece, nodes, at)).filter(|contacts| !contacts.is_empty()).collect()
}

/// As [`along`], for contacts that are known to a table's error: nodes of the whole range stay where the pieces are long. So many probes
/// look for pieces where the range is not whole.
pub(super) fn stepped(
    range: [f64; 2],
    nodes: usize,
    probes: usize,
    at: &dyn Fn(f64) -> Option<Contact>,
) -> Vec<Vec<Contact>> {
    if nodes < PROBES {
        return along(range, &[], nodes, at);
    }
    let [from, to] = range;
    let last = nodes - 1;
    let place = |i: usize| if i == last { to } else { from + (to - from) * i as f64 / last as f64 };
    // A range whose end has none is not whole.
    let end = at(to);
    let mut whole = Vec::with_capacity(nodes);
    if let Some(end) = end {
        whole.extend((0..last).map_while(|i| at(place(i))));
        if whole.len() == last {
            whole.push(end);
            return vec![whole];
        }
    }
    let seen = probed(whole, end, (nodes, probes), &|i| at(place(i)));
    let mut pieces = Vec::new();
    let mut next = 0;
    while let Some(start) = (next..seen.len()).find(|k| seen[*k].1.is_some()) {
        next = (start..seen.len()).find(|k| seen[*k].1.is_none()).unwrap_or(seen.len());
        let (run, before, after) = (&seen[start..next], start.checked_sub(1).map(|k| &seen[k]), seen.get(next));
        let (first, last) = (place(run[0].0), place(run[run.len() - 1].0));
        let lo = before.map_or(from, |before| end_of(at, first, place(before.0), FINE));
        let hi = after.map_or(to, |after| end_of(at, last, place(after.0), FINE));
        if 2 * run.len() < nodes {
            pieces.push(sampled([lo, hi], nodes, at));
        } else {
            let before = (lo < first).then(|| at(lo)).flatten();
            let after = (hi > last).then(|| at(hi)).flatten();
            pieces.push(before.into_iter().chain(run.iter().filter_map(|seen| seen.1)).chain(after).collect());
        }
    }
    pieces
}

/// What some of the `nodes` have: of those after the first ones, which are `known`, only probes and the last, or all next to a probe that
/// has something when that is half of them.
fn probed(
    known: Vec<Contact>,
    end: Option<Contact>,
    (nodes, probes): (usize, usize),
    at: &dyn Fn(usize) -> Option<Contact>,
) -> Vec<(usize, Option<Contact>)> {
    let (count, last) = (known.len(), nodes - 1);
    let stride = last / probes.clamp(1, last) + 1;
    let mut seen: Vec<(usize, Option<Contact>)> = known.into_iter().map(Some).enumerate().collect();
    seen.extend((count..last).step_by(stride).map(|i| (i, at(i))));
    seen.push((last, end));
    let inside = count + stride * seen[count..].iter().filter(|seen| seen.1.is_some()).count();
    if 2 * inside < nodes {
        return seen;
    }
    let mut all = Vec::with_capacity(nodes);
    for pair in seen.windows(2) {
        all.push(pair[0]);
        if pair[0].1.is_some() || pair[1].1.is_some() {
            all.extend((pair[0].0 + 1..pair[1].0).map(|i| (i, at(i))));
        }
    }
    all.push((last, end));
    all
}

/// The last parameter with a value on the way from `inside` to `outside`.
fn end_of(at: &dyn Fn(f64) -> Option<Contact>, inside: f64, outside: f64, bisections: usize) -> f64 {
    let (mut good, mut bad) = (inside, outside);
    for _ in 0..bisections {
        let middle = 0.5 * (good + bad);
        if at(middle).is_some() { good = middle } else { bad = middle }
    }
    good
}

fn sampled([from, to]: [f64; 2], nodes: usize, at: &dyn Fn(f64) -> Option<Contact>) -> Vec<Contact> {
    let last = nodes.max(2) - 1;
    let place = |i: usize| if i == last { to } else { from + (to - from) * i as f64 / last as f64 };
    (0..=last).filter_map(|i| at(place(i))).collect()
}
