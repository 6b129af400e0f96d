//! The second door: moments along the sweep, smoothed over a short history.
//!
//! The paper aligns a whisker's shape with the boundary by the slope that "a short temporal history (2 to 3) of whisker
//! shapes" shows \[routray, section "Constructing a Preimage from Sensor Observation"\]. A single reading is off by
//! several percent, so the shapes are taken from a parabola through all readings of the history.

use super::quadratic::Quadratic;
use crate::config::DeterministicOptions;
use crate::plane::{Pose2, Vec2};
use crate::world::MountedWhisker;
use std::collections::VecDeque;

/// Fewest readings in a history: a parabola and two to check it.
const FEWEST_READINGS: usize = 5;
/// Readings closer than this share of the update travel are averaged: a robot that stands still adds no shapes.
const STANDSTILL: f64 = 0.05;

/// A moment and where the whisker base was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MomentReading {
    /// When (s).
    pub t: f64,
    /// The whisker base in the odometry frame.
    pub odom_from_whisker: Pose2,
    /// The base moment (N m).
    pub moment: f64,
}

/// A short stretch of contact: smoothed moments at a few poses.
#[derive(Clone, Debug, PartialEq)]
pub struct MomentHistory {
    /// The reading in the middle, smoothed: the one that gets aligned.
    pub center: MomentReading,
    /// The readings, smoothed, at which shapes are taken, in time order.
    pub shapes: Vec<MomentReading>,
    /// How far the base had travelled at each shape, from the centre (m).
    pub travel: Vec<f64>,
    /// Standard deviation of the centre's moment (N m) if the declared bound is used evenly and independently.
    pub center_std: f64,
    /// Standard deviation of the moment's slope along the travel (N m/m), likewise.
    pub slope_std: f64,
    /// Standard deviation of half the moment's second derivative along the travel (N m/m²), likewise.
    pub bend_std: f64,
    /// Bound on the error of one reading at the centre (N m).
    pub bound: f64,
    /// Whether a parabola explains all readings within their bound; if not, something jumped in between.
    pub smooth: bool,
}

#[derive(Clone, Copy, Debug)]
struct Sample {
    reading: MomentReading,
    travel: f64,
    count: f64,
}

/// The readings of one contact of one whisker, from which histories are cut.
#[derive(Clone, Debug)]
pub struct MomentTrack {
    tip: Vec2,
    relative: f64,
    absolute: f64,
    shapes: usize,
    span: f64,
    update: f64,
    samples: VecDeque<Sample>,
    updated_at: Option<f64>,
}

impl MomentTrack {
    /// An empty track for this whisker.
    #[must_use]
    pub fn new(whisker: &MountedWhisker, options: &DeterministicOptions) -> Self {
        Self {
            tip: Vec2::new(whisker.beam.length, 0.0),
            relative: whisker.noise.moment_relative,
            absolute: whisker.noise.moment_absolute,
            shapes: options.history_shapes,
            span: options.history_travel,
            update: options.update_travel,
            samples: VecDeque::new(),
            updated_at: None,
        }
    }

    /// Whether a reading this large means contact: it exceeds what the bound allows without any.
    #[must_use]
    pub fn is_contact(&self, moment: f64) -> bool {
        moment.abs() > self.absolute / (1.0 - self.relative)
    }

    /// Adds a reading in contact; a history, when the base has travelled far enough since the last.
    pub fn push(&mut self, reading: MomentReading) -> Option<MomentHistory> {
        self.append(reading);
        self.trim();
        let newest = self.samples.back()?.travel;
        let span = newest - self.samples.front()?.travel;
        let due = self.updated_at.is_none_or(|at| newest - at >= self.update);
        if !due || span < 0.98 * self.span || self.samples.len() < FEWEST_READINGS {
            return None;
        }
        self.updated_at = Some(newest);
        self.history()
    }

    /// Ends the contact; a history of all its readings, when it was too short for one so far.
    pub fn end(&mut self) -> Option<MomentHistory> {
        let whole = self.updated_at.is_none() && self.samples.len() >= FEWEST_READINGS;
        let history = if whole { self.history() } else { None };
        self.samples.clear();
        self.updated_at = None;
        history
    }

    fn append(&mut self, reading: MomentReading) {
        let Some(last) = self.samples.back_mut() else {
            self.samples.push_back(Sample { reading, travel: 0.0, count: 1.0 });
            return;
        };
        let (from, to) = (last.reading.odom_from_whisker, reading.odom_from_whisker);
        let base = from.position().distance(to.position());
        let moved = base.max(from.transform_point(self.tip).distance(to.transform_point(self.tip)));
        if moved < STANDSTILL * self.update {
            last.count += 1.0;
            last.reading.moment += (reading.moment - last.reading.moment) / last.count;
        } else {
            let travel = last.travel + moved;
            self.samples.push_back(Sample { reading, travel, count: 1.0 });
        }
    }

    /// Drops readings that lie before the history, as long as enough remain.
    fn trim(&mut self) {
        let newest = self.samples.back().map_or(0.0, |s| s.travel);
        while self.samples.len() > FEWEST_READINGS
            && self.samples.get(1).is_some_and(|s| newest - s.travel >= self.span)
        {
            self.samples.pop_front();
        }
    }

    fn nearest(&self, travel: f64) -> Option<&Sample> {
        self.samples.iter().min_by(|a, b| (a.travel - travel).abs().total_cmp(&(b.travel - travel).abs()))
    }

    fn history(&self) -> Option<MomentHistory> {
        let (first, last) = (self.samples.front()?.travel, self.samples.back()?.travel);
        let center = *self.nearest(0.5 * (first + last))?;
        let fit = Quadratic::fit(self.samples.iter().map(|s| (s.travel - center.travel, s.reading.moment)))?;
        let smoothed = |s: &Sample| MomentReading { moment: fit.at(s.travel - center.travel), ..s.reading };
        let bound = |moment: f64| self.relative * moment.abs() + self.absolute;
        // The parabola itself may be off by part of the bound, so a little more than the bound is forgiven.
        let smooth = self.samples.iter().all(|s| {
            let z = s.reading.moment;
            (fit.at(s.travel - center.travel) - z).abs() <= 1.3 * bound(z)
        });
        let mut picked: Vec<&Sample> = Vec::with_capacity(self.shapes);
        for k in 0..self.shapes {
            let share = k as f64 / (self.shapes - 1) as f64;
            let sample = self.nearest(first + share * (last - first))?;
            if picked.last().is_none_or(|p| p.travel < sample.travel) {
                picked.push(sample);
            }
        }
        let readings = self.samples.iter().map(|s| s.count).sum::<f64>() / self.samples.len() as f64;
        let std = bound(fit.a) / 3.0_f64.sqrt() / readings.sqrt();
        Some(MomentHistory {
            center: smoothed(&center),
            travel: picked.iter().map(|s| s.travel - center.travel).collect(),
            shapes: picked.into_iter().map(smoothed).collect(),
            center_std: std * fit.variance_a.sqrt(),
            slope_std: std * fit.variance_b.sqrt(),
            bend_std: std * fit.variance_c.sqrt(),
            bound: bound(fit.a),
            smooth,
        })
    }
}
