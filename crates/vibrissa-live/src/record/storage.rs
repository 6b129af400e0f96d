//! Where a recording's bytes go.

use crate::{Error, Result};
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use vibrissa_io::ros::GrowingFile;

/// Waits until all bytes that were written before are on the disk; what the system says where they cannot be.
pub type Synchroniser = Box<dyn FnMut() -> std::io::Result<()> + Send>;

/// The file of a recording, so that tests can let it fail.
pub trait Storage: GrowingFile + Send {
    /// What synchronises the file with the disk, for another thread: bytes may be appended meanwhile.
    fn synchroniser(&self) -> Synchroniser;

    /// Cuts the file to a length.
    ///
    /// # Errors
    ///
    /// What the system says.
    fn truncate(&mut self, length: u64) -> std::io::Result<()>;
}

/// A file on the disk.
#[derive(Debug)]
pub struct FileStorage(Arc<File>);

impl FileStorage {
    /// A new file `NAME.mcap` in a folder, which is made where it is missing; `NAME-2.mcap` and so on where there is one: no
    /// earlier recording is touched.
    ///
    /// # Errors
    ///
    /// A folder or a file that cannot be made.
    pub fn create(folder: &Path, name: &str) -> Result<(Self, PathBuf)> {
        let fault = |path: &Path, error: &std::io::Error| {
            Error::data(format!("cannot begin the recording ({error})"))
                .in_file(path)
                .remedy("choose another folder with --out, or free the disk")
        };
        std::fs::create_dir_all(folder).map_err(|error| fault(folder, &error))?;
        let mut count = 1;
        loop {
            let path = folder.join(if count == 1 { format!("{name}.mcap") } else { format!("{name}-{count}.mcap") });
            match OpenOptions::new().read(true).write(true).create_new(true).open(&path) {
                Ok(file) => {
                    // The entry in the folder has to survive a power cut, too; not every system synchronises folders.
                    if let Ok(folder) = File::open(folder) {
                        let _ = folder.sync_all();
                    }
                    return Ok((Self(Arc::new(file)), path));
                }
                Err(error) if error.kind() == ErrorKind::AlreadyExists => count += 1,
                Err(error) => return Err(fault(&path, &error)),
            }
        }
    }
}

impl GrowingFile for FileStorage {
    fn append(&mut self, bytes: &[u8]) -> std::io::Result<()> {
        self.0.seek(SeekFrom::End(0))?;
        self.0.write_all(bytes)
    }

    fn read_at(&mut self, place: u64, buffer: &mut [u8]) -> std::io::Result<usize> {
        self.0.seek(SeekFrom::Start(place))?;
        self.0.read(buffer)
    }
}

impl Storage for FileStorage {
    fn synchroniser(&self) -> Synchroniser {
        let file = Arc::clone(&self.0);
        Box::new(move || file.sync_data())
    }

    fn truncate(&mut self, length: u64) -> std::io::Result<()> {
        self.0.set_len(length)
    }
}
