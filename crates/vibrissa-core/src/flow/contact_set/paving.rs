//! Covering the contacts that explain readings: the plane of arc length and load number is cut until each piece either
//! cannot explain them or is small.
//!
//! Over a piece every quantity is known at nine nodes; between the nodes it is believed to stay within their range and
//! twice what the second differences show. A smooth function leaves the range by once that much.

use super::{Contact, ContactModel, Resolution};
use crate::math;
use crate::plane::{ConvexPolygon, Vec2};
use crate::sets::Interval;
use core::f64::consts::FRAC_PI_2;
use std::collections::VecDeque;

/// Cuts after which a piece is kept as it is.
const MOST_CUTS: usize = 24;
/// As many where images are small because the base is near, and only the readings tell contacts apart.
const MOST_CUTS_AT_BASE: usize = 60;
/// Cuts in all: what is left then stays coarse, which is sound. Rods take microseconds where the closed family takes tens of nanoseconds.
const MOST_PIECES: usize = 300_000;
const MOST_ROD_PIECES: usize = 12_000;
/// The share of the length that counts as near the base, and how well readings are told apart there.
const AT_BASE: f64 = 0.05;
const DISCERNED: f64 = 0.1;
/// Arc lengths and load numbers of the pieces at the start: fine enough for the nodes to see each fold.
const START: [usize; 2] = [4, 16];
/// Below this share of a starting piece nothing is cut that has no image.
const NO_IMAGE: f64 = 1.0 / 32.0;
/// The same at the tip, where the last loads have no moment, as the first have, but move the tip far.
const NO_IMAGE_AT_TIP: f64 = 1.0 / 512.0;

/// What a contact must fulfil: quantity and range.
pub(super) type Demand = (fn(&Contact) -> f64, Interval);

/// Which plane of contacts is cut: what stands beside the stretched load number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Chart {
    /// Arc length (m): contacts of the side.
    Side,
    /// Tilt of the force (rad): contacts of the tip.
    Tip,
}

impl Chart {
    /// The direction of the touched wall, or the opposite where the force is negative (rad, whisker frame).
    pub(super) fn wall(self) -> fn(&Contact) -> f64 {
        match self {
            Self::Side => |c| c.phi_a,
            Self::Tip => |c| c.phi_a + c.tilt,
        }
    }
}

/// A rectangle of arc length (or tilt) and stretched load number, with the contacts at its nine nodes, arc length first.
#[derive(Clone, Debug)]
pub(super) struct PavingCell {
    pub(super) chart: Chart,
    pub(super) s: [f64; 2],
    pub(super) v: [f64; 2],
    nodes: [[Option<Contact>; 3]; 3],
    cuts: usize,
}

/// The pieces of the plane that may explain all `demands`, in order.
pub(super) fn pave(
    model: &ContactModel,
    arc_lengths: Interval,
    demands: &[Demand],
    resolution: &Resolution,
) -> Vec<PavingCell> {
    let last = math::asinh(2.0 * model.last_load_number());
    let [rows, columns] = START;
    let mut start = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let s = cell(arc_lengths.lo(), arc_lengths.hi(), row, rows);
            let v = cell(-last, last, column, columns);
            // An arc length that is known exactly needs one row.
            if row == 0 || s[1] > s[0] {
                start.push(PavingCell::new(model, Chart::Side, s, v));
            }
        }
    }
    refine(model, start, demands, resolution)
}

/// As [`pave`] for contacts of the tip: the tilts at which the whisker leaves the wall on its free side, which have the force's sign.
pub(super) fn pave_tip(model: &ContactModel, demands: &[Demand], resolution: &Resolution) -> Vec<PavingCell> {
    let last = math::asinh(2.0 * model.last_load_number());
    let [rows, columns] = START;
    let mut start = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let (tilt, v) = (cell(0.0, FRAC_PI_2, row, rows), cell(-last, last, column, columns));
            let tilt = if v[1] <= 0.0 { [-tilt[1], -tilt[0]] } else { tilt };
            start.push(PavingCell::new(model, Chart::Tip, tilt, v));
        }
    }
    refine(model, start, demands, resolution)
}

fn cell(lo: f64, hi: f64, index: usize, count: usize) -> [f64; 2] {
    let at = |i: usize| if i == count { hi } else { lo + (hi - lo) * i as f64 / count as f64 };
    [at(index), at(index + 1)]
}

/// Cuts pieces, the oldest first, until each is dropped or small, or the work allowed is done; then all that are left are kept.
fn refine(
    model: &ContactModel,
    start: Vec<PavingCell>,
    demands: &[Demand],
    resolution: &Resolution,
) -> Vec<PavingCell> {
    let mut left = if model.has_closed_family() { MOST_PIECES } else { MOST_ROD_PIECES };
    let (mut queue, mut kept) = (VecDeque::from(start), Vec::new());
    while let Some(piece) = queue.pop_front() {
        let Some(verdict) = piece.verdict(demands) else { continue };
        let small = piece.is_small(verdict, resolution);
        let at_base = small && !verdict && piece.is_blurred(model, demands);
        let most = if at_base { MOST_CUTS_AT_BASE } else { MOST_CUTS };
        if piece.cuts >= most || left == 0 || (small && !at_base) {
            kept.push(piece);
            continue;
        }
        left -= 1;
        queue.extend(piece.halves(model, at_base.then_some(demands)));
    }
    kept
}

fn at(model: &ContactModel, chart: Chart, s: f64, v: f64) -> Option<Contact> {
    let last = model.last_load_number();
    let force = |s_a: f64| model.force_of((0.5 * math::sinh(v)).clamp(-last, last), s_a);
    match chart {
        Chart::Side => model.contact(force(s), s),
        Chart::Tip => {
            // Where the end of the first mode is known, loads are shares of it, so that pieces are whole.
            let share = (v / math::asinh(2.0 * last)).clamp(-1.0, 1.0);
            let load = model.last_tip_force(s).map_or_else(|| force(model.length()), |end| end * share * share.abs());
            model.tip_contact(load, s)
        }
    }
}

impl PavingCell {
    fn new(model: &ContactModel, chart: Chart, s: [f64; 2], v: [f64; 2]) -> Self {
        let third = |range: [f64; 2]| [range[0], 0.5 * (range[0] + range[1]), range[1]];
        let (ss, vs) = (third(s), third(v));
        Self { chart, s, v, nodes: ss.map(|s| vs.map(|v| at(model, chart, s, v))), cuts: 0 }
    }

    fn known(&self) -> impl Iterator<Item = &Contact> + '_ {
        self.nodes.iter().flatten().flatten()
    }

    fn is_whole(&self) -> bool {
        self.known().count() == 9
    }

    /// Whether every contact of the piece fulfils the demands; `None` when none does.
    fn verdict(&self, demands: &[Demand]) -> Option<bool> {
        self.known().next()?;
        let mut whole = self.is_whole();
        for (quantity, demanded) in demands {
            let range = self.range(quantity);
            if range.intersection(*demanded).is_empty() {
                return None;
            }
            whole &= demanded.contains(range.lo()) && demanded.contains(range.hi());
        }
        Some(whole)
    }

    /// The values that a quantity takes over the piece.
    pub(super) fn range(&self, quantity: &dyn Fn(&Contact) -> f64) -> Interval {
        let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in self.known().map(quantity) {
            (lo, hi) = (lo.min(value), hi.max(value));
        }
        // Near the end of the first mode some nodes have no contact: then the range itself is the slack.
        let slack = if self.is_whole() { self.slack(&|c| Vec2::new(quantity(c), 0.0)) } else { hi - lo };
        let rounding = 1e-14 * lo.abs().max(hi.abs());
        Interval::new(lo - slack - rounding, hi + slack + rounding)
    }

    /// Twice what a quantity can leave the hull of its nine values by: half the sags along both directions.
    fn slack(&self, quantity: &dyn Fn(&Contact) -> Vec2) -> f64 {
        let value = |i: usize, j: usize| self.nodes[i][j].as_ref().map_or(Vec2::ZERO, quantity);
        let sag = |a: Vec2, b: Vec2, c: Vec2| 0.5 * (a - 2.0 * b + c).norm();
        let (mut by_s, mut by_v) = (0.0f64, 0.0f64);
        for k in 0..3 {
            by_s = by_s.max(sag(value(0, k), value(1, k), value(2, k)));
            by_v = by_v.max(sag(value(k, 0), value(k, 1), value(k, 2)));
        }
        0.5 * (by_s + by_v)
    }

    /// How far apart the images of opposite sides are, by arc length and by load.
    fn extents(&self) -> [f64; 2] {
        let distance = |a: Option<Contact>, b: Option<Contact>| match (a, b) {
            (Some(a), Some(b)) => a.position.distance(b.position),
            _ => f64::NAN,
        };
        // `max` passes over what is not a number.
        let widest = |pairs: [f64; 3]| pairs.into_iter().fold(f64::NAN, f64::max);
        [
            widest([0, 1, 2].map(|k| distance(self.nodes[0][k], self.nodes[2][k]))),
            widest([0, 1, 2].map(|k| distance(self.nodes[k][0], self.nodes[k][2]))),
        ]
    }

    fn is_small(&self, inside: bool, resolution: &Resolution) -> bool {
        let [by_s, by_v] = self.extents();
        let limit = if inside { resolution.inner } else { resolution.rim };
        let slope = self.range(&self.chart.wall()).width();
        if self.is_whole() {
            return by_s + by_v <= limit && slope <= resolution.slope;
        }
        let limit_of_image = if self.chart == Chart::Tip { NO_IMAGE_AT_TIP } else { NO_IMAGE };
        // A rod near the end of its first mode may show no extent; then the piece itself must be small.
        by_s.max(by_v) <= limit && slope <= resolution.slope
            || (self.v[1] - self.v[0] < limit_of_image && self.s[1] - self.s[0] < limit_of_image * self.scale())
    }

    /// What counts as one across the loads: the arc length itself (m), a right angle.
    fn scale(&self) -> f64 {
        if self.chart == Chart::Tip { FRAC_PI_2 } else { self.s[1] }
    }

    /// Whether the piece is near the base and its readings are wider than what is demanded.
    fn is_blurred(&self, model: &ContactModel, demands: &[Demand]) -> bool {
        let wide = |(quantity, demanded): &Demand| {
            let size = demanded.lo().abs().max(demanded.hi().abs());
            size > 0.0 && size.is_finite() && self.range(quantity).width() > demanded.width() + DISCERNED * size
        };
        self.chart == Chart::Side && self.is_whole() && self.s[1] < AT_BASE * model.length() && demands.iter().any(wide)
    }

    /// Whether the readings change more by arc length than by load, each as a share of what is demanded.
    fn reads_by_s(&self, demands: &[Demand]) -> bool {
        let (mut by_s, mut by_v) = (0.0f64, 0.0f64);
        for (quantity, demanded) in demands {
            let size = demanded.lo().abs().max(demanded.hi().abs());
            let change = |a: Option<Contact>, b: Option<Contact>| {
                a.zip(b).map_or(0.0, |(a, b)| (quantity(&a) - quantity(&b)).abs() / size)
            };
            for k in 0..3 {
                by_s = by_s.max(change(self.nodes[0][k], self.nodes[2][k]));
                by_v = by_v.max(change(self.nodes[k][0], self.nodes[k][2]));
            }
        }
        by_s > by_v
    }

    /// The piece cut across its longer image, or where images do not count as the readings ask.
    fn halves(&self, model: &ContactModel, at_base: Option<&[Demand]>) -> [Self; 2] {
        let [by_s, by_v] = self.extents();
        let wall = self.chart.wall();
        let slopes =
            |a: Option<Contact>, b: Option<Contact>| a.zip(b).map_or(0.0, |(a, b)| (wall(&a) - wall(&b)).abs());
        let lever = model.length();
        let by_s = by_s.max(lever * slopes(self.nodes[0][1], self.nodes[2][1]));
        let by_v = by_v.max(lever * slopes(self.nodes[1][0], self.nodes[1][2]));
        // Where images are unknown the piece's own proportions decide.
        let own = [(self.s[1] - self.s[0]) / self.scale(), self.v[1] - self.v[0]];
        let longer = match (at_base, self.is_whole()) {
            (Some(demands), _) => self.reads_by_s(demands),
            (_, true) => by_s > by_v,
            _ => own[0] > own[1],
        };
        let across_s = self.s[1] > self.s[0] && longer;
        let half = |upper: usize| {
            let mut piece = Self { cuts: self.cuts + 1, ..self.clone() };
            let range = if across_s { &mut piece.s } else { &mut piece.v };
            range[1 - upper] = 0.5 * (range[0] + range[1]);
            let (s, v) = (piece.s, piece.v);
            for k in 0..3 {
                let old = |i: usize| if across_s { self.nodes[i][k] } else { self.nodes[k][i] };
                let third = |range: [f64; 2]| [range[0], 0.5 * (range[0] + range[1]), range[1]][k];
                let new = if across_s {
                    at(model, self.chart, 0.5 * (s[0] + s[1]), third(v))
                } else {
                    at(model, self.chart, third(s), 0.5 * (v[0] + v[1]))
                };
                for (i, contact) in [old(upper), new, old(1 + upper)].into_iter().enumerate() {
                    if across_s { piece.nodes[i][k] = contact } else { piece.nodes[k][i] = contact }
                }
            }
            piece
        };
        [half(0), half(1)]
    }

    /// The contact in the middle, or whichever is known.
    pub(super) fn middle(&self) -> Option<Contact> {
        self.nodes[1][1].or_else(|| self.known().next().copied())
    }

    /// A polygon that holds the places of all contacts of the piece.
    pub(super) fn cover(&self) -> Option<ConvexPolygon> {
        let places: Vec<Vec2> = self.known().map(|c| c.position).collect();
        let hull = ConvexPolygon::hull(&places)?;
        let slack = if self.is_whole() { self.slack(&|c| c.position) } else { hull.bounds().size().norm() };
        Some(hull.grown(slack + 1e-12))
    }
}
