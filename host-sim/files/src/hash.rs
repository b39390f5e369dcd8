//! Hashes of files: XXH3 of 128 bits, as `xxh128sum` prints it.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::vec;

use bytemuck::Pod;
use ndarray::{ArrayView, Dimension};
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

    /// Hashes the bytes up to the position `end` in all files.
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
            let most = (end - self.done).min(AT_A_TIME as u64) as usize;
            let read = file.read(&mut self.buffer[..most]);
            let count = read.map_err(|e| file_error(path, cannot_be_opened(&e)))?;
            self.hasher.write(&self.buffer[..count]);
            self.done += count as u64;
            if count == 0 {
                self.open = None;
            }
        }
        Ok(())
    }

    /// Hashes bytes of a single file that a reader has in memory, at a position in the file.
    ///
    /// The bytes before them are read. Bytes that have been hashed are left out.
    ///
    /// # Errors
    /// As [`FileHash::up_to`].
    fn pass(&mut self, position: u64, bytes: &[u8]) -> Result<()> {
        self.up_to(position)?;
        let known = self.done.saturating_sub(position).min(bytes.len() as u64);
        let new = &bytes[known as usize..];
        if let Some((path, file)) = &mut self.open
            && !new.is_empty()
            && self.done >= position
        {
            let moved = file.seek(SeekFrom::Current(new.len() as i64));
            moved.map_err(|e| file_error(path, cannot_be_opened(&e)))?;
            self.hasher.write(new);
            self.done += new.len() as u64;
        }
        Ok(())
    }

    /// Hashes the rest; returns the hash.
    ///
    /// # Errors
    /// As [`FileHash::up_to`].
    pub fn finish(&mut self) -> Result<u128> {
        self.up_to(u64::MAX)?;
        Ok(self.hasher.finish_128())
    }
}

/// The hash of an array's numbers in memory.
pub fn of_array<T: Pod, D: Dimension>(array: &ArrayView<'_, T, D>) -> u128 {
    let array = array.as_standard_layout();
    XxHash3_128::oneshot(bytemuck::cast_slice(array.as_slice().unwrap_or_default()))
}

/// A hash that the reader of a file shares with another thread.
///
/// The thread hashes the bytes that are not read in order.
#[derive(Clone)]
pub struct SharedHash(Arc<Mutex<FileHash>>);

impl SharedHash {
    /// Shares a hash.
    pub fn new(hash: FileHash) -> Self {
        SharedHash(Arc::new(Mutex::new(hash)))
    }

    /// The hash, for one thread at a time.
    pub fn lock(&self) -> MutexGuard<'_, FileHash> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A reader whose bytes are hashed while they are in the cache.
pub(crate) struct Hashed<'h, R> {
    pub(crate) inner: R,
    /// Position of the next byte in the file.
    pub(crate) position: u64,
    pub(crate) hash: Option<&'h SharedHash>,
}

impl<R: Read> Read for Hashed<'_, R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(bytes)?;
        if let Some(hash) = self.hash {
            let passed = hash.lock().pass(self.position, &bytes[..count]);
            passed.map_err(io::Error::other)?;
        }
        self.position += count as u64;
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Parts that a reader passes, in order, again or far ahead, do not change the hash.
    #[test]
    fn a_hash_does_not_depend_on_who_reads() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        let bytes: Vec<u8> = (0..3 * AT_A_TIME + 77)
            .map(|k| (k * 31 + k / 256) as u8)
            .collect();
        std::fs::write(&path, &bytes).unwrap();
        let expected = XxHash3_128::oneshot(&bytes);
        let hash = || FileHash::new(vec![path.clone()], false);
        assert_eq!(hash().finish().unwrap(), expected);
        let parts = [
            0..10,
            10..5000,
            4000..4500,
            4900..9000,
            AT_A_TIME + 3..2 * AT_A_TIME,
            77..bytes.len(),
        ];
        for behind in [0, 6000, bytes.len()] {
            let shared = SharedHash::new(hash());
            for part in parts.clone() {
                let mut hashed = Hashed {
                    inner: &bytes[part.clone()],
                    position: part.start as u64,
                    hash: Some(&shared),
                };
                io::copy(&mut hashed, &mut io::sink()).unwrap();
                shared.lock().up_to(behind as u64).unwrap();
            }
            assert_eq!(shared.lock().finish().unwrap(), expected, "{behind}");
        }
    }
}
