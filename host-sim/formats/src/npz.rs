//! Arrays of a `.npz` archive by names that users choose.

use std::cell::RefCell;
use std::path::Path;

use ndarray::ArrayD;

use crate::values::{AxisRange, NamedArrays, Reads, Values};
use bonebeam_files::{Error, Result, npz};

/// An archive whose arrays are read whole.
pub struct Archive {
    reader: RefCell<npz::Reader>,
    names: Vec<String>,
    read: Reads,
}

impl Archive {
    /// Opens the archive and reads its table of contents.
    ///
    /// # Errors
    /// As [`npz::Reader::open`].
    pub fn open(path: &Path) -> Result<Self> {
        let reader = npz::Reader::open(path)?;
        Ok(Self {
            names: reader.keys(),
            reader: RefCell::new(reader),
            read: Reads::default(),
        })
    }
}

impl NamedArrays for Archive {
    fn error(&self, message: String) -> Error {
        self.reader.borrow().error(message)
    }

    fn names(&self) -> Vec<String> {
        self.names.clone()
    }

    fn unread(&self) -> Vec<String> {
        self.read.without(self.names())
    }

    fn numbers(&self, name: &str) -> Result<ArrayD<f64>> {
        self.read.note(name);
        self.reader.borrow_mut().real_of_any_rank(name)
    }

    fn shape_for_parts(&self, _: &str) -> Result<Option<Vec<usize>>> {
        Ok(None)
    }

    fn samples(&self, name: &str, _: Option<AxisRange>) -> Result<Values> {
        self.read.note(name);
        let mut reader = self.reader.borrow_mut();
        match reader.is_complex(name)? {
            true => Ok(Values::Complex(reader.complex(name, "any axes")?)),
            false => Ok(Values::Real(reader.samples_of_any_rank(name)?)),
        }
    }

    fn sides(&self, name: &str) -> Option<Vec<usize>> {
        self.reader.borrow_mut().shape(name).ok()
    }
}
