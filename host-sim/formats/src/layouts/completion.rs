//! Keys that a layout adds to a file.

use crate::aliases::is_given;
use crate::layout::Layout;
use crate::values::NamedArrays;
use crate::variables::{Given, Variables};
use bonebeam_files::Result;

/// Keys that a layout adds to those found.
pub(super) struct Completion<'a> {
    pub(super) source: &'a dyn NamedArrays,
    pub(super) layout: Layout,
    /// Variables of the user.
    pub(super) given: &'a Variables,
    pub(super) all: &'a mut Variables,
    pub(super) assumed: &'a mut Vec<String>,
}

impl Completion<'_> {
    pub(super) fn assume(&mut self, key: &str, value: Given, why: &str) {
        self.all.insert(key, value);
        self.assumed.push(why.to_owned());
    }

    pub(super) fn is_given(&self, key: &str) -> bool {
        is_given(self.source, self.all, key)
    }

    /// The numbers of a key, if given.
    pub(super) fn numbers(&self, key: &str) -> Result<Option<Vec<f64>>> {
        match self.all.get(key) {
            Some(Given::Number(value)) => Ok(Some(vec![*value])),
            Some(Given::Numbers(values)) => Ok(Some(values.clone())),
            Some(Given::Name(name)) => self.source.vector(name).map(Some),
            _ if self.source.has(key) => self.source.vector(key).map(Some),
            _ => Ok(None),
        }
    }

    pub(super) fn number(&self, key: &str) -> Result<Option<f64>> {
        let numbers = self.numbers(key)?;
        Ok(numbers
            .as_deref()
            .and_then(|numbers| numbers.first().copied()))
    }
}
