//! Reads the arrays of an HDF5 file: zea, UFF, PICMUS, MATLAB 7.3 and others.
//!
//! `rust-hdf5` reads them, without a C library. It follows links into other files by itself, so it is given paths of
//! hard links only: a recording is one file, and links out of it and raw data in another file are refused.

mod kind;
mod numbers;

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use ndarray::ArrayD;
use rust_hdf5::{
    DatatypeMessage, H5Dataset, H5File, H5Group, Hdf5Error, LinkClass, Reference, StorageLayout,
};

use crate::guard::{ReadResult, claim_in_memory, guarded};
use crate::values::{AxisRange, NamedArrays, Reads, Values, steps};
use bonebeam_files::{Error, Result, cannot_be_opened, file_error, input};
use kind::{damaged, kind};

/// Offset at which an HDF5 file may begin within one of MATLAB's.
const USER_BLOCK: u64 = 512;
/// Largest number of soft links on a path.
const MAX_LINKS: usize = 16;

/// An open file.
pub struct Store {
    path: PathBuf,
    file: H5File,
    /// Its length, bytes.
    length: u64,
    /// Whether MATLAB or Octave wrote it, whose order of axes is reversed.
    matlab: bool,
    /// Whether Octave wrote it: groups with `type` and `value`.
    octave: bool,
    read: Reads,
}

impl Store {
    /// Opens the file and reads its table of contents.
    ///
    /// # Errors
    /// A file that cannot be opened, or is damaged.
    pub fn open(path: &Path, matlab: bool) -> Result<Self> {
        let length = input::open(path)
            .and_then(|file| file.metadata())
            .map_err(|e| file_error(path, cannot_be_opened(&e)))?
            .len();
        let file = guarded(|| {
            let options = H5File::options().no_locking();
            options.open(path).map_err(|e| damaged(&e))
        });
        let mut store = Self {
            path: path.to_path_buf(),
            file: file.map_err(|message| file_error(path, message))?,
            length: length.max(USER_BLOCK),
            matlab,
            octave: false,
            read: Reads::default(),
        };
        let names = store.names();
        let is_pair = |name: &String| {
            let group = name.strip_suffix("/type");
            group.is_some_and(|group| names.contains(&format!("{group}/value")))
        };
        let is_of_pair = |name: &String| name.ends_with("/type") || name.contains("/value");
        store.octave = !matlab && names.iter().any(is_pair) && names.iter().all(is_of_pair);
        store.matlab |= store.octave;
        Ok(store)
    }

    /// Whether Octave wrote the file, in its own layout.
    pub fn is_octave(&self) -> bool {
        self.octave
    }

    /// The path in the file of a name.
    fn own<'a>(&self, name: &'a str) -> Cow<'a, str> {
        match self.octave {
            true => steps(name)
                .iter()
                .map(|(step, _)| format!("{step}/value"))
                .collect::<Vec<_>>()
                .join("/")
                .into(),
            false => name.into(),
        }
    }

    /// Whether there is a group at this path.
    pub fn has_group(&self, path: &str) -> bool {
        guarded(|| Ok(self.group(path)?.is_some())).unwrap_or(false)
    }

    /// The names of the groups in a group, in order.
    pub fn groups(&self, path: &str) -> Vec<String> {
        let names = guarded(|| {
            let names = self.group(path)?.map(|group| group.group_names());
            names.transpose().map_err(|e| damaged(&e))
        });
        names.ok().flatten().unwrap_or_default()
    }

    /// A text attribute of a group.
    pub fn mark(&self, group: &str, name: &str) -> Option<String> {
        let read = || {
            Ok(self
                .group(group)?
                .and_then(|group| group.attr_string(name).ok()))
        };
        guarded(read).ok().flatten()
    }

    /// Path of hard links to an object; `None` if there is none.
    ///
    /// # Errors
    /// A link into another file on the way, or too many soft links.
    fn within(&self, path: &str) -> ReadResult<Option<String>> {
        let reversed = |path: &str| {
            let steps = path.split('/').filter(|step| !["", "."].contains(step));
            steps.rev().map(str::to_owned).collect::<Vec<_>>()
        };
        let (mut group, mut ahead, mut links) = (self.file.root_group(), reversed(path), 0);
        while let Some(step) = ahead.pop() {
            match group.link_class(&step) {
                Ok(LinkClass::External { .. } | LinkClass::UserDefined { .. }) => {
                    return Err("is a link into another file, which is not followed".into());
                }
                Ok(LinkClass::Soft { path }) => {
                    links += 1;
                    if links > MAX_LINKS || path.contains("..") {
                        return Err("is a link that is not followed".into());
                    }
                    if path.starts_with('/') {
                        group = self.file.root_group();
                    }
                    ahead.extend(reversed(&path));
                }
                Ok(LinkClass::Hard) if ahead.is_empty() => {
                    let folder = group.name().trim_end_matches('/');
                    return Ok(Some(format!("{folder}/{step}")));
                }
                // Its name is its path by hard links, also if the step is a second one to it.
                Ok(LinkClass::Hard) => match group.group(&step) {
                    Ok(next) => group = next,
                    Err(_) => return Ok(None),
                },
                Err(_) => return Ok(None),
            }
        }
        Ok(Some(group.name().to_owned()))
    }

    /// The group at a path, if there is one.
    fn group(&self, path: &str) -> ReadResult<Option<H5Group>> {
        let root = self.file.root_group();
        let path = self.within(path)?;
        Ok(match path.as_deref() {
            Some("/") => Some(root),
            Some(path) => root.group(path).ok(),
            None => None,
        })
    }

    /// The dataset at a path, if there is one.
    ///
    /// # Errors
    /// It is not in this file, or not readable.
    fn at(&self, path: &str) -> ReadResult<Option<H5Dataset>> {
        let Some(path) = self.within(path)? else {
            return Ok(None);
        };
        let dataset = match self.file.dataset(&path) {
            Ok(dataset) => dataset,
            Err(Hdf5Error::NotFound(_)) => return Ok(None),
            Err(other) => return Err(damaged(&other)),
        };
        let files = dataset.external_files().map_err(|e| damaged(&e))?;
        match files.is_empty() {
            true => Ok(Some(dataset)),
            false => Err("is in another file, which is not read".into()),
        }
    }

    /// Checks that the sources of a virtual dataset are in this file, and are not virtual.
    fn check_sources(&self, dataset: &H5Dataset) -> ReadResult<()> {
        let is_virtual = |dataset: &H5Dataset| {
            let layout = dataset.storage_layout().map_err(|e| damaged(&e))?;
            Ok::<_, String>(layout == StorageLayout::Virtual)
        };
        if !is_virtual(dataset)? {
            return Ok(());
        }
        for mapping in dataset.virtual_mappings().map_err(|e| damaged(&e))? {
            let source = &mapping.source_dset_name;
            // A percent sign stands for a number.
            if mapping.source_file_name != "." || source.contains('%') {
                return Err("is in another file, which is not read".into());
            }
            let of_source = |e: String| format!("is made of `{source}`, which {e}");
            if let Some(own) = self.at(source).map_err(of_source)?
                && is_virtual(&own)?
            {
                return Err(of_source("is virtual, too, and is not read".into()));
            }
        }
        Ok(())
    }

    /// The shape of a dataset, in the file's order of axes.
    ///
    /// # Errors
    /// There is no dataset with this name.
    pub fn shape(&self, name: &str) -> Result<Vec<usize>> {
        self.about(name, guarded(|| Ok(self.dataset(name)?.shape())))
    }

    /// Paths of the datasets that a name stands for.
    ///
    /// They are its own, those that MATLAB's cells refer to, or those of a field of all structs of an array, whose
    /// group has references as its members.
    fn paths(&self, name: &str) -> ReadResult<Vec<String>> {
        let mut paths = vec![String::new()];
        // The entry of an array of structs, until a field is reached.
        let mut chosen = None;
        for (step, index) in steps(name) {
            chosen = index.or(chosen);
            let mut next = Vec::new();
            for path in paths {
                let path = format!("{path}/{step}");
                match self.references(&path)? {
                    None => next.push(path),
                    Some(entries) => {
                        let choice = chosen.take();
                        let numbered = entries.into_iter().zip(1..);
                        let asked =
                            numbered.filter(|(_, k)| choice.is_none_or(|choice| choice == *k));
                        next.extend(asked.filter_map(|(entry, _)| entry));
                    }
                }
            }
            paths = next;
        }
        // One that was chosen of what has no entries is not there.
        paths.retain(|_| chosen.is_none_or(|k| k == 1));
        let found = paths.into_iter().filter_map(|path| match self.at(&path) {
            Ok(dataset) => dataset.map(|_| Ok(path)),
            Err(message) => Some(Err(message)),
        });
        found.collect()
    }

    /// Targets of a dataset's references.
    ///
    /// `None` if it has other elements, or is not a dataset.
    fn references(&self, path: &str) -> ReadResult<Option<Vec<Option<String>>>> {
        let Some(dataset) = self.at(path)? else {
            return Ok(None);
        };
        let datatype = dataset.datatype().map_err(|e| damaged(&e))?;
        if !matches!(datatype, DatatypeMessage::Reference { .. }) {
            return Ok(None);
        }
        claim_in_memory(&dataset.shape(), dataset.element_size(), self.length)?;
        let references = dataset.read_references().map_err(|e| damaged(&e))?;
        if references
            .iter()
            .any(|reference| reference.file().is_some())
        {
            return Err("refers to another file, which is not read".into());
        }
        let path = |reference: &Reference| reference.path().map(str::to_owned);
        Ok(Some(references.iter().map(path).collect()))
    }

    /// The dataset that a name stands for.
    fn dataset(&self, name: &str) -> ReadResult<H5Dataset> {
        let name = &*self.own(name);
        let mut dataset = self.at(name)?;
        if dataset.is_none() || self.references(name)?.is_some() {
            let mut paths = self.paths(name)?;
            if paths.len() > 1 {
                return Err(format!(
                    "stands for {} arrays; expected one of them, such as `{name}{{1}}`",
                    paths.len()
                ));
            }
            if let Some(path) = paths.pop() {
                dataset = self.at(&path)?;
            }
        }
        let dataset = dataset.ok_or("is missing")?;
        self.check_sources(&dataset)?;
        Ok(dataset)
    }

    fn about<T>(&self, name: &str, outcome: ReadResult<T>) -> Result<T> {
        outcome.map_err(|message| self.error(format!("`{name}` {message}")))
    }

    /// A text of one string.
    ///
    /// # Errors
    /// There is no such text.
    pub fn word(&self, name: &str) -> Result<String> {
        self.read.note(name);
        let read = || {
            let dataset = self.dataset(name)?;
            let is_one = dataset.shape().iter().all(|side| *side == 1);
            let words = is_one.then(|| dataset.read_strings()).transpose();
            let word = words
                .map_err(|e| damaged(&e))?
                .and_then(|mut words| words.pop());
            word.ok_or_else(|| "is no text".to_owned())
        };
        self.about(name, guarded(read))
    }
}

impl NamedArrays for Store {
    fn note(&self, name: &str) {
        self.read.note(name);
    }

    fn unread(&self) -> Vec<String> {
        self.read.without(self.names())
    }

    fn error(&self, message: String) -> Error {
        file_error(&self.path, message)
    }

    /// Names, without arrays that only MATLAB's references use.
    fn names(&self) -> Vec<String> {
        let mut names = guarded(|| Ok(self.file.dataset_names())).unwrap_or_default();
        names.retain(|name| !name.trim_start_matches('/').starts_with('#'));
        if self.octave {
            names.retain(|name| name.ends_with("/value"));
            for name in &mut names {
                *name = name
                    .split('/')
                    .filter(|&step| step != "value")
                    .collect::<Vec<_>>()
                    .join("/");
            }
        }
        names
    }

    fn sides(&self, name: &str) -> Option<Vec<usize>> {
        let read = || {
            let dataset = self.dataset(name)?;
            kind(&dataset.datatype().map_err(|e| damaged(&e))?)?;
            let mut shape = dataset.shape();
            if self.matlab {
                shape.reverse();
            }
            Ok(shape)
        };
        guarded(read).ok()
    }

    fn entries(&self, name: &str) -> Vec<String> {
        if self.octave {
            let known = self.names().into_iter();
            return known.filter(|known| steps(known) == steps(name)).collect();
        }
        guarded(|| self.paths(name)).unwrap_or_default()
    }

    /// Whether an array exists.
    ///
    /// One that leads out of the file exists, and is refused when it is read.
    fn has(&self, name: &str) -> bool {
        let leads_out = || guarded(|| self.at(&self.own(name))).is_err();
        self.names().iter().any(|known| known == name)
            || leads_out()
            || !self.entries(name).is_empty()
    }

    fn numbers(&self, name: &str) -> Result<ArrayD<f64>> {
        self.about(name, guarded(|| self.read_numbers(name)))
    }

    fn shape_for_parts(&self, name: &str) -> Result<Option<Vec<usize>>> {
        self.about(name, guarded(|| self.shape_of_parts(name)))
    }

    fn samples(&self, name: &str, part: Option<AxisRange>) -> Result<Values> {
        self.about(name, guarded(|| self.read_samples(name, part)))
    }
}

#[cfg(test)]
mod tests;
