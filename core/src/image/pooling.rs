//! Envelope of a line from its sub-lines.

use super::envelope::{check_signal, magnitude};
use crate::Error;
use crate::error::check_length;
use num_complex::Complex;

/// Combination of the sub-lines' envelopes into the line's envelope.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Pooling {
    /// The largest: an isolated point keeps its level at every position.
    #[default]
    Largest,
    /// The root mean square: smoother speckle, and points up to `10·lg N` dB lower.
    Rms,
}

/// Computes the envelope of a line from its sub-lines.
///
/// `z[n·N + k]` is sub-line `k` of sample `n`. The result has the unit of `z`.
///
/// Order: `|z|` as [`envelope`](super::envelope()); the root mean square is `a·√(Σ(|z|/a)²/N)` with the largest `a`,
/// ascending from zero, so that no square overflows or vanishes.
///
/// ```
/// use bonebeam::Complex;
/// use bonebeam::image::{Pooling, pooled_envelope};
///
/// let z = [Complex::new(1.0, 0.0), Complex::new(0.0, -7.0)];
/// let mut out = [0.0];
/// pooled_envelope(&z, 2, Pooling::Largest, &mut out)?;
/// assert_eq!(out, [7.0]);
/// pooled_envelope(&z, 2, Pooling::Rms, &mut out)?;
/// assert!((out[0] - 5.0).abs() < 1e-6);
/// # Ok::<(), bonebeam::Error>(())
/// ```
///
/// # Errors
/// [`Error::Length`] if `z` is not `sub_lines` times as long as `out`, [`Error::NonFinite`] with the index of the first
/// bad number; `out` is then unchanged.
pub fn pooled_envelope(
    z: &[Complex<f32>],
    sub_lines: usize,
    pooling: Pooling,
    out: &mut [f32],
) -> Result<(), Error> {
    check_length("sub-lines", z.len(), out.len().saturating_mul(sub_lines))?;
    check_signal(z)?;
    for (out, z) in out.iter_mut().zip(z.chunks_exact(sub_lines.max(1))) {
        *out = pool(pooling, z.iter().map(|&z| magnitude(z)));
    }
    Ok(())
}

/// One envelope of some magnitudes.
///
/// Each is computed once, and twice for the root mean square.
#[inline(always)]
pub(super) fn pool(pooling: Pooling, magnitudes: impl Iterator<Item = f32> + Clone) -> f32 {
    let mut largest = 0.0;
    for magnitude in magnitudes.clone() {
        if magnitude > largest {
            largest = magnitude;
        }
    }
    match pooling {
        Pooling::Rms if largest > 0.0 => {
            let (mut sum, mut count) = (0.0, 0usize);
            for magnitude in magnitudes {
                let part = magnitude / largest;
                sum += part * part;
                count += 1;
            }
            largest * crate::instructions::sqrt(sum / count as f32)
        }
        _ => largest,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At the ends of the floats' range, and of silence.
    #[test]
    fn a_level_that_all_sub_lines_have_is_that_of_the_line() {
        for level in [0.0, 1e-44, 1.5, 3.0e38] {
            for (pooling, sub_lines) in
                [(Pooling::Largest, 4), (Pooling::Rms, 4), (Pooling::Rms, 1)]
            {
                let z = [Complex::new(0.0, -level); 4];
                let mut out = [f32::NAN; 4];
                let out = &mut out[..4 / sub_lines];
                assert_eq!(pooled_envelope(&z, sub_lines, pooling, out), Ok(()));
                assert!(
                    out.iter().all(|&value| value == level),
                    "{level} {pooling:?}"
                );
            }
        }
    }

    #[test]
    fn what_is_not_a_line_is_refused() {
        let mut out = [9.0; 2];
        let z = [Complex::new(1.0, 0.0); 5];
        let length = Error::length("sub-lines", 5, 4);
        let pooled = pooled_envelope(&z, 2, Pooling::Rms, &mut out);
        assert_eq!(pooled, Err(length));
        let bad = [z[0], z[0], Complex::new(0.0, f32::NAN), z[0]];
        let non_finite = Error::NonFinite {
            name: "analytic signal",
            index: 2,
        };
        let pooled = pooled_envelope(&bad, 2, Pooling::Largest, &mut out);
        assert_eq!((pooled, out), (Err(non_finite), [9.0; 2]));
    }
}
