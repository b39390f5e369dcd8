//! Arrays, their lines and the pixels of the field.
//!
//! Points are (x, z) in mm, with z down from the middle of the array. Echoes are drawn on a grid of lines and samples.

use super::random::Draw;

/// Arrays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Array {
    /// Parallel lines.
    Linear,
    /// Lines from a flat array that meet `apex` mm behind it.
    Trapezoid { apex: f32 },
    /// Lines from an arc of a radius in mm.
    Convex { radius: f32 },
}

/// A field of view.
#[derive(Clone, Debug)]
pub struct View {
    /// The array.
    pub array: Array,
    /// Half the width of the array, mm, or half the angle of an arc.
    pub half: f32,
    /// Length of the lines, mm.
    pub depth: f32,
    /// Number of lines.
    pub lines: usize,
    /// Samples of a line.
    pub samples: usize,
    /// Side of a pixel, mm.
    pub pixel: f32,
    /// Pixels of the field: columns, rows.
    pub size: [usize; 2],
}

impl View {
    /// A random view: mostly of a linear array, or of the arrays for depth.
    pub fn drawn(draw: &mut Draw, deep: f32) -> Self {
        let (array, half, depth) = match draw.within(0.0, 1.0) {
            p if p < deep => {
                let [radius, half, depth] = draw.row("convex");
                (Array::Convex { radius }, half, depth)
            }
            p if p < deep + 0.08 => {
                let [half, angle, depth] = draw.row("trapezoid");
                let apex = half / libm::tanf(angle);
                (Array::Trapezoid { apex }, half, depth)
            }
            _ => {
                let [half, depth] = draw.row("linear");
                (Array::Linear, half, depth)
            }
        };
        let [pixel, lines, samples] = draw.row("grid");
        let pixel = pixel.clamp(depth / 1000.0, (depth / 200.0).min(0.25));
        let grid = [lines, samples].map(|number| number as usize);
        View::new(array, half, depth, grid, pixel)
    }

    /// A view whose pixels are at most 1,150 on each side.
    pub fn new(array: Array, half: f32, depth: f32, grid: [usize; 2], pixel: f32) -> Self {
        let [lines, samples] = grid;
        let mut view = View {
            array,
            half,
            depth,
            lines,
            samples,
            pixel,
            size: [0, 0],
        };
        let (width, height) = (2.0 * view.reach(), depth - view.top());
        let least = width.max(height) / 1150.0;
        view.pixel = pixel.max(least);
        view.size = [width, height].map(|side| (side / view.pixel).round() as usize);
        view
    }

    /// Half the width of the field, mm.
    pub fn reach(&self) -> f32 {
        match self.array {
            Array::Linear => self.half,
            Array::Trapezoid { .. } => self.point(self.lines as f32 - 1.0, self.samples as f32)[0],
            Array::Convex { radius } => (radius + self.depth) * libm::sinf(self.half),
        }
    }

    /// Depth of the first row of pixels, mm.
    pub fn top(&self) -> f32 {
        match self.array {
            Array::Convex { radius } => radius * (libm::cosf(self.half) - 1.0),
            _ => 0.0,
        }
    }

    /// Distance of samples, mm.
    pub fn step(&self) -> f32 {
        self.depth / self.samples as f32
    }

    /// Distance of lines at a sample, mm.
    pub fn pitch(&self, sample: f32) -> f32 {
        let pitch = 2.0 * self.half / (self.lines as f32 - 1.0);
        match self.array {
            Array::Linear => pitch,
            Array::Trapezoid { apex } => pitch * (1.0 + sample * self.step() / apex),
            Array::Convex { radius } => pitch * (radius + sample * self.step()),
        }
    }

    /// The point of a line and sample.
    pub fn point(&self, line: f32, sample: f32) -> [f32; 2] {
        let across = self.half * (2.0 * line / (self.lines as f32 - 1.0) - 1.0);
        let along = sample * self.step();
        match self.array {
            Array::Linear => [across, along],
            Array::Trapezoid { apex } => {
                let slope = across / apex;
                let cos = 1.0 / (1.0 + slope * slope).sqrt();
                [across + along * slope * cos, along * cos]
            }
            Array::Convex { radius } => {
                let (sin, cos) = libm::sincosf(across);
                [(radius + along) * sin, (radius + along) * cos - radius]
            }
        }
    }

    /// The line and sample of a point.
    pub fn place(&self, [x, z]: [f32; 2]) -> [f32; 2] {
        let (across, along) = match self.array {
            Array::Linear => (x, z),
            Array::Trapezoid { apex } => {
                let slope = x / (z + apex);
                (apex * slope, z * (1.0 + slope * slope).sqrt())
            }
            Array::Convex { radius } => (
                libm::atan2f(x, z + radius),
                libm::hypotf(x, z + radius) - radius,
            ),
        };
        let line = 0.5 * (across / self.half + 1.0) * (self.lines as f32 - 1.0);
        [line, along / self.step()]
    }

    /// The point of a pixel, and the pixel of a point by `to_pixel`.
    pub fn of_pixel(&self, column: f32, row: f32) -> [f32; 2] {
        [
            (column + 0.5) * self.pixel - self.reach(),
            (row + 0.5) * self.pixel + self.top(),
        ]
    }

    /// The column and row of a point.
    pub fn to_pixel(&self, [x, z]: [f32; 2]) -> [f32; 2] {
        [
            (x + self.reach()) / self.pixel - 0.5,
            (z - self.top()) / self.pixel - 0.5,
        ]
    }
}

/// Whole numbers below `end` that a segment crosses, and the shares of its way there.
pub fn crossed(from: f32, to: f32, end: usize) -> impl Iterator<Item = (usize, f32)> {
    let [first, last] = [from.min(to), from.max(to)].map(|at| at.ceil().max(0.0) as usize);
    (first..last.min(end)).map(move |k| (k, (k as f32 - from) / (to - from)))
}
