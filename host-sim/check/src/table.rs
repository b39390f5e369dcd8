//! Echoes aligned on lines, as correlations of neighbouring elements and of neighbouring transmits.
//!
//! All checks of geometry read these tables: an echo that is aligned right has the same phase at neighbours.

use std::f64::consts::TAU;

use num_complex::Complex;
use rayon::prelude::*;

use crate::base::Base;
use crate::view::View;

/// Elements to either side that an element is compared with.
pub(crate) const NEAR: usize = 4;
/// Subapertures of the aligned elements, side by side.
const PARTS: usize = 4;
/// Samples of a block along a line, one per period of the carrier in two-way time.
const BLOCK: usize = 16;

/// Sums of the elements from `first` on, and of as many after them.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub first: usize,
    pub elements: usize,
    /// Their correlation.
    pub product: Complex<f32>,
    /// Their mean power.
    pub power: f32,
}

/// A part of a line.
pub(crate) struct Block {
    pub line: usize,
    /// One-way time of its middle, s.
    pub time: f64,
    /// Power of each element.
    pub power: Vec<f32>,
    /// Correlation of each element with those 1, 2, … elements further.
    pub lags: [Vec<Complex<f32>>; NEAR],
    /// Subapertures, focused, and each with the one beside it.
    pub parts: Vec<Part>,
    /// Correlation of each transmit with the next, both focused on receive; and their power.
    pub transmits: Vec<(Complex<f32>, f32)>,
}

impl Block {
    /// Correlation of neighbours, all over the aperture.
    pub fn next(&self) -> Complex<f32> {
        self.lags[0].iter().sum()
    }

    /// Correlation of each element with the sum of those nearby, in the direction of the echoes; and that sum's power.
    pub fn near(&self) -> Vec<(Complex<f32>, f32)> {
        let next = self.next();
        let tilt = if next.norm() > 0.0 {
            next / next.norm()
        } else {
            next
        };
        let mut near = vec![(Complex::default(), 0.0); self.power.len()];
        let mut turn = Complex::from(1.0);
        for (lag, products) in (1..).zip(&self.lags) {
            turn *= tilt;
            for m in 0..self.power.len().saturating_sub(lag) {
                let product = products[m] * turn.conj();
                near[m].0 += product.conj();
                near[m + lag].0 += product;
                near[m].1 += self.power[m + lag];
                near[m + lag].1 += self.power[m];
            }
        }
        near
    }

    /// Sums of subapertures' products, their real parts, and of their powers.
    fn of_parts(&self) -> [f32; 2] {
        self.parts.iter().fold([0.0; 2], |[product, power], part| {
            [product + part.product.re, power + part.power]
        })
    }

    /// Power of all elements.
    pub fn total(&self) -> f64 {
        f64::from(self.power.iter().sum::<f32>())
    }
}

/// Correlations of all blocks.
pub(crate) struct Table {
    pub blocks: Vec<Block>,
    /// Of neighbouring compounded transmits, focused on receive: sums of products and powers.
    pub transmits: Vec<(Complex<f64>, f64)>,
    /// Mean frequency of the focused echoes, Hz.
    pub frequency: f64,
}

impl Table {
    /// Aligns the records as `view` has them.
    pub fn new(base: &Base, view: &View) -> Self {
        let lines = view.lines.len();
        let found: Vec<_> = (0..lines.div_ceil(view.every))
            .into_par_iter()
            .map(|line| of_line(base, view, line * view.every))
            .collect();
        let mut table = Table {
            blocks: Vec::new(),
            transmits: vec![Default::default(); view.waves.len().saturating_sub(1)],
            frequency: base.carrier,
        };
        let mut turn = Complex::<f64>::default();
        for (blocks, turned) in found {
            for block in &blocks {
                for (sum, (product, power)) in table.transmits.iter_mut().zip(&block.transmits) {
                    sum.0 += Complex::new(f64::from(product.re), f64::from(product.im));
                    sum.1 += f64::from(*power);
                }
            }
            table.blocks.extend(blocks);
            turn += turned;
        }
        table.frequency *= 1.0 + turn.arg() / TAU;
        table
    }

    /// Mean coherence of neighbouring transmits; `None` of a single one, or if each has its line.
    pub fn transmit_coherence(&self) -> Option<f64> {
        transmit_coherence(&self.blocks)
    }

    /// How well each transmit agrees with the neighbour that it agrees with better; on a line of its own, its elements
    /// and its subapertures.
    pub fn agreements(&self, view: &View) -> Vec<f64> {
        let mut found = vec![0.0; view.waves.len()];
        if view.own {
            for blocks in self.blocks.chunk_by(|a, b| a.line == b.line) {
                found[blocks[0].line] = coherence(blocks) + of_parts(blocks);
            }
        }
        for (t, (product, power)) in self.transmits.iter().enumerate() {
            if *power > 0.0 {
                found[t] = (product.re / power).max(found[t]);
                found[t + 1] = product.re / power;
            }
        }
        found
    }

    /// Power of the echoes that neighbouring elements have in common, also of those beside the lines.
    pub fn coherent_power(&self) -> f64 {
        let of = |block: &Block| f64::from(block.next().norm());
        self.blocks.iter().map(of).sum::<f64>() / self.blocks.len().max(1) as f64
    }

    /// Power that subapertures have in common, also of echoes beside the lines.
    pub fn focus(&self) -> f64 {
        let of = |block: &Block| {
            let sum: Complex<f32> = block.parts.iter().map(|part| part.product).sum();
            f64::from(sum.norm())
        };
        self.blocks.iter().map(of).sum()
    }

    /// The coherence of elements and of transmits, by which alternatives are compared.
    pub fn score(&self) -> f64 {
        score(&self.blocks)
    }

    /// The mean coherence of subapertures on each line.
    pub fn focused(&self) -> Vec<f64> {
        let of = |block: &Block| {
            let [product, power] = block.of_parts();
            f64::from(product / power.max(f32::MIN_POSITIVE))
        };
        let lines = self.blocks.chunk_by(|a, b| a.line == b.line);
        let mean = |line: &[Block]| line.iter().map(of).sum::<f64>() / line.len() as f64;
        lines.map(mean).collect()
    }
}

/// The mean of the differences of two rows, in its standard deviations.
pub(crate) fn sureness(values: &[f64], others: &[f64]) -> f64 {
    let gains: Vec<f64> = values.iter().zip(others).map(|(a, b)| a - b).collect();
    let count = gains.len() as f64;
    let mean = gains.iter().sum::<f64>() / count;
    let squares: f64 = gains.iter().map(|gain| (gain - mean).powi(2)).sum();
    let deviation = (squares / (count - 1.0) / count).sqrt();
    if deviation > 0.0 {
        mean / deviation
    } else {
        0.0
    }
}

/// The mean of products over powers. Strong echoes count more, by the root of their power.
fn mean(blocks: &[Block], of: impl Fn(&Block) -> (f64, f64)) -> f64 {
    let (mut shared, mut all) = (0.0, 0.0);
    for (product, power) in blocks.iter().map(of).filter(|(_, power)| *power > 0.0) {
        shared += product / power.sqrt();
        all += power.sqrt();
    }
    if all > 0.0 { shared / all } else { 0.0 }
}

fn coherence(blocks: &[Block]) -> f64 {
    mean(blocks, |block| (f64::from(block.next().re), block.total()))
}

/// The same of subapertures, which see best from where echoes come.
fn of_parts(blocks: &[Block]) -> f64 {
    mean(blocks, |block| {
        let [product, power] = block.of_parts();
        (product.into(), power.into())
    })
}

fn transmit_coherence(blocks: &[Block]) -> Option<f64> {
    let (mut shared, mut all) = (0.0, 0.0);
    for (product, power) in blocks.iter().flat_map(|block| &block.transmits) {
        shared += f64::from(product.re);
        all += f64::from(*power);
    }
    (all > 0.0).then(|| shared / all)
}

fn score(blocks: &[Block]) -> f64 {
    coherence(blocks) + transmit_coherence(blocks).unwrap_or(0.0)
}

fn parts(active: &std::ops::Range<usize>) -> Vec<Part> {
    let elements = (active.len() / PARTS).max(2);
    let last = (active.end + 1).saturating_sub(2 * elements);
    let firsts = (active.start..last).step_by(elements / 2);
    firsts
        .map(|first| Part {
            first,
            elements,
            product: Complex::default(),
            power: 0.0,
        })
        .collect()
}

/// The phase of some cycles, times a factor.
fn turned(cycles: f64, factor: f32) -> Complex<f32> {
    Complex::from_polar(factor, (TAU * (cycles - cycles.floor())) as f32)
}

type OfLine = (Vec<Block>, Complex<f64>);

fn of_line(base: &Base, view: &View, line: usize) -> OfLine {
    let (_, count, length) = base.z.dim();
    let rate = base.rate;
    let step = 0.5 / base.carrier;
    let own = if view.own {
        line..line + 1
    } else {
        0..view.waves.len()
    };
    let own: Vec<usize> = own.filter(|&t| view.signs[t] != 0.0).collect();
    if own.is_empty() {
        return OfLine::default();
    }
    let starts: Vec<f64> = (0..base.t0.len()).map(|t| base.t0[t] - view.late).collect();
    let last_time =
        starts.iter().fold(f64::NEG_INFINITY, |a, &b| a.max(b)) + (length.max(1) - 1) as f64 / rate;
    let first_time = starts.iter().fold(f64::INFINITY, |a, &b| a.min(b));
    let from = (first_time / 2.0).max(3e-3 / view.c);
    let samples = ((last_time / 2.0 - from) / step).max(0.0) as usize;
    let rays = view.lines[line];
    let mut blocks = Vec::new();
    let mut turn = Complex::<f64>::default();
    let mut aligned = vec![Complex::<f32>::default(); count];
    let mut sums = vec![Complex::<f32>::default(); view.waves.len()];
    let mut until = vec![Complex::<f32>::default(); count + 1];
    let mut received = vec![(0.0, Complex::<f32>::default()); count];
    let records = base.z.as_slice().expect("records in order");
    let last = (length.max(1) - 1) as f64;
    for first in (0..samples.saturating_sub(BLOCK - 1)).step_by(BLOCK) {
        let middle = from + (first as f64 + 0.5 * (BLOCK - 1) as f64) * step;
        let active = view.active(&rays, view.c * middle);
        let mut block = Block {
            line,
            time: middle,
            power: vec![0.0; count],
            lags: std::array::from_fn(|_| vec![Complex::default(); count]),
            parts: parts(&active),
            transmits: vec![Default::default(); view.waves.len().saturating_sub(1)],
        };
        let mut before = Complex::<f32>::default();
        for n in first..first + BLOCK {
            let time = from + n as f64 * step;
            aligned.fill(Complex::default());
            sums.fill(Complex::default());
            // Delay and phase are sums of the way there and the way back.
            for m in active.clone() {
                if view.without.contains(&m) {
                    received[m] = (0.0, Complex::default());
                    continue;
                }
                let back = view.receive(&rays, time, m, view.c) + view.screen[m];
                received[m] = (back * rate, turned(base.carrier * back, 1.0));
            }
            for &t in &own {
                let arrival = view.arrival(&view.waves[t], &rays, view.c * time);
                let start = (arrival - starts[t]) * rate;
                let there = turned(base.carrier * (arrival + view.late), view.signs[t]);
                let records = &records[t * count * length..];
                for m in active.clone() {
                    let (back, phase) = received[m];
                    let position = start + back;
                    if !(position >= 0.0 && position < last) {
                        continue;
                    }
                    let whole = position as usize;
                    let from = view.order[m] * length + whole;
                    let [a, b] = [records[from], records[from + 1]];
                    let mut value = a + (b - a) * (position - whole as f64) as f32;
                    if view.conjugate {
                        value = value.conj();
                    }
                    value *= phase * there;
                    aligned[m] += value;
                    sums[t] += value;
                }
            }
            if !view.own {
                for (pair, sum) in block.transmits.iter_mut().zip(sums.windows(2)) {
                    pair.0 += sum[1] * sum[0].conj();
                    pair.1 += (sum[0].norm_sqr() + sum[1].norm_sqr()) / 2.0;
                }
            }
            let all: Complex<f32> = aligned.iter().sum();
            let product = all * before.conj();
            turn += Complex::new(f64::from(product.re), f64::from(product.im));
            before = all;
            let mut sum = Complex::default();
            for (before, value) in until.iter_mut().zip(&aligned) {
                *before = sum;
                sum += value;
            }
            until[count] = sum;
            for part in &mut block.parts {
                let middle = part.first + part.elements;
                let a = until[middle] - until[part.first];
                let b = until[middle + part.elements] - until[middle];
                part.product += b * a.conj();
                part.power += (a.norm_sqr() + b.norm_sqr()) / 2.0;
            }
            for m in active.clone() {
                block.power[m] += aligned[m].norm_sqr();
                for (lag, sums) in (1..).zip(&mut block.lags) {
                    if m + lag < active.end {
                        sums[m] += aligned[m + lag] * aligned[m].conj();
                    }
                }
            }
        }
        blocks.push(block);
    }
    (blocks, turn)
}
