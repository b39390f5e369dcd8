//! Memory that is known before it is needed is asked for once before: an error says what is missing,
//! where the system would end the program.

use crate::{Error, Result};

/// Whether so many bytes could be had now, for what is named.
///
/// They are given back at once: what is asked for later is taken from the same. A limit of the process
/// (`ulimit -v`) is seen here. Memory that a system promises and then does not have is not.
///
/// # Errors
/// [`Error::Data`] with the size.
pub fn check(bytes: usize, what: &str) -> Result<()> {
    if Vec::<u8>::new().try_reserve_exact(bytes).is_ok() {
        return Ok(());
    }
    Err(Error::Data(format!(
        "{what} needs {:.1} GiB of memory, which cannot be had",
        bytes as f64 / (1u64 << 30) as f64
    )))
}

/// The product of some sides, as many as there are numbers at the most.
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
}
