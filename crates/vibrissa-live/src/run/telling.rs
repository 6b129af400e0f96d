//! What is told while a run goes on, on the calling thread: estimates as they come, and where the estimator is late the last one
//! carried on by odometry.

use super::queue::Shared;
use super::{Health, Update};
use crate::carry::carried;
use crate::config::CARRY_AFTER;
use crate::estimate::{Told, next_due};
use crate::join::JoinedRow;
use crate::journal::Journal;
use crate::pipeline::Notice;
use crate::source::HostClock;
use core::ops::ControlFlow;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use vibrissa_core::world::Odometry;

/// Whoever looks on.
pub(super) type Watch<'a> = &'a mut dyn FnMut(Update<'_>) -> ControlFlow<()>;

/// What is told next.
pub(super) struct Teller<'a> {
    pub(super) journal: Option<&'a Journal>,
    pub(super) clock: &'a HostClock,
    pub(super) shared: &'a Shared,
    pub(super) stop: &'a AtomicBool,
    pub(super) odometry: Odometry,
    /// Whether rows have times of the host, so that their age can be told.
    pub(super) on_host_time: bool,
    /// Time between estimates (s).
    pub(super) period: f64,
    /// Whether there are any.
    pub(super) estimates: bool,
}

/// What is known and what waits.
struct Known {
    /// The estimator's last estimate.
    latest: Option<Told>,
    /// Row time from which the next one is told.
    due: f64,
    /// Rows whose pose is not known yet.
    waiting: VecDeque<JoinedRow>,
    health: Health,
}

impl Teller<'_> {
    /// Tells until the estimator has ended.
    pub(super) fn tell(&self, watch: Watch<'_>) -> Health {
        let mut known =
            Known { latest: None, due: f64::NEG_INFINITY, waiting: VecDeque::new(), health: Health::default() };
        loop {
            let first = known.waiting.front().filter(|_| !self.shared.patient);
            let patience = first.map_or(f64::INFINITY, |row| row.arrival + CARRY_AFTER - self.clock.now());
            let news = self.shared.news(patience);
            self.look(&mut known.health);
            let quiet = news.rows.is_empty() && news.estimates.is_empty() && news.notices.is_empty();
            let mut go_on = self.say(&news.notices, watch);
            if let Some((channels, robot)) = &news.began {
                go_on &= watch(Update::Began(channels, robot)).is_continue();
            }
            for row in &news.rows {
                go_on &= watch(Update::Row(row)).is_continue();
            }
            known.waiting.extend(news.rows);
            while known.waiting.front().is_some_and(|row| row.row.line as u64 <= news.done.0) {
                let row = known.waiting.pop_front();
                row.iter().for_each(|row| self.time(&mut known.health, row, news.done.1));
            }
            for told in news.estimates {
                if told.t >= known.due {
                    go_on &= self.estimate(&told, &mut known, watch);
                }
                known.latest = Some(told);
            }
            if !self.shared.patient && self.estimates {
                go_on &= self.carry(&mut known, watch);
            }
            if quiet || !self.estimates {
                go_on &= watch(Update::Idle(&known.health)).is_continue();
            }
            if !go_on {
                self.stop.store(true, Ordering::Relaxed);
            }
            if news.finished {
                return known.health;
            }
        }
    }

    /// Rows that have waited long enough get the last estimate, carried on.
    fn carry(&self, known: &mut Known, watch: Watch<'_>) -> bool {
        let mut go_on = true;
        let now = self.clock.now();
        while known.waiting.front().is_some_and(|row| row.arrival + CARRY_AFTER <= now) {
            let Some(row) = known.waiting.pop_front() else { break };
            self.time(&mut known.health, &row, now);
            known.health.carried += 1;
            let Some(latest) = known.latest.as_ref().filter(|latest| row.row.t >= known.due && row.row.t > latest.t)
            else {
                continue;
            };
            let told = carried(latest, &row, &self.odometry);
            go_on &= self.estimate(&told, known, watch);
        }
        go_on
    }

    fn estimate(&self, told: &Told, known: &mut Known, watch: Watch<'_>) -> bool {
        known.due = next_due(told.t, self.period);
        if let Some(journal) = self.journal {
            journal.estimate(told);
        }
        watch(Update::Estimate(told, &known.health)).is_continue()
    }

    /// Counts how long a row took until its pose was known.
    fn time(&self, health: &mut Health, row: &JoinedRow, now: f64) {
        health.latency.push(now - row.arrival);
        if self.on_host_time {
            health.age.push(now - row.row.t);
        }
    }

    fn look(&self, health: &mut Health) {
        self.shared.look(health);
        if let Some(journal) = self.journal {
            (health.dropped, health.disk) = (journal.recorder().dropped(), journal.recorder().fault());
        }
    }

    /// Says what happened; whether to go on.
    fn say(&self, notices: &[Notice], watch: Watch<'_>) -> bool {
        let mut go_on = true;
        for notice in notices {
            if let Some(journal) = self.journal {
                journal.notice(notice);
            }
            go_on &= watch(Update::Notice(notice)).is_continue();
        }
        go_on
    }
}
