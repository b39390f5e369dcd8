//! Bones and tissue of each subject.

use super::bone::{arch, first, span};
use super::medium::{Layer, Medium, Streaks};
use super::random::{Curve, Draw};
use super::view::View;

/// Subjects of pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Subject {
    /// A shaft across, often with a second one.
    Shafts,
    /// A surface along the array, with steps or a joint.
    Along,
    /// A joint: convex against concave ends.
    Joint,
    /// Several small bones side by side.
    Row,
    /// Ribs over the pleura.
    Ribs,
    /// Processes and laminae of a vertebra.
    Vertebra,
    /// Muscle between aponeuroses.
    Muscle,
    /// Fat lobules, ligaments and a lesion.
    Breast,
    /// A gland under thin muscles, beside vessels.
    Thyroid,
    /// Liver, diaphragm and kidney.
    Liver,
    /// Vessels in tissue.
    Vessels,
    /// Gas, or lung, under tissue.
    Gas,
}

impl Subject {
    /// All subjects.
    pub const ALL: [Subject; 12] = [
        Subject::Shafts,
        Subject::Along,
        Subject::Joint,
        Subject::Row,
        Subject::Ribs,
        Subject::Vertebra,
        Subject::Muscle,
        Subject::Breast,
        Subject::Thyroid,
        Subject::Liver,
        Subject::Vessels,
        Subject::Gas,
    ];

    /// The usual mixture: two thirds with bone.
    pub const MIX: [Subject; 21] = {
        use Subject::*;
        [
            Shafts, Muscle, Along, Vertebra, Breast, Joint, Shafts, Thyroid, Row, Along, Liver,
            Ribs, Shafts, Vessels, Joint, Vertebra, Gas, Along, Shafts, Muscle, Row,
        ]
    };

    /// Whether its pictures have bone.
    pub fn has_bone(self) -> bool {
        (self as usize) < Subject::Muscle as usize
    }

    /// The share of its views by arrays for depth.
    pub fn deep(self) -> f32 {
        match self {
            Subject::Liver => 0.9,
            Subject::Vertebra => 0.4,
            Subject::Ribs | Subject::Gas => 0.25,
            Subject::Breast | Subject::Thyroid => 0.0,
            _ => 0.08,
        }
    }

    /// The outlines of its bones, within a view.
    pub fn outlines(self, draw: &mut Draw, view: &View) -> Vec<Vec<[f32; 2]>> {
        let reach = view.reach();
        let depth = draw.log(0.1, 0.55) * view.depth;
        let x = draw.within(-0.7, 0.7) * reach;
        match self {
            Subject::Shafts => {
                let wide = draw.log(3.0, 18.0);
                let high = wide * draw.within(0.35, 1.3);
                let mut all = vec![arch(draw, [x, depth], [wide, high])];
                if draw.chance(0.5) {
                    let wide = draw.log(4.0, 18.0);
                    let high = wide * draw.within(0.3, 1.1);
                    let beside = x + draw.sign() * draw.within(0.3, 1.4) * (wide + 6.0);
                    let below = depth + draw.within(-0.1, 0.45) * view.depth;
                    all.push(arch(draw, [beside, below.max(4.0)], [wide, high]));
                }
                all
            }
            Subject::Along => {
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
                    depth
                        + slope * t
                        + wave.at(t)
                        + step * edge
                        + flare * (1.0 - libm::expf(-wide * wide))
                });
                let ends = [
                    if draw.chance(0.6) {
                        -1.1
                    } else {
                        draw.within(-0.9, -0.2)
                    },
                    if draw.chance(0.6) {
                        1.1
                    } else {
                        draw.within(0.2, 0.9)
                    },
                ];
                let bends = [draw.within(0.0, 6.0), draw.within(0.0, 6.0)];
                vec![span(&curve, ends.map(|end| end * reach), bends)]
            }
            Subject::Joint => {
                let gap = draw.log(0.6, 6.0);
                let mut side = |sign: f32, end: f32| {
                    let slope = draw.normal() * 0.25;
                    let cup = draw.within(-0.02, 0.03);
                    let wave = draw.curve(0.3, 40.0, 6.0);
                    let shift = draw.within(-0.06, 0.06) * view.depth;
                    let curve = Curve::of(|t| {
                        let far = (t - x).abs();
                        depth + shift + slope * (t - x) + (cup * far * far).min(15.0) + wave.at(t)
                    });
                    let bend = draw.log(0.4, 9.0);
                    let (ends, bends) = match sign < 0.0 {
                        true => ([end, x - 0.5 * gap], [0.0, bend]),
                        false => ([x + 0.5 * gap, end], [bend, 0.0]),
                    };
                    span(&curve, ends, bends)
                };
                vec![side(-1.0, -1.1 * reach), side(1.0, 1.1 * reach)]
            }
            Subject::Row => {
                let number = draw.count(2, 5);
                let wide = draw.log(2.0, 7.0).min(0.8 * reach / number as f32);
                let apart = 2.0 * wide * draw.within(1.05, 1.9);
                let start = x - 0.5 * apart * (number - 1) as f32;
                let bones = (0..number).map(|k| {
                    let top = [start + apart * k as f32, depth + draw.within(-2.0, 2.0)];
                    let size = [wide * draw.within(0.7, 1.2), wide * draw.within(0.2, 1.0)];
                    arch(draw, top, size)
                });
                bones.collect()
            }
            Subject::Ribs => {
                let (wide, apart) = (draw.within(3.0, 8.0), draw.within(13.0, 25.0));
                let bow = draw.within(-0.004, 0.012);
                let number = (2.0 * reach / apart) as i32 + 1;
                let bones = (-number / 2..=number / 2).map(|k| {
                    let x = 0.3 * x + apart * k as f32;
                    let high = wide * draw.within(0.25, 0.9);
                    arch(draw, [x, depth + bow * x * x], [wide, high])
                });
                bones.collect()
            }
            _ => vertebra(draw, [0.6 * x, depth]),
        }
    }

    /// Tissue above outlines, or alone.
    pub fn tissue(
        self,
        draw: &mut Draw,
        view: &View,
        skin: &Curve,
        outlines: &[Vec<[f32; 2]>],
    ) -> Medium {
        let mut medium = Medium::new(view);
        match self {
            Subject::Breast => breast(draw, &mut medium, skin),
            Subject::Thyroid => thyroid(draw, &mut medium, skin),
            Subject::Liver => liver(draw, &mut medium, skin),
            _ => limb(draw, &mut medium, skin, outlines, self),
        }
        medium
    }
}

/// Spinous process, laminae, and facets or transverse processes; or laminae along the spine.
fn vertebra(draw: &mut Draw, [x, depth]: [f32; 2]) -> Vec<Vec<[f32; 2]>> {
    if draw.chance(0.4) {
        let (apart, slope) = (
            draw.within(18.0, 34.0),
            draw.sign() * draw.within(0.05, 0.5),
        );
        let laminae = (-3..=3).map(|k| {
            let (x, long) = (x + apart * k as f32, apart * draw.within(0.3, 0.46));
            let bow = draw.within(0.0, 0.03);
            let wave = draw.curve(0.2, 20.0, 4.0);
            let top = depth + draw.within(-1.0, 1.0);
            let curve = Curve::of(|t| top + slope * (t - x) + bow * (t - x) * (t - x) + wave.at(t));
            span(
                &curve,
                [x - long, x + long],
                [draw.within(0.0, 3.0), draw.within(0.0, 3.0)],
            )
        });
        return laminae.collect();
    }
    let deep = depth + draw.within(4.0, 16.0);
    let mut all = Vec::new();
    if draw.chance(0.8) {
        let process = [draw.within(1.5, 5.0), draw.within(1.0, 6.0)];
        all.push(arch(draw, [x, depth], process));
    }
    for side in [-1.0, 1.0] {
        let (near, far) = (draw.within(1.0, 5.0), draw.within(11.0, 20.0));
        let (slope, bow) = (draw.within(-0.1, 0.7), draw.within(-0.03, 0.02));
        let wave = draw.curve(0.3, 20.0, 5.0);
        let curve = Curve::of(|t| {
            let out = side * (t - x);
            deep + slope * (out - near) + bow * (out - near) * (out - near) + wave.at(t)
        });
        let ends = [x + side * near, x + side * far];
        let ends = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        all.push(span(
            &curve,
            ends,
            [draw.within(0.0, 2.0), draw.within(0.0, 2.0)],
        ));
        if draw.chance(0.7) {
            let facet = [
                x + side * (far + draw.within(2.0, 14.0)),
                deep + draw.within(-5.0, 8.0),
            ];
            let size = [draw.within(3.0, 9.0), draw.within(1.0, 6.0)];
            all.push(arch(draw, facet, size));
        }
    }
    all
}

/// A boundary at a share of the way to a depth, with waves.
fn boundary(
    draw: &mut Draw,
    skin: &Curve,
    depth: f32,
    drape: &Curve,
    share: f32,
    rough: f32,
) -> Curve {
    let wave = draw.curve(rough, 50.0, 6.0);
    let slope = draw.normal() * 0.03;
    Curve::of(|x| {
        let down = depth + wave.at(x) + slope * x + share * drape.at(x);
        skin.at(x) + down.max(0.05)
    })
}

fn skin_layer(draw: &mut Draw, skin: &Curve) -> Layer {
    let level = draw.within(0.0, 9.0);
    let line = draw.within(8.0, 24.0);
    Layer {
        top: skin.clone(),
        level,
        uneven: draw.within(0.0, 2.0),
        fascia: draw.chance(0.8).then(|| [line, draw.log(0.1, 0.5)]),
        streaks: vec![],
    }
}

fn septa(draw: &mut Draw) -> Streaks {
    Streaks {
        density: draw.log(2.0, 25.0),
        length: [2.0, draw.within(6.0, 25.0)],
        slope: [0.0, draw.within(0.03, 0.25)],
        level: [draw.within(-2.0, 6.0), draw.within(8.0, 20.0)],
    }
}

fn fibres(draw: &mut Draw) -> Vec<Streaks> {
    let along = draw.chance(0.6);
    let slope = if along { draw.within(-0.45, 0.45) } else { 0.0 };
    let many = Streaks {
        density: draw.log(10.0, 150.0),
        length: if along {
            [3.0, draw.within(8.0, 30.0)]
        } else {
            [0.6, draw.within(2.0, 6.0)]
        },
        slope: [
            slope,
            if along {
                draw.within(0.01, 0.12)
            } else {
                draw.within(0.1, 0.4)
            },
        ],
        level: [draw.within(-6.0, 2.0), draw.within(5.0, 17.0)],
    };
    let mut all = vec![many];
    if draw.chance(0.5) {
        let few = Streaks {
            density: draw.log(0.5, 6.0),
            length: [5.0, 30.0],
            slope: [slope, draw.within(0.05, 0.4)],
            level: [5.0, 20.0],
        };
        all.push(few);
    }
    all
}

/// Skin, fat, and muscles with fasciae; tendons and vessels; gas if it is the subject.
fn limb(
    draw: &mut Draw,
    medium: &mut Medium,
    skin: &Curve,
    outlines: &[Vec<[f32; 2]>],
    subject: Subject,
) {
    let depth = medium.view.depth;
    let bone = first(outlines, 1.3 * depth);
    let deepest = outlines
        .iter()
        .flatten()
        .map(|p| p[1])
        .fold(f32::MAX, f32::min)
        .min(0.9 * depth);
    let smooth = bone.smooth(draw.within(4.0, 25.0));
    let fall = draw.within(3.0, 12.0);
    let drape = Curve::of(|x| (smooth.at(x) - deepest).min(fall));
    let drape = drape.smooth(draw.within(4.0, 12.0));
    let share = draw.within(0.0, 0.9);
    let mut layers = vec![skin_layer(draw, skin)];
    let mut down = draw.within(0.8, 2.6);
    let thick = draw.log(0.05, 0.5) * deepest;
    let dark = draw.within(-16.0, -2.0);
    layers.push(Layer {
        top: boundary(draw, skin, down, &drape, 0.0, 0.05),
        level: dark,
        uneven: draw.within(0.5, 6.0),
        fascia: draw
            .chance(0.3)
            .then(|| [draw.within(-2.0, 12.0), draw.log(0.1, 0.4)]),
        streaks: vec![septa(draw)],
    });
    down += thick;
    let muscle = subject == Subject::Muscle;
    let base = draw.within(-12.0, 2.0);
    for k in 0..draw.count(1, if muscle { 3 } else { 4 }) {
        let at = share * (down / deepest.max(1.0)).min(1.0);
        let bright = if muscle {
            draw.within(8.0, 24.0)
        } else {
            draw.within(-6.0, 22.0)
        };
        let deep = if muscle && k > 0 {
            draw.within(-20.0, 0.0)
        } else {
            draw.within(-9.0, 5.0)
        };
        let thickness = if muscle {
            draw.log(0.2, 1.5)
        } else {
            draw.log(0.1, 0.9)
        };
        layers.push(Layer {
            top: boundary(draw, skin, down, &drape, at, 0.6),
            level: base + deep,
            uneven: draw.within(0.5, 6.0),
            fascia: draw.chance(0.85).then_some([bright, thickness]),
            streaks: fibres(draw),
        });
        let rest = if muscle {
            0.6 * depth
        } else {
            (deepest - down).max(2.0)
        };
        down += (draw.within(0.2, 0.8) * rest).max(1.5);
    }
    medium.layers(draw, &layers);
    let vessels = if subject == Subject::Vessels {
        draw.count(2, 5)
    } else {
        draw.count(0, 3)
    };
    ovals(draw, medium, vessels, deepest);
    if subject == Subject::Gas {
        gas(draw, medium, skin);
    }
    if subject == Subject::Ribs && draw.chance(0.7) {
        let pleura = Curve::of(|x| deepest + 6.0 + 0.004 * x * x);
        let loss = draw.within(8.0, 25.0);
        air(draw, medium, &pleura, skin, loss);
    }
}

/// Vessels that are dark with brighter tissue below, and tendons or nerves that are bright.
fn ovals(draw: &mut Draw, medium: &mut Medium, number: usize, depth: f32) {
    for _ in 0..number {
        let x = draw.within(-1.0, 1.0) * medium.view.reach();
        let z = draw.within(0.15, 0.95) * depth;
        let a = draw.log(0.8, 7.0);
        let b = a * draw.within(0.35, 1.0);
        let (level, loss) = match draw.chance(0.6) {
            true => (draw.within(-35.0, -10.0), -draw.within(0.2, 1.5)),
            false => (draw.within(1.0, 9.0), draw.within(0.0, 0.5)),
        };
        let wall = draw.within(-12.0, 14.0);
        medium.ellipse(draw, [x, z], [a, b], level, wall, loss);
    }
}

/// Gas in the bowel, or lung, behind a bright surface.
fn gas(draw: &mut Draw, medium: &mut Medium, skin: &Curve) {
    let depth = draw.within(0.15, 0.5) * medium.view.depth;
    let height = draw.log(0.05, 2.0);
    let wave = draw.curve(height, 40.0, 8.0);
    let surface = Curve::of(|x| depth + wave.at(x));
    let loss = draw.within(6.0, 30.0);
    air(draw, medium, &surface, skin, loss);
}

/// A surface of air: bright, repeated at multiples of its depth, with streaks of scattered sound below.
fn air(draw: &mut Draw, medium: &mut Medium, surface: &Curve, skin: &Curve, loss: f32) {
    let reach = medium.view.reach();
    let (level, dirty) = (draw.within(10.0, 26.0), draw.within(-22.0, -4.0));
    let fade = draw.log(0.1, 1.5);
    let columns = draw.curve(5.0, 20.0, 0.8);
    let step = medium.view.step();
    let view = medium.view.clone();
    for ((sample, line), cell) in medium.level.indexed_iter_mut() {
        let [x, z] = view.point(line as f32, sample as f32);
        let far = z - surface.at(x);
        if far > 0.0 {
            *cell = dirty + columns.at(x) - fade * far + loss;
            medium.lines[[sample, line]] = 0.0;
        }
        if far > 0.0 && far <= step {
            medium.loss[[sample, line]] += loss;
        }
    }
    for times in 1..=draw.count(1, 4) {
        let again =
            Curve::of(|x| surface.at(x) + (times - 1) as f32 * (surface.at(x) - skin.at(x)));
        let level = level - draw.within(6.0, 14.0) * (times - 1) as f32;
        let hidden = if times > 1 { loss } else { 0.0 };
        medium.curve(draw, &again, [-reach, reach], level + hidden, 0.4);
    }
}

fn breast(draw: &mut Draw, medium: &mut Medium, skin: &Curve) {
    let (reach, depth) = (medium.view.reach(), medium.view.depth);
    let flat = Curve::of(|_| 0.0);
    let fat = draw.within(-14.0, -4.0);
    let gland = draw.within(-4.0, 6.0);
    let layer = |top, level, streaks| Layer {
        top,
        level,
        uneven: 5.0,
        fascia: None,
        streaks,
    };
    let ligaments = |draw: &mut Draw| Streaks {
        density: draw.log(2.0, 14.0),
        length: [4.0, 30.0],
        slope: [0.0, draw.within(0.1, 0.5)],
        level: [8.0, 24.0],
    };
    let mut layers = vec![skin_layer(draw, skin)];
    for (share, level) in [
        (0.05, fat),
        (draw.within(0.15, 0.4), gland),
        (draw.within(0.55, 0.9), fat),
    ] {
        let top = boundary(draw, skin, share * depth, &flat, 0.0, 1.5);
        layers.push(layer(top, level, vec![ligaments(draw), septa(draw)]));
    }
    layers[3].fascia = Some([draw.within(6.0, 20.0), draw.log(0.2, 1.0)]);
    medium.layers(draw, &layers);
    for _ in 0..draw.count(0, 2) {
        let centre = [
            draw.within(-0.7, 0.7) * reach,
            draw.within(0.2, 0.6) * depth,
        ];
        let a = draw.log(2.0, 11.0);
        let b = a * draw.within(0.5, 1.1);
        let (level, loss) = (draw.within(-30.0, -8.0), draw.within(-1.0, 2.5));
        let wall = draw.within(-5.0, 16.0);
        medium.ellipse(draw, centre, [a, b], level, wall, loss);
    }
}

fn thyroid(draw: &mut Draw, medium: &mut Medium, skin: &Curve) {
    let (reach, depth) = (medium.view.reach(), medium.view.depth);
    let flat = Curve::of(|_| 0.0);
    let mut layers = vec![skin_layer(draw, skin)];
    for (share, low, high) in [
        (0.06, -12.0, -4.0),
        (0.14, -16.0, -6.0),
        (0.25, -2.0, 5.0),
        (0.75, -14.0, -3.0),
    ] {
        let share = share * depth * draw.within(0.8, 1.3);
        let top = boundary(draw, skin, share, &flat, 0.0, 1.0);
        let gland = low == -2.0;
        layers.push(Layer {
            top,
            level: draw.within(low, high),
            uneven: if gland { draw.within(0.0, 2.0) } else { 4.0 },
            fascia: Some([draw.within(2.0, 18.0), draw.log(0.1, 0.6)]),
            streaks: if gland { vec![] } else { fibres(draw) },
        });
    }
    medium.layers(draw, &layers);
    let artery = [
        draw.sign() * draw.within(0.5, 0.9) * reach,
        draw.within(0.35, 0.6) * depth,
    ];
    let half = draw.within(2.5, 5.0);
    let wall = draw.within(0.0, 16.0);
    medium.ellipse(draw, artery, [half, half], -30.0, wall, -0.8);
    ovals(draw, medium, 2, 0.7 * depth);
    if draw.chance(0.4) {
        let x = -artery[0];
        let trachea = Curve::of(|t| 0.25 * depth + 0.05 * (t - x) * (t - x));
        let span = Curve::of(|t| {
            if (t - x).abs() < 9.0 {
                trachea.at(t)
            } else {
                3.0 * depth
            }
        });
        let loss = draw.within(10.0, 25.0);
        air(draw, medium, &span, skin, loss);
    }
}

fn liver(draw: &mut Draw, medium: &mut Medium, skin: &Curve) {
    let (reach, depth) = (medium.view.reach(), medium.view.depth);
    let flat = Curve::of(|_| 0.0);
    let mut layers = vec![skin_layer(draw, skin)];
    for (down, low, high) in [(2.0, -12.0, 0.0), (9.0, -12.0, 0.0), (22.0, -4.0, 3.0)] {
        let liver = down == 22.0;
        let down = down * draw.within(0.7, 1.2);
        layers.push(Layer {
            top: boundary(draw, skin, down, &flat, 0.0, 1.0),
            level: draw.within(low, high),
            uneven: if liver { draw.within(0.0, 2.0) } else { 5.0 },
            fascia: Some([draw.within(4.0, 18.0), draw.log(0.2, 1.0)]),
            streaks: if liver { vec![] } else { vec![septa(draw)] },
        });
    }
    medium.layers(draw, &layers);
    let number = draw.count(2, 9);
    ovals(draw, medium, number, 0.8 * depth);
    let slope = draw.normal() * 0.4;
    let (x, z) = (
        draw.within(-0.5, 0.5) * reach,
        draw.within(0.55, 0.9) * depth,
    );
    let bow = draw.within(-0.008, 0.008);
    let diaphragm = Curve::of(|t| z + slope * (t - x) + bow * (t - x) * (t - x));
    let mirror = draw.within(-25.0, -3.0);
    medium.cells(|level, [x, z]| {
        if z > diaphragm.at(x) {
            *level += mirror;
        }
    });
    let ends = [x - draw.within(10.0, reach), x + draw.within(10.0, reach)];
    let (level, thickness) = (draw.within(12.0, 28.0), draw.within(0.6, 2.5));
    medium.curve(draw, &diaphragm, ends, level, thickness);
    if draw.chance(0.5) {
        let centre = [
            draw.within(-0.5, 0.5) * reach,
            draw.within(0.4, 0.7) * depth,
        ];
        let (a, b) = (draw.within(35.0, 55.0), draw.within(15.0, 25.0));
        let (cortex, wall, sinus) = (
            draw.within(-10.0, -3.0),
            draw.within(8.0, 22.0),
            draw.within(8.0, 16.0),
        );
        medium.ellipse(draw, centre, [a, b], cortex, wall, 0.0);
        medium.ellipse(draw, centre, [0.6 * a, 0.4 * b], sinus, -20.0, 0.0);
    }
}
