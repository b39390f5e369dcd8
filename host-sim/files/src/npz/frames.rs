//! Reads some frames of an archive's samples.

use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;

use ndarray::{Array2, Array4, ArrayD, ArrayView2, Axis};
use num_complex::Complex;
use zip::CompressionMethod;
use zip::result::ZipResult;

use super::{MAX_INFLATION, Reader, SMALL};
use crate::hash::Hashed;
use crate::npy;
use crate::npy_header::Header;
use crate::{Error, Result, memory};

/// Size from which an array may stay in the file, bytes.
const LARGE: usize = 16 << 20;
/// Numbers to read at a time.
const AT_A_TIME: usize = 1 << 14;

/// Some frames of an array.
pub struct SomeFrames<T> {
    /// The samples, [frame, …].
    pub array: Array4<T>,
    /// Number of all frames in the file.
    pub held: usize,
    /// Whether all samples are known to be finite.
    pub are_finite: bool,
}

/// Some frames of an array, or all.
pub struct Part {
    pub(crate) header: Header,
    /// Within the member.
    bytes: Range<usize>,
    /// Number of all frames.
    held: usize,
    /// Whether the bytes are the member's rest.
    is_all: bool,
}

impl Part {
    /// The last three sides.
    pub(crate) fn sides(&self) -> [usize; 3] {
        self.header.shape.last_chunk().copied().unwrap_or_default()
    }
}

impl Reader {
    /// Real samples of some frames, [frame, …].
    ///
    /// Types are those of [`Reader::samples_of_any_rank`]. A file without a frame axis has one frame. `axes` names
    /// the other axes. Samples stored by columns are read whole.
    pub fn real_frames(
        &mut self,
        key: &str,
        axes: &str,
        frames: Range<usize>,
    ) -> Result<SomeFrames<f32>> {
        if let Some(part) = self.part(key, &frames)?
            && part.header.descr == "<f4"
        {
            let numbers = std::mem::take(&mut self.spare.real);
            if let Some(stored) = self.stored(key, &part, numbers, floats)? {
                return self.framed(key, axes, stored, Some(part.held));
            }
        }
        let (bytes, held) = self.bytes_of_frames(key, frames)?;
        let array = self.real_samples(key, &bytes)?;
        self.framed(key, axes, (array, false), held)
    }

    /// Samples of some frames that are stored as i16; `None` for another type.
    pub fn count_frames(
        &mut self,
        key: &str,
        axes: &str,
        frames: Range<usize>,
    ) -> Result<Option<SomeFrames<i16>>> {
        let head = self.head(key)?;
        if !Header::read(&head).is_ok_and(|(header, _)| header.descr == "<i2") {
            return Ok(None);
        }
        if let Some(part) = self.part(key, &frames)? {
            let numbers = std::mem::take(&mut self.spare.counts);
            if let Some(stored) = self.stored(key, &part, numbers, counts)? {
                return self.framed(key, axes, stored, Some(part.held)).map(Some);
            }
        }
        let (bytes, held) = self.bytes_of_frames(key, frames)?;
        let array = self.typed(key, npy::read::<i16>(&bytes), "int16")?;
        self.framed(key, axes, (array, true), held).map(Some)
    }

    /// Complex samples of some frames, complex64 or complex128; else as real samples.
    pub fn complex_frames(
        &mut self,
        key: &str,
        axes: &str,
        frames: Range<usize>,
    ) -> Result<SomeFrames<Complex<f32>>> {
        if let Some(part) = self.part(key, &frames)?
            && part.header.descr == "<c8"
        {
            let numbers = std::mem::take(&mut self.spare.complex);
            if let Some(stored) = self.stored(key, &part, numbers, complex)? {
                return self.framed(key, axes, stored, Some(part.held));
            }
        }
        let (bytes, held) = self.bytes_of_frames(key, frames)?;
        let array = self.complex_samples(key, &bytes)?;
        self.framed(key, axes, (array, false), held)
    }

    fn framed<T>(
        &self,
        key: &str,
        axes: &str,
        (array, are_finite): (ArrayD<T>, bool),
        held: Option<usize>,
    ) -> Result<SomeFrames<T>> {
        let expected = match array.ndim() {
            4 => format!("[frame, {axes}]"),
            _ => format!("[{axes}], or with a frame axis before them"),
        };
        let array = match array.ndim() {
            3 => array.insert_axis(Axis(0)),
            _ => array,
        };
        let array: Array4<T> = self.ranked(key, array, &expected)?;
        let held = held.unwrap_or(array.dim().0);
        Ok(SomeFrames {
            array,
            held,
            are_finite,
        })
    }

    /// Bytes of an array of four axes at some indices of the first, and its length.
    ///
    /// Returns all bytes and `None` if the array has other axes, is stored by columns or has no more indices. The
    /// archive's checksum is not compared for a part of a member.
    fn bytes_of_frames(
        &mut self,
        key: &str,
        frames: Range<usize>,
    ) -> Result<(Vec<u8>, Option<usize>)> {
        let Some(part) = self.part(key, &frames)?.filter(|part| !part.is_all) else {
            return Ok((self.bytes(key)?, None));
        };
        let mut bytes = part.header.bytes();
        let own = bytes.len();
        bytes.resize(own + part.bytes.len(), 0);
        self.read_at(key, part.bytes.start, &mut bytes[own..])?;
        Ok((bytes, Some(part.held)))
    }

    /// Position of some indices along the first of four axes.
    ///
    /// `None` if [`Reader::bytes_of_frames`] reads all.
    fn part(&mut self, key: &str, frames: &Range<usize>) -> Result<Option<Part>> {
        let head = self.head(key)?;
        // What is wrong with a header is reported where all of it is read.
        let Ok((mut header, numbers)) = Header::read(&head) else {
            return Ok(None);
        };
        let held = match header.shape[..] {
            [held, _, _, _] => held,
            [_, _, _] => 1,
            _ => return Ok(None),
        };
        if header.in_columns {
            self.check_whole(key, numbers.end)?;
            return Ok(None);
        }
        let end = frames.end.min(held);
        let start = frames.start.min(end);
        let is_all = header.shape.len() == 3 || (start, end) == (0, held);
        if numbers.is_empty() {
            return Ok(None);
        }
        let frame = numbers.len() / held;
        let (start, end) = if is_all { (0, held) } else { (start, end) };
        if !is_all {
            header.shape[0] = end - start;
        }
        let too_large = |e: Error| self.error(format!("`{key}` is too large: {e}"));
        let length = (end - start) * frame;
        if !is_all {
            memory::check(length.saturating_mul(npy::CONVERSIONS), "the array")
                .map_err(too_large)?;
        }
        let first = numbers.start + start * frame;
        Ok(Some(Part {
            header,
            bytes: first..first + length,
            held,
            is_all,
        }))
    }

    /// Reads the numbers of a part that is stored uncompressed into the memory of `numbers`.
    ///
    /// `read` fills some numbers, few enough to stay in the cache, and returns whether they are finite.
    fn stored<T: Clone + Default>(
        &mut self,
        key: &str,
        part: &Part,
        mut numbers: Vec<T>,
        read: impl Fn(&mut dyn Read, &mut [T]) -> io::Result<bool>,
    ) -> Result<Option<(ArrayD<T>, bool)>> {
        // What is too large is reported by `Reader::bytes`.
        if part.is_all && memory::check(part.bytes.len(), "the array").is_err() {
            return Ok(None);
        }
        let count = part.header.shape.iter().product();
        let filled = self.within(key, part, |member| {
            numbers.resize(count, T::default());
            let mut are_finite = true;
            for some in numbers.chunks_mut(AT_A_TIME) {
                are_finite &= read(member, some)?;
            }
            Ok(are_finite)
        })?;
        let Some((are_finite, _)) = filled else {
            return Ok(None);
        };
        let array = ArrayD::from_shape_vec(part.header.shape.clone(), numbers);
        let array = array.map_err(|e| self.error(format!("`{key}` {e}")))?;
        Ok(Some((array, are_finite)))
    }

    /// The result of `work` with the bytes of a part that is stored uncompressed, and their position in the file.
    ///
    /// `None` if it is compressed, or not as long as its header says.
    fn within<R>(
        &mut self,
        key: &str,
        part: &Part,
        work: impl FnOnce(&mut dyn Read) -> io::Result<R>,
    ) -> Result<Option<(R, u64)>> {
        let name = format!("{key}.npy");
        let within = || -> ZipResult<Option<(R, u64)>> {
            let member = self.archive.by_name(&name)?;
            let is_short = part.is_all && member.size() != part.bytes.end as u64;
            if member.compression() != CompressionMethod::Stored || is_short {
                return Ok(None);
            }
            let (begin, from) = (member.data_start(), part.bytes.start as u64);
            let work = |inner: &mut dyn Read, skipped: u64| -> io::Result<R> {
                let (position, hash) = (begin + skipped, self.hash.as_ref());
                let mut member = Hashed {
                    inner,
                    position,
                    hash,
                };
                io::copy(&mut (&mut member).take(from - skipped), &mut io::sink())?;
                work(&mut member)
            };
            let done = if part.is_all {
                let mut member = member;
                let done = work(&mut member, 0)?;
                // Its end compares the archive's checksum.
                io::copy(&mut member, &mut io::sink())?;
                done
            } else {
                drop(member);
                let mut member = self.archive.by_name_seek(&name)?;
                member.seek(SeekFrom::Start(from))?;
                work(&mut member, from)?
            };
            Ok(Some((done, begin + from)))
        };
        within().map_err(|e| self.damaged(key, &e))
    }

    /// A large array of three axes, or of four with one frame, that may stay in the file: its header.
    ///
    /// Only a file with a hash.
    pub(crate) fn large(&mut self, key: &str) -> Result<Option<Part>> {
        let part = self.part(key, &(0..1))?;
        let is_large = |part: &Part| part.is_all && part.bytes.len() >= LARGE;
        Ok(part.filter(|part| self.hash.is_some() && is_large(part)))
    }

    /// Passes such an array to `each`, one index of the first of the last three axes after the other.
    ///
    /// Returns the position of its numbers in the file; `None` if it is compressed, or if a number is not finite.
    pub(crate) fn pass<T: Clone + Default>(
        &mut self,
        (key, part): (&str, &Part),
        read: fn(&mut dyn Read, &mut [T]) -> io::Result<bool>,
        mut each: impl FnMut(ArrayView2<'_, T>),
    ) -> Result<Option<u64>> {
        let [count, rows, columns] = part.sides();
        let passed = self.within(key, part, |member| {
            let mut own = Array2::default((rows, columns));
            let mut are_finite = true;
            for _ in 0..count {
                for some in own.as_slice_mut().unwrap_or_default().chunks_mut(AT_A_TIME) {
                    are_finite &= read(member, some)?;
                }
                each(own.view());
            }
            Ok(are_finite)
        })?;
        Ok(passed.and_then(|(are_finite, position)| are_finite.then_some(position)))
    }

    /// Checks that there is memory for an array that is stored by columns.
    ///
    /// It is read whole, whatever frames are requested.
    fn check_whole(&mut self, key: &str, claimed: usize) -> Result<()> {
        // What it claims may not be there.
        let member = self.archive.by_name(&format!("{key}.npy"));
        let size = member.map(|member| member.size());
        let size = size.map_err(|e| self.damaged(key, &e))?;
        let claimed = claimed.min(size as usize);
        // Its bytes, too.
        let bytes = claimed.saturating_mul(1 + npy::CONVERSIONS);
        memory::check(bytes, "the array").map_err(|e| {
            self.error(format!(
                "`{key}` is too large: {e}; it is stored in columns (Fortran order) and read whole: in \
                 C order, as numpy.ascontiguousarray or host-sim convert on a larger machine make it, it \
                 is read frame by frame"
            ))
        })
    }

    /// Fills `bytes` from a position in a member.
    ///
    /// A stored member is read there directly; a compressed one is inflated up to there.
    fn read_at(&mut self, key: &str, from: usize, bytes: &mut [u8]) -> Result<()> {
        let name = format!("{key}.npy");
        let mut read = || -> ZipResult<bool> {
            let member = self.archive.by_name(&name)?;
            let limit = member.compressed_size().saturating_mul(MAX_INFLATION);
            if (from + bytes.len()) as u64 > limit.max(SMALL) {
                return Ok(false);
            }
            if member.compression() == CompressionMethod::Stored {
                drop(member);
                let mut member = self.archive.by_name_seek(&name)?;
                member.seek(SeekFrom::Start(from as u64))?;
                member.read_exact(bytes)?;
                return Ok(true);
            }
            let mut member = member;
            io::copy(&mut member.by_ref().take(from as u64), &mut io::sink())?;
            member.read_exact(bytes)?;
            Ok(true)
        };
        match read() {
            Ok(true) => Ok(()),
            Ok(false) => Err(self.inflated(key)),
            Err(e) => Err(self.damaged(key, &e)),
        }
    }
}

/// Fills `numbers` with little-endian f32 in pairs; returns whether all are finite.
pub(crate) fn complex(source: &mut dyn Read, numbers: &mut [Complex<f32>]) -> io::Result<bool> {
    floats(source, bytemuck::cast_slice_mut(numbers))
}

/// Fills `numbers` with little-endian f32; returns whether all are finite.
pub(crate) fn floats(source: &mut dyn Read, numbers: &mut [f32]) -> io::Result<bool> {
    source.read_exact(bytemuck::cast_slice_mut(numbers))?;
    for number in numbers.iter_mut() {
        *number = f32::from_bits(u32::from_le(number.to_bits()));
    }
    Ok(numbers.iter().fold(true, |all, v| all & v.is_finite()))
}

/// Fills `numbers` with little-endian i16.
pub(crate) fn counts(source: &mut dyn Read, numbers: &mut [i16]) -> io::Result<bool> {
    source.read_exact(bytemuck::cast_slice_mut(numbers))?;
    for number in numbers {
        *number = i16::from_le(*number);
    }
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::super::{Spare, Writer};
    use super::*;
    use std::io::Cursor;

    /// Samples of every type that is read without a copy, whatever the spare memory is.
    #[test]
    fn frames_in_spare_memory_are_those_of_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("frames.npz");
        let shape = (5, 2, 3, 7000);
        let at = |(f, t, m, n): (usize, usize, usize, usize)| (f * 7919 + t * 31 + m * 5 + n) % 251;
        let real = Array4::from_shape_fn(shape, |index| at(index) as f32 - 125.5);
        let whole = Array4::from_shape_fn(shape, |index| at(index) as i16 - 125);
        let complex = real.mapv(|re| Complex::new(re, 0.25 - re));
        let mut bytes = Cursor::new(Vec::new());
        let mut npz = Writer::new(&mut bytes, 0);
        npz.add("real", &real).unwrap();
        npz.add("whole", &whole).unwrap();
        npz.add("complex", &complex).unwrap();
        npz.finish().unwrap();
        std::fs::write(&path, bytes.into_inner()).unwrap();
        for spare in [0, 17, 100_000] {
            for frames in [0..1, 1..3, 4..5, 3..9, 0..5] {
                let own = frames.start..frames.end.min(5);
                let mut file = Reader::open(&path).unwrap().with_spare(Spare {
                    real: vec![f32::NAN; spare],
                    counts: vec![i16::MAX; spare],
                    complex: vec![Complex::from(f32::NAN); spare],
                });
                let part = real.slice_axis(Axis(0), own.clone().into());
                let found = file.real_frames("real", "a", frames.clone()).unwrap();
                assert_eq!((found.array.view(), found.held), (part, 5));
                let part = whole.slice_axis(Axis(0), own.clone().into());
                let found = file
                    .count_frames("whole", "a", frames.clone())
                    .unwrap()
                    .unwrap();
                assert_eq!((found.array.view(), found.held), (part, 5));
                assert!(
                    file.count_frames("real", "a", frames.clone())
                        .unwrap()
                        .is_none()
                );
                let part = complex.slice_axis(Axis(0), own.into());
                let found = file.complex_frames("complex", "a", frames).unwrap();
                assert_eq!((found.array.view(), found.held), (part, 5));
            }
        }
    }
}
