//! Five octave scales of phase symmetry from four: a low-rank radial basis.
//!
//! Over `ln r` the radial factors of Eq. 9 are equal bells, `g_k = exp(−(ln r − ln r_k)²/(2·s²))`,
//! `s = ln 0.15`, so wide that five of them, each an octave (`δ = −ln 2`) from the one before, nearly
//! span four dimensions. With `y = exp(δ·ln(r/r₂)/s²)` and `q = exp(−δ²/(2·s²))` each is the middle
//! one times a power of y, `g_{2+j} = g₂·q^{j²}·yʲ`. So weights of the other four make
//!
//! `g₂ − Σ w_k·g_k = g₂·(y − y₁)(y − y₂)(y − y₃)(y − y₄)/(e₂·y²)`
//!
//! for any four radii at which the error is to be zero (`e_i`: the elementary symmetric polynomials of
//! their y), and as the inverse transform is linear, the same weights make the middle filtered image of
//! an orientation from the other four: 24 inverse transforms instead of 30. Zeros at the Chebyshev
//! points of `ln r`, from the lowest frequency to 0.35 cycles per pixel, spread the error evenly.

use super::external::{Source, Store};
use super::fft::Fft;
use super::gains::Gains;
use super::lines::{groups, load, store};
use super::log_gabor::{ORIENTATIONS, RADIAL_RATIO, Scale};
use super::strip::{Kernels, PhaseSymmetry};
use super::workspace::StripBuffers;
use crate::Error;
use crate::simd::Vector;
use core::ops::Range;

/// The upper end of the frequencies over which the error is spread, cycles per pixel.
const HIGHEST: f64 = 0.35;
/// `cos(π/8)` and `cos(3π/8)`: the Chebyshev points of four zeros in [−1, 1], and their negatives.
const POINTS: [f64; 2] = [0.923_879_532_511_286_7, 0.382_683_432_365_089_8];

/// A bank of five octave scales of which four are filtered and the middle one is mixed.
///
/// The sums of Eq. 10 still have 30 terms. The middle scale's gain errs by at most 2·10⁻³ of the
/// peak (2⁻⁵ to 2⁻⁹, any size); the map of images 0..255 was seen to err by 4·10⁻⁴ at a threshold of
/// 15, and without one by 8·10⁻⁴ on ridges and 3·10⁻³ on noise. The terms are added orientation by
/// orientation, so the map has bits of its own, the same for every strip height and vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowRank {
    bank: PhaseSymmetry,
    weights: [f32; Self::BASIS.len()],
}

impl LowRank {
    /// The scales that are filtered, by their positions among the five.
    pub const BASIS: [usize; 4] = [0, 1, 3, 4];

    /// The weights for a bank.
    ///
    /// # Errors
    /// [`Error::Parameter`] where the scales are not five, each half the one before.
    pub fn new(bank: &PhaseSymmetry) -> Result<Self, Error> {
        let scales = &bank.scales[..bank.scale_count];
        let expected = "five scales, each half the one before, such as 2^-5 to 2^-9";
        let refuse = |name, value| {
            Err(Error::Parameter {
                name,
                value,
                expected,
            })
        };
        if scales.len() != 5 {
            return refuse(
                "number of scales of the low-rank basis",
                scales.len() as f64,
            );
        }
        for pair in scales.windows(2) {
            if pair[0].radius() != 2.0 * pair[1].radius() {
                return refuse("scale of the low-rank basis", pair[1].radius());
            }
        }
        Ok(LowRank {
            bank: *bank,
            weights: weights(&scales[2]),
        })
    }

    /// The filters of an orientation (by its position in [`ORIENTATIONS`]) at the scales of
    /// [`LowRank::BASIS`], as [`PhaseSymmetry::filter_columns`] counts them.
    pub fn filters(orientation: usize) -> [usize; 4] {
        Self::BASIS.map(|scale| (scale * ORIENTATIONS.len()).saturating_add(orientation))
    }

    /// [`PhaseSymmetry::add_rows`] for all five scales of an orientation at once, by its position in
    /// [`ORIENTATIONS`], and for one of [`PhaseSymmetry::row_strips`]. `filtered` holds the filtered
    /// columns of the scales of [`LowRank::BASIS`] one after another, 4 × 2 × rows × columns.
    /// [`StripBuffers::strip`] must be twice as long as otherwise: the middle scale grows in it.
    ///
    /// # Errors
    /// As [`PhaseSymmetry::add_rows`]; [`Error::Capacity`] also for a strip buffer that is not twice
    /// as long.
    pub fn add_rows<V: Vector, F: Fft<V>, G: Gains<V>>(
        &self,
        kernels: &Kernels<'_, V, F, G>,
        orientation: usize,
        rows: Range<usize>,
        filtered: &mut dyn Source,
        mut sums: [&mut dyn Store; 2],
        buffers: &mut StripBuffers<'_, V>,
    ) -> Result<(), Error> {
        let bank = &self.bank;
        bank.check(kernels, buffers)?;
        let [.., last_filter] = Self::filters(orientation);
        bank.check_step(last_filter, &rows, bank.row_strips())?;
        let area = rows.len() * bank.columns;
        if buffers.strip.len() < 4 * area {
            return Err(Error::Capacity {
                name: "strip buffer",
                actual: 4 * area,
                capacity: buffers.strip.len(),
            });
        }
        buffers.strip[2 * area..4 * area].fill(0.0);
        let first = orientation == 0;
        bank.read_sums(first, rows.start, &mut sums, &mut buffers.sums[..2 * area])?;
        for (k, &weight) in self.weights.iter().enumerate() {
            let place = k * bank.rows + rows.start;
            let strip = &mut buffers.strip[..2 * area];
            filtered.read(2 * place * bank.columns, strip)?;
            let complete = k + 1 == self.weights.len();
            kernels.zero.vectorize(
                #[inline(always)]
                || self.add(kernels, rows.len(), weight, complete, buffers),
            );
        }
        let last = orientation + 1 == ORIENTATIONS.len();
        bank.write_sums(last, rows.start, sums, &mut buffers.sums[..2 * area])
    }

    /// From the strip buffer's first half to the sums buffer, and times `weight` to the second half;
    /// when that is complete, instead to the sums buffer, too.
    #[inline(always)]
    fn add<V: Vector, F: Fft<V>, G: Gains<V>>(
        &self,
        kernels: &Kernels<'_, V, F, G>,
        height: usize,
        weight: f32,
        complete: bool,
        buffers: &mut StripBuffers<'_, V>,
    ) {
        let (bank, zero) = (&self.bank, kernels.zero);
        let (columns, area) = (bank.columns, bank.columns * height);
        let (above, below) = buffers.sums[..2 * area].split_at_mut(area);
        let (strip, mixed) = buffers.strip[..4 * area].split_at_mut(2 * area);
        let line = &mut buffers.line[..columns];
        let scale = zero.splat(1.0 / columns as f32);
        let (threshold, weight) = (zero.splat(bank.threshold), zero.splat(weight));
        for (first, lanes) in groups::<V>(height) {
            bank.invert_rows(kernels, strip, height, (first, lanes), line);
            let sums = above
                .chunks_exact_mut(height)
                .zip(below.chunks_exact_mut(height));
            let mixed = mixed.chunks_exact_mut(2 * height);
            for ((c, mixed), (above, below)) in line.iter().zip(mixed).zip(sums) {
                let (re, im) = mixed.split_at_mut(height);
                let place = (first, lanes);
                let [e, o] = [c.re * scale, c.im * scale];
                PhaseSymmetry::add_response(threshold, [e, o], [above, below], place);
                let (e, o) = (
                    load(zero, re, first, lanes) + weight * e,
                    load(zero, im, first, lanes) + weight * o,
                );
                if complete {
                    PhaseSymmetry::add_response(threshold, [e, o], [above, below], place);
                } else {
                    store(e, re, first, lanes);
                    store(o, im, first, lanes);
                }
            }
        }
    }
}

/// The weights of the other four scales in the middle one.
fn weights(middle: &Scale) -> [f32; 4] {
    let width = libm::log(RADIAL_RATIO);
    let shift = -core::f64::consts::LN_2 / (width * width);
    let [lowest, highest] = [middle.lowest(), HIGHEST].map(|r| libm::log(r / middle.radius()));
    let (centre, half) = (0.5 * (lowest + highest), 0.5 * (highest - lowest));
    let [a, b] = POINTS;
    let y = [-a, -b, b, a].map(|point| libm::exp(shift * (centre + half * point)));
    // The elementary symmetric polynomials, by one factor 1 + y·t after another.
    let mut e = [1.0, 0.0, 0.0, 0.0, 0.0];
    for y in y {
        for i in (1..e.len()).rev() {
            e[i] += y * e[i - 1];
        }
    }
    let q = libm::exp(0.5 * shift * core::f64::consts::LN_2);
    let q4 = (q * q) * (q * q);
    [-e[4] / q4, e[3] / q, e[1] / q, -1.0 / q4].map(|weight| (weight / e[2]) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mixed radial factor against Eq. 9's, over all radii of the grid, in f64.
    #[test]
    fn four_scales_make_the_fifth() {
        let bell = |r: f64, r0: f64| {
            let z = libm::log(r / r0) / libm::log(0.15);
            libm::exp(-0.5 * z * z)
        };
        let scales = [5, 6, 7, 8, 9].map(|power| libm::exp2(-f64::from(power)));
        for side in [64, 128, 256, 512, 1024] {
            let bank = PhaseSymmetry::new(side, side, &scales, 0.0, 1).unwrap();
            let low_rank = LowRank::new(&bank).unwrap();
            let mut largest = 0.0f64;
            for step in 0..=1000 {
                let highest = core::f64::consts::FRAC_1_SQRT_2 * side as f64;
                let r = libm::pow(highest, f64::from(step) / 1000.0) / side as f64;
                let mixed = LowRank::BASIS.iter().zip(low_rank.weights);
                let sum = mixed.map(|(&k, w)| f64::from(w) * bell(r, scales[k]));
                let sum = sum.fold(0.0, |a, b| a + b);
                largest = largest.max((sum - bell(r, scales[2])).abs());
            }
            // The quartic times the bell, largest at the corner of the spectrum.
            assert!(largest < 2e-3, "{side}: {largest}");
            assert!(largest > 1e-5, "{side}: it is not exact");
        }
    }

    #[test]
    fn other_scales_are_refused() {
        let low_rank = |scales: &[f64]| {
            LowRank::new(&PhaseSymmetry::new(64, 64, scales, 0.0, 1).unwrap()).is_ok()
        };
        assert!(low_rank(&[0.2, 0.1, 0.05, 0.025, 0.0125]));
        assert!(!low_rank(&[0.2, 0.1, 0.05, 0.025]));
        assert!(!low_rank(&[0.4, 0.2, 0.1, 0.05, 0.025, 0.0125]));
        assert!(!low_rank(&[0.0125, 0.025, 0.05, 0.1, 0.2]));
        assert!(!low_rank(&[0.2, 0.1, 0.05, 0.025, 0.0124]));
    }
}
