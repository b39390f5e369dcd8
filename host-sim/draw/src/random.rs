//! Random numbers by a table of ranges, curves over the width, and patches over the plane.

use std::f32::consts::TAU;

use ndarray::Array2;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// Ranges of parameters, by name.
const TABLE: &str = include_str!("ranges.txt");

/// The words of each row of a name.
pub fn rows(name: &str) -> impl Iterator<Item = Vec<&'static str>> {
    let rows = TABLE.lines().map(str::split_whitespace);
    rows.filter_map(move |mut words| (words.next() == Some(name)).then(|| words.collect()))
}

/// A value at a share of the way from one to another.
pub fn mix(from: f32, to: f32, share: f32) -> f32 {
    from + share * (to - from)
}

/// A generator of the parameters and the speckle of one picture.
pub struct Draw(ChaCha8Rng);

impl Draw {
    pub fn new(seed: u64, picture: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(picture);
        Draw(random)
    }

    /// Values of the table's row of a name.
    pub fn row<const N: usize>(&mut self, name: &str) -> [f32; N] {
        let row = rows(name).next().expect(name);
        self.values(row.try_into().expect(name))
    }

    /// Values of words of the table.
    pub fn values<const N: usize>(&mut self, words: [&str; N]) -> [f32; N] {
        words.map(|word| self.value(word))
    }

    fn value(&mut self, word: &str) -> f32 {
        let number = |word: &str| word.parse::<f32>().expect(word);
        if let Some((chance, values)) = word.split_once('?') {
            let (value, other) = values.split_once(':').unwrap_or((values, "0"));
            let drawn = self.chance(number(chance));
            self.value(if drawn { value } else { other })
        } else if let Some((low, high)) = word.split_once("..=") {
            self.count(number(low) as usize, number(high) as usize) as f32
        } else if let Some((low, high)) = word.split_once("..") {
            self.within(number(low), number(high))
        } else if let Some((low, high)) = word.split_once('~') {
            self.log(number(low), number(high))
        } else if let Some(deviation) = word.strip_prefix('±') {
            self.normal() * number(deviation)
        } else {
            number(word)
        }
    }

    /// Uniform within a range.
    pub fn within(&mut self, low: f32, high: f32) -> f32 {
        mix(low, high, self.0.random::<f32>())
    }

    /// Uniform in the logarithm; `low` is above 0.
    pub fn log(&mut self, low: f32, high: f32) -> f32 {
        libm::expf(self.within(libm::logf(low), libm::logf(high)))
    }

    /// An integer of `low..=high`.
    pub fn count(&mut self, low: usize, high: usize) -> usize {
        self.0.random_range(low..=high)
    }

    pub fn chance(&mut self, probability: f32) -> bool {
        self.0.random::<f32>() < probability
    }

    /// Nearly Gaussian with variance 1: a sum of four uniform values.
    pub fn normal(&mut self) -> f32 {
        let bits = self.0.random::<u64>();
        let sum: u64 = (0..4).map(|k| (bits >> (16 * k)) & 0xffff).sum();
        (sum as f32 / 65535.0 - 2.0) * 1.732_050_8
    }

    /// A sum of waves of random length, with an RMS of about `height`.
    pub fn curve(&mut self, height: f32, longest: f32, shortest: f32) -> Curve {
        let waves = [(); 4].map(|()| {
            let length = self.log(shortest, longest);
            let size = height * 0.9 * self.within(0.3, 1.0) * (length / longest).sqrt();
            (size, TAU / length, self.within(0.0, TAU))
        });
        let wave = |x, (size, k, phase)| size * libm::sinf(k * x + phase);
        Curve::of(|x| waves.iter().map(|waves| wave(x, *waves)).sum())
    }
}

/// A function of the lateral position, in a table.
#[derive(Clone, Debug)]
pub struct Curve(Vec<f32>);

impl Curve {
    /// Half the width that the table covers, mm.
    const REACH: f32 = 150.0;
    const STEP: f32 = 0.4;

    pub fn of(function: impl Fn(f32) -> f32) -> Self {
        let points = (2.0 * Self::REACH / Self::STEP) as usize;
        let points = (0..=points).map(|k| function(k as f32 * Self::STEP - Self::REACH));
        Curve(points.collect())
    }

    pub fn at(&self, x: f32) -> f32 {
        let last = self.0.len() - 2;
        let position = ((x + Self::REACH) / Self::STEP).clamp(0.0, last as f32);
        let k = position as usize;
        mix(self.0[k], self.0[k + 1], position - k as f32)
    }

    /// The mean over `width` mm around each position.
    pub fn smooth(&self, width: f32) -> Self {
        let near = |x: f32| (-8..=8).map(move |k| self.at(x + width * k as f32 / 16.0));
        Curve::of(|x| near(x).sum::<f32>() / 17.0)
    }
}

/// Noise of −1 to 1 that changes over a length, mm.
pub struct Patches {
    values: Array2<f32>,
    length: [f32; 2],
    /// Shear of the patches: lateral shift per mm of depth.
    shear: f32,
}

impl Patches {
    pub fn new(draw: &mut Draw, length: [f32; 2], shear: f32) -> Self {
        let values = Array2::from_shape_simple_fn((64, 64), || draw.within(-1.0, 1.0));
        Patches {
            values,
            length,
            shear,
        }
    }

    pub fn at(&self, x: f32, z: f32) -> f32 {
        let part = |value: f32| {
            let (k, t) = (value.floor() as i32, value - value.floor());
            let [k, next] = [k, k + 1].map(|k| k.rem_euclid(64) as usize);
            (k, next, t * t * (3.0 - 2.0 * t))
        };
        let (i, i2, s) = part((x + self.shear * z) / self.length[0]);
        let (j, j2, t) = part(z / self.length[1]);
        let [top, bottom] = [j, j2].map(|j| mix(self.values[[j, i]], self.values[[j, i2]], s));
        mix(top, bottom, t)
    }
}

/// The amplitude of a level in dB.
pub fn amplitude(decibels: f32) -> f32 {
    libm::expf(decibels * 0.115_129_25)
}
