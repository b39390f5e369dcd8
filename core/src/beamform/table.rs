//! Tables of parameters, methods and postfilters, the source of all other lists.
//!
//! A row of `choices!` is a variant of an enum. A row of `parameters!` (in `parameters.rs`) is a field of
//! [`Parameters`](super::Parameters). Lists made from rows are complete.

use crate::Error;

/// One parameter: its name, its help text, its default and its range.
///
/// ```
/// use bonebeam::beamform::Parameters;
///
/// let loading = Parameters::TABLE.into_iter().find(|row| row.name == "diagonal_loading");
/// let loading = loading.expect("a row");
/// assert_eq!(loading.default, 0.05);
/// assert!(loading.check(-1.0).is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameter {
    /// The field name, also the configuration key and, with `-` for `_`, the flag.
    pub name: &'static str,
    /// The unit; empty for a plain number.
    pub unit: &'static str,
    /// The help text.
    pub help: &'static str,
    /// The value if none is given.
    pub default: f64,
    /// A usual value other than the default, for tests.
    pub example: f64,
    /// Whether the value is a whole number.
    pub whole: bool,
    /// The values that are accepted.
    pub range: Range,
}

impl Parameter {
    /// Checks a value.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a value outside the range.
    pub const fn check(&self, value: f64) -> Result<(), Error> {
        if self.range.contains(value) && (!self.whole || value == value as u64 as f64) {
            return Ok(());
        }
        Err(Error::parameter(self.name, value, self.range.text))
    }
}

/// The values that a [`Parameter`] accepts.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Range {
    /// The lower bound.
    pub least: f64,
    /// Whether the lower bound itself is refused.
    pub above: bool,
    /// The largest value; infinite if there is none.
    pub most: f64,
    /// The range in words, for instance "above 0, at most 1".
    pub text: &'static str,
}

impl Range {
    /// Whether the range contains `value`; no range contains NaN.
    pub const fn contains(&self, value: f64) -> bool {
        let enough = value > self.least || value == self.least && !self.above;
        enough && value <= self.most
    }
}

/// A [`Range`], with its words from its numbers.
macro_rules! range {
    (above $least:literal, at most $most:literal) => {
        Range {
            above: true,
            ..range!(@ $least, $most, "above ", stringify!($least), ", at most ", stringify!($most))
        }
    };
    (at least $least:literal and at most $most:literal) => {
        range!(@ $least, $most, "at least ", stringify!($least), " and at most ", stringify!($most))
    };
    (at least $least:literal) => {
        range!(@ $least, f64::INFINITY, "at least ", stringify!($least))
    };
    ($least:literal to $most:literal) => {
        range!(@ $least, $most, stringify!($least), " to ", stringify!($most))
    };
    (@ $least:literal, $most:expr, $($text:expr),*) => {
        Range { least: $least as f64, above: false, most: $most as f64, text: concat!($($text),*) }
    };
}
pub(super) use range;

/// An enum by its table. A row: the variant, with its argument (name, type, example, [`Parameter`]) if it
/// has one; its key for files and programs; its name for people.
macro_rules! choices {
    (
        $(#[$about:meta])*
        $type:ident {
            $(
                $(#[doc = $doc:literal])*
                $variant:ident $(($argument:ident: $number:ty = $example:expr, $parameter:expr))?,
                $key:literal, $name:literal;
            )*
        }
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        #[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
        pub enum $type {
            $($(#[doc = $doc])* $variant $(($number))?,)*
        }

        impl $type {
            /// An example of every row, with an example of its argument.
            pub const EXAMPLES: [Self; [$($key),*].len()] = [$($type::$variant $(($example))?),*];

            /// Key for files: short, without spaces, the same in every version.
            pub const fn key(&self) -> &'static str {
                match self {
                    $($type::$variant { .. } => $key,)*
                }
            }

            /// Name for people.
            pub const fn name(&self) -> &'static str {
                match self {
                    $($type::$variant { .. } => $name,)*
                }
            }

            /// Help text, made from the documentation of the row.
            pub fn help(&self) -> &'static str {
                match self {
                    $($type::$variant { .. } => concat!($($doc),*).trim_start(),)*
                }
            }

            /// Description of the argument, if the row has one.
            pub const fn parameter(&self) -> Option<Parameter> {
                match self {
                    $($type::$variant { .. } => [$(Some($parameter),)? None][0],)*
                }
            }

            /// Value of the argument, if the row has one.
            pub const fn argument(&self) -> Option<f64> {
                match *self {
                    $($type::$variant $(($argument))? => [$(Some($argument as f64),)? None][0],)*
                }
            }

            /// The same choice with another argument; unchanged if it has no argument.
            #[allow(unused_variables)]
            pub fn with_argument(&self, argument: f64) -> Self {
                match self {
                    $($type::$variant { .. } => $type::$variant $((argument as $number))?,)*
                }
            }
        }
    };
}
pub(super) use choices;
