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
    /// Bone in water.
    Bath,
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
    /// Wires in water or in a phantom.
    Wires,
}

use Subject::*;

impl Subject {
    /// The usual mixture: two thirds have bone.
    pub const MIX: [Subject; 23] = [
        Shafts, Muscle, Along, Vertebra, Breast, Joint, Shafts, Thyroid, Row, Along, Liver, Ribs,
        Bath, Vessels, Joint, Vertebra, Gas, Along, Shafts, Muscle, Row, Bath, Wires,
    ];

    /// Whether its pictures have bone.
    pub fn has_bone(self) -> bool {
        (self as usize) < Muscle as usize
    }

    /// The share of its views by curved and phased arrays.
    pub fn deep(self) -> f32 {
        match self {
            Liver => 0.9,
            Vertebra | Bath => 0.4,
            Ribs | Gas => 0.25,
            Breast | Thyroid | Wires => 0.0,
            _ => 0.08,
        }
    }

    /// The outlines of its bones, within a view.
    pub fn outlines(self, draw: &mut Draw, view: &View) -> Vec<Outline> {
        let [depth, x] = draw.row("place");
        let at @ [x, depth] = [x * view.reach(), depth * view.depth];
        match self {
            Shafts => shafts(draw, view, at),
            Along => vec![along(draw, view, at)],
            Joint => joint(draw, view, at),
            Row | Ribs => row(draw, view, at, self == Ribs),
            Bath if draw.chance(0.3) => vec![along(draw, view, at)],
            Bath if draw.chance(0.3) => shafts(draw, view, at),
            Vertebra | Bath if draw.chance(0.6) => vertebra(draw, [0.6 * x, depth]),
            Vertebra | Bath => laminae(draw, at),
            _ => Vec::new(),
        }
    }
}

fn shafts(draw: &mut Draw, view: &View, [x, depth]: [f32; 2]) -> Vec<Outline> {
    let [wide, flat] = draw.row("shaft");
    let mut all = vec![arch(draw, [x, depth], [wide, wide * flat])];
    if draw.chance(0.55) {
        let [wide, flat, side, apart, below] = draw.row("second");
        let x = x + side * apart * (wide + 6.0);
        let depth = depth + below * view.depth;
        all.push(arch(
            draw,
            [x, depth.clamp(4.0, 0.95 * view.depth)],
            [wide, wide * flat],
        ));
    }
    all
}

fn along(draw: &mut Draw, view: &View, [x, depth]: [f32; 2]) -> Outline {
    let [slope, height] = draw.row("along");
    let wave = draw.curve(height, 60.0, 9.0);
    let [step, flare, left, right, bends @ ..] = draw.row::<6>("along-ends");
    let curve = Curve::of(|t| {
        let edge = 1.0 / (1.0 + libm::expf(-(t - x) / 0.25));
        let wide = ((t - x) / 14.0).clamp(-2.0, 2.0);
        let flare = flare * (1.0 - libm::expf(-wide * wide));
        depth + slope * t + wave.at(t) + step * edge + flare
    });
    let ends = [-left, right].map(|end| end * view.reach());
    span(&curve, ends, bends)
}

fn joint(draw: &mut Draw, view: &View, [x, depth]: [f32; 2]) -> Vec<Outline> {
    let [gap] = draw.row("gap");
    let (gap, end) = (0.5 * gap, 1.1 * view.reach());
    let sides = [[-end, x - gap], [x + gap, end]].into_iter().enumerate();
    let sides = sides.map(|(side, ends)| {
        let [slope, cup] = draw.row("side");
        let wave = draw.curve(0.3, 40.0, 6.0);
        let [below, bend] = draw.row("side-end");
        let depth = depth + below * view.depth;
        let bow = |t: f32| (cup * (t - x) * (t - x)).clamp(-15.0, 15.0);
        let curve = Curve::of(|t| depth + slope * (t - x) + bow(t) + wave.at(t));
        let mut bends = [0.0; 2];
        bends[1 - side] = bend;
        span(&curve, ends, bends)
    });
    sides.collect()
}

fn row(draw: &mut Draw, view: &View, [x, depth]: [f32; 2], ribs: bool) -> Vec<Outline> {
    let [bow, number, mut wide, mut apart] = draw.row(if ribs { "ribs" } else { "row" });
    if !ribs {
        wide = wide.min(0.8 * view.reach() / number);
        apart *= 2.0 * wide;
    }
    let bones = (0..number as usize).map(|k| {
        let x = x + apart * (k as f32 - 0.5 * (number - 1.0));
        let [uneven, across, high] = draw.row(if ribs { "rib" } else { "small" });
        let top = depth + bow * x * x + uneven;
        arch(draw, [x, top], [wide * across, wide * high])
    });
    bones.collect()
}

fn laminae(draw: &mut Draw, [x, depth]: [f32; 2]) -> Vec<Outline> {
    let [apart, side, slope] = draw.row("laminae");
    let laminae = (-3..=3).map(|k| {
        let [long, bow] = draw.row("lamina");
        let (x, long) = (x + apart * k as f32, apart * long);
        let wave = draw.curve(0.2, 20.0, 4.0);
        let [top, bends @ ..] = draw.row::<3>("lamina-end");
        let straight = |t: f32| depth + top + side * slope * (t - x);
        let curve = Curve::of(|t| straight(t) + bow * (t - x) * (t - x) + wave.at(t));
        span(&curve, [x - long, x + long], bends)
    });
    laminae.collect()
}

/// A spinous process, laminae at its sides, and facets or transverse processes.
fn vertebra(draw: &mut Draw, [x, depth]: [f32; 2]) -> Vec<Outline> {
    let [deep, process @ ..] = draw.row::<3>("vertebra");
    let deep = depth + deep;
    let mut all = vec![arch(draw, [x, depth], process)];
    for side in [-1.0, 1.0] {
        let [near, far, slope, bow] = draw.row("half");
        let wave = draw.curve(0.3, 20.0, 5.0);
        let curve = Curve::of(|t| {
            let out = side * (t - x) - near;
            deep + slope * out + bow * out * out + wave.at(t)
        });
        let mut ends = [x + side * near, x + side * far];
        ends.sort_by(f32::total_cmp);
        let [left, right, with_facet] = draw.row("half-end");
        all.push(span(&curve, ends, [left, right]));
        if with_facet > 0.0 {
            let [out, wide, high, top] = draw.row("facet");
            let x = x + side * (far + out);
            all.push(arch(draw, [x, deep + top], [wide, high]));
        }
    }
    all
}
