//! The header of an `.npy` array, bounded before the npy crate sees it.
//!
//! A crafted header of a few bytes can claim terabytes, overflow a product of sides, or nest so
//! deep that parsing does not come back. What passes here claims just the bytes that follow it.

use py_literal::Value;

/// What every `.npy` array begins with.
const MAGIC: &[u8; 6] = b"\x93NUMPY";
/// The longest header, bytes: numpy's own limit.
const MAX_HEADER: usize = 10_000;
/// How many bytes of an array hold its header, at the most.
pub const MAX_LENGTH: usize = MAX_HEADER + 12;
/// Brackets within brackets: a dictionary holds a tuple.
const MAX_NESTING: usize = 3;

/// How many bytes the array has in all, header and numbers, as its header tells.
///
/// # Errors
/// What is wrong with the header.
pub fn claimed_length(bytes: &[u8]) -> Result<usize, String> {
    let (start, header) = header(bytes)?;
    check_nesting(header)?;
    let damaged = || "has a damaged header".to_owned();
    let value: Value = header.trim().parse().map_err(|_| damaged())?;
    let entries = value.as_dict().ok_or_else(damaged)?;
    let entry = |key: &str| {
        let found = entries
            .iter()
            .find(|(name, _)| name.as_string().is_some_and(|name| name == key));
        found.map(|(_, value)| value).ok_or_else(damaged)
    };
    let size = element_size(entry("descr")?).ok_or_else(|| {
        "has a structured or unknown dtype; expected numbers of one type".to_owned()
    })?;
    let sides = entry("shape")?.as_tuple().ok_or_else(damaged)?;
    let mut count = size;
    let mut empty = false;
    for side in sides {
        let side = side.as_integer().ok_or_else(damaged)?;
        let too_large = || format!("has a side of {side} in its shape; no memory holds that");
        let side = usize::try_from(side).map_err(|_| too_large())?;
        if side == 0 {
            empty = true;
        } else {
            // The other sides count where one is 0, too: the npy crate multiplies them.
            count = count
                .checked_mul(side)
                .filter(|&count| count <= isize::MAX as usize)
                .ok_or_else(too_large)?;
        }
    }
    Ok(start + header.len() + if empty { 0 } else { count })
}

/// Where the header begins, and its text.
fn header(bytes: &[u8]) -> Result<(usize, &str), String> {
    let truncated = || "is truncated: its header is not whole".to_owned();
    let rest = bytes
        .strip_prefix(MAGIC)
        .ok_or_else(|| "is not an .npy array".to_owned())?;
    let (&[major, _], rest) = rest.split_first_chunk().ok_or_else(truncated)?;
    let (length, rest) = match major {
        1 => {
            let (&length, rest) = rest.split_first_chunk().ok_or_else(truncated)?;
            (usize::from(u16::from_le_bytes(length)), rest)
        }
        2 | 3 => {
            let (&length, rest) = rest.split_first_chunk().ok_or_else(truncated)?;
            let length = u32::from_le_bytes(length);
            (usize::try_from(length).unwrap_or(usize::MAX), rest)
        }
        _ => return Err(format!("is of .npy version {major}; expected 1, 2 or 3")),
    };
    if length > MAX_HEADER {
        return Err(format!(
            "has a header of {length} bytes; expected at most {MAX_HEADER}"
        ));
    }
    let start = bytes.len() - rest.len();
    let header = rest.get(..length).ok_or_else(truncated)?;
    let header = std::str::from_utf8(header).map_err(|_| "has a damaged header".to_owned())?;
    Ok((start, header))
}

/// The parser of Python literals takes exponential time in the nesting.
fn check_nesting(header: &str) -> Result<(), String> {
    let mut depth = 0usize;
    for c in header.chars() {
        match c {
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth > MAX_NESTING {
            return Err("has a damaged header: it nests too deep".into());
        }
    }
    Ok(())
}

/// The bytes of a number of a plain dtype such as `<f4`.
fn element_size(descr: &Value) -> Option<usize> {
    let descr = descr.as_string()?;
    let digits = descr.trim_start_matches(|c: char| !c.is_ascii_digit());
    let size: usize = digits.parse().ok()?;
    // Sixteen bytes are complex128, the widest that is read.
    (1..=16).contains(&size).then_some(size)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn array(version: u8, header: &str) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend([version, 0]);
        if version == 1 {
            bytes.extend((header.len() as u16).to_le_bytes());
        } else {
            bytes.extend((header.len() as u32).to_le_bytes());
        }
        bytes.extend(header.as_bytes());
        bytes
    }

    fn of(descr: &str, shape: &str) -> Vec<u8> {
        let header =
            format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}        \n");
        array(1, &header)
    }

    #[test]
    fn the_length_is_that_of_header_and_numbers() {
        for (descr, shape, expected) in [
            ("'<f4'", "(2, 3, 5)", 120),
            ("'>c16'", "(7,)", 112),
            ("'<i2'", "()", 2),
            ("'|u1'", "(0, 9)", 0),
        ] {
            let bytes = of(descr, shape);
            assert_eq!(claimed_length(&bytes), Ok(bytes.len() + expected));
        }
        let wide = array(2, "{'descr': '<f8', 'fortran_order': False, 'shape': (4,)}");
        assert_eq!(claimed_length(&wide), Ok(wide.len() + 32));
    }

    #[test]
    fn what_no_memory_holds_is_refused() {
        for shape in [
            "(0, 18446744073709551615)",
            "(4294967296, 4294967296)",
            "(0, 4294967296, 4294967296)",
            "(99999999999999999999999,)",
            "(-1,)",
        ] {
            let message = claimed_length(&of("'<f4'", shape)).unwrap_err();
            assert!(message.contains("no memory holds"), "{shape}: {message}");
        }
    }

    #[test]
    fn hostile_headers_are_refused_at_once() {
        let nested = format!("{}{}", "(".repeat(40), ")".repeat(40));
        let message = claimed_length(&of("'<f4'", &nested)).unwrap_err();
        assert!(message.contains("nests too deep"), "{message}");
        let mut claims = array(2, "{}");
        claims[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
        let message = claimed_length(&claims).unwrap_err();
        assert!(message.contains("4294967295 bytes"), "{message}");
        for bytes in [
            &b""[..],
            b"\x93NUM",
            b"\x93NUMPY\x01",
            b"\x93NUMPY\x09\x00\x00\x00",
        ] {
            claimed_length(bytes).unwrap_err();
        }
        claimed_length(&of("[('a', '<f4')]", "(1,)")).unwrap_err();
    }
}
