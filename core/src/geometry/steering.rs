//! Directions of sub-lines from a table.
//!
//! A sub-line is within the cell of its line, which extends half way to the neighbours. Its direction at a sample
//! is a phase that grows linearly from element to element: the least-squares line through the differences of the
//! echo paths. The table holds cosines and sines, so that the beamformer computes none.

use super::{Active, DepthStep, Ray, Scan};
use crate::error::check_length;
use crate::memory::Need;
use crate::{Complex, Error};

/// Complex numbers of a direction: `e^{js/2}` and `e^{−jφ_c}`.
const PARTS: usize = 2;

/// The direction of the line itself.
const AHEAD: [Complex<f32>; PARTS] = [Complex::new(1.0, 0.0); PARTS];

/// Directions of a line's sub-lines at each sample.
///
/// With the focus point `q` of the line, `q_δ` of the sub-line and the active elements `e_m`,
/// `φ_m = 2πf₀(‖e_m − q‖ − ‖e_m − q_δ‖)/c`. Its least-squares line over the element index is
/// `φ_c + s·(m − centre)`, and the table holds `e^{js/2}` and `e^{−jφ_c}`.
///
/// ```
/// use bonebeam::prelude::stages::*;
///
/// # let scan = Scan::new(ScanParameters {
/// #     lines: Lines::Even(Axis::centred(16, 0.3e-3)),
/// #     ..ScanParameters::EXAMPLE
/// # })?;
/// let mut memory = vec![Complex::default(); Steering::need(scan.samples(), 2).complex];
/// let steering = Steering::new(&scan, 8, 2, &mut memory)?;
/// // Two sub-lines, a quarter of a pitch to the left and to the right: the path grows to the left and to the right.
/// let [left, right] = [0, 1].map(|sub_line| steering.direction(100, sub_line)[0].im);
/// assert!(left < 0.0 && right > 0.0);
/// # Ok::<(), bonebeam::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Steering<'m> {
    /// `[computed sample][sub-line]`.
    directions: &'m [[Complex<f32>; PARTS]],
    sub_lines: usize,
    step: DepthStep,
}

impl<'m> Steering<'m> {
    /// Memory of a line with `samples` samples and `sub_lines` sub-lines.
    ///
    /// With a depth step, `samples` is the number of computed samples.
    pub const fn need(samples: usize, sub_lines: usize) -> Need {
        Need::new(0, samples.saturating_mul(sub_lines).saturating_mul(PARTS))
    }

    /// Computes the directions of a line's sub-lines, once for all frames of a scan.
    ///
    /// The `sub_lines` sub-lines are those of [`Lines::sub_line`], the memory that of [`Steering::need`].
    ///
    /// [`Lines::sub_line`]: super::Lines::sub_line
    ///
    /// Cost in f64: per sample and active element a root and a division for each sub-line, or five of each for more
    /// than four sub-lines; per sample and sub-line two sines with cosines.
    ///
    /// # Errors
    /// [`Error::Length`].
    pub fn new(
        scan: &Scan<'_>,
        line: usize,
        sub_lines: usize,
        memory: &'m mut [Complex<f32>],
    ) -> Result<Self, Error> {
        Self::of_step(scan, line, (sub_lines, 1), memory)
    }

    /// [`Steering::new`] at only the computed samples of a [depth step].
    ///
    /// The directions have the same bits. The memory is [`Steering::need`] of
    /// [`Parameters::line_samples`](crate::beamform::Parameters::line_samples).
    ///
    /// [depth step]: crate::beamform::Parameters::depth_step
    ///
    /// # Errors
    /// [`Error::Length`].
    pub fn of_step(
        scan: &Scan<'_>,
        line: usize,
        (sub_lines, depth_step): (usize, usize),
        memory: &'m mut [Complex<f32>],
    ) -> Result<Self, Error> {
        let step = DepthStep::new(depth_step);
        let need = Self::need(step.outputs(scan.samples()), sub_lines);
        check_length("steering", memory.len(), need.complex)?;
        let (directions, _) = memory.as_chunks_mut::<PARTS>();
        match sub_lines {
            0 | 1 => directions.fill(AHEAD),
            2 => Cell::<2>::new(scan, line).fill(sub_lines, step, directions),
            4 => Cell::<4>::new(scan, line).fill(sub_lines, step, directions),
            _ => Cell::<NODES>::new(scan, line).fill(sub_lines, step, directions),
        }
        Ok(Steering {
            directions,
            sub_lines,
            step,
        })
    }

    /// Directions in memory that [`Steering::new`] filled.
    pub fn of(directions: &'m [Complex<f32>], sub_lines: usize) -> Self {
        Steering {
            directions: directions.as_chunks().0,
            sub_lines,
            step: DepthStep::ONE,
        }
    }

    /// Number of sub-lines.
    pub fn sub_lines(&self) -> usize {
        self.sub_lines
    }

    /// Number of samples, computed or not.
    ///
    /// With a depth step, up to the next computed sample.
    pub fn samples(&self) -> usize {
        let computed = self.directions.len().checked_div(self.sub_lines);
        computed.unwrap_or(0).saturating_mul(self.step.get())
    }

    /// Distance of the samples with directions.
    pub(crate) fn step(&self) -> DepthStep {
        self.step
    }

    /// `e^{js/2}` and `e^{−jφ_c}` of each sub-line at a sample; none beyond the last.
    #[inline(always)]
    pub(crate) fn at(&self, sample: usize) -> &'m [[Complex<f32>; PARTS]] {
        let first = self.step.index(sample).wrapping_mul(self.sub_lines);
        let directions = self.directions.get(first..).unwrap_or_default();
        directions.get(..self.sub_lines).unwrap_or_default()
    }

    /// `e^{js/2}` and `e^{−jφ_c}` of a sub-line at a sample.
    ///
    /// Beyond the last sample, those of the line itself. With a depth step, those of the computed sample at or before
    /// `sample`.
    #[inline(always)]
    pub fn direction(&self, sample: usize, sub_line: usize) -> [Complex<f32>; 2] {
        let index = self.step.index(sample) * self.sub_lines + sub_line;
        self.directions.get(index).copied().unwrap_or(AHEAD)
    }
}

/// Directions of all lines of a scan.
#[derive(Clone, Copy, Debug)]
pub struct SteeringTable<'m> {
    /// `[line][sample][sub-line][2]`.
    directions: &'m [Complex<f32>],
    /// Length of the directions of a line.
    length: usize,
    sub_lines: usize,
    step: DepthStep,
}

impl<'m> SteeringTable<'m> {
    /// Memory of `lines` lines with `samples` samples and `sub_lines` sub-lines.
    ///
    /// With a depth step, `samples` is the number of computed samples.
    pub const fn need(lines: usize, samples: usize, sub_lines: usize) -> Need {
        Need::new(
            0,
            Steering::need(samples, sub_lines)
                .complex
                .saturating_mul(lines),
        )
    }

    /// Computes [`Steering::new`] of every line, in memory of [`SteeringTable::need`].
    ///
    /// # Errors
    /// [`Error::Length`].
    pub fn new(
        scan: &Scan<'_>,
        sub_lines: usize,
        memory: &'m mut [Complex<f32>],
    ) -> Result<Self, Error> {
        Self::of_step(scan, (sub_lines, 1), memory)
    }

    /// Computes [`Steering::of_step`] of every line, in memory of [`SteeringTable::need`].
    ///
    /// # Errors
    /// [`Error::Length`].
    pub fn of_step(
        scan: &Scan<'_>,
        (sub_lines, depth_step): (usize, usize),
        memory: &'m mut [Complex<f32>],
    ) -> Result<Self, Error> {
        let step = DepthStep::new(depth_step);
        let samples = step.outputs(scan.samples());
        let need = Self::need(scan.lines(), samples, sub_lines);
        check_length("steering table", memory.len(), need.complex)?;
        let length = Steering::need(samples, sub_lines).complex;
        for (line, memory) in memory.chunks_exact_mut(length.max(1)).enumerate() {
            Steering::of_step(scan, line, (sub_lines, depth_step), memory)?;
        }
        Self::of(scan, (sub_lines, depth_step), memory)
    }

    /// Directions that [`SteeringTable::of_step`] computed before, in memory or in flash.
    ///
    /// # Errors
    /// [`Error::Length`].
    pub fn of(
        scan: &Scan<'_>,
        (sub_lines, depth_step): (usize, usize),
        directions: &'m [Complex<f32>],
    ) -> Result<Self, Error> {
        let step = DepthStep::new(depth_step);
        let samples = step.outputs(scan.samples());
        let need = Self::need(scan.lines(), samples, sub_lines);
        check_length("directions", directions.len(), need.complex)?;
        Ok(SteeringTable {
            directions,
            length: Steering::need(samples, sub_lines).complex,
            sub_lines,
            step,
        })
    }

    /// Directions of a line; `None` for a line outside the scan.
    pub fn line(&self, line: usize) -> Option<Steering<'m>> {
        let mut of_lines = self.directions.chunks_exact(self.length.max(1));
        Some(Steering {
            step: self.step,
            ..Steering::of(of_lines.nth(line)?, self.sub_lines)
        })
    }
}

/// The cell of a line at `N` parts of its width.
///
/// These are the middles of two or four sub-lines. For more sub-lines they are [`NODES`] parts, with a polynomial
/// between them.
struct Cell<'s, 'a, const N: usize> {
    scan: &'s Scan<'a>,
    line: usize,
    own: Ray,
    rays: [Ray; N],
    parts: [f64; N],
}

/// Parts of a cell's width between which `s` and `φ_c` are polynomials of degree 4.
///
/// In a cell of half width `h` the polynomials err by about `k·h·(h/z)⁴/10` rad, with the wavenumber `k` at the depth
/// `z`: 10⁻⁶ at 4 mm between lines of 0.3 mm.
const NODES: usize = 5;

impl<'s, 'a, const N: usize> Cell<'s, 'a, N> {
    fn new(scan: &'s Scan<'a>, line: usize) -> Self {
        let lines = &scan.parameters().lines;
        let [left, right] = lines.cell(line);
        let mut parts = [0.0; N];
        for (k, part) in parts.iter_mut().enumerate() {
            *part = match N {
                NODES => k as f64 / (NODES - 1) as f64,
                _ => middle_of(k, N),
            };
        }
        Cell {
            scan,
            line,
            own: scan.ray(line),
            rays: parts.map(|part| left.towards(&right, part)),
            parts,
        }
    }

    /// The directions of `sub_lines` sub-lines at all computed samples.
    fn fill(&self, sub_lines: usize, step: DepthStep, directions: &mut [[Complex<f32>; PARTS]]) {
        let p = self.scan.parameters();
        let wave = 2.0 * core::f64::consts::PI * p.centre_frequency / p.sound_speed;
        for (index, directions) in directions.chunks_exact_mut(sub_lines.max(1)).enumerate() {
            let lines = self.least_squares(index * step.get());
            for (k, direction) in directions.iter_mut().enumerate() {
                let [mut mean, mut slope] = [0.0; 2];
                for (node, line) in lines.iter().enumerate() {
                    let weight = match N {
                        NODES => self.weight(node, middle_of(k, sub_lines)),
                        _ => f64::from(u8::from(node == k)),
                    };
                    mean += weight * line[0];
                    slope += weight * line[1];
                }
                *direction = phasors(wave * mean, wave * slope / 2.0);
            }
        }
    }

    /// Lagrange's weight of a node at a part of the width.
    fn weight(&self, node: usize, part: f64) -> f64 {
        let mut weight = 1.0;
        let own = self.parts.get(node).copied().unwrap_or(0.0);
        for (other, &at) in self.parts.iter().enumerate() {
            if other != node {
                weight *= (part - at) / (own - at);
            }
        }
        weight
    }

    /// Constant and slope of the least-squares line through the differences of the echo paths, m, at each part.
    fn least_squares(&self, sample: usize) -> [[f64; 2]; N] {
        let Active { first, count } = self.scan.active(self.line, sample);
        let array = &self.scan.parameters().array;
        let depth = self.scan.depth(sample);
        let [x, z] = self.own.point(depth);
        let points = self.rays.map(|ray| ray.point(depth));
        let centre = count.saturating_sub(1) as f64 / 2.0;
        let (mut lines, mut squares) = ([[0.0; 2]; N], 0.0);
        for m in 0..count {
            let [element_x, element_z] = array.position(first + m);
            let (ax, az) = (element_x - x, element_z - z);
            let own = libm::sqrt(ax * ax + az * az);
            let offset = m as f64 - centre;
            squares += offset * offset;
            for (line, [to_x, to_z]) in lines.iter_mut().zip(points) {
                let (bx, bz) = (element_x - to_x, element_z - to_z);
                let lengths = own + libm::sqrt(bx * bx + bz * bz);
                // ‖a‖ − ‖b‖ = (a − b)·(a + b)/(‖a‖ + ‖b‖): nothing cancels.
                let path = ((to_x - x) * (ax + bx) + (to_z - z) * (az + bz)) / lengths;
                line[0] += path;
                line[1] += offset * path;
            }
        }
        lines.map(|[mean, slope]| {
            let slope = if count > 1 { slope / squares } else { 0.0 };
            [mean / count as f64, slope]
        })
    }
}

/// The middle of sub-line `index` of `count`, as a part of the cell's width.
fn middle_of(index: usize, count: usize) -> f64 {
    (index as f64 + 0.5) / count as f64
}

/// `e^{js/2}` and `e^{−jφ_c}`.
fn phasors(constant: f64, half: f64) -> [Complex<f32>; PARTS] {
    // An element at a focus point, or no element.
    if !(constant.is_finite() && half.is_finite()) {
        return AHEAD;
    }
    let phasor = |phase: f64| {
        let (sine, cosine) = libm::sincos(phase);
        Complex::new(cosine as f32, sine as f32)
    };
    [phasor(half), phasor(-constant)]
}

impl Ray {
    /// The ray `part` of the way from this one to another: position and angle.
    fn towards(&self, other: &Ray, part: f64) -> Ray {
        let between = |a: f64, b: f64| a + part * (b - a);
        Ray::new(
            between(self.x(), other.x()),
            between(self.z(), other.z()),
            between(self.angle(), other.angle()),
        )
    }
}

impl super::Lines<'_> {
    /// Sub-line `index` of `count` of a line.
    ///
    /// Sub-lines are evenly spaced within the line's cell, which extends half way to the neighbours; for the first and
    /// the last line, as far outwards as inwards. All sub-lines of a single line are the line itself.
    ///
    /// ```
    /// use bonebeam::geometry::{Axis, Lines};
    ///
    /// let lines = Lines::Even(Axis::centred(3, 0.4e-3));
    /// let x = [0, 1].map(|index| lines.sub_line(1, index, 2).x());
    /// assert!((x[0] + 0.1e-3).abs() < 1e-15 && (x[1] - 0.1e-3).abs() < 1e-15);
    /// ```
    pub fn sub_line(&self, line: usize, index: usize, count: usize) -> Ray {
        let [left, right] = self.cell(line);
        left.towards(&right, middle_of(index, count))
    }

    /// The edges of a line's cell.
    fn cell(&self, line: usize) -> [Ray; 2] {
        let own = self.ray(line);
        let neighbour = |line: Option<usize>| {
            let line = line.filter(|&line| line < self.count());
            line.map(|line| self.ray(line))
        };
        let left = neighbour(line.checked_sub(1));
        let right = neighbour(line.checked_add(1));
        match (left, right) {
            (Some(left), Some(right)) => [own.towards(&left, 0.5), own.towards(&right, 0.5)],
            (Some(left), None) => [own.towards(&left, 0.5), own.towards(&left, -0.5)],
            (None, Some(right)) => [own.towards(&right, -0.5), own.towards(&right, 0.5)],
            (None, None) => [own; 2],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Array, Axis, Depth, Lines, ScanParameters};
    use std::vec;

    #[test]
    fn directions_of_a_depth_step_are_those_of_its_samples() {
        let scan = Scan::new(ScanParameters {
            array: Array::linear(8, 0.3e-3),
            lines: Lines::Even(Axis::centred(3, 0.3e-3)),
            end: Depth::Metres(5e-3),
            min_elements: 4,
            ..ScanParameters::EXAMPLE
        });
        let scan = scan.expect("valid parameters");
        let samples = scan.samples();
        for (sub_lines, step) in [(2, 2), (2, 7), (4, 3), (16, 2)] {
            let memory = |samples| {
                let need = SteeringTable::need(scan.lines(), samples, sub_lines);
                vec![Complex::ZERO; need.complex]
            };
            let (mut all, mut computed) = (memory(samples), memory(samples.div_ceil(step)));
            let all = SteeringTable::new(&scan, sub_lines, &mut all).expect("memory");
            let computed = SteeringTable::of_step(&scan, (sub_lines, step), &mut computed);
            let computed = computed.expect("memory");
            for line in 0..scan.lines() {
                let [all, computed] =
                    [all, computed].map(|table| table.line(line).expect("a line"));
                assert!((samples..samples + step).contains(&computed.samples()));
                for n in (0..samples).step_by(step) {
                    assert_eq!(computed.at(n), all.at(n), "{line}, {n}");
                    assert_eq!(computed.direction(n, 1), all.direction(n, 1));
                }
            }
        }
    }
}
