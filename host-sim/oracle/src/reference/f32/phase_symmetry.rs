//! Phase symmetry with dense filters and a whole row–column transform in memory.

use std::f64::consts::PI;

use num_complex::Complex;

type Cubic = [f32; 4];

/// `PS` of a `rows` × `columns` image, row-major, for scales in cycles per pixel.
pub fn phase_symmetry(
    image: &[f32],
    rows: usize,
    columns: usize,
    scales: &[f64],
    threshold: f32,
) -> Vec<f32> {
    let tables = Tables::new();
    let spectrum = spectrum(image, rows, columns);
    let mut numerator = vec![0.0f32; image.len()];
    let mut denominator = vec![0.0f32; image.len()];
    for &r0 in scales {
        for k in 0..6 {
            let filter = tables.filter(rows, columns, r0, k);
            let c = inverse(&spectrum, &filter, rows, columns);
            for i in 0..image.len() {
                let (e, o) = (c[i].re, c[i].im);
                let excess = e - o.abs() - threshold;
                if excess > 0.0 {
                    numerator[i] += excess;
                }
                denominator[i] += libm::sqrtf(e * e + o * o);
            }
        }
    }
    let mut symmetry = Vec::new();
    for i in 0..image.len() {
        let ratio = numerator[i] / (denominator[i] + 1e-10);
        symmetry.push(if ratio < 1.0 {
            ratio
        } else {
            1.0f32.next_down()
        });
    }
    symmetry
}

/// A real image's spectrum and its image after a filter, row-major.
///
/// The filter has scale `r0` and orientation `orientation`. `e` and `o` are the real and imaginary parts of the filtered
/// image.
pub fn filtered(
    image: &[f32],
    rows: usize,
    columns: usize,
    r0: f64,
    orientation: usize,
) -> (Vec<Complex<f32>>, Vec<Complex<f32>>) {
    let spectrum = spectrum(image, rows, columns);
    let filter = Tables::new().filter(rows, columns, r0, orientation);
    let filtered = inverse(&spectrum, &filter, rows, columns);
    (spectrum, filtered)
}

/// The spectrum times a filter's gains, transformed back.
fn inverse(
    spectrum: &[Complex<f32>],
    filter: &[f32],
    rows: usize,
    columns: usize,
) -> Vec<Complex<f32>> {
    let mut c: Vec<Complex<f32>> = Vec::new();
    for i in 0..spectrum.len() {
        c.push(Complex::new(
            spectrum[i].re * filter[i],
            spectrum[i].im * filter[i],
        ));
    }
    for column in 0..columns {
        transform_column(&mut c, columns, column, true);
    }
    for row in 0..rows {
        transform(&mut c[row * columns..(row + 1) * columns], true);
    }
    c
}

/// The spectrum of a real image: the left half transformed, the right half its mirror image.
fn spectrum(image: &[f32], rows: usize, columns: usize) -> Vec<Complex<f32>> {
    let mut spectrum: Vec<Complex<f32>> = image.iter().map(|&p| Complex::new(p, 0.0)).collect();
    for row in 0..rows {
        transform(&mut spectrum[row * columns..(row + 1) * columns], false);
    }
    for column in 0..=columns / 2 {
        transform_column(&mut spectrum, columns, column, false);
    }
    for row in 0..rows {
        for column in columns / 2 + 1..columns {
            let opposite = (rows - row) % rows * columns + (columns - column);
            spectrum[row * columns + column] = spectrum[opposite].conj();
        }
    }
    spectrum
}

fn transform_column(data: &mut [Complex<f32>], columns: usize, column: usize, inverse: bool) {
    let mut line: Vec<Complex<f32>> = data[column..].iter().step_by(columns).copied().collect();
    transform(&mut line, inverse);
    for (row, value) in line.iter().enumerate() {
        data[row * columns + column] = *value;
    }
}

fn transform(line: &mut [Complex<f32>], inverse: bool) {
    use microfft::{complex, inverse as back};
    let length = "a supported length";
    match (line.len(), inverse) {
        (64, false) => drop(complex::cfft_64(line.try_into().expect(length))),
        (128, false) => drop(complex::cfft_128(line.try_into().expect(length))),
        (256, false) => drop(complex::cfft_256(line.try_into().expect(length))),
        (512, false) => drop(complex::cfft_512(line.try_into().expect(length))),
        (1024, false) => drop(complex::cfft_1024(line.try_into().expect(length))),
        (64, true) => drop(back::ifft_64(line.try_into().expect(length))),
        (128, true) => drop(back::ifft_128(line.try_into().expect(length))),
        (256, true) => drop(back::ifft_256(line.try_into().expect(length))),
        (512, true) => drop(back::ifft_512(line.try_into().expect(length))),
        (1024, true) => drop(back::ifft_1024(line.try_into().expect(length))),
        (other, _) => panic!("a line of {other} pixels"),
    }
}

/// The two factors of Eq. 9, each as cubics over segments.
struct Tables {
    /// Over `m = (r/r0)²`, 16 segments per octave from 2⁻¹⁸.
    radial: Vec<Cubic>,
    /// For orientations 0 and −π/6: over `t` from −1 to 1, 64 segments, for each of four faces.
    angular: [[Vec<Cubic>; 4]; 2],
}

impl Tables {
    fn new() -> Self {
        let mut radial = Vec::new();
        for octave in -18..20 {
            for segment in 0..16 {
                let m = |x: f64| {
                    libm::exp2(f64::from(octave)) * (1.0 + (f64::from(segment) + x) / 16.0)
                };
                radial.push(cubic([0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(|x| {
                    let z = 0.5 * libm::log(m(x)) / libm::log(0.15);
                    libm::exp(-0.5 * z * z)
                })));
            }
        }
        let angular = [0.0, -PI / 6.0].map(|theta0| {
            [0.0, 1.0, 2.0, 3.0].map(|face: f64| {
                let mut cubics = Vec::new();
                for segment in 0..64 {
                    cubics.push(cubic([0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(|x| {
                        let t = (f64::from(segment) + x) * (2.0 / 64.0) - 1.0;
                        let mut alpha = face * (PI / 2.0) + libm::atan(t) - theta0;
                        if alpha > PI {
                            alpha -= 2.0 * PI;
                        }
                        let z = alpha / (PI / 6.0);
                        libm::exp(-0.5 * z * z)
                    })));
                }
                cubics
            })
        });
        Tables { radial, angular }
    }

    /// The gains of orientation −k·π/6 on the whole grid.
    fn filter(&self, rows: usize, columns: usize, r0: f64, k: usize) -> Vec<f32> {
        let longest = rows.max(columns);
        let radius = r0 * longest as f64;
        let per_square = (1.0 / (radius * radius)) as f32;
        let mut gains = Vec::new();
        for row in 0..rows {
            for column in 0..columns {
                let u = frequency(column, columns) * (longest / columns) as f32;
                let v = -(frequency(row, rows) * (longest / rows) as f32);
                let square = u * u + v * v;
                gains.push(if square == 0.0 {
                    0.0
                } else {
                    self.radial_at(square * per_square) * self.angular_at(u, v, k)
                });
            }
        }
        gains
    }

    fn radial_at(&self, m: f32) -> f32 {
        // The octave, and where in it: both exact.
        let octave = libm::ilogbf(m);
        let within = (libm::ldexpf(m, -octave) - 1.0) * 16.0;
        let segment = within as usize;
        let index = (octave + 18) as usize * 16 + segment;
        evaluate(self.radial[index], within - segment as f32)
    }

    fn angular_at(&self, u: f32, v: f32, k: usize) -> f32 {
        // Turn or reflect the direction (u, v) so that the filter's becomes 0 or −π/6. Signs and
        // swaps alone, so nothing is rounded.
        let ((u, v), table) = match k {
            0 => ((u, v), 0),
            1 => ((u, v), 1),
            // −π/3 is −π/6 reflected about the diagonal −π/4.
            2 => ((-v, -u), 1),
            // −π/2 turned up by π/2 is 0.
            3 => ((-v, u), 0),
            4 => ((-v, u), 1),
            // −5π/6 is −π/6 reflected about the vertical.
            _ => ((-u, v), 1),
        };
        let (face, t) = if v.abs() < u.abs() || (v.abs() == u.abs() && k != 2 && k != 3 && k != 4) {
            (if u > 0.0 { 0 } else { 2 }, v / u)
        } else {
            (if v > 0.0 { 1 } else { 3 }, -(u / v))
        };
        let at = (t + 1.0) * 32.0;
        let segment = (at as usize).min(63);
        evaluate(self.angular[table][face][segment], at - segment as f32)
    }
}

/// The signed frequency of a bin in units of 1/n.
fn frequency(k: usize, n: usize) -> f32 {
    if 2 * k < n {
        k as f32
    } else {
        k as f32 - n as f32
    }
}

/// The cubic through values at 0, 1/3, 2/3, 1, by Newton's forward differences.
fn cubic([a, b, c, d]: [f64; 4]) -> Cubic {
    let first = b - a;
    let second = (c - 2.0 * b + a) / 2.0;
    let third = (d - 3.0 * c + 3.0 * b - a) / 6.0;
    [
        a as f32,
        (3.0 * (first - second + 2.0 * third)) as f32,
        (9.0 * (second - 3.0 * third)) as f32,
        (27.0 * third) as f32,
    ]
}

fn evaluate([a, b, c, d]: Cubic, x: f32) -> f32 {
    a + x * (b + x * (c + x * d))
}
