//! What is known about the robot's place besides its touch.

/// Options of the methods that use it; each default lives in `vibrissa::config`.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "Options of the possibilistic and the probabilistic method")]
pub(crate) struct KnownArgs {
    /// Bound on the error of the log's absolute headings, in rad [default: 0.05]
    #[arg(long, value_name = "RAD")]
    pub(super) heading_error: Option<f64>,
    /// Where the robot is at the first row, in m and rad: least and largest x, y and heading, six numbers
    #[arg(long, value_name = "BOX", value_delimiter = ',', num_args = 6, allow_hyphen_values = true)]
    within: Option<Vec<f64>>,
}

impl KnownArgs {
    /// The region that holds the first pose: least and largest x, y (m) and heading (rad).
    pub(super) fn region(&self) -> Option<[[f64; 2]; 3]> {
        match *self.within.as_deref()? {
            [a, b, c, d, e, f] => Some([[a, b], [c, d], [e, f]]),
            _ => None,
        }
    }
}
