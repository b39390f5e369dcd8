//! Depths and apertures of a scan.

use std::vec;
use std::vec::Vec;

use bonebeam::geometry::ApertureTable;
use bonebeam::prelude::stages::*;

use super::delay::Place;
use crate::draw::Draw;
use crate::kernel::Kernel;

/// The apertures of a scan's first, middle and last line, and of one more.
#[derive(Clone, Debug)]
pub struct Apertures {
    /// The array.
    pub place: Place,
    /// The lines: even, at positions, or rays.
    pub kind: usize,
    /// The rays.
    pub rays: Vec<Ray>,
    /// All other parameters.
    pub parameters: ScanParameters<'static>,
}

impl Apertures {
    fn with<T>(&self, work: impl FnOnce(&Scan<'_>) -> Result<T, Error>) -> Result<T, Error> {
        let at: Vec<f64> = self.rays.iter().map(Ray::x).collect();
        let lines = match self.kind {
            0 => self.parameters.lines,
            1 => Lines::At(&at),
            _ => Lines::Rays(&self.rays),
        };
        let parameters = ScanParameters {
            array: self.place.array(),
            lines,
            ..self.parameters
        };
        work(&match self.kind % 2 {
            0 => Scan::new(parameters)?,
            _ => Scan::of_iq(parameters)?,
        })
    }
}

impl Kernel for Apertures {
    type Number = f32;

    fn draw(draw: &mut impl Draw) -> Result<Self, Error> {
        let wild = draw.once_in(4);
        let (elements, lines) = (draw.size(8, 200), draw.size(4, 40));
        let pitch = draw.number(wild, [1e-5, 2e-3]);
        let place = Place::draw(draw, wild, (elements, pitch));
        let mut at = |usual| draw.number(wild, usual);
        let (step, angle) = (at([1e-5, 2e-3]), at([-1.0, 1.0]));
        let parameters = ScanParameters {
            array: bonebeam::geometry::Array::linear(1, 1.0),
            lines: Lines::Even(Axis::centred(lines, step)),
            sound_speed: at([300.0, 4000.0]),
            centre_frequency: at([1e6, 10e6]),
            sampling_rate: at([10e6, 100e6]),
            record_samples: 0,
            output_rate: at([10e6, 60e6]),
            start: Depth::Metres(at([0.0, 1e-2])),
            end: Depth::Metres(at([1e-2, 2e-2])),
            f_number: at([0.5, 4.0]),
            min_elements: draw.byte().into(),
        };
        let record_samples = usize::from(draw.byte()) << draw.below(9);
        let mut parameters = ScanParameters {
            record_samples,
            ..parameters
        };
        if draw.flag() {
            let seconds = |depth| match depth {
                Depth::Metres(depth) => Depth::Seconds(depth / 1000.0),
                seconds => seconds,
            };
            (parameters.start, parameters.end) =
                (seconds(parameters.start), seconds(parameters.end));
        }
        let rays = (0..lines)
            .map(|line| Ray::new(line as f64 * step, 0.0, angle))
            .collect();
        let scan = Apertures {
            place,
            kind: draw.below(6),
            rays,
            parameters,
        };
        scan.with(|_| Ok(()))?;
        Ok(scan)
    }

    fn need(&self, _: usize, _: usize) -> [Need; 2] {
        [Need::default(); 2]
    }

    fn numbers(&self) -> usize {
        16
    }

    fn run<V: Vector>(
        &self,
        _: V,
        _: usize,
        _: (Scratch<'_>, Scratch<'_, V>),
        out: &mut [f32],
    ) -> Result<(), Error> {
        self.with(|scan| {
            let (lines, samples, elements) = (scan.lines(), scan.samples(), scan.elements());
            let mut widths = vec![f32::NAN; samples.min(100_000)];
            let table = ApertureTable::new(scan, &mut widths);
            let places = [0, samples / 3, samples / 2, samples.saturating_sub(1)];
            for (line, out) in [0, lines / 2, lines - 1, lines]
                .into_iter()
                .zip(out.as_chunks_mut::<4>().0)
            {
                for (sample, out) in places.into_iter().zip(&mut *out) {
                    assert!(scan.time(sample).is_finite() && scan.depth(sample).is_finite());
                    let active = scan.active(line, sample);
                    assert!(active.first + active.count <= elements, "{active:?}");
                    if let Ok(table) = &table {
                        let centre = ApertureTable::centre(scan, line);
                        assert_eq!(table.active(centre, sample), active);
                    }
                    *out = active.count as f32;
                }
                assert!(out.is_sorted(), "an aperture that shrinks");
            }
            assert!(
                places.map(|sample| scan.depth(sample)).is_sorted(),
                "depths in order"
            );
            Ok(())
        })
    }
}
