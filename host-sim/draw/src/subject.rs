//! Subjects, and the outlines of their bones.

use super::bone::{Outline, arch, span};
use super::random::{Curve, Draw};
use super::view::View;

/// Subjects of pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Subject {
    /// A shaft across, often with a second one.
    Shafts,
    /// A surface along the array, with steps.
    Along,
    /// Two ends with a gap.
    Joint,
    /// Several small bones side by side.
    Row,
    /// Ribs over the pleura.
    Ribs,
    /// Processes and laminae of a vertebra, or laminae along the spine.
    Vertebra,
    /// Muscle between aponeuroses.
    Muscle,
    /// Fat lobules, ligaments and lesions.
    Breast,
    /// A gland under thin muscles, beside an artery and the trachea.
    Thyroid,
    /// Liver, diaphragm and kidney.
    Liver,
    /// Vessels in tissue.
    Vessels,
    /// Gas, or lung, under tissue.
    Gas,
}

use Subject::*;

impl Subject {
    /// The usual mixture: two thirds have bone.
    pub const MIX: [Subject; 21] = [
        Shafts, Muscle, Along, Vertebra, Breast, Joint, Shafts, Thyroid, Row, Along, Liver, Ribs,
        Shafts, Vessels, Joint, Vertebra, Gas, Along, Shafts, Muscle, Row,
    ];

    /// Whether its pictures have bone.
    pub fn has_bone(self) -> bool {
        (self as usize) < Muscle as usize
    }

    /// The share of its views by curved and phased arrays.
    pub fn deep(self) -> f32 {
        match self {
            Liver => 0.9,
            Vertebra => 0.4,
            Ribs | Gas => 0.25,
            Breast | Thyroid => 0.0,
            _ => 0.08,
        }
    }

    /// The outlines of its bones, within a view.
    pub fn outlines(self, draw: &mut Draw, view: &View) -> Vec<Outline> {
        let depth = draw.log(0.1, 0.55) * view.depth;
        let x = draw.within(-0.7, 0.7) * view.reach();
        match self {
            Shafts => shafts(draw, view, [x, depth]),
            Along => vec![along(draw, view, [x, depth])],
            Joint => joint(draw, view, [x, depth]),
            Row | Ribs => row(draw, view, [x, depth], self == Ribs),
            Vertebra if draw.chance(0.6) => vertebra(draw, [0.6 * x, depth]),
            Vertebra => laminae(draw, [x, depth]),
            _ => Vec::new(),
        }
    }
}

fn shafts(draw: &mut Draw, view: &View, [x, depth]: [f32; 2]) -> Vec<Outline> {
    let wide = draw.log(3.0, 18.0);
    let high = wide * draw.within(0.35, 1.3);
    let mut all = vec![arch(draw, [x, depth], [wide, high])];
    if draw.chance(0.55) {
        let wide = draw.log(4.0, 18.0);
        let high = wide * draw.within(0.3, 1.1);
        let beside = x + draw.sign() * draw.within(0.3, 1.4) * (wide + 6.0);
        let below = depth + draw.within(-0.1, 0.45) * view.depth;
        all.push(arch(draw, [beside, below.max(4.0)], [wide, high]));
    }
    all
}

fn along(draw: &mut Draw, view: &View, [x, depth]: [f32; 2]) -> Outline {
    let slope = draw.normal() * 0.2;
    let height = draw.log(0.1, 2.5);
    let wave = draw.curve(height, 60.0, 9.0);
    let step = if draw.chance(0.3) {
        draw.within(-1.5, 1.5)
    } else {
        0.0
    };
    let flare = if draw.chance(0.4) {
        draw.within(-5.0, 6.0)
    } else {
        0.0
    };
    let curve = Curve::of(|t| {
        let edge = 1.0 / (1.0 + libm::expf(-(t - x) / 0.25));
        let wide = ((t - x) / 14.0).clamp(-2.0, 2.0);
        let flare = flare * (1.0 - libm::expf(-wide * wide));
        depth + slope * t + wave.at(t) + step * edge + flare
    });
    let mut end = || if draw.chance(0.6) { 1.1 } else { draw.within(0.2, 0.9) } * view.reach();
    let ends = [-end(), end()];
    span(&curve, ends, [draw.within(0.0, 6.0), draw.within(0.0, 6.0)])
}

fn joint(draw: &mut Draw, view: &View, [x, depth]: [f32; 2]) -> Vec<Outline> {
    let (gap, end) = (0.5 * draw.log(0.6, 6.0), 1.1 * view.reach());
    let sides = [([-end, x - gap], 0), ([x + gap, end], 1)];
    let sides = sides.into_iter().map(|(ends, side)| {
        let (slope, cup) = (draw.normal() * 0.25, draw.within(-0.02, 0.03));
        let wave = draw.curve(0.3, 40.0, 6.0);
        let depth = depth + draw.within(-0.06, 0.06) * view.depth;
        let bow = |t: f32| (cup * (t - x) * (t - x)).clamp(-15.0, 15.0);
        let curve = Curve::of(|t| depth + slope * (t - x) + bow(t) + wave.at(t));
        let mut bends = [0.0; 2];
        bends[1 - side] = draw.log(0.4, 9.0);
        span(&curve, ends, bends)
    });
    sides.collect()
}

fn row(draw: &mut Draw, view: &View, [x, depth]: [f32; 2], ribs: bool) -> Vec<Outline> {
    let reach = view.reach();
    let bow = draw.within(-0.004, 0.012);
    let (number, wide, apart) = match ribs {
        true => (9, draw.within(3.0, 8.0), draw.within(13.0, 25.0)),
        false => {
            let number = draw.count(2, 5);
            let wide = draw.log(2.0, 7.0).min(0.8 * reach / number as f32);
            (number, wide, 2.0 * wide * draw.within(1.05, 1.9))
        }
    };
    let bones = (0..number).map(|k| {
        let x = x + apart * (k as f32 - 0.5 * (number - 1) as f32);
        let uneven = if ribs { 0.0 } else { draw.within(-2.0, 2.0) };
        let size = [wide * draw.within(0.7, 1.2), wide * draw.within(0.2, 1.0)];
        arch(draw, [x, depth + bow * x * x + uneven], size)
    });
    bones.collect()
}

fn laminae(draw: &mut Draw, [x, depth]: [f32; 2]) -> Vec<Outline> {
    let (apart, slope) = (
        draw.within(18.0, 34.0),
        draw.sign() * draw.within(0.05, 0.5),
    );
    let laminae = (-3..=3).map(|k| {
        let (x, long) = (x + apart * k as f32, apart * draw.within(0.3, 0.46));
        let (bow, wave) = (draw.within(0.0, 0.03), draw.curve(0.2, 20.0, 4.0));
        let top = depth + draw.within(-1.0, 1.0);
        let curve = Curve::of(|t| top + slope * (t - x) + bow * (t - x) * (t - x) + wave.at(t));
        let bends = [draw.within(0.0, 3.0), draw.within(0.0, 3.0)];
        span(&curve, [x - long, x + long], bends)
    });
    laminae.collect()
}

/// A spinous process, laminae at its sides, and facets or transverse processes.
fn vertebra(draw: &mut Draw, [x, depth]: [f32; 2]) -> Vec<Outline> {
    let deep = depth + draw.within(4.0, 16.0);
    let process = [draw.within(1.5, 5.0), draw.within(1.0, 6.0)];
    let mut all = vec![arch(draw, [x, depth], process)];
    for side in [-1.0, 1.0] {
        let (near, far) = (draw.within(1.0, 5.0), draw.within(11.0, 20.0));
        let (slope, bow) = (draw.within(-0.1, 0.7), draw.within(-0.03, 0.02));
        let wave = draw.curve(0.3, 20.0, 5.0);
        let curve = Curve::of(|t| {
            let out = side * (t - x) - near;
            deep + slope * out + bow * out * out + wave.at(t)
        });
        let ends = [x + side * near, x + side * far];
        let ends = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        let bends = [draw.within(0.0, 2.0), draw.within(0.0, 2.0)];
        all.push(span(&curve, ends, bends));
        if draw.chance(0.7) {
            let x = x + side * (far + draw.within(2.0, 14.0));
            let size = [draw.within(3.0, 9.0), draw.within(1.0, 6.0)];
            let top = deep + draw.within(-5.0, 8.0);
            all.push(arch(draw, [x, top], size));
        }
    }
    all
}
