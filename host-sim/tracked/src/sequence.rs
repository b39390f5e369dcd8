//! A sequence of tracked pictures: its frames, poses and pixels.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use ndarray::{Array2, Array3, Axis};
use num_complex::Complex32;

use bonebeam_files::{Error, Result, file_error, image};

use crate::dicom;
use crate::header::Fields;
use crate::orientation::Orientation;
use crate::pixels::{Bytes, Element, Pixels, grey};
use crate::poses::PoseTable;
use crate::transforms::Matrix;

/// Side of a pixel of a recording's plane, mm.
pub(crate) const RECORDING_PIXEL: f64 = 0.1;

/// Content of the frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Content {
    /// Grey levels.
    Brightness,
    /// Colours.
    Rgb,
    /// Lines of RF.
    RfReal,
    /// Lines of I/Q, sample by sample.
    RfIqLine,
    /// Lines of I and lines of Q in turn.
    RfILineQLine,
}

impl Content {
    /// Contents by PLUS's names.
    const NAMES: [(&'static str, Self); 5] = [
        ("BRIGHTNESS", Self::Brightness),
        ("RGB_COLOR", Self::Rgb),
        ("RF_REAL", Self::RfReal),
        ("RF_IQ_LINE", Self::RfIqLine),
        ("RF_I_LINE_Q_LINE", Self::RfILineQLine),
    ];

    pub(crate) fn of(name: &str) -> Option<Self> {
        let own = Self::NAMES.iter().find(|(own, _)| *own == name)?;
        Some(own.1)
    }

    /// PLUS's name.
    pub fn name(self) -> &'static str {
        let own = Self::NAMES.iter().find(|(_, own)| *own == self);
        own.map_or("", |own| own.0)
    }

    /// Whether frames are lines along beams instead of pictures.
    pub fn is_lines(self) -> bool {
        ![Self::Brightness, Self::Rgb].contains(&self)
    }
}

/// A transform of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Tracked {
    /// The matrix, mm; `None` if the file has none for this frame.
    pub matrix: Option<Matrix>,
    /// PLUS's status: `OK`, or `INVALID`, `OUT_OF_VIEW` and others.
    pub status: String,
}

/// A frame without its pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Time, s.
    pub timestamp: Option<f64>,
    /// Whether the frame has a valid picture.
    pub has_picture: bool,
    /// Transforms by their names, such as `ProbeToTracker`.
    pub transforms: BTreeMap<String, Tracked>,
}

/// A tracked sequence.
pub struct Sequence {
    /// The file or the folder.
    pub path: PathBuf,
    /// Name of the format.
    pub format: &'static str,
    /// Content of the frames.
    pub content: Content,
    /// Orientation of the pixels in the file; [`Sequence::picture`] returns `MF`.
    pub orientation: Orientation,
    /// Sides of the `MF` picture, [columns, rows]; or [samples, lines].
    pub sides: [usize; 2],
    /// Frames, in order.
    pub frames: Vec<Frame>,
    /// Sides of a pixel along columns and rows, mm, if the file gives them.
    pub pixel: Option<[f64; 2]>,
    /// The part that shows tissue, if the file says so: column, row, width, height.
    pub part: Option<[usize; 4]>,
    /// Fields of the file.
    pub fields: Fields,
    /// What the file does not say and was assumed.
    pub assumed: Vec<String>,
    pub(crate) source: Source,
}

pub(crate) enum Source {
    Pixels(Pixels),
    Pictures(Vec<PathBuf>),
    Memory(Array3<f32>),
    Dicom(Box<dicom::Pictures>),
}

impl Sequence {
    pub(crate) fn of_pictures(
        path: &Path,
        pictures: Vec<PathBuf>,
        frames: Vec<Frame>,
        assumed: Vec<String>,
    ) -> Result<Self> {
        let first = pictures
            .first()
            .ok_or_else(|| file_error(path, "has no pictures"))?;
        let (rows, columns) = image::read(first)?.dim();
        Ok(Self {
            path: path.to_path_buf(),
            format: "folder of PNGs",
            content: Content::Brightness,
            orientation: Orientation::MF,
            sides: [columns, rows],
            frames,
            pixel: None,
            part: None,
            fields: Fields::new(),
            assumed,
            source: Source::Pictures(pictures),
        })
    }

    /// Pictures `[frame, row, column]` with matrices to `Reference`, mm.
    ///
    /// # Errors
    /// Another number of matrices than of frames, or no pixels.
    pub fn of_arrays(pictures: Array3<f32>, poses: &[Option<Matrix>]) -> Result<Self> {
        let (frames, rows, columns) = pictures.dim();
        if frames != poses.len() || pictures.is_empty() {
            return Err(Error::Data(format!(
                "{frames} pictures of {columns} x {rows} pixels have {} poses",
                poses.len()
            )));
        }
        let frame = |matrix: &Option<Matrix>| {
            let pose = Tracked {
                matrix: *matrix,
                status: "OK".into(),
            };
            Frame {
                has_picture: true,
                transforms: [("ImageToReference".into(), pose)].into(),
                timestamp: None,
            }
        };
        Ok(Self {
            path: "arrays".into(),
            format: "arrays",
            content: Content::Brightness,
            orientation: Orientation::MF,
            sides: [columns, rows],
            frames: poses.iter().map(frame).collect(),
            pixel: None,
            part: None,
            fields: Fields::new(),
            assumed: Vec::new(),
            source: Source::Memory(pictures),
        })
    }

    /// The poses of a recording's frames, whose picture is a plane of 0.1 mm pixels.
    ///
    /// `Image` has its origin in the middle of the array, columns along it, and rows along the depth. `poses` are
    /// positions in m with Euler angles about fixed axes, rad, or quaternions x, y, z, w.
    pub fn of_recording(path: &Path, poses: &[Option<Vec<f64>>]) -> Self {
        let side = RECORDING_PIXEL;
        let image = [
            [side, 0.0, 0.0, 0.0],
            [0.0, 0.0, -1.0, 0.0],
            [0.0, side, 0.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ];
        let of = |matrix: Option<Matrix>| Tracked {
            matrix,
            status: "OK".into(),
        };
        let frame = |pose: &Option<Vec<f64>>| Frame {
            has_picture: true,
            transforms: [
                ("ImageToProbe".into(), of(Some(image))),
                (
                    "ProbeToReference".into(),
                    of(pose.as_ref().and_then(|pose| PoseTable::in_metres(pose))),
                ),
            ]
            .into(),
            timestamp: None,
        };
        let is_euler = poses.iter().flatten().any(|pose| pose.len() == 6);
        Self {
            path: path.to_path_buf(),
            format: "recording",
            content: Content::Brightness,
            orientation: Orientation::MF,
            sides: [400; 2],
            frames: poses.iter().map(frame).collect(),
            pixel: None,
            part: None,
            fields: Fields::new(),
            assumed: is_euler
                .then(|| "angles of poses turn about the fixed axes x, y, z, rad".to_owned())
                .into_iter()
                .collect(),
            source: Source::Memory(Array3::zeros((0, 0, 0))),
        }
    }

    /// The names of the transforms of all frames.
    pub fn transform_names(&self) -> BTreeSet<&str> {
        let names = self.frames.iter().flat_map(|frame| frame.transforms.keys());
        names.map(String::as_str).collect()
    }

    /// Frames a second by the timestamps' median distance.
    pub fn rate(&self) -> Option<f64> {
        let times: Vec<f64> = self
            .frames
            .iter()
            .filter_map(|frame| frame.timestamp)
            .collect();
        let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.sort_by(f64::total_cmp);
        let middle = *steps.get(steps.len() / 2)?;
        (middle > 0.0).then_some(1.0 / middle)
    }

    /// Opens the frames for reading, in order.
    ///
    /// # Errors
    /// A file that cannot be opened.
    pub fn reader(&self) -> Result<Reader<'_>> {
        let bytes = match &self.source {
            Source::Pixels(pixels) => Some(pixels.open()?),
            Source::Pictures(_) | Source::Memory(_) | Source::Dicom(_) => None,
        };
        Ok(Reader {
            sequence: self,
            bytes,
        })
    }

    /// The numbers of a frame as an `MF` picture, `[row, column]`.
    ///
    /// Colours become their Rec. 709 luma.
    ///
    /// # Errors
    /// A PNG that is damaged or of another size, or a NaN or infinite number.
    pub fn picture(&self, encoded: Encoded) -> Result<Array2<f32>> {
        let [columns, rows] = self.sides;
        let picture = match (&self.source, encoded) {
            (Source::Pixels(pixels), Encoded::Bytes(bytes)) => self.arranged(pixels, &bytes),
            (_, Encoded::Picture(path)) => {
                let picture = image::read(&path)?;
                if picture.dim() != (rows, columns) {
                    let (own_rows, own_columns) = picture.dim();
                    return Err(file_error(
                        &path,
                        format!(
                            "has {own_columns} x {own_rows} pixels; the first has {columns} x {rows}"
                        ),
                    ));
                }
                picture
            }
            (Source::Memory(pictures), Encoded::Held(frame)) => {
                pictures.index_axis(Axis(0), frame).to_owned()
            }
            (Source::Dicom(pictures), Encoded::Held(frame)) => {
                let picture = pictures.picture(frame);
                picture.map_err(|message| file_error(&self.path, message))?
            }
            _ => Array2::zeros((rows, columns)),
        };
        match picture.iter().all(|level| level.is_finite()) {
            true => Ok(picture),
            false => Err(file_error(&self.path, "holds a NaN or infinite pixel")),
        }
    }

    /// Checks that the levels of pictures are 0 to 255, if they may be others.
    ///
    /// # Errors
    /// Numbers of another range, such as 0 to 1 or decibels.
    pub fn check_levels(&self, picture: &Array2<f32>) -> Result<()> {
        let wide = match &self.source {
            Source::Pixels(pixels) if pixels.element == Element::U8 => return Ok(()),
            Source::Pixels(_) | Source::Memory(_) => false,
            Source::Dicom(pictures) if pictures.is_wide() => true,
            Source::Pictures(_) | Source::Dicom(_) => return Ok(()),
        };
        image::check_levels(picture, wide).map_err(|message| file_error(&self.path, message))
    }

    fn arranged(&self, pixels: &Pixels, bytes: &[u8]) -> Array2<f32> {
        let size = pixels.element.size();
        let value = |at: usize| {
            let bytes = bytes.get(at * size..).unwrap_or_default();
            pixels.element.value(bytes, pixels.big_endian)
        };
        let [of_component, fast, slow] = pixels.strides;
        let plain = pixels.components == 1 && self.orientation == Orientation::MF;
        if plain && pixels.element == Element::U8 && [fast, slow] == [1, pixels.sides[0]] {
            // The usual case, without a decision for each pixel.
            let levels = bytes.iter().copied().map(f32::from).collect();
            return Array2::from_shape_vec((pixels.sides[1], fast * slow), levels)
                .unwrap_or_default();
        }
        let [columns, rows] = match self.orientation.transposed {
            true => [pixels.sides[1], pixels.sides[0]],
            false => pixels.sides,
        };
        Array2::from_shape_fn((rows, columns), |(row, column)| {
            let [a, b] = self.orientation.place([column, row], [columns, rows]);
            let at = a * fast + b * slow;
            grey(pixels.components, |k| value(at + k * of_component))
        })
    }

    /// The lines of a frame of RF, `[line, sample]`, from the marked side.
    ///
    /// # Errors
    /// Frames that are pictures, or a NaN or infinite number.
    pub fn lines(&self, encoded: Encoded) -> Result<Array2<Complex32>> {
        let (Source::Pixels(pixels), Encoded::Bytes(bytes), true) =
            (&self.source, encoded, self.content.is_lines())
        else {
            return Err(file_error(&self.path, "holds pictures, not lines"));
        };
        // Pairs of I and Q are mirrored as one.
        let size = pixels.element.size();
        let value = |sample: usize, row: usize| {
            let at = size * (sample * pixels.strides[1] + row * pixels.strides[2]);
            pixels
                .element
                .value(bytes.get(at..).unwrap_or_default(), pixels.big_endian)
        };
        let [samples, lines] = self.sides;
        let of = |(line, sample): (usize, usize)| {
            let line = if self.orientation.unmarked {
                lines - 1 - line
            } else {
                line
            };
            let sample = if self.orientation.near {
                samples - 1 - sample
            } else {
                sample
            };
            match self.content {
                Content::RfIqLine => [value(2 * sample, line), value(2 * sample + 1, line)],
                Content::RfILineQLine => [value(sample, 2 * line), value(sample, 2 * line + 1)],
                _ => [value(sample, line), 0.0],
            }
        };
        let lines = Array2::from_shape_fn((lines, samples), |at| {
            let [re, im] = of(at);
            Complex32::new(re, im)
        });
        match lines
            .iter()
            .all(|value| value.re.is_finite() && value.im.is_finite())
        {
            true => Ok(lines),
            false => Err(file_error(&self.path, "holds a NaN or infinite sample")),
        }
    }
}

/// A frame's pixels as in the file; [`Sequence::picture`] decodes them.
pub enum Encoded {
    /// Numbers.
    Bytes(Vec<u8>),
    /// A PNG, not yet read.
    Picture(PathBuf),
    /// A frame in memory, or in a DICOM file.
    Held(usize),
}

/// Reads the frames of a sequence, in order.
pub struct Reader<'s> {
    sequence: &'s Sequence,
    bytes: Option<Bytes<'s>>,
}

impl Reader<'_> {
    /// The pixels of a frame, at or after the last one that was read.
    ///
    /// # Errors
    /// A truncated or damaged file, or a frame beyond the last.
    pub fn frame(&mut self, frame: usize) -> Result<Encoded> {
        match (&mut self.bytes, &self.sequence.source) {
            (Some(bytes), _) if frame < self.sequence.frames.len() => {
                Ok(Encoded::Bytes(bytes.frame(frame)?))
            }
            (None, Source::Memory(pictures)) if frame < pictures.len_of(Axis(0)) => {
                Ok(Encoded::Held(frame))
            }
            (None, Source::Dicom(_)) if frame < self.sequence.frames.len() => {
                Ok(Encoded::Held(frame))
            }
            (None, Source::Pictures(pictures)) if frame < pictures.len() => {
                Ok(Encoded::Picture(pictures[frame].clone()))
            }
            _ => Err(file_error(
                &self.sequence.path,
                format!("has no frame {frame}"),
            )),
        }
    }
}
