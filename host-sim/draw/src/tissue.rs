//! Tissue of the subjects: layers by the table of ranges, vessels, lesions, organs and gas.

use super::bone::{Outline, first};
use super::medium::{Layer, Medium};
use super::random::{Curve, Draw, Patches, mix, rows};
use super::subject::Subject;
use super::view::View;

impl Subject {
    /// Tissue above outlines, or alone.
    pub fn tissue(self, draw: &mut Draw, view: &View, skin: Curve, bones: &[Outline]) -> Medium {
        let mut medium = Medium::new(view, skin);
        let points = bones.iter().flatten().map(|point| point[1]);
        let deep = points.fold(0.9 * view.depth, f32::min);
        let layers = self.layers(draw, &medium, bones, deep);
        medium.layers(draw, &layers);
        let number = match self {
            Subject::Breast | Subject::Bath | Subject::Wires => 0,
            Subject::Vessels | Subject::Liver => draw.count(2, 8),
            _ => draw.count(0, 5),
        };
        for _ in 0..number {
            // Dark with brighter tissue below, or a tendon or nerve, which is bright.
            let [wide, dark] = draw.row("vessel");
            let row = draw.row(if dark > 0.0 { "dark" } else { "bright" });
            let [level, loss, x, z, flat, wall] = row;
            let at = [x * view.reach(), z * (0.9 * deep)];
            medium.ellipse(draw, at, [wide, wide * flat], [level, wall, loss]);
        }
        self.organs(draw, &mut medium, deep);
        medium
    }

    /// Layers, which follow the skin and, in part, the bone.
    fn layers(self, draw: &mut Draw, medium: &Medium, bones: &[Outline], deep: f32) -> Vec<Layer> {
        let skin = &medium.skin;
        let [wide, fall, share] = draw.row("drape");
        let bone = first(bones, 1.3 * medium.view.depth).smooth(wide);
        let drape = Curve::of(|x| (bone.at(x) - deep).clamp(0.0, fall)).smooth(0.6 * wide);
        let mut own: Vec<_> = rows(&format!("{self:?}")).collect();
        if own.is_empty() {
            own = rows("limb").collect();
        }
        let (mut down, mut layers) = (0.0, Vec::new());
        for row in own {
            let (ranges, streaks) = row.split_first_chunk::<9>().expect("a layer");
            let [number, ranges @ ..] = *ranges;
            let [number] = draw.values([number]);
            for _ in 0..number as usize {
                let values = draw.values(ranges);
                let [way, level, uneven, bright, thickness, along, across, chance] = values;
                let rough = draw.log(0.04, 0.02 * deep.clamp(4.0, 30.0));
                let (wave, slope) = (draw.curve(rough, 50.0, 4.0), 0.03 * draw.normal());
                let follow = share * (down / deep).min(1.0);
                let lower = |x| down + wave.at(x) + slope * x + follow * drape.at(x);
                let top = match down {
                    0.0 => skin.clone(),
                    _ => Curve::of(|x| skin.at(x) + lower(x).max(0.05)),
                };
                let streaks: Vec<_> = streaks.iter().map(|name| draw.row(name)).collect();
                let shear = streaks.first().map_or(0.0, |streaks| -streaks[2]);
                let grain = Patches::new(draw, [along, across], shear);
                let fascia = draw.chance(0.01 * chance).then_some([bright, thickness]);
                layers.push(Layer {
                    top,
                    level,
                    uneven,
                    fascia,
                    grain,
                    streaks,
                });
                down += (0.01 * way * deep.min(40.0)).max(0.7);
            }
        }
        layers
    }

    /// What a subject has beside layers and vessels.
    fn organs(self, draw: &mut Draw, medium: &mut Medium, deep: f32) {
        let (reach, depth) = (medium.view.reach(), medium.view.depth);
        let [_, z, loss] = draw.row("organ");
        match self {
            Subject::Breast => {
                for _ in 0..draw.count(0, 2) {
                    let [x, z, wide, flat, level, loss, wall] = draw.row("lesion");
                    let (at, half) = ([x * reach, z * depth], [wide, wide * flat]);
                    medium.ellipse(draw, at, half, [level, wall, loss]);
                }
            }
            Subject::Thyroid => {
                let [side, x, half, z, wall] = draw.row("artery");
                let x = side * x * reach;
                medium.ellipse(draw, [x, z * depth], [half; 2], [-30.0, wall, -0.8]);
                if draw.chance(0.25) {
                    let trachea = Curve::of(|t| match t + x {
                        far if far.abs() < 9.0 => 0.25 * depth + 0.05 * far * far,
                        _ => 3.0 * depth,
                    });
                    air(draw, medium, &trachea, loss);
                }
            }
            Subject::Liver => liver(draw, medium),
            Subject::Gas => {
                let [height] = draw.row("gas");
                let wave = draw.curve(height, 40.0, 8.0);
                let surface = Curve::of(|x| z * depth + wave.at(x));
                air(draw, medium, &surface, loss);
            }
            Subject::Wires => {
                for _ in 0..draw.count(1, 12) {
                    let [x, z, wide, level, thickness] = draw.row("wire");
                    let (x, flat) = (x * reach, Curve::of(|_| z * depth));
                    medium.curve(draw, &flat, [x, x + wide], [level, thickness]);
                }
            }
            Subject::Ribs if draw.chance(0.7) => {
                let pleura = Curve::of(|x| deep + 6.0 + 0.004 * x * x);
                air(draw, medium, &pleura, loss);
            }
            _ => {}
        }
    }
}

/// A diaphragm with what is behind it, and a kidney.
fn liver(draw: &mut Draw, medium: &mut Medium) {
    let (reach, depth) = (medium.view.reach(), medium.view.depth);
    let [slope, x, z, bow, mirror, left, right, level, thickness] = draw.row("diaphragm");
    let (x, z) = (x * reach, z * depth);
    let diaphragm = Curve::of(|t| z + slope * (t - x) + bow * (t - x) * (t - x));
    medium.cells(|[x, z], [level, ..]| *level += if z > diaphragm.at(x) { mirror } else { 0.0 });
    let [left, right] = [left, right].map(|share| mix(10.0, reach, share));
    medium.curve(draw, &diaphragm, [x - left, x + right], [level, thickness]);
    if draw.chance(0.5) {
        let [x, z, a, b, level, wall] = draw.row("kidney");
        let at = [x * reach, z * depth];
        medium.ellipse(draw, at, [a, b], [level, wall, 0.0]);
        let [level] = draw.row("sinus");
        medium.ellipse(draw, at, [0.6 * a, 0.4 * b], [level, -20.0, 0.0]);
    }
}

/// A surface of air: bright, repeated at multiples of its depth, above streaks of scattered sound.
fn air(draw: &mut Draw, medium: &mut Medium, surface: &Curve, loss: f32) {
    let (reach, step) = (medium.view.reach(), medium.view.step());
    let [level, dirty, fade] = draw.row("air");
    let columns = draw.curve(5.0, 20.0, 0.8);
    medium.cells(|[x, z], [level, lines, lost]| {
        let far = z - surface.at(x);
        if far > 0.0 {
            *level = dirty + columns.at(x) - fade * far + loss;
            *lines = 0.0;
            *lost += if far <= step { loss } else { 0.0 };
        }
    });
    for times in 0..draw.count(1, 4) {
        let deep = |x| surface.at(x) - medium.skin.at(x);
        let again = Curve::of(|x| surface.at(x) + times as f32 * deep(x));
        let level = level - draw.within(6.0, 14.0) * times as f32;
        let hidden = if times > 0 { loss } else { 0.0 };
        medium.curve(draw, &again, [-reach, reach], [level + hidden, 0.4]);
    }
}
