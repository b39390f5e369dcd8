//! The channel-data simulator against arrival times, an independent sum in the time domain, and
//! what physics demands: reciprocity, superposition, shadows.

use crate::common;

use std::f64::consts::PI;

use bonebeam_files::{ChannelData, Transmits};
use bonebeam_simulate::{
    Baffle, NoiseSpectrum, Outline, Phantom, Pulse, Scatterer, Settings, Summation, add_noise,
    channel_data, visible,
};
use common::tolerances;
use ndarray::{Array3, Axis};
use num_complex::Complex;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
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
        .map(|&(x, z, amplitude)| Scatterer {
            x,
            y: 0.0,
            z,
            amplitude,
        })
        .collect();
    Phantom {
        scatterers,
        ..Phantom::default()
    }
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

/// Time of the envelope's largest value, s: analytic signal by the discrete Fourier transform,
/// a parabola through the three largest samples.
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
    let settings = Settings {
        focus: 11e-3,
        ..small()
    };
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
    // An f-number so large that one element transmits.
    let settings = Settings {
        f_number: 1e4,
        ..small()
    };
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

/// The pulse in the time domain: the closed form of h ∗ h, integrated over the square wave's
/// half-periods by Simpson's rule, at multiples of half a nanosecond.
struct TimePulse {
    step: f64,
    samples: Vec<f64>,
}

impl TimePulse {
    fn new(f0: f64, bandwidth: f64) -> Self {
        let a = (PI * f0 * bandwidth).powi(2) / (4.0 * 10f64.powf(6.0 / 20.0).ln());
        let w = 2.0 * PI * f0;
        let hh = |t: f64| (-a * t * t / 2.0).exp() * ((w * t).cos() + (-w * w / (2.0 * a)).exp());
        let step = 0.5e-9;
        let half = 4000i32;
        let margin = (0.75 / f0 / step).round() as i32;
        let mut integral = vec![0.0];
        for k in -half - margin..half + margin {
            let t = f64::from(k) * step;
            let simpson = hh(t) + 4.0 * hh(t + 0.5 * step) + hh(t + step);
            integral.push(integral.last().unwrap() + simpson * step / 6.0);
        }
        let quarter = (0.25 / f0 / step).round() as usize;
        let samples: Vec<f64> = (0..=2 * half as usize)
            .map(|k| {
                let at = |quarters: i32| {
                    integral[(k as i32 + margin + quarters * quarter as i32) as usize]
                };
                // + in the middle half-period, − in the outer two.
                2.0 * (at(1) - at(-1)) - (at(3) - at(-3))
            })
            .collect();
        let peak = samples[half as usize];
        TimePulse {
            step,
            samples: samples.iter().map(|v| v / peak).collect(),
        }
    }

    /// Cubic Lagrange interpolation: 2e-9 of the peak for 5 MHz at half a nanosecond.
    fn at(&self, t: f64) -> f64 {
        let u = t / self.step + (self.samples.len() / 2) as f64;
        let k = u.floor();
        if k < 1.0 || k + 3.0 > self.samples.len() as f64 {
            return 0.0;
        }
        let (f, k) = (u - k, k as usize);
        let s = &self.samples[k - 1..k + 3];
        -f * (f - 1.0) * (f - 2.0) / 6.0 * s[0] + (f + 1.0) * (f - 1.0) * (f - 2.0) / 2.0 * s[1]
            - (f + 1.0) * f * (f - 2.0) / 2.0 * s[2]
            + (f + 1.0) * f * (f - 1.0) / 6.0 * s[3]
    }
}

/// Six nodes of Gauss's quadrature over (−1, 1), and half their weights.
const GAUSS: [(f64, f64); 6] = [
    (-0.932469514203152, 0.0856622461895852),
    (-0.661209386466265, 0.1803807865240693),
    (-0.238619186083197, 0.2339569672863455),
    (0.238619186083197, 0.2339569672863455),
    (0.661209386466265, 0.1803807865240693),
    (0.932469514203152, 0.0856622461895852),
];

/// One row straight from the model, in the time domain and f64: each element is a row of strips across
/// its width, in its far field, and a column of strips along its height.
fn reference_row(
    settings: &Settings,
    phantom: &Phantom,
    data: &ChannelData,
    l: usize,
    j: usize,
) -> Vec<f64> {
    let pulse = TimePulse::new(settings.f0, settings.bandwidth);
    let (c, focus) = (settings.c, settings.focus);
    let width = settings.pitch - settings.kerf;
    // 17 elements at F# 2.8 and 15 mm, centred on the beam's own element.
    let aperture = (l as i32 - 8).max(0)..(l as i32 + 9).min(settings.elements as i32);
    // Of every strip of an element: when it hears the scatterer, and how much of it.
    let strips = |s: &Scatterer, e: usize| -> Vec<(f64, f64)> {
        let dx = s.x - data.element_x[e];
        let range = (dx * dx + s.y * s.y + s.z * s.z).sqrt();
        let obliquity = match settings.baffle {
            Baffle::Rigid => 1.0,
            Baffle::Soft => s.z / range,
        };
        let mut strips = Vec::new();
        for (u, wu) in GAUSS {
            let across = 0.5 * width * u * dx / range;
            if settings.element_height == 0.0 {
                strips.push(((range + across) / c, wu * obliquity / range));
                continue;
            }
            // Three panels of six nodes over the height.
            for (v, wv) in (0..3)
                .flat_map(|p| GAUSS.map(|(v, w)| ((v + 2.0 * f64::from(p) - 2.0) / 3.0, w / 3.0)))
            {
                let strip = 0.5 * settings.element_height * v;
                let other = (dx * dx + s.z * s.z + (s.y - strip).powi(2)).sqrt();
                let lens = settings.elevation_focus.map_or(0.0, |f| strip.hypot(f) - f);
                strips.push(((other + across - lens) / c, wu * wv * obliquity / other));
            }
        }
        strips
    };
    let mut echoes = Vec::new();
    for s in &phantom.scatterers {
        let receive = strips(s, j);
        for i in aperture.clone().map(|i| i as usize) {
            let dx = data.element_x[i] - data.element_x[l];
            let advance = ((dx * dx + focus * focus).sqrt() - focus) / c;
            for (t, gt) in strips(s, i) {
                for (r, gr) in &receive {
                    echoes.push((t + r - advance, s.amplitude * gt * gr));
                }
            }
        }
    }
    (0..data.samples.dim().3)
        .map(|n| {
            let t = data.t0[l] + n as f64 / settings.fs;
            echoes
                .iter()
                .map(|(at, gain)| gain * pulse.at(t - at))
                .sum()
        })
        .collect()
}

#[test]
fn both_sums_agree_with_the_model_in_the_time_domain() {
    let flat = Settings {
        elements: 32,
        beams: 32,
        ..small()
    };
    let with_lens = Settings {
        element_height: 4e-3,
        elevation_focus: Some(19e-3),
        baffle: Baffle::Soft,
        ..flat.clone()
    };
    // The reference's strips make a row with a lens cost what hundreds without do.
    let all = [(16, 16), (3, 30), (31, 0)];
    for (settings, count, rows) in [(flat, 12, &all[..]), (with_lens, 2, &all[1..2])] {
        let mut phantom = random_points(count, 3);
        if settings.element_height > 0.0 {
            for (s, y) in phantom.scatterers.iter_mut().zip([-0.4e-3, 1.4e-3]) {
                s.y = y;
            }
        }
        let direct = simulate(&settings, &phantom, Summation::Direct);
        let cells = simulate(&settings, &phantom, Summation::Cells);
        for &(l, j) in rows {
            let reference = reference_row(&settings, &phantom, &direct, l, j);
            let error = error_db(&row(&direct, l, j), &reference);
            println!("{l} {j}: direct {error} dB");
            assert!(error < tolerances::DIRECT_SUM_DB, "{l} {j}: {error} dB");
            let error = error_db(&row(&cells, l, j), &reference);
            println!("{l} {j}: cells {error} dB");
            assert!(error < tolerances::CELL_SUM_DB, "{l} {j}: {error} dB");
        }
    }
}

#[test]
fn cells_sum_agrees_with_direct_at_other_rates_and_for_beams_between_elements() {
    for fs in [25e6, 40e6, 62.5e6] {
        let settings = Settings {
            fs,
            beams: 7,
            first_beam: 2.25,
            beam_step: 1.5,
            ..small()
        };
        let phantom = random_points(20, 4);
        let direct = simulate(&settings, &phantom, Summation::Direct);
        let cells = simulate(&settings, &phantom, Summation::Cells);
        let all = |d: &ChannelData| rf(d).map(|&v| f64::from(v)).collect::<Vec<_>>();
        let error = error_db(&all(&cells), &all(&direct));
        println!("{fs}: {error} dB");
        assert!(error < tolerances::CELL_SUM_DB, "{fs}: {error} dB");
    }
}

/// The cells' sum takes beams first where they are few, and pairs of elements where they are many.
#[test]
fn a_beam_has_the_same_record_alone_and_among_others() {
    let all = Settings {
        elements: 32,
        beams: 32,
        ..small()
    };
    let one = Settings {
        beams: 1,
        first_beam: 5.0,
        ..all.clone()
    };
    let phantom = random_points(20, 6);
    let [all, one] = [all, one].map(|s| simulate(&s, &phantom, Summation::Cells));
    for element in [0, 5, 31] {
        let error = error_db(&row(&one, 0, element), &row(&all, 5, element));
        assert!(error < tolerances::CELL_SUM_DB, "{element}: {error} dB");
    }
}

/// The record of the quarter of a metre that no grid may be too short for.
#[test]
fn deep_echoes_are_heard_at_every_frequency() {
    for (f0, depth) in [(5e6, 0.1), (5e6, 0.19), (7.5e6, 0.12), (15e6, 0.08)] {
        let settings = Settings {
            f0,
            fs: 80e6,
            depth_start: depth - 3e-3,
            depth_end: depth + 3e-3,
            focus: depth,
            ..small()
        };
        let phantom = points(&[(0.1e-3, depth, 1.0)]);
        let cells = simulate(&settings, &phantom, Summation::Cells);
        let direct = simulate(&settings, &phantom, Summation::Direct);
        let error = error_db(&row(&cells, 8, 3), &row(&direct, 8, 3));
        assert!(error < tolerances::CELL_SUM_DB, "{f0} {depth}: {error} dB");
        let found = envelope_peak(&cells, 8, 8);
        let dx = [8usize].map(|e| cells.element_x[e] - 0.1e-3)[0];
        // The focus lies beside the beam by 0.05 mm: the wave is there after its depth, to 1e-10 s.
        let expected = (depth + depth.hypot(dx)) / settings.c;
        assert!((found - expected).abs() * settings.fs < 0.1, "{f0} {depth}");
    }
}

/// Echoes from below the record come after its end. A transform's window is periodic, and must not show
/// them at its beginning.
#[test]
fn late_echoes_do_not_come_back_early() {
    let settings = Settings {
        depth_start: 12e-3,
        depth_end: 18e-3,
        elements: 128,
        beams: 3,
        first_beam: 0.0,
        ..Settings::default()
    };
    let x = settings.array().x(64.0);
    let phantom = points(&[(x, 15e-3, 1.0), (x, 24e-3, 1.0), (x, 40e-3, 1.0)]);
    // The same with a record so long that it holds them all.
    let long = Settings {
        depth_end: 60e-3,
        ..settings.clone()
    };
    for summation in [Summation::Direct, Summation::Cells] {
        let short = simulate(&settings, &phantom, summation);
        let long = simulate(&long, &phantom, summation);
        let samples = short.samples.dim().3;
        for l in 0..3 {
            for j in 0..128 {
                let whole = row(&long, l, j);
                let peak = whole.iter().fold(0.0f64, |m, v| m.max(v.abs()));
                let worst = (row(&short, l, j).iter().zip(&whole[..samples]))
                    .fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
                let error = 20.0 * (worst / peak).log10();
                assert!(
                    error < tolerances::WINDOW_DB,
                    "{summation:?} {l} {j}: {error} dB"
                );
            }
        }
    }
}

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

/// Noise and converter come to a record of their own as they do within a simulation: to the bit.
#[test]
fn noise_can_be_added_afterwards() {
    let noisy = Settings {
        noise: Some(-30.0),
        adc_bits: Some(10),
        seed: 7,
        ..small()
    };
    let phantom = points(&[(0.0, 11e-3, 1.0)]);
    let expected = simulate(&noisy, &phantom, Summation::Direct);
    let quiet = Settings {
        noise: None,
        adc_bits: None,
        ..noisy.clone()
    };
    let mut found = simulate(&quiet, &phantom, Summation::Direct);
    assert_ne!(found, expected);
    add_noise(&noisy, &mut found).unwrap();
    assert_eq!(found, expected);
    let other = Settings {
        beams: noisy.beams + 1,
        ..noisy
    };
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
            &Settings {
                noise: None,
                ..settings.clone()
            },
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
    let settings = Settings {
        adc_bits: Some(8),
        ..small()
    };
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
fn exchanging_transmitter_and_receiver_changes_nothing() {
    let settings = Settings {
        f_number: 1e4,
        ..small()
    };
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

/// A square bone of 2 mm at 9 to 11 mm, with scatterers before, beside and behind it.
fn bone_and_points() -> Phantom {
    let square = vec![[-1e-3, 9e-3], [1e-3, 9e-3], [1e-3, 11e-3], [-1e-3, 11e-3]];
    let mut phantom = points(&[(0.3e-3, 8.5e-3, 1.0), (1.6e-3, 12e-3, 1.0)]);
    phantom.bone = Some(Outline::new(vec![square]).unwrap());
    phantom
}

#[test]
fn a_shadowed_scatterer_contributes_nothing() {
    let settings = small();
    for summation in [Summation::Direct, Summation::Cells] {
        let without = simulate(&settings, &bone_and_points(), summation);
        let mut phantom = bone_and_points();
        // Right behind the bone: the outermost elements at ±2.3 mm do not see it.
        phantom.scatterers.push(Scatterer {
            x: 0.0,
            y: 0.0,
            z: 11.2e-3,
            amplitude: 100.0,
        });
        assert_eq!(
            simulate(&settings, &phantom, summation).samples,
            without.samples
        );
        phantom.bone = None;
        assert_ne!(
            simulate(&settings, &phantom, summation).samples,
            without.samples
        );
    }
}

#[test]
fn each_element_sees_past_the_edge_on_its_own() {
    // One element transmits; the scatterer behind the right edge is seen from the right only.
    let settings = Settings {
        f_number: 1e4,
        ..small()
    };
    let mut phantom = bone_and_points();
    phantom.scatterers = vec![Scatterer {
        y: 0.0,
        x: 1.15e-3,
        z: 12.5e-3,
        amplitude: 1.0,
    }];
    let bone = phantom.bone.clone().unwrap();
    let data = simulate(&settings, &phantom, Summation::Direct);
    let seen = visible(&bone, &data.element_x, &[[1.15e-3, 12.5e-3]]);
    for (element, x) in data.element_x.iter().enumerate() {
        // The straight line passes the corners (1, 9) and (1, 11) mm on the right.
        let at = |z: f64| x + (1.15e-3 - x) * z / 12.5e-3;
        let expected = at(9e-3) > 1e-3 && at(11e-3) > 1e-3;
        assert_eq!(seen[element][0], expected, "element {element}");
        let echo = row(&data, element, element);
        assert_eq!(echo.iter().any(|&v| v != 0.0), expected);
    }
    assert!(!seen[0][0] && seen[15][0]);
}

#[test]
fn noise_has_its_level_and_is_reproducible() {
    let quiet = small();
    let noisy = Settings {
        noise: Some(-40.0),
        ..quiet.clone()
    };
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
    // Rows are independent: their correlation is that of chance.
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

#[test]
fn the_number_of_threads_changes_no_bit() {
    let settings = Settings {
        noise: Some(-40.0),
        ..small()
    };
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
        (
            Settings {
                fs: 19e6,
                ..small()
            },
            "fs",
        ),
        (
            Settings {
                pitch: f64::NAN,
                ..small()
            },
            "pitch",
        ),
        (
            Settings {
                kerf: 1.0,
                ..small()
            },
            "kerf",
        ),
        (
            Settings {
                beams: 17,
                ..small()
            },
            "beams",
        ),
        (
            Settings {
                elements: 1,
                ..small()
            },
            "elements",
        ),
        (
            Settings {
                f_number: 0.0,
                ..small()
            },
            "f_number",
        ),
        (
            Settings {
                depth_end: 1e-3,
                ..small()
            },
            "depth",
        ),
        (
            Settings {
                noise: Some(f64::INFINITY),
                ..small()
            },
            "noise",
        ),
    ] {
        let message = fails(settings, &phantom);
        assert!(message.contains(name), "{name}: {message}");
    }
    assert!(fails(small(), &points(&[(0.0, 0.0, 1.0)])).contains("phantom"));
    assert!(fails(small(), &points(&[(f64::NAN, 1e-2, 1.0)])).contains("phantom"));
}
