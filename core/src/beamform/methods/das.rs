//! Delay and sum.

use crate::beamform::aligned_line::AlignedLine;
use crate::beamform::apodization::Window;
use crate::beamform::compiled::APODIZATION;
use crate::beamform::segment::Segment;
use crate::geometry::DepthStep;
use num_complex::Complex;

/// Elements with unrolled additions, which share the loop's overhead.
const BLOCK: usize = 8;

/// The means over the `count` active elements of the segment's computed samples.
///
/// Each is the sum in ascending order from zero, divided by the count, directly from the aligned samples.
///
/// The line's own scale is used if the sum can neither overflow nor lose bits at the end of the floats' range.
/// Otherwise its working scale is used. Both give the same bits, except for samples below `2⁻¹²⁶` of the line's
/// largest.
///
/// With a window it is [`Window::das`].
#[cfg_attr(feature = "constants", inline(always))]
pub(in crate::beamform) fn das(
    segment: &Segment<'_>,
    (count, step): (usize, DepthStep),
    window: Option<&Window>,
    z: &mut [Complex<f32>],
) {
    if let Some(window) = window
        && APODIZATION
    {
        return window.das(segment, (count, step), z);
    }
    // Separate loops: whole snapshots of known length take 3 % fewer instructions on a Cortex-M7, and more code.
    match step.get() {
        1 if cfg!(feature = "constants") => means(segment, count, segment.all_snapshots(), z),
        _ => stepped(segment, (count, step), z),
    }
}

/// A separate function, so that the code without a depth step can be inlined.
#[cold]
#[inline(never)]
fn stepped(segment: &Segment<'_>, (count, step): (usize, DepthStep), z: &mut [Complex<f32>]) {
    means(segment, count, segment.snapshots(step), z);
}

#[inline(always)]
fn means<'a>(
    segment: &Segment<'_>,
    count: usize,
    snapshots: impl Iterator<Item = &'a [Complex<f32>]>,
    z: &mut [Complex<f32>],
) {
    let line = &segment.line;
    for (z, snapshot) in z.iter_mut().zip(snapshots) {
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

/// `1/count` each, or the window divided by its sum.
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

/// The mean, computed at the line's working scale and converted back.
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
    use crate::beamform::Parameters;

    /// At the working scale of the first sample, the second has lost its last bits.
    #[test]
    fn a_weak_sample_keeps_its_bits_beside_a_strong_one() {
        let largest = f32::from_bits((127 + 60) << 23);
        let weak = Complex::new(1.2345678e-24, -7.654321e-24);
        let x = [Complex::new(largest, 0.0), weak];
        let segment = Segment::new(AlignedLine::new(&x, 1).expect("finite"), 0, 0);
        let mut z = [Complex::new(0.0, 0.0); 2];
        let every = Parameters::DEFAULT.step();
        das(&segment, (1, every), None, &mut z);
        assert_eq!(z, x);
    }
}
