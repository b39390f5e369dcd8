//! The covariance and the data of one sample in the solver's coordinates, in plain loops, in the
//! order of operations of `bonebeam::covariance`.

use std::f32::consts::{FRAC_1_SQRT_2, SQRT_2};

use num_complex::Complex;

use super::linalg::Number;

/// Lower triangle of `Σ_l x[l+i]·x*[l+j]`: the first column summed, the rest by sliding.
pub(super) fn forward(x: &[Complex<f32>], subarray: usize) -> Vec<Vec<Complex<f32>>> {
    let subarrays = x.len() - subarray + 1;
    let mut r: Vec<Vec<Complex<f32>>> = Vec::new();
    for i in 0..subarray {
        let mut first = Complex::ZERO;
        for l in 0..subarrays {
            first += x[l + i] * x[l].conj();
        }
        let mut row = vec![first];
        for j in 1..=i {
            let enters = x[i - 1 + subarrays] * x[j - 1 + subarrays].conj();
            let leaves = x[i - 1] * x[j - 1].conj();
            row.push(r[i - 1][j - 1] + enters - leaves);
        }
        r.push(row);
    }
    r
}

/// `Σ_l x[l+i]`: the first entry summed, the rest by sliding.
pub(super) fn subarray_sum(x: &[Complex<f32>], subarray: usize) -> Vec<Complex<f32>> {
    let subarrays = x.len() - subarray + 1;
    let mut sum = Complex::ZERO;
    for l in 0..subarrays {
        sum += x[l];
    }
    let mut sums = vec![sum];
    for i in 1..subarray {
        sum = sum + x[i - 1 + subarrays] - x[i - 1];
        sums.push(sum);
    }
    sums
}

/// Forward-backward averaging: twice the real matrix `QᴴR_FB Q`, lower triangle.
pub(super) fn real_form(r: &[Vec<Complex<f32>>]) -> Vec<Vec<f32>> {
    let n = r.len();
    let (half, last) = (n / 2, n - 1);
    let difference = n - half;
    let mut t: Vec<Vec<f32>> = (0..n).map(|i| vec![0.0; i + 1]).collect();
    for i in 0..half {
        for j in 0..half {
            // The four entries at which the pairs (i, i') and (j, j') meet, from the lower triangle.
            if j <= i {
                let (a, b) = (r[i][j], r[last - j][i]);
                let (c, d) = (r[last - i][j], r[last - j][last - i]);
                t[i][j] = (a.re + b.re) + (c.re + d.re);
                t[difference + i][difference + j] = (a.re - b.re) + (d.re - c.re);
                t[difference + i][j] = (a.im - b.im) + (d.im - c.im);
            } else {
                let (a, b) = (r[j][i], r[last - i][j]);
                let (c, d) = (r[last - j][i], r[last - i][last - j]);
                t[difference + i][j] = -((a.im + b.im) + (c.im + d.im));
            }
        }
    }
    if n % 2 == 1 {
        for j in 0..half {
            let (a, b) = (r[half][j], r[last - j][half]);
            t[half][j] = SQRT_2 * (a.re + b.re);
            t[difference + j][half] = -(SQRT_2 * (a.im + b.im));
        }
        t[half][half] = r[half][half].re + r[half][half].re;
    }
    t
}

/// Forward-backward averaging: `√2·Qᴴs`.
pub(super) fn real_form_of_data(s: &[Complex<f32>]) -> Vec<Complex<f32>> {
    let n = s.len();
    let half = n / 2;
    let mut turned = Vec::new();
    for i in 0..half {
        turned.push(s[i] + s[n - 1 - i]);
    }
    if n % 2 == 1 {
        turned.push(s[half] * SQRT_2);
    }
    for i in 0..half {
        let difference = s[i] - s[n - 1 - i];
        turned.push(Complex::new(difference.im, -difference.re));
    }
    turned
}

/// Forward-backward averaging: `Qᴴa/√2`.
pub(super) fn real_form_of_steering(n: usize) -> Vec<f32> {
    let half = n / 2;
    let mut steering = vec![1.0; half];
    if n % 2 == 1 {
        steering.push(FRAC_1_SQRT_2);
    }
    steering.resize(n, 0.0);
    steering
}

/// Sum over a time window of matrices: those before `block` from the newest to the oldest, those
/// from `block` on from the oldest to the newest, then the one plus the other.
pub(super) fn window_sum<T: Number>(matrices: &[Vec<Vec<T>>], block: usize) -> Vec<Vec<T>> {
    let mut newer = matrices[block].clone();
    for matrix in &matrices[block + 1..] {
        add(&mut newer, matrix);
    }
    if block == 0 {
        return newer;
    }
    let mut older = matrices[block - 1].clone();
    for matrix in matrices[..block - 1].iter().rev() {
        add(&mut older, matrix);
    }
    add(&mut older, &newer);
    older
}

fn add<T: Number>(sum: &mut [Vec<T>], matrix: &[Vec<T>]) {
    for (sum, row) in sum.iter_mut().zip(matrix) {
        for (sum, &entry) in sum.iter_mut().zip(row) {
            *sum = *sum + entry;
        }
    }
}

/// Scales the trace into [1, 2) by a power of two and adds the loading; `None` for no power.
pub(super) fn load<T: Number>(mut a: Vec<Vec<T>>, loading: f32) -> Option<Vec<Vec<T>>> {
    let n = a.len();
    let mut trace = 0.0;
    for i in 0..n {
        trace += a[i][i].re();
    }
    if trace < libm::ldexpf(1.0, -100) {
        return None;
    }
    let factor = libm::ldexpf(1.0, -libm::ilogbf(trace));
    let added = loading / n as f32 * (trace * factor);
    for i in 0..n {
        for j in 0..i {
            a[i][j] = a[i][j] * factor;
        }
        a[i][i] = T::real(a[i][i].re() * factor + added);
    }
    Some(a)
}
