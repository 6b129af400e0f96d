//! The corridor, door by door, in the order in which data flows:
//! sensor log → moment → contact set → preimage → state set → pose.

pub mod pose;
pub mod sensor_log;
pub mod trajectory;
mod words;
