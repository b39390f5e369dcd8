//! The channel-data simulator against arrival times and a time-domain sum.
//!
//! Also the physical properties: reciprocity, superposition, shadows.

mod model;
mod noise;
mod shadow;

use crate::common::kit::*;
use bonebeam_simulate::{
    Baffle, NoiseSpectrum, Outline, Phantom, Pulse, Scatterer, Settings, Summation, add_noise,
    channel_data, visible,
};
use ndarray::Axis;
use rustfft::FftPlanner;

/// Sixteen elements and a record of 8 to 14 mm: quick to simulate.
fn small() -> Settings {
    Settings {
        elements: 16,
        beams: 16,
        depth_start: 8e-3,
        depth_end: 14e-3,
        ..Settings::default()
    }
}

fn points(points: &[(f64, f64, f64)]) -> Phantom {
    let scatterers = points
        .iter()
        .map(|&(x, z, amplitude)| Scatterer::new([x, 0.0, z], amplitude))
        .collect();
    changed(Phantom::default(), |s| s.scatterers = scatterers)
}

fn random_points(count: usize, seed: u64) -> Phantom {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
    let list: Vec<_> = (0..count)
        .map(|_| {
            (
                uniform(-3e-3, 3e-3),
                uniform(8e-3, 14e-3),
                uniform(-1.0, 1.0),
            )
        })
        .collect();
    points(&list)
}

/// A square bone of 2 mm at 9 to 11 mm, with scatterers before, beside and behind it.
fn bone_and_points() -> Phantom {
    let square = vec![[-1e-3, 9e-3], [1e-3, 9e-3], [1e-3, 11e-3], [-1e-3, 11e-3]];
    let mut phantom = points(&[(0.3e-3, 8.5e-3, 1.0), (1.6e-3, 12e-3, 1.0)]);
    phantom.bone = Some(Outline::new(vec![square]).unwrap());
    phantom
}

fn simulate(settings: &Settings, phantom: &Phantom, summation: Summation) -> ChannelData {
    channel_data(settings, phantom, summation, &|_| ()).unwrap()
}

/// All samples of the one frame.
fn rf(data: &ChannelData) -> impl Iterator<Item = &f32> {
    data.samples.rf(0).unwrap().into_iter()
}

fn whole(data: ChannelData) -> Array3<f32> {
    data.samples.rf(0).unwrap().to_owned()
}

fn row(data: &ChannelData, beam: usize, element: usize) -> Vec<f64> {
    let rf = data.samples.rf(0).unwrap();
    let row = rf.index_axis(Axis(0), beam);
    row.row(element).iter().map(|&v| f64::from(v)).collect()
}

/// Largest |a − b| relative to the largest |b|, dB.
fn error_db(a: &[f64], b: &[f64]) -> f64 {
    let peak = b.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let error = a
        .iter()
        .zip(b)
        .fold(0.0f64, |m, (x, y)| m.max((x - y).abs()));
    20.0 * (error / peak).log10()
}

/// Time of the envelope's maximum, s.
///
/// Analytic signal by the discrete Fourier transform, then a parabola through the three largest samples.
fn envelope_peak(data: &ChannelData, beam: usize, element: usize) -> f64 {
    let row = row(data, beam, element);
    let n = row.len();
    let mut signal: Vec<Complex<f64>> = row.iter().map(|&v| Complex::new(v, 0.0)).collect();
    let mut planner = FftPlanner::new();
    planner.plan_fft_forward(n).process(&mut signal);
    signal[n / 2 + 1..].fill(Complex::default());
    planner.plan_fft_inverse(n).process(&mut signal);
    let envelope: Vec<f64> = signal.iter().map(|v| v.norm()).collect();
    let k = (1..n - 1)
        .max_by(|&a, &b| envelope[a].total_cmp(&envelope[b]))
        .unwrap();
    let (a, b, c) = (envelope[k - 1], envelope[k], envelope[k + 1]);
    data.t0[beam] + (k as f64 + 0.5 * (a - c) / (a - 2.0 * b + c)) / data.fs
}

#[test]
fn echo_of_the_focus_arrives_on_time_at_every_element() {
    let settings = changed(small(), |s| s.focus = 11e-3);
    let x = settings.beam_x(5);
    let data = simulate(
        &settings,
        &points(&[(x, settings.focus, 1.0)]),
        Summation::Direct,
    );
    for (element, &ex) in data.element_x.iter().enumerate() {
        let expected = (settings.focus + settings.focus.hypot(x - ex)) / settings.c;
        let error = (envelope_peak(&data, 5, element) - expected) * data.fs;
        assert!(
            error.abs() < tolerances::ARRIVAL_SAMPLES,
            "element {element}: {error} samples"
        );
    }
}

#[test]
fn echo_of_one_transmitting_element_arrives_on_time_anywhere() {
    // An f-number large enough for one transmitting element.
    let settings = changed(small(), |s| s.f_number = 1e4);
    let (x, z) = (1.234e-3, 9.876e-3);
    for summation in [Summation::Direct, Summation::Cells] {
        let data = simulate(&settings, &points(&[(x, z, 1.0)]), summation);
        for beam in [0, 7, 15] {
            for element in [0, 8, 15] {
                let [t, r] = [beam, element].map(|e: usize| z.hypot(x - data.element_x[e]));
                let error = (envelope_peak(&data, beam, element) - (t + r) / settings.c) * data.fs;
                assert!(
                    error.abs() < tolerances::ARRIVAL_SAMPLES,
                    "{beam} {element}: {error} samples"
                );
            }
        }
    }
}

#[test]
fn beams_and_elements_lie_where_the_file_says() {
    let data = simulate(&small(), &points(&[(0.0, 11e-3, 1.0)]), Summation::Direct);
    let Transmits::Focused { x, focus, f_number } = &data.transmits else {
        panic!("the simulator transmits focused beams");
    };
    assert_eq!(x, &data.element_x);
    assert!((data.element_x[15] - 7.5 * 0.308e-3).abs() < 1e-12);
    assert!(focus.iter().all(|&z| z == 15e-3) && *f_number == Some(2.8));
}

#[test]
fn exchanging_transmitter_and_receiver_changes_nothing() {
    let settings = changed(small(), |s| s.f_number = 1e4);
    for summation in [Summation::Direct, Summation::Cells] {
        let data = simulate(&settings, &bone_and_points(), summation);
        for (i, j) in [(0, 15), (3, 9), (14, 2)] {
            let error = error_db(&row(&data, i, j), &row(&data, j, i));
            assert!(error < tolerances::RECIPROCITY_DB, "{i} {j}: {error} dB");
        }
    }
}

#[test]
fn echoes_superpose() {
    let settings = small();
    let (a, b) = (random_points(5, 1), random_points(5, 2));
    let mut both = a.clone();
    both.scatterers.extend(&b.scatterers);
    let [a, b, both] = [a, b, both].map(|phantom| simulate(&settings, &phantom, Summation::Direct));
    let sum: Vec<f64> = rf(&a)
        .zip(rf(&b))
        .map(|(&a, &b)| f64::from(a) + f64::from(b))
        .collect();
    let both: Vec<f64> = rf(&both).map(|&v| f64::from(v)).collect();
    assert!(error_db(&sum, &both) < tolerances::SUPERPOSITION_DB);
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let settings = changed(small(), |s| s.noise = Some(-40.0));
    for summation in [Summation::Direct, Summation::Cells] {
        let [one, three] = [1, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build()
                .unwrap()
                .install(|| simulate(&settings, &bone_and_points(), summation))
        });
        assert_eq!(one.samples, three.samples);
    }
}

#[test]
fn the_pulse_has_the_bandwidth_of_the_model() {
    // −6 dB of excitation and both ways at 3.93 and 5.82 MHz, for 5 MHz and 60 %.
    let pulse = Pulse::new(5e6, 0.6);
    let peak = (0..1000)
        .map(|k| pulse.spectrum(4e6 + 2e3 * f64::from(k)))
        .fold(0.0, f64::max);
    let crossing = |mut below: f64, mut above: f64| {
        for _ in 0..60 {
            let middle = 0.5 * (below + above);
            let half = pulse.spectrum(middle) < peak * 10f64.powf(-6.0 / 20.0);
            *(if half { &mut below } else { &mut above }) = middle;
        }
        above
    };
    let (low, high) = (crossing(1e6, 5e6), crossing(9e6, 5e6));
    assert!(
        (low - 3.93e6).abs() < 0.01e6 && (high - 5.82e6).abs() < 0.01e6,
        "{low} {high}"
    );
    // One way, the transducer alone is 6 dB down at f0(1 ± B/2).
    for f in [3.5e6, 6.5e6] {
        let level = 20.0 * pulse.transducer(f).log10();
        assert!((level + 6.0).abs() < 0.01, "{level}");
    }
}

#[test]
fn progress_ends_at_one() {
    let last = std::sync::Mutex::new(0.0f64);
    let progress = |done: f64| {
        let mut last = last.lock().unwrap();
        *last = last.max(done);
    };
    channel_data(&small(), &random_points(1, 1), Summation::Direct, &progress).unwrap();
    assert_eq!(*last.lock().unwrap(), 1.0);
}

#[test]
fn impossible_settings_and_phantoms_are_named() {
    let phantom = random_points(1, 1);
    let fails = |settings: Settings, phantom: &Phantom| {
        channel_data(&settings, phantom, Summation::Direct, &|_| ())
            .expect_err("an error")
            .to_string()
    };
    for (settings, name) in [
        (Settings { fs: 0.0, ..small() }, "fs"),
        (changed(small(), |s| s.fs = 19e6), "fs"),
        (changed(small(), |s| s.pitch = f64::NAN), "pitch"),
        (changed(small(), |s| s.kerf = 1.0), "kerf"),
        (changed(small(), |s| s.beams = 17), "beams"),
        (changed(small(), |s| s.elements = 1), "elements"),
        (changed(small(), |s| s.f_number = 0.0), "f_number"),
        (changed(small(), |s| s.depth_end = 1e-3), "depth"),
        (changed(small(), |s| s.noise = Some(f64::INFINITY)), "noise"),
    ] {
        let message = fails(settings, &phantom);
        assert!(message.contains(name), "{name}: {message}");
    }
    assert!(fails(small(), &points(&[(0.0, 0.0, 1.0)])).contains("phantom"));
    assert!(fails(small(), &points(&[(f64::NAN, 1e-2, 1.0)])).contains("phantom"));
}
