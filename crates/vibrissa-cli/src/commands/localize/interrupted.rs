//! What is known by the last row, put aside for an interrupt in the middle of a long step.

use super::inputs::Inputs;
use crate::interrupt::last_resort;
use crate::output::{OutputArgs, Run, Runtime, complain, deliver, no_answer, progress, warn};
use std::cell::Cell;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use vibrissa::flow::pose::{Estimate, Localization, StampedPose};
use vibrissa::{Localizer, Method};

/// How often an estimate is put aside: one takes a tenth of a millisecond to some milliseconds.
const EVERY: Duration = Duration::from_millis(100);

/// What is put aside, shared with the thread that is told of a signal.
#[derive(Default)]
struct Aside {
    rows: usize,
    estimate: Estimate,
    trajectory: Vec<StampedPose>,
    /// The answer, once there is one.
    answer: Option<(Localization, Option<Vec<u8>>)>,
}

/// Puts aside what is known.
pub(super) struct Known {
    aside: Arc<Mutex<Aside>>,
    last: Cell<Instant>,
    times: Vec<f64>,
}

impl Known {
    /// Begins, and says what becomes of it where work does not heed an interrupt in time: the same files, marked.
    pub(super) fn keep(inputs: &Inputs, method: &Method, output: &OutputArgs) -> Self {
        let aside = Arc::new(Mutex::new(Aside::default()));
        let begin = Instant::now();
        let (shared, output, method) = (Arc::clone(&aside), output.clone(), method.name());
        let (title, map, truth, all) = (inputs.title(), inputs.outlines(), inputs.truth.clone(), inputs.rows().len());
        last_resort(move || {
            let aside = core::mem::take(&mut *shared.lock().unwrap_or_else(PoisonError::into_inner));
            let rows = aside.rows;
            let whole = aside.answer.is_some();
            let (answer, recording) =
                aside.answer.unwrap_or_else(|| (answer(method, aside.estimate, aside.trajectory), None));
            let total_s = begin.elapsed().as_secs_f64();
            let runtime = Runtime { total_s, ..Runtime::default() };
            warn(&if whole {
                super::WHOLE.to_owned()
            } else {
                format!(
                    "interrupted after {rows} of {all} rows: the results are what was known by then, less exact than at the end of a log"
                )
            });
            let run = Run {
                title,
                answer,
                runtime,
                rows,
                interrupted: !whole,
                map,
                truth,
                recording,
                inputs: Vec::new(),
                film: None,
            };
            if let Err(error) = deliver(&run, &output) {
                complain("error", &error);
            }
        });
        let times = inputs.rows().iter().map(|row| row.t).collect();
        Self { aside, last: Cell::new(begin), times }
    }

    fn aside(&self) -> std::sync::MutexGuard<'_, Aside> {
        self.aside.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts the estimate aside from time to time, and at the last row, behind which the search for the answer begins.
    pub(super) fn row(&self, rows: usize, localizer: &Localizer<'_>) {
        let now = Instant::now();
        let is_last = rows == self.times.len();
        if !is_last && now - self.last.get() < EVERY {
            return;
        }
        progress::count(rows, self.times.len());
        if is_last {
            progress::phase("searching the places that explain the whole log");
        }
        let estimate = localizer.estimate();
        let mut aside = self.aside();
        let t = rows.checked_sub(1).and_then(|row| self.times.get(row)).copied();
        aside.trajectory.extend(t.zip(estimate.pose()).map(|(t, map_from_robot)| StampedPose { t, map_from_robot }));
        (aside.rows, aside.estimate) = (rows, estimate);
        // From its end on, so that slow estimates take no more than a part of the time.
        self.last.set(Instant::now());
    }

    /// Puts the answer aside.
    pub(super) fn answer(&self, answer: &Localization, recording: &Option<Vec<u8>>) {
        self.aside().answer = Some((answer.clone(), recording.clone()));
    }
}

/// The answer that an estimate is.
fn answer(method: &'static str, estimate: Estimate, trajectory: Vec<StampedPose>) -> Localization {
    let pose = estimate.pose();
    Localization {
        method,
        status: estimate.status,
        estimate: pose,
        states: estimate.hypotheses.iter().map(|place| place.extent).collect(),
        hypotheses: estimate.hypotheses,
        trajectory,
        ..no_answer()
    }
}
