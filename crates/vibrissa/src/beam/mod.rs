//! Whisker mechanics.

mod whisker;

pub use whisker::Whisker;
