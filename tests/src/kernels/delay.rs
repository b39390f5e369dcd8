//! The delay stage, from RF or I/Q: a line, and more added to it.

use std::boxed::Box;
use std::vec;
use std::vec::Vec;

use bonebeam::prelude::stages::*;

use crate::draw::Draw;
use crate::kernel::Kernel;

/// Rates of the record and of the output, and centre frequency, Hz.
///
/// Records are interpolated, filtered, and halved up to three times.
pub const FILTERS: [[f64; 3]; 8] = [
    [20e6, 20e6, 5e6],
    [20e6, 40e6, 5e6],
    [40e6, 20e6, 5e6],
    [50e6, 20e6, 3e6],
    [62.5e6, 5e6, 5e6],
    [100e6, 20e6, 7e6],
    [160e6, 12e6, 2e6],
    [80e6, 5e6, 1.5e6],
];

/// Lines of the delay stage.
#[derive(Clone, Debug)]
pub struct Lines {
    /// The array, its elements at any positions.
    pub place: Place,
    /// The waves, the first of which replaces the output: law, `t0` and ray.
    pub waves: Vec<(Law, f64, Ray)>,
    /// The active elements.
    pub active: Active,
    /// Samples of a block in the second way.
    pub block: usize,
    /// Where the samples come from.
    pub input: Input,
}

/// A stage with its record.
#[derive(Clone, Debug)]
pub enum Input {
    /// RF, `[element][sample]`, and whether the filter is made in f32.
    Rf(Box<Delay>, Vec<f32>, bool),
    /// I/Q.
    Iq(IqDelay, Iq),
}

/// A record of I/Q.
#[derive(Clone, Debug)]
pub struct Iq {
    /// `[element][sample]`; counts as numbers.
    pub planar: Vec<Complex<f32>>,
    /// The scale of counts; `None` for numbers.
    pub counts: Option<f32>,
    /// Whether the record is `[sample][element]`.
    pub interleaved: bool,
    /// Phase of the demodulator, rad.
    pub phase: f64,
}

/// Elements at a pitch, on an axis, or anywhere.
#[derive(Clone, Debug)]
pub enum Place {
    /// Elements and pitch.
    Even(usize, f64),
    /// Lateral positions, m.
    Level(Vec<f64>),
    /// Any positions.
    Any(Vec<Element>),
}

impl Place {
    /// As the core takes it.
    pub fn array(&self) -> Array<'_> {
        match self {
            Place::Even(elements, pitch) => Array::linear(*elements, *pitch),
            Place::Level(x) => Array::LinearAt(x),
            Place::Any(elements) => Array::at(elements, 0.3e-3),
        }
    }

    /// An array of some elements, at a pitch if it is even.
    pub fn draw(draw: &mut impl Draw, wild: bool, (elements, pitch): (usize, f64)) -> Self {
        match draw.below(4) {
            0 => Place::Even(elements, pitch),
            1 => Place::Level((0..elements).map(|m| m as f64 * pitch).collect()),
            2 => {
                let curve = |m| Element::convex(elements, 0.3e-3, 40e-3, m);
                Place::Any((0..elements).map(curve).collect())
            }
            _ => {
                let mut at = || draw.number(wild, [-5e-3, 5e-3]);
                let elements = (0..elements).map(|_| Element::down(at(), at()));
                Place::Any(elements.collect())
            }
        }
    }
}

/// A transmit law with its own memory.
#[derive(Clone, Debug)]
pub enum Law {
    /// A law of numbers.
    Of(TransmitLaw<'static>),
    /// The firing times of the elements.
    Delays(Vec<f64>),
}

impl Law {
    /// As the core takes it.
    pub fn law(&self) -> TransmitLaw<'_> {
        match self {
            Law::Of(law) => *law,
            Law::Delays(delays) => TransmitLaw::Delays(delays),
        }
    }

    /// A law for an array of `elements` elements.
    pub fn draw(draw: &mut impl Draw, wild: bool, elements: usize) -> Self {
        let mut at = |usual| draw.number(wild, usual);
        let (x, z) = (at([-0.02, 0.02]), at([-0.02, 0.02]));
        Law::Of(match draw.below(6) {
            0 | 1 => TransmitLaw::Focused,
            2 => TransmitLaw::Plane {
                angle: if wild { x } else { 50.0 * x },
            },
            3 => TransmitLaw::Element { x, z },
            4 => TransmitLaw::VirtualSource { x, z },
            _ => {
                let delay = |_| match draw.byte() {
                    0..16 => f64::NAN,
                    _ => draw.number(wild, [0.0, 1e-6]),
                };
                return Law::Delays((0..elements).map(delay).collect());
            }
        })
    }
}

/// A stage of usual rates, whose filters take longer to make than a line.
fn stage(parameters: DelayParameters) -> Result<Delay, Error> {
    use std::cell::RefCell;
    std::thread_local! {
        static STAGES: RefCell<Vec<Delay>> = const { RefCell::new(Vec::new()) };
    }
    STAGES.with_borrow_mut(|stages| {
        let rates = |p: &DelayParameters| [p.sampling_rate, p.output_rate, p.centre_frequency];
        let taps = |p: &DelayParameters| p.hilbert_taps;
        let alike =
            |p: &DelayParameters| rates(p) == rates(&parameters) && taps(p) == taps(&parameters);
        let kept = stages.iter().position(|stage| alike(stage.parameters()));
        let mut stage = match kept {
            Some(kept) => stages[kept].clone(),
            None => Delay::new(parameters)?,
        };
        stage.set(parameters)?;
        if kept.is_none() && FILTERS.contains(&rates(&parameters)) {
            stages.push(stage.clone());
        }
        Ok(stage)
    })
}

impl Lines {
    /// The lines, the first of which replaces the output.
    pub fn lines(&self) -> impl Iterator<Item = ScanLine<'_>> {
        self.waves
            .iter()
            .enumerate()
            .map(|(index, (law, t0, ray))| ScanLine {
                active: self.active,
                compounding: if index == 0 {
                    Compounding::Replace
                } else {
                    Compounding::Add
                },
                ..ScanLine::new(Transmit::new(law.law(), *t0), *ray, self.place.array())
            })
    }

    /// Elements and samples of the output.
    pub fn shape(&self) -> [usize; 2] {
        match &self.input {
            Input::Rf(stage, ..) => [
                stage.parameters().elements,
                stage.parameters().output_samples,
            ],
            Input::Iq(stage, _) => [
                stage.parameters().elements,
                stage.parameters().output_samples,
            ],
        }
    }
}

/// The record as the core takes it.
fn with_iq<T>(
    iq: &Iq,
    elements: usize,
    work: impl FnOnce(&Record<'_>) -> Result<T, Error>,
) -> Result<T, Error> {
    let samples = iq.planar.len() / elements;
    let place = |n: usize| {
        if iq.interleaved {
            (n % elements) * samples + n / elements
        } else {
            n
        }
    };
    let numbers = (0..iq.planar.len()).map(|n| iq.planar[place(n)]);
    let layout = if iq.interleaved {
        IqLayout::Interleaved
    } else {
        IqLayout::Planar
    };
    let of = |samples| Record::iq(samples, layout, elements)?.with_phase(iq.phase);
    match iq.counts {
        None => work(&of(IqSamples::Float(&numbers.collect::<Vec<_>>()))?),
        Some(scale) => {
            let counts: Vec<_> = numbers.map(|x| [x.re as i16, x.im as i16]).collect();
            work(&of(IqSamples::Counts(&counts, scale))?)
        }
    }
}

/// The lines, whole or in blocks of `block` samples.
fn run<V: Vector, D: Stage>(
    zero: V,
    lines: &Lines,
    (stage, record): (&D, &Record<'_>),
    block: usize,
    scratch: &mut [f32],
    out: &mut [Complex<f32>],
) -> Result<(), Error> {
    let [elements, _] = lines.shape();
    for line in lines.lines() {
        if block == 0 {
            stage.line(zero, &line, record, scratch, out)?;
            continue;
        }
        for (index, out) in out.chunks_mut(block * elements).enumerate() {
            let need = stage.need(V::LANES, out.len() / elements).real;
            let actual = scratch.len();
            let short = Error::Length {
                name: "scratch",
                actual,
                expected: need,
            };
            let scratch = scratch.get_mut(..need).ok_or(short)?;
            stage.block(zero, &line, record, index * block, scratch, out)?;
        }
    }
    Ok(())
}

impl Kernel for Lines {
    type Number = Complex<f32>;

    fn draw(draw: &mut impl Draw) -> Result<Self, Error> {
        let wild = draw.once_in(4);
        let iq = draw.flag();
        let (elements, record_samples) = (draw.size(6, 40), draw.size(200, 2000));
        let output_samples = draw.size(40, 200);
        let [mut sampling_rate, mut output_rate, centre_frequency] = draw.one_of(&FILTERS);
        if draw.byte() < 32 {
            sampling_rate = draw.number(wild, [10e6, 200e6]);
            output_rate = if draw.flag() {
                sampling_rate
            } else {
                draw.number(wild, [5e6, 60e6])
            };
        }
        let pitch = draw.number(wild, [1e-5, 2e-3]);
        let place = Place::draw(draw, wild, (elements, pitch));
        let waves = (0..1 + draw.below(2)).map(|_| {
            let law = Law::draw(draw, wild, elements);
            // On the grid of an even array, where the elements are in pairs, or anywhere.
            let ray = match draw.below(4) {
                0 => Ray::down(draw.below(2 * elements) as f64 * pitch / 2.0),
                1 => {
                    let half = draw.below(2 * elements) as f64 - (elements as f64 - 1.0);
                    Ray::down(half * pitch / 2.0)
                }
                2 => Ray::down(draw.number(wild, [-3e-3, 3e-3])),
                _ => {
                    let mut at = |usual| draw.number(wild, usual);
                    Ray::new(at([-3e-3, 3e-3]), at([-3e-3, 3e-3]), at([-0.6, 0.6]))
                }
            };
            (law, draw.number(wild, [-1e-6, 1e-6]), ray)
        });
        let waves = waves.collect();
        let active = match draw.byte() {
            0..128 => Active::new(0, elements),
            _ => Active::new(draw.below(8), draw.below(elements + 2)),
        };
        // So that a line begins before the record, within it, or behind it.
        let length = record_samples as f64 / sampling_rate;
        let output_start = draw.number(wild, [-0.3 * length, 0.9 * length]);
        let sound_speed = draw.number(wild, [300.0, 4000.0]);
        let block = 1 + draw.below(output_samples);
        let input = match iq {
            false => {
                let mut stage = stage(DelayParameters {
                    sound_speed,
                    sampling_rate,
                    centre_frequency,
                    output_rate,
                    output_start,
                    output_samples,
                    elements,
                    record_samples,
                    hilbert_taps: 1 + draw.below(40),
                })?;
                let in_f32 = draw.once_in(8);
                if in_f32 {
                    let parameters = *stage.parameters();
                    stage.set_in_f32(parameters)?;
                }
                let rf = draw.record(elements * record_samples);
                Record::new(&rf, elements)?;
                Input::Rf(Box::new(stage), rf, in_f32)
            }
            true => {
                let interpolation = draw.one_of(&[
                    IqInterpolation::Linear,
                    IqInterpolation::Cubic,
                    IqInterpolation::Sinc,
                    IqInterpolation::LinearFixed,
                ]);
                let stage = IqDelay::new(IqParameters {
                    sound_speed,
                    sampling_rate,
                    demodulation_frequency: draw.number(wild, [-0.9, 0.9]) * sampling_rate,
                    output_rate,
                    output_start,
                    output_samples,
                    elements,
                    record_samples,
                    interpolation,
                })?;
                let counts = interpolation == IqInterpolation::LinearFixed || draw.flag();
                let mut iq = Iq {
                    planar: Vec::new(),
                    counts: counts.then(|| draw.number(wild, [1e-3, 2.0]).abs() as f32),
                    interleaved: draw.flag(),
                    phase: draw.number(wild, [-7.0, 7.0]),
                };
                let parts = draw.record(2 * elements * record_samples);
                let (pairs, _) = parts.as_chunks::<2>();
                // Counts take all 16 bits.
                let part = |part: f32| {
                    if counts {
                        f32::from((part * 300.0) as i16)
                    } else {
                        part
                    }
                };
                iq.planar = pairs
                    .iter()
                    .map(|pair| Complex::new(part(pair[0]), part(pair[1])))
                    .collect();
                with_iq(&iq, elements, |_| Ok(()))?;
                Input::Iq(stage, iq)
            }
        };
        Ok(Lines {
            input,
            place,
            waves,
            active,
            block,
        })
    }

    fn need(&self, lanes: usize, way: usize) -> [Need; 2] {
        let samples = if way == 0 { self.shape()[1] } else { way };
        let need = match &self.input {
            Input::Rf(stage, ..) => Stage::need(&**stage, lanes, samples),
            Input::Iq(stage, _) => Stage::need(stage, lanes, samples),
        };
        [need, Need::default()]
    }

    fn numbers(&self) -> usize {
        let [elements, samples] = self.shape();
        elements * samples
    }

    fn run<V: Vector>(
        &self,
        zero: V,
        way: usize,
        (scratch, _): (Scratch<'_>, Scratch<'_, V>),
        out: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        let [elements, _] = self.shape();
        match &self.input {
            Input::Rf(stage, rf, _) => {
                let record = Record::new(rf, elements)?;
                run(zero, self, (&**stage, &record), way, scratch.real, out)
            }
            Input::Iq(stage, iq) => with_iq(iq, elements, |record| {
                run(zero, self, (stage, record), way, scratch.real, out)
            }),
        }
    }

    fn is_one_call(&self, way: usize) -> bool {
        way == 0 && self.waves.len() == 1
    }

    fn ways(&self) -> Vec<usize> {
        vec![self.block]
    }
}
