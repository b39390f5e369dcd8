//! The sub-lines of one line in plain loops.
//!
//! The order of operations is that of `bonebeam::beamform`.

use bonebeam::beamform::{Method, Parameters, Postfilter};
use bonebeam::covariance::Covariance;
use num_complex::Complex;

use super::beamform::{
    apodization, inner, postfilter_of, response_by, subaperture, subapertures, total, with_diagonal,
};
use super::covariance::{
    forward, forward_trace, loading, mirrored, real_form, real_form_of_data, real_form_trace,
    scaled, window_sum,
};
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
    let components = x.iter().flatten().flat_map(|x| [x.re.abs(), x.im.abs()]);
    let largest = components.fold(0.0, |a, b| if b > a { b } else { a });
    let exponent = libm::ilogbf(largest).clamp(-126, 126);
    let (down, up) = (libm::ldexpf(1.0, -exponent), libm::ldexpf(1.0, exponent));
    let half_window = parameters.temporal_half_window;
    let mut z: Vec<Vec<Complex<f32>>> = Vec::new();
    while z.len() < x.len() {
        let start = z.len();
        let alike = active[start..].iter();
        let run = alike.take_while(|&&set| set == active[start]).count();
        let (first, count) = active[start];
        if count == 0 {
            z.extend((start..start + run).map(|n| vec![Complex::ZERO; directions[n].len()]));
            continue;
        }
        let elements: Vec<Vec<Complex<f32>>> = (0..run + 2 * half_window)
            .map(|i| match (start + i).checked_sub(half_window) {
                Some(n) if n < x.len() => {
                    let active = x[n][first..first + count].iter();
                    active.map(|x| x * down).collect()
                }
                _ => vec![Complex::ZERO; count],
            })
            .collect();
        let of_run = &directions[start..start + run];
        z.extend(match (parameters.method, parameters.covariance) {
            (Method::Das, _) => das(&elements, of_run, parameters),
            (_, Covariance::Forward) => run_forward(&elements, of_run, parameters),
            (_, Covariance::ForwardBackward) => run_forward_backward(&elements, of_run, parameters),
        });
    }
    let saturate = |value: f32| value.clamp(f32::MIN, f32::MAX);
    for z in z.iter_mut().flatten() {
        *z = Complex::new(saturate(z.re * up), saturate(z.im * up));
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

fn run_forward(
    elements: &[Vec<Complex<f32>>],
    directions: &[Vec<Direction>],
    parameters: &Parameters,
) -> Vec<Vec<Complex<f32>>> {
    let n = subaperture(elements[0].len(), parameters);
    let gain = total(&apodization(elements[0].len() - n + 1, parameters));
    let sums: Vec<_> = elements.iter().map(|x| forward(x, n)).collect();
    outputs(elements, directions, parameters, |i, block, length| {
        let r = window_sum(&sums[i..i + length], block);
        let (factor, added) = loading(forward_trace(&r), n, parameters)?;
        let a = with_diagonal(scaled(&r, factor), added);
        Some(move |steering: &[Complex<f32>], s: &[Complex<f32>]| {
            response(&a, steering, s, parameters.method) / gain
        })
    })
}

fn run_forward_backward(
    elements: &[Vec<Complex<f32>>],
    directions: &[Vec<Direction>],
    parameters: &Parameters,
) -> Vec<Vec<Complex<f32>>> {
    let n = subaperture(elements[0].len(), parameters);
    let gain = 2.0 * total(&apodization(elements[0].len() - n + 1, parameters));
    let sums: Vec<_> = elements.iter().map(|x| mirrored(&forward(x, n))).collect();
    outputs(elements, directions, parameters, |i, block, length| {
        let f = window_sum(&sums[i..i + length], block);
        let (factor, added) = loading(real_form_trace(&f), n, parameters)?;
        let a = with_diagonal(real_form(&f, factor), added);
        Some(move |steering: &[Complex<f32>], s: &[Complex<f32>]| {
            // Qᴴa/√2 of a centred a is real.
            let mut real = Vec::new();
            for a in &steering[..n / 2] {
                real.extend([a.re, a.im]);
            }
            if n % 2 == 1 {
                real.push(std::f32::consts::FRAC_1_SQRT_2);
            }
            response(&a, &real, &real_form_of_data(s), parameters.method) / gain
        })
    })
}

/// The response of a covariance in each direction.
///
/// `covariance(sample, block, length)` of the run's window gives the response to a steering vector and data, or `None`
/// without power.
fn outputs<R: Fn(&[Complex<f32>], &[Complex<f32>]) -> Complex<f32>>(
    elements: &[Vec<Complex<f32>>],
    directions: &[Vec<Direction>],
    parameters: &Parameters,
    covariance: impl Fn(usize, usize, usize) -> Option<R>,
) -> Vec<Vec<Complex<f32>>> {
    let half_window = parameters.temporal_half_window;
    let length = 2 * half_window + 1;
    let n = subaperture(elements[0].len(), parameters);
    let weights = apodization(elements[0].len() - n + 1, parameters);
    let of_sample = |(i, directions): (usize, &Vec<Direction>)| {
        let x = &elements[i + half_window];
        let response = covariance(i, i.div_ceil(length) * length - i, length);
        let of_direction = |&[half, phasor]: &Direction| {
            let y = rotated(x, half);
            let a = steering_vector(half, n);
            let sums = subapertures(&y, n, parameters, &weights);
            let s: Vec<Complex<f32>> = a.iter().zip(sums).map(|(a, sum)| a * sum).collect();
            let value = response.as_ref().map_or(Complex::ZERO, |of| of(&a, &s));
            let y: Vec<(usize, Complex<f32>)> = y.into_iter().enumerate().collect();
            value * phase(x, &y, phasor, parameters)
        };
        directions.iter().map(of_direction).collect()
    };
    directions.iter().enumerate().map(of_sample).collect()
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
