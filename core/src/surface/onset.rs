//! Scores of a line from five terms.
//!
//! Shadow onset, contrast, change of level, rest, and shadow to the end.

use super::logarithm::{NAT, ln};
use super::parameters::{PARTS, Sizes, WHITE};

/// Grey levels of a frame, in 1/16: its darkest shadows, its tissue, its brightest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Levels {
    /// The 2nd percentile of the mean grey from a cell to the end of its line.
    pub dark: u16,
    /// The 60th percentile of grey.
    pub tissue: u16,
    /// The 98th percentile of grey.
    pub bright: u16,
}

/// A window around a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Window {
    /// From this cell on, from the cell itself.
    from: isize,
    /// Up to before this one.
    end: isize,
    /// 2²³ over its number of samples.
    reciprocal: u32,
}

/// Sums times reciprocals are means in units of 2⁻²³ of a grey level.
pub(super) const SHIFT: u32 = 23 - PARTS.trailing_zeros();

impl Window {
    /// From one cell to another, both within.
    pub(super) const fn new(from: isize, to: isize, stride: usize) -> Self {
        let cells = (to - from + 1) as u32;
        Window {
            from,
            end: to + 1,
            reciprocal: reciprocal(cells * stride as u32),
        }
    }

    /// The sums of the windows of consecutive cells.
    ///
    /// The windows of the first cell begin at `origin`.
    #[inline(always)]
    fn sums<'a>(&self, sums: &'a [u32], origin: usize) -> impl Iterator<Item = u32> + use<'a> {
        let [from, end] = [self.from, self.end].map(|offset| {
            let start = origin.saturating_add_signed(offset);
            sums.get(start..).unwrap_or_default()
        });
        from.iter()
            .zip(end)
            .map(|(from, end)| end.wrapping_sub(*from))
    }

    /// 2²³ times the mean over the part of a cell's window within its line.
    ///
    /// The line has `cells` cells; the result is 0 if no part is within.
    #[inline(always)]
    fn cut(&self, sum: u32, cell: i32, cells: i32, stride: i32) -> i32 {
        let from = (cell + self.from as i32).max(0);
        let end = (cell + self.end as i32).min(cells);
        scaled(sum, reciprocal(((end - from) * stride).max(0) as u32))
    }
}

const fn reciprocal(samples: u32) -> u32 {
    match (1u32 << 23).checked_div(samples) {
        Some(reciprocal) => reciprocal,
        None => 0,
    }
}

/// At most 255·2²³, which an `i32` holds.
#[inline(always)]
fn scaled(sum: u32, reciprocal: u32) -> i32 {
    sum.wrapping_mul(reciprocal) as i32
}

/// `gain·(x − centre)` within ±limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct RampPlan {
    /// Gain, 2⁻¹² scores for each 1/16 of a level; below 2¹⁷.
    gain: i32,
    /// Minus the gain times the centre.
    offset: i32,
    /// Limit, in scores.
    limit: i32,
}

impl RampPlan {
    /// Steeper ones are as steep as this.
    const STEEPEST: i32 = (1 << 17) - 1;

    /// `centre` in 1/16 of a grey level, `gain` in 2⁻¹² scores for each of them.
    pub(super) const fn new(centre: i32, gain: i32, limit: i32) -> Self {
        RampPlan {
            gain,
            offset: centre.wrapping_mul(gain).wrapping_neg(),
            limit,
        }
    }

    #[inline(always)]
    fn at(&self, x: i32) -> i32 {
        // The sum is below 2³¹, though its parts are not: x and the centre are below 2¹⁴.
        let value = x.wrapping_mul(self.gain).wrapping_add(self.offset) >> 12;
        value.min(self.limit).max(-self.limit)
    }
}

/// The plan of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Line {
    pub echo: Window,
    pub near: Window,
    pub far: Window,
    pub above: Window,
    pub below: Window,
    /// Floor, added to the onset.
    pub floor: u32,
    /// Weight of the onset's logarithm, in 1/1024.
    pub weight: i32,
    pub contrast: RampPlan,
    pub level: RampPlan,
    pub coherence: RampPlan,
    pub rest: RampPlan,
    /// Margin below the echo, 2²³ times a grey level.
    pub margin: i32,
    /// Offset of the first window of `rest` below a cell, cells.
    pub rest_from: usize,
    /// Windows of `rest`; the brightest one counts.
    pub rest_block: Window,
    /// Offset of the shadow that extends to the end below a cell, cells.
    pub shadow_from: usize,
    /// Centre, in 1/256 of the range from dark to tissue.
    pub shadow_centre: i32,
    /// Gain, 2⁻¹² scores from dark to tissue.
    pub shadow_gain: i32,
    pub shadow_limit: i32,
    /// Minimum range from dark to tissue.
    pub shadow_range: i32,
}

/// The means around a cell: 2²³ times a grey level, except for the last two.
struct Means {
    echo: i32,
    near: i32,
    far: i32,
    above: i32,
    below: i32,
    /// To the end of the line, in 1/16.
    shadow: i32,
    /// The brightest below, in 1/16.
    rest: i32,
}

impl Line {
    /// Sums of grey from the first cell to before each cell.
    ///
    /// `sums` begins `above` places earlier, with zeros, and ends with the sum of all.
    pub(super) fn sums(grey: &[u8], [stride, above]: [usize; 2], sums: &mut [u32]) {
        let (head, sums) = sums.split_at_mut_checked(above).unwrap_or_default();
        head.fill(0);
        let mut sum = 0u32;
        let mut entries = sums.iter_mut();
        if let Some(first) = entries.next() {
            *first = 0;
        }
        // Grey first, so that the iterator skips no place at the end.
        match stride {
            1 => {
                for (&level, entry) in grey.iter().zip(entries.by_ref()) {
                    sum = sum.wrapping_add(u32::from(level));
                    *entry = sum;
                }
            }
            2 => {
                for (&[a, b], entry) in grey.as_chunks::<2>().0.iter().zip(entries.by_ref()) {
                    sum = sum.wrapping_add(u32::from(a) + u32::from(b));
                    *entry = sum;
                }
            }
            4 => {
                for (cell, entry) in grey.as_chunks::<4>().0.iter().zip(entries.by_ref()) {
                    let [a, b, c, d] = cell.map(u32::from);
                    sum = sum.wrapping_add(a + b + c + d);
                    *entry = sum;
                }
            }
            _ => {
                for (cell, entry) in grey.chunks_exact(stride.max(1)).zip(entries.by_ref()) {
                    sum = cell
                        .iter()
                        .fold(sum, |sum, &level| sum.wrapping_add(u32::from(level)));
                    *entry = sum;
                }
            }
        }
        entries.for_each(|entry| *entry = sum);
    }

    /// The ramp of the shadow to the end, for a frame's levels.
    fn shadow(&self, levels: Levels) -> RampPlan {
        let [dark, tissue] = [levels.dark, levels.tissue].map(|level| i32::from(level).min(WHITE));
        let range = (tissue - dark).max(self.shadow_range).max(1);
        let centre = dark + ((self.shadow_centre * range) >> 8);
        let gain = self.shadow_gain / range;
        let gain = gain.clamp(-RampPlan::STEEPEST, RampPlan::STEEPEST);
        RampPlan::new(centre, gain, self.shadow_limit)
    }

    /// Scores of cells from the first of the search on.
    ///
    /// The initial contents of `scores` do not matter.
    pub(super) fn scores(&self, sums: &[u32], sizes: &Sizes, levels: Levels, scores: &mut [i32]) {
        let Sizes {
            cells,
            first,
            above,
            below,
            ..
        } = *sizes;
        let shadow = self.shadow(levels);
        self.brightest(sums, sizes, scores);
        // Cells whose windows are all within the line, between those some of whose are cut.
        let start = above.saturating_sub(first).min(scores.len());
        let end = cells.saturating_sub(below).saturating_sub(first);
        let end = end.min(scores.len()).max(start);
        let (head, rest) = scores.split_at_mut_checked(start).unwrap_or_default();
        let (whole, tail) = rest.split_at_mut_checked(end - start).unwrap_or_default();
        self.fill::<true>(sums, sizes, first, &shadow, head);
        self.fill::<false>(sums, sizes, first + start, &shadow, whole);
        self.fill::<true>(sums, sizes, first + end, &shadow, tail);
    }

    /// The brightest mean of a block that begins far enough below each cell, in 1/16.
    ///
    /// It is written in the place of the cell's score. A cell without such a block has the mean of the last.
    fn brightest(&self, sums: &[u32], sizes: &Sizes, rest: &mut [i32]) {
        let block = self.rest_block.end.unsigned_abs();
        let ends = sizes.above.saturating_add(sizes.cells).saturating_add(1);
        let ends = sums.get(..ends).unwrap_or_default();
        let ends = ends
            .get(sizes.above.saturating_add(block)..)
            .unwrap_or_default();
        let starts = sums.get(sizes.above..).unwrap_or_default();
        let starts = starts.get(..ends.len()).unwrap_or_default();
        // The cells for which blocks are left, and where these begin.
        let nearest = sizes.first.saturating_add(self.rest_from);
        let left = ends.len().saturating_sub(nearest).min(rest.len());
        let (beside, beyond) = rest.split_at_mut_checked(left).unwrap_or_default();
        let beside_end = nearest.saturating_add(left).min(ends.len());
        let (ends, ends_below) = ends.split_at_checked(beside_end).unwrap_or_default();
        let (starts, starts_below) = starts.split_at_checked(beside_end).unwrap_or_default();
        let sum = |(start, end): (&u32, &u32)| end.wrapping_sub(*start);
        let reciprocal = self.rest_block.reciprocal;
        let mean = |brightest: u32| scaled(brightest, reciprocal) >> SHIFT;
        let below = || starts_below.iter().zip(ends_below).map(sum);
        let beside_blocks = || starts.iter().zip(ends).map(sum);
        let last = below().next_back().or_else(|| beside_blocks().next_back());
        beyond.fill(mean(last.unwrap_or(0)));
        let mut brightest = below().fold(0, u32::max);
        for (entry, sum) in beside.iter_mut().rev().zip(beside_blocks().rev()) {
            brightest = brightest.max(sum);
            *entry = mean(brightest);
        }
    }

    /// Adds the term of coherence to the scores of cells from the first of the search on.
    ///
    /// `sums` are those of a line's coherence.
    pub(super) fn add_coherence(&self, sums: &[u32], sizes: &Sizes, scores: &mut [i32]) {
        let (stride, cells) = (sizes.stride as i32, sizes.cells as i32);
        let below = self
            .below
            .sums(sums, sizes.above.saturating_add(sizes.first));
        for (cell, (sum, score)) in (sizes.first as i32..).zip(below.zip(scores)) {
            let mean = self.below.cut(sum, cell, cells, stride) >> SHIFT;
            *score += self.coherence.at(mean);
        }
    }

    /// Scores of cells from `first` on; `CUT`: some of their windows are cut.
    #[inline(never)]
    fn fill<const CUT: bool>(
        &self,
        sums: &[u32],
        sizes: &Sizes,
        first: usize,
        shadow: &RampPlan,
        scores: &mut [i32],
    ) {
        let origin = sizes.above.saturating_add(first);
        let (stride, cells) = (sizes.stride as i32, sizes.cells as i32);
        let total = sums.last().copied().unwrap_or_default();
        let to_end = sums
            .get(origin.saturating_add(self.shadow_from)..)
            .unwrap_or_default();
        let mut samples = (cells - first as i32 - self.shadow_from as i32) * stride;
        let sums = |window: &Window| window.sums(sums, origin);
        let onset = sums(&self.echo).zip(sums(&self.near)).zip(sums(&self.far));
        let level = sums(&self.above).zip(sums(&self.below));
        let all = onset.zip(level).zip(to_end).zip(scores);
        for (cell, (((((echo, near), far), (above, below)), to_end), score)) in
            (first as i32..).zip(all)
        {
            let mean_of = |window: &Window, sum: u32| match CUT {
                true => window.cut(sum, cell, cells, stride),
                false => scaled(sum, window.reciprocal),
            };
            let means = Means {
                echo: mean_of(&self.echo, echo),
                near: mean_of(&self.near, near),
                far: mean_of(&self.far, far),
                above: mean_of(&self.above, above),
                below: mean_of(&self.below, below),
                shadow: mean(total.wrapping_sub(*to_end), samples),
                rest: *score,
            };
            *score = self.score(&means, shadow);
            samples -= stride;
        }
    }

    #[inline(always)]
    fn score(&self, means: &Means, shadow: &RampPlan) -> i32 {
        let above = |below: i32| ((means.echo - below) >> SHIFT).max(0) as u32;
        // At most (255·16)², below 2²⁴.
        let onset = above(means.near).wrapping_mul(above(means.far));
        let onset = ln(onset.wrapping_add(self.floor)) - ln((WHITE * WHITE) as u32);
        let contrast = self.contrast.at((means.echo - means.above) >> SHIFT);
        // The margin is at most white, so that the difference fits.
        let reference = means.above.max(means.echo - self.margin);
        let level = self.level.at((reference - means.below) >> SHIFT);
        let rest = self.rest.at((reference >> SHIFT) - means.rest);
        let onset = (onset * self.weight) >> NAT.trailing_zeros();
        onset + contrast + level + rest + shadow.at(means.shadow)
    }
}

/// In 1/16.
#[inline(always)]
fn mean(sum: u32, samples: i32) -> i32 {
    (sum.wrapping_mul(PARTS as u32) / samples.max(1) as u32) as i32
}
