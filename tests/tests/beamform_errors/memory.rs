//! Memory: what it takes, and where it is too little.

use super::*;

/// A workspace takes what the documentation says.
fn assert_bytes<const M: usize, const L: usize, const K: usize, A: Storage<L, K>>(
    s: usize,
    lag_sums: usize,
    basis: usize,
) {
    let sets = if K == 0 { 1 } else { 2 * K + 2 };
    let lengths = Workspace::<M, L, K, A>::SIZES.lengths(A::COVARIANCE);
    assert_eq!(lengths.complex, M + (5 + K) * L + sets * lag_sums);
    assert_eq!(lengths.scalars, L * L + 10 * L + basis);
    assert_eq!(lengths.reals, 5 * L);
    let formula = 8 * lengths.complex + 4 * s * lengths.scalars + 4 * lengths.reals;
    assert_eq!(Workspace::<M, L, K, A>::BYTES, formula);
}

#[test]
fn memory_is_what_the_documentation_says() {
    assert_bytes::<4, 4, 0, ForwardBackward>(1, 6, 0);
    // With L = 8 the Lanczos basis is longer than a factor.
    assert_bytes::<16, 8, 2, ForwardBackward>(1, 20, 8);
    assert_bytes::<32, 16, 2, ForwardBackward>(1, 72, 0);
    assert_bytes::<128, 64, 10, ForwardBackward>(1, 32 * 33, 0);
    assert_bytes::<7, 4, 0, Forward>(2, 10, 0);
    assert_bytes::<33, 20, 3, Forward>(2, 210, 0);
    assert_bytes::<256, 128, 10, Forward>(2, 64 * 129, 0);
}

/// A line through slices for 6 elements, L = 3 and K = 1, each shorter than it has to be by so many.
fn short(by: [usize; 3]) -> Result<(), Error> {
    let sizes = Sizes {
        elements: 6,
        subaperture: 3,
        temporal_half_window: 1,
    };
    let lengths = sizes.lengths(Covariance::Forward);
    let mut complex = vec![ComplexVector::from_real(0.0f32); lengths.complex - by[0]];
    let mut scalars = vec![Forward::scalar(0.0f32); lengths.scalars - by[1]];
    let mut reals = vec![0.0; lengths.reals - by[2]];
    let slices = Slices {
        complex: &mut complex,
        scalars: &mut scalars,
        reals: &mut reals,
    };
    let mut view = WorkspaceView::<Forward>::new(0.0, sizes, slices)?;
    assert_eq!(view.sizes(), sizes);
    let x = [Complex::ONE; 40];
    let parameters = Parameters {
        temporal_half_window: 1,
        ..Parameters::default()
    };
    let six = Active { first: 0, count: 6 };
    let mut z = [Complex::ZERO; 5];
    Beamformer::new(parameters)?.line(&mut view, AlignedLine::new(&x, 8)?, |_| six, &mut z)
}

#[test]
fn slices_that_are_too_short() {
    assert_eq!(short([0; 3]), Ok(()));
    let names = ["complex", "scalars", "reals"];
    for (slice, name) in names.into_iter().enumerate() {
        let mut by = [0; 3];
        by[slice] = 1;
        let message = short(by).expect_err("a short slice").to_string();
        assert!(
            message.starts_with(&format!("slice `{name}` has length ")),
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
        let [elements, subaperture, temporal_half_window] = sizes;
        let sizes = Sizes {
            elements,
            subaperture,
            temporal_half_window,
        };
        for covariance in [Covariance::Forward, Covariance::ForwardBackward] {
            let lengths = sizes.lengths(covariance);
            assert!(lengths.complex >= 1 << 40, "{sizes:?}: {lengths:?}");
        }
        let refused = Memory::<Forward, f32>::new(0.0, sizes);
        let error = refused.err().expect("more than there is");
        assert_eq!(error.exit_status(), 2, "{error}");
        assert!(
            error.to_string().contains("temporal_half_window"),
            "{error}"
        );
    }
}

#[test]
fn das_needs_no_memory() {
    let x = [Complex::new(2.0, -1.0); 40];
    let line = AlignedLine::new(&x, 8).expect("finite");
    let all = |_| Active { first: 0, count: 8 };
    let mut view = WorkspaceView::empty(0.0f32);
    let beamformer = |method| {
        Beamformer::new(Parameters {
            method,
            ..Parameters::default()
        })
        .expect("valid")
    };
    let das = beamformer(Method::Das);
    assert_eq!(das.sizes(8), Sizes::default());
    let mut z = [Complex::ZERO; 5];
    assert_eq!(das.line(&mut view, line, all, &mut z), Ok(()));
    assert_eq!(z, [Complex::new(2.0, -1.0); 5]);
    let mut weights = [Complex::ZERO; 8];
    assert_eq!(das.weights(&mut view, line, all(0), 2, &mut weights), Ok(8));
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

/// Nor do samples without an active element, wherever their empty set is said to begin.
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
        let mut view = WorkspaceView::empty(0.0f32);
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
    let mut workspace = Workspace::<6, 4, 0>::new();
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
    // The mean of the elements, which are alike.
    assert_eq!(z[3..], [Complex::ONE; 2]);
}
