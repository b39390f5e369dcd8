//! The covariance and the data of one sample in the solver's coordinates.
//!
//! The order of operations is that of `bonebeam::covariance`, in plain loops.

use std::f32::consts::{FRAC_1_SQRT_2, SQRT_2};

use bonebeam::beamform::Parameters;
use bonebeam::covariance::Covariance;
use num_complex::Complex;

use super::linalg::Number;

/// Lower triangle of `Σ_l x[l+i]·x*[l+j]`: the first column summed, the rest by sliding.
fn forward(x: &[Complex<f32>], subaperture: usize) -> Vec<Vec<Complex<f32>>> {
    let subapertures = x.len() - subaperture + 1;
    let mut r: Vec<Vec<Complex<f32>>> = Vec::new();
    for i in 0..subaperture {
        let mut first = Complex::ZERO;
        for l in 0..subapertures {
            first += x[l + i] * x[l].conj();
        }
        let mut row = vec![first];
        for j in 1..=i {
            let enters = x[i - 1 + subapertures] * x[j - 1 + subapertures].conj();
            let leaves = x[i - 1] * x[j - 1].conj();
            row.push(r[i - 1][j - 1] + enters - leaves);
        }
        r.push(row);
    }
    r
}

/// `Σ_l x[l+i]`: the first entry summed, the rest by sliding.
pub(super) fn subaperture_sum(x: &[Complex<f32>], subaperture: usize) -> Vec<Complex<f32>> {
    let subapertures = x.len() - subaperture + 1;
    let mut sum = Complex::ZERO;
    for l in 0..subapertures {
        sum += x[l];
    }
    let mut sums = vec![sum];
    for i in 1..subaperture {
        sum = sum + x[i - 1 + subapertures] - x[i - 1];
        sums.push(sum);
    }
    sums
}

/// Mirrored forward sums for forward-backward averaging.
///
/// They are each entry on or below the diagonal plus its mirror image along the diagonal. Half of them repeat.
fn mirrored(r: &[Vec<Complex<f32>>]) -> Vec<Vec<Complex<f32>>> {
    let last = r.len() - 1;
    let mut f = r.to_vec();
    for i in 0..r.len() {
        for j in 0..=i {
            // The upper half of a diagonal first.
            f[i][j] = if i + j <= last {
                r[i][j] + r[last - j][last - i]
            } else {
                r[last - j][last - i] + r[i][j]
            };
        }
    }
    f
}

/// Forward-backward averaging: the lower triangle of twice `QᴴR_FB Q`, which is real.
///
/// It is computed from the mirrored sums.
fn real_form(f: &[Vec<Complex<f32>>], factor: f32) -> Vec<Vec<f32>> {
    let n = f.len();
    let last = n - 1;
    let mut t: Vec<Vec<f32>> = (0..n).map(|i| vec![0.0; i + 1]).collect();
    let mut set = |i: usize, j: usize, value: f32| {
        if j <= i {
            t[i][j] = value;
        }
    };
    for i in 0..n / 2 {
        for j in 0..=i {
            let (f, g) = (f[i][j], f[last - i][j]);
            set(2 * i, 2 * j, (f.re + g.re) * factor);
            set(2 * i + 1, 2 * j + 1, (f.re - g.re) * factor);
            let (low, high) = ((f.im - g.im) * factor, -(f.im + g.im) * factor);
            set(2 * i + 1, 2 * j, low);
            set(2 * i, 2 * j + 1, high);
        }
    }
    if n % 2 == 1 {
        let c = n / 2;
        for j in 0..c {
            let (f, g) = (f[c][j], f[last - c][j]);
            set(last, 2 * j, (f.re + g.re) * factor * FRAC_1_SQRT_2);
            set(last, 2 * j + 1, -(f.im + g.im) * factor * FRAC_1_SQRT_2);
        }
        set(last, last, f[c][c].re * factor);
    }
    t
}

/// The trace of the real matrix.
fn real_form_trace(f: &[Vec<Complex<f32>>]) -> f32 {
    let half = f.len() / 2;
    let mut trace = 0.0;
    for i in 0..half {
        trace += f[i][i].re;
    }
    trace += trace;
    if f.len() % 2 == 1 {
        trace += f[half][half].re;
    }
    trace
}

/// Forward-backward averaging: `√2·Qᴴs`.
pub(super) fn real_form_of_data(s: &[Complex<f32>]) -> Vec<Complex<f32>> {
    let n = s.len();
    let half = n / 2;
    let mut rotated = Vec::new();
    for i in 0..half {
        let difference = s[i] - s[n - 1 - i];
        rotated.push(s[i] + s[n - 1 - i]);
        rotated.push(Complex::new(difference.im, -difference.re));
    }
    if n % 2 == 1 {
        rotated.push(s[half] * SQRT_2);
    }
    rotated
}

/// Forward-backward averaging: `Qᴴa/√2` of a centred `a`, which is real.
pub(super) fn real_form_of_steering(a: &[Complex<f32>]) -> Vec<f32> {
    let (half, n) = (a.len() / 2, a.len());
    let mut steering: Vec<f32> = a[..half].iter().flat_map(|a| [a.re, a.im]).collect();
    if n % 2 == 1 {
        steering.push(FRAC_1_SQRT_2);
    }
    steering
}

/// Sum of matrices over a time window.
///
/// Matrices before `block` are summed from the newest to the oldest, those from `block` from the oldest to the newest.
/// Then both sums are added.
fn window_sum<T: Number>(matrices: &[Vec<Vec<T>>], block: usize) -> Vec<Vec<T>> {
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

/// The trace of the forward matrix.
fn forward_trace(r: &[Vec<Complex<f32>>]) -> f32 {
    let mut trace = 0.0;
    for i in 0..r.len() {
        trace += r[i][i].re;
    }
    trace
}

/// The forward matrix at the solvers' scale.
fn scaled(r: &[Vec<Complex<f32>>], factor: f32) -> Vec<Vec<Complex<f32>>> {
    let mut a = r.to_vec();
    for i in 0..a.len() {
        for j in 0..i {
            a[i][j] *= factor;
        }
        a[i][i] = Complex::from(a[i][i].re * factor);
    }
    a
}

/// The power of two that scales a trace into [1, 2), and the diagonal loading.
///
/// The loading is for a diagonal of `n` entries. `None` without power.
fn loading(trace: f32, n: usize, parameters: &Parameters) -> Option<(f32, f32)> {
    if trace < libm::ldexpf(1.0, -100) {
        return None;
    }
    let factor = libm::ldexpf(1.0, -libm::ilogbf(trace));
    let added = parameters.diagonal_loading / n as f32 * (trace * factor);
    Some((factor, added))
}

pub(super) fn subaperture(elements: usize, parameters: &Parameters) -> usize {
    ((parameters.subaperture_ratio * elements as f64).floor() as usize).max(1)
}

/// A loaded covariance in the solver's coordinates.
pub(super) enum Loaded {
    Forward(Vec<Vec<Complex<f32>>>),
    /// Real.
    ForwardBackward(Vec<Vec<f32>>),
}

/// The loaded covariances of a run with one active set; `None` without power.
///
/// `elements` has K samples more on each side. Blocks of 2K+1 samples are counted from the run's first one.
pub(super) fn loaded(
    elements: &[Vec<Complex<f32>>],
    parameters: &Parameters,
) -> Vec<Option<Loaded>> {
    let n = subaperture(elements[0].len(), parameters);
    let both = parameters.covariance == Covariance::ForwardBackward;
    let of_elements = |x: &Vec<_>| match forward(x, n) {
        sums if both => mirrored(&sums),
        sums => sums,
    };
    let sums: Vec<_> = elements.iter().map(of_elements).collect();
    let length = 2 * parameters.temporal_half_window + 1;
    let of_window = |(i, window): (usize, &[Vec<Vec<_>>])| {
        let r = window_sum(window, i.div_ceil(length) * length - i);
        if both {
            let (factor, added) = loading(real_form_trace(&r), n, parameters)?;
            let a = with_diagonal(real_form(&r, factor), added);
            return Some(Loaded::ForwardBackward(a));
        }
        let (factor, added) = loading(forward_trace(&r), n, parameters)?;
        Some(Loaded::Forward(with_diagonal(scaled(&r, factor), added)))
    };
    sums.windows(length).enumerate().map(of_window).collect()
}

fn with_diagonal<T: Number>(mut a: Vec<Vec<T>>, added: f32) -> Vec<Vec<T>> {
    for i in 0..a.len() {
        a[i][i] = T::real(a[i][i].re() + added);
    }
    a
}
