//! Sections of the configuration: a key is stated once for files, flags and Python.
//!
//! [`section!`](crate::section!) makes a struct of rows. A row has the documentation, which is the flag's help, the type,
//! the default, and a [`Row`] with the rest. The heading above rows groups the flags of `--help`, and names the data that
//! they affect. [`Section::keys`] lists the keys, from which the command makes flags, and Python its keywords.

use std::fmt;
use std::path::PathBuf;

use bonebeam::beamform::{Apodization, Parameter, Parameters, Postfilter};
use bonebeam::covariance::Covariance;

use crate::settings::out_of_range;
use crate::terminal::short;

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
    fn contains(&self, value: f64) -> bool {
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
    placeholder: &'static str,
    range: Option<Range>,
    usual: Option<fn() -> String>,
    flag: Option<&'static str>,
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
fn chosen<T: Copy>(text: &str, all: &[(T, &str)]) -> Result<T, String> {
    let found = all.iter().find(|(_, name)| *name == text);
    found
        .map(|(value, _)| *value)
        .ok_or_else(|| format!("unknown name `{text}`"))
}

macro_rules! of_core {
    ($($choice:ty),*) => {$(
        impl Value for $choice {
            fn choices() -> Vec<[&'static str; 2]> {
                Self::EXAMPLES.iter().map(|one| [one.key(), one.help()]).collect()
            }

            fn read(text: &str) -> Result<Self, String> {
                chosen(text, &Self::EXAMPLES.map(|one| (one, one.key())))
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
        chosen(
            text,
            &all.map(|one| (one, ["forward", "forward-backward"][one as usize])),
        )
    }
}

/// A key of a section, with its flag.
#[derive(Clone, Debug)]
pub struct Key {
    /// The key; of a section within the section, with its name: `clutter.level`.
    pub name: String,
    /// The flag without dashes; empty if there is none.
    pub flag: String,
    /// Former names.
    pub aliases: &'static [&'static str],
    /// The heading in `--help`.
    pub heading: &'static str,
    /// The first paragraph of the help, with the default.
    pub help: String,
    /// The other paragraphs.
    pub more: String,
    /// The value's name in `--help`.
    pub placeholder: String,
    /// The names of a choice, each with its help.
    pub choices: Vec<[&'static str; 2]>,
    /// Whether the flag has no value.
    pub switch: bool,
    /// Whether the value is a list, separated by commas.
    pub list: bool,
    /// Its type in Python.
    pub python: String,
    /// The rest of its row.
    pub row: Row,
    /// Checks that a flag's text can be read.
    pub check: fn(&str) -> Result<(), String>,
}

impl Key {
    /// The key of a row; `section!` calls it.
    #[doc(hidden)]
    pub fn new<T: Value>(
        name: &str,
        heading: &'static str,
        lines: &[&str],
        aliases: &'static [&'static str],
        row: Row,
        default: &T,
    ) -> Self {
        let paragraphs = lines.split(|line| line.trim().is_empty());
        let paragraphs = paragraphs.map(|lines| {
            lines
                .iter()
                .map(|line| line.trim())
                .collect::<Vec<_>>()
                .join(" ")
        });
        let mut paragraphs = paragraphs.filter(|text| !text.is_empty());
        let mut help = paragraphs.next().unwrap_or_default();
        let mut placeholder = row.placeholder.to_owned();
        let mut stated = row.usual.map(|usual| usual()).or_else(|| default.stated());
        if let Some(parameter) = of_core(name) {
            let text = parameter
                .help
                .trim()
                .trim_end_matches('.')
                .replace('\n', "");
            help = format!("{text}; {}", parameter.range.text);
            stated = Some(short(parameter.default));
        }
        if placeholder.is_empty() {
            placeholder = name.to_uppercase();
        }
        if let Some(default) = stated.filter(|_| !help.contains("[default")) {
            help += &format!(" [default: {default}]");
        }
        Key {
            name: name.into(),
            flag: row
                .flag
                .map_or_else(|| name.replace('_', "-"), str::to_owned),
            aliases,
            heading,
            help,
            more: paragraphs.collect::<Vec<_>>().join("\n\n"),
            placeholder,
            choices: T::choices(),
            switch: T::SWITCH,
            list: T::LIST,
            python: T::python(),
            row,
            check: |text| T::read(text).map(drop),
        }
    }

    /// The key of a section within a section.
    #[doc(hidden)]
    pub fn within(self, section: &str) -> Self {
        Key {
            name: format!("{section}.{}", self.name),
            ..self
        }
    }
}

/// The core's parameter with this name, from its table.
pub fn of_core(name: &str) -> Option<Parameter> {
    Parameters::TABLE.into_iter().find(|row| row.name == name)
}

/// A section of the configuration, made by [`section!`](crate::section!).
pub trait Section: Default + Clone + PartialEq + 'static {
    /// Its name in a file.
    const NAME: &'static str;

    /// Its keys, in order.
    fn keys() -> Vec<Key>;

    /// Sets a key to a flag's text; nothing happens if the text cannot be read.
    fn set(&mut self, key: &str, text: &str);

    /// Sets a key to its default.
    fn reset(&mut self, key: &str);

    /// The value of a key as text, if it is outside the range.
    fn outside(&self, key: &str, range: &Range) -> Option<String>;

    /// The first value outside its range: the key, the value and the range.
    fn first_outside(&self) -> Option<(Key, String, Range)> {
        Self::keys().into_iter().find_map(|key| {
            let range = key.row.range?;
            let value = self.outside(&key.name, &range)?;
            Some((key, value, range))
        })
    }

    /// Checks the range of each value.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] naming the flag, the key, the value and the range.
    fn check_ranges(&self) -> crate::Result<()> {
        match self.first_outside() {
            None => Ok(()),
            Some((key, value, range)) => Err(out_of_range(
                Self::NAME,
                &key.name,
                value,
                &range.to_string(),
            )),
        }
    }

    /// Checks the range of each value of a section within another section.
    ///
    /// # Errors
    /// As [`Section::check_ranges`].
    fn check_ranges_in(&self, section: &str) -> crate::Result<()> {
        match self.first_outside() {
            None => Ok(()),
            Some((key, value, range)) => {
                let key = format!("{}.{}", Self::NAME, key.name);
                Err(out_of_range(section, &key, value, &range.to_string()))
            }
        }
    }
}

/// A struct of keys, as a section of the configuration: see the [module](mod@crate::section).
///
/// ```
/// use bonebeam_files::section::{Section, row};
///
/// bonebeam_files::section! {
///     /// Section `[picture]`.
///     Picture "picture" {
///         "Picture" {
///             /// Dynamic range, dB
///             dynamic_range: f64 = 60.0, row("DB").within([0.1, 1000.0], " dB");
///         }
///     }
/// }
///
/// let mut picture = Picture::default();
/// picture.set("dynamic_range", "0");
/// let message = picture.check_ranges().unwrap_err().to_string();
/// assert_eq!(message, "--dynamic-range (`dynamic_range` in [picture]) is 0; expected 0.1 to 1000 dB");
/// assert_eq!(Picture::keys()[0].help, "Dynamic range, dB [default: 60]");
/// ```
#[macro_export]
macro_rules! section {
    (
        $(#[$about:meta])*
        $type:ident $section:literal {
            $($heading:literal {
                $(
                    $(#[doc = $doc:literal])*
                    $(#[alias = $alias:literal])*
                    $name:ident: $value:ty = $default:expr, $row:expr;
                )*
            })*
        }
        $($(#[doc = $about_inner:literal])* $inner:ident: Option<$inner_type:ty>, $access:expr;)*
    ) => {
        $(#[$about])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct $type {
            $($(
                $(#[doc = $doc])*
                $(#[serde(alias = $alias)])*
                #[serde(skip_serializing_if = "bonebeam_files::section::Value::absent")]
                pub $name: $value,
            )*)*
            $(
                $(#[doc = $about_inner])*
                #[serde(skip_serializing_if = "Option::is_none")]
                pub $inner: Option<$inner_type>,
            )*
        }

        impl Default for $type {
            fn default() -> Self {
                Self {
                    $($($name: $default,)*)*
                    $($inner: None,)*
                }
            }
        }

        impl $crate::section::Section for $type {
            const NAME: &'static str = $section;

            fn keys() -> Vec<$crate::section::Key> {
                let usual = Self::default();
                let mut keys = vec![$($($crate::section::Key::new(
                    stringify!($name),
                    $heading,
                    &[$($doc),*],
                    &[$($alias),*],
                    $row,
                    &usual.$name,
                ),)*)*];
                $(keys.extend(
                    <$inner_type as $crate::section::Section>::keys()
                        .into_iter()
                        .map(|key| key.within(stringify!($inner))),
                );)*
                keys
            }

            fn set(&mut self, key: &str, text: &str) {
                $(if let Some(key) = key.strip_prefix(concat!(stringify!($inner), ".")) {
                    let access: fn(&mut Self) -> &mut $inner_type = $access;
                    return access(self).set(key, text);
                })*
                match key {
                    $($(stringify!($name) => if let Ok(value) = $crate::section::Value::read(text) {
                        self.$name = value;
                    },)*)*
                    _ => {}
                }
            }

            fn reset(&mut self, key: &str) {
                match key {
                    $($(stringify!($name) => self.$name = Self::default().$name,)*)*
                    _ => {}
                }
            }

            fn outside(&self, key: &str, range: &$crate::section::Range) -> Option<String> {
                $(if let Some(key) = key.strip_prefix(concat!(stringify!($inner), ".")) {
                    return self.$inner.as_ref()?.outside(key, range);
                })*
                match key {
                    $($(stringify!($name) => $crate::section::Value::outside(&self.$name, range),)*)*
                    _ => None,
                }
            }
        }
    };
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
                let found = Self::ALL.into_iter().find(|one| one.name() == text);
                found.ok_or_else(|| format!("unknown name `{text}`"))
            }

            fn stated(&self) -> Option<String> {
                Some(self.name().into())
            }
        }
    };
}
