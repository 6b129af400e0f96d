//! vibrissa: where a robot is, by touch.

pub mod beam;
pub mod config;
pub mod error;
pub mod figure;
pub mod flow;
pub mod localizer;
pub mod plane;
pub mod sets;
pub mod tasks;
pub mod world;

pub use error::{Error, Result};
pub use localizer::Localizer;
pub use tasks::{LocalizeOptions, localize};
