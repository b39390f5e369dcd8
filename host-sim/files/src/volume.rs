//! Volumes as NIfTI files, for 3D Slicer, ParaView and similar programs.

use std::io::{self, Write};

use flate2::Compression;
use flate2::write::GzEncoder;
use ndarray::ArrayView3;

use crate::{Error, Result};

/// Bytes of a gzipped NIfTI-1 file of 16-bit voxels, `[x, y, z]`.
///
/// `corner` is the first voxel's centre and `step` the distance between voxels, both in m. The file is in mm along
/// the same axes as the surfaces beside it. NIfTI's own names for its axes (right, anterior, superior) do not
/// apply.
///
/// # Errors
/// A side longer than 32767 voxels.
pub fn nifti(voxels: ArrayView3<i16>, corner: [f64; 3], step: [f64; 3]) -> Result<Vec<u8>> {
    let cannot = |e: String| Error::Data(format!("the volume cannot be written: {e}"));
    let shape: [usize; 3] = voxels.dim().into();
    let mut sides = [0; 3];
    for (side, count) in sides.iter_mut().zip(shape) {
        *side = i16::try_from(count).map_err(|_| cannot(format!("{count} voxels in a row")))?;
    }
    write(&header(sides, corner, step), voxels).map_err(|e| cannot(e.to_string()))
}

/// The header with the four bytes after it that declare no extensions.
///
/// Fields that are not set are 0.
fn header(sides: [i16; 3], corner: [f64; 3], step: [f64; 3]) -> [u8; 352] {
    /// i16.
    const TYPE: i16 = 4;
    const MILLIMETRES: u8 = 2;
    const SCANNER: i16 = 1;

    let mut header = [0; 352];
    let mut put = |at: usize, bytes: &[u8]| header[at..at + bytes.len()].copy_from_slice(bytes);
    let reals =
        |values: &[f32]| -> Vec<u8> { values.iter().flat_map(|v| v.to_le_bytes()).collect() };
    let whole =
        |values: &[i16]| -> Vec<u8> { values.iter().flat_map(|v| v.to_le_bytes()).collect() };
    let [x, y, z] = sides;
    let [dx, dy, dz] = step.map(|step| (1e3 * step) as f32);
    let [x0, y0, z0] = corner.map(|corner| (1e3 * corner) as f32);
    // Names of the fields as in nifti1.h.
    put(0, &348i32.to_le_bytes()); // sizeof_hdr
    put(40, &whole(&[3, x, y, z, 1, 1, 1, 1])); // dim
    put(70, &whole(&[TYPE, 16])); // datatype, bitpix
    put(76, &reals(&[1.0, dx, dy, dz, 1.0, 1.0, 1.0, 1.0])); // pixdim
    put(108, &reals(&[352.0, 1.0])); // vox_offset, scl_slope
    put(123, &[MILLIMETRES]); // xyzt_units
    put(252, &whole(&[SCANNER, SCANNER])); // qform_code, sform_code
    put(268, &reals(&[x0, y0, z0])); // qoffset, of a quaternion of 0: not rotated
    put(280, &reals(&[dx, 0.0, 0.0, x0])); // srow_x
    put(296, &reals(&[0.0, dy, 0.0, y0])); // srow_y
    put(312, &reals(&[0.0, 0.0, dz, z0])); // srow_z
    put(344, b"n+1\0"); // magic
    header
}

fn write(header: &[u8], voxels: ArrayView3<i16>) -> io::Result<Vec<u8>> {
    let mut file = GzEncoder::new(Vec::new(), Compression::fast());
    file.write_all(header)?;
    // The first axis runs fastest.
    for plane in voxels.t().outer_iter() {
        let bytes: Vec<u8> = plane.iter().flat_map(|v| v.to_le_bytes()).collect();
        file.write_all(&bytes)?;
    }
    file.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    use flate2::read::GzDecoder;
    use ndarray::Array3;

    /// The offsets are those of nifti1.h.
    #[test]
    fn a_volume_is_read_again_with_its_position() {
        let voxels =
            Array3::from_shape_fn((3, 4, 5), |(x, y, z)| (100 * x + 10 * y + z) as i16 - 50);
        let (corner, step) = ([-19.7e-3, -15e-3, 5e-3], [0.077e-3, 0.5e-3, 0.077e-3]);
        let deflated = nifti(voxels.view(), corner, step).unwrap();
        let mut bytes = Vec::new();
        let mut inflated = GzDecoder::new(&deflated[..]);
        inflated.read_to_end(&mut bytes).unwrap();
        let short = |at: usize| i16::from_le_bytes([bytes[at], bytes[at + 1]]);
        let float = |at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        let floats = |at: usize| [0, 4, 8, 12].map(|k| float(at + k));
        assert_eq!(bytes[..4], 348i32.to_le_bytes());
        assert_eq!([0, 1, 2, 3, 4].map(|k| short(40 + 2 * k)), [3, 3, 4, 5, 1]);
        // i16 of 16 bits; the scanner's positions in mm, by a rotation of 0 and by an affine transform.
        assert_eq!([70, 72, 252, 254].map(short), [4, 16, 1, 1]);
        assert_eq!(floats(76), [1.0, 0.077, 0.5, 0.077]);
        assert_eq!(float(108), 352.0);
        assert_eq!(bytes[123], 2);
        assert_eq!(floats(256), [0.0, 0.0, 0.0, -19.7]);
        assert_eq!([272, 276].map(float), [-15.0, 5.0]);
        assert_eq!(floats(280), [0.077, 0.0, 0.0, -19.7]);
        assert_eq!(floats(296), [0.0, 0.5, 0.0, -15.0]);
        assert_eq!(floats(312), [0.0, 0.0, 0.077, 5.0]);
        assert_eq!(&bytes[344..352], b"n+1\0\0\0\0\0");
        // x runs fastest.
        let order = (0..5).flat_map(|z| (0..4).flat_map(move |y| (0..3).map(move |x| (x, y, z))));
        let expected: Vec<i16> = order.map(|index| voxels[index]).collect();
        let read: Vec<i16> = (352..bytes.len()).step_by(2).map(short).collect();
        assert_eq!(read, expected);
    }

    #[test]
    fn a_side_beyond_the_format_is_refused() {
        let voxels = Array3::zeros((1, 40_000, 1));
        let message = nifti(voxels.view(), [0.0; 3], [1.0; 3])
            .unwrap_err()
            .to_string();
        assert!(message.contains("40000 voxels in a row"), "{message}");
    }
}
