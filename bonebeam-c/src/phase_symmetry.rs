//! Phase symmetry of an image, in strips.

use crate::bounds::THRESHOLD;
use crate::memory::{Bytes, Output, array, bytes_of, new, one, one_mut, sum};
use crate::status::{Refused, Status, status};
use crate::workspace::{need_bytes, scratch};
use bonebeam::phase_symmetry::{
    External, Kernels, LogGabor, Microfft, Parameters, PhaseSymmetry, Sizes, StripSlices,
};
use core::ffi::c_void;

/// The parameters of phase symmetry.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct PhaseSymmetryParameters {
    /// Rows of the image: 64, 128, 256, 512 or 1024.
    pub rows: usize,
    /// Columns of the image: 64, 128, 256, 512 or 1024.
    pub columns: usize,
    /// Number of rows or columns that are transformed at a time.
    ///
    /// It changes memory and time, never the map.
    pub strip: usize,
    /// Centre frequencies r₀ of the filters, cycles per pixel.
    pub scales: *const f64,
    /// Number of scales, 1 to 8.
    pub scale_count: usize,
    /// Noise threshold T_n, grey levels.
    pub threshold: f32,
}

impl PhaseSymmetryParameters {
    pub(crate) fn sizes(&self) -> Sizes {
        Sizes::new(self.rows, self.columns, self.strip)
    }

    /// The core's parameters.
    ///
    /// # Safety
    /// As [`array`], for the scales.
    pub(crate) unsafe fn core<'a>(&self) -> Result<Parameters<'a>, Refused> {
        THRESHOLD.check("threshold", self.threshold.into())?;
        Ok(Parameters {
            sizes: self.sizes(),
            // SAFETY: by the caller's promise.
            scales: unsafe { array(self.scales, self.scale_count)? },
            threshold: self.threshold,
        })
    }
}

/// Phase symmetry of images of one size.
pub struct PhaseSymmetryObject {
    bank: PhaseSymmetry,
    strip: StripSlices<'static, f32>,
    spectrum: &'static mut [f32],
    filtered: &'static mut [f32],
    amplitude: &'static mut [f32],
}

/// Returns the bytes of fast memory for phase symmetry; they grow with the strip.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_phase_symmetry_bytes(
    parameters: *const PhaseSymmetryParameters,
) -> usize {
    // SAFETY: by the caller's promise.
    unsafe { one(parameters) }.map_or(0, |parameters| {
        let sizes = parameters.sizes();
        sum(&[bytes_of::<PhaseSymmetryObject>(1), need_bytes(sizes.need())])
    })
}

/// Returns the bytes of slow memory for phase symmetry.
///
/// They grow with the image.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_phase_symmetry_slow_bytes(
    parameters: *const PhaseSymmetryParameters,
) -> usize {
    // SAFETY: by the caller's promise.
    unsafe { one(parameters) }.map_or(0, |parameters| {
        let sizes = parameters.sizes();
        sum(&[
            bytes_of::<f32>(sizes.spectrum_len()),
            bytes_of::<f32>(sizes.filtered_len()),
            bytes_of::<f32>(sizes.amplitude_len()),
        ])
    })
}

/// Places phase symmetry in `memory` and `slow`.
///
/// The array of scales is not used after the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_phase_symmetry_new(
    memory: *mut c_void,
    bytes: usize,
    slow: *mut c_void,
    slow_bytes: usize,
    parameters: *const PhaseSymmetryParameters,
    phase_symmetry: *mut *mut PhaseSymmetryObject,
) -> Status {
    // SAFETY: by the caller's promise.
    unsafe {
        new(memory, bytes, phase_symmetry, |fast| {
            let mut slow = Bytes::new(slow, slow_bytes)?;
            let parameters = one(parameters)?;
            let sizes = parameters.sizes();
            Ok(PhaseSymmetryObject {
                bank: PhaseSymmetry::new(&parameters.core()?)?,
                strip: StripSlices::new(sizes, scratch(fast, sizes.need())?)?,
                spectrum: slow.fill(sizes.spectrum_len(), 0.0)?,
                filtered: slow.fill(sizes.filtered_len(), 0.0)?,
                amplitude: slow.fill(sizes.amplitude_len(), 0.0)?,
            })
        })
    }
}

/// Computes the map of an image of grey levels 0 to 255.
///
/// The map is at least 0 and below 1. Image and map are `[row][column]`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_phase_symmetry_map(
    phase_symmetry: *mut PhaseSymmetryObject,
    image: *const f32,
    map: *mut f32,
) -> Status {
    // SAFETY: by the caller's promise.
    status(|| unsafe {
        let own = one_mut(phase_symmetry)?;
        let pixels = own.bank.sizes().image_len();
        let map = Output::new(map, pixels)?;
        let mut image = map.apart(array(image, pixels)?)?;
        let mut map = map.values();
        let kernels = Kernels {
            fft: &Microfft,
            gains: &LogGabor::fixed(),
        };
        let mut external = External {
            image: &mut image,
            spectrum: &mut own.spectrum,
            filtered: &mut own.filtered,
            amplitude: &mut own.amplitude,
            symmetry: &mut map,
        };
        let strip = &mut own.strip;
        Ok(own.bank.run(&kernels, &mut external, strip, &mut |_| {})?)
    })
}
