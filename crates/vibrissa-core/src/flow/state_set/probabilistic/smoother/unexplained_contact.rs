//! Contacts that the best mode does not explain: fault detection by residuals \[barshalom2001estimation, sec. 5.4\]. Where another boundary is
//! within reach the contact is one that the model does not cover, and is left out until the whisker is free; else the modes are wrong.

use super::super::goodness_of_fit::Fit;
use super::super::measurement::Row;
use super::super::optimisation::UNEXPLAINED;
use super::super::places::PosteriorPlace;
use super::{CONTACT_ROWS, MultiHypothesisSmoother, Phase, StepOutcome};
use crate::flow::pose::Stretch;
use crate::plane::{Bounds, Vec2, wrap_angle};

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

impl MultiHypothesisSmoother<'_> {
    /// Looks whether the best mode explains the last rows. Where a sensor's are not explained after a contact that was, the whisker is in
    /// one that the model does not cover, and its readings say nothing of the place until it is free; otherwise the modes are wrong.
    pub(super) async fn judge(&mut self) -> StepOutcome {
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
    pub(super) async fn keep_explained(&mut self) {
        let Self { scene, window, phase, explained, .. } = self;
        let Phase::Tracking(bank) = phase else { return };
        let before = explained.as_ref().map_or(0, |(_, rows)| *rows);
        let model = scene.model(window, 0);
        if bank.modes.len() <= MANY_KEPT && bank.explains_from(&model, before).await {
            *explained = Some((Box::new(bank.copy(&model).await), bank.seen));
        }
    }

    /// The places by the modes before a contact at the end of the log which none of them explains: the model does not cover it, and nothing
    /// has come after it. None where that is not so, or does not explain the rest.
    pub(super) async fn before_unexplained_end(&mut self) -> Option<(Vec<PosteriorPlace>, Option<Fit>)> {
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
    pub(super) async fn ends_unexplained(&mut self, from: usize) -> bool {
        let Self { scene, window, phase, .. } = self;
        let Phase::Tracking(bank) = phase else { return false };
        let rows: Vec<usize> = bank.rows.iter().copied().filter(|&row| row < from).chain(from..window.len()).collect();
        let told = bank.run_rows(&scene.model(window, 0), &rows).await;
        let last = told.rows.iter().rev().take(CONTACT_ROWS * scene.sensors.len());
        last.filter(|row| is_off(row)).count() >= CONTACT_ROWS
    }

    /// What the best mode does not explain, if it is anything: a sensor's readings from a row on, where that contact can be left out, or all.
    pub(super) async fn unexplained(&mut self) -> Option<Option<(usize, usize)>> {
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
    pub(super) fn may_touch_twice(&self, sensor: usize, row: usize) -> bool {
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

    /// Places that explain a contact which is left out at the end of the log as one that the model covers: the robot was carried there. None
    /// where it is shorter than the whisker, since little is explained anywhere.
    pub(super) async fn elsewhere(&mut self) -> Option<(Vec<PosteriorPlace>, Option<Fit>)> {
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
