//! Files for the tests, valid or with one fault.

mod pages;
pub mod program;
mod runs;
pub mod shaft;

use bonebeam_files::Recording;
use bonebeam_formats::Variables;
use std::fs::File;
use std::path::Path;

use ndarray::{Array1, Array3, ArrayD, Ix3, arr0};
use ndarray_npy::{NpzWriter, WritableElement};
use zip::CompressionMethod;
use zip::write::{SimpleFileOptions, ZipWriter};

/// A `.npz` file put together key by key.
pub struct Npz(NpzWriter<File>);

impl Npz {
    pub fn create(path: &Path) -> Self {
        Self(NpzWriter::new(File::create(path).unwrap()))
    }

    pub fn with<T: WritableElement>(mut self, key: &str, array: ArrayD<T>) -> Self {
        self.0.add_array(key, &array).unwrap();
        self
    }

    pub fn finish(self) {
        self.0.finish().unwrap();
    }
}

/// All frames of a recording, in the format that the file has.
pub fn read(path: &Path) -> bonebeam_files::Result<Recording> {
    let all = 0..usize::MAX;
    Ok(bonebeam_formats::read(path, &Variables::default(), all)?.recording)
}

pub fn scalar(value: f64) -> ArrayD<f64> {
    arr0(value).into_dyn()
}

pub fn vector(values: &[f64]) -> ArrayD<f64> {
    Array1::from_vec(values.to_vec()).into_dyn()
}

/// Two transmits, four elements, 64 samples: a ramp, so that every sample differs.
pub fn ramp() -> Array3<f32> {
    Array3::from_shape_fn((2, 4, 64), |(t, m, n)| (t * 1000 + m * 100 + n) as f32)
}

/// Writes plane-wave channel data without the key `left_out`.
pub fn channel_data_without(path: &Path, left_out: &[&str]) -> Npz {
    let mut npz = Npz::create(path);
    if !left_out.contains(&"rf") {
        npz = npz.with("rf", ramp().into_dyn());
    }
    let keys = [
        ("fs", scalar(40e6)),
        ("t0", vector(&[1e-6, 2e-6])),
        ("element_x", vector(&[-0.45e-3, -0.15e-3, 0.15e-3, 0.45e-3])),
        ("c", scalar(1540.0)),
        ("f0", scalar(5e6)),
        ("tx_angle", vector(&[-0.1, 0.1])),
    ];
    for (key, array) in keys {
        if !left_out.contains(&key) {
            npz = npz.with(key, array);
        }
    }
    npz
}

/// Plane-wave channel data whose member `key` is begun, to be compressed so.
pub fn channel_data_with(path: &Path, key: &str, how: CompressionMethod) -> ZipWriter<File> {
    channel_data_without(path, &[key]).finish();
    let file = File::options().read(true).write(true).open(path).unwrap();
    let mut archive = ZipWriter::new_append(file).unwrap();
    let options = SimpleFileOptions::default().compression_method(how);
    archive.start_file(format!("{key}.npy"), options).unwrap();
    archive
}

/// An `.npy` array of version 1 with this dtype, this shape and these bytes.
pub fn npy(descr: &str, shape: &str, numbers: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(numbers);
    bytes
}

/// The ramp in column-major order, as Fortran and MATLAB write it.
pub fn column_major_ramp() -> ArrayD<f32> {
    use ndarray::ShapeBuilder;
    let mut array = Array3::<f32>::zeros(Ix3(2, 4, 64).f());
    array.assign(&ramp());
    array.into_dyn()
}

/// A value with something changed.
pub fn changed<T>(mut value: T, change: impl FnOnce(&mut T)) -> T {
    change(&mut value);
    value
}
