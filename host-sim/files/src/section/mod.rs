//! Sections of the configuration: a key is stated once for files, flags and Python.
//!
//! [`section!`](crate::section!) makes a struct of rows. A row has the documentation, which is the flag's help, the type,
//! the default, and a [`Row`] with the rest. The heading above rows groups the flags of `--help`, and names the data that
//! they affect. [`Section::keys`] lists the keys, from which the command makes flags, and Python its keywords.

mod row;
mod value;

pub use row::{Range, Row, row};
pub use value::{Value, chosen, number_or_power};

use bonebeam::beamform::{Parameter, Parameters};

use crate::settings::out_of_range;
use crate::terminal::short;

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
        self.first_outside().map_or(Ok(()), |(key, value, range)| {
            Err(out_of_range(
                Self::NAME,
                &key.name,
                value,
                &range.to_string(),
            ))
        })
    }

    /// Checks the range of each value of a section within another section.
    ///
    /// # Errors
    /// As [`Section::check_ranges`].
    fn check_ranges_in(&self, section: &str) -> crate::Result<()> {
        self.first_outside().map_or(Ok(()), |(key, value, range)| {
            let key = format!("{}.{}", Self::NAME, key.name);
            Err(out_of_range(section, &key, value, &range.to_string()))
        })
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
