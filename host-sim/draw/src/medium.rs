//! Scattering of the tissue on the grid of lines and samples.

use std::f32::consts::PI;

use ndarray::Array2;

use super::random::{Curve, Draw, Patches, amplitude};
use super::view::View;

/// Tissue before sound passes through it: `[sample, line]`.
pub struct Medium {
    pub view: View,
    /// Level of the speckle, dB.
    pub level: Array2<f32>,
    /// Amplitude of smooth reflectors, which add up in phase.
    pub lines: Array2<f32>,
    /// Loss on the way through a sample, dB; negative where less is lost than the gain makes up for.
    pub loss: Array2<f32>,
}

/// Short lines within a layer.
#[derive(Clone, Debug)]
pub struct Streaks {
    /// Number per cm².
    pub density: f32,
    /// Range of lengths, mm.
    pub length: [f32; 2],
    /// Mean slope against the layer, and its spread.
    pub slope: [f32; 2],
    /// Range of levels over the layer, dB.
    pub level: [f32; 2],
}

/// A layer down to the next one.
pub struct Layer {
    pub top: Curve,
    pub level: f32,
    /// Size of slow changes of the level, dB.
    pub uneven: f32,
    /// Level of the line on its top, dB, and its thickness, mm.
    pub fascia: Option<[f32; 2]>,
    /// Small changes of the level.
    pub grain: Patches,
    pub streaks: Vec<Streaks>,
}

/// An ellipse: a vessel, tendon, lesion or organ.
pub struct Oval {
    pub at: [f32; 2],
    pub half: [f32; 2],
    /// Level within, relative, dB.
    pub level: f32,
    /// Level of the wall, dB.
    pub wall: f32,
    /// Loss within, dB per mm.
    pub loss: f32,
}

impl Medium {
    pub fn new(view: &View) -> Self {
        let zeros = Array2::zeros((view.samples, view.lines));
        Medium {
            view: view.clone(),
            level: zeros.clone(),
            lines: zeros.clone(),
            loss: zeros,
        }
    }

    /// Calls a function with each cell's index and point.
    pub fn cells(&mut self, mut set: impl FnMut(&mut f32, [f32; 2])) {
        let view = self.view.clone();
        for ((sample, line), level) in self.level.indexed_iter_mut() {
            set(level, view.point(line as f32, sample as f32));
        }
    }

    /// Fills the plane with layers from the top down, and draws their lines.
    pub fn layers(&mut self, draw: &mut Draw, layers: &[Layer]) {
        let length = draw.log(2.0, 12.0);
        let coarse = Patches::new(draw, [1.6 * length, length], 0.0);
        let jagged = Patches::new(draw, [1.5, 0.7], 0.0);
        self.cells(|level, [x, z]| {
            let near = z + 0.35 * jagged.at(x, z);
            let Some(layer) = layers.iter().rfind(|layer| near >= layer.top.at(x)) else {
                *level = -60.0;
                return;
            };
            let patches = 0.9 * coarse.at(x, z) + layer.grain.at(x, z - layer.top.at(x));
            *level = layer.level + layer.uneven * patches;
        });
        let reach = self.view.reach();
        for (k, layer) in layers.iter().enumerate() {
            let end = Curve::of(|x| {
                let below = layers[k + 1..].iter().map(|next| next.top.at(x));
                below.fold(self.view.depth, f32::min)
            });
            if let Some([level, thickness]) = layer.fascia {
                self.curve(draw, &layer.top, [-reach, reach], level, thickness);
            }
            for streaks in &layer.streaks {
                self.streaks(draw, [&layer.top, &end], streaks, layer.level);
            }
        }
    }

    /// Draws a line along a curve, with a level that changes along it.
    pub fn curve(
        &mut self,
        draw: &mut Draw,
        curve: &Curve,
        [start, end]: [f32; 2],
        level: f32,
        thickness: f32,
    ) {
        let changes = draw.curve(4.5, 20.0, 1.2);
        let points = (0..=200).map(|k| {
            let x = start + (end - start) * k as f32 / 200.0;
            ([x, curve.at(x)], amplitude(level + changes.at(x)))
        });
        self.line(&points.collect::<Vec<_>>(), thickness);
    }

    /// Short lines between two curves.
    pub fn streaks(
        &mut self,
        draw: &mut Draw,
        [top, end]: [&Curve; 2],
        streaks: &Streaks,
        level: f32,
    ) {
        let reach = self.view.reach();
        let height = (end.at(0.0) - top.at(0.0)).clamp(1.0, 200.0);
        let number = (streaks.density * 0.02 * reach * height) as usize;
        let clusters = Patches::new(draw, [9.0, 5.0], 0.3);
        for _ in 0..number.min(700) {
            let x0 = draw.within(-reach, reach);
            let length = draw.log(streaks.length[0], streaks.length[1]);
            let slope = streaks.slope[0] + streaks.slope[1] * draw.normal();
            let part = draw.within(0.0, 1.0);
            let bright = level + draw.within(streaks.level[0], streaks.level[1]);
            let (bend, thickness) = (draw.within(-0.05, 0.05), draw.log(0.05, 0.25));
            let (from, to) = (top.at(x0), end.at(x0));
            let bright = bright + 5.0 * clusters.at(x0, from + part * (to - from));
            let points = (0..=12).map(|k| {
                let t = k as f32 / 12.0;
                let dx = length * (t - 0.5);
                let (top, end) = (top.at(x0 + dx), end.at(x0 + dx));
                let z =
                    top + part * (end - top) + slope * dx + bend * dx * dx / length.max(1.0) * 4.0;
                let size = if z > top && z < end {
                    libm::sinf(PI * t)
                } else {
                    0.0
                };
                ([x0 + dx, z], size * amplitude(bright))
            });
            self.line(&points.collect::<Vec<_>>(), thickness);
        }
    }

    /// Adds a smooth reflector: points with their amplitudes, a thickness in mm.
    pub fn line(&mut self, points: &[([f32; 2], f32)], thickness: f32) {
        let sigma = (0.5 * thickness / self.view.step()).max(0.35);
        for pair in points.windows(2) {
            let [(a, from), (b, to)] = [pair[0], pair[1]];
            let ([l0, s0], [l1, s1]) = (self.view.place(a), self.view.place(b));
            let (first, last) = (l0.min(l1).ceil().max(0.0), l0.max(l1).ceil());
            for line in first as usize..(last.max(0.0) as usize).min(self.view.lines) {
                let t = (line as f32 - l0) / (l1 - l0);
                let (middle, size) = (s0 + t * (s1 - s0), from + t * (to - from));
                let (start, end) = (middle - 2.5 * sigma, middle + 2.5 * sigma);
                for sample in
                    start.max(0.0) as usize..(end.max(0.0) as usize).min(self.view.samples)
                {
                    let far = (sample as f32 - middle) / sigma;
                    self.lines[[sample, line]] +=
                        0.4 * size / sigma.max(1.0) * libm::expf(-0.5 * far * far);
                }
            }
        }
    }

    /// Draws an ellipse.
    pub fn ellipse(&mut self, draw: &mut Draw, oval: &Oval) {
        let Oval {
            at: [x0, z0],
            half: [a, b],
            level,
            wall,
            loss,
        } = *oval;
        let (sin, cos) = libm::sincosf(draw.within(-0.4, 0.4));
        let uneven = draw.log(0.01, 0.12);
        let rim = draw.curve(uneven, 25.0, 6.0);
        let (step, view) = (self.view.step(), self.view.clone());
        for (at @ (sample, line), cell) in self.level.indexed_iter_mut() {
            let [x, z] = view.point(line as f32, sample as f32);
            let (dx, dz) = (x - x0, z - z0);
            let (p, q) = ((dx * cos + dz * sin) / a, (dz * cos - dx * sin) / b);
            let far = p * p + q * q;
            if far < 2.0 && far.sqrt() < 1.0 + rim.at(8.0 * libm::atan2f(q, p)) {
                *cell += level;
                self.loss[at] += loss * step;
                self.lines[at] *= amplitude(level);
            }
        }
        let points = (-24..=24).map(|k| {
            let angle = k as f32 / 24.0 * PI;
            let (q, p) = libm::sincosf(angle);
            let far = 1.0 + rim.at(8.0 * angle);
            let (p, q) = (p * far * a, q * far * b);
            let flat = libm::sinf(angle).abs() * 0.8 + 0.2;
            (
                [x0 + p * cos - q * sin, z0 + p * sin + q * cos],
                flat * amplitude(wall),
            )
        });
        self.line(&points.collect::<Vec<_>>(), 0.2);
    }
}
