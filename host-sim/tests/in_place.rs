//! Results in the caller's memory: the bits of returned results.
//!
//! Earlier contents of the memory have no effect.

use bonebeam::beamform::{Method, Parameters};
use bonebeam::geometry::Active;
use bonebeam::simd::InstructionSet;
use bonebeam_drive::beamform::Plan;
use bonebeam_drive::phase_symmetry;
use ndarray::{Array2, Array3, Axis};
use num_complex::Complex;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

#[test]
fn lines_go_into_memory_of_the_caller() {
    let (beams, samples, elements) = (5, 70, 16);
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut noise = || random.random_range(-1.0f32..1.0);
    let x = Array3::from_shape_simple_fn((beams, samples, elements), || {
        Complex::new(noise(), noise())
    });
    // Fewer elements near the top and at the sides, so that the pieces' order is not the samples'.
    let active = |beam: usize, sample: usize| {
        Active::new(beam, (4 + sample / 20 + beam % 2).min(elements - beam))
    };
    let parameters = Parameters {
        temporal_half_window: 1,
        ..Parameters::of(Method::Mv)
    };
    let plan = Plan::new(InstructionSet::detect(), parameters, elements).unwrap();
    let expected = plan.run(x.view(), &active, &|_| {}).unwrap();

    let nan = Complex::new(f32::NAN, f32::NAN);
    let mut frames = Array3::from_elem((3, beams, samples), nan);
    let own = frames.index_axis_mut(Axis(0), 1);
    plan.run_into(x.view(), &active, &|_| {}, own).unwrap();
    let bits = |z: &Complex<f32>| [z.re.to_bits(), z.im.to_bits()];
    let written = frames.index_axis(Axis(0), 1);
    assert!(written.iter().map(bits).eq(expected.iter().map(bits)));
    for other in [0, 2] {
        assert!(
            frames
                .index_axis(Axis(0), other)
                .iter()
                .all(|z| z.re.is_nan())
        );
    }

    let mut short = Array2::from_elem((beams, samples - 1), nan);
    let mut turned = Array2::from_elem((samples, beams), nan);
    for wrong in [short.view_mut(), turned.view_mut().reversed_axes()] {
        let message = plan
            .run_into(x.view(), &active, &|_| {}, wrong)
            .unwrap_err();
        assert!(
            message.to_string().contains("expected (5, 70), row by row"),
            "{message}"
        );
    }
}

#[test]
fn a_map_goes_into_memory_of_the_caller() {
    let image = Array2::from_shape_fn(
        (64, 128),
        |(row, column)| {
            if row == 20 + column / 8 { 200.0 } else { 3.0 }
        },
    );
    let parameters = phase_symmetry::Parameters {
        scales: vec![1.0 / 16.0],
        threshold: 2.0,
        strip: 16,
    };
    let set = InstructionSet::detect();
    let mut plan = phase_symmetry::Plan::new(image.dim(), &parameters).unwrap();
    let expected = plan.run(image.view(), set, &mut |_, _| {}).unwrap();
    assert!(expected.iter().any(|&symmetry| symmetry > 0.1));

    let mut map = Array2::from_elem(image.dim(), f32::NAN);
    plan.run_into(image.view(), set, &mut |_, _| {}, map.view_mut())
        .unwrap();
    let bits = |map: &Array2<f32>| map.iter().map(|m| m.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&map), bits(&expected));

    let mut wrong = Array2::zeros((128, 64));
    let message = plan.run_into(image.view(), set, &mut |_, _| {}, wrong.view_mut());
    let message = message.unwrap_err().to_string();
    assert!(
        message.contains("expected (64, 128), row by row"),
        "{message}"
    );
}
