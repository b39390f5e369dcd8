//! Pixels in a file: their type and order, raw or compressed, read frame by frame.

use std::fs::File;
use std::io::{self, BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use bonebeam_files::memory::{self, product};
use bonebeam_files::{Result, cannot_be_opened, file_error, input};
use flate2::read::{MultiGzDecoder, ZlibDecoder};

use super::header::Header;

/// Longest side of a picture, pixels.
const LONGEST_SIDE: usize = 16_384;
/// Most bytes of a frame.
const LARGEST_FRAME: usize = 1 << 30;

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Element {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    F32,
    F64,
}

impl Element {
    /// Bytes of a number.
    pub fn size(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The number at the beginning of `bytes`; 0 past their end.
    pub fn value(self, bytes: &[u8], big_endian: bool) -> f32 {
        fn of<const N: usize>(bytes: &[u8], big_endian: bool) -> [u8; N] {
            let mut own = bytes.first_chunk::<N>().copied().unwrap_or([0; N]);
            if big_endian {
                own.reverse();
            }
            own
        }
        match self {
            Self::U8 => f32::from(u8::from_le_bytes(of(bytes, big_endian))),
            Self::I8 => f32::from(i8::from_le_bytes(of(bytes, big_endian))),
            Self::U16 => f32::from(u16::from_le_bytes(of(bytes, big_endian))),
            Self::I16 => f32::from(i16::from_le_bytes(of(bytes, big_endian))),
            Self::U32 => u32::from_le_bytes(of(bytes, big_endian)) as f32,
            Self::I32 => i32::from_le_bytes(of(bytes, big_endian)) as f32,
            Self::F32 => f32::from_le_bytes(of(bytes, big_endian)),
            Self::F64 => f64::from_le_bytes(of(bytes, big_endian)) as f32,
        }
    }
}

/// The grey level of a pixel of 1, 3 or 4 numbers: of colours their Rec. 709 luma.
pub fn grey(components: usize, value: impl Fn(usize) -> f32) -> f32 {
    match components {
        1 => value(0),
        _ => 0.2126 * value(0) + 0.7152 * value(1) + 0.0722 * value(2),
    }
}

/// What an axis counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Axis {
    /// Red, green and blue.
    Component,
    /// An axis of the picture.
    Picture,
    /// Frames.
    Frame,
}

/// How the numbers are packed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Packing {
    Raw,
    Zlib,
    Gzip,
}

/// The numbers of all frames, and their place in a file.
#[derive(Clone, Debug)]
pub struct Pixels {
    /// The file.
    pub path: PathBuf,
    /// Bytes before the numbers.
    pub offset: u64,
    /// Bytes of the packed numbers, if the header says so.
    pub length: Option<u64>,
    pub packing: Packing,
    pub element: Element,
    pub big_endian: bool,
    /// Sides of the frame's picture in the file: [fast, slow].
    pub sides: [usize; 2],
    /// Numbers of a pixel.
    pub components: usize,
    /// Number of frames.
    pub frames: usize,
    /// Distances between neighbours, in numbers: components, fast axis, slow axis.
    pub strides: [usize; 3],
    /// Distance between frames that run faster than an axis of the picture.
    ///
    /// In numbers. The file is then read whole.
    pub frame_stride: Option<usize>,
}

impl Pixels {
    /// The pixels of a header: behind it, or in `file` of the same folder.
    ///
    /// # Errors
    /// A name that is not that of one file beside the header, sides that no picture has, or volumes.
    pub fn of(
        path: &Path,
        header: &Header,
        packing: Packing,
        element: Element,
        big_endian: bool,
        axes: &[(Axis, usize)],
        file: Option<&str>,
    ) -> std::result::Result<Self, String> {
        let mut pixels = Self {
            path: path.to_path_buf(),
            offset: 0,
            length: None,
            packing,
            element,
            big_endian,
            sides: [0; 2],
            components: 1,
            frames: 1,
            strides: [1; 3],
            frame_stride: None,
        };
        pixels.arrange(axes)?;
        let Some(file) = file else {
            pixels.offset = header.length;
            return Ok(pixels);
        };
        let plain = Path::new(file).file_name().is_some_and(|name| name == file);
        if !plain || file.contains('%') || file.starts_with("LIST") {
            return Err(format!(
                "has its pixels in {file}; expected one file in the same folder"
            ));
        }
        pixels.path = path.with_file_name(file);
        Ok(pixels)
    }

    /// The order of the numbers by the axes of a header, the fastest first.
    ///
    /// # Errors
    /// Sides that no picture has, or volumes.
    fn arrange(&mut self, axes: &[(Axis, usize)]) -> std::result::Result<(), String> {
        let of = |axis: Axis| axes.iter().filter(move |(kind, _)| *kind == axis);
        let mut sides: Vec<usize> = of(Axis::Picture).map(|(_, side)| *side).collect();
        // PLUS writes the one slice of a picture as an axis of its own.
        while sides.len() > 2 && sides.last() == Some(&1) {
            sides.pop();
        }
        let [fast, slow] = sides[..] else {
            return Err(format!(
                "has frames of the sides {sides:?}; expected pictures of two axes"
            ));
        };
        if of(Axis::Frame).count() > 1 || of(Axis::Component).count() > 1 {
            return Err("has two axes of frames or of colours".into());
        }
        let count = |axis| of(axis).map(|(_, side)| *side).next().unwrap_or(1);
        (self.sides, self.components, self.frames) =
            ([fast, slow], count(Axis::Component), count(Axis::Frame));
        if fast.min(slow) == 0 || fast.max(slow) > LONGEST_SIDE {
            return Err(format!(
                "has pictures of {fast} x {slow}; expected sides of 1 to {LONGEST_SIDE} pixels"
            ));
        }
        if ![1, 3, 4].contains(&self.components) {
            return Err(format!(
                "has pixels of {} numbers; expected 1, 3 or 4",
                self.components
            ));
        }
        if !(1..=super::header::MOST_FRAMES).contains(&self.frames) {
            return Err(format!("claims {} frames", self.frames));
        }
        // Of one frame's numbers; those of several frames may lie between them.
        let mut stride = 1;
        let mut own = [1, 0, 0];
        let mut frame = None;
        for (axis, side) in axes {
            match axis {
                Axis::Component => own[0] = stride,
                Axis::Frame => frame = Some(stride),
                Axis::Picture if own[1] == 0 => own[1] = stride,
                Axis::Picture if own[2] == 0 => own[2] = stride,
                Axis::Picture => {}
            }
            if *axis != Axis::Frame {
                stride *= side;
            }
        }
        self.strides = own;
        self.frame_stride = frame.filter(|stride| *stride < fast * slow * self.components);
        self.frame_stride = self.frame_stride.filter(|_| self.frames > 1);
        match self.frame_bytes() <= LARGEST_FRAME {
            true => Ok(()),
            false => Err("has frames of more than 1 GiB".into()),
        }
    }

    /// Bytes of a frame.
    pub fn frame_bytes(&self) -> usize {
        product(&[
            self.sides[0],
            self.sides[1],
            self.components,
            self.element.size(),
        ])
    }

    /// Refuses a file that is shorter than its header says.
    ///
    /// # Errors
    /// A file that cannot be opened, or with fewer bytes.
    pub fn check(&self) -> Result<()> {
        let file = input::open(&self.path).map_err(|e| self.error(cannot_be_opened(&e)))?;
        let held = file
            .metadata()
            .map_err(|e| self.error(cannot_be_opened(&e)))?
            .len();
        let held = held.saturating_sub(self.offset);
        let frame = self.frame_bytes() as u64;
        match (self.packing, self.length) {
            (Packing::Raw, _) if held < frame * self.frames as u64 => {
                let message = format!(
                    "holds {} whole frames; the header says {}",
                    held / frame,
                    self.frames
                );
                Err(self.error(message))
            }
            (Packing::Zlib | Packing::Gzip, Some(length)) if held < length => Err(self.error(
                format!("holds {held} bytes of compressed frames; the header says {length}"),
            )),
            _ => Ok(()),
        }
    }

    /// An error about the file.
    pub fn error(&self, message: impl Into<String>) -> bonebeam_files::Error {
        file_error(&self.path, message)
    }

    /// Opens the file at its first frame.
    ///
    /// # Errors
    /// A file that cannot be opened, or too little memory for one that is read whole.
    pub fn open(&self) -> Result<Bytes<'_>> {
        let wrong = |e: io::Error| self.error(cannot_be_opened(&e));
        let mut file = input::open(&self.path).map_err(wrong)?;
        file.seek(SeekFrom::Start(self.offset)).map_err(wrong)?;
        let file = BufReader::with_capacity(1 << 17, file);
        let mut source = match self.packing {
            Packing::Raw => Source::Raw(file),
            Packing::Zlib => Source::Packed(Box::new(ZlibDecoder::new(file))),
            Packing::Gzip => Source::Packed(Box::new(MultiGzDecoder::new(file))),
        };
        if self.frame_stride.is_some() {
            let bytes = product(&[self.frame_bytes(), self.frames]);
            let own = "reading frames that alternate pixel by pixel";
            memory::check(bytes, own).map_err(|e| self.error(e.to_string()))?;
            let mut whole = vec![0; bytes];
            self.fill(&mut source, &mut whole, 0)?;
            source = Source::Whole(whole);
        }
        Ok(Bytes {
            pixels: self,
            source,
            next: 0,
        })
    }

    fn fill(&self, source: &mut Source, bytes: &mut [u8], frame: usize) -> Result<()> {
        let read = match source {
            Source::Raw(file) => file.read_exact(bytes),
            Source::Packed(stream) => stream.read_exact(bytes),
            Source::Whole(_) => Ok(()),
        };
        read.map_err(|e| {
            let reason = match e.kind() {
                ErrorKind::UnexpectedEof => "is truncated".to_owned(),
                _ => format!("is damaged ({e})"),
            };
            self.error(format!("{reason} within frame {frame} of {}", self.frames))
        })
    }
}

enum Source {
    Raw(BufReader<File>),
    Packed(Box<dyn Read + Send>),
    Whole(Vec<u8>),
}

/// The bytes of frames, in their order.
pub struct Bytes<'p> {
    pixels: &'p Pixels,
    source: Source,
    next: usize,
}

impl Bytes<'_> {
    /// The bytes of a frame, at or after the next.
    ///
    /// # Errors
    /// A truncated or damaged file.
    pub fn frame(&mut self, frame: usize) -> Result<Vec<u8>> {
        let pixels = self.pixels;
        let mut bytes = vec![0; pixels.frame_bytes()];
        if let (Source::Whole(whole), Some(stride)) = (&self.source, pixels.frame_stride) {
            // Within a block of `stride` numbers there is no frame axis; blocks of frames alternate.
            let size = stride * pixels.element.size();
            let blocks = whole.chunks_exact(size).skip(frame).step_by(pixels.frames);
            for (to, from) in bytes.chunks_exact_mut(size).zip(blocks) {
                to.copy_from_slice(from);
            }
            return Ok(bytes);
        }
        if let Source::Raw(file) = &mut self.source {
            let skipped = frame.saturating_sub(self.next) as i64 * bytes.len() as i64;
            let skipped = file.seek_relative(skipped);
            skipped.map_err(|e| pixels.error(cannot_be_opened(&e)))?;
            self.next = self.next.max(frame);
        }
        while self.next <= frame {
            pixels.fill(&mut self.source, &mut bytes, self.next)?;
            self.next += 1;
        }
        Ok(bytes)
    }
}
