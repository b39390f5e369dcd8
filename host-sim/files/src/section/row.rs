//! The range of a key, and what its row states.

use std::fmt;

/// Values that a key accepts.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    least: f64,
    most: f64,
    words: Words,
    unit: &'static str,
}

/// The words of a range, before its unit.
#[derive(Clone, Copy, Debug)]
enum Words {
    To,
    Positive,
    AtLeast,
    Given(&'static str),
}

impl Range {
    pub(super) fn contains(&self, value: f64) -> bool {
        (self.least..=self.most).contains(&value)
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Range {
            least, most, unit, ..
        } = self;
        match self.words {
            Words::To => write!(f, "{least} to {most}{unit}"),
            Words::Positive => write!(f, "a number above 0, from {least} to {most}{unit}"),
            Words::AtLeast => write!(f, "at least {least} and at most {most}{unit}"),
            Words::Given(words) => f.write_str(words),
        }
    }
}

/// What a row states beside its documentation, type and default.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    pub(super) placeholder: &'static str,
    pub(super) range: Option<Range>,
    pub(super) usual: Option<fn() -> String>,
    pub(super) flag: Option<&'static str>,
    /// Flags that cannot be given together with this one.
    pub excludes: &'static [&'static str],
    /// Keys that the flag resets, since they contradict it.
    pub replaces: &'static [&'static str],
    /// Whether it does so only if it changes the value.
    pub if_changed: bool,
}

/// A row with its value's placeholder in `--help`; if empty, the key's name.
pub const fn row(placeholder: &'static str) -> Row {
    Row {
        placeholder,
        range: None,
        usual: None,
        flag: None,
        excludes: &[],
        replaces: &[],
        if_changed: false,
    }
}

impl Row {
    const fn range(self, [least, most]: [f64; 2], words: Words, unit: &'static str) -> Self {
        Row {
            range: Some(Range {
                least,
                most,
                words,
                unit,
            }),
            ..self
        }
    }

    /// The least and the largest value that it accepts, if it has a range.
    pub fn bounds(&self) -> Option<[f64; 2]> {
        self.range.map(|range| [range.least, range.most])
    }

    /// Accepts `range`; an error says "0 to 1 m".
    pub const fn within(self, range: [f64; 2], unit: &'static str) -> Self {
        self.range(range, Words::To, unit)
    }

    /// Accepts `range`; an error says "a number above 0, from 0.001 to 1 (m)".
    pub const fn positive(self, range: [f64; 2], unit: &'static str) -> Self {
        self.range(range, Words::Positive, unit)
    }

    /// Accepts `range`; an error says "at least 0 and at most 1 (m)".
    pub const fn at_least(self, range: [f64; 2], unit: &'static str) -> Self {
        self.range(range, Words::AtLeast, unit)
    }

    /// Accepts `range`, in these words.
    pub const fn said(self, range: [f64; 2], words: &'static str) -> Self {
        self.range(range, Words::Given(words), "")
    }

    /// The default, as text for `--help`.
    pub const fn usual(self, usual: fn() -> String) -> Self {
        Row {
            usual: Some(usual),
            ..self
        }
    }

    /// The flag, if its name is not the key's; empty for a key without a flag.
    pub const fn flag(self, flag: &'static str) -> Self {
        Row {
            flag: Some(flag),
            ..self
        }
    }

    /// Flags that cannot be given together with this one.
    pub const fn excludes(self, excludes: &'static [&'static str]) -> Self {
        Row { excludes, ..self }
    }

    /// Keys that the flag resets.
    pub const fn replaces(self, replaces: &'static [&'static str]) -> Self {
        Row { replaces, ..self }
    }

    /// Keys that the flag resets if it changes the value.
    pub const fn replaces_if_changed(self, replaces: &'static [&'static str]) -> Self {
        Row {
            replaces,
            if_changed: true,
            ..self
        }
    }
}
