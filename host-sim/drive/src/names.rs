//! Names that serde reads into a type: keys of a section, variants of a choice.

use std::fmt;

use serde::Deserialize;
use serde::de::Error;
use serde::de::value::{MapDeserializer, StrDeserializer};

/// The keys of a section.
pub(crate) fn keys<'de, T: Deserialize<'de>>() -> &'static [&'static str] {
    let entries = [("", "")].into_iter();
    known(T::deserialize(MapDeserializer::<_, Known>::new(entries)))
}

/// The names of a choice.
pub(crate) fn variants<'de, T: Deserialize<'de>>() -> &'static [&'static str] {
    known(T::deserialize(StrDeserializer::<Known>::new("")))
}

fn known<T>(refused: Result<T, Known>) -> &'static [&'static str] {
    refused.err().map_or(&[], |Known(names)| names)
}

/// Error of an unknown name: the known names.
#[derive(Debug)]
struct Known(&'static [&'static str]);

impl Error for Known {
    fn custom<T: fmt::Display>(_: T) -> Self {
        Known(&[])
    }

    fn unknown_field(_: &str, expected: &'static [&'static str]) -> Self {
        Known(expected)
    }

    fn unknown_variant(_: &str, expected: &'static [&'static str]) -> Self {
        Known(expected)
    }
}

impl std::error::Error for Known {}

impl fmt::Display for Known {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.join(", "))
    }
}
