//! The methods to choose from: the only list of them. Another estimator is a variant here and its lines below.

use super::Estimator;
use crate::beam::Whisker;
use crate::config::{DeterministicOptions, PossibilisticOptions, ProbabilisticOptions, Setting, SettingValue};
use crate::flow::sensor_log::Channel;
use crate::world::{Map, Robot};
use crate::{Error, Result};
use core::fmt;

/// A method of localization with its options.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// The paper's intersection of discretised preimages.
    Deterministic(DeterministicOptions),
    /// Guaranteed bounds on the state: what is outside is ruled out.
    Possibilistic(PossibilisticOptions),
    /// Least squares over all readings at every place that explains them, with calibrated weights.
    Probabilistic(ProbabilisticOptions),
}

/// What a method's options say of the method; each stands beside its estimator.
pub(super) trait MethodOptions {
    /// The word that files, messages and shells use.
    fn name(&self) -> &'static str;

    /// What the method gives, in a phrase for help.
    fn summary(&self) -> &'static str;

    /// The options that shells offer.
    fn settings(&mut self) -> Vec<Setting<'_>>;

    /// Refuses options out of range.
    fn check(&self) -> Result<()>;

    /// Refuses a whisker that the method does not cover.
    fn takes(&self, whisker: &Whisker) -> Result<()>;

    /// The estimator with these options.
    fn estimator<'a>(&self, map: &'a Map, robot: &'a Robot, channels: &[Channel]) -> Result<Box<dyn Estimator + 'a>>;
}

impl Default for Method {
    fn default() -> Self {
        Self::Probabilistic(ProbabilisticOptions::default())
    }
}

impl Method {
    /// Every method with its default options.
    #[must_use]
    pub fn all() -> [Self; 3] {
        [
            Self::Deterministic(DeterministicOptions::default()),
            Self::Possibilistic(PossibilisticOptions::default()),
            Self::Probabilistic(ProbabilisticOptions::default()),
        ]
    }

    fn options(&self) -> &dyn MethodOptions {
        match self {
            Self::Deterministic(options) => options,
            Self::Possibilistic(options) => options,
            Self::Probabilistic(options) => options,
        }
    }

    fn options_mut(&mut self) -> &mut dyn MethodOptions {
        match self {
            Self::Deterministic(options) => options,
            Self::Possibilistic(options) => options,
            Self::Probabilistic(options) => options,
        }
    }
}

impl Method {
    /// The method of this name, with its default options.
    ///
    /// # Errors
    ///
    /// Usage: there is none; the message lists those that there are.
    pub fn named(name: &str) -> Result<Self> {
        let words = Self::all().map(|method| method.name());
        let found = Self::all().into_iter().find(|method| method.name() == name);
        found.ok_or_else(|| Error::usage("method").value(name).allowed(words.join(", ")))
    }

    /// The word that files, messages and shells use.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.options().name()
    }

    /// What the method gives, in a phrase for help.
    #[must_use]
    pub fn summary(&self) -> &'static str {
        self.options().summary()
    }

    /// The options that shells offer, with their values.
    pub fn settings(&mut self) -> Vec<Setting<'_>> {
        self.options_mut().settings()
    }

    /// Sets an option by its name; ranges are checked by [`Method::check`].
    ///
    /// # Errors
    ///
    /// Usage: the method has no such option, or the value is of another kind.
    pub fn set(&mut self, option: &str, value: SettingValue) -> Result<()> {
        let name = self.name();
        if let Some(mut setting) = self.settings().into_iter().find(|setting| setting.name == option) {
            return setting.take(value);
        }
        let remedy = match Self::having(option).as_slice() {
            [] => "leave it out".to_owned(),
            names => format!("leave it out, or choose method {}", names.join(" or ")),
        };
        Err(Error::usage(format!("the option {option} is none of the method {name}")).remedy(remedy))
    }

    /// Whether the method has an option of this name.
    #[must_use]
    pub fn has(mut self, option: &str) -> bool {
        self.settings().iter().any(|setting| setting.name == option)
    }

    /// The names of the methods that have an option of this name.
    #[must_use]
    pub fn having(option: &str) -> Vec<&'static str> {
        Self::all().iter().filter(|method| method.has(option)).map(Self::name).collect()
    }

    /// Checks that every option is in its range.
    ///
    /// # Errors
    ///
    /// Usage: names the option, its value and the allowed range.
    pub fn check(&self) -> Result<()> {
        self.options().check()
    }

    /// Checks that the method covers a whisker.
    ///
    /// # Errors
    ///
    /// Data: names what the whisker has that the method does not cover, and the next step.
    pub fn takes(&self, whisker: &Whisker) -> Result<()> {
        self.options().takes(whisker)
    }

    /// A fresh estimator for logs with these channels, if the method covers the robot's whiskers.
    pub(super) fn estimator<'a>(
        &self,
        map: &'a Map,
        robot: &'a Robot,
        channels: &[Channel],
    ) -> Result<Box<dyn Estimator + 'a>> {
        for whisker in &robot.whiskers {
            self.takes(&whisker.beam).map_err(|error| error.about(&format!("whisker \"{}\"", whisker.name)))?;
        }
        self.options().estimator(map, robot, channels)
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
