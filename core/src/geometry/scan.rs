//! The geometry of a scan, stated once.

use super::{Active, Aperture, ApertureParameters, Array, Axis, Depth, Lines, Ray};
use crate::Error;
use crate::error::{at_least_one, finite, positive};

/// Array, lines, sampling and aperture of a scan. SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ScanParameters<'a> {
    /// The transducer.
    pub array: Array<'a>,
    /// The scan lines.
    pub lines: Lines<'a>,
    /// Speed of sound c, m/s.
    pub sound_speed: f64,
    /// Centre frequency of the pulse f₀, Hz.
    pub centre_frequency: f64,
    /// Sampling rate of the records fs, Hz.
    pub sampling_rate: f64,
    /// Samples of each element's record.
    pub record_samples: usize,
    /// Output rate along the lines fout, Hz: above 2·f₀, except for [`Scan::of_iq`].
    pub output_rate: f64,
    /// Beginning of the lines.
    pub start: Depth,
    /// End of the lines; the last sample is here or less than one sample before.
    pub end: Depth,
    /// Receive f-number: depth over aperture.
    pub f_number: f64,
    /// Minimum number of active elements at any depth; fewer at the ends of the array.
    pub min_elements: usize,
}

impl ScanParameters<'_> {
    /// A small scan for examples.
    ///
    /// It has 64 lines of 16 elements from 4 mm to 12 mm, and RF at 20 MHz.
    pub const EXAMPLE: ScanParameters<'static> = ScanParameters {
        array: Array::linear(16, 0.3e-3),
        lines: Lines::Even(Axis::centred(64, 0.1e-3)),
        sound_speed: 1540.0,
        centre_frequency: 5e6,
        sampling_rate: 20e6,
        record_samples: 512,
        output_rate: 20e6,
        start: Depth::Metres(4e-3),
        end: Depth::Metres(12e-3),
        f_number: 1.5,
        min_elements: 8,
    };
}

/// A valid scan, with derived sizes and positions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Scan<'a> {
    parameters: ScanParameters<'a>,
    aperture: Aperture,
    start: f64,
    samples: usize,
}

impl<'a> Scan<'a> {
    /// Validates the parameters.
    ///
    /// A `const` scan can give the sizes of statics:
    ///
    /// ```
    /// use bonebeam::valid;
    /// use bonebeam::geometry::{Array, Axis, Depth, Lines, Scan, ScanParameters};
    ///
    /// const SCAN: Scan = valid!(Scan::new(ScanParameters {
    ///     array: Array::linear(64, 0.3e-3),
    ///     lines: Lines::Even(Axis::centred(64, 0.3e-3)),
    ///     start: Depth::Metres(5e-3),
    ///     end: Depth::Metres(35e-3),
    ///     ..ScanParameters::EXAMPLE
    /// }));
    /// static LINE: [f32; SCAN.samples()] = [0.0; SCAN.samples()];
    /// assert_eq!(LINE.len(), 780); // 60 mm there and back at 1540 m/s and 20 MHz
    /// assert_eq!(SCAN.active(0, 0).count, 6); // 11 elements at 5 mm, cut at the array's end
    /// ```
    ///
    /// # Errors
    /// [`Error::Parameter`], naming the parameter that is out of range.
    pub const fn new(parameters: ScanParameters<'a>) -> Result<Self, Error> {
        match more_than_twice(parameters.output_rate, parameters.centre_frequency) {
            Ok(()) => Self::of_iq(parameters),
            // Out-of-range numbers are reported first.
            Err(error) => match Self::of_iq(parameters) {
                Ok(_) => Err(error),
                Err(first) => Err(first),
            },
        }
    }

    /// Validates the parameters of a scan whose records are I/Q.
    ///
    /// The output rate may have any value, since I/Q holds only the pulse's band.
    ///
    /// # Errors
    /// As [`Scan::new`].
    pub const fn of_iq(parameters: ScanParameters<'a>) -> Result<Self, Error> {
        let p = &parameters;
        let start = p.start.seconds(p.sound_speed);
        let end = p.end.seconds(p.sound_speed);
        let checks = [
            p.array.check(),
            p.lines.check(),
            positive("sound_speed", p.sound_speed),
            positive("centre_frequency", p.centre_frequency),
            positive("sampling_rate", p.sampling_rate),
            at_least_one("record_samples", p.record_samples),
            positive("output_rate", p.output_rate),
            finite("start", start),
            finite("end", end),
            deeper(start, end),
            // Each is finite; their products may not be.
            finite("two-way path to the start", p.sound_speed * start),
            finite("two-way path to the end", p.sound_speed * end),
        ];
        let mut k = 0;
        while k < checks.len() {
            if let Err(error) = checks[k] {
                return Err(error);
            }
            k += 1;
        }
        let aperture = match Aperture::new(ApertureParameters {
            elements: p.array.elements(),
            pitch: p.array.pitch(),
            f_number: p.f_number,
            min_elements: p.min_elements,
        }) {
            Ok(aperture) => aperture,
            Err(error) => return Err(error),
        };
        // The last sample may be at the end; rounding must not lose it. The cast rounds down.
        let intervals = (end - start) * p.output_rate + 1e-6;
        Ok(Scan {
            parameters,
            aperture,
            start,
            samples: (intervals as usize).saturating_add(1),
        })
    }

    /// The parameters.
    pub const fn parameters(&self) -> &ScanParameters<'a> {
        &self.parameters
    }

    /// Number of elements, M.
    pub const fn elements(&self) -> usize {
        self.parameters.array.elements()
    }

    /// Number of scan lines.
    pub const fn lines(&self) -> usize {
        self.parameters.lines.count()
    }

    /// Output samples of a line: ⌊(end − start)·fout + 10⁻⁶⌋ + 1.
    pub const fn samples(&self) -> usize {
        self.samples
    }

    /// Two-way time of output sample 0, s.
    pub const fn start(&self) -> f64 {
        self.start
    }

    /// Two-way time of an output sample, s.
    pub const fn time(&self, sample: usize) -> f64 {
        self.start + sample as f64 / self.parameters.output_rate
    }

    /// Depth of an output sample, m: the distance along a ray.
    pub const fn depth(&self, sample: usize) -> f64 {
        self.parameters.sound_speed * self.time(sample) / 2.0
    }

    /// Depths of the output samples.
    pub const fn depths(&self) -> Axis {
        let p = &self.parameters;
        Axis::new(
            p.sound_speed * self.start / 2.0,
            p.sound_speed / p.output_rate / 2.0,
            self.samples,
        )
    }

    /// The receive aperture.
    pub const fn aperture(&self) -> &Aperture {
        &self.aperture
    }

    /// The active elements of a line at an output sample.
    ///
    /// No element is active for a line outside the scan.
    pub fn active(&self, line: usize, sample: usize) -> Active {
        self.active_at(self.aperture_centre(line), sample)
    }

    /// Intersection of a line with the array: [`Array::aperture_centre`].
    pub fn aperture_centre(&self, line: usize) -> f64 {
        self.parameters.array.aperture_centre(&self.ray(line))
    }

    /// The active elements at an output sample for this aperture centre.
    ///
    /// As [`Aperture::active`] at the sample's distance along the line.
    pub fn active_at(&self, centre: f64, sample: usize) -> Active {
        self.aperture.active(centre, self.depth(sample))
    }

    /// A line as a ray; NaN for a line outside the scan.
    pub const fn ray(&self, line: usize) -> Ray {
        self.parameters.lines.ray(line)
    }

    /// The elements of a line that are active at any sample.
    ///
    /// These are the elements of the last sample, since a deeper set contains the shallower ones.
    pub fn widest(&self, line: usize) -> Active {
        self.active(line, self.samples.saturating_sub(1))
    }
}

const fn more_than_twice(output_rate: f64, centre_frequency: f64) -> Result<(), Error> {
    if output_rate / centre_frequency > 2.0 {
        return Ok(());
    }
    let expected = "more than twice the centre frequency";
    Err(Error::parameter("output_rate", output_rate, expected))
}

const fn deeper(start: f64, end: f64) -> Result<(), Error> {
    if end > start {
        return Ok(());
    }
    Err(Error::parameter("end", end, "a position below the start"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: ScanParameters = ScanParameters {
        array: Array::Linear {
            elements: 16,
            pitch: 0.3e-3,
        },
        lines: Lines::Even(Axis::centred(31, 0.15e-3)),
        sampling_rate: 40e6,
        record_samples: 1000,
        start: Depth::Metres(1.54e-3),
        end: Depth::Metres(15.4e-3),
        ..ScanParameters::EXAMPLE
    };

    #[test]
    fn samples_reach_from_the_start_to_the_end() {
        let scan = Scan::new(GOOD).unwrap();
        // 18 µs at 20 MHz; the last sample is at the end.
        assert_eq!(scan.samples(), 361);
        assert!((scan.depth(360) - 15.4e-3).abs() < 1e-15);
        assert_eq!(scan.depths().first, scan.depth(0));
        assert!((scan.depths().last() - scan.depth(360)).abs() < 1e-15);
        let by_time = Scan::new(ScanParameters {
            start: Depth::Seconds(2e-6),
            end: Depth::Seconds(20e-6),
            ..GOOD
        });
        assert_eq!(by_time.unwrap().samples(), 361);
    }

    /// Found by fuzzing: both numbers were finite, the depth was not.
    #[test]
    fn depths_that_are_not_finite_are_refused() {
        let far = |start, end| {
            Scan::of_iq(ScanParameters {
                sound_speed: 1e200,
                start: Depth::Seconds(start),
                end: Depth::Seconds(end),
                ..GOOD
            })
        };
        for (start, end) in [(0.0, 1e150), (-1e150, 0.0)] {
            let refused = far(start, end);
            assert!(matches!(refused, Err(Error::Parameter { .. })));
        }
        assert!(far(0.0, 1e100).unwrap().depth(0).is_finite());
    }

    #[test]
    fn the_active_set_is_the_apertures() {
        let scan = Scan::new(GOOD).unwrap();
        for line in 0..scan.lines() {
            for sample in [0, 100, 360] {
                let expected = scan
                    .aperture()
                    .active(line as f64 / 2.0, scan.depth(sample));
                assert_eq!(scan.active(line, sample), expected);
            }
            assert_eq!(scan.widest(line), scan.active(line, 360));
        }
        assert_eq!(scan.active(31, 0).count, 0);
    }

    #[test]
    fn given_positions_are_those_of_the_formula() {
        let even = Scan::new(GOOD).unwrap();
        let x: [f64; 16] = core::array::from_fn(|m| GOOD.array.x(m));
        let lines: [f64; 31] = core::array::from_fn(|line| GOOD.lines.x(line));
        let given = Scan::new(ScanParameters {
            array: Array::LinearAt(&x),
            lines: Lines::At(&lines),
            ..GOOD
        })
        .unwrap();
        for line in 0..31 {
            assert_eq!(given.active(line, 200), even.active(line, 200));
        }
        // Symmetric, to the bit.
        assert!((0..16).all(|m| x[m] == -x[15 - m]));
    }

    #[test]
    fn bad_parameters_are_named() {
        let name = |change: fn(&mut ScanParameters)| {
            let mut p = GOOD;
            change(&mut p);
            match Scan::new(p) {
                Err(Error::Parameter { name, .. }) => name,
                other => panic!("{other:?}"),
            }
        };
        assert_eq!(name(|p| p.sound_speed = 0.0), "sound_speed");
        assert_eq!(name(|p| p.centre_frequency = f64::NAN), "centre_frequency");
        assert_eq!(name(|p| p.sampling_rate = -1.0), "sampling_rate");
        assert_eq!(name(|p| p.record_samples = 0), "record_samples");
        assert_eq!(name(|p| p.output_rate = f64::INFINITY), "output_rate");
        assert_eq!(name(|p| p.output_rate = 10e6), "output_rate");
        assert_eq!(name(|p| p.start = Depth::Seconds(f64::NAN)), "start");
        assert_eq!(name(|p| p.end = Depth::Metres(f64::INFINITY)), "end");
        assert_eq!(name(|p| p.end = p.start), "end");
        assert_eq!(name(|p| p.f_number = 0.0), "f_number");
        assert_eq!(name(|p| p.min_elements = 0), "min_elements");
        assert_eq!(name(|p| p.array = Array::LinearAt(&[])), "elements");
        assert_eq!(name(|p| p.array = Array::LinearAt(&[1.0])), "pitch");
        let infinite = |p: &mut ScanParameters| p.array = Array::LinearAt(&[0.0, f64::INFINITY]);
        assert_eq!(name(infinite), "element_x");
        assert_eq!(name(|p| p.lines = Lines::At(&[])), "lines");
        assert_eq!(name(|p| p.lines = Lines::At(&[f64::NAN])), "line position");
        let step = |p: &mut ScanParameters| p.lines = Lines::Even(Axis::centred(4, 0.0));
        assert_eq!(name(step), "line spacing");
    }
}
