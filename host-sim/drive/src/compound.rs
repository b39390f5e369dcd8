//! Many transmits compounded into lines, each record upsampled once.

use std::ops::Range;

use bonebeam::focus::{Compounding, Contribution, Delay, ScanLine, Upsampled};
use bonebeam::geometry::{Active, Array, Ray, Transmit};
use bonebeam::simd::{Task, Vector};
use num_complex::Complex;
use rayon::prelude::*;

use crate::Result;

/// Elements that a thread adds together: they read the transmits' parts of the places, which are too many for
/// any cache, once, and their records fit in the second one.
const TOGETHER: usize = 2;

/// What is compounded, into some lines.
pub(super) struct Compound<'a> {
    pub delay: &'a Delay,
    pub transmits: &'a [Transmit<'a>],
    /// What was recorded, checked, as [transmit, element, sample].
    pub rf: &'a [f32],
    pub array: Array<'a>,
    /// The lines.
    pub rays: &'a [Ray],
    /// The active elements of a line at an output sample; those deeper down include them.
    pub active: &'a (dyn Fn(usize, usize) -> Active + Sync),
    /// The aligned samples, [line, sample, element].
    pub x: &'a mut [Complex<f32>],
}

impl Compound<'_> {
    fn line(&self, transmit: usize, line: usize) -> ScanLine<'_> {
        let last = self.delay.parameters().output_samples - 1;
        ScanLine {
            transmit: self.transmits[transmit],
            ray: self.rays[line],
            array: self.array,
            active: (self.active)(line, last),
            compounding: Compounding::Replace,
        }
    }

    /// The first sample at which an element is active in a line, if there is one.
    fn first(&self, line: usize, element: usize) -> Option<usize> {
        let samples = self.delay.parameters().output_samples;
        let inactive = |sample| !range((self.active)(line, sample)).contains(&element);
        if inactive(samples - 1) {
            return None;
        }
        // Once active, it stays so.
        let (mut low, mut high) = (0, samples - 1);
        while low < high {
            let middle = (low + high) / 2;
            if inactive(middle) {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        Some(low)
    }

    /// The real parts of all elements, [element, line, value]: the mean over the transmits, added up in
    /// their order. Values of samples at which an element is not active are incomplete.
    fn values<V: Vector>(&self, zero: V, upsampled: &Upsampled<'_>) -> Result<Vec<f32>> {
        let p = self.delay.parameters();
        let (lines, length) = (self.rays.len(), upsampled.line_len());
        // All elements share them.
        let mut centres = vec![0; self.transmits.len() * lines * length];
        let places = centres.par_chunks_exact_mut(length).enumerate();
        places.try_for_each(|(k, places)| {
            upsampled.centre(&self.line(k / lines, k % lines), places)
        })?;
        let mut values = vec![0.0; p.elements * lines * length];
        let scale = 1.0 / self.transmits.len() as f32;
        let of_elements = values.par_chunks_mut(TOGETHER * lines * length);
        let record_len = upsampled.record_len();
        let memory = || {
            (
                vec![0; TOGETHER * lines * length],
                vec![0.0; upsampled.scratch_len()],
                vec![0.0; TOGETHER * record_len],
            )
        };
        let of_elements = of_elements.enumerate();
        of_elements.try_for_each_init(memory, |(lags, scratch, records), (group, values)| {
            let elements = group * TOGETHER..p.elements.min((group + 1) * TOGETHER);
            // [element, line], as the lags and the values.
            let mut first = Vec::with_capacity(elements.len() * lines);
            for element in elements.clone() {
                first.extend((0..lines).map(|line| self.first(line, element)));
            }
            for (k, lags) in lags.chunks_exact_mut(length).enumerate() {
                if first.get(k).is_some_and(Option::is_some) {
                    let (line, element) = (k % lines, elements.start + k / lines);
                    upsampled.lags(zero, &self.line(0, line), element, lags)?;
                }
            }
            for (transmit, centres) in centres.chunks_exact(lines * length).enumerate() {
                for (element, record) in elements.clone().zip(records.chunks_exact_mut(record_len))
                {
                    let row = (transmit * p.elements + element) * p.record_samples;
                    let samples = &self.rf[row..row + p.record_samples];
                    upsampled.record(zero, samples, scratch, record)?;
                }
                for (line, centre) in centres.chunks_exact(length).enumerate() {
                    for (element, record) in records.chunks_exact(record_len).enumerate() {
                        let own = element * lines + line;
                        let Some(&Some(first)) = first.get(own) else {
                            continue;
                        };
                        let contribution = Contribution {
                            record,
                            centre: &centre[first..],
                            lags: &lags[own * length..][first..length],
                        };
                        let values = &mut values[own * length..][first..length];
                        upsampled.add(zero, &contribution, values)?;
                    }
                }
            }
            for value in values {
                *value *= scale;
            }
            Ok::<(), bonebeam::Error>(())
        })?;
        Ok(values)
    }
}

impl Task for Compound<'_> {
    type Output = Result<()>;

    fn run<V: Vector>(mut self, zero: V) -> Self::Output {
        if self.rays.is_empty() {
            return Ok(());
        }
        let upsampled = Upsampled::new(self.delay)?;
        let values = self.values(zero, &upsampled)?;
        let x = std::mem::take(&mut self.x);
        let p = self.delay.parameters();
        let (lines, length) = (self.rays.len(), upsampled.line_len());
        let memory = || {
            (
                Vec::with_capacity(p.elements * length),
                vec![0.0; p.scratch_len(V::LANES)],
            )
        };
        x.par_chunks_exact_mut(p.output_samples * p.elements)
            .enumerate()
            .try_for_each_init(memory, |(own, scratch), (index, x)| {
                let line = self.line(0, index);
                own.clear();
                for element in range(line.active) {
                    let row = (element * lines + index) * length;
                    own.extend_from_slice(&values[row..row + length]);
                }
                upsampled.analytic(zero, &line, own, scratch, x)?;
                // What is not active is not complete.
                for (sample, row) in x.chunks_exact_mut(p.elements).enumerate() {
                    let active = range((self.active)(index, sample));
                    row[..active.start].fill(Complex::ZERO);
                    row[active.end..].fill(Complex::ZERO);
                }
                Ok(())
            })
    }
}

fn range(active: Active) -> Range<usize> {
    active.first..active.first + active.count
}
