//! Counts with interpolation and phase rotation in fixed point.

use super::refused::refused_name;
use super::*;
use crate::common::changed;
use crate::common::delays::line_into;

/// Noise as counts.
fn counted(samples: usize, seed: u64) -> Vec<[i16; 2]> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..ELEMENTS * samples).map(|_| rng.random()).collect()
}

/// The table of docs/numerics.md, its last column: the pulse's peak has 16 000 counts.
#[test]
fn the_documented_errors_of_fixed_point_hold() {
    let convex = convex(ELEMENTS);
    let bounds = [8.0e-2, 3.7e-2, 1.4e-2, 1.2e-3, 2.3e-2, 6.4e-2];
    for ((bandwidth, fs, _), bound) in ERRORS.into_iter().zip(bounds) {
        for line in lines(&convex) {
            let mut p = parameters(fs, (30e-6 * fs) as usize, IqInterpolation::LinearFixed);
            p.output_rate = 40e6;
            p.output_start = 5e-6;
            p.output_samples = 800;
            let [x, z] = line.ray.point(17e-3);
            let (iq, _) = echoes(&p, &line, &[[x, z]], (bandwidth * F0, 1e6, 1));
            let counts: Vec<[i16; 2]> = iq
                .iter()
                .map(|y| [y.re, y.im].map(|part| (16_000.0 * part).round() as i16))
                .collect();
            let samples = IqSamples::Counts(&counts, 1.0 / 16_000.0);
            let record = Record::iq(samples, IqLayout::Planar, ELEMENTS).unwrap();
            let ours = core_line(&p, &line, &record);
            let exact = reference::f64::iq::line(&p, &line, &iq);
            let error = worst(&ours, exact.iter().copied());
            println!("{bandwidth}, {fs}: {error:.2e}");
            assert!(error < bound, "{bandwidth}, {fs}: {error}");
            assert!(
                ours.iter().any(|y| y.norm() > 0.9),
                "{bandwidth}, {fs}: empty"
            );
        }
    }
}

#[test]
fn what_fixed_point_cannot_read_is_refused() {
    let good = parameters(10e6, 100, IqInterpolation::LinearFixed);
    let name = |change| refused_name(good, change);
    assert_eq!(
        name(|p| p.demodulation_frequency = 20e6),
        "demodulation_frequency"
    );
    assert_eq!(name(|p| p.record_samples = 65_537), "record_samples");
    assert_eq!(name(|p| p.elements = 4097), "elements");
    let floats = noise(ELEMENTS * 100, 1);
    let mut scratch = vec![0.0; good.need(1).real];
    let mut out = vec![ZERO; good.output_samples * ELEMENTS];
    let refused = IqDelay::new(good).unwrap().line(
        0.0f32,
        &lines(&convex(ELEMENTS))[0],
        &planar(&floats),
        &mut scratch,
        &mut out,
    );
    assert!(matches!(refused, Err(Error::Parameter { name: "iq", .. })));
}

/// Asserts equal aligned samples of counts by both, added to the same values.
fn assert_reference(
    p: &IqParameters,
    line: &ScanLine,
    (counts, scale, phase): (&[[i16; 2]], f32, f64),
    before: &[Complex<f32>],
    what: &str,
) {
    let floats: Vec<_> = counts
        .iter()
        .map(|&[i, q]| Complex::new(f32::from(i), f32::from(q)))
        .collect();
    let mut expected = before.to_vec();
    reference::f32::iq::line(p, line, (&floats, scale, phase), &mut expected);
    let samples = p.record_samples;
    let interleaved: Vec<[i16; 2]> = (0..counts.len())
        .map(|i| counts[(i % p.elements) * samples + i / p.elements])
        .collect();
    for (counts, layout) in [
        (counts, IqLayout::Planar),
        (&interleaved[..], IqLayout::Interleaved),
    ] {
        let samples = IqSamples::Counts(counts, scale);
        let record = Record::iq(samples, layout, p.elements).unwrap();
        let record = record.with_phase(phase).unwrap();
        let mut ours = before.to_vec();
        line_into(&IqDelay::new(*p).unwrap(), line, &record, &mut ours);
        assert_same_bits(&ours, &expected, &format!("{what}, {layout:?}, {line:?}"));
    }
}

/// A scene in which a position is a number of samples.
///
/// The line is straight down from the middle of three elements, at one sample a second and a wave of 2 m/s. The
/// position at t is t − t0, the depth t.
fn plain(interpolation: IqInterpolation) -> (IqParameters, ScanLine<'static>) {
    let p = IqParameters {
        sound_speed: 2.0,
        sampling_rate: 1.0,
        demodulation_frequency: 0.3,
        output_rate: 1.0,
        output_start: 0.0,
        output_samples: 40,
        elements: 3,
        record_samples: 200,
        interpolation,
    };
    let line = ScanLine {
        compounding: Compounding::Add,
        ..ScanLine::new(
            Transmit::new(TransmitLaw::Focused, 0.0),
            Ray::down(0.0),
            Array::linear(3, 7.0),
        )
    };
    (p, line)
}

#[test]
fn fixed_point_has_the_bits_of_the_reference_where_nothing_is_above_and_far_from_t0() {
    let counts = counted(200, 5);
    let counts = &counts[..600];
    let before = noise(120, 6);
    let (p, line) = plain(IqInterpolation::LinearFixed);
    // The first sample is at depth 0; its earlier value stays.
    let mut at_five = line;
    at_five.transmit.t0 = -5.0;
    assert_reference(&p, &at_five, (counts, 0.3, 0.0), &before, "depth 0");
    // Whole samples, beyond the 64th too, and more than 2¹⁹ whole turns.
    let mut at_sixty = line;
    at_sixty.transmit.t0 = -60.0;
    for phase in [0.7, -1e7, 1e7] {
        assert_reference(&p, &at_sixty, (counts, 0.3, phase), &before, "turns");
    }
    // A negative scale: zeros have its sign.
    let replace = changed(at_five, |l| l.compounding = Compounding::Replace);
    let zeros = vec![[0; 2]; 600];
    let samples = IqSamples::Counts(&zeros, -0.3);
    let record = Record::iq(samples, IqLayout::Interleaved, 3).unwrap();
    let floats = vec![ZERO; 600];
    let (mut ours, mut expected) = (before.clone(), before.clone());
    line_into(&IqDelay::new(p).unwrap(), &replace, &record, &mut ours);
    reference::f32::iq::line(&p, &replace, (&floats, -0.3, 0.0), &mut expected);
    assert_same_bits(&ours, &expected, "scale below 0");
    // A depth equal to the largest number.
    let mut deepest = p;
    deepest.sound_speed = 2f64.powi(100);
    deepest.output_start = 2.0 * f64::from(f32::MAX) / deepest.sound_speed;
    let mut there = line;
    there.transmit.t0 = deepest.output_start - 50.0;
    assert_reference(&deepest, &there, (counts, 0.3, 0.0), &before, "deepest");
}

/// A sample read from the record, added to −0, gives 0; without one, −0 stays.
#[test]
fn positions_beyond_two_to_the_23_are_left_alone_as_in_the_reference() {
    const FAR: f64 = 8_388_608.0;
    let counts = counted(200, 5);
    let counts = &counts[..600];
    let before = vec![Complex::new(-0.0, -0.0); 120];
    for interpolation in INTERPOLATIONS
        .into_iter()
        .chain([IqInterpolation::LinearFixed])
    {
        for law in [
            TransmitLaw::Focused,
            TransmitLaw::Element { x: 0.0, z: 0.0 },
        ] {
            let (mut p, mut line) = plain(interpolation);
            line.transmit.law = law;
            // The first position, and the last one: before, at and behind the limit.
            for aside in [-45.0, -39.0, -38.0, -20.0, -1.0, 0.0, 1.0, 5.0] {
                p.output_start = 1.0;
                line.transmit.t0 = 1.0 + FAR - aside;
                let what = format!("{interpolation:?} {aside}");
                assert_reference(&p, &line, (counts, 0.3, 0.7), &before, &what);
                p.output_start = FAR + aside;
                line.transmit.t0 = 0.0;
                assert_reference(&p, &line, (counts, 0.3, 0.7), &before, &what);
            }
        }
    }
    // As many turns as the format can hold.
    for interpolation in INTERPOLATIONS {
        for demodulation_frequency in [2.0, -2.0] {
            let (mut p, mut line) = plain(interpolation);
            (p.sound_speed, p.sampling_rate, p.output_samples) = (1.0, 2.0, 1);
            p.demodulation_frequency = demodulation_frequency;
            p.output_start = f64::MAX / 2.0;
            line.transmit.t0 = p.output_start;
            let what = format!("{interpolation:?} {demodulation_frequency}");
            assert_reference(&p, &line, (counts, 0.3, 0.0), &before[..3], &what);
        }
    }
}

/// Positions grow evenly from the first sample to the last.
///
/// A further position beyond the limit has no effect.
#[test]
fn fixed_point_of_a_line_that_ends_near_the_limit_is_even() {
    let (mut p, mut line) = plain(IqInterpolation::LinearFixed);
    p.record_samples = 65_000;
    p.output_rate = 1.0 / 1000.37;
    p.output_start = 1.0;
    p.output_samples = 8386;
    line.array = Array::linear(3, 6000.0);
    let last = p.output_start + 8385.0 / p.output_rate;
    assert!(last < 8_388_608.0 && last + 1.0 / p.output_rate > 8_388_608.0);
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let counts: Vec<[i16; 2]> = (0..3 * 65_000).map(|_| rng.random()).collect();
    let before = vec![ZERO; 3 * p.output_samples];
    assert_reference(&p, &line, (&counts, 0.3, 0.0), &before, "even");
}

#[test]
fn fixed_point_reads_elements_below_8191_samples_way() {
    let (mut p, mut line) = plain(IqInterpolation::LinearFixed);
    p.elements = 1;
    // Two samples a metre.
    (p.sound_speed, p.sampling_rate) = (1.0, 2.0);
    line.active.count = 1;
    let counts = vec![[1i16, 2]; 200];
    let record = Record::iq(IqSamples::Counts(&counts, 1.0), IqLayout::Planar, 1).unwrap();
    let read = |array: Array| {
        let line = ScanLine { array, ..line };
        let mut out = vec![ZERO; p.output_samples];
        let mut scratch = vec![0.0; p.need(1).real];
        let delay = IqDelay::new(p).unwrap();
        let result = delay.line(0.0f32, &line, &record, &mut scratch, &mut out);
        match result {
            Ok(()) => Ok(out),
            Err(Error::Parameter { name, value, .. }) => Err((name, value)),
            Err(error) => panic!("{error}"),
        }
    };
    let beyond = Err(("element's way to the line", 4095.5));
    for sign in [1.0, -1.0] {
        assert!(read(Array::LinearAt(&[sign * 4095.25])).is_ok());
        assert_eq!(read(Array::LinearAt(&[sign * 4095.5])), beyond);
        // An offset along the line counts twice.
        let along = |z: f64| {
            let element = Element::down(0.0, sign * z);
            read(Array::At {
                elements: &[element],
                pitch: 1.0,
            })
        };
        assert!(along(2047.5).is_ok());
        assert_eq!(along(2047.75), beyond);
    }
    // A single element has no pitch.
    assert_eq!(
        read(Array::LinearAt(&[0.0])),
        read(Array::linear(1, 0.3e-3))
    );
}

/// Positions behind the longest record, and an element thousands of samples ahead.
///
/// The element's own positions are within the record, or still behind it.
#[test]
fn fixed_point_of_an_element_far_ahead_has_the_bits_of_the_reference() {
    let (mut p, line) = plain(IqInterpolation::LinearFixed);
    (p.elements, p.record_samples) = (1, 65_536);
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let counts: Vec<[i16; 2]> = (0..65_536).map(|_| rng.random()).collect();
    for sign in [1.0, -1.0] {
        let element = Element::down(0.0, sign * 8000.0);
        let mut line = ScanLine {
            array: Array::At {
                elements: &[element],
                pitch: 1.0,
            },
            active: Active::new(0, 1),
            ..line
        };
        for position in [-100_000.0, -66_000.0, 66_000.0, 100_000.0] {
            p.output_start = 10_000.0;
            line.transmit.t0 = p.output_start - position;
            let before = vec![ZERO; p.output_samples];
            let what = format!("{sign} {position}");
            assert_reference(&p, &line, (&counts, 0.3, 0.0), &before, &what);
        }
    }
}
