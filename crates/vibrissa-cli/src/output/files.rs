//! Result files that are whole or not there.

use super::picture::{self, Picture};
use super::{plain, warn};
use crate::interrupt::replacing;
use std::borrow::Cow;
use std::collections::hash_map::RandomState;
use std::fs::{self, File, TryLockError};
use std::hash::{BuildHasher, Hasher};
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
    if made.is_empty() && !formats.is_empty() {
        warn("--pictures: there is no figure among these results");
    }
    Ok(made)
}

/// A map that is a result, which is no figure.
const MAP: &str = "map.svg";

/// Writes `(name, content)` files into a folder, which is made if missing, and gives their paths; one content is in memory
/// at a time, and all pictures.
///
/// All are written under temporary names first and renamed at the end, so that earlier results stay whole when the disk
/// fills up or the program is stopped. Runs that share a folder rename one after the other. Temporary files of runs that were
/// ended before they could remove them are removed.
pub(crate) fn write_each(to: Destination<'_>, files: &[(&str, Content<'_>)]) -> Result<Vec<PathBuf>> {
    let pictures = pictures(files, to.pictures)?;
    let folder = to.folder;
    // Boxed once more, since those of the pictures live shorter.
    #[allow(clippy::redundant_closure, reason = "the function itself would have to live as long as the pictures")]
    let given = files.iter().map(|(name, content)| (*name, Box::new(move || content()) as Content<'_>));
    let drawn = pictures
        .iter()
        .map(|(name, bytes)| (name.as_str(), Box::new(move || Cow::Borrowed(bytes.as_slice())) as Content<'_>));
    let files: Vec<(&str, Content<'_>)> = given.chain(drawn).collect();
    fs::create_dir_all(folder).map_err(|error| fault("cannot make the folder", folder, &error))?;
    let paths: Vec<PathBuf> = files.iter().map(|(name, _)| folder.join(name)).collect();
    no_folders(&paths)?;
    let mut staged = Vec::new();
    let result = stage_and_rename(folder, &paths, &files, &mut staged);
    if result.is_err() {
        for part in &staged {
            // Those already renamed are no longer there under this name.
            let _ = fs::remove_file(&part.temporary);
        }
    }
    result.map(|()| paths)
}

/// A file under its temporary name, locked as long as the run lives that writes it.
struct Part {
    temporary: PathBuf,
    file: File,
}

impl Part {
    /// Makes the file anew: a file or a link that stands under the name is never written to.
    fn create(path: &Path) -> std::io::Result<Self> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let temporary = path.with_file_name(format!(".{name}.{:016x}.part", random()));
        let file = File::options().write(true).create_new(true).open(&temporary)?;
        // Where the system has no locks, parts of other runs are not removed either.
        let _ = file.try_lock();
        Ok(Self { temporary, file })
    }

    fn write(&mut self, content: &[u8]) -> std::io::Result<()> {
        self.file.write_all(content)?;
        self.file.sync_all()
    }
}

/// A number that nobody can foretell.
fn random() -> u64 {
    RandomState::new().build_hasher().finish()
}

fn stage_and_rename(
    folder: &Path,
    paths: &[PathBuf],
    files: &[(&str, Content<'_>)],
    staged: &mut Vec<Part>,
) -> Result<()> {
    let turn = take_turn(folder);
    if turn.is_some() {
        remove_left_over(folder, files);
    }
    for path in paths {
        staged.push(Part::create(path).map_err(|error| fault("cannot write", path, &error))?);
    }
    drop(turn);
    for ((part, path), (name, content)) in staged.iter_mut().zip(paths).zip(files) {
        let bytes = content();
        let safe = if name.ends_with("json") { as_plain(&bytes) } else { None };
        part.write(safe.as_deref().map_or(&bytes, str::as_bytes))
            .map_err(|error| fault("cannot write", path, &error))?;
    }
    let _turn = take_turn(folder);
    let _whole = replacing();
    no_folders(paths)?;
    for (part, path) in staged.iter().zip(paths) {
        fs::rename(&part.temporary, path).map_err(|error| fault("cannot replace", path, &error))?;
    }
    Ok(())
}

/// JSON that a viewer shows as it is, where it holds what would steer it.
fn as_plain(bytes: &[u8]) -> Option<String> {
    match plain(std::str::from_utf8(bytes).ok()?) {
        Cow::Owned(safe) => Some(safe),
        Cow::Borrowed(_) => None,
    }
}

/// Refuses a folder in the place of a result before any result is replaced.
fn no_folders(paths: &[PathBuf]) -> Result<()> {
    match paths.iter().find(|path| fs::symlink_metadata(path).is_ok_and(|kind| kind.is_dir())) {
        Some(path) => Err(Error::data("cannot replace: a folder has the name of a result")
            .in_file(path)
            .remedy("rename the folder, or choose another --out; nothing was written")),
        None => Ok(()),
    }
}

/// Removes the temporary files of these results that no living run has locked.
fn remove_left_over(folder: &Path, files: &[(&str, Content<'_>)]) {
    let is_ours = |name: &str| {
        let inner = name.strip_prefix('.').and_then(|name| name.strip_suffix(".part"));
        inner.is_some_and(|inner| {
            files.iter().any(|(of, _)| inner.strip_prefix(of).is_some_and(|rest| rest.starts_with('.')))
        })
    };
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if is_file && entry.file_name().to_str().is_some_and(is_ours) {
            let left = File::open(entry.path()).is_ok_and(|file| file.try_lock().is_ok());
            if left {
                // It may be gone by now.
                let _ = fs::remove_file(entry.path());
            }
        }
    }
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
    fn a_folder_in_the_place_of_a_result_is_told_before_anything_is_replaced() {
        let folder = fresh("folder");
        write_all(&folder, &[("a", "old".into())]).unwrap();
        fs::create_dir(folder.join("b")).unwrap();
        let error = write_all(&folder, &[("a", "new".into()), ("b", "new".into())]).unwrap_err();
        assert!(
            error.file().is_some_and(|file| file.ends_with("b")) && error.to_string().contains("a folder"),
            "{error}"
        );
        assert_eq!(fs::read_to_string(folder.join("a")).unwrap(), "old");
        assert_eq!(names(&folder), ["a", "b"]);
    }

    #[test]
    fn what_a_run_left_that_was_ended_is_removed_and_what_a_living_one_writes_is_not() {
        let folder = fresh("left");
        fs::create_dir_all(&folder).unwrap();
        for name in [".a.4711.part", ".a.0123456789abcdef.part", ".other.1.part", ".a.part.txt"] {
            fs::write(folder.join(name), "half").unwrap();
        }
        let living = fs::File::options().write(true).create_new(true).open(folder.join(".a.1.part")).unwrap();
        living.lock().unwrap();
        write_all(&folder, &[("a", "new".into())]).unwrap();
        assert_eq!(names(&folder), [".a.1.part", ".a.part.txt", ".other.1.part", "a"]);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_under_a_temporary_name_is_not_followed() {
        let folder = fresh("link");
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("victim"), "mine").unwrap();
        // The names that could be foretold, and the result itself.
        let id = std::process::id();
        for name in [format!(".a.{id}.part"), "a".to_owned()] {
            std::os::unix::fs::symlink(folder.join("victim"), folder.join(name)).unwrap();
        }
        write_all(&folder, &[("a", "new".into())]).unwrap();
        assert_eq!(fs::read_to_string(folder.join("victim")).unwrap(), "mine");
        assert_eq!(fs::read_to_string(folder.join("a")).unwrap(), "new");
        let mut made: Vec<u64> = (0..100).map(|_| super::random()).collect();
        made.sort_unstable();
        made.dedup();
        assert_eq!(made.len(), 100);
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
