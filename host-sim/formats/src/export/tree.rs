//! Writes groups, arrays and attributes of an HDF5 file.

use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};

use rust_hdf5::types::H5Type;
use rust_hdf5::{H5Dataset, H5File, H5Group, VarLenUnicode};

use crate::guard::guarded;
use bonebeam_files::{Error, Result};

/// Bytes that the library may write when it closes a file.
const CLOSING: usize = 1 << 18;

/// A file that is being written.
pub struct Tree {
    file: H5File,
    path: PathBuf,
}

/// Numerical attributes: name and list each.
pub type Marks<'a> = &'a [(&'a str, &'a [i64])];

fn failed(error: impl std::fmt::Display) -> String {
    format!("cannot be written: {error}")
}

/// Runs a write of the library; a panic becomes an error.
fn written<T>(write: impl FnOnce() -> std::result::Result<T, rust_hdf5::Hdf5Error>) -> Result<T> {
    guarded(|| write().map_err(failed)).map_err(Error::Data)
}

impl Tree {
    /// Creates a file in place of an empty one.
    pub fn create(path: &Path) -> Result<Self> {
        let file = written(|| H5File::options().no_locking().create(path))?;
        // A file that is dropped is written again, and the library prints that it failed, too.
        std::mem::forget(file.root_group());
        Ok(Tree {
            file,
            path: path.to_path_buf(),
        })
    }

    /// The root group.
    pub fn root(&self) -> Branch {
        Branch(self.file.root_group())
    }

    /// Closes the file.
    ///
    /// The disk has room for it beforehand; the library cuts off the rest.
    pub fn close(self) -> Result<()> {
        written(|| self.file.flush())?;
        let file = OpenOptions::new().append(true).open(&self.path);
        let reserved = file.and_then(|mut file| file.write_all(&vec![0; CLOSING]));
        reserved.map_err(|e| Error::Data(failed(e)))?;
        written(|| self.file.close())
    }
}

/// A group.
pub struct Branch(H5Group);

impl Branch {
    /// A group within this one, with attributes of texts and numbers.
    pub fn group(&self, name: &str, texts: &[(&str, &str)], numbers: Marks<'_>) -> Result<Branch> {
        let branch = Branch(written(|| self.0.create_group(name))?);
        branch.mark(texts)?;
        for (mark, values) in numbers {
            written(|| branch.0.set_attr_array_numeric(mark, values))?;
        }
        Ok(branch)
    }

    /// Adds texts as attributes of the group.
    pub fn mark(&self, texts: &[(&str, &str)]) -> Result<()> {
        for (mark, text) in texts {
            written(|| self.0.set_attr_string(mark, text))?;
        }
        Ok(())
    }

    /// An array of a shape, or a single number without axes.
    ///
    /// Its values follow.
    pub fn array<T: H5Type>(&self, name: &str, shape: &[usize]) -> Result<H5Dataset> {
        written(|| {
            let builder = self.0.new_dataset::<T>();
            match shape {
                [] => builder.scalar().create(name),
                shape => builder.shape(shape).create(name),
            }
        })
    }

    /// An array with its values.
    pub fn values<T: H5Type>(
        &self,
        name: &str,
        shape: &[usize],
        values: &[T],
    ) -> Result<H5Dataset> {
        let array = self.array::<T>(name, shape)?;
        written(|| array.write_raw(values))?;
        Ok(array)
    }
}

/// Adds texts and numbers as attributes of an array.
pub fn mark(array: &H5Dataset, texts: &[(&str, &str)], numbers: Marks<'_>) -> Result<()> {
    written(|| {
        for (mark, text) in texts {
            let attribute = array.new_attr::<VarLenUnicode>().shape(()).create(mark)?;
            attribute.write_string(text)?;
        }
        for (mark, values) in numbers {
            let attribute = array.new_attr::<i64>().shape([values.len()]).create(mark)?;
            attribute.write_array(values)?;
        }
        Ok(())
    })
}

/// Writes a frame: all of an array at one index of its first axis.
pub fn frame(array: &H5Dataset, shape: &[usize], index: usize, values: &[f32]) -> Result<()> {
    let mut starts = vec![0; shape.len()];
    starts[0] = index;
    let mut counts = shape.to_vec();
    counts[0] = 1;
    written(|| array.write_slice(&starts, &counts, values))
}

/// Writes all of an array.
pub fn all(array: &H5Dataset, values: &[f32]) -> Result<()> {
    written(|| array.write_raw(values))
}
