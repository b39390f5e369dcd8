//! Outlines of bone, and the lines' first hits on them.

use super::random::{Curve, Draw, mix};
use super::view::{View, crossed};

/// Points (x, z) of a surface from left to right, mm.
pub type Outline = Vec<[f32; 2]>;

/// A bone and its echo.
#[derive(Clone, Debug)]
pub struct Bone {
    /// The first hit of each line.
    pub hits: Vec<Option<Hit>>,
    /// Level of the flat surface over the tissue's speckle, dB.
    pub level: f32,
    /// Length over which the echo falls by e, mm.
    pub tail: f32,
    /// Share of the echo whose phase is random.
    pub rough: f32,
    /// Fall of the echo at a tilt of 45°, dB.
    pub fall: f32,
    /// Level of the sound that passes, dB.
    pub through: f32,
}

/// A hit of a line on a bone.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Sample of the surface.
    pub sample: f32,
    /// Tilt of the surface against the line, radians.
    pub tilt: f32,
}

/// The first hits of a view's lines on an outline: points (x, z), mm.
pub fn hits(outline: &[[f32; 2]], view: &View) -> Vec<Option<Hit>> {
    let mut hits: Vec<Option<Hit>> = vec![None; view.lines];
    for pair in outline.windows(2) {
        let ([l0, s0], [l1, s1]) = (view.place(pair[0]), view.place(pair[1]));
        for (line, share) in crossed(l0, l1, view.lines) {
            let sample = mix(s0, s1, share);
            let slope = (s1 - s0) * view.step() / ((l1 - l0) * view.pitch(sample));
            let nearer = hits[line].is_none_or(|old| sample < old.sample);
            if nearer && sample > 1.0 && sample < view.samples as f32 {
                let tilt = libm::atanf(slope);
                hits[line] = Some(Hit { sample, tilt });
            }
        }
    }
    hits
}

/// An arch: half an ellipse of an exponent, 2 for round and less for a ridge, with a tilt.
pub fn arch(draw: &mut Draw, [x, top]: [f32; 2], [wide, high]: [f32; 2]) -> Outline {
    let [exponent, tilt, left, right] = draw.row("arch");
    let tilt = tilt * (high / wide).min(1.0);
    let rough = draw.curve(0.02 * wide.min(8.0), wide, 0.2 * wide);
    let points = (-60..=60).map(|k| {
        let t = k as f32 / 60.0 * if k < 0 { left } else { right };
        let fall = 1.0 - libm::powf(1.0 - libm::powf(t.abs(), exponent), 1.0 / exponent);
        let dx = wide * t;
        [x + dx, top + high * fall + tilt * dx + rough.at(dx)]
    });
    points.collect()
}

/// A surface along a curve from `start` to `end`, whose ends bend down by up to `bend` mm.
pub fn span(curve: &Curve, [start, end]: [f32; 2], bend: [f32; 2]) -> Outline {
    let near = |far: f32| (1.0 - far / 3.0).max(0.0);
    let down = |far, bend: f32| bend * near(far) * near(far);
    let points = (0..=160).map(|k| {
        let x = start + (end - start) * k as f32 / 160.0;
        let down = [down(x - start, bend[0]), down(end - x, bend[1])];
        [x, curve.at(x) + down[0] + down[1]]
    });
    points.collect()
}

/// The depth of the first surface at each position; `other` where there is none.
pub fn first(outlines: &[Outline], other: f32) -> Curve {
    Curve::of(|x| {
        let all = outlines.iter().flat_map(|outline| outline.windows(2));
        let within = all.filter(|pair| (pair[0][0]..pair[1][0]).contains(&x));
        within.map(|pair| pair[0][1]).fold(other, f32::min)
    })
}
