//! vibrissa: where a robot is, by touch.

pub mod beam;
pub mod config;
pub mod error;
pub mod flow;
pub mod plane;
pub mod sets;
pub mod world;

pub use error::{Error, Result};
