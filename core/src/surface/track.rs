//! Path of the surface over the lines, by Viterbi's algorithm.

use core::iter::once;

use super::detector::Detector;
use super::logarithm::NAT;
use super::onset::{Levels, Line};
use super::parameters::{AROUND, Prices, Sizes};
use crate::Error;
use crate::error::check_length;
use crate::instructions::integers;
use crate::memory::Scratch;
use crate::simd::split_front;

/// The surface in a line.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Point {
    /// Depth along the line, m.
    ///
    /// The depth is that of a straight line, fitted to the centres of the echo in the line and in up to three lines of
    /// the same piece on either side. The weights of the least-squares fit are 4 for the line itself, and 3, 2, 1 for
    /// its neighbours.
    pub depth: f32,
    /// Confidence, from 0 to 1.
    ///
    /// An estimate of the share of such points that are on bone, by the settings' `confidence`.
    pub confidence: f32,
    /// Whether a piece of surface begins here.
    ///
    /// If so, the line before has no surface, or one at the distance of a jump or of more than the settings' `step`.
    pub begins: bool,
}

/// Origin of the path to a cell, in seven bits, and the cell's score, in nine.
///
/// 127 to 65: a cell 0 to 62 above. 64 to 3: a cell 1 to 62 below. Then a jump from the best of the line before, and a
/// start. Paths of equal value are chosen in this order. Scores are in 1/32 nat from −10 to below 6.
#[derive(Clone, Copy)]
struct Pointer(u16);

impl Pointer {
    /// The cell itself.
    const HERE: i32 = 127;
    /// Code of a cell below: this less the number of cells.
    const BELOW: i32 = 65;
    const JUMP: i32 = 1;
    const START: i32 = 0;
    /// Bits of the origin, below the bits of a path's value.
    const BITS: u32 = 7;
    const ORIGIN: i32 = (1 << Self::BITS) - 1;

    #[inline(always)]
    fn packed(origin: i32, score: i32) -> u16 {
        let score = ((score >> 5) + 320).clamp(0, 511);
        ((score << Self::BITS) | origin) as u16
    }

    fn origin(self) -> i32 {
        i32::from(self.0) & Self::ORIGIN
    }

    /// In 1/32 nat above −10.
    fn score(self) -> i32 {
        i32::from(self.0 >> Self::BITS)
    }
}

/// Value of an impossible path; all others are above half of it.
const NEVER: i32 = -(1 << 23);

/// A detector with its memory, working on the lines of a frame.
///
/// ```
/// use bonebeam::geometry::Axis;
/// use bonebeam::memory::Scratch;
/// use bonebeam::surface::{Detector, Levels, Parameters, Settings, Tracker};
///
/// let samples = Axis { first: 0.0, step: 0.1e-3, count: 300 };
/// let detector = Detector::new(Parameters { samples, spacing: 0.3e-3, settings: Settings::DEFAULT, latency: 5 })?;
/// let mut real = vec![0.0; detector.need().real];
/// let scratch = Scratch { real: &mut real, complex: &mut [] };
/// let mut tracker = Tracker::new(&detector, scratch)?;
///
/// let mut line = [100; 300];
/// line[118..122].fill(250);
/// line[122..].fill(10);
/// let levels = Levels { dark: 160, tissue: 1600, bright: 4000 };
/// let mut depths = vec![];
/// for _ in 0..12 {
///     // Nothing for five lines, then what the sixth line before has.
///     depths.extend(tracker.line(&line, levels)?.flatten().map(|point| point.depth));
/// }
/// assert_eq!(depths.len(), 7);
/// tracker.finish(|point| depths.extend(point.map(|point| point.depth)));
/// assert_eq!(depths.len(), 12);
/// # Ok::<(), bonebeam::Error>(())
/// ```
pub struct Tracker<'p, 'm> {
    detector: &'p Detector,
    sums: &'m mut [u32],
    scores: &'m mut [i32],
    /// Value of the best path to each cell of the last line, times 128.
    ///
    /// It is relative to the best of the line before.
    values: &'m mut [i32],
    /// Value of the best path from below, times 128, with its origin.
    below: &'m mut [i32],
    /// Back pointers `[line][cell]`, as a ring.
    pointers: &'m mut [u16],
    /// Ring over lines: the best cell of the line before.
    ///
    /// Bit 16 is set if absence comes from there.
    heads: &'m mut [u32],
    /// Ring over lines: the path's cell plus one, or 0; bit 31 if a piece begins there.
    path: &'m mut [u32],
    /// Lines so far.
    lines: usize,
    /// Number of those lines that are decided.
    decided: usize,
    /// The best path to a cell of the last line.
    best: Best,
    /// The best path that ends in absence.
    absent: i32,
}

/// The largest value of a line, and its first cell.
#[derive(Clone, Copy)]
struct Best {
    value: i32,
    cell: u32,
}

/// Distance of the largest score below the centre of an echo, cells.
///
/// Measured on simulated bones. The terms of the shadow grow with depth.
const BELOW_ECHO: f32 = 0.15;
/// Bit in [`Tracker::path`].
const BEGINS: u32 = 1 << 31;
/// Bit in [`Tracker::heads`].
const FROM_CELL: u32 = 1 << 16;

impl<'p, 'm> Tracker<'p, 'm> {
    /// A tracker before its first line, in memory of [`Detector::need`].
    ///
    /// # Errors
    /// [`Error::Length`] if the memory is shorter.
    pub fn new(detector: &'p Detector, scratch: Scratch<'m>) -> Result<Self, Error> {
        scratch.check(detector.need())?;
        let Sizes { searched, kept, .. } = detector.sizes;
        let mut real = scratch.real;
        let pointers = kept.saturating_mul(searched).div_ceil(2);
        let mut tracker = Tracker {
            detector,
            sums: integers(split_front(&mut real, detector.sizes.sums())),
            scores: integers(split_front(&mut real, searched)),
            values: integers(split_front(&mut real, searched)),
            below: integers(split_front(&mut real, searched)),
            pointers: integers(split_front(&mut real, pointers)),
            heads: integers(split_front(&mut real, kept)),
            path: integers(split_front(&mut real, kept)),
            lines: 0,
            decided: 0,
            best: Best {
                value: NEVER,
                cell: 0,
            },
            absent: 0,
        };
        tracker.begin();
        Ok(tracker)
    }

    /// Resets the tracker to before the first line of a frame.
    fn begin(&mut self) {
        self.values.fill(NEVER << Pointer::BITS);
        self.heads.fill(0);
        self.path.fill(0);
        (self.lines, self.decided, self.absent) = (0, 0, 0);
        self.best = Best {
            value: NEVER,
            cell: 0,
        };
    }

    /// Takes the next line; returns the point, or none, of a line that it decides.
    ///
    /// Lines come from left to right. The decided line is `latency` lines before; the first `latency` lines decide
    /// none. `levels` are those of the frame or of the previous frame.
    ///
    /// # Errors
    /// [`Error::Length`] if the number of samples differs from the parameters'.
    pub fn line(&mut self, grey: &[u8], levels: Levels) -> Result<Option<Option<Point>>, Error> {
        self.line_of(grey, None, levels)
    }

    /// [`Tracker::line`] with the coherence of each sample.
    ///
    /// A coherence of 0 or less is coded as 0, a coherence of 1 as 255. Its term is the settings'
    /// [`coherence`](super::Settings::coherence).
    ///
    /// # Errors
    /// As [`Tracker::line`], for both slices.
    pub fn line_with_coherence(
        &mut self,
        grey: &[u8],
        coherence: &[u8],
        levels: Levels,
    ) -> Result<Option<Option<Point>>, Error> {
        self.line_of(grey, Some(coherence), levels)
    }

    pub(super) fn line_of(
        &mut self,
        grey: &[u8],
        coherence: Option<&[u8]>,
        levels: Levels,
    ) -> Result<Option<Option<Point>>, Error> {
        let Detector {
            sizes,
            line,
            learnt,
            ..
        } = self.detector;
        let parameters = self.detector.parameters();
        check_length("line", grey.len(), parameters.samples.count)?;
        if let Some(coherence) = coherence {
            check_length("coherence", coherence.len(), parameters.samples.count)?;
        }
        let shape = [sizes.stride, sizes.above];
        Line::sums(grey, shape, self.sums);
        match learnt {
            Some(learnt) => learnt.scores(self.sums, sizes, levels, self.below, self.scores),
            None => line.scores(self.sums, sizes, levels, self.scores),
        }
        if let Some(coherence) = coherence {
            Line::sums(coherence, shape, self.sums);
            line.add_coherence(self.sums, sizes, self.scores);
        }
        self.step();
        if self.lines <= parameters.latency {
            return Ok(None);
        }
        self.trace(parameters.latency.saturating_add(AROUND));
        Ok(Some(self.decide()))
    }

    /// Passes the undecided lines to `take`, in their order.
    ///
    /// The next line is then the first of another frame.
    pub fn finish(&mut self, mut take: impl FnMut(Option<Point>)) {
        let undecided = self.lines.saturating_sub(self.decided);
        self.trace(undecided.saturating_add(AROUND));
        for _ in 0..undecided {
            take(self.decide());
        }
        self.begin();
    }

    /// The best paths to all cells of the next line, by its scores.
    fn step(&mut self) {
        let Sizes { searched, kept, .. } = self.detector.sizes;
        let prices = &self.detector.prices;
        let slot = self.lines.checked_rem(kept).unwrap_or(0);
        let start = slot.saturating_mul(searched);
        let pointers = self.pointers.get_mut(start..).unwrap_or_default();
        let pointers = pointers.get_mut(..searched).unwrap_or_default();
        from_below(self.values, prices.step, self.below);
        let Best { value, cell } = self.best;
        // At the first line a surface exists without a start.
        let started = match self.lines {
            0 => 0,
            _ => self.absent - prices.end,
        };
        let jumped = value - prices.jump;
        let packed = |value: i32, origin: i32| (value << Pointer::BITS) | origin;
        let other = packed(jumped, Pointer::JUMP).max(packed(started, Pointer::START));
        // Values stay small: they count from the best of the line before.
        let base = if self.lines == 0 { 0 } else { value };
        let ended = value - prices.end;
        let head = if ended > self.absent { FROM_CELL } else { 0 };
        self.absent = self.absent.max(ended) - base + prices.absent;
        if let Some(entry) = self.heads.get_mut(slot) {
            *entry = head | cell;
        }
        let cells = Cells {
            scores: self.scores,
            below: self.below,
            values: self.values,
            pointers,
        };
        self.best = cells.step(prices, other, base);
        self.lines = self.lines.saturating_add(1);
    }

    /// Follows the best path from the last line back over `before` lines, or to the first.
    fn trace(&mut self, before: usize) {
        let Sizes { searched, kept, .. } = self.detector.sizes;
        let mut cell = (self.best.value >= self.absent).then_some(self.best.cell);
        let lines = self.lines;
        for back in 0..before.saturating_add(1).min(lines).min(kept) {
            let slot = (lines - 1 - back).checked_rem(kept).unwrap_or(0);
            let head = self.heads.get(slot).copied().unwrap_or_default();
            let best = head & (FROM_CELL - 1);
            let mut mark = 0;
            let previous = match cell {
                None => (head & FROM_CELL != 0).then_some(best),
                Some(cell) => {
                    let index = slot.saturating_mul(searched).saturating_add(cell as usize);
                    let pointer = self.pointers.get(index).copied().unwrap_or_default();
                    let origin = Pointer(pointer).origin();
                    mark = cell + 1;
                    match origin {
                        Pointer::START => {
                            mark |= BEGINS;
                            None
                        }
                        Pointer::JUMP => {
                            mark |= BEGINS;
                            Some(best)
                        }
                        _ => {
                            // Cells down to where the path comes from.
                            let down = match origin < Pointer::BELOW {
                                true => Pointer::BELOW - origin,
                                false => origin - Pointer::HERE,
                            };
                            if down.unsigned_abs() > self.detector.prices.most {
                                mark |= BEGINS;
                            }
                            Some(cell.saturating_add_signed(down))
                        }
                    }
                }
            };
            if let Some(entry) = self.path.get_mut(slot) {
                *entry = mark;
            }
            cell = previous;
        }
    }

    /// The point of the first line that is not decided, by the path.
    fn decide(&mut self) -> Option<Point> {
        let line = self.decided;
        self.decided = self.decided.saturating_add(1);
        let (cell, begins) = self.at(line)?;
        let (offset, margin) = self.fit(line, cell, begins);
        Some(Point {
            depth: self.detector.depth(cell as usize, offset),
            confidence: self.confidence(margin),
            begins,
        })
    }

    /// The path's cell in a line, and whether a piece begins there.
    fn at(&self, line: usize) -> Option<(u32, bool)> {
        let slot = line.checked_rem(self.detector.sizes.kept)?;
        let mark = self.path.get(slot).copied()?;
        let cell = (mark & !BEGINS).checked_sub(1)?;
        Some((cell, mark & BEGINS != 0))
    }

    /// The back pointers of a line.
    fn pointers(&self, line: usize) -> &[u16] {
        let Sizes { searched, kept, .. } = self.detector.sizes;
        let slot = line.checked_rem(kept).unwrap_or(0);
        let pointers = self.pointers.get(slot.saturating_mul(searched)..);
        let pointers = pointers.and_then(|pointers| pointers.get(..searched));
        pointers.unwrap_or_default()
    }

    /// Up to [`AROUND`] lines before a line in the same piece, and their cells, the nearest first.
    fn before(&self, line: usize, begins: bool) -> impl Iterator<Item = (usize, u32)> {
        let mut begun = begins;
        (1..=AROUND).map_while(move |back| {
            let line = line.checked_sub(back).filter(|_| !begun)?;
            let (cell, begins) = self.at(line)?;
            begun = begins;
            Some((line, cell))
        })
    }

    /// The same after a line.
    fn after(&self, line: usize) -> impl Iterator<Item = (usize, u32)> {
        let lines = line + 1..self.lines.min(line + 1 + AROUND);
        lines.map_while(|line| match self.at(line)? {
            (cell, false) => Some((line, cell)),
            _ => None,
        })
    }

    /// Offset of a point's depth, in cells below its cell, and the mean of the scores above absence.
    ///
    /// Both extend over lines on either side of the same piece. The mean is over up to [`AROUND`] lines a side. The depth
    /// is that of the straight line through the echo's centres, a fit by least squares with weights that fall evenly, to
    /// 0 at [`AROUND`] lines.
    fn fit(&self, line: usize, cell: u32, begins: bool) -> (f32, f32) {
        let (mut scores, mut count) = (0.0, 0.0);
        // Sums of weights times powers of the distance, and times depths.
        let (mut w, mut wx, mut wxx, mut wz, mut wxz) = (0.0, 0.0, 0.0, 0.0, 0.0);
        let beside = self.before(line, begins).chain(self.after(line));
        for (at, other) in once((line, cell)).chain(beside) {
            let pointers = self.pointers(at);
            let pointer = pointers.get(other as usize).copied();
            scores += Pointer(pointer.unwrap_or_default()).score() as f32 / 32.0 - 10.0;
            count += 1.0;
            let x = at as f32 - line as f32;
            let weight = AROUND as f32 - x.abs();
            if weight > 0.0 {
                let z = other as f32 - cell as f32 + centre(pointers, other);
                w += weight;
                wx += weight * x;
                wxx += weight * x * x;
                wz += weight * z;
                wxz += weight * x * z;
            }
        }
        let divisor = w * wxx - wx * wx;
        let fitted = if divisor > 0.0 {
            (wz * wxx - wxz * wx) / divisor
        } else {
            wz / w
        };
        let absence = self.detector.prices.absence as f32 / NAT as f32;
        (fitted - BELOW_ECHO, scores / count - absence)
    }

    fn confidence(&self, margin: f32) -> f32 {
        let [a, b] = self.detector.parameters().settings.confidence;
        1.0 / (1.0 + libm::expf(-(a + b * margin)))
    }
}

/// Centroid of the scores of a cell and two on either side, in cells below it.
///
/// Scores count from a nat below the largest. The centroid is the cell itself if fewer cells are searched.
fn centre(pointers: &[u16], cell: u32) -> f32 {
    let from = cell.checked_sub(2);
    let from = from.and_then(|from| pointers.get(from as usize..));
    let Some(&around) = from.and_then(|pointers| pointers.first_chunk::<5>()) else {
        return 0.0;
    };
    let scores = around.map(|pointer| Pointer(pointer).score());
    let least = scores.into_iter().fold(0, i32::max) - 32;
    let [a, b, c, d, e] = scores.map(|score| (score - least).max(0));
    (2 * (e - a) + d - b) as f32 / (a + b + c + d + e) as f32
}

/// The best paths from cells below, and the number of cells of each.
///
/// With each further cell a path's value falls by a step and its origin by 1, in one subtraction.
#[inline(never)]
fn from_below(values: &[i32], step: i32, below: &mut [i32]) {
    let step = (step << Pointer::BITS) + 1;
    let mut run = NEVER << Pointer::BITS;
    for (&value, below) in values.iter().zip(below).rev() {
        run -= step;
        *below = run;
        run = run.max(value | Pointer::BELOW);
    }
}

/// A line's cells.
struct Cells<'a> {
    scores: &'a [i32],
    below: &'a [i32],
    /// Values of the line before, overwritten with those of this line.
    values: &'a mut [i32],
    pointers: &'a mut [u16],
}

impl Cells<'_> {
    /// Takes the first of the best paths from above, from below and the other.
    ///
    /// Adds the cell's score.
    #[inline(never)]
    fn step(self, prices: &Prices, other: i32, base: i32) -> Best {
        let step = (prices.step << Pointer::BITS) + 1;
        let base = base << 8;
        let (mut best, mut best_cell) = (i32::MIN, 0);
        let mut run = NEVER << Pointer::BITS;
        let cells = self.scores.iter().zip(self.below).zip(self.values);
        for (((&score, &below), value), (pointer, cell)) in
            cells.zip(self.pointers.iter_mut().zip(0u32..))
        {
            run = (run - step).max(*value | Pointer::HERE);
            let path = run.max(below).max(other);
            let origin = path & Pointer::ORIGIN;
            let own = (score * prices.factor - base) >> 8;
            let sum = path - origin + (own << Pointer::BITS);
            (*value, *pointer) = (sum, Pointer::packed(origin, score));
            if sum > best {
                (best, best_cell) = (sum, cell);
            }
        }
        Best {
            value: best >> Pointer::BITS,
            cell: best_cell,
        }
    }
}
