//! How often the deterministic method keeps the truth: random sweeps along the walls of the built-in arena.
//!
//! `cargo run --release --example random_sweeps -- [TRIALS] [FIRST_SEED]`. Each trial presses the paper's whisker
//! against a random stretch of wall, sweeps along it with 5 % noise, and localizes without a prior. Trials in which the
//! whisker touches with its side are replaced: the method knows no such contact.

#[path = "../tests/data/random.rs"]
mod random;
#[path = "../tests/data/random_arena.rs"]
mod random_arena;

use random::Random;
use random_arena::{Draws, sweep_of};
use vibrissa::flow::pose::{Localization, Status};
use vibrissa::plane::{Pose2, wrap_angle};
use vibrissa::sim::{Part, Sweep};
use vibrissa::tasks::demo;
use vibrissa::world::Robot;
use vibrissa::{Method, Result, localize};

/// Short sweeps, whose walls may look like others.
const DRAWS: Draws = Draws {
    first_half: 1.0,
    lean: [0.5, 1.1],
    off: 0.004,
    pressed: [0.005, 0.02],
    press: [0.004, 0.02],
    length: [0.08, 0.16],
    fewest: 100,
};

/// Whether the whisker touched with its tip alone.
fn by_tip(sweep: &Sweep) -> bool {
    sweep.contacts.iter().all(|touch| touch.part == Part::Tip)
}

/// Whether a place's extent holds the truth.
fn holds(answer: &Localization, truth: Pose2) -> bool {
    answer.hypotheses.iter().any(|h| {
        let middle = 0.5 * (h.extent.theta.lo() + h.extent.theta.hi());
        h.extent.x.contains(truth.x)
            && h.extent.y.contains(truth.y)
            && h.extent.theta.contains(middle + wrap_angle(truth.theta - middle))
    })
}

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1).map_while(|a| a.parse::<u64>().ok());
    let (trials, first) = (arguments.next().unwrap_or(100), arguments.next().unwrap_or(1));
    let map = demo::arena()?;
    let (mut run, mut lost, mut localized, mut wrong) = (0, 0, Vec::new(), 0);
    let mut seed = first;
    while run < trials {
        seed += 1;
        let Some(sweep) = sweep_of(&map, &mut Random(seed.wrapping_mul(0x9e37_79b9)), seed, &DRAWS) else { continue };
        if !by_tip(&sweep) {
            continue;
        }
        run += 1;
        let answer =
            localize(&sweep.log, &map, &Robot::default(), &Method::Deterministic(Default::default()), &mut |_| {})?;
        let truth = sweep.truth[sweep.truth.len() - 1].map_from_robot;
        let kept = holds(&answer, truth);
        lost += u64::from(!kept);
        let error = answer.estimate.map_or(f64::INFINITY, |e| e.position().distance(truth.position()));
        if answer.status == Status::Localized {
            localized.push(1e3 * error);
            wrong += u64::from(error > 5e-3);
        }
        if !kept {
            println!(
                "seed {seed}: {}, best place {:.1} mm off, {:?}",
                answer.status,
                1e3 * error,
                answer.events.last()
            );
        }
    }
    localized.sort_by(f64::total_cmp);
    let at = |share: f64| localized.get((share * localized.len() as f64) as usize).copied().unwrap_or(f64::NAN);
    println!(
        "{run} sweeps: truth outside every place in {lost}; localized {}, of these wrong {wrong}",
        localized.len()
    );
    println!("error where localized: median {:.2} mm, 95 % {:.2} mm", at(0.5), at(0.95));
    Ok(())
}
