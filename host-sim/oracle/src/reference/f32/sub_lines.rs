//! The sub-lines of one line in plain loops.
//!
//! The order of operations is that of `bonebeam::beamform`.

use bonebeam::beamform::Parameters;
use bonebeam::prelude::stages::*;
use num_complex::Complex;

use super::beamform::{
    apodization, inner, postfilter_of, response_by, run_of, scale_back, subapertures, times, total,
    working_exponent,
};
use super::covariance::{Loaded, loaded, real_form_of_data, real_form_of_steering, subaperture};
use super::linalg::{Number, factor, power, row_times};

/// `e^{js/2}` and `e^{−jφ_c}`.
pub type Direction = [Complex<f32>; 2];

/// z of every sub-line of every computed sample of a line, each `depth_step`-th.
///
/// `x[n]` has the elements of sample `n`, `active[n]` its first active element and the number of active elements, and
/// `directions[n]` the directions of its sub-lines.
///
/// The line is scaled as by [`beamform`](super::beamform::beamform), also for DAS.
pub fn sub_lines(
    x: &[Vec<Complex<f32>>],
    active: &[(usize, usize)],
    directions: &[Vec<Direction>],
    parameters: &Parameters,
) -> Vec<Vec<Complex<f32>>> {
    let exponent = working_exponent(x);
    let scaled = times(x, -exponent);
    let mut z: Vec<Vec<Complex<f32>>> = Vec::new();
    for run in active.chunk_by(PartialEq::eq) {
        let of_run = &directions[z.len()..][..run.len()];
        let elements = run_of(&scaled, z.len(), run, parameters);
        z.extend(match (run[0].1, parameters.method) {
            (0, _) => (of_run.iter())
                .map(|all| vec![Complex::ZERO; all.len()])
                .collect(),
            (_, Method::Das) => das(&elements, of_run, parameters),
            _ => adaptive(&elements, of_run, parameters),
        });
    }
    for z in &mut z {
        scale_back(z, exponent);
    }
    z.into_iter().step_by(parameters.depth_step).collect()
}

/// The powers of `e^{js}` from the middle outwards, for a number of elements.
fn powers(half: Complex<f32>, elements: usize) -> Vec<Complex<f32>> {
    let step = half * half;
    let square = step * step;
    let four = square * square;
    let mut powers: Vec<Complex<f32>> = Vec::new();
    for k in 0..elements.div_ceil(2).max(4) {
        powers.push(match k {
            0 if elements % 2 == 1 => Complex::ONE,
            0 => half,
            1..4 => powers[k - 1] * step,
            _ => powers[k - 4] * four,
        });
    }
    powers
}

/// `e^{js(i−(n−1)/2)}`.
fn steering_vector(half: Complex<f32>, n: usize) -> Vec<Complex<f32>> {
    let powers = powers(half, n);
    let entry = |i: usize| match i < n / 2 {
        true => powers[n / 2 - 1 - i + n % 2].conj(),
        false => powers[i - n / 2],
    };
    (0..n).map(entry).collect()
}

/// The samples with phases, `e^{−js(m−centre)}·x_m`.
fn rotated(x: &[Complex<f32>], half: Complex<f32>) -> Vec<Complex<f32>> {
    let a = steering_vector(half, x.len());
    x.iter().zip(a).map(|(x, a)| x * a.conj()).collect()
}

/// `e^{−jφ_c}` times the postfilter's factor, for the samples with phases.
///
/// Samples are in the order of summation.
fn phase(
    x: &[Complex<f32>],
    y: &[(usize, Complex<f32>)],
    phase: Complex<f32>,
    parameters: &Parameters,
) -> Complex<f32> {
    if parameters.postfilter == Postfilter::None {
        return phase;
    }
    let mut power = 0.0;
    for x in x {
        power += x.norm_sqr();
    }
    phase * postfilter_of(y, power, parameters)
}

fn das(
    elements: &[Vec<Complex<f32>>],
    directions: &[Vec<Direction>],
    parameters: &Parameters,
) -> Vec<Vec<Complex<f32>>> {
    let samples = elements[parameters.temporal_half_window..].iter();
    let of_sample = |(x, directions): (&Vec<Complex<f32>>, &Vec<Direction>)| {
        let weights = apodization(x.len(), parameters);
        let of_direction = |&[half, phasor]: &Direction| {
            let y = rotated(x, half);
            // From the middle outwards.
            let count = x.len();
            let mut order: Vec<usize> = Vec::new();
            if count % 2 == 1 {
                order.push(count / 2);
            }
            for k in 0..count / 2 {
                order.extend([count.div_ceil(2) + k, count / 2 - 1 - k]);
            }
            let y: Vec<(usize, Complex<f32>)> = order.iter().map(|&m| (m, y[m])).collect();
            let mut sum = Complex::<f32>::ZERO;
            for (m, y) in &y {
                sum += y * weights[*m];
            }
            (sum / total(&weights)) * phase(x, &y, phasor, parameters)
        };
        directions.iter().map(of_direction).collect()
    };
    samples.zip(directions).map(of_sample).collect()
}

/// The response of each sample's covariance in each direction.
fn adaptive(
    elements: &[Vec<Complex<f32>>],
    directions: &[Vec<Direction>],
    parameters: &Parameters,
) -> Vec<Vec<Complex<f32>>> {
    let n = subaperture(elements[0].len(), parameters);
    let weights = apodization(elements[0].len() - n + 1, parameters);
    let (gain, method) = (total(&weights), parameters.method);
    let of_sample = |((x, directions), a): ((&Vec<Complex<f32>>, &Vec<Direction>), _)| {
        let of_direction = |&[half, phasor]: &Direction| {
            let y = rotated(x, half);
            let steering = steering_vector(half, n);
            let sums = subapertures(&y, n, parameters, &weights);
            let s: Vec<Complex<f32>> = steering.iter().zip(sums).map(|(a, sum)| a * sum).collect();
            let value = match &a {
                None => Complex::ZERO,
                Some(Loaded::Forward(a)) => response(a, &steering, &s, method) / gain,
                Some(Loaded::ForwardBackward(a)) => {
                    let (steering, s) = (real_form_of_steering(&steering), real_form_of_data(&s));
                    response(a, &steering, &s, method) / (2.0 * gain)
                }
            };
            let y: Vec<(usize, Complex<f32>)> = y.into_iter().enumerate().collect();
            value * phase(x, &y, phasor, parameters)
        };
        directions.iter().map(of_direction).collect()
    };
    let samples = elements[parameters.temporal_half_window..].iter();
    let all = samples.zip(directions).zip(loaded(elements, parameters));
    all.map(of_sample).collect()
}

/// `wᴴs` or `w_pᴴs` for the loaded covariance `a`.
fn response<T: Number>(
    a: &[Vec<T>],
    steering: &[T],
    s: &[Complex<f32>],
    method: Method,
) -> Complex<f32> {
    response_by(
        (a, steering, s),
        method,
        || minimum_variance(a, steering, s),
        |eigenpair| rank1(a, steering, s, eigenpair),
    )
}

/// The factor of `a`, the row `(G⁻¹b)*` below it, and `‖G⁻¹b‖²`; `None` if `a` is singular.
fn whitened<T: Number>(a: &[Vec<T>], b: &[T]) -> Option<(Vec<Vec<T>>, f32)> {
    let row: Vec<T> = b.iter().map(|b| b.conj()).collect();
    let g = factor(a, &[row])?;
    let mut sum = 0.0;
    for &y in &g[a.len()] {
        sum += power(y);
    }
    Some((g, sum))
}

/// `wᴴs` by `u = G⁻ᴴG⁻¹a`.
fn minimum_variance<T: Number>(
    a: &[Vec<T>],
    steering: &[T],
    s: &[Complex<f32>],
) -> Option<Complex<f32>> {
    let (g, power) = whitened(a, steering)?;
    let n = a.len();
    let mut u = g[n].clone();
    for c in (0..n).rev() {
        for k in (c + 1..n).rev() {
            u[c] = u[c] - u[k] * g[k][c];
        }
        u[c] = u[c] * g[c][c].re();
    }
    let mut sum = Complex::ZERO;
    for (u, &s) in u.iter().zip(s) {
        sum += u.times(s);
    }
    Some(sum / power)
}

/// `w_pᴴs` of one eigenpair, with `p = R·e`.
fn rank1<T: Number>(
    a: &[Vec<T>],
    steering: &[T],
    s: &[Complex<f32>],
    (eigenvalue, e): (f32, Vec<T>),
) -> Option<Complex<f32>> {
    let mut projection = T::zero();
    for (i, &steering) in steering.iter().enumerate() {
        let p = row_times(T::zero(), a, 0, i, &e);
        projection = projection + steering * p.conj();
    }
    let (_, power) = whitened(a, steering)?;
    Some(projection.conj().times(inner(&e, s)) / (eigenvalue * eigenvalue * power))
}
