//! Extent of a cell's echoes in time.

use super::input::{Beam, CellSumInput};
use super::powers::GROUP;
use crate::cells::Cell;
use crate::pulse::FLOOR;
use crate::time_axis::Window;

/// Extent of a cell's echoes in time.
pub struct Shape {
    /// Samples of a pair's row with the echoes, a multiple of 16.
    pub samples: usize,
    /// Number of those before the first echo's centre.
    pub before: usize,
    /// Whole sample from which each element's times count.
    pub origins: Vec<i64>,
    /// Whole sample from which each beam's times count; each element's without beams.
    pub lefts: Vec<i64>,
}

impl Shape {
    /// The extent of a cell's echoes.
    pub fn of(cell: &Cell, input: &CellSumInput<'_>) -> Self {
        let Window { rate, start, .. } = input.window;
        let half = input.pulse.half_length(FLOOR);
        let ranges = |x: f64| cell.ranges(x).map(|r| r / input.response.c);
        let origin = |time: f64| ((time - 0.5 * start) * rate).floor() as i64;
        let mut longest = 0.0f64;
        let origins: Vec<i64> = (input.element_x.iter())
            .map(|&x| {
                let [nearest, furthest] = ranges(x);
                longest = longest.max(furthest - nearest);
                origin(nearest)
            })
            .collect();
        let mut longest_left = longest;
        let lefts = match input.beams {
            None => origins.clone(),
            Some(beams) => {
                let left = |beam: &Beam| {
                    let mut span = [f64::INFINITY, f64::NEG_INFINITY];
                    for (i, advance) in beam.elements.clone().zip(&beam.advance) {
                        let [nearest, furthest] = ranges(input.element_x[i]);
                        span = [
                            span[0].min(nearest - advance),
                            span[1].max(furthest - advance),
                        ];
                    }
                    longest_left = longest_left.max(span[1] - span[0]);
                    origin(span[0])
                };
                beams.iter().map(left).collect()
            }
        };
        let before = ((half - 2.0 * cell.patches[0]) * rate).ceil() + 1.0;
        let after = (half + 2.0 * cell.patches[1] + longest + longest_left) * rate + 3.0;
        Shape {
            samples: ((before + after.ceil()) as usize).next_multiple_of(GROUP),
            before: before as usize,
            origins,
            lefts,
        }
    }
}

/// Longest duration of a cell's echoes, s.
pub fn longest(input: &CellSumInput<'_>) -> f64 {
    let samples = input
        .cells
        .iter()
        .map(|cell| Shape::of(cell, input).samples);
    samples.max().unwrap_or(0) as f64 / input.window.rate
}
