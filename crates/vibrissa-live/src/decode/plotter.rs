//! One value a line, `>NAME: VALUE`, as serial plotters read; the values of a round are one frame.

use super::{Columns, Decoded};
use crate::{Error, Result};
use vibrissa_io::log::foreign::number;

/// Puts the values of a round together.
#[derive(Clone, Debug)]
pub(super) struct Plotter {
    /// The names as they are printed.
    names: Vec<String>,
    pub(super) columns: Columns,
    values: Vec<Option<f64>>,
}

impl Plotter {
    /// A plotter of columns `PRINTED:column`, such as `X:ax`; a name alone is printed as the column is called.
    pub(super) fn new(columns: &[String], whisker: &str) -> Result<Self> {
        if columns.is_empty() {
            return Err(Error::data("the format plotter needs to know what its names mean")
                .remedy("add columns = [\"X:ax\", \"Y:ay\"]: the printed name, then what it is"));
        }
        let pairs = columns.iter().map(|entry| entry.split_once(':').unwrap_or((entry, entry)));
        let (names, meanings): (Vec<String>, Vec<String>) =
            pairs.map(|(name, column)| (name.trim().to_owned(), column.trim().to_owned())).unzip();
        Ok(Self { values: vec![None; names.len()], names, columns: Columns::new(&meanings, whisker)? })
    }

    pub(super) fn line(&mut self, text: &str) -> Decoded {
        let named = text.trim_start_matches('>').split_once(':');
        let told = named.and_then(|(name, value)| {
            let index = self.names.iter().position(|known| known == name.trim())?;
            Some((index, number(value)?))
        });
        let Some((index, value)) = told else {
            // Other names are plotted, too; a line that is none breaks the round.
            if named.is_some_and(|(_, value)| number(value).is_some()) {
                return Decoded::Nothing;
            }
            self.values.fill(None);
            return Decoded::Lost;
        };
        let broken = self.values[index].is_some();
        if broken {
            // A line of the round before is missing.
            self.values.fill(None);
        }
        self.values[index] = Some(value);
        match self.values.iter().copied().collect::<Option<Vec<f64>>>() {
            Some(values) => {
                self.values.fill(None);
                Decoded::Frame(self.columns.frame(&values))
            }
            None if broken => Decoded::Lost,
            None => Decoded::Nothing,
        }
    }
}
