//! Channel data of focused transmits, from the echoes of every pair of elements.
//!
//! 1. The echoes of every element pair: `cell_sum` in f32, or `direct_sum` in f64. By reciprocity the pair
//!    (i, j) is that of (j, i), and the cost does not depend on the number of beams.
//! 2. Beam l, receiver j: S(f) = Σ_i H_ij(f)·e^{+j2πfτ_i} over the transmit aperture, with the
//!    focusing advance τ_i = (√(x_i² + F²) − F)/c for x_i from the beam's axis and the focus F.
//! 3. An inverse transform per row at the record's sampling frequency, electronic noise, the converter.
//!
//! Time 0 is the moment at which the transmit wave passes z = 0 on the beam's axis. The result's
//! bits depend neither on the number of threads nor on the machine.

use std::sync::atomic::{AtomicUsize, Ordering};

use bonebeam::dispatch;
use bonebeam::simd::InstructionSet;
use ndarray::Array3;
use num_complex::Complex;
use rayon::prelude::*;

use crate::{Error, Result};
use bonebeam_files::memory::{self, product};
use bonebeam_files::{ChannelData, Samples, Transmits};

use super::cell_sum::{self, Beam, Tile};
use super::cells::cells;
use super::checkpoint::Checkpoint;
use super::coherence::decorrelate;
use super::direct_sum;
use super::fourier::{Fourier, unit};
use super::noise::Noise;
use super::phantom::Phantom;
use super::pulse::{DIRECT_FLOOR, FLOOR};
use super::response::Response;
use super::scatterer::PointSource;
use super::settings::Settings;
use super::shadow::Shadow;
use super::time_axis::{Window, row_rate};

/// Method of summation over the scatterers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Summation {
    /// Every scatterer at every frequency in f64: exact, for up to some tens of them.
    Direct,
    /// Cells of scatterers in f32: for any number, within −85 dB of the direct sum.
    Cells,
}

/// Share of the sum over the scatterers in the whole work.
const SUM_SHARE: f64 = 0.9;
/// Ratio of pairs to rows of beams from which beams are summed first.
const FEW: usize = 3;
/// Side of a cell, in lengths of the pulse.
const CELL: f64 = 0.25;

/// Simulates the record of every beam and element.
///
/// `progress` is called with the fraction done, 0 to 1, from any thread.
///
/// # Errors
/// Impossible settings, a phantom that reaches the array, or an empty record.
pub fn channel_data(
    settings: &Settings,
    phantom: &Phantom,
    summation: Summation,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<ChannelData> {
    let set = InstructionSet::detect();
    resumed_channel_data(
        settings,
        phantom,
        summation,
        set,
        progress,
        &mut Checkpoint::none(),
    )
}

/// As [`channel_data`], with the vectors of `set`, resuming from a checkpoint.
///
/// The bits are those of a run without interruption.
///
/// # Errors
/// As [`channel_data`], and a checkpoint that cannot be read or written.
pub fn resumed_channel_data(
    settings: &Settings,
    phantom: &Phantom,
    summation: Summation,
    set: InstructionSet,
    progress: &(dyn Fn(f64) + Sync),
    checkpoint: &mut Checkpoint,
) -> Result<ChannelData> {
    settings.validate()?;
    phantom.check_in_front()?;
    let beams: Vec<Beam> = (0..settings.beams).map(|l| beam(settings, l)).collect();
    let how = How {
        settings,
        beams: &beams,
        summation,
        set,
    };
    let mut rf = match phantom.without_incoherent_clutter() {
        None => how.echoes(phantom, progress, checkpoint)?,
        Some([rest, clutter]) => {
            let fraction = rest.sources().len() as f64;
            let fraction = fraction / (fraction + clutter.sources().len() as f64);
            let mut rf = how.echoes(&rest, &|done| progress(fraction * done), checkpoint)?;
            let progress = |done| progress(fraction + (1.0 - fraction) * done);
            let mut more = how.echoes(&clutter, &progress, &mut Checkpoint::none())?;
            decorrelate(settings, phantom.clutter_coherence, &mut more);
            rf.iter_mut().zip(&more).for_each(|(sum, v)| *sum += v);
            rf
        }
    };
    let peak = rf.par_iter().map(|v| v.abs()).reduce(|| 0.0, f32::max);
    if peak == 0.0 || !peak.is_finite() {
        return Err(Error::Data(format!(
            "the record is silent; no element receives an echo of the phantom from {} to {} m of depth; \
             give other depths, or a phantom below the array that no bone hides",
            settings.depth_start, settings.depth_end
        )));
    }
    let record = settings.time_axis();
    receive(settings, &mut rf);
    let shape = (beams.len(), settings.elements, record.samples);
    Ok(ChannelData {
        t0: vec![record.t0; beams.len()],
        ..ChannelData::linear(
            Array3::from_shape_vec(shape, rf).expect("the record's shape"),
            settings.array().element_x(),
            Transmits::Focused {
                x: beams.iter().map(|beam| beam.x).collect(),
                focus: vec![settings.focus; beams.len()],
                f_number: Some(settings.f_number),
            },
            ([settings.fs, settings.f0], settings.c),
        )
    })
}

/// Method of the simulation of a record.
struct How<'a> {
    settings: &'a Settings,
    beams: &'a [Beam],
    summation: Summation,
    set: InstructionSet,
}

impl How<'_> {
    /// The echoes of a phantom, free of noise, `[beam][element][sample]`.
    fn echoes(
        &self,
        phantom: &Phantom,
        progress: &(dyn Fn(f64) + Sync),
        checkpoint: &mut Checkpoint,
    ) -> Result<Vec<f32>> {
        let How {
            settings, beams, ..
        } = self;
        let sources = phantom.sources();
        let mut transmits = vec![false; settings.elements];
        for i in beams.iter().flat_map(|beam| beam.elements.clone()) {
            transmits[i] = true;
        }
        let acquisition = Acquisition {
            settings,
            sources: &sources,
            shadow: phantom.shadow(),
            element_x: settings.array().element_x(),
            transmits: &transmits,
            beams,
        };
        progress(0.0);
        let sum = |done: f64| progress(SUM_SHARE * done);
        let (window, pairs) = match self.summation {
            Summation::Direct => acquisition.direct(&sum)?,
            Summation::Cells => acquisition.cells(self.set, checkpoint, &sum)?,
        };
        let done = AtomicUsize::new(0);
        let tick = || {
            let beams = (done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / settings.beams as f64;
            progress(SUM_SHARE + (1.0 - SUM_SHARE) * beams);
        };
        Ok(form_beams(settings, &window, &pairs, beams, &tick))
    }
}

/// Adds the receiver's noise and rounding to a record simulated without.
///
/// Echoes add up, so the same echoes are summed only once for several receivers.
///
/// # Errors
/// Samples of another record than that of the settings.
pub fn add_noise(settings: &Settings, data: &mut ChannelData) -> Result<()> {
    let expected = [
        settings.beams,
        settings.elements,
        settings.time_axis().samples,
    ];
    let refused = |found: &[usize]| {
        Error::Data(format!(
            "the record has shape {found:?}; expected RF of one frame, {expected:?}"
        ))
    };
    let Samples::Rf(rf) = &mut data.samples else {
        return Err(refused(&[]));
    };
    if rf.shape()[1..] != expected || rf.shape()[0] != 1 {
        return Err(refused(rf.shape()));
    }
    let shape = rf.shape().to_vec();
    let rf = rf.as_slice_mut().ok_or_else(|| refused(&shape))?;
    receive(settings, rf);
    Ok(())
}

/// Noise of the settings' spectrum, seed and time-gain curve in every channel.
///
/// The record is `[transmit][element][sample]`; the RMS at depth 0 is `rms`.
pub fn noise(settings: &Settings, rms: f64) -> Vec<f32> {
    let samples = settings.time_axis().samples;
    let mut rows = vec![0.0; settings.beams * settings.elements * samples];
    Noise::new(settings, rms).add_to(&mut rows);
    rows
}

/// Adds the settings' noise and applies their converter.
fn receive(settings: &Settings, rf: &mut [f32]) {
    if let Some(level) = settings.noise {
        let peak = rf.par_iter().map(|v| v.abs()).reduce(|| 0.0, f32::max);
        let rms = f64::from(peak) * libm::pow(10.0, level / 20.0);
        Noise::new(settings, rms).add_to(rf);
    }
    if let Some(bits) = settings.adc_bits {
        quantise(rf, bits);
    }
}

/// Sources, elements and their visibility.
struct Acquisition<'a> {
    settings: &'a Settings,
    sources: &'a [PointSource],
    shadow: Shadow,
    element_x: Vec<f64>,
    transmits: &'a [bool],
    beams: &'a [Beam],
}

/// Spectra of echoes.
enum Spectra {
    /// Spectra of the pairs i ≤ j; empty if no element of the pair transmits.
    Pairs(Vec<Vec<Complex<f64>>>),
    /// Spectra of every beam and element, `[beam·elements + element][frequency]`.
    Beams(Vec<Vec<Complex<f64>>>),
}

impl Acquisition<'_> {
    fn direct(&self, tick: &(dyn Fn(f64) + Sync)) -> Result<(Window, Spectra)> {
        let settings = self.settings;
        let input = direct_sum::DirectSumInput {
            sources: self.sources,
            shadow: &self.shadow,
            element_x: &self.element_x,
            response: Response::new(settings),
            pulse: settings.pulse(),
        };
        let band = input.pulse.band(DIRECT_FLOOR);
        let window = settings.window(band, settings.fs, 2.0 * input.reach());
        let legs = [settings.elements, self.sources.len(), window.bins, 16];
        self.check_memory(&window, product(&legs))?;
        let legs = input.all_legs(&window);
        let elements = settings.elements;
        let done = AtomicUsize::new(0);
        let rows = (0..elements)
            .into_par_iter()
            .flat_map_iter(|i| {
                let row = |j: usize| match self.transmits[i] || self.transmits[j] {
                    true => input.pair(&window, &legs[i], &legs[j]),
                    false => Vec::new(),
                };
                let rows: Vec<_> = (i..elements).map(row).collect();
                tick((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / elements as f64);
                rows
            })
            .collect();
        Ok((window, Spectra::Pairs(rows)))
    }

    fn cells(
        &self,
        set: InstructionSet,
        checkpoint: &mut Checkpoint,
        tick: &(dyn Fn(f64) + Sync),
    ) -> Result<(Window, Spectra)> {
        let settings = self.settings;
        let (response, pulse) = (Response::new(settings), settings.pulse());
        let band = pulse.band(FLOOR);
        let rate = row_rate(settings.fs, band);
        let side = CELL * settings.c * 2.0 * pulse.half_length(FLOOR);
        let cells = cells(self.sources, side, &response);
        let mut input = cell_sum::CellSumInput {
            sources: self.sources,
            cells: &cells,
            shadow: &self.shadow,
            element_x: &self.element_x,
            response,
            pulse,
            window: settings.window(band, rate, 0.0),
            transmits: self.transmits,
            beams: None,
        };
        // Few beams have fewer rows than the pairs of their elements, though longer ones.
        let pairs = input.pairs();
        if self.beams.len() * settings.elements * FEW <= pairs {
            input.beams = Some(self.beams);
        }
        let longest = cell_sum::longest(&input);
        input.window = settings.window(band, rate, longest);
        let legs = [settings.elements, 64, longest_frequencies(longest, band), 8];
        self.check_memory(&input.window, product(&legs))?;
        let mut tiles = Tile::all(&input);
        dispatch!(set, zero => cell_sum::sum(zero, &input, &mut tiles, checkpoint, tick))?;
        let beams = input.beams.map(<[Beam]>::len);
        let spectra = spectra(&input.window, tiles, settings.elements, beams);
        Ok((input.window, spectra))
    }

    /// Checks the memory of the record, of the pairs and of `legs` bytes.
    ///
    /// It is done before any is allocated.
    fn check_memory(&self, window: &Window, legs: usize) -> Result<()> {
        let settings = self.settings;
        let pairs = product(&[
            settings.elements,
            settings.elements.div_ceil(2) + 1,
            // A row in f32, and its spectrum in f64.
            window
                .row
                .saturating_mul(8)
                .saturating_add(window.bins * 16),
        ]);
        let transforms = product(&[rayon::current_num_threads(), window.samples, 4 * 16]);
        let record = settings.record_bytes();
        let parts = [record, pairs, transforms, legs];
        let all = parts.into_iter().fold(0, usize::saturating_add);
        memory::check(all, "the record")
    }
}

/// Largest number of frequencies for a cell's echoes of a duration in s.
fn longest_frequencies(longest: f64, [lowest, highest]: [f64; 2]) -> usize {
    (longest * (highest - lowest)).ceil() as usize + 32
}

/// Spectra of the rows at the frequencies of the window.
fn spectra(window: &Window, tiles: Vec<Tile>, elements: usize, beams: Option<usize>) -> Spectra {
    let plan = Fourier::new(window.row);
    let count = beams.map_or(elements * (elements + 1) / 2, |beams| beams * elements);
    let mut rows = vec![Vec::new(); count];
    for tile in tiles {
        let found: Vec<Vec<Complex<f64>>> = (tile.rows)
            .par_chunks_exact(2 * window.row)
            .map(|row| {
                let (re, im) = row.split_at(window.row);
                let mut x: Vec<Complex<f64>> = (re.iter().zip(im))
                    .map(|(&re, &im)| Complex::new(f64::from(re), f64::from(im)))
                    .collect();
                plan.forward(&mut x, &mut Vec::new());
                let scale = 1.0 / window.row as f64;
                (0..window.bins)
                    .map(|k| x[(window.first_bin + k) % window.row] * scale)
                    .collect()
            })
            .collect();
        for (&(i, j), row) in tile.pairs.iter().zip(found) {
            let index = match beams {
                Some(_) => i * elements + j,
                None => pair_index(elements, i, j),
            };
            rows[index] = row;
        }
    }
    match beams {
        Some(_) => Spectra::Beams(rows),
        None => Spectra::Pairs(rows),
    }
}

/// Index of the pair i ≤ j when pairs are counted (0, 0), (0, 1), …, (1, 1), ….
fn pair_index(elements: usize, i: usize, j: usize) -> usize {
    i * (2 * elements + 1 - i) / 2 + j - i
}

/// The record of every beam and element.
fn form_beams(
    settings: &Settings,
    window: &Window,
    spectra: &Spectra,
    beams: &[Beam],
    tick: &(dyn Fn() + Sync),
) -> Vec<f32> {
    let samples = settings.time_axis().samples;
    let mut rf = vec![0.0f32; beams.len() * settings.elements * samples];
    let plan = Fourier::new(window.samples);
    rf.par_chunks_mut(settings.elements * samples)
        .zip(beams)
        .enumerate()
        .for_each(|(l, (rows, beam))| {
            let phases: Vec<Vec<Complex<f64>>> = beam
                .advance
                .iter()
                .map(|&advance| beam_phase(window, advance))
                .collect();
            let elements = settings.elements;
            let sum = |j: usize| {
                let pairs = match spectra {
                    Spectra::Beams(rows) => return rows[l * elements + j].clone(),
                    Spectra::Pairs(rows) => rows,
                };
                let mut sum = vec![Complex::<f64>::default(); window.bins];
                for (i, phase) in beam.elements.clone().zip(&phases) {
                    let pair = &pairs[pair_index(elements, i.min(j), i.max(j))];
                    for ((s, h), e) in sum.iter_mut().zip(pair).zip(phase) {
                        *s += h * e;
                    }
                }
                sum
            };
            let (mut x, mut scratch) = (Vec::new(), Vec::new());
            // Two real rows are the real and the imaginary part of one transform.
            for (pair, rows) in rows.chunks_mut(2 * samples).enumerate() {
                let two = rows.len() > samples;
                let first = sum(2 * pair);
                let second = if two { sum(2 * pair + 1) } else { Vec::new() };
                x.clear();
                x.resize(window.samples, Complex::default());
                for k in 0..window.bins {
                    let (a, b) = (first[k], second.get(k).copied().unwrap_or_default());
                    let ib = Complex::new(-b.im, b.re);
                    let bin = window.first_bin + k;
                    x[bin] = a + ib;
                    x[window.samples - bin] = (a - ib).conj();
                }
                plan.inverse(&mut x, &mut scratch);
                let (a, b) = rows.split_at_mut(samples);
                // A row without echoes stays zero: it has no part in the rounding of the other.
                let has_echoes =
                    |sum: &[Complex<f64>]| sum.iter().any(|v| *v != Complex::default());
                let values = &x[window.lead..];
                if has_echoes(&first) {
                    a.iter_mut().zip(values).for_each(|(r, v)| *r = v.re as f32);
                }
                if has_echoes(&second) {
                    b.iter_mut().zip(values).for_each(|(r, v)| *r = v.im as f32);
                }
            }
            tick();
        });
    rf
}

/// Rounds to the steps of a converter of `bits` bits over the largest sample.
fn quantise(rf: &mut [f32], bits: u32) {
    let peak = rf.par_iter().map(|v| v.abs()).reduce(|| 0.0, f32::max);
    let most = f64::from((1u32 << (bits - 1)) - 1);
    let step = f64::from(peak) / most;
    rf.par_iter_mut()
        .for_each(|v| *v = (libm::rint(f64::from(*v) / step) * step) as f32);
}

fn beam(settings: &Settings, index: usize) -> Beam {
    let array = settings.array();
    let x = settings.beam_x(index);
    let position = settings.first_beam + index as f64 * settings.beam_step;
    let elements = array.transmit_elements(position, settings.focus, settings.f_number);
    let advance = elements
        .clone()
        .map(|i| settings.advance(array.x(i as f64) - x))
        .collect();
    Beam {
        x,
        elements,
        advance,
    }
}

fn beam_phase(window: &Window, advance: f64) -> Vec<Complex<f64>> {
    (0..window.bins)
        .map(|k| unit((window.first_bin + k) as f64 * window.df * advance))
        .collect()
}
