//! What the readers of files share: opening within a budget, lines, suggestions.

use crate::{Error, Result};
use std::fs::{File, Metadata};
use std::io::{ErrorKind, Read};
use std::path::Path;

/// The text of a file of at most `most` bytes.
///
/// # Errors
///
/// A file that is missing, unreadable, not a file, too large or not UTF-8; `what` names it for people (`map`, `robot`).
pub fn read_text(path: &Path, what: &str, most: u64) -> Result<String> {
    text_of(read_bytes(path, what, most)?, path, what)
}

/// The text of bytes that are those of a file.
///
/// # Errors
///
/// Bytes that are not UTF-8; `what` names the file for people.
pub fn text_of(bytes: Vec<u8>, path: &Path, what: &str) -> Result<String> {
    let text = String::from_utf8(bytes).map_err(|e| {
        let line = line_at(&e.as_bytes()[..e.utf8_error().valid_up_to()], e.utf8_error().valid_up_to());
        Error::data(format!("the {what} file is not UTF-8 text")).in_file(path).at_line(line).remedy("save it as UTF-8")
    })?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

/// The bytes of a file of at most `most` bytes.
///
/// # Errors
///
/// A file that is missing, unreadable, not a file, or too large.
pub fn read_bytes(path: &Path, what: &str, most: u64) -> Result<Vec<u8>> {
    let (file, size) = open_sized(path, what)?;
    if size > most {
        return Err(too_large(path, what, format!("{size} bytes"), most));
    }
    let mut bytes = Vec::with_capacity(usize::try_from(size).unwrap_or_default());
    // What grows while it is read, and what has no size, is cut off one byte behind the budget.
    file.take(most + 1).read_to_end(&mut bytes).map_err(|e| cannot_open(path, what, &e))?;
    if bytes.len() as u64 > most {
        return Err(too_large(path, what, format!("more than {most} bytes"), most));
    }
    Ok(bytes)
}

/// A file opened to be read piece by piece: a file proper, or the standard input and other pipes that the caller has open.
///
/// # Errors
///
/// A file that is missing or unreadable; a device, a socket, a folder, a named pipe, which may never end or never begin.
pub fn open(path: &Path, what: &str) -> Result<File> {
    open_sized(path, what).map(|(file, _)| file)
}

fn open_sized(path: &Path, what: &str) -> Result<(File, u64)> {
    let kind = std::fs::metadata(path).map_err(|e| cannot_open(path, what, &e))?;
    if kind.is_dir() {
        return Err(cannot_open(path, what, &ErrorKind::IsADirectory.into()));
    }
    let is_streamed = is_pipe(&kind) && is_own(path);
    if !(kind.is_file() || is_streamed) {
        return Err(Error::data(format!("cannot read the {what} file"))
            .in_file(path)
            .value(format!("it is {}, not a file", kind_word(&kind)))
            .allowed("a file, /dev/stdin, or <(COMMAND) of a shell")
            .remedy("write what it holds to a file first"));
    }
    let file = File::open(path).map_err(|e| cannot_open(path, what, &e))?;
    Ok((file, if kind.is_file() { kind.len() } else { 0 }))
}

/// Whether a path names what this process has open: a pipe there has somebody at its other end.
fn is_own(path: &Path) -> bool {
    ["/dev/stdin", "/dev/fd", "/proc/self/fd"].iter().any(|own| path.starts_with(own))
}

#[cfg(unix)]
fn is_pipe(kind: &Metadata) -> bool {
    std::os::unix::fs::FileTypeExt::is_fifo(&kind.file_type())
}

#[cfg(not(unix))]
fn is_pipe(_: &Metadata) -> bool {
    false
}

#[cfg(unix)]
fn kind_word(kind: &Metadata) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    let kind = kind.file_type();
    if kind.is_fifo() {
        "a named pipe"
    } else if kind.is_socket() {
        "a socket"
    } else {
        "a device"
    }
}

#[cfg(not(unix))]
fn kind_word(_: &Metadata) -> &'static str {
    "a device"
}

fn too_large(path: &Path, what: &str, size: String, most: u64) -> Error {
    Error::data(format!("the {what} file is too large"))
        .in_file(path)
        .value(size)
        .allowed(format!("up to {most} bytes"))
        .remedy("is it this kind of file? Leave out what is not needed, or split it")
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

/// The error for what goes beyond a budget: `what` there is too much of, how much is allowed, and what to do.
#[must_use]
pub fn beyond(what: &str, value: impl core::fmt::Display, most: usize, remedy: &str) -> Error {
    Error::data(what).value(value).allowed(format!("up to {most}")).remedy(remedy)
}

/// The line, counted from 1, that holds the byte at `offset`.
#[must_use]
pub fn line_at(text: &[u8], offset: usize) -> usize {
    1 + text[..offset.min(text.len())].iter().filter(|&&b| b == b'\n').count()
}

/// The one of `known` that `word` most resembles, when it is near enough to be meant.
pub fn suggestion<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // What is much longer than any word was not mistyped; comparing it would take long.
    if word.len() > 64 {
        return None;
    }
    let lower = word.to_lowercase();
    known
        .into_iter()
        .filter(|k| k.len() <= 64)
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
        None => format!("known: {}", listed(known)),
    }
}

/// Most names that a message lists.
const LISTED: usize = 24;

/// A few of many names, for messages.
#[must_use]
pub fn listed<T: AsRef<str>>(names: &[T]) -> String {
    let shown = names.iter().take(LISTED).map(|name| short(name.as_ref())).collect::<Vec<_>>().join(", ");
    if names.len() > LISTED { format!("{shown} and {} more", names.len() - LISTED) } else { shown }
}

/// A number with its noun.
#[must_use]
pub fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

/// Longest name that a message shows as a whole (characters).
const SHORT: usize = 64;

/// A name, cut where it would flood a message.
#[must_use]
pub fn short(name: &str) -> std::borrow::Cow<'_, str> {
    match name.char_indices().nth(SHORT) {
        Some((at, _)) => format!("{}…", &name[..at]).into(),
        None => name.into(),
    }
}
