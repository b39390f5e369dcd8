//! Checks that memory is available before it is needed.
//!
//! The error then gives the size, instead of the system ending the program.

use crate::{Error, Result};

/// Checks that `bytes` of memory are available for `what`.
///
/// The memory is freed at once; later allocations use it. A limit of the process (`ulimit -v`) is detected. Memory
/// that the system promises but does not have is not.
///
/// # Errors
/// [`Error::Data`] with the size.
pub fn check(bytes: usize, what: &str) -> Result<()> {
    if Vec::<u8>::new().try_reserve_exact(bytes).is_ok() {
        return Ok(());
    }
    Err(Error::Data(format!(
        "{what} needs {} of memory, which is not available",
        size(bytes)
    )))
}

/// A number of bytes in the largest unit that is at least 1.
fn size(bytes: usize) -> String {
    let units = [(30, "GiB"), (20, "MiB"), (10, "KiB")];
    match units.iter().find(|(power, _)| bytes >> power > 0) {
        Some((power, unit)) => format!("{:.1} {unit}", bytes as f64 / (1u64 << power) as f64),
        None => format!("{bytes} bytes"),
    }
}

/// The product of some sides; saturates.
pub fn product(sides: &[usize]) -> usize {
    sides.iter().copied().fold(1, usize::saturating_mul)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_machine_has_is_refused_with_its_size() {
        assert!(check(1 << 20, "a megabyte").is_ok());
        let error = check(product(&[1 << 40, 1 << 20]), "a frame").unwrap_err();
        let message = error.to_string();
        assert!(
            message.contains("a frame needs") && message.contains("GiB"),
            "{message}"
        );
    }

    #[test]
    fn sizes_are_reported_in_a_unit_that_fits() {
        for (bytes, expected) in [
            (0, "0 bytes"),
            (1023, "1023 bytes"),
            (1024, "1.0 KiB"),
            (40 << 20, "40.0 MiB"),
            ((1 << 30) - 1, "1024.0 MiB"),
            (3 << 29, "1.5 GiB"),
        ] {
            assert_eq!(size(bytes), expected);
        }
    }
}
