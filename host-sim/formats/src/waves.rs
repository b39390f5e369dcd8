//! Converts waves of other formats to the delay laws of channel data.

use ndarray::Array2;

use bonebeam_files::Transmits;

/// Tolerance of an element's delay, in periods of the centre frequency.
const TOLERANCE: f64 = 0.1;

/// A wave of an array.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wave {
    /// A plane wave, rad.
    Plane(f64),
    /// From a source behind the array, or towards one in front of it, at (x, z) in m.
    ///
    /// The second position is the beginning of its beam.
    VirtualSource([f64; 2], [f64; 2]),
}

/// Firing times of elements, and the beginning of the record, in the file's time.
pub struct Fired<'a> {
    /// The positions (x, z) of the elements, m.
    pub elements: &'a [[f64; 2]],
    /// Firing time of each, s, [transmit, element]; NaN if it does not fire.
    pub delay: Array2<f64>,
    /// The time of sample 0 of each transmit, s.
    pub start: Vec<f64>,
    /// The speed of sound, m/s.
    pub c: f64,
    /// The centre frequency, Hz.
    pub f0: f64,
}

/// A delay law, and the time of sample 0 relative to its origin, s.
pub type Law = (Transmits, Vec<f64>);

impl Fired<'_> {
    /// The law of waves of one kind if it matches the delays, else the delays.
    pub fn law(&self, waves: &[Wave]) -> Law {
        self.single()
            .or_else(|| self.beams(waves))
            .or_else(|| self.plane(waves))
            .or_else(|| self.sources(waves))
            .unwrap_or_else(|| {
                let delay = self.delay.clone();
                (Transmits::Delays { delay }, self.start.clone())
            })
    }

    /// The law of transmits of one element each.
    fn single(&self) -> Option<Law> {
        let mut index = Vec::new();
        let mut t0 = Vec::new();
        for (delay, start) in self.delay.outer_iter().zip(&self.start) {
            let mut firing = delay
                .iter()
                .enumerate()
                .filter(|(_, delay)| !delay.is_nan());
            let (element, delay) = firing.next().filter(|_| delay.len() > 1)?;
            if firing.next().is_some() {
                return None;
            }
            index.push(element);
            t0.push(start - delay);
        }
        Some((Transmits::Element { index }, t0))
    }

    /// The law of beams straight down, each towards a focus below its beginning.
    fn beams(&self, waves: &[Wave]) -> Option<Law> {
        let mut x = Vec::new();
        let mut focus = Vec::new();
        for wave in waves {
            match wave {
                Wave::VirtualSource([sx, sz], [ox, oz]) if *sz > 0.0 && sx == ox && *oz == 0.0 => {
                    x.push(*sx);
                    focus.push(*sz);
                }
                _ => return None,
            }
        }
        let apart = |x: &[f64]| x.windows(2).all(|pair| pair[0] != pair[1]);
        if x.len() < 2 || !apart(&x) {
            return None;
        }
        let t0 = self.origins(|transmit, [ex, ez]| {
            let depth = focus[transmit];
            (depth - (ex - x[transmit]).hypot(ez - depth)) / self.c
        })?;
        let f_number = None;
        Some((Transmits::Focused { x, focus, f_number }, t0))
    }

    fn plane(&self, waves: &[Wave]) -> Option<Law> {
        let angle = |wave: &Wave| match wave {
            Wave::Plane(angle) => Some(*angle),
            Wave::VirtualSource(..) => None,
        };
        let angle: Vec<f64> = waves.iter().map(angle).collect::<Option<_>>()?;
        let t0 = self.origins(|transmit, [x, z]| {
            let (sine, cosine) = angle[transmit].sin_cos();
            (x * sine + z * cosine) / self.c
        })?;
        Some((Transmits::Plane { angle }, t0))
    }

    fn sources(&self, waves: &[Wave]) -> Option<Law> {
        let source = |wave: &Wave| match wave {
            Wave::VirtualSource(source, _) => Some(*source),
            Wave::Plane(_) => None,
        };
        let sources: Vec<[f64; 2]> = waves.iter().map(source).collect::<Option<_>>()?;
        let t0 = self.origins(|transmit, [x, z]| {
            let [sx, sz] = sources[transmit];
            let (from, to) = (sx.hypot(sz), (x - sx).hypot(z - sz));
            // A wave that converges leaves the far elements first.
            if sz > 0.0 {
                (from - to) / self.c
            } else {
                (to - from) / self.c
            }
        })?;
        let (x, z) = sources.iter().map(|&[x, z]| (x, z)).unzip();
        Some((Transmits::VirtualSource { x, z }, t0))
    }

    /// Time of sample 0 from the moment when each wave passes the origin.
    ///
    /// `passes` is the moment when it passes an element. `None` if the elements fire otherwise.
    fn origins(&self, passes: impl Fn(usize, [f64; 2]) -> f64) -> Option<Vec<f64>> {
        let tolerance = TOLERANCE / self.f0;
        let mut t0 = Vec::new();
        for (transmit, delay) in self.delay.outer_iter().enumerate() {
            let firing = delay.iter().zip(self.elements).filter(|(d, _)| !d.is_nan());
            let origins: Vec<f64> = firing.map(|(d, &e)| d - passes(transmit, e)).collect();
            let mean = origins.iter().sum::<f64>() / origins.len() as f64;
            if origins.is_empty() || origins.iter().any(|o| (o - mean).abs() > tolerance) {
                return None;
            }
            t0.push(self.start[transmit] - mean);
        }
        Some(t0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const C: f64 = 1540.0;

    fn fired(elements: &[[f64; 2]], passes: impl Fn([f64; 2]) -> f64) -> Fired<'_> {
        let delays: Vec<f64> = elements.iter().map(|&e| passes(e)).collect();
        let first = delays.iter().copied().fold(f64::INFINITY, f64::min);
        let delays = delays.iter().map(|d| d - first).collect();
        Fired {
            elements,
            delay: Array2::from_shape_vec((1, elements.len()), delays).unwrap(),
            start: vec![5e-6 - first],
            c: C,
            f0: 5e6,
        }
    }

    /// Whatever the moment from which a file counts, the origin is passed at 0.
    #[test]
    fn laws_are_found_with_their_origins() {
        let elements: Vec<[f64; 2]> = (0..16).map(|m| [(m as f64 - 3.0) * 3e-4, 0.0]).collect();
        let plane = fired(&elements, |[x, _]| x * 0.2f64.sin() / C);
        let (law, t0) = plane.law(&[Wave::Plane(0.2)]);
        assert_eq!(law, Transmits::Plane { angle: vec![0.2] });
        assert!((t0[0] - 5e-6).abs() < 1e-15);
        for (source, sign) in [([2e-3, -8e-3], 1.0), ([2e-3, 20e-3], -1.0)] {
            let [sx, sz]: [f64; 2] = source;
            let wave = fired(&elements, |[x, z]| {
                sign * ((x - sx).hypot(z - sz) - sx.hypot(sz)) / C
            });
            let (law, t0) = wave.law(&[Wave::VirtualSource(source, [0.0, 0.0])]);
            let (x, z) = (vec![sx], vec![sz]);
            assert_eq!(law, Transmits::VirtualSource { x, z });
            assert!((t0[0] - 5e-6).abs() < 1e-15);
        }
    }

    #[test]
    fn delays_of_no_law_stay_delays() {
        let elements: Vec<[f64; 2]> = (0..16).map(|m| [m as f64 * 3e-4, 0.0]).collect();
        let wave = fired(&elements, |[x, _]| (x * 1e4).sin() * 1e-6);
        let (law, t0) = wave.law(&[Wave::Plane(0.0)]);
        assert!(matches!(law, Transmits::Delays { .. }));
        assert_eq!(t0, wave.start);
    }
}
