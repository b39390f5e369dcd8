//! Beamformers of three sizes, forward-backward, K = 0.

use bonebeam::beamform::{Parameters, Sizes};
use bonebeam::prelude::stages::*;
use cortex_m_semihosting::hprintln;
use firmware::arrays;
use static_cell::ConstStaticCell;

use crate::counter::{Cost, Counter};
use crate::input::{ECHO, EXTREMES, KINDS, SAMPLES, of_extreme, of_kind, snapshots};
use crate::report;

const LARGEST: usize = 64;

/// A counted case.
struct Case {
    name: &'static str,
    method: Method,
    echo: f32,
    /// Bounds on the instructions per output sample for `M` = 16, 32 and 64.
    ///
    /// They are a quarter above the counts of Rust 1.95, so that another compiler passes and a slower kernel fails.
    bounds: [u32; 3],
}

/// Steps of the power iteration.
const STEPS: usize = 8;

const CASES: [Case; 7] = [
    case("das", Method::Das, ECHO, [230, 445, 875]),
    case("mv", Method::Mv, ECHO, [3340, 15_630, 60_700]),
    case(
        "esmv-rank1",
        Method::EsmvRank1,
        ECHO,
        [6_130, 23_200, 78_300],
    ),
    // All eigenvalues are similar.
    case(
        "esmv-rank1-noise",
        Method::EsmvRank1,
        0.0,
        [13_740, 48_200, 189_000],
    ),
    case(
        "esmv-rank1-steps",
        Method::EsmvRank1Steps(STEPS),
        ECHO,
        [5_040, 23_470, 85_200],
    ),
    case(
        "esmv-rank1-steps-noise",
        Method::EsmvRank1Steps(STEPS),
        0.0,
        [5_040, 23_470, 85_200],
    ),
    case(
        "esmv-beta",
        Method::EsmvBeta(0.01),
        ECHO,
        [16_720, 65_000, 253_400],
    ),
];

const fn case(name: &'static str, method: Method, echo: f32, bounds: [u32; 3]) -> Case {
    Case {
        name,
        method,
        echo,
        bounds,
    }
}

const fn sizes(elements: usize) -> Sizes {
    Parameters::DEFAULT.sizes(elements)
}

arrays! {
    /// The memory of the cases.
    struct Workspaces {
        m16: Memory<{ sizes(16).need().real }, { sizes(16).need().complex }> = Memory::new(),
        m32: Memory<{ sizes(32).need().real }, { sizes(32).need().complex }> = Memory::new(),
        m64: Memory<{ sizes(64).need().real }, { sizes(64).need().complex }> = Memory::new(),
        x: [Complex<f32>; SAMPLES * LARGEST] = [Complex::ZERO; _],
        z: [Complex<f32>; SAMPLES] = [Complex::ZERO; _],
    }
}
static WORKSPACES: ConstStaticCell<Workspaces> = ConstStaticCell::new(Workspaces::new());

/// Counts every case at every size; returns whether all stay within their bounds.
pub fn run(counter: &mut Counter) -> Result<bool, Error> {
    let Workspaces {
        m16,
        m32,
        m64,
        x,
        z,
    } = WORKSPACES.take();
    let mut within = true;
    for case in &CASES {
        within &= line::<16, _, _>(counter, m16, case, case.bounds[0], x, z)?;
        within &= line::<32, _, _>(counter, m32, case, case.bounds[1], x, z)?;
        within &= line::<64, _, _>(counter, m64, case, case.bounds[2], x, z)?;
    }
    for case in CASES.iter().filter(|case| case.echo > 0.0) {
        within &= spread::<16, _, _>(counter, m16, case, x)?;
        within &= spread::<32, _, _>(counter, m32, case, x)?;
        within &= spread::<64, _, _>(counter, m64, case, x)?;
    }
    Ok(within)
}

/// Counts one sample of every kind of data.
///
/// Prints `spread NAME SIZE MEAN LEAST MOST`. Returns whether the methods of constant time are constant.
fn spread<const M: usize, const REAL: usize, const COMPLEX: usize>(
    counter: &mut Counter,
    memory: &mut Memory<REAL, COMPLEX>,
    case: &Case,
    x: &mut [Complex<f32>],
) -> Result<bool, Error> {
    let x = &mut x[..M];
    let beamformer = Beamformer::new(Parameters::of(case.method))?;
    let all = |_| Active::new(0, M);
    let mut z = [Complex::new(0.0, 0.0)];
    let (mut sum, mut least, mut most) = (0, u32::MAX, 0);
    let mut count = |x: &[Complex<f32>]| {
        let line = AlignedLine::new(x, M)?;
        let cost = counter.cost(|| {
            let mut workspace = Workspace::new(0.0, sizes(M), memory.scratch())?;
            beamformer.line(&mut workspace, line, all, &mut z)
        });
        cost.map(|cost| cost.instructions)
    };
    for kind in 0..KINDS {
        of_kind(x, kind);
        let instructions = count(x)?;
        sum += instructions;
        least = least.min(instructions);
        most = most.max(instructions);
    }
    let mean = sum / KINDS as u32;
    hprintln!("spread {} {M} {mean} {least} {most}", case.name);
    // A comparison around the kernel, for example in its scale, may take some instructions more or less, and so a
    // tick of 40. DAS scales lines whose largest sample is 0 or beyond 2^±64.
    let (tolerance, of_extremes) = match case.method {
        Method::Das => (40 + most / 500, 40 + most / 3),
        Method::Mv | Method::EsmvRank1Steps(_) => (40 + most / 500, 40 + most / 500),
        _ => return Ok(true),
    };
    let mut constant = most - least <= tolerance;
    if !constant {
        hprintln!("error: {} takes {least} to {most} instructions", case.name);
    }
    for (name, magnitude, elements) in EXTREMES {
        of_extreme(x, magnitude, elements);
        let instructions = count(x)?;
        if instructions.abs_diff(least) > of_extremes || instructions.abs_diff(most) > of_extremes {
            hprintln!(
                "error: {} takes {least}, of {name} {instructions}",
                case.name
            );
            constant = false;
        }
    }
    Ok(constant)
}

fn line<const M: usize, const REAL: usize, const COMPLEX: usize>(
    counter: &mut Counter,
    memory: &mut Memory<REAL, COMPLEX>,
    case: &Case,
    bound: u32,
    x: &mut [Complex<f32>],
    z: &mut [Complex<f32>],
) -> Result<bool, Error> {
    let x = &mut x[..SAMPLES * M];
    snapshots(x, M, case.echo);
    let beamformer = Beamformer::new(Parameters::of(case.method))?;
    let all = |_| Active::new(0, M);
    let cost = counter.cost(|| {
        let line = AlignedLine::new(x, M)?;
        let mut workspace = Workspace::new(0.0, sizes(M), memory.scratch())?;
        beamformer.line(&mut workspace, line, all, z)
    })?;
    let name = case.name;
    for (n, z) in z.iter().enumerate() {
        hprintln!("value {name} {M} {n} {:e} {:e}", z.re, z.im);
    }
    let bytes = Memory::<REAL, COMPLEX>::BYTES;
    let within = report(name, M, SAMPLES, &cost, bytes, bound);
    if case.method != Method::Das {
        return Ok(within);
    }
    let cost = checked::<M>(counter, memory.scratch(), x, z)?;
    Ok(report("das-checked", M, SAMPLES, &cost, bytes, bound) && within)
}

/// Counts DAS without the check of the line's samples, which a pipeline need not make.
///
/// A separate function, so that DAS with the check is compiled as in a program of one call.
#[inline(never)]
fn checked<const M: usize>(
    counter: &mut Counter,
    scratch: Scratch<'_>,
    x: &[Complex<f32>],
    z: &mut [Complex<f32>],
) -> Result<Cost, Error> {
    let beamformer = Beamformer::new(Parameters::of(Method::Das))?;
    let all = |_| Active::new(0, M);
    let line = AlignedLine::new(x, M)?;
    let mut workspace = Workspace::new(0.0, sizes(M), scratch)?;
    counter.cost(|| beamformer.line(&mut workspace, line, all, z))
}
