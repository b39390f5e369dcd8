//! Raw samples: a constant, clipping, frames in which nothing oscillates.

use bonebeam_files::terminal::digits;
use bonebeam_files::{ChannelData, FrameSamples};
use ndarray::{ArrayView3, Axis};

use crate::finding::{Finding, Severity};

/// Mean of RF over its RMS from which it is reported.
const CONSTANT: f64 = 0.2;
/// Equal samples at the extreme that are a flat top.
const FLAT: usize = 2;
/// Flat tops of an element from which it is clipped.
const TOPS: usize = 3;

/// Checks the samples of the first frame; also the variance of each element's samples, times a constant.
pub(crate) fn check(data: &ChannelData) -> (Vec<Finding>, Vec<f64>) {
    match data.samples.frame(0) {
        Some(FrameSamples::Rf(rf)) => of_frame(rf, |v| [f64::from(v); 2], true),
        Some(FrameSamples::Counts(rf)) => of_frame(rf, |v| [f64::from(v); 2], true),
        Some(FrameSamples::Iq { iq, .. }) => {
            of_frame(iq, |v| [f64::from(v.re), f64::from(v.im)], false)
        }
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
        let (mut extremes, mut own) = ([0.0f64; 2], [0.0; 2]);
        for &value in of_element {
            let [a, b] = parts(value);
            own = [own[0] + a, own[1] + a * a];
            least = least.min(a);
            extremes = [extremes[0].min(a.min(b)), extremes[1].max(a.max(b))];
        }
        sum += own[0];
        squares += own[1];
        power.push(own[1] - own[0] * own[0] / (transmits * samples).max(1) as f64);
        let mut tops = 0;
        for part in 0..if rf { 1 } else { 2 } {
            for row in rows() {
                let mut run = 0;
                for &value in row {
                    let value = parts(value)[part];
                    let flat = value != 0.0 && extremes.contains(&value);
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
