//! The scan of the image `stream` without blocks, pool, sequence and pipeline.

use bonebeam::beamform::{AlignedLine, Beamformer, Workspace};
use bonebeam::delay::{
    Compounding, IqDelay, IqLayout, IqParameters, IqSamples, Record, ScanLine, Stage,
};
use bonebeam::geometry::Axis;
use bonebeam::image::{BMode, BModeParameters, Logarithm, PixelGrid, envelope};
use bonebeam::memory::Scratch;
use bonebeam::phase_symmetry::{
    External, Kernels, LogGabor, LogGaborTables, Microfft, Parameters, PhaseSymmetry, Sizes,
    StripSlices,
};
use bonebeam::{Complex, Error};
use bonebeam_stream::scan::{self, BEAMS, ELEMENTS, INPUT, LENGTH, PARAMETERS, SCAN, TRANSMIT};

const SIDE: usize = 64;
const PIXELS: usize = SIDE * SIDE;
const STRIPS: Sizes = Sizes::new(SIDE, SIDE, SIDE);

/// Image and map by the core alone: numbers instead of counts, `[element][sample]`, no table of apertures.
///
/// # Errors
/// None: the scan is valid.
pub fn by_the_core() -> Result<(Vec<f32>, Vec<f32>), Error> {
    let delay = IqDelay::new(IqParameters {
        interpolation: INPUT.interpolation.unwrap(),
        ..IqParameters::of(&SCAN, INPUT.demodulation_frequency)
    })?;
    let beamformer = Beamformer::new(PARAMETERS.beamformer)?;
    let sizes = beamformer.sizes(ELEMENTS);
    let need = sizes.need();
    let mut real = vec![0.0; need.real];
    let mut complex = vec![Complex::new(0.0, 0.0); need.complex];
    let own = Scratch::new(&mut real, &mut complex);
    let mut workspace = Workspace::new(0.0, sizes, own)?;
    let mut scratch = vec![0.0; delay.parameters().need(1).real];
    let mut aligned = vec![Complex::new(0.0, 0.0); ELEMENTS * LENGTH];
    let mut z = vec![Complex::new(0.0, 0.0); LENGTH];
    let mut envelopes = vec![0.0; BEAMS * LENGTH];
    for (beam, envelopes) in envelopes.chunks_exact_mut(LENGTH).enumerate() {
        let echoes = scan::echoes(beam);
        let iq: Vec<Complex<f32>> = (0..ELEMENTS)
            .flat_map(|m| echoes.iter().map(move |row| row[m]))
            .map(|[i, q]| Complex::new(i.into(), q.into()))
            .collect();
        let record = Record::iq(IqSamples::Float(&iq), IqLayout::Planar, ELEMENTS)?;
        let line = ScanLine::of(&SCAN, beam, TRANSMIT, Compounding::Replace);
        delay.line(0.0f32, &line, &record, &mut scratch, &mut aligned)?;
        let x = AlignedLine::new(&aligned, ELEMENTS)?;
        let active = |sample| SCAN.active(beam, sample);
        beamformer.line(&mut workspace, x, active, &mut z)?;
        envelope(&z, envelopes)?;
    }
    let (lines, samples) = (Axis::centred(BEAMS, 0.5e-3), SCAN.depths());
    let b_mode = BMode::new(BModeParameters {
        lines,
        samples,
        grid: PixelGrid::of_lines(&lines, &samples, SIDE, SIDE),
        dynamic_range: PARAMETERS.dynamic_range,
        logarithm: Logarithm::Exact,
        median: true,
    })?;
    let (mut work, mut image) = (vec![0.0; b_mode.need().real], vec![0.0; PIXELS]);
    b_mode.image(0.0f32, &envelopes, &mut work, &mut image)?;
    let bank = PhaseSymmetry::new(&Parameters {
        sizes: STRIPS,
        scales: PARAMETERS.scales,
        threshold: PARAMETERS.threshold,
    })?;
    let mut tables = LogGaborTables::new();
    let mut spectrum = vec![0.0; STRIPS.spectrum_len()];
    let mut filtered = vec![0.0; STRIPS.filtered_len()];
    let mut amplitude = vec![0.0; STRIPS.amplitude_len()];
    let mut map = vec![0.0; PIXELS];
    let need = STRIPS.need();
    let mut real = vec![0.0; need.real];
    let mut complex = vec![Complex::new(0.0, 0.0); need.complex];
    let fast = Scratch::new(&mut real, &mut complex);
    bank.run(
        &Kernels {
            fft: &Microfft,
            gains: &LogGabor::new(&mut tables),
        },
        &mut External {
            image: &mut &image[..],
            spectrum: &mut &mut spectrum[..],
            filtered: &mut &mut filtered[..],
            amplitude: &mut &mut amplitude[..],
            symmetry: &mut &mut map[..],
        },
        &mut StripSlices::new(STRIPS, fast)?,
        &mut |_| {},
    )?;
    Ok((image, map))
}
