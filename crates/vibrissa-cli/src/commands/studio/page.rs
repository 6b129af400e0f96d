//! Where the page is.

use std::path::{Path, PathBuf};
use vibrissa::{Error, Result};

/// The page beside a program, and where it is built in the repository.
const NAME: &str = "studio.html";
const BUILT: &str = "studio/dist/studio.html";
/// A mark that every page has.
const MARK: &[u8] = b"<title>vibrissa studio</title>";
/// What to do about a page that is not there.
const BUILD: &str = "run `studio/build` in the repository of vibrissa (it needs Node.js 20 and Rust's target \
                     wasm32-unknown-unknown), or give the page that it made: --page studio.html";

/// The page that was given, or the one that is found.
pub(crate) fn read(given: Option<&Path>) -> Result<Vec<u8>> {
    let Some(path) = given.map(Path::to_owned).or_else(found) else {
        return Err(Error::data("the studio's page is not built").remedy(BUILD));
    };
    let bytes = std::fs::read(&path)
        .map_err(|reason| Error::data("cannot read the studio's page").in_file(&path).value(reason).remedy(BUILD))?;
    if bytes.windows(MARK.len()).any(|window| window == MARK) {
        return Ok(bytes);
    }
    Err(Error::data("this is not the studio's page").in_file(&path).remedy(BUILD))
}

/// The page beside the program, in the repository that it was built in, or in the one that holds the current folder.
fn found() -> Option<PathBuf> {
    let program = std::env::current_exe().ok().and_then(|path| path.canonicalize().ok());
    let program = program.as_deref().and_then(Path::parent);
    let here = std::env::current_dir().ok();
    let beside = program.map(|folder| folder.join(NAME)).into_iter();
    let shared = program.and_then(Path::parent).map(|folder| folder.join("share/vibrissa").join(NAME));
    let built = |folder: Option<&Path>| {
        folder.into_iter().flat_map(Path::ancestors).map(|folder| folder.join(BUILT)).collect::<Vec<_>>()
    };
    beside.chain(shared).chain(built(program)).chain(built(here.as_deref())).find(|path| path.is_file())
}
