//! The smoother row by row: waiting for contact, global localization, tracking, and global localization again when lost
//! \[thrun2005probabilistic, ch. 7-8\].

use super::admission::Admission;
use super::bank::{Bank, Effort, TAKEN_TOGETHER};
use super::contact_episodes::{judging_rows, longest_contact};
use super::correlated_noise::NoiseModel;
use super::grid_search::{ContactOnset, GridSearch};
use super::log_window::LogWindow;
use super::map_symmetry::MapSymmetries;
use super::measurement::{MeasurementModel, Row, Start, State};
use super::optimisation::{Mode, UNEXPLAINED};
use super::places::{self, Fit, PosteriorPlace};
use super::sensor::{FreeLevel, Sensor};
use super::unknowns::{Sense, Unknowns};
use crate::beam::{TipModel, TipTable};
use crate::config::{ProbabilisticOptions, UndeclaredErrors};
use crate::contact::follow::{Mechanics, WhiskerState};
use crate::contact::{Boundaries, SensedQuantity};
use crate::coroutine::{Pace, completed};
use crate::flow::pose::Stretch;
use crate::flow::prior;
use crate::plane::{Bounds, Pose2, Vec2, wrap_angle};
use crate::world::{Map, Robot};

/// Free rows that are kept before a contact: what the whisker did not touch.
const LEAD_ROWS: usize = 24;
/// Travel between them (m).
const LEAD_STEP: f64 = 1.5e-3;
/// So many readings in a row begin or end a contact; fewer are taken for false ones.
const CONTACT_ROWS: usize = 3;
/// Fewest rows of contact to seed from.
pub(super) const FEWEST_ROWS: usize = 5;
/// Readings that are run through the forward model in one call while the grid is searched (some milliseconds).
const SLICE: usize = 4000;
/// Readings that are run in one call while modes take in rows.
const FITTED: usize = 2000;
/// With many cells a contact is followed for longer, by this factor, as long as it has not been followed for this many times the usual travel.
const PATIENCE: f64 = 2.0;
const MOST_PATIENCE: f64 = 4.0;
/// The best mode does not explain the last readings of a sensor where more than this share of them is unexplained, and how many these are.
const LOST_SHARE: f64 = 0.5;
const WATCHED: usize = 40;
/// A contact that is not explained is left out if so many readings of contact had been explained since the last such one, and the whisker may
/// touch more than one stretch of boundary: within this share of its length there are some whose normals differ by so much (rad).
const EXPLAINED: usize = 24;
const REACH: f64 = 1.1;
const OTHER_NORMAL: f64 = 0.3;
/// So many stretches in which readings were left out are kept.
const MOST_LEFT_OUT: usize = 200;
/// With more modes than this none are kept for a contact at the log's end that is not explained: each is some kilobytes.
const MANY_KEPT: usize = 500;
/// The zero of a sensor whose zero is not known exactly is tared by so many rows, if its readings may be those of a free whisker.
const TARE_ROWS: usize = 8;
/// More searches than this are not tried, unless one has held for so many rows.
const MOST_STARTS: u32 = 24;
const TRUSTED: usize = 300;
/// Each search of a contact that explains nothing waits for so much more travel than the one before, up to this many times the usual one.
const MOST_BACKOFF: f64 = 64.0;
/// Weight of what is marginalised, each time that rows are added to it.
const FORGETTING: f64 = 0.8;

/// What a row did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepOutcome {
    /// Nothing that changes the set.
    Nothing,
    /// Modes were made, this many.
    Started(usize),
    /// The modes took in the reading.
    Updated,
    /// The modes do not explain a sensor's contact, which is left out until the whisker is free: the sensor.
    SetAside(usize),
    /// No mode explains the readings any more.
    Lost,
}

/// Where the smoother stands.
enum Phase {
    /// No contact yet.
    Waiting,
    /// In a first contact, which began at this row of the window; with what an earlier search has found.
    Pressing { sensor: usize, onset: usize, from_free: bool, travelled: f64, search: Option<Box<GridSearch>> },
    /// Looking for modes, while rows go on; with how far the base had travelled, and whether the contact has ended.
    Searching { search: Box<GridSearch>, travelled: f64, ended: bool },
    /// With modes.
    Tracking(Box<Bank>),
}

/// What all parts of the smoother share.
pub(super) struct Scene<'a> {
    pub(super) map: &'a Map,
    /// The robot as it is declared, and with bounds of what it does not bound.
    pub(super) declared: &'a Robot,
    pub(super) robot: Robot,
    pub(super) options: ProbabilisticOptions,
    pub(super) ground: Boundaries,
    pub(super) symmetries: MapSymmetries,
    pub(super) table: TipTable,
    pub(super) sensors: Vec<Sensor>,
    pub(super) senses: Vec<Sense>,
    pub(super) whiskers: Vec<usize>,
    pub(super) unknowns: Unknowns,
    /// What is taken off the readings of each sensor, once it is known.
    pub(super) tare: Option<Vec<f64>>,
    /// When work pauses.
    pub(super) pace: Pace,
}

impl<'a> Scene<'a> {
    /// Rows that are kept: twice as many where the odometry is declared to be wrong, which what is marginalised does not know of.
    fn window(&self) -> usize {
        let odometry = &self.declared.odometry;
        let is_bounded = odometry.translation_relative > 0.0 || odometry.rotation_relative > 0.0;
        self.options.window * if is_bounded { 2 } else { 1 }
    }

    /// How far the odometry frame can have been shifted (m) and turned (rad) by errors of the odometry before the first row of a window.
    pub(super) fn drift(&self, window: &LogWindow) -> [f64; 2] {
        let ([way, turned], odometry) = (window.gone(), &self.robot.odometry);
        let turn = odometry.rotation_relative * turned;
        // A frame that turns about a place on the way shifts by no more than the way.
        [(odometry.translation_relative + turn) * way, turn]
    }

    /// How far the first pose by a mode may be beside the region for it (m) and turned (rad) although the robot was inside: by a cell, by
    /// what the odometry may have drifted, and by what mounts, lengths and the map's scale leave open. A heading that is `turn` off (rad)
    /// turns the way back to the first pose about the contact.
    pub(super) fn prior_slack(&self, window: &LogWindow, turn: f64) -> [f64; 2] {
        let way_back = window.pose(window.len() - 1).position().norm();
        let drift = self.drift(window);
        let mut mounted = [0.0_f64; 2];
        for errors in self.robot.whiskers.iter().map(|whisker| &whisker.errors) {
            let [x, y, heading] = errors.mount;
            mounted = [mounted[0].max(x.hypot(y) + errors.length), mounted[1].max(heading)];
        }
        let place = mounted[0] + (self.robot.map_scale + mounted[1] + turn) * way_back;
        [self.options.seed_spacing + drift[0] + place, self.options.seed_turn + drift[1] + mounted[1]]
    }

    /// The measurement model of a window.
    pub(super) fn model<'b>(&'b self, window: &'b LogWindow, anchor: usize) -> MeasurementModel<'b> {
        MeasurementModel {
            map: self.map,
            ground: &self.ground,
            sensors: &self.sensors,
            whiskers: &self.whiskers,
            unknowns: &self.unknowns,
            window,
            anchor,
            heading_std: self.options.heading_error / 3.0_f64.sqrt(),
            solver: Mechanics::Table(&self.table),
            noise_model: self.options.noise_model,
            whole: true,
            pace: &self.pace,
        }
    }
}

/// The modes of one robot on one map.
pub struct MultiHypothesisSmoother<'a> {
    scene: Scene<'a>,
    window: LogWindow,
    phase: Phase,
    /// Contact readings in a row for each sensor, and free ones.
    touching: Vec<usize>,
    free: usize,
    levels: Vec<FreeLevel>,
    /// For how many free rows the readings of each sensor are left out yet.
    aside: Vec<usize>,
    /// When readings were left out, the last of these.
    left_out: Vec<Stretch>,
    starts: u32,
    patience: f64,
    /// How often the set has begun anew in the present contact.
    begun_again: i32,
    last: Option<Pose2>,
    /// Rows since the set was started, and its best mode when it was last given up.
    tracked: usize,
    abandoned: Option<Pose2>,
    /// Its best mode when it last explained the rows.
    believed: Option<Pose2>,
    /// The modes when the best one last explained all that had just come, and how many rows of the window that were.
    explained: Option<(Box<Bank>, usize)>,
    /// Whether rows are marginalised in the modes, and whether contacts are neither there nor in the window any more.
    marginalised: bool,
    forgotten: bool,
    /// Whether none of the modes explains the last rows of the log.
    emptied_at_end: bool,
    /// From when on the places at the end are others than those that were believed (s).
    carried: Option<f64>,
    /// When the contacts began from which modes have been searched (s).
    searched: Vec<f64>,
}

impl<'a> MultiHypothesisSmoother<'a> {
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
            Some((Sensor::new(robot.whiskers.get(whisker)?, tips.get(whisker)?.clone(), quantity), whisker))
        };
        let (sensors, whiskers): (Vec<Sensor>, Vec<usize>) = quantities.iter().filter_map(sensor).unzip();
        let sense = |(sensor, &whisker): (&Sensor, &usize)| Sense {
            whisker,
            quantity: sensor.quantity,
            per_reading: sensor.per_reading,
        };
        let senses: Vec<Sense> = sensors.iter().zip(&whiskers).map(sense).collect();
        let declared = robot;
        let robot = match options.undeclared {
            UndeclaredErrors::Typical => declared.with_typical_errors(),
            UndeclaredErrors::None => declared.clone(),
        };
        let unknowns = Unknowns::new(&robot, &senses, options.shared_gain);
        let count = sensors.len();
        let ground = Boundaries::new(map).with_clearance(map);
        let scene = Scene {
            map,
            declared,
            tare: unknowns.zero_is_declared(&robot).then_some(()).map_or_else(|| Some(vec![0.0; count]), |()| None),
            robot,
            options,
            symmetries: MapSymmetries::of(&ground),
            ground,
            table: TipTable::new(),
            sensors,
            senses,
            whiskers,
            unknowns,
            pace: Pace::default(),
        };
        Self {
            scene,
            window: LogWindow::new(count),
            phase: Phase::Waiting,
            touching: vec![0; count],
            free: 0,
            levels: vec![FreeLevel::default(); count],
            aside: vec![0; count],
            left_out: Vec::new(),
            starts: 0,
            patience: 1.0,
            begun_again: 0,
            last: None,
            tracked: 0,
            abandoned: None,
            believed: None,
            explained: None,
            marginalised: false,
            forgotten: false,
            emptied_at_end: false,
            carried: None,
            searched: Vec::new(),
        }
    }

    /// Takes the middle of the first readings for the zero where they may be those of a free whisker.
    fn take_tare(&mut self) {
        let rows = self.window.len();
        let of = |index: usize| {
            let mut first: Vec<f64> = (0..rows).map(|row| self.window.readings(row)[index]).collect();
            first.sort_by(f64::total_cmp);
            let inner = &first[rows / 4..rows - rows / 4];
            let middle = inner.iter().sum::<f64>() / inner.len() as f64;
            let spread = first[rows - 1] - first[0];
            let whisker = &self.scene.robot.whiskers[self.scene.whiskers[index]];
            let sensor = &self.scene.sensors[index];
            let bound = whisker.errors.zero * sensor.per_reading;
            // A whisker that is pressed does not say the same again and again.
            if sensor.is_steady(middle, bound, spread) { middle } else { 0.0 }
        };
        let tare: Vec<f64> = (0..self.scene.sensors.len()).map(of).collect();
        self.window.subtract(&tare);
        self.scene.sensors.iter_mut().for_each(Sensor::tared);
        self.scene.tare = Some(tare);
        (0..rows).for_each(|row| self.tell_contacts(row));
    }

    /// Tells the window which whiskers are in contact at a row.
    fn tell_contacts(&mut self, row: usize) {
        let (t, readings) = (self.window.time(row), self.window.readings(row));
        let each = self.levels.iter_mut().zip(&self.scene.sensors).zip(readings);
        let told: Vec<bool> = each.map(|((level, sensor), &z)| level.is_contact(sensor, t, z)).collect();
        self.window.tell_contacts(row, told.into_iter());
    }

    /// Looks for a contact that lasts.
    fn wait(&mut self, any: bool) -> StepOutcome {
        let last = self.window.len() - 1;
        if let Some(sensor) = self.touching.iter().position(|&rows| rows >= CONTACT_ROWS)
            && self.starts < MOST_STARTS
        {
            // After a loss the rows before this one are forgotten, although the whisker touched there, too.
            let onset = (last + 1).saturating_sub(CONTACT_ROWS);
            self.patience = 1.0;
            self.phase = Phase::Pressing { sensor, onset, from_free: onset > 0, travelled: 0.0, search: None };
            return StepOutcome::Nothing;
        }
        if !any && last >= 2 {
            // The row before the last stays only if it is far enough from the one before it.
            let (before, middle) = (self.window.pose(last - 2), self.window.pose(last - 1));
            let turned = before.between(middle).theta.abs() * 0.1;
            if before.position().distance(middle.position()).max(turned) < LEAD_STEP {
                self.window.drop_row(last - 1);
            }
        }
        if self.window.len() > LEAD_ROWS + CONTACT_ROWS {
            self.forget(1);
        }
        StepOutcome::Nothing
    }

    /// Waits until the contact tells enough, or has ended.
    async fn press(&mut self, at_end: bool) -> StepOutcome {
        let Phase::Pressing { sensor, onset, from_free, travelled, .. } = self.phase else {
            return StepOutcome::Nothing;
        };
        let ended = at_end || self.free >= CONTACT_ROWS;
        if travelled < self.scene.options.seed_travel * self.patience && !ended {
            return StepOutcome::Nothing;
        }
        if self.window.len() < onset + FEWEST_ROWS + if ended { CONTACT_ROWS } else { 0 } {
            if ended {
                self.begin_again();
            }
            return StepOutcome::Nothing;
        }
        if !from_free && onset > 0 {
            self.forget(onset);
        }
        let onset = self.onset(sensor, if from_free { onset } else { 0 }, from_free);
        let before = match &mut self.phase {
            Phase::Pressing { search, .. } => search.take(),
            _ => None,
        };
        let search = match before {
            Some(mut search) => {
                search.resume(onset.rows);
                search
            }
            None => Box::new(GridSearch::new(&self.scene.model(&self.window, 0), onset, self.symmetries())),
        };
        self.phase = Phase::Searching { search, travelled, ended };
        self.search(if at_end { usize::MAX } else { SLICE }).await
    }

    /// The symmetries of the map, if nothing tells its images apart.
    fn symmetries(&self) -> Option<&MapSymmetries> {
        let all = Some(&self.scene.symmetries).filter(|symmetries| !symmetries.all.is_empty());
        all.filter(|_| self.scene.options.prior.is_none() && self.window.heading().is_none())
    }

    /// The contact that began at a row, and what judges it.
    fn onset(&self, sensor: usize, row: usize, from_free: bool) -> ContactOnset {
        let (own, options) = (&self.scene.sensors[sensor], &self.scene.options);
        let tip = Vec2::new(own.length, 0.0);
        let odom_from_whisker = self.window.pose(row).compose(own.robot_from_whisker);
        let before = self.window.pose(row.saturating_sub(3)).compose(own.robot_from_whisker);
        let arm = odom_from_whisker.position();
        let unknowns = &self.scene.unknowns;
        let std = |place: Option<usize>| place.map_or(0.0, |at| unknowns.all()[at - 3].std);
        let drifted = std(unknowns.drift[sensor]) * self.window.since_start(row);
        ContactOnset {
            sensor,
            row,
            from_free,
            approach: tip - odom_from_whisker.inverse_transform_point(before.transform_point(tip)),
            rows: judging_rows(&self.window, (sensor, own.length), row, options.seed_step),
            spacing: options.seed_spacing,
            turn: options.seed_turn,
            near: options.prior.map(|region| {
                let [place, turn] = self.scene.prior_slack(&self.window, 0.0);
                prior::around(region, arm, options.seed_spacing + place + arm.norm() * turn, own.length)
            }),
            priors: [std(unknowns.gain[sensor]), std(unknowns.zero[sensor]).hypot(drifted)],
        }
    }

    /// Looks for modes with this much work.
    async fn search(&mut self, mut work: usize) -> StepOutcome {
        let by_symmetry = self.symmetries().is_some();
        let Self { scene, window, phase, .. } = self;
        let Phase::Searching { search, travelled, ended } = phase else { return StepOutcome::Nothing };
        let model = scene.model(window, 0);
        let admission = Admission::of_cells(scene, window);
        let row = search.onset().row;
        let admits = |frame: Pose2| admission.satisfies_prior(frame) && admission.origin_is_free(frame, row);
        let is_last = *ended || self.patience >= MOST_PATIENCE;
        if !search.step(&model, &admits, is_last, &mut work).await {
            return StepOutcome::Nothing;
        }
        let travelled = *travelled;
        let Phase::Searching { search, .. } = core::mem::replace(phase, Phase::Waiting) else {
            return StepOutcome::Nothing;
        };
        let ContactOnset { sensor, row, from_free, .. } = *search.onset();
        // A contact too weak or too short to tell headings or places apart is followed for longer before anything is decided.
        if !is_last && search.is_many() {
            self.patience *= PATIENCE;
            self.phase = Phase::Pressing { sensor, onset: row, from_free, travelled, search: Some(search) };
            return StepOutcome::Nothing;
        }
        let cells = search.into_found(&model);
        self.starts += 1;
        self.searched.push(window.time(row));
        let mode = |cell: super::grid_search::Cell| {
            let start = if from_free {
                window_start(scene, window)
            } else {
                let robot = cell.frame.compose(window.pose(row));
                let mut states = vec![WhiskerState::Free; scene.sensors.len()];
                states[sensor] = cell.state;
                let bases = scene.sensors.iter().map(|s| robot.compose(s.robot_from_whisker)).collect();
                Start { states, bases, prior: None }
            };
            let state = State { frame: cell.frame, values: vec![0.0; scene.unknowns.all().len()] };
            Mode::new(state, start, NoiseModel::tracked(scene.options.noise_model))
        };
        let mut bank = Bank::new(cells.into_iter().map(mode).collect(), by_symmetry);
        bank.begin(&model, &|frame| admission.is_allowed(frame));
        self.phase = Phase::Tracking(Box::new(bank));
        self.fit(work).await
    }

    /// Goes on fitting modes with this much work.
    async fn fit(&mut self, mut work: usize) -> StepOutcome {
        let Self { scene, window, phase, .. } = self;
        let Phase::Tracking(bank) = phase else { return StepOutcome::Nothing };
        let model = scene.model(window, 0);
        let admission = Admission::of_cells(scene, window);
        if !bank.is_busy() {
            return StepOutcome::Nothing;
        }
        let was_fitted = bank.is_fitted;
        if !bank.advance(&model, &|frame| admission.is_allowed(frame), Effort::ONLINE, &mut work).await {
            return StepOutcome::Nothing;
        }
        if was_fitted {
            return self.judge().await;
        }
        let count = bank.modes.len() * bank.times(&scene.symmetries);
        if count == 0 {
            self.begin_again();
            return StepOutcome::Lost;
        }
        self.keep_explained().await;
        StepOutcome::Started(count)
    }

    /// Fits the modes when enough rows have come.
    async fn track(&mut self) -> StepOutcome {
        let Self { scene, window, phase, tracked, .. } = self;
        let Phase::Tracking(bank) = phase else { return StepOutcome::Nothing };
        *tracked += 1;
        if window.heading().is_some() && !bank.is_busy() {
            bank.expand_images(&scene.symmetries);
        }
        if self.tracked > TRUSTED {
            (self.starts, self.begun_again) = (1, 0);
        }
        let full = window.len() > scene.window();
        if !full && (bank.is_busy() || window.len() < bank.seen + TAKEN_TOGETHER) {
            let work = if bank.is_fitted { FITTED } else { SLICE };
            return if bank.is_busy() { self.fit(work).await } else { StepOutcome::Nothing };
        }
        let model = scene.model(window, 0);
        let admission = Admission::of_cells(scene, window);
        let admits = |frame: Pose2| admission.is_allowed(frame);
        if !full {
            bank.begin(&model, &admits);
            return self.fit(FITTED).await;
        }
        bank.extend(&model, &admits, Effort::ONLINE).await;
        bank.converge(&model).await;
        bank.marginalise(&model, scene.window() / 4, FORGETTING).await;
        self.explained = None;
        self.marginalised = true;
        window.forget(scene.window() / 4);
        self.judge().await
    }

    /// Looks whether the best mode explains the last rows. Where a sensor's are not explained after a contact that was, the whisker is in
    /// one that the model does not cover, and its readings say nothing of the place until it is free; otherwise the modes are wrong.
    async fn judge(&mut self) -> StepOutcome {
        match self.unexplained().await {
            None => {
                self.believed = self.best();
                self.keep_explained().await;
                StepOutcome::Updated
            }
            Some(Some((sensor, from))) => {
                (from..self.window.len()).for_each(|row| self.window.set_aside(row, sensor));
                self.aside[sensor] = CONTACT_ROWS;
                if self.left_out.len() >= MOST_LEFT_OUT {
                    self.left_out.remove(0);
                }
                let to = self.window.time(self.window.len() - 1);
                self.left_out.push(Stretch { from: self.window.time(from), to });
                if let Phase::Tracking(bank) = &mut self.phase {
                    bank.forget_fits();
                }
                StepOutcome::SetAside(sensor)
            }
            Some(None) => {
                self.relocalize();
                StepOutcome::Lost
            }
        }
    }

    /// Keeps the modes where the best one explains what has just come.
    async fn keep_explained(&mut self) {
        let Self { scene, window, phase, explained, .. } = self;
        let Phase::Tracking(bank) = phase else { return };
        let before = explained.as_ref().map_or(0, |(_, rows)| *rows);
        if bank.modes.len() <= MANY_KEPT && bank.explains_from(&scene.model(window, 0), before).await {
            *explained = Some((bank.clone(), bank.seen));
        }
    }

    /// The places by the modes before a contact at the end of the log which none of them explains: the model does not cover it, and nothing
    /// has come after it. None where that is not so, or does not explain the rest.
    async fn before_unexplained_end(&mut self) -> Option<(Vec<PosteriorPlace>, Option<Fit>)> {
        let (bank, from) = self.explained.take()?;
        let last = self.window.len() - 1;
        let touching: Vec<usize> = (0..self.touching.len()).filter(|&sensor| self.touching[sensor] > 0).collect();
        if from > last || touching.is_empty() {
            return None;
        }
        let after = core::mem::replace(&mut self.phase, Phase::Tracking(bank));
        if self.ends_unexplained(from).await && touching.iter().any(|&sensor| self.may_touch_twice(sensor, from)) {
            for &sensor in &touching {
                (from..=last).for_each(|row| self.window.set_aside(row, sensor));
            }
            let told = self.choose().await;
            if told.1.as_ref().is_some_and(|fit| fit.agrees() && fit.touching >= EXPLAINED) {
                self.left_out.push(Stretch { from: self.window.time(from), to: self.window.time(last) });
                return Some(told);
            }
            for &sensor in &touching {
                (from..=last).for_each(|row| self.window.take(row, sensor));
            }
        }
        self.phase = after;
        None
    }

    /// Whether the best mode does not explain the last readings, of those from this row on.
    async fn ends_unexplained(&mut self, from: usize) -> bool {
        let Self { scene, window, phase, .. } = self;
        let Phase::Tracking(bank) = phase else { return false };
        let rows: Vec<usize> = bank.rows.iter().copied().filter(|&row| row < from).chain(from..window.len()).collect();
        let told = bank.run_rows(&scene.model(window, 0), &rows).await;
        let last = told.rows.iter().rev().take(CONTACT_ROWS * scene.sensors.len());
        last.filter(|row| is_off(row)).count() >= CONTACT_ROWS
    }

    /// Searches anew from another contact of the window, the longest first; the modes that are found are fitted to the whole window. Starts
    /// from the present contact where there is none.
    fn relocalize(&mut self) {
        self.aside.fill(0);
        self.explained = None;
        self.forgotten |= core::mem::take(&mut self.marginalised);
        self.window.take_all();
        match longest_contact(&self.window, &self.scene.sensors, &self.searched) {
            Some(contact) => {
                self.abandoned = self.believed.take().or(self.abandoned);
                let onset = self.onset(contact.sensor, contact.onset, true);
                let rows = onset.rows.into_iter().filter(|&row| row < contact.end).collect();
                let model = self.scene.model(&self.window, 0);
                let search = GridSearch::new(&model, ContactOnset { rows, ..onset }, self.symmetries());
                self.phase = Phase::Searching { search: Box::new(search), travelled: 0.0, ended: true };
            }
            None => self.begin_again(),
        }
    }

    /// What the best mode does not explain, if it is anything: a sensor's readings from a row on, where that contact can be left out, or all.
    async fn unexplained(&mut self) -> Option<Option<(usize, usize)>> {
        let Phase::Tracking(bank) = &mut self.phase else { return None };
        let model = self.scene.model(&self.window, 0);
        if bank.modes.is_empty() {
            return Some(None);
        }
        let told = bank.run(&model).await;
        let found = (0..self.scene.sensors.len()).find_map(|sensor| {
            let own: Vec<&Row> = told.rows.iter().filter(|row| row.sensor == sensor).collect();
            let last = own.len().checked_sub(WATCHED)?;
            let share = own[last..].iter().filter(|row| is_off(row)).count() as f64 / WATCHED as f64;
            if share <= LOST_SHARE {
                return None;
            }
            let first = last + own[last..].iter().position(|row| is_off(row))?;
            // Back to where it began, and how much of what was before speaks for the mode.
            let explained = own[..first].iter().rposition(|row| !is_off(row)).map_or(0, |at| at + 1);
            let from = own[explained].row;
            let aside = (0..from).rev().find(|&row| self.window.is_aside(row, sensor)).map_or(0, |row| row + 1);
            let speaks = |row: &&&Row| row.row >= aside && row.held == Some(true) && !is_off(row);
            let is_trusted = own[..explained].iter().filter(speaks).count() >= EXPLAINED;
            let touches = self.touching[sensor] > 0 || self.free < CONTACT_ROWS;
            Some((is_trusted && touches).then_some((sensor, from)))
        });
        match found {
            Some(Some((sensor, from))) if !self.may_touch_twice(sensor, from) => Some(None),
            found => found,
        }
    }

    /// Whether a whisker may touch more than one stretch of boundary by the best mode, or go over a corner.
    fn may_touch_twice(&self, sensor: usize, row: usize) -> bool {
        let (Some(frame), own) = (self.best(), &self.scene.sensors[sensor]) else { return true };
        let base = frame.compose(self.window.pose(row)).compose(own.robot_from_whisker).position();
        let reach = REACH * own.length;
        let around = Vec2::new(reach, reach);
        let mut first: Option<f64> = None;
        let mut other = false;
        self.scene.map.for_each_edge_in(Bounds { min: base - around, max: base + around }, |[a, b]| {
            let along = (b - a).angle();
            let along_edge = ((base - a).dot(b - a) / (b - a).norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            if (a + (b - a) * along_edge).distance(base) <= reach {
                other |= wrap_angle(along - *first.get_or_insert(along)).abs() > OTHER_NORMAL;
            }
            other
        });
        other
    }

    /// Forgets the first rows of the window, and what is marginalised.
    fn forget(&mut self, rows: usize) {
        let touched = (0..rows).any(|row| self.window.contacts(row).contains(&true));
        self.forgotten |= touched || core::mem::take(&mut self.marginalised);
        self.window.forget(rows);
    }

    /// Forgets everything and starts from the present contact, or waits for the next.
    fn begin_again(&mut self) {
        self.abandoned = self.believed.take().or(self.abandoned);
        self.tracked = 0;
        self.forget(self.window.len().saturating_sub(1));
        // A contact that is not covered may go on for long.
        self.patience = PATIENCE.powi(self.begun_again).min(MOST_BACKOFF);
        self.begun_again += 1;
        self.aside.fill(0);
        self.explained = None;
        self.window.take_all();
        self.phase = match self.touching.iter().position(|&rows| rows >= CONTACT_ROWS) {
            Some(sensor) if self.starts < MOST_STARTS => {
                Phase::Pressing { sensor, onset: 0, from_free: false, travelled: 0.0, search: None }
            }
            _ => Phase::Waiting,
        };
    }

    /// The places by the modes at the end of the log.
    async fn choose(&mut self) -> (Vec<PosteriorPlace>, Option<Fit>) {
        let Self { scene, window, phase, .. } = self;
        let Phase::Tracking(bank) = phase else { return (Vec::new(), None) };
        let had_any = !bank.modes.is_empty();
        let told = places::choose(bank, scene, window).await;
        self.emptied_at_end |= had_any && told.0.is_empty();
        told
    }

    /// The modes, once they have been fitted to any rows.
    fn bank(&self) -> Option<&Bank> {
        match &self.phase {
            Phase::Tracking(bank) => Some(bank.as_ref()).filter(|bank| bank.is_fitted),
            _ => None,
        }
    }

    /// The odometry frame in the map frame by each mode, or by so many of them.
    fn frames(&self, most: usize) -> Vec<Pose2> {
        let Some(bank) = self.bank() else { return Vec::new() };
        let step = bank.modes.len().div_ceil(most).max(1);
        let last = self.window.len() - 1;
        let model = self.scene.model(&self.window, 0);
        let times = bank.times(&self.scene.symmetries);
        let images = |frame: Pose2| self.scene.symmetries.images(frame).take(times);
        let some = bank.modes.iter().step_by(step);
        some.flat_map(|mode| images(model.anchored(&mode.state, last).frame)).collect()
    }

    /// The best mode now: the odometry frame in the map frame.
    fn best(&self) -> Option<Pose2> {
        let mode = self.bank()?.modes.first()?;
        Some(self.scene.model(&self.window, 0).anchored(&mode.state, self.window.len() - 1).frame)
    }
}

impl MultiHypothesisSmoother<'_> {
    /// Whether the next row may bring work that takes long: others are kept until there are enough of them.
    pub(crate) fn is_due(&self) -> bool {
        let next = self.window.len() + 1;
        match &self.phase {
            Phase::Waiting => false,
            Phase::Pressing { .. } | Phase::Searching { .. } => true,
            Phase::Tracking(bank) => bank.is_busy() || next >= bank.seen + TAKEN_TOGETHER || next > self.scene.window(),
        }
    }

    /// What its work pauses by.
    pub(crate) fn pace(&self) -> Pace {
        self.scene.pace.clone()
    }

    /// How many rows are kept: as many as the window, and a few.
    #[must_use]
    pub fn rows_kept(&self) -> usize {
        self.window.len()
    }

    /// The odometry frame in the map frame by the best mode of the set that was last given up.
    #[must_use]
    pub fn abandoned(&self) -> Option<Pose2> {
        self.abandoned
    }

    /// For each sense whether its last reading is that of a whisker in contact, beside a zero that drifts.
    #[must_use]
    pub fn contacts(&self) -> &[bool] {
        self.window.len().checked_sub(1).map_or(&[], |last| self.window.contacts(last))
    }

    /// When readings were left out of what the places are told by.
    #[must_use]
    pub fn left_out(&self) -> &[Stretch] {
        &self.left_out
    }

    /// Whether the modes are fitted to every contact since the log began, whatever was given up in between.
    #[must_use]
    pub fn explains_all(&self) -> bool {
        !self.forgotten
    }

    /// Whether there were modes until the end of the log, and none of them explains its last rows.
    #[must_use]
    pub fn emptied_at_end(&self) -> bool {
        self.emptied_at_end
    }

    /// From when on (s) the robot is elsewhere than was believed, by what the end of the log has shown.
    #[must_use]
    pub fn carried(&self) -> Option<f64> {
        self.carried
    }

    /// How many modes there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.bank().map_or(0, |bank| bank.modes.len() * bank.times(&self.scene.symmetries))
    }

    /// Takes in one row: its time (s), the robot in the odometry frame, one reading for each sense (N m, N, rad), and the absolute
    /// heading (map frame, rad) where there is one.
    pub fn step(&mut self, t: f64, odom_from_robot: Pose2, readings: &[f64], heading: Option<f64>) -> StepOutcome {
        completed(self.step_in_pieces(t, odom_from_robot, readings, heading))
    }

    /// The same at its pace.
    pub(crate) async fn step_in_pieces(
        &mut self,
        t: f64,
        odom_from_robot: Pose2,
        readings: &[f64],
        heading: Option<f64>,
    ) -> StepOutcome {
        let sensors = &self.scene.sensors;
        let mut readings: Vec<f64> = readings.iter().zip(sensors).map(|(m, f)| m * f.per_reading).collect();
        if let Some(tare) = &self.scene.tare {
            readings.iter_mut().zip(tare).for_each(|(reading, tare)| *reading -= tare);
        }
        self.window.push(t, odom_from_robot, &readings);
        if let Some(heading) = heading {
            self.window.point(heading);
        }
        if self.scene.tare.is_none() {
            self.last = Some(odom_from_robot);
            if self.window.len() >= TARE_ROWS {
                self.take_tare();
            } else {
                let beyond = self.scene.sensors.iter().zip(&readings).map(|(sensor, &z)| sensor.is_contact(z));
                self.window.tell_contacts(self.window.len() - 1, beyond);
            }
            return StepOutcome::Nothing;
        }
        let travel = self.last.map_or(0.0, |last| last.position().distance(odom_from_robot.position()));
        let turn = self.last.map_or(0.0, |last| last.between(odom_from_robot).theta.abs());
        self.last = Some(odom_from_robot);
        self.tell_contacts(self.window.len() - 1);
        let contacts = self.window.contacts(self.window.len() - 1);
        let any = contacts.contains(&true);
        for (rows, &contact) in self.touching.iter_mut().zip(contacts) {
            *rows = if contact { *rows + 1 } else { 0 };
        }
        let last = self.window.len() - 1;
        for (sensor, left) in self.aside.iter_mut().enumerate().filter(|(_, left)| **left > 0) {
            *left = if self.touching[sensor] > 0 { CONTACT_ROWS } else { *left - 1 };
            self.window.set_aside(last, sensor);
            self.left_out.iter_mut().next_back().into_iter().for_each(|stretch| stretch.to = t);
        }
        let lever = self.scene.sensors.iter().map(|f| f.length).fold(0.0, f64::max);
        self.free = if any { 0 } else { self.free + 1 };
        if self.free >= CONTACT_ROWS {
            self.begun_again = 0;
        }
        match &mut self.phase {
            Phase::Waiting => self.wait(any),
            Phase::Pressing { travelled, .. } => {
                *travelled += travel.max(turn * lever);
                // A robot that rests with its whisker on a wall says the same again and again.
                if self.window.len() > self.scene.window() {
                    let newest = self.window.len() - 2;
                    self.window.drop_row(newest);
                }
                self.press(false).await
            }
            Phase::Searching { .. } => self.search(SLICE).await,
            Phase::Tracking(_) => self.track().await,
        }
    }

    /// The robot's pose by each mode, with the odometry at `odom_from_robot`.
    #[must_use]
    pub fn states(&self, odom_from_robot: Pose2) -> Vec<Pose2> {
        self.some_states(odom_from_robot, usize::MAX)
    }

    /// The same by so many of the modes at most.
    pub(crate) fn some_states(&self, odom_from_robot: Pose2, most: usize) -> Vec<Pose2> {
        self.frames(most).into_iter().map(|frame| frame.compose(odom_from_robot)).collect()
    }

    /// Area of the modes' projection onto the plane (m²) and their volume (m² rad): ellipses that hold 95 %.
    #[must_use]
    pub fn size(&self) -> (f64, f64) {
        completed(self.size_in_pieces())
    }

    /// The same at its pace.
    pub(crate) async fn size_in_pieces(&self) -> (f64, f64) {
        let Some(bank) = self.bank().filter(|bank| bank.is_whole()) else { return (0.0, 0.0) };
        let (area, volume) = places::size(bank, &self.scene.model(&self.window, 0)).await;
        let times = bank.times(&self.scene.symmetries) as f64;
        (times * area, times * volume)
    }

    /// The places by the modes as they are linearised now, at the last row.
    #[must_use]
    pub fn places(&self) -> Vec<PosteriorPlace> {
        self.bank()
            .filter(|bank| bank.is_whole())
            .map_or_else(Vec::new, |bank| places::linearised(bank, &self.scene, &self.window))
    }

    /// Ends the log: every mode moved to its least cost over all rows that are kept, weighed and grouped; and how well the best one fits.
    pub fn finish(&mut self) -> (Vec<PosteriorPlace>, Option<Fit>) {
        completed(self.finish_in_pieces())
    }

    /// The same at its pace.
    pub(crate) async fn finish_in_pieces(&mut self) -> (Vec<PosteriorPlace>, Option<Fit>) {
        let mut outcomes = vec![self.search(usize::MAX).await];
        if matches!(self.phase, Phase::Pressing { .. }) {
            outcomes.push(self.press(true).await);
        }
        outcomes.push(self.fit(usize::MAX).await);
        self.emptied_at_end = outcomes.contains(&StepOutcome::Lost);
        let mut told = self.choose().await;
        if told.1.as_ref().is_some_and(|fit| !fit.agrees())
            && let Some(before) = self.before_unexplained_end().await
        {
            return before;
        }
        while told.1.as_ref().is_some_and(|fit| !fit.agrees())
            && longest_contact(&self.window, &self.scene.sensors, &self.searched).is_some()
        {
            self.relocalize();
            self.search(usize::MAX).await;
            let other = self.choose().await;
            if other.1.as_ref().zip(told.1.as_ref()).is_some_and(|(new, old)| new.beyond < old.beyond) {
                told = other;
            }
        }
        self.elsewhere().await.unwrap_or(told)
    }

    /// Places that explain a contact which is left out at the end of the log as one that the model covers: the robot was carried there. None
    /// where it is shorter than the whisker, since little is explained anywhere.
    async fn elsewhere(&mut self) -> Option<(Vec<PosteriorPlace>, Option<Fit>)> {
        let (sensor, last) = (self.aside.iter().position(|&left| left > 0)?, self.window.len() - 1);
        let row = (0..=last).rev().find(|&row| !self.window.is_aside(row, sensor)).map_or(0, |row| row + 1);
        let length = self.scene.sensors[sensor].length;
        if row >= last || self.window.way(row, last, length) < length {
            return None;
        }
        let (t, believed) = (self.window.time(row), self.believed);
        self.aside.fill(0);
        self.window.take_all();
        self.forget(row);
        self.phase = Phase::Pressing { sensor, onset: 0, from_free: false, travelled: 0.0, search: None };
        self.press(true).await;
        self.fit(usize::MAX).await;
        let other = self.choose().await;
        let explains = other.1.as_ref().is_some_and(|fit| fit.agrees() && fit.touching >= EXPLAINED);
        explains.then(|| {
            (self.abandoned, self.carried) = (believed.or(self.abandoned), Some(t));
            other
        })
    }
}

/// Whether a reading is not explained.
fn is_off(row: &Row) -> bool {
    !row.unmapped && (row.held.is_none() || row.plain.abs() > UNEXPLAINED)
}

/// How the whiskers stand at the window's first row where that is not known.
fn window_start(scene: &Scene<'_>, window: &LogWindow) -> Start {
    let mut start = Start::free(scene.sensors.len());
    for (state, _) in start.states.iter_mut().zip(window.contacts(0)).filter(|(_, contact)| **contact) {
        *state = WhiskerState::Unknown;
    }
    start
}
