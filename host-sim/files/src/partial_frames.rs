//! The lines of an interrupted run, frame by frame.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use ndarray::Array2;
use num_complex::Complex;

use super::{file_error, temporary_files};
use crate::memory::product;
use crate::terminal::warn;
use crate::{Error, Result};

/// Longest work that an interruption may lose.
const INTERVAL: Duration = Duration::from_secs(10);
const MAGIC: [u8; 16] = *b"bonebeam lines 2";
/// The magic number, the key, and the numbers of beams and samples.
const HEADER: usize = 16 + 16 + 8 + 8;

/// A file beside the output with the lines of the frames done.
///
/// Its frames are those of one run, which a key identifies. Each has a hash of the samples of which it was made, and a
/// checksum, so a frame that was being written when the run was killed does not count. The file is removed when the output exists, and when a run of less than
/// ten seconds fails or is ended by a signal.
pub struct PartialLines {
    path: PathBuf,
    key: u128,
    /// The file, once it exists and belongs to this run alone.
    file: Option<File>,
    shape: (usize, usize),
    /// Memory of the frame that is written.
    record: Vec<u8>,
    done: usize,
    resumed: usize,
    begin: Instant,
    is_temporary: bool,
}

impl PartialLines {
    /// Opens the file at `path` with the frames of the run `key`.
    ///
    /// There are no frames if the file does not exist or belongs to another run; in the latter case it is replaced.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn open(path: &Path, key: u128) -> Result<Self> {
        let mut lines = PartialLines {
            path: path.to_path_buf(),
            key,
            file: None,
            shape: (0, 0),
            record: Vec::new(),
            done: 0,
            resumed: 0,
            begin: Instant::now(),
            is_temporary: false,
        };
        let file = match OpenOptions::new().read(true).write(true).open(path) {
            Ok(file) => file,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(lines),
            Err(e) => return Err(lines.error(e)),
        };
        // Another run's, which is at work: this one goes without.
        if file.try_lock().is_err() {
            return Ok(lines);
        }
        lines.file = Some(file);
        if !lines.count().map_err(|e| lines.error(e))? {
            warn(&format!(
                "{}: belongs to another run; all frames are computed again",
                path.display()
            ));
            lines.file = None;
            fs::remove_file(path).map_err(|e| lines.error(e))?;
        }
        lines.resumed = lines.done;
        Ok(lines)
    }

    /// Keeps the frames made of samples with these hashes, up to the first that is not.
    ///
    /// # Errors
    /// Errors of `hash_of`.
    pub fn keep(&mut self, mut hash_of: impl FnMut(usize) -> Result<u128>) -> Result<()> {
        for frame in 0..self.done {
            let kept = self.frame(frame).map_err(|e| self.error(e))?;
            let hash = hash_of(frame)?;
            if kept.is_none_or(|(_, own)| own != hash) {
                warn(&format!(
                    "{}: belongs to another run from frame {frame} on; these frames are computed again",
                    self.path.display()
                ));
                (self.done, self.resumed) = (frame, frame);
                break;
            }
        }
        Ok(())
    }

    /// Number of frames done.
    pub fn done(&self) -> usize {
        self.done
    }

    /// Number of frames done by an interrupted run.
    pub fn resumed(&self) -> usize {
        self.resumed
    }

    /// The lines of a frame that is done.
    ///
    /// # Errors
    /// The file cannot be read, or has changed.
    pub fn read(&mut self, frame: usize) -> Result<Array2<Complex<f32>>> {
        let values = self.frame(frame).map_err(|e| self.error(e))?;
        let z = values.and_then(|(values, _)| Array2::from_shape_vec(self.shape, values).ok());
        z.ok_or_else(|| file_error(&self.path, "has changed; remove it"))
    }

    /// Adds the lines of the next frame, made of samples with a hash.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn append(&mut self, z: &Array2<Complex<f32>>, hash: u128) -> Result<()> {
        self.write(z, hash).map_err(|e| self.error(e))?;
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

    /// The bytes of a frame, with hash and checksum.
    fn bytes(&self) -> usize {
        let values = product(&[self.shape.0, self.shape.1, size_of::<Complex<f32>>()]);
        values.saturating_add(size_of::<u128>() + size_of::<u32>())
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
        let number = |at: usize| {
            let mut bytes = [0; 8];
            bytes.copy_from_slice(&header[at..at + 8]);
            usize::try_from(u64::from_le_bytes(bytes)).unwrap_or(usize::MAX)
        };
        self.shape = (number(32), number(40));
        let is_some = self.shape.0 > 0 && self.shape.1 > 0;
        let is_same = is_some && header[..16] == MAGIC && header[16..32] == self.key.to_le_bytes();
        let whole = (length - HEADER as u64) / self.bytes().max(1) as u64;
        while is_same && (self.done as u64) < whole && self.frame(self.done)?.is_some() {
            self.done += 1;
        }
        Ok(is_same)
    }

    /// Values of a frame and their hash; `None` if the checksum does not match.
    fn frame(&mut self, frame: usize) -> io::Result<Option<(Vec<Complex<f32>>, u128)>> {
        let (bytes, start) = (self.bytes(), self.start(frame));
        let Some(file) = &mut self.file else {
            return Ok(None);
        };
        file.seek(SeekFrom::Start(start))?;
        let mut record = Vec::new();
        record.try_reserve_exact(bytes)?;
        file.take(bytes as u64).read_to_end(&mut record)?;
        let Some((hashed, checksum)) = record.split_last_chunk::<4>() else {
            return Ok(None);
        };
        let Some((values, hash)) = hashed.split_last_chunk::<16>() else {
            return Ok(None);
        };
        if record.len() != bytes || crc32fast::hash(hashed) != u32::from_le_bytes(*checksum) {
            return Ok(None);
        }
        let parts = values.as_chunks::<4>().0.as_chunks::<2>().0.iter();
        let complex =
            parts.map(|[re, im]| Complex::new(f32::from_le_bytes(*re), f32::from_le_bytes(*im)));
        Ok(Some((complex.collect(), u128::from_le_bytes(*hash))))
    }

    fn start(&self, frame: usize) -> u64 {
        (HEADER as u64).saturating_add((frame as u64).saturating_mul(self.bytes() as u64))
    }

    fn write(&mut self, z: &Array2<Complex<f32>>, hash: u128) -> io::Result<()> {
        if self.done == 0 && self.file.is_none() {
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
            self.shape = z.dim();
            let mut header = [MAGIC, self.key.to_le_bytes()].concat();
            for side in [self.shape.0, self.shape.1] {
                header.extend((side as u64).to_le_bytes());
            }
            file.write_all(&header)?;
            self.file = Some(file);
        }
        let start = self.start(self.done);
        let Some(file) = &mut self.file else {
            return Ok(());
        };
        if z.dim() != self.shape {
            return Err(io::Error::other("frames of several shapes"));
        }
        let record = &mut self.record;
        record.clear();
        record.try_reserve_exact((z.len() + 3) * size_of::<Complex<f32>>())?;
        for value in z {
            record.extend(value.re.to_le_bytes());
            record.extend(value.im.to_le_bytes());
        }
        record.extend(hash.to_le_bytes());
        record.extend(crc32fast::hash(record).to_le_bytes());
        file.seek(SeekFrom::Start(start))?;
        file.write_all(record)?;
        self.done += 1;
        Ok(())
    }
}

impl Drop for PartialLines {
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

    fn frame(number: usize) -> Array2<Complex<f32>> {
        Array2::from_shape_fn((3, 5), |(beam, sample)| {
            Complex::new((100 * number + 10 * beam + sample) as f32, -(sample as f32))
        })
    }

    #[test]
    fn frames_are_there_again_up_to_the_first_that_is_damaged() {
        let folder = tempdir().unwrap();
        let path = folder.path().join("lines.npz.partial");
        let mut lines = PartialLines::open(&path, 7).unwrap();
        assert!(!path.exists());
        for number in 0..4 {
            lines.append(&frame(number), number as u128).unwrap();
        }
        assert!(lines.append(&Array2::zeros((3, 4)), 0).is_err());
        // As after a kill: nothing is dropped.
        std::mem::forget(lines);
        let whole = fs::read(&path).unwrap();
        let size = 3 * 5 * 8 + 16 + 4;
        assert_eq!(whole.len(), HEADER + 4 * size);

        let kept = |bytes: &[u8], key: u128| {
            let path = folder.path().join("other.partial");
            fs::write(&path, bytes).unwrap();
            let mut lines = PartialLines::open(&path, key).unwrap();
            let done = lines.done();
            for number in 0..done {
                assert_eq!(lines.read(number).unwrap(), frame(number));
            }
            assert_eq!(lines.resumed(), done);
            // It goes on from there.
            lines.append(&frame(done), done as u128).unwrap();
            assert_eq!(lines.read(done).unwrap(), frame(done));
            lines.finish();
            assert!(!path.exists());
            done
        };
        assert_eq!(kept(&whole, 7), 4);
        // Of other samples from frame 2 on.
        let again = folder.path().join("again.partial");
        fs::write(&again, &whole).unwrap();
        let mut lines = PartialLines::open(&again, 7).unwrap();
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
        // A header that claims more than there is.
        damaged[40..48].copy_from_slice(&u64::MAX.to_le_bytes());
        fs::write(&path, damaged).unwrap();
        assert_eq!(PartialLines::open(&path, 7).unwrap().done(), 0);
    }
}
