//! Sound speed and time zero, by the curvature of echoes over the aperture.
//!
//! The phase between two neighbours of an aligned echo, elements or transmits, is 2πf·(D(c₀) − D(c)), with D the difference of their
//! delays: `Table` has it for every block. Each pair of elements also has a phase of its own, the same for all lines:
//! delays of its channels, or of tissue before it. It is eliminated, so only what moves with the lines counts.

use std::f64::consts::TAU;

use num_complex::Complex;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use crate::base::Base;
use crate::table::{LAGS, Table, View};

/// Alignments, each at the speed that the one before found.
const PASSES: usize = 4;
/// Largest step of the speed, as a share.
const STEP: f64 = 0.1;
/// Speeds that are tried, m/s.
const RANGE: [f64; 2] = [1000.0, 2200.0];
/// Resamples of the bootstrap.
const RESAMPLES: usize = 200;
/// Sizes of a block's own step, in medians, from which it is left out.
const OUTLYING: f64 = 6.0;
/// Half-width of an interval of 95 %, in standard deviations.
const QUANTILE: f64 = 1.96;

/// A number with an interval of 95 %.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Estimate {
    pub value: f64,
    /// Standard deviation.
    pub deviation: f64,
}

impl Estimate {
    pub fn interval(&self) -> [f64; 2] {
        let half = QUANTILE * self.deviation;
        [self.value - half, self.value + half]
    }
}

/// Sound speed, with time zero as the file has it or estimated with it.
pub(crate) struct Speeds {
    /// Of the file's time zero, m/s.
    pub speed: Estimate,
    /// The same with time zero free, m/s.
    pub free: Estimate,
    /// Time by which echoes come later than the file's times, s.
    pub late: Estimate,
}

/// One pair of elements in one block: its correlation, and the derivatives of its phase by c and by time.
struct Row {
    block: usize,
    line: usize,
    pair: usize,
    /// Weight of the pair, and the part of its correlation across its own phase.
    weight: f64,
    phase: f64,
    by: [f64; 2],
}

/// Estimates the speed of the echoes between elements for which `good` is true.
///
/// `None` if too few echoes are coherent.
pub(crate) fn estimate(base: &Base, view: &View, good: &[bool]) -> Option<Speeds> {
    let mut view = view.clone();
    let mut table = Table::new(base, &view);
    for pass in 0..PASSES {
        let lags = if pass == 0 { 1 } else { LAGS.len() };
        let rows = rows(&table, &view, good, lags);
        let sums = Sums::of(&rows, &view, &vec![1.0; table.blocks.len()]);
        let [step, _] = sums.solve(&vec![1.0; view.lines.len()], false)?;
        view.c = (view.c + step.clamp(-STEP * view.c, STEP * view.c)).clamp(RANGE[0], RANGE[1]);
        table = Table::new(base, &view);
    }
    let rows = rows(&table, &view, good, LAGS.len());
    let kept = robust(&rows, &table);
    let sums = Sums::of(&rows, &view, &kept);
    let lines = view.lines.len();
    let all = vec![1.0; lines];
    let [step, _] = sums.solve(&all, false)?;
    let [free, late] = sums.solve(&all, true)?;
    let mut random = ChaCha8Rng::seed_from_u64(58);
    let mut samples = Vec::new();
    for _ in 0..RESAMPLES {
        let mut times = vec![0.0; lines];
        (0..lines).for_each(|_| times[random.random_range(0..lines)] += 1.0);
        if let (Some([step, _]), Some([free, late])) =
            (sums.solve(&times, false), sums.solve(&times, true))
        {
            samples.push([step, free, late]);
        }
    }
    let estimate = |k: usize, value: f64| Estimate {
        value,
        deviation: deviation(samples.iter().map(|sample| sample[k])),
    };
    (samples.len() > RESAMPLES / 2).then(|| Speeds {
        speed: estimate(0, view.c + step),
        free: estimate(1, view.c + free),
        late: estimate(2, late),
    })
}

fn deviation(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    (values.map(|v| (v - mean) * (v - mean)).sum::<f64>() / (count - 1.0)).sqrt()
}

/// Number of pairs: of elements at each lag, and of transmits.
fn pairs(view: &View) -> usize {
    LAGS.len() * view.elements.len() + view.waves.len()
}

/// One row for each pair and block.
///
/// A transmit that reaches a point of a line is as good a witness as an element that receives from it.
fn rows(table: &Table, view: &View, good: &[bool], lags: usize) -> Vec<Row> {
    let count = view.elements.len();
    let (mut rows, mut values) = (Vec::new(), Vec::new());
    let turn = -TAU * table.frequency;
    let bare = View {
        order: Vec::new(),
        ..view.clone()
    };
    for (index, block) in table.blocks.iter().enumerate() {
        let line = &view.lines[block.line];
        let power = block.total();
        if power <= 0.0 {
            continue;
        }
        let shared: Complex<f32> = block.lags[0].iter().sum();
        // Blocks without echoes have little to say.
        let weight = f64::from(shared.norm()) / (power * power);
        let (dc, dt) = (1.0, 5e-9);
        let delays = |time: f64, c: f64| -> Vec<f64> {
            (0..count).map(|m| view.receive(line, time, m, c)).collect()
        };
        let arrivals = |time: f64, c: f64| -> Vec<f64> {
            let view = View { c, ..bare.clone() };
            view.waves
                .iter()
                .map(|wave| view.arrival(wave, line, c * time))
                .collect()
        };
        let power_of_transmits = f64::from(block.transmits.iter().map(|pair| pair.1).sum::<f32>());
        if !view.own && power_of_transmits > 0.0 {
            let shared: Complex<f32> = block.transmits.iter().map(|pair| pair.0).sum();
            let weight = f64::from(shared.norm()) / (power_of_transmits * power_of_transmits);
            let here = arrivals(block.time, view.c);
            let faster = arrivals(block.time, view.c + dc);
            let later = arrivals(block.time + 0.5 * dt, view.c);
            for (t, (value, _)) in block.transmits.iter().enumerate() {
                let difference = |d: &[f64]| d[t + 1] - d[t];
                values.push(Complex::new(f64::from(value.re), f64::from(value.im)) * weight);
                rows.push(Row {
                    block: index,
                    line: block.line,
                    pair: LAGS.len() * count + t,
                    weight: 0.0,
                    phase: 0.0,
                    by: [
                        turn * (difference(&faster) - difference(&here)) / dc,
                        turn * (difference(&later) - difference(&here)) / dt,
                    ],
                });
            }
        }
        let here = delays(block.time, view.c);
        let faster = delays(block.time, view.c + dc);
        let later = delays(block.time + 0.5 * dt, view.c);
        for (k, lag) in LAGS.into_iter().enumerate().take(lags) {
            for m in 0..count.saturating_sub(lag) {
                let value = block.lags[k][m];
                if value == Complex::default() || !good[m] || !good[m + lag] {
                    continue;
                }
                let difference = |d: &[f64]| d[m + lag] - d[m];
                values.push(Complex::new(f64::from(value.re), f64::from(value.im)) * weight);
                rows.push(Row {
                    block: index,
                    line: block.line,
                    pair: k * count + m,
                    weight: 0.0,
                    phase: 0.0,
                    by: [
                        turn * (difference(&faster) - difference(&here)) / dc,
                        turn * (difference(&later) - difference(&here)) / dt,
                    ],
                });
            }
        }
    }
    // Each pair's own phase is taken off.
    let mut own = vec![Complex::<f64>::default(); pairs(view)];
    rows.iter()
        .zip(&values)
        .for_each(|(row, value)| own[row.pair] += value);
    let turned = |row: &Row, value: &Complex<f64>| {
        value * own[row.pair].conj() / own[row.pair].norm().max(f64::MIN_POSITIVE)
    };
    // Pairs of one block and lag weigh alike: by the mean that they have in common.
    let groups = LAGS.len() + 1;
    let group = |row: &Row| row.block * groups + (row.pair / count).min(LAGS.len());
    let mut means = vec![[0.0; 2]; table.blocks.len() * groups];
    for (row, value) in rows.iter().zip(&values) {
        let mean = &mut means[group(row)];
        *mean = [mean[0] + turned(row, value).re, mean[1] + 1.0];
    }
    for (row, value) in rows.iter_mut().zip(&values) {
        let [sum, number] = means[group(row)];
        row.phase = turned(row, value).im;
        row.weight = (sum / number).max(0.0);
    }
    rows
}

/// Sums over the blocks of a line for each pair: weights w, phases p, and their products with the derivatives x, y.
struct Sums {
    /// [line][pair]: w, wx, wy, wxx, wxy, wyy, p, px, py.
    sums: Vec<Vec<[f64; 9]>>,
}

impl Sums {
    fn of(rows: &[Row], view: &View, weights: &[f64]) -> Self {
        let mut sums = vec![vec![[0.0; 9]; pairs(view)]; view.lines.len()];
        for row in rows {
            let ([x, y], by) = (row.by, weights[row.block]);
            let (w, p) = (by * row.weight, by * row.phase);
            let terms = [
                w,
                w * x,
                w * y,
                w * x * x,
                w * x * y,
                w * y * y,
                p,
                p * x,
                p * y,
            ];
            let sum = &mut sums[row.line][row.pair];
            sum.iter_mut()
                .zip(terms)
                .for_each(|(sum, term)| *sum += term);
        }
        Sums { sums }
    }

    /// The step of c and of time zero that turns the phases to 0; of c alone unless `both`.
    ///
    /// Each pair keeps a phase of its own.
    fn solve(&self, lines: &[f64], both: bool) -> Option<[f64; 2]> {
        let ([mut xx, mut xy, mut yy], [mut px, mut py]) = ([0.0; 3], [0.0; 2]);
        for pair in 0..self.sums.first()?.len() {
            let mut all = [0.0; 9];
            for (sums, weight) in self.sums.iter().zip(lines) {
                let terms = all.iter_mut().zip(&sums[pair]);
                terms.for_each(|(all, term)| *all += weight * term);
            }
            let [w, wx, wy, wxx, wxy, wyy, p, own_px, own_py] = all;
            if w <= 0.0 {
                continue;
            }
            xx += wxx - wx * wx / w;
            xy += wxy - wx * wy / w;
            yy += wyy - wy * wy / w;
            px += own_px - wx * p / w;
            py += own_py - wy * p / w;
        }
        if !both {
            return (xx > 0.0).then(|| [px / xx, 0.0]);
        }
        let determinant = xx * yy - xy * xy;
        (determinant > 1e-9 * xx * yy).then(|| {
            [
                (px * yy - py * xy) / determinant,
                (py * xx - px * xy) / determinant,
            ]
        })
    }
}

/// Weights of the blocks: 0 for those whose own speed is far from the others'.
///
/// A mirror's echo does not come from where it lies.
fn robust(rows: &[Row], table: &Table) -> Vec<f64> {
    let mut own = vec![[0.0; 2]; table.blocks.len()];
    for row in rows {
        own[row.block][0] += row.by[0] * row.phase;
        own[row.block][1] += row.by[0] * row.by[0] * row.weight;
    }
    let size = |[b, a]: [f64; 2]| if a > 0.0 { (b / a.sqrt()).abs() } else { 0.0 };
    let mut sizes: Vec<f64> = own
        .iter()
        .map(|&own| size(own))
        .filter(|&size| size > 0.0)
        .collect();
    sizes.sort_by(f64::total_cmp);
    let usual = sizes.get(sizes.len() / 2).copied().unwrap_or(0.0);
    let outlying = |own: [f64; 2]| size(own) > OUTLYING * usual;
    own.into_iter()
        .map(|own| if outlying(own) { 0.0 } else { 1.0 })
        .collect()
}
