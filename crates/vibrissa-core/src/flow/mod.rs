//! The corridor, door by door, in the order in which data flows:
//! sensor log → moment → contact set → preimage → state set → pose.

pub mod contact_set;
pub mod moment;
pub mod pose;
pub mod preimage;
pub(crate) mod prior;
mod quadratic;
pub mod sensor_log;
pub mod state_set;
pub mod taps;
pub(crate) mod thinned;
pub mod trajectory;
mod words;

pub use thinned::one_in;
