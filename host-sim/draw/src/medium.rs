//! Scattering of the tissue on the grid of lines and samples.

use std::f32::consts::PI;

use ndarray::{Array2, Zip};

use super::random::{Curve, Draw, Patches, amplitude, mix};
use super::view::{View, crossed};

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

/// Short lines within a layer: least and greatest length, mean slope against the layer and its spread, least and greatest
/// level over the layer, number per cm².
pub type Streaks = [f32; 7];

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

    /// Calls a function with each cell's point, and its level, lines and loss.
    pub fn cells(&mut self, mut set: impl FnMut([f32; 2], [&mut f32; 3])) {
        let cells = Zip::indexed(&mut self.level).and(&mut self.lines);
        cells
            .and(&mut self.loss)
            .for_each(|(sample, line), a, b, c| {
                set(self.view.point(line as f32, sample as f32), [a, b, c]);
            });
    }

    /// Fills the plane with layers from the top down, and draws their lines.
    pub fn layers(&mut self, draw: &mut Draw, layers: &[Layer]) {
        let length = draw.log(2.0, 12.0);
        let coarse = Patches::new(draw, [1.6 * length, length], 0.0);
        let jagged = Patches::new(draw, [1.5, 0.7], 0.0);
        self.cells(|[x, z], [level, ..]| {
            let near = z + 0.35 * jagged.at(x, z);
            let layer = layers.iter().rfind(|layer| near >= layer.top.at(x));
            *level = layer.map_or(-60.0, |layer| {
                let patches = 0.9 * coarse.at(x, z) + layer.grain.at(x, z - layer.top.at(x));
                layer.level + layer.uneven * patches
            });
        });
        let reach = self.view.reach();
        for (k, layer) in layers.iter().enumerate() {
            let end = Curve::of(|x| {
                let below = layers[k + 1..].iter().map(|next| next.top.at(x));
                below.fold(self.view.depth, f32::min)
            });
            if let Some(fascia) = layer.fascia {
                self.curve(draw, &layer.top, [-reach, reach], fascia);
            }
            for streaks in &layer.streaks {
                self.streaks(draw, [&layer.top, &end], streaks, layer.level);
            }
        }
    }

    /// Draws a line of a level and a thickness along a curve; the level changes along it.
    pub fn curve(
        &mut self,
        draw: &mut Draw,
        curve: &Curve,
        [start, end]: [f32; 2],
        [level, thickness]: [f32; 2],
    ) {
        let changes = draw.curve(4.5, 20.0, 1.2);
        let points = (0..=200).map(|k| {
            let x = start + (end - start) * k as f32 / 200.0;
            ([x, curve.at(x)], amplitude(level + changes.at(x)))
        });
        self.line(points, thickness);
    }

    /// Short lines between two curves.
    fn streaks(&mut self, draw: &mut Draw, [top, end]: [&Curve; 2], streaks: &Streaks, level: f32) {
        let [shortest, longest, slope, spread, dark, bright, density] = *streaks;
        let reach = self.view.reach();
        let height = (end.at(0.0) - top.at(0.0)).clamp(1.0, 200.0);
        let number = (density * 0.02 * reach * height) as usize;
        let clusters = Patches::new(draw, [9.0, 5.0], 0.3);
        for _ in 0..number.min(700) {
            let x0 = draw.within(-reach, reach);
            let length = draw.log(shortest, longest);
            let slope = slope + spread * draw.normal();
            let part = draw.within(0.0, 1.0);
            let level = level + draw.within(dark, bright);
            let (bend, thickness) = (draw.within(-0.05, 0.05), draw.log(0.05, 0.25));
            let bend = |dx: f32| bend * dx * dx / length.max(1.0) * 4.0;
            let level = level + 5.0 * clusters.at(x0, mix(top.at(x0), end.at(x0), part));
            let points = (0..=12).map(|k| {
                let t = k as f32 / 12.0;
                let dx = length * (t - 0.5);
                let (top, end) = (top.at(x0 + dx), end.at(x0 + dx));
                let z = mix(top, end, part) + slope * dx + bend(dx);
                let within = if z > top && z < end { 1.0 } else { 0.0 };
                ([x0 + dx, z], within * libm::sinf(PI * t) * amplitude(level))
            });
            self.line(points, thickness);
        }
    }

    /// Adds a smooth reflector: points with their amplitudes, a thickness in mm.
    fn line(&mut self, points: impl Iterator<Item = ([f32; 2], f32)>, thickness: f32) {
        let (lines, samples) = (self.view.lines, self.view.samples);
        let sigma = (0.5 * thickness / self.view.step()).max(0.35);
        let points: Vec<_> = points
            .map(|(at, size)| (self.view.place(at), size))
            .collect();
        for pair in points.windows(2) {
            let [([l0, s0], from), ([l1, s1], to)] = [pair[0], pair[1]];
            for (line, share) in crossed(l0, l1, lines) {
                let (middle, size) = (mix(s0, s1, share), mix(from, to, share));
                let [start, end] = [-2.5, 2.5].map(|far| (middle + far * sigma).max(0.0) as usize);
                for sample in start..end.min(samples) {
                    let far = (sample as f32 - middle) / sigma;
                    self.lines[[sample, line]] +=
                        0.4 * size / sigma.max(1.0) * libm::expf(-0.5 * far * far);
                }
            }
        }
    }

    /// Draws an ellipse at a point: half its width and height; relative level within, level of the wall, loss per mm.
    pub fn ellipse(
        &mut self,
        draw: &mut Draw,
        [x0, z0]: [f32; 2],
        [a, b]: [f32; 2],
        [level, wall, loss]: [f32; 3],
    ) {
        let (sin, cos) = libm::sincosf(draw.within(-0.4, 0.4));
        let uneven = draw.log(0.01, 0.12);
        let rim = draw.curve(uneven, 25.0, 6.0);
        let step = self.view.step();
        self.cells(|[x, z], [cell, lines, lost]| {
            let (dx, dz) = (x - x0, z - z0);
            let (p, q) = ((dx * cos + dz * sin) / a, (dz * cos - dx * sin) / b);
            let far = p * p + q * q;
            if far < 2.0 && far.sqrt() < 1.0 + rim.at(8.0 * libm::atan2f(q, p)) {
                *cell += level;
                *lost += loss * step;
                *lines *= amplitude(level);
            }
        });
        let points = (-24..=24).map(|k| {
            let angle = k as f32 / 24.0 * PI;
            let (q, p) = libm::sincosf(angle);
            let far = 1.0 + rim.at(8.0 * angle);
            let (p, q) = (p * far * a, q * far * b);
            let at = [x0 + p * cos - q * sin, z0 + p * sin + q * cos];
            let flat = libm::sinf(angle).abs() * 0.8 + 0.2;
            (at, flat * amplitude(wall))
        });
        self.line(points, 0.2);
    }
}
