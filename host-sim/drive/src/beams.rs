//! The lines of a recording: those that fit its array, or those requested.

use std::ops::Range;

use bonebeam::geometry::{Array, Element, Ray};

use crate::config::{Beamform, LineKind};
use crate::{Error, Result};
use bonebeam_files::terminal::digits;
use bonebeam_files::{ChannelData, Transmits};

/// Pitch in wavelengths below which a straight array is steered.
///
/// Grating lobes stay away from a sector at half a wavelength; a linear array has about one wavelength.
const PHASED: f64 = 0.7;
/// Largest number of lines.
const MOST_LINES: usize = 65536;
/// Halvings of an interval of elements, down to a billionth of an element.
const HALVINGS: usize = 40;

/// The lines of a recording.
pub struct Beams {
    /// From left to right.
    pub rays: Vec<Ray>,
    /// Whether output lines, made of sub-lines, may be closer than these.
    pub divided: bool,
    /// Whether each line has its own transmits; else all are compounded into each.
    pub own: bool,
    /// The recording's transmits in the order of the lines, if they have another.
    pub order: Option<Vec<usize>>,
    /// Transmits of each line in that order, if it has its own.
    ///
    /// Its samples are their mean.
    pub of_lines: Vec<Range<usize>>,
}

/// The elements with their directions, if the array is not straight.
pub fn elements_of(data: &ChannelData) -> Vec<Element> {
    if data.is_straight() {
        return Vec::new();
    }
    let last = data.element_x.len() - 1;
    // Across the line from one element to another.
    let across = |left: usize, right: usize| {
        let ([ax, az], [bx, bz]) = (data.element(left), data.element(right));
        libm::atan2(az - bz, bx - ax)
    };
    let angle = |m: usize| match &data.element_angle {
        Some(angle) => angle[m],
        None if last == 1 => across(0, 1),
        // At the ends as if the curve went on: it turns by as much again.
        None if m == 0 => 2.0 * across(0, 1) - across(0, 2),
        None if m == last => 2.0 * across(last - 1, last) - across(last - 2, last),
        None => across(m - 1, m + 1),
    };
    (0..=last)
        .map(|m| {
            let [x, z] = data.element(m);
            let angle = angle(m);
            Element { x, z, angle }
        })
        .collect()
}

/// The array of a recording; `elements` are given if it is not straight.
pub(super) fn array_of<'e>(data: &'e ChannelData, elements: &'e [Element]) -> Array<'e> {
    if elements.is_empty() {
        return Array::LinearAt(&data.element_x);
    }
    let between = |pair: &[Element]| (pair[1].x - pair[0].x).hypot(pair[1].z - pair[0].z);
    let along: f64 = elements.windows(2).map(between).sum();
    Array::at(elements, along / (elements.len() - 1) as f64)
}

impl Beams {
    /// The lines of `data` on `array`, as the parameters ask for.
    ///
    /// # Errors
    /// [`Error::Usage`] for flags that do not fit the transmits.
    pub fn new(data: &ChannelData, array: &Array<'_>, parameters: &Beamform) -> Result<Self> {
        if let Transmits::Focused { x, .. } = &data.transmits {
            if let Some(flag) = asked_for(parameters) {
                return Err(Error::Usage(format!(
                    "{flag} has no effect on focused transmits (`tx_x`), which make one line each"
                )));
            }
            let (rays, places) = (x.iter().map(|&x| Ray::down(x)), x.clone());
            return Ok(Beams::sorted(rays.collect(), &places));
        }
        let c = parameters.sound_speed.unwrap_or(data.c);
        let fitting = if !data.is_straight() {
            LineKind::Normals
        } else if phased(data, c) {
            LineKind::Sector
        } else {
            LineKind::Down
        };
        if asked_for(parameters).is_none()
            && let Some((rays, places)) = through_foci(data, array, fitting)
        {
            return Ok(Beams::sorted(rays, &places));
        }
        let kind = parameters.lines.unwrap_or(fitting);
        let rays = grid(data, array, kind, parameters)?;
        // Sub-lines of one line an element are as right as those of two, at half the cost.
        let divided = parameters.chooses_sub_lines() && !counted(parameters);
        let step = if divided { 2 } else { 1 };
        Ok(Beams {
            rays: rays.into_iter().step_by(step).collect(),
            divided,
            own: false,
            order: None,
            of_lines: Vec::new(),
        })
    }

    /// A line for each place, from left to right whatever the order of the transmits.
    fn sorted(mut rays: Vec<Ray>, places: &[f64]) -> Self {
        let mut order: Vec<usize> = (0..places.len()).collect();
        order.sort_by(|&a, &b| places[a].total_cmp(&places[b]));
        let mut of_lines: Vec<Range<usize>> = Vec::new();
        for at in 0..order.len() {
            match of_lines.last_mut() {
                Some(last) if places[order[last.start]] == places[order[at]] => last.end = at + 1,
                _ => of_lines.push(at..at + 1),
            }
        }
        rays = of_lines.iter().map(|of| rays[order[of.start]]).collect();
        Beams {
            rays,
            divided: false,
            own: true,
            order: (!order.is_sorted()).then_some(order),
            of_lines,
        }
    }

    /// Places in [`Beams::order`] of the transmits of some lines, if they have their own.
    pub fn transmits_of(&self, lines: &Range<usize>) -> Option<Range<usize>> {
        let own = self.of_lines.get(lines.clone()).filter(|_| self.own)?;
        Some(own.first().map_or(0, |of| of.start)..own.last().map_or(0, |of| of.end))
    }
}

/// Whether a straight array is steered.
///
/// Plane and single-element transmits are as often those of a linear array with narrow elements; such data are imaged
/// straight down.
fn phased(data: &ChannelData, c: f64) -> bool {
    let steered = matches!(
        data.transmits,
        Transmits::VirtualSource { .. } | Transmits::Delays { .. }
    );
    steered && data.pitch() < PHASED * c / data.f0
}

/// The first given flag that asks for lines of a grid.
fn asked_for(parameters: &Beamform) -> Option<&'static str> {
    let flags = [
        ("--lines", parameters.lines.is_some()),
        ("--line-count", parameters.line_count.is_some()),
        ("--line-spacing", parameters.line_spacing.is_some()),
        ("--lateral-start", parameters.lateral_start.is_some()),
        ("--lateral-end", parameters.lateral_end.is_some()),
    ];
    flags
        .into_iter()
        .find(|(_, given)| *given)
        .map(|(flag, _)| flag)
}

/// Whether the number of lines is given.
fn counted(parameters: &Beamform) -> bool {
    let asked = [
        parameters.line_count.is_some(),
        parameters.line_spacing.is_some(),
        parameters.lateral_start.is_some(),
        parameters.lateral_end.is_some(),
    ];
    asked.contains(&true)
}

/// Evenly spaced lines over the whole array, or those requested.
///
/// The default is two per element.
fn grid(
    data: &ChannelData,
    array: &Array<'_>,
    kind: LineKind,
    parameters: &Beamform,
) -> Result<Vec<Ray>> {
    let elements = data.element_x.len();
    let usual = 2 * elements - 1;
    let lateral = [
        ("--line-spacing", parameters.line_spacing),
        ("--lateral-start", parameters.lateral_start),
        ("--lateral-end", parameters.lateral_end),
    ];
    if let Some((flag, _)) = lateral.iter().find(|(_, given)| given.is_some()) {
        if kind == LineKind::Down {
            return lateral_lines(data, parameters);
        }
        return Err(Error::Usage(format!(
            "{flag} is for lines straight down; --line-count and, for a sector, --sector choose lines that fan \
             out, and --lines down makes straight lines"
        )));
    }
    let count = parameters.line_count.unwrap_or(usual);
    let fraction = |line: usize| line as f64 / (count - 1) as f64;
    let [first, last] = [data.element_x[0], data.element_x[elements - 1]];
    Ok(match kind {
        LineKind::Down => {
            let step = match count == usual {
                true if data.is_straight() => data.pitch() / 2.0,
                _ => (last - first) / (count - 1) as f64,
            };
            let at = |line: usize| Ray::down(first + line as f64 * step);
            (0..count).map(at).collect()
        }
        LineKind::Normals => (0..count)
            .map(|line| array.normal(fraction(line) * (elements - 1) as f64))
            .collect(),
        LineKind::Sector => {
            let (left, width) = (-parameters.sector / 2.0, parameters.sector);
            let middle = (first + last) / 2.0;
            (0..count)
                .map(|line| Ray::new(middle, 0.0, left + fraction(line) * width))
                .collect()
        }
    })
}

/// Lines straight down between given positions, by spacing or count.
///
/// If spacing and count leave the ends open, the lines are centred on the array.
fn lateral_lines(data: &ChannelData, parameters: &Beamform) -> Result<Vec<Ray>> {
    let [left, right] = [data.element_x[0], data.element_x[data.element_x.len() - 1]];
    let (first, last) = (parameters.lateral_start, parameters.lateral_end);
    let [start, end] = [first.unwrap_or(left), last.unwrap_or(right)];
    let (first, step, count) = match (parameters.line_spacing, parameters.line_count) {
        (Some(step), Some(count)) => {
            let width = (count - 1) as f64 * step;
            let middle = (left + right) / 2.0;
            let from = first.or(last.map(|last| last - width));
            (from.unwrap_or(middle - width / 2.0), step, count)
        }
        (None, Some(count)) => (start, (end - start) / (count - 1) as f64, count),
        (spacing, None) => {
            let step = spacing.unwrap_or(data.pitch() / 2.0);
            // The cast saturates. A last line that rounding puts beyond the end is on it.
            let steps = ((end - start) / step + 1e-6).floor() as usize;
            (start, step, steps.saturating_add(1))
        }
    };
    if !(step > 0.0 && (2..=MOST_LINES).contains(&count)) {
        return Err(Error::Usage(format!(
            "{} m to {} m at {} m makes {count} lines (--lateral-start, --lateral-end, --line-spacing); expected 2 to \
             {MOST_LINES}, from left to right",
            digits(start),
            digits(end),
            digits(step)
        )));
    }
    let at = |line: usize| Ray::down(first + line as f64 * step);
    Ok((0..count).map(at).collect())
}

/// A line through each focus, and its place among them.
///
/// Only if all transmits converge, each at its own position.
fn through_foci(
    data: &ChannelData,
    array: &Array<'_>,
    kind: LineKind,
) -> Option<(Vec<Ray>, Vec<f64>)> {
    let Transmits::VirtualSource { x, z } = &data.transmits else {
        return None;
    };
    if x.len() < 2 || z.iter().any(|&z| z <= 0.0) {
        return None;
    }
    let last = data.element_x.len() - 1;
    let middle = (data.element_x[0] + data.element_x[last]) / 2.0;
    let rays: Vec<Ray> = x
        .iter()
        .zip(z)
        .map(|(&x, &z)| match kind {
            LineKind::Down => Ray::down(x),
            LineKind::Normals => normal_through(array, [x, z]),
            LineKind::Sector => Ray::new(middle, 0.0, libm::atan2(x - middle, z)),
        })
        .collect();
    let along = |ray: &Ray| match kind {
        LineKind::Down => ray.x(),
        LineKind::Normals | LineKind::Sector => ray.angle(),
    };
    let places: Vec<f64> = rays.iter().map(along).collect();
    let mut sorted = places.clone();
    sorted.sort_by(f64::total_cmp);
    let apart = sorted.is_sorted_by(|a, b| a < b);
    apart.then_some((rays, places))
}

/// The array's normal through a position.
fn normal_through(array: &Array<'_>, position: [f64; 2]) -> Ray {
    let (mut low, mut high) = (0.0, (array.elements() - 1) as f64);
    for _ in 0..HALVINGS {
        let middle = (low + high) / 2.0;
        let [right, _] = array.normal(middle).coordinates(position);
        if right > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    array.normal((low + high) / 2.0)
}
