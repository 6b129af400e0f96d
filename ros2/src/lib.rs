//! A ROS 2 node that localizes a robot by its whiskers. It speaks DDS by itself: no ROS is needed to build or to run it.
//!
//! **messages → rows → estimator → messages**. Joining and estimating are those of `vibrissa_live`.
//!
//! | what | where |
//! | --- | --- |
//! | messages, field by field | [`messages`] |
//! | odometry and readings to rows | [`feed`] |
//! | rows to estimates; what is known | [`engine`] |
//! | estimates to messages | [`outputs`] |
//! | states of a managed node | [`lifecycle`] |
//! | parameters, and the files and arguments that say them | [`parameters`], [`parameters_file`] |
//! | maps that are messages | [`grid`] |
//! | messages as lines for `vibrissa live` | [`lines`] |
//! | topics, services, threads | [`node`] |

pub mod config;
pub mod engine;
pub mod feed;
pub mod grid;
pub mod lifecycle;
pub mod lines;
pub mod messages;
pub mod node;
pub mod outputs;
pub mod parameters;
pub mod parameters_file;
