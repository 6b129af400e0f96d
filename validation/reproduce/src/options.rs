//! How the paper is made anew.

use vibrissa::Result;
use vibrissa::config::within;

/// How the paper's figures and tables are made anew.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReproduceOptions {
    /// Draws of the noise for each sweep of the localization table: enough for a mean and a spread, in a minute.
    pub seeds: usize,
    /// How many of the five sweeps are run.
    pub sweeps: usize,
    /// Trials for each distance of the contact table: the worst of a thousand in all.
    pub trials: usize,
    /// The sections by key; all when empty.
    pub only: Vec<String>,
    /// Threads; as many as the machine has processors when none. The answer does not depend on it.
    pub threads: Option<usize>,
}

impl Default for ReproduceOptions {
    fn default() -> Self {
        Self { seeds: 5, sweeps: 5, trials: 200, only: Vec::new(), threads: None }
    }
}

impl ReproduceOptions {
    /// Checks that every knob is in its range.
    ///
    /// # Errors
    ///
    /// Usage: names the knob, its value and the allowed range.
    pub fn check(&self) -> Result<()> {
        within("seeds", self.seeds as f64, 1.0, 100.0, "draws")?;
        within("sweeps", self.sweeps as f64, 1.0, 5.0, "sweeps")?;
        within("trials", self.trials as f64, 1.0, 10_000.0, "trials")?;
        within("threads", self.threads.unwrap_or(1) as f64, 1.0, 1024.0, "threads")
    }
}
