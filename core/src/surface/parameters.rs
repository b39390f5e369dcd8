//! Parameters of a detector, and its memory.

use crate::Error;
use crate::error::{attempt, positive};
use crate::geometry::Axis;
use crate::memory::Need;

/// Fractions of a grey level in means.
pub(super) const PARTS: i32 = 16;
/// White, in these fractions.
pub(super) const WHITE: i32 = 255 * PARTS;

/// No window is as long as this, m.
const LONGEST: f64 = 1.0;
/// Numbers of both histograms of a frame.
pub(super) const HISTOGRAMS: usize = 512;

/// A term of the score: `weight·clip((x − centre)/width, −1, 1)`, in nats.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ramp {
    /// Largest amount that the term adds or subtracts, nats.
    ///
    /// 0 disables the term. If negative, the term falls with `x`.
    pub weight: f64,
    /// Value of `x` at which the term is 0.
    pub centre: f64,
    /// Distance from the centre to the saturation of the term, above 0.
    pub width: f64,
}

impl Ramp {
    /// The term of a weight, a centre and a width.
    pub const fn new(weight: f64, centre: f64, width: f64) -> Self {
        Ramp {
            weight,
            centre,
            width,
        }
    }
}

/// Windows, terms and prices. Grey levels range from 0, black, to 1, white.
///
/// The score of a cell is `onset_weight·ln(o + onset_floor) + contrast + level + rest + shadow`:
///
/// - shadow onset `o = max(B − S₁, 0)·max(B − S₂, 0)`, with `B` the mean grey within ±`echo`, `S₁` that of `near`
///   and `S₂` that of `far` below the cell;
/// - `contrast`, a [`Ramp`] of `B − U`: the echo less the mean grey of `above` above the cell;
/// - `level`, a ramp of `R − D`: the reference `R = max(U, B − margin)` less the mean grey of `below` below the cell;
/// - `rest`, a ramp of `R − M`, with `M` the brightest mean grey of any `rest_block` that begins `rest_from` or more
///   below the cell. Below bone nothing is as bright as the tissue above it; below a fascia there is tissue of that
///   level;
/// - `shadow`, a ramp of `(E − d)/max(t − d, shadow_range)`, with `E` the mean grey from `shadow_from` below the
///   cell to the end of the line, `d` and `t` the frame's dark and tissue ([`Levels`](super::Levels)).
///
/// A strong echo is its own reference `R`: in water there is no tissue above it, and clutter may fill its shadow.
///
/// Windows are cut at the ends of the line.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Settings {
    /// Whether scores come from the learnt model in place of the terms.
    ///
    /// It was trained on drawn pictures. Its lengths are fixed, for cells of 0.05 to 0.3 mm. The settings' windows and terms then have no effect.
    pub learnt: bool,
    /// Minimum length of a cell, m. A cell has the fewest samples of this length.
    pub cell: f64,
    /// Half the window of the echo, m.
    pub echo: f64,
    /// Nearest and farthest depth of the first shadow window below the echo, m.
    pub near: [f64; 2],
    /// Nearest and farthest depth of the second shadow window below the echo, m.
    pub far: [f64; 2],
    /// Floor added to the onset, which bounds its logarithm.
    pub onset_floor: f64,
    /// Weight of the logarithm of the onset.
    pub onset_weight: f64,
    /// Nearest and farthest distance of the tissue window above the cell, m.
    pub above: [f64; 2],
    /// Nearest and farthest distance of the shadow window below the cell, m.
    pub below: [f64; 2],
    /// Margin of an echo above its own reference `R`, 0 to 1.
    ///
    /// 1 disables it: only the tissue counts.
    pub margin: f64,
    /// Term of the echo's contrast with the tissue above.
    pub contrast: Ramp,
    /// Term of the change of level from `above` to `below`.
    pub level: Ramp,
    /// Term of the brightest level below, relative to the tissue above.
    pub rest: Ramp,
    /// Distance from the cell to the beginning of `rest`, m.
    pub rest_from: f64,
    /// Length of a mean of `rest`, m.
    pub rest_block: f64,
    /// Distance from the cell to the shadow that extends to the end of the line, m.
    pub shadow_from: f64,
    /// Term of that shadow's mean, from the frame's dark (0) to its tissue (1).
    pub shadow: Ramp,
    /// Minimum range from dark to tissue.
    ///
    /// In a frame without a shadow the measured range is small.
    pub shadow_range: f64,
    /// Term of the mean coherence of `below` below the cell, 0 to 1.
    ///
    /// Clutter that fills a shadow has little coherence. The term is absent without a map of coherence
    /// ([`Tracker::line_with_coherence`](super::Tracker::line_with_coherence)).
    pub coherence: Ramp,
    /// Depths of the search, m: the first and the last, which may be infinite.
    ///
    /// The search ends where the near window still fits above the line's end.
    pub depths: [f64; 2],
    /// Score of a line without bone, nats.
    pub absence: f64,
    /// Price of each start and of each end of a surface, nats.
    pub end: f64,
    /// Price of a jump to any other depth, nats; at most that of a move by 62 cells.
    pub jump: f64,
    /// Price of a move in depth from line to line, nats per m.
    ///
    /// A move that costs more than `jump` is a jump.
    pub slope: f64,
    /// Greatest change in depth from line to line within a piece, m; may be infinite.
    pub step: f64,
    /// Spacing of lines whose scores count fully, m.
    ///
    /// Scores of closer lines count less, in proportion.
    pub spacing: f64,
    /// Coefficients `a` and `b` of a point's confidence.
    ///
    /// The confidence is `1/(1 + e^−(a + b·m))`, with `m` the mean of the scores above absence, in nats, of up to
    /// four lines on either side of the same piece.
    pub confidence: [f32; 2],
    /// Least mean confidence of a piece of a whole frame.
    ///
    /// [`Detector::keep_sure_pieces`](super::Detector::keep_sure_pieces) leaves out the others.
    pub piece: f32,
}

impl Settings {
    /// Settings for lines of channel data, with 60 dB of grey levels.
    ///
    /// Tuned on simulated vertebrae in layers of tissue and in water, clean and disturbed, also with clutter that fills
    /// the shadow.
    pub const DEFAULT: Settings = Settings {
        learnt: false,
        cell: 0.12e-3,
        echo: 0.15e-3,
        near: [0.5e-3, 2e-3],
        far: [1.5e-3, 6e-3],
        onset_floor: 1e-4,
        onset_weight: 1.0,
        above: [0.3e-3, 10e-3],
        below: [0.6e-3, 10e-3],
        margin: 0.26,
        contrast: Ramp::new(1.94, 0.26, 0.43),
        level: Ramp::new(0.98, -0.1, 0.145),
        rest: Ramp::new(1.58, 0.012, 0.056),
        rest_from: 1.5e-3,
        rest_block: 1e-3,
        shadow_from: 1.5e-3,
        shadow: Ramp::new(-0.58, 0.253, 0.325),
        shadow_range: 0.063,
        coherence: Ramp::new(0.0, 0.12, 0.05),
        depths: [5e-3, f64::INFINITY],
        absence: -2.35,
        end: 8.0,
        jump: 8.5,
        slope: 2.5e3,
        step: f64::INFINITY,
        spacing: 0.308e-3,
        confidence: [0.96, 0.69],
        piece: 0.0,
    };

    /// Settings for lines of channel data with a map of coherence.
    ///
    /// The map is [`ShortLagCoherence`](crate::beamform::ShortLagCoherence) over ±0.4 mm. Tuned as
    /// [`Settings::DEFAULT`].
    pub const COHERENCE: Settings = Settings {
        coherence: Ramp {
            weight: -0.85,
            ..Self::DEFAULT.coherence
        },
        rest: Ramp {
            weight: 1.85,
            ..Self::DEFAULT.rest
        },
        shadow: Ramp {
            weight: -1.1,
            ..Self::DEFAULT.shadow
        },
        absence: -2.4,
        ..Self::DEFAULT
    };

    /// Settings for scanner pictures, with the learnt model.
    ///
    /// It takes the place of the terms, over lines 0.12 to 0.25 mm apart.
    /// The model and the prices were trained on drawn pictures of bone and of other tissue, displayed as on scanners.
    pub const LEARNT: Settings = Settings {
        learnt: true,
        cell: 0.1e-3,
        near: [0.5e-3, 1.5e-3],
        far: [1e-3, 1.5e-3],
        depths: [2e-3, f64::INFINITY],
        absence: -1.5,
        end: 10.0,
        jump: 12.0,
        slope: 1.5e3,
        step: 1.5e-3,
        confidence: [-1.15, 0.94],
        piece: 0.56,
        ..Self::DEFAULT
    };
}

impl Default for Settings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Parameters of a [`Detector`](super::Detector).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameters {
    /// The depths of a line's samples, at most 65,536 of them.
    pub samples: Axis,
    /// Spacing of lines, m.
    pub spacing: f64,
    /// Windows, terms and prices.
    pub settings: Settings,
    /// Number of further lines before the surface of a line is decided.
    ///
    /// At most 16,383. With the number of lines less one, the surface is the best of the whole frame.
    pub latency: usize,
}

/// Sizes that follow from the parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Sizes {
    /// Samples of a cell.
    pub stride: usize,
    /// Cells of a line.
    pub cells: usize,
    /// Farthest reach of the windows above and below a cell, cells.
    pub above: usize,
    pub below: usize,
    /// First cell of the search.
    pub first: usize,
    /// Number of cells of the search.
    pub searched: usize,
    /// Number of lines whose back pointers are kept.
    pub kept: usize,
}

/// Lines on either side that depth and confidence may use.
pub(super) const AROUND: usize = 4;

impl Parameters {
    const MAX_SAMPLES: usize = 1 << 16;
    const MAX_LATENCY: usize = (1 << 14) - 1;

    /// Memory of a [`Tracker`](super::Tracker) and of [`Detector::frame`](super::Detector::frame).
    ///
    /// Real numbers only: with `n` cells in the settings' depths, `3·n + n/2·(latency + 5)` plus a few hundred.
    ///
    /// # Errors
    /// [`Error::Parameter`] or [`Error::Capacity`], naming the parameter: samples that do not ascend, or are too many
    /// or too few for the windows; a spacing that is not positive.
    pub const fn need(&self) -> Result<Need, Error> {
        Ok(attempt!(self.sizes()).need())
    }

    pub(super) const fn sizes(&self) -> Result<Sizes, Error> {
        attempt!(self.samples.check("samples"));
        attempt!(positive("line spacing", self.spacing));
        if self.samples.count > Self::MAX_SAMPLES {
            return Err(Error::capacity(
                "samples",
                self.samples.count,
                Self::MAX_SAMPLES,
            ));
        }
        if self.latency > Self::MAX_LATENCY {
            return Err(Error::capacity("latency", self.latency, Self::MAX_LATENCY));
        }
        let Settings { depths, near, .. } = self.settings;
        attempt!(window("near", near));
        if !(depths[0] < depths[1] && depths[0].is_finite()) {
            let expected = "a finite depth, below the second";
            return Err(Error::parameter("depths", depths[0], expected));
        }
        // The casts truncate and saturate; negative numbers become 0.
        attempt!(positive("cell", self.settings.cell));
        let quotient = self.settings.cell * (1.0 - 1e-9) / self.samples.step;
        let stride = (quotient as usize).saturating_add(1);
        let cells = match self.samples.count.checked_div(stride) {
            Some(cells) => cells,
            None => 0,
        };
        let cell = stride as f64 * self.samples.step;
        let first = cells_of(depths[0] - self.samples.first, cell);
        let end = cells_of(depths[1] - self.samples.first, cell);
        // The near window follows below the last cell.
        let last = cells.saturating_sub(cells_of(near[1], cell));
        let end = if end < last { end } else { last };
        if end < first.saturating_add(3) {
            let expected = "the first of the depths, three cells, and the near window below them";
            let value = self.samples.last();
            return Err(Error::parameter("end of the lines (m)", value, expected));
        }
        let Settings {
            echo,
            far,
            above,
            below,
            shadow_from,
            ..
        } = self.settings;
        attempt!(window("echo", [0.0, echo]));
        attempt!(window("far", far));
        attempt!(window("above", above));
        attempt!(window("below", below));
        attempt!(window("shadow_from", [0.0, shadow_from]));
        let farthest = longer(longer(far[1], near[1]), longer(below[1], shadow_from));
        Ok(Sizes {
            stride,
            cells,
            above: cells_of(longer(echo, above[1]), cell),
            below: cells_of(longer(echo, farthest), cell) + 1,
            first,
            searched: end - first,
            kept: self.latency + 1 + AROUND,
        })
    }
}

impl Sizes {
    /// Memory of a tracker, in real numbers.
    ///
    /// Sums and scores of a line, the path's values and those of paths from below; a back pointer for each cell; two
    /// numbers for each line.
    pub(super) const fn need(self) -> Need {
        let line = self.sums() + 3 * self.searched;
        let pointers = self.kept.saturating_mul(self.searched).div_ceil(2);
        let lines = 2 * self.kept;
        Need::real(pointers.saturating_add(line + lines + HISTOGRAMS))
    }
}

impl Sizes {
    /// Sums of a line, with those above and below it.
    pub(super) const fn sums(self) -> usize {
        self.above + self.cells + 1 + self.below
    }
}

const fn longer(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The nearest number of cells to a length; none for one below 0.
pub(super) const fn cells_of(length: f64, cell: f64) -> usize {
    (length / cell + 0.5) as usize
}

/// Refuses a window that is not two lengths from 0 on, the second at least the first.
pub(super) const fn window(name: &'static str, [from, to]: [f64; 2]) -> Result<(), Error> {
    if from >= 0.0 && from <= to && to < LONGEST {
        return Ok(());
    }
    let expected = "lengths of at least 0 and below 1 m, the first at most the second";
    Err(Error::parameter(
        name,
        if from >= 0.0 && from <= to { to } else { from },
        expected,
    ))
}

/// Prices as scores, [`Settings`](super::Settings).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Prices {
    /// Score of a line without bone.
    pub absence: i32,
    /// Most cells of a move within a piece.
    pub most: u32,
    /// `absence`, scaled by the weight of a line.
    pub absent: i32,
    /// Price of a start and of an end.
    pub end: i32,
    pub jump: i32,
    /// Price of a move by a cell.
    pub step: i32,
    /// Weight of a line, in 1/256.
    pub factor: i32,
}

impl Prices {
    /// The farthest move that is not a jump, cells.
    pub(super) const FARTHEST: i32 = 62;
}
