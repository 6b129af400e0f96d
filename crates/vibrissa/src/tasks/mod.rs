//! What people do with the corridor, one call each.

mod localize;

pub use localize::{LocalizeOptions, localize};
