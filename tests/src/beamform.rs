//! The beamformers on the golden snapshots: M = 32, L = 16, K = 2.

use bonebeam::beamform::{
    AlignedLine, Apodization, Beamformer, Method, Parameters, Postfilter, Sizes, Workspace,
};
use bonebeam::covariance::{Averaging, Covariance, Forward, ForwardBackward};
use bonebeam::geometry::{Active, Aperture, ApertureParameters};
use bonebeam::memory::{self, Need};
use bonebeam::{Complex, Error};

use crate::hash;
use crate::snapshots::{ELEMENTS, PERIODIC, SAMPLES, SNAPSHOTS};

/// The subaperture's length.
pub const SUBAPERTURE: usize = ELEMENTS / 2;
/// `K`.
pub const TEMPORAL: usize = 2;
/// Steps of the power iteration.
pub const STEPS: usize = 8;
/// A beamformer and what its hash is called.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// The name.
    pub name: &'static str,
    /// What it is asked for.
    pub parameters: Parameters,
}

const fn case(name: &'static str, method: Method) -> Case {
    let parameters = Parameters {
        method,
        temporal_half_window: TEMPORAL,
        ..Parameters::DEFAULT
    };
    Case { name, parameters }
}

/// MV with every postfilter, under the key of that, forward-backward, all elements active. The first of the
/// table is none.
pub const POSTFILTERS: [Case; Postfilter::EXAMPLES.len() - 1] = {
    let mut cases = [case("", Method::Mv); Postfilter::EXAMPLES.len() - 1];
    let mut i = 0;
    while i < cases.len() {
        let postfilter = Postfilter::EXAMPLES[i + 1];
        cases[i].name = postfilter.key();
        cases[i].parameters.postfilter = postfilter;
        i += 1;
    }
    cases
};

/// The cases with apodization, forward-backward, all elements active.
pub const APODIZED: [Case; 3] = [
    apodized("das-hann", Method::Das, Apodization::Hann),
    apodized("mv-hamming", Method::Mv, Apodization::Hamming),
    apodized("esmv-rank1-tukey", Method::EsmvRank1, Apodization::Tukey),
];

const fn apodized(name: &'static str, method: Method, apodization: Apodization) -> Case {
    let mut case = case(name, method);
    case.parameters.apodization = apodization;
    case
}

/// The cases with forward-backward averaging, all elements active. (DAS has no covariance.)
pub const FORWARD_BACKWARD: [Case; 7] = [
    case("das", Method::Das),
    case("mv", Method::Mv),
    case("esmv-rank1", Method::EsmvRank1),
    case("esmv-beta", Method::EsmvBeta(0.1)),
    case("esmv-rank3", Method::EsmvRank(3)),
    case("esmv-exclude-first", Method::EsmvExcludeFirst),
    case("esmv-rank1-steps", Method::EsmvRank1Steps(STEPS)),
];

/// The cases with the forward covariance, all elements active.
pub const FORWARD: [Case; 5] = [
    case("mv-forward", Method::Mv),
    case("esmv-rank1-forward", Method::EsmvRank1),
    case("esmv-beta-forward", Method::EsmvBeta(0.1)),
    case("esmv-exclude-first-forward", Method::EsmvExcludeFirst),
    case("esmv-rank1-steps-forward", Method::EsmvRank1Steps(STEPS)),
];

/// The case whose aperture grows with depth ([`growing`]), forward-backward.
pub const GROWING: Case = case("mv-growing-aperture", Method::Mv);

/// The case of the same aperture, adaptive within [`GATE`] and DAS elsewhere.
pub const GATED: Case = case("mv-depth-gate", Method::Mv);

/// The samples of [`GATED`] that are adaptive: the first is amid a block of the time window.
pub const GATE: core::ops::Range<usize> = 13..38;

/// The case without diagonal loading on [`PERIODIC`], whose covariance no sample's Cholesky factorisation comes
/// through: MV by the eigenvectors.
pub const SINGULAR: Case = {
    let mut case = case("mv-singular", Method::Mv);
    case.parameters.diagonal_loading = 0.0;
    case
};

/// The active elements of a sample of [`GROWING`]: from 8 to all, cut at the array's start.
///
/// # Errors
/// None: the aperture is a valid one.
pub fn growing() -> Result<impl Fn(usize) -> Active, Error> {
    let aperture = Aperture::new(ApertureParameters {
        elements: ELEMENTS,
        pitch: 0.3e-3,
        f_number: 1.5,
        min_elements: 8,
    })?;
    Ok(move |n| aperture.active(9.5, 2e-3 + n as f64 * 0.3e-3))
}

const SIZES: Sizes = Sizes {
    elements: ELEMENTS,
    subaperture: SUBAPERTURE,
    temporal_half_window: TEMPORAL,
};
const FORWARD_NEED: Need = SIZES.need(Covariance::Forward);
const BACKWARD_NEED: Need = SIZES.need(Covariance::ForwardBackward);

/// The memory of the cases.
pub struct Memory {
    forward: memory::Memory<{ FORWARD_NEED.real }, { FORWARD_NEED.complex }>,
    forward_backward: memory::Memory<{ BACKWARD_NEED.real }, { BACKWARD_NEED.complex }>,
    z: [Complex<f32>; SAMPLES],
}

impl Memory {
    pub(crate) const fn new() -> Self {
        Memory {
            forward: memory::Memory::new(),
            forward_backward: memory::Memory::new(),
            z: [Complex::new(0.0, 0.0); SAMPLES],
        }
    }
}

pub(crate) fn run(memory: &mut Memory, report: &mut impl FnMut(&str, u64)) -> Result<(), Error> {
    let Memory {
        forward,
        forward_backward,
        z,
    } = memory;
    let forward = &mut Workspace::<Forward>::new(0.0, SIZES, forward.scratch())?;
    let forward_backward =
        &mut Workspace::<ForwardBackward>::new(0.0, SIZES, forward_backward.scratch())?;
    let all = |_| Active {
        first: 0,
        count: ELEMENTS,
    };
    for case in FORWARD_BACKWARD {
        beamform(case, forward_backward, all, z, report)?;
    }
    for case in FORWARD {
        beamform(case, forward, all, z, report)?;
    }
    beamform(GROWING, forward_backward, growing()?, z, report)?;
    let line = AlignedLine::new(&SNAPSHOTS, ELEMENTS)?;
    let beamformer = Beamformer::new(GATED.parameters)?;
    beamformer.line_within(forward_backward, line, growing()?, GATE, z)?;
    report(GATED.name, hash::complex(z));
    let line = AlignedLine::new(&PERIODIC, ELEMENTS)?;
    let beamformer = Beamformer::new(SINGULAR.parameters)?;
    beamformer.line(forward_backward, line, all, z)?;
    report(SINGULAR.name, hash::complex(z));
    for case in POSTFILTERS.into_iter().chain(APODIZED) {
        beamform(case, forward_backward, all, z, report)?;
    }
    Ok(())
}

fn beamform<A: Averaging<f32>>(
    case: Case,
    workspace: &mut Workspace<'_, A>,
    active: impl Fn(usize) -> Active,
    z: &mut [Complex<f32>],
    report: &mut impl FnMut(&str, u64),
) -> Result<(), Error> {
    let line = AlignedLine::new(&SNAPSHOTS, ELEMENTS)?;
    Beamformer::new(case.parameters)?.line(workspace, line, active, z)?;
    report(case.name, hash::complex(z));
    Ok(())
}
