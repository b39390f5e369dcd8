//! The files of the golden vectors.

use std::fs;
use std::io::Write;
use std::path::Path;

use fnv::FnvHasher;
use ndarray::{ArrayViewD, IxDyn};
use num_complex::Complex;
use serde::Serialize;
use std::hash::Hasher;

use super::adaptive::{self, Adaptive, LOADING, Program};
use super::chain;
use super::fixed_point::{FixedPoint, quantise};
use super::integer::{Word, corners, covariance, das};
use super::scene::{ELEMENTS, SAMPLES, SUBAPERTURE, TRACED};
use super::stages::{Stage, Values};
use crate::{Error, Result};
use bonebeam_files::atomic::Outputs;
use bonebeam_files::{npy, temporary_files};

/// Contents of the folder.
#[derive(Clone, Debug, Serialize)]
pub struct Manifest {
    /// Instructions for reading the files.
    pub conventions: &'static [&'static str],
    /// The stages, in their order.
    pub stages: Vec<Entry>,
    /// The stages that are computed from integers.
    pub integer: Vec<Integer>,
}

/// One stage's files.
#[derive(Clone, Debug, Serialize)]
pub struct Entry {
    /// `NAME.npy`, `NAME.f32.hex`, `NAME.q15.hex`.
    pub name: String,
    /// Contents of the files.
    pub what: &'static str,
    /// The meaning of each axis.
    pub axes: &'static [&'static str],
    /// The length of each axis; row-major.
    pub shape: Vec<usize>,
    /// "float32" or "complex64".
    pub number: &'static str,
    /// FNV-1a, 64 bits, over the little-endian words.
    pub hash: String,
    /// A number is `word·2^(exponent − 15)`.
    pub exponent: i32,
    /// The largest error of the words, relative to the stage's largest number.
    pub largest_error: f64,
    /// The RMS error of the words, relative to the same number.
    pub rms_error: f64,
    /// Number of words that saturate.
    pub saturated: usize,
}

/// Vectors of a computation on integers.
#[derive(Clone, Debug, Serialize)]
pub struct Integer {
    /// The files, input and output.
    pub files: [&'static str; 2],
    /// The computation.
    pub what: &'static str,
    /// Number of vectors, and of corner cases at their end.
    pub vectors: [usize; 2],
    /// The largest error against the f32 stage, if the stage has that result.
    ///
    /// It is relative to the stage's largest number.
    pub largest_error: Option<f64>,
}

const CONVENTIONS: &[&str] = &[
    "NAME.npy: the numbers, float32 or complex64, row-major",
    "NAME.f32.hex: for $readmemh, the bits of each float as eight hexadecimal digits; a complex number is \
     its real part, then its imaginary one",
    "NAME.q15.hex: for $readmemh, signed words of 16 bits in two's complement; a number is \
     word·2^(exponent − 15); rounded to nearest, ties to even; saturated at ±32767",
    "a comment before each index of the first axis: // AXIS K",
    "das.in.hex, covariance.in.hex: 16 complex words a vector, {re, im} as 8 digits",
    "das.out.hex: {re, im} as 8 digits, (sum + 8) >> 4",
    "covariance.out.hex: {re, im} as 20 digits, 40 bits each, for i = 0..7 and j = 0..i",
    "mv.in.hex: as das.in.hex; mv.out.hex, mv.rank1.hex, mv.das.hex: MV, rank-1 ESMV and DAS {re, im} as 16 digits, in 2^-10 of a count",
    "chain.in.hex: beats of the blocks of 12 lines, 175 samples each; chain.out.hex: {im, re}, as mv.out.hex",
    "real_form.hex, solver.hex, reciprocals.hex: the tables of the cores of these names",
];

const DAS: [&str; 2] = ["das.in.hex", "das.out.hex"];
const COVARIANCE: [&str; 2] = ["covariance.in.hex", "covariance.out.hex"];
const CHAIN: [&str; 2] = ["chain.in.hex", "chain.out.hex"];
const MV: [&str; 2] = ["mv.in.hex", "mv.out.hex"];
const RANK1: [&str; 2] = ["mv.in.hex", "mv.rank1.hex"];

/// A text file.
type Text = (String, String);

/// All files but the `.npy` ones, as text.
pub(super) fn texts(stages: &[Stage]) -> Result<(Manifest, Vec<Text>)> {
    let mut texts = Vec::new();
    let mut entries = Vec::new();
    for stage in stages {
        let words = stage.values.words();
        let block = quantise(&words);
        let bits = words.iter().map(|word| format!("{:08x}", word.to_bits()));
        texts.push((
            format!("{}.f32.hex", stage.name),
            marked(stage, words.len(), bits),
        ));
        let integers = block
            .words
            .iter()
            .map(|&word| format!("{:04x}", word as u16));
        texts.push((
            format!("{}.q15.hex", stage.name),
            marked(stage, words.len(), integers),
        ));
        entries.push(entry(stage, &words, &block));
    }
    let integer = integer_vectors(stages, &mut texts)?;
    let manifest = Manifest {
        conventions: CONVENTIONS,
        stages: entries,
        integer,
    };
    let json = serde_json::to_string_pretty(&manifest)
        .map_err(|e| Error::Data(format!("the manifest cannot be written: {e}")))?;
    texts.push(("manifest.json".into(), json + "\n"));
    Ok((manifest, texts))
}

fn entry(stage: &Stage, words: &[f32], block: &FixedPoint) -> Entry {
    let mut hasher = FnvHasher::default();
    for word in words {
        hasher.write(&word.to_bits().to_le_bytes());
    }
    Entry {
        name: stage.name.clone(),
        what: stage.what,
        axes: stage.axes,
        shape: stage.shape.clone(),
        number: match stage.values {
            Values::Real(_) => "float32",
            Values::Complex(_) => "complex64",
        },
        hash: format!("{:016x}", hasher.finish()),
        exponent: block.exponent,
        largest_error: block.largest_error,
        rms_error: block.rms_error,
        saturated: block.saturated,
    }
}

/// One line per word, with a comment at each index of the first axis.
fn marked(stage: &Stage, count: usize, words: impl Iterator<Item = String>) -> String {
    let frame = count / stage.shape[0].max(1);
    let mut text = format!("// {}: {}\n", stage.name, stage.what);
    for (i, word) in words.enumerate() {
        if i % frame.max(1) == 0 {
            text += &format!("// {} {}\n", stage.axes[0], i / frame.max(1));
        }
        text += &word;
        text.push('\n');
    }
    text
}

/// The vectors of DAS and of the covariance: the traced lines' samples, then the corners.
fn integer_vectors(stages: &[Stage], texts: &mut Vec<Text>) -> Result<Vec<Integer>> {
    let words_of = |name: &str| {
        let stage = stages.iter().find(|stage| stage.name == name);
        let missing = || Error::Data(format!("there is no stage {name}"));
        stage.map(|s| s.values.words()).ok_or_else(missing)
    };
    let focused = words_of("focused")?;
    let line = 2 * SAMPLES * ELEMENTS;
    let traced: Vec<f32> = TRACED
        .iter()
        .flat_map(|&k| focused[k * line..][..line].iter().copied())
        .collect();
    let block = quantise(&traced);
    let (words, _) = block.words.as_chunks::<2>();
    let (snapshots, _) = words.as_chunks::<ELEMENTS>();
    let mut vectors: Vec<[Word; ELEMENTS]> = snapshots.to_vec();
    let corners = corners();
    vectors.extend(&corners);
    let counts = [vectors.len(), corners.len()];

    let digits = |[re, im]: Word| format!("{:04x}{:04x}", re as u16, im as u16);
    let mut input = String::from("// 16 elements a vector: {re, im}\n");
    let (mut sums, mut products) = (
        String::from("// the mean of each vector: {re, im}\n"),
        String::from("// the forward covariance of each vector, i = 0..7, j = 0..i: {re, im}\n"),
    );
    let adaptive = Adaptive::new(LOADING);
    let mut lines =
        Program::ALL.map(|program| format!("// {program:?} of each vector: {{re, im}}\n"));
    for (k, vector) in vectors.iter().enumerate() {
        let of_sums = [&mut input, &mut sums, &mut products];
        for text in of_sums.into_iter().chain(&mut lines) {
            *text += &format!("// vector {k}\n");
        }
        for &word in vector {
            input += &(digits(word) + "\n");
        }
        sums += &(digits(das(vector)) + "\n");
        for (text, program) in lines.iter_mut().zip(Program::ALL) {
            let [re, im] = adaptive.z(program, vector);
            *text += &format!("{re:08x}{im:08x}\n");
        }
        for i in 0..SUBAPERTURE {
            for j in 0..=i {
                let [re, im] = covariance(vector, i, j).map(|part| part as u64 & 0xff_ffff_ffff);
                products += &format!("{re:010x}{im:010x}\n");
            }
        }
    }
    // Error of DAS from the integers.
    let z = words_of("line-das")?;
    let exact = TRACED
        .iter()
        .flat_map(|&k| z[2 * k * SAMPLES..][..2 * SAMPLES].iter().copied());
    let exact: Vec<f32> = exact.collect();
    let largest = exact.iter().fold(0.0f64, |a, &b| a.max(f64::from(b.abs())));
    let scale = libm::ldexp(1.0, block.exponent - 15);
    let means = vectors.iter().flat_map(das);
    let errors = means
        .zip(&exact)
        .map(|(mean, &z)| (f64::from(mean) * scale - f64::from(z)).abs() / largest);
    let worst = errors.fold(0.0, f64::max);
    let [rank1, mv, averages] = lines;
    for (name, text) in [
        (DAS[0], input.clone()),
        (DAS[1], sums),
        (COVARIANCE[0], input.clone()),
        (COVARIANCE[1], products),
        (MV[0], input),
        (MV[1], mv),
        (RANK1[1], rank1),
        ("mv.das.hex", averages),
    ] {
        texts.push((name.into(), text));
    }
    texts.extend(adaptive::tables());
    let (chain, aligned) = chain::vectors();
    texts.extend(chain);
    Ok(vec![
        Integer {
            files: DAS,
            what: "delay and sum of 16 words of 16 bits: (sum + 8) >> 4, in two's complement",
            vectors: counts,
            largest_error: Some(worst),
        },
        Integer {
            files: COVARIANCE,
            what: "the forward covariance's sums of products of 9 subapertures of 8 elements, exact in 40 \
                   bits, before scaling, time window and loading",
            vectors: counts,
            largest_error: None,
        },
        Integer {
            files: MV,
            what: "MV of 16 words by subapertures of 8, forward-backward, K = 0, by the program of solver.hex",
            vectors: counts,
            largest_error: Some(adaptive::largest_error(Program::Mv, &vectors, LOADING)?),
        },
        Integer {
            files: RANK1,
            what: "rank-1 ESMV of the same, by eight steps of power iteration",
            vectors: counts,
            largest_error: Some(adaptive::largest_error(Program::Rank1, &vectors, LOADING)?),
        },
        Integer {
            files: CHAIN,
            what: "lines from blocks of I/Q, by the registers of chain.lines.hex: MV, DAS and rank 1 in turn; the error of MV alone",
            vectors: [aligned.len(), 0],
            largest_error: Some(adaptive::largest_error(Program::Mv, &aligned, LOADING)?),
        },
    ])
}

/// Writes all files into `folder`, which is created.
///
/// # Errors
/// A folder or a file that cannot be written.
pub fn write(folder: &Path, stages: &[Stage]) -> Result<Manifest> {
    let (manifest, texts) = texts(stages)?;
    fs::create_dir_all(folder).map_err(|e| Error::File {
        path: folder.to_path_buf(),
        message: format!("cannot be made: {e}"),
    })?;
    temporary_files::remove_leftovers(folder);
    let mut outputs = Outputs::new();
    for stage in stages {
        let path = folder.join(format!("{}.npy", stage.name));
        let shape = IxDyn(&stage.shape);
        outputs.add(&path, |sink| {
            match &stage.values {
                Values::Real(values) => {
                    npy::write(&ArrayViewD::<f32>::from_shape(shape, values)?, sink)?;
                }
                Values::Complex(values) => {
                    npy::write(
                        &ArrayViewD::<Complex<f32>>::from_shape(shape, values)?,
                        sink,
                    )?;
                }
            }
            Ok(())
        })?;
    }
    for (name, text) in &texts {
        outputs.add(&folder.join(name), |sink| {
            Ok(sink.write_all(text.as_bytes())?)
        })?;
    }
    outputs.commit()?;
    Ok(manifest)
}
