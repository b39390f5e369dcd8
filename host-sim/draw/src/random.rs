//! Random numbers, curves over the width, and patches over the plane.

use std::f32::consts::TAU;

use ndarray::Array2;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// A generator of the parameters and the speckle of one picture.
pub struct Draw(ChaCha8Rng);

impl Draw {
    pub fn new(seed: u64, picture: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(picture);
        Draw(random)
    }

    /// Uniform within a range.
    pub fn within(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.0.random::<f32>()
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

    /// Uniform within a range with a probability, else 0.
    pub fn sometimes(&mut self, probability: f32, low: f32, high: f32) -> f32 {
        if self.chance(probability) {
            self.within(low, high)
        } else {
            0.0
        }
    }

    /// 1 or −1.
    pub fn sign(&mut self) -> f32 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }

    /// Nearly Gaussian with variance 1: a sum of four uniform values.
    pub fn normal(&mut self) -> f32 {
        let bits = self.0.random::<u64>();
        let sum: u64 = (0..4).map(|k| (bits >> (16 * k)) & 0xffff).sum();
        (sum as f32 / 65535.0 - 2.0) * 1.732_050_8
    }

    /// A sum of waves of random length, with an RMS of about `height`.
    pub fn curve(&mut self, height: f32, longest: f32, shortest: f32) -> Curve {
        let waves: Vec<_> = (0..4)
            .map(|_| {
                let length = self.log(shortest, longest);
                let size = height * 0.9 * self.within(0.3, 1.0) * (length / longest).sqrt();
                (size, TAU / length, self.within(0.0, TAU))
            })
            .collect();
        Curve::of(|x| {
            waves
                .iter()
                .map(|(size, k, phase)| size * libm::sinf(k * x + phase))
                .sum()
        })
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
        Curve(
            (0..=points)
                .map(|k| function(k as f32 * Self::STEP - Self::REACH))
                .collect(),
        )
    }

    pub fn at(&self, x: f32) -> f32 {
        let last = self.0.len() - 2;
        let position = ((x + Self::REACH) / Self::STEP).clamp(0.0, last as f32);
        let k = position as usize;
        self.0[k] + (position - k as f32) * (self.0[k + 1] - self.0[k])
    }

    /// The mean over `width` mm around each position.
    pub fn smooth(&self, width: f32) -> Self {
        Curve::of(|x| {
            (-8..=8)
                .map(|k| self.at(x + width * k as f32 / 16.0))
                .sum::<f32>()
                / 17.0
        })
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
            let low = value.floor();
            let t = value - low;
            let k = low as i32;
            (
                k.rem_euclid(64) as usize,
                (k + 1).rem_euclid(64) as usize,
                t * t * (3.0 - 2.0 * t),
            )
        };
        let (i, i2, s) = part((x + self.shear * z) / self.length[0]);
        let (j, j2, t) = part(z / self.length[1]);
        let v = &self.values;
        let top = v[[j, i]] + s * (v[[j, i2]] - v[[j, i]]);
        let bottom = v[[j2, i]] + s * (v[[j2, i2]] - v[[j2, i]]);
        top + t * (bottom - top)
    }
}

/// The amplitude of a level in dB.
pub fn amplitude(decibels: f32) -> f32 {
    libm::expf(decibels * 0.115_129_25)
}
