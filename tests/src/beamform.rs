//! The beamformers on the golden snapshots: M = 32, L = 16, K = 2.

use bonebeam::beamform::{
    AlignedLine, Apodization, Beamformer, Method, Parameters, Postfilter, Sizes, Workspace,
};
use bonebeam::covariance::Covariance;
use bonebeam::geometry::{
    Active, Aperture, ApertureParameters, Array, Axis, Depth, Lines, Scan, ScanParameters, Steering,
};
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
/// A beamformer and the name of its hash.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// The name.
    pub name: &'static str,
    /// The parameters of the beamformer.
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

/// MV with every postfilter, named by its key.
///
/// Forward-backward, all elements active. The first entry of the table, no postfilter, is left out.
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
    forward(case("mv-forward", Method::Mv)),
    forward(case("esmv-rank1-forward", Method::EsmvRank1)),
    forward(case("esmv-beta-forward", Method::EsmvBeta(0.1))),
    forward(case("esmv-exclude-first-forward", Method::EsmvExcludeFirst)),
    forward(case(
        "esmv-rank1-steps-forward",
        Method::EsmvRank1Steps(STEPS),
    )),
];

const fn forward(case: Case) -> Case {
    let mut case = case;
    case.parameters.covariance = Covariance::Forward;
    case
}

/// The case whose aperture grows with depth ([`growing`]), forward-backward.
pub const GROWING: Case = case("mv-growing-aperture", Method::Mv);

/// The case of the same aperture, adaptive within [`GATE`] and DAS elsewhere.
pub const GATED: Case = case("mv-depth-gate", Method::Mv);

/// The samples of [`GATED`] that are adaptive.
///
/// The first is in the middle of a block of the time window.
pub const GATE: core::ops::Range<usize> = 13..38;

/// The case without diagonal loading on [`PERIODIC`]: MV by the eigenvectors.
///
/// The Cholesky factorisation of the covariance fails at every sample.
pub const SINGULAR: Case = {
    let mut case = case("mv-singular", Method::Mv);
    case.parameters.diagonal_loading = 0.0;
    case
};

/// The cases with a depth step, forward-backward, all elements active.
///
/// Without a time window, with one, with one longer than the step, and with sub-lines.
pub const DEPTH_STEPS: [Case; 4] = [
    depth_step(case("das-depth-step-2", Method::Das), 2, 0),
    depth_step(case("esmv-rank1-depth-step-4", Method::EsmvRank1), 4, 0),
    depth_step(case("mv-depth-step-3", Method::Mv), 3, TEMPORAL),
    depth_step(
        sub_lines("sub-lines-mv-depth-step-8", Method::Mv),
        8,
        TEMPORAL,
    ),
];

/// The case of [`GROWING`] with a depth step.
pub const GROWING_DEPTH_STEP: Case = depth_step(
    case("mv-growing-aperture-depth-step-3", Method::Mv),
    3,
    TEMPORAL,
);

const fn depth_step(case: Case, depth_step: usize, temporal_half_window: usize) -> Case {
    let mut case = case;
    case.parameters.depth_step = depth_step;
    case.parameters.temporal_half_window = temporal_half_window;
    case
}

const fn sub_lines(name: &'static str, method: Method) -> Case {
    let mut case = case(name, method);
    case.parameters.sub_lines = SUB_LINES;
    case
}

/// Number of sub-lines in the cases with sub-lines.
pub const SUB_LINES: usize = 4;

/// Index of the line of [`scan`] in the cases with sub-lines.
pub const LINE: usize = 9;

/// The cases of sub-lines with forward-backward averaging, all elements active.
pub const SUB_LINES_FORWARD_BACKWARD: [Case; 7] = [
    sub_lines("sub-lines-das", Method::Das),
    sub_lines("sub-lines-mv", Method::Mv),
    sub_lines("sub-lines-esmv-rank1", Method::EsmvRank1),
    sub_lines("sub-lines-esmv-beta", Method::EsmvBeta(0.1)),
    sub_lines("sub-lines-esmv-rank3", Method::EsmvRank(3)),
    sub_lines("sub-lines-esmv-exclude-first", Method::EsmvExcludeFirst),
    sub_lines("sub-lines-esmv-rank1-steps", Method::EsmvRank1Steps(STEPS)),
];

/// The cases of sub-lines with the forward covariance, all elements active.
pub const SUB_LINES_FORWARD: [Case; 3] = [
    forward(sub_lines("sub-lines-mv-forward", Method::Mv)),
    forward(sub_lines("sub-lines-esmv-rank1-forward", Method::EsmvRank1)),
    forward(sub_lines(
        "sub-lines-esmv-beta-forward",
        Method::EsmvBeta(0.1),
    )),
];

/// The case of two sub-lines and a coherence factor, forward-backward.
///
/// It has the aperture of [`GROWING`].
pub const SUB_LINES_GROWING: Case = {
    let mut case = sub_lines("sub-lines-mv-growing-aperture", Method::Mv);
    case.parameters.sub_lines = 2;
    case.parameters.postfilter = Postfilter::CoherenceFactor;
    case
};

/// The scan that defines the sub-lines: a line for each element of a linear array.
///
/// # Errors
/// None: the scan is valid.
pub fn scan() -> Result<Scan<'static>, Error> {
    Scan::new(ScanParameters {
        array: Array::linear(ELEMENTS, 0.3e-3),
        lines: Lines::Even(Axis::centred(ELEMENTS, 0.3e-3)),
        sound_speed: 1540.0,
        centre_frequency: 5e6,
        sampling_rate: 20e6,
        record_samples: 1024,
        output_rate: 20e6,
        start: Depth::Seconds(5e-6),
        end: Depth::Seconds(5e-6 + (SAMPLES - 1) as f64 / 20e6),
        f_number: 1.5,
        min_elements: 8,
    })
}

/// The active elements of a sample of [`GROWING`]: from 8 to all, cut at the array's start.
///
/// # Errors
/// None: the aperture is valid.
pub fn growing() -> Result<impl Fn(usize) -> Active, Error> {
    let aperture = Aperture::new(ApertureParameters {
        elements: ELEMENTS,
        pitch: 0.3e-3,
        f_number: 1.5,
        min_elements: 8,
    })?;
    Ok(move |n| aperture.active(9.5, 2e-3 + n as f64 * 0.3e-3))
}

const fn sizes(covariance: Covariance) -> Sizes {
    Sizes {
        covariance,
        elements: ELEMENTS,
        subaperture: SUBAPERTURE,
        temporal_half_window: TEMPORAL,
        sub_lines: SUB_LINES,
    }
}
const NEED: Need = {
    let forward = sizes(Covariance::Forward).need();
    forward.or(sizes(Covariance::ForwardBackward).need())
};

/// The memory of the cases.
pub struct Memory {
    scratch: CaseScratch,
    z: [Complex<f32>; SAMPLES * SUB_LINES],
    steering: [Complex<f32>; STEERING],
}

const STEERING: usize = Steering::need(SAMPLES, SUB_LINES).complex;

impl Memory {
    pub(crate) const fn new() -> Self {
        Memory {
            scratch: memory::Memory::new(),
            z: [Complex::new(0.0, 0.0); SAMPLES * SUB_LINES],
            steering: [Complex::new(0.0, 0.0); STEERING],
        }
    }
}

pub(crate) fn run(memory: &mut Memory, report: &mut impl FnMut(&str, u64)) -> Result<(), Error> {
    let Memory {
        scratch,
        z: all_z,
        steering,
    } = memory;
    let (z, _) = all_z.split_at_mut(SAMPLES);
    let all = |_| Active {
        first: 0,
        count: ELEMENTS,
    };
    for case in FORWARD_BACKWARD.into_iter().chain(FORWARD) {
        beamform(case, scratch, all, z, report)?;
    }
    beamform(GROWING, scratch, growing()?, z, report)?;
    beamform(GROWING_DEPTH_STEP, scratch, growing()?, z, report)?;
    let line = AlignedLine::new(&SNAPSHOTS, ELEMENTS)?;
    let beamformer = Beamformer::new(GATED.parameters)?;
    let workspace = &mut workspace_of(&GATED, scratch)?;
    beamformer.line_within(workspace, line, growing()?, GATE, z)?;
    report(GATED.name, hash::complex(z));
    let line = AlignedLine::new(&PERIODIC, ELEMENTS)?;
    let beamformer = Beamformer::new(SINGULAR.parameters)?;
    let workspace = &mut workspace_of(&SINGULAR, scratch)?;
    beamformer.line(workspace, line, all, z)?;
    report(SINGULAR.name, hash::complex(z));
    for case in POSTFILTERS.into_iter().chain(APODIZED) {
        beamform(case, scratch, all, z, report)?;
    }
    let z = &mut all_z[..];
    for case in DEPTH_STEPS {
        match case.parameters.sub_lines {
            1 => beamform(case, scratch, all, z, report)?,
            _ => beamform_sub_lines(case, scratch, all, (steering, z), report)?,
        }
    }
    for case in SUB_LINES_FORWARD_BACKWARD
        .into_iter()
        .chain(SUB_LINES_FORWARD)
    {
        beamform_sub_lines(case, scratch, all, (steering, z), report)?;
    }
    let growing = growing()?;
    beamform_sub_lines(SUB_LINES_GROWING, scratch, growing, (steering, z), report)?;
    report("steering", hash::complex(steering));
    Ok(())
}

type CaseScratch = memory::Memory<{ NEED.real }, { NEED.complex }>;

fn workspace_of<'a>(case: &Case, scratch: &'a mut CaseScratch) -> Result<Workspace<'a>, Error> {
    Workspace::new(0.0, sizes(case.parameters.covariance), scratch.scratch())
}

fn beamform_sub_lines(
    case: Case,
    scratch: &mut CaseScratch,
    active: impl Fn(usize) -> Active,
    (steering, z): (&mut [Complex<f32>], &mut [Complex<f32>]),
    report: &mut impl FnMut(&str, u64),
) -> Result<(), Error> {
    let count = case.parameters.sub_lines;
    let (steering, _) = steering.split_at_mut(Steering::need(SAMPLES, count).complex);
    let steering = Steering::new(&scan()?, LINE, count, steering)?;
    let line = AlignedLine::new(&SNAPSHOTS, ELEMENTS)?;
    let beamformer = Beamformer::new(case.parameters)?;
    let (z, _) = z.split_at_mut(beamformer.line_samples(SAMPLES) * count);
    let workspace = &mut workspace_of(&case, scratch)?;
    beamformer.sub_lines(workspace, (line, steering), active, z)?;
    report(case.name, hash::complex(z));
    Ok(())
}

fn beamform(
    case: Case,
    scratch: &mut CaseScratch,
    active: impl Fn(usize) -> Active,
    z: &mut [Complex<f32>],
    report: &mut impl FnMut(&str, u64),
) -> Result<(), Error> {
    let line = AlignedLine::new(&SNAPSHOTS, ELEMENTS)?;
    let beamformer = Beamformer::new(case.parameters)?;
    let (z, _) = z.split_at_mut(beamformer.line_samples(SAMPLES));
    let workspace = &mut workspace_of(&case, scratch)?;
    beamformer.line(workspace, line, active, z)?;
    report(case.name, hash::complex(z));
    Ok(())
}
