//! Phase symmetry with its gain tables: a map from 0 to below 1 whose bits depend neither on the strip,
//! nor on the instruction set, nor on whether the memory was used before.

#![no_main]

use std::sync::Once;

use arbitrary::Arbitrary;
use bonebeam::simd::InstructionSet;
use bonebeam_fuzz::{finite_bits, samples};
use host_sim::drive::phase_symmetry::{Parameters, Plan};
use libfuzzer_sys::fuzz_target;
use ndarray::Array2;

#[derive(Arbitrary, Debug)]
struct Input {
    tall: bool,
    scales: Vec<u8>,
    wild_scale: Option<f64>,
    threshold: f32,
    strips: [u8; 2],
    any_bits: bool,
    exponent: i8,
    data: Vec<u8>,
}

fuzz_target!(|input: Input| {
    static THREADS: Once = Once::new();
    THREADS.call_once(|| {
        let _ = rayon_of_one();
    });
    let size = if input.tall { (128, 64) } else { (64, 64) };
    let scales = input
        .scales
        .iter()
        .take(2)
        .map(|&scale| f64::from(scale) / 500.0);
    let scales: Vec<f64> = scales.chain(input.wild_scale).collect();
    let with = |strip: u8| Parameters {
        scales: scales.clone(),
        threshold: input.threshold,
        strip: usize::from(strip),
    };
    let Ok(mut plan) = Plan::new(size, &with(input.strips[0])) else {
        return;
    };
    let pixels = samples(&input.data, size.0 * size.1, input.any_bits, input.exponent);
    let image = Array2::from_shape_vec(size, pixels).expect("a pixel each");
    let Ok(expected) = plan.run(image.view(), InstructionSet::Scalar, |_, _| {}) else {
        return;
    };
    assert!(
        expected.iter().all(|value| (0.0..1.0).contains(value)),
        "beyond 0 to 1"
    );
    let bits = |map: &Array2<f32>| finite_bits(map.as_slice().expect("as it was made"));
    for set in InstructionSet::available() {
        let map = plan
            .run(image.view(), set, |_, _| {})
            .expect("what one lane takes");
        assert_eq!(bits(&expected), bits(&map), "{}", set.name());
    }
    if let Ok(mut other) = Plan::new(size, &with(input.strips[1])) {
        let map = other.run(image.view(), InstructionSet::detect(), |_, _| {});
        assert_eq!(
            bits(&expected),
            bits(&map.expect("what one strip takes")),
            "another strip"
        );
    }
});

/// One thread: a target is run on several processes instead.
fn rayon_of_one() -> Result<(), rayon::ThreadPoolBuildError> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build_global()
}
