//! Arrays in NumPy's `.npy` format, with the element type of the file.
//!
//! Versions 1 to 3 are read, version 1 is written.

use std::array;
use std::io::{self, Write};
use std::path::Path;

use ndarray::{ArrayD, ArrayRef, Dimension, IxDyn, ShapeBuilder};
use num_complex::Complex;

use super::npy_header::Header;
use super::{cannot_be_opened, file_error};
use crate::Result;
use crate::{input, memory};

/// Memory to read and convert an array, as a multiple of its size.
pub const CONVERSIONS: usize = 4;

/// Reason why an array could not be read.
pub enum NpyError {
    /// It has another element type, named here.
    Type(String),
    /// It is damaged.
    Damaged(String),
}

/// Numbers (`None` if the file has another type), or a description of the damage.
pub type Decoded<T> = std::result::Result<Option<Vec<T>>, String>;

/// Element type of an array.
pub trait Element: Clone {
    /// numpy's name of the type, little-endian, as written.
    const NAME: &'static str;

    /// The numbers in the bytes; `None` if they have another type.
    ///
    /// # Errors
    /// A value that the type cannot hold.
    fn decode(descr: &str, bytes: &[u8]) -> Decoded<Self>;

    /// Writes numbers in order.
    ///
    /// # Errors
    /// Errors of the sink.
    fn encode(values: &[Self], sink: &mut impl Write) -> io::Result<()>;
}

macro_rules! real {
    ($($type:ty: $little:literal, $big:literal;)*) => {$(
        impl Element for $type {
            const NAME: &'static str = $little;

            fn decode(descr: &str, bytes: &[u8]) -> Decoded<Self> {
                Ok(match descr {
                    $little => Some(from_bytes(bytes, <$type>::from_le_bytes)),
                    $big => Some(from_bytes(bytes, <$type>::from_be_bytes)),
                    _ => None,
                })
            }

            fn encode(values: &[Self], sink: &mut impl Write) -> io::Result<()> {
                write_bytes(values, sink, |value| value.to_le_bytes())
            }
        }
    )*};
}

real! {
    i8: "|i1", "i1";
    u8: "|u1", "u1";
    i16: "<i2", ">i2";
    u16: "<u2", ">u2";
    i32: "<i4", ">i4";
    u32: "<u4", ">u4";
    i64: "<i8", ">i8";
    u64: "<u8", ">u8";
    f32: "<f4", ">f4";
    f64: "<f8", ">f8";
}

/// numpy's float16, which is only read.
#[derive(Clone, Copy, Debug)]
pub struct Half(u16);

impl From<Half> for f32 {
    /// The exact value.
    fn from(Half(bits): Half) -> f32 {
        let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
        let (exponent, fraction) = (i32::from(bits >> 10 & 31), f32::from(bits & 1023));
        sign * match exponent {
            0 => fraction * 2f32.powi(-24),
            31 if fraction == 0.0 => f32::INFINITY,
            31 => f32::NAN,
            _ => (1024.0 + fraction) * 2f32.powi(exponent - 25),
        }
    }
}

impl Element for Half {
    const NAME: &'static str = "<f2";

    fn decode(descr: &str, bytes: &[u8]) -> Decoded<Self> {
        Ok(match descr {
            "<f2" => Some(from_bytes(bytes, |b| Half(u16::from_le_bytes(b)))),
            ">f2" => Some(from_bytes(bytes, |b| Half(u16::from_be_bytes(b)))),
            _ => None,
        })
    }

    fn encode(values: &[Self], sink: &mut impl Write) -> io::Result<()> {
        write_bytes(values, sink, |half| half.0.to_le_bytes())
    }
}

macro_rules! complex {
    ($($part:ty: $little:literal, $big:literal;)*) => {$(
        impl Element for Complex<$part> {
            const NAME: &'static str = $little;

            fn decode(descr: &str, bytes: &[u8]) -> Decoded<Self> {
                const PART: usize = size_of::<$part>();
                let parts = |z: [u8; 2 * PART]| [0, PART].map(|at| array::from_fn(|k| z[at + k]));
                let number = |[re, im]: [$part; 2]| Complex::new(re, im);
                Ok(match descr {
                    $little => Some(from_bytes(bytes, |z| number(parts(z).map(<$part>::from_le_bytes)))),
                    $big => Some(from_bytes(bytes, |z| number(parts(z).map(<$part>::from_be_bytes)))),
                    _ => None,
                })
            }

            fn encode(values: &[Self], sink: &mut impl Write) -> io::Result<()> {
                const PART: usize = size_of::<$part>();
                write_bytes::<_, { 2 * PART }>(values, sink, |z| {
                    let parts = [z.re, z.im].map(<$part>::to_le_bytes);
                    array::from_fn(|k| parts[k / PART][k % PART])
                })
            }
        }
    )*};
}

complex! {
    f32: "<c8", ">c8";
    f64: "<c16", ">c16";
}

impl Element for bool {
    const NAME: &'static str = "|b1";

    fn decode(descr: &str, bytes: &[u8]) -> Decoded<Self> {
        if descr != Self::NAME {
            return Ok(None);
        }
        match bytes.iter().find(|&&byte| byte > 1) {
            Some(byte) => Err(format!("{byte:#04x} is not a truth value")),
            None => Ok(Some(bytes.iter().map(|&byte| byte == 1).collect())),
        }
    }

    fn encode(values: &[Self], sink: &mut impl Write) -> io::Result<()> {
        write_bytes(values, sink, |&value| [value.into()])
    }
}

fn from_bytes<T, const N: usize>(bytes: &[u8], number: impl Fn([u8; N]) -> T) -> Vec<T> {
    bytes.as_chunks().0.iter().map(|&b| number(b)).collect()
}

fn write_bytes<T, const N: usize>(
    values: &[T],
    sink: &mut impl Write,
    bytes: impl Fn(&T) -> [u8; N],
) -> io::Result<()> {
    // A call of the sink for many numbers.
    let mut some = [[0; N]; 1024];
    for values in values.chunks(some.len()) {
        for (some, value) in some.iter_mut().zip(values) {
            *some = bytes(value);
        }
        sink.write_all(some[..values.len()].as_flattened())?;
    }
    Ok(())
}

/// Reads an array of element type `T` in row-major order, from either order.
pub fn read<T: Element>(bytes: &[u8]) -> std::result::Result<ArrayD<T>, NpyError> {
    let damaged = |message: String| NpyError::Damaged(message);
    // Before anything is allocated: a damaged header may ask for more memory than any machine has.
    let (header, numbers) = Header::read(bytes).map_err(NpyError::Damaged)?;
    let held = bytes.len();
    if let Some(missing) = numbers.end.checked_sub(held).filter(|&missing| missing > 0) {
        return Err(damaged(format!(
            "is truncated: {missing} bytes are missing"
        )));
    }
    // The array, its row-major copy, and what it is converted to.
    memory::check(held.saturating_mul(CONVERSIONS), "the array")
        .map_err(|e| damaged(format!("is too large: {e}")))?;
    let extra = held - numbers.end;
    let numbers = T::decode(&header.descr, &bytes[numbers])
        .map_err(|e| damaged(format!("is damaged: {e}")))?
        .ok_or_else(|| NpyError::Type(format!("'{}'", header.descr)))?;
    if extra > 0 {
        return Err(damaged(format!("is damaged: {extra} bytes too many")));
    }
    let shape = IxDyn(&header.shape).set_f(header.in_columns);
    let array = ArrayD::from_shape_vec(shape, numbers);
    let array = array.map_err(|e| damaged(format!("is damaged: {e}")))?;
    if array.is_standard_layout() {
        Ok(array)
    } else {
        Ok(array.as_standard_layout().into_owned())
    }
}

/// Writes an array: by columns if it is so in memory, else by rows.
///
/// # Errors
/// Errors of the sink.
pub fn write<T: Element, D: Dimension>(
    array: &ArrayRef<T, D>,
    sink: &mut impl Write,
) -> io::Result<()> {
    let reversed = array.t();
    let in_columns = !array.is_standard_layout() && reversed.is_standard_layout();
    let header = Header {
        descr: T::NAME.into(),
        in_columns,
        shape: array.shape().to_vec(),
    };
    sink.write_all(&header.bytes())?;
    let rows = array.as_standard_layout();
    let numbers = if in_columns {
        reversed.as_slice()
    } else {
        rows.as_slice()
    };
    T::encode(numbers.unwrap_or_default(), sink)
}

/// Reads a `.npy` file of element type `T`.
///
/// # Errors
/// [`crate::Error::File`]: it cannot be opened, is damaged, or has another element type.
pub fn read_array<T: Element>(path: &Path) -> Result<ArrayD<T>> {
    let bytes = input::read(path, u64::MAX).map_err(|e| file_error(path, cannot_be_opened(&e)))?;
    read(&bytes).map_err(|error| match error {
        NpyError::Type(found) => file_error(path, format!("has the element type {found}")),
        NpyError::Damaged(how) => file_error(path, how),
    })
}

/// Tries another element type if the first did not match.
pub fn or_type<T, F>(
    first: std::result::Result<ArrayD<T>, NpyError>,
    next: F,
) -> std::result::Result<ArrayD<T>, NpyError>
where
    F: FnOnce() -> std::result::Result<ArrayD<T>, NpyError>,
{
    match first {
        Err(NpyError::Type(_)) => next(),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::{Array, ArrayView, Ix0, Ix1, Ix2, Ix3};
    use ndarray_npy::{ReadNpyExt, WritableElement, WriteNpyExt};

    fn bytes<T: Element, D: Dimension>(array: &ArrayRef<T, D>) -> Vec<u8> {
        let mut bytes = Vec::new();
        write(array, &mut bytes).unwrap();
        bytes
    }

    /// Written as another library writes it, and read again.
    fn written<T, D>(view: ArrayView<T, D>)
    where
        T: Element + WritableElement + PartialEq + std::fmt::Debug,
        D: Dimension,
    {
        let mut expected = Vec::new();
        view.write_npy(&mut expected).unwrap();
        let own = bytes(&view);
        assert_eq!(own, expected, "{:?} {}", view.shape(), T::NAME);
        let Ok(back) = read::<T>(&own) else {
            panic!("{:?} {}", view.shape(), T::NAME);
        };
        assert_eq!(back, view.to_owned().into_dyn());
    }

    fn of<T>(number: fn(usize) -> T)
    where
        T: Element + WritableElement + PartialEq + std::fmt::Debug,
    {
        let cube = |sides: [usize; 3]| {
            let values = (0..sides.iter().product()).map(number).collect();
            Array::<T, Ix3>::from_shape_vec(sides, values).unwrap()
        };
        written(cube([2, 3, 5]).view());
        written(cube([2, 0, 5]).view());
        // More numbers than are written at once.
        written(cube([3, 29, 31]).view());
        written(cube([2, 3, 5]).t());
        written(cube([2, 3, 5]).permuted_axes([1, 0, 2]).view());
        written(Array::<T, Ix0>::from_elem((), number(7)).view());
        written(Array::<T, Ix1>::from_iter((0..9).map(number)).view());
        written(Array::<T, Ix2>::from_shape_fn((1, 200), |(_, k)| number(k)).view());
    }

    #[test]
    fn files_are_those_of_another_library() {
        of(|k| k as i8);
        of(|k| k as u8);
        of(|k| k as i16 - 9);
        of(|k| k as u16);
        of(|k| k as i32 - 9);
        of(|k| k as u32);
        of(|k| k as i64 - 9);
        of(|k| k as u64);
        of(|k| k as f32 / 7.0);
        of(|k| k as f64 / 7.0);
        of(|k| Complex::new(k as f32, -0.5));
        of(|k| Complex::new(k as f64, -0.5));
        of(|k| k % 3 == 1);
    }

    #[test]
    fn big_endian_numbers_are_read() {
        let header = |descr: &str| {
            let header = Header {
                descr: descr.into(),
                in_columns: false,
                shape: vec![2],
            };
            header.bytes()
        };
        let mut file = header(">c8");
        file.extend(
            [1.5f32, -2.0, 0.0, 3e9]
                .map(f32::to_be_bytes)
                .as_flattened(),
        );
        let expected = ArrayD::<Complex<f32>>::read_npy(file.as_slice()).unwrap();
        assert!(read(&file).is_ok_and(|read: ArrayD<Complex<f32>>| read == expected));
        let mut file = header(">i2");
        file.extend([-2i16, 300].map(i16::to_be_bytes).as_flattened());
        assert!(read(&file).is_ok_and(|read| read.as_slice() == Some(&[-2i16, 300])));
        // Of another type, with a byte too many, and with a value that no bool has.
        assert!(matches!(read::<f32>(&file), Err(NpyError::Type(name)) if name == "'>i2'"));
        file.push(0);
        assert!(
            matches!(read::<i16>(&file), Err(NpyError::Damaged(e)) if e.contains("1 bytes too many"))
        );
        let mut file = header("|b1");
        file.extend([1, 2]);
        assert!(matches!(read::<bool>(&file), Err(NpyError::Damaged(e)) if e.contains("0x02")));
    }
}
