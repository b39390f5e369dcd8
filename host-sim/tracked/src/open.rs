//! Opens sequences: their format by the content, their header as frames.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use bonebeam_files::{Result, cannot_be_opened, file_error, input};

use crate::header::{Fields, Header};
use crate::orientation::Orientation;
use crate::pixels::Pixels;
use crate::poses::PoseTable;
use crate::sequence::{Content, Frame, Sequence, Source, Tracked};
use crate::transforms::{Matrix, check_last_row, name_parts};
use crate::{dicom, folder, metaimage, nrrd};

/// Number of a frame's transforms that are read from a header at most.
const MOST_TRANSFORMS: usize = 64;
/// Largest deviation of the scale of a tracker's pose from 1.
const RIGID: f64 = 0.02;

impl Sequence {
    /// Whether a path looks like a sequence, by its content.
    pub fn recognizes(path: &Path) -> bool {
        folder::is_folder_of_pictures(path)
            || beginning(path).is_ok_and(|bytes| Kind::of(&bytes).is_some())
    }

    /// Reads the header of a sequence, or the table of a folder.
    ///
    /// # Errors
    /// A file that is no sequence, is damaged, or holds less than its header says.
    pub fn open(path: &Path, poses: &PoseTable) -> Result<Self> {
        let wrong = |message: String| file_error(path, message);
        if path.is_dir() {
            return folder::open(path, poses);
        }
        let bytes = beginning(path).map_err(wrong)?;
        let kind = Kind::of(&bytes);
        let kind = kind.ok_or_else(|| {
            wrong("is no tracked sequence (.mha, .nrrd, DICOM, zea's HDF5 or a folder)".into())
        })?;
        if let Kind::Dicom = kind {
            return Self::of_dicom(path, dicom::read(path).map_err(wrong)?, poses);
        }
        let file = input::open(path).map_err(|e| wrong(cannot_be_opened(&e)))?;
        let mut reader = BufReader::new(file);
        let (header, pixels) = match kind {
            Kind::MetaImage => metaimage::read(path, &mut reader),
            _ => nrrd::read(path, &mut reader),
        }
        .map_err(wrong)?;
        Self::of_header(path, kind, header, pixels)
    }

    fn of_dicom(path: &Path, file: dicom::File, poses: &PoseTable) -> Result<Self> {
        let count = file.pictures.frames;
        let whole = "no region with a size in cm: the whole picture is used".to_owned();
        let mut assumed: Vec<String> = file.part.is_none().then_some(whole).into_iter().collect();
        let mut frames = vec![
            Frame {
                has_picture: true,
                ..Frame::default()
            };
            count
        ];
        if let Some(table) = &poses.path {
            let names: Vec<String> = (0..count).map(|k| k.to_string()).collect();
            let (own, also) = folder::posed_frames(path, &names, poses, table)?;
            frames = own;
            assumed.extend(also);
        }
        for (k, frame) in frames.iter_mut().enumerate() {
            let time = file.interval.map(|interval| interval * k as f64);
            frame.timestamp = frame.timestamp.or(time);
        }
        Ok(Self {
            path: path.to_path_buf(),
            format: "DICOM",
            content: match file.pictures.is_grey() {
                true => Content::Brightness,
                false => Content::Rgb,
            },
            orientation: Orientation::MF,
            sides: file.pictures.sides,
            frames,
            pixel: file.pixel,
            part: file.part,
            fields: Fields::new(),
            assumed,
            source: Source::Dicom(Box::new(file.pictures)),
        })
    }

    fn of_header(path: &Path, kind: Kind, header: Header, pixels: Pixels) -> Result<Self> {
        let wrong = |message: String| file_error(path, message);
        let mut assumed = Vec::new();
        // ITK keeps the names of MetaImage when it writes NRRD.
        let field = |names: [&'static str; 2]| {
            let found = names.map(|name| header.get(name).map(|value| (name, value)));
            found[0].or(found[1])
        };
        let content = field(["UltrasoundImageType", "ultrasound image type"]);
        let orientation = field(["UltrasoundImageOrientation", "ultrasound image orientation"]);
        let colours = pixels.components > 1;
        let content = match content {
            None if colours => Content::Rgb,
            None => Content::Brightness,
            Some((key, name)) => Content::of(name).ok_or_else(|| {
                wrong(format!(
                    "has {key} = {name}; expected BRIGHTNESS, RGB_COLOR or RF lines"
                ))
            })?,
        };
        let orientation = match orientation {
            Some((key, code)) if code != "XX" => Orientation::of(code).ok_or_else(|| {
                wrong(format!("has {key} = {code}; expected one such as MF or FM"))
            })?,
            _ => {
                assumed.push("UltrasoundImageOrientation = MF".into());
                Orientation {
                    transposed: content.is_lines(),
                    ..Orientation::MF
                }
            }
        };
        if content.is_lines() && (!orientation.transposed || colours) {
            return Err(wrong(
                "has lines that do not run along the fastest axis (FM)".into(),
            ));
        }
        let [fast, slow] = pixels.sides;
        let sides = match content {
            Content::RfIqLine => [fast / 2, slow],
            Content::RfILineQLine => [fast, slow / 2],
            Content::RfReal => [fast, slow],
            _ if orientation.transposed => [slow, fast],
            _ => [fast, slow],
        };
        if sides.contains(&0)
            || (content == Content::RfIqLine && fast % 2 > 0)
            || (content == Content::RfILineQLine && slow % 2 > 0)
        {
            return Err(wrong(format!(
                "has I/Q lines in {fast} x {slow} numbers; expected pairs"
            )));
        }
        pixels.check()?;
        if let Some((&last, _)) = header
            .frames
            .last_key_value()
            .filter(|(k, _)| **k >= pixels.frames)
        {
            return Err(wrong(format!(
                "has fields of frame {last}, but pixels of {} frames",
                pixels.frames
            )));
        }
        let none = Fields::new();
        let frames = (0..pixels.frames)
            .map(|k| frame(header.frames.get(&k).unwrap_or(&none)))
            .collect::<std::result::Result<Vec<_>, _>>();
        let frames = frames.map_err(wrong)?;
        let pixel = spacing(&header, orientation);
        Ok(Self {
            path: path.to_path_buf(),
            format: match kind {
                Kind::MetaImage => "MetaImage",
                _ => "NRRD",
            },
            content,
            orientation,
            sides,
            frames,
            pixel,
            part: None,
            fields: header.fields,
            assumed,
            source: Source::Pixels(pixels),
        })
    }
}

#[derive(Clone, Copy)]
enum Kind {
    MetaImage,
    Nrrd,
    Dicom,
}

impl Kind {
    fn of(bytes: &[u8]) -> Option<Self> {
        if bytes.starts_with(nrrd::MAGIC) {
            return Some(Self::Nrrd);
        }
        let (at, mark) = dicom::MAGIC;
        if bytes.get(at..).is_some_and(|rest| rest.starts_with(mark)) {
            return Some(Self::Dicom);
        }
        let is = |magic: &&[u8]| bytes.starts_with(magic);
        metaimage::MAGIC.iter().any(is).then_some(Self::MetaImage)
    }
}

/// Whether a file is DICOM, by its mark.
pub(crate) fn is_dicom(path: &Path) -> bool {
    let kind = beginning(path).ok().and_then(|bytes| Kind::of(&bytes));
    matches!(kind, Some(Kind::Dicom))
}

/// The first bytes of a file.
fn beginning(path: &Path) -> std::result::Result<Vec<u8>, String> {
    let file: File = input::open(path).map_err(|e| cannot_be_opened(&e))?;
    let mut bytes = Vec::new();
    let read = file.take(256).read_to_end(&mut bytes);
    read.map_err(|e| cannot_be_opened(&e))?;
    Ok(bytes)
}

/// A frame by its fields.
fn frame(fields: &Fields) -> std::result::Result<Frame, String> {
    let mut frame = Frame {
        has_picture: true,
        ..Frame::default()
    };
    for (name, value) in fields {
        if name == "Status" || name == "ImageStatus" {
            frame.has_picture = value == "OK";
        } else if name == "Timestamp" {
            frame.timestamp = value.parse().ok().filter(|time: &f64| time.is_finite());
        } else if let Some(name) = name.strip_suffix("TransformStatus") {
            entry(&mut frame, name).status = value.clone();
        } else if let Some(name) = name
            .strip_suffix("Transform")
            .filter(|name| name_parts(name).is_some())
        {
            entry(&mut frame, name).matrix = Some(matrix(name, value)?);
        }
    }
    let valid = frame
        .transforms
        .iter()
        .filter(|(_, own)| own.status == "OK");
    for (name, matrix) in valid.filter_map(|(name, own)| Some((name, own.matrix.as_ref()?))) {
        check_pose(name, matrix)?;
    }
    match frame.transforms.len() <= MOST_TRANSFORMS {
        true => Ok(frame),
        false => Err(format!(
            "has {} transforms in a frame",
            frame.transforms.len()
        )),
    }
}

fn entry<'f>(frame: &'f mut Frame, name: &str) -> &'f mut Tracked {
    let ok = || Tracked {
        matrix: None,
        status: "OK".into(),
    };
    frame.transforms.entry(name.into()).or_insert_with(ok)
}

/// Sixteen numbers, rows first.
fn matrix(name: &str, text: &str) -> std::result::Result<Matrix, String> {
    let numbers: Option<Vec<f64>> = text
        .split_whitespace()
        .map(|word| word.parse().ok())
        .collect();
    let rows = numbers.filter(|numbers| numbers.len() == 16);
    let rows = rows.ok_or_else(|| format!("has a {name}Transform that is not 16 numbers"))?;
    Ok(std::array::from_fn(|row| {
        std::array::from_fn(|column| rows[4 * row + column])
    }))
}

/// Refuses columns in place of rows, and a tracker's pose with another scale than 1; pictures have one.
fn check_pose(name: &str, matrix: &Matrix) -> std::result::Result<(), String> {
    check_last_row(matrix).map_err(|e| format!("{e}, rows first, in {name}Transform"))?;
    let scale = |k: usize| {
        matrix[..3]
            .iter()
            .map(|row| row[k] * row[k])
            .sum::<f64>()
            .sqrt()
    };
    let scales = [0, 1, 2].map(scale);
    let pictures = name.contains("Image");
    match pictures || scales.iter().all(|scale| (scale - 1.0).abs() < RIGID) {
        true => Ok(()),
        false => Err(format!(
            "has a {name}Transform that scales by {scales:.3?}; expected a pose, with columns of length 1"
        )),
    }
}

/// The sides of a pixel, mm; PLUS writes 1 for unknown.
fn spacing(header: &Header, orientation: Orientation) -> Option<[f64; 2]> {
    let text = header.get("ElementSpacing").or(header.get("spacings"))?;
    let mut numbers = text
        .split_whitespace()
        .map_while(|word| word.parse::<f64>().ok());
    let [fast, slow] = [numbers.next()?, numbers.next()?];
    let valid = [fast, slow].iter().all(|side| (1e-3..=10.0).contains(side));
    let known = valid && [fast, slow] != [1.0, 1.0];
    known.then_some(if orientation.transposed {
        [slow, fast]
    } else {
        [fast, slow]
    })
}
