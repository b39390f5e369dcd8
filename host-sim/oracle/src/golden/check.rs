//! Comparison of another implementation's vectors with the golden ones.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use num_complex::Complex;

use super::files::texts;
use super::stages::{Stage, Values, stages};
use crate::{Error, Result};
use bonebeam_files::{input, read_array};

/// Comparison of a file with the golden one.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The file's name.
    pub file: String,
    /// Whether the file is equal to the bit.
    pub same: bool,
    /// The difference, in one line.
    pub detail: String,
}

/// Compares the `.npy` files and files of words in `folder` with the golden ones.
///
/// It finds the first word that differs, and the largest error of each stage.
///
/// # Errors
/// [`Error::File`] if the folder has none of them.
pub fn check(folder: &Path) -> Result<Vec<Verdict>> {
    let stages = stages()?;
    let mut verdicts = Vec::new();
    for stage in &stages {
        let path = folder.join(format!("{}.npy", stage.name));
        if path.exists() {
            verdicts.push(numbers(&path, stage));
        }
    }
    let (_, texts) = texts(&stages)?;
    for (name, text) in texts.iter().filter(|(name, _)| name.ends_with(".hex")) {
        let path = folder.join(name);
        if path.exists() {
            verdicts.push(words(&path, name, text)?);
        }
    }
    if verdicts.is_empty() {
        return Err(Error::File {
            path: folder.to_path_buf(),
            message:
                "holds no golden vectors; expected files as `host-sim golden -o DIR` writes them"
                    .into(),
        });
    }
    Ok(verdicts)
}

/// A `.npy` file.
fn numbers(path: &Path, stage: &Stage) -> Verdict {
    let found = match &stage.values {
        Values::Real(_) => read_array::<f32>(path)
            .map(|a| (a.shape().to_vec(), a.iter().copied().collect::<Vec<f32>>())),
        Values::Complex(_) => read_array::<Complex<f32>>(path).map(|a| {
            (
                a.shape().to_vec(),
                a.iter().flat_map(|z| [z.re, z.im]).collect(),
            )
        }),
    };
    let file = format!("{}.npy", stage.name);
    let (shape, found) = match found {
        Ok(found) => found,
        Err(error) => {
            return Verdict {
                file,
                same: false,
                detail: error.to_string(),
            };
        }
    };
    if shape != stage.shape {
        return Verdict {
            file,
            same: false,
            detail: format!("has the shape {shape:?}; expected {:?}", stage.shape),
        };
    }
    let expected = stage.values.words();
    let first = (0..expected.len()).find(|&i| expected[i].to_bits() != found[i].to_bits());
    let detail = match first {
        None => format!("{} words are the same", expected.len()),
        Some(i) => format!(
            "{} is {:e} ({:08x}); expected {:e} ({:08x}); the largest error is {:.1e} of the largest \
             number",
            position(stage, i),
            found[i],
            found[i].to_bits(),
            expected[i],
            expected[i].to_bits(),
            largest_error(&expected, &found)
        ),
    };
    Verdict {
        file,
        same: first.is_none(),
        detail,
    }
}

/// The word of index `i`, by its indices in the array.
fn position(stage: &Stage, i: usize) -> String {
    let parts = stage.values.parts();
    let mut rest = i / parts;
    let mut indices = Vec::new();
    for &length in stage.shape.iter().rev() {
        indices.push(rest % length);
        rest /= length;
    }
    let named = stage.axes.iter().zip(indices.iter().rev());
    let named: Vec<String> = named.map(|(axis, i)| format!("{axis} {i}")).collect();
    let part = match (parts, i % parts) {
        (1, _) => "",
        (_, 0) => ", real part",
        _ => ", imaginary part",
    };
    format!("[{}]{part}", named.join(", "))
}

/// The largest error relative to the largest number; infinite if a word is NaN.
fn largest_error(expected: &[f32], found: &[f32]) -> f64 {
    let largest = expected
        .iter()
        .fold(0.0f64, |a, &b| a.max(f64::from(b.abs())));
    let mut worst = 0.0f64;
    for (&expected, &found) in expected.iter().zip(found) {
        let error = (f64::from(expected) - f64::from(found)).abs();
        worst = if error.is_nan() {
            f64::INFINITY
        } else {
            worst.max(error)
        };
    }
    worst / largest
}

/// A file of words, as `$readmemh` reads it.
fn words(path: &Path, name: &str, text: &str) -> Result<Verdict> {
    let unreadable = |e: std::io::Error| Error::File {
        path: path.to_path_buf(),
        message: format!("cannot be read: {e}"),
    };
    // A file of the right length is not much longer than the golden one.
    let most = 4 * text.len() as u64;
    let file = BufReader::new(input::open(path).map_err(unreadable)?.take(most));
    let mut found = Vec::new();
    for line in file.split(b'\n') {
        let line = line.map_err(unreadable)?;
        let line = String::from_utf8_lossy(&line);
        let line = line.split("//").next().unwrap_or("");
        found.extend(
            line.split_whitespace()
                .map(|word| word.to_ascii_lowercase()),
        );
    }
    let expected: Vec<&str> = text
        .lines()
        .filter(|line| !line.starts_with("//"))
        .collect();
    let differing: Vec<usize> = (0..expected.len().max(found.len()))
        .filter(|&i| expected.get(i).copied() != found.get(i).map(String::as_str))
        .collect();
    let word = |word: Option<&str>| match word {
        // A file of another program may have any contents.
        Some(word) => word
            .chars()
            .take(40)
            .flat_map(char::escape_default)
            .collect(),
        None => "missing".to_owned(),
    };
    Ok(Verdict {
        file: name.to_owned(),
        same: differing.is_empty(),
        detail: match differing.first() {
            None => format!("{} words are the same", expected.len()),
            Some(&i) => format!(
                "word {i} is {}; expected {}; {} of {} words differ",
                word(found.get(i).map(String::as_str)),
                word(expected.get(i).copied()),
                differing.len(),
                expected.len()
            ),
        },
    })
}
