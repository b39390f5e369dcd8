//! The numbers of a dataset: real ones, samples, and parts of them.

use ndarray::ArrayD;
use num_complex::Complex;
use rust_hdf5::{Complex32, Complex64, H5Dataset, Hdf5Error, ReadNumeric};

use super::Store;
use super::kind::{Kind, Part, damaged, kind};
use crate::guard::{ReadResult, claim, claim_in_memory};
use crate::values::{AxisRange, NamedArrays, Values, array};

impl Store {
    /// Plans to read a dataset: its shape in the file's order, and its type.
    ///
    /// Checks that the memory has room for it.
    fn plan(&self, dataset: &H5Dataset, part: Option<AxisRange>) -> ReadResult<(Slice, Kind)> {
        if dataset.is_null() {
            return Err("is empty".into());
        }
        let whole = dataset.shape();
        let element = dataset.element_size();
        claim(&whole, element, self.length)?;
        let mut slice = Slice {
            start: vec![0; whole.len()],
            shape: whole.clone(),
            is_whole: true,
        };
        if let Some((axis, range)) = part {
            let axis = if self.matlab {
                whole.len() - 1 - axis
            } else {
                axis
            };
            let end = range.end.min(whole[axis]);
            slice.start[axis] = range.start.min(end);
            slice.shape[axis] = end - slice.start[axis];
            slice.is_whole = slice.shape == whole;
        }
        claim_in_memory(&slice.shape, element, self.length)?;
        if let Some(chunk) = dataset.chunk_dims() {
            claim_in_memory(&chunk, element, self.length)?;
        }
        let kind = kind(&dataset.datatype().map_err(|e| damaged(&e))?)?;
        Ok((slice, kind))
    }

    /// The values in the order of axes that users see.
    fn ordered<T: Clone>(&self, shape: &[usize], values: Vec<T>) -> ReadResult<ArrayD<T>> {
        let values = array(shape, values)?;
        Ok(match self.matlab {
            true => values.reversed_axes().as_standard_layout().into_owned(),
            false => values,
        })
    }

    pub(super) fn read_numbers(&self, name: &str) -> ReadResult<ArrayD<f64>> {
        self.read.note(name);
        let dataset = self.dataset(name)?;
        let (slice, kind) = self.plan(&dataset, None)?;
        let values = match kind {
            Kind::Single | Kind::Double => dataset.read_numeric_as::<f64>(),
            Kind::Unsigned8 | Kind::Short | Kind::Long => dataset
                .read_numeric_as::<i64>()
                .map(|values| values.into_iter().map(|v| v as f64).collect()),
            Kind::Flags => dataset
                .read_raw_bytes()
                .map(|bytes| bytes.into_iter().map(f64::from).collect()),
            Kind::Complex { .. } => return Err("is complex; expected real numbers".into()),
        };
        self.ordered(&slice.shape, values.map_err(|e| damaged(&e))?)
    }

    /// Whether complex numbers are two arrays, as in MATLAB's UFF and PICMUS.
    pub(super) fn is_in_two(&self, name: &str) -> bool {
        !self.has(name) && self.has_group(name)
    }

    pub(super) fn read_samples(&self, name: &str, part: Option<AxisRange>) -> ReadResult<Values> {
        if self.is_in_two(name) {
            let half =
                |half: &str| match self.read_samples(&format!("{name}/{half}"), part.clone())? {
                    Values::Real(values) => Ok(values),
                    Values::Complex(_) => Err(format!("has a complex part `{half}`")),
                };
            let (real, imaginary) = (half("real")?, half("imag")?);
            if real.shape() != imaginary.shape() {
                return Err("has a real and an imaginary part of different shapes".into());
            }
            let both = real.iter().zip(&imaginary);
            let values = both.map(|(&re, &im)| Complex::new(re, im)).collect();
            return Ok(Values::Complex(array(real.shape(), values)?));
        }
        self.read.note(name);
        let dataset = self.dataset(name)?;
        let (slice, kind) = self.plan(&dataset, part)?;
        let shape = &slice.shape;
        let failed = |e: Hdf5Error| damaged(&e);
        let real = match kind {
            Kind::Single => slice.read::<f32>(&dataset).map_err(failed)?,
            Kind::Double => {
                let wide = slice.read::<f64>(&dataset).map_err(failed)?;
                wide.into_iter().map(|v| v as f32).collect()
            }
            Kind::Unsigned8 => {
                let bytes = slice.read::<u8>(&dataset).map_err(failed)?;
                bytes.into_iter().map(|v| f32::from(v) - 128.0).collect()
            }
            Kind::Short => {
                let short = slice.read::<i32>(&dataset).map_err(failed)?;
                short.into_iter().map(|v| v as f32).collect()
            }
            Kind::Long => {
                let long = slice.read::<i64>(&dataset).map_err(failed)?;
                long.into_iter().map(|v| v as f32).collect()
            }
            Kind::Flags => return Err("has truth values; expected samples".into()),
            Kind::Complex {
                part: Part { bytes: 4, .. },
                ..
            } if !slice.is_whole => {
                let read = dataset.read_slice::<Complex32>(&slice.start, shape);
                let values = read.map_err(failed)?.into_iter();
                let values = values.map(|z| Complex::new(z.re, z.im)).collect();
                return Ok(Values::Complex(self.ordered(shape, values)?));
            }
            Kind::Complex { .. } if !slice.is_whole => {
                let read = dataset.read_slice::<Complex64>(&slice.start, shape);
                let values = read.map_err(failed)?.into_iter();
                let values = values.map(|z| Complex::new(z.re as f32, z.im as f32));
                return Ok(Values::Complex(self.ordered(shape, values.collect())?));
            }
            Kind::Complex {
                part,
                real,
                imaginary,
                size,
            } => {
                let raw = dataset.read_raw_bytes().map_err(failed)?;
                let part = |element: &[u8], at: usize| part.value(&element[at..at + part.bytes]);
                let values = raw
                    .chunks_exact(size)
                    .map(|e| Complex::new(part(e, real), part(e, imaginary)));
                return Ok(Values::Complex(self.ordered(shape, values.collect())?));
            }
        };
        Ok(Values::Real(self.ordered(shape, real)?))
    }

    /// The shape for [`NamedArrays::shape_for_parts`].
    pub(super) fn shape_of_parts(&self, name: &str) -> ReadResult<Option<Vec<usize>>> {
        if self.is_in_two(name) {
            return self.shape_of_parts(&format!("{name}/real"));
        }
        let dataset = self.dataset(name)?;
        let kind = kind(&dataset.datatype().map_err(|e| damaged(&e))?)?;
        let mut shape = dataset.shape();
        if self.matlab {
            shape.reverse();
        }
        // rust-hdf5 reads parts of pairs of numbers, and of no other compounds.
        let is_pair = match kind {
            Kind::Complex {
                part,
                real,
                imaginary,
                size,
            } => part.is_plain() && (real, imaginary, size) == (0, part.bytes, 2 * part.bytes),
            _ => true,
        };
        Ok((is_pair && !dataset.is_null()).then_some(shape))
    }
}

/// A part of a dataset, or all of it.
struct Slice {
    start: Vec<usize>,
    shape: Vec<usize>,
    is_whole: bool,
}

impl Slice {
    fn read<T: ReadNumeric>(&self, dataset: &H5Dataset) -> rust_hdf5::Result<Vec<T>> {
        match self.is_whole {
            true => dataset.read_numeric_as(),
            false => dataset.read_numeric_slice_as(&self.start, &self.shape),
        }
    }
}
