//! Hashes of files: XXH3 of 128 bits, as `xxh128sum` prints it.

use std::fs::File;
use std::io::Read;
use std::path::PathBuf;
use std::vec;

use twox_hash::XxHash3_128;

use crate::{Result, cannot_be_opened, file_error, input};

/// Bytes of a file to read at a time.
const AT_A_TIME: usize = 1 << 18;

/// A hash of files, one after the other, that are read some bytes at a time.
///
/// It is in this crate to be compiled for speed.
pub struct FileHash {
    files: vec::IntoIter<PathBuf>,
    open: Option<(PathBuf, File)>,
    /// Whether a file's name is hashed before its bytes.
    named: bool,
    hasher: XxHash3_128,
    buffer: Vec<u8>,
    done: u64,
}

impl FileHash {
    /// Begins the hash of `files`; with `named`, over their names, too.
    pub fn new(files: Vec<PathBuf>, named: bool) -> Self {
        FileHash {
            files: files.into_iter(),
            open: None,
            named,
            hasher: XxHash3_128::with_seed(0),
            buffer: vec![0; AT_A_TIME],
            done: 0,
        }
    }

    /// Hashes the bytes up to about the position `end` in all files.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn up_to(&mut self, end: u64) -> Result<()> {
        while self.done < end {
            let Some((path, file)) = &mut self.open else {
                let Some(path) = self.files.next() else {
                    return Ok(());
                };
                if self.named {
                    let name = path.file_name().unwrap_or_default();
                    self.hasher.write(name.as_encoded_bytes());
                }
                let file = input::open(&path);
                let file = file.map_err(|e| file_error(&path, cannot_be_opened(&e)))?;
                self.open = Some((path, file));
                continue;
            };
            let read = file.read(&mut self.buffer);
            let count = read.map_err(|e| file_error(path, cannot_be_opened(&e)))?;
            self.hasher.write(&self.buffer[..count]);
            self.done += count as u64;
            if count == 0 {
                self.open = None;
            }
        }
        Ok(())
    }

    /// Hashes the rest; returns the hash.
    ///
    /// # Errors
    /// As [`FileHash::up_to`].
    pub fn finish(mut self) -> Result<u128> {
        self.up_to(u64::MAX)?;
        Ok(self.hasher.finish_128())
    }
}
