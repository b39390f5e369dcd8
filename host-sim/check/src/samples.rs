//! Raw samples: a constant, clipping, frames in which nothing oscillates.

use bonebeam_files::terminal::digits;
use bonebeam_files::{ChannelData, FrameSamples, Survey};
use ndarray::{ArrayView3, Axis};
use num_complex::Complex;

use crate::finding::{Finding, Severity};

/// Mean of RF over its RMS from which it is reported.
const CONSTANT: f64 = 0.2;
/// Equal samples at the extreme that are a flat top.
const FLAT: usize = 2;
/// Flat tops of an element from which it is clipped.
const TOPS: usize = 3;
fn real<T: Into<f64>>(value: T) -> [f64; 2] {
    [value.into(); 2]
}

fn both(value: Complex<f32>) -> [f64; 2] {
    [f64::from(value.re), f64::from(value.im)]
}

/// Checks the samples of the first frame.
pub(crate) fn check(data: &ChannelData, survey: &Survey) -> Vec<Finding> {
    match data.samples.frame(0) {
        Some(FrameSamples::Rf(rf)) => of_frame(rf, survey, real, true),
        Some(FrameSamples::Counts(rf)) => of_frame(rf, survey, real, true),
        Some(FrameSamples::Iq { iq, .. }) => of_frame(iq, survey, both, false),
        Some(FrameSamples::Stored(_)) | None => Vec::new(),
    }
}

fn of_frame<T: Copy>(
    frame: ArrayView3<'_, T>,
    survey: &Survey,
    parts: impl Fn(T) -> [f64; 2],
    rf: bool,
) -> Vec<Finding> {
    let (transmits, elements, samples) = frame.dim();
    let mut findings = Vec::new();
    let (mut sum, mut squares, mut least) = (0.0, 0.0, f64::INFINITY);
    let (mut clipped, mut share) = (Vec::new(), 0);
    for (m, own) in survey.elements.iter().enumerate() {
        let of_element = frame.index_axis(Axis(1), m);
        let rows = || of_element.outer_iter();
        least = least.min(own.least);
        sum += own.sums[0];
        squares += own.sums[1];
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
    findings
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
