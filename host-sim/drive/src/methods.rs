//! Beamformers by name: those for the command line, and those that are compared.
//!
//! A method of the core needs a [`MethodName`], with its keys, for the command line and the configuration, which
//! the compiler enforces, and a row of [`COMPARED`] to be in figures, tables and checks.

use bonebeam::beamform::Method;
use bonebeam_files::choice;

choice! {
    /// Name of a beamformer: the value of `--method` and of the key `method`.
    MethodName {
        /// Delay and sum
        Das = "das",
        /// Minimum variance (Capon)
        Mv = "mv",
        /// Eigenspace minimum variance, by β or by a fixed rank
        Esmv = "esmv",
        /// Eigenspace minimum variance with a signal subspace of rank 1
        EsmvRank1 = "esmv-rank1",
    }
}

/// A beamformer that is compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComparedMethod {
    /// Its name in files and in the report's data.
    pub key: &'static str,
    /// Its name in tables.
    pub name: &'static str,
    /// The core's method.
    pub method: Method,
    /// Whether the paper's claims are about it.
    ///
    /// It is first among the pictures, beside the paper's figures, and on top of the other curves.
    pub featured: bool,
}

/// The compared beamformers, in the order of tables and pictures.
///
/// They are those of the paper's figures. The first is the reference for levels.
pub const COMPARED: [ComparedMethod; 7] = [
    ComparedMethod {
        featured: true,
        ..compared("das", "DAS", Method::Das)
    },
    compared("mv", "MV", Method::Mv),
    compared("esmv-10", "ESMV β = 10 %", Method::EsmvBeta(0.1)),
    compared("esmv-1", "ESMV β = 1 %", Method::EsmvBeta(0.01)),
    compared("esmv-0.001", "ESMV β = 0.001 %", Method::EsmvBeta(1e-5)),
    ComparedMethod {
        featured: true,
        ..compared("esmv-rank1", "ESMV rank 1", Method::EsmvRank1)
    },
    compared(
        "esmv-without-first",
        "ESMV without λ₁",
        Method::EsmvExcludeFirst,
    ),
];

const fn compared(key: &'static str, name: &'static str, method: Method) -> ComparedMethod {
    ComparedMethod {
        key,
        name,
        method,
        featured: false,
    }
}

impl MethodName {
    /// Keys of [`Beamform`](crate::config::Beamform) that only this method accepts.
    pub fn takes(self) -> &'static [&'static str] {
        match self {
            MethodName::Das | MethodName::Mv => &[],
            MethodName::Esmv => &["beta", "rank"],
            MethodName::EsmvRank1 => &["exclude_first", "power_steps"],
        }
    }
}

/// Default β of ESMV if neither β nor a rank is given.
pub fn default_beta() -> f64 {
    let row = Method::EsmvBeta(1.0).parameter();
    row.expect("a method with an argument").default
}
