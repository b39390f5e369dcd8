//! Cases that only a few methods meet.

use crate::common;
use crate::common::kit::*;
use bonebeam::beamform::{Method, Parameters};
use common::lines::core;

/// Two subapertures of seven elements without loading are of rank 2.
///
/// With the backward ones the rank is 4. In f32 a Cholesky factorisation fails.
#[test]
fn a_singular_covariance_takes_the_eigensolver() {
    for turn in [0.3, 0.7, 1.1] {
        let line = Line::from_fn(6, 8, |n, m| {
            Complex::from_polar(1.0 + n as f32, turn * (m * m + n * m) as f32)
        });
        for covariance in COVARIANCES {
            let z = |method| {
                let parameters = Parameters {
                    covariance,
                    diagonal_loading: 0.0,
                    subaperture_ratio: 0.9,
                    ..Parameters::of(method)
                };
                bits(&core(&line, parameters))
            };
            assert_eq!(
                z(Method::EsmvRank1),
                z(Method::EsmvRank(1)),
                "{covariance:?}"
            );
        }
    }
}

/// Constant time has no eigensolver: a noise-free wave gives 0 if its loaded covariance is singular in f32.
///
/// That is so for tiny loadings, and never from a thousandth on.
#[test]
fn steps_serve_a_wave_with_a_loading_of_a_thousandth() {
    let zeros = |elements, diagonal_loading| {
        let line = Line::from_fn(4, elements, |_, m| Complex::cis(0.7 * m as f32));
        COVARIANCES.map(|covariance| {
            let parameters = Parameters {
                covariance,
                diagonal_loading,
                ..Parameters::of(Method::EsmvRank1Steps(8))
            };
            let z = core(&line, parameters);
            z.iter().filter(|z| z.norm() == 0.0).count()
        })
    };
    for elements in [8, 32, 128] {
        assert_eq!(zeros(elements, 1e-3), [0, 0], "{elements}");
    }
    assert!(zeros(128, 1e-7).iter().all(|&zeros| zeros > 0));
}
