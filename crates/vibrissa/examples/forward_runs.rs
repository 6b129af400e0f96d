//! How much of what a whisker feels the probabilistic method's forward model knows: random sweeps on random maps.
//!
//! `cargo run --release --example forward_runs -- [TRIALS] [FIRST_SEED]` follows the true path of the sweeps of
//! `calibration_runs` and compares with the simulator's exact moments, which know tip, side, both at once and snaps. A row
//! is odd where the two differ by more than a fifth of the declared noise. For each sweep with odd rows it prints how many
//! and what the simulator says happened.

#[path = "../tests/data/random.rs"]
mod random;
#[path = "../tests/data/random_arena.rs"]
mod random_arena;

use random::Random;
use random_arena::{arena, sweep};
use vibrissa::Result;
use vibrissa::beam::TipModel;
use vibrissa::flow::state_set::probabilistic::predicted_moments;
use vibrissa::plane::Pose2;
use vibrissa::world::Robot;

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1).map_while(|a| a.parse::<u64>().ok());
    let (trials, first) = (arguments.next().unwrap_or(200), arguments.next().unwrap_or(1));
    let whisker = &Robot::default().whiskers[0];
    let (mut run, mut rows, mut odd, mut with) = (0, 0, 0, 0);
    let mut seed = first;
    while run < trials {
        seed += 1;
        let mut draw = Random(seed.wrapping_mul(0x9e37_79b9));
        let map = arena(&mut draw)?;
        let Some(sweep) = sweep(&map, &mut draw, seed) else { continue };
        run += 1;
        let path: Vec<Pose2> =
            sweep.truth.iter().map(|p| p.map_from_robot.compose(whisker.robot_from_whisker)).collect();
        let ours = predicted_moments(&map, &TipModel::new(&whisker.beam)?, &path);
        let far = |(row, exact): (usize, &Vec<f64>)| {
            let bound = whisker.noise.moment_relative * exact[0].abs() + whisker.noise.moment_absolute;
            ((ours[row].moment - exact[0]).abs() > 0.2 * bound).then_some(row)
        };
        let these: Vec<usize> = sweep.exact_moments.iter().enumerate().filter_map(far).collect();
        rows += sweep.contacts.len();
        odd += these.len();
        if let (Some(from), Some(to)) = (these.first(), these.last()) {
            with += 1;
            let time = |row: usize| sweep.truth[row].t;
            let words: Vec<String> = sweep.events.iter().map(|e| format!("{:.3} {}", e.t, e.kind)).collect();
            println!(
                "seed {seed}: {} of {} odd, {:.3} to {:.3} s; {}",
                these.len(),
                ours.len(),
                time(*from),
                time(*to),
                words.join(", ")
            );
        }
    }
    println!("{run} sweeps: {odd} odd rows of {rows} with contact, in {with} sweeps");
    Ok(())
}
