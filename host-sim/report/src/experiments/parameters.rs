//! Parameters of an experiment, each stated once with its default and its range.

use crate::Result;
use bonebeam_files::settings::{LEVELS, out_of_range};

/// Makes a section of an experiment's configuration from rows.
///
/// A row has the documentation, the key with its type and default, and its [`Range`] or, after `=>`, the check of a
/// section within the section. `check` goes through the rows. The fields of a scanner may follow the section's name.
#[macro_export]
macro_rules! parameters {
    (
        $(#[$about:meta])*
        $type:ident $section:literal
        $([$($simulation:ident).+, $($receive:ident).+, $($image:ident).+])? {
            $($(#[$of:meta])* $name:ident: $value:ty = $default:expr $(, $range:expr)? $(=> $valid:path)?;)*
        }
    ) => {
        $(#[$about])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct $type {
            $($(#[$of])* pub(crate) $name: $value,)*
        }

        impl Default for $type {
            fn default() -> Self {
                $type { $($name: $default,)* }
            }
        }

        impl $crate::experiments::Parameters for $type {
            const NAME: &'static str = $section;

            fn check(&self) -> $crate::Result<()> {
                $(
                    $($range.check(&self.$name, $section, stringify!($name))?;)?
                    $($valid(&self.$name)?;)?
                )*
                Ok(())
            }

            $(fn scanner(&mut self) -> Option<$crate::experiments::experiment::Scanner<'_>> {
                let own = (&mut self.$($simulation).+, &mut self.$($receive).+, &mut self.$($image).+);
                Some(own)
            })?
        }
    };
}

/// A range of numbers, and its words in an error.
pub struct Range {
    ends: [f64; 2],
    words: String,
}

/// Accepts a range; an error says "0 to 1 (m)".
pub fn within(ends @ [least, most]: [f64; 2], unit: &str) -> Range {
    let words = format!("{least} to {most}{unit}");
    Range { ends, words }
}

/// Accepts a range; an error says "a number above 0, from 0.001 to 1 (m)".
pub fn positive(ends: [f64; 2], unit: &str) -> Range {
    let words = format!("a number above 0, from {}", within(ends, unit).words);
    Range { ends, words }
}

/// Accepts levels in dB.
pub fn level() -> Range {
    within(LEVELS, " (dB)")
}

impl Range {
    /// Checks the numbers of a key.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] naming the section, the key, the value and the range.
    pub fn check<T: Numbers>(&self, value: &T, section: &str, key: &str) -> Result<()> {
        let [least, most] = self.ends;
        let numbers = value.numbers();
        let Some(k) = numbers.iter().position(|v| !(least..=most).contains(v)) else {
            return Ok(());
        };
        let key = match numbers.len() {
            1 => key.to_owned(),
            _ => format!("{key}[{k}]"),
        };
        Err(out_of_range(section, &key, numbers[k], &self.words))
    }
}

/// Numbers that have one range.
pub trait Numbers {
    /// All of them.
    fn numbers(&self) -> Vec<f64>;
}

macro_rules! numbers {
    ($($type:ty, |$value:ident| $numbers:expr;)*) => {$(
        impl Numbers for $type {
            fn numbers(&self) -> Vec<f64> {
                let $value = self;
                $numbers
            }
        }
    )*};
}

numbers! {
    f64, |v| vec![*v];
    usize, |v| vec![*v as f64];
    u64, |v| vec![*v as f64];
    Option<f64>, |v| Vec::from_iter(*v);
    Vec<f64>, |v| v.clone();
    [f64; 2], |v| v.to_vec();
    [f64; 3], |v| v.to_vec();
}
