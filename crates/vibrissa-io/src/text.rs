//! What the readers of text files share: opening, lines, suggestions.

use crate::{Error, Result};
use std::io::ErrorKind;
use std::path::Path;

/// The text of a file.
///
/// # Errors
///
/// A file that is missing, unreadable or not UTF-8; `what` names it for people (`map`, `robot`).
pub fn read_text(path: &Path, what: &str) -> Result<String> {
    let bytes = std::fs::read(path).map_err(|e| cannot_open(path, what, &e))?;
    let text = String::from_utf8(bytes).map_err(|e| {
        let line = line_at(&e.as_bytes()[..e.utf8_error().valid_up_to()], e.utf8_error().valid_up_to());
        Error::data(format!("the {what} file is not UTF-8 text")).in_file(path).at_line(line).remedy("save it as UTF-8")
    })?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

/// The error for a file that cannot be opened.
#[must_use]
pub fn cannot_open(path: &Path, what: &str, reason: &std::io::Error) -> Error {
    let remedy = match reason.kind() {
        ErrorKind::NotFound => match path.parent().filter(|p| !p.as_os_str().is_empty() && !p.exists()) {
            Some(folder) => format!("the folder {} does not exist; check the path", folder.display()),
            None => "check the spelling; relative paths start at the current folder".to_owned(),
        },
        ErrorKind::IsADirectory => format!("give a {what} file, not a folder"),
        ErrorKind::PermissionDenied => "check the file's permissions".to_owned(),
        _ => return Error::data(format!("cannot read the {what} file")).in_file(path).value(reason),
    };
    let why = match reason.kind() {
        ErrorKind::NotFound => "no such file",
        ErrorKind::IsADirectory => "it is a folder",
        _ => "permission denied",
    };
    Error::data(format!("cannot read the {what} file")).in_file(path).value(why).remedy(remedy)
}

/// The line, counted from 1, that holds the byte at `offset`.
#[must_use]
pub fn line_at(text: &[u8], offset: usize) -> usize {
    1 + text[..offset.min(text.len())].iter().filter(|&&b| b == b'\n').count()
}

/// The one of `known` that `word` most resembles, when it is near enough to be meant.
pub fn suggestion<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = word.to_lowercase();
    known
        .into_iter()
        .map(|k| (strsim::damerau_levenshtein(&lower, &k.to_lowercase()), k))
        .filter(|(distance, k)| *distance <= 1 + k.len() / 4)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, k)| k)
}

/// A `did you mean` sentence, or the list of what is known.
#[must_use]
pub fn did_you_mean(word: &str, known: &[&str]) -> String {
    match suggestion(word, known.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("known: {}", known.join(", ")),
    }
}
