//! The localizers on worlds of any kind, row by row and in pieces, as a robot that must answer in time calls them.

use super::world::World;
use super::{Verdict, promise, read, refused, size};
use crate::watch::worked;
use core::time::Duration;
use std::time::Instant;
use vibrissa::flow::pose::Hypothesis;
use vibrissa::localizer::{Localizer, Method};
use vibrissa::{Stop, WorkBudget};

/// Units of a piece, after which a caller looks at the clock.
const PIECE: usize = 1000;
/// Pieces after which the end is asked for: some tenths of a second.
const MOST_PIECES: usize = 1000;
/// Longest piece: what is asked to end may take so long, where the machine is as fast as one that is measured on.
const LONGEST: Duration = if cfg!(debug_assertions) { Duration::from_millis(1000) } else { Duration::from_millis(200) };

pub(crate) fn deterministic(bytes: &[u8]) -> Verdict {
    place(bytes, "deterministic")
}

pub(crate) fn possibilistic(bytes: &[u8]) -> Verdict {
    place(bytes, "possibilistic")
}

pub(crate) fn probabilistic(bytes: &[u8]) -> Verdict {
    place(bytes, "probabilistic")
}

/// Rows in pieces; after the last of them, or when time is up, the end is asked for and must come.
fn place(bytes: &[u8], method: &str) -> Verdict {
    let answer = World::read(bytes).and_then(|world| {
        let method = world.with_options(Method::named(method)?);
        let mut localizer = Localizer::new(&world.map, &world.robot, &world.log.channels, &method)?;
        let stop = Stop::default();
        localizer.heed(&stop);
        let mut run = Run { localizer, pieces: 0, longest: Duration::ZERO, told: 0 };
        for (index, row) in world.log.rows.iter().enumerate() {
            run.measured(|localizer| localizer.begin(row).map(|()| true))?;
            run.work(&stop)?;
            if stop.is_asked() {
                break;
            }
            if index % 16 == 7
                && let Err(fault) = run.told()
            {
                return Ok(Err(fault));
            }
        }
        run.localizer.end();
        run.work(&stop)?;
        Ok(run.finish(stop.is_asked()))
    });
    match answer {
        Ok(verdict) => verdict,
        Err(error) => refused(&error),
    }
}

/// A localizer at work, and how long its pieces are.
struct Run<'a> {
    localizer: Localizer<'a>,
    pieces: usize,
    longest: Duration,
    /// Most places that were told.
    told: usize,
}

impl Run<'_> {
    /// Does one piece and keeps how long the longest took.
    fn measured<T>(&mut self, piece: impl FnOnce(&mut Localizer<'_>) -> vibrissa::Result<T>) -> vibrissa::Result<T> {
        let (begin, before) = (Instant::now(), worked());
        let done = piece(&mut self.localizer);
        let mut time = begin.elapsed();
        if time > LONGEST {
            // A busy machine lets a try wait; what counts is its own work.
            time = worked().zip(before).map_or(time, |(now, then)| now.saturating_sub(then));
        }
        self.longest = self.longest.max(time);
        done
    }

    /// Goes on until nothing is left to do, or the end is due.
    fn work(&mut self, stop: &Stop) -> vibrissa::Result<()> {
        loop {
            if self.measured(|localizer| Ok(localizer.advance(&mut WorkBudget::new(PIECE))))? {
                return Ok(());
            }
            self.pieces += 1;
            if self.pieces == MOST_PIECES {
                stop.ask();
            }
            if self.pieces > MOST_PIECES + MOST_PIECES / 4 {
                // What is left is done by `finish`, which heeds the request.
                return Ok(());
            }
        }
    }

    /// What is told at a row is sound, and asking changes nothing.
    fn told(&mut self) -> Result<(), String> {
        let estimate = self.localizer.estimate();
        sound(&estimate.hypotheses)?;
        promise(estimate == self.localizer.estimate(), || "an estimate that changes when it is asked for".into())?;
        self.told = self.told.max(estimate.hypotheses.len());
        let whole =
            self.localizer.states_now().iter().all(|pose| pose.position().is_finite() && pose.theta.is_finite());
        promise(whole, || "a state that is no numbers".into())
    }

    fn finish(mut self, is_stopped: bool) -> Verdict {
        let (begin, before) = (Instant::now(), worked());
        let answer = self.localizer.finish();
        let time = worked().zip(before).map_or(begin.elapsed(), |(now, then)| now.saturating_sub(then));
        if is_stopped {
            self.longest = self.longest.max(time);
        }
        let longest = self.longest;
        promise(longest <= LONGEST, || format!("a piece of work of {} ms", longest.as_millis()))?;
        sound(&answer.hypotheses)?;
        let sizes = answer.steps.iter().all(|s| s.area_m2 >= 0.0 && s.volume >= 0.0);
        promise(sizes, || format!("a set of no size: {:?}", answer.steps))?;
        let path = answer.trajectory.iter().all(|p| p.map_from_robot.position().is_finite());
        promise(path, || "a trajectory that is no numbers".into())?;
        read((
            answer.status as u8,
            size(answer.steps.len()),
            size(answer.events.len()),
            size(answer.hypotheses.len()),
            size(self.told),
            is_stopped,
        ))
    }
}

/// Places in numbers, with weights that are shares and extents that hold them.
fn sound(places: &[Hypothesis]) -> Result<(), String> {
    let weights: f64 = places.iter().map(|h| h.weight).sum();
    promise(places.is_empty() || (weights > 0.0 && weights <= 1.0 + 1e-9), || {
        format!("weights that sum to {weights}")
    })?;
    for place in places {
        let finite = place.pose.position().is_finite() && place.pose.theta.is_finite() && place.weight >= 0.0;
        promise(finite, || format!("a place that is no numbers: {place:?}"))?;
        let spread = place
            .covariance
            .is_none_or(|c| c.iter().flatten().all(|v| v.is_finite()) && (0..3).all(|k| c[k][k] >= 0.0));
        promise(spread, || format!("a covariance that is none: {:?}", place.covariance))?;
        let ridge = place.ridge.iter().all(|p| p.position().is_finite() && p.theta.is_finite());
        promise(ridge, || "a ridge that is no numbers".into())?;
    }
    Ok(())
}
