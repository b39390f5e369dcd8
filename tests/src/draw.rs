//! Where the numbers of a kernel's plan come from: a seed, or the bytes of a fuzzer.

use std::vec::Vec;

/// A source of numbers.
pub trait Draw {
    /// The next byte.
    fn byte(&mut self) -> u8;

    /// Bytes of data, drawn last.
    fn data(&mut self, count: usize) -> Vec<u8>;

    /// One choice in two.
    fn flag(&mut self) -> bool {
        self.byte() & 1 == 1
    }

    /// One choice in `count`.
    fn once_in(&mut self, count: u8) -> bool {
        self.byte().is_multiple_of(count)
    }

    /// A number of any bits or any magnitude if `wild`, or one in a usual range.
    fn number(&mut self, wild: bool, [least, most]: [f64; 2]) -> f64 {
        let bytes = [(); 8].map(|()| self.byte());
        let bits = u64::from_le_bytes(bytes);
        let share = bits as f64 / u64::MAX as f64;
        match (wild, bytes[0] % 4) {
            (false, _) => least + share * (most - least),
            (true, 0) => f64::from_bits(bits),
            (true, 1) => 0.01 * share,
            (true, kind) => {
                let magnitude = 10f64.powf(120.0 * share - 60.0);
                if kind == 2 {
                    magnitude
                } else {
                    least.signum() * magnitude
                }
            }
        }
    }

    /// A size of 1 to `few`, or up to about `most` for one choice in 16.
    ///
    /// Small sizes take little time, and reach the same branches.
    fn size(&mut self, few: usize, most: usize) -> usize {
        match usize::from(self.byte()) {
            choice @ ..240 => 1 + choice % few,
            choice => 1 + (choice - 240) * most / 16,
        }
    }

    /// A size below `count`.
    fn below(&mut self, count: usize) -> usize {
        usize::from(self.byte()) % count.max(1)
    }

    /// One of some values.
    fn one_of<T: Copy>(&mut self, values: &[T]) -> T {
        values[self.below(values.len())]
    }

    /// Finite samples: small numbers of a common scale, or any bits.
    ///
    /// The small numbers make covariances as recordings do.
    fn samples(&mut self, count: usize) -> Vec<f32> {
        let any_bits = self.once_in(4);
        let scale = f32::from(self.byte() as i8).exp2();
        let finite = |value: f32| if value.is_finite() { value } else { 0.0 };
        match any_bits {
            true => {
                let bytes = self.data(4 * count);
                let (words, _) = bytes.as_chunks::<4>();
                words
                    .iter()
                    .map(|&word| finite(f32::from_le_bytes(word)))
                    .collect()
            }
            false => {
                let bytes = self.data(count);
                bytes
                    .iter()
                    .map(|&byte| finite(f32::from(byte as i8) * scale))
                    .collect()
            }
        }
    }

    /// Samples that a record takes, at most 10²⁹.
    fn record(&mut self, count: usize) -> Vec<f32> {
        let samples = self.samples(count).into_iter();
        samples
            .map(|x| if x.abs() <= 1e29 { x } else { 1.0 })
            .collect()
    }
}

/// Numbers of a seed (SplitMix64).
pub struct Seed(pub u64);

impl Draw for Seed {
    fn byte(&mut self) -> u8 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z >> 56) as u8
    }

    fn data(&mut self, count: usize) -> Vec<u8> {
        (0..count).map(|_| self.byte()).collect()
    }
}

/// A fuzzer's bytes, 0 after their end; as data, the rest is repeated.
pub struct Bytes<'a>(pub &'a [u8]);

impl Draw for Bytes<'_> {
    fn byte(&mut self) -> u8 {
        self.0.split_off_first().copied().unwrap_or(0)
    }

    fn data(&mut self, count: usize) -> Vec<u8> {
        let byte = |index: usize| match self.0.len() {
            0 => 0,
            // Rotated, since repeated rows would be equal.
            length => self.0[index % length].rotate_left((index / length) as u32 % 8),
        };
        (0..count).map(byte).collect()
    }
}
