//! Types of values, and enums of names.

use std::path::PathBuf;

use bonebeam::beamform::{Apodization, Postfilter};
use bonebeam::covariance::Covariance;

use super::Range;
use crate::terminal::short;

/// A type of a key's value.
pub trait Value: Sized {
    /// Whether a flag without a value sets it.
    const SWITCH: bool = false;
    /// Whether it is a list, whose items are separated by commas.
    const LIST: bool = false;

    /// The names of a choice, each with its help.
    fn choices() -> Vec<[&'static str; 2]> {
        Vec::new()
    }

    /// Its type in Python.
    fn python() -> String {
        let names: Vec<_> = Self::choices()
            .iter()
            .map(|c| format!("\"{}\"", c[0]))
            .collect();
        format!("Literal[{}]", names.join(", "))
    }

    /// Reads the value of a flag.
    ///
    /// # Errors
    /// The reason, for people.
    fn read(text: &str) -> Result<Self, String>;

    /// Whether a file leaves the key out.
    fn absent(&self) -> bool {
        false
    }

    /// The value as text for `--help`, if it is a default that is worth stating.
    fn stated(&self) -> Option<String> {
        None
    }

    /// The value as text, if it is outside the range.
    fn outside(&self, _: &Range) -> Option<String> {
        None
    }
}

macro_rules! numbers {
    ($($number:ty, $python:literal;)*) => {$(
        impl Value for $number {
            fn python() -> String {
                $python.into()
            }

            fn read(text: &str) -> Result<Self, String> {
                text.parse().map_err(|e: <$number as std::str::FromStr>::Err| e.to_string())
            }

            fn stated(&self) -> Option<String> {
                Some(short(self))
            }

            fn outside(&self, range: &Range) -> Option<String> {
                (!range.contains(*self as f64)).then(|| short(self))
            }
        }
    )*};
}

numbers! {
    f64, "float";
    usize, "int";
    u32, "int";
    u64, "int";
}

impl Value for bool {
    const SWITCH: bool = true;

    fn python() -> String {
        "bool".into()
    }

    fn read(text: &str) -> Result<Self, String> {
        Ok(text == "true")
    }
}

impl Value for PathBuf {
    fn python() -> String {
        "str".into()
    }

    fn read(text: &str) -> Result<Self, String> {
        Ok(text.into())
    }
}

impl<T: Value> Value for Option<T> {
    const SWITCH: bool = T::SWITCH;
    const LIST: bool = T::LIST;

    fn choices() -> Vec<[&'static str; 2]> {
        T::choices()
    }

    fn python() -> String {
        format!("{} | None", T::python())
    }

    fn read(text: &str) -> Result<Self, String> {
        T::read(text).map(Some)
    }

    fn absent(&self) -> bool {
        self.is_none()
    }

    fn outside(&self, range: &Range) -> Option<String> {
        self.as_ref()?.outside(range)
    }
}

impl Value for Vec<f64> {
    const LIST: bool = true;

    fn python() -> String {
        "Sequence[float]".into()
    }

    fn read(text: &str) -> Result<Self, String> {
        text.split(',').map(number_or_power).collect()
    }

    fn absent(&self) -> bool {
        self.is_empty()
    }

    fn outside(&self, range: &Range) -> Option<String> {
        self.iter().find_map(|value| value.outside(range))
    }
}

/// Parses a number: `2^-7` or `0.0078125`.
///
/// # Errors
/// The expected forms.
pub fn number_or_power(text: &str) -> Result<f64, String> {
    let value = match text.strip_prefix("2^") {
        Some(exponent) => exponent.parse().ok().map(f64::exp2),
        None => text.parse().ok(),
    };
    value.ok_or_else(|| "expected a power of two such as 2^-7, or a decimal number".into())
}

/// The value of a choice by its name.
#[doc(hidden)]
pub fn chosen<'a, T>(text: &str, all: impl IntoIterator<Item = (T, &'a str)>) -> Result<T, String> {
    let found = all.into_iter().find(|(_, name)| *name == text);
    found
        .map(|(value, _)| value)
        .ok_or_else(|| format!("unknown name `{text}`"))
}

macro_rules! of_core {
    ($($choice:ty),*) => {$(
        impl Value for $choice {
            fn choices() -> Vec<[&'static str; 2]> {
                Self::EXAMPLES.iter().map(|one| [one.key(), one.help()]).collect()
            }

            fn read(text: &str) -> Result<Self, String> {
                chosen(text, Self::EXAMPLES.map(|one| (one, one.key())))
            }
        }
    )*};
}

of_core!(Postfilter, Apodization);

impl Value for Covariance {
    fn choices() -> Vec<[&'static str; 2]> {
        vec![
            ["forward", "`R` of Eq. 2, as in the paper's figures"],
            ["forward-backward", "`R_FB` of Eq. 3, the default"],
        ]
    }

    fn read(text: &str) -> Result<Self, String> {
        let all = [Covariance::Forward, Covariance::ForwardBackward];
        chosen(text, all.into_iter().zip(["forward", "forward-backward"]))
    }
}

/// An enum of names for files, flags and Python; a doc comment is the help of its flag.
#[macro_export]
macro_rules! choice {
    (
        $(#[$about:meta])*
        $type:ident $(= $usual:ident)? {
            $(
                $(#[doc = $doc:literal])*
                $variant:ident = $name:literal,
            )*
        }
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
        pub enum $type {
            $(
                $(#[doc = $doc])*
                #[serde(rename = $name)]
                $variant,
            )*
        }

        impl $type {
            /// All values, in order.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$variant),*];

            /// The name in files, flags and Python.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }

        $(impl Default for $type {
            fn default() -> Self {
                Self::$usual
            }
        })?

        impl std::fmt::Display for $type {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(self.name())
            }
        }

        impl $crate::section::Value for $type {
            fn choices() -> Vec<[&'static str; 2]> {
                vec![$([$name, [$($doc),*][0].trim()]),*]
            }

            fn read(text: &str) -> std::result::Result<Self, String> {
                $crate::section::chosen(text, Self::ALL.map(|one| (one, one.name())))
            }

            fn stated(&self) -> Option<String> {
                Some(self.name().into())
            }
        }
    };
}
