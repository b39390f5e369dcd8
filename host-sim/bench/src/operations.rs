//! The cost of the exact method, in real additions and multiplications.

/// Flops per sample of MV with forward-backward averaging.
///
/// For `m` active elements and subapertures of length `l`, with `P = m − l + 1`:
///
/// - `8·l·P`: the first row of the covariance, `l` entries, each the sum of `P` products of complex
///   numbers (6 flops a product, 2 an addition);
/// - `8·l²`: the others, each the one above it on its diagonal with one product added and one
///   taken away (16 flops), a triangle of `l²/2`;
/// - `2·l²`: forward-backward averaging, two real additions an entry;
/// - `2·l²`: the change to a real symmetric matrix, two real additions an entry;
/// - `3·l²/2` where `K > 0`: three additions an entry of the real triangle for the time window;
/// - `l³/3`: the real Cholesky factorisation;
/// - `2·l²`: two triangular solves.
///
/// At 128/64/0: 33 280 + 32 768 + 16 384 + 87 381 + 8 192 = 178 005.
pub fn mv_forward_backward(m: usize, l: usize, temporal_half_window: usize) -> f64 {
    let (m, l) = (m as f64, l as f64);
    let positions = m - l + 1.0;
    let window = if temporal_half_window > 0 {
        1.5 * l * l
    } else {
        0.0
    };
    let covariance = 8.0 * l * positions + 8.0 * l * l + 4.0 * l * l + window;
    covariance + l * l * l / 3.0 + 2.0 * l * l
}
