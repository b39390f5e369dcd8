//! Short-lag coherence against the f64 reference.

use bonebeam::Complex;
use bonebeam::beamform::{AlignedLine, ShortLagCoherence};
use bonebeam::geometry::Active;
use bonebeam::memory::Scratch;
use bonebeam_oracle::reference::f64::coherence::short_lag_coherence;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// Sums of at most 5·127 positive powers err by fewer units in the last place; the products no more than they.
#[test]
fn agrees_with_the_f64_reference() {
    let bound = 2.0 * 5.0 * 128.0 * f64::from(f32::EPSILON);
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for (elements, temporal_half_window) in [(1, 0), (2, 3), (33, 1), (64, 0), (128, 2)] {
        let samples = 60;
        // Echoes that are alike on neighbouring elements, and noise; from tiny to huge.
        let scale = 10f32.powi(rng.random_range(-15..15));
        let mut x = Vec::new();
        for n in 0..samples {
            let (slope, noise) = (0.02 * n as f32, 0.05 * n as f32);
            x.extend((0..elements).map(|m| {
                let mut random = || rng.random_range(-1.0..1.0);
                let noise = Complex::new(random(), random()) * noise;
                (Complex::from_polar(1.0, slope * m as f32) + noise) * scale
            }));
        }
        let active = |n: usize| {
            let count = (elements * (n + 4) / 40).min(elements);
            Active {
                first: (elements - count) / 2,
                count,
            }
        };
        let coherence = ShortLagCoherence {
            temporal_half_window,
        };
        let line = AlignedLine::new(&x, elements).unwrap();
        let mut real = vec![f32::NAN; coherence.need().real];
        let scratch = Scratch {
            real: &mut real,
            complex: &mut [],
        };
        let mut found = vec![f32::NAN; samples];
        coherence.line(line, active, scratch, &mut found).unwrap();
        for (n, &found) in found.iter().enumerate() {
            let expected = short_lag_coherence(&x, elements, active, temporal_half_window, n);
            let error = (f64::from(found) - expected).abs();
            assert!(error <= bound, "{elements}, {n}: {found} and {expected}");
        }
    }
}
