//! Sets: intervals and boxes of states. The empty set is a value.

mod interval;
mod state_box;

pub use interval::Interval;
pub use state_box::StateBox;
