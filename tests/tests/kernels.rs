//! Every kernel on many plans: the bits of the f32 reference, in every way that the catalogue knows.

use bonebeam::Complex;
use bonebeam::beamform::Method;
use bonebeam_oracle::reference::f32 as plain;
use bonebeam_tests::kernel::{bits, judge_seeds};
use bonebeam_tests::kernels::delay::Input;
use bonebeam_tests::kernels::{beamform, delay, upsampled};

const DIRT: Complex<f32> = Complex::new(7.0, 7.0);

fn assert_plain(numbers: &[Complex<f32>], plain: &[Complex<f32>], what: &str) {
    let (ours, plain) = (bits(numbers), bits(plain));
    let at = ours.iter().zip(&plain).position(|(a, b)| a != b);
    assert!(
        at.is_none() && ours.len() == plain.len(),
        "{what}: other bits at {at:?} than the reference"
    );
}

#[test]
fn delayed_lines() {
    let [computed, refused] = judge_seeds(
        0..4000,
        |draw| delay::Lines::draw(draw),
        |lines, numbers, what| {
            let mut expected = vec![DIRT; numbers.len()];
            for line in lines.lines() {
                match &lines.input {
                    Input::Rf(stage, rf) => {
                        plain::delay::line(stage.parameters(), &line, rf, &mut expected)
                    }
                    Input::Iq(stage, iq) => {
                        let samples = (&iq.planar[..], iq.counts.unwrap_or(1.0), iq.phase);
                        plain::iq::line(stage.parameters(), &line, samples, &mut expected);
                    }
                }
            }
            assert_plain(numbers, &expected, &format!("{what} {lines:?}"));
        },
    );
    println!("{computed} {refused}");
    assert!(computed > 2000, "{computed} {refused}");
}

#[test]
fn upsampled_lines() {
    let [computed, refused] = judge_seeds(
        0..1000,
        |draw| upsampled::Waves::draw(draw),
        |waves, numbers, what| {
            let lines: Vec<_> = waves.lines().map(|line| (line, &waves.rf[..])).collect();
            let mut expected = vec![DIRT; numbers.len()];
            plain::delay::upsampled(waves.delay.parameters(), &lines, &mut expected);
            assert_plain(numbers, &expected, what);
        },
    );
    println!("{computed} {refused}");
    assert!(computed > 500, "{computed} {refused}");
}

/// Within the adaptive samples the lines of the method, elsewhere those of DAS.
fn plain_lines(lines: &beamform::Lines) -> Vec<Complex<f32>> {
    let mut all = Vec::new();
    for (line, (x, _)) in lines.lines.iter().enumerate() {
        let x: Vec<_> = x.chunks(lines.elements).map(<[_]>::to_vec).collect();
        let active: Vec<_> = (0..x.len())
            .map(|n| lines.active(line, n))
            .map(|set| (set.first, set.count))
            .collect();
        let parameters = lines.parameters;
        if parameters.sub_lines > 1 {
            let directions = lines.directions(line).expect("directions");
            let steering = bonebeam::geometry::Steering::of(&directions, parameters.sub_lines);
            let of_sample = |n| {
                (0..parameters.sub_lines)
                    .map(|k| steering.direction(n, k))
                    .collect()
            };
            let directions: Vec<Vec<_>> = (0..x.len()).map(of_sample).collect();
            all.extend(
                plain::sub_lines::sub_lines(
                    &x,
                    &active,
                    &directions,
                    &parameters,
                    lines.covariance,
                )
                .concat(),
            );
            continue;
        }
        let of = |method| {
            let parameters = bonebeam::beamform::Parameters {
                method,
                ..parameters
            };
            plain::beamform::beamform(&x, &active, &parameters, lines.covariance)
        };
        let (adaptive, das) = (of(parameters.method), of(Method::Das));
        let within = |i: usize| lines.within.contains(&(i * parameters.depth_step));
        all.extend((0..das.len()).map(|i| if within(i) { adaptive[i] } else { das[i] }));
    }
    all
}

#[test]
fn beamformed_lines() {
    let [computed, refused] = judge_seeds(
        0..6000,
        |draw| beamform::Lines::draw(draw),
        |lines, numbers, what| {
            assert_plain(
                numbers,
                &plain_lines(lines),
                &format!("{what} {:?} {:?}", lines.covariance, lines.parameters),
            );
        },
    );
    println!("{computed} {refused}");
    assert!(computed > 4000, "{computed} {refused}");
}
