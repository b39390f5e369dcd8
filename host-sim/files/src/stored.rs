//! A frame of samples that stays in its file.

use std::io::{self, Read, Seek, SeekFrom};
use std::path::PathBuf;

use ndarray::Array4;
use num_complex::Complex;
use rayon::prelude::*;

use super::npz::{self, complex, counts, floats};
use super::survey::Survey;
use super::{file_error, input};
use crate::Result;

/// A frame of samples in a file, of which transmits are read when they are needed.
///
/// All of its samples were finite when the file was opened, and some of RF are below 0.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredFrame {
    pub(super) path: PathBuf,
    /// Of its first sample, bytes.
    pub(super) position: u64,
    pub(super) kind: Kind,
    /// [transmit, element, sample].
    pub(super) shape: [usize; 3],
    pub(super) survey: Survey,
}

/// The kind of its samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    /// f32.
    Rf,
    /// i16.
    Counts,
    /// Complex f32, by the demodulation frequency, Hz.
    Iq(f64),
}

impl StoredFrame {
    /// Number of parts in which a frame is read and beamformed.
    pub const WINDOWS: usize = 8;

    /// Numbers of transmits, elements and samples.
    pub(super) fn dim(&self) -> (usize, usize, usize) {
        self.shape.into()
    }

    /// Size in the file.
    pub(super) fn bytes(&self) -> usize {
        let size = match self.kind {
            Kind::Rf => size_of::<f32>(),
            Kind::Counts => size_of::<i16>(),
            Kind::Iq(_) => size_of::<Complex<f32>>(),
        };
        self.shape.iter().product::<usize>() * size
    }

    /// The samples of a large frame of focused transmits, which stay in the file.
    ///
    /// `None` if they have to be read: those that are compressed, or are changed when they are read.
    pub(super) fn of_npz(file: &mut npz::Reader) -> Result<Option<Self>> {
        let key = if file.has("iq") { "iq" } else { "rf" };
        if !(file.has("tx_x") && file.has("rf") != file.has("iq")) {
            return Ok(None);
        }
        let Some(part) = file.large(key)? else {
            return Ok(None);
        };
        let kind = match (key, &*part.header.descr) {
            ("rf", "<f4") => Kind::Rf,
            ("rf", "<i2") => Kind::Counts,
            ("iq", "<c8") => Kind::Iq(file.scalar("f_demod")?),
            _ => return Ok(None),
        };
        let x = file.vector_of_any_length("element_x", "element")?;
        if x.first() > x.last() || matches!(kind, Kind::Iq(f_demod) if f_demod <= 0.0) {
            return Ok(None);
        }
        let (shape, own) = (part.sides(), (key, &part));
        let mut survey = Survey::new([shape[0], shape[1]]);
        let position = match kind {
            Kind::Rf => file.pass(own, floats, |rf| survey.add_rf(rf)),
            Kind::Counts => file.pass(own, counts, |rf| survey.add_rf(rf)),
            Kind::Iq(_) => file.pass(own, complex, |iq| survey.add_iq(iq)),
        };
        let position = position?.filter(|_| survey.is_below_0());
        Ok(position.map(|position| StoredFrame {
            path: file.path().to_path_buf(),
            position,
            kind,
            shape,
            survey,
        }))
    }

    /// Reads some transmits on all threads, [1, transmit, element, sample], into spare memory.
    pub(super) fn array<T: Clone + Default + Send>(
        &self,
        transmits: &[usize],
        spare: &mut Vec<T>,
        read: fn(&mut dyn Read, &mut [T]) -> io::Result<bool>,
    ) -> Result<Array4<T>> {
        let [_, elements, samples] = self.shape;
        let (length, mut numbers) = (elements * samples, std::mem::take(spare));
        numbers.resize(transmits.len() * length, T::default());
        let each = numbers.par_chunks_mut(length).zip(transmits);
        let done = each.try_for_each(|(own, transmit)| {
            let mut file = input::open(&self.path)?;
            let before = transmit * length * size_of::<T>();
            file.seek(SeekFrom::Start(self.position + before as u64))?;
            read(&mut file, own).map(drop)
        });
        let failed = |e| file_error(&self.path, format!("cannot be read: {e}"));
        done.map_err(|e: io::Error| failed(e.to_string()))?;
        let shape = (1, transmits.len(), elements, samples);
        Array4::from_shape_vec(shape, numbers).map_err(|e| failed(e.to_string()))
    }
}
