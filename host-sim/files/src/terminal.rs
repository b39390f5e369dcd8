//! Output on standard output and standard error.

use std::fmt::Display;
use std::io::{self, ErrorKind, Write};

use crate::{Error, Result};

/// Longest message, characters: a line of a crafted file may have millions.
const LONGEST: usize = 1000;

/// Prints to standard output.
///
/// A closed reader, such as `head`, is not an error.
///
/// # Errors
/// [`Error::Data`] if it cannot be written, as on a full disk.
pub fn print(text: &str) -> Result<()> {
    // Names and texts of files are in it; the program itself prints no escape sequences.
    let text = text.split_inclusive(['\n', '\t']).map(|part| {
        let end = part.trim_end_matches(['\n', '\t']).len();
        escaped(&part[..end]) + &part[end..]
    });
    let text: String = text.collect();
    let mut output = io::stdout().lock();
    match output
        .write_all(text.as_bytes())
        .and_then(|()| output.flush())
    {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(Error::Data(format!(
            "the standard output cannot be written: {e}"
        ))),
        _ => Ok(()),
    }
}

/// Prints an error as one line on standard error.
///
/// If that fails too, the exit status still reports it.
pub fn complain(error: &Error) {
    let line = format!("host-sim: {}\n", one_line(&error.to_string()));
    let _ = io::stderr().lock().write_all(line.as_bytes());
}

/// Prints a warning as one line on standard error; the run continues.
pub fn warn(message: &str) {
    remark(&format!("warning: {message}"));
}

/// Prints a remark as one line on standard error; the run continues.
pub fn remark(message: &str) {
    let line = format!("host-sim: {}\n", one_line(message));
    let _ = io::stderr().lock().write_all(line.as_bytes());
}

/// A measured value with six digits.
///
/// Digits that are only rounding are removed.
pub fn digits(value: f64) -> String {
    let rounded = format!("{value:.5e}").parse().unwrap_or(value);
    f64::to_string(&rounded)
}

/// A value as it was given; with an exponent if it has many digits, as 10³⁰⁰.
pub fn short(value: impl Display) -> String {
    let text = value.to_string();
    match text.parse::<f64>() {
        Ok(number) if text.len() > 24 => format!("{number:e}"),
        _ => text,
    }
}

/// The text as one short line.
///
/// Names and texts of files may contain line breaks and escape sequences, which a terminal would obey.
pub fn one_line(message: &str) -> String {
    match message.char_indices().nth(LONGEST) {
        None => escaped(message),
        Some((end, _)) => escaped(&message[..end]) + "…",
    }
}

/// A text with its control characters as escapes: `\u{1b}` is ESC.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() {
            escaped.extend(c.escape_default());
        } else {
            escaped.push(c);
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_measured_value_has_six_digits() {
        for (value, expected) in [
            (6.6000000000000005, "6.6"),
            (0.019_049_999_862_909_32, "0.01905"),
            (1540.0, "1540"),
            (-3.87e-6, "-0.00000387"),
            (20e6, "20000000"),
            (16.777_216, "16.7772"),
            (0.0, "0"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(digits(value), expected);
        }
        assert_eq!(digits(f64::NAN), "NaN");
    }

    #[test]
    fn a_value_of_many_digits_is_reported_by_its_exponent() {
        for (value, expected) in [
            (1e300, "1e300"),
            (-1e-300, "-1e-300"),
            (0.1, "0.1"),
            (3.0, "3"),
        ] {
            assert_eq!(short(value), expected);
        }
        assert_eq!(short(u64::MAX), "18446744073709551615");
    }

    #[test]
    fn a_message_is_one_short_line_without_escape_sequences() {
        assert_eq!(one_line("β = 1 %: no"), "β = 1 %: no");
        assert_eq!(
            one_line("a\nb\x1b[31mc\u{9b}d"),
            "a\\nb\\u{1b}[31mc\\u{9b}d"
        );
        let long = one_line(&"x".repeat(10_000_000));
        assert_eq!(long.chars().count(), LONGEST + 1);
    }
}
