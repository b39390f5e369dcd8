//! Types of a dataset's numbers, and reasons of the library's errors.

use rust_hdf5::{ByteOrder, DatatypeMessage, Hdf5Error};

use crate::guard::ReadResult;

/// Types of a dataset's numbers.
pub(super) enum Kind {
    /// f32, or f16, which fits in f32.
    Single,
    Double,
    Unsigned8,
    /// Truth values of h5py, a byte each.
    Flags,
    /// Integers that fit in i32.
    Short,
    Long,
    /// Two numbers, at these offsets in an element of a size in bytes.
    Complex {
        part: Part,
        real: usize,
        imaginary: usize,
        size: usize,
    },
}

/// A part of a complex number.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Part {
    pub(super) bytes: usize,
    big_endian: bool,
    /// Whether it is a float, or else a signed integer.
    float: bool,
}

impl Part {
    fn of(datatype: &DatatypeMessage) -> Option<Self> {
        let (size, order, float) = match datatype {
            DatatypeMessage::FloatingPoint {
                size: size @ (4 | 8),
                byte_order,
                ..
            } => (size, byte_order, true),
            DatatypeMessage::FixedPoint {
                size: size @ (2 | 4),
                byte_order,
                signed: true,
                ..
            } => (size, byte_order, false),
            _ => return None,
        };
        Some(Self {
            bytes: *size as usize,
            big_endian: *order == ByteOrder::BigEndian,
            float,
        })
    }

    pub(super) fn value(self, bytes: &[u8]) -> f32 {
        let mut own = [0; 8];
        let own = &mut own[..self.bytes];
        own.copy_from_slice(bytes);
        if self.big_endian {
            own.reverse();
        }
        match (self.float, &*own) {
            (true, &[a, b, c, d]) => f32::from_le_bytes([a, b, c, d]),
            (true, own) => f64::from_le_bytes(own.try_into().unwrap_or_default()) as f32,
            (false, &[a, b]) => f32::from(i16::from_le_bytes([a, b])),
            (false, own) => i32::from_le_bytes(own.try_into().unwrap_or_default()) as f32,
        }
    }

    /// Whether rust-hdf5 reads parts of arrays of it.
    pub(super) fn is_plain(self) -> bool {
        self.float && !self.big_endian
    }
}

/// Type to which a datatype's numbers are read.
pub(super) fn kind(datatype: &DatatypeMessage) -> ReadResult<Kind> {
    match datatype {
        DatatypeMessage::FloatingPoint { size: 8, .. } => Ok(Kind::Double),
        DatatypeMessage::FloatingPoint { size: 2 | 4, .. } => Ok(Kind::Single),
        DatatypeMessage::FixedPoint { size, signed, .. } => Ok(match (size, signed) {
            (1, false) => Kind::Unsigned8,
            (1 | 2, _) | (4, true) => Kind::Short,
            _ => Kind::Long,
        }),
        DatatypeMessage::Enum { base, .. } if base.element_size() == 1 => Ok(Kind::Flags),
        DatatypeMessage::Compound { size, members } => {
            let [real, imaginary] = members.as_slice() else {
                return Err("is a compound of other than two numbers".into());
            };
            let are_named = [('r', 'i'), ('i', 'q')].iter().any(|&(first, second)| {
                let starts = |name: &str, with: char| name.to_ascii_lowercase().starts_with(with);
                starts(&real.name, first) && starts(&imaginary.name, second)
            });
            let part = Part::of(&real.datatype)
                .filter(|_| are_named)
                .filter(|&part| Part::of(&imaginary.datatype) == Some(part))
                .ok_or_else(|| {
                    format!(
                        "is a compound of `{}` and `{}`, not a complex number of `real` and `imag` of one type",
                        real.name, imaginary.name
                    )
                })?;
            let (real, imaginary, size) = (
                real.offset as usize,
                imaginary.offset as usize,
                *size as usize,
            );
            if size == 0 || real.max(imaginary).saturating_add(part.bytes) > size {
                return Err("is damaged: a complex number does not fit".into());
            }
            Ok(Kind::Complex {
                part,
                real,
                imaginary,
                size,
            })
        }
        other => Err(format!(
            "is of type {other}; expected numbers: floats of 2, 4 or 8 bytes, or integers"
        )),
    }
}

/// Codecs of plugins, by the numbers of their filters.
const CODECS: [(&str, &str); 6] = [
    ("32013", "ZFP"),
    ("32017", "SZ"),
    ("32018", "FCIDECOMP"),
    ("32024", "SZ3"),
    ("32026", "Blosc2"),
    ("32028", "SPERR"),
];

pub(super) fn damaged(error: &Hdf5Error) -> String {
    let text = error.to_string();
    let Some((_, what)) = text.split_once("unsupported") else {
        return format!("is damaged or not readable as HDF5: {text}");
    };
    if what.contains("datatype class 11") {
        return "is of HDF5 2.0's own complex type, which is not read; store pairs of `r` and `i`, as h5py does of \
                complex64"
            .into();
    }
    let what = what.trim_start_matches(" feature").trim_start_matches(": ");
    let codec = CODECS
        .iter()
        .find(|(id, _)| what == format!("filter id {id}"));
    let name = codec.map_or(String::new(), |(_, name)| format!(" of {name}"));
    format!(
        "is stored in a way that is not read ({what}{name}); write it anew with gzip, as by `h5repack -f GZIP=1`, or by h5py \
         with hdf5plugin"
    )
}
