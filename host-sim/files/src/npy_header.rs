//! The header of an `.npy` array: read within bounds, and written as numpy does.
//!
//! A crafted header of a few bytes can claim terabytes, or overflow a product of sides. This reader accepts a
//! header only if the bytes that follow match it and memory can hold them.

use std::ops::Range;

/// First bytes of every `.npy` array.
const MAGIC: &[u8; 6] = b"\x93NUMPY";
/// Longest header, bytes: numpy's own limit.
const MAX_HEADER: usize = 10_000;
/// Most bytes of an array that its header can take.
pub const MAX_LENGTH: usize = MAX_HEADER + 12;
/// Deepest nesting of brackets: a tuple in a dictionary.
const MAX_NESTING: usize = 3;
/// Alignment of the numbers, bytes.
const ALIGNMENT: usize = 64;

const DAMAGED: &str = "has a damaged header";
const STRUCTURED: &str = "has a structured or unknown dtype; expected numbers of one type";

/// The header of an array of numbers of one type.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// numpy's name of the type, such as `<f4`.
    pub descr: String,
    /// Whether it is in Fortran order: the first side runs fastest.
    pub in_columns: bool,
    /// The sides.
    pub shape: Vec<usize>,
}

impl Header {
    /// The header at the beginning of `bytes`, and the range of its numbers.
    ///
    /// # Errors
    /// A description of the damage.
    pub fn read(bytes: &[u8]) -> Result<(Self, Range<usize>), String> {
        let (start, text) = text(bytes)?;
        check_nesting(text)?;
        // The line break at its end and a minor version of 0 are part of the format.
        if !text.ends_with('\n') || bytes[MAGIC.len() + 1] != 0 {
            return Err(DAMAGED.into());
        }
        let (descr, in_columns, sides) = Literal(text).header()?;
        let size = element_size(descr).ok_or(STRUCTURED)?;
        let mut shape = Vec::new();
        let mut count = size;
        for side in sides {
            let too_large = || format!("has a side of {side} in its shape; no memory holds that");
            let side: usize = side.parse().map_err(|_| too_large())?;
            // The other sides count where one is 0, too: arrays of ndarray multiply them.
            count = count
                .checked_mul(side.max(1))
                .filter(|&count| count <= isize::MAX as usize)
                .ok_or_else(too_large)?;
            shape.push(side);
        }
        if shape.contains(&0) {
            count = 0;
        }
        let begin = start + text.len();
        let header = Header {
            descr: descr.to_owned(),
            in_columns,
            shape,
        };
        Ok((header, begin..begin + count))
    }

    /// Its bytes, as version 1.
    pub fn bytes(&self) -> Vec<u8> {
        let order = if self.in_columns { "True" } else { "False" };
        let sides: Vec<String> = self.shape.iter().map(usize::to_string).collect();
        let comma = if sides.len() == 1 { "," } else { "" };
        let text = format!(
            "{{'descr': '{}', 'fortran_order': {order}, 'shape': ({}{comma})}}",
            self.descr,
            sides.join(", ")
        );
        let begin = MAGIC.len() + 4;
        let end = (begin + text.len() + 2).next_multiple_of(ALIGNMENT);
        let mut bytes = MAGIC.to_vec();
        bytes.extend([1, 0]);
        bytes.extend(((end - begin) as u16).to_le_bytes());
        bytes.extend(text.as_bytes());
        bytes.resize(end - 1, b' ');
        bytes.push(b'\n');
        bytes
    }
}

/// The rest of a Python literal.
///
/// Only the syntax that numpy writes: strings without escapes, whole numbers, truth values, and a tuple in a
/// dictionary.
struct Literal<'a>(&'a str);

/// A part of a literal, or a description of the damage.
type Read<T> = Result<T, &'static str>;

impl<'a> Literal<'a> {
    /// The header's dictionary: type, whether by columns, and sides as text.
    fn header(&mut self) -> Read<(&'a str, bool, Vec<&'a str>)> {
        let (mut descr, mut in_columns, mut sides) = (None, None, None);
        self.expect("{")?;
        while !self.take("}") {
            let key = self.string()?;
            self.expect(":")?;
            match key {
                // A structured type is a list of names and types.
                "descr" if self.take("[") => return Err(STRUCTURED),
                "descr" => descr = Some(self.string()?),
                "fortran_order" if self.take("True") => in_columns = Some(true),
                "fortran_order" => {
                    self.expect("False")?;
                    in_columns = Some(false);
                }
                "shape" => sides = Some(self.tuple()?),
                _ => return Err(DAMAGED),
            }
            if !self.take(",") {
                self.expect("}")?;
                break;
            }
        }
        let entries = descr.zip(in_columns).zip(sides);
        match entries {
            Some(((descr, in_columns), sides)) if self.0.trim().is_empty() => {
                Ok((descr, in_columns, sides))
            }
            _ => Err(DAMAGED),
        }
    }

    /// Whether the token comes next; if so, skips it.
    fn take(&mut self, token: &str) -> bool {
        self.0 = self.0.trim_start();
        let rest = self.0.strip_prefix(token);
        self.0 = rest.unwrap_or(self.0);
        rest.is_some()
    }

    fn expect(&mut self, token: &str) -> Read<()> {
        self.take(token).then_some(()).ok_or(DAMAGED)
    }

    fn string(&mut self) -> Read<&'a str> {
        let quote = if self.take("\"") { '"' } else { '\'' };
        if quote == '\'' {
            self.expect("'")?;
        }
        let (text, rest) = self.0.split_once(quote).ok_or(DAMAGED)?;
        self.0 = rest;
        Some(text).filter(|t| !t.contains('\\')).ok_or(DAMAGED)
    }

    /// Whole numbers in brackets; a single one is followed by a comma.
    fn tuple(&mut self) -> Read<Vec<&'a str>> {
        let mut numbers = Vec::new();
        self.expect("(")?;
        while !self.take(")") {
            let end = self.0.find([',', ')', ' ']).ok_or(DAMAGED)?;
            let (number, rest) = self.0.split_at(end);
            let digits = number.strip_prefix('-').unwrap_or(number);
            if digits.is_empty() || !digits.bytes().all(|b| b.is_ascii_digit()) {
                return Err(DAMAGED);
            }
            numbers.push(number);
            self.0 = rest;
            if !self.take(",") {
                self.expect(")")?;
                return if numbers.len() > 1 {
                    Ok(numbers)
                } else {
                    Err(DAMAGED)
                };
            }
        }
        Ok(numbers)
    }
}

/// Offset of the header, and its text.
fn text(bytes: &[u8]) -> Result<(usize, &str), String> {
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
    let text = rest.get(..length).ok_or_else(truncated)?;
    let text = std::str::from_utf8(text).map_err(|_| DAMAGED.to_owned())?;
    Ok((start, text))
}

/// Checks that the header nests no deeper than one of numbers.
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

/// Size of a number of a plain dtype such as `<f4`, bytes.
fn element_size(descr: &str) -> Option<usize> {
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

    fn end(bytes: &[u8]) -> Result<usize, String> {
        Header::read(bytes).map(|(_, numbers)| numbers.end)
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
            assert_eq!(end(&bytes), Ok(bytes.len() + expected));
        }
        for version in [2, 3] {
            let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (4,)}\n";
            let wide = array(version, header);
            assert_eq!(end(&wide), Ok(wide.len() + 32));
        }
    }

    #[test]
    fn what_no_memory_holds_is_refused() {
        for shape in [
            "(0, 18446744073709551615)",
            "(4294967296, 4294967296)",
            "(2305843009213693952,)",
            "(0, 4294967296, 4294967296)",
            "(99999999999999999999999,)",
            "(-1,)",
        ] {
            let message = end(&of("'<f4'", shape)).unwrap_err();
            assert!(message.contains("no memory holds"), "{shape}: {message}");
        }
    }

    #[test]
    fn hostile_headers_are_refused_at_once() {
        let nested = format!("{}{}", "(".repeat(40), ")".repeat(40));
        let message = end(&of("'<f4'", &nested)).unwrap_err();
        assert!(message.contains("nests too deep"), "{message}");
        let mut claims = array(2, "{}");
        claims[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
        let message = end(&claims).unwrap_err();
        assert!(message.contains("4294967295 bytes"), "{message}");
        for bytes in [
            &b""[..],
            b"\x93NUM",
            b"\x93NUMPY\x01",
            b"\x93NUMPY\x09\x00\x00\x00",
        ] {
            end(bytes).unwrap_err();
        }
        end(&of("[('a', '<f4')]", "(1,)")).unwrap_err();
    }

    #[test]
    fn a_header_is_what_numpy_writes() {
        let read = |text: &str| Header::read(&array(1, text)).map(|(header, _)| header);
        let expected = Header {
            descr: ">f8".into(),
            in_columns: true,
            shape: vec![12, 3],
        };
        for text in [
            "{'descr': '>f8', 'fortran_order': True, 'shape': (12, 3), }     \n",
            "{\"shape\":(12,3,),\t'fortran_order':True ,\"descr\" : '>f8'}\n",
            "  { 'fortran_order': True, 'shape': ( 12 , 3 ), 'descr': '>f8' }\n",
        ] {
            assert_eq!(read(text).as_ref(), Ok(&expected), "{text}");
        }
        let whole = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }\n";
        read(whole).unwrap();
        for (part, other) in [
            ("\n", ""),
            ("\n", "x\n"),
            ("{", ""),
            ("}", ""),
            ("'descr'", "descr"),
            ("'<f4'", "'<f4\""),
            ("'<f4'", "'<f\\64'"),
            ("'<f4'", "4"),
            ("'descr': '<f4', ", ""),
            (", 'shape': (2, 3)", ""),
            ("'shape'", "'size'"),
            ("False", "0"),
            (", 'fort", " 'fort"),
            ("(2, 3)", "6"),
            ("(2, 3)", "(6)"),
            ("(2, 3)", "(2, 3"),
            ("(2, 3)", "(2 3)"),
            ("(2, 3)", "(2,, 3)"),
            ("(2, 3)", "(2, 3.0)"),
            ("(2, 3)", "(+2, 3)"),
            ("(2, 3)", "(2, -)"),
            ("(2, 3)", "(2L, 3L)"),
        ] {
            let text = whole.replacen(part, other, 1);
            assert_eq!(read(&text), Err(DAMAGED.to_owned()), "{text}");
        }
        let mut minor = array(1, whole);
        minor[7] = 1;
        assert_eq!(end(&minor), Err(DAMAGED.to_owned()));
        for descr in ["[('a', '<f4')]", "'<f32'", "'<f0'", "'O'", "'<M8[ns]'"] {
            let message = read(&whole.replace("'<f4'", descr)).unwrap_err();
            assert!(message.contains("structured or unknown"), "{message}");
        }
    }
}
