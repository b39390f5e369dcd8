//! What the beamformer refuses, and how it says so; what it takes.

mod common;

use bonebeam::Error;
use bonebeam::beamform::{
    AlignedLine, Beamformer, Method, Parameters, Run, Sizes, Slices, Storage, Workspace,
    WorkspaceView,
};
use bonebeam::covariance::{Covariance, Forward, ForwardBackward};
use bonebeam::geometry::Active;
use bonebeam::simd::ComplexVector;
use common::lines::COVARIANCES;
use ndarray::Array3;
use num_complex::Complex;

fn refusal(parameters: Parameters) -> String {
    let refused = Beamformer::new(parameters).expect_err("parameters out of range");
    refused.to_string()
}

#[test]
fn parameters_out_of_range() {
    for beta in [0.0, -1.0, 1.5, f32::NAN] {
        let message = refusal(Parameters {
            method: Method::EsmvBeta(beta),
            ..Parameters::default()
        });
        assert_eq!(
            message,
            format!("beta is {beta}, expected above 0, at most 1")
        );
    }
    let message = refusal(Parameters {
        method: Method::EsmvRank(0),
        ..Parameters::default()
    });
    assert_eq!(message, "rank is 0, expected at least 1");
    for diagonal_loading in [-0.05, f32::NAN, f32::INFINITY] {
        let message = refusal(Parameters {
            diagonal_loading,
            ..Parameters::default()
        });
        assert!(message.starts_with("diagonal_loading is "), "{message}");
    }
    // L > M is a ratio above 1.
    for subaperture_ratio in [0.0, -0.5, 1.01, f64::NAN] {
        let message = refusal(Parameters {
            subaperture_ratio,
            ..Parameters::default()
        });
        assert!(message.starts_with("subaperture ratio is "), "{message}");
    }
}

#[test]
fn lines_that_are_empty_or_ragged() {
    let x = [Complex::ONE; 7];
    assert!(matches!(
        AlignedLine::new(&x, 0),
        Err(Error::Parameter {
            name: "elements",
            ..
        })
    ));
    assert!(matches!(
        AlignedLine::new(&[], 4),
        Err(Error::Length { actual: 0, .. })
    ));
    assert!(matches!(
        AlignedLine::new(&x, 4),
        Err(Error::Length { actual: 7, .. })
    ));
}

/// A line of 5 samples of 8 elements through a workspace for 6 elements, L = 4 and K = 1.
fn run(parameters: Parameters, active: Active, length: usize) -> Result<(), Error> {
    let x = [Complex::ONE; 40];
    let line = AlignedLine::new(&x, 8)?;
    let mut workspace = Workspace::<6, 4, 1>::new();
    let mut z = vec![Complex::ZERO; length];
    Beamformer::new(parameters)?.line(&mut workspace.view(), line, |_| active, &mut z)
}

#[test]
fn what_does_not_fit() {
    let six = Active { first: 0, count: 6 };
    let temporal_half_window = |temporal_half_window| Parameters {
        temporal_half_window,
        ..Parameters::default()
    };
    let ratio = Parameters {
        subaperture_ratio: 1.0,
        ..Parameters::default()
    };
    let name = |result: Result<(), Error>| match result {
        Err(Error::Parameter { name, .. }) => format!("parameter {name}"),
        Err(Error::Capacity { name, .. }) => format!("capacity {name}"),
        Err(Error::Length { name, .. }) => format!("length {name}"),
        other => format!("{other:?}"),
    };
    assert_eq!(run(temporal_half_window(1), six, 5), Ok(()));
    assert_eq!(name(run(temporal_half_window(0), six, 4)), "length z");
    assert_eq!(
        name(run(temporal_half_window(2), six, 5)),
        "capacity temporal_half_window"
    );
    // K beyond the record, however large.
    assert_eq!(
        name(run(temporal_half_window(5), six, 5)),
        "parameter temporal_half_window"
    );
    assert_eq!(
        name(run(temporal_half_window(usize::MAX), six, 5)),
        "parameter temporal_half_window"
    );
    assert_eq!(name(run(ratio, six, 5)), "capacity subaperture");
    let seven = Active { first: 0, count: 7 };
    assert_eq!(
        name(run(temporal_half_window(0), seven, 5)),
        "capacity active elements"
    );
    let outside = Active { first: 3, count: 6 };
    assert_eq!(
        name(run(temporal_half_window(0), outside, 5)),
        "parameter first element"
    );
    let overflow = Active {
        first: usize::MAX,
        count: 2,
    };
    assert_eq!(
        name(run(temporal_half_window(0), overflow, 5)),
        "parameter first element"
    );
}

#[test]
fn a_line_is_refused_before_anything_is_put_out() {
    let x = [Complex::ONE; 40];
    let line = AlignedLine::new(&x, 8).expect("finite");
    let mut workspace = Workspace::<6, 4, 0>::new();
    let beamformer = Beamformer::new(Parameters::default()).expect("valid");
    // The last sample's aperture exceeds the capacity, or the array.
    for last in [Active { first: 0, count: 7 }, Active { first: 4, count: 5 }] {
        let six = Active { first: 0, count: 6 };
        let mut z = [Complex::I; 5];
        let active = |n| if n == 4 { last } else { six };
        let refused = beamformer.line(&mut workspace.view(), line, active, &mut z);
        assert!(refused.is_err());
        assert_eq!(z, [Complex::I; 5]);
    }
}

#[test]
fn a_run_outside_its_line() {
    let x = [Complex::ONE; 40];
    let line = AlignedLine::new(&x, 8).expect("finite");
    let mut workspace = Workspace::<8, 4, 0>::new();
    let beamformer = Beamformer::new(Parameters::default()).expect("valid");
    for first_sample in [4, 5, 6, usize::MAX] {
        let run = Run {
            line,
            first_element: 0,
            first_sample,
        };
        let mut z = [Complex::ONE; 2];
        let refused = beamformer.runs(&mut workspace.view(), &[run], 8, &mut [&mut z]);
        assert!(
            matches!(
                refused,
                Err(Error::Parameter {
                    name: "first sample",
                    ..
                })
            ),
            "{refused:?}"
        );
        // Nothing was put out.
        assert_eq!(z, [Complex::ONE; 2]);
    }
}

#[test]
fn the_host_names_beam_sample_and_element() {
    let mut x = Array3::from_elem((3, 4, 5), Complex::ONE);
    x[[1, 2, 3]].im = f32::NAN;
    let all = Active { first: 0, count: 5 };
    for covariance in COVARIANCES {
        let refused = host_sim::drive::beamform::beamform(
            x.view(),
            |_, _| all,
            Parameters::default(),
            covariance,
            |_| {},
        );
        let error = refused.expect_err("a NaN sample");
        assert_eq!(error.exit_status(), 1);
        let message = error.to_string();
        assert_eq!(
            message,
            "aligned sample [beam 1, sample 2, element 3] is NaN or infinite"
        );
    }
}

#[test]
fn more_runs_than_lanes_or_fewer_outputs() {
    let x = [Complex::ONE; 40];
    let run = Run {
        line: AlignedLine::new(&x, 8).expect("finite"),
        first_element: 0,
        first_sample: 0,
    };
    let mut workspace = Workspace::<8, 4, 0>::new();
    let beamformer = Beamformer::new(Parameters::default()).expect("valid");
    let mut z = [Complex::I; 5];
    let refused = beamformer.runs(&mut workspace.view(), &[run; 2], 8, &mut [&mut z, &mut []]);
    let name = "runs";
    let (actual, capacity) = (2, 1);
    assert_eq!(
        refused,
        Err(Error::Capacity {
            name,
            actual,
            capacity
        })
    );
    let refused = beamformer.runs(&mut workspace.view(), &[run], 8, &mut []);
    let (name, actual, expected) = ("z", 0, 1);
    assert_eq!(
        refused,
        Err(Error::Length {
            name,
            actual,
            expected
        })
    );
    assert_eq!(z, [Complex::I; 5]);
}

/// The formula of the workspace's documentation, with `s` numbers a scalar.
fn assert_bytes<A: Storage<L, K>, const M: usize, const L: usize, const K: usize>(s: usize) {
    // Lag sums of a sample, counted entry by entry: on and below the diagonal, or of those the upper half
    // of each diagonal.
    let kept = |lag: usize| {
        let entries = L - lag;
        if s == 2 { entries } else { entries.div_ceil(2) }
    };
    let set: usize = (0..L).map(kept).sum();
    let sets = if K == 0 { 1 } else { 2 * K + 2 };
    let complex = M + (5 + K) * L + sets * set;
    let lengths = Workspace::<M, L, K, A>::SIZES.lengths(A::COVARIANCE);
    assert_eq!(lengths.complex, complex, "M = {M}, L = {L}, K = {K}");
    assert_eq!(
        (lengths.reals, lengths.floats, lengths.indices),
        (5 * L, 3 * L, L)
    );
    let formula = 8 * complex
        + 4 * s * lengths.scalars
        + 4 * (lengths.reals + lengths.floats)
        + size_of::<usize>() * lengths.indices;
    let more = Workspace::<M, L, K, A>::BYTES - formula;
    assert!(more < 8, "M = {M}, L = {L}, K = {K}: {more} more");
    // What a workspace took when matrix and factor were whole squares.
    let rows = K + 1 + (sets * set).div_ceil(L);
    let squares = 4 * (2 * s * L * L + 2 * M + 2 * L * rows + (13 + 6 * s) * L);
    let before = squares + 12 * L + L * size_of::<usize>();
    assert!(
        formula <= before,
        "M = {M}, L = {L}, K = {K}: {formula}, {before} before"
    );
}

#[test]
fn memory_is_what_the_documentation_says() {
    assert_bytes::<ForwardBackward, 4, 4, 0>(1);
    assert_bytes::<ForwardBackward, 32, 16, 2>(1);
    assert_bytes::<ForwardBackward, 128, 64, 10>(1);
    assert_bytes::<Forward, 7, 4, 0>(2);
    assert_bytes::<Forward, 33, 20, 1>(2);
    assert_bytes::<Forward, 128, 64, 10>(2);
}

/// Memory for 8 elements, L = 4 and K = 1, with one slice too short by one number, or none.
fn slices_of(short: &str) -> Result<(), Error> {
    let sizes = Sizes {
        elements: 8,
        subaperture: 4,
        temporal_half_window: 1,
    };
    let lengths = sizes.lengths(Covariance::Forward);
    let length = |name: &str, length: usize| length - usize::from(name == short);
    let zero = ComplexVector { re: 0.0, im: 0.0 };
    let slices: Slices<'_, Forward, f32> = Slices {
        complex: &mut vec![zero; length("complex", lengths.complex)],
        scalars: &mut vec![zero; length("scalars", lengths.scalars)],
        reals: &mut vec![0.0; length("reals", lengths.reals)],
        floats: &mut vec![0.0; length("floats", lengths.floats)],
        indices: &mut vec![0; length("indices", lengths.indices)],
    };
    WorkspaceView::new(0.0, sizes, slices).map(drop)
}

#[test]
fn a_slice_that_is_too_short_is_named() {
    assert_eq!(slices_of("none"), Ok(()));
    for slice in ["complex", "scalars", "reals", "floats", "indices"] {
        match slices_of(slice) {
            Err(Error::Length {
                name,
                actual,
                expected,
            }) => {
                assert!(name.contains(slice), "{name}");
                assert_eq!(actual + 1, expected, "{name}");
            }
            other => panic!("{slice}: {other:?}"),
        }
    }
}

#[test]
fn das_needs_no_memory() {
    let x: Vec<_> = (0..40).map(|k| Complex::new(k as f32, 1.0)).collect();
    let line = AlignedLine::new(&x, 8).expect("finite");
    let all = |_| Active { first: 0, count: 8 };
    let of = |method| {
        let beamformer = Beamformer::new(Parameters {
            method,
            ..Parameters::default()
        });
        let mut z = [Complex::ZERO; 5];
        let mut none = WorkspaceView::empty(0.0);
        let outcome = beamformer
            .expect("valid")
            .line(&mut none, line, all, &mut z);
        outcome.map(|()| z)
    };
    // The mean of 8n to 8n + 7.
    let means = [3.5, 11.5, 19.5, 27.5, 35.5].map(|re| Complex::new(re, 1.0));
    assert_eq!(of(Method::Das), Ok(means));
    assert!(matches!(of(Method::Mv), Err(Error::Capacity { .. })));
}
