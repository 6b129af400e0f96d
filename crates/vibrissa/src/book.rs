//! The Rust examples of the book, compiled and run with the documentation tests.

#[doc = include_str!("../../../docs/tutorial/1-sensor-log.md")]
mod sensor_log {}
#[doc = include_str!("../../../docs/tutorial/2-moment.md")]
mod moment {}
#[doc = include_str!("../../../docs/tutorial/3-contact-set.md")]
mod contact_set {}
#[doc = include_str!("../../../docs/tutorial/4-preimage.md")]
mod preimage {}
#[doc = include_str!("../../../docs/tutorial/5-state-set.md")]
mod state_set {}
#[doc = include_str!("../../../docs/tutorial/6-pose.md")]
mod pose {}
#[doc = include_str!("../../../docs/how-to/row-by-row.md")]
mod row_by_row {}
