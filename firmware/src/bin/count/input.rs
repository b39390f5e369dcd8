//! The input data; `plain-c/main.c` makes the same numbers.

use bonebeam::Complex;

/// Samples of the line.
pub const SAMPLES: usize = 32;
/// The amplitude of an echo 20 dB above the noise.
pub const ECHO: f32 = 4.0;

/// Aligned samples `[sample][element]` of `elements` elements.
///
/// They are an echo of amplitude `echo` from straight ahead, one 10 dB weaker from the side with a phase step of a
/// quarter turn an element, and noise. Both echoes are at 5 MHz, a quarter turn a sample. Samples have few bits, so
/// that every compiler rounds alike.
pub fn snapshots(x: &mut [Complex<f32>], elements: usize, echo: f32) {
    const QUARTERS: [(f32, f32); 4] = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)];
    let mut noise = noise();
    for (n, snapshot) in x.chunks_exact_mut(elements).enumerate() {
        for (m, x) in snapshot.iter_mut().enumerate() {
            let (ahead, side) = (QUARTERS[n % 4], QUARTERS[(n + m) % 4]);
            x.re = echo * (ahead.0 + 0.3125 * side.0) + noise();
            x.im = echo * (ahead.1 + 0.3125 * side.1) + noise();
        }
    }
}

/// Number of kinds of snapshots that [`of_kind`] makes.
pub const KINDS: usize = LEVELS.len() * RATIOS.len() * TURNS.len();
/// Amplitudes of an echo: from no echo to 70 dB above the noise.
const LEVELS: [f32; 12] = [
    0.0, 0.125, 0.25, 0.375, 0.5, 0.75, 1.0, 1.5, 2.0, 4.0, 32.0, 1024.0,
];
/// Ratios of the second echo to the first.
const RATIOS: [f32; 6] = [0.0, 0.3125, 0.625, 0.875, 0.96875, 1.0];
/// Phase step of the second echo an element: 0.01, 0.05, 0.11 and 0.25 of a turn.
const TURNS: [(f32, f32); 4] = [
    (0.998_026_7, 0.062_790_52),
    (0.951_056_5, 0.309_017),
    (0.770_513_24, 0.637_424),
    (0.0, 1.0),
];

/// A snapshot of one or two echoes in noise.
pub fn of_kind(x: &mut [Complex<f32>], kind: usize) {
    let level = LEVELS[kind % LEVELS.len()];
    let ratio = RATIOS[kind / LEVELS.len() % RATIOS.len()];
    let (cos, sin) = TURNS[kind / (LEVELS.len() * RATIOS.len()) % TURNS.len()];
    let mut noise = noise();
    // Independent noise for each.
    for _ in 0..2 * kind * x.len() {
        noise();
    }
    let mut side = Complex::new(ratio, 0.0);
    for x in x {
        x.re = level * (1.0 + side.re) + noise();
        x.im = level * side.im + noise();
        side = Complex::new(side.re * cos - side.im * sin, side.re * sin + side.im * cos);
    }
}

/// Noise at the ends of what may come: its name, magnitude, and elements that have it; the others are silent.
pub const EXTREMES: [(&str, f32, usize); 7] = [
    ("zeros", 0.0, 0),
    ("the smallest numbers", 1e-45, usize::MAX),
    ("subnormal numbers", 1e-39, usize::MAX),
    ("tiny numbers", 1e-30, usize::MAX),
    ("huge numbers", 1e30, usize::MAX),
    ("the largest numbers", f32::MAX, usize::MAX),
    ("one element alone", 1.0, 1),
];

/// A snapshot of [`EXTREMES`].
pub fn of_extreme(x: &mut [Complex<f32>], magnitude: f32, elements: usize) {
    let mut noise = noise();
    x.fill(Complex::new(0.0, 0.0));
    for x in x.iter_mut().take(elements) {
        *x = Complex::new(2.0 * noise() * magnitude, 2.0 * noise() * magnitude);
    }
}

/// An image of `side` × `side` pixels: two bright ridges that cross, on speckle.
pub fn image(pixels: &mut [f32], side: usize) {
    for (n, pixel) in pixels.iter_mut().enumerate() {
        let (row, column) = (n / side, n % side);
        let speckle = (n as u32).wrapping_mul(2_654_435_761) >> 26;
        let ridges = ridge(row, side / 2 + column / 5) + ridge(column, side / 4 + row / 2);
        *pixel = (10 + speckle + ridges) as f32;
    }
}

fn ridge(at: usize, top: usize) -> u32 {
    match at.abs_diff(top) {
        0 => 90,
        1 => 70,
        2 => 25,
        _ => 0,
    }
}

/// RF: noise.
pub fn rf(samples: &mut [f32]) {
    samples.fill_with(noise());
}

/// Uniform in −0.5..0.5: a power of 1/12.
fn noise() -> impl FnMut() -> f32 {
    let mut state = 1u32;
    move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0 - 0.5
    }
}
