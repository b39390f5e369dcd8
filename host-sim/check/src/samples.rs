//! Raw samples: a constant, clipping, frames in which nothing oscillates.

use bonebeam_files::terminal::digits;
use bonebeam_files::{ChannelData, FrameSamples};
use ndarray::{ArrayView2, ArrayView3, Axis};
use num_complex::Complex;
use rayon::prelude::*;

use crate::finding::{Finding, Severity};

/// Mean of RF over its RMS from which it is reported.
const CONSTANT: f64 = 0.2;
/// Equal samples at the extreme that are a flat top.
const FLAT: usize = 2;
/// Flat tops of an element from which it is clipped.
const TOPS: usize = 3;
/// Samples that are summed side by side.
const SIDE: usize = 8;

/// Sums and extremes of an element's samples.
struct Moments {
    /// Of the samples, of I/Q of their real parts, and of their squares.
    sums: [f64; 2],
    least: f64,
    extremes: [f64; 2],
    count: usize,
}

impl Moments {
    fn of<T: Copy>(samples: ArrayView2<'_, T>, parts: impl Fn(T) -> [f64; 2]) -> Self {
        let (mut sums, mut squares) = ([0.0; SIDE], [0.0; SIDE]);
        let (mut least, mut lowest, mut highest) =
            ([f64::INFINITY; SIDE], [0.0; SIDE], [0.0; SIDE]);
        let mut add = |side: usize, value: T| {
            let [a, b] = parts(value);
            sums[side] += a;
            squares[side] += a * a;
            least[side] = a.min(least[side]);
            lowest[side] = a.min(b).min(lowest[side]);
            highest[side] = a.max(b).max(highest[side]);
        };
        for row in samples.rows() {
            let row = row.as_standard_layout();
            let (parts, rest) = row.as_slice().unwrap_or_default().as_chunks::<SIDE>();
            for part in parts {
                (0..SIDE).for_each(|side| add(side, part[side]));
            }
            rest.iter()
                .enumerate()
                .for_each(|(side, &value)| add(side, value));
        }
        Moments {
            sums: [sums, squares].map(|sums| sums.iter().sum()),
            least: least.into_iter().fold(f64::INFINITY, f64::min),
            extremes: [
                lowest.into_iter().fold(0.0, f64::min),
                highest.into_iter().fold(0.0, f64::max),
            ],
            count: samples.len(),
        }
    }

    /// Variance, times a constant.
    fn power(&self) -> f64 {
        let [sum, squares] = self.sums;
        squares - sum * sum / self.count.max(1) as f64
    }
}

fn real<T: Into<f64>>(value: T) -> [f64; 2] {
    [value.into(); 2]
}

fn both(value: Complex<f32>) -> [f64; 2] {
    [f64::from(value.re), f64::from(value.im)]
}

/// The variance of each element's samples in the first frame, times a constant.
pub(crate) fn power(data: &ChannelData) -> Vec<f64> {
    fn of<T: Copy + Sync>(
        frame: ArrayView3<'_, T>,
        parts: impl Fn(T) -> [f64; 2] + Sync,
    ) -> Vec<f64> {
        let of_element = |m| Moments::of(frame.index_axis(Axis(1), m), &parts).power();
        (0..frame.dim().1).into_par_iter().map(of_element).collect()
    }
    match data.samples.frame(0) {
        Some(FrameSamples::Rf(rf)) => of(rf, real),
        Some(FrameSamples::Counts(rf)) => of(rf, real),
        Some(FrameSamples::Iq { iq, .. }) => of(iq, both),
        None => vec![0.0; data.element_x.len()],
    }
}

/// Checks the samples of the first frame; also the variance of each element's samples, times a constant.
pub(crate) fn check(data: &ChannelData) -> (Vec<Finding>, Vec<f64>) {
    match data.samples.frame(0) {
        Some(FrameSamples::Rf(rf)) => of_frame(rf, real, true),
        Some(FrameSamples::Counts(rf)) => of_frame(rf, real, true),
        Some(FrameSamples::Iq { iq, .. }) => of_frame(iq, both, false),
        None => (Vec::new(), vec![0.0; data.element_x.len()]),
    }
}

fn of_frame<T: Copy>(
    frame: ArrayView3<'_, T>,
    parts: impl Fn(T) -> [f64; 2],
    rf: bool,
) -> (Vec<Finding>, Vec<f64>) {
    let (transmits, elements, samples) = frame.dim();
    let mut findings = Vec::new();
    let (mut sum, mut squares, mut least) = (0.0, 0.0, f64::INFINITY);
    let (mut clipped, mut power) = (Vec::new(), Vec::new());
    let mut share = 0;
    for m in 0..elements {
        let of_element = frame.index_axis(Axis(1), m);
        let rows = || of_element.outer_iter();
        let own = Moments::of(of_element, &parts);
        least = least.min(own.least);
        sum += own.sums[0];
        squares += own.sums[1];
        power.push(own.power());
        let mut tops = 0;
        for part in 0..if rf { 1 } else { 2 } {
            for row in rows() {
                let mut run = 0;
                for &value in row {
                    let value = parts(value)[part];
                    let flat = value != 0.0 && own.extremes.contains(&value);
                    run = if flat { run + 1 } else { 0 };
                    tops += usize::from(run == FLAT);
                    share += usize::from(run >= FLAT);
                }
            }
        }
        if tops >= TOPS {
            clipped.push(m);
        }
    }
    let count = (transmits * elements * samples).max(1) as f64;
    let mean = sum / count;
    let rms = (squares / count - mean * mean).max(0.0).sqrt();
    if rf && least < 0.0 && mean.abs() > CONSTANT * rms {
        let text = format!(
            "the samples have a mean of {}, {} times their RMS",
            digits(mean),
            digits(mean.abs() / rms)
        );
        findings.push(
            Finding::new("constant", Severity::Warning, text)
                .valued(mean, "")
                .remedy("subtract the mean, or the converter's zero, from rf"),
        );
    }
    let permille = 1e3 * share as f64 / count;
    if 8 * clipped.len() > elements {
        let text = format!(
            "{} of {elements} elements have flat tops at their largest sample: the receiver clips",
            clipped.len()
        );
        let finding =
            Finding::new("clipped", Severity::Warning, text).valued(permille, "per mille");
        findings.push(finding.remedy("record with less gain"));
    } else if !clipped.is_empty() {
        let text = format!("flat tops at the largest sample of {}", listed(&clipped));
        let finding = Finding::new("saturated", Severity::Warning, text)
            .valued(clipped.len() as f64, "elements");
        findings.push(finding.remedy("record with less gain, or set these elements of rf to 0"));
    }
    (findings, power)
}

/// A short list of elements.
pub(crate) fn listed(elements: &[usize]) -> String {
    let first: Vec<String> = elements.iter().take(8).map(usize::to_string).collect();
    let (s, more) = (
        if elements.len() == 1 { "" } else { "s" },
        if elements.len() > 8 { ", …" } else { "" },
    );
    format!("element{s} {}{more}", first.join(", "))
}
