//! Memory of a thread for the core's beamformer, for sizes known at run time.

use bonebeam::beamform::Sizes;
use bonebeam::dispatch;
use bonebeam::prelude::stages::*;
use num_complex::Complex;

use crate::{Error, Result};

/// Most memory of a thread, bytes; more is a mistake.
const MOST: usize = 1 << 30;

/// Memory over the lanes of `V`, on the heap.
pub struct Memory<V> {
    zero: V,
    sizes: Sizes,
    real: Vec<V>,
    complex: Vec<Complex<V>>,
}

impl<V: Vector> Memory<V> {
    /// Allocates memory for shapes of up to `sizes`, over the lanes of `zero`.
    ///
    /// # Errors
    /// [`Error::Usage`] if that is more than 1 GiB, or more than the machine has.
    pub fn new(zero: V, sizes: Sizes) -> Result<Self> {
        let need = sizes.need();
        let real = need.real.saturating_mul(size_of::<V>());
        let bytes = real.saturating_add(need.complex.saturating_mul(size_of::<Complex<V>>()));
        if bytes > MOST {
            return Err(too_much(sizes, bytes));
        }
        let no_room = |_| too_much(sizes, bytes);
        Ok(Memory {
            zero,
            sizes,
            real: filled(zero, need.real).map_err(no_room)?,
            complex: filled(Complex::new(zero, zero), need.complex).map_err(no_room)?,
        })
    }

    /// The workspace for the core.
    pub fn view(&mut self) -> Workspace<'_, V> {
        let scratch = Scratch::new(&mut self.real, &mut self.complex);
        Workspace::new(self.zero, self.sizes, scratch).expect("memory of the length needed")
    }
}

fn filled<T: Copy>(
    value: T,
    length: usize,
) -> std::result::Result<Vec<T>, std::collections::TryReserveError> {
    let mut values = Vec::new();
    values.try_reserve_exact(length)?;
    values.resize(length, value);
    Ok(values)
}

fn too_much(sizes: Sizes, bytes: usize) -> Error {
    Error::Usage(format!(
        "temporal_half_window (K) {} and a subaperture of {} elements need {} MB per thread, more than \
         is available or allowed (at most {} MB); give a smaller K or subaperture_ratio",
        sizes.temporal_half_window,
        sizes.subaperture,
        bytes >> 20,
        MOST >> 20
    ))
}

/// A [`Memory`] whose lanes are chosen at run time.
pub trait AnyMemory: Send {
    /// Number of segments processed at a time.
    fn lanes(&self) -> usize;

    /// See [`Beamformer::segments`].
    fn segments(
        &mut self,
        beamformer: &Beamformer,
        segments: &[Segment<'_>],
        count: usize,
        z: &mut [&mut [Complex<f32>]],
    ) -> std::result::Result<(), bonebeam::Error>;

    /// See [`Beamformer::sub_line_segments`].
    fn sub_lines(
        &mut self,
        beamformer: &Beamformer,
        lines: SteeredSegments<'_, '_>,
        count: usize,
        z: &mut [&mut [Complex<f32>]],
    ) -> std::result::Result<(), bonebeam::Error>;

    /// See [`Beamformer::eigenvalue_shares`].
    fn eigenvalue_shares(
        &mut self,
        beamformer: &Beamformer,
        line: AlignedLine<'_>,
        active: &dyn Fn(usize) -> Active,
        shares: &mut [f32],
    ) -> std::result::Result<(), bonebeam::Error>;
}

impl<V: Vector> AnyMemory for Memory<V> {
    fn lanes(&self) -> usize {
        V::LANES
    }

    fn segments(
        &mut self,
        beamformer: &Beamformer,
        segments: &[Segment<'_>],
        count: usize,
        z: &mut [&mut [Complex<f32>]],
    ) -> std::result::Result<(), bonebeam::Error> {
        beamformer.segments(&mut self.view(), segments, count, z)
    }

    fn sub_lines(
        &mut self,
        beamformer: &Beamformer,
        lines: SteeredSegments<'_, '_>,
        count: usize,
        z: &mut [&mut [Complex<f32>]],
    ) -> std::result::Result<(), bonebeam::Error> {
        beamformer.sub_line_segments(&mut self.view(), lines, count, z)
    }

    fn eigenvalue_shares(
        &mut self,
        beamformer: &Beamformer,
        line: AlignedLine<'_>,
        active: &dyn Fn(usize) -> Active,
        shares: &mut [f32],
    ) -> std::result::Result<(), bonebeam::Error> {
        beamformer.eigenvalue_shares(&mut self.view(), line, active, shares)
    }
}

/// A memory for `sizes`, over the lanes of `set`.
///
/// # Errors
/// As [`Memory::new`].
pub fn memory(set: InstructionSet, sizes: Sizes) -> Result<Box<dyn AnyMemory>> {
    Ok(dispatch!(set, zero => Box::new(Memory::new(zero, sizes)?)))
}
