//! Regions: all contacts that explain readings with bounds on their errors, covered.

use super::paving::{Chart, Demand, PavingCell, pave, pave_tip};
use super::runs::{run_cells, tips_of_load};
use super::{Contact, ContactCurve, ContactModel, ContactSet, Parts, Reading, VirtualSensor};
use crate::Result;
use crate::plane::{Bounds, ConvexPolygon, Pose2, Vec2, union_area};
use crate::sets::Interval;
use core::f64::consts::TAU;

/// Lines along which an area is measured.
const AREA_COLUMNS: usize = 1500;
/// Arc lengths this close to the length are the tip's, as a share.
const ROUNDING: f64 = 1e-9;

/// How finely a region is covered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resolution {
    /// Largest extent of a cell at the rim of the region (m).
    pub rim: f64,
    /// Largest extent of a cell inside (m).
    pub inner: f64,
    /// Largest range of slopes of a cell (rad).
    pub slope: f64,
}

impl Default for Resolution {
    /// A fifth of a millimetre at the rim, so that the paper's strips of centimetres are known to about a percent.
    fn default() -> Self {
        Self { rim: 0.2e-3, inner: 2e-3, slope: 0.2 }
    }
}

impl Resolution {
    /// Cells alike at the rim and inside (m, rad).
    #[must_use]
    pub fn even(length: f64, slope: f64) -> Self {
        Self { rim: length, inner: length, slope }
    }
}

/// A piece of a region: contacts that are alike.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactCell {
    /// One contact of the cell, its middle.
    pub contact: Contact,
    /// Holds the place of each contact of the cell, whisker frame.
    pub cover: ConvexPolygon,
    /// How far the cover reaches from the middle contact (m).
    pub radius: f64,
    /// The slopes at the contacts (rad).
    pub slope: Interval,
    /// The directions of the touched wall where the force is positive, the opposite ones where it is negative (rad): the
    /// slopes at the side, at the tip the slopes and the tilts.
    pub wall: Interval,
    /// Whether the tip touches, at any tilt.
    pub is_tip: bool,
    /// The arc lengths of the contacts (m).
    pub arc_length: Interval,
    /// The forces at the contacts (N).
    pub force: Interval,
    pub(super) bounds: Bounds,
}

/// All contacts that explain one or several readings of one whisker, covered by cells; never less than all.
///
/// Several readings are combined where they belong, on the contact itself: a cell stays when one and the same shape can
/// explain all of them. The empty region is an answer.
///
/// Guarantee: every contact of the model within its limits whose exact values lie in the readings is in a cell, as
/// long as functions stay within twice what their second differences show over a cell.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactRegion {
    /// The cells, in a fixed order.
    pub cells: Vec<ContactCell>,
    model: ContactModel,
}

impl ContactRegion {
    /// The contacts of the side of `model` that explain all `readings`; without any, all contacts within whisker and limits.
    ///
    /// [`ContactRegion::of_parts`] takes those of the tip, too.
    ///
    /// Moments are read by the elastica unless the small-angle regime is asked for by name: a region is to keep the truth.
    ///
    /// # Errors
    /// Usage: a reading that is not finite; the small-angle regime of a whisker that has none.
    pub fn new(model: &ContactModel, readings: &[Reading], resolution: &Resolution) -> Result<Self> {
        Self::of_parts(model, readings, Parts::Side, resolution)
    }

    /// As [`ContactRegion::new`], with the contacts of the `parts` of the whisker that may touch.
    ///
    /// At the tip the force may have any tilt up to a right angle at which the whisker lies in front of the wall; a tip
    /// reads its whole length as arc length, and the size of its force as load.
    ///
    /// # Errors
    /// Usage: as [`ContactRegion::new`].
    pub fn of_parts(model: &ContactModel, readings: &[Reading], parts: Parts, resolution: &Resolution) -> Result<Self> {
        let mut own = model.clone();
        for reading in readings {
            reading.check()?;
            if let VirtualSensor::Moment(regime @ super::MomentRegime::SmallAngle) = reading.sensor {
                own = own.in_regime(regime, 0.0)?;
            }
        }
        let first = own.first_arc_length();
        let mut arc_lengths = Interval::new(first, own.length());
        let limit = |value: f64| Interval::new(-value * (1.0 + 1e-12), value * (1.0 + 1e-12));
        let limits = *own.limits();
        let mut demands: [Demand; 3] = [
            (|c| c.force, limit(limits.force)),
            (|c| c.moment, limit(limits.moment)),
            (|c| c.phi_a, limit(limits.slope)),
        ];
        for Reading { sensor, value } in readings {
            let range = match sensor {
                VirtualSensor::Strip => &mut arc_lengths,
                VirtualSensor::Load => &mut demands[0].1,
                VirtualSensor::Moment(_) => &mut demands[1].1,
                VirtualSensor::Slope => &mut demands[2].1,
            };
            *range = range.intersection(*value);
        }
        if arc_lengths.is_empty() || demands.iter().any(|(_, range)| range.is_empty()) {
            return Ok(Self { cells: Vec::new(), model: own });
        }
        let bounded = |demand: &Demand| demand.1.lo().is_finite() || demand.1.hi().is_finite();
        let demands: Vec<Demand> = demands.into_iter().filter(bounded).collect();
        let mut cells = Vec::new();
        if parts.side() {
            let pieces = pave(&own, arc_lengths, &demands, resolution);
            cells.extend(pieces.iter().filter_map(|piece| cell(&own, piece)));
            cells.extend(base_cell(&own, &pieces, readings));
        }
        if parts.tip() && arc_lengths.hi() >= own.length() * (1.0 - ROUNDING) {
            match readings {
                // At a known load one tilt after the other is a contact.
                [Reading { sensor: VirtualSensor::Load, value }] if value.width() <= 0.0 && value.lo().abs() > 0.0 => {
                    cells.extend(tips_of_load(&own, value.lo(), resolution));
                }
                _ => {
                    let pieces = pave_tip(&own, &demands, resolution);
                    cells.extend(pieces.iter().filter_map(|piece| cell(&own, piece)));
                }
            }
        }
        Ok(Self { cells, model: own })
    }

    /// The contacts on exact curves, cut into cells of about `resolution.rim` and `resolution.slope`: along a curve that is known
    /// in closed form this takes fewer cells than a search.
    #[must_use]
    pub fn along(set: &ContactSet, resolution: &Resolution) -> Self {
        let curves = set.curves.iter().map(ContactCurve::contacts);
        let mut cells: Vec<ContactCell> =
            curves.flat_map(|contacts| run_cells(contacts, set.tolerance, Chart::Side, resolution)).collect();
        let first = set.model().first_arc_length();
        if let Some(near) = cells.iter().find(|c: &&ContactCell| c.arc_length.lo() <= 1.001 * first).cloned()
            && let Some(cover) = ConvexPolygon::hull(&[Vec2::ZERO]).map(|p| p.grown(first))
        {
            let slope = Interval::new(near.slope.lo().min(0.0), near.slope.hi().max(0.0));
            cells.push(ContactCell { bounds: cover.bounds(), cover, radius: 2.0 * first, slope, wall: slope, ..near });
        }
        Self { cells, model: set.model().clone() }
    }

    /// Both regions' cells in one: of one whisker, say its side's and its tip's.
    #[must_use]
    pub fn joined(mut self, other: Self) -> Self {
        self.cells.extend(other.cells);
        self
    }

    /// The model whose contacts these are.
    #[must_use]
    pub fn model(&self) -> &ContactModel {
        &self.model
    }

    /// Whether no contact explains the readings.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// Whether a contact at `point` (m, whisker frame) may explain the readings.
    #[must_use]
    pub fn contains(&self, point: Vec2) -> bool {
        self.cells.iter().any(|cell| cell.bounds.contains(point) && cell.cover.contains(point))
    }

    /// Whether a contact may explain the readings: its place, slope and arc length together.
    #[must_use]
    pub fn explains(&self, contact: &Contact) -> bool {
        self.cells.iter().any(|cell| {
            cell.bounds.contains(contact.position)
                && cell.slope.contains(contact.phi_a)
                && cell.cover.contains(contact.position)
        })
    }

    /// The area of the places (m²), at most this.
    #[must_use]
    pub fn area(&self) -> f64 {
        let covers: Vec<ConvexPolygon> = self.cells.iter().map(|cell| cell.cover.clone()).collect();
        union_area(&covers, AREA_COLUMNS)
    }

    /// The connected components: indices of cells, in order of their first.
    ///
    /// Sets that are connected are never taken apart; sets closer than the resolution may be joined.
    #[must_use]
    pub fn components(&self) -> Vec<Vec<usize>> {
        let mut order: Vec<usize> = (0..self.cells.len()).collect();
        order.sort_by(|&a, &b| self.cells[a].bounds.min.x.total_cmp(&self.cells[b].bounds.min.x));
        let mut parent: Vec<usize> = (0..self.cells.len()).collect();
        for (rank, &a) in order.iter().enumerate() {
            let here = &self.cells[a];
            for &b in order[rank + 1..].iter().take_while(|&&b| self.cells[b].bounds.min.x <= here.bounds.max.x) {
                let there = &self.cells[b];
                let (ra, rb) = (root(&mut parent, a), root(&mut parent, b));
                if ra != rb && here.bounds.overlaps(there.bounds) && here.cover.intersection(&there.cover).is_some() {
                    parent[ra.max(rb)] = ra.min(rb);
                }
            }
        }
        let mut groups: Vec<Vec<usize>> = vec![Vec::new(); self.cells.len()];
        for i in 0..self.cells.len() {
            let top = root(&mut parent, i);
            groups[top].push(i);
        }
        groups.retain(|group| !group.is_empty());
        groups
    }

    /// Keeps the contacts that another whisker can make at the same place: both touch one point.
    ///
    /// `own_from_other` is the other whisker's base seen from this one's.
    #[must_use]
    pub fn shared_with(&self, other: &Self, own_from_other: Pose2) -> Self {
        let moved: Vec<(Bounds, ConvexPolygon)> = other
            .cells
            .iter()
            .map(|cell| cell.cover.moved(|p| own_from_other.transform_point(p)))
            .map(|cover| (cover.bounds(), cover))
            .collect();
        let touches = |cell: &ContactCell| {
            moved
                .iter()
                .any(|(bounds, cover)| bounds.overlaps(cell.bounds) && cover.intersection(&cell.cover).is_some())
        };
        Self { cells: self.cells.iter().filter(|cell| touches(cell)).cloned().collect(), model: self.model.clone() }
    }
}

fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}

fn cell(model: &ContactModel, piece: &PavingCell) -> Option<ContactCell> {
    let (contact, cover) = (piece.middle()?, piece.cover()?);
    let radius = cover.corners().iter().map(|p| p.distance(contact.position)).fold(0.0, f64::max);
    let force = piece.range(&|c| c.force);
    Some(ContactCell {
        contact,
        radius,
        slope: piece.range(&|c| c.phi_a),
        wall: piece.range(&piece.chart.wall()),
        is_tip: piece.chart == Chart::Tip,
        arc_length: match piece.chart {
            Chart::Side => Interval::new(piece.s[0], piece.s[1]),
            Chart::Tip => Interval::point(model.length()),
        },
        // The load number's sign is the force's, exactly.
        force: force.intersection(Interval::new(
            if piece.v[0] >= 0.0 { 0.0 } else { -f64::INFINITY },
            if piece.v[1] <= 0.0 { 0.0 } else { f64::INFINITY },
        )),
        bounds: cover.bounds(),
        cover,
    })
    .filter(|cell| cell.radius <= 2.0 * model.length())
}

/// The contacts nearer to the base than the first arc length: one cell around the base, when the region reaches there.
fn base_cell(model: &ContactModel, pieces: &[PavingCell], readings: &[Reading]) -> Option<ContactCell> {
    let first = model.first_arc_length();
    let strip_allows = |r: &Reading| r.sensor != VirtualSensor::Strip || r.value.lo() <= first;
    if !readings.iter().all(strip_allows) {
        return None;
    }
    let near = || pieces.iter().filter(|piece| piece.s[0] <= first);
    let contact = Contact { s_a: 0.5 * first, position: Vec2::new(0.5 * first, 0.0), ..near().next()?.middle()? };
    let cover = ConvexPolygon::hull(&[Vec2::ZERO])?.grown(first);
    let hull_of = |quantity: &dyn Fn(&Contact) -> f64| {
        near().map(|piece| piece.range(quantity)).fold(Interval::EMPTY, Interval::hull)
    };
    let (slope, force) = (hull_of(&|c| c.phi_a), hull_of(&|c| c.force));
    let middle = 0.5 * (slope.lo() + slope.hi());
    let slope = Interval::new(slope.lo().clamp(-TAU, 0.0), slope.hi().clamp(0.0, TAU));
    Some(ContactCell {
        contact: Contact { phi_a: middle, ..contact },
        radius: 2.0 * first,
        slope,
        wall: slope,
        is_tip: false,
        arc_length: Interval::new(0.0, first),
        force: if force.lo() < 0.0 && force.hi() > 0.0 {
            Interval::new(f64::NEG_INFINITY, f64::INFINITY)
        } else {
            force
        },
        bounds: cover.bounds(),
        cover,
    })
}
