//! What a screen has around the field and over it.

use ndarray::{Array2, Slice};

use super::random::Draw;
use super::view::View;

/// A screen with its field, the column and row of the field's first pixel, and where marks are.
pub fn framed(
    draw: &mut Draw,
    field: &Array2<f32>,
    view: &View,
) -> (Array2<f32>, [usize; 2], String) {
    let (rows, columns) = field.dim();
    let [share, left, right, above, below, ground, grey] = draw.row("screen");
    let side = |part: f32, length: usize| {
        let wide = share * part * share * length as f32;
        wide.min(0.5 * (1195.0 - length as f32).max(0.0)) as usize
    };
    let [left, right] = [left, right].map(|part| side(part, columns));
    let [above, below] = [above, below].map(|part| side(part, rows));
    let (right_end, bottom_end) = (left + columns, above + rows);
    let mut screen = Array2::from_elem((bottom_end + below, right_end + right), ground);
    for ((row, column), value) in field.indexed_iter().filter(|(_, value)| !value.is_nan()) {
        screen[[above + row, left + column]] = *value;
    }
    let mut crop = Vec::new();
    if screen.dim() != field.dim() {
        let (x, y) = (right_end - 1, bottom_end - 1);
        crop.push(format!("image field x {left}-{x}, y {above}-{y}"));
    }
    let mut pen = Pen(&mut screen, grey);
    if draw.chance(0.5) {
        let inside = right < 14 || draw.chance(0.3);
        let x = match inside {
            true => right_end - draw.count(1, 8),
            false => right_end + draw.count(2, right - 8),
        };
        let (minor, long) = ([1, 2, 5, 10][draw.count(0, 3)], draw.count(1, 7));
        let (zero, apart) = (view.top() / view.pixel, 10.0 / view.pixel / minor as f32);
        for k in 0..((rows as f32 + zero) / apart) as usize {
            let y = (above as f32 - zero + k as f32 * apart) as usize;
            let length = long.div_ceil(if k % minor == 0 { 1 } else { 2 });
            pen.block([x, y], [length, 1 + columns / 600]);
        }
        crop.push(format!("depth ticks at x {x}-{}", x + long));
    }
    if draw.chance(0.3) {
        let x = right_end - draw.count(4, 20);
        let y = above + draw.count(rows / 8, rows * 2 / 3);
        let long = draw.count(rows / 40, rows / 8);
        pen.block([x, y], [draw.count(1, 3), long]);
        crop.push(format!("focus mark at x {x}, y {y}-{}", y + long));
    }
    if left > 26 && draw.chance(0.6) {
        let (x, y, long) = (draw.count(2, left - 22), above + rows / 5, rows / 3);
        for k in 0..long {
            let pen = &mut Pen(pen.0, 255.0 * (1.0 - k as f32 / long as f32));
            pen.block([x, y + k], [(left / 6).clamp(4, 18), 1]);
        }
    }
    for (height, top) in [(above, 0), (below, bottom_end)] {
        for _ in 0..if height > 12 { draw.count(0, 4) } else { 0 } {
            let at = [draw.count(0, columns / 2), top + draw.count(0, height - 10)];
            pen.text(draw, at);
        }
    }
    let at = |draw: &mut Draw| {
        let x = left + draw.count(8, columns / 2);
        [x, above + draw.count(8, rows * 3 / 4)]
    };
    if draw.chance(0.12) {
        let [x, y] = at(draw);
        pen.text(draw, [x, y]);
        crop.push(format!("text at x {x}, y {y}"));
    }
    for _ in 0..if draw.chance(0.1) { 2 } else { 0 } {
        let [x, y] = at(draw);
        pen.block([x - 4, y], [9, 1]);
        pen.block([x, y - 4], [1, 9]);
        crop.push(format!("calliper at x {x}, y {y}"));
    }
    if draw.chance(0.12) {
        for x in [left, right_end - 1] {
            pen.block([x, above], [1, rows]);
        }
        for y in [above, bottom_end - 1] {
            pen.block([left, y], [columns, 1]);
        }
        crop.push("a line around the field".into());
    }
    if crop.is_empty() {
        crop.push("none".into());
    }
    (screen, [left, above], crop.join("; "))
}

/// A screen, and the grey of marks on it.
struct Pen<'a>(&'a mut Array2<f32>, f32);

impl Pen<'_> {
    fn block(&mut self, [x, y]: [usize; 2], [width, height]: [usize; 2]) {
        let mut block = self.0.slice_each_axis_mut(|axis| {
            let (at, size) = [(y, height), (x, width)][axis.axis.index()];
            Slice::from(at.min(axis.len)..(at + size).min(axis.len))
        });
        block.fill(self.1);
    }

    /// Signs of 3 × 5 points, which need not be letters.
    fn text(&mut self, draw: &mut Draw, [x, y]: [usize; 2]) {
        let size = draw.count(1, 2);
        for sign in 0..draw.count(2, 18) {
            let bits = draw.count(0, 0x7fff) | 0x1249;
            for bit in (0..15).filter(|bit| bits >> bit & 1 == 1) {
                let at = [x + (sign * 4 + bit % 3) * size, y + bit / 3 * size];
                self.block(at, [size, size]);
            }
        }
    }
}
