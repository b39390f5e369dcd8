//! Scores of a line by a learnt model.
//!
//! An echo is a cell brighter than its neighbours and than any block of 1 mm below it. It gets the score of a network with one hidden layer, from mean grey
//! levels around it, and its neighbours nearly that score. Other cells get the lowest score. `training/` makes the
//! weights.

use super::logarithm::ln;
use super::onset::Levels;
use super::parameters::{PARTS, Sizes, cells_of};
use super::weights::{BIASES, CENTRES, GAINS, INPUTS, OUTPUT, OUTPUT_BIAS, WEIGHTS};

/// Mean levels of an echo.
const LEVELS: usize = 20;
/// Score of a cell that is no echo.
const LOWEST: i32 = -4 << 10;
/// Largest score; back pointers hold less than 6 nats.
const HIGHEST: i32 = 6040;
/// Price of a cell beside an echo.
const BESIDE: i32 = 717;
/// Smallest level of an echo above the frame's dark, in 1/16.
const LEAST: i32 = 3 * PARTS;
/// Largest ratio of a block below bone to its echo.
const SHADOW: [i32; 2] = [4, 5];
/// Drop from the tissue to a dark that is not black, and largest black, in 1/16.
const DROP: i32 = 56 * PARTS;
const BLACK: i32 = 13 * PARTS;
/// Added to levels before their logarithm, in 1/16.
const OFFSET: i32 = 4 * PARTS;
/// Inputs are limited to this, in 1/64 of their standard deviation.
const LIMIT: i32 = 3 * 64;
/// Farther than any cell of a line.
const FAR: i32 = 1 << 20;

/// Lengths in cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Learnt {
    /// Half the window of the echo.
    echo: i32,
    /// Cells on either side that an echo exceeds.
    apart: usize,
    /// Length of a block below, and distance from which echoes above and below count.
    block: usize,
    /// Distance to the first block below.
    shadow: usize,
    /// Windows around a cell, its first cell and the one after its last.
    windows: [[i32; 2]; 15],
}

/// Levels of the frame, in 1/16, and the logarithms of the same.
struct Frame {
    dark: i32,
    bright: i32,
    inputs: [i32; 2],
}

impl Learnt {
    /// For cells of a length, m.
    pub(super) const fn new(cell: f64) -> Self {
        const fn at_least_one(cells: i32) -> i32 {
            if cells > 1 { cells } else { 1 }
        }
        const fn cells(length: f64, cell: f64) -> i32 {
            let cells = cells_of(1e-3 * length, cell);
            if cells < FAR as usize {
                cells as i32
            } else {
                FAR
            }
        }
        // Distances in mm.
        const BELOW: [[f64; 2]; 6] = [
            [0.3, 0.6],
            [0.5, 1.0],
            [1.0, 2.0],
            [2.0, 4.0],
            [4.0, 8.0],
            [8.0, 16.0],
        ];
        let fine = cells(0.1, cell);
        let coarse = at_least_one(cells(0.5, cell));
        let shadow = at_least_one(cells(1.5, cell));
        let mut windows = [[0; 2]; 15];
        windows[0] = [-fine, fine + 1];
        windows[1] = [-coarse, coarse + 1];
        let mut k = 0;
        while k < BELOW.len() {
            let [near, far] = [cells(BELOW[k][0], cell), cells(BELOW[k][1], cell)];
            windows[2 + k] = [near, far];
            if k < 5 {
                windows[8 + k] = [1 - far, 1 - near];
            }
            k += 1;
        }
        windows[13] = [shadow, FAR];
        windows[14] = [-FAR, 1 - coarse];
        Learnt {
            echo: at_least_one(cells(0.2, cell)),
            apart: at_least_one(cells(0.4, cell)) as usize,
            block: at_least_one(cells(1.0, cell)) as usize,
            shadow: shadow as usize,
            windows,
        }
    }

    /// Scores of the searched cells.
    ///
    /// The initial contents of `scores` and of `echoes`, both as long as the search, do not matter.
    pub(super) fn scores(
        &self,
        sums: &[u32],
        sizes: &Sizes,
        levels: Levels,
        echoes: &mut [i32],
        scores: &mut [i32],
    ) {
        let sums = sums.get(sizes.above..).unwrap_or_default();
        let sums = sums
            .get(..sizes.cells.saturating_add(1))
            .unwrap_or_default();
        let line = Line {
            sums,
            stride: sizes.stride as u32,
        };
        let first = sizes.first as i32;
        // Echoes, and in place of each score the brightest echo above.
        let mut brightest = 0;
        for (index, cell) in (0..echoes.len()).zip(first..) {
            let echo = line.mean(cell - self.echo, cell + self.echo + 1);
            if let Some(entry) = echoes.get_mut(index) {
                *entry = echo;
            }
            let above = index.checked_sub(self.block);
            let above = above.and_then(|above| echoes.get(above)).copied();
            brightest = brightest.max(above.unwrap_or(0));
            if let Some(entry) = scores.get_mut(index) {
                *entry = brightest;
            }
        }
        let most = echoes.iter().copied().fold(0, i32::max);
        let frame = Frame::of(levels);
        let (mut below, mut block, mut beside) = (0, 0, LOWEST);
        let mut next = sums.len().saturating_sub(self.block);
        for index in (0..echoes.len().min(scores.len())).rev() {
            let cell = sizes.first.saturating_add(index);
            let farther = echoes.get(index.saturating_add(self.block)).copied();
            below = below.max(farther.unwrap_or(0));
            while next > cell.saturating_add(self.shadow) {
                next -= 1;
                block = block.max(line.mean(next as i32, (next + self.block) as i32));
            }
            let score = if self.is_echo(echoes, index, frame.dark, block) {
                let above = scores.get(index).copied().unwrap_or_default();
                let mut means = [0; LEVELS];
                let (head, tail) = means.split_at_mut_checked(16).unwrap_or_default();
                if let Some(echo) = head.first_mut() {
                    *echo = echoes.get(index).copied().unwrap_or_default();
                }
                let windows = head.iter_mut().skip(1).zip(&self.windows);
                for (mean, [from, end]) in windows {
                    *mean = line.mean(cell as i32 + from, cell as i32 + end);
                }
                for (entry, mean) in tail.iter_mut().zip([block, below, above, most]) {
                    *entry = mean;
                }
                frame.score(&means)
            } else {
                LOWEST
            };
            if let Some(entry) = scores.get_mut(index) {
                *entry = score.max(beside);
            }
            beside = (score - BESIDE).max(LOWEST);
            if let Some(entry) = scores.get_mut(index.saturating_add(1)) {
                *entry = beside.max(*entry);
            }
        }
    }

    /// Whether a cell exceeds its neighbours, the frame's dark and the brightest block below.
    #[inline(always)]
    fn is_echo(&self, echoes: &[i32], index: usize, dark: i32, block: i32) -> bool {
        let Some(&echo) = echoes.get(index) else {
            return false;
        };
        let shadow = SHADOW[1] * (block + OFFSET) <= SHADOW[0] * (echo + OFFSET);
        if echo < dark + LEAST || !shadow {
            return false;
        }
        let (above, rest) = echoes.split_at_checked(index).unwrap_or_default();
        let below = rest.get(1..).unwrap_or_default();
        below.iter().take(self.apart).all(|&other| other < echo)
            && above
                .iter()
                .rev()
                .take(self.apart)
                .all(|&other| other <= echo)
    }
}

/// Sums of a line from its first cell to before each cell, and to the end.
struct Line<'a> {
    sums: &'a [u32],
    stride: u32,
}

impl Line<'_> {
    /// Mean level from a cell to before another, in 1/16.
    ///
    /// It is over the cells within the line, at least one.
    #[inline(always)]
    fn mean(&self, from: i32, end: i32) -> i32 {
        let cells = self.sums.len() as i32 - 1;
        let from = from.min(cells - 1).max(0);
        let end = end.min(cells).max(from + 1);
        let at = |cell: i32| self.sums.get(cell as usize).copied().unwrap_or_default();
        let sum = at(end).wrapping_sub(at(from)).wrapping_mul(PARTS as u32);
        let samples = (end - from) as u32 * self.stride;
        sum.checked_div(samples).unwrap_or(0) as i32
    }
}

/// Logarithm of a level in 1/16.
#[inline(always)]
fn ln_of(level: i32) -> i32 {
    ln((level + OFFSET) as u32)
}

impl Frame {
    fn of(levels: Levels) -> Self {
        let [dark, tissue, bright] = [levels.dark, levels.tissue, levels.bright].map(i32::from);
        // A dark neither black nor far below the tissue is muscle.
        let dark = dark.min((tissue - DROP).max(BLACK));
        let bright = ln_of(bright);
        Frame {
            dark,
            bright,
            inputs: [dark, tissue].map(|level| ln_of(level) - bright),
        }
    }

    /// The network's score of an echo.
    ///
    /// Its inputs are the levels' logarithms, and two of the frame.
    #[inline(never)]
    fn score(&self, means: &[i32; LEVELS]) -> i32 {
        let echo = ln_of(means.first().copied().unwrap_or_default());
        let logarithms = means.iter().enumerate().map(|(index, &mean)| match index {
            0 => echo - self.bright,
            _ => ln_of(mean) - echo,
        });
        let mut inputs = [0i16; INPUTS];
        let all = logarithms.chain(self.inputs);
        let scales = CENTRES.iter().zip(&GAINS);
        for ((entry, input), (&centre, &gain)) in inputs.iter_mut().zip(all).zip(scales) {
            let scaled = ((input - i32::from(centre)) * i32::from(gain)) >> 12;
            *entry = scaled.min(LIMIT).max(-LIMIT) as i16;
        }
        let mut score = OUTPUT_BIAS;
        for ((weights, &bias), &output) in WEIGHTS.iter().zip(&BIASES).zip(&OUTPUT) {
            let products = weights.iter().zip(&inputs);
            let sum = products.fold(bias, |sum, (&weight, &input)| {
                sum.wrapping_add(i32::from(weight) * i32::from(input))
            });
            score = score.wrapping_add((sum.max(0) >> 8).wrapping_mul(i32::from(output)));
        }
        (score >> 8).min(HIGHEST).max(LOWEST)
    }
}
