//! What people do with whiskers and logs, one call each.

pub mod batch;
pub mod calibrate;
pub mod contact;
pub mod demo;
mod doubts;
mod drawing;
pub mod explore;
pub mod join;
mod localize;
pub mod mapping;
pub mod plan;
pub mod profile;
mod remedies;
mod second_opinion;
pub mod sensor_design;
pub mod temporal_filter;

pub use doubts::doubts;
pub use drawing::outlines;
pub use localize::{
    RowObserver, StatesObserver, localize, localize_observed, localize_until, localize_watched, localize_while,
};
pub use remedies::{advise, remedies};
