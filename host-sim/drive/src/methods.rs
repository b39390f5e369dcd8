//! The beamformers by name: those that can be asked for, and those that are compared.
//!
//! A method of the core is one row here for the command line and the configuration, and one more to
//! stand in the figures, the tables and the checks.

use std::fmt;

use bonebeam::beamform::Method;
use clap::ValueEnum;
use clap::builder::PossibleValue;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// What some methods are told beside their name: keys of the configuration and flags.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// β of the cross-spectral rank rule (Eq. 8).
    pub beta: Option<f64>,
    /// A fixed rank of the signal subspace.
    pub rank: Option<usize>,
    /// All eigenvectors but the first (Fig. 2c).
    pub exclude_first: bool,
    /// Steps of power iteration in place of the eigenvector to f32's accuracy.
    pub power_steps: Option<usize>,
}

/// A beamformer that can be asked for by name.
#[derive(Clone, Copy)]
pub struct Choice {
    /// The value of `--method` and of the key `method`.
    pub name: &'static str,
    /// What it is, for the command's help.
    help: &'static str,
    /// The keys of [`Options`] that it takes.
    pub takes: &'static [&'static str],
    /// The core's method.
    pub method: fn(&Options) -> Method,
}

/// Every beamformer that can be asked for.
pub const CHOICES: [Choice; 4] = [
    Choice {
        name: "das",
        help: "Delay and sum",
        takes: &[],
        method: |_| Method::Das,
    },
    Choice {
        name: "mv",
        help: "Minimum variance (Capon)",
        takes: &[],
        method: |_| Method::Mv,
    },
    Choice {
        name: "esmv",
        help: "Eigenspace minimum variance, by β or by a fixed rank",
        takes: &["beta", "rank"],
        method: |options| match options.rank {
            Some(rank) => Method::EsmvRank(rank),
            None => Method::EsmvBeta(options.beta.unwrap_or(default_beta()) as f32),
        },
    },
    Choice {
        name: "esmv-rank1",
        help: "Eigenspace minimum variance with a signal subspace of rank 1",
        takes: &["exclude_first", "power_steps"],
        method: |options| match (options.exclude_first, options.power_steps) {
            (true, _) => Method::EsmvExcludeFirst,
            (false, Some(steps)) => Method::EsmvRank1Steps(steps),
            (false, None) => Method::EsmvRank1,
        },
    },
];

/// One of the beamformers that are compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compared {
    /// Its name in files and in the report's data.
    pub key: &'static str,
    /// Its name for people.
    pub name: &'static str,
    /// The core's method.
    pub method: Method,
    /// Whether the paper's claims are about it: it stands first among the pictures, beside the
    /// paper's figures, and over the other curves.
    pub featured: bool,
}

/// The beamformers that the paper's figures compare, in the order of tables and pictures. The first
/// is the reference for levels.
pub const COMPARED: [Compared; 7] = [
    Compared {
        featured: true,
        ..compared("das", "DAS", Method::Das)
    },
    compared("mv", "MV", Method::Mv),
    compared("esmv-10", "ESMV β = 10 %", Method::EsmvBeta(0.1)),
    compared("esmv-1", "ESMV β = 1 %", Method::EsmvBeta(0.01)),
    compared("esmv-0.001", "ESMV β = 0.001 %", Method::EsmvBeta(1e-5)),
    Compared {
        featured: true,
        ..compared("esmv-rank1", "ESMV rank 1", Method::EsmvRank1)
    },
    compared(
        "esmv-without-first",
        "ESMV without λ₁",
        Method::EsmvExcludeFirst,
    ),
];

const fn compared(key: &'static str, name: &'static str, method: Method) -> Compared {
    Compared {
        key,
        name,
        method,
        featured: false,
    }
}

impl Choice {
    /// The beamformer of this name.
    pub fn named(name: &str) -> Option<Self> {
        CHOICES.into_iter().find(|choice| choice.name == name)
    }

    /// The name of a method of the core, and what is told beside it.
    pub fn of(method: Method) -> (&'static str, Options) {
        let none = Options::default();
        match method {
            Method::Das => ("das", none),
            Method::Mv => ("mv", none),
            Method::EsmvBeta(beta) => {
                let beta = Some(crate::config::plain(beta.into()));
                ("esmv", Options { beta, ..none })
            }
            Method::EsmvRank(rank) => {
                let rank = Some(rank);
                ("esmv", Options { rank, ..none })
            }
            Method::EsmvRank1 => ("esmv-rank1", none),
            Method::EsmvRank1Steps(steps) => {
                let power_steps = Some(steps);
                (
                    "esmv-rank1",
                    Options {
                        power_steps,
                        ..none
                    },
                )
            }
            Method::EsmvExcludeFirst => {
                let exclude_first = true;
                (
                    "esmv-rank1",
                    Options {
                        exclude_first,
                        ..none
                    },
                )
            }
        }
    }
}

/// β where ESMV is asked for with neither β nor a rank.
pub fn default_beta() -> f64 {
    let row = Method::EsmvBeta(1.0).parameter();
    row.expect("a method with an argument").default
}

impl PartialEq for Choice {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl fmt::Debug for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

impl Serialize for Choice {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name)
    }
}

impl<'de> Deserialize<'de> for Choice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        Choice::named(&name).ok_or_else(|| {
            let known = CHOICES.map(|choice| choice.name).join(", ");
            let message = format!("unknown method `{name}`, expected one of {known}");
            serde::de::Error::custom(message)
        })
    }
}

impl ValueEnum for Choice {
    fn value_variants<'a>() -> &'a [Self] {
        &CHOICES
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name).help(self.help))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_of_the_core_can_be_asked_for() {
        for method in Method::EXAMPLES {
            let (name, options) = Choice::of(method);
            let choice = Choice::named(name).expect("a row of the table");
            assert_eq!((choice.method)(&options), method);
        }
    }
}
