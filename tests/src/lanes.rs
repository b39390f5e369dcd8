//! The golden cases over vectors: each must have its hash of one lane.

use std::boxed::Box;
use std::vec;
use std::vec::Vec;

use bonebeam::beamform::{AlignedLine, Beamformer, Segment, SteeredSegments, Workspace};
use bonebeam::geometry::Steering;
use bonebeam::image::median;
use bonebeam::memory::Scratch;
use bonebeam::phase_symmetry::{
    External, GainTables, Kernels, LaneFft, LogGabor, LogGaborTables, PhaseSymmetry, StripSlices,
};
use bonebeam::simd::{InstructionSet, Task, Vector};
use bonebeam::{Complex, Error};

use crate::snapshots::{ELEMENTS, PERIODIC, SAMPLES, SNAPSHOTS};
use crate::{beamform, delay, hash, image, iq, phase_symmetry};

/// Runs every case over the lanes of `set`, and reports its name and hash.
///
/// Each beamformer runs in the first lane, in a middle one and in the last.
///
/// # Errors
/// Errors of the core, which are faults of a case.
pub fn run(set: InstructionSet, report: &mut dyn FnMut(&str, u64)) -> Result<(), Error> {
    set.dispatch(Cases { report })
}

struct Cases<'a> {
    report: &'a mut dyn FnMut(&str, u64),
}

impl Task for Cases<'_> {
    type Output = Result<(), Error>;

    fn run<V: Vector>(self, zero: V) -> Self::Output {
        let report = self.report;
        delay_lines(zero, report)?;
        let cases = beamform::FORWARD_BACKWARD.into_iter();
        let cases = cases.chain(beamform::SUB_LINES_FORWARD_BACKWARD);
        let cases = cases.chain(beamform::POSTFILTERS);
        let cases = cases.chain(beamform::DEPTH_STEPS);
        let cases = cases.chain(beamform::APODIZED);
        let cases = cases.chain(beamform::FORWARD);
        for case in cases.chain(beamform::SUB_LINES_FORWARD) {
            beamformer(zero, case, &SNAPSHOTS, report)?;
        }
        beamformer(zero, beamform::SINGULAR, &PERIODIC, report)?;
        smooth(zero, report)?;
        strips(zero, report)
    }
}

fn delay_lines<V: Vector>(zero: V, report: &mut dyn FnMut(&str, u64)) -> Result<(), Error> {
    let mut scratch = vec![0.0; delay::HALVED.need(V::LANES).real];
    let mut x = vec![Complex::new(0.0, 0.0); delay::SAMPLES * delay::ELEMENTS];
    delay::lines(zero, &mut scratch, &mut x, report)?;
    let mut memory = delay::UpsampledMemory::new();
    scratch.truncate(delay::UPSAMPLED.need(V::LANES).real);
    delay::upsampled_lines(zero, &mut memory, &mut scratch, &mut x, report)?;
    iq::rays(zero, &mut scratch, &mut x, report)?;
    let mut scratch = vec![0.0; iq::PARAMETERS.need(V::LANES).real];
    let mut x = vec![Complex::new(0.0, 0.0); iq::OUTPUTS * ELEMENTS];
    iq::lines(zero, &mut scratch, &mut x, report)
}

/// The other lanes start elsewhere in the sequence, so that all lanes differ.
fn beamformer<V: Vector>(
    zero: V,
    case: beamform::Case,
    x: &[Complex<f32>],
    report: &mut dyn FnMut(&str, u64),
) -> Result<(), Error> {
    let beamformer = Beamformer::new(case.parameters)?;
    let sizes = beamformer.sizes(ELEMENTS);
    let need = sizes.need();
    let scratch = Scratch {
        real: &mut vec![zero; need.real],
        complex: &mut vec![Complex { re: zero, im: zero }; need.complex],
    };
    let mut workspace = Workspace::new(zero, sizes, scratch)?;
    let line = AlignedLine::new(x, ELEMENTS)?;
    let sub_lines = case.parameters.sub_lines;
    let mut steering = vec![Complex::new(0.0, 0.0); Steering::need(SAMPLES, sub_lines).complex];
    let steering = Steering::new(&beamform::scan()?, beamform::LINE, sub_lines, &mut steering)?;
    let steering = vec![steering; V::LANES];
    for lane_index in [0, (V::LANES - 1) / 2, V::LANES - 1] {
        let segments: Vec<Segment<'_>> = (0..V::LANES)
            .map(|lane| Segment {
                line,
                first_element: 0,
                first_sample: lane.abs_diff(lane_index),
            })
            .collect();
        let mut z: Vec<_> = segments
            .iter()
            .map(|segment| {
                let before = beamformer.line_samples(segment.first_sample);
                beamformer.line_samples(SAMPLES) - before
            })
            .map(|samples| vec![Complex::new(0.0, 0.0); samples * sub_lines])
            .collect();
        let mut out: Vec<_> = z.iter_mut().map(Vec::as_mut_slice).collect();
        let lines = SteeredSegments {
            segments: &segments,
            steering: &steering,
        };
        beamformer.sub_line_segments(&mut workspace, lines, ELEMENTS, &mut out)?;
        report(case.name, hash::complex(&z[lane_index]));
    }
    Ok(())
}

fn smooth<V: Vector>(zero: V, report: &mut dyn FnMut(&str, u64)) -> Result<(), Error> {
    let mut memory = Box::new(image::Memory::new());
    let pixels = image::pixels(&mut memory)?.to_vec();
    let mut smooth = vec![0.0; pixels.len()];
    median(zero, &pixels, image::SIDE, &mut smooth)?;
    report("median", hash::real(&smooth));
    Ok(())
}

fn strips<V: Vector>(zero: V, report: &mut dyn FnMut(&str, u64)) -> Result<(), Error> {
    let mut tables = Box::new(LogGaborTables::new());
    let filters = LogGabor::new(&mut tables);
    for (name, strip) in phase_symmetry::STRIPS {
        let bank = PhaseSymmetry::new(&phase_symmetry::parameters(strip))?;
        let sizes = bank.sizes();
        let kernels = Kernels {
            fft: &LaneFft::new(),
            gains: &GainTables::new(&filters, &bank, vec![0.0; bank.gain_tables_len()])?,
        };
        let mut symmetry = vec![0.0; sizes.symmetry_len()];
        let mut external = External {
            image: &mut &phase_symmetry::IMAGE[..],
            spectrum: &mut &mut vec![0.0; sizes.spectrum_len()][..],
            filtered: &mut &mut vec![0.0; sizes.filtered_len()][..],
            amplitude: &mut &mut vec![0.0; sizes.amplitude_len()][..],
            symmetry: &mut &mut symmetry[..],
        };
        let mut fast = StripSlices {
            strip: &mut vec![0.0; sizes.strip_len()],
            sums: &mut vec![0.0; sizes.sums_len()],
            line: &mut vec![Complex { re: zero, im: zero }; sizes.line_len()],
            gains: &mut vec![zero; sizes.gains_len()],
        };
        bank.run(&kernels, &mut external, &mut fast, &mut |_| {})?;
        report(name, hash::real(&symmetry));
    }
    Ok(())
}
