//! `vibrissa live --replay`: a recorded run again.

use super::monitor::{Monitor, say, verdict};
use super::{Args, map_of, no_map, robot_of};
use crate::interrupt::stopped;
use crate::output::warn;
use core::ops::ControlFlow;
use std::path::Path;
use vibrissa::{Error, Result};
use vibrissa_live::journal;
use vibrissa_live::replay::{Pace, Played, replay};
use vibrissa_live::run::Health;
use vibrissa_live::setup::{self, Setup};

pub(super) fn run(args: &Args, recording: &Path, other: Option<&Path>) -> Result<()> {
    let recorded = journal::read(recording)?;
    recorded.warnings.iter().for_each(|warning| warn(warning));
    let setup = match other {
        Some(path) => of_same_sources(setup::read(path)?, &recorded.setup, path)?,
        None => recorded.setup.clone(),
    };
    let map = map_of(&setup)?.ok_or_else(|| {
        no_map(&setup).remedy(
            "a run that made a map is mapped again by `vibrissa map RECORDING`; give a setup with a map to localize in",
        )
    })?;
    let robot = robot_of(&setup, true)?;
    let mut monitor = Monitor::new(args.json);
    let (mut same, mut told) = (0, 0);
    // By another setup other rows come out, and no recorded merging fits them.
    let pace = Pace { speed: args.speed, every_row: other.is_some() };
    let answer = replay(&recorded, &setup, &map, &robot, pace, &mut |played| {
        match played {
            Played::Estimate(estimate) => {
                same += usize::from(recorded.lines.get(told) == Some(&estimate.line));
                told += 1;
                if args.speed.is_some() {
                    monitor.estimate(estimate, &Health::default());
                } else {
                    monitor.line(estimate);
                }
            }
            Played::Notice(notice) if args.speed.is_some() || other.is_some() => monitor.notice(notice),
            Played::Notice(_) => {}
        }
        if stopped() || monitor.is_closed() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    monitor.end();
    if answer.missing > 0 {
        warn(&format!("{} rows of the run are not in its raw bytes: they were dropped or cut off", answer.missing));
    }
    let mut text = verdict(&answer.estimate, &Health { rows: answer.rows, ..Health::default() });
    text.push_str(&format!("  rows: {}\n", answer.rows));
    if other.is_none() {
        text.push_str(&format!(
            "  estimates: {same} of {} the same to the byte as during the run\n",
            recorded.lines.len()
        ));
    }
    say(args.json, &text)
}

/// A setup for a recording of another one: its sources must be named alike.
fn of_same_sources(setup: Setup, recorded: &Setup, path: &Path) -> Result<Setup> {
    let names = |setup: &Setup| setup.sources.iter().map(|source| source.name.clone()).collect::<Vec<_>>();
    if names(&setup) == names(recorded) {
        return Ok(setup);
    }
    Err(Error::data("the setup has other sources than the recording")
        .in_file(path)
        .value(names(&setup).join(", "))
        .allowed(names(recorded).join(", "))
        .remedy("name the sources as they were, in their order"))
}
