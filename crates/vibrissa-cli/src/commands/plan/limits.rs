//! What the robot can do.

use crate::quantity::{of_option as quantity, option};
use clap::ValueEnum;
use vibrissa::Result;
use vibrissa::io::Dimension;
use vibrissa::tasks::plan::{Criterion, PlanOptions};

/// What the robot can do, and how long may be thought about it.
#[derive(Clone, Debug, clap::Args)]
pub(in crate::commands) struct LimitArgs {
    /// The longest motion (m)
    #[arg(long, value_name = "LENGTH", default_value = "240 mm", help_heading = "What the robot can do")]
    longest: String,
    /// The radius of the robot around its origin that must stay clear of all boundaries (m)
    #[arg(long, value_name = "LENGTH", default_value = "10 mm", help_heading = "What the robot can do")]
    footprint: String,
    /// The robot goes ahead, back and along arcs, not sideways
    #[arg(long, help_heading = "What the robot can do")]
    ahead_only: bool,
    /// The robot does not turn on the spot
    #[arg(long, help_heading = "What the robot can do")]
    no_turns: bool,
    /// The largest moment that a whisker may feel (N m) [default: 2 EI / L]
    #[arg(long, value_name = "MOMENT", allow_hyphen_values = true, help_heading = "What the robot can do")]
    largest_moment: Option<String>,
    /// What motions are judged by
    #[arg(long, value_enum, default_value_t, help_heading = "How long may be thought")]
    criterion: Word,
    /// Readings of the forward model that may be taken: the plan is the best of these, whatever the machine
    #[arg(long, value_name = "N", default_value_t = PlanOptions::default().budget, help_heading = "How long may be thought")]
    budget: usize,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Word {
    /// The information that is expected for the way
    #[default]
    Expected,
    /// The extent of what is left at worst
    Worst,
}

impl LimitArgs {
    /// The options, checked.
    pub(in crate::commands) fn options(&self) -> Result<PlanOptions> {
        let options = PlanOptions {
            longest: quantity("--longest", &self.longest, Dimension::Length)?,
            turns: !self.no_turns,
            sideways: !self.ahead_only,
            footprint: quantity("--footprint", &self.footprint, Dimension::Length)?,
            largest_moment: option("--largest-moment", Dimension::Moment, self.largest_moment.as_deref())?,
            criterion: match self.criterion {
                Word::Expected => Criterion::Expected,
                Word::Worst => Criterion::Worst,
            },
            budget: self.budget,
            ..PlanOptions::default()
        };
        options.check()?;
        Ok(options)
    }
}
