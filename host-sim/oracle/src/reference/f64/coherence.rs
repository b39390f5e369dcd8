//! Short-lag coherence and coherence factors in f64, from their definitions.

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

/// The squared coherence factors of a line's blocks of `block` samples, added up.
pub fn squared_coherence_factors(
    line: &[Complex<f32>],
    elements: usize,
    active: impl Fn(usize) -> Active,
    block: usize,
) -> f64 {
    let factor = |(first, x): (usize, &[Complex<f32>])| {
        let [mut coherent, mut all] = [0.0; 2];
        for (n, x) in (first * block..).zip(x.chunks_exact(elements)) {
            let Active { first, count } = active(n);
            let x = x[first..first + count].iter();
            let x = x.map(|x| Complex::new(f64::from(x.re), f64::from(x.im)));
            coherent += x.clone().sum::<Complex<f64>>().norm_sqr();
            all += count as f64 * x.map(|x| x.norm_sqr()).sum::<f64>();
        }
        if all > 0.0 { coherent / all } else { 0.0 }
    };
    let blocks = line.chunks(block * elements).enumerate();
    blocks.map(|block| factor(block).powi(2)).sum()
}
