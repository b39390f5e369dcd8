//! Drawn B-mode pictures with labelled bone.
//!
//! A picture is drawn in the order of the physics: tissue and bone (`subject`), contact and shadows (`shadow`), echoes,
//! beam and noise (`echo`), the scanner's display (`display`) and the screen around it (`screen`). Each parameter is random
//! within a range that the physics or the variety of scanners gives. Lengths are in mm, levels in dB over speckle.

mod bone;
mod display;
mod echo;
pub mod labels;
mod medium;
mod random;
mod screen;
mod shadow;
mod subject;
mod tissue;
mod view;

use ndarray::Array2;

use bone::{Bone, Outline};
use echo::Sound;
use labels::Polyline;
use random::{Curve, Draw};
pub use subject::Subject;
use view::{Array, View};

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

/// Ranges that make bone clear or faint, dB.
#[derive(Debug)]
pub struct Look {
    /// Flat bone over the tissue's speckle.
    bone: [f32; 2],
    /// Noise at the skin.
    noise: [f32; 2],
    /// Fall of all echoes over the field.
    fall: [f32; 2],
}

impl Look {
    /// Bone of any kind.
    pub const ANY: Look = Look {
        bone: [6.0, 40.0],
        noise: [-78.0, -36.0],
        fall: [-2.0, 60.0],
    };
    /// Bone brighter than most of the tissue.
    pub const CLEAR: Look = Look {
        bone: [20.0, 40.0],
        noise: [-78.0, -45.0],
        fall: [-2.0, 25.0],
    };
    /// Bone from that down to what hardly differs from tissue.
    pub const FAINT: Look = Look {
        bone: [6.0, 30.0],
        noise: [-70.0, -36.0],
        fall: [5.0, 50.0],
    };
}

impl Picture {
    /// The picture of a number among those of a seed.
    pub fn of(subject: Subject, seed: u64, number: u64) -> Self {
        let draw = &mut Draw::new(seed, number);
        let view = View::drawn(draw, subject.deep());
        let outlines = subject.outlines(draw, &view);
        let (field, mut picture) = Picture::field(draw, subject, view, &outlines, &Look::ANY);
        let (screen, corner, crop) = screen::framed(draw, &field, &picture.view);
        (picture.pixels, picture.corner, picture.crop) = (rounded(&screen), corner, crop);
        let shift = corner.map(|corner| corner as f32);
        for [x, y] in picture.bone.iter_mut().chain(&mut picture.maybe).flatten() {
            (*x, *y) = (*x + shift[0], *y + shift[1]);
        }
        picture
    }

    /// The vertebra of a number, or layers alone, in a rectangle without a screen around it.
    ///
    /// `size` is in pixels: columns, rows. Pixels have a side of `pixel` mm; the first begins at the array.
    pub fn vertebra(
        look: &Look,
        bone: Option<u64>,
        seed: u64,
        size: [usize; 2],
        pixel: f32,
    ) -> Self {
        let [width, depth] = size.map(|side| side as f32 * pixel);
        let view = View::new(Array::Linear, 0.5 * width, depth, [256, 500], pixel);
        let outlines = bone.map(|bone| Subject::Vertebra.outlines(&mut Draw::new(bone, 1), &view));
        let (draw, outlines) = (&mut Draw::new(seed, 2), outlines.unwrap_or_default());
        Picture::field(draw, Subject::Vertebra, view, &outlines, look).1
    }

    /// The field alone, NaN outside a fan, and as a picture.
    fn field(
        draw: &mut Draw,
        subject: Subject,
        view: View,
        outlines: &[Outline],
        look: &Look,
    ) -> (Array2<f32>, Self) {
        let (levels, bones, sound) = scanned(draw, subject, &view, outlines, look);
        let grey = display::grey(draw, &levels, &view);
        let mut field = display::pixels(&grey, &view);
        display::stored(draw, &mut field);
        let [bone, maybe] = labels::polylines(&grey, &view, &bones, &sound);
        let picture = Picture {
            pixels: rounded(&field),
            subject,
            view,
            corner: [0, 0],
            crop: "none".into(),
            bone,
            maybe,
        };
        (field, picture)
    }
}

/// Grey levels; black where there are none.
fn rounded(grey: &Array2<f32>) -> Array2<u8> {
    grey.mapv(|value| value.round() as u8)
}

/// The echoes of a subject in dB, and its bones.
fn scanned(
    draw: &mut Draw,
    subject: Subject,
    view: &View,
    outlines: &[Outline],
    look: &Look,
) -> (Array2<f32>, Vec<Bone>, Sound) {
    let points = outlines.iter().flatten().map(|point| point[1]);
    let highest = points.fold(view.depth, f32::min).max(2.0);
    let most = if draw.chance(0.6) { 0.05 } else { 0.2 };
    let standoff = draw.within(0.0, most) * highest;
    let height = draw.within(0.0, 3.0);
    let bow = draw.curve(height, 120.0, 25.0);
    let skin = Curve::of(|x| (standoff + bow.at(x)).clamp(0.0, 0.6 * highest));
    let mut medium = subject.tissue(draw, view, &skin, outlines);
    let enters = shadow::contact(draw, &mut medium, &skin);
    let sound = Sound::drawn(draw, view, look);
    let level = draw.within(look.bone[0], look.bone[1]);
    let bones = outlines.iter().map(|outline| Bone {
        hits: bone::hits(outline, view),
        level: level + draw.within(-4.0, 4.0),
        tail: draw.log(0.1, 0.8),
        rough: draw.within(0.1, 1.0),
        fall: draw.within(3.0, 26.0),
        through: -draw.within(20.0, 90.0),
    });
    let bones: Vec<_> = bones.collect();
    let light = shadow::light(&medium, &enters, &bones, sound.spread);
    let levels = echo::echoes(draw, &sound, &medium, &light, &bones, &skin);
    (levels, bones, sound)
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
        for subject in Subject::MIX {
            for number in 0..3 {
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

    #[test]
    fn a_place_is_the_inverse_of_a_point() {
        let arrays = [
            Array::Linear,
            Array::Trapezoid { apex: 60.0 },
            Array::Convex { radius: 40.0 },
        ];
        for array in arrays {
            let half = if matches!(array, Array::Convex { .. }) {
                0.6
            } else {
                20.0
            };
            let view = View::new(array, half, 50.0, [128, 400], 0.1);
            for (line, sample) in [(0.0, 0.0), (31.5, 100.0), (127.0, 399.0)] {
                let [x, z] = view.point(line, sample);
                let again = view.place([x, z]);
                assert!((again[0] - line).abs() < 0.01 && (again[1] - sample).abs() < 0.05);
                let [column, row] = view.to_pixel([x, z]);
                let [x2, z2] = view.of_pixel(column, row);
                assert!((x - x2).abs() < 1e-3 && (z - z2).abs() < 1e-3);
            }
        }
    }

    #[test]
    fn a_vertebra_fills_its_size_and_its_bone_stays_the_same_under_other_tissue() {
        let draw = |bone, seed| Picture::vertebra(&Look::CLEAR, bone, seed, [381, 461], 0.1);
        let [first, second] = [draw(Some(1), 1), draw(Some(1), 2)];
        assert_eq!(first.pixels.dim(), (461, 381));
        assert_ne!(first.pixels, second.pixels);
        let pairs = first.first().into_iter().zip(second.first());
        let apart = pairs.filter_map(|(a, b)| Some((a? - b?).abs()));
        let apart: Vec<f32> = apart.collect();
        assert!(apart.len() > 100 && apart.iter().all(|apart| *apart < 10.0));
        assert!(draw(None, 1).first().iter().all(Option::is_none));
    }
}
