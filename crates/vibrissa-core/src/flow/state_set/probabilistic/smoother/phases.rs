//! Phases of the smoother: waiting for contact, global localization, tracking, and global localization again when lost
//! \[thrun2005probabilistic, ch. 7-8\].

use super::super::admission::Admission;
use super::super::bank::{Bank, Effort, TAKEN_TOGETHER};
use super::super::contact_episodes::{FEWEST_ROWS, judging_rows, longest_contact};
use super::super::correlated_noise::NoiseModel;
use super::super::grid_search::{Cell, ContactOnset, GridSearch};
use super::super::log_window::LogWindow;
use super::super::map_symmetry::MapSymmetries;
use super::super::optimisation::Mode;
use super::super::scene::Scene;
use super::super::state::{Start, State};
use super::super::unknowns::POSE;
use super::{CONTACT_ROWS, MultiHypothesisSmoother, Phase, StepOutcome};
use crate::contact::follow::WhiskerState;
use crate::flow::prior;
use crate::math::powf;
use crate::plane::{Pose2, Vec2};
use core::ops::Range;

/// Free rows that are kept before a contact: what the whisker did not touch.
const LEAD_ROWS: usize = 24;
/// So many of them tell where a zero has drifted to.
const LEVEL_ROWS: usize = 8;
/// Travel between them (m).
const LEAD_STEP: f64 = 1.5e-3;
/// Readings that are run through the forward model in one call while modes are fitted first (some milliseconds).
const SLICE: usize = 4000;
/// Readings that are run in one call while modes take in rows.
const FITTED: usize = 2000;
/// With many cells a contact is followed for longer, by this factor, as long as it has not been followed for this many times the usual travel.
const PATIENCE: f64 = 2.0;
const MOST_PATIENCE: f64 = 16.0;
/// Beyond so many times only while half of the window is free: modes are to be fitted to rows before these are summed up.
const PATIENCE_OF_ANY_WINDOW: f64 = 4.0;
/// More searches than this are not tried, unless one has held for so many rows.
const MOST_STARTS: u32 = 24;
const TRUSTED: usize = 300;
/// Each search of a contact that explains nothing waits for so much more travel than the one before, up to this many times the usual one.
const MOST_BACKOFF: f64 = 64.0;
/// Weight of what is marginalised, once a quarter of the window's rows has been added to it.
const FORGETTING: f64 = 0.8;

impl MultiHypothesisSmoother<'_> {
    /// Looks for a contact that lasts.
    pub(super) fn wait(&mut self, any: bool) -> StepOutcome {
        let last = self.window.len() - 1;
        if let Some(sensor) = self.touching.iter().position(|&rows| rows >= CONTACT_ROWS)
            && self.starts < MOST_STARTS
        {
            // The first readings, of which the zero is taken, and those before a loss may have touched, too.
            let has_touched = |row: &usize| self.window.contacts(*row)[sensor];
            let onset = (0..=last).rev().take_while(has_touched).last().unwrap_or(last);
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
    pub(super) async fn press(&mut self, at_end: bool) -> StepOutcome {
        let Phase::Pressing { sensor, onset, from_free, travelled, .. } = self.phase else {
            return StepOutcome::Nothing;
        };
        let ended = at_end || self.free >= CONTACT_ROWS;
        let is_followed = matches!(&self.phase, Phase::Pressing { search: Some(_), .. });
        let waits = !(is_followed && self.patience > PATIENCE_OF_ANY_WINDOW && self.is_half_full());
        if travelled < self.scene.options.seed_travel * self.patience && !ended && waits {
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
        let first = if from_free { onset } else { 0 };
        let onset = self.onset(sensor, first..self.window.len(), from_free);
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
        self.search(at_end).await
    }

    /// The symmetries of the map, if nothing tells its images apart.
    pub(super) fn symmetries(&self) -> Option<&MapSymmetries> {
        let all = Some(&self.scene.symmetries).filter(|symmetries| !symmetries.all.is_empty());
        all.filter(|_| self.scene.options.prior.is_none() && self.window.heading().is_none())
    }

    /// The contact that began at a row, and what judges it.
    pub(super) fn onset(&self, sensor: usize, contact: Range<usize>, from_free: bool) -> ContactOnset {
        let row = contact.start;
        let (own, options) = (&self.scene.sensors[sensor], &self.scene.options);
        let tip = Vec2::new(own.length, 0.0);
        let odom_from_whisker = self.window.pose(row).compose(own.robot_from_whisker);
        let before = self.window.pose(row.saturating_sub(3)).compose(own.robot_from_whisker);
        let arm = odom_from_whisker.position();
        let unknowns = &self.scene.unknowns;
        let std = |place: Option<usize>| place.map_or(0.0, |at| unknowns.all()[at - 3].std);
        let level = free_level(&self.scene, &self.window, sensor, row);
        let drifted = if level.is_some() { 0.0 } else { std(unknowns.drift[sensor]) * self.window.since_start(row) };
        ContactOnset {
            sensor,
            row,
            from_free,
            approach: tip - odom_from_whisker.inverse_transform_point(before.transform_point(tip)),
            rows: judging_rows(&self.window, (sensor, own.length), contact, options.seed_step),
            spacing: options.seed_spacing,
            turn: options.seed_turn,
            near: options.prior.map(|region| {
                let [place, turn] = self.scene.prior_slack(&self.window, 0.0);
                prior::around(region, arm, options.seed_spacing + place + arm.norm() * turn, own.length)
            }),
            level: level.unwrap_or_default(),
            priors: [std(unknowns.gain[sensor]), std(unknowns.zero[sensor]).hypot(drifted)],
        }
    }

    /// Whether half of the window's rows are taken.
    fn is_half_full(&self) -> bool {
        2 * self.window.len() > self.scene.window()
    }

    /// Whether the contact is not followed for longer, however many cells are left.
    fn is_followed_enough(&self) -> bool {
        self.patience >= MOST_PATIENCE || (self.patience >= PATIENCE_OF_ANY_WINDOW && self.is_half_full())
    }

    /// Looks for modes with the work of one row, or with all that it takes.
    pub(super) async fn search(&mut self, whole: bool) -> StepOutcome {
        let (by_symmetry, is_enough) = (self.symmetries().is_some(), self.is_followed_enough());
        let Self { scene, window, phase, .. } = self;
        let Phase::Searching { search, travelled, ended } = phase else { return StepOutcome::Nothing };
        let mut work = if whole { usize::MAX } else { search.work_of_a_row() };
        let model = scene.model(window, 0);
        let admission = Admission::of_cells(scene, window);
        let row = search.onset().row;
        let admits = |frame: Pose2| admission.satisfies_prior(frame) && admission.origin_is_free(frame, row);
        let is_last = *ended || is_enough;
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
        let values = values_by_levels(scene, window, row);
        let mode = |cell: Cell| {
            let start = if from_free {
                window_start(scene, window)
            } else {
                let robot = cell.frame.compose(window.pose(row));
                let mut states = vec![WhiskerState::Free; scene.sensors.len()];
                states[sensor] = cell.state;
                let bases = scene.sensors.iter().map(|s| robot.compose(s.robot_from_whisker)).collect();
                Start { states, bases, prior: None }
            };
            let state = State { frame: cell.frame, values: values.clone() };
            Mode::new(state, start, NoiseModel::tracked(scene.options.noise_model))
        };
        let mut modes = Vec::with_capacity(cells.len());
        for cell in cells {
            modes.push(mode(cell));
            model.works(1).await;
        }
        let mut bank = Bank::new(modes, by_symmetry);
        bank.begin(&model, &|frame| admission.is_allowed(frame)).await;
        self.phase = Phase::Tracking(Box::new(bank));
        self.fit(work).await
    }

    /// Goes on fitting modes with this much work.
    pub(super) async fn fit(&mut self, mut work: usize) -> StepOutcome {
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
    pub(super) async fn track(&mut self) -> StepOutcome {
        let Self { scene, window, phase, tracked, .. } = self;
        let Phase::Tracking(bank) = phase else { return StepOutcome::Nothing };
        *tracked += 1;
        if window.heading().is_some() && !bank.is_busy() {
            bank.expand_images(&scene.symmetries);
        }
        if self.tracked > TRUSTED {
            (self.starts, self.begun_again) = (1, 0);
        }
        let most = scene.lag(bank.modes.len());
        let full = window.len() > most;
        if !full && (bank.is_busy() || window.len() < bank.seen + TAKEN_TOGETHER) {
            let work = if bank.is_fitted { FITTED } else { SLICE };
            return if bank.is_busy() { self.fit(work).await } else { StepOutcome::Nothing };
        }
        let model = scene.model(window, 0);
        let admission = Admission::of_cells(scene, window);
        let admits = |frame: Pose2| admission.is_allowed(frame);
        if !full {
            bank.begin(&model, &admits).await;
            return self.fit(FITTED).await;
        }
        bank.extend(&model, &admits, Effort::ONLINE).await;
        bank.converge(&model).await;
        let gone = window.len() - 1 - (most - most / 4);
        let weight = powf(FORGETTING, 4.0 * gone as f64 / scene.window() as f64);
        bank.marginalise(&model, gone, weight).await;
        self.explained = None;
        self.marginalised = true;
        window.forget(gone);
        self.judge().await
    }

    /// Searches anew from another contact of the window, the longest first; the modes that are found are fitted to the whole window. Starts
    /// from the present contact where there is none.
    pub(super) fn relocalize(&mut self) {
        self.aside.fill(0);
        self.explained = None;
        self.forgotten |= core::mem::take(&mut self.marginalised);
        self.window.take_all();
        match longest_contact(&self.window, &self.scene.sensors, &self.searched) {
            Some(contact) => {
                self.abandoned = self.believed.take().or(self.abandoned);
                let onset = self.onset(contact.sensor, contact.onset..contact.end, true);
                let search = GridSearch::new(&self.scene.model(&self.window, 0), onset, self.symmetries());
                self.phase = Phase::Searching { search: Box::new(search), travelled: 0.0, ended: true };
            }
            None => self.begin_again(),
        }
    }

    /// Forgets everything and starts from the present contact, or waits for the next.
    pub(super) fn begin_again(&mut self) {
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
}

/// What a sensor whose zero drifts has read in the last rows before this one while its whisker was free.
fn free_level(scene: &Scene<'_>, window: &LogWindow, sensor: usize, row: usize) -> Option<f64> {
    scene.unknowns.drift[sensor]?;
    let is_free = |row: &usize| !window.contacts(*row)[sensor];
    let free = (0..row).rev().filter(is_free).take(LEVEL_ROWS).map(|row| window.readings(row)[sensor]);
    let (count, sum) = free.fold((0, 0.0), |(count, sum), z| (count + 1, sum + z));
    (count > 0).then(|| sum / f64::from(count))
}

/// The nuisance parameters with which a mode begins: drifts as they have brought zeros to where they were before this row, within their bounds.
fn values_by_levels(scene: &Scene<'_>, window: &LogWindow, row: usize) -> Vec<f64> {
    let mut values = vec![0.0; scene.unknowns.all().len()];
    let since = window.since_start(row);
    for (sensor, drift) in scene.unknowns.drift.iter().enumerate() {
        let Some((at, level)) = drift.zip(free_level(scene, window, sensor, row)).filter(|_| since > 0.0) else {
            continue;
        };
        // Bounds are those of what is even within them.
        let most = 3.0_f64.sqrt() * scene.unknowns.all()[at - POSE].std;
        values[at - POSE] = (level / since).clamp(-most, most);
    }
    values
}

/// How the whiskers stand at the window's first row where that is not known.
fn window_start(scene: &Scene<'_>, window: &LogWindow) -> Start {
    let mut start = Start::free(scene.sensors.len());
    for (state, _) in start.states.iter_mut().zip(window.contacts(0)).filter(|(_, contact)| **contact) {
        *state = WhiskerState::Unknown;
    }
    start
}
