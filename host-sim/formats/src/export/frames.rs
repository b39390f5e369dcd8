//! Frames of a recording, its delays, and positions of lines for output formats.

use std::borrow::Cow;
use std::ops::Range;

use ndarray::Array2;
use num_complex::Complex;

use bonebeam_files::{BeamformedLines, ChannelData, Error, Recording, Result, Samples, Transmits};

/// Some frames of a recording that is read part by part.
pub type Part<'a> = Result<(Cow<'a, Recording>, Range<usize>)>;

/// All but the samples, without the lens.
///
/// The lens's two-way delay is subtracted from `t0`. The carrier phase of I/Q still counts from the former `t0`.
pub(super) fn without_lens(data: &ChannelData) -> ChannelData {
    ChannelData {
        samples: data
            .samples
            .frame(0)
            .map_or_else(|| data.samples.clone(), |frame| frame.none()),
        t0: data
            .t0
            .iter()
            .map(|t0| t0 - 2.0 * data.lens_delay)
            .collect(),
        ..data.clone()
    }
}

/// Passes the frames of the parts on, as [transmit, element, sample].
///
/// I/Q is rotated by a phase in cycles for each transmit. It is passed as real and imaginary part, RF as the first
/// alone.
pub(super) fn each_frame<'a>(
    parts: impl Iterator<Item = Part<'a>>,
    cycles: &[f64],
    mut take: impl FnMut(usize, [&[f32]; 2]) -> Result<()>,
) -> Result<()> {
    let phasors: Vec<Complex<f64>> = cycles
        .iter()
        .map(|cycles| Complex::from_polar(1.0, std::f64::consts::TAU * cycles.fract()))
        .collect();
    let mut done = 0;
    for part in parts {
        let (recording, own) = part?;
        let Recording::Channel(data) = recording.as_ref() else {
            return Err(Error::Data(
                "a part of the recording has another kind of samples".into(),
            ));
        };
        for frame in own {
            let missing = || Error::Data(format!("the recording has no frame {frame}"));
            match &data.samples {
                Samples::Rf(_) | Samples::Counts(_) | Samples::Stored(_) => {
                    let rf = data.samples.rf(frame).ok_or_else(missing)?;
                    let rf = rf.as_standard_layout();
                    take(done, [rf.as_slice().unwrap_or_default(), &[]])?;
                }
                Samples::Iq { iq, .. } => {
                    let iq = iq.index_axis(ndarray::Axis(0), frame);
                    let turned = |part: fn(Complex<f64>) -> f64| -> Vec<f32> {
                        let transmits = iq.outer_iter().zip(&phasors);
                        transmits
                            .flat_map(|(record, phasor)| {
                                record.into_iter().map(move |sample| {
                                    let wide =
                                        Complex::new(f64::from(sample.re), f64::from(sample.im));
                                    // Exact where nothing turns.
                                    let turned = if *phasor == Complex::new(1.0, 0.0) {
                                        wide
                                    } else {
                                        wide * phasor
                                    };
                                    part(turned) as f32
                                })
                            })
                            .collect()
                    };
                    take(done, [&turned(|z| z.re), &turned(|z| z.im)])?;
                }
            }
            done += 1;
        }
    }
    Ok(())
}

/// Firing time of each element, s; NaN if it does not fire.
///
/// It counts from the moment when the wave passes the origin of its law.
pub(super) fn delays(data: &ChannelData) -> Array2<f64> {
    let (_, transmits, elements, _) = data.samples.dim();
    let c = data.c;
    Array2::from_shape_fn((transmits, elements), |(transmit, element)| {
        let [x, z] = data.element(element);
        match &data.transmits {
            Transmits::Plane { angle } => {
                let (sine, cosine) = angle[transmit].sin_cos();
                (x * sine + z * cosine) / c
            }
            Transmits::Focused { x: axis, focus, .. } => {
                (focus[transmit] - (x - axis[transmit]).hypot(z - focus[transmit])) / c
            }
            Transmits::VirtualSource { x: sx, z: sz } => {
                let (sx, sz) = (sx[transmit], sz[transmit]);
                let later = (x - sx).hypot(z - sz) - sx.hypot(sz);
                if sz > 0.0 { -later / c } else { later / c }
            }
            Transmits::Element { index } if index[transmit] == element => 0.0,
            Transmits::Element { .. } => f64::NAN,
            Transmits::Delays { delay } => delay[(transmit, element)],
        }
    })
}

/// Positions (x, 0, z) of the samples of lines, m, beam by beam.
pub(super) fn positions(lines: &BeamformedLines) -> Vec<[f64; 3]> {
    let (beams, samples) = lines.z.dim();
    let position = |k: usize| {
        let (beam, sample) = (k / samples, k % samples);
        let depth = lines.c * (lines.t0 + sample as f64 / lines.fs) / 2.0;
        let [x, z] = lines.point(beam, depth);
        [x, 0.0, z]
    };
    (0..beams * samples).map(position).collect()
}
