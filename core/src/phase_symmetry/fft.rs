//! The one-dimensional transform of rows and columns, one line per lane.

use super::fft64;
use crate::simd::Vector;
use num_complex::Complex;

/// A discrete Fourier transform of independent lines, one in each lane.
///
/// [`Microfft`] serves a microcontroller, [`super::LaneFft`] wider vectors. Their numbers are equal, so phase
/// symmetry has the same bits with either.
///
/// ```
/// use bonebeam::phase_symmetry::{Fft, LaneFft, Microfft};
/// use num_complex::Complex;
///
/// let input = |n| Complex::new(if n == 3 { 1.0f32 } else { 0.0 }, 0.0);
/// let mut by_microfft = [Complex::ZERO; 64];
/// Microfft.transform(input, &mut by_microfft);
/// let mut by_lane_fft = [Complex::ZERO; 64];
/// LaneFft::new().transform(input, &mut by_lane_fft);
/// assert_eq!(by_microfft, by_lane_fft);
/// ```
pub trait Fft<V: Vector> {
    /// Computes `line[k] = Σ input(n)·exp(−2πikn/N)` in every lane.
    ///
    /// `N`, the length of `line`, is 64, 128, 256, 512 or 1024. A line of another length stays unchanged.
    fn transform(&self, input: impl Fn(usize) -> Complex<V>, line: &mut [Complex<V>]);
}

/// The transform of the `microfft` crate, with its own tables in flash.
///
/// Radix 2. Lines of 64 points use the same operations, three levels at a time.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Microfft;

impl Fft<f32> for Microfft {
    #[inline(always)]
    fn transform(&self, input: impl Fn(usize) -> Complex<f32>, line: &mut [Complex<f32>]) {
        use microfft::complex::{cfft_128, cfft_256, cfft_512, cfft_1024};
        if !is_supported(line.len()) {
            return;
        }
        if let Some(line) = line.as_mut_array() {
            return fft64::transform(input, line);
        }
        for (n, bin) in line.iter_mut().enumerate() {
            *bin = input(n);
        }
        // microfft's sizes are types, ours are values.
        match line.len() {
            128 => sized(line, cfft_128),
            256 => sized(line, cfft_256),
            512 => sized(line, cfft_512),
            1024 => sized(line, cfft_1024),
            _ => {}
        }
    }
}

/// The inverse transform of one line without its factor 1/N.
///
/// The results go to `output(k, number)`; `line` is scratch.
#[inline(always)]
pub(super) fn inverse_to(
    input: impl Fn(usize) -> Complex<f32>,
    line: &mut [Complex<f32>],
    mut output: impl FnMut(usize, Complex<f32>),
) {
    if let Some(line) = line.as_mut_array() {
        let input = |n| input(opposite(n, fft64::POINTS));
        return fft64::transform_to(input, line, output);
    }
    inverse(&Microfft, input, line);
    for (k, number) in line.iter().enumerate() {
        output(k, *number);
    }
}

type Line<const N: usize> = [Complex<f32>; N];

fn sized<const N: usize>(line: &mut [Complex<f32>], transform: fn(&mut Line<N>) -> &mut Line<N>) {
    if let Some(line) = line.first_chunk_mut() {
        transform(line);
    }
}

/// The inverse transform without its factor 1/N, as a forward one of the input in reverse.
#[inline(always)]
pub(super) fn inverse<V: Vector>(
    fft: &impl Fft<V>,
    input: impl Fn(usize) -> Complex<V>,
    line: &mut [Complex<V>],
) {
    let length = line.len();
    fft.transform(
        #[inline(always)]
        |n| input(opposite(n, length)),
        line,
    );
}

/// The index of the opposite frequency, `−n`, for a length that is a power of two.
#[inline(always)]
pub(super) fn opposite(n: usize, length: usize) -> usize {
    (length - n) & (length - 1)
}

/// Whether a side of the image can be transformed.
pub(super) const fn is_supported(length: usize) -> bool {
    length.is_power_of_two() && 64 <= length && length <= LONGEST
}

/// The longest line.
pub(super) const LONGEST: usize = if LARGE_MAPS { 1024 } else { 64 };

/// Whether sides above 64 are compiled in.
pub(super) const LARGE_MAPS: bool = cfg!(feature = "large-maps");

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_its_feature_sides_above_64_are_refused() {
        let supported = (0..=4096).filter(|&length| is_supported(length));
        let sides: &[usize] = match LARGE_MAPS {
            true => &[64, 128, 256, 512, 1024],
            false => &[64],
        };
        assert!(supported.eq(sides.iter().copied()));
    }
}
