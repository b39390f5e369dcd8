//! What made a result: the program's version and commit, and a hash of its input.

use std::fs::{self, Metadata};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use twox_hash::XxHash3_128;

use crate::{Error, Result};
use bonebeam_files::{cannot_be_opened, file_error, input};

/// The program's version.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
/// The commit that the program was built of; `unknown` outside a repository.
pub const COMMIT: &str = env!("HOST_SIM_COMMIT");
/// Version and commit, as `--version` prints them.
pub const PROGRAM: &str = concat!(
    env!("CARGO_PKG_VERSION"),
    ", commit ",
    env!("HOST_SIM_COMMIT")
);
/// The largest file that is hashed where only a part of it was used, bytes.
const PART: u64 = 1 << 30;

/// A file that a result was made of.
pub struct Input {
    /// Its path as it was given.
    pub path: PathBuf,
    /// XXH3 of 128 bits over its bytes, as `xxh128sum` prints it; of a folder, over names and bytes of its files in
    /// the order of their names. None for a large file of which only a part was used.
    pub xxh128: Option<String>,
}

impl Input {
    /// Reads and hashes a file or the files of a folder.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn read(path: &Path, is_whole: bool) -> Result<Self> {
        let files = files_of(path)?;
        let bytes: u64 = files.iter().map(|(_, metadata)| metadata.len()).sum();
        let xxh128 = match is_whole || bytes <= PART {
            true => Some(format!("{:032x}", hash(path, &files)?)),
            false => None,
        };
        Ok(Input {
            path: path.to_path_buf(),
            xxh128,
        })
    }
}

fn hash(path: &Path, files: &[(PathBuf, Metadata)]) -> Result<u128> {
    let mut hasher = XxHash3_128::with_seed(0);
    let mut buffer = vec![0; 1 << 18];
    for (file, _) in files {
        if file != path {
            hasher.write(file.file_name().unwrap_or_default().as_encoded_bytes());
        }
        let wrong = |e| unreadable(file, &e);
        let mut opened = input::open(file).map_err(wrong)?;
        loop {
            match opened.read(&mut buffer).map_err(wrong)? {
                0 => break,
                count => hasher.write(&buffer[..count]),
            }
        }
    }
    Ok(hasher.finish_128())
}

/// A number that changes with the input's path, length or time of change, and with `settings`.
///
/// # Errors
/// A file that cannot be read.
pub fn key(path: &Path, settings: &str) -> Result<u128> {
    let mut hasher = XxHash3_128::with_seed(0);
    hasher.write(PROGRAM.as_bytes());
    hasher.write(settings.as_bytes());
    let full = fs::canonicalize(path).map_err(|e| unreadable(path, &e))?;
    hasher.write(full.as_os_str().as_encoded_bytes());
    for (_, metadata) in files_of(path)? {
        hasher.write(&metadata.len().to_le_bytes());
        let changed = metadata.modified().ok();
        let changed = changed.and_then(|time| time.duration_since(UNIX_EPOCH).ok());
        hasher.write(&changed.unwrap_or_default().as_nanos().to_le_bytes());
    }
    Ok(hasher.finish_128())
}

/// The file, or the files of a folder by their names.
fn files_of(path: &Path) -> Result<Vec<(PathBuf, Metadata)>> {
    let wrong = |e| unreadable(path, &e);
    let metadata = fs::metadata(path).map_err(wrong)?;
    if !metadata.is_dir() {
        return Ok(vec![(path.to_path_buf(), metadata)]);
    }
    let mut files = Vec::new();
    for entry in fs::read_dir(path).map_err(wrong)? {
        let file = entry.map_err(wrong)?.path();
        let metadata = fs::metadata(&file).map_err(wrong)?;
        if metadata.is_file() {
            files.push((file, metadata));
        }
    }
    files.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(files)
}

fn unreadable(path: &Path, error: &std::io::Error) -> Error {
    file_error(path, cannot_be_opened(error))
}
