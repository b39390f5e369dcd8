//! Volumes as NIfTI files, for 3D Slicer, ParaView and the like.

use std::error::Error as StdError;
use std::fs;

use ndarray::ArrayView3;
use nifti::NiftiHeader;
use nifti::writer::WriterOptions;

use crate::{Error, Result};

/// The bytes of a gzipped NIfTI-1 file of voxels of 16 bits, `[x, y, z]`. `corner` is the first voxel's centre
/// and `step` the distance between voxels, both in m. The file is in mm along the same axes, as the surfaces
/// beside it are. NIfTI's own names for its axes (right, anterior, superior) do not apply.
///
/// # Errors
/// It cannot be written.
pub fn nifti(voxels: ArrayView3<i16>, corner: [f64; 3], step: [f64; 3]) -> Result<Vec<u8>> {
    write(voxels, corner, step)
        .map_err(|e| Error::Data(format!("the volume cannot be written: {e}")))
}

fn write(
    voxels: ArrayView3<i16>,
    corner: [f64; 3],
    step: [f64; 3],
) -> std::result::Result<Vec<u8>, Box<dyn StdError>> {
    let row = |axis: usize| {
        let mut row = [0.0f32; 4];
        row[axis] = (1e3 * step[axis]) as f32;
        row[3] = (1e3 * corner[axis]) as f32;
        row
    };
    let mut pixdim = [1.0f32; 8];
    for axis in 0..3 {
        pixdim[1 + axis] = (1e3 * step[axis]) as f32;
    }
    let header = NiftiHeader {
        pixdim,
        // Lengths in mm; coordinates of the scanner.
        xyzt_units: 2,
        sform_code: 1,
        srow_x: row(0),
        srow_y: row(1),
        srow_z: row(2),
        ..NiftiHeader::default()
    };
    // The library writes to a path of its own.
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("volume.nii.gz");
    WriterOptions::new(&file)
        .reference_header(&header)
        .write_nifti(&voxels)?;
    Ok(fs::read(&file)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array3;
    use nifti::{IntoNdArray, NiftiObject, ReaderOptions};

    #[test]
    fn a_volume_is_read_again_with_its_place() {
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
        assert_eq!(read, voxels.into_dyn());
    }
}
