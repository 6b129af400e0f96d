//! The outline of what a whisker swept along.

mod band;
mod tip_trace;

pub use tip_trace::{TraceNode, TraceOptions, TracePoint, tip_traces};
