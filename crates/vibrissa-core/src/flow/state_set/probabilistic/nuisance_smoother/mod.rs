//! Multi-hypothesis smoother over pose and nuisance parameters \[reid1979algorithm, dellaert2017factor\], with correlated noise: modes of
//! the posterior, each a least-squares fit of all rows.
//!
//! The unknowns are the robot's pose and the nuisance parameters that the robot declares: errors of odometry, mounts, lengths, gains,
//! zeros, delay and map. Errors of the readings may stay alike for a while. Modes come from a grid over all contacts, are refitted
//! as the window grows, and are weighed by importance sampling at the end.

mod admission;
mod bank;
mod contact_episodes;
mod corrected_path;
mod correlated_noise;
mod grid_search;
mod importance_sampling;
mod log_window;
mod measurement;
mod normal_equations;
mod optimisation;
mod places;
mod sensor;
mod shared_runs;
mod smoother;
mod unknowns;
mod unobservable;

pub use places::Fit;
pub use smoother::NuisanceSmoother;
