//! The beamformers, of the usual sizes.

use crate::iq_lines::{self, IqLines, IqWave, LineMemory};
use crate::memory::{array, array_mut, one, one_mut, place};
use crate::status::{Status, status};
use crate::{Active, Complex};
use bonebeam::beamform::{self, AlignedLine, Beamformer, Workspace};
use bonebeam::covariance::{Forward, ForwardBackward};
use bonebeam::geometry::{Aperture, ApertureParameters};
use core::ffi::c_void;

/// A beamformer's name.
#[repr(i32)]
#[derive(Clone, Copy)]
pub enum Method {
    /// Delay and sum.
    Das = 0,
    /// Minimum variance.
    Mv = 1,
    /// Eigenspace MV, its rank by `beta`.
    EsmvBeta = 2,
    /// Eigenspace MV of the rank `rank`.
    EsmvRank = 3,
    /// Eigenspace MV of rank 1.
    EsmvRank1 = 4,
    /// Eigenspace MV with all eigenvectors but the first.
    EsmvExcludeFirst = 5,
    /// Eigenspace MV of rank 1, its eigenvector by `steps` of power iteration, in constant time.
    EsmvRank1Steps = 6,
}

/// What a beamformer is asked for.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct BeamformParameters {
    /// One of `bonebeam_method`, as a number: any other is refused.
    pub method: i32,
    /// Of `ESMV_BETA`, above 0 and at most 1.
    pub beta: f32,
    /// Of `ESMV_RANK`, at least 1.
    pub rank: usize,
    /// Of `ESMV_RANK1_STEPS`, 1 to 64.
    pub steps: usize,
    /// `K`: the covariance is averaged over `2K + 1` samples.
    pub temporal_half_window: usize,
    /// `Δ`, 0.05 for instance.
    pub diagonal_loading: f32,
    /// The subaperture's share of the active elements, 0.5 for instance.
    pub subaperture_ratio: f64,
}

impl BeamformParameters {
    pub(crate) fn core(&self) -> Result<beamform::Parameters, Status> {
        const METHODS: [Method; 7] = [
            Method::Das,
            Method::Mv,
            Method::EsmvBeta,
            Method::EsmvRank,
            Method::EsmvRank1,
            Method::EsmvExcludeFirst,
            Method::EsmvRank1Steps,
        ];
        let known = METHODS.iter().find(|&&method| method as i32 == self.method);
        let method = match known.ok_or(Status::Parameter)? {
            Method::Das => beamform::Method::Das,
            Method::Mv => beamform::Method::Mv,
            Method::EsmvBeta => beamform::Method::EsmvBeta(self.beta),
            Method::EsmvRank => beamform::Method::EsmvRank(self.rank),
            Method::EsmvRank1 => beamform::Method::EsmvRank1,
            Method::EsmvExcludeFirst => beamform::Method::EsmvExcludeFirst,
            Method::EsmvRank1Steps => beamform::Method::EsmvRank1Steps(self.steps),
        };
        Ok(beamform::Parameters {
            method,
            temporal_half_window: self.temporal_half_window,
            diagonal_loading: self.diagonal_loading,
            subaperture_ratio: self.subaperture_ratio,
        })
    }
}

/// An aperture that grows with depth.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ApertureShape {
    /// Elements of the array.
    pub elements: usize,
    /// From one element to the next, m.
    pub pitch: f64,
    /// Depth over width.
    pub f_number: f64,
    /// Active at the least.
    pub min_elements: usize,
}

/// The active elements at each of `count` depths, m, below the place `beam`, in pitches from element 0.
///
/// # Safety
/// `aperture` leads to what it says, `depths` and `active` to `count` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_active_elements(
    aperture: *const ApertureShape,
    beam: f64,
    depths: *const f64,
    count: usize,
    active: *mut Active,
) -> Status {
    status(|| {
        // SAFETY: by the caller's promise.
        let (shape, depths) = unsafe { (one(aperture)?, array(depths, count)?) };
        // SAFETY: by the caller's promise.
        let active = unsafe { array_mut(active, count)? };
        let aperture = Aperture::new(ApertureParameters {
            elements: shape.elements,
            pitch: shape.pitch,
            f_number: shape.f_number,
            min_elements: shape.min_elements,
        })?;
        for (active, &depth) in active.iter_mut().zip(depths) {
            let set = aperture.active(beam, depth);
            *active = Active {
                first: set.first,
                count: set.count,
            };
        }
        Ok(())
    })
}

/// Samples of a line: from `first` on, up to `end`, which is not one of them.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Samples {
    /// The first.
    pub first: usize,
    /// The one after the last.
    pub end: usize,
}

/// What every size's line does, all of it or that within `adaptive`.
///
/// # Safety
/// `x` leads to `samples × elements` numbers, `active` to `samples`, `z` to `samples`.
unsafe fn line<A: bonebeam::covariance::Averaging<f32>>(
    beamformer: &Beamformer,
    workspace: &mut beamform::WorkspaceView<'_, A>,
    x: *const Complex,
    (samples, elements): (usize, usize),
    active: *const Active,
    adaptive: Option<&Samples>,
    z: *mut Complex,
) -> Result<(), Status> {
    let length = samples.checked_mul(elements).ok_or(Status::Length)?;
    // SAFETY: by the caller's promise. The core's complex number is two floats as well.
    let (x, z): (&[bonebeam::Complex<f32>], &mut [bonebeam::Complex<f32>]) =
        unsafe { (array(x.cast(), length)?, array_mut(z.cast(), samples)?) };
    // SAFETY: by the caller's promise.
    let active = unsafe { array(active, samples)? };
    let active = |n: usize| {
        let active = active
            .get(n)
            .copied()
            .unwrap_or(Active { first: 0, count: 0 });
        bonebeam::geometry::Active {
            first: active.first,
            count: active.count,
        }
    };
    let x = AlignedLine::new(x, elements)?;
    match adaptive {
        None => beamformer.line(workspace, x, active, z)?,
        Some(&Samples { first, end }) => {
            beamformer.line_within(workspace, x, active, first..end, z)?;
        }
    }
    Ok(())
}

/// A beamformer of a size: its opaque type, the constants of its storage, and its functions.
macro_rules! beamformer {
    (
        $type:ident, $covariance:ty, $elements:literal, $subaperture:literal, $half_window:literal,
        $size:ident = $bytes:literal, $align:ident, $init:ident, $line:ident, $line_within:ident,
        $iq_line:ident
    ) => {
        #[doc = concat!(
            " A beamformer for up to ", $elements, " active elements, subapertures of up to ", $subaperture,
            " and time windows of up to 2·", $half_window, " + 1 samples."
        )]
        pub struct $type {
            beamformer: Beamformer,
            workspace: Workspace<$elements, $subaperture, $half_window, $covariance>,
        }

        /// Bytes of its storage.
        pub const $size: usize = $bytes;
        /// Alignment of its storage, bytes.
        pub const $align: usize = 8;

        const _: () = assert!(size_of::<$type>() <= $size && align_of::<$type>() <= $align);

        /// Sets a beamformer up in storage of the caller's, which it lives in from then on.
        ///
        /// `*beamformer` becomes the pointer to use. Refuses parameters outside their ranges, and
        /// storage that is too small or not aligned.
        ///
        /// # Safety
        /// `storage` leads to so many `bytes`; `parameters` and `beamformer` lead to what they say.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $init(
            storage: *mut c_void,
            bytes: usize,
            parameters: *const BeamformParameters,
            beamformer: *mut *mut $type,
        ) -> Status {
            status(|| {
                // SAFETY: by the caller's promise.
                let (parameters, out) = unsafe { (one(parameters)?, one_mut(beamformer)?) };
                let place: *mut $type = place(storage, bytes)?;
                let checked = Beamformer::new(parameters.core()?)?;
                // SAFETY: the place is large enough and aligned. A workspace is made of floats, so that
                // zeros, which a new one has, are one.
                unsafe {
                    (&raw mut (*place).workspace).write_bytes(0, 1);
                    (&raw mut (*place).beamformer).write(checked);
                }
                *out = place;
                Ok(())
            })
        }

        /// Beamforms one beam: `z[n]` from `x[n·elements..]`, aligned analytic samples, with the elements
        /// `active[n]`.
        ///
        /// Refuses a sample that is not finite, and active elements beyond the array or the
        /// beamformer's size. The scale is that of the input.
        ///
        /// # Safety
        /// `beamformer` is from its init; `x` leads to `samples · elements` numbers, `active` and `z` to
        /// `samples`.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $line(
            beamformer: *mut $type,
            x: *const Complex,
            samples: usize,
            elements: usize,
            active: *const Active,
            z: *mut Complex,
        ) -> Status {
            status(|| {
                // SAFETY: by the caller's promise.
                let own = unsafe { one_mut(beamformer)? };
                let workspace = &mut own.workspace.view();
                // SAFETY: by the caller's promise.
                unsafe { line(&own.beamformer, workspace, x, (samples, elements), active, None, z) }
            })
        }

        /// The same within a depth gate: the samples `adaptive` by the beamformer's method, with the bits of the
        /// whole line, and the others by DAS. Only the active elements within need be as few as the
        /// beamformer's size.
        ///
        /// # Safety
        /// As for a whole line; `adaptive` leads to what it says.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $line_within(
            beamformer: *mut $type,
            x: *const Complex,
            samples: usize,
            elements: usize,
            active: *const Active,
            adaptive: *const Samples,
            z: *mut Complex,
        ) -> Status {
            status(|| {
                // SAFETY: by the caller's promise.
                let (own, gate) = unsafe { (one_mut(beamformer)?, Some(one(adaptive)?)) };
                let workspace = &mut own.workspace.view();
                // SAFETY: by the caller's promise.
                unsafe { line(&own.beamformer, workspace, x, (samples, elements), active, gate, z) }
            })
        }

        /// Line `index` of a scan of I/Q, the mean over `count` transmits, by the beamformer that `lines` was set up
        /// with: of this one it takes the memory only. `z` gets as many samples as `bonebeam_iq_lines_lengths`
        /// says, and may be changed in part where something is refused.
        ///
        /// # Safety
        /// `beamformer` and `lines` are from their inits; `waves` leads to `count`, their counts to as many as the
        /// scan has; `memory` to its lengths, `z` to the line's samples.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $iq_line(
            beamformer: *mut $type,
            lines: *const IqLines,
            index: usize,
            waves: *const IqWave,
            count: usize,
            memory: *const LineMemory,
            z: *mut Complex,
        ) -> Status {
            status(|| {
                // SAFETY: by the caller's promise.
                let own = unsafe { one_mut(beamformer)? };
                let workspace = &mut own.workspace.view();
                // SAFETY: by the caller's promise.
                unsafe { iq_lines::line(workspace, lines, index, (waves, count), memory, z) }
            })
        }
    };
}

beamformer!(
    Beamformer16x8,
    ForwardBackward,
    16,
    8,
    2,
    BONEBEAM_16_8_SIZE = 2432,
    BONEBEAM_16_8_ALIGN,
    bonebeam_16_8_init,
    bonebeam_16_8_line,
    bonebeam_16_8_line_within,
    bonebeam_16_8_iq_line
);
beamformer!(
    Beamformer32x16,
    ForwardBackward,
    32,
    16,
    2,
    BONEBEAM_32_16_SIZE = 6720,
    BONEBEAM_32_16_ALIGN,
    bonebeam_32_16_init,
    bonebeam_32_16_line,
    bonebeam_32_16_line_within,
    bonebeam_32_16_iq_line
);
beamformer!(
    Beamformer64x32,
    ForwardBackward,
    64,
    32,
    2,
    BONEBEAM_64_32_SIZE = 21504,
    BONEBEAM_64_32_ALIGN,
    bonebeam_64_32_init,
    bonebeam_64_32_line,
    bonebeam_64_32_line_within,
    bonebeam_64_32_iq_line
);
beamformer!(
    Beamformer128x64,
    ForwardBackward,
    128,
    64,
    2,
    BONEBEAM_128_64_SIZE = 75648,
    BONEBEAM_128_64_ALIGN,
    bonebeam_128_64_init,
    bonebeam_128_64_line,
    bonebeam_128_64_line_within,
    bonebeam_128_64_iq_line
);
beamformer!(
    BeamformerForward32x16,
    Forward,
    32,
    16,
    2,
    BONEBEAM_FORWARD_32_16_SIZE = 11456,
    BONEBEAM_FORWARD_32_16_ALIGN,
    bonebeam_forward_32_16_init,
    bonebeam_forward_32_16_line,
    bonebeam_forward_32_16_line_within,
    bonebeam_forward_32_16_iq_line
);
