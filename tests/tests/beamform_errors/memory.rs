//! Memory: the required sizes, and errors if it is too small.

use super::*;

/// Asserts that a workspace needs the documented memory.
fn assert_need(sizes: [usize; 3], covariance: Covariance, lag_sums: usize, basis: usize) {
    let [m, l, k] = sizes;
    let sets = if k == 0 { 1 } else { 2 * k + 2 };
    let scalars = l * l + 10 * l + basis;
    let mut expected = Need {
        real: 5 * l,
        complex: m + (5 + k) * l + sets * lag_sums,
    };
    match covariance {
        Covariance::Forward => expected.complex += scalars,
        Covariance::ForwardBackward => expected.real += scalars,
    }
    let sizes = Sizes {
        covariance,
        ..of(sizes)
    };
    assert_eq!(sizes.need(), expected);
}

#[test]
fn memory_is_what_the_documentation_says() {
    let (both, forward) = (Covariance::ForwardBackward, Covariance::Forward);
    assert_need([4, 4, 0], both, 6, 0);
    // With L = 8 the Lanczos basis is longer than a factor.
    assert_need([16, 8, 2], both, 20, 8);
    assert_need([32, 16, 2], both, 72, 0);
    assert_need([128, 64, 10], both, 32 * 33, 0);
    assert_need([7, 4, 0], forward, 10, 0);
    assert_need([33, 20, 3], forward, 210, 0);
    assert_need([256, 128, 10], forward, 64 * 129, 0);
}

/// A line through slices for 6 elements, L = 3 and K = 1, each shorter by `by`.
fn short(by: [usize; 2]) -> Result<(), Error> {
    let covariance = Covariance::Forward;
    let sizes = Sizes {
        covariance,
        ..of([6, 3, 1])
    };
    let need = sizes.need();
    let scratch = Scratch {
        real: &mut vec![0.0; need.real - by[0]],
        complex: &mut vec![Complex::ZERO; need.complex - by[1]],
    };
    let mut view = Workspace::new(0.0, sizes, scratch)?;
    assert_eq!(view.sizes(), sizes);
    let x = [Complex::ONE; 40];
    let parameters = Parameters {
        covariance,
        temporal_half_window: 1,
        ..Parameters::default()
    };
    let six = Active { first: 0, count: 6 };
    let mut z = [Complex::ZERO; 5];
    Beamformer::new(parameters)?.line(&mut view, AlignedLine::new(&x, 8)?, |_| six, &mut z)
}

#[test]
fn slices_that_are_too_short() {
    assert_eq!(short([0; 2]), Ok(()));
    let names = ["real", "complex"];
    for (slice, name) in names.into_iter().enumerate() {
        let mut by = [0; 2];
        by[slice] = 1;
        let message = short(by).expect_err("a short slice").to_string();
        assert!(
            message.starts_with(&format!("{name} memory has length ")),
            "{message}"
        );
    }
}

#[test]
fn sizes_that_no_memory_has() {
    for sizes in [
        [usize::MAX, 4, 0],
        [4, usize::MAX, 0],
        [4, 4, usize::MAX],
        [usize::MAX; 3],
        [1 << 40, 1 << 40, 1 << 40],
    ] {
        for covariance in COVARIANCES {
            let sizes = Sizes {
                covariance,
                ..of(sizes)
            };
            let need = sizes.need();
            assert!(need.complex >= 1 << 40, "{sizes:?}: {need:?}");
            let refused = Memory::new(0.0, sizes);
            let error = refused.err().expect("more than there is");
            assert_eq!(error.exit_status(), 2, "{error}");
            assert!(
                error.to_string().contains("temporal_half_window"),
                "{error}"
            );
        }
    }
}

#[test]
fn a_workspace_of_another_covariance_is_refused() {
    let x = [Complex::ONE; 40];
    let line = AlignedLine::new(&x, 8).expect("finite");
    let all = |_| Active { first: 0, count: 8 };
    for covariance in COVARIANCES {
        let parameters = Parameters {
            covariance,
            ..Parameters::default()
        };
        let beamformer = Beamformer::new(parameters).expect("valid");
        for other in COVARIANCES {
            let sizes = Sizes {
                covariance: other,
                ..of([8, 4, 0])
            };
            let mut memory = Memory::new(0.0, sizes).expect("little memory");
            let mut z = [Complex::I; 5];
            let done = beamformer.line(&mut memory.view(), line, all, &mut z);
            if other == covariance {
                assert_eq!(done, Ok(()));
                continue;
            }
            let expected = "that of the workspace";
            let name = "covariance";
            let value = f64::from(covariance as u8);
            assert_eq!(
                done,
                Err(Error::Parameter {
                    name,
                    value,
                    expected
                })
            );
            assert_eq!(z, [Complex::I; 5]);
        }
    }
}

#[test]
fn das_needs_no_memory() {
    let x = [Complex::new(2.0, -1.0); 40];
    let line = AlignedLine::new(&x, 8).expect("finite");
    let all = |_| Active { first: 0, count: 8 };
    let mut memory = memory([0; 3]);
    let mut view = memory.view();
    let beamformer = |method| {
        Beamformer::new(Parameters {
            method,
            ..Parameters::default()
        })
        .expect("valid")
    };
    let das = beamformer(Method::Das);
    let none = Sizes {
        sub_lines: 1,
        ..Sizes::default()
    };
    assert_eq!(das.sizes(8), none);
    let mut z = [Complex::ZERO; 5];
    assert_eq!(das.line(&mut view, line, all, &mut z), Ok(()));
    assert_eq!(z, [Complex::new(2.0, -1.0); 5]);
    let mut weights = [Complex::ZERO; 8];
    let segment = Segment {
        line,
        first_element: 0,
        first_sample: 2,
    };
    assert_eq!(das.weights(&mut view, &segment, 8, &mut weights), Ok(8));
    assert_eq!(weights, [Complex::new(0.125, 0.0); 8]);
    let refused = beamformer(Method::Mv).line(&mut view, line, all, &mut z);
    let (name, actual, capacity) = ("active elements", 8, 0);
    assert_eq!(
        refused,
        Err(Error::Capacity {
            name,
            actual,
            capacity
        })
    );
}

/// Nor do samples without an active element, for any start of their empty set.
#[test]
fn no_active_element_needs_no_memory() {
    let x = [Complex::ONE; 40];
    let line = AlignedLine::new(&x, 8).expect("finite");
    let beamformer = Beamformer::new(Parameters {
        temporal_half_window: 1,
        ..Parameters::default()
    });
    let beamformer = beamformer.expect("valid");
    for first in [0, 8] {
        let none = |_| Active { first, count: 0 };
        let mut memory = memory([0; 3]);
        let mut view = memory.view();
        let mut z = [Complex::I; 5];
        assert_eq!(beamformer.line(&mut view, line, none, &mut z), Ok(()));
        assert_eq!(z, [Complex::ZERO; 5]);
        let mut z = [Complex::I; 5];
        let done = beamformer.line_within(&mut view, line, none, 1..4, &mut z);
        assert_eq!(done, Ok(()));
        assert_eq!(z, [Complex::ZERO; 5]);
    }
}

#[test]
fn memory_fits_what_is_within_or_nothing_is_put_out() {
    let x = [Complex::ONE; 40];
    let line = AlignedLine::new(&x, 8).expect("finite");
    let beamformer = Beamformer::new(Parameters::default()).expect("valid");
    let mut workspace = memory([6, 4, 0]);
    let active = |n| Active {
        first: 0,
        count: if n < 3 { 6 } else { 7 },
    };
    let mut z = [Complex::I; 5];
    let refused = beamformer.line_within(&mut workspace.view(), line, active, 0..4, &mut z);
    assert!(matches!(refused, Err(Error::Capacity { .. })));
    assert_eq!(z, [Complex::I; 5]);
    let done = beamformer.line_within(&mut workspace.view(), line, active, 0..3, &mut z);
    assert_eq!(done, Ok(()));
    // The mean of the elements, which are equal.
    assert_eq!(z[3..], [Complex::ONE; 2]);
}
