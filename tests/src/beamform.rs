//! The beamformers on the golden snapshots: M = 32, L = 16, K = 2.

use bonebeam::beamform::{Parameters, Sizes};
use bonebeam::geometry::{Aperture, ApertureParameters};
use bonebeam::memory;
use bonebeam::prelude::stages::*;

use crate::snapshots::{ELEMENTS, PERIODIC, SAMPLES, SNAPSHOTS};
use crate::{arrays, hash};

/// `K`.
const TEMPORAL: usize = 2;
/// The largest number of sub-lines.
const SUB_LINES: usize = 4;
/// The line of [`scan`] whose sub-lines are computed.
const LINE: usize = 9;
/// The adaptive samples of a case with a gate; the first is in the middle of a block of the time window.
const GATE: core::ops::Range<usize> = 13..38;

/// A beamformer and the name of its hash: forward-backward, all elements active.
#[derive(Clone, Copy, Debug)]
struct Case {
    name: &'static str,
    parameters: Parameters,
    /// The aperture grows with depth, as [`growing`].
    grows: bool,
    /// DAS outside [`GATE`].
    gated: bool,
}

const fn case(name: &'static str, method: Method) -> Case {
    let parameters = Parameters {
        temporal_half_window: TEMPORAL,
        ..Parameters::of(method)
    };
    let (grows, gated) = (false, false);
    Case {
        name,
        parameters,
        grows,
        gated,
    }
}

impl Case {
    const fn forward(mut self) -> Self {
        self.parameters.covariance = Covariance::Forward;
        self
    }

    const fn with(mut self, apodization: Apodization) -> Self {
        self.parameters.apodization = apodization;
        self
    }

    const fn growing(mut self) -> Self {
        self.grows = true;
        self
    }

    const fn stepped(mut self, depth_step: usize, temporal_half_window: usize) -> Self {
        self.parameters.depth_step = depth_step;
        self.parameters.temporal_half_window = temporal_half_window;
        self
    }

    const fn sub_lines(mut self, sub_lines: usize) -> Self {
        self.parameters.sub_lines = sub_lines;
        self
    }
}

/// The cases before those of the postfilters. (DAS has no covariance.)
const CASES: [Case; 16] = [
    case("das", Method::Das),
    case("mv", Method::Mv),
    case("esmv-rank1", Method::EsmvRank1),
    case("esmv-beta", Method::EsmvBeta(0.1)),
    case("esmv-rank3", Method::EsmvRank(3)),
    case("esmv-exclude-first", Method::EsmvExcludeFirst),
    case("esmv-rank1-steps", Method::EsmvRank1Steps(8)),
    case("mv-forward", Method::Mv).forward(),
    case("esmv-rank1-forward", Method::EsmvRank1).forward(),
    case("esmv-beta-forward", Method::EsmvBeta(0.1)).forward(),
    case("esmv-exclude-first-forward", Method::EsmvExcludeFirst).forward(),
    case("esmv-rank1-steps-forward", Method::EsmvRank1Steps(8)).forward(),
    case("mv-growing-aperture", Method::Mv).growing(),
    case("mv-growing-aperture-depth-step-3", Method::Mv)
        .growing()
        .stepped(3, TEMPORAL),
    {
        let mut case = case("mv-depth-gate", Method::Mv).growing();
        case.gated = true;
        case
    },
    // Without diagonal loading, on `PERIODIC`: MV by the eigenvectors, since the Cholesky factorisation fails.
    {
        let mut case = case("mv-singular", Method::Mv);
        case.parameters.diagonal_loading = 0.0;
        case
    },
];

/// MV with every postfilter, named by its key; no postfilter, the first of the table, is left out.
const POSTFILTERS: [Case; Postfilter::EXAMPLES.len() - 1] = {
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

/// Every method behind the seventh, named by its key.
const FURTHER: [Case; Method::EXAMPLES.len() - 7] = {
    let mut cases = [case("", Method::Mv); Method::EXAMPLES.len() - 7];
    let mut i = 0;
    while i < cases.len() {
        let method = Method::EXAMPLES[i + 7];
        cases[i] = case(method.key(), method);
        i += 1;
    }
    cases
};

/// The cases behind those of the postfilters.
const OTHERS: [Case; 18] = [
    case("das-hann", Method::Das).with(Apodization::Hann),
    case("mv-hamming", Method::Mv).with(Apodization::Hamming),
    case("esmv-rank1-tukey", Method::EsmvRank1).with(Apodization::Tukey),
    // Without a time window, with one, with one longer than the step, and with sub-lines.
    case("das-depth-step-2", Method::Das).stepped(2, 0),
    case("esmv-rank1-depth-step-4", Method::EsmvRank1).stepped(4, 0),
    case("mv-depth-step-3", Method::Mv).stepped(3, TEMPORAL),
    case("sub-lines-mv-depth-step-8", Method::Mv)
        .stepped(8, TEMPORAL)
        .sub_lines(4),
    case("sub-lines-das", Method::Das).sub_lines(4),
    case("sub-lines-mv", Method::Mv).sub_lines(4),
    case("sub-lines-esmv-rank1", Method::EsmvRank1).sub_lines(4),
    case("sub-lines-esmv-beta", Method::EsmvBeta(0.1)).sub_lines(4),
    case("sub-lines-esmv-rank3", Method::EsmvRank(3)).sub_lines(4),
    case("sub-lines-esmv-exclude-first", Method::EsmvExcludeFirst).sub_lines(4),
    case("sub-lines-esmv-rank1-steps", Method::EsmvRank1Steps(8)).sub_lines(4),
    case("sub-lines-mv-forward", Method::Mv)
        .sub_lines(4)
        .forward(),
    case("sub-lines-esmv-rank1-forward", Method::EsmvRank1)
        .sub_lines(4)
        .forward(),
    case("sub-lines-esmv-beta-forward", Method::EsmvBeta(0.1))
        .sub_lines(4)
        .forward(),
    {
        let mut case = case("sub-lines-mv-growing-aperture", Method::Mv)
            .growing()
            .sub_lines(2);
        case.parameters.postfilter = Postfilter::CoherenceFactor;
        case
    },
];

/// The scan that defines the sub-lines: a line for each element of a linear array.
fn scan() -> Result<Scan<'static>, Error> {
    Scan::new(ScanParameters {
        array: Array::linear(ELEMENTS, 0.3e-3),
        lines: Lines::Even(Axis::centred(ELEMENTS, 0.3e-3)),
        record_samples: 1024,
        start: Depth::Seconds(5e-6),
        end: Depth::Seconds(5e-6 + (SAMPLES - 1) as f64 / 20e6),
        ..ScanParameters::EXAMPLE
    })
}

/// The active elements of a sample, from 8 to all, cut at the array's start.
pub(crate) fn growing() -> Result<impl Fn(usize) -> Active, Error> {
    let aperture = Aperture::new(ApertureParameters {
        elements: ELEMENTS,
        pitch: 0.3e-3,
        f_number: 1.5,
        min_elements: 8,
    })?;
    Ok(move |n| aperture.active(9.5, 2e-3 + n as f64 * 0.3e-3))
}

const fn sizes(covariance: Covariance) -> Sizes {
    let mut parameters = case("", Method::Mv).sub_lines(SUB_LINES).parameters;
    parameters.covariance = covariance;
    parameters.sizes(ELEMENTS)
}
const NEED: Need = {
    let forward = sizes(Covariance::Forward).need();
    forward.or(sizes(Covariance::ForwardBackward).need())
};

arrays! {
    /// The memory of the cases.
    pub struct Memory {
        scratch: memory::Memory<{ NEED.real }, { NEED.complex }> = memory::Memory::new(),
        z: [Complex<f32>; SAMPLES * SUB_LINES] = [Complex::ZERO; _],
        steering: [Complex<f32>; Steering::need(SAMPLES, SUB_LINES).complex] = [Complex::ZERO; _],
    }
}

pub(crate) fn run(memory: &mut Memory, report: &mut impl FnMut(&str, u64)) -> Result<(), Error> {
    let cases = CASES.into_iter().chain(POSTFILTERS).chain(OTHERS);
    for case in cases.chain(FURTHER) {
        let z = beamform(case, memory)?;
        report(case.name, hash::complex(z));
    }
    report("steering", hash::complex(&memory.steering));
    Ok(())
}

fn beamform(case: Case, memory: &mut Memory) -> Result<&[Complex<f32>], Error> {
    let Parameters {
        sub_lines,
        covariance,
        diagonal_loading,
        ..
    } = case.parameters;
    let x = if diagonal_loading > 0.0 {
        &SNAPSHOTS
    } else {
        &PERIODIC
    };
    let line = AlignedLine::new(x, ELEMENTS)?;
    let beamformer = Beamformer::new(case.parameters)?;
    let workspace = &mut Workspace::new(0.0, sizes(covariance), memory.scratch.scratch())?;
    let (z, _) = memory
        .z
        .split_at_mut(beamformer.line_samples(SAMPLES) * sub_lines);
    let (growing, all) = (growing()?, Active::new(0, ELEMENTS));
    let active = |n| if case.grows { growing(n) } else { all };
    match sub_lines {
        1 if case.gated => beamformer.line_within(workspace, line, active, GATE, z)?,
        1 => beamformer.line(workspace, line, active, z)?,
        _ => {
            let need = Steering::need(SAMPLES, sub_lines).complex;
            let (steering, _) = memory.steering.split_at_mut(need);
            let steering = Steering::new(&scan()?, LINE, sub_lines, steering)?;
            beamformer.sub_lines(workspace, (line, steering), active, z)?;
        }
    }
    Ok(z)
}
