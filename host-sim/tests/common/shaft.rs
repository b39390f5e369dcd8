//! A drawn sweep over a shaft, with known poses.

use bonebeam_tracked::{Matrix, apply, inverse, product};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use tempfile::{TempDir, tempdir};

use super::program::Folder;

pub const FRAMES: usize = 24;
pub const COLUMNS: usize = 160;
pub const ROWS: usize = 240;
/// Side of a pixel, mm.
pub const PIXEL: f64 = 0.15;
/// Radius of the shaft and a point of its axis in the reference's frame, mm.
pub const RADIUS: f64 = 11.0;
pub const MIDDLE: [f64; 3] = [40.0, -20.0, 30.0];
/// Frames whose pose is out of view, whose pose jumps, and without a picture.
pub const LOST: usize = 5;
pub const JUMP: usize = 9;
pub const EMPTY: usize = 15;

/// The rotation by angles about x, then y, then z, and a translation.
pub fn pose(angles: [f64; 3], [x, y, z]: [f64; 3]) -> Matrix {
    let [(sa, ca), (sb, cb), (sc, cc)] = angles.map(f64::sin_cos);
    [
        [cb * cc, sa * sb * cc - ca * sc, ca * sb * cc + sa * sc, x],
        [cb * sc, sa * sb * sc + ca * cc, ca * sb * sc - sa * cc, y],
        [-sb, sa * cb, ca * cb, z],
        [0.0, 0.0, 0.0, 1.0],
    ]
}

pub fn calibration() -> Matrix {
    let [x, y] = [COLUMNS, ROWS].map(|side| side as f64 * PIXEL / 2.0);
    let scale = [
        [PIXEL, 0.0, 0.0, -x],
        [0.0, PIXEL, 0.0, -y],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ];
    product(&pose([0.1, 1.2, -0.4], [5.0, 50.0, -3.0]), &scale)
}

/// Direction of the shaft in the reference's frame.
pub fn axis() -> [f64; 3] {
    let at = apply(&pose([0.3, 0.2, 0.5], [0.0; 3]), [0.0, 0.0, 1.0]);
    at.map(|x| x / at.iter().map(|x| x * x).sum::<f64>().sqrt())
}

/// The vector from the axis to a point.
pub fn from_axis(point: [f64; 3]) -> [f64; 3] {
    let own = axis();
    let off: [f64; 3] = std::array::from_fn(|k| point[k] - MIDDLE[k]);
    let along: f64 = (0..3).map(|k| off[k] * own[k]).sum();
    std::array::from_fn(|k| off[k] - along * own[k])
}

pub fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

pub fn reference() -> Matrix {
    pose([-0.7, 0.4, 2.0], [100.0, -40.0, 900.0])
}

/// The picture's matrix to the reference: across the shaft, the array 14 mm above it, wobbling.
pub fn image_to_reference(frame: usize) -> Matrix {
    let k = frame as f64 - FRAMES as f64 / 2.0;
    let along = axis().map(|x| 0.8 * k * x);
    let wobble = pose([0.02 * k.sin(), 0.02 * k.cos(), 0.01 * k.sin()], [0.0; 3]);
    let upright = product(
        &pose(
            [0.3, 0.2, 0.5],
            std::array::from_fn(|k| MIDDLE[k] + along[k]),
        ),
        &wobble,
    );
    let top = [
        [PIXEL, 0.0, 0.0, -(COLUMNS as f64) * PIXEL / 2.0],
        [0.0, PIXEL, 0.0, -14.0 - RADIUS],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ];
    product(&upright, &top)
}

/// Speckle, with an echo of 0.25 mm on the shaft and a shadow below it.
pub fn picture(frame: usize, matrix: &Matrix) -> Vec<u8> {
    let mut rng = ChaCha8Rng::seed_from_u64(59 + frame as u64);
    let mut pixels = vec![0; ROWS * COLUMNS];
    for column in 0..COLUMNS {
        let depth = |row: f64| length(from_axis(apply(matrix, [column as f64, row, 0.0]))) - RADIUS;
        let bone = (0..ROWS)
            .map(|row| row as f64)
            .find(|row| depth(*row) < 0.0);
        let bone = bone.map(|row| row - depth(row) / (depth(row) - depth(row - 1.0)));
        for row in 0..ROWS {
            let speckle: f64 = rng.random_range(0.0..50.0);
            let below = bone.map_or(-1e3, |bone| PIXEL * (row as f64 - bone));
            let tissue = if below > 0.3 {
                speckle / 4.0
            } else {
                45.0 + speckle
            };
            let echo = 190.0 * (-(below / 0.25).powi(2)).exp();
            pixels[row * COLUMNS + column] = (tissue + echo).min(255.0) as u8;
        }
    }
    pixels
}

pub fn text(matrix: &Matrix) -> String {
    let numbers: Vec<String> = matrix.as_flattened().iter().map(f64::to_string).collect();
    numbers.join(" ") + " "
}

/// The sweep as PLUS writes it, and its configuration.
pub fn folder() -> TempDir {
    let noted = |k: usize| {
        let mut pose = image_to_reference(k);
        pose[1][3] += if k == JUMP { 30.0 } else { 0.0 };
        pose
    };
    folder_of(FRAMES, image_to_reference, noted)
}

/// Pictures by their poses, and the poses that are written.
pub fn folder_of(
    count: usize,
    true_pose: impl Fn(usize) -> Matrix,
    noted: impl Fn(usize) -> Matrix,
) -> TempDir {
    let folder = tempdir().unwrap();
    let mut header = format!(
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nCompressedData = False\n\
         DimSize = {COLUMNS} {ROWS}                {count} \nElementSpacing = 1 1 1\nElementType = MET_UCHAR\n\
         Kinds = domain domain               list\nUltrasoundImageOrientation = MFA\n"
    );
    let to_image = inverse(&calibration()).unwrap();
    for k in 0..count {
        let probe = product(&reference(), &product(&noted(k), &to_image));
        let status = if k == LOST { "OUT_OF_VIEW" } else { "OK" };
        let valid = if k == EMPTY { "INVALID" } else { "OK" };
        let of = |name: &str, matrix: &Matrix, status: &str| {
            let name = format!("Seq_Frame{k:04}_{name}ToTrackerTransform");
            format!("{name} = {}\n{name}Status = {status}\n", text(matrix))
        };
        header += &of("Probe", &probe, status);
        header += &of("Reference", &reference(), "OK");
        header += &format!("Seq_Frame{k:04}_Timestamp = {:.6}\n", 0.05 * k as f64);
        header += &format!("Seq_Frame{k:04}_ImageStatus = {valid}\n");
    }
    header += "ElementDataFile = LOCAL\n";
    let pixels: Vec<u8> = (0..count).flat_map(|k| picture(k, &true_pose(k))).collect();
    folder.write("sweep.igs.mha", [header.as_bytes(), &pixels].concat());
    let plus = format!(
        "<PlusConfiguration><CoordinateDefinitions><Transform From=\"Image\" To=\"Probe\" Matrix=\"{}\"/>\
         </CoordinateDefinitions></PlusConfiguration>",
        text(&calibration())
    );
    folder.write("plus.xml", plus);
    folder
}
