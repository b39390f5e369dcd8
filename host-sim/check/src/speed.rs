//! Sound speed and time zero, by the curvature of echoes over the aperture.
//!
//! The phase between two neighbours of an aligned echo, elements or transmits, is 2πf·(D(c₀) − D(c)), with D the difference of their
//! delays: `Table` has it for every block. The mean over a block's pairs is left out, so only the curvature counts.

use std::f64::consts::TAU;

use num_complex::Complex;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use crate::base::Base;
use crate::table::{Block, LAGS, Table, View};

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

/// Curvature of a block: sums over its pairs of xx, xy, yy, px, py, with the phases p and their derivatives x by c and
/// y by time, less their means.
type Curvature = [f64; 5];

/// Estimates the speed of the echoes between elements for which `good` is true.
///
/// `None` if too few echoes are coherent.
pub(crate) fn estimate(base: &Base, view: &View, good: &[bool]) -> Option<Speeds> {
    let mut view = view.clone();
    let mut table = Table::new(base, &view);
    for pass in 0..PASSES {
        let lags = if pass == 0 { 1 } else { LAGS.len() };
        let [step, _] = solve(&curvatures(&table, &view, good, lags), false)?;
        view.c = (view.c + step.clamp(-STEP * view.c, STEP * view.c)).clamp(RANGE[0], RANGE[1]);
        table = Table::new(base, &view);
    }
    let blocks = robust(curvatures(&table, &view, good, LAGS.len()));
    let mut lines = vec![Curvature::default(); view.lines.len()];
    for (block, own) in table.blocks.iter().zip(blocks) {
        lines[block.line]
            .iter_mut()
            .zip(own)
            .for_each(|(sum, term)| *sum += term);
    }
    let [step, _] = solve(&lines, false)?;
    let [free, late] = solve(&lines, true)?;
    let mut random = ChaCha8Rng::seed_from_u64(58);
    let mut samples = Vec::new();
    for _ in 0..RESAMPLES {
        let drawn: Vec<Curvature> = (0..lines.len())
            .map(|_| lines[random.random_range(0..lines.len())])
            .collect();
        if let (Some([step, _]), Some([free, late])) = (solve(&drawn, false), solve(&drawn, true)) {
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

/// The curvature of each block.
///
/// A transmit that reaches a point of a line is as good a witness as an element that receives from it. The mean phase of
/// a block's pairs is left out: an echo that comes from beside the line.
fn curvatures(table: &Table, view: &View, good: &[bool], lags: usize) -> Vec<Curvature> {
    let count = view.elements.len();
    let turn = -TAU * table.frequency;
    let (dc, dt) = (1.0, 5e-9);
    let bare = |c: f64| View {
        c,
        order: Vec::new(),
        ..view.clone()
    };
    let views = [bare(view.c), bare(view.c + dc)];
    let of = |block: &Block| {
        let line = &view.lines[block.line];
        // Here, at a higher speed, later.
        let at = [
            (&views[0], block.time),
            (&views[1], block.time),
            (&views[0], block.time + 0.5 * dt),
        ];
        let by = |delays: &[Vec<f64>; 3], a: usize, b: usize| {
            let [here, faster, later] = [0, 1, 2].map(|k| delays[k][b] - delays[k][a]);
            [turn * (faster - here) / dc, turn * (later - here) / dt]
        };
        let mut sums = Curvature::default();
        let power = block.total();
        if power > 0.0 {
            let received = at.map(|(view, time)| -> Vec<f64> {
                (0..count)
                    .map(|m| view.receive(line, time, m, view.c))
                    .collect()
            });
            for (k, lag) in LAGS.into_iter().enumerate().take(lags) {
                let pairs = (0..count.saturating_sub(lag)).filter(|&m| good[m] && good[m + lag]);
                let pairs = pairs.filter(|&m| block.lags[k][m] != Complex::default());
                add(
                    &mut sums,
                    power,
                    pairs.map(|m| (block.lags[k][m], by(&received, m, m + lag))),
                );
            }
        }
        let power = f64::from(block.transmits.iter().map(|pair| pair.1).sum::<f32>());
        if !view.own && power > 0.0 {
            let reached = at.map(|(view, time)| -> Vec<f64> {
                view.waves
                    .iter()
                    .map(|wave| view.arrival(wave, line, view.c * time))
                    .collect()
            });
            let pairs = block.transmits.iter().enumerate();
            add(
                &mut sums,
                power,
                pairs.map(|(t, (value, _))| (*value, by(&reached, t, t + 1))),
            );
        }
        sums
    };
    table.blocks.iter().map(of).collect()
}

/// Adds the pairs of one kind: correlations and the derivatives of their phases.
fn add(sums: &mut Curvature, power: f64, pairs: impl Iterator<Item = (Complex<f32>, [f64; 2])>) {
    let pairs: Vec<(Complex<f64>, [f64; 2])> = pairs
        .map(|(value, by)| {
            (
                Complex::new(f64::from(value.re), f64::from(value.im)) / power,
                by,
            )
        })
        .collect();
    let shared: Complex<f64> = pairs.iter().map(|pair| pair.0).sum();
    let coherence = shared.norm();
    if pairs.len() < 3 || coherence == 0.0 {
        return;
    }
    let number = pairs.len() as f64;
    let mean = |k: usize| pairs.iter().map(|pair| pair.1[k]).sum::<f64>() / number;
    let means = [mean(0), mean(1)];
    // Blocks without echoes have little to say.
    let weight = coherence * coherence / number;
    for (value, by) in &pairs {
        let [x, y] = [by[0] - means[0], by[1] - means[1]];
        let phase = (value * shared.conj()).im;
        let terms = [
            weight * x * x,
            weight * x * y,
            weight * y * y,
            phase * x,
            phase * y,
        ];
        sums.iter_mut()
            .zip(terms)
            .for_each(|(sum, term)| *sum += term);
    }
}

/// The step of c and of time zero that turns the phases to 0; of c alone unless `both`.
fn solve(all: &[Curvature], both: bool) -> Option<[f64; 2]> {
    let [xx, xy, yy, px, py] = [0, 1, 2, 3, 4].map(|k| all.iter().map(|own| own[k]).sum::<f64>());
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

/// Leaves out blocks whose own speed is far from the others'.
///
/// A mirror's echo does not come from where it lies.
fn robust(mut blocks: Vec<Curvature>) -> Vec<Curvature> {
    let size = |own: &Curvature| {
        if own[0] > 0.0 {
            own[3].abs() / own[0].sqrt()
        } else {
            0.0
        }
    };
    let mut sizes: Vec<f64> = blocks.iter().map(size).filter(|&size| size > 0.0).collect();
    sizes.sort_by(f64::total_cmp);
    let usual = sizes.get(sizes.len() / 2).copied().unwrap_or(0.0);
    for own in &mut blocks {
        if size(own) > OUTLYING * usual {
            *own = Curvature::default();
        }
    }
    blocks
}
