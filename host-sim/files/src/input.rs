//! Opens files for reading: only regular files, with bounded memory.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

/// Opens a regular file, by its own name or by a link to it.
///
/// # Errors
/// Errors of the system. [`ErrorKind::IsADirectory`] for a folder; [`ErrorKind::Unsupported`] for a device, a pipe
/// or a socket, which may block or never end.
pub fn open(path: &Path) -> io::Result<File> {
    // Before it is opened: opening a pipe waits for a writer.
    let kind = fs::metadata(path)?.file_type();
    if kind.is_dir() {
        return Err(ErrorKind::IsADirectory.into());
    }
    if !kind.is_file() {
        return Err(ErrorKind::Unsupported.into());
    }
    File::open(path)
}

/// Reads a regular file of at most `most` bytes whole.
///
/// # Errors
/// As [`open`]; [`ErrorKind::FileTooLarge`]; [`ErrorKind::OutOfMemory`].
pub fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let file = open(path)?;
    let length = file.metadata()?.len();
    let mut bytes = Vec::new();
    if length <= most {
        bytes.try_reserve_exact(length as usize)?;
        // Files that the system makes up are longer than they say.
        file.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    }
    match length.max(bytes.len() as u64) <= most {
        true => Ok(bytes),
        false => Err(ErrorKind::FileTooLarge.into()),
    }
}

/// The reason why a file cannot be opened.
pub fn cannot_be_opened(error: &io::Error) -> String {
    let reason = match error.kind() {
        ErrorKind::NotFound => "no such file".into(),
        ErrorKind::Unsupported => "not a regular file, but a device, a pipe or a socket".into(),
        kind => kind.to_string(),
    };
    format!("cannot be opened: {reason}")
}
