//! Odometry and readings with ROS times to rows, by the clock and the join of live runs.

use std::collections::VecDeque;
use vibrissa_core::plane::Pose2;
use vibrissa_io::Calibrator;
use vibrissa_live::config::{ROWS_BEFORE_MERGING, ROWS_WAITING};
use vibrissa_live::counts::Counts;
use vibrissa_live::decode::Frame;
use vibrissa_live::estimate::{UsedRow, merged};
use vibrissa_live::join::{Joiner, Share};
use vibrissa_live::timing::{TimeBase, Timing};

const READINGS: usize = 0;
const ODOMETRY: usize = 1;

/// Messages to rows. All stamps are of one clock, that of ROS.
#[derive(Clone, Debug)]
pub struct Feed {
    timings: [Timing; 2],
    counts: [Counts; 2],
    joiner: Joiner,
    calibrator: Option<Calibrator>,
    /// How many readings a message has.
    readings: usize,
    rows: VecDeque<UsedRow>,
    odometry: Option<(f64, Pose2)>,
    /// When the last readings and the last odometry arrived (host, s).
    heard: [Option<f64>; 2],
}

impl Feed {
    /// A feed of messages with so many readings, `delay` (s) older than their stamps say, and what makes moments of them.
    #[must_use]
    pub fn new(readings: usize, calibrator: Option<Calibrator>, delay: f64) -> Self {
        let shares = vec![Share { pose: false, readings }, Share { pose: true, readings: 0 }];
        Self {
            timings: [Timing::new(TimeBase::Own, delay), Timing::new(TimeBase::Own, 0.0)],
            counts: [Counts::default(); 2],
            joiner: Joiner::new(shares, READINGS, ODOMETRY),
            calibrator,
            readings,
            rows: VecDeque::new(),
            odometry: None,
            heard: [None; 2],
        }
    }

    /// Takes odometry: its stamp (s), its arrival (host, s), the robot in the odometry frame; none where it held no pose.
    pub fn odometry(&mut self, stamp: f64, arrival: f64, pose: Option<Pose2>) {
        if let Some(pose) = pose {
            self.odometry = Some((stamp, pose));
        }
        self.push(ODOMETRY, stamp, arrival, pose.map(|pose| Frame { pose: Some(pose), ..Frame::default() }));
    }

    /// Takes readings: their stamp (s), their arrival (host, s) and values; none where the message did not hold them.
    pub fn readings(&mut self, stamp: f64, arrival: f64, values: Option<Vec<f64>>) {
        let values = values.filter(|values| values.len() == self.readings && values.iter().all(|v| v.is_finite()));
        self.push(READINGS, stamp, arrival, values.map(|readings| Frame { readings, ..Frame::default() }));
    }

    fn push(&mut self, stream: usize, stamp: f64, arrival: f64, frame: Option<Frame>) {
        self.heard[stream] = Some(arrival);
        let (counts, joiner) = (&mut self.counts[stream], &mut self.joiner);
        match frame {
            None => counts.damaged += 1,
            Some(frame) => {
                counts.frames += 1;
                let frame = Frame { stamp: Some(stamp), ..frame };
                self.timings[stream]
                    .push(frame, arrival, counts, &mut |t, frame| joiner.push(stream, t, arrival, frame));
            }
        }
        self.tick(arrival);
    }

    /// Joins what is complete by now (host, s).
    pub fn tick(&mut self, now: f64) {
        let Self { joiner, calibrator, rows, counts, .. } = self;
        let mut beyond = 0;
        counts[READINGS].unjoined += joiner.rows(now, &mut |mut joined| match calibrator
            .as_ref()
            .map_or(Ok(()), |calibrator| calibrator.row(&mut joined.row))
        {
            Ok(()) => rows.push_back(UsedRow { joined, merged: 1 }),
            Err(_) => beyond += 1,
        });
        counts[READINGS].uncalibrated += beyond;
        if rows.len() > ROWS_WAITING {
            *rows = merged(core::mem::take(rows).into_iter(), ROWS_WAITING / 2).into();
        }
    }

    /// The rows that wait; of many the newest of each stretch.
    pub fn take(&mut self) -> Vec<UsedRow> {
        merged(core::mem::take(&mut self.rows).into_iter(), ROWS_BEFORE_MERGING)
    }

    /// Whether rows wait.
    #[must_use]
    pub fn has_rows(&self) -> bool {
        !self.rows.is_empty()
    }

    /// The last odometry: its stamp (s) and the robot in the odometry frame.
    #[must_use]
    pub fn last_odometry(&self) -> Option<(f64, Pose2)> {
        self.odometry
    }

    /// Whether a clock went back: what came before has nothing to do with what comes.
    #[must_use]
    pub fn jumped(&self) -> bool {
        self.counts.iter().any(|counts| counts.resets > 0)
    }

    /// Counts of readings and of odometry, with their names, and when each was heard last (host, s).
    #[must_use]
    pub fn counts(&self) -> [(&'static str, &Counts, Option<f64>); 2] {
        [
            ("readings", &self.counts[READINGS], self.heard[READINGS]),
            ("odometry", &self.counts[ODOMETRY], self.heard[ODOMETRY]),
        ]
    }
}
