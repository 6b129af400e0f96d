//! The outline of what whiskers swept along: the union of contact points over sweeps \[routray, section "Experiment:
//! Obstacle Profile Estimation"\], and how it compares with a known shape.
//!
//! | file | what it knows |
//! | --- | --- |
//! | `run` | contact points in a row, good enough to be drawn |
//! | `chain` | a line through several runs |
//! | `near_points` | points near a place |
//! | `outline` | the line with its uncertainty, from all sweeps |
//! | `assembly` | a map with bands of felt lines: corners, rings, unknown stretches |
//! | `joint` | what two ends have to do with each other: one wall, a corner, an unknown stretch |
//! | `alignment` | shape error and absolute error against a map |
//! | `shape` | rounded polygons and circles fitted to points |

mod alignment;
mod assembly;
mod chain;
mod joint;
mod near_points;
mod outline;
mod run;
mod shape;

pub use alignment::{Alignment, Misfit, compare};
pub use assembly::{AssembledMap, FeltLine, FeltPoint, FoundCorner, assemble};
pub(crate) use near_points::NearPoints;
pub(crate) use outline::merged;
pub use outline::{Outline, OutlinePoint, Profile, profile, profile_until};
pub use shape::{FittedShape, FreeSize, RoundedPolygon, fit_shape};
