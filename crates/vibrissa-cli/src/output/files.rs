//! Result files that are whole or not there.

use super::picture::{self, Picture};
use std::borrow::Cow;
use std::fs::{self, File, TryLockError};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;
use vibrissa::{Error, Result};

/// The content of a result file, made when its turn comes: of a long log each takes as much memory as the log.
pub(crate) type Content<'a> = Box<dyn Fn() -> Cow<'a, [u8]> + 'a>;

/// A folder, and the formats that figures (`.svg`) are written in beside their own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Destination<'a> {
    pub(crate) folder: &'a Path,
    pub(crate) pictures: &'a [Picture],
}

impl<'a> From<&'a Path> for Destination<'a> {
    fn from(folder: &'a Path) -> Self {
        Self { folder, pictures: &[] }
    }
}

impl<'a> From<&'a PathBuf> for Destination<'a> {
    fn from(folder: &'a PathBuf) -> Self {
        folder.as_path().into()
    }
}

/// Writes `(name, text)` files; see [`write_each`].
pub(crate) fn write_all<'a>(to: impl Into<Destination<'a>>, files: &[(&str, String)]) -> Result<Vec<PathBuf>> {
    let files: Vec<(&str, &[u8])> = files.iter().map(|(name, text)| (*name, text.as_bytes())).collect();
    write_bytes(to, &files)
}

/// Writes `(name, bytes)` files; see [`write_each`].
pub(crate) fn write_bytes<'a>(to: impl Into<Destination<'a>>, files: &[(&str, &[u8])]) -> Result<Vec<PathBuf>> {
    let files: Vec<(&str, Content<'_>)> =
        files.iter().map(|&(name, bytes)| (name, Box::new(move || Cow::Borrowed(bytes)) as Content<'_>)).collect();
    write_each(to.into(), &files)
}

/// The pictures of figures: their names, and what they are made of.
fn pictures(files: &[(&str, Content<'_>)], formats: &[Picture]) -> Result<Vec<(String, Vec<u8>)>> {
    picture::check(formats)?;
    let mut made = Vec::new();
    for (name, content) in files.iter().filter(|_| !formats.is_empty()) {
        let Some(stem) = name.strip_suffix(".svg").filter(|_| *name != MAP) else { continue };
        let svg = content();
        for format in formats {
            let bytes = format.of(&String::from_utf8_lossy(&svg))?;
            made.push((format!("{stem}.{}", format.extension()), bytes));
        }
    }
    Ok(made)
}

/// A map that is a result, which is no figure.
const MAP: &str = "map.svg";

/// Writes `(name, content)` files into a folder, which is made if missing, and gives their paths; one content is in memory
/// at a time, and all pictures.
///
/// All are written under temporary names first and renamed at the end, so that earlier results stay whole when the disk
/// fills up or the program is stopped. Runs that share a folder rename one after the other.
pub(crate) fn write_each(to: Destination<'_>, files: &[(&str, Content<'_>)]) -> Result<Vec<PathBuf>> {
    let pictures = pictures(files, to.pictures)?;
    let folder = to.folder;
    // Boxed once more, since those of the pictures live shorter.
    let given = files.iter().map(|(name, content)| (*name, Box::new(move || content()) as Content<'_>));
    let drawn = pictures
        .iter()
        .map(|(name, bytes)| (name.as_str(), Box::new(move || Cow::Borrowed(bytes.as_slice())) as Content<'_>));
    let files: Vec<(&str, Content<'_>)> = given.chain(drawn).collect();
    fs::create_dir_all(folder).map_err(|error| fault("cannot make the folder", folder, &error))?;
    let staged: Vec<(PathBuf, PathBuf)> = files
        .iter()
        .map(|(name, _)| (folder.join(format!(".{name}.{}.part", std::process::id())), folder.join(name)))
        .collect();
    let result = stage_and_rename(&staged, &files);
    if result.is_err() {
        for (temporary, _) in &staged {
            // Those already renamed are no longer there under this name.
            let _ = fs::remove_file(temporary);
        }
    }
    result.map(|()| staged.into_iter().map(|(_, path)| path).collect())
}

fn stage_and_rename(staged: &[(PathBuf, PathBuf)], files: &[(&str, Content<'_>)]) -> Result<()> {
    for ((temporary, path), (_, content)) in staged.iter().zip(files) {
        write_one(temporary, &content()).map_err(|error| fault("cannot write", path, &error))?;
    }
    let _turn = staged.first().and_then(|(_, path)| take_turn(path.parent()?));
    for (temporary, path) in staged {
        fs::rename(temporary, path).map_err(|error| fault("cannot replace", path, &error))?;
    }
    Ok(())
}

/// Waits until no other run renames its results in this folder, so that they are not mixed; the turn ends with the value.
///
/// None where the system has no locks on folders, or where another run does not end its turn.
fn take_turn(folder: &Path) -> Option<File> {
    let handle = File::open(folder).ok()?;
    for _ in 0..LONGEST_WAIT {
        match handle.try_lock() {
            Ok(()) => return Some(handle),
            Err(TryLockError::WouldBlock) => std::thread::sleep(LOOK_AGAIN),
            Err(TryLockError::Error(_)) => return None,
        }
    }
    None
}

/// How often another run's turn is looked at,
const LONGEST_WAIT: usize = 500;
/// and the time between two looks: five seconds in all, where renaming takes a millisecond.
const LOOK_AGAIN: Duration = Duration::from_millis(10);

fn write_one(path: &Path, content: &[u8]) -> std::io::Result<()> {
    let mut file = File::create(path)?;
    file.write_all(content)?;
    file.sync_all()
}

fn fault(what: &str, path: &Path, error: &std::io::Error) -> Error {
    Error::data(format!("{what} ({error})"))
        .in_file(path)
        .remedy("free the disk or the folder, or choose another --out")
}

#[cfg(test)]
mod tests {
    use super::write_all;
    use std::fs;
    use std::path::{Path, PathBuf};

    fn fresh(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("vibrissa-files-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        folder
    }

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn files_replace_earlier_ones_and_leave_nothing_else() {
        let folder = fresh("replace").join("made/on/the/way");
        write_all(&folder, &[("a", "old".into()), ("b", "old".into())]).unwrap();
        write_all(&folder, &[("a", "new".into())]).unwrap();
        assert_eq!(fs::read_to_string(folder.join("a")).unwrap(), "new");
        assert_eq!(fs::read_to_string(folder.join("b")).unwrap(), "old");
        assert_eq!(names(&folder), ["a", "b"]);
    }

    #[test]
    fn a_failed_write_leaves_earlier_results_and_no_litter() {
        let folder = fresh("fail");
        write_all(&folder, &[("a", "old".into())]).unwrap();
        // The second name lies in a folder that is not there, so staging it fails after the first is staged.
        let error = write_all(&folder, &[("a", "new".into()), ("missing/b", "new".into())]).unwrap_err();
        assert!(error.is_data() && error.to_string().contains("help:"), "{error}");
        assert_eq!(fs::read_to_string(folder.join("a")).unwrap(), "old");
        assert_eq!(names(&folder), ["a"]);
    }

    #[test]
    fn a_file_in_the_folders_place_is_named() {
        let folder = fresh("file");
        fs::write(&folder, "in the way").unwrap();
        let error = write_all(&folder, &[("a", String::new())]).unwrap_err();
        assert_eq!(error.file(), folder.to_str());
        fs::remove_file(&folder).unwrap();
    }
}
