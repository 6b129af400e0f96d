//! The one error type of the library: it names the thing, the value, the allowed range and the next step.

use std::fmt;
use std::path::{Path, PathBuf};

/// The result of anything in this crate that can fail.
pub type Result<T> = std::result::Result<T, Error>;

/// What is at fault, coarsely; see [`Error::is_data`] and [`Error::is_usage`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Data,
    Usage,
}

/// A fault in a file, a value or a call, told so that the reader knows what to do next.
///
/// The message reads `FILE:LINE: WHAT: VALUE (allowed: RANGE)`, followed by the remedy on a line of its own. Every part
/// but WHAT is optional.
#[derive(Clone, Debug, PartialEq)]
pub struct Error {
    kind: Kind,
    what: String,
    file: Option<PathBuf>,
    line: Option<usize>,
    value: Option<String>,
    allowed: Option<String>,
    remedy: Option<String>,
}

impl Error {
    /// An error in the user's data: a log, a map, a robot description.
    pub fn data(what: impl Into<String>) -> Self {
        Self::new(Kind::Data, what)
    }

    /// An error in the call itself: an option or an argument out of range.
    pub fn usage(what: impl Into<String>) -> Self {
        Self::new(Kind::Usage, what)
    }

    fn new(kind: Kind, what: impl Into<String>) -> Self {
        Self { kind, what: what.into(), file: None, line: None, value: None, allowed: None, remedy: None }
    }

    /// Adds the file at fault, unless one is already named.
    #[must_use]
    pub fn in_file(mut self, file: impl AsRef<Path>) -> Self {
        self.file.get_or_insert_with(|| file.as_ref().to_path_buf());
        self
    }

    /// Adds the line at fault, counted from 1, unless one is already named.
    #[must_use]
    pub fn at_line(mut self, line: usize) -> Self {
        self.line.get_or_insert(line);
        self
    }

    /// Adds the offending value.
    #[must_use]
    pub fn value(mut self, value: impl fmt::Display) -> Self {
        self.value = Some(value.to_string());
        self
    }

    /// Adds the allowed range or the allowed words.
    #[must_use]
    pub fn allowed(mut self, allowed: impl Into<String>) -> Self {
        self.allowed = Some(allowed.into());
        self
    }

    /// Adds the next step for the reader.
    #[must_use]
    pub fn remedy(mut self, remedy: impl Into<String>) -> Self {
        self.remedy = Some(remedy.into());
        self
    }

    /// Whether the log, the map or another file is at fault (exit code 1 of the command line).
    #[must_use]
    pub fn is_data(&self) -> bool {
        self.kind == Kind::Data
    }

    /// Whether the call is at fault (exit code 2 of the command line).
    #[must_use]
    pub fn is_usage(&self) -> bool {
        self.kind == Kind::Usage
    }

    /// The file at fault, where there is one.
    #[must_use]
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// The line at fault, counted from 1, where there is one.
    #[must_use]
    pub fn line(&self) -> Option<usize> {
        self.line
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.file, self.line) {
            (Some(file), Some(line)) => write!(f, "{}:{line}: ", file.display())?,
            (Some(file), None) => write!(f, "{}: ", file.display())?,
            (None, Some(line)) => write!(f, "line {line}: ")?,
            (None, None) => {}
        }
        f.write_str(&self.what)?;
        if let Some(value) = &self.value {
            write!(f, ": {value}")?;
        }
        if let Some(allowed) = &self.allowed {
            write!(f, " (allowed: {allowed})")?;
        }
        if let Some(remedy) = &self.remedy {
            write!(f, "\n  help: {remedy}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Error {}
