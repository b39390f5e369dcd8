//! Faults that are put into sound recordings: what is done, and what must be named.

use bonebeam_files::{ChannelData, Transmits};
use bonebeam_simulate::{complex_gaussian, demodulate};
use ndarray::Axis;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use crate::scene::rf;

/// A fault: its name, the findings of which one must name it, and its deed; `false` if it cannot be in this recording.
pub struct Fault {
    pub name: &'static str,
    pub named: &'static [&'static str],
    pub put: fn(&mut ChannelData, &mut ChaCha8Rng) -> bool,
}

const fn fault(
    name: &'static str,
    named: &'static [&'static str],
    put: fn(&mut ChannelData, &mut ChaCha8Rng) -> bool,
) -> Fault {
    Fault { name, named, put }
}

pub const FAULTS: &[Fault] = &[
    fault("elements reversed", &["mirrored"], |data, _| {
        permute(data, |m, count| count - 1 - m);
        !matches!(&data.transmits, Transmits::Plane { angle } if angle.len() < 2)
    }),
    fault("transmits mirrored", &["mirrored"], |data, _| {
        match &mut data.transmits {
            Transmits::Focused { x, .. } | Transmits::VirtualSource { x, .. } => {
                x.iter_mut().for_each(|x| *x = -*x)
            }
            Transmits::Plane { angle } => angle.iter_mut().for_each(|a| *a = -*a),
            _ => return false,
        }
        true
    }),
    fault(
        "halves of the elements exchanged",
        &["connectors"],
        |data, _| {
            permute(data, |m, count| (m + count / 2) % count);
            true
        },
    ),
    fault("elements interleaved", &["interleaved"], |data, _| {
        permute(data, |m, count| m / 2 + m % 2 * (count / 2));
        true
    }),
    fault("two neighbours exchanged", &["swapped"], |data, random| {
        let m = random.random_range(20..43);
        swap(data, m, m + 1);
        true
    }),
    fault(
        "two far elements exchanged",
        &["swapped"],
        |data, random| {
            let (a, b) = (random.random_range(8..24), random.random_range(36..56));
            swap(data, a, b);
            true
        },
    ),
    fault("an element inverted", &["inverted"], |data, random| {
        scale(data, random.random_range(8..56), -1.0);
        true
    }),
    fault("an element dead", &["dead"], |data, random| {
        scale(data, random.random_range(8..56), 0.0);
        true
    }),
    fault("an element 12 dB weak", &["weak"], |data, random| {
        scale(data, random.random_range(8..56), 0.25);
        true
    }),
    fault(
        "an element with noise of 10 times its power",
        &["noisy"],
        |data, random| {
            let m = random.random_range(8..56);
            let mut own = rf(data).index_axis_mut(Axis(2), m).to_owned();
            let power = own.iter().map(|v| v * v).sum::<f32>() / own.len() as f32;
            own.mapv_inplace(|v| v + (10.0 * power).sqrt() * complex_gaussian(random).re as f32);
            rf(data).index_axis_mut(Axis(2), m).assign(&own);
            true
        },
    ),
    fault("an element saturated", &["saturated"], |data, random| {
        let m = random.random_range(8..56);
        clip(&mut rf(data).index_axis_mut(Axis(2), m));
        true
    }),
    fault("all elements clipped", &["clipped"], |data, _| {
        clip(rf(data));
        true
    }),
    fault(
        "a constant of half the RMS",
        &["constant", "offset-binary"],
        |data, _| {
            let rms = rms(data);
            rf(data).mapv_inplace(|v| v + 0.5 * rms);
            true
        },
    ),
    fault("offset binary", &["offset-binary"], |data, _| {
        let most = rf(data).iter().fold(0.0f32, |a, v| a.max(v.abs()));
        rf(data).mapv_inplace(|v| v + 1.01 * most);
        true
    }),
    fault("f0 half of the echoes'", &["harmonic"], |data, _| {
        data.f0 *= 0.5;
        true
    }),
    fault("f0 twice the echoes'", &["harmonic"], |data, _| {
        data.f0 *= 2.0;
        true
    }),
    fault("fs twice", &["sampling-rate"], |data, _| {
        data.fs *= 2.0;
        true
    }),
    fault("fs half", &["sampling-rate"], |data, _| {
        data.fs *= 0.5;
        true
    }),
    fault("I/Q conjugated", &["carrier-sign"], |data, _| {
        *data = demodulate(data.clone());
        data.samples = data.samples.clone().conjugate();
        true
    }),
    fault("angles converted twice", &["angle-unit"], |data, _| {
        angles(data, f64::to_radians)
    }),
    fault(
        "tx_element from 1",
        &["element-index"],
        |data, _| match &mut data.transmits {
            Transmits::Element { index } => {
                index.iter_mut().for_each(|i| *i += 1);
                true
            }
            _ => false,
        },
    ),
    fault(
        "first transmit missing from the list",
        &["transmit-order"],
        |data, _| {
            shift(data);
            data.transmits.len() > 3 && !matches!(data.transmits, Transmits::Delays { .. })
        },
    ),
    fault(
        "a transmit recorded twice",
        &["doubled", "transmit-order"],
        |data, random| {
            let t = random.random_range(1..data.transmits.len());
            let before = rf(data).index_axis(Axis(1), t - 1).to_owned();
            rf(data).index_axis_mut(Axis(1), t).assign(&before);
            true
        },
    ),
    fault(
        "a transmit of opposite polarity",
        &["polarity"],
        |data, random| {
            let t = random.random_range(0..data.transmits.len());
            rf(data).index_axis_mut(Axis(1), t).mapv_inplace(|v| -v);
            !has_own_lines(data)
        },
    ),
    fault(
        "two transmits exchanged",
        &["transmit-order"],
        |data, random| {
            let count = data.transmits.len();
            let a = random.random_range(0..count - 2);
            let b = random.random_range(a + 2..count);
            match &mut data.transmits {
                Transmits::Focused { x, .. } => x.swap(a, b),
                Transmits::Plane { angle } => angle.swap(a, b),
                Transmits::VirtualSource { x, z } => {
                    x.swap(a, b);
                    z.swap(a, b);
                }
                Transmits::Element { index } => index.swap(a, b),
                Transmits::Delays { .. } => return false,
            }
            // Exchanged ends of three mirror them.
            count > 3
        },
    ),
    fault("c 5 % high", &["sound-speed"], |data, _| {
        data.c *= 1.05;
        true
    }),
    fault("pitch a third wide", &["pitch"], |data, _| {
        data.element_x.iter_mut().for_each(|x| *x *= 4.0 / 3.0);
        true
    }),
    fault(
        "a lens of 0.8 us and more, there and back, left out",
        &["time-zero"],
        |data, _| {
            let late = std::mem::take(&mut data.lens_delay);
            late >= 0.4e-6 && !has_own_lines(data)
        },
    ),
    fault("t0 1 us early", &["time-zero"], |data, _| {
        data.t0.iter_mut().for_each(|t| *t -= 1e-6);
        !has_own_lines(data)
    }),
];

/// Whether each transmit is focused on a line of its own, which has neither its sign nor its time.
fn has_own_lines(data: &ChannelData) -> bool {
    match &data.transmits {
        Transmits::Focused { .. } => true,
        Transmits::VirtualSource { z, .. } => z[0] > 0.0,
        _ => false,
    }
}

fn permute(data: &mut ChannelData, from: impl Fn(usize, usize) -> usize) {
    let count = data.element_x.len();
    let order: Vec<usize> = (0..count).map(|m| from(m, count)).collect();
    *rf(data) = rf(data).select(Axis(2), &order);
}

fn swap(data: &mut ChannelData, a: usize, b: usize) {
    permute(data, |m, _| {
        if m == a {
            b
        } else if m == b {
            a
        } else {
            m
        }
    });
}

fn scale(data: &mut ChannelData, m: usize, factor: f32) {
    rf(data)
        .index_axis_mut(Axis(2), m)
        .mapv_inplace(|v| factor * v);
}

fn rms(data: &mut ChannelData) -> f32 {
    (rf(data).iter().map(|v| v * v).sum::<f32>() / rf(data).len() as f32).sqrt()
}

/// Clips at the level that a twentieth of a percent of the samples exceed.
fn clip<D: ndarray::Dimension>(
    samples: &mut ndarray::ArrayBase<impl ndarray::DataMut<Elem = f32>, D>,
) {
    let mut sizes: Vec<f32> = samples.iter().map(|v| v.abs()).collect();
    sizes.sort_by(f32::total_cmp);
    let level = sizes[sizes.len() - 1 - sizes.len() / 200];
    samples.mapv_inplace(|v| v.clamp(-level, level));
}

fn angles(data: &mut ChannelData, change: impl Fn(f64) -> f64) -> bool {
    match &mut data.transmits {
        Transmits::Plane { angle } => {
            // Only angles that readers accept.
            let changed: Vec<f64> = angle.iter().map(|&a| change(a)).collect();
            let accepted = changed.iter().all(|a| a.abs() < 1.5);
            *angle = changed;
            accepted
        }
        _ => false,
    }
}

/// The list of transmits begins with the second record's.
fn shift(data: &mut ChannelData) {
    match &mut data.transmits {
        Transmits::Focused { x, .. } => x.rotate_left(1),
        Transmits::Plane { angle } => angle.rotate_left(1),
        Transmits::VirtualSource { x, .. } => x.rotate_left(1),
        Transmits::Element { index } => index.rotate_left(1),
        Transmits::Delays { .. } => {}
    }
}

/// Randomness of a fault in a recording.
pub fn random(seed: u64, fault: usize) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed.wrapping_mul(1000) + fault as u64)
}
