//! Tissue of the subjects: layers by the table `tissue.txt`, vessels, lesions, organs and gas.

use super::bone::{Outline, first};
use super::medium::{Layer, Medium, Oval, Streaks};
use super::random::{Curve, Draw, Patches};
use super::subject::Subject;
use super::view::View;

/// Ranges of layers and streaks.
const TABLE: &str = include_str!("tissue.txt");

/// The rows of a name: numbers, and the words after them.
fn rows(name: &str) -> impl Iterator<Item = (Vec<f32>, Vec<&'static str>)> {
    let lines = TABLE.lines().map(str::split_whitespace);
    let rows = lines.filter_map(move |mut words| {
        let own = words.next() == Some(name);
        own.then(|| words.partition::<Vec<_>, _>(|word| word.parse::<f32>().is_ok()))
    });
    rows.map(|(numbers, words)| {
        let numbers = numbers.iter().filter_map(|number| number.parse().ok());
        (numbers.collect(), words)
    })
}

/// Streaks of a name.
fn streaks(draw: &mut Draw, name: &str) -> Streaks {
    let (row, _) = rows(name).next().expect("a row of streaks");
    let mut value = |k: usize| draw.within(row[k], row[k + 1]);
    let (length, slope) = ([value(2), value(4)], [value(6), value(8)]);
    let level = [value(10), value(12)];
    let density = draw.log(row[0], row[1]);
    Streaks {
        density,
        length,
        slope,
        level,
    }
}

impl Subject {
    /// Tissue above outlines, or alone.
    pub fn tissue(self, draw: &mut Draw, view: &View, skin: &Curve, bones: &[Outline]) -> Medium {
        let mut medium = Medium::new(view);
        let points = bones.iter().flatten().map(|point| point[1]);
        let deep = points.fold(0.9 * view.depth, f32::min);
        let name = format!("{self:?}");
        let name = if rows(&name).next().is_some() {
            &name
        } else {
            "limb"
        };
        let layers = layers(draw, view, skin, bones, deep, name);
        medium.layers(draw, &layers);
        let number = match self {
            Subject::Breast => 0,
            Subject::Vessels | Subject::Liver => draw.count(2, 8),
            _ => draw.count(0, 5),
        };
        for _ in 0..number {
            let oval = vessel(draw, view, 0.9 * deep);
            medium.ellipse(draw, &oval);
        }
        self.organs(draw, &mut medium, skin, deep);
        medium
    }

    /// What a subject has beside layers and vessels.
    fn organs(self, draw: &mut Draw, medium: &mut Medium, skin: &Curve, deep: f32) {
        let (reach, depth) = (medium.view.reach(), medium.view.depth);
        let at = [
            draw.within(-0.7, 0.7) * reach,
            draw.within(0.2, 0.6) * depth,
        ];
        let loss = draw.within(6.0, 30.0);
        match self {
            Subject::Breast => {
                for _ in 0..draw.count(0, 2) {
                    let at = [
                        draw.within(-0.7, 0.7) * reach,
                        draw.within(0.2, 0.6) * depth,
                    ];
                    let wide = draw.log(2.0, 11.0);
                    let half = [wide, wide * draw.within(0.5, 1.1)];
                    let (level, loss) = (draw.within(-30.0, -8.0), draw.within(-1.0, 2.5));
                    let wall = draw.within(-5.0, 16.0);
                    medium.ellipse(
                        draw,
                        &Oval {
                            at,
                            half,
                            level,
                            wall,
                            loss,
                        },
                    );
                }
            }
            Subject::Thyroid => {
                let (x, half) = (
                    draw.sign() * draw.within(0.5, 0.9) * reach,
                    draw.within(2.5, 5.0),
                );
                let at = [x, draw.within(0.35, 0.6) * depth];
                let (level, wall) = (-30.0, draw.within(0.0, 16.0));
                medium.ellipse(
                    draw,
                    &Oval {
                        at,
                        half: [half; 2],
                        level,
                        wall,
                        loss: -0.8,
                    },
                );
                if draw.chance(0.25) {
                    let rings = |t: f32| 0.25 * depth + 0.05 * (t + x) * (t + x);
                    let span = |t: f32| {
                        if (t + x).abs() < 9.0 {
                            rings(t)
                        } else {
                            3.0 * depth
                        }
                    };
                    air(draw, medium, &Curve::of(span), skin, loss);
                }
            }
            Subject::Liver => liver(draw, medium),
            Subject::Gas => {
                let height = draw.log(0.05, 2.0);
                let wave = draw.curve(height, 40.0, 8.0);
                air(draw, medium, &Curve::of(|x| at[1] + wave.at(x)), skin, loss);
            }
            Subject::Ribs if draw.chance(0.7) => {
                let pleura = Curve::of(|x| deep + 6.0 + 0.004 * x * x);
                air(draw, medium, &pleura, skin, loss);
            }
            _ => {}
        }
    }
}

/// The layers of a name, which follow the skin and, in part, the bone.
fn layers(
    draw: &mut Draw,
    view: &View,
    skin: &Curve,
    bones: &[Outline],
    deep: f32,
    name: &str,
) -> Vec<Layer> {
    let (wide, fall) = (draw.within(4.0, 25.0), draw.within(3.0, 12.0));
    let bone = first(bones, 1.3 * view.depth).smooth(wide);
    let drape = Curve::of(|x| (bone.at(x) - deep).clamp(0.0, fall)).smooth(0.6 * wide);
    let share = draw.within(0.0, 0.9);
    let (mut down, mut layers) = (0.0, Vec::new());
    for (row, words) in rows(name) {
        for _ in 0..draw.count(row[0] as usize, row[1] as usize) {
            let mut value = |k: usize| draw.within(row[k], row[k + 1]);
            let (way, level, uneven) = (0.01 * value(2) * deep.min(40.0), value(4), value(6));
            let (bright, thickness) = (value(9), value(11));
            let (along, across) = (draw.log(row[13], row[14]), draw.log(row[15], row[16]));
            let rough = draw.log(0.04, 0.02 * deep.clamp(4.0, 30.0));
            let (wave, slope) = (draw.curve(rough, 50.0, 4.0), 0.03 * draw.normal());
            let follow = share * (down / deep).min(1.0);
            let top = |x: f32| {
                skin.at(x) + (down + wave.at(x) + slope * x + follow * drape.at(x)).max(0.05)
            };
            let top = if down == 0.0 {
                skin.clone()
            } else {
                Curve::of(top)
            };
            let streaks: Vec<_> = words
                .iter()
                .filter(|w| **w != "none")
                .map(|w| streaks(draw, w))
                .collect();
            let shear = streaks.first().map_or(0.0, |streaks| -streaks.slope[0]);
            let grain = Patches::new(draw, [along, across], shear);
            let fascia = draw.chance(0.01 * row[8]).then_some([bright, thickness]);
            layers.push(Layer {
                top,
                level,
                uneven,
                fascia,
                grain,
                streaks,
            });
            down += way.max(0.7);
        }
    }
    layers
}

/// A vessel, dark with brighter tissue below, or a tendon or nerve, which is bright.
fn vessel(draw: &mut Draw, view: &View, depth: f32) -> Oval {
    let wide = draw.log(0.8, 7.0);
    let (level, loss) = match draw.chance(0.6) {
        true => (draw.within(-35.0, -8.0), -draw.within(0.1, 1.2)),
        false => (draw.within(1.0, 9.0), draw.within(0.0, 0.5)),
    };
    Oval {
        at: [
            draw.within(-1.0, 1.0) * view.reach(),
            draw.within(0.15, 1.0) * depth,
        ],
        half: [wide, wide * draw.within(0.35, 1.0)],
        level,
        wall: draw.within(-12.0, 14.0),
        loss,
    }
}

/// A diaphragm with what is behind it, and a kidney.
fn liver(draw: &mut Draw, medium: &mut Medium) {
    let (reach, depth) = (medium.view.reach(), medium.view.depth);
    let slope = draw.normal() * 0.4;
    let (x, z) = (
        draw.within(-0.5, 0.5) * reach,
        draw.within(0.55, 0.9) * depth,
    );
    let bow = draw.within(-0.008, 0.008);
    let diaphragm = Curve::of(|t| z + slope * (t - x) + bow * (t - x) * (t - x));
    let mirror = draw.within(-25.0, -3.0);
    medium.cells(|level, [x, z]| *level += if z > diaphragm.at(x) { mirror } else { 0.0 });
    let ends = [x - draw.within(10.0, reach), x + draw.within(10.0, reach)];
    let (level, thickness) = (draw.within(10.0, 26.0), draw.within(0.6, 2.5));
    medium.curve(draw, &diaphragm, ends, level, thickness);
    if draw.chance(0.5) {
        let at = [
            draw.within(-0.5, 0.5) * reach,
            draw.within(0.4, 0.7) * depth,
        ];
        let half @ [a, b] = [draw.within(35.0, 55.0), draw.within(15.0, 25.0)];
        let (level, wall) = (draw.within(-10.0, -3.0), draw.within(4.0, 18.0));
        medium.ellipse(
            draw,
            &Oval {
                at,
                half,
                level,
                wall,
                loss: 0.0,
            },
        );
        let (level, half) = (draw.within(8.0, 16.0), [0.6 * a, 0.4 * b]);
        medium.ellipse(
            draw,
            &Oval {
                at,
                half,
                level,
                wall: -20.0,
                loss: 0.0,
            },
        );
    }
}

/// A surface of air: bright, repeated at multiples of its depth, above streaks of scattered sound.
fn air(draw: &mut Draw, medium: &mut Medium, surface: &Curve, skin: &Curve, loss: f32) {
    let reach = medium.view.reach();
    let (level, dirty) = (draw.within(8.0, 24.0), draw.within(-26.0, -6.0));
    let (fade, columns) = (draw.log(0.1, 1.5), draw.curve(5.0, 20.0, 0.8));
    let (step, view) = (medium.view.step(), medium.view.clone());
    for (at @ (sample, line), cell) in medium.level.indexed_iter_mut() {
        let [x, z] = view.point(line as f32, sample as f32);
        let far = z - surface.at(x);
        if far > 0.0 {
            *cell = dirty + columns.at(x) - fade * far + loss;
            medium.lines[at] = 0.0;
            medium.loss[at] += if far <= step { loss } else { 0.0 };
        }
    }
    for times in 0..draw.count(1, 4) {
        let again = Curve::of(|x| surface.at(x) + times as f32 * (surface.at(x) - skin.at(x)));
        let level = level - draw.within(6.0, 14.0) * times as f32;
        let hidden = if times > 0 { loss } else { 0.0 };
        medium.curve(draw, &again, [-reach, reach], level + hidden, 0.4);
    }
}
