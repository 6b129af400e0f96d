//! The smoother row by row: what it keeps, what it is asked, and how a row and the end of the log go through its phases.

mod phases;
mod unexplained_contact;

use super::bank::{Bank, TAKEN_TOGETHER};
use super::contact_episodes::longest_contact;
use super::goodness_of_fit::Fit;
use super::grid_search::GridSearch;
use super::log_window::LogWindow;
use super::map_symmetry::MapSymmetries;
use super::places::{self, PosteriorPlace};
use super::scene::Scene;
use super::sensor::{FreeLevel, Sensor};
use super::unknowns::{Sense, Unknowns};
use crate::beam::{TipModel, TipTable};
use crate::config::{ProbabilisticOptions, UndeclaredErrors};
use crate::contact::{Boundaries, SensedQuantity};
use crate::coroutine::{Pace, completed};
use crate::flow::pose::Stretch;
use crate::plane::Pose2;
use crate::world::{Map, Robot};

/// So many readings in a row begin or end a contact; fewer are taken for false ones.
const CONTACT_ROWS: usize = 3;
/// The zero of a sensor whose zero is not known exactly is tared by so many rows, if its readings may be those of a free whisker.
const TARE_ROWS: usize = 8;

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
        let ground = Boundaries::simplified(map).with_clearance(map);
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
            window: LogWindow::new(count)
                .with_drift([declared.odometry.translation_relative, declared.odometry.rotation_relative]),
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

    /// Forgets the first rows of the window, and what is marginalised.
    fn forget(&mut self, rows: usize) {
        let touched = (0..rows).any(|row| self.window.contacts(row).contains(&true));
        self.forgotten |= touched || core::mem::take(&mut self.marginalised);
        self.window.forget(rows);
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
            Phase::Tracking(bank) => {
                bank.is_busy() || next >= bank.seen + TAKEN_TOGETHER || next > self.scene.lag(bank.modes.len())
            }
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
                // Until then a reading within the bound on the zero says nothing.
                let each = self.scene.sensors.iter().zip(&self.scene.whiskers).zip(&readings);
                let told = each.map(|((sensor, &whisker), &z)| {
                    let zero = self.scene.robot.whiskers[whisker].errors.zero;
                    sensor.is_contact_within(z, zero * sensor.per_reading)
                });
                self.window.tell_contacts(self.window.len() - 1, told);
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
            Phase::Searching { .. } => self.search(false).await,
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
        let mut outcomes = vec![self.search(true).await];
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
            self.search(true).await;
            let other = self.choose().await;
            if other.1.as_ref().zip(told.1.as_ref()).is_some_and(|(new, old)| new.beyond < old.beyond) {
                told = other;
            }
        }
        self.elsewhere().await.unwrap_or(told)
    }
}
