//! Elements of a MATLAB 5 file.

/// Length of the tag before an element: type and length.
pub const TAG: usize = 8;
/// The flag of an array with an imaginary part.
pub const COMPLEX: u32 = 0x800;

/// An array before its numbers are read.
pub struct Array<'a> {
    pub class: u8,
    pub complex: bool,
    /// Sides as claimed; a negative side becomes a very large one.
    pub sides: Vec<usize>,
    pub name: &'a [u8],
    /// The real part, then the imaginary one.
    pub numbers: Elements<'a>,
}

/// Consecutive elements: type and length, then bytes padded to a multiple of 8.
pub struct Elements<'a> {
    pub rest: &'a [u8],
    pub big_endian: bool,
}

impl<'a> Elements<'a> {
    pub fn number(&self, at: usize) -> Option<u32> {
        let four = *self.rest.get(at..)?.first_chunk()?;
        Some(match self.big_endian {
            true => u32::from_be_bytes(four),
            false => u32::from_le_bytes(four),
        })
    }

    /// The type and the bytes of the next element.
    pub fn next(&mut self) -> Option<(u32, &'a [u8])> {
        let tag = self.number(0)?;
        // Up to four bytes share the tag's eight.
        let (kind, begin, length) = match tag >> 16 {
            0 => (tag, TAG, self.number(4)? as usize),
            length @ 1..=4 => (tag & 0xffff, 4, length as usize),
            _ => return None,
        };
        let end = begin.checked_add(length)?;
        let bytes = self.rest.get(begin..end)?;
        let padded = end.checked_next_multiple_of(TAG)?;
        self.rest = self.rest.get(padded..).unwrap_or_default();
        Some((kind, bytes))
    }

    /// The array that consists of these elements, from its flags on.
    pub fn array(mut self) -> Option<Array<'a>> {
        let (_, flags) = self.next()?;
        let flags = self.like(flags).number(0)?;
        let (_, sides) = self.next()?;
        let sides = self.like(sides);
        let side = |k| Some(sides.number(4 * k)? as i32 as usize);
        let sides = (0..sides.rest.len() / 4).map(side).collect::<Option<_>>()?;
        let (_, name) = self.next()?;
        Some(Array {
            class: flags as u8,
            complex: flags & COMPLEX != 0,
            sides,
            name,
            numbers: self,
        })
    }

    pub fn like(&self, bytes: &'a [u8]) -> Self {
        Elements {
            rest: bytes,
            big_endian: self.big_endian,
        }
    }

    /// The numbers of the next element.
    ///
    /// Their type is the element's own: MATLAB stores whole numbers of any class in the smallest type that holds
    /// them.
    pub fn numbers<T>(&mut self, text: bool, convert: impl Fn(f64) -> T) -> Option<Vec<T>> {
        let (kind, bytes) = self.next()?;
        let big_endian = self.big_endian;
        macro_rules! numbers {
            ($type:ty) => {{
                let (chunks, _) = bytes.as_chunks();
                let number = |&chunk| match big_endian {
                    true => <$type>::from_be_bytes(chunk),
                    false => <$type>::from_le_bytes(chunk),
                };
                chunks
                    .iter()
                    .map(|chunk| convert(number(chunk) as f64))
                    .collect()
            }};
        }
        Some(match kind {
            1 => numbers!(i8),
            2 => numbers!(u8),
            3 => numbers!(i16),
            4 => numbers!(u16),
            5 => numbers!(i32),
            6 => numbers!(u32),
            7 => numbers!(f32),
            9 => numbers!(f64),
            12 => numbers!(i64),
            13 => numbers!(u64),
            // Text: UTF-8 and UTF-16.
            16 if text => numbers!(u8),
            17 if text => numbers!(u16),
            _ => return None,
        })
    }
}
