//! Aligned lines for tests of beamformers, and the core's results for them.

use bonebeam::beamform::{Parameter, Parameters};
use bonebeam::prelude::stages::*;
use bonebeam_drive::beamform::Memory;
use bonebeam_oracle::verify::beamform as verify;
use ndarray::{Array2, Array3};
use num_complex::Complex;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

pub const COVARIANCES: [Covariance; 2] = [Covariance::Forward, Covariance::ForwardBackward];

/// Every method of the core, and one with another argument.
pub const METHODS: [Method; Method::EXAMPLES.len() + 1] = {
    let mut methods = [Method::EsmvBeta(1e-5); Method::EXAMPLES.len() + 1];
    let (examples, _) = methods.split_at_mut(Method::EXAMPLES.len());
    examples.copy_from_slice(&Method::EXAMPLES);
    methods
};

/// Parameters with other than default values: all postfilters and apodizations.
///
/// Includes the example of every number, with the choices that need it.
pub fn variants() -> Vec<Parameters> {
    let of_postfilter = |postfilter| Parameters {
        postfilter,
        ..Parameters::default()
    };
    let of_row = |row: &Parameter| {
        let mut parameters = Parameters {
            postfilter: Postfilter::GeneralizedCoherenceFactor,
            apodization: Apodization::Tukey,
            ..Parameters::default()
        };
        parameters.set(row.name, row.example).expect("a row's name");
        parameters
    };
    let postfilters = Postfilter::EXAMPLES.map(of_postfilter);
    let rows = Parameters::TABLE.iter().map(of_row);
    let apodizations = Apodization::EXAMPLES.map(|apodization| Parameters {
        apodization,
        ..Parameters::default()
    });
    let choices = postfilters.into_iter().chain(apodizations);
    choices.chain(rows).collect()
}

/// Aligned samples of one beam, [sample, element], and each sample's active elements.
#[derive(Clone, Debug)]
pub struct Line {
    pub x: Array2<Complex<f32>>,
    pub active: Vec<Active>,
}

impl Line {
    /// With every element active.
    pub fn full(x: Array2<Complex<f32>>) -> Self {
        let all = Active::new(0, x.ncols());
        let active = vec![all; x.nrows()];
        Line { x, active }
    }

    /// `f(sample, element)` with every element active.
    pub fn from_fn(
        samples: usize,
        elements: usize,
        mut f: impl FnMut(usize, usize) -> Complex<f32>,
    ) -> Self {
        Line::full(Array2::from_shape_fn((samples, elements), |(n, m)| f(n, m)))
    }

    /// Complex Gaussian noise of unit power.
    pub fn noise(seed: u64, samples: usize, elements: usize) -> Self {
        let mut gaussian = Gaussian::new(seed);
        Line::from_fn(samples, elements, |_, _| gaussian.next())
    }

    /// The same line with every sample changed.
    pub fn map(&self, f: impl Fn(Complex<f32>) -> Complex<f32>) -> Self {
        Line {
            x: self.x.mapv(f),
            active: self.active.clone(),
        }
    }

    fn delayed(&self) -> AlignedLine<'_> {
        let samples = self.x.as_slice().expect("standard layout");
        AlignedLine::new(samples, self.x.ncols()).expect("finite samples")
    }
}

/// Complex Gaussian numbers with E|x|² = 1, by Box and Muller.
pub struct Gaussian(ChaCha8Rng);

impl Gaussian {
    pub fn new(seed: u64) -> Self {
        Gaussian(ChaCha8Rng::seed_from_u64(seed))
    }

    pub fn next(&mut self) -> Complex<f32> {
        let uniform: f32 = 1.0 - self.0.random::<f32>();
        Complex::from_polar(
            (-uniform.ln()).sqrt(),
            self.0.random::<f32>() * std::f32::consts::TAU,
        )
    }
}

/// The same number in f64.
pub fn widen(z: Complex<f32>) -> Complex<f64> {
    Complex::new(f64::from(z.re), f64::from(z.im))
}

/// Memory of exactly the size that a line needs.
fn line_memory<V: Vector>(zero: V, beamformer: &Beamformer, line: &Line) -> Memory<V> {
    let counts = line.active.iter().map(|set| set.count);
    let sizes = beamformer.sizes(counts.max().unwrap_or(0));
    Memory::new(zero, sizes).expect("memory")
}

/// The core, one line at a time.
pub fn core(line: &Line, parameters: Parameters) -> Vec<Complex<f32>> {
    let beamformer = Beamformer::new(parameters).expect("valid parameters");
    let mut memory = line_memory(0.0, &beamformer, line);
    let mut z = vec![Complex::ZERO; beamformer.line_samples(line.active.len())];
    beamformer
        .line(
            &mut memory.view(),
            line.delayed(),
            |n| line.active[n],
            &mut z,
        )
        .expect("a line that fits");
    z
}

/// The core's weights of one sample.
pub fn core_weights(line: &Line, sample: usize, parameters: Parameters) -> Vec<Complex<f32>> {
    let (line, active) = (line.delayed(), line.active[sample]);
    verify::core_weights(line, active, sample, parameters).expect("a sample that fits")
}

/// Lines of one length as a frame's samples.
pub fn stacked(lines: &[Line]) -> Array3<Complex<f32>> {
    let views: Vec<_> = lines.iter().map(|line| line.x.view()).collect();
    ndarray::stack(ndarray::Axis(0), &views).expect("lines of one shape")
}

/// The core through the host's driver: lines of one length, on all threads.
pub fn frame(lines: &[Line], parameters: Parameters) -> Array2<Complex<f32>> {
    let x = stacked(lines);
    let active = |beam: usize, sample: usize| lines[beam].active[sample];
    bonebeam_drive::beamform::beamform(x.view(), &active, parameters, &|_| {})
        .expect("a frame that fits")
}
