//! The geometry of a recording: elements, waves and lines, as its keys have them or as an alternative has them.

use bonebeam_files::{ChannelData, Transmits};

/// Receive f-number of the aligned elements.
const F_NUMBER: f64 = 1.2;
/// Least number of aligned elements.
const LEAST: usize = 8;
/// Largest number of lines, and of transmits that are read.
pub(crate) const LINES: usize = 24;
/// Angle from the first line of a sector to the last, rad.
const SECTOR: f64 = 1.2;
/// Pitch in wavelengths below which lines of virtual sources fan out.
const PHASED: f64 = 0.7;

/// One transmit wave, by the values that [`Transmits`] has of it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Wave {
    /// On its own line: the distance along it over c.
    Own,
    Plane(f64),
    Source([f64; 2]),
    Element(usize),
    Delays(Vec<f64>),
}

/// A straight line from the array.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub from: [f64; 2],
    pub angle: f64,
}

impl Line {
    pub fn at(&self, r: f64) -> [f64; 2] {
        let (sin, cos) = self.angle.sin_cos();
        [self.from[0] + r * sin, self.from[1] + r * cos]
    }

    /// Distance of a point from the line.
    fn beside(&self, [x, z]: [f64; 2]) -> f64 {
        let (sin, cos) = self.angle.sin_cos();
        ((x - self.from[0]) * cos - (z - self.from[1]) * sin).abs()
    }
}

/// The line across the array from an element with neighbours on both sides.
fn normal(elements: &[[f64; 2]], m: usize) -> Line {
    let [a, b] = [elements[m - 1], elements[m + 1]];
    Line {
        from: elements[m],
        angle: (a[1] - b[1]).atan2(b[0] - a[0]),
    }
}

/// Geometry of a recording as its keys have it, or as an alternative has it.
#[derive(Clone, Debug)]
pub(crate) struct View {
    pub elements: Vec<[f64; 2]>,
    /// Row of the records of each element.
    pub order: Vec<usize>,
    pub waves: Vec<Wave>,
    /// Factor of each transmit: 0 leaves it out.
    pub signs: Vec<f32>,
    pub lines: Vec<Line>,
    /// Every how many of them are read.
    pub every: usize,
    /// Whether each transmit has its own line.
    pub own: bool,
    pub c: f64,
    /// Later than the record's times by this, s: a lens, there and back, or an alternative of time zero.
    pub late: f64,
    /// The carrier's sign in I/Q.
    pub conjugate: bool,
    pub f_number: f64,
    /// Delays of tissue before the elements, s.
    pub screen: Vec<f64>,
    /// Elements that are left out.
    pub without: Vec<usize>,
}

/// The transmits that are read: all, or at most so many evenly from the list.
pub(crate) fn chosen(count: usize, most: usize) -> Vec<usize> {
    let kept = count.min(most);
    let step = (count.max(1) - 1) as f64 / (kept.max(2) - 1) as f64;
    let mut chosen: Vec<usize> = (0..kept)
        .map(|k| (k as f64 * step).round() as usize)
        .collect();
    chosen.dedup();
    chosen
}

impl View {
    /// The geometry of some transmits of a recording.
    pub fn new(data: &ChannelData, transmits: &[usize]) -> Self {
        let count = data.element_x.len();
        let elements: Vec<[f64; 2]> = (0..count).map(|m| data.element(m)).collect();
        let (first, last) = (elements[0], elements[count - 1]);
        let middle = [(first[0] + last[0]) / 2.0, 0.0];
        let phased = data.is_straight() && data.pitch() < PHASED * data.c / data.f0;
        let own_sources = match &data.transmits {
            Transmits::VirtualSource { x, z } => {
                x.len() > 1 && z.iter().all(|&z| z > 0.0) && x.windows(2).all(|x| x[0] != x[1])
            }
            _ => false,
        };
        let waves: Vec<Wave> = transmits
            .iter()
            .map(|&t| match &data.transmits {
                Transmits::Focused { .. } => Wave::Own,
                Transmits::Plane { angle } => Wave::Plane(angle[t]),
                Transmits::Element { index } => Wave::Element(index[t]),
                Transmits::VirtualSource { x, z } => Wave::Source([x[t], z[t]]),
                Transmits::Delays { delay } => Wave::Delays(delay.row(t).to_vec()),
            })
            .collect();
        let down = |x: f64| Line {
            from: [x, 0.0],
            angle: 0.0,
        };
        let share = |k: usize| (k as f64 + 0.5) / LINES as f64;
        let lines = match &data.transmits {
            Transmits::Focused { x, .. } => transmits.iter().map(|&t| down(x[t])).collect(),
            Transmits::VirtualSource { x, z } if own_sources => transmits
                .iter()
                .map(|&t| match phased {
                    true => Line {
                        from: middle,
                        angle: (x[t] - middle[0]).atan2(z[t]),
                    },
                    false if data.is_straight() => down(x[t]),
                    false => (1..count - 1)
                        .map(|m| normal(&elements, m))
                        .min_by(|a, b| a.beside([x[t], z[t]]).total_cmp(&b.beside([x[t], z[t]])))
                        .unwrap_or(down(x[t])),
                })
                .collect(),
            Transmits::VirtualSource { .. } if phased => (0..LINES)
                .map(|k| Line {
                    from: middle,
                    angle: (share(k) - 0.5) * SECTOR,
                })
                .collect(),
            _ if data.is_straight() => (0..LINES)
                .map(|k| down(first[0] + share(k) * (last[0] - first[0])))
                .collect(),
            _ => (0..LINES)
                .map(|k| normal(&elements, 1 + (share(k) * (count - 3) as f64) as usize))
                .collect(),
        };
        View {
            order: (0..count).collect(),
            elements,
            signs: vec![1.0; waves.len()],
            waves,
            lines,
            every: 1,
            own: own_sources || matches!(data.transmits, Transmits::Focused { .. }),
            c: data.c,
            late: 2.0 * data.lens_delay,
            conjugate: false,
            f_number: F_NUMBER,
            screen: vec![0.0; count],
            without: Vec::new(),
        }
    }

    /// Time at which a wave reaches the distance `r` along a line, s.
    pub fn arrival(&self, wave: &Wave, line: &Line, r: f64) -> f64 {
        let p = line.at(r);
        let from = |s: [f64; 2]| (p[0] - s[0]).hypot(p[1] - s[1]);
        let path = match wave {
            Wave::Own => r,
            Wave::Plane(angle) => p[0] * angle.sin() + p[1] * angle.cos(),
            Wave::Source(s) if s[1] > 0.0 => {
                let range = s[0].hypot(s[1]);
                range + if p[1] < s[1] { -from(*s) } else { from(*s) }
            }
            Wave::Source(s) => from(*s) - s[0].hypot(s[1]),
            Wave::Element(m) => from(self.elements[*m]),
            Wave::Delays(delays) => {
                let each = delays.iter().zip(&self.elements);
                let each = each.filter(|(delay, _)| delay.is_finite());
                let each = each.map(|(delay, &at)| delay * self.c + from(at));
                each.fold(f64::INFINITY, f64::min)
            }
        };
        path / self.c + self.crossing(wave, p).map_or(0.0, |m| self.screen_at(m))
    }

    /// Where a wave to a point crosses the array, in elements.
    pub fn crossing(&self, wave: &Wave, [x, z]: [f64; 2]) -> Option<f64> {
        let (first, last) = (self.elements[0], self.elements[self.elements.len() - 1]);
        let at = |x: f64| {
            let share = (x - first[0]) / (last[0] - first[0]);
            ((self.elements.len() - 1) as f64 * share.clamp(0.0, 1.0)).into()
        };
        match wave {
            Wave::Element(m) => Some(*m as f64),
            Wave::Plane(angle) => at(x - z * angle.tan()),
            Wave::Source([sx, sz]) if *sz < 0.0 => at(sx + (x - sx) * sz / (sz - z)),
            _ => None,
        }
    }

    fn screen_at(&self, m: f64) -> f64 {
        let low = (m as usize).min(self.screen.len().saturating_sub(2));
        let part = m - low as f64;
        self.screen[low] * (1.0 - part) + self.screen[low + 1] * part
    }

    /// Receive delay of an element from the distance `c·time` along a line, s.
    pub fn receive(&self, line: &Line, time: f64, element: usize, c: f64) -> f64 {
        let ([x, z], [ex, ez]) = (line.at(c * time), self.elements[element]);
        (x - ex).hypot(z - ez) / c
    }

    /// From an element near a position to the next, m.
    pub fn pitch_at(&self, from: [f64; 2]) -> [f64; 2] {
        let away = |m: usize| {
            let [x, z] = self.elements[m];
            (x - from[0]).hypot(z - from[1])
        };
        let nearest = (1..self.elements.len() - 1).min_by(|&a, &b| away(a).total_cmp(&away(b)));
        let nearest = nearest.unwrap_or(1);
        let [a, b] = [self.elements[nearest - 1], self.elements[nearest + 1]];
        [(b[0] - a[0]) / 2.0, (b[1] - a[1]) / 2.0]
    }

    /// Elements within the aperture of a line at the distance `r`.
    pub fn active(&self, line: &Line, r: f64) -> std::ops::Range<usize> {
        let across = |m: usize| line.beside(self.elements[m]);
        let count = self.elements.len();
        let nearest = (0..count).min_by(|&a, &b| across(a).total_cmp(&across(b)));
        let nearest = nearest.unwrap_or(0);
        let half = 0.5 * r / self.f_number;
        let inside = |m: &usize| across(*m) <= half;
        let first = (0..count).find(inside).unwrap_or(nearest);
        let last = (0..count).rev().find(inside).unwrap_or(nearest);
        first.min(nearest.saturating_sub(LEAST / 2))
            ..(last + 1).max((nearest + LEAST / 2).min(count))
    }
}
