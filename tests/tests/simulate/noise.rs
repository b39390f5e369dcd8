//! Noise, and the converter.

use super::*;

#[test]
fn a_silent_record_is_an_error() {
    // Above the record, beneath it, and behind a bone that hides it from every element.
    let square = vec![[-8e-3, 9e-3], [8e-3, 9e-3], [8e-3, 9.5e-3], [-8e-3, 9.5e-3]];
    let mut hidden = points(&[(0.0, 12e-3, 1.0)]);
    hidden.bone = Some(Outline::new(vec![square]).unwrap());
    for phantom in [
        points(&[(0.0, 2e-3, 1.0)]),
        points(&[(0.0, 60e-3, 1.0)]),
        hidden,
        Phantom::default(),
    ] {
        for summation in [Summation::Direct, Summation::Cells] {
            let outcome = channel_data(&small(), &phantom, summation, &|_| ());
            let message = outcome.expect_err("silence").to_string();
            assert!(message.contains("silent"), "{message}");
        }
    }
}

/// Noise and converter, applied later, give the bits of a simulation with both.
#[test]
fn noise_can_be_added_afterwards() {
    let noisy = changed(small(), |s| {
        (s.noise, s.adc_bits, s.seed) = (Some(-30.0), Some(10), 7)
    });
    let phantom = points(&[(0.0, 11e-3, 1.0)]);
    let expected = simulate(&noisy, &phantom, Summation::Direct);
    let quiet = changed(noisy.clone(), |s| (s.noise, s.adc_bits) = (None, None));
    let mut found = simulate(&quiet, &phantom, Summation::Direct);
    assert_ne!(found, expected);
    add_noise(&noisy, &mut found).unwrap();
    assert_eq!(found, expected);
    let other = changed(noisy, |s| s.beams += 1);
    let error = add_noise(&other, &mut found).unwrap_err().to_string();
    assert!(error.contains("expected RF of one frame"), "{error}");
}

/// An amplifier's noise reaches to three times the centre frequency, a transducer's does not.
#[test]
fn noise_has_the_spectrum_that_is_asked_for() {
    let share_above = |noise_spectrum: NoiseSpectrum| {
        let settings = Settings {
            noise: Some(0.0),
            noise_spectrum,
            ..small()
        };
        let phantom = points(&[(0.0, 11e-3, 1.0)]);
        let mut noise = whole(simulate(&settings, &phantom, Summation::Direct));
        noise -= &whole(simulate(
            &changed(settings.clone(), |s| s.noise = None),
            &phantom,
            Summation::Direct,
        ));
        let samples = noise.dim().2;
        let (mut above, mut all) = (0.0, 0.0);
        let mut planner = FftPlanner::new();
        for line in noise.rows() {
            let mut x: Vec<Complex<f64>> = line.iter().map(|&v| f64::from(v).into()).collect();
            planner.plan_fft_forward(samples).process(&mut x);
            for (k, v) in x[..samples / 2].iter().enumerate() {
                all += v.norm_sqr();
                if k as f64 * settings.fs / samples as f64 > 9e6 {
                    above += v.norm_sqr();
                }
            }
        }
        above / all
    };
    // Flat from 0.5 to 15 MHz: 6 of 14.5 lie above 9 MHz. 256 rows of some hundred values: within 2 %.
    let amplifier = share_above(NoiseSpectrum::Amplifier);
    assert!((amplifier - 6.0 / 14.5).abs() < 0.02, "{amplifier}");
    // −31 dB at 9 MHz one way.
    assert!(share_above(NoiseSpectrum::Transducer) < 0.01);
}

#[test]
fn the_converter_rounds_to_its_steps() {
    let settings = changed(small(), |s| s.adc_bits = Some(8));
    let exact = whole(simulate(&small(), &random_points(5, 1), Summation::Direct));
    let rounded = whole(simulate(&settings, &random_points(5, 1), Summation::Direct));
    let peak = exact.iter().fold(0.0f32, |m, v| m.max(v.abs()));
    let step = peak / 127.0;
    for (a, b) in exact.iter().zip(&rounded) {
        let level = b / step;
        // f32 levels up to 127: 1e-5.
        assert!((level - level.round()).abs() < 2e-5 && (a - b).abs() < 0.5001 * step);
    }
}

#[test]
fn noise_has_its_level_and_is_reproducible() {
    let quiet = small();
    let noisy = changed(quiet.clone(), |s| s.noise = Some(-40.0));
    let phantom = points(&[(0.0, 11e-3, 1.0)]);
    let clean = simulate(&quiet, &phantom, Summation::Direct);
    let clean = clean.samples.rf(0).unwrap();
    let noisy_data = simulate(&noisy, &phantom, Summation::Direct);
    let data = noisy_data.samples.rf(0).unwrap();
    let peak = clean.iter().fold(0.0f32, |m, v| m.max(v.abs()));
    let noise = &data - &clean;
    let rms =
        (noise.iter().map(|&v| f64::from(v).powi(2)).sum::<f64>() / noise.len() as f64).sqrt();
    let level = 20.0 * (rms / f64::from(peak)).log10();
    assert!(
        (level + 40.0).abs() < tolerances::NOISE_LEVEL_DB,
        "{level} dB"
    );
    // Rows are independent: their correlation is only that of random rows.
    let first = noise.index_axis(Axis(0), 0);
    let (a, b) = (first.row(0), first.row(1));
    let correlation = (&a * &b).sum() / ((&a * &a).sum() * (&b * &b).sum()).sqrt();
    assert!(correlation.abs() < 0.5, "{correlation}");

    let again = simulate(&noisy, &phantom, Summation::Direct);
    assert_eq!(again.samples, noisy_data.samples);
    let other = Settings { seed: 2, ..noisy };
    let other = simulate(&other, &phantom, Summation::Direct);
    assert_ne!(other.samples, noisy_data.samples);
}
