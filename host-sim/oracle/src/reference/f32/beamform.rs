//! DAS, MV and ESMV of one line in plain loops.
//!
//! The order of operations is that of `bonebeam::beamform`.

use bonebeam::beamform::{Apodization, Method, Parameters, Postfilter};
use bonebeam::covariance::Covariance;
use num_complex::Complex;

use super::covariance::{
    forward, forward_trace, loading, mirrored, real_form, real_form_of_data, real_form_of_steering,
    real_form_trace, scaled, subaperture_sum, window_sum,
};
use super::dominant_eigenpair::{dominant_eigenpair, power_iteration};
use super::linalg::{FLOOR, Number, cholesky, eigen, factor, partial_sums, row_times};

/// z of every computed sample of a line, each `depth_step`-th.
///
/// `x[n]` has the elements of sample `n`, and `active[n]` its first active element and the number of active elements.
///
/// The line is scaled by a power of two so that its largest component is in [1, 2) ([2, 4) for the largest floats), and
/// its output is scaled back. DAS is only scaled if the power is beyond 2^±64.
pub fn beamform(
    x: &[Vec<Complex<f32>>],
    active: &[(usize, usize)],
    parameters: &Parameters,
) -> Vec<Complex<f32>> {
    let mut largest = 0.0;
    for value in x.iter().flatten() {
        for component in [value.re.abs(), value.im.abs()] {
            if component > largest {
                largest = component;
            }
        }
    }
    let working = libm::ilogbf(largest).clamp(-126, 126);
    let exponent = match working {
        -64..=64
            if parameters.method == Method::Das && parameters.apodization == Apodization::None =>
        {
            0
        }
        exponent => exponent,
    };
    let times = |factor: f32| -> Vec<Vec<Complex<f32>>> {
        let sample = |sample: &Vec<_>| sample.iter().map(|value| value * factor).collect();
        x.iter().map(sample).collect()
    };
    let up = libm::ldexpf(1.0, exponent);
    let scaled = times(libm::ldexpf(1.0, -exponent));
    let at_working_scale = times(libm::ldexpf(1.0, -working));

    let mut z = Vec::new();
    while z.len() < x.len() {
        let start = z.len();
        let run = active[start..]
            .iter()
            .take_while(|&&set| set == active[start])
            .count();
        let (first, count) = active[start];
        // The run's samples and K on each side, zero outside the record.
        let before = start as isize - parameters.temporal_half_window as isize;
        let elements: Vec<Vec<Complex<f32>>> = (0..run + 2 * parameters.temporal_half_window)
            .map(|i| match usize::try_from(before + i as isize) {
                Ok(n) if n < x.len() => scaled[n][first..first + count].to_vec(),
                _ => vec![Complex::ZERO; count],
            })
            .collect();
        z.extend(match (count, parameters.covariance) {
            (0, _) => vec![Complex::ZERO; run],
            (_, Covariance::Forward) => run_forward(&elements, parameters),
            (_, Covariance::ForwardBackward) => run_forward_backward(&elements, parameters),
        });
    }
    let saturate = |value: f32| {
        if value.abs() > f32::MAX {
            f32::MAX.copysign(value)
        } else {
            value
        }
    };
    let mut z: Vec<_> = z
        .into_iter()
        .map(|z| Complex::new(saturate(z.re * up), saturate(z.im * up)))
        .collect();
    if parameters.postfilter != Postfilter::None {
        for ((z, sample), &(first, count)) in z.iter_mut().zip(&at_working_scale).zip(active) {
            *z *= postfilter(&sample[first..first + count], parameters);
        }
    }
    z.into_iter().step_by(parameters.depth_step).collect()
}

/// The postfilter's factor for the active elements `x` of a sample.
fn postfilter(x: &[Complex<f32>], parameters: &Parameters) -> f32 {
    let mut power = 0.0;
    for value in x {
        power += value.norm_sqr();
    }
    let ascending: Vec<(usize, Complex<f32>)> = x.iter().copied().enumerate().collect();
    postfilter_of(&ascending, power, parameters)
}

/// The postfilter's factor for elements with their indices, and their power.
///
/// Elements are in the order of summation.
pub(super) fn postfilter_of(
    x: &[(usize, Complex<f32>)],
    power: f32,
    parameters: &Parameters,
) -> f32 {
    let mut sum = Complex::<f32>::ZERO;
    for (_, value) in x {
        sum += value;
    }
    let all = power * x.len() as f32;
    let factor = match parameters.postfilter {
        Postfilter::None => 1.0,
        Postfilter::CoherenceFactor => sum.norm_sqr() / all,
        Postfilter::GeneralizedCoherenceFactor => {
            let mut coherent = sum.norm_sqr();
            for k in 1..=parameters
                .coherence_cutoff
                .min(x.len().saturating_sub(1) / 2)
            {
                let mut cosines = Complex::<f32>::ZERO;
                let mut sines = Complex::<f32>::ZERO;
                for (m, value) in x {
                    let cycles = (k * m % x.len()) as f32 / x.len() as f32;
                    let (sine, cosine) = libm::sincosf(std::f32::consts::TAU * cycles);
                    cosines += value * cosine;
                    sines += value * sine;
                }
                let both = cosines.norm_sqr() + sines.norm_sqr();
                coherent = coherent + both + both;
            }
            coherent / all
        }
    };
    match power > 0.0 {
        true if factor < 1.0 => factor,
        true => 1.0,
        false => 0.0,
    }
}

/// Intermediate values of an adaptive beamformer at one sample.
///
/// They are at the line's working scale.
#[derive(Clone, Debug)]
pub struct Intermediates {
    /// The loaded covariance, row-major `[L][L]`.
    ///
    /// With forward-backward averaging it is real, in the coordinates of docs/numerics.md.
    pub matrix: Vec<Complex<f32>>,
    /// Its Cholesky factor below the diagonal, `1/G(j,j)` on it, 0 above.
    pub factor: Vec<Complex<f32>>,
    /// Its largest eigenvalue.
    pub eigenvalue: f32,
    /// Its unit eigenvector.
    pub eigenvector: Vec<Complex<f32>>,
}

/// Intermediate values of every sample of a line with all elements active.
///
/// Also returns the exponent `e` of the line's working scale: samples are multiplied by `2^-e` first. `None` for a sample
/// without power.
pub fn intermediates(
    x: &[Vec<Complex<f32>>],
    parameters: &Parameters,
) -> (i32, Vec<Option<Intermediates>>) {
    let components = x.iter().flatten().flat_map(|x| [x.re.abs(), x.im.abs()]);
    let largest = components.fold(0.0, |a, b| if b > a { b } else { a });
    let exponent = libm::ilogbf(largest).clamp(-126, 126);
    let down = libm::ldexpf(1.0, -exponent);
    let temporal_half_window = parameters.temporal_half_window;
    let count = x[0].len();
    let elements: Vec<Vec<Complex<f32>>> = (0..x.len() + 2 * temporal_half_window)
        .map(|i| match x.get(i.wrapping_sub(temporal_half_window)) {
            Some(sample) => sample.iter().map(|value| value * down).collect(),
            None => vec![Complex::ZERO; count],
        })
        .collect();
    let n = subaperture(count, parameters);
    let sums: Vec<_> = elements.iter().map(|x| forward(x, n)).collect();
    let length = 2 * temporal_half_window + 1;
    let of_sample = |i: usize| {
        let block = i.div_ceil(length) * length - i;
        match parameters.covariance {
            Covariance::Forward => {
                let r = window_sum(&sums[i..i + length], block);
                let (factor, added) = loading(forward_trace(&r), n, parameters)?;
                Some(intermediates_of(&with_diagonal(scaled(&r, factor), added)))
            }
            Covariance::ForwardBackward => {
                let folded: Vec<_> = sums[i..i + length].iter().map(|r| mirrored(r)).collect();
                let f = window_sum(&folded, block);
                let (factor, added) = loading(real_form_trace(&f), n, parameters)?;
                Some(intermediates_of(&with_diagonal(
                    real_form(&f, factor),
                    added,
                )))
            }
        }
    };
    (exponent, (0..x.len()).map(of_sample).collect())
}

fn intermediates_of<T: Number>(a: &[Vec<T>]) -> Intermediates {
    let n = a.len();
    let lower = |g: &[Vec<T>]| -> Vec<Complex<f32>> {
        let entry = |i: usize| match (i / n, i % n) {
            (row, column) if column <= row => g[row][column].into(),
            _ => Complex::ZERO,
        };
        (0..n * n).map(entry).collect()
    };
    let matrix = |i: usize| match (i / n, i % n) {
        (row, column) if column <= row => a[row][column].into(),
        (row, column) => a[column][row].conj().into(),
    };
    let (eigenvalue, eigenvector) = dominant_eigenpair(a);
    Intermediates {
        matrix: (0..n * n).map(matrix).collect(),
        factor: factor(a, &[]).map_or_else(|| vec![Complex::ZERO; n * n], |g| lower(&g)),
        eigenvalue,
        eigenvector: eigenvector.into_iter().map(Into::into).collect(),
    }
}

/// The weights of `count` elements or subapertures; 1 each without apodization.
pub(super) fn apodization(count: usize, parameters: &Parameters) -> Vec<f32> {
    let (taper, edge) = match parameters.apodization {
        Apodization::None => return vec![1.0; count],
        Apodization::Hann => (1.0, 0.0),
        Apodization::Hamming => (1.0, 0.08),
        Apodization::Tukey => (parameters.tukey_taper, 0.0),
    };
    let weight = |index: usize| {
        let from_middle = (2 * index + 1).abs_diff(count) as f32 / count as f32;
        let u: f32 = (from_middle - (1.0 - taper)) / taper;
        if u > 0.0 {
            let cosine = libm::cosf(std::f32::consts::PI * u);
            edge + (1.0 - edge) * (0.5 + 0.5 * cosine)
        } else {
            1.0
        }
    };
    (0..count).map(weight).collect()
}

/// The weights' sum in ascending order; of ones it is exact.
pub(super) fn total(weights: &[f32]) -> f32 {
    weights.iter().fold(0.0, |sum, weight| sum + weight)
}

/// `Σ_l v_l·x[l+i]`: by sliding without apodization, term by term with it.
pub(super) fn subapertures(
    x: &[Complex<f32>],
    subaperture: usize,
    parameters: &Parameters,
    weights: &[f32],
) -> Vec<Complex<f32>> {
    if parameters.apodization == Apodization::None {
        return subaperture_sum(x, subaperture);
    }
    let mut sums = vec![Complex::ZERO; subaperture];
    for (l, weight) in weights.iter().enumerate() {
        for (i, sum) in sums.iter_mut().enumerate() {
            *sum += x[l + i] * weight;
        }
    }
    sums
}

pub(super) fn subaperture(elements: usize, parameters: &Parameters) -> usize {
    ((parameters.subaperture_ratio * elements as f64).floor() as usize).max(1)
}

/// The samples of a run with one active set; `elements` has K more on each side.
fn run_forward(elements: &[Vec<Complex<f32>>], parameters: &Parameters) -> Vec<Complex<f32>> {
    let n = subaperture(elements[0].len(), parameters);
    let weights = apodization(elements[0].len() - n + 1, parameters);
    let gain = total(&weights);
    let steering = vec![Complex::ONE; n];
    let sums: Vec<_> = elements.iter().map(|x| forward(x, n)).collect();
    outputs(elements, &sums, parameters, |r, x| {
        let (factor, added) = loading(forward_trace(r), n, parameters)?;
        let a = with_diagonal(scaled(r, factor), added);
        let data = subapertures(x, n, parameters, &weights);
        Some(response(&a, &steering, &data, parameters.method) / gain)
    })
}

/// The samples of a run in the real coordinates of forward-backward averaging.
fn run_forward_backward(
    elements: &[Vec<Complex<f32>>],
    parameters: &Parameters,
) -> Vec<Complex<f32>> {
    let n = subaperture(elements[0].len(), parameters);
    let weights = apodization(elements[0].len() - n + 1, parameters);
    let gain = 2.0 * total(&weights);
    let steering = real_form_of_steering(n);
    let sums: Vec<_> = elements.iter().map(|x| mirrored(&forward(x, n))).collect();
    outputs(elements, &sums, parameters, |f, x| {
        let (factor, added) = loading(real_form_trace(f), n, parameters)?;
        let a = with_diagonal(real_form(f, factor), added);
        let data = real_form_of_data(&subapertures(x, n, parameters, &weights));
        Some(response(&a, &steering, &data, parameters.method) / gain)
    })
}

pub(super) fn with_diagonal<T: Number>(mut a: Vec<Vec<T>>, added: f32) -> Vec<Vec<T>> {
    for i in 0..a.len() {
        a[i][i] = T::real(a[i][i].re() + added);
    }
    a
}

/// DAS, or the result of `adaptive` for the sums over each sample's window and its elements.
///
/// It is 0 without power.
fn outputs(
    elements: &[Vec<Complex<f32>>],
    sums: &[Vec<Vec<Complex<f32>>>],
    parameters: &Parameters,
    adaptive: impl Fn(&[Vec<Complex<f32>>], &[Complex<f32>]) -> Option<Complex<f32>>,
) -> Vec<Complex<f32>> {
    let temporal_half_window = parameters.temporal_half_window;
    let length = 2 * temporal_half_window + 1;
    let mut z = Vec::new();
    for i in 0..elements.len() - 2 * temporal_half_window {
        let x = &elements[i + temporal_half_window];
        if parameters.method == Method::Das {
            let mut sum = Complex::ZERO;
            let weights = apodization(x.len(), parameters);
            for (value, weight) in x.iter().zip(&weights) {
                sum += value * weight;
            }
            z.push(sum / total(&weights));
            continue;
        }
        // Blocks of 2K+1 samples are counted from the run's first one.
        let window = &sums[i..i + length];
        let block = i.div_ceil(length) * length - i;
        z.push(adaptive(&window_sum(window, block), x).unwrap_or(Complex::ZERO));
    }
    z
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

/// `wᴴs` or `w_pᴴs` by functions for minimum variance, for rank 1, and for other ranks.
pub(super) fn response_by<T: Number>(
    (a, steering, s): (&[Vec<T>], &[T], &[Complex<f32>]),
    method: Method,
    minimum_variance: impl Fn() -> Option<Complex<f32>>,
    rank1: impl Fn((f32, Vec<T>)) -> Option<Complex<f32>>,
) -> Complex<f32> {
    let solved = match method {
        Method::Mv => minimum_variance(),
        Method::EsmvRank1 => rank1(dominant_eigenpair(a)),
        Method::EsmvRank1Steps(steps) => {
            let sum = rank1(power_iteration(a, steps));
            return sum.filter(|z| z.is_finite()).unwrap_or(Complex::ZERO);
        }
        _ => None,
    };
    solved
        .filter(|z| z.is_finite())
        .unwrap_or_else(|| eigenspace(a, steering, s, method))
}

/// `aᴴR⁻¹a` and `aᴴR⁻¹s` by Cholesky, if `a` is not singular.
fn whitened<T: Number>(
    a: &[Vec<T>],
    steering: &[T],
    s: &[Complex<f32>],
) -> Option<(f32, Complex<f32>)> {
    let rows: Vec<Vec<T>> = T::right_sides(steering, s);
    let rows = cholesky(a, &rows)?;
    let mut power = 0.0;
    let mut product = Complex::ZERO;
    for k in 0..s.len() {
        let y: Complex<f32> = rows[0][k].into();
        power += y.norm_sqr();
        product += T::product(&rows, k);
    }
    Some((power, product))
}

/// `wᴴs` by Cholesky, if `a` is not singular.
fn minimum_variance<T: Number>(
    a: &[Vec<T>],
    steering: &[T],
    s: &[Complex<f32>],
) -> Option<Complex<f32>> {
    let (power, product) = whitened(a, steering, s)?;
    Some(product / power)
}

/// `w_pᴴs` of one eigenpair, if `a` is not singular.
fn rank1<T: Number>(
    a: &[Vec<T>],
    steering: &[T],
    s: &[Complex<f32>],
    (eigenvalue, e): (f32, Vec<T>),
) -> Option<Complex<f32>> {
    // λ₁·e₁ᴴa, as e₁ᴴ(R·a).
    let projection = partial_sums((0..e.len()).map(|i| {
        let entry = row_times(T::zero(), a, 0, i, steering);
        entry * e[i].conj()
    }));
    let (power, _) = whitened(a, steering, s)?;
    Some(projection.conj().times(inner(&e, s)) / (eigenvalue * eigenvalue * power))
}

/// `vᴴs`.
pub(super) fn inner<T: Number>(v: &[T], s: &[Complex<f32>]) -> Complex<f32> {
    let mut sum = Complex::ZERO;
    for i in 0..v.len() {
        sum += v[i].conj().times(s[i]);
    }
    sum
}

/// `w_pᴴs` by all eigenvectors: `Σ (e_kᴴa)*(e_kᴴs)/λ_k` over the kept ones, over `c_L`.
fn eigenspace<T: Number>(
    a: &[Vec<T>],
    steering: &[T],
    s: &[Complex<f32>],
    method: Method,
) -> Complex<f32> {
    let steering: Vec<Complex<f32>> = steering.iter().map(|&entry| entry.into()).collect();
    let mut rows = [steering, s.to_vec()];
    let values = eigen(a.to_vec(), &mut rows);
    let n = values.len();
    let mut order: Vec<usize> = (0..n).collect();
    // Stable: equal eigenvalues stay in the order found.
    order.sort_by(|&i, &j| {
        values[j]
            .partial_cmp(&values[i])
            .expect("eigenvalues are finite")
    });
    let value = |k: usize| if values[k] > FLOOR { values[k] } else { FLOOR };

    let mut sums = Vec::new();
    let mut total = 0.0;
    for &k in &order {
        total += rows[0][k].norm_sqr() / value(k);
        sums.push(total);
    }
    let kept = match method {
        Method::EsmvBeta(beta) => {
            0..sums
                .iter()
                .position(|&sum| sum >= beta * total)
                .expect("beta is at most 1")
                + 1
        }
        Method::EsmvRank(rank) => 0..rank.min(n),
        Method::EsmvRank1 | Method::EsmvRank1Steps(_) => 0..1,
        Method::EsmvExcludeFirst => 1..n,
        Method::Mv | Method::Das => 0..n,
    };
    let mut sum = Complex::ZERO;
    for &k in &order[kept] {
        sum += rows[0][k].conj() * rows[1][k] / value(k);
    }
    sum / total
}
