//! The pose of each frame's picture, and the frames without a usable one.

use std::collections::BTreeSet;

use crate::Result;
use crate::calibration::Calibration;
use crate::sequence::{Frame, Sequence};
use crate::transforms::{Chain, Matrix, apply};

/// Frames of reference that are chosen without a name, in this order.
const TARGETS: [&str; 4] = ["Reference", "World", "CT", "Tracker"];
/// Sides of a pixel that a scanner may have, mm.
const SIDES: [f64; 2] = [0.005, 1.5];
/// A jump is farther than this many usual steps, too.
const STEPS: f64 = 4.0;

/// The poses of a sequence's pictures.
#[derive(Clone, Debug)]
pub struct Track {
    /// Name of the frame of reference.
    pub target: String,
    /// The chain of transforms from `Image`.
    pub chain: Chain,
    /// The matrix from (column, row, 0, 1) to the target, mm; or why there is none.
    pub poses: Vec<std::result::Result<Matrix, String>>,
    /// Sides of a pixel along columns and rows, mm.
    pub pixel: [f64; 2],
}

impl Track {
    /// The poses by the sequence's transforms and those of a calibration.
    ///
    /// `pixel` are the sides of a pixel in mm, for a calibration in mm instead of pixels; by default those of the file.
    /// `jump` is the largest deviation
    /// in mm of a picture's corner from the median of five frames; deviations up to four usual steps are no jump.
    ///
    /// # Errors
    /// No chain of transforms to the target, a singular matrix, or sides of a pixel that no scanner has.
    pub fn of(
        sequence: &Sequence,
        calibration: &Calibration,
        target: Option<&str>,
        pixel: Option<[f64; 2]>,
        jump: f64,
    ) -> Result<Self> {
        let own = |message: String| bonebeam_files::file_error(&sequence.path, message);
        let fixed = calibration.transforms.iter().map(|(name, _)| &name[..]);
        let names = sequence
            .transform_names()
            .into_iter()
            .chain(fixed)
            .collect();
        let (target, chain) = chain_from_image(&names, target).map_err(own)?;
        let mut poses: Vec<std::result::Result<Matrix, String>> = Vec::new();
        // All frames have the first one's sides of a pixel, up to rounding.
        let mut side = None;
        for frame in &sequence.frames {
            let mut pose = pose(&chain, calibration, frame);
            if let Ok(matrix) = &mut pose {
                let (scaled, sides) = in_pixels(*matrix, pixel, sequence.pixel).map_err(own)?;
                *matrix = scaled;
                side.get_or_insert(sides);
            }
            poses.push(pose);
        }
        let pixel = side.unwrap_or([1.0; 2]);
        let [columns, rows] = sequence.sides.map(|side| side as f64);
        leave_out_jumps(
            &mut poses,
            [[columns / 2.0, 0.0], [0.0, rows], [columns, rows]],
            jump,
        );
        Ok(Self {
            target,
            chain,
            poses,
            pixel,
        })
    }
}

impl Track {
    /// The frames of `frames` with a pose, and their poses.
    pub fn usable(&self, frames: &[usize]) -> Vec<(usize, Matrix)> {
        let of = |&frame: &usize| Some((frame, *self.poses.get(frame)?.as_ref().ok()?));
        frames.iter().filter_map(of).collect()
    }
}

/// The frame of reference and the chain to it from `Image`.
///
/// # Errors
/// No chain.
pub(crate) fn chain_from_image(
    names: &BTreeSet<&str>,
    target: Option<&str>,
) -> std::result::Result<(String, Chain), String> {
    let of = |target: &str| {
        let chain = Chain::of(names.iter().copied(), "Image", target);
        chain.map(|chain| (target.to_owned(), chain))
    };
    let found = match target {
        Some(target) => of(target),
        None => {
            let found = TARGETS.iter().find_map(|target| of(target).ok());
            found.map_or_else(|| of(TARGETS[0]), Ok)
        }
    };
    let known = names.iter().any(|name| name.starts_with("ImageTo"));
    found.map_err(|message| match known {
        true => message,
        false => message + "; give ImageToProbe by --calibration",
    })
}

/// The product of a chain for a frame; or the reason why there is none.
pub(crate) fn pose(
    chain: &Chain,
    calibration: &Calibration,
    frame: &Frame,
) -> std::result::Result<Matrix, String> {
    let fixed = |name: &str| calibration.transforms.iter().rfind(|(own, _)| own == name);
    let link = |name: &str| match (fixed(name), frame.transforms.get(name)) {
        (Some((_, matrix)), _) => Ok(*matrix),
        (None, Some(transform)) if transform.status != "OK" => {
            Err(format!("{name} {}", transform.status))
        }
        (None, transform) => transform
            .and_then(|transform| transform.matrix)
            .filter(|matrix| matrix.as_flattened().iter().all(|value| value.is_finite()))
            .ok_or_else(|| format!("{name} missing")),
    };
    match frame.has_picture {
        true => chain.product(link, |name| format!("{name} singular")),
        false => Err("no picture".into()),
    }
}

/// The lengths of a matrix's first two columns.
pub(crate) fn sides(matrix: &Matrix) -> [f64; 2] {
    [0, 1].map(|k| (0..3).map(|row| matrix[row][k].powi(2)).sum::<f64>().sqrt())
}

/// A pose with the pixel's sides in it, and the sides.
///
/// `pixel` are sides to multiply by, and `own` those of the file, for a pose in mm.
///
/// # Errors
/// Sides that no scanner has.
pub(crate) fn in_pixels(
    pose: Matrix,
    pixel: Option<[f64; 2]>,
    own: Option<[f64; 2]>,
) -> std::result::Result<(Matrix, [f64; 2]), String> {
    let is_one = sides(&pose).iter().all(|side| (side - 1.0).abs() < 1e-3);
    let pose = match pixel.or(own.filter(|_| is_one)) {
        Some([x, y]) => pose.map(|[a, b, c, d]| [a * x, b * y, c, d]),
        None => pose,
    };
    let sides = sides(&pose);
    check_pixel(sides).map(|()| (pose, sides))
}

fn check_pixel(pixel: [f64; 2]) -> std::result::Result<(), String> {
    let [x, y] = pixel;
    let is_one = pixel.iter().all(|side| (side - 1.0).abs() < 1e-3);
    let within = pixel
        .iter()
        .all(|side| (SIDES[0]..=SIDES[1]).contains(side));
    let even = (0.5..=2.0).contains(&(x / y));
    match (is_one, within && even) {
        (true, _) => Err(
            "has pixels of 1 mm by its transforms: ImageToProbe is in mm; give --pixel-size".into(),
        ),
        (false, true) => Ok(()),
        (false, false) => Err(format!(
            "has pixels of {x:.4} x {y:.4} mm by its transforms; expected {} to {} mm (ImageToProbe, --pixel-size)",
            SIDES[0], SIDES[1]
        )),
    }
}

/// Leaves out the frames whose picture is far from those around it.
fn leave_out_jumps(
    poses: &mut [std::result::Result<Matrix, String>],
    corners: [[f64; 2]; 3],
    jump: f64,
) {
    let valid: Vec<usize> = (0..poses.len()).filter(|&k| poses[k].is_ok()).collect();
    let at = valid.iter().filter_map(|&k| poses[k].as_ref().ok());
    let at: Vec<[[f64; 3]; 3]> = at
        .map(|pose| corners.map(|[column, row]| apply(pose, [column, row, 0.0])))
        .collect();
    let distance = |a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]| {
        let of =
            |(a, b): (&[f64; 3], &[f64; 3])| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>();
        a.iter().zip(b).map(of).fold(0.0, f64::max).sqrt()
    };
    let median = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        let middle = values.len() / 2;
        values.get(middle).copied().unwrap_or(0.0)
    };
    let usual = median(
        at.windows(2)
            .map(|pair| distance(&pair[0], &pair[1]))
            .collect(),
    );
    let limit = jump.max(STEPS * usual);
    for (j, &k) in valid.iter().enumerate() {
        let around = &at[j.saturating_sub(2)..at.len().min(j + 3)];
        if around.len() < 3 {
            continue;
        }
        let middle: [[f64; 3]; 3] = std::array::from_fn(|corner| {
            std::array::from_fn(|axis| median(around.iter().map(|at| at[corner][axis]).collect()))
        });
        if distance(&at[j], &middle) > limit {
            poses[k] = Err("jump".into());
        }
    }
}
