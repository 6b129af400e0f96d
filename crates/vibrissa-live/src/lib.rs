//! Localization while the robot drives: from the wire to the pose, and nothing lost when the power goes.
//!
//! | step | from | to | where |
//! | --- | --- | --- | --- |
//! | wire | serial ports, sockets, pipes, recordings | bytes and when they arrived | [`source`] |
//! | frames | bytes, torn anywhere | numbers of one line | [`decode`] |
//! | clock | stamps, counts, arrivals | host times | [`clock`], [`timing`] |
//! | join | frames of several streams | rows with odometry | [`join`] |
//! | calibrate | flux, counts | moments | `vibrissa_io::Calibrator` |
//! | estimator | rows | places and a verdict | `vibrissa_core::Localizer` |
//! | carry | estimates of earlier rows, odometry | the pose now | [`carry`] |
//! | outputs | estimates | JSON lines, a recording, words, what viewers draw | [`output`], [`record`], `scene`, `view` |

pub mod carry;
pub mod clock;
pub mod config;
pub mod counts;
pub mod decode;
mod doubts;
pub mod estimate;
pub mod head;
pub mod join;
pub mod journal;
pub mod latency;
pub mod output;
pub mod pipeline;
pub mod record;
pub mod replay;
#[cfg(unix)]
pub mod robot;
pub mod run;
#[cfg(feature = "view")]
pub mod scene;
pub mod setup;
pub mod source;
pub mod timing;
#[cfg(feature = "view")]
pub mod view;

use vibrissa_core::{Error, Result};
