//! Sound on its way down: contact with the skin, and shadows.

use std::f32::consts::PI;

use ndarray::{Array1, Array2};

use super::bone::Bone;
use super::medium::Medium;
use super::random::{Curve, Draw, amplitude};

/// Draws the array's own echo, gel and lines without contact; returns the sound that enters.
pub fn contact(draw: &mut Draw, medium: &mut Medium, skin: &Curve) -> Array1<f32> {
    let view = medium.view.clone();
    let (lines, step) = (view.lines as f32, view.step());
    let row = draw.row("contact");
    let [
        bang,
        deep,
        gel,
        thick,
        air,
        gap,
        middle,
        width,
        fade,
        period,
        ringing,
    ] = row;
    let (bang, middle, half) = (amplitude(bang), lines * middle, 0.5 * lines * width);
    let enters = (0..view.lines).map(|line| {
        let [x, z] = view.point(line as f32, 0.0);
        let depth = skin.at(x) - z.max(0.0);
        let lost = ((half - (line as f32 - middle).abs()) / 4.0).clamp(0.0, 1.0);
        let sound = air * ((depth - thick) / thick).clamp(0.0, 1.0) + gap * lost;
        for sample in 0..view.samples {
            let (at, z) = ([sample, line], sample as f32 * step);
            if z < depth {
                medium.level[at] = gel;
                medium.lines[at] = 0.0;
            }
            medium.lines[at] += bang * libm::expf(-2.0 * (z / deep) * (z / deep));
            if lost > 0.0 && gap < 0.0 && z < 0.5 * view.depth {
                let ring = libm::powf(libm::sinf(PI * sample as f32 / period), 8.0);
                medium.lines[at] += lost * amplitude(ringing - 3.0 * z - sound) * ring;
            }
        }
        // The array repeats the skin's line that it sees through gel.
        let first = (depth / step) as usize + 1;
        if fade < 0.0 && depth > 0.8 && first < view.samples {
            let size = medium.lines[[first, line]].min(20.0);
            for times in 2..7 {
                let level = amplitude(fade * (times - 1) as f32 - 0.5 * sound);
                for sample in (first * times).saturating_sub(1)..first * times + 2 {
                    if let Some(value) = medium.lines.get_mut([sample, line]) {
                        *value += 0.7 * size * level;
                    }
                }
            }
        }
        amplitude(sound)
    });
    enters.collect()
}

/// The share of sound at each cell, past bone and losses.
///
/// Sound spreads to neighbouring lines on its way, so that the edges of shadows soften.
pub fn light(medium: &Medium, enters: &Array1<f32>, bones: &[Bone], spread: f32) -> Array2<f32> {
    let view = &medium.view;
    let mut light = Array2::zeros((view.samples, view.lines));
    let mut now = enters.clone();
    for sample in 0..view.samples {
        light.row_mut(sample).assign(&now);
        for bone in bones {
            for (now, hit) in now.iter_mut().zip(&bone.hits) {
                if hit.is_some_and(|hit| hit.sample as usize == sample) {
                    *now *= amplitude(bone.through);
                }
            }
        }
        let (old, last) = (now.clone(), view.lines - 1);
        for (line, (now, loss)) in now.iter_mut().zip(medium.loss.row(sample)).enumerate() {
            let (left, right) = (old[line.saturating_sub(1)], old[(line + 1).min(last)]);
            *now += spread * (left + right - 2.0 * *now);
            *now *= amplitude(-loss);
        }
    }
    light
}
