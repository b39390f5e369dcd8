//! Drawn B-mode pictures with labelled bone.
//!
//! A picture is drawn in the order of the physics: tissue and bone (`subject`), contact, shadows, echoes, beam and
//! noise (`echo`), the scanner's display (`display`) and the screen around it (`screen`). Each parameter is random
//! within a range that the physics or the variety of scanners gives. Lengths are in mm, levels in dB over speckle.

mod bone;
mod display;
mod echo;
pub mod labels;
mod medium;
mod random;
mod screen;
mod subject;
mod view;

use ndarray::Array2;

use bone::Bone;
use echo::Sound;
use labels::Polyline;
use random::{Curve, Draw};
pub use subject::Subject;
use view::View;

/// A picture and its bone.
pub struct Picture {
    /// Grey levels, `[row, column]`.
    pub pixels: Array2<u8>,
    /// What was drawn.
    pub subject: Subject,
    view: View,
    corner: [usize; 2],
    /// Where marks of the screen are.
    pub crop: String,
    /// Crests of bone that is seen, in pixels.
    pub bone: Vec<Polyline>,
    /// Crests of bone that is hardly seen, or not.
    pub maybe: Vec<Polyline>,
}

impl Picture {
    /// The picture of a number among those of a seed.
    pub fn of(subject: Subject, seed: u64, number: u64) -> Self {
        let draw = &mut Draw::new(seed, number);
        let view = View::drawn(draw, subject.deep());
        let outlines = if subject.has_bone() {
            subject.outlines(draw, &view)
        } else {
            Vec::new()
        };
        let (levels, bones, sound) = scanned(draw, subject, &view, outlines);
        let grey = display::grey(draw, &levels, &view);
        let mut field = display::pixels(&grey, &view);
        let black = field.map(|value| value.is_nan());
        field.mapv_inplace(|value| if value.is_nan() { 0.0 } else { value });
        display::stored(draw, &mut field);
        field.zip_mut_with(&black, |value, black| {
            *value = if *black { f32::NAN } else { *value }
        });
        let (screen, corner, crop) = screen::framed(draw, &field, &view);
        let [bone, maybe] = labels::polylines(&grey, &view, &bones, &sound, corner);
        Picture {
            pixels: screen.mapv(|value| value.round() as u8),
            subject,
            view,
            corner,
            crop,
            bone,
            maybe,
        }
    }
}

/// The echoes of a subject in dB, and its bones with their hits.
fn scanned(
    draw: &mut Draw,
    subject: Subject,
    view: &View,
    outlines: Vec<Vec<[f32; 2]>>,
) -> (Array2<f32>, Vec<Bone>, Sound) {
    let highest = outlines
        .iter()
        .flatten()
        .map(|point| point[1])
        .fold(view.depth, f32::min);
    let standoff = if draw.chance(0.6) {
        draw.within(0.0, 0.05)
    } else {
        draw.within(0.0, 0.2)
    } * highest.max(2.0);
    let height = draw.within(0.0, 3.0);
    let bow = draw.curve(height, 120.0, 25.0);
    let skin = Curve::of(|x| (standoff + bow.at(x)).clamp(0.0, 0.6 * highest.max(1.0)));
    let mut medium = subject.tissue(draw, view, &skin, &outlines);
    let enters = echo::contact(draw, &mut medium, &skin);
    let sound = Sound::drawn(draw, view);
    let level = draw.within(4.0, 32.0);
    let bones: Vec<_> = outlines
        .iter()
        .map(|outline| bone_of(draw, view, outline, level))
        .collect();
    let light = echo::light(&medium, &enters, &bones, sound.spread);
    (
        echo::echoes(draw, &sound, &medium, &light, &bones, &skin),
        bones,
        sound,
    )
}

fn bone_of(draw: &mut Draw, view: &View, outline: &[[f32; 2]], level: f32) -> Bone {
    Bone {
        hits: bone::hits(outline, view),
        level: level + draw.within(-4.0, 4.0),
        tail: draw.log(0.05, 0.5),
        rough: draw.within(0.1, 1.0),
        fall: draw.within(3.0, 26.0),
        through: -draw.within(18.0, 75.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_seed_gives_the_same_picture_and_another_does_not() {
        let pixels = |seed, number| Picture::of(Subject::Shafts, seed, number).pixels;
        assert_eq!(pixels(3, 1), pixels(3, 1));
        assert_ne!(pixels(3, 1), pixels(3, 2));
        assert_ne!(pixels(3, 1), pixels(4, 1));
    }

    /// Grey levels of all pictures' labels: at the crest, the distance to the brightest within 1 mm, and 2 to 4 mm below.
    #[test]
    fn labels_lie_on_a_crest_above_a_shadow_and_pictures_without_bone_have_none() {
        let (mut distances, mut crest, mut below) = (Vec::new(), Vec::new(), Vec::new());
        for subject in Subject::ALL {
            for number in 0..6 {
                let picture = Picture::of(subject, 5, number);
                assert!(subject.has_bone() || picture.bone.len() + picture.maybe.len() == 0);
                let mm = 1.0 / picture.view.pixel;
                let (rows, columns) = picture.pixels.dim();
                for [x, y] in picture.bone.iter().flatten() {
                    let (x, y) = (x.round() as usize, y.round());
                    assert!(x < columns && y >= 0.0 && (y as usize) < rows);
                    let at =
                        |row: f32| picture.pixels.get([row as usize, x]).map(|v| f32::from(*v));
                    let near =
                        (-(mm as i32)..=mm as i32).filter_map(|k| Some((at(y + k as f32)?, k)));
                    let best = near.max_by(|a, b| a.0.total_cmp(&b.0)).expect("a pixel");
                    distances.push(best.1.abs() as f32 / mm);
                    crest.extend(at(y));
                    below.extend((2 * mm as i32..4 * mm as i32).filter_map(|k| at(y + k as f32)));
                }
            }
        }
        distances.sort_by(f32::total_cmp);
        let mean = |values: &[f32]| values.iter().sum::<f32>() / values.len() as f32;
        assert!(distances.len() > 500);
        assert!(
            distances[distances.len() / 2] < 0.2,
            "{}",
            distances[distances.len() / 2]
        );
        assert!(
            mean(&below) < 0.5 * mean(&crest),
            "{} {}",
            mean(&below),
            mean(&crest)
        );
    }
}
