//! Volumes as NIfTI files, for 3D Slicer, ParaView and the like.

use std::io::{self, Write};

use flate2::Compression;
use flate2::write::GzEncoder;
use ndarray::ArrayView3;

use crate::{Error, Result};

/// The bytes of a gzipped NIfTI-1 file of voxels of 16 bits, `[x, y, z]`. `corner` is the first voxel's centre
/// and `step` the distance between voxels, both in m. The file is in mm along the same axes, as the surfaces
/// beside it are. NIfTI's own names for its axes (right, anterior, superior) do not apply.
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

/// The header with the four bytes behind it that tell of no extensions. What is not set is 0.
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
    use std::fs;
    use std::io::Read;

    use flate2::read::GzDecoder;
    use ndarray::Array3;
    use nifti::writer::WriterOptions;
    use nifti::{IntoNdArray, NiftiHeader, NiftiObject, ReaderOptions};

    #[test]
    fn a_volume_is_read_again_with_its_position() {
        let voxels =
            Array3::from_shape_fn((3, 4, 5), |(x, y, z)| (100 * x + 10 * y + z) as i16 - 50);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("us.nii.gz");
        let (corner, step) = ([-19.7e-3, -15e-3, 5e-3], [0.077e-3, 0.5e-3, 0.077e-3]);
        fs::write(&path, nifti(voxels.view(), corner, step).unwrap()).unwrap();
        let object = ReaderOptions::new().read_file(&path).unwrap();
        let header = object.header();
        assert_eq!(header.dim[..4], [3, 3, 4, 5]);
        assert_eq!(header.srow_y, [0.0, 0.5, 0.0, -15.0]);
        assert_eq!(header.srow_z, [0.0, 0.0, 0.077, 5.0]);
        assert_eq!(header.pixdim[1..4], [0.077, 0.5, 0.077]);
        let read = object.into_volume().into_ndarray::<i16>().unwrap();
        assert_eq!(read, voxels.clone().into_dyn());

        // Byte for byte what the library writes.
        let other = folder.path().join("other.nii.gz");
        let header = NiftiHeader {
            pixdim: [1.0, 0.077, 0.5, 0.077, 1.0, 1.0, 1.0, 1.0],
            xyzt_units: 2,
            srow_x: [0.077, 0.0, 0.0, -19.7],
            srow_y: [0.0, 0.5, 0.0, -15.0],
            srow_z: [0.0, 0.0, 0.077, 5.0],
            ..NiftiHeader::default()
        };
        let options = WriterOptions::new(&other).reference_header(&header);
        options.write_nifti(&voxels).unwrap();
        let inflated = |path| {
            let mut bytes = Vec::new();
            let mut file = GzDecoder::new(fs::File::open(path).unwrap());
            file.read_to_end(&mut bytes).unwrap();
            bytes
        };
        assert_eq!(inflated(&path), inflated(&other));
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
