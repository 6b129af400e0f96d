//! Set-membership state estimation \[jaulin2001applied, ch. 3-6; jaulin2009robust\]: a paving of cells encloses all states that
//! the readings allow. A cell is a parallelotope; readings contract cells, and SIVIA bisects them.
//!
//! A state explains a reading if some single contact of the whisker with the map does, history or not. The first
//! reading that needs a contact lays cells along every boundary; from then on each reading cuts the cells that it
//! meets, and cells that do not explain it die. Work is bounded for each row: cells that had no turn yet stay as they
//! are, which is never wrong. `docs/possibilistic.md` gives the reasons why nothing true is lost.

mod agenda;
mod band_blur;
mod clusters;
mod constraint_order;
mod contact_tables;
mod contraction;
mod contractor;
mod edge_contractor;
mod errors;
mod free_space;
mod initial_cover;
mod last_effort;
mod measure;
mod parallelotope;
mod record;
mod sivia;
#[cfg(test)]
mod tests;
mod thick_piece;
mod two_contact_cover;
mod two_contacts;
mod vertex_contractor;

use crate::beam::press::ContactTable;
use crate::config::PossibilisticOptions;
use crate::flow::prior;
use crate::math;
use crate::plane::{Bounds, Pose2, wrap_angle};
use crate::sets::{Interval, StateBox};
use crate::world::{Map, MountedWhisker, Robot};
use crate::{Stop, WorkBudget};
use agenda::Task;
use constraint_order::ConstraintOrder;
use contact_tables::{FIRST_TABLE, TABLES, each_table, tables};
use contractor::{BaseView, BoundaryLevels};
use errors::{PoseSlack, StepBounds, UncertainWhisker};
pub use measure::EnclosedPlace;
pub(crate) use measure::Measurement;
use parallelotope::{Parallelotope, contract_box};
use record::{OdometryRecord, ReadingContacts};
use std::collections::VecDeque;
use two_contacts::TwoContacts;

/// Rows have so many times their work as long as there are cells that no reading has met.
const FIRST_WORK_FACTOR: usize = 3;
/// Odometry may be off by this much before a cell is moved to the present row (m).
const STALE: f64 = 5e-5;
/// And a cell that is wide in heading is moved when the robot is this far away (m).
const FAR: f64 = 0.03;
/// Readings are kept for cells that come late at least this far apart (m of the robot's way), and at most so many.
const KEPT_EVERY: f64 = 1e-3;
const MOST_KEPT: usize = 160;
/// So many looks at pieces of boundary and contacts are one more piece of work.
const COMPARISONS_PER_WORK: usize = 12;
/// The place of a base is checked once in so many records.
const CHECK_BASE_EVERY: u32 = 8;

/// A whisker with its tables.
#[derive(Clone, Debug)]
struct TabledWhisker {
    whisker: UncertainWhisker,
    /// From fine to coarse.
    tables: Vec<ContactTable>,
}

/// One row of the log.
#[derive(Clone, Debug)]
struct LogRecord {
    stand: OdometryRecord,
    /// What each whisker felt; empty once it is forgotten.
    touches: Vec<ReadingContacts>,
    heading: Option<Interval>,
    /// How far from where the odometry has it the robot may have been when it read.
    late: PoseSlack,
}

/// The states that explain the readings so far.
#[derive(Clone, Debug)]
pub struct PossibleSet {
    options: PossibilisticOptions,
    odometry: StepBounds,
    /// Rows whose odometry is known and whose readings have not come yet.
    ahead: VecDeque<OdometryRecord>,
    ground: BoundaryLevels,
    /// Where two contacts are reckoned with.
    two_contacts: Option<TwoContacts>,
    probes: Vec<TabledWhisker>,
    records: Vec<LogRecord>,
    /// Records that still have their readings, but for the newest.
    kept: Vec<u32>,
    kept_every: f64,
    cells: Vec<Parallelotope>,
    starts: usize,
    /// The record of the first contact.
    started_at: u32,
    cursor: usize,
    /// How many turns it takes until every cell has met a reading.
    untried: usize,
    constraint_order: ConstraintOrder,
    /// What is still to be done, the last first.
    agenda: Vec<Task>,
    /// Whether the final refinement ended for want of work.
    is_cut_short: bool,
    stop: Stop,
}

impl PossibleSet {
    /// The set of everything: no reading yet.
    #[must_use]
    pub fn new(map: &Map, robot: &Robot, options: PossibilisticOptions) -> Self {
        let whisker = |whisker: &MountedWhisker| UncertainWhisker::new(whisker, robot.map_scale, options.largest_slope);
        let whiskers: Vec<UncertainWhisker> = robot.whiskers.iter().map(whisker).collect();
        let tables = each_table(whiskers.iter(), |whisker| tables(FIRST_TABLE, TABLES, whisker, &options));
        let longest = whiskers.iter().map(|whisker| whisker.longest).fold(0.0, f64::max);
        let steepest = whiskers.iter().map(|whisker| math::atan(whisker.friction)).fold(0.0, f64::max);
        let ground = BoundaryLevels::new(map);
        let probe = |(whisker, tables)| TabledWhisker { whisker, tables };
        let probes = whiskers.into_iter().zip(tables).map(probe).collect();
        Self {
            options,
            odometry: StepBounds::new(robot),
            ahead: VecDeque::new(),
            two_contacts: options.two_contacts.map(|_| TwoContacts::new(&ground.coarse.all, longest, steepest)),
            ground,
            probes,
            records: Vec::new(),
            kept: Vec::new(),
            kept_every: KEPT_EVERY,
            cells: Vec::new(),
            starts: 0,
            started_at: 0,
            cursor: 0,
            untried: 0,
            constraint_order: ConstraintOrder::default(),
            agenda: Vec::new(),
            is_cut_short: false,
            stop: Stop::default(),
        }
    }

    /// Takes a request to end early: from then on no cell gets smaller, and all that explain the readings stay.
    pub fn heed(&mut self, stop: &Stop) {
        self.stop = stop.clone();
    }

    /// Whether a contact has laid the first cells.
    #[must_use]
    pub fn has_started(&self) -> bool {
        self.starts > self.options.tolerate
    }

    /// Whether no state explains the readings.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.has_started() && self.cells.is_empty()
    }

    /// Whether the final refinement has used up its work: with more of it the set may be smaller.
    pub(crate) fn is_cut_short(&self) -> bool {
        self.is_cut_short
    }

    /// The middles of the cells at the newest row.
    #[must_use]
    pub fn middles(&self) -> Vec<Pose2> {
        self.now().map(|cell| cell.center).collect()
    }

    /// An upper bound of the volume (m² rad).
    #[must_use]
    pub fn volume(&self) -> f64 {
        self.cells.iter().map(Parallelotope::volume).sum()
    }

    /// How many cells enclose the set.
    #[must_use]
    pub fn len(&self) -> usize {
        self.cells.len()
    }

    /// Takes one row: the odometry, each whisker's interval of moments (N m), and an absolute heading (rad).
    pub fn update(&mut self, map: &Map, odom_from_robot: Pose2, moments: &[Interval], heading: Option<Interval>) {
        self.foresee(odom_from_robot);
        self.read(map, moments, heading, (0.0, 0.0));
    }

    /// Takes the odometry of a row whose readings come later.
    pub(crate) fn foresee(&mut self, odom_from_robot: Pose2) {
        let last = self.ahead.back().or(self.records.last().map(|last| &last.stand));
        let stand = match last {
            Some(last) => last.next(odom_from_robot, &self.odometry),
            None => OdometryRecord::first(odom_from_robot),
        };
        self.ahead.push_back(stand);
    }

    /// Takes the readings of the earliest row that has none yet, or no readings where nothing is known of them; when they
    /// were taken, the odometry's way to the robot (m) and its turn (rad) from that row were at most `late`.
    pub(crate) fn read(&mut self, map: &Map, moments: &[Interval], heading: Option<Interval>, late: (f64, f64)) {
        self.begin_reading(moments, heading, late);
        self.advance(map, &mut WorkBudget::unlimited());
    }

    /// Forgets the readings of the last record unless they are worth keeping.
    fn forget(&mut self) {
        let Some(last) = self.records.len().checked_sub(1) else { return };
        // The first contact waits for cells that had no turn yet.
        let is_birth = self.starts > 0 && last == self.started_at as usize;
        if is_birth || self.is_apart(self.records[last].stand.path()) {
            self.kept.push(last as u32);
        } else {
            self.records[last].touches = Vec::new();
        }
        if self.kept.len() > MOST_KEPT {
            self.kept_every *= 2.0;
            let (mut index, kept) = (0, std::mem::take(&mut self.kept));
            for record in kept {
                if index % 2 == 0 {
                    self.kept.push(record);
                } else {
                    self.records[record as usize].touches = Vec::new();
                }
                index += 1;
            }
        }
    }

    /// Whether a record this far along the way is worth keeping.
    fn is_apart(&self, way: f64) -> bool {
        let last = self.kept.last();
        last.is_none_or(|&k| way - self.records[k as usize].stand.path() >= self.kept_every)
    }

    /// Where on the map a whisker can touch at the newest row, with the first pose in the prior's region.
    fn near(&self, whisker: &UncertainWhisker) -> Option<Bounds> {
        let (first, last) = (&self.records.first()?.stand, self.records.last()?);
        let (step, place, turn) = first.until(&last.stand);
        let arm = step.compose(whisker.mount()).position();
        let (late, mounted) = (last.late, whisker.mounted());
        let slack = place + arm.norm() * turn + late.place + arm.norm() * late.turn + mounted.place;
        Some(prior::around(self.options.prior?, arm, slack, whisker.longest))
    }

    /// The part of a new cell that has the heading known at its row, and from which the robot was in the region where it is
    /// known to have started.
    fn with_prior_knowledge(&self, cell: Parallelotope) -> Option<Parallelotope> {
        let there = &self.records[cell.anchor as usize];
        let cell = there.heading.map_or(Some(cell), |heading| with_heading_in(cell, 0.0, there.late.turn, heading))?;
        let Some(prior) = self.options.prior else { return Some(cell) };
        let (step, place, turn) = there.stand.until(&self.records[0].stand);
        within(cell, step, (place, turn), &prior)
    }

    /// What is left of a cell that met one reading, after the one that it was born from and what is known from before; older
    /// cells stay.
    fn contracted_by_first(&self, map: &Map, mut cell: Parallelotope, work: &mut usize) -> Option<Parallelotope> {
        if !cell.is_fresh {
            return Some(cell);
        }
        cell.is_fresh = false;
        // The newest it has met.
        if self.started_at as usize + 1 < self.records.len() {
            cell = self.contracted_by(map, cell, self.started_at, true, work)?;
        }
        let earlier = self.kept.iter().rev().filter(|&&k| k < self.started_at).step_by(4).take(4);
        earlier.copied().try_fold(cell, |cell, k| self.contracted_by(map, cell, k, false, work))
    }

    /// What is left of a cell after one record; none when it cannot explain it. The work grows with the boundary around.
    fn contracted_by(
        &self,
        map: &Map,
        cell: Parallelotope,
        record: u32,
        look: bool,
        work: &mut usize,
    ) -> Option<Parallelotope> {
        let mut comparisons = 0;
        let met = self.contracted(map, cell, record, look, &mut comparisons);
        // No work is left once the end is asked for: what is not met stays possible.
        let left = if self.stop.is_asked() { 0 } else { *work };
        *work = left.saturating_sub(1 + comparisons / COMPARISONS_PER_WORK);
        met
    }

    fn contracted(
        &self,
        map: &Map,
        cell: Parallelotope,
        record: u32,
        look: bool,
        comparisons: &mut usize,
    ) -> Option<Parallelotope> {
        // Where misses are counted, no reading may count twice.
        if self.options.tolerate > 0 && record <= cell.seen {
            return Some(cell);
        }
        let there = &self.records[record as usize];
        let mut cell = cell;
        let (mut step, mut place, mut turn) = self.records[cell.anchor as usize].stand.until(&there.stand);
        let bends = step.position().norm_squared() > FAR * FAR;
        if record > cell.anchor && (place > STALE || bends) {
            cell.transport(step, record);
            cell.inflate(place, turn);
            (step, place, turn) = (Pose2::IDENTITY, 0.0, 0.0);
        }
        cell.seen = cell.seen.max(record);
        if let Some(heading) = there.heading {
            cell = with_heading_in(cell, step.theta, turn + there.late.turn, heading)?;
        }
        let is_late = self.is_late(record);
        for touch in &there.touches {
            let off = (place + there.late.place, turn + there.late.turn);
            let view = BaseView::new(&cell, step, off, touch.robot_from_whisker).with_base(touch.base);
            if look && !free_space::base_may_be_free(&view, map) {
                return None;
            }
            if touch.free && free_space::whisker_may_be_free(&view, &touch.rest, &self.ground.coarse.all) {
                continue;
            }
            let two = self.two_contacts.as_ref().filter(|_| is_late);
            // What tells two contacts from one is known of uniform whiskers alone.
            if two.is_some_and(|two| (view.is_wide() || !touch.is_uniform) && two.may_be_near(&view, touch)) {
                continue;
            }
            let left = contractor::contract(&view, touch, &self.ground, comparisons);
            let may_be_two = |two: &TwoContacts| two.may_explain(&view, touch, &mut *comparisons);
            if !contraction::is_whole(&left) && two.is_some_and(may_be_two) {
                continue;
            }
            match left {
                // With misses left, the part that does not explain the reading stays possible, too.
                Some(_) if (cell.missed as usize) < self.options.tolerate => {}
                Some(left) => cell.contract_to(&left),
                None if (cell.missed as usize) < self.options.tolerate => cell.missed += 1,
                None => return None,
            }
        }
        Some(cell)
    }

    /// Where the odometry stood at a row.
    fn stand(&self, row: usize) -> Option<&OdometryRecord> {
        let ahead = || self.ahead.get(row.checked_sub(self.records.len())?);
        self.records.get(row).map(|record| &record.stand).or_else(ahead)
    }

    /// Whether the whisker may touch in two places at a record, as far as it is told.
    fn is_late(&self, record: u32) -> bool {
        let swept = |record: u32| self.records[record as usize].stand.swept();
        // Before there are cells the record is the first contact.
        let first = if self.starts > 0 { self.started_at } else { record };
        self.options.two_contacts.is_some_and(|way| swept(record) - swept(first) >= way)
    }

    /// The cells at the newest row, moved one by one: of the boundary of a large map there are hundreds of thousands.
    fn now(&self) -> impl ExactSizeIterator<Item = Parallelotope> + Clone {
        let newest = (self.records.len() + self.ahead.len()).saturating_sub(1);
        self.cells.iter().map(move |cell| {
            let mut cell = *cell;
            if let Some(now) = self.stand(newest).filter(|_| cell.anchor as usize != newest) {
                let there = &self.records[cell.anchor as usize].stand;
                let (step, place, turn) = there.until(now);
                cell.transport(step, newest as u32);
                cell.inflate(place, turn);
            }
            cell
        })
    }
}

impl Parallelotope {
    /// Keeps what explains a reading.
    fn contract_to(&mut self, left: &contraction::Contraction) {
        let (mut form, mut middle) = (left.form, 0.0);
        for (k, &(lo, hi)) in form.iter_mut().zip(&left.part) {
            middle += *k * 0.5 * (lo + hi);
            *k *= 0.5 * (hi - lo);
        }
        self.restrict(&left.part);
        self.contract(&form, (left.range.0 - middle, left.range.1 - middle));
    }
}

/// The part of the cell from which the robot, after `step`, is in a box.
fn within(
    cell: Parallelotope,
    step: Pose2,
    (place, turn): (f64, f64),
    bounds: &[[f64; 2]; 3],
) -> Option<Parallelotope> {
    let view = BaseView::new(&cell, step, (place, turn), Pose2::IDENTITY);
    let mut part = [(-1.0, 1.0); 3];
    let at = [view.base.x, view.base.y, wrap_near(view.heading, 0.5 * (bounds[2][0] + bounds[2][1]))];
    let slop = [view.slop, view.slop, turn];
    for axis in 0..3 {
        let form = [0, 1, 2].map(|j| [view.moves[j].x, view.moves[j].y, view.turns[j]][axis]);
        let [lo, hi] = bounds[axis];
        if !contract_box(&mut part, &form, (lo - at[axis] - slop[axis], hi - at[axis] + slop[axis])) {
            return None;
        }
    }
    let mut cell = cell;
    cell.restrict(&part);
    Some(cell)
}

/// The part of the cell whose heading, after a turn known to `off`, is in an interval.
fn with_heading_in(cell: Parallelotope, turn: f64, off: f64, heading: Interval) -> Option<Parallelotope> {
    let middle = 0.5 * (heading.lo() + heading.hi());
    let at = wrap_near(cell.center.theta + turn, middle);
    let form = cell.sides.map(|s| s[2]);
    let mut part = [(-1.0, 1.0); 3];
    if !contract_box(&mut part, &form, (heading.lo() - at - off, heading.hi() - at + off)) {
        return None;
    }
    let mut cell = cell;
    cell.restrict(&part);
    Some(cell)
}

fn wrap_near(angle: f64, middle: f64) -> f64 {
    middle + wrap_angle(angle - middle)
}

impl PossibleSet {
    /// The boxes that hold every possible state at the newest row, map frame; long cells are cut into several.
    #[must_use]
    pub fn boxes(&self) -> Vec<StateBox> {
        measure::boxes(self.now())
    }

    /// The separate places at the newest row, the largest share of the volume first.
    #[must_use]
    pub fn places(&self) -> Vec<EnclosedPlace> {
        measure::places(self.now())
    }

    /// Places of an earlier row, by its index, at the newest row: as the odometry carries them, with its bounds.
    pub(crate) fn carried(&self, places: &[EnclosedPlace], row: usize) -> Vec<EnclosedPlace> {
        let newest = (self.records.len() + self.ahead.len()).saturating_sub(1);
        let (Some(then), Some(newest)) = (self.stand(row), self.stand(newest)) else { return Vec::new() };
        let (step, off, turn) = then.until(newest);
        places.iter().map(|place| measure::carried(place, step, (off, turn))).collect()
    }

    /// Upper bounds of the area that the set covers (m²) and of its volume (m² rad), at the newest row.
    #[must_use]
    pub fn size(&self) -> (f64, f64) {
        measure::size(self.now(), true)
    }

    /// The measurement of the set, which takes longer to tell sharply, before any work.
    pub(crate) fn measurement(&self, sharp: bool) -> Measurement {
        Measurement::new(self.now(), sharp)
    }
}
