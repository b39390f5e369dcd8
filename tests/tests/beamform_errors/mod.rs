//! The errors of the beamformer and their contents, and its memory.

mod memory;

use crate::common;
use bonebeam::Error;
use bonebeam::beamform::{AlignedLine, Beamformer, Method, Parameters, Segment, Sizes, Workspace};
use bonebeam::covariance::Covariance;
use bonebeam::geometry::Active;
use bonebeam::memory::{Need, Scratch};
use bonebeam_drive::beamform::Memory;
use common::lines::COVARIANCES;
use common::refused::refused;
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
    assert_eq!(message, "rank is 0, expected at least 1 and at most 65536");
    for steps in [0, Method::MOST_STEPS + 1] {
        let message = refusal(Parameters {
            method: Method::EsmvRank1Steps(steps),
            ..Parameters::default()
        });
        assert_eq!(message, format!("power_steps is {steps}, expected 1 to 64"));
    }
    for diagonal_loading in [-0.05, f32::NAN, f32::INFINITY] {
        let message = refusal(Parameters {
            diagonal_loading,
            ..Parameters::default()
        });
        assert!(message.starts_with("diagonal_loading is "), "{message}");
    }
    // L is above M: the ratio is above 1.
    for subaperture_ratio in [0.0, -0.5, 1.01, f64::NAN] {
        let message = refusal(Parameters {
            subaperture_ratio,
            ..Parameters::default()
        });
        assert!(message.starts_with("subaperture_ratio is "), "{message}");
    }
}

#[test]
fn lines_that_are_empty_or_ragged() {
    let x = [Complex::ONE; 7];
    let none = refused(AlignedLine::new(&x, 0));
    assert!(none.starts_with("parameter elements 0"), "{none}");
    assert_eq!(
        refused(AlignedLine::new(&[], 4)),
        "length aligned samples 0 for 4"
    );
    // Less than one sample: the error expects one sample.
    for elements in [4, 8, usize::MAX] {
        let ragged = refused(AlignedLine::new(&x, elements));
        assert_eq!(ragged, format!("length aligned samples 7 for {elements}"));
    }
}

#[test]
fn a_subaperture_is_never_longer_than_its_aperture() {
    let beamformer = Beamformer::new(Parameters {
        subaperture_ratio: 1.0,
        ..Parameters::default()
    });
    let beamformer = beamformer.expect("valid");
    for count in [
        1,
        2,
        (1 << 53) + 1,
        usize::MAX / 2,
        usize::MAX - 1,
        usize::MAX,
    ] {
        let length = beamformer.subaperture(count);
        assert!(length >= 1 && length <= count, "{count}: {length}");
    }
}

/// `[M, L, K]`.
fn of([elements, subaperture, temporal_half_window]: [usize; 3]) -> Sizes {
    Sizes {
        covariance: Covariance::ForwardBackward,
        elements,
        subaperture,
        temporal_half_window,
        sub_lines: 1,
    }
}

fn memory(sizes: [usize; 3]) -> Memory<f32> {
    Memory::new(0.0, of(sizes)).expect("little memory")
}

/// A line of 5 samples of 8 elements through a workspace for 6 elements, L = 4 and K = 1.
fn run(parameters: Parameters, active: Active, length: usize) -> Result<(), Error> {
    let x = [Complex::ONE; 40];
    let line = AlignedLine::new(&x, 8)?;
    let mut workspace = memory([6, 4, 1]);
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
    // K longer than the record, up to the largest integer.
    assert_eq!(
        name(run(temporal_half_window(5), six, 5)),
        "parameter temporal_half_window"
    );
    assert_eq!(
        name(run(temporal_half_window(usize::MAX), six, 5)),
        "parameter temporal_half_window"
    );
    // A window longer than any record is refused before a record exists.
    assert!(Beamformer::new(temporal_half_window(4095)).is_ok());
    assert_eq!(
        name(Beamformer::new(temporal_half_window(4096)).map(drop)),
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
    let mut workspace = memory([6, 4, 0]);
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
fn a_segment_outside_its_line() {
    let x = [Complex::ONE; 40];
    let line = AlignedLine::new(&x, 8).expect("finite");
    let mut workspace = memory([8, 4, 0]);
    let beamformer = Beamformer::new(Parameters::default()).expect("valid");
    for first_sample in [4, 5, 6, usize::MAX] {
        let segment = Segment {
            line,
            first_element: 0,
            first_sample,
        };
        let mut z = [Complex::ONE; 2];
        let refused =
            refused(beamformer.segments(&mut workspace.view(), &[segment], 8, &mut [&mut z]));
        assert!(refused.starts_with("parameter first sample "), "{refused}");
        // No output was written.
        assert_eq!(z, [Complex::ONE; 2]);
    }
}

#[test]
fn the_host_names_beam_sample_and_element() {
    let mut x = Array3::from_elem((3, 4, 5), Complex::ONE);
    x[[1, 2, 3]].im = f32::NAN;
    let all = Active { first: 0, count: 5 };
    for covariance in COVARIANCES {
        let refused = bonebeam_drive::beamform::beamform(
            x.view(),
            &|_, _| all,
            Parameters {
                covariance,
                ..Parameters::default()
            },
            &|_| {},
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
fn more_segments_than_lanes_or_fewer_outputs() {
    let x = [Complex::ONE; 40];
    let segment = Segment {
        line: AlignedLine::new(&x, 8).expect("finite"),
        first_element: 0,
        first_sample: 0,
    };
    let mut workspace = memory([8, 4, 0]);
    let beamformer = Beamformer::new(Parameters::default()).expect("valid");
    let mut z = [Complex::I; 5];
    let two = beamformer.segments(
        &mut workspace.view(),
        &[segment; 2],
        8,
        &mut [&mut z, &mut []],
    );
    assert_eq!(refused(two), "capacity segments 2 over 1");
    let one = beamformer.segments(&mut workspace.view(), &[segment], 8, &mut []);
    assert_eq!(refused(one), "length z 0 for 1");
    assert_eq!(z, [Complex::I; 5]);
}

/// K is refused with and without segments.
#[test]
fn no_segments_and_a_window_beyond_the_memory() {
    let mut workspace = memory([6, 4, 1]);
    for temporal_half_window in [2, 100, 4095] {
        let parameters = Parameters {
            temporal_half_window,
            ..Parameters::default()
        };
        let beamformer = Beamformer::new(parameters).expect("valid");
        let none = beamformer.segments(&mut workspace.view(), &[], 4, &mut []);
        let expected = format!("capacity temporal_half_window {temporal_half_window} over 1");
        assert_eq!(refused(none), expected);
    }
}

#[test]
fn a_segment_of_no_samples_ends_with_its_line() {
    let x = [Complex::ONE; 40];
    let segment = Segment {
        line: AlignedLine::new(&x, 8).expect("finite"),
        first_element: 0,
        first_sample: 5,
    };
    let mut workspace = memory([8, 4, 0]);
    let beamformer = Beamformer::new(Parameters::default()).expect("valid");
    let done = beamformer.segments(&mut workspace.view(), &[segment], 8, &mut [&mut []]);
    assert_eq!(done, Ok(()));
}

/// With one active set; each change of the set costs one more call a pass.
#[test]
fn each_sample_is_asked_twice_for_its_active_set() {
    let x = [Complex::ONE; 40];
    let line = AlignedLine::new(&x, 8).expect("finite");
    let beamformer = Beamformer::new(Parameters::default()).expect("valid");
    let mut workspace = memory([8, 4, 0]);
    let asked = [const { std::cell::Cell::new(0) }; 5];
    let all = |n: usize| {
        asked[n].set(asked[n].get() + 1);
        Active { first: 0, count: 8 }
    };
    let mut z = [Complex::ZERO; 5];
    assert_eq!(
        beamformer.line(&mut workspace.view(), line, all, &mut z),
        Ok(())
    );
    assert_eq!(asked.map(|asked| asked.get()), [2; 5]);
}
