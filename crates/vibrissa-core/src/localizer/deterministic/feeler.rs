//! A whisker's readings on their way to histories, and what is remembered of the whole way.

use super::super::SHAPES;
use super::super::limit_check::LimitCheck;
use crate::beam::TipModel;
use crate::config::{DeterministicOptions, TipLoad};
use crate::flow::contact_set::Ladder;
use crate::flow::moment::{MomentHistory, MomentReading, MomentTrack};
use crate::flow::pose::{Event, StepRecord};
use crate::flow::preimage::Observation;
use crate::flow::sensor_log::{LogRow, SensorLog};
use crate::flow::state_set::Candidate;
use crate::flow::thinned::Thinned;
use crate::plane::Pose2;
use crate::world::MountedWhisker;
use crate::{Error, Result};

/// One whisker's way from its column of the log to its histories.
pub(super) struct WhiskerColumn {
    pub(super) whisker: MountedWhisker,
    pub(super) tip: TipModel,
    pub(super) contacts: Ladder,
    pub(super) channel: usize,
    pub(super) track: MomentTrack,
    pub(super) in_contact: bool,
    /// Whether the last moment was more than the tip can cause.
    pub(super) on_side: bool,
    /// What the tip can cause, and what the whisker can anywhere.
    pub(super) tip_limit: LimitCheck,
    pub(super) limit: LimitCheck,
}

impl WhiskerColumn {
    pub(super) fn new(whisker: &MountedWhisker, log: &SensorLog, options: &DeterministicOptions) -> Result<Self> {
        let tip = TipModel::new(&whisker.beam)?;
        leans(whisker, options)?;
        let limit = LimitCheck::any_place(whisker, &tip);
        let tip_limit = match options.tip_load {
            TipLoad::BoundaryNormal => LimitCheck::any_tilt(whisker, &tip),
            TipLoad::WhiskerNormal => LimitCheck::new(whisker, &tip, 0.0),
        };
        Ok(Self {
            channel: log.moment_channel(&whisker.name)?,
            track: MomentTrack::new(whisker, options),
            in_contact: false,
            on_side: false,
            tip_limit,
            limit,
            contacts: Ladder::new(&tip, options.tip_load, whisker.lean),
            tip,
            whisker: whisker.clone(),
        })
    }

    /// Whether the whisker can cause the reading of a row that it has not felt yet.
    ///
    /// # Errors
    ///
    /// The message names the line.
    pub(super) fn check(&self, row: &LogRow) -> Result<()> {
        let moment = self.moment(row);
        if self.tip_limit.allows(moment) {
            return Ok(());
        }
        // No contact begins like that.
        let limit = if self.in_contact || self.on_side { &self.limit } else { &self.tip_limit };
        limit.check(moment, row)
    }

    fn moment(&self, row: &LogRow) -> f64 {
        row.readings.get(self.channel).copied().unwrap_or(0.0)
    }

    /// The first two doors: reading → moment → history, of a row that was [checked](Self::check).
    pub(super) fn feel(&mut self, row: &LogRow, record: &mut RunRecord) -> Option<MomentHistory> {
        let moment = self.moment(row);
        let by_tip = self.tip_limit.allows(moment);
        if !by_tip {
            let detail = format!(
                "{}: {moment} N m is more than any contact of its tip causes; while its side touches nearer to its base, the \
                 readings are not used (if it hardly ever bends that far, check the unit: N m, not mN m)",
                self.whisker.name
            );
            record.event_once(row.t, "not_tip", detail);
        }
        self.on_side = !by_tip;
        let touching = self.track.is_contact(moment) && by_tip;
        if touching != self.in_contact {
            let (kind, what) = if touching { ("contact", "touches") } else { ("lift_off", "is free") };
            if by_tip {
                record.events.push(Event { t: row.t, kind, detail: format!("{} {what}", self.whisker.name) });
            }
        }
        self.in_contact = touching;
        if !touching {
            return self.track.end();
        }
        record.touched = true;
        let odom_from_whisker = row.odom_from_robot.compose(self.whisker.robot_from_whisker);
        self.track.push(MomentReading { t: row.t, odom_from_whisker, moment })
    }
}

/// Refuses whiskers that lean in a way that is not covered.
fn leans(whisker: &MountedWhisker, options: &DeterministicOptions) -> Result<()> {
    if whisker.lean.is_level() {
        return Ok(());
    }
    let fault =
        |what: &str| Error::data(format!("the whisker \"{}\" leans out of the horizontal and {what}", whisker.name));
    whisker.require_turned_plane()?;
    if options.tip_load == TipLoad::WhiskerNormal {
        return Err(fault("the load is taken normal to it, not to the walls")
            .remedy("take --tip-load boundary-normal, since an upright wall pushes horizontally"));
    }
    Ok(())
}

/// What is remembered of the way, for the answer.
#[derive(Default)]
pub(super) struct RunRecord {
    pub(super) touched: bool,
    pub(super) steps: Vec<StepRecord>,
    pub(super) events: Vec<Event>,
    /// Whisker and observation until the state set starts.
    pub(super) waiting: Vec<(usize, Observation)>,
    /// Whisker and observation, for drawing: not all of long logs, which would fill the memory.
    pub(super) observations: Thinned<(usize, Observation), SHAPES>,
    pub(super) first_states: Vec<Pose2>,
    pub(super) first_row: Option<usize>,
    /// The best candidate and the row of the last update before the set became empty.
    pub(super) last: Option<(Candidate, usize)>,
    pub(super) empty_at: Option<usize>,
}

impl RunRecord {
    /// Notes that no candidate is left.
    pub(super) fn emptied(&mut self, t: f64, row: usize) {
        self.empty_at = Some(row);
        let detail = "nowhere on this map explains the readings up to here; \
                      is it the right map, are whisker and noise bounds those of the robot, and did \
                      the whisker touch with its tip alone, as it may not in corners?"
            .to_owned();
        self.events.push(Event { t, kind: "inconsistent", detail });
    }

    /// Adds an event unless the same kind was the last one.
    pub(super) fn event_once(&mut self, t: f64, kind: &'static str, detail: String) {
        if self.events.last().is_none_or(|e| e.kind != kind) {
            self.events.push(Event { t, kind, detail });
        }
    }
}
