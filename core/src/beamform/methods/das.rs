//! Delay and sum.

use crate::beamform::aligned_line::AlignedLine;
use crate::beamform::apodization::Window;
use crate::beamform::segment::Segment;
use num_complex::Complex;

/// Elements whose additions are written out, so that a loop's bookkeeping is shared.
const BLOCK: usize = 8;

/// The means over the segment's `count` active elements: each the sum in ascending order from zero,
/// divided by the count, straight from the aligned samples.
///
/// At the line's own scale where the sum can neither overflow nor lose bits to the end of the floats'
/// range, else at its working scale; both give the same bits, but for samples below `2⁻¹²⁶` of the
/// line's largest.
///
/// With a window it is [`Window::das`].
#[inline(always)]
pub(in crate::beamform) fn das(
    segment: &Segment<'_>,
    count: usize,
    window: Option<&Window>,
    z: &mut [Complex<f32>],
) {
    if let Some(window) = window {
        return window.das(segment, count, z);
    }
    let line = &segment.line;
    let samples = line.samples_from(segment.first_sample);
    for (z, snapshot) in z.iter_mut().zip(samples.chunks_exact(line.elements())) {
        let active = snapshot.get(segment.first_element..);
        let Some(active) = active.and_then(|active| active.get(..count)) else {
            return;
        };
        *z = if line.is_moderate() {
            mean(active, |x| x)
        } else {
            scaled(line, active)
        };
    }
}

/// `1/count` each, or the window over its sum.
pub(in crate::beamform) fn weights(
    _: &Segment<'_>,
    window: Option<&Window>,
    weights: &mut [Complex<f32>],
) {
    match window {
        Some(window) => window.weights(weights),
        None => weights.fill(Complex::new(1.0 / weights.len() as f32, 0.0)),
    }
}

/// The mean at the line's working scale, put back.
#[cold]
fn scaled(line: &AlignedLine<'_>, active: &[Complex<f32>]) -> Complex<f32> {
    let scale = line.scale();
    line.unscale(mean(active, |x| x * scale))
}

#[inline(always)]
fn mean(active: &[Complex<f32>], scale: impl Fn(Complex<f32>) -> Complex<f32>) -> Complex<f32> {
    let mut sum = Complex::new(0.0, 0.0);
    let (blocks, rest) = active.as_chunks::<BLOCK>();
    for block in blocks {
        for &x in block {
            sum += scale(x);
        }
    }
    for &x in rest {
        sum += scale(x);
    }
    sum / active.len() as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At the working scale of the first sample, the second has lost its last bits.
    #[test]
    fn a_weak_sample_keeps_its_bits_beside_a_strong_one() {
        let largest = f32::from_bits((127 + 60) << 23);
        let weak = Complex::new(1.2345678e-24, -7.654321e-24);
        let x = [Complex::new(largest, 0.0), weak];
        let segment = Segment {
            line: AlignedLine::new(&x, 1).expect("finite"),
            first_element: 0,
            first_sample: 0,
        };
        let mut z = [Complex::new(0.0, 0.0); 2];
        das(&segment, 1, None, &mut z);
        assert_eq!(z, x);
    }
}
