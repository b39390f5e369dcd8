//! Sound speed, time zero and delays of tissue before the array, by the phases of echoes over the aperture.
//!
//! An aligned echo has the phase 2πf·(D(c₀) − D(c)) between two focused subapertures side by side, or between two
//! elements that send, with D the difference of their delays. Subapertures, since a single element also hears echoes from beside
//! the line, which look like a higher speed. The mean over a block's pairs is left out: it is the echo's direction.
//! Tissue before the array delays each element; twelve cosines over the array have these delays. Their variance is
//! found with them, so that even tissue adds nothing.

use std::f64::consts::TAU;

use nalgebra::{SMatrix, SVector};
use num_complex::Complex;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use crate::base::Base;
use crate::elements::median;
use crate::order::{is_sharper, mean};
use crate::table::{Block, Part, Table};
use crate::view::{View, Wave, chosen};

/// Alignments, each at the speed that the one before found: by neighbours, whose phases are small.
const COARSE: usize = 4;
/// The same by subapertures.
const PASSES: usize = 4;
/// Gain of the focused echoes from which the first estimate counts.
const MORE: f64 = 1.1;
/// Speeds that are tried where neighbours hear too much from beside the line, in steps from the file's, the step as a
/// share, and the lines and transmits that are read.
///
/// A pitch that is wrong acts as a speed far off.
const TRIED: [i32; 2] = [-10, 18];
const APART: f64 = 0.02;
const EVERY: usize = 3;
const FEW: usize = 4;
/// Largest step of the time, s.
const LONGEST: f64 = 1e-6;
/// Largest step of the speed, as a share.
const STEP: f64 = 0.1;
/// Speeds that are tried, m/s.
const RANGE: [f64; 2] = [1000.0, 2200.0];
/// Resamples of the bootstrap.
const RESAMPLES: usize = 200;
/// Lines that are drawn together.
const RUN: usize = 4;
/// Sizes of a block's own step, in medians, from which it is left out.
const OUTLYING: f64 = 6.0;
/// Half-width of an interval of 95 %, in standard deviations.
const QUANTILE: f64 = 1.96;
/// Standard deviation in the bootstrap's: echoes are seen by several lines.
const SHARED: f64 = 2.0;

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
    /// Time to be added to the file's times, s.
    pub late: Estimate,
    /// Aligned by this speed and by the delays of tissue.
    pub view: View,
}

/// Cosines over the array, of which the delays of tissue before it are a sum.
const MODES: usize = 12;
/// Standard deviation of each, s.
const PRIOR: f64 = 10e-9;
/// Standard deviations of the speed and of time zero by uneven tissue, m/s and s, each per s of its delays' RMS.
///
/// Waves that are sent through it are not focused again. From 90 recordings of the study, seeds from 500000 on and from
/// 520000 on.
const UNEVEN: [f64; 2] = [0.4e9, 12.0];
/// Share of the tissue's delays that is left if time zero explains them.
const EXPLAINED: f64 = 0.5;
/// Speed that uneven tissue adds, m/s per s² of its delays' mean square: it widens the beams, and echoes from beside
/// the line look like a higher speed. From the same recordings.
const WIDER: f64 = 0.011e18;
/// Least standard deviation, ns.
const LEAST: f64 = 0.2;
const ROUNDS: usize = 10;
/// The unknowns: c, m/s; time, s; the cosines, s.
const UNKNOWNS: usize = 2 + MODES;
/// Each unknown's unit, so that matrices are of one size.
const TIME_UNIT: f64 = 1e-9;

type Row = SVector<f64, UNKNOWNS>;

/// Least squares of the phases of pairs: sums over pairs of xxᵀ and xp, with the phases p and their derivatives x by the
/// unknowns, less their means in a block; of p²; and of 1.
#[derive(Clone)]
struct Curvature {
    xx: SMatrix<f64, UNKNOWNS, UNKNOWNS>,
    xp: Row,
    pp: f64,
    count: f64,
}

impl Curvature {
    fn new() -> Self {
        Curvature {
            xx: SMatrix::zeros(),
            xp: Row::zeros(),
            pp: 0.0,
            count: 0.0,
        }
    }

    fn add(&mut self, other: &Self) {
        self.xx += other.xx;
        self.xp += other.xp;
        self.pp += other.pp;
        self.count += other.count;
    }

    /// The unknowns that turn the phases to 0; time is one only if `both`. `at` has the cosines so far, which are as
    /// large as they are found to be.
    fn solve(&self, both: bool, at: &Row) -> Option<Row> {
        let mut found = Row::zeros();
        let mut variance = (PRIOR / TIME_UNIT).powi(2);
        for _ in 0..ROUNDS {
            let left = self.pp - 2.0 * found.dot(&self.xp) + found.dot(&(self.xx * found));
            let noise = (left / self.count.max(1.0)).max(0.0);
            let (mut xx, mut xp) = (self.xx, self.xp);
            for k in 2..UNKNOWNS {
                let by = noise / variance;
                xx[(k, k)] += by;
                xp[k] -= by * at[k];
            }
            if !both {
                xx.row_mut(1).fill(0.0);
                xx.column_mut(1).fill(0.0);
                xx[(1, 1)] = 1.0;
                xp[1] = 0.0;
            }
            if xx[(0, 0)] <= 0.0 {
                return None;
            }
            let factor = xx.cholesky()?;
            found = factor.solve(&xp);
            let inverse = factor.inverse();
            let sizes = (2..UNKNOWNS).map(|k| (at[k] + found[k]).powi(2) + noise * inverse[(k, k)]);
            variance = (sizes.sum::<f64>() / MODES as f64).max(LEAST * LEAST);
        }
        Some(found)
    }
}

fn sum<'a>(lines: impl Iterator<Item = &'a Curvature>) -> Curvature {
    let mut all = Curvature::new();
    lines.for_each(|own| all.add(own));
    all
}

/// Estimates the speed of the echoes between elements for which `good` is true.
///
/// `None` if too few echoes are coherent.
pub(crate) fn estimate(base: &Base, view: &View, good: &[bool]) -> Option<Speeds> {
    let mut view = view.clone();
    view.without = (0..good.len()).filter(|&m| !good[m]).collect();
    let mut coarse = view.clone();
    for _ in 0..COARSE {
        let blocks = curvatures(&Table::new(base, &coarse), &coarse, true);
        let [xx, xp] = blocks.iter().fold([0.0; 2], |sum, own| {
            [sum[0] + own.xx[(0, 0)], sum[1] + own.xp[0]]
        });
        coarse.step(xp / xx)?;
    }
    // Echoes from beside the line make neighbours' phases imprecise.
    if Table::new(base, &coarse).focus() > MORE * Table::new(base, &view).focus() {
        view.c = coarse.c;
    }
    if let Some(c) = sharpest(base, &view) {
        view.c = c;
    }
    let (mut aligned, [speed, _], uneven) = refined(base, view.clone(), false)?;
    let (_, [free, late], and_late) = refined(base, view, true)?;
    aligned.without.clear();
    let with = |estimate: Estimate, wider: f64, by: f64| Estimate {
        value: estimate.value - wider,
        deviation: (SHARED * estimate.deviation).hypot(by),
    };
    let speed_of = |speed, uneven: f64| with(speed, WIDER * uneven * uneven, UNEVEN[0] * uneven);
    // A wrong time that is not allowed for looks like tissue; tissue stays.
    let of_late = if and_late < EXPLAINED * uneven {
        and_late
    } else {
        uneven.max(and_late)
    };
    Some(Speeds {
        speed: speed_of(speed, uneven),
        free: speed_of(free, and_late),
        late: with(late, 0.0, UNEVEN[1] * of_late),
        view: aligned,
    })
}

/// The speed at which subapertures agree best, if clearly better than at the view's.
fn sharpest(base: &Base, view: &View) -> Option<f64> {
    let at = |c: f64, every: usize| {
        let mut view = View {
            c,
            every,
            ..view.clone()
        };
        if !view.own && every > 1 {
            let read = chosen(view.waves.len(), FEW);
            let all = view.signs.iter_mut().enumerate();
            all.for_each(|(t, sign)| *sign *= f32::from(u8::from(read.contains(&t))));
        }
        Table::new(base, &view).focused()
    };
    let speeds = (TRIED[0]..=TRIED[1]).map(|k| view.c * (1.0 + APART * f64::from(k)));
    let tried = speeds.map(|c| (c, mean(&at(c, EVERY))));
    let (c, _) = tried.max_by(|a, b| a.1.total_cmp(&b.1))?;
    is_sharper(&at(c, 1), &at(view.c, 1)).then_some(c)
}

impl View {
    fn step(&mut self, step: f64) -> Option<()> {
        let step = step.is_finite().then_some(step)?;
        self.c = (self.c + step.clamp(-STEP * self.c, STEP * self.c)).clamp(RANGE[0], RANGE[1]);
        Some(())
    }
}

/// Alignment, speed and time by the phases between subapertures, with the bootstrap's deviations, and the RMS of the
/// tissue's delays, s; the time is the file's unless `both`.
fn refined(base: &Base, mut view: View, both: bool) -> Option<(View, [Estimate; 2], f64)> {
    let count = view.elements.len();
    let file = view.late;
    let mut table = Table::new(base, &view);
    let mut at = Row::zeros();
    for _ in 0..PASSES {
        let step = sum(curvatures(&table, &view, false).iter()).solve(both, &at)?;
        view.step(step[0])?;
        view.late -= (TIME_UNIT * step[1]).clamp(-LONGEST, LONGEST);
        at += step;
        for k in 0..MODES {
            for m in 0..count {
                view.screen[m] += TIME_UNIT * step[2 + k] * mode(k, m as f64, count);
            }
        }
        table = Table::new(base, &view);
    }
    let blocks = robust(curvatures(&table, &view, false));
    let mut lines = vec![Curvature::new(); view.lines.len()];
    for (block, own) in table.blocks.iter().zip(&blocks) {
        lines[block.line].add(own);
    }
    let step = sum(lines.iter()).solve(both, &at)?;
    let mut random = ChaCha8Rng::seed_from_u64(58);
    let drawn: Vec<Row> = (0..RESAMPLES)
        .filter_map(|_| {
            // Lines side by side have echoes in common.
            let first = (0..lines.len())
                .step_by(RUN)
                .map(|_| random.random_range(0..lines.len()));
            let run =
                first.flat_map(|first| (first..first + RUN).map(|line| &lines[line % lines.len()]));
            sum(run).solve(both, &at)
        })
        .collect();
    if drawn.len() <= RESAMPLES / 2 {
        return None;
    }
    let estimate = |k: usize, value: f64, unit: f64| Estimate {
        value,
        deviation: unit * deviation(drawn.iter().map(|row| row[k])),
    };
    let late = file - view.late + TIME_UNIT * step[1];
    let found = [
        estimate(0, view.c + step[0], 1.0),
        estimate(1, late, TIME_UNIT),
    ];
    let uneven = TIME_UNIT * (at + step).rows(2, MODES).norm();
    Some((view, found, uneven))
}

/// A cosine over the array: k half periods and more than one.
fn mode(k: usize, m: f64, count: usize) -> f64 {
    let at = (m + 0.5) / count as f64;
    std::f64::consts::SQRT_2 * (0.5 * TAU * (k + 2) as f64 * at).cos()
}

fn deviation(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    (values.map(|v| (v - mean) * (v - mean)).sum::<f64>() / (count - 1.0)).sqrt()
}

/// The curvature of each block.
///
/// An element that sends is as good a witness as one that receives. The mean phase of a block's pairs is left out: an
/// echo that comes from beside the line.
fn curvatures(table: &Table, view: &View, coarse: bool) -> Vec<Curvature> {
    let count = view.elements.len();
    let turn = -TAU * table.frequency;
    let (dc, dt) = (1.0, TIME_UNIT);
    let bare = |c: f64| View {
        c,
        order: Vec::new(),
        ..view.clone()
    };
    let views = [bare(view.c), bare(view.c + dc)];
    let sums_of = |delays: &dyn Fn(usize) -> f64| {
        let mut sum = 0.0;
        let mut until = vec![0.0];
        until.extend((0..count).map(|m| {
            sum += delays(m);
            sum
        }));
        until
    };
    let modes: Vec<Vec<f64>> = (0..MODES)
        .map(|k| sums_of(&|m| mode(k, m as f64, count)))
        .collect();
    let of = |block: &Block| {
        let line = &view.lines[block.line];
        // Here, at a higher speed, later.
        let at = [
            (&views[0], block.time),
            (&views[1], block.time),
            (&views[0], block.time + 0.5 * dt),
        ];
        let mut sums = Curvature::new();
        let until = at.map(|(view, time)| sums_of(&|m| view.receive(line, time, m, view.c)));
        let neighbours = (0..count.saturating_sub(1))
            .filter(|&m| coarse && block.lags[0][m] != Complex::default())
            .map(|m| Part {
                first: m,
                elements: 1,
                product: block.lags[0][m],
                power: (block.power[m] + block.power[m + 1]) / 2.0,
            });
        let parts = block
            .parts
            .iter()
            .filter(|part| !coarse && part.power > 0.0);
        let each = neighbours.chain(parts.cloned()).map(|part| {
            let between = |until: &[f64]| {
                let [a, b, c] = [0, 1, 2].map(|n| until[part.first + n * part.elements]);
                (c - 2.0 * b + a) / part.elements as f64
            };
            let [here, faster, later] = [0, 1, 2].map(|k| between(&until[k]));
            let mut by = Row::zeros();
            by[0] = turn * (faster - here) / dc;
            by[1] = turn * (later - here);
            for k in 0..MODES {
                by[2 + k] = turn * TIME_UNIT * between(&modes[k]);
            }
            (part.product / part.power, by)
        });
        add(&mut sums, each);
        let power = block.transmits.iter().map(|pair| pair.1).sum::<f32>();
        if matches!(view.waves.first(), Some(Wave::Element(_))) && power > 0.0 {
            let reached = at.map(|(view, time)| -> Vec<f64> {
                view.waves
                    .iter()
                    .map(|wave| view.arrival(wave, line, view.c * time))
                    .collect()
            });
            let pairs = block.transmits.iter().enumerate();
            let each = pairs.map(|(t, (value, _))| {
                let [here, faster, later] = [0, 1, 2].map(|k| reached[k][t + 1] - reached[k][t]);
                let mut by = Row::zeros();
                by[0] = turn * (faster - here) / dc;
                by[1] = turn * (later - here);
                let crossing =
                    |t: usize| view.crossing(&view.waves[t], line.at(view.c * block.time));
                if let (Some(a), Some(b)) = (crossing(t), crossing(t + 1)) {
                    for k in 0..MODES {
                        by[2 + k] = turn * TIME_UNIT * (mode(k, b, count) - mode(k, a, count));
                    }
                }
                (value * (block.transmits.len() as f32 / power), by)
            });
            add(&mut sums, each);
        }
        sums
    };
    table.blocks.iter().map(of).collect()
}

/// Adds the pairs of one kind: correlations and the derivatives of their phases.
fn add(sums: &mut Curvature, pairs: impl Iterator<Item = (Complex<f32>, Row)>) {
    let pairs: Vec<(Complex<f64>, Row)> = pairs
        .map(|(value, by)| (Complex::new(f64::from(value.re), f64::from(value.im)), by))
        .collect();
    let number = pairs.len() as f64;
    let shared: Complex<f64> = pairs.iter().map(|pair| pair.0).sum::<Complex<f64>>() / number;
    let coherence = shared.norm();
    if pairs.len() < 3 || coherence == 0.0 {
        return;
    }
    let mean = pairs.iter().map(|pair| pair.1).sum::<Row>() / number;
    // Blocks without echoes have little to say.
    let weight = coherence * coherence;
    for (value, by) in &pairs {
        let x = by - mean;
        let phase = (value * shared.conj()).im;
        sums.xx += weight * x * x.transpose();
        sums.xp += phase * x;
        sums.pp += phase * phase / weight;
        sums.count += 1.0;
    }
}

/// Leaves out blocks whose own speed is far from the others'.
///
/// A mirror's echo does not come from where it lies.
fn robust(mut blocks: Vec<Curvature>) -> Vec<Curvature> {
    let size = |own: &Curvature| {
        if own.xx[(0, 0)] > 0.0 {
            own.xp[0].abs() / own.xx[(0, 0)].sqrt()
        } else {
            0.0
        }
    };
    let usual = median(blocks.iter().map(size).filter(|&size| size > 0.0));
    for own in &mut blocks {
        if size(own) > OUTLYING * usual {
            *own = Curvature::new();
        }
    }
    blocks
}
