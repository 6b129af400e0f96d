//! Options as shells offer them: each with a name, the words of its help and its field, from one table for each method.

use crate::{Error, Result};

/// Least and largest x (m), y (m) and heading (rad) of the robot at the first row, map frame.
pub type Region = [[f64; 2]; 3];

/// One option of a method: what shells call it and say about it, and where its value is.
pub struct Setting<'a> {
    /// Its name; shells with dashes in their options put them for the underscores.
    pub name: &'static str,
    /// What its value is called in help: `M`, `RAD`, `N`, …
    pub value_name: &'static str,
    /// What it does, in a phrase with its unit, without the default.
    pub help: &'static str,
    /// Its value.
    pub field: Slot<'a>,
}

/// The value of an option in its place.
pub enum Slot<'a> {
    /// A number in the unit that the help names.
    Number(&'a mut f64),
    /// A number that may be left to the method, and what the method then takes.
    OptionalNumber(&'a mut Option<f64>, &'static str),
    /// A count.
    Count(&'a mut usize),
    /// One of a few words.
    Choice(&'a mut dyn Choice),
    /// A region that may be unknown.
    Region(&'a mut Option<Region>),
}

/// A value that is one of a few words.
pub trait Choice {
    /// Every word with its meaning, in the order in which help lists them.
    fn words(&self) -> &'static [(&'static str, &'static str)];

    /// The word of the value.
    fn word(&self) -> &'static str;

    /// Takes the value of a word; whether there is one.
    fn take(&mut self, word: &str) -> bool;
}

/// A value given to an option.
#[derive(Clone, Debug, PartialEq)]
pub enum SettingValue {
    /// A number, in the unit of the option.
    Number(f64),
    /// A count.
    Count(usize),
    /// A word.
    Choice(String),
    /// A region.
    Region(Region),
}

impl Setting<'_> {
    /// The value as help and documents show it, numbers rounded to four decimals; none where nothing is taken.
    #[must_use]
    pub fn shown(&self) -> Option<String> {
        match &self.field {
            Slot::Number(value) => Some(rounded(**value)),
            Slot::OptionalNumber(Some(value), _) => Some(rounded(*value)),
            Slot::OptionalNumber(None, words) => Some((*words).to_owned()),
            Slot::Count(value) => Some(value.to_string()),
            Slot::Choice(value) => Some(value.word().to_owned()),
            Slot::Region(_) => None,
        }
    }

    /// Takes a value; the range is checked by the method's `check`.
    ///
    /// # Errors
    ///
    /// Usage: a value of another kind, or a word that there is not.
    pub fn take(&mut self, value: SettingValue) -> Result<()> {
        let allowed = match (&mut self.field, value) {
            (Slot::Number(at), SettingValue::Number(given)) => return done(*at, given),
            (Slot::OptionalNumber(at, _), SettingValue::Number(given)) => return done(*at, Some(given)),
            (Slot::Count(at), SettingValue::Count(given)) => return done(*at, given),
            (Slot::Region(at), SettingValue::Region(given)) => return done(*at, Some(given)),
            (Slot::Choice(at), SettingValue::Choice(given)) => {
                if at.take(&given) {
                    return Ok(());
                }
                let words: Vec<&str> = at.words().iter().map(|(word, _)| *word).collect();
                return Err(Error::usage(self.name).value(given).allowed(words.join(", ")));
            }
            (Slot::Number(_) | Slot::OptionalNumber(..), _) => "a number",
            (Slot::Count(_), _) => "a whole number",
            (Slot::Region(_), _) => "six numbers",
            (Slot::Choice(_), _) => "a word",
        };
        Err(Error::usage(format!("the option {} is of another kind", self.name)).allowed(allowed))
    }
}

fn done<T>(at: &mut T, given: T) -> Result<()> {
    *at = given;
    Ok(())
}

/// With four decimals at most.
fn rounded(value: f64) -> String {
    format!("{}", (value * 1e4).round() / 1e4)
}
