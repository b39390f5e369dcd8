//! Refusals of the command, from the tables in this folder: one line with these words, this status, and no new file.
//!
//! A group has files and a command. A row is a list: text for the command's `{}`, then words of the message. Or it is a
//! table with `spoilt`, the contents of the file that the group `spoils`. With status 0, the line is a warning; without
//! words there is none.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use ndarray::{Array2, ArrayD};
use ndarray_npy::write_npy;
use num_complex::Complex;
use serde::Deserialize;
use tempfile::tempdir;
use toml::Value;

use super::common::program::{judged, names};
use super::common::{Npz, channel_data_without, ramp, scalar, vector};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    group: Vec<Group>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Group {
    about: String,
    run: String,
    #[serde(default = "usage")]
    status: i32,
    #[serde(default)]
    files: BTreeMap<String, Contents>,
    #[serde(default)]
    spoils: String,
    rows: Vec<Row>,
}

/// The exit status of a wrong command line.
fn usage() -> i32 {
    2
}

fn one() -> usize {
    1
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Row {
    Flags(Vec<String>),
    Spoilt {
        spoilt: Box<Contents>,
        #[serde(default)]
        flags: String,
        words: Vec<String>,
        /// Lines of the message.
        #[serde(default = "one")]
        lines: usize,
    },
}

/// Contents of a file: the first that is given of those below, changed by the others.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Contents {
    /// Channel data of two plane waves with these keys in place of their own; `false` leaves a key out.
    npz: Option<BTreeMap<String, Value>>,
    /// An archive with these keys alone.
    only: Option<BTreeMap<String, Value>>,
    npy: Option<Value>,
    /// Rows and columns of a black picture.
    png: Option<[usize; 2]>,
    /// Bytes, one for each character up to U+00FF.
    text: String,
    /// Bytes and how often they follow.
    then: (String, usize),
    folder: bool,
    link: Option<String>,
    /// A pipe without a writer, which would wait for ever.
    pipe: bool,
    /// The length, or how many bytes fewer than whole, or the share that is kept.
    length: Option<Value>,
    /// A byte of which one bit is flipped.
    flipped: Option<usize>,
}

/// An array of a type and a shape, all `fill` or a ramp, with axes in another `order` and one value `set`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Array {
    of: String,
    #[serde(default)]
    shape: Vec<usize>,
    #[serde(default)]
    fill: f64,
    values: Option<Vec<f64>>,
    /// The first value, their distance and their number.
    steps: Option<(f64, f64, usize)>,
    order: Option<[usize; 3]>,
    set: Option<(Vec<usize>, f64)>,
}

impl Array {
    fn of(value: &Value) -> Self {
        let read = |of: &str, values: ArrayD<f64>| Array {
            of: of.into(),
            shape: values.shape().to_vec(),
            fill: 0.0,
            values: Some(values.into_iter().collect()),
            steps: None,
            order: None,
            set: None,
        };
        let number = |value: &Value| value.clone().try_into::<f64>().unwrap();
        match value {
            Value::Table(_) => value.clone().try_into().unwrap(),
            Value::Array(values) => read(
                "f64",
                vector(&values.iter().map(number).collect::<Vec<_>>()),
            ),
            value => read("f64", scalar(number(value))),
        }
    }

    fn values(&self) -> ArrayD<f64> {
        if let Some((first, step, count)) = self.steps {
            return vector(
                &(0..count)
                    .map(|n| first + n as f64 * step)
                    .collect::<Vec<_>>(),
            );
        }
        let mut array = match (&self.values, self.shape.is_empty()) {
            (Some(values), true) => vector(values),
            (Some(values), false) => vector(values)
                .into_shape_with_order(self.shape.clone())
                .unwrap(),
            (None, true) => ramp().mapv(f64::from).into_dyn(),
            (None, false) => ArrayD::from_elem(self.shape.clone(), self.fill),
        };
        if let Some(order) = self.order {
            array = array
                .permuted_axes(&order[..])
                .as_standard_layout()
                .into_owned();
        }
        if let Some((index, value)) = &self.set {
            array[&index[..]] = *value;
        }
        array
    }
}

/// Calls `$write` with the array in its type.
macro_rules! typed {
    ($array:expr, |$typed:ident| $write:expr) => {{
        let (array, values) = ($array, $array.values());
        match array.of.as_str() {
            "f32" => {
                let $typed = values.mapv(|v| v as f32);
                $write
            }
            "f64" => {
                let $typed = values;
                $write
            }
            "u32" => {
                let $typed = values.mapv(|v| v as u32);
                $write
            }
            "i64" => {
                let $typed = values.mapv(|v| v as i64);
                $write
            }
            "u64" => {
                let $typed = values.mapv(|v| v as u64);
                $write
            }
            "c64" => {
                let $typed = values.mapv(|v| Complex::new(v as f32, 1.0));
                $write
            }
            "c64 imaginary" => {
                let $typed = values.mapv(|v| Complex::new(0.0, v as f32));
                $write
            }
            "c128" => {
                let $typed = values.mapv(|v| Complex::new(v, 0.0));
                $write
            }
            other => panic!("no type {other}"),
        }
    }};
}

fn bytes(text: &str) -> Vec<u8> {
    text.chars()
        .map(|c| u8::try_from(u32::from(c)).unwrap())
        .collect()
}

impl Contents {
    fn write(&self, path: &Path) {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        let _ = fs::remove_file(path);
        if self.folder {
            return fs::create_dir_all(path).unwrap();
        }
        if self.pipe {
            assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
            return;
        }
        if let Some(target) = &self.link {
            return std::os::unix::fs::symlink(target, path).unwrap();
        }
        if let Some(keys) = self.npz.as_ref().or(self.only.as_ref()) {
            let without: Vec<&str> = keys.keys().map(String::as_str).collect();
            let mut npz = match self.npz {
                Some(_) => channel_data_without(path, &without),
                None => Npz::create(path),
            };
            for (key, value) in keys.iter().filter(|(_, value)| value.as_bool().is_none()) {
                npz = typed!(Array::of(value), |array| npz.with(key, array));
            }
            npz.finish();
        } else if let Some(value) = &self.npy {
            typed!(Array::of(value), |array| write_npy(path, &array).unwrap());
        } else if let Some([rows, columns]) = self.png {
            bonebeam_files::image::write(&Array2::zeros((rows, columns)), path).unwrap();
        } else {
            let mut contents = bytes(&self.text);
            contents.extend(bytes(&self.then.0).repeat(self.then.1));
            fs::write(path, contents).unwrap();
        }
        if let Some(index) = self.flipped {
            let mut contents = fs::read(path).unwrap();
            contents[index] ^= 1;
            fs::write(path, contents).unwrap();
        }
        if let Some(length) = &self.length {
            let file = fs::OpenOptions::new().write(true).open(path).unwrap();
            let whole = file.metadata().unwrap().len();
            let length = match *length {
                Value::Float(share) => (share * whole as f64) as u64,
                Value::Integer(fewer) if fewer < 0 => whole - fewer.unsigned_abs(),
                ref length => length.as_integer().unwrap() as u64,
            };
            file.set_len(length).unwrap();
        }
    }
}

impl Group {
    fn check(&self) {
        let folder = tempdir().unwrap();
        for (name, contents) in &self.files {
            contents.write(&folder.path().join(name));
        }
        for row in &self.rows {
            let (flags, words, lines) = match row {
                Row::Flags(row) => (&row[0], &row[1..], 1),
                Row::Spoilt {
                    spoilt,
                    flags,
                    words,
                    lines,
                } => {
                    spoilt.write(&folder.path().join(&self.spoils));
                    (flags, &words[..], *lines)
                }
            };
            let silent = words.is_empty() && self.status != 0;
            assert!(!silent, "{}: a row without words", self.about);
            judged(
                &folder,
                self.run.replace("{}", flags).trim(),
                self.status,
                lines,
                words,
            );
        }
    }
}

/// Checks the groups of a table; returns the number of rows.
fn rows_of(name: &str) -> usize {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/refused");
    let text = fs::read_to_string(folder.join(name).with_extension("toml")).unwrap();
    let table: Table = toml::from_str(&text).unwrap_or_else(|e| panic!("{name}: {e}"));
    table.group.iter().for_each(Group::check);
    table.group.iter().map(|group| group.rows.len()).sum()
}

macro_rules! tables {
    ($($name:ident at least $rows:literal;)*) => {
        $(#[test]
        fn $name() {
            assert!(rows_of(stringify!($name)) >= $rows);
        })*

        #[test]
        fn every_table_is_read() {
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/refused");
            let tables = names(&folder).into_iter().filter(|name| name != "mod.rs");
            let read = [$(concat!(stringify!($name), ".toml")),*];
            assert_eq!(tables.collect::<Vec<_>>(), read);
        }
    };
}

tables! {
    configurations at least 48;
    flags at least 60;
    irregular at least 22;
    pictures at least 35;
    recordings at least 110;
    registration at least 15;
    simulations at least 30;
}
