//! Records upsampled once and interpolated along lines.

use std::vec;
use std::vec::Vec;

use bonebeam::prelude::stages::*;

use super::delay::{Law, Place};
use crate::draw::Draw;
use crate::kernel::Kernel;

/// Waves compounded from upsampled records.
#[derive(Clone, Debug)]
pub struct Waves {
    /// The stage.
    pub delay: Delay,
    /// The array.
    pub place: Place,
    /// The waves: law, `t0` and record `[element][sample]`.
    pub waves: Vec<(Law, f64, Vec<f32>)>,
    /// The line.
    pub ray: Ray,
    /// The active elements.
    pub active: Active,
    /// Values that are added at a time, in the second way.
    pub block: usize,
}

impl Waves {
    /// The waves' lines, and their records.
    pub fn lines(&self) -> impl Iterator<Item = (ScanLine<'_>, &[f32])> {
        self.waves.iter().map(|(law, t0, rf)| {
            let line = ScanLine {
                active: self.active,
                ..ScanLine::new(Transmit::new(law.law(), *t0), self.ray, self.place.array())
            };
            (line, &rf[..])
        })
    }
}

impl Kernel for Waves {
    type Number = Complex<f32>;

    fn draw(draw: &mut impl Draw) -> Result<Self, Error> {
        let wild = draw.once_in(4);
        let (elements, record_samples) = (draw.size(6, 40), draw.size(200, 700));
        let [sampling_rate, output_rate] = draw.one_of(&[[20e6, 20e6], [20e6, 40e6], [40e6, 20e6]]);
        let length = record_samples as f64 / sampling_rate;
        let delay = Delay::new(DelayParameters {
            sound_speed: draw.number(wild, [300.0, 4000.0]),
            sampling_rate,
            centre_frequency: 5e6,
            output_rate,
            output_start: draw.number(wild, [-0.3 * length, 0.9 * length]),
            output_samples: draw.size(40, 200),
            elements,
            record_samples,
            hilbert_taps: 1 + draw.below(20),
        })?;
        let pitch = draw.number(wild, [1e-5, 2e-3]);
        let place = Place::draw(draw, wild, (elements, pitch));
        let waves = (0..1 + draw.below(3)).map(|_| {
            let law = Law::draw(draw, wild, elements);
            (law, draw.number(wild, [-1e-6, 1e-6]), Vec::new())
        });
        let mut waves: Vec<_> = waves.collect();
        let mut at = |usual| draw.number(wild, usual);
        let ray = Ray::new(at([-3e-3, 3e-3]), at([-3e-3, 3e-3]), at([-0.6, 0.6]));
        let first = draw.below(elements);
        let active = Active::new(first, 1 + draw.below(elements - first));
        let block = 1 + draw.below(200);
        for (.., rf) in &mut waves {
            *rf = draw.record(elements * record_samples);
        }
        Ok(Waves {
            delay,
            place,
            waves,
            ray,
            active,
            block,
        })
    }

    fn need(&self, lanes: usize, _: usize) -> [Need; 2] {
        let padded =
            Upsampled::new(&self.delay).map_or(Need::default(), |upsampled| upsampled.need());
        [
            self.delay.parameters().need(lanes).and(padded),
            Need::default(),
        ]
    }

    fn numbers(&self) -> usize {
        let p = self.delay.parameters();
        p.elements * p.output_samples
    }

    fn run<V: Vector>(
        &self,
        zero: V,
        way: usize,
        (mut memory, _): (Scratch<'_>, Scratch<'_, V>),
        out: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        let p = self.delay.parameters();
        let upsampled = Upsampled::new(&self.delay)?;
        let scratch = memory.take(p.need(V::LANES))?.real;
        let length = upsampled.line_len();
        let block = if way == 0 { length } else { way };
        let mut lines = vec![0.0; self.active.count * length];
        let (mut centre, mut receive_delays) = (vec![i32::MAX; length], vec![i32::MAX; length]);
        let mut record = vec![f32::NAN; upsampled.record_len()];
        for (line, rf) in self.lines() {
            upsampled.centre(&line, &mut centre)?;
            for (k, values) in lines.chunks_exact_mut(length).enumerate() {
                let element = self.active.first + k;
                let samples = &rf[element * p.record_samples..][..p.record_samples];
                upsampled.record(zero, samples, memory.real, &mut record)?;
                upsampled.receive_delays(zero, &line, element, &mut receive_delays)?;
                let blocks = centre.chunks(block).zip(receive_delays.chunks(block));
                for ((centre, receive_delays), values) in blocks.zip(values.chunks_mut(block)) {
                    upsampled.add(
                        zero,
                        &Contribution {
                            record: &record,
                            centre,
                            receive_delays,
                        },
                        values,
                    )?;
                }
            }
        }
        let first = self.lines().next();
        first.map_or(Ok(()), |(line, _)| {
            upsampled.analytic(zero, &line, &lines, scratch, out)
        })
    }

    fn ways(&self) -> Vec<usize> {
        vec![self.block]
    }
}
