//! Phase symmetry of an image, in strips.

use crate::memory::{array, array_mut, one};
use crate::status::{Status, status};
use bonebeam::Complex;
use bonebeam::phase_symmetry::{
    External, Kernels, LogGabor, Microfft, Parameters, PhaseSymmetry, Sizes, StripSlices,
};

/// What phase symmetry is asked for.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct PhaseSymmetryParameters {
    /// Rows of the image: 64, 128, 256, 512 or 1024.
    pub rows: usize,
    /// Columns of the image, likewise.
    pub columns: usize,
    /// How many rows or columns are worked on at a time: memory, never the result.
    pub strip: usize,
    /// The filters' centre frequencies r₀, cycles a pixel.
    pub scales: *const f64,
    /// How many, 1 to 8.
    pub scale_count: usize,
    /// The noise threshold T_n, grey levels.
    pub threshold: f32,
}

/// How many floats of each kind of memory it takes.
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct PhaseSymmetryLengths {
    /// Fast: what a strip reads, what it gives, a line and a filter's gains, all in one array.
    pub fast: usize,
    /// Slow: spectrum, filtered image and the denominator, all in one array.
    pub slow: usize,
    /// The map, as large as the image.
    pub map: usize,
}

fn sizes(parameters: &PhaseSymmetryParameters) -> Sizes {
    Sizes {
        rows: parameters.rows,
        columns: parameters.columns,
        strip: parameters.strip,
    }
}

/// The memory that phase symmetry takes; all 0 where the parameters are null.
///
/// # Safety
/// `parameters` leads to what it says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_phase_symmetry_lengths(
    parameters: *const PhaseSymmetryParameters,
) -> PhaseSymmetryLengths {
    // SAFETY: by the caller's promise.
    match unsafe { one(parameters) } {
        Ok(parameters) => lengths(&sizes(parameters)),
        Err(_) => PhaseSymmetryLengths::default(),
    }
}

fn lengths(sizes: &Sizes) -> PhaseSymmetryLengths {
    let sum = |parts: &[usize]| {
        parts
            .iter()
            .fold(0usize, |sum, &part| sum.saturating_add(part))
    };
    PhaseSymmetryLengths {
        fast: sum(&[
            sizes.strip_len(),
            sizes.sums_len(),
            sizes.line_len().saturating_mul(2),
            sizes.gains_len(),
        ]),
        slow: sum(&[
            sizes.spectrum_len(),
            sizes.filtered_len(),
            sizes.amplitude_len(),
        ]),
        map: sizes.symmetry_len(),
    }
}

/// The map of an image 0 to 255, `[row][column]`: at least 0 and below 1.
///
/// `fast` and `slow` have the lengths of
/// `bonebeam_phase_symmetry_lengths`; their contents are irrelevant.
///
/// # Safety
/// `parameters->scales` leads to `scale_count` numbers; `image` and `map` to
/// rows · columns; `fast` and `slow` to their lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_phase_symmetry(
    parameters: *const PhaseSymmetryParameters,
    image: *const f32,
    fast: *mut f32,
    slow: *mut f32,
    map: *mut f32,
) -> Status {
    status(|| {
        // SAFETY: by the caller's promise.
        let parameters = unsafe { one(parameters)? };
        // SAFETY: by the caller's promise.
        let scales = unsafe { array(parameters.scales, parameters.scale_count)? };
        let sizes = sizes(parameters);
        let bank = PhaseSymmetry::new(&Parameters {
            sizes,
            scales,
            threshold: parameters.threshold,
        })?;
        let lengths = lengths(&sizes);
        // SAFETY: by the caller's promise.
        let (mut image, fast, slow, mut map) = unsafe {
            (
                array(image, sizes.image_len())?,
                array_mut(fast, lengths.fast)?,
                array_mut(slow, lengths.slow)?,
                array_mut(map, lengths.map)?,
            )
        };
        let (strip, fast) = fast.split_at_mut(sizes.strip_len());
        let (sums, fast) = fast.split_at_mut(sizes.sums_len());
        let (line, gains) = fast.split_at_mut(2 * sizes.line_len());
        // SAFETY: as many complex numbers, each of two floats, which are not used besides.
        let line: &mut [Complex<f32>] =
            unsafe { array_mut(line.as_mut_ptr().cast(), sizes.line_len())? };
        let (mut spectrum, slow) = slow.split_at_mut(sizes.spectrum_len());
        let (mut filtered, mut amplitude) = slow.split_at_mut(sizes.filtered_len());
        let kernels = Kernels {
            fft: &Microfft,
            gains: &LogGabor::fixed(),
        };
        let mut external = External {
            image: &mut image,
            spectrum: &mut spectrum,
            filtered: &mut filtered,
            amplitude: &mut amplitude,
            symmetry: &mut map,
        };
        let mut memory = StripSlices {
            strip,
            sums,
            line,
            gains,
        };
        Ok(bank.run(&kernels, &mut external, &mut memory, &mut |_| {})?)
    })
}
