//! Numbers of every stage, by the core or by the f32 reference.
//!
//! The reference gives values that the core does not expose; its bits are the same.

use bonebeam::beamform::Parameters;
use bonebeam::delay::Stage as _;
use bonebeam::image::{envelope, largest, log_compression, resample};
use bonebeam::prelude::stages::*;
use ndarray::ArrayView2;
use num_complex::Complex;

use super::scene::{
    self, DYNAMIC_RANGE, ELEMENTS, LINES, SAMPLES, SCALES, SIDE, STRIP, SUBAPERTURE, THRESHOLD,
    TRACED, parameters,
};
use crate::Result;
use crate::reference::f32 as reference;
use crate::reference::f32::beamform::{Intermediates, intermediates};
use crate::verify::beamform::core_weights;
use bonebeam_drive::beamform::Memory;
use bonebeam_drive::phase_symmetry;

/// The numbers of a stage, row-major.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Real ones.
    Real(Vec<f32>),
    /// Complex ones.
    Complex(Vec<Complex<f32>>),
}

impl Values {
    /// The words in the order of the file.
    ///
    /// A complex number is its real part, then its imaginary part.
    pub fn words(&self) -> Vec<f32> {
        match self {
            Values::Real(values) => values.clone(),
            Values::Complex(values) => values.iter().flat_map(|z| [z.re, z.im]).collect(),
        }
    }

    /// Words of a number.
    pub fn parts(&self) -> usize {
        match self {
            Values::Real(_) => 1,
            Values::Complex(_) => 2,
        }
    }
}

/// One stage.
#[derive(Clone, Debug)]
pub struct Stage {
    /// The name of its files.
    pub name: String,
    /// Description of the contents.
    pub what: &'static str,
    /// The meaning of each axis, in order.
    pub axes: &'static [&'static str],
    /// The length of each axis.
    pub shape: Vec<usize>,
    /// The numbers.
    pub values: Values,
}

/// All stages of the scene, each after its inputs.
///
/// # Errors
/// A value that the core rejects.
pub fn stages() -> Result<Vec<Stage>> {
    let mut stages = Stages(Vec::new());
    let focused = focus(&mut stages)?;
    // The forward-backward lines of rank-1 ESMV, from which the image is made.
    let mut rank1 = Vec::new();
    for covariance in [Covariance::Forward, Covariance::ForwardBackward] {
        decompositions(&mut stages, &focused, covariance);
        weights(&mut stages, &focused, covariance)?;
        rank1 = lines(&mut stages, &focused, covariance)?;
    }
    let pixels = image(&mut stages, &rank1)?;
    ridges(&mut stages, &pixels)?;
    Ok(stages.0)
}

struct Stages(Vec<Stage>);

impl Stages {
    fn add(
        &mut self,
        name: impl Into<String>,
        what: &'static str,
        axes: &'static [&'static str],
        shape: &[usize],
        values: Values,
    ) {
        self.0.push(Stage {
            name: name.into(),
            what,
            axes,
            shape: shape.to_vec(),
            values,
        });
    }
}

const ALL: Active = Active::new(0, ELEMENTS);

/// The prefix of a covariance's stages.
fn folder(covariance: Covariance) -> &'static str {
    match covariance {
        Covariance::Forward => "forward",
        Covariance::ForwardBackward => "forward-backward",
    }
}

/// The delayed samples of a line.
fn samples_of(focused: &[Complex<f32>], line: usize) -> &[Complex<f32>] {
    &focused[line * SAMPLES * ELEMENTS..][..SAMPLES * ELEMENTS]
}

/// The recording, and its delayed samples, which are returned.
fn focus(stages: &mut Stages) -> Result<Vec<Complex<f32>>> {
    let (data, records) = scene::records();
    let delay_parameters = scene::delay(&data);
    let delay = Delay::new(delay_parameters)?;
    let mut scratch = vec![0.0; delay_parameters.need(1).real];
    let rf: Vec<f32> = records.iter().flat_map(|r| r.rf.iter().copied()).collect();
    let recorded = delay_parameters.record_samples;
    stages.add(
        "rf",
        "input: what the elements of each line recorded",
        &["line", "element", "record sample"],
        &[LINES, ELEMENTS, recorded],
        Values::Real(rf),
    );

    let mut focused = vec![Complex::ZERO; LINES * SAMPLES * ELEMENTS];
    for (record, out) in records.iter().zip(focused.chunks_mut(SAMPLES * ELEMENTS)) {
        let line = ScanLine::new(
            Transmit::new(TransmitLaw::Focused, record.t0),
            Ray::down(record.x),
            Array::LinearAt(&record.element_x),
        );
        let rf = Record::new(&record.rf, ELEMENTS)?;
        delay.line(0.0f32, &line, &rf, &mut scratch, out)?;
    }
    stages.add(
        "focused",
        "delayed analytic samples",
        &["line", "sample", "element"],
        &[LINES, SAMPLES, ELEMENTS],
        Values::Complex(focused.clone()),
    );
    Ok(focused)
}

/// Covariance, Cholesky factor and dominant eigenpair of the traced lines.
fn decompositions(stages: &mut Stages, focused: &[Complex<f32>], covariance: Covariance) {
    let folder = folder(covariance);
    let lines: Vec<Vec<Option<Intermediates>>> = TRACED
        .iter()
        .map(|&line| {
            let x: Vec<_> = samples_of(focused, line)
                .chunks(ELEMENTS)
                .map(<[_]>::to_vec)
                .collect();
            intermediates(&x, &parameters(Method::Mv, covariance)).1
        })
        .collect();
    let of = |part: fn(&Intermediates) -> Vec<Complex<f32>>, length: usize| -> Values {
        let samples = lines.iter().flatten();
        let numbers = samples.flat_map(|sample| match sample {
            Some(sample) => part(sample),
            None => vec![Complex::ZERO; length],
        });
        let numbers: Vec<Complex<f32>> = numbers.collect();
        match covariance {
            Covariance::Forward => Values::Complex(numbers),
            Covariance::ForwardBackward => Values::Real(numbers.iter().map(|z| z.re).collect()),
        }
    };
    let n = SUBAPERTURE;
    let matrix_axes = &["traced line", "sample", "row", "column"];
    stages.add(
        format!("{folder}-covariance"),
        "loaded covariance (Eq. 2, 3) at the line's working scale; real coordinates with \
         forward-backward averaging",
        matrix_axes,
        &[TRACED.len(), SAMPLES, n, n],
        of(|i| i.matrix.clone(), n * n),
    );
    stages.add(
        format!("{folder}-cholesky"),
        "its factor G below the diagonal, 1/G(j,j) on it",
        matrix_axes,
        &[TRACED.len(), SAMPLES, n, n],
        of(|i| i.factor.clone(), n * n),
    );
    let eigenvalues = lines
        .iter()
        .flatten()
        .map(|i| i.as_ref().map_or(0.0, |i| i.eigenvalue));
    stages.add(
        format!("{folder}-eigenvalue"),
        "its largest eigenvalue",
        &["traced line", "sample"],
        &[TRACED.len(), SAMPLES],
        Values::Real(eigenvalues.collect()),
    );
    stages.add(
        format!("{folder}-eigenvector"),
        "the unit eigenvector e₁ to it",
        &["traced line", "sample", "row"],
        &[TRACED.len(), SAMPLES, n],
        of(|i| i.eigenvector.clone(), n),
    );
}

/// Weights of the traced lines.
fn weights(stages: &mut Stages, focused: &[Complex<f32>], covariance: Covariance) -> Result<()> {
    let folder = folder(covariance);
    for (name, method) in [("mv", Method::Mv), ("esmv-rank1", Method::EsmvRank1)] {
        let mut numbers = Vec::new();
        for line in TRACED {
            let parameters = parameters(method, covariance);
            numbers.extend(line_weights(samples_of(focused, line), parameters)?);
        }
        stages.add(
            format!("{folder}-weights-{name}"),
            "weights of the subaperture's elements (Eq. 1, 7)",
            &["traced line", "sample", "element"],
            &[TRACED.len(), SAMPLES, SUBAPERTURE],
            Values::Complex(numbers),
        );
    }
    Ok(())
}

/// Beamformed samples of every line; those of rank-1 ESMV are returned.
fn lines(
    stages: &mut Stages,
    focused: &[Complex<f32>],
    covariance: Covariance,
) -> Result<Vec<Complex<f32>>> {
    let folder = folder(covariance);
    let mut rank1 = Vec::new();
    for (name, method) in [
        ("das", Method::Das),
        ("mv", Method::Mv),
        ("esmv-rank1", Method::EsmvRank1),
        ("esmv-beta", Method::EsmvBeta(0.01)),
    ] {
        if method == Method::Das && covariance == Covariance::ForwardBackward {
            continue;
        }
        let mut z = vec![Complex::ZERO; LINES * SAMPLES];
        for (line, z) in z.chunks_mut(SAMPLES).enumerate() {
            beamform(samples_of(focused, line), parameters(method, covariance), z)?;
        }
        if method == Method::EsmvRank1 {
            rank1.clone_from(&z);
        }
        let name = match method {
            Method::Das => "line-das".to_owned(),
            _ => format!("{folder}-line-{name}"),
        };
        stages.add(
            name,
            "beamformed samples (Eq. 4, 7); ESMV by β takes β = 1 %",
            &["line", "sample"],
            &[LINES, SAMPLES],
            Values::Complex(z),
        );
    }
    Ok(rank1)
}

/// Envelope, grey levels and pixels of beamformed samples; the pixels are returned.
fn image(stages: &mut Stages, z: &[Complex<f32>]) -> Result<Vec<f32>> {
    let (mut envelopes, mut levels) = (vec![0.0; z.len()], vec![0.0; z.len()]);
    envelope(z, &mut envelopes)?;
    log_compression(&envelopes, largest(&envelopes), DYNAMIC_RANGE, &mut levels)?;
    let axis = |count: usize| Axis::new(0.0, 1.0 / (count - 1) as f64, count);
    let mut image = vec![0.0; SIDE * SIDE];
    let (data, pixels) = ([axis(LINES), axis(SAMPLES)], [axis(SIDE); 2]);
    resample(&levels, data, pixels, &mut image)?;
    stages.add(
        "envelope",
        "of rank-1 ESMV, forward-backward",
        &["line", "sample"],
        &[LINES, SAMPLES],
        Values::Real(envelopes),
    );
    stages.add(
        "levels",
        "grey levels 0 to 255 of 50 dB",
        &["line", "sample"],
        &[LINES, SAMPLES],
        Values::Real(levels),
    );
    stages.add(
        "image",
        "pixels, bilinear between lines and samples",
        &["row", "column"],
        &[SIDE, SIDE],
        Values::Real(image.clone()),
    );
    Ok(image)
}

/// Phase symmetry of an image, and two intermediate values.
fn ridges(stages: &mut Stages, image: &[f32]) -> Result<()> {
    let (spectrum, filtered) = reference::phase_symmetry::filtered(image, SIDE, SIDE, SCALES[0], 0);
    let sides = [SIDE, SIDE];
    stages.add(
        "spectrum",
        "of the image, unscaled, frequency 0 first",
        &["row", "column"],
        &sides,
        Values::Complex(spectrum),
    );
    stages.add(
        "filtered",
        "the image through the filter of scale 1/8 and orientation 0: e and o of Eq. 10",
        &["row", "column"],
        &sides,
        Values::Complex(filtered),
    );
    let pixels = ArrayView2::from_shape((SIDE, SIDE), image).expect("as many pixels");
    let map = phase_symmetry::phase_symmetry(
        pixels,
        &phase_symmetry::Parameters {
            scales: SCALES.to_vec(),
            threshold: THRESHOLD,
            strip: STRIP,
        },
        &mut |_, _| {},
    )?;
    stages.add(
        "phase-symmetry",
        "the map of Eq. 10: scales 1/8 and 1/16, T_n = 3",
        &["row", "column"],
        &[SIDE, SIDE],
        Values::Real(map.into_iter().collect()),
    );
    Ok(())
}

/// The weights of every sample of a line.
fn line_weights(x: &[Complex<f32>], parameters: Parameters) -> Result<Vec<Complex<f32>>> {
    let line = AlignedLine::new(x, ELEMENTS)?;
    let of_sample = |sample| core_weights(line, ALL, sample, parameters);
    let all: Result<Vec<_>> = (0..SAMPLES).map(of_sample).collect();
    Ok(all?.concat())
}

/// A line with all elements active.
fn beamform(x: &[Complex<f32>], parameters: Parameters, z: &mut [Complex<f32>]) -> Result<()> {
    let beamformer = Beamformer::new(parameters)?;
    let mut memory = Memory::new(0.0, beamformer.sizes(ELEMENTS))?;
    let line = AlignedLine::new(x, ELEMENTS)?;
    Ok(beamformer.line(&mut memory.view(), line, |_| ALL, z)?)
}
