//! Settings of the host: reads TOML files, and reports values out of range.

use crate::terminal::short;
use crate::{Error, Result};

/// Longest configuration to read, bytes: a hundred times one with every parameter.
#[cfg(feature = "toml")]
const MOST: u64 = 1 << 20;

/// Reads a TOML file with `parse`.
///
/// # Errors
/// The file cannot be opened, or does not match `parse`; the line is named.
#[cfg(feature = "toml")]
pub fn read_toml_with<T>(
    path: &std::path::Path,
    parse: impl FnOnce(&str) -> std::result::Result<T, toml::de::Error>,
) -> Result<T> {
    let error = |message: String| Error::Usage(format!("{}: {message}", path.display()));
    let bytes = crate::input::read(path, MOST).map_err(|e| {
        let reason = crate::cannot_be_opened(&e);
        error(format!("the configuration {reason}"))
    })?;
    let text = String::from_utf8(bytes)
        .map_err(|_| error("the configuration cannot be opened: it is not UTF-8".into()))?;
    parse(&text).map_err(|e| {
        // The parser may explain itself over several lines; the first says what is wrong.
        let message = e.message().lines().next().unwrap_or("not valid TOML");
        error(match e.span() {
            Some(span) => {
                let before = text.bytes().take(span.start);
                let line = 1 + before.filter(|&b| b == b'\n').count();
                format!("line {line}: {message}")
            }
            None => message.to_owned(),
        })
    })
}

/// The usage error for a parameter outside its range.
///
/// It gives flag, key, value and the expected range.
pub fn out_of_range(
    section: &str,
    key: &str,
    value: impl std::fmt::Display,
    expected: &str,
) -> Error {
    let flag = key.replace('_', "-");
    let value = short(value);
    let metres = value.parse().ok().filter(|_| expected.ends_with("(m)"));
    let hint = metres.map_or(String::new(), in_mm);
    Error::Usage(format!(
        "--{flag} (`{key}` in [{section}]) is {value}; expected {expected}{hint}"
    ))
}

/// What a length of metres probably is, to append to a message.
pub fn in_mm(metres: f64) -> String {
    match metres {
        1.0..=300.0 => format!("; probably mm: {}", short(metres / 1e3)),
        _ => String::new(),
    }
}

/// Range of lengths of an image, a bone or a record, m.
pub const LENGTHS: [f64; 2] = [1e-6, 10.0];
/// Range of numbers of elements, eigenvectors or rows; more is a mistake.
pub const COUNTS: [f64; 2] = [1.0, 65_536.0];
/// Range of levels, dB.
pub const LEVELS: [f64; 2] = [-200.0, 40.0];
