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
    let plain = draw.chance(0.4);
    let mut side = |most: f32, length: usize| match plain {
        true => 0,
        false => (draw.within(0.0, most).powi(2) * length as f32)
            .min((1195 - length.min(1195)) as f32 * 0.5) as usize,
    };
    let (left, right) = (side(0.7, columns), side(0.7, columns));
    let (above, below) = (side(0.45, rows), side(0.45, rows));
    let ground = if draw.chance(0.15) {
        draw.within(10.0, 70.0)
    } else {
        0.0
    };
    let mut screen = Array2::from_elem((rows + above + below, columns + left + right), ground);
    for ((row, column), value) in field.indexed_iter().filter(|(_, value)| !value.is_nan()) {
        screen[[above + row, left + column]] = *value;
    }
    let mut crop = Vec::new();
    if left + right + above + below > 0 {
        crop.push(format!(
            "image field x {left}-{}, y {above}-{}",
            left + columns - 1,
            above + rows - 1
        ));
    }
    let mut pen = Pen {
        screen: &mut screen,
        grey: draw.within(90.0, 255.0),
    };
    let centimetre = 10.0 / view.pixel;
    if draw.chance(0.5) {
        let inside = right < 14 || draw.chance(0.3);
        let x = if inside {
            left + columns - draw.count(1, 8)
        } else {
            left + columns + draw.count(2, right - 8)
        };
        let (minor, long) = (draw.pick_share(), draw.count(1, 7));
        let zero = above as f32 - view.top() / view.pixel;
        for k in 0..400 {
            let y = zero + k as f32 * centimetre * minor;
            if y >= (above + rows) as f32 {
                break;
            }
            let length = if (k as f32 * minor).fract() < 0.01 {
                long
            } else {
                long.div_ceil(2)
            };
            pen.block([x, y as usize], [length, 1 + columns / 600]);
        }
        crop.push(format!("depth ticks at x {x}-{}", x + long));
    }
    if draw.chance(0.3) {
        let (x, y) = (
            left + columns - draw.count(4, 20),
            above + draw.count(rows / 8, rows * 2 / 3),
        );
        let long = draw.count(rows / 40, rows / 8);
        pen.block([x, y], [draw.count(1, 3), long]);
        crop.push(format!("focus mark at x {x}, y {y}-{}", y + long));
    }
    if left > 26 && draw.chance(0.6) {
        let (x, y, long) = (draw.count(2, left - 22), above + rows / 5, rows / 3);
        for k in 0..long {
            pen.grey = 255.0 * (1.0 - k as f32 / long as f32);
            pen.block([x, y + k], [draw_width(left), 1]);
        }
        pen.grey = 220.0;
    }
    for (height, top) in [(above, 0), (below, above + rows)] {
        for _ in 0..if height > 12 { draw.count(0, 4) } else { 0 } {
            let at = [draw.count(0, columns / 2), top + draw.count(0, height - 10)];
            pen.text(draw, at);
        }
    }
    if draw.chance(0.12) {
        let at = [
            left + draw.count(2, columns / 2),
            above + draw.count(2, rows * 3 / 4),
        ];
        pen.text(draw, at);
        crop.push(format!("text at x {}, y {}", at[0], at[1]));
    }
    if draw.chance(0.1) {
        for _ in 0..2 {
            let (x, y) = (
                left + draw.count(8, columns - 8),
                above + draw.count(8, rows - 8),
            );
            pen.block([x - 4, y], [9, 1]);
            pen.block([x, y - 4], [1, 9]);
        }
        crop.push("callipers".into());
    }
    if draw.chance(0.12) {
        for (start, size) in [
            ([left, above], [columns, 1]),
            ([left, above + rows - 1], [columns, 1]),
            ([left, above], [1, rows]),
            ([left + columns - 1, above], [1, rows]),
        ] {
            pen.block(start, size);
        }
        crop.push("a line around the field".into());
    }
    let crop = if crop.is_empty() {
        "none".into()
    } else {
        crop.join("; ")
    };
    (screen, [left, above], crop)
}

fn draw_width(left: usize) -> usize {
    (left / 6).clamp(4, 18)
}

impl Draw {
    /// Distance of ticks, cm.
    fn pick_share(&mut self) -> f32 {
        [1.0, 0.5, 0.1, 0.2][self.count(0, 3)]
    }
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
