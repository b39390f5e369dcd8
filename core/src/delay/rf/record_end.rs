//! The part of a record that a block of a line reads.

use core::ops::Range;

use super::{Delay, FAR, ScanLine};
use crate::Error;
use crate::delay::decimator::reach;
use crate::delay::flight::CentreSample;
use crate::delay::stage::check_line;

impl Delay {
    /// Number of a record's first samples that output samples of a line depend on.
    ///
    /// A scanner can compute these outputs once it has recorded this number of samples: later ones may have any finite
    /// value. The number is at most a few samples too large, and at most the whole record. Line, transmit and active
    /// elements are those of [`Stage::line`](crate::delay::Stage::line), and elements lie along a line or an arc.
    ///
    /// Cost: two positions in f64 for each output sample, so compute it with the plan.
    ///
    /// ```
    /// use bonebeam::prelude::stages::*;
    ///
    /// let scan = Scan::new(ScanParameters::EXAMPLE)?;
    /// let delay = Delay::new(DelayParameters::of(&scan))?;
    /// let transmit = Transmit::new(TransmitLaw::Focused, 0.0);
    /// let line = ScanLine::of(&scan, 32, transmit, Compounding::Replace);
    /// // 104 samples to 4 mm, 64 of the block, and 30 of the receive delay and the filters.
    /// assert_eq!(delay.record_end(&line, 0..64)?, 198);
    /// # Ok::<(), bonebeam::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Stage::line`](crate::delay::Stage::line) for the line; [`Error::Capacity`] for a block that ends after the
    /// line.
    pub fn record_end(&self, line: &ScanLine, block: Range<usize>) -> Result<usize, Error> {
        let p = &self.parameters;
        if block.end > p.output_samples {
            return Err(Error::capacity("block", block.end, p.output_samples));
        }
        let transmit = check_line(line, p.elements, p.sound_speed)?;
        let active = line.active.first..line.active.first.saturating_add(line.active.count);
        if active.is_empty() || block.is_empty() {
            return Ok(0);
        }
        let hilbert = self.hilbert.reach();
        let flight = self.flight(&transmit, line);
        // The receive delay is largest at an end of the elements.
        let receive = [active.start, active.end.saturating_sub(1)]
            .map(|element| self.receive_delay(line, element));
        let mut last = f64::NEG_INFINITY;
        for sample in block.start..block.end.saturating_add(2 * hilbert) {
            let CentreSample {
                depth: z,
                position: centre,
                ..
            } = flight.at(sample as f64 - hilbert as f64);
            for receive in &receive {
                let position =
                    centre - f64::from(receive.ahead()) + f64::from(receive.samples(z as f32));
                if position.is_nan() {
                    return Ok(p.record_samples);
                }
                if z > 0.0 && position < FAR && position > last {
                    last = position;
                }
            }
        }
        let decimator = self.interpolator.decimator();
        // Of the decimated record, in which sample 0 has the index `origin`.
        let end = self
            .around(last, last)
            .end
            .saturating_sub(decimator.origin());
        let whole = (end << decimator.halvings()).saturating_add(reach(decimator.halvings()));
        Ok(if end == 0 {
            0
        } else {
            whole.min(p.record_samples)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Complex;
    use crate::delay::{DelayParameters, Record, Stage};
    use crate::geometry::{Array, Element, Ray, Transmit, TransmitLaw};
    use std::vec::Vec;
    use std::{format, vec};

    const ELEMENTS: usize = 6;

    /// A block of a line whose record is `late` from sample `end` on.
    fn block(
        delay: &Delay,
        line: &ScanLine,
        block: &Range<usize>,
        (end, late): (usize, f32),
    ) -> Vec<Complex<f32>> {
        let samples = delay.parameters().record_samples;
        let value = |k: usize| match k % samples < end {
            true => ((k * 7919 + k / 3) % 2003) as f32 - 1001.0,
            false => late,
        };
        let rf: Vec<f32> = (0..ELEMENTS * samples).map(value).collect();
        let record = Record::new(&rf, ELEMENTS).unwrap();
        let mut scratch = vec![0.0; delay.need(1, block.len()).real];
        let mut out = vec![Complex::ZERO; block.len() * ELEMENTS];
        delay
            .block(0.0f32, line, &record, block.start, &mut scratch, &mut out)
            .unwrap();
        out
    }

    /// Later samples change no bit, and those a few samples earlier do.
    #[test]
    fn a_block_depends_on_the_record_up_to_its_end() {
        let convex = core::array::from_fn(|k| Element::convex(ELEMENTS, 0.5e-3, 20e-3, k));
        let convex: [Element; ELEMENTS] = convex;
        let delays = [0.0, 1e-7, f64::NAN, 2e-7, 1e-7, 0.0];
        let arrays = [Array::linear(ELEMENTS, 0.5e-3), Array::at(&convex, 0.5e-3)];
        let laws = [
            TransmitLaw::Focused,
            TransmitLaw::Plane { angle: -0.3 },
            TransmitLaw::Element { x: 1e-3, z: 0.0 },
            TransmitLaw::VirtualSource { x: 1e-3, z: -5e-3 },
            TransmitLaw::VirtualSource { x: 0.0, z: 6e-3 },
            TransmitLaw::Delays(&delays),
        ];
        for (halvings, ratio) in [1.0, 3.0, 6.0, 12.0].into_iter().enumerate() {
            let parameters = DelayParameters {
                sampling_rate: ratio * 20e6,
                output_start: 4e-6,
                output_samples: 160,
                elements: ELEMENTS,
                record_samples: (ratio * 300.0) as usize,
                hilbert_taps: 5,
                ..DelayParameters::EXAMPLE
            };
            let delay = Delay::new(parameters).unwrap();
            assert_eq!(delay.interpolator.halvings(), halvings);
            for (case, (array, law)) in arrays
                .iter()
                .flat_map(|a| laws.map(|law| (a, law)))
                .enumerate()
            {
                // The element on the far side ends last.
                let side = (case % 3) as f64 - 1.0;
                let line = ScanLine {
                    active: crate::geometry::Active::new(1, 4),
                    ..ScanLine::new(
                        Transmit::new(law, 1.3e-7),
                        Ray::new(side * 0.4e-3, 0.0, side * 0.2),
                        *array,
                    )
                };
                for own in [0..1, 0..32, 30..67, 20..90] {
                    let end = delay.record_end(&line, own.clone()).unwrap();
                    assert!(end < parameters.record_samples, "{end}");
                    let of = |end, late| block(&delay, &line, &own, (end, late));
                    let what = format!("{law:?} {own:?} {ratio} {end}");
                    assert_eq!(of(end, 0.0), of(end, 1e6), "{what}");
                    let earlier = end - (8 << halvings);
                    assert_ne!(of(earlier, 0.0), of(earlier, 1e6), "{what}");
                }
            }
        }
    }

    #[test]
    fn nothing_of_a_record_is_read_for_no_samples_or_elements() {
        let parameters = DelayParameters {
            sampling_rate: 20e6,
            output_start: 4e-6,
            output_samples: 160,
            elements: ELEMENTS,
            record_samples: 100,
            hilbert_taps: 5,
            ..DelayParameters::EXAMPLE
        };
        let delay = Delay::new(parameters).unwrap();
        let line = |count, t0| ScanLine {
            active: crate::geometry::Active::new(0, count),
            ..ScanLine::new(
                Transmit::new(TransmitLaw::Focused, t0),
                Ray::down(0.0),
                Array::linear(ELEMENTS, 0.5e-3),
            )
        };
        assert_eq!(delay.record_end(&line(0, 0.0), 0..9), Ok(0));
        assert_eq!(delay.record_end(&line(6, 0.0), 9..9), Ok(0));
        // At no speed of a medium there is no number of positions.
        let sound_speed = 1e300;
        let parameters = DelayParameters {
            sound_speed,
            ..*delay.parameters()
        };
        let fast = Delay::new(parameters).unwrap();
        let record = parameters.record_samples;
        assert_eq!(fast.record_end(&line(6, 0.0), 0..9), Ok(record));
        // Before the record, and behind it.
        assert_eq!(delay.record_end(&line(6, 1.0), 0..9), Ok(0));
        assert_eq!(delay.record_end(&line(6, -0.1), 0..9), Ok(100));
        assert!(matches!(
            delay.record_end(&line(6, 0.0), 0..161),
            Err(Error::Capacity {
                actual: 161,
                capacity: 160,
                ..
            })
        ));
    }
}
