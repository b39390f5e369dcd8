//! The bone's echo and its repetitions, the beam and noise.

use std::f32::consts::FRAC_1_SQRT_2;

use ndarray::{Array1, Array2, Axis, Slice};

use super::Look;
use super::bone::{Bone, Hit};
use super::medium::Medium;
use super::random::{Curve, Draw, Patches, amplitude, mix};
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
        let [
            frequency,
            axial,
            lateral,
            focus,
            range,
            noise,
            rise,
            fall,
            looks,
            ghost,
            haze,
            far,
            lobes,
            spread,
        ] = draw.row("sound");
        let wavelength = 1.54 / (frequency / view.depth).clamp(2.0, 16.0);
        let within = |[low, high]: [f32; 2], share| mix(low, high, share);
        Sound {
            point: [wavelength * axial, wavelength * lateral],
            focus: [focus * view.depth, range * view.depth],
            noise: [within(look.noise, noise), rise / view.depth],
            fall: within(look.fall, fall) / view.depth,
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
        echoes
            .fold(
                (0.0, 0.0),
                |best, now| if now.1 > best.1 { now } else { best },
            )
            .0
    }
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

/// The level of the echoes, dB: `[sample, line]`.
pub fn echoes(
    draw: &mut Draw,
    sound: &Sound,
    medium: &Medium,
    light: &Array2<f32>,
    bones: &[Bone],
    skin: &Curve,
) -> Array2<f32> {
    let view = &medium.view;
    let step = view.step();
    let middle = sound.lateral(view, 0.5 * view.samples as f32);
    let axial = sound.axial(view);
    // The peak of a thin line's echo.
    let gain = axial.iter().copied().fold(0.0, f32::max) * middle.iter().sum::<f32>();
    let fall = |sample: f32| amplitude(-sound.fall * sample * step);
    let falls = Array1::from_shape_fn(view.samples, |sample| fall(sample as f32));
    let falls = falls.insert_axis(Axis(1));
    let mut rough = medium.level.mapv(amplitude) * light * &falls;
    let mut lines = &medium.lines / gain * light * &falls;
    for bone in bones {
        let uneven = draw.curve(2.0, 15.0, 1.0);
        let patches = Patches::new(draw, [5.0, 1.5 * sound.haze[1]], 0.0);
        let [level, length] = sound.haze;
        for (line, hit) in bone.hits.iter().enumerate() {
            let Some(Hit { sample, tilt }) = *hit else {
                continue;
            };
            let [x, _] = view.point(line as f32, sample);
            let first = sample.ceil() as usize;
            let turned = tilt.abs() / 0.785;
            let decibels = bone.level + uneven.at(x) - bone.fall * turned.powf(1.5);
            let fall = fall(sample);
            let size = amplitude(decibels) * light[[sample as usize, line]] * fall;
            let sum = (1.0 + bone.tail / sound.point[0]).sqrt();
            let repeated = amplitude(sound.ghost - 0.5 * bone.fall * turned * turned);
            let top = (skin.at(x) / step).max(1.0) as usize;
            for k in first..view.samples {
                let far = (k as f32 - sample) * step;
                let at = [k, line];
                let echo = size * libm::expf(-far / bone.tail);
                let share = match k - first {
                    0 => 1.0,
                    _ => 2.0 * step / bone.tail.max(step),
                };
                lines[at] += echo * (1.0 - bone.rough) / gain / sum * share;
                let mut power = rough[at] * rough[at] + echo * echo * bone.rough * bone.rough;
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
    for _ in 0..sound.looks {
        for part in 0..2 {
            let mut field = rough.mapv(|level| level * draw.normal() * FRAC_1_SQRT_2);
            if part == 0 {
                field += &lines;
            }
            let field = blurred(draw, sound, view, &field, &axial);
            power.zip_mut_with(&field, |sum: &mut f32, value| *sum += value * value);
        }
    }
    let looks = sound.looks as f32;
    power.mapv(|power| 4.342_945 * libm::logf(power / looks + 1e-12))
}

/// A field through the beam, with side lobes and noise.
fn blurred(
    draw: &mut Draw,
    sound: &Sound,
    view: &View,
    field: &Array2<f32>,
    axial: &[f32],
) -> Array2<f32> {
    let lines = view.lines;
    let mut wide = Array2::<f32>::zeros(field.raw_dim());
    let lobes = amplitude(sound.lobes) / (lines as f32).sqrt();
    let mut padded = Vec::new();
    for sample in 0..view.samples {
        let weights = sound.lateral(view, sample as f32);
        let reach = weights.len() / 2;
        padded.clear();
        padded.resize(reach, 0.0);
        padded.extend(field.row(sample));
        padded.resize(lines + 2 * reach, 0.0);
        let mut row = wide.row_mut(sample);
        let row = row.as_slice_mut().expect("standard layout");
        for (k, weight) in weights.iter().enumerate() {
            for (sum, value) in row.iter_mut().zip(&padded[k..]) {
                *sum += weight * value;
            }
        }
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
        let noise = amplitude(sound.noise[0] + sound.noise[1] * sample as f32 * view.step());
        for (value, side) in row.iter_mut().zip(side) {
            *value += lobes * side + noise * draw.normal() * FRAC_1_SQRT_2;
        }
    }
    let reach = axial.len() / 2;
    let mut deep = Array2::zeros(field.raw_dim());
    for (k, weight) in axial.iter().enumerate() {
        let shift = k as isize - reach as isize;
        let (from, to) = (shift.max(0), view.samples as isize + shift.min(0));
        let source = wide.slice_axis(Axis(0), Slice::from(from..to));
        deep.slice_axis_mut(Axis(0), Slice::from(from - shift..to - shift))
            .scaled_add(*weight, &source);
    }
    deep
}
