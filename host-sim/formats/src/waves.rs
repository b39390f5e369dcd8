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

/// Marks the elements of weight 0 as not firing, by NaN.
///
/// # Errors
/// The place of a negative weight: its element sends the inverted pulse.
pub fn silence<'a>(
    delays: impl Iterator<Item = &'a mut f64>,
    weights: impl Iterator<Item = f64>,
) -> Result<(), usize> {
    for (place, (delay, weight)) in delays.zip(weights).enumerate() {
        if weight < 0.0 {
            return Err(place);
        }
        if weight == 0.0 {
            *delay = f64::NAN;
        }
    }
    Ok(())
}

/// The message about a negative weight.
pub fn inverted(name: &str, transmit: usize, element: usize) -> String {
    format!(
        "`{name}` is negative at transmit {transmit}, element {element}: inverted pulses, as of Hadamard codes, are not \
         decoded; expected weights of at least 0, of records decoded by the inverse of `{name}`"
    )
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

/// Moment at which an element fires, from that at which the wave passes the origin of its law, s.
///
/// NaN if it does not fire.
fn passes(law: &Transmits, transmit: usize, [x, z]: [f64; 2], c: f64) -> f64 {
    let from_source = |sx: f64, sz: f64| {
        let later = (x - sx).hypot(z - sz) - sx.hypot(sz);
        // A wave that converges leaves the far elements first.
        if sz > 0.0 { -later / c } else { later / c }
    };
    match law {
        Transmits::Focused {
            x: beams,
            focus,
            f_number,
        } => {
            let (from, depth) = (x - beams[transmit], focus[transmit]);
            let is_active = f_number.is_none_or(|number| from.abs() <= depth / number / 2.0);
            if is_active {
                (depth - from.hypot(z - depth)) / c
            } else {
                f64::NAN
            }
        }
        Transmits::Plane { angle } => {
            let (sine, cosine) = angle[transmit].sin_cos();
            (x * sine + z * cosine) / c
        }
        Transmits::VirtualSource { x, z } => from_source(x[transmit], z[transmit]),
        Transmits::Element { .. } => 0.0,
        Transmits::Delays { .. } => f64::NAN,
    }
}

/// Moment at which the first element fires, s.
///
/// It counts from the moment at which the wave passes the origin of its law.
pub fn first_fires(law: &Transmits, transmit: usize, elements: &[[f64; 2]], c: f64) -> f64 {
    // `f64::min` leaves NaN out.
    let first = match law {
        Transmits::Delays { delay } => delay
            .row(transmit)
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min),
        _ => {
            let fires = elements
                .iter()
                .map(|&element| passes(law, transmit, element, c));
            fires.fold(f64::INFINITY, f64::min)
        }
    };
    if first.is_finite() { first } else { 0.0 }
}

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
        let f_number = None;
        self.matched(Transmits::Focused { x, focus, f_number })
    }

    fn plane(&self, waves: &[Wave]) -> Option<Law> {
        let angle = |wave: &Wave| match wave {
            Wave::Plane(angle) => Some(*angle),
            Wave::VirtualSource(..) => None,
        };
        let angle: Vec<f64> = waves.iter().map(angle).collect::<Option<_>>()?;
        self.matched(Transmits::Plane { angle })
    }

    fn sources(&self, waves: &[Wave]) -> Option<Law> {
        let source = |wave: &Wave| match wave {
            Wave::VirtualSource(source, _) => Some(*source),
            Wave::Plane(_) => None,
        };
        let sources: Vec<[f64; 2]> = waves.iter().map(source).collect::<Option<_>>()?;
        let (x, z) = sources.iter().map(|&[x, z]| (x, z)).unzip();
        self.matched(Transmits::VirtualSource { x, z })
    }

    /// The law, with the time of sample 0 from the moment when each wave passes its origin.
    ///
    /// `None` if the elements fire otherwise.
    fn matched(&self, law: Transmits) -> Option<Law> {
        let tolerance = TOLERANCE / self.f0;
        let mut t0 = Vec::new();
        for (transmit, delay) in self.delay.outer_iter().enumerate() {
            let firing = delay.iter().zip(self.elements).filter(|(d, _)| !d.is_nan());
            let origins = firing.map(|(d, &e)| d - passes(&law, transmit, e, self.c));
            let origins: Vec<f64> = origins.collect();
            let mean = origins.iter().sum::<f64>() / origins.len() as f64;
            if origins.is_empty() || origins.iter().any(|o| (o - mean).abs() > tolerance) {
                return None;
            }
            t0.push(self.start[transmit] - mean);
        }
        Some((law, t0))
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
