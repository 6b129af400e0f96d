//! The smoother row by row: waiting for contact, global localization, tracking, and global localization again when lost
//! \[thrun2005probabilistic, ch. 7-8\].

use super::bank::{BankContext, GlobalLocalization, HypothesisBank, MOST_TEMPERED};
use super::calibrated_path::CalibrationPrior;
use super::congruent_places::congruent_places;
use super::consistency::Consistency;
use super::log_window::LogWindow;
use super::map_symmetry::MapSymmetries;
use super::multistart::multistart;
use super::packed_hypothesis::PackedHypothesis;
use super::places::{self, PosteriorPlace};
use super::running_estimate;
use super::sensor::{OUTLIER_COST, Sensor};
use crate::beam::{TipModel, TipTable};
use crate::config::ProbabilisticOptions;
use crate::contact::{Boundaries, SensedQuantity};
use crate::plane::Pose2;
use crate::world::{Map, Robot};

/// Free rows that are kept before a contact: what the whisker did not touch.
const LEAD_ROWS: usize = 24;
/// Travel between them (m).
const LEAD_STEP: f64 = 1.5e-3;
/// So many readings in a row begin or end a contact; fewer are taken for false ones.
const CONTACT_ROWS: usize = 3;
/// Over so many used rows the fit is watched, and a mean cost above this says that no hypothesis explains them, those
/// that are tolerated left out.
const WATCHED: usize = 40;
const LOST_COST: f64 = 2.2;
/// More seedings than this are not tried, unless one has held for so many rows.
const MOST_STARTS: u32 = 6;
const TRUSTED: usize = 300;
/// Fewest rows of contact to seed from.
const FEWEST_ROWS: usize = 5;

/// Readings that are run through the forward model in one call while hypotheses are searched for (some milliseconds), and rows
/// that are caught up with in one call afterwards.
const SLICE: usize = 4000;
const CAUGHT_UP: usize = 2;
/// The odometry is corrected so often in the rows that are kept, and so often in turn with the places before rows are marginalised.
const CORRECTED: usize = 8;
const CORRECTIONS: usize = 3;
/// With more hypotheses than this for each place of the boundary that was tried, and as long as a contact has not been followed for this many times the
/// usual travel, it is followed for longer, by this factor.
const MANY_STARTS: f64 = 2.0;
const MOST_PATIENCE: f64 = 4.0;
const PATIENCE: f64 = 2.0;

/// What a row did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepOutcome {
    /// Nothing that changes the set.
    Nothing,
    /// Hypotheses were made, this many.
    Started(usize),
    /// The hypotheses took in the reading.
    Updated,
    /// No hypothesis explains the readings any more.
    Lost,
}

/// Where the corridor stands.
enum Phase {
    /// No contact yet.
    Waiting,
    /// In a first contact, which began at this row of the history; with what an earlier search has found.
    Pressing { sensor: usize, onset: usize, from_free: bool, travelled: f64, found: Vec<PackedHypothesis> },
    /// Looking for hypotheses, while rows go on.
    Searching(GlobalLocalization),
    /// With hypotheses.
    Tracking(HypothesisBank),
}

/// The hypotheses of one robot on one map.
pub struct ProbabilisticSet<'a> {
    map: &'a Map,
    robot: &'a Robot,
    options: ProbabilisticOptions,
    ground: Boundaries,
    symmetries: MapSymmetries,
    table: TipTable,
    sensors: Vec<Sensor>,
    history: LogWindow,
    phase: Phase,
    /// Contact readings in a row for each whisker, and free ones.
    touching: Vec<usize>,
    free: usize,
    /// Least costs after each used row, the last few.
    costs: Vec<f64>,
    starts: u32,
    patience: f64,
    last: Option<Pose2>,
    /// Rows since the set was started, and its best hypothesis when it was last given up.
    tracked: usize,
    abandoned: Option<Pose2>,
}

impl<'a> ProbabilisticSet<'a> {
    /// An empty set; `tips` are the models of the robot's whiskers, in order, and `quantities` say what is read: the whisker's
    /// index and the sense, in the order of each row's readings.
    #[must_use]
    pub fn new(
        map: &'a Map,
        robot: &'a Robot,
        tips: &[TipModel],
        quantities: &[(usize, SensedQuantity)],
        options: ProbabilisticOptions,
    ) -> Self {
        let sensor = |&(whisker, quantity): &(usize, SensedQuantity)| {
            Some(Sensor::new(robot.whiskers.get(whisker)?, tips.get(whisker)?.clone(), quantity))
        };
        let sensors: Vec<Sensor> = quantities.iter().filter_map(sensor).collect();
        let ground = Boundaries::new(map).with_clearance(map);
        // The odometry's calibration parameters come to light over a long way only, and what is marginalised before they are known is reported around a wrong
        // path.
        let times = if CalibrationPrior::new(0.0, &robot.odometry).has_odometry() { 2 } else { 1 };
        let options = ProbabilisticOptions { window: times * options.window, ..options };
        Self {
            map,
            robot,
            options,
            symmetries: MapSymmetries::of(&ground),
            ground,
            table: TipTable::new(),
            history: LogWindow::new(&sensors),
            touching: vec![0; sensors.len()],
            sensors,
            phase: Phase::Waiting,
            free: 0,
            costs: Vec::new(),
            starts: 0,
            patience: 1.0,
            last: None,
            tracked: 0,
            abandoned: None,
        }
    }

    /// The hypotheses, once there are any.
    #[cfg(test)]
    pub(super) fn bank(&mut self) -> Option<&mut HypothesisBank> {
        if let Phase::Tracking(bank) = &mut self.phase { Some(bank) } else { None }
    }

    /// How many rows are kept: as many as the window, and a few.
    #[must_use]
    pub fn rows_kept(&self) -> usize {
        self.history.len()
    }

    /// The odometry frame in the map frame by the best hypothesis of the set that was last given up.
    #[must_use]
    pub fn abandoned(&self) -> Option<Pose2> {
        self.abandoned
    }

    /// How many hypotheses there are.
    #[must_use]
    pub fn len(&self) -> usize {
        match &self.phase {
            Phase::Tracking(bank) => bank.hypotheses.len() * bank.times(&self.symmetries),
            _ => 0,
        }
    }

    /// Whether there is no hypothesis.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn context(&self) -> BankContext<'_> {
        BankContext {
            map: self.map,
            ground: &self.ground,
            symmetries: &self.symmetries,
            table: &self.table,
            robot: self.robot,
            sensors: &self.sensors,
            options: &self.options,
        }
    }

    /// Takes in one row: the robot in the odometry frame, one reading for each sense (N m, N, rad), and the absolute
    /// heading (map frame, rad) where there is one.
    pub fn step(&mut self, odom_from_robot: Pose2, readings: &[f64], heading: Option<f64>) -> StepOutcome {
        let readings: Vec<f64> = readings.iter().zip(&self.sensors).map(|(m, f)| m * f.per_reading).collect();
        self.history.push(odom_from_robot, &readings);
        if let Some(heading) = heading {
            self.history.point(heading);
        }
        let travel = self.last.map_or(0.0, |last| last.position().distance(odom_from_robot.position()));
        let turn = self.last.map_or(0.0, |last| last.between(odom_from_robot).theta.abs());
        self.last = Some(odom_from_robot);
        let mut any = false;
        for (index, sensor) in self.sensors.iter().enumerate() {
            let contact = sensor.is_contact(readings[index]);
            any |= contact;
            self.touching[index] = if contact { self.touching[index] + 1 } else { 0 };
        }
        self.free = if any { 0 } else { self.free + 1 };
        let lever = self.sensors.iter().map(|f| f.length).fold(0.0, f64::max);
        match &mut self.phase {
            Phase::Waiting => self.wait(any),
            Phase::Pressing { travelled, .. } => {
                *travelled += travel.max(turn * lever);
                // A robot that rests with its whisker on a wall says the same again and again.
                if self.history.len() > self.options.window {
                    let newest = self.history.len() - 2;
                    self.history.drop_row(newest);
                }
                self.press(false)
            }
            Phase::Searching(_) => self.search(SLICE),
            Phase::Tracking(_) => self.track(),
        }
    }

    /// Looks for a contact that lasts.
    fn wait(&mut self, any: bool) -> StepOutcome {
        let last = self.history.len() - 1;
        if let Some(sensor) = self.touching.iter().position(|&rows| rows >= CONTACT_ROWS)
            && self.starts < MOST_STARTS
        {
            // After a loss the rows before this one are forgotten, although the whisker touched there, too.
            let onset = (last + 1).saturating_sub(CONTACT_ROWS);
            self.phase = Phase::Pressing { sensor, onset, from_free: onset > 0, travelled: 0.0, found: Vec::new() };
            return StepOutcome::Nothing;
        }
        if !any && last >= 2 {
            // The row before the last stays only if it is far enough from the one before it.
            let (before, middle) = (self.history.pose(last - 2), self.history.pose(last - 1));
            let turned = before.between(middle).theta.abs() * 0.1;
            if before.position().distance(middle.position()).max(turned) < LEAD_STEP {
                self.history.drop_row(last - 1);
            }
        }
        if self.history.len() > LEAD_ROWS + CONTACT_ROWS {
            self.history.forget(1);
        }
        StepOutcome::Nothing
    }

    /// Waits until the contact tells enough, or has ended.
    fn press(&mut self, at_end: bool) -> StepOutcome {
        let Phase::Pressing { sensor, onset, from_free, travelled, .. } = self.phase else {
            return StepOutcome::Nothing;
        };
        let ended = at_end || self.free >= CONTACT_ROWS;
        if travelled < self.options.seed_travel * self.patience && !ended {
            return StepOutcome::Nothing;
        }
        if self.history.len() < onset + FEWEST_ROWS + if ended { CONTACT_ROWS } else { 0 } {
            if ended {
                self.begin_again();
            }
            return StepOutcome::Nothing;
        }
        if !from_free && onset > 0 {
            self.history.forget(onset);
        }
        let onset = if from_free { onset } else { 0 };
        let found = match &mut self.phase {
            Phase::Pressing { found, .. } => core::mem::take(found),
            _ => Vec::new(),
        };
        let search = GlobalLocalization::new(
            &self.context(),
            &self.history,
            (sensor, onset),
            from_free,
            ended,
            travelled,
            found,
        );
        self.phase = Phase::Searching(search);
        self.search(if at_end { usize::MAX } else { SLICE })
    }

    /// Looks for hypotheses with this much work.
    fn search(&mut self, mut work: usize) -> StepOutcome {
        let Self { map, robot, options, ground, symmetries, table, sensors, history, phase, .. } = self;
        let Phase::Searching(search) = phase else { return StepOutcome::Nothing };
        let context = BankContext { map, ground, symmetries, table, robot, sensors, options };
        let Some(bank) = search.step(&context, history, &mut work) else { return StepOutcome::Nothing };
        let count = bank.hypotheses.len() * bank.times(symmetries);
        // A contact too weak or too short to tell headings or places apart is followed for longer before anything is decided.
        let many = count as f64 > MANY_STARTS * ground.total_length() / options.seed_spacing || search.is_cut();
        if many && !search.ended && self.patience < MOST_PATIENCE {
            self.patience *= PATIENCE;
            let GlobalLocalization { sensor, onset, from_free, travelled, .. } = *search;
            let found = core::mem::take(&mut search.found);
            self.phase = Phase::Pressing { sensor, onset, from_free, travelled, found };
            return StepOutcome::Nothing;
        }
        self.starts += 1;
        self.costs.clear();
        if count == 0 {
            self.begin_again();
            return StepOutcome::Lost;
        }
        self.phase = Phase::Tracking(bank);
        StepOutcome::Started(count)
    }

    /// Hands the row to the hypotheses and watches how they fare.
    fn track(&mut self) -> StepOutcome {
        let Self { map, robot, options, ground, symmetries, table, sensors, history, phase, tracked, .. } = self;
        let Phase::Tracking(bank) = phase else { return StepOutcome::Nothing };
        let context = BankContext { map, ground, symmetries, table, robot, sensors, options };
        let (used, next) = (bank.used.len(), bank.next);
        if history.heading().is_some() && bank.by_symmetry {
            bank.complete(&context, history);
            bank.expand_images(symmetries);
        }
        bank.step(&context, history, CAUGHT_UP);
        let often = (options.window / CORRECTED).max(1);
        let before = *tracked;
        *tracked += bank.next - next;
        if bank.shared.has_odometry() && before / often != *tracked / often {
            bank.complete(&context, history);
            bank.recalibrate_odometry(&context, history);
        }
        if history.len() > options.window {
            bank.complete(&context, history);
            let taken = bank.used.len() > used;
            if !bank.has_marginalised() {
                // The last time that all rows are there to say what else explains them.
                let equals = congruent_places(bank, &context, history);
                bank.hypotheses.extend(equals);
            }
            let first = !bank.has_marginalised();
            for _ in 0..CORRECTIONS {
                // What is marginalised is reported around this path for good.
                if !(bank.optimise_if_few(&context, history) && bank.recalibrate_odometry(&context, history)) {
                    break;
                }
            }
            if bank.optimise_if_few(&context, history) && first {
                // What is marginalised holds a place for good: on a map of facets it must not be the shallower of two minima.
                multistart(bank, &context, history);
            }
            bank.marginalise(&context, history, options.window / 4);
            if bank.may_search_congruent() {
                let equals = bank.congruent(&context, history);
                bank.hypotheses.extend(equals);
            }
            return if taken { StepOutcome::Updated } else { StepOutcome::Nothing };
        }
        if bank.used.len() == used {
            return StepOutcome::Nothing;
        }
        if bank.used.len() != used + 1 {
            self.costs.clear();
        }
        self.costs.push(bank.least());
        if self.costs.len() > WATCHED {
            // A whisker on its side is explained by no place: a share of the rows may count as false, in twice as many.
            let tolerated = (options.tolerated_share * self.tracked.min(options.window) as f64) as usize;
            let stale = self.costs.len().saturating_sub(WATCHED + 2 * tolerated + 1);
            self.costs.drain(..stale);
            let most = self.costs[0] + LOST_COST * WATCHED as f64 + OUTLIER_COST * tolerated as f64;
            let mut now = bank.least();
            if now > most && bank.shared.has_odometry() {
                // Along a wrong path the true place explains the readings no better than others.
                bank.complete(&context, history);
                for _ in 0..2 * CORRECTIONS {
                    if !(bank.recalibrate_odometry(&context, history) && bank.optimise_if_few(&context, history)) {
                        break;
                    }
                }
                now = bank.least();
            }
            if now > most {
                bank.complete(&context, history);
                bank.hypotheses.iter_mut().for_each(|h| h.cooldown = 0);
                bank.refit_tempered(&context, history, MOST_TEMPERED);
                now = bank.least();
            }
            if now > most {
                bank.retry_all_pruned(&context, history);
                now = bank.least();
            }
            if now > most {
                self.begin_again();
                return StepOutcome::Lost;
            }
        }
        if self.is_empty() {
            self.begin_again();
            return StepOutcome::Lost;
        }
        if self.tracked > TRUSTED {
            self.starts = 1;
        }
        StepOutcome::Updated
    }

    /// Forgets everything and starts from the present contact, or waits for the next.
    fn begin_again(&mut self) {
        self.abandoned = self.best().or(self.abandoned);
        self.tracked = 0;
        let rows = self.history.len();
        self.history.forget(rows.saturating_sub(1));
        self.patience = 1.0;
        self.costs.clear();
        self.phase = match self.touching.iter().position(|&rows| rows >= CONTACT_ROWS) {
            Some(sensor) if self.starts < MOST_STARTS => {
                Phase::Pressing { sensor, onset: 0, from_free: false, travelled: 0.0, found: Vec::new() }
            }
            _ => Phase::Waiting,
        };
    }

    /// The robot's pose by each hypothesis, with the odometry at `odom_from_robot`.
    #[must_use]
    pub fn states(&self, odom_from_robot: Pose2) -> Vec<Pose2> {
        match &self.phase {
            Phase::Tracking(bank) => {
                let frames = bank
                    .hypotheses
                    .iter()
                    .flat_map(|h| self.symmetries.images(h.map_from_odom).take(bank.times(&self.symmetries)));
                let odom_from_robot = self.history.corrected_from_raw().compose(odom_from_robot);
                frames.map(|frame| frame.compose(odom_from_robot)).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Area of the hypotheses' projection onto the plane (m²) and their volume (m² rad): ellipses that hold 95 %.
    #[must_use]
    pub fn size(&self) -> (f64, f64) {
        match &self.phase {
            Phase::Tracking(bank) => {
                let (area, volume) = places::size(bank);
                let times = bank.times(&self.symmetries) as f64;
                (times * area, times * volume)
            }
            _ => (0.0, 0.0),
        }
    }

    /// The best hypothesis now: the odometry frame in the map frame.
    #[must_use]
    pub fn best(&self) -> Option<Pose2> {
        match &self.phase {
            Phase::Tracking(bank) => {
                let last = self.history.pose(self.history.len() - 1);
                running_estimate::best(bank, last).map(|frame| frame.compose(self.history.corrected_from_raw()))
            }
            _ => None,
        }
    }

    /// The places by the hypotheses as they are linearised now, at the last row.
    #[must_use]
    pub fn places(&self) -> Vec<PosteriorPlace> {
        match &self.phase {
            Phase::Tracking(bank) => {
                running_estimate::places(bank, &self.symmetries, &self.history, &self.robot.odometry)
            }
            _ => Vec::new(),
        }
    }

    /// Ends the log: every hypothesis moved to its least cost over all rows that are kept, weighed and grouped.
    pub fn finish(&mut self) -> (Vec<PosteriorPlace>, Option<Consistency>) {
        // A search under way may ask for a longer contact than it began with: the rows since then are one.
        self.search(usize::MAX);
        if matches!(self.phase, Phase::Pressing { .. }) {
            self.press(true);
        }
        let Self { map, robot, options, ground, symmetries, table, sensors, history, phase, .. } = self;
        let Phase::Tracking(bank) = phase else { return (Vec::new(), None) };
        let context = BankContext { map, ground, symmetries, table, robot, sensors, options };
        bank.step(&context, history, usize::MAX);
        if history.heading().is_some() {
            bank.expand_images(symmetries);
        }
        let equals = bank.congruent(&context, history);
        bank.hypotheses.extend(equals);
        let (mut places, mut fit) = places::choose(bank, &context, history);
        // Another place may explain what this one does not, along another path.
        if fit.is_some_and(|fit| fit.is_biased()) && bank.retry_all_pruned(&context, history) {
            (places, fit) = places::choose(bank, &context, history);
        }
        let corrected = history.corrected_from_raw();
        places.iter_mut().for_each(|place| place.map_from_odom = place.map_from_odom.compose(corrected));
        (places, fit)
    }
}
