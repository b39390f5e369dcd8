//! Short-lag coherence in f64, directly from its definition.

use bonebeam::geometry::Active;
use num_complex::Complex;

/// The coherence of sample `n` of a line, `[sample][element]`.
///
/// `active(n)` is the active set of sample `n`, and `half_window` the `K` of its time window.
pub fn short_lag_coherence(
    line: &[Complex<f32>],
    elements: usize,
    active: impl Fn(usize) -> Active,
    half_window: usize,
    n: usize,
) -> f64 {
    let samples = line.len() / elements;
    let value = |n: usize, m: usize| {
        let x = line[n * elements + m];
        Complex::new(f64::from(x.re), f64::from(x.im))
    };
    let (mut products, mut powers) = (0.0, 0.0);
    for k in n.saturating_sub(half_window)..=(n + half_window).min(samples - 1) {
        let Active { first, count } = active(k);
        for i in (0..count).filter(|i| i % 4 == 0) {
            for j in (i + 1..=i + 4).filter(|j| *j < count) {
                let [x, y] = [i, j].map(|m| value(k, first + m));
                products += (x * y.conj()).re;
                powers += (x.norm_sqr() + y.norm_sqr()) / 2.0;
            }
        }
    }
    if powers > 0.0 { products / powers } else { 0.0 }
}
