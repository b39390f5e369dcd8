//! Beamformers: from aligned samples to a line.

use crate::bounds::{F_NUMBER, PITCH};
use crate::image::product;
use crate::memory::{Output, array, bytes_of, complex, new, one, one_mut, possible, sum};
use crate::status::{Refused, Status, chosen, status};
use crate::vectors::V;
use crate::workspace::{workspace, workspace_bytes};
use crate::{Complex, Range};
use bonebeam::beamform::{
    self, AlignedLine, Apodization, Beamformer, Method, Postfilter, Sizes, Workspace,
};
use bonebeam::covariance::Covariance as Core;
use bonebeam::geometry::{self, Aperture, ApertureParameters};
use core::ffi::{CStr, c_char, c_void};

/// The covariance that adaptive methods use.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum Covariance {
    /// Forward-backward averaging: real arithmetic, the faster.
    ForwardBackward = 0,
    /// Forward averaging, unless the library was built without its feature `forward`.
    Forward = 1,
}

/// The parameters of a beamformer.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct BeamformParameters {
    /// Key of the method: "das", "mv", "esmv-rank1" and others.
    ///
    /// docs/numerics.md has the tables of all keys.
    pub method: *const c_char,
    /// Key of the postfilter in the same tables, or null for none.
    ///
    /// For instance "coherence-factor".
    pub postfilter: *const c_char,
    /// Key of the apodization in the same tables, or null for none.
    ///
    /// For instance "hann".
    pub apodization: *const c_char,
    /// Argument of the method, if the tables give one.
    ///
    /// β, a rank, or a number of steps.
    pub argument: f64,
    /// One of `bonebeam_covariance`.
    pub covariance: i32,
    /// Parameters other than their defaults, `count` of them; null for none.
    pub numbers: *const Number,
    /// Number of `numbers`.
    pub count: usize,
    /// Sub-lines of each line of a scan: 1, 2, 4, 8, 16 or 32; 0 is 1.
    ///
    /// Sub-lines are directions within the line's cell that share its covariance. More than 1 need the library's
    /// feature `sub-lines`, and work only in frames and lines of scans. For I/Q their phases are those of the
    /// demodulation frequency.
    pub sub_lines: usize,
}

/// A parameter by its name in the tables of docs/numerics.md.
///
/// For instance "temporal_half_window", "diagonal_loading" or "subaperture_ratio". If a name occurs several times, the
/// last value counts.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Number {
    /// The name.
    pub name: *const c_char,
    /// The value.
    pub value: f64,
}

impl BeamformParameters {
    /// The core's parameters.
    ///
    /// # Safety
    /// Keys and names are strings that end with a zero, and there are `count` numbers.
    pub(crate) unsafe fn core(&self) -> Result<beamform::Parameters, Refused> {
        // SAFETY: by the caller's promise.
        let (method, postfilter, apodization, numbers) = unsafe {
            (
                choice("method", self.method, Method::EXAMPLES, Method::key)?,
                match self.postfilter.is_null() {
                    true => Postfilter::None,
                    false => choice(
                        "postfilter",
                        self.postfilter,
                        Postfilter::EXAMPLES,
                        Postfilter::key,
                    )?,
                },
                match self.apodization.is_null() {
                    true => Apodization::None,
                    false => choice(
                        "apodization",
                        self.apodization,
                        Apodization::EXAMPLES,
                        Apodization::key,
                    )?,
                },
                match self.count {
                    0 => &[],
                    count => array(self.numbers, count)?,
                },
            )
        };
        if let Some(row) = method.parameter() {
            row.check(self.argument)?;
        }
        let mut parameters = beamform::Parameters {
            method: method.with_argument(self.argument),
            covariance: chosen(
                "covariance",
                self.covariance,
                &[Core::ForwardBackward, Core::Forward],
            )?,
            postfilter,
            apodization,
            sub_lines: self.sub_lines.max(1),
            ..beamform::Parameters::DEFAULT
        };
        for number in numbers {
            // SAFETY: by the caller's promise.
            let row = unsafe {
                choice("numbers", number.name, beamform::Parameters::TABLE, |row| {
                    row.name
                })?
            };
            row.check(number.value)?;
            parameters.set(row.name, number.value);
        }
        Ok(parameters)
    }

    /// The beamformer, and the sizes of a workspace for up to `elements` active elements.
    ///
    /// # Safety
    /// As [`BeamformParameters::core`].
    unsafe fn plan(&self, elements: usize) -> Result<(Beamformer, Sizes), Refused> {
        // SAFETY: by the caller's promise.
        let beamformer = Beamformer::new(unsafe { self.core()? })?;
        // Directions belong to a scan.
        if self.sub_lines > 1 {
            let expected = "1: directions belong to a scan";
            return Err(Refused::field("sub_lines", self.sub_lines as f64, expected));
        }
        Ok((beamformer, beamformer.sizes(elements)))
    }
}

/// The row of a table whose key is `text`.
///
/// # Safety
/// If `text` is not null, it is a string that ends with a zero.
unsafe fn choice<T>(
    name: &'static str,
    text: *const c_char,
    rows: impl IntoIterator<Item = T>,
    key: fn(&T) -> &'static str,
) -> Result<T, Refused> {
    // SAFETY: by the caller's promise.
    let text = unsafe { CStr::from_ptr(one(text)?) };
    let row = rows
        .into_iter()
        .find(|row| key(row).as_bytes() == text.to_bytes());
    row.ok_or(Refused::field(
        name,
        0.0,
        "a name of the tables of docs/numerics.md",
    ))
}

/// An aperture that grows with depth.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ApertureShape {
    /// Elements of the array.
    pub elements: usize,
    /// Distance of neighbouring elements, m.
    pub pitch: f64,
    /// F-number: depth divided by the width of the aperture.
    pub f_number: f64,
    /// Minimum number of active elements; fewer at the ends of the array.
    pub min_elements: usize,
}

impl ApertureShape {
    pub(crate) fn check(&self) -> Result<(), Refused> {
        PITCH.check("pitch", self.pitch)?;
        F_NUMBER.check("f_number", self.f_number)
    }
}

/// Computes the active elements at each of `count` depths, m.
///
/// `beam` is the lateral position, in pitches from element 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_active_elements(
    aperture: *const ApertureShape,
    beam: f64,
    depths: *const f64,
    count: usize,
    active: *mut Range,
) -> Status {
    // SAFETY: by the caller's promise.
    status(|| unsafe {
        let (shape, active) = (one(aperture)?, Output::new(active, count)?);
        let depths = active.apart(array(depths, count)?)?;
        shape.check()?;
        let aperture = Aperture::new(ApertureParameters {
            elements: shape.elements,
            pitch: shape.pitch,
            f_number: shape.f_number,
            min_elements: shape.min_elements,
        })?;
        for (active, &depth) in active.values().iter_mut().zip(depths) {
            let geometry::Active { first, count } = aperture.active(beam, depth);
            *active = Range { first, count };
        }
        Ok(())
    })
}

/// A beamformer of aligned samples.
pub struct BeamformerObject {
    beamformer: Beamformer,
    workspace: Workspace<'static, V>,
}

/// Returns the bytes of a beamformer for up to `elements` active elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_beamformer_bytes(
    parameters: *const BeamformParameters,
    elements: usize,
) -> usize {
    // SAFETY: by the caller's promise.
    let bytes = || unsafe {
        let (_, sizes) = one(parameters)?.plan(elements)?;
        let workspace = workspace_bytes(sizes.need());
        possible(sum(&[bytes_of::<BeamformerObject>(1), workspace]))
    };
    bytes().unwrap_or(0)
}

/// Places a beamformer in `memory`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_beamformer_new(
    memory: *mut c_void,
    bytes: usize,
    parameters: *const BeamformParameters,
    elements: usize,
    beamformer: *mut *mut BeamformerObject,
) -> Status {
    // SAFETY: by the caller's promise.
    unsafe {
        new(memory, bytes, beamformer, |bytes| {
            let (beamformer, sizes) = one(parameters)?.plan(elements)?;
            Ok(BeamformerObject {
                beamformer,
                workspace: workspace(bytes, sizes)?,
            })
        })
    }
}

/// Beamforms a line: `z[n]` from aligned samples.
///
/// Sample n is `x[n·elements]` to `x[n·elements + elements - 1]`, of which `active[n]` are used. `z` has the scale of
/// `x`. With a `depth_step` of s, `z[i]` is sample `n = i·s`, and `z` has `samples/s` numbers, rounded up.
///
/// `adaptive`: a depth gate. Samples outside are DAS, and may have more active elements than the beamformer was made
/// for. Null: all samples are adaptive.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_beamformer_line(
    beamformer: *mut BeamformerObject,
    x: *const Complex,
    samples: usize,
    elements: usize,
    active: *const Range,
    adaptive: *const Range,
    z: *mut Complex,
) -> Status {
    let mut done = 0;
    let aligned = Range {
        first: 0,
        count: samples,
    };
    // SAFETY: by the caller's promise.
    unsafe {
        bonebeam_beamformer_partial_line(
            beamformer, x, aligned, samples, elements, 0.0, active, adaptive, &mut done, z,
        )
    }
}

/// Beamforms the samples of a line that are aligned so far.
///
/// The bits are those of `bonebeam_beamformer_line` for the whole line of `samples` samples. `x` has only the samples
/// `aligned`: sample n begins at `x[(n - aligned.first)·elements]`. `largest` is the largest magnitude of a real or
/// imaginary part of the whole line, which sets its working scale. With 0 it is that of `x`: bits may then differ for
/// samples 300 dB below it. `active` and `z` are those of the whole line.
/// Output is written to `z` from sample `*done` on, and `*done` becomes the first sample without output. Set `*done` to
/// 0 before the first call. With a `temporal_half_window` of K, `aligned` begins K samples before `*done` or earlier,
/// and a call leaves up to 3·K aligned samples for the next. In the last call, `aligned` ends with the line.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_beamformer_partial_line(
    beamformer: *mut BeamformerObject,
    x: *const Complex,
    aligned: Range,
    samples: usize,
    elements: usize,
    largest: f32,
    active: *const Range,
    adaptive: *const Range,
    done: *mut usize,
    z: *mut Complex,
) -> Status {
    // SAFETY: by the caller's promise.
    status(|| unsafe {
        let length = product(aligned.count, elements)?;
        let BeamformerObject {
            beamformer: by,
            workspace,
        } = one_mut(beamformer)?;
        let z = Output::complex(z, by.line_samples(samples))?;
        let x = AlignedLine::new(z.apart(complex(x, length)?)?, elements)?;
        let x = x.of_line(aligned.first, samples)?.of_largest(largest)?;
        let active = z.apart(array(active, samples)?)?;
        let none = geometry::Active::new(0, 0);
        let active = |n: usize| active.get(n).map_or(none, Range::active);
        let adaptive = match adaptive.is_null() {
            true => 0..samples,
            false => one(adaptive)?.samples(),
        };
        let (done, z) = (one_mut(done)?, z.values());
        *done = by.partial_line(workspace, x, *done, (active, adaptive), z)?;
        Ok(())
    })
}
