//! The one error type of the library: it names the thing, the value, the allowed range and the next step.

use alloc::borrow::ToOwned;
use alloc::boxed::Box;
use alloc::format;
use alloc::string::{String, ToString};
use core::fmt;
#[cfg(feature = "std")]
use std::path::Path;

/// The result of anything in this crate that can fail.
pub type Result<T> = core::result::Result<T, Error>;

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
pub struct Error(Box<Parts>);

/// What an error says; boxed, so that results stay small where all goes well.
#[derive(Clone, Debug, PartialEq)]
struct Parts {
    kind: Kind,
    what: String,
    file: Option<String>,
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
        let what = what.into();
        Self(Box::new(Parts { kind, what, file: None, line: None, value: None, allowed: None, remedy: None }))
    }

    /// Adds the file at fault, unless one is already named.
    #[cfg(feature = "std")]
    #[must_use]
    pub fn in_file(mut self, file: impl AsRef<Path>) -> Self {
        self.0.file.get_or_insert_with(|| file.as_ref().display().to_string());
        self
    }

    /// Adds the line at fault, counted from 1, unless one is already named.
    #[must_use]
    pub fn at_line(mut self, line: usize) -> Self {
        self.0.line.get_or_insert(line);
        self
    }

    /// Names the thing at fault in front of the description, as `THING: WHAT`.
    #[must_use]
    pub fn about(mut self, thing: &str) -> Self {
        self.0.what = format!("{thing}: {}", self.0.what);
        self
    }

    /// Adds the offending value.
    #[must_use]
    pub fn value(mut self, value: impl fmt::Display) -> Self {
        self.0.value = Some(value.to_string());
        self
    }

    /// Adds the allowed range or the allowed words.
    #[must_use]
    pub fn allowed(mut self, allowed: impl Into<String>) -> Self {
        self.0.allowed = Some(allowed.into());
        self
    }

    /// Adds the next step for the reader.
    #[must_use]
    pub fn remedy(mut self, remedy: impl Into<String>) -> Self {
        self.0.remedy = Some(remedy.into());
        self
    }

    /// Adds the next step for the reader, unless one is already named: every error ends in one.
    #[must_use]
    pub fn or_remedy(mut self, remedy: &str) -> Self {
        self.0.remedy.get_or_insert_with(|| remedy.to_owned());
        self
    }

    /// The same error with a file at fault: what a call was told came from there.
    #[must_use]
    pub fn into_data(mut self) -> Self {
        self.0.kind = Kind::Data;
        self
    }

    /// Whether the log, the map or another file is at fault (exit code 1 of the command line).
    #[must_use]
    pub fn is_data(&self) -> bool {
        self.0.kind == Kind::Data
    }

    /// Whether the call is at fault (exit code 2 of the command line).
    #[must_use]
    pub fn is_usage(&self) -> bool {
        self.0.kind == Kind::Usage
    }

    /// The file at fault, where there is one.
    #[must_use]
    pub fn file(&self) -> Option<&str> {
        self.0.file.as_deref()
    }

    /// The line at fault, counted from 1, where there is one.
    #[must_use]
    pub fn line(&self) -> Option<usize> {
        self.0.line
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.0.file.as_deref().map(told), self.0.line) {
            (Some(file), Some(line)) => write!(f, "{file}:{line}: ")?,
            (Some(file), None) => write!(f, "{file}: ")?,
            (None, Some(line)) => write!(f, "line {line}: ")?,
            (None, None) => {}
        }
        write!(f, "{}", told(&self.0.what))?;
        if let Some(value) = &self.0.value {
            write!(f, ": {}", told(value))?;
        }
        if let Some(allowed) = &self.0.allowed {
            write!(f, " (allowed: {})", told(allowed))?;
        }
        if let Some(remedy) = &self.0.remedy {
            write!(f, "\n  help: {}", Told { text: remedy, most: LONGEST, lines: true })?;
        }
        Ok(())
    }
}

/// Longest part of a message (characters): a few lines of a terminal.
const LONGEST: usize = 600;

/// Whether a character steers what shows a text instead of being seen: control characters, marks that turn the direction of
/// writing round, line and paragraph separators, tags and other marks without a width.
#[must_use]
pub fn is_steering(character: char) -> bool {
    character.is_control()
        || matches!(character,
            '\u{61c}' | '\u{200b}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}'
            | '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}')
}

/// A text from a file as it may be shown: every [steering](is_steering) character escaped as `\u{1b}`, and what is beyond `most`
/// characters left out and counted.
///
/// ```
/// assert_eq!(vibrissa_beam::error::printable("a\u{202e}b\n", 10), "a\\u{202e}b\\n");
/// assert_eq!(vibrissa_beam::error::printable("abcdef", 2), "ab… (4 more characters)");
/// ```
#[must_use]
pub fn printable(text: &str, most: usize) -> String {
    Told { text, most, lines: false }.to_string()
}

/// A part of a message, which may quote a damaged file: cut where it would flood the terminal, and without the characters that
/// would steer it.
struct Told<'a> {
    text: &'a str,
    most: usize,
    /// Whether line ends and tabulators are kept.
    lines: bool,
}

fn told(text: &str) -> Told<'_> {
    Told { text, most: LONGEST, lines: false }
}

impl fmt::Display for Told<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for character in self.text.chars().take(self.most) {
            if is_steering(character) && !(self.lines && matches!(character, '\n' | '\t')) {
                match character {
                    '\n' | '\t' | '\r' => write!(f, "{}", character.escape_default())?,
                    _ => write!(f, "{}", character.escape_unicode())?,
                }
            } else {
                write!(f, "{character}")?;
            }
        }
        let left_out = self.text.chars().skip(self.most).count();
        if left_out > 0 { write!(f, "… ({left_out} more characters)") } else { Ok(()) }
    }
}

impl core::error::Error for Error {}

#[cfg(test)]
mod tests {
    use super::{Error, LONGEST};
    use alloc::format;
    use alloc::string::ToString;

    #[test]
    fn what_a_damaged_file_holds_neither_floods_nor_steers_the_terminal() {
        let error = Error::data("not a number").value("9".repeat(65_000)).remedy("x\u{1b}]0;title\u{7}\nend");
        let message = error.to_string();
        assert!(message.len() < 2 * LONGEST && message.contains("9… (64400 more characters)"), "{message}");
        assert!(!message.contains('\u{1b}') && message.contains("\\u{1b}]0;title\\u{7}\nend"), "{message}");
        let named = Error::data("x").in_file("a\u{1b}[2J\u{202e}gvs\n  help: rm -r /").value("b\nc\td").to_string();
        assert_eq!(named, "a\\u{1b}[2J\\u{202e}gvs\\n  help: rm -r /: x: b\\nc\\td");
        let whole = Error::data("größe").value("ü".repeat(LONGEST)).to_string();
        assert_eq!(whole, format!("größe: {}", "ü".repeat(LONGEST)));
    }
}
