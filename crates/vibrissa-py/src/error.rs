//! Our errors as Python exceptions with the same texts.

use pyo3::prelude::*;
use pyo3::types::PyAnyMethods;

/// Turns our results into Python's.
pub(crate) trait OrRaise<T> {
    /// The value, or the exception that stands for the error.
    fn or_raise(self, py: Python<'_>) -> PyResult<T>;
}

impl<T> OrRaise<T> for vibrissa::Result<T> {
    fn or_raise(self, py: Python<'_>) -> PyResult<T> {
        self.map_err(|error| exception(py, &error, error.to_string()))
    }
}

/// What stands in the text of an error where a file is missing.
const MISSING: &str = ": no such file";

/// `vibrissa.DataError` or `vibrissa.UsageError` with this text, and the file and line of `error`.
pub(crate) fn exception(py: Python<'_>, error: &vibrissa::Error, text: String) -> PyErr {
    let name = match error.is_usage() {
        true => "UsageError",
        false if text.contains(MISSING) => "MissingFileError",
        false => "DataError",
    };
    let file = error.file().map(str::to_owned);
    let value =
        py.import("vibrissa._errors").and_then(|module| module.getattr(name)?.call1((text, file, error.line())));
    value.map_or_else(|failure| failure, PyErr::from_value)
}

/// Says what looks wrong but could be read, as `vibrissa.DataWarning`.
pub(crate) fn warn(py: Python<'_>, texts: &[String]) -> PyResult<()> {
    if texts.is_empty() {
        return Ok(());
    }
    let category = py.import("vibrissa._errors")?.getattr("DataWarning")?;
    let warn = py.import("warnings")?.getattr("warn")?;
    for text in texts {
        warn.call1((text, &category, 2))?;
    }
    Ok(())
}
