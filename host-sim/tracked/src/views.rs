//! A picture of a cloud from three sides.

use ndarray::Array2;

use crate::cloud::CloudPoint;

/// Side of a view, pixels, and the margin around its points.
const SIDE: usize = 640;
const MARGIN: usize = 24;
/// Colours of a sure point and of a doubtful one.
const SURE: [f32; 3] = [255.0, 170.0, 40.0];
const DOUBTFUL: [f32; 3] = [60.0, 90.0, 255.0];
const GREY: [u8; 3] = [110; 3];

/// Draws points from three sides, with a bar of 10 mm.
///
/// From left to right: x and y, x and z, y and z, the second axis upwards. All views have one scale. Surer points are drawn over doubtful ones.
pub fn views(points: &[CloudPoint]) -> Array2<[u8; 3]> {
    let mut picture = Array2::from_elem((SIDE, 3 * SIDE), [16u8; 3]);
    let ends: [[f64; 2]; 3] = std::array::from_fn(|axis| {
        let values = points.iter().map(|point| point.position[axis]);
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], x| {
            [least.min(x), most.max(x)]
        })
    });
    let width = ends
        .iter()
        .map(|[least, most]| most - least)
        .fold(1.0, f64::max);
    let scale = (SIDE - 2 * MARGIN) as f64 / width;
    let mut order: Vec<&CloudPoint> = points.iter().collect();
    order.sort_by(|a, b| a.confidence.total_cmp(&b.confidence));
    for (view, [right, up]) in [[0, 1], [0, 2], [1, 2]].into_iter().enumerate() {
        let left = view * SIDE;
        let mut fill = |[x, y]: [f64; 2], sides: [usize; 2], colour: [u8; 3]| {
            // The cast saturates.
            let [x, y] = [x.round() as usize, y.round() as usize];
            for row in y..(y + sides[1]).min(SIDE) {
                for column in x..(x + sides[0]).min(SIDE) {
                    picture[[row, left + column]] = colour;
                }
            }
        };
        for point in &order {
            let place = |axis: usize| {
                let [least, most] = ends[axis];
                scale * (point.position[axis] - (least + most) / 2.0)
            };
            let middle = SIDE as f64 / 2.0;
            let colour = std::array::from_fn(|k| {
                (DOUBTFUL[k] + (SURE[k] - DOUBTFUL[k]) * point.confidence + 0.5) as u8
            });
            fill([middle + place(right), middle - place(up)], [2, 2], colour);
        }
        fill([0.0, 0.0], [1, SIDE], GREY);
        fill(
            [MARGIN as f64, (SIDE - MARGIN / 2) as f64],
            [(10.0 * scale) as usize, 3],
            GREY,
        );
    }
    picture
}
