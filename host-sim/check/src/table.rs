//! Echoes aligned on lines, as correlations of neighbouring elements and of neighbouring transmits.
//!
//! All checks of geometry read these tables: an echo that is aligned right has the same phase at neighbours.

use std::f64::consts::TAU;

use bonebeam_files::{ChannelData, Transmits};
use num_complex::Complex;
use rayon::prelude::*;

use crate::base::Base;

/// Elements to either side that an element is compared with.
pub(crate) const NEAR: usize = 4;
/// Subapertures of the aligned elements, side by side.
const PARTS: usize = 4;
/// Receive f-number of the aligned elements.
const F_NUMBER: f64 = 1.2;
/// Least number of aligned elements.
const LEAST: usize = 8;
/// Samples of a block along a line, one per period of the carrier in two-way time.
const BLOCK: usize = 16;
/// Largest number of lines, and of transmits that are read.
pub(crate) const LINES: usize = 24;
/// Angle from the first line of a sector to the last, rad.
const SECTOR: f64 = 1.2;
/// Pitch in wavelengths below which lines of virtual sources fan out.
const PHASED: f64 = 0.7;

/// One transmit wave, by the values that [`Transmits`] has of it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Wave {
    /// On its own line: the distance along it over c.
    Own,
    Plane(f64),
    Source([f64; 2]),
    Element(usize),
    Delays(Vec<f64>),
}

/// A straight line from the array.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub from: [f64; 2],
    pub angle: f64,
}

impl Line {
    pub fn at(&self, r: f64) -> [f64; 2] {
        let (sin, cos) = self.angle.sin_cos();
        [self.from[0] + r * sin, self.from[1] + r * cos]
    }

    /// Distance of a point from the line.
    fn beside(&self, [x, z]: [f64; 2]) -> f64 {
        let (sin, cos) = self.angle.sin_cos();
        ((x - self.from[0]) * cos - (z - self.from[1]) * sin).abs()
    }
}

/// The line across the array from an element with neighbours on both sides.
fn normal(elements: &[[f64; 2]], m: usize) -> Line {
    let [a, b] = [elements[m - 1], elements[m + 1]];
    Line {
        from: elements[m],
        angle: (a[1] - b[1]).atan2(b[0] - a[0]),
    }
}

/// Geometry of a recording as its keys have it, or as an alternative has it.
#[derive(Clone, Debug)]
pub(crate) struct View {
    pub elements: Vec<[f64; 2]>,
    /// Row of the records of each element.
    pub order: Vec<usize>,
    pub waves: Vec<Wave>,
    /// Factor of each transmit: 0 leaves it out.
    pub signs: Vec<f32>,
    pub lines: Vec<Line>,
    /// Every how many of them are read.
    pub every: usize,
    /// Whether each transmit has its own line.
    pub own: bool,
    pub c: f64,
    /// Later than the record's times by this, s: a lens, there and back, or an alternative of time zero.
    pub late: f64,
    /// The carrier's sign in I/Q.
    pub conjugate: bool,
    pub f_number: f64,
    /// Delays of tissue before the elements, s.
    pub screen: Vec<f64>,
    /// Elements that are left out.
    pub without: Vec<usize>,
}

/// The transmits that are read: all, or at most so many evenly from the list.
pub(crate) fn chosen(count: usize, most: usize) -> Vec<usize> {
    let kept = count.min(most);
    let step = (count.max(1) - 1) as f64 / (kept.max(2) - 1) as f64;
    let mut chosen: Vec<usize> = (0..kept)
        .map(|k| (k as f64 * step).round() as usize)
        .collect();
    chosen.dedup();
    chosen
}

impl View {
    /// The geometry of some transmits of a recording.
    pub fn new(data: &ChannelData, transmits: &[usize]) -> Self {
        let count = data.element_x.len();
        let elements: Vec<[f64; 2]> = (0..count).map(|m| data.element(m)).collect();
        let (first, last) = (elements[0], elements[count - 1]);
        let middle = [(first[0] + last[0]) / 2.0, 0.0];
        let phased = data.is_straight() && data.pitch() < PHASED * data.c / data.f0;
        let own_sources = match &data.transmits {
            Transmits::VirtualSource { x, z } => {
                x.len() > 1 && z.iter().all(|&z| z > 0.0) && x.windows(2).all(|x| x[0] != x[1])
            }
            _ => false,
        };
        let waves: Vec<Wave> = transmits
            .iter()
            .map(|&t| match &data.transmits {
                Transmits::Focused { .. } => Wave::Own,
                Transmits::Plane { angle } => Wave::Plane(angle[t]),
                Transmits::Element { index } => Wave::Element(index[t]),
                Transmits::VirtualSource { x, z } => Wave::Source([x[t], z[t]]),
                Transmits::Delays { delay } => Wave::Delays(delay.row(t).to_vec()),
            })
            .collect();
        let down = |x: f64| Line {
            from: [x, 0.0],
            angle: 0.0,
        };
        let share = |k: usize| (k as f64 + 0.5) / LINES as f64;
        let lines = match &data.transmits {
            Transmits::Focused { x, .. } => transmits.iter().map(|&t| down(x[t])).collect(),
            Transmits::VirtualSource { x, z } if own_sources => transmits
                .iter()
                .map(|&t| match phased {
                    true => Line {
                        from: middle,
                        angle: (x[t] - middle[0]).atan2(z[t]),
                    },
                    false if data.is_straight() => down(x[t]),
                    false => (1..count - 1)
                        .map(|m| normal(&elements, m))
                        .min_by(|a, b| a.beside([x[t], z[t]]).total_cmp(&b.beside([x[t], z[t]])))
                        .unwrap_or(down(x[t])),
                })
                .collect(),
            Transmits::VirtualSource { .. } if phased => (0..LINES)
                .map(|k| Line {
                    from: middle,
                    angle: (share(k) - 0.5) * SECTOR,
                })
                .collect(),
            _ if data.is_straight() => (0..LINES)
                .map(|k| down(first[0] + share(k) * (last[0] - first[0])))
                .collect(),
            _ => (0..LINES)
                .map(|k| normal(&elements, 1 + (share(k) * (count - 3) as f64) as usize))
                .collect(),
        };
        View {
            order: (0..count).collect(),
            elements,
            signs: vec![1.0; waves.len()],
            waves,
            lines,
            every: 1,
            own: own_sources || matches!(data.transmits, Transmits::Focused { .. }),
            c: data.c,
            late: 2.0 * data.lens_delay,
            conjugate: false,
            f_number: F_NUMBER,
            screen: vec![0.0; count],
            without: Vec::new(),
        }
    }

    /// Time at which a wave reaches the distance `r` along a line, s.
    pub fn arrival(&self, wave: &Wave, line: &Line, r: f64) -> f64 {
        let p = line.at(r);
        let from = |s: [f64; 2]| (p[0] - s[0]).hypot(p[1] - s[1]);
        let path = match wave {
            Wave::Own => r,
            Wave::Plane(angle) => p[0] * angle.sin() + p[1] * angle.cos(),
            Wave::Source(s) if s[1] > 0.0 => {
                let range = s[0].hypot(s[1]);
                range + if p[1] < s[1] { -from(*s) } else { from(*s) }
            }
            Wave::Source(s) => from(*s) - s[0].hypot(s[1]),
            Wave::Element(m) => from(self.elements[*m]),
            Wave::Delays(delays) => {
                let each = delays.iter().zip(&self.elements);
                let each = each.filter(|(delay, _)| delay.is_finite());
                let each = each.map(|(delay, &at)| delay * self.c + from(at));
                each.fold(f64::INFINITY, f64::min)
            }
        };
        path / self.c + self.crossing(wave, p).map_or(0.0, |m| self.screen_at(m))
    }

    /// Where a wave to a point crosses the array, in elements.
    pub fn crossing(&self, wave: &Wave, [x, z]: [f64; 2]) -> Option<f64> {
        let (first, last) = (self.elements[0], self.elements[self.elements.len() - 1]);
        let at = |x: f64| {
            let share = (x - first[0]) / (last[0] - first[0]);
            ((self.elements.len() - 1) as f64 * share.clamp(0.0, 1.0)).into()
        };
        match wave {
            Wave::Element(m) => Some(*m as f64),
            Wave::Plane(angle) => at(x - z * angle.tan()),
            Wave::Source([sx, sz]) if *sz < 0.0 => at(sx + (x - sx) * sz / (sz - z)),
            _ => None,
        }
    }

    fn screen_at(&self, m: f64) -> f64 {
        let low = (m as usize).min(self.screen.len().saturating_sub(2));
        let part = m - low as f64;
        self.screen[low] * (1.0 - part) + self.screen[low + 1] * part
    }

    /// Receive delay of an element from the distance `c·time` along a line, s.
    pub fn receive(&self, line: &Line, time: f64, element: usize, c: f64) -> f64 {
        let ([x, z], [ex, ez]) = (line.at(c * time), self.elements[element]);
        (x - ex).hypot(z - ez) / c
    }

    /// From an element near a position to the next, m.
    pub fn pitch_at(&self, from: [f64; 2]) -> [f64; 2] {
        let away = |m: usize| {
            let [x, z] = self.elements[m];
            (x - from[0]).hypot(z - from[1])
        };
        let nearest = (1..self.elements.len() - 1).min_by(|&a, &b| away(a).total_cmp(&away(b)));
        let nearest = nearest.unwrap_or(1);
        let [a, b] = [self.elements[nearest - 1], self.elements[nearest + 1]];
        [(b[0] - a[0]) / 2.0, (b[1] - a[1]) / 2.0]
    }

    /// Elements within the aperture of a line at the distance `r`.
    fn active(&self, line: &Line, r: f64) -> std::ops::Range<usize> {
        let across = |m: usize| line.beside(self.elements[m]);
        let count = self.elements.len();
        let nearest = (0..count).min_by(|&a, &b| across(a).total_cmp(&across(b)));
        let nearest = nearest.unwrap_or(0);
        let half = 0.5 * r / self.f_number;
        let inside = |m: &usize| across(*m) <= half;
        let first = (0..count).find(inside).unwrap_or(nearest);
        let last = (0..count).rev().find(inside).unwrap_or(nearest);
        first.min(nearest.saturating_sub(LEAST / 2))
            ..(last + 1).max((nearest + LEAST / 2).min(count))
    }
}

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

    /// Mean coherence of neighbouring elements, −1 to 1.
    pub fn coherence(&self) -> f64 {
        coherence(&self.blocks)
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
            let sums = block.parts.iter().fold([0.0; 2], |[shared, all], part| {
                [shared + part.product.re, all + part.power]
            });
            f64::from(sums[0] / sums[1].max(f32::MIN_POSITIVE))
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

/// Strong echoes count more, by the root of their power.
fn coherence(blocks: &[Block]) -> f64 {
    let (mut shared, mut all) = (0.0, 0.0);
    for block in blocks {
        let power = block.total();
        if power > 0.0 {
            shared += f64::from(block.next().re) / power.sqrt();
            all += power.sqrt();
        }
    }
    if all > 0.0 { shared / all } else { 0.0 }
}

/// The same of subapertures, which see best from where echoes come.
fn of_parts(blocks: &[Block]) -> f64 {
    let (mut shared, mut all) = (0.0, 0.0);
    for block in blocks {
        let power: f32 = block.parts.iter().map(|part| part.power).sum();
        if power > 0.0 {
            let product: f32 = block.parts.iter().map(|part| part.product.re).sum();
            shared += f64::from(product / power.sqrt());
            all += f64::from(power.sqrt());
        }
    }
    if all > 0.0 { shared / all } else { 0.0 }
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
