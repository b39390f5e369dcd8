//! DAS, MV and ESMV of one line in plain loops.
//!
//! The order of operations is that of `bonebeam::beamform`.

use bonebeam::beamform::Parameters;
use bonebeam::prelude::stages::*;
use num_complex::Complex;

use super::covariance::{
    Loaded, loaded, real_form_of_data, real_form_of_steering, subaperture, subaperture_sum,
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
    let working = working_exponent(x);
    let exponent = match working {
        -64..=64
            if parameters.method == Method::Das && parameters.apodization == Apodization::None =>
        {
            0
        }
        exponent => exponent,
    };
    let scaled = times(x, -exponent);
    let at_working_scale = times(x, -working);

    let mut z = Vec::new();
    for run in active.chunk_by(PartialEq::eq) {
        let elements = run_of(&scaled, z.len(), run, parameters);
        z.extend(match (run[0].1, parameters.method) {
            (0, _) => vec![Complex::ZERO; run.len()],
            (_, Method::Das) => das(
                &elements[parameters.temporal_half_window..][..run.len()],
                parameters,
            ),
            _ => adaptive(&elements, parameters),
        });
    }
    scale_back(&mut z, exponent);
    if parameters.postfilter != Postfilter::None {
        for ((z, sample), &(first, count)) in z.iter_mut().zip(&at_working_scale).zip(active) {
            *z *= postfilter(&sample[first..first + count], parameters);
        }
    }
    z.into_iter().step_by(parameters.depth_step).collect()
}

/// Exponent of the power of two that scales a line's largest component into [1, 2).
pub(super) fn working_exponent(x: &[Vec<Complex<f32>>]) -> i32 {
    let components = x.iter().flatten().flat_map(|x| [x.re.abs(), x.im.abs()]);
    let largest = components.fold(0.0, |a, b| if b > a { b } else { a });
    libm::ilogbf(largest).clamp(-126, 126)
}

/// A line times a power of two.
pub(super) fn times(x: &[Vec<Complex<f32>>], exponent: i32) -> Vec<Vec<Complex<f32>>> {
    let factor = libm::ldexpf(1.0, exponent);
    let sample = |sample: &Vec<_>| sample.iter().map(|value| value * factor).collect();
    x.iter().map(sample).collect()
}

/// Results times a power of two, at most the largest number.
pub(super) fn scale_back(z: &mut [Complex<f32>], exponent: i32) {
    let up = libm::ldexpf(1.0, exponent);
    let saturate = |value: f32| value.clamp(f32::MIN, f32::MAX);
    for z in z {
        *z = Complex::new(saturate(z.re * up), saturate(z.im * up));
    }
}

/// The active elements of a run, and of K samples on each side; zero outside the record.
pub(super) fn run_of(
    x: &[Vec<Complex<f32>>],
    start: usize,
    run: &[(usize, usize)],
    parameters: &Parameters,
) -> Vec<Vec<Complex<f32>>> {
    let (half_window, (first, count)) = (parameters.temporal_half_window, run[0]);
    (0..run.len() + 2 * half_window)
        .map(|i| match x.get((start + i).wrapping_sub(half_window)) {
            Some(sample) => sample[first..first + count].to_vec(),
            None => vec![Complex::ZERO; count],
        })
        .collect()
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
    let exponent = working_exponent(x);
    let all = vec![(0, x[0].len()); x.len()];
    let elements = run_of(&times(x, -exponent), 0, &all, parameters);
    let of_sample = |a: Option<Loaded>| {
        Some(match a? {
            Loaded::Forward(a) => intermediates_of(&a),
            Loaded::ForwardBackward(a) => intermediates_of(&a),
        })
    };
    let samples = loaded(&elements, parameters).into_iter();
    (exponent, samples.map(of_sample).collect())
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
        let beyond: f32 = from_middle - (1.0 - taper);
        if beyond > 0.0 {
            let cosine = libm::cosf(std::f32::consts::PI * (beyond / taper));
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

fn das(samples: &[Vec<Complex<f32>>], parameters: &Parameters) -> Vec<Complex<f32>> {
    let of_sample = |x: &Vec<Complex<f32>>| {
        let mut sum = Complex::ZERO;
        let weights = apodization(x.len(), parameters);
        for (value, weight) in x.iter().zip(&weights) {
            sum += value * weight;
        }
        sum / total(&weights)
    };
    samples.iter().map(of_sample).collect()
}

/// The samples of a run with one active set; `elements` has K more on each side.
fn adaptive(elements: &[Vec<Complex<f32>>], parameters: &Parameters) -> Vec<Complex<f32>> {
    let n = subaperture(elements[0].len(), parameters);
    let weights = apodization(elements[0].len() - n + 1, parameters);
    let (gain, method) = (total(&weights), parameters.method);
    let steering = vec![Complex::ONE; n];
    let of_sample = |(x, a): (&Vec<_>, Option<Loaded>)| {
        let data = subapertures(x, n, parameters, &weights);
        match a {
            None => Complex::ZERO,
            Some(Loaded::Forward(a)) => response(&a, &steering, &data, method) / gain,
            Some(Loaded::ForwardBackward(a)) => {
                let (steering, data) = (real_form_of_steering(&steering), real_form_of_data(&data));
                response(&a, &steering, &data, method) / (2.0 * gain)
            }
        }
    };
    let samples = elements[parameters.temporal_half_window..].iter();
    let all = samples.zip(loaded(elements, parameters));
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
