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
    let (bang, deep) = (amplitude(draw.within(-10.0, 22.0)), draw.log(0.15, 1.2));
    // Sound through thick gel, and in a strip: its middle, half its width, lines.
    let (gel, thick) = (draw.within(-70.0, -25.0), draw.within(0.6, 2.5));
    let air = draw.sometimes(0.35, -50.0, -12.0);
    let gap = draw.sometimes(0.25, -45.0, -8.0);
    let at_edge = draw.chance(0.6);
    let middle = lines
        * if at_edge {
            draw.count(0, 1) as f32
        } else {
            draw.within(0.0, 1.0)
        };
    let half = 0.5 * lines * draw.log(0.03, 0.5);
    let again = draw.chance(0.7).then(|| draw.within(-14.0, -3.0));
    let (period, ringing) = (draw.log(0.6, 5.0), draw.within(-20.0, 8.0));
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
        if let (Some(fade), true) = (again, depth > 0.8 && first < view.samples) {
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
    let mut passes = vec![Vec::new(); view.samples];
    for bone in bones {
        let through = amplitude(bone.through);
        let hits = bone.hits.iter().enumerate();
        for (line, hit) in hits.filter_map(|(line, hit)| Some((line, (*hit)?))) {
            passes[hit.sample as usize].push((line, through));
        }
    }
    for sample in 0..view.samples {
        light.row_mut(sample).assign(&now);
        for (line, through) in &passes[sample] {
            now[*line] *= through;
        }
        let last = view.lines - 1;
        let old = now.clone();
        for line in 0..view.lines {
            let (left, right) = (old[line.saturating_sub(1)], old[(line + 1).min(last)]);
            let loss = medium.loss[[sample, line]];
            let passed = old[line] + spread * (left + right - 2.0 * old[line]);
            now[line] = if loss == 0.0 {
                passed
            } else {
                passed * amplitude(-loss)
            };
        }
    }
    light
}
