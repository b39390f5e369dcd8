//! Drawn B-mode pictures with labelled bone.
//!
//! A picture is drawn in the order of the physics: tissue and bone (`subject`), contact and shadows (`shadow`), echoes,
//! beam and noise (`echo`), the scanner's display (`display`) and the screen around it (`screen`). Each parameter is random
//! within a range that the physics or the variety of scanners gives. Lengths are in mm, levels in dB over speckle.

mod bone;
mod display;
mod echo;
mod labels;
mod look;
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
pub use labels::Label;
pub use look::Look;
use random::{Curve, Draw};
pub use subject::Subject;
use view::{Array, View};

/// A picture and its label.
pub struct Picture {
    /// Grey levels, `[row, column]`.
    pub pixels: Array2<u8>,
    /// What was drawn, and its bone.
    pub label: Label,
}

impl Picture {
    /// The picture of a number among those of a seed.
    pub fn of(subject: Subject, seed: u64, number: u64) -> Self {
        let draw = &mut Draw::new(seed, number);
        let view = View::drawn(draw, subject.deep());
        let outlines = subject.outlines(draw, &view);
        let (field, mut label) = field(draw, subject, &view, &outlines, &Look::ANY);
        let (screen, corner, crop) = screen::framed(draw, &field, &view);
        let corner = corner.map(|corner| corner as f32);
        for [x, y] in label.bone.iter_mut().flatten() {
            (*x, *y) = (*x + corner[0], *y + corner[1]);
        }
        label.image = format!("{number:05}.png");
        label.source = format!("bonebeam-draw, seed {seed}, picture {number}");
        label.geometry = labels::geometry(&view, corner);
        (label.crop, label.size) = (crop, [screen.ncols(), screen.nrows()]);
        let pixels = rounded(&screen);
        Picture { pixels, label }
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
        let (field, label) = field(draw, Subject::Vertebra, &view, &outlines, look);
        let pixels = rounded(&field);
        Picture { pixels, label }
    }
}

/// The field alone, NaN outside a fan, and its label.
fn field(
    draw: &mut Draw,
    subject: Subject,
    view: &View,
    outlines: &[Outline],
    look: &Look,
) -> (Array2<f32>, Label) {
    let points = outlines.iter().flatten().map(|point| point[1]);
    let highest = points.fold(view.depth, f32::min).max(2.0);
    let [most, share, height] = draw.row("skin");
    let standoff = most * share * highest;
    let bow = draw.curve(height, 120.0, 25.0);
    let skin = Curve::of(|x| (standoff + bow.at(x)).clamp(0.0, 0.6 * highest));
    let mut medium = subject.tissue(draw, view, skin, outlines);
    let enters = shadow::contact(draw, &mut medium);
    let mut sound = Sound::drawn(draw, view, look);
    if matches!(subject, Subject::Bath | Subject::Wires) {
        // Water has no echoes that hide the noise.
        [sound.noise[0]] = draw.row("water");
    }
    let [low, high] = look.0[0];
    let level = draw.within(low, high);
    let bones = outlines.iter().map(|outline| {
        let (hits, mut echo) = (bone::hits(outline, view), draw.row("bone"));
        echo[0] += level;
        Bone { hits, echo }
    });
    let bones: Vec<_> = bones.collect();
    medium.light = shadow::light(&medium, enters, &bones, sound.spread);
    let levels = sound.echoes(draw, &medium, &bones);
    let grey = display::grey(draw, &levels, view);
    let mut field = display::pixels(&grey, view);
    display::stored(draw, &mut field);
    let bone = labels::polylines(view, &bones, &sound);
    let label = Label {
        kind: ["no bone", "bone"][usize::from(subject.has_bone())],
        specimen: format!("{subject:?}"),
        pixel_mm: view.pixel,
        size: view.size,
        bone,
        ..Label::default()
    };
    (field, label)
}

/// Grey levels; black where there are none.
fn rounded(grey: &Array2<f32>) -> Array2<u8> {
    grey.mapv(|value| value.round() as u8)
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
        let subjects = Subject::MIX.into_iter();
        for (subject, number) in subjects.flat_map(|subject| [0, 1, 2].map(|k| (subject, k))) {
            let Picture { pixels, label } = Picture::of(subject, 5, number);
            assert!(subject.has_bone() || label.bone.is_empty());
            let mm = (1.0 / label.pixel_mm) as i32;
            for [x, y] in label.bone.iter().flatten() {
                assert!(x.round() >= 0.0 && y.round() >= 0.0);
                let [x, y] = [x, y].map(|v| v.round() as usize);
                assert!(x < pixels.ncols() && y < pixels.nrows());
                let at = |k: i32| pixels.get([y.checked_add_signed(k as isize)?, x]).copied();
                let near = (-mm..=mm).filter_map(|k| Some((at(k)?, k)));
                let best = near.max().expect("a pixel");
                distances.push(best.1.abs() as f32 * label.pixel_mm);
                crest.push(f32::from(pixels[[y, x]]));
                below.extend((2 * mm..4 * mm).filter_map(at).map(f32::from));
            }
        }
        distances.sort_by(f32::total_cmp);
        let mean = |values: &[f32]| values.iter().sum::<f32>() / values.len() as f32;
        let (median, crest, below) = (distances[distances.len() / 2], mean(&crest), mean(&below));
        assert!(distances.len() > 500);
        assert!(median < 0.2, "{median}");
        assert!(below < 0.5 * crest, "{below} {crest}");
    }

    #[test]
    fn a_place_is_the_inverse_of_a_point() {
        let arrays = [
            (Array::Linear, 20.0),
            (Array::Trapezoid { apex: 60.0 }, 20.0),
            (Array::Convex { radius: 40.0 }, 0.6),
        ];
        for (array, half) in arrays {
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
        let pairs = first.label.first().into_iter().zip(second.label.first());
        let apart: Vec<f32> = pairs.filter_map(|(a, b)| Some((a? - b?).abs())).collect();
        assert!(apart.len() > 100 && apart.iter().all(|apart| *apart < 10.0));
        assert!(draw(None, 1).label.first().iter().all(Option::is_none));
    }
}
