//! Tracked sequences: the flags of their poses, and what `info` prints.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::surface_inputs::{Crop, parse_crop};
use crate::{Error, Result};
use bonebeam_files::terminal::digits;
use bonebeam_tracked::{AngleUnit, Calibration, Euler, LengthUnit, PoseTable, Sequence};

/// Flags on the poses of a folder of pictures.
#[derive(Debug, clap::Args)]
pub struct SequenceArguments {
    /// CSV table of the poses of a folder or DICOM file, with a header [default: the only .csv in the folder or above it]
    ///
    /// A column such as file_path, timestamp or frame names the PNG of a row. Otherwise rows have the order of the
    /// names. A pose maps the probe to the reference (or to the CT).
    #[arg(long, value_name = "POSES.csv", help_heading = "Folder of pictures")]
    poses: Option<PathBuf>,

    /// Columns of the poses [default: by usual names, such as x,y,z,euler_x,euler_y,euler_z or tx,ty,tz,qx,qy,qz,qw]
    ///
    /// A position with three Euler angles or with a quaternion x, y, z, w; or the 12 or 16 numbers of a matrix, rows
    /// first.
    #[arg(
        long,
        value_name = "NAME,…",
        value_delimiter = ',',
        help_heading = "Folder of pictures"
    )]
    pose_columns: Option<Vec<String>>,

    /// Axes of Euler angles: small letters are fixed axes, capitals moving axes, as in SciPy [default: xyz]
    #[arg(long, value_name = "AXES", help_heading = "Folder of pictures")]
    euler: Option<Euler>,

    /// Unit of positions in the table, mm or m [default: by the columns' names, or mm]
    #[arg(long, value_name = "UNIT", help_heading = "Folder of pictures")]
    pose_unit: Option<LengthUnit>,

    /// Unit of angles in the table, degrees or radians [default: by the columns' names, or degrees]
    #[arg(long, value_name = "UNIT", help_heading = "Folder of pictures")]
    angle_unit: Option<AngleUnit>,
}

impl SequenceArguments {
    /// Axes of Euler angles.
    pub fn euler(&self) -> Euler {
        self.euler.unwrap_or_default()
    }

    /// Opens a sequence.
    ///
    /// # Errors
    /// As [`Sequence::open`].
    pub fn open(&self, path: &Path) -> Result<Sequence> {
        let poses = PoseTable {
            path: self.poses.clone(),
            columns: self.pose_columns.clone(),
            euler: self.euler(),
            length: self.pose_unit,
            angle: self.angle_unit,
        };
        Sequence::open(path, &poses)
    }
}

/// Flags on the place of pictures in space.
#[derive(Debug, clap::Args)]
pub struct PlaceArguments {
    /// Fixed transforms, mm: a configuration of PLUS (.xml), JSON, a file of numbers, or [NAME=]16 numbers; repeatable
    ///
    /// Numbers are a matrix, rows first, or x, y, z in mm and three Euler angles in degrees (--euler). Without a name they
    /// are ImageToProbe. They replace transforms of the same name in the sequence.
    #[arg(long, value_name = "FILE|NUMBERS", allow_hyphen_values = true)]
    calibration: Vec<String>,

    /// Frame of reference of the points [default: the first with a chain from Image of Reference, World, CT, Tracker]
    #[arg(long, value_name = "NAME")]
    to: Option<String>,

    /// Side of a pixel, m, or along columns and rows: for a calibration in mm instead of pixels
    #[arg(long, value_name = "M[,M]", value_delimiter = ',', num_args = 1)]
    pixel_size: Vec<f64>,

    /// Part of the pictures to use, in pixels from the top left [default: all]
    #[arg(long, value_name = "X,Y,WIDTH,HEIGHT", value_parser = parse_crop)]
    crop: Option<Crop>,
}

impl PlaceArguments {
    /// The fixed transforms.
    ///
    /// # Errors
    /// As [`Calibration::of`].
    pub fn calibration(&self, euler: Euler) -> Result<Calibration> {
        let mut calibration = Calibration::default();
        for text in &self.calibration {
            let own = Calibration::of(text, euler)?.transforms;
            calibration.transforms.extend(own);
        }
        Ok(calibration)
    }

    /// Name of the frame of reference.
    pub fn target(&self) -> Option<&str> {
        self.to.as_deref()
    }

    /// Sides of a pixel along columns and rows, mm.
    ///
    /// # Errors
    /// More than two numbers.
    pub fn pixel(&self) -> Result<Option<[f64; 2]>> {
        match self.pixel_size[..] {
            [] => Ok(None),
            [side] => Ok(Some([1e3 * side; 2])),
            [x, y] => Ok(Some([1e3 * x, 1e3 * y])),
            _ => Err(Error::Usage(
                "--pixel-size has more than two numbers".into(),
            )),
        }
    }

    /// A given flag that applies only to pictures.
    pub fn given(&self) -> Option<&'static str> {
        let size = (!self.pixel_size.is_empty()).then_some("pixel-size");
        size.or(self.crop.map(|_| "crop"))
    }

    /// The part of the pictures: x, y, width, height.
    pub fn part(&self) -> Option<[usize; 4]> {
        let crop = self.crop?;
        Some([crop.x, crop.y, crop.width, crop.height])
    }
}

/// What `info` prints about a sequence.
pub fn facts(sequence: &Sequence) -> Vec<(&'static str, String)> {
    let frames = &sequence.frames;
    let [columns, rows] = sequence.sides;
    let what = match sequence.content.is_lines() {
        true => {
            let content = sequence.content.name();
            format!("{rows} lines of {columns} samples ({content})")
        }
        false => format!("pictures of {columns} x {rows} pixels"),
    };
    let kind = match sequence.transform_names().is_empty() {
        true => "without poses",
        false => "a tracked sequence",
    };
    let s = if frames.len() == 1 { "" } else { "s" };
    let mut facts = vec![
        ("format", format!("{}, {kind}", sequence.format)),
        ("holds", format!("{} frame{s} of {what}", frames.len())),
    ];
    facts.extend(
        sequence
            .assumed
            .iter()
            .map(|what| ("assumed", what.clone())),
    );
    facts.push(("written", format!("as {}", sequence.orientation)));
    let pixels = match sequence.pixel {
        Some([x, y]) => format!("{} x {} mm", digits(x), digits(y)),
        None => "of a size that is in ImageToProbe, not in the file".into(),
    };
    if !sequence.content.is_lines() {
        facts.push(("pixels", pixels));
    }
    if let Some([x, y, width, height]) = sequence.part {
        facts.push(("used", format!("{width} x {height} pixels from {x},{y}")));
    }
    let valid = frames.iter().filter(|frame| frame.has_picture).count();
    if valid < frames.len() {
        facts.push((
            "pictures",
            format!("{valid} valid, {} invalid", frames.len() - valid),
        ));
    }
    let times: Vec<f64> = frames.iter().filter_map(|frame| frame.timestamp).collect();
    if let ([first, .., last], Some(rate)) = (&times[..], sequence.rate()) {
        let rate = format!(
            "{} per second of the timestamps, {first} to {last}",
            digits(rate)
        );
        facts.push(("rate", rate));
    }
    for name in sequence.transform_names() {
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        for frame in frames {
            let status = match frame.transforms.get(name) {
                Some(transform) if transform.matrix.is_some() => &transform.status[..],
                _ => "missing",
            };
            *counts.entry(status).or_default() += 1;
        }
        let counts: Vec<String> = counts
            .iter()
            .map(|(name, count)| format!("{count} {name}"))
            .collect();
        facts.push(("transform", format!("{name}: {}", counts.join(", "))));
    }
    facts
}
