//! The part of a screen that is the picture.

use std::collections::VecDeque;

use ndarray::{Array2, ArrayView2, Axis};

/// Largest distance of grey levels from the background's, of 255.
///
/// Compression leaves some grey beside letters and edges.
const BLACK: f32 = 8.0;
/// Side of the blocks in which connected parts are found, pixels, and the pixels that fill one.
///
/// Smaller gaps do not split the picture.
const BLOCK: usize = 4;
const FILLED: usize = 6;
/// Thickness that lines of a frame do not reach, pixels, and their shortest length, as a share of the picture's side.
const THIN: usize = 3;
const LONG: f64 = 0.4;

/// The pixels of a screen that are not background, without thin lines, and their blocks.
pub(super) struct Lit {
    pixels: Array2<bool>,
    blocks: Array2<bool>,
}

impl Lit {
    pub fn of(pixels: ArrayView2<f32>) -> Self {
        let (rows, columns) = pixels.dim();
        let background = background(pixels);
        let lit = pixels.mapv(|level| (level - background).abs() > BLACK);
        let pixels = without_frame(&lit);
        let mut counts = Array2::from_elem((rows.div_ceil(BLOCK), columns.div_ceil(BLOCK)), 0);
        for ((row, column), lit) in pixels.indexed_iter() {
            counts[[row / BLOCK, column / BLOCK]] += usize::from(*lit);
        }
        let blocks = counts.mapv(|count| count >= FILLED);
        Lit { pixels, blocks }
    }

    /// The pixels of the largest connected part.
    ///
    /// What is not wider than twice `margin` blocks is left out, as letters are that touch the picture.
    pub fn largest_part(&self, margin: usize) -> Array2<bool> {
        let mut filled = self.blocks.clone();
        for _ in 0..margin {
            filled = of_around(&filled, true);
        }
        // The numbers of parts, 0 for none.
        let mut parts = Array2::from_elem(filled.dim(), 0usize);
        let mut sizes = vec![0];
        for (start, _) in filled.indexed_iter().filter(|(_, filled)| **filled) {
            if parts[start] != 0 {
                continue;
            }
            let name = sizes.len();
            let mut size = 0;
            parts[start] = name;
            let mut left = VecDeque::from([start]);
            while let Some((row, column)) = left.pop_front() {
                size += 1;
                for beside in (row.saturating_sub(1)..=row + 1)
                    .flat_map(|r| (column.saturating_sub(1)..=column + 1).map(move |c| (r, c)))
                {
                    if filled.get(beside) == Some(&true) && parts[beside] == 0 {
                        parts[beside] = name;
                        left.push_back(beside);
                    }
                }
            }
            sizes.push(size);
        }
        let largest = (1..sizes.len()).max_by_key(|&name| sizes[name]);
        let mut part = parts.mapv(|name| Some(name) == largest);
        // Also the blocks beside it, of which it fills a part.
        for _ in 0..margin.max(1) {
            part = of_around(&part, false);
        }
        Array2::from_shape_fn(self.pixels.dim(), |(row, column)| {
            self.pixels[[row, column]] && part[[row / BLOCK, column / BLOCK]]
        })
    }
}

/// Whether every place, or any, is true of each with those around it.
fn of_around(blocks: &Array2<bool>, every: bool) -> Array2<bool> {
    let (rows, columns) = blocks.dim();
    Array2::from_shape_fn((rows, columns), |(row, column)| {
        let [rows, columns] = [(row, rows), (column, columns)]
            .map(|(at, count)| at.saturating_sub(1)..(at + 2).min(count));
        let mut all = rows.flat_map(|r| columns.clone().map(move |c| blocks[[r, c]]));
        match every {
            true => all.all(|inside| inside),
            false => all.any(|inside| inside),
        }
    })
}

/// Without thin straight lines along rows and columns, as a frame around the picture has.
fn without_frame(lit: &Array2<bool>) -> Array2<bool> {
    let mut rest = lit.clone();
    for axis in [0, 1] {
        let lit = if axis == 0 { lit.view() } else { lit.t() };
        let mut rest = if axis == 0 {
            rest.view_mut()
        } else {
            rest.view_mut().reversed_axes()
        };
        let (rows, length) = lit.dim();
        for row in 0..rows {
            let beside = [
                row.checked_sub(THIN),
                Some(row + THIN).filter(|r| *r < rows),
            ];
            let mut start = 0;
            for end in 0..=length {
                if end < length && lit[[row, end]] {
                    continue;
                }
                let dark = |column: &usize| {
                    let of = |r: &usize| lit[[*r, *column]];
                    !beside.iter().flatten().any(of)
                };
                let long = (end - start) as f64 >= LONG * length as f64;
                let run = start..end;
                if long && run.clone().filter(dark).count() * 3 >= run.len() * 2 {
                    run.for_each(|column| rest[[row, column]] = false);
                }
                start = end + 1;
            }
        }
    }
    rest
}

/// The level of the corners if they agree, else black.
fn background(pixels: ArrayView2<f32>) -> f32 {
    let [rows, columns] = [0, 1].map(|axis| {
        let length = pixels.len_of(Axis(axis));
        [2..10, length.saturating_sub(10)..length.saturating_sub(2)]
    });
    let corners = rows
        .iter()
        .flat_map(|r| columns.iter().map(move |c| (r, c)));
    let corners = corners.map(|(rows, columns)| {
        let all = rows
            .clone()
            .flat_map(|r| columns.clone().map(move |c| [r, c]));
        let mut levels: Vec<f32> = all.filter_map(|at| pixels.get(at).copied()).collect();
        levels.sort_by(f32::total_cmp);
        levels.get(levels.len() / 2).copied().unwrap_or(0.0)
    });
    let mut corners: Vec<f32> = corners.collect();
    corners.sort_by(f32::total_cmp);
    match corners[3] - corners[0] <= 3.0 {
        true => corners[2],
        false => 0.0,
    }
}
