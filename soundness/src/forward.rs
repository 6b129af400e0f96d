//! The smoother's forward model along the true way of drives around corners, against the simulator's moments without noise.

use crate::corner_drive;
use std::process::ExitCode;
use vibrissa::beam::TipModel;
use vibrissa::flow::state_set::probabilistic::{PredictedMoment, predicted_moments, predicted_moments_by_readings};
use vibrissa::plane::Pose2;
use vibrissa::world::MomentNoise;

/// A row is odd where the two differ by more than this share of the declared noise.
const ODD: f64 = 0.5;

/// Rows of a drive.
#[derive(Clone, Copy, Default)]
pub(crate) struct Followed {
    /// Whether the base is elastic, where the model knows contacts of the tip only.
    is_elastic: bool,
    touching: usize,
    /// Odd rows, those of them with two contacts at once, and stretches of odd rows.
    odd: usize,
    doubled: usize,
    stretches: usize,
    /// Odd rows where readings tell on which branch of equilibria the whisker is.
    by_readings: usize,
}

/// The drive of a seed, if there is one; stretches of odd rows are printed.
pub(crate) fn drive(seed: u64) -> Option<(u64, Followed)> {
    let (drive, _) = corner_drive(seed, 1)?;
    let simulated = &drive.simulated;
    let whisker = &simulated.robot.whiskers[0];
    let bases: Vec<Pose2> =
        simulated.path.iter().map(|p| p.map_from_robot.compose(whisker.robot_from_whisker)).collect();
    let tip = TipModel::new(&whisker.beam).ok()?;
    let told = predicted_moments(&simulated.map, &tip, &bases);
    let noise = MomentNoise {
        moment_relative: ODD * whisker.noise.moment_relative,
        moment_absolute: ODD * whisker.noise.moment_absolute,
    };
    let by_readings = predicted_moments_by_readings(&simulated.map, &tip, &bases, &simulated.moments, noise);
    let off = |row: usize, told: &[PredictedMoment]| {
        let exact = simulated.moments[row];
        (told[row].moment - exact).abs() > noise.moment_relative * exact.abs() + noise.moment_absolute
    };
    let is_odd = |row: usize| off(row, &told);
    let rows = bases.len();
    let mut one = Followed {
        is_elastic: whisker.beam.base_stiffness.is_finite(),
        by_readings: (0..rows).filter(|&row| off(row, &by_readings)).count(),
        ..Followed::default()
    };
    let mut row = 0;
    while row < rows {
        let touches = simulated.touches[row];
        one.touching += usize::from(touches > 0);
        if !is_odd(row) {
            row += 1;
            continue;
        }
        let from = row;
        while row < rows && is_odd(row) {
            one.touching += usize::from(row > from && simulated.touches[row] > 0);
            one.doubled += usize::from(simulated.touches[row] > 1);
            row += 1;
        }
        (one.odd, one.stretches) = (one.odd + row - from, one.stretches + 1);
        let t = |row: usize| simulated.path[row.min(rows - 1)].t;
        let before = simulated.events.iter().rev().find(|event| event.t <= t(from) + 1e-9);
        println!(
            "seed {seed}{}: rows {from} to {row} of {rows}, {:.3} to {:.3} s: told {:.3e}, is {:.3e} N m, {} contacts; last {}",
            if one.is_elastic { " (elastic base)" } else { "" },
            t(from),
            t(row),
            told[from].moment,
            simulated.moments[from],
            touches,
            before.map_or_else(|| "nothing".to_owned(), |event| format!("{:.3} {}", event.t, event.kind)),
        );
    }
    Some((seed, one))
}

/// Counts of all drives.
pub(crate) fn report(all: &[Followed]) -> ExitCode {
    for elastic in [false, true] {
        let some: Vec<&Followed> = all.iter().filter(|one| one.is_elastic == elastic).collect();
        let sum = |of: &dyn Fn(&Followed) -> usize| some.iter().map(|one| of(one)).sum::<usize>();
        println!(
            "{} base: {} drives, {} rows with contact: {} odd ({} with two contacts) in {} stretches of {} drives; where readings tell the branch {} odd",
            if elastic { "elastic" } else { "clamped" },
            some.len(),
            sum(&|one| one.touching),
            sum(&|one| one.odd),
            sum(&|one| one.doubled),
            sum(&|one| one.stretches),
            some.iter().filter(|one| one.odd > 0).count(),
            sum(&|one| one.by_readings),
        );
    }
    if all.is_empty() { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}
