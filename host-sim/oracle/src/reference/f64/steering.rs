//! The direction of a sub-line in f64, directly from its definition.

use bonebeam::prelude::stages::*;
use nalgebra::{Matrix2, Vector2};

/// The slope `s` and the constant `φ_c` of a sub-line's phases, by least squares.
///
/// The straight line over the element index from the centre is fitted to `φ_m = 2πf₀(‖e_m − q‖ − ‖e_m − q_δ‖)/c`, for the
/// focus points `q` of the line and `q_δ` of the sub-line. `wave` is `2πf₀/c`. For one element the slope is 0.
pub fn direction(
    array: &Array<'_>,
    active: Active,
    [line, sub_line]: [[f64; 2]; 2],
    wave: f64,
) -> [f64; 2] {
    let centre = (active.count as f64 - 1.0) / 2.0;
    let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
    for m in 0..active.count {
        let [x, z] = array.position(active.first + m);
        let distance = |[to_x, to_z]: [f64; 2]| (x - to_x).hypot(z - to_z);
        let row = Vector2::new(m as f64 - centre, 1.0);
        normal += row * row.transpose();
        right += row * (wave * (distance(line) - distance(sub_line)));
    }
    match active.count {
        0 => [0.0, 0.0],
        1 => [0.0, right.y],
        _ => {
            let solution = normal.lu().solve(&right).expect("two elements at least");
            [solution.x, solution.y]
        }
    }
}
