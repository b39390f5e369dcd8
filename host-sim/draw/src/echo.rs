//! The bone's echo and its repetitions, the beam and noise.

use std::f32::consts::FRAC_1_SQRT_2;

use ndarray::{Array, Array1, Array2, ArrayView, Axis, Dimension, Slice};

use super::bone::{Bone, Hit};
use super::look::Look;
use super::medium::Medium;
use super::random::{Draw, Patches, amplitude, mix};
use super::view::View;

/// Sound, array and receiver. Lengths in mm, levels in dB over the tissue's speckle.
pub struct Sound {
    /// Full widths of a point's echo at half its maximum: axial, and lateral at the focus.
    pub point: [f32; 2],
    /// Depth of the focus, and the depth over which the beam widens by √2.
    pub focus: [f32; 2],
    /// Noise at the skin, and its increase per mm.
    pub noise: [f32; 2],
    /// Fall of all echoes per mm.
    pub fall: f32,
    /// Speckle patterns that are averaged.
    pub looks: usize,
    /// Level of the layers' repetition below bone, relative.
    pub ghost: f32,
    /// Level of scattered sound below bone, relative to its echo, and its length.
    pub haze: [f32; 2],
    /// Level of wide side lobes, relative.
    pub lobes: f32,
    /// Samples that the shadow's edge spreads into: share of a line's sound that passes to each neighbour, per sample.
    pub spread: f32,
}

impl Sound {
    pub fn drawn(draw: &mut Draw, view: &View, look: &Look) -> Self {
        let [frequency, axial, lateral, focus, range, noise, rise, fall] = draw.row("sound");
        let [looks, ghost, haze, far, lobes, spread] = draw.row("received");
        let wavelength = 1.54 / (frequency / view.depth).clamp(2.0, 16.0);
        let [_, noises, falls] = look.0;
        Sound {
            point: [wavelength * axial, wavelength * lateral],
            focus: [focus * view.depth, range * view.depth],
            noise: [mix(noises[0], noises[1], noise), rise / view.depth],
            fall: mix(falls[0], falls[1], fall) / view.depth,
            looks: looks as usize,
            ghost,
            haze: [haze, far],
            lobes,
            spread,
        }
    }

    /// Weights of the axial blur, with squares that sum to 1.
    fn axial(&self, view: &View) -> Vec<f32> {
        kernel(self.point[0] / view.step() / 2.3548)
    }

    fn lateral(&self, view: &View, sample: f32) -> Vec<f32> {
        let far = (sample * view.step() - self.focus[0]) / self.focus[1];
        let width = self.point[1] * (1.0 + far * far).sqrt();
        kernel(width / view.pitch(sample) / 2.3548)
    }

    /// Distance from a surface down to the crest of its echo, mm.
    pub fn crest(&self, tail: f32) -> f32 {
        let sigma = self.point[0] / 2.3548;
        let echo = |z: f32| -> f32 {
            let part = |k: i32| {
                let y = 0.1 * k as f32 * tail;
                libm::expf(-y / tail - 0.5 * ((z - y) / sigma) * ((z - y) / sigma))
            };
            (0..60).map(part).sum()
        };
        let depths = (0..100).map(|k| 0.02 * k as f32 * (sigma + tail));
        let echoes = depths.map(|z| (z, echo(z)));
        let best = echoes.rev().max_by(|a, b| a.1.total_cmp(&b.1));
        best.map_or(0.0, |best| best.0)
    }

    /// The level of the echoes, dB: `[sample, line]`.
    pub fn echoes(&self, draw: &mut Draw, medium: &Medium, bones: &[Bone]) -> Array2<f32> {
        let (view, light, step) = (&medium.view, &medium.light, medium.view.step());
        let middle = self.lateral(view, 0.5 * view.samples as f32);
        // The peak of a thin line's echo.
        let gain = self.axial(view).into_iter().fold(0.0, f32::max) * middle.iter().sum::<f32>();
        let fall = |sample: f32| amplitude(-self.fall * sample * step);
        let falls = Array1::from_shape_fn(view.samples, |sample| fall(sample as f32));
        let falls = falls.insert_axis(Axis(1));
        let mut rough = medium.level.mapv(amplitude) * light * &falls;
        let mut lines = &medium.lines / gain * light * &falls;
        for bone in bones {
            let uneven = draw.curve(2.0, 15.0, 1.0);
            let patches = Patches::new(draw, [5.0, 1.5 * self.haze[1]], 0.0);
            let [level, length] = self.haze;
            let [decibels, tail, random, slant, _] = bone.echo;
            for &Hit { line, sample, tilt } in &bone.hits {
                let [x, _] = view.point(line as f32, sample);
                let first = sample.ceil() as usize;
                let turned = tilt.abs() / 0.785;
                let decibels = decibels + uneven.at(x) - slant * turned.powf(1.5);
                let fall = fall(sample);
                let size = amplitude(decibels) * light[[sample as usize, line]] * fall;
                let sum = (1.0 + tail / self.point[0]).sqrt();
                let repeated = amplitude(self.ghost - 0.5 * slant * turned * turned);
                let top = (medium.skin.at(x) / step).max(1.0) as usize;
                for k in first..view.samples {
                    let far = (k as f32 - sample) * step;
                    let at = [k, line];
                    let echo = size * libm::expf(-far / tail);
                    let share = match k - first {
                        0 => 1.0,
                        _ => 2.0 * step / tail.max(step),
                    };
                    lines[at] += echo * (1.0 - random) / gain / sum * share;
                    let mut power = rough[at] * rough[at] + echo * echo * random * random;
                    let decay = libm::expf(-far / length - 0.35 * patches.at(x, far));
                    let haze = (size * decay * amplitude(level)).min(0.35 * fall);
                    power += haze * haze;
                    // What lies above is seen again, once more from the array and back.
                    let source = [k - first + top, line];
                    if source[0] < view.samples && source[0] != k {
                        power += (rough[source] * repeated) * (rough[source] * repeated);
                        lines[at] += lines[source] * repeated;
                    }
                    rough[at] = power.sqrt();
                }
            }
        }
        let mut power = Array2::zeros(light.raw_dim());
        for _ in 0..self.looks {
            for part in 0..2 {
                let mut field = rough.mapv(|level| level * draw.normal() * FRAC_1_SQRT_2);
                if part == 0 {
                    field += &lines;
                }
                let field = self.blurred(draw, view, &field);
                power.zip_mut_with(&field, |sum: &mut f32, value| *sum += value * value);
            }
        }
        let looks = self.looks as f32;
        power.mapv(|power| 4.342_945 * libm::logf(power / looks + 1e-12))
    }

    /// A field through the beam, with side lobes and noise.
    fn blurred(&self, draw: &mut Draw, view: &View, field: &Array2<f32>) -> Array2<f32> {
        let lines = view.lines;
        let mut wide = Array2::<f32>::zeros(field.raw_dim());
        let lobes = amplitude(self.lobes) / (lines as f32).sqrt();
        for sample in 0..view.samples {
            let mut row = convolved(field.row(sample), &self.lateral(view, sample as f32));
            // Side lobes: a running mean over a quarter of the lines, in alternating phase.
            let half = lines / 8;
            let (mut sum, mut side) = (0.0, vec![0.0; lines]);
            for line in 0..lines + half {
                let at = |line| row.get(line).copied().unwrap_or(0.0);
                sum += at(line);
                sum -= at(line.wrapping_sub(2 * half + 1));
                if line >= half {
                    side[line - half] = sum;
                }
            }
            let noise = amplitude(self.noise[0] + self.noise[1] * sample as f32 * view.step());
            for (value, side) in row.iter_mut().zip(side) {
                *value += lobes * side + noise * draw.normal() * FRAC_1_SQRT_2;
            }
            wide.row_mut(sample).assign(&row);
        }
        convolved(wide.view(), &self.axial(view))
    }
}

/// A field convolved along its first axis, with zeros beyond its ends.
fn convolved<D: Dimension>(field: ArrayView<f32, D>, weights: &[f32]) -> Array<f32, D> {
    let (last, reach) = (field.len_of(Axis(0)) as isize, weights.len() as isize / 2);
    let mut sum = Array::zeros(field.raw_dim());
    for (shift, weight) in (-reach..=reach)
        .zip(weights)
        .filter(|(k, _)| k.abs() < last)
    {
        let (from, to) = (shift.max(0), last + shift.min(0));
        let source = field.slice_axis(Axis(0), Slice::from(from..to));
        let mut sum = sum.slice_axis_mut(Axis(0), Slice::from(from - shift..to - shift));
        sum.scaled_add(*weight, &source);
    }
    sum
}

/// A Gaussian of `sigma` samples, whose squares sum to 1.
fn kernel(sigma: f32) -> Vec<f32> {
    let sigma = sigma.max(0.3);
    let reach = (2.6 * sigma).ceil() as i32;
    let places = (-reach..=reach).map(|k| k as f32 / sigma);
    let weights = places.map(|far| libm::expf(-0.5 * far * far));
    let norm = weights.clone().map(|w| w * w).sum::<f32>().sqrt();
    weights.map(|w| w / norm).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{random::Curve, view::Array::Linear};
    use super::*;

    /// Levels of a medium of a level with a point, at light 1 and without noise.
    fn levels(level: f32, point: f32) -> (View, Array2<f32>) {
        let (draw, view) = (&mut Draw::new(1, 1), [256, 500]);
        let view = View::new(Linear, 20.0, 40.0, view, 0.1);
        let mut sound = Sound::drawn(draw, &view, &Look::ANY);
        (sound.point, sound.focus, sound.fall) = ([0.5, 1.0], [20.0, 1000.0], 0.0);
        (sound.looks, sound.noise, sound.lobes) = (1, [-200.0, 0.0], -200.0);
        let mut medium = Medium::new(&view, Curve::of(|_| 0.0));
        medium.light.fill(1.0);
        medium.level.fill(level);
        medium.lines[[250, 128]] = point;
        let levels = sound.echoes(draw, &medium, &[]);
        (view, levels)
    }

    #[test]
    fn speckle_of_a_uniform_region_has_the_level_and_spread_of_rayleigh_amplitudes() {
        let (_, levels) = levels(0.0, 0.0);
        let (mean, spread) = (levels.mean().expect("cells"), levels.std(0.0));
        assert!(
            (mean + 2.51).abs() < 0.3 && (spread - 5.57).abs() < 0.2,
            "{mean} {spread}"
        );
    }

    #[test]
    fn a_point_has_its_widths_at_half_its_maximum() {
        let (view, levels) = levels(-100.0, 1e3);
        let half = levels[[250, 128]] - 6.02;
        let above = |lane: ndarray::ArrayView1<f32>| lane.iter().filter(|v| **v > half).count();
        let deep = above(levels.column(128)) as f32 * view.step();
        let wide = above(levels.row(250)) as f32 * view.pitch(250.0);
        assert!(
            (deep - 0.5).abs() < 0.1 && (wide - 1.0).abs() < 0.2,
            "{deep} {wide}"
        );
    }
}
