//! What a screen has around the field and over it.

use ndarray::Array2;

use super::random::Draw;
use super::view::View;

/// A screen with its field: pixels, and the column and row of the field's first pixel.
pub fn framed(
    draw: &mut Draw,
    field: &Array2<f32>,
    view: &View,
) -> (Array2<f32>, [usize; 2], String) {
    let (rows, columns) = field.dim();
    let share = draw.sometimes(0.6, 0.2, 0.7);
    let mut side = |length: usize| {
        let wide = draw.within(0.0, share) * share * length as f32;
        wide.min(0.5 * (1195.0 - length as f32).max(0.0)) as usize
    };
    let (left, right, above, below) = (side(columns), side(columns), side(rows), side(rows));
    let ground = draw.sometimes(0.15, 10.0, 70.0);
    let mut screen = Array2::from_elem((rows + above + below, columns + left + right), ground);
    for ((row, column), value) in field.indexed_iter().filter(|(_, value)| !value.is_nan()) {
        screen[[above + row, left + column]] = *value;
    }
    let mut crop = Vec::new();
    let (right_end, bottom_end) = (left + columns, above + rows);
    if screen.dim() != field.dim() {
        let (x, y) = (right_end - 1, bottom_end - 1);
        crop.push(format!("image field x {left}-{x}, y {above}-{y}"));
    }
    let grey = draw.within(90.0, 255.0);
    let mut pen = Pen {
        screen: &mut screen,
        grey,
    };
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
            let length = if k % minor == 0 {
                long
            } else {
                long.div_ceil(2)
            };
            pen.block([x, y], [length, 1 + columns / 600]);
        }
        crop.push(format!("depth ticks at x {x}-{}", x + long));
    }
    if draw.chance(0.3) {
        let x = right_end - draw.count(4, 20);
        let (y, long) = (
            above + draw.count(rows / 8, rows * 2 / 3),
            draw.count(rows / 40, rows / 8),
        );
        pen.block([x, y], [draw.count(1, 3), long]);
        crop.push(format!("focus mark at x {x}, y {y}-{}", y + long));
    }
    if left > 26 && draw.chance(0.6) {
        let (x, y, long) = (draw.count(2, left - 22), above + rows / 5, rows / 3);
        for k in 0..long {
            let pen = &mut Pen {
                grey: 255.0 * (1.0 - k as f32 / long as f32),
                screen: pen.screen,
            };
            pen.block([x, y + k], [(left / 6).clamp(4, 18), 1]);
        }
    }
    for (height, top) in [(above, 0), (below, bottom_end)]
        .into_iter()
        .filter(|side| side.0 > 12)
    {
        for _ in 0..draw.count(0, 4) {
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
        for (x, y) in [
            (left, above),
            (left, bottom_end - 1),
            (right_end - 1, above),
        ] {
            pen.block([x, y], if y == above { [1, rows] } else { [columns, 1] });
        }
        pen.block([left, above], [columns, 1]);
        crop.push("a line around the field".into());
    }
    let crop = if crop.is_empty() {
        "none".into()
    } else {
        crop.join("; ")
    };
    (screen, [left, above], crop)
}

struct Pen<'a> {
    screen: &'a mut Array2<f32>,
    grey: f32,
}

impl Pen<'_> {
    fn block(&mut self, [x, y]: [usize; 2], [width, height]: [usize; 2]) {
        let (rows, columns) = self.screen.dim();
        let (right, bottom) = ((x + width).min(columns), (y + height).min(rows));
        for row in y..bottom {
            for column in x..right {
                self.screen[[row, column]] = self.grey;
            }
        }
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
