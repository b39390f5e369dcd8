//! The bone's surface in a CT volume: a threshold, and the largest part above it.

use std::io::{self, ErrorKind, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;

use crate::algebra::{V3, cross, dot};
use crate::cloud::to_lps;
use crate::{Error, Result};
use bonebeam_files::memory::{self, product};
use bonebeam_files::{cannot_be_opened, file_error, input};
use bonebeam_simulate::{CtVolume, Surface, VolumeGrid};

/// Density of voxels that are not of the largest part, HU.
const AIR: i16 = -1000;
/// Largest distance between two places of a voxel that is not worth a warning, mm.
const APART: f64 = 0.1;

/// A CT volume.
pub struct Volume {
    /// Voxels along each axis.
    pub sides: [usize; 3],
    /// Hounsfield units, the first axis fastest.
    pub hu: Vec<i16>,
    /// Rows of the matrix from (i, j, k, 1) to mm in LPS.
    pub to_lps: [[f64; 4]; 3],
}

impl Volume {
    /// Reads a NIfTI-1 file, `.nii` or `.nii.gz`, with a warning if it has two places.
    ///
    /// # Errors
    /// A file that cannot be read, is no volume, or holds less than its header says.
    pub fn read_nifti(path: &Path) -> Result<(Volume, Option<String>)> {
        let fail = |message: String| file_error(path, message);
        let file = input::open(path).map_err(|e| fail(cannot_be_opened(&e)))?;
        let packed = path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("gz"));
        match packed {
            true => nifti(MultiGzDecoder::new(file)),
            false => nifti(io::BufReader::new(file)),
        }
        .map_err(fail)
    }

    /// The surface at `threshold` HU of the largest connected part above it.
    ///
    /// # Errors
    /// No voxel above the threshold.
    pub fn surface(mut self, threshold: f64) -> Result<Surface> {
        self.keep_largest(threshold);
        let volume = CtVolume {
            grid: VolumeGrid {
                corner: [0.0; 3],
                step: [1.0; 3],
                nodes: self.sides,
            },
            hu: self.hu,
        };
        let rows = self.to_lps;
        let place = |[i, j, k]: V3| rows.map(|[a, b, c, d]| a * i + b * j + c * k + d);
        let surface = volume.surface(threshold).mapped(place);
        if surface.triangles().is_empty() {
            let message = format!("no voxel is above {threshold} HU; give another --threshold");
            return Err(Error::Data(message));
        }
        let [x, y, z] = rows.map(|[a, b, c, _]| [a, b, c]);
        // Axes of a left-handed grid turn the triangles over.
        if dot(cross(x, y), z) > 0.0 {
            return Ok(surface);
        }
        let turned = surface.triangles().iter().map(|[a, b, c]| [*a, *c, *b]);
        Ok(Surface::new(surface.vertices().to_vec(), turned.collect()))
    }

    /// Makes air of all voxels above the threshold that are not of its largest part.
    fn keep_largest(&mut self, threshold: f64) {
        let [nx, ny, _] = self.sides;
        let strides = [1, nx, nx * ny];
        let is_bone: Vec<bool> = self.hu.iter().map(|v| f64::from(*v) > threshold).collect();
        // Calls `visit` with the voxels of a part.
        let part = |from: usize, known: &mut [bool]| {
            let (mut waiting, mut size) = (vec![from], 0usize);
            known[from] = true;
            while let Some(at) = waiting.pop() {
                size += 1;
                for (axis, stride) in strides.iter().enumerate() {
                    let index = at / stride % self.sides[axis];
                    let before = (index > 0).then(|| at - stride);
                    let after = (index + 1 < self.sides[axis]).then(|| at + stride);
                    for next in [before, after].into_iter().flatten() {
                        if is_bone[next] && !known[next] {
                            known[next] = true;
                            waiting.push(next);
                        }
                    }
                }
            }
            size
        };
        let mut known = vec![false; is_bone.len()];
        let mut largest = (0, 0);
        for at in 0..is_bone.len() {
            if is_bone[at] && !known[at] {
                largest = largest.max((part(at, &mut known), at));
            }
        }
        known.fill(false);
        if largest.0 > 0 {
            part(largest.1, &mut known);
        }
        for ((hu, known), is_bone) in self.hu.iter_mut().zip(known).zip(&is_bone) {
            if *is_bone && !known {
                *hu = AIR;
            }
        }
    }
}

/// Largest distance between two places of a corner of a volume, mm.
fn apart(a: [[f64; 4]; 3], b: [[f64; 4]; 3], sides: [usize; 3]) -> f64 {
    let rows: [[f64; 4]; 3] = std::array::from_fn(|i| std::array::from_fn(|k| a[i][k] - b[i][k]));
    let corners = (0..8).map(|corner| {
        let index = [0, 1, 2].map(|k| ((corner >> k & 1) * (sides[k] - 1)) as f64);
        let off = rows.map(|[x, y, z, from]| dot([x, y, z], index) + from);
        dot(off, off).sqrt()
    });
    corners.fold(0.0, f64::max)
}

/// A volume by the names of nifti1.h.
fn nifti(mut reader: impl Read) -> std::result::Result<(Volume, Option<String>), String> {
    let unreadable = |e: io::Error| match e.kind() {
        ErrorKind::UnexpectedEof => "is truncated".to_owned(),
        _ => format!("is damaged ({e})"),
    };
    let mut header = [0; 348];
    reader.read_exact(&mut header).map_err(unreadable)?;
    let bytes = |at: usize| [0, 1, 2, 3].map(|k| header[at + k]);
    let big_endian = match (i32::from_le_bytes(bytes(0)), i32::from_be_bytes(bytes(0))) {
        (348, _) => false,
        (_, 348) => true,
        _ => return Err("is not a NIfTI-1 file".into()),
    };
    let short = |at: usize| {
        let pair = [header[at], header[at + 1]];
        if big_endian {
            i16::from_be_bytes(pair)
        } else {
            i16::from_le_bytes(pair)
        }
    };
    let float = |at: usize| {
        let four = bytes(at);
        f64::from(if big_endian {
            f32::from_be_bytes(four)
        } else {
            f32::from_le_bytes(four)
        })
    };
    // dim
    let sides = [42, 44, 46].map(|at| usize::try_from(short(at)).unwrap_or(0));
    let mut more = (44 + 4..56)
        .step_by(2)
        .take((short(40).clamp(3, 7) - 3) as usize);
    if short(40) < 3 || sides.iter().any(|side| *side < 2) || more.any(|at| short(at) > 1) {
        return Err("is not one volume of three axes".into());
    }
    // datatype
    let (size, signed, real) = match short(70) {
        2 => (1, false, false),
        256 => (1, true, false),
        4 => (2, true, false),
        512 => (2, false, false),
        8 => (4, true, false),
        768 => (4, false, false),
        16 => (4, true, true),
        64 => (8, true, true),
        other => return Err(format!("has datatype {other}; expected one of numbers")),
    };
    // xyzt_units
    let mm = match header[123] & 7 {
        1 => 1e3,
        3 => 1e-3,
        _ => 1.0,
    };
    let srow = [280, 296, 312].map(|row| [0, 4, 8, 12].map(|k| mm * float(row + k)));
    let quatern = {
        let [b, c, d] = [256, 260, 264].map(float);
        let a = (1.0 - b * b - c * c - d * d).max(0.0).sqrt();
        let sign = if float(76) < 0.0 { -1.0 } else { 1.0 }; // qfac
        let steps = [float(80), float(84), sign * float(88)]; // pixdim
        let turn = crate::pose::of_quaternion([a, b, c, d]);
        [0, 1, 2].map(|i| {
            let [x, y, z] = [0, 1, 2].map(|j| mm * turn[i][j] * steps[j]);
            [x, y, z, mm * float(268 + 4 * i)]
        })
    };
    // qform_code, sform_code
    let given = [252, 254].map(|at| short(at) > 0);
    let to_ras = if given[1] { srow } else { quatern };
    let apart = apart(srow, quatern, sides);
    let warning = (given == [true; 2] && apart > APART).then(|| {
        format!(
            "sform and qform are up to {apart:.1} mm apart; the sform is used, as by nibabel, but by ITK only if its code is 1"
        )
    });
    let turned = |column: usize| to_lps(to_ras.map(|row| row[column]));
    let columns = [turned(0), turned(1), turned(2), turned(3)];
    let to_lps = [0, 1, 2].map(|i| columns.map(|column| column[i]));
    if columns.iter().flatten().any(|v| !v.is_finite()) {
        return Err("has an orientation that is not finite".into());
    }
    // vox_offset, scl_slope, scl_inter
    let (offset, slope, shift) = (float(108), float(112), float(116));
    if !(348.0..1e8).contains(&offset) || !slope.is_finite() || !shift.is_finite() {
        return Err("has a header whose numbers are out of range".into());
    }
    let (slope, shift) = if slope == 0.0 {
        (1.0, 0.0)
    } else {
        (slope, shift)
    };
    let count = product(&sides);
    memory::check(product(&[count, 4]), "the CT volume").map_err(|e| e.to_string())?;
    io::copy(
        &mut (&mut reader).take(offset as u64 - 348),
        &mut io::sink(),
    )
    .map_err(unreadable)?;
    let mut hu = Vec::new();
    let mut row = vec![0; sides[0] * size];
    for _ in 0..sides[1] * sides[2] {
        reader.read_exact(&mut row).map_err(unreadable)?;
        hu.extend(row.chunks_exact_mut(size).map(|number| {
            if big_endian {
                number.reverse();
            }
            let mut eight = [0; 8];
            eight[..size].copy_from_slice(number);
            let whole = i64::from_le_bytes(eight) << (64 - 8 * size);
            let value = match (real, signed) {
                (true, _) if size == 4 => {
                    f64::from(f32::from_bits(u64::from_le_bytes(eight) as u32))
                }
                (true, _) => f64::from_bits(u64::from_le_bytes(eight)),
                (_, true) => (whole >> (64 - 8 * size)) as f64,
                _ => u64::from_le_bytes(eight) as f64,
            };
            // The cast saturates, and NaN is 0.
            (slope * value + shift).round() as i16
        }));
    }
    Ok((Volume { sides, hu, to_lps }, warning))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bone::Bone;
    use ndarray::Array3;

    /// Two balls of bone, the larger at voxel (20, 12, 10).
    fn balls() -> Vec<u8> {
        let voxels = Array3::from_shape_fn((40, 24, 20), |(i, j, k)| {
            let from = |c: [f64; 3]| {
                let off = [i as f64 - c[0], j as f64 - c[1], k as f64 - c[2]];
                dot(off, off).sqrt()
            };
            let depth = (7.0 - from([20.0, 12.0, 10.0])).max(3.0 - from([34.0, 6.0, 6.0]));
            (300.0 + 400.0 * depth).clamp(-1000.0, 1500.0) as i16
        });
        let packed =
            bonebeam_files::nifti(voxels.view(), [1e-3, 2e-3, 3e-3], [0.5e-3, 0.6e-3, 0.7e-3]);
        let mut bytes = Vec::new();
        MultiGzDecoder::new(&packed.unwrap()[..])
            .read_to_end(&mut bytes)
            .unwrap();
        bytes
    }

    #[test]
    fn the_largest_part_has_its_place_in_lps() {
        let (volume, warning) = nifti(&balls()[..]).unwrap();
        assert_eq!(warning, None);
        let bone = Bone::new(volume.surface(300.0).unwrap());
        let centre = [-(1.0 + 20.0 * 0.5), -(2.0 + 12.0 * 0.6), 3.0 + 10.0 * 0.7];
        for vertex in bone.surface().vertices() {
            let off = [0, 1, 2].map(|k| (vertex[k] - centre[k]) / [0.5, 0.6, 0.7][k]);
            assert!((dot(off, off).sqrt() - 7.0).abs() < 0.2, "{vertex:?}");
        }
        // Outwards.
        assert!(bone.surface().volume() > 0.9 * 4.0 / 3.0 * std::f64::consts::PI * 343.0 * 0.21);
        let nothing = nifti(&balls()[..]).unwrap().0.surface(5000.0);
        assert!(nothing.is_err_and(|e| e.to_string().contains("--threshold")));
    }

    /// The sform counts, as nibabel 5.4.2 takes it; SimpleITK 2.5.7 takes the qform unless the sform's code is 1.
    #[test]
    fn two_places_of_a_volume_are_said() {
        let mut bytes = balls();
        bytes[276..280].copy_from_slice(&8f32.to_le_bytes()); // qoffset_z, 5 mm further
        let (volume, warning) = nifti(&bytes[..]).unwrap();
        assert!((volume.to_lps[2][3] - 3.0).abs() < 1e-6);
        let warning = warning.expect("a warning");
        assert!(
            warning.contains("up to 5.0 mm apart; the sform is used"),
            "{warning}"
        );
    }

    #[test]
    fn every_type_of_number_and_both_orders_are_read() {
        let small = |kind: i16, big: bool, number: &[u8]| {
            let mut bytes = balls();
            let mut put =
                |at: usize, value: &[u8]| bytes[at..at + value.len()].copy_from_slice(value);
            for (at, side) in [(42, 2i16), (44, 2), (46, 2), (70, kind)] {
                put(at, &side.to_le_bytes());
            }
            // The orientation by the quaternion and the steps, mirrored.
            put(254, &0i16.to_le_bytes());
            put(76, &(-1f32).to_le_bytes());
            bytes.truncate(352);
            if big {
                let fields = [
                    (0, 4, 1),
                    (40, 2, 8),
                    (70, 2, 2),
                    (76, 4, 8),
                    (108, 4, 3),
                    (252, 2, 2),
                ];
                let floats = [(256, 4, 6)];
                for (at, size, count) in fields.into_iter().chain(floats) {
                    bytes[at..at + size * count]
                        .chunks_mut(size)
                        .for_each(<[u8]>::reverse);
                }
            }
            let mut number = number.to_vec();
            if big {
                number.reverse();
            }
            bytes.extend(number.repeat(8));
            nifti(&bytes[..]).unwrap().0
        };
        for big in [false, true] {
            for (kind, number, expected) in [
                (2, &200u8.to_le_bytes()[..], 200),
                (256, &(-5i8).to_le_bytes(), -5),
                (4, &(-300i16).to_le_bytes(), -300),
                (512, &40_000u16.to_le_bytes(), i16::MAX),
                (8, &(-70i32).to_le_bytes(), -70),
                (768, &9u32.to_le_bytes(), 9),
                (16, &(-12.4f32).to_le_bytes(), -12),
                (64, &1e9f64.to_le_bytes(), i16::MAX),
            ] {
                let volume = small(kind, big, number);
                assert_eq!(volume.hu, [expected; 8], "{kind} {big}");
                let expected = [
                    [-0.5, 0.0, 0.0, -1.0],
                    [0.0, -0.6, 0.0, -2.0],
                    [0.0, 0.0, -0.7, 3.0],
                ];
                for (found, expected) in volume
                    .to_lps
                    .iter()
                    .flatten()
                    .zip(expected.iter().flatten())
                {
                    assert!((found - expected).abs() < 1e-6, "{:?}", volume.to_lps);
                }
            }
        }
    }

    #[test]
    fn files_that_hold_less_than_they_say_are_refused() {
        let message = |change: fn(&mut Vec<u8>)| {
            let mut bytes = balls();
            change(&mut bytes);
            nifti(&bytes[..]).err().unwrap()
        };
        assert!(message(|b| b.truncate(300)).contains("truncated"));
        assert!(message(|b| b.truncate(5000)).contains("truncated"));
        assert!(message(|b| b[0] = 7).contains("not a NIfTI-1"));
        assert!(message(|b| b[40] = 2).contains("three axes"));
        assert!(message(|b| b[70] = 32).contains("datatype 32"));
        assert!(message(|b| b[108..112].fill(0xff)).contains("out of range"));
        let huge = message(|b| b[42..48].fill(0x7f));
        assert!(
            huge.contains("truncated") || huge.contains("memory"),
            "{huge}"
        );
    }
}
