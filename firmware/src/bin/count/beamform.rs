//! Beamformers of three sizes, forward-backward, K = 0.

use bonebeam::beamform::{AlignedLine, Beamformer, Method, Parameters, Storage, Workspace};
use bonebeam::covariance::ForwardBackward;
use bonebeam::geometry::Active;
use bonebeam::{Complex, Error};
use cortex_m_semihosting::hprintln;

use crate::counter::Counter;
use crate::input::{ECHO, SAMPLES, snapshots};
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

const CASES: [Case; 5] = [
    case("das", Method::Das, ECHO, [280, 510, 980]),
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
        [17_700, 52_300, 202_000],
    ),
    case(
        "esmv-beta",
        Method::EsmvBeta(0.01),
        ECHO,
        [29_300, 98_900, 378_500],
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
    Ok(within)
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
