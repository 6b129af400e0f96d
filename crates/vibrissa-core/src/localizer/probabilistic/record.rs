//! The smoother with a record of what it has told: readings are screened, events and sizes are noted, and at the end all of it is the answer.

use super::super::drawn::{DrawnReading, DrawnReadings};
use super::super::{LimitCheck, searchable};
use super::NAME;
use crate::beam::TipModel;
use crate::config::ProbabilisticOptions;
use crate::config::limits::MOST_SEARCHED;
use crate::coroutine::{Pace, until};
use crate::flow::pose::{
    self, Broken, ConsistencyReport, Estimate, Event, Evidence, Hypothesis, Localization, Nuisance, NuisanceQuantity,
    OdometryEstimate, RECOVERED, ShapeRecord, StampedPose, Status, StepRecord, Stretch,
};
use crate::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog, one_owner_each};
use crate::flow::state_set::probabilistic::{
    Fit, MultiHypothesisSmoother, PosteriorPlace, STRETCHES, SensedQuantity, StepOutcome,
};
use crate::flow::trajectory::pose_at;
use crate::plane::Pose2;
use crate::world::{Map, ReadingNoise, Robot};
use crate::{Result, Stop, WorkBudget};

/// The smoother and what it has told.
pub(super) struct Record<'a> {
    map: &'a Map,
    robot: &'a Robot,
    quantities: Vec<Reader>,
    /// For each quantity the last possible reading, how many impossible ones came since, and by how many more of a contact were possible.
    last: Vec<(f64, usize, i64)>,
    set: MultiHypothesisSmoother<'a>,
    start: Option<Pose2>,
    rows: Vec<(f64, Pose2)>,
    in_contact: Vec<bool>,
    touched: bool,
    steps: Vec<StepRecord>,
    events: Vec<Event>,
    first_row: Option<usize>,
    first_states: Vec<Pose2>,
    lost: usize,
    /// What has been told of the way before each loss: the row after it, and the odometry frame in the map frame.
    before: Vec<(usize, Option<Pose2>)>,
    /// Rows taken in, and rows that touched since the set last started anew after a loss.
    taken: usize,
    since: Option<usize>,
    /// Whether the way is recorded.
    recording: bool,
    tolerated_share: f64,
    /// Contacts for drawing: not all of long logs.
    felt: DrawnReadings<DRAWN>,
    stop: Stop,
}

impl<'a> Record<'a> {
    /// Of a log with these channels that is to come.
    pub(super) fn new(
        map: &'a Map,
        robot: &'a Robot,
        channels: &[Channel],
        options: ProbabilisticOptions,
    ) -> Result<Self> {
        options.check()?;
        robot.require_level("the probabilistic method")?;
        one_owner_each(robot, channels)?;
        searchable(map, options.prior, MOST_SEARCHED)?;
        let tips = robot.whiskers.iter().map(|w| TipModel::new(&w.beam)).collect::<Result<Vec<_>>>()?;
        let quantities = readers(robot, &tips, channels)?;
        let told: Vec<(usize, SensedQuantity)> = quantities.iter().map(|r| (r.whisker, r.quantity)).collect();
        let set = MultiHypothesisSmoother::new(map, robot, &tips, &told, options);
        Ok(Self {
            map,
            robot,
            last: vec![(0.0, 0, 0); quantities.len()],
            quantities,
            tolerated_share: options.tolerated_share,
            set,
            start: None,
            rows: Vec::new(),
            in_contact: vec![false; robot.whiskers.len()],
            touched: false,
            steps: Vec::new(),
            events: Vec::new(),
            first_row: None,
            first_states: Vec::new(),
            lost: 0,
            before: Vec::new(),
            taken: 0,
            since: None,
            recording: true,
            felt: DrawnReadings::default(),
            stop: Stop::default(),
        })
    }

    /// Keeps no way and few events from now on.
    pub(super) fn forget_way(&mut self) {
        self.recording = false;
    }

    /// Takes a request to end early.
    pub(super) fn heed(&mut self, stop: &Stop) {
        self.stop = stop.clone();
    }

    /// How many rows are kept to be fitted again.
    pub(super) fn rows_kept(&self) -> usize {
        self.set.rows_kept()
    }

    /// What its work pauses by.
    pub(super) fn pace(&self) -> Pace {
        self.set.pace()
    }

    /// Puts the last possible reading in the place of an impossible one; many on end are refused where the others do not speak for the
    /// whisker and its units: one that is held between two walls feels more than any one contact makes.
    fn screen(&mut self, readings: &mut [f64], row: &LogRow) -> Result<()> {
        for (index, reading) in readings.iter_mut().enumerate() {
            let (last, impossible, possible) = &mut self.last[index];
            let Reader { limit, noise, .. } = &self.quantities[index];
            match limit.as_ref().map_or(Ok(()), |limit| limit.check(*reading, row)) {
                Ok(()) => {
                    *possible += i64::from(reading.abs() * (1.0 - noise.relative) > noise.absolute);
                    (*last, *impossible) = (*reading, 0);
                }
                Err(error) => {
                    *possible -= 1;
                    *impossible += 1;
                    if *impossible >= MOST_IMPOSSIBLE && *possible <= 0 {
                        return Err(error);
                    }
                    if *impossible < MOST_IMPOSSIBLE {
                        *reading = *last;
                    }
                }
            }
        }
        Ok(())
    }

    /// Notes contacts that begin and end.
    fn watch(&mut self, t: f64) {
        for (index, whisker) in self.robot.whiskers.iter().enumerate() {
            let own = |(reader, touches): (&Reader, &bool)| reader.whisker == index && *touches;
            let touching = self.quantities.iter().zip(self.set.contacts()).any(own);
            if touching != self.in_contact[index] {
                let (kind, what) = if touching { ("contact", "touches") } else { ("lift_off", "is free") };
                self.events.push(Event { t, kind, detail: format!("{} {what}", whisker.name) });
            }
            self.in_contact[index] = touching;
            self.touched |= touching;
        }
    }

    /// Keeps the moments of whiskers that touch for sure, for drawing.
    fn keep_drawn(&mut self, t: f64, odom_from_robot: Pose2, readings: &[f64]) {
        if !self.recording {
            return;
        }
        for (reader, &moment) in self.quantities.iter().zip(readings) {
            let touches = moment.abs() * (1.0 - reader.noise.relative) > reader.noise.absolute;
            if touches && reader.quantity == SensedQuantity::Moment {
                self.felt.push(DrawnReading { t, odom_from_robot, whisker: reader.whisker, moment });
            }
        }
    }

    /// Tells when a set that was started after a loss has explained enough.
    fn believe_again(&mut self, t: f64) {
        let Some(rows) = self.since.as_mut().filter(|_| self.in_contact.contains(&true)) else { return };
        *rows += 1;
        if *rows == RECOVERED {
            let detail = format!("{RECOVERED} rows of contact agree with where the robot is now; it had been lost");
            self.events.push(Event { t, kind: "recovered", detail });
        }
    }

    async fn note(&mut self, t: f64) {
        if !self.recording {
            return;
        }
        let (area_m2, volume) = self.set.size_in_pieces().await;
        self.steps.push(StepRecord { t, components: self.set.count(), area_m2, volume });
    }

    fn note_loss(&mut self, t: f64) {
        self.lost += 1;
        self.since = None;
        self.before.push((self.taken, self.set.abandoned()));
        let detail = if self.first_row.is_some() {
            "no place explains the readings up to here: the robot was moved by hand, the whisker slipped or touched with \
             its side, or the map, the whisker or the noise bounds are not the robot's; starting anew"
        } else {
            "nowhere on this map explains this contact; is it the right map, and does the whisker touch with its tip?"
        };
        self.events.push(Event { t, kind: "inconsistent", detail: detail.to_owned() });
    }

    /// Notes at the end that the robot is found again after the last loss, where no row has told it.
    fn note_recovered(&mut self, t: f64, is_found_again: bool) {
        let last =
            self.events.iter().rev().map(|event| event.kind).find(|kind| ["inconsistent", "recovered"].contains(kind));
        if self.lost == 0 || last != Some("inconsistent") {
            return;
        }
        let detail = if is_found_again {
            "one place explains the contacts from the first on; it had been given up on the way"
        } else {
            "the rows since agree with where the robot is now; it had been lost"
        };
        self.events.push(Event { t, kind: "recovered", detail: detail.to_owned() });
    }

    /// Notes that the contact since a time is explained elsewhere.
    fn note_carried(&mut self, from: f64, t: f64) {
        self.lost += 1;
        let rows = self.rows.partition_point(|row| row.0 < from);
        self.before.push((rows, self.set.abandoned()));
        let detail =
            format!("the contact from {from:.3} s on fits only elsewhere: the robot was moved by hand, or slipped");
        self.events.push(Event { t, kind: "inconsistent", detail });
        let detail = "the end of the log agrees with where the robot is now; it had been lost".to_owned();
        self.events.push(Event { t, kind: "recovered", detail });
    }

    fn note_set_aside(&mut self, t: f64, reader: usize) {
        let whisker = &self.robot.whiskers[self.quantities[reader].whisker].name;
        let detail = format!(
            "{whisker} is in a contact that does not fit where the robot was localized: a second boundary holds it, or it \
             slipped; its readings are left out until it is free"
        );
        self.events.push(Event { t, kind: "set_aside", detail });
    }

    fn evidence<'b>(&self, places: &'b [Hypothesis]) -> Evidence<'b> {
        Evidence { touched: self.touched, emptied: self.lost > 0, places, ..Evidence::default() }
    }

    /// Whether the modes were given up on the way although a place explains every contact: no reading contradicts the others then.
    fn is_found_again(&self, fit: Option<&Fit>) -> bool {
        self.lost > 0 && self.set.explains_all() && fit.is_some_and(Fit::agrees)
    }

    /// Tells why the verdict is not what the places alone would make it.
    fn note_reason(&mut self, t: f64, nowhere: bool, reason: Option<(&'static str, String)>) {
        let too_short = self.touched && nowhere && self.lost == 0;
        let short = "the contact was too short to tell any place; keep the whisker on the wall for a longer sweep";
        let reason = reason.or(too_short.then(|| ("too_short", short.to_owned())));
        self.events.extend(reason.map(|(kind, detail)| Event { t, kind, detail }));
    }

    /// How well the best place fits the readings.
    fn consistency(fit: &Fit) -> ConsistencyReport {
        ConsistencyReport {
            statistic: fit.statistic,
            most: pose::most_statistic(fit),
            correlation_time: fit.correlation_time,
            worst: fit.worst,
            remedies: Vec::new(),
        }
    }

    /// When the last row before the last loss was taken (s).
    fn last_lost(&self) -> Option<f64> {
        self.before.last().and_then(|&(row, _)| self.rows.get(row.checked_sub(1)?)).map(|row| row.0)
    }

    /// Where the way is not sure: up to the last loss, where contacts were left out, and where the readings fit worse than errors within their
    /// bounds do.
    fn unsure(
        &self,
        trajectory: &[StampedPose],
        lost: Option<f64>,
        fits: Option<&(&Fit, ConsistencyReport)>,
    ) -> Vec<Stretch> {
        let Some(first) = trajectory.first() else { return Vec::new() };
        let before = lost.filter(|t| *t > first.t).map(|t| Stretch { from: first.t, to: t });
        let end = before.map_or(first.t, |stretch| stretch.to);
        let misfit = fits.and_then(|(fit, report)| {
            let (stretch, there) = report.worst?;
            let from = stretch.from.max(end);
            (there > pose::most_of_stretch(fit, STRETCHES) && stretch.to > from).then_some(Stretch { from, ..stretch })
        });
        let left_out = self.set.left_out().iter().filter(|stretch| stretch.to > end && self.recording).copied();
        let mut all: Vec<Stretch> = before.into_iter().chain(left_out).chain(misfit).collect();
        all.sort_by(|a, b| a.from.total_cmp(&b.from));
        all
    }

    /// The whiskers for drawing along the way.
    async fn shapes(&self, trajectory: &[StampedPose]) -> Vec<ShapeRecord> {
        let whiskers = &self.robot.whiskers;
        let (mut drawing, pace) = (self.felt.drawing(whiskers), self.pace());
        loop {
            // The frame of each row, since the odometry is corrected along the way.
            let frame =
                |felt: &DrawnReading| Some(pose_at(trajectory, felt.t)?.compose(felt.odom_from_robot.inverse()));
            if drawing.advance(self.map, whiskers, &frame, &mut WorkBudget::new(DRAWN_UNITS)) {
                return drawing.shapes;
            }
            pace.spend(DRAWN_UNITS).await;
        }
    }

    /// The best place along the rows, from the first estimate on; before a loss it is what was believed then. Takes the rows.
    fn trajectory(&mut self, place: &PosteriorPlace, odometry: Option<&OdometryEstimate>) -> Vec<StampedPose> {
        let Some(first) = self.first_row.filter(|_| self.recording) else { return Vec::new() };
        let lost = |row: usize| self.before.iter().find(|(end, frame)| row < *end && frame.is_some());
        let of_scale = |told: &&Nuisance| told.quantity == NuisanceQuantity::MapScale;
        let scale = place.nuisances.iter().find(of_scale).map(|told| 1.0 + told.estimate);
        // An increment of the odometry as it is in the map as it is drawn.
        let corrected = |step: Pose2| {
            let step = odometry.map_or(step, |odometry| odometry.corrected(step));
            scale.map_or(step, |scale| Pose2 { x: step.x / scale, y: step.y / scale, ..step })
        };
        let is_corrected = odometry.is_some() || scale.is_some();
        // Where the odometry has the robot, in the same memory, becomes where it was in the map.
        let rows = core::mem::take(&mut self.rows).into_iter();
        let mut poses: Vec<StampedPose> = rows.map(|(t, odom)| StampedPose { t, map_from_robot: odom }).collect();
        poses.drain(..first.min(poses.len()));
        // Back from the last row, where the place is told.
        let mut next: Option<(Pose2, Pose2)> = None;
        for (row, stamped) in poses.iter_mut().enumerate().rev() {
            let odom = stamped.map_from_robot;
            stamped.map_from_robot = match (lost(first + row), next) {
                (Some((_, Some(frame))), _) => frame.compose(odom),
                (_, Some((pose, after))) if is_corrected => pose.before(corrected(odom.between(after))),
                _ => place.map_from_odom.compose(odom),
            };
            next = Some((stamped.map_from_robot, odom));
        }
        poses
    }
}

impl Record<'_> {
    /// Takes a row, whose work is left to [`Self::work`].
    pub(super) fn take(&mut self, row: &LogRow) -> Result<TakenRow> {
        let start = *self.start.get_or_insert(row.odom_from_robot);
        let odom = start.between(row.odom_from_robot);
        let mut readings: Vec<f64> =
            self.quantities.iter().map(|r| row.readings.get(r.channel).copied().unwrap_or(0.0)).collect();
        self.screen(&mut readings, row)?;
        if !self.recording {
            self.rows.clear();
            self.events.drain(..self.events.len().saturating_sub(LAST_EVENTS));
            self.before.drain(..self.before.len().saturating_sub(1));
        }
        self.keep_drawn(row.t, odom, &readings);
        self.rows.push((row.t, odom));
        self.taken += 1;
        Ok(TakenRow { t: row.t, odom, readings, heading: row.heading.filter(|h| h.is_finite()) })
    }

    /// Whether the next row may bring work that takes long.
    pub(super) fn is_due(&self) -> bool {
        self.set.is_due()
    }

    /// Does the work of a row.
    pub(super) async fn work(&mut self, row: TakenRow) {
        let TakenRow { t, odom, readings, heading } = row;
        let outcome = self.set.step_in_pieces(t, odom, &readings, heading).await;
        self.watch(t);
        match outcome {
            StepOutcome::Nothing => self.believe_again(t),
            StepOutcome::Started(_) => {
                self.first_row.get_or_insert(self.taken - 1);
                self.since = (self.lost > 0).then_some(0);
                if self.first_states.is_empty() {
                    self.first_states = self.set.states(odom);
                }
                self.note(t).await;
            }
            StepOutcome::Updated => {
                self.note(t).await;
                self.believe_again(t);
            }
            StepOutcome::Lost => self.note_loss(t),
            StepOutcome::SetAside(reader) => self.note_set_aside(t, reader),
        }
    }

    /// What can be said at the last row.
    pub(super) fn estimate(&self) -> Estimate {
        let places = self.set.places();
        let hypotheses: Vec<Hypothesis> = places.iter().map(pose::fitted).collect();
        let verdict = pose::verdict(&Evidence {
            explained_since: self.since.unwrap_or(0),
            broken: Broken::Unknown,
            ..self.evidence(&hypotheses)
        });
        Estimate { status: verdict.status, hypotheses, rows: self.taken }
    }

    /// The robot at the last row by each mode, or by so many of them.
    pub(super) fn states_now(&self, most: usize) -> Vec<Pose2> {
        self.rows.last().map_or_else(Vec::new, |&(_, odom)| self.set.some_states(odom, most))
    }

    /// The answer. Where its end is asked for early, it is by the places as they are linearised at the last row.
    pub(super) async fn finish(mut self) -> Localization {
        let t = self.rows.last().map_or(0.0, |row| row.0);
        let before = self.first_row;
        let (linearised, since) = (self.set.places(), self.since.unwrap_or(0));
        let refined = until(&self.stop, self.set.finish_in_pieces()).await;
        let is_refined = refined.is_some();
        let (places, fit) = refined.unwrap_or((linearised, None));
        let since = if is_refined { 0 } else { since };
        if let Some(from) = self.set.carried() {
            self.note_carried(from, t);
        }
        if places.is_empty() && self.set.emptied_at_end() {
            self.note_loss(t);
        }
        if !places.is_empty() {
            self.first_row.get_or_insert(self.taken.saturating_sub(1));
        }
        if before.is_none() && !places.is_empty() {
            self.note(t).await;
        }
        let hypotheses: Vec<Hypothesis> = places.iter().map(pose::fitted).collect();
        let broken: Vec<f64> = places.iter().map(|place| place.broken).collect();
        let is_found_again = self.is_found_again(fit.as_ref());
        if is_found_again {
            self.before.clear();
        }
        let verdict = pose::verdict(&Evidence {
            explained_since: fit.as_ref().map_or(since, |fit| fit.touching),
            emptied: self.lost > 0 && !is_found_again,
            broken: if is_refined { Broken::Shares(&broken) } else { Broken::Unknown },
            fit: fit.as_ref(),
            tolerated_share: self.tolerated_share,
            ..self.evidence(&hypotheses)
        });
        self.note_reason(t, hypotheses.is_empty(), verdict.reason);
        let status = verdict.status;
        let keep = status != Status::Inconsistent;
        if keep && !hypotheses.is_empty() {
            self.note_recovered(t, is_found_again);
        }
        let estimate = hypotheses.first().map(|h| h.pose).filter(|_| keep);
        let odometry = places.first().and_then(|place| place.calibration).map(odometry_estimate);
        let nuisances = places.first().map_or_else(Vec::new, |place| place.nuisances.clone());
        let lost = self.last_lost();
        let trajectory = places.first().map_or_else(Vec::new, |place| self.trajectory(place, odometry.as_ref()));
        let shapes = until(&self.stop, self.shapes(&trajectory)).await.unwrap_or_default();
        let fits = fit.as_ref().map(|fit| (fit, Self::consistency(fit)));
        let unsure = if keep { self.unsure(&trajectory, lost, fits.as_ref()) } else { Vec::new() };
        // A set that was given up before is contradicted by what the last one does not have to explain.
        let consistency = fits.map(|fits| fits.1).filter(|fits| keep || fits.statistic > fits.most);
        let states = places.iter().flat_map(|p| p.members.iter().map(|(pose, c)| pose::box_95(*pose, c))).collect();
        Localization {
            nuisances: if keep { nuisances } else { Vec::new() },
            consistency,
            unsure,
            method: NAME,
            status,
            estimate,
            hypotheses: if keep { hypotheses } else { Vec::new() },
            trajectory: if keep { trajectory } else { Vec::new() },
            odometry: odometry.filter(|_| keep),
            states: if keep { states } else { Vec::new() },
            encloses: false,
            first_states: self.first_states,
            steps: self.steps,
            events: self.events,
            shapes: if keep { shapes } else { Vec::new() },
        }
    }
}

fn odometry_estimate([long, aside, turn]: [[f64; 2]; 3]) -> OdometryEstimate {
    OdometryEstimate {
        translation_scale: 1.0 + long[0],
        translation_scale_std: long[1],
        aside: aside[0],
        aside_std: aside[1],
        rotation_scale: 1.0 + turn[0],
        rotation_scale_std: turn[1],
    }
}

/// A row whose work is to be done: its time (s), the odometry since the first row, its possible readings and heading.
pub(super) struct TakenRow {
    t: f64,
    odom: Pose2,
    readings: Vec<f64>,
    heading: Option<f64>,
}

/// One quantity of one whisker in a log.
struct Reader {
    whisker: usize,
    quantity: SensedQuantity,
    channel: usize,
    noise: ReadingNoise,
    /// What the whisker can cause, where that is known.
    limit: Option<LimitCheck>,
}

/// What a log has of each whisker, at least one; the moment first.
fn readers(robot: &Robot, tips: &[TipModel], channels: &[Channel]) -> Result<Vec<Reader>> {
    let log = SensorLog { channels: channels.to_vec(), ..SensorLog::default() };
    let mut readers = Vec::new();
    for (index, (whisker, tip)) in robot.whiskers.iter().zip(tips).enumerate() {
        let before = readers.len();
        let quantities = [
            (Quantity::Moment, SensedQuantity::Moment),
            (Quantity::Force, SensedQuantity::Force),
            (Quantity::Slope, SensedQuantity::Slope),
        ];
        for (column, quantity) in quantities {
            let Some(channel) = log.channel(&whisker.name, column) else { continue };
            let limit = (quantity == SensedQuantity::Moment).then(|| LimitCheck::any_place(whisker, tip));
            readers.push(Reader { whisker: index, quantity, channel, noise: quantity.noise(whisker), limit });
        }
        if readers.len() == before {
            log.moment_channel(&whisker.name)?;
        }
    }
    Ok(readers)
}

/// Work between two places at which the drawing of whiskers may pause.
const DRAWN_UNITS: usize = 600;
/// So many impossible readings on end are no single false readings any more.
const MOST_IMPOSSIBLE: usize = 4;
/// At least so many contacts are kept for drawing, where there are as many: each takes a third of a millisecond at the end.
const DRAWN: usize = 12;
/// Events that are kept where the way is not recorded.
const LAST_EVENTS: usize = 100;
