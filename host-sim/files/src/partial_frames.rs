//! The results of an interrupted run, frame by frame.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::{file_error, temporary_files};
use crate::terminal::warn;
use crate::{Error, Result};

/// Longest work that an interruption may lose.
const INTERVAL: Duration = Duration::from_secs(10);
const MAGIC: [u8; 16] = *b"bonebeam frame 3";
/// The magic number and the key.
const HEADER: usize = 16 + 16;
/// What a frame has beside its bytes: their number before them, a hash and a checksum behind.
const BESIDE: u64 = 8 + 16 + 4;

/// A file beside the output with the results of the frames done, as bytes.
///
/// Its frames are those of one run, which a key identifies. Each has a hash of the data of which it was made, and a
/// checksum, so a frame that was being written when the run was killed does not count. The file is removed when the output exists, and when a run of less than
/// ten seconds fails or is ended by a signal.
pub struct PartialFrames {
    path: PathBuf,
    key: u128,
    /// The file, once it exists and belongs to this run alone.
    file: Option<File>,
    /// Where each whole frame ends.
    ends: Vec<u64>,
    /// Memory of the frame that is written.
    record: Vec<u8>,
    resumed: usize,
    begin: Instant,
    is_temporary: bool,
}

impl PartialFrames {
    /// Opens OUTPUT.partial beside an output, with the frames of the run `key`.
    ///
    /// There are no frames if the file does not exist or belongs to another run; in the latter case it is replaced.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn beside(output: &Path, key: u128) -> Result<Self> {
        let mut path = output.as_os_str().to_owned();
        path.push(".partial");
        Self::open(Path::new(&path), key)
    }

    fn open(path: &Path, key: u128) -> Result<Self> {
        let mut partial = PartialFrames {
            path: path.to_path_buf(),
            key,
            file: None,
            ends: Vec::new(),
            record: Vec::new(),
            resumed: 0,
            begin: Instant::now(),
            is_temporary: false,
        };
        let file = match OpenOptions::new().read(true).write(true).open(path) {
            Ok(file) => file,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(partial),
            Err(e) => return Err(partial.error(e)),
        };
        // Another run's, which is at work: this one goes without.
        if file.try_lock().is_err() {
            return Ok(partial);
        }
        partial.file = Some(file);
        if !partial.count().map_err(|e| partial.error(e))? {
            warn(&format!(
                "{}: belongs to another run; all frames are computed again",
                path.display()
            ));
            partial.file = None;
            fs::remove_file(path).map_err(|e| partial.error(e))?;
        }
        partial.resumed = partial.done();
        Ok(partial)
    }

    /// Keeps the frames made of samples with these hashes, up to the first that is not.
    ///
    /// # Errors
    /// Errors of `hash_of`.
    pub fn keep(&mut self, mut hash_of: impl FnMut(usize) -> Result<u128>) -> Result<()> {
        for frame in 0..self.done() {
            let kept = self.frame(frame).map_err(|e| self.error(e))?;
            let hash = hash_of(frame)?;
            if kept.is_none_or(|(_, own)| own != hash) {
                warn(&format!(
                    "{}: belongs to another run from frame {frame} on; these frames are computed again",
                    self.path.display()
                ));
                self.ends.truncate(frame);
                self.resumed = frame;
                break;
            }
        }
        Ok(())
    }

    /// Number of frames done.
    pub fn done(&self) -> usize {
        self.ends.len()
    }

    /// Number of frames done by an interrupted run.
    pub fn resumed(&self) -> usize {
        self.resumed
    }

    /// What `decoded` makes of the bytes of a frame that is done.
    ///
    /// # Errors
    /// The file cannot be read, or has changed, or `decoded` makes nothing of it.
    pub fn read<T>(&mut self, frame: usize, decoded: impl FnOnce(&[u8]) -> Option<T>) -> Result<T> {
        let bytes = self.frame(frame).map_err(|e| self.error(e))?;
        let value = bytes.and_then(|(bytes, _)| decoded(&bytes));
        value.ok_or_else(|| file_error(&self.path, "has changed; remove it"))
    }

    /// Adds the bytes of the next frame, made of data with a hash.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn append(&mut self, bytes: &[u8], hash: u128) -> Result<()> {
        self.write(bytes, hash).map_err(|e| self.error(e))?;
        if self.is_temporary && self.begin.elapsed() > INTERVAL {
            self.is_temporary = false;
            temporary_files::lock().forget(&self.path);
        }
        Ok(())
    }

    /// Removes the file, once the output exists.
    pub fn finish(mut self) {
        self.is_temporary = self.file.is_some();
    }

    fn error(&self, error: io::Error) -> Error {
        file_error(&self.path, format!("cannot be used: {error}"))
    }

    /// Counts the whole frames; `false` if the file belongs to another run.
    fn count(&mut self) -> io::Result<bool> {
        let Some(file) = &mut self.file else {
            return Ok(false);
        };
        let length = file.metadata()?.len();
        if length < HEADER as u64 {
            return Ok(false);
        }
        let mut header = [0; HEADER];
        file.read_exact(&mut header)?;
        let is_same = header[..16] == MAGIC && header[16..] == self.key.to_le_bytes();
        while is_same && let Some(bytes) = self.next_length(length)? {
            self.ends.push(self.end().saturating_add(bytes + BESIDE));
            if self.frame(self.done() - 1)?.is_none() {
                self.ends.pop();
                break;
            }
        }
        Ok(is_same)
    }

    /// The number of bytes of the frame after the last, if the file is long enough.
    fn next_length(&mut self, length: u64) -> io::Result<Option<u64>> {
        let start = self.end();
        let (Some(rest), Some(file)) = (
            length
                .checked_sub(start)
                .and_then(|rest| rest.checked_sub(BESIDE)),
            &mut self.file,
        ) else {
            return Ok(None);
        };
        let mut bytes = [0; 8];
        file.seek(SeekFrom::Start(start))?;
        file.read_exact(&mut bytes)?;
        Ok(Some(u64::from_le_bytes(bytes)).filter(|bytes| *bytes <= rest))
    }

    /// Bytes of a frame and their hash; `None` if the checksum does not match.
    fn frame(&mut self, frame: usize) -> io::Result<Option<(Vec<u8>, u128)>> {
        let [start, end] = [self.ends[..frame].last(), self.ends.get(frame)]
            .map(|end| end.copied().unwrap_or(HEADER as u64));
        let Some(file) = &mut self.file else {
            return Ok(None);
        };
        let bytes = end.saturating_sub(start + 8);
        file.seek(SeekFrom::Start(start + 8))?;
        let mut record = Vec::new();
        record.try_reserve_exact(usize::try_from(bytes).unwrap_or(usize::MAX))?;
        file.take(bytes).read_to_end(&mut record)?;
        let Some((hashed, checksum)) = record.split_last_chunk::<4>() else {
            return Ok(None);
        };
        if record.len() as u64 != bytes || crc32fast::hash(hashed) != u32::from_le_bytes(*checksum)
        {
            return Ok(None);
        }
        let parts = hashed.split_last_chunk::<16>();
        Ok(parts.map(|(bytes, hash)| (bytes.to_vec(), u128::from_le_bytes(*hash))))
    }

    /// Where the frames done end.
    fn end(&self) -> u64 {
        self.ends.last().copied().unwrap_or(HEADER as u64)
    }

    fn write(&mut self, bytes: &[u8], hash: u128) -> io::Result<()> {
        if self.ends.is_empty() && self.file.is_none() {
            let mut guard = temporary_files::lock();
            guard.add(&self.path);
            let new = OpenOptions::new()
                .read(true)
                .write(true)
                .create_new(true)
                .open(&self.path);
            let mut file = match new {
                Ok(file) => file,
                Err(e) => {
                    guard.forget(&self.path);
                    // Another run's.
                    let taken = e.kind() == io::ErrorKind::AlreadyExists;
                    return if taken { Ok(()) } else { Err(e) };
                }
            };
            self.is_temporary = true;
            drop(guard);
            // A file system without locks goes without.
            let _ = file.try_lock();
            file.write_all(&[MAGIC, self.key.to_le_bytes()].concat())?;
            self.file = Some(file);
        }
        let start = self.end();
        let Some(file) = &mut self.file else {
            return Ok(());
        };
        let record = &mut self.record;
        record.clear();
        record.try_reserve_exact(bytes.len() + BESIDE as usize)?;
        record.extend((bytes.len() as u64).to_le_bytes());
        record.extend(bytes);
        record.extend(hash.to_le_bytes());
        record.extend(crc32fast::hash(&record[8..]).to_le_bytes());
        file.seek(SeekFrom::Start(start))?;
        file.write_all(record)?;
        let end = start + record.len() as u64;
        self.ends.push(end);
        Ok(())
    }
}

impl Drop for PartialFrames {
    fn drop(&mut self) {
        if self.is_temporary {
            let mut guard = temporary_files::lock();
            // A file that cannot be removed stays: there is nobody to tell.
            let _ = fs::remove_file(&self.path);
            guard.forget(&self.path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tempfile::tempdir;

    /// Frames may differ in length.
    fn frame(number: usize) -> Vec<u8> {
        (0..40 + number).map(|k| (100 * number + k) as u8).collect()
    }

    #[test]
    fn frames_are_there_again_up_to_the_first_that_is_damaged() {
        let folder = tempdir().unwrap();
        let path = folder.path().join("lines.npz.partial");
        let mut lines = PartialFrames::open(&path, 7).unwrap();
        assert!(!path.exists());
        for number in 0..4 {
            lines.append(&frame(number), number as u128).unwrap();
        }
        // As after a kill: nothing is dropped.
        std::mem::forget(lines);
        let whole = fs::read(&path).unwrap();
        let size = 8 + 40 + 16 + 4;
        assert_eq!(whole.len(), HEADER + 4 * size + 6);

        let read = |lines: &mut PartialFrames, frame: usize| {
            lines.read(frame, |bytes| Some(bytes.to_vec())).unwrap()
        };
        let kept = |bytes: &[u8], key: u128| {
            let path = folder.path().join("other.partial");
            fs::write(&path, bytes).unwrap();
            let mut lines = PartialFrames::open(&path, key).unwrap();
            let done = lines.done();
            for number in 0..done {
                assert_eq!(read(&mut lines, number), frame(number));
            }
            assert_eq!(lines.resumed(), done);
            // It goes on from there.
            lines.append(&frame(done), done as u128).unwrap();
            assert_eq!(read(&mut lines, done), frame(done));
            lines.finish();
            assert!(!path.exists());
            done
        };
        assert_eq!(kept(&whole, 7), 4);
        // Of other samples from frame 2 on.
        let again = folder.path().join("again.partial");
        fs::write(&again, &whole).unwrap();
        let mut lines = PartialFrames::open(&again, 7).unwrap();
        lines
            .keep(|frame| Ok(if frame < 2 { frame as u128 } else { 9 }))
            .unwrap();
        assert_eq!((lines.done(), lines.resumed()), (2, 2));
        drop(lines);
        assert_eq!(kept(&whole, 8), 0);
        assert_eq!(kept(&whole[..whole.len() - 1], 7), 3);
        assert_eq!(kept(&whole[..HEADER - 1], 7), 0);
        assert_eq!(kept(&[], 7), 0);
        let mut damaged = whole.clone();
        damaged[HEADER + size + 9] ^= 1;
        assert_eq!(kept(&damaged, 7), 1);
        // A length that claims more than there is.
        damaged[HEADER..HEADER + 8].copy_from_slice(&u64::MAX.to_le_bytes());
        fs::write(&path, damaged).unwrap();
        assert_eq!(PartialFrames::open(&path, 7).unwrap().done(), 0);
    }
}
