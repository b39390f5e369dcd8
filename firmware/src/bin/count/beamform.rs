//! Beamformers of three sizes, forward-backward, K = 0.

use bonebeam::beamform::{AlignedLine, Beamformer, Method, Parameters, Storage, Workspace};
use bonebeam::covariance::ForwardBackward;
use bonebeam::geometry::Active;
use bonebeam::{Complex, Error};
use cortex_m_semihosting::hprintln;

use crate::counter::Counter;
use crate::input::{ECHO, KINDS, SAMPLES, of_kind, snapshots};
use crate::report;

const LARGEST: usize = 64;

/// What is counted.
struct Case {
    name: &'static str,
    method: Method,
    echo: f32,
    /// Bounds on the instructions per output sample for `M` = 16, 32 and 64: a quarter above what
    /// Rust 1.95 gives, so that another compiler passes and a kernel grown slower is noticed.
    bounds: [u32; 3],
}

/// Steps of the power iteration.
const STEPS: usize = 8;

const CASES: [Case; 7] = [
    case("das", Method::Das, ECHO, [230, 445, 875]),
    case("mv", Method::Mv, ECHO, [5200, 16_300, 63_900]),
    case(
        "esmv-rank1",
        Method::EsmvRank1,
        ECHO,
        [9_600, 23_600, 80_600],
    ),
    // No eigenvalue stands out.
    case(
        "esmv-rank1-noise",
        Method::EsmvRank1,
        0.0,
        [17_200, 50_200, 197_300],
    ),
    case(
        "esmv-rank1-steps",
        Method::EsmvRank1Steps(STEPS),
        ECHO,
        [9_000, 30_000, 120_000],
    ),
    case(
        "esmv-rank1-steps-noise",
        Method::EsmvRank1Steps(STEPS),
        0.0,
        [9_000, 30_000, 120_000],
    ),
    case(
        "esmv-beta",
        Method::EsmvBeta(0.01),
        ECHO,
        [19_900, 65_000, 253_400],
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

/// The memory of the cases.
pub struct Workspaces {
    m16: Workspace<16, 8, 0>,
    m32: Workspace<32, 16, 0>,
    m64: Workspace<64, 32, 0>,
    x: [Complex<f32>; SAMPLES * LARGEST],
    z: [Complex<f32>; SAMPLES],
}

impl Workspaces {
    /// All zero.
    pub const fn new() -> Self {
        let zero = Complex::new(0.0, 0.0);
        Workspaces {
            m16: Workspace::new(),
            m32: Workspace::new(),
            m64: Workspace::new(),
            x: [zero; SAMPLES * LARGEST],
            z: [zero; SAMPLES],
        }
    }
}

/// Counts every case at every size; whether all stay within their bounds.
pub fn run(counter: &mut Counter, workspaces: &mut Workspaces) -> Result<bool, Error> {
    let Workspaces {
        m16,
        m32,
        m64,
        x,
        z,
    } = workspaces;
    let mut within = true;
    for case in &CASES {
        within &= line(counter, m16, case, case.bounds[0], x, z)?;
        within &= line(counter, m32, case, case.bounds[1], x, z)?;
        within &= line(counter, m64, case, case.bounds[2], x, z)?;
    }
    for case in CASES.iter().filter(|case| case.echo > 0.0) {
        within &= spread(counter, m16, case, x)?;
        within &= spread(counter, m32, case, x)?;
        within &= spread(counter, m64, case, x)?;
    }
    Ok(within)
}

/// Counts one sample of every kind of data, and prints `spread NAME SIZE MEAN LEAST MOST`; whether what takes
/// constant time does.
fn spread<const M: usize, const L: usize>(
    counter: &mut Counter,
    workspace: &mut Workspace<M, L, 0>,
    case: &Case,
    x: &mut [Complex<f32>],
) -> Result<bool, Error>
where
    ForwardBackward: Storage<L, 0>,
{
    let x = &mut x[..M];
    let beamformer = Beamformer::new(Parameters {
        method: case.method,
        ..Parameters::default()
    })?;
    let all = |_| Active { first: 0, count: M };
    let mut z = [Complex::new(0.0, 0.0)];
    let (mut sum, mut least, mut most) = (0, u32::MAX, 0);
    for kind in 0..KINDS {
        of_kind(x, kind);
        let line = AlignedLine::new(x, M)?;
        let mut outcome = Ok(());
        let cost = counter.count(|| {
            outcome = beamformer.line(&mut workspace.view(), line, all, &mut z);
        });
        outcome?;
        sum += cost.instructions;
        least = least.min(cost.instructions);
        most = most.max(cost.instructions);
    }
    let mean = sum / KINDS as u32;
    hprintln!("spread {} {M} {mean} {least} {most}", case.name);
    // A comparison around the kernel, as in its scale, may take some instructions more or less, and so a tick,
    // which is 40.
    let varies = !matches!(
        case.method,
        Method::Das | Method::Mv | Method::EsmvRank1Steps(_)
    );
    let constant = varies || most - least <= 40 + most / 500;
    if !constant {
        hprintln!("error: {} takes {least} to {most} instructions", case.name);
    }
    Ok(constant)
}

fn line<const M: usize, const L: usize>(
    counter: &mut Counter,
    workspace: &mut Workspace<M, L, 0>,
    case: &Case,
    bound: u32,
    x: &mut [Complex<f32>],
    z: &mut [Complex<f32>],
) -> Result<bool, Error>
where
    ForwardBackward: Storage<L, 0>,
{
    let x = &mut x[..SAMPLES * M];
    snapshots(x, M, case.echo);
    let beamformer = Beamformer::new(Parameters {
        method: case.method,
        ..Parameters::default()
    })?;
    let all = |_| Active { first: 0, count: M };
    let mut outcome = Ok(());
    let cost = counter.count(|| {
        outcome = AlignedLine::new(x, M)
            .and_then(|line| beamformer.line(&mut workspace.view(), line, all, z));
    });
    outcome?;
    let name = case.name;
    for (n, z) in z.iter().enumerate() {
        hprintln!("value {name} {M} {n} {:e} {:e}", z.re, z.im);
    }
    let bytes = Workspace::<M, L, 0>::BYTES;
    Ok(report(name, M, SAMPLES, &cost, bytes, bound))
}
