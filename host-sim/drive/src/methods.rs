//! Beamformers by name: those for the command line, and those that are compared.
//!
//! A method of the core needs a [`MethodName`] with [`Options`] for the command line and the configuration, which
//! the compiler enforces, and a row of [`COMPARED`] to be in figures, tables and checks.

use bonebeam::beamform::Method;
use bonebeam_files::choice;

/// Extra parameters of some methods: configuration keys and flags.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// β of the cross-spectral rank rule (Eq. 8).
    pub beta: Option<f64>,
    /// A fixed rank of the signal subspace.
    pub rank: Option<usize>,
    /// All eigenvectors but the first (Fig. 2c).
    pub exclude_first: bool,
    /// Steps of power iteration, in place of an eigenvector accurate to f32.
    pub power_steps: Option<usize>,
}

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
    /// Keys of [`Options`] that the method accepts.
    pub fn takes(self) -> &'static [&'static str] {
        match self {
            MethodName::Das | MethodName::Mv => &[],
            MethodName::Esmv => &["beta", "rank"],
            MethodName::EsmvRank1 => &["exclude_first", "power_steps"],
        }
    }

    /// The core's method.
    pub fn method(self, options: &Options) -> Method {
        match (self, *options) {
            (MethodName::Das, _) => Method::Das,
            (MethodName::Mv, _) => Method::Mv,
            (
                MethodName::Esmv,
                Options {
                    rank: Some(rank), ..
                },
            ) => Method::EsmvRank(rank),
            (MethodName::Esmv, Options { beta, .. }) => {
                Method::EsmvBeta(beta.unwrap_or(default_beta()) as f32)
            }
            (MethodName::EsmvRank1, options) => {
                match (options.exclude_first, options.power_steps) {
                    (true, _) => Method::EsmvExcludeFirst,
                    (false, Some(steps)) => Method::EsmvRank1Steps(steps),
                    (false, None) => Method::EsmvRank1,
                }
            }
        }
    }

    /// Name and options of a method of the core.
    pub fn of(method: Method) -> (Self, Options) {
        let mut options = Options::default();
        let choice = match method {
            Method::Das => MethodName::Das,
            Method::Mv => MethodName::Mv,
            Method::EsmvBeta(beta) => {
                options.beta = Some(crate::config::plain(beta));
                MethodName::Esmv
            }
            Method::EsmvRank(rank) => {
                options.rank = Some(rank);
                MethodName::Esmv
            }
            Method::EsmvRank1 => MethodName::EsmvRank1,
            Method::EsmvRank1Steps(steps) => {
                options.power_steps = Some(steps);
                MethodName::EsmvRank1
            }
            Method::EsmvExcludeFirst => {
                options.exclude_first = true;
                MethodName::EsmvRank1
            }
        };
        (choice, options)
    }
}

/// Default β of ESMV if neither β nor a rank is given.
pub fn default_beta() -> f64 {
    let row = Method::EsmvBeta(1.0).parameter();
    row.expect("a method with an argument").default
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_of_the_core_can_be_asked_for() {
        for method in Method::EXAMPLES {
            let (choice, options) = MethodName::of(method);
            assert_eq!(choice.method(&options), method);
            assert!(MethodName::ALL.contains(&choice));
        }
    }
}
