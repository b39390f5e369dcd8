//! What one pass over the samples of a frame tells of mistakes.

use ndarray::{ArrayView1, ArrayView2};
use num_complex::Complex;
use rayon::prelude::*;

/// Samples that are summed side by side.
const SIDE: usize = 8;
/// Largest number of records that are kept.
const KEPT: usize = 64;

/// What is known of an element's samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Moments {
    /// Sums of the samples, of I/Q of their real parts, and of their squares.
    pub sums: [f64; 2],
    /// The smallest of these.
    pub least: f64,
    /// The smallest and the largest of the samples' parts and 0.
    pub extremes: [f64; 2],
    count: usize,
    /// Whether a record is not constant.
    changes: bool,
    /// Sum of each sample of I/Q times the conjugate of the one before.
    turn: Complex<f64>,
}

/// What is known of the samples of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Survey {
    /// Of each element.
    pub elements: Vec<Moments>,
    /// Largest number of elements that recorded a transmit.
    pub(super) most_receivers: usize,
    /// Every how many records of RF are kept, the number of those passed, and those kept.
    every: usize,
    passed: usize,
    records: Vec<Vec<f32>>,
}

impl Moments {
    /// Adds a record; returns whether it has samples other than 0.
    fn add<T: Copy + PartialEq + Default>(
        &mut self,
        row: ArrayView1<'_, T>,
        parts: impl Fn(T) -> [f64; 2],
    ) -> bool {
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
        let row = row.as_standard_layout();
        let row = row.as_slice().unwrap_or_default();
        let (whole, rest) = row.as_chunks::<SIDE>();
        for part in whole {
            (0..SIDE).for_each(|side| add(side, part[side]));
        }
        for (side, &value) in rest.iter().enumerate() {
            add(side, value);
        }
        self.sums[0] += sums.iter().sum::<f64>();
        self.sums[1] += squares.iter().sum::<f64>();
        self.least = least.into_iter().fold(self.least, f64::min);
        self.extremes[0] = lowest.into_iter().fold(self.extremes[0], f64::min);
        self.extremes[1] = highest.into_iter().fold(self.extremes[1], f64::max);
        self.count += row.len();
        self.changes |= row.iter().any(|&value| value != row[0]);
        row.iter().any(|&value| value != T::default())
    }
}

impl Survey {
    /// Begins the survey of a frame of some transmits and elements.
    pub(super) fn new([transmits, elements]: [usize; 2]) -> Self {
        let none = Moments {
            sums: [0.0; 2],
            least: f64::INFINITY,
            extremes: [0.0; 2],
            count: 0,
            changes: false,
            turn: Complex::default(),
        };
        Survey {
            elements: vec![none; elements],
            most_receivers: 0,
            every: (transmits * elements).div_ceil(KEPT).max(1),
            passed: 0,
            records: Vec::new(),
        }
    }

    /// Adds the next transmit of RF, [element, sample], on all threads.
    pub(super) fn add_rf<T>(&mut self, rf: ArrayView2<'_, T>)
    where
        T: Copy + PartialEq + Default + Sync + Into<f32> + Into<f64>,
    {
        let kept = (0..rf.nrows()).filter(|m| (self.passed + m).is_multiple_of(self.every));
        let record = |m| rf.row(m).iter().map(|&v| v.into()).collect();
        self.records.extend(kept.map(record));
        self.add(rf, |v| [v.into(); 2]);
    }

    /// As [`Survey::add_rf`], of I/Q.
    pub(super) fn add_iq(&mut self, iq: ArrayView2<'_, Complex<f32>>) {
        let wide = |z: Complex<f32>| Complex::<f64>::new(z.re.into(), z.im.into());
        for (own, row) in self.elements.iter_mut().zip(iq.rows()) {
            let pairs = row.iter().zip(row.iter().skip(1));
            own.turn += pairs
                .map(|(&a, &b)| wide(b) * wide(a).conj())
                .sum::<Complex<_>>();
        }
        self.add(iq, |z| [z.re.into(), z.im.into()]);
    }

    fn add<T: Copy + PartialEq + Default + Sync>(
        &mut self,
        records: ArrayView2<'_, T>,
        parts: impl Fn(T) -> [f64; 2] + Sync,
    ) {
        self.passed += records.nrows();
        let elements = self.elements.par_iter_mut().enumerate();
        let live = elements.filter_map(|(m, own)| own.add(records.row(m), &parts).then_some(()));
        self.most_receivers = self.most_receivers.max(live.count());
    }

    /// The variance of each element's samples, times a constant.
    pub fn power(&self) -> Vec<f64> {
        let power = |own: &Moments| {
            let [sum, squares] = own.sums;
            squares - sum * sum / own.count.max(1) as f64
        };
        self.elements.iter().map(power).collect()
    }

    /// Whether a sample, of I/Q a real part, is below 0.
    pub(super) fn is_below_0(&self) -> bool {
        self.elements.iter().any(|own| own.least < 0.0)
    }

    /// Elements whose records are constant.
    pub fn dead(&self) -> Vec<usize> {
        let all = 0..self.elements.len();
        let is_dead = |own: &Moments| own.count > 0 && !own.changes;
        all.filter(|&m| is_dead(&self.elements[m])).collect()
    }

    /// Mean frequency of I/Q, Hz.
    ///
    /// It follows from the phase from one sample to the next.
    pub(super) fn mean_frequency(&self, fs: f64) -> Option<f64> {
        let turn: Complex<f64> = self.elements.iter().map(|own| own.turn).sum();
        (turn.norm() > 0.0).then(|| fs * turn.arg() / std::f64::consts::TAU)
    }

    /// Power of RF at twice and at half a frequency, over that at the frequency itself.
    ///
    /// It is that of Hann windows of eight periods without mean and slope, in at most 64 records. `None` without RF; 0
    /// beyond half the rate, and without a maximum there: the power of an edge falls with the square of the frequency.
    pub(super) fn harmonics(&self, f0: f64, fs: f64) -> Option<[f64; 2]> {
        if self.records.is_empty() {
            return None;
        }
        let window = (8.0 * fs / f0).ceil();
        let power = |f: f64| {
            let turn = std::f64::consts::TAU;
            let hann = |n: f64| 0.5 - 0.5 * (turn * (n + 0.5) / window).cos();
            let mut carrier: Vec<Complex<f64>> = (0..window as usize)
                .map(|n| Complex::from_polar(hann(n as f64), turn * f / fs * n as f64))
                .collect();
            let middle = 0.5 * (window - 1.0);
            let mean = carrier.iter().sum::<Complex<f64>>() / window;
            let tilted = (0..)
                .zip(&carrier)
                .map(|(n, z)| z * (f64::from(n) - middle));
            let slope = tilted.sum::<Complex<f64>>() * 12.0 / (window * (window * window - 1.0));
            for (n, z) in (0..).zip(&mut carrier) {
                *z -= mean + slope * (f64::from(n) - middle);
            }
            let parts = self
                .records
                .iter()
                .flat_map(|record| record.chunks_exact(carrier.len()));
            let mixed = parts.map(|part| {
                let each = part.iter().zip(&carrier);
                let sum: Complex<f64> = each.map(|(&sample, z)| z * f64::from(sample)).sum();
                sum.norm_sqr()
            });
            mixed.sum::<f64>()
        };
        let squares = self
            .records
            .iter()
            .flatten()
            .map(|&v| f64::from(v) * f64::from(v));
        let all: f64 = squares.sum();
        let own = power(f0);
        let over = |f: f64| {
            let (between, beyond) = (0.5 * (f + f0), 1.5 * f - 0.5 * f0);
            match (power(f), 2.0 * f < fs && own > 0.0) {
                // Below a millionth of the amplitude all is rounding.
                (found, true) if found > power(between).max(power(beyond)).max(1e-12 * all) => {
                    found / own
                }
                _ => 0.0,
            }
        };
        Some([over(2.0 * f0), over(0.5 * f0)])
    }
}
