//! Records against the model, computed in the time domain.

use super::*;

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

/// One row directly from the model, in the time domain and f64.
///
/// Each element is a row of patches across its width, in its far field, and a column of patches along its height.
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
    // For every patch of an element: arrival time and amplitude of the scatterer's echo.
    let patches = |s: &Scatterer, e: usize| -> Vec<(f64, f64)> {
        let dx = s.x - data.element_x[e];
        let range = (dx * dx + s.y * s.y + s.z * s.z).sqrt();
        let obliquity = match settings.baffle {
            Baffle::Rigid => 1.0,
            Baffle::Soft => s.z / range,
        };
        let mut patches = Vec::new();
        for (u, wu) in GAUSS {
            let across = 0.5 * width * u * dx / range;
            if settings.element_height == 0.0 {
                patches.push(((range + across) / c, wu * obliquity / range));
                continue;
            }
            // Three panels of six nodes over the height.
            for (v, wv) in (0..3)
                .flat_map(|p| GAUSS.map(|(v, w)| ((v + 2.0 * f64::from(p) - 2.0) / 3.0, w / 3.0)))
            {
                let patch = 0.5 * settings.element_height * v;
                let other = (dx * dx + s.z * s.z + (s.y - patch).powi(2)).sqrt();
                let lens = settings.elevation_focus.map_or(0.0, |f| patch.hypot(f) - f);
                patches.push(((other + across - lens) / c, wu * wv * obliquity / other));
            }
        }
        patches
    };
    let mut echoes = Vec::new();
    for s in &phantom.scatterers {
        let receive = patches(s, j);
        for i in aperture.clone().map(|i| i as usize) {
            let dx = data.element_x[i] - data.element_x[l];
            let advance = ((dx * dx + focus * focus).sqrt() - focus) / c;
            for (t, gt) in patches(s, i) {
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
    let flat = changed(small(), |s| (s.elements, s.beams) = (32, 32));
    let with_lens = Settings {
        element_height: 4e-3,
        elevation_focus: Some(19e-3),
        baffle: Baffle::Soft,
        ..flat.clone()
    };
    // With a lens the reference's patches make a row as slow as hundreds of rows without one.
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

/// The sum by cells starts with beams if they are few, else with pairs of elements.
#[test]
fn a_beam_has_the_same_record_alone_and_among_others() {
    let all = changed(small(), |s| (s.elements, s.beams) = (32, 32));
    let one = changed(all.clone(), |s| (s.beams, s.first_beam) = (1, 5.0));
    let phantom = random_points(20, 6);
    let [all, one] = [all, one].map(|s| simulate(&s, &phantom, Summation::Cells));
    for element in [0, 5, 31] {
        let error = error_db(&row(&one, 0, element), &row(&all, 5, element));
        assert!(error < tolerances::CELL_SUM_DB, "{element}: {error} dB");
    }
}

/// The record of 0.25 m for which no grid may be too short.
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
        // The focus is 0.05 mm beside the beam: the wave arrives at the time of its depth, to 1e-10 s.
        let expected = (depth + depth.hypot(dx)) / settings.c;
        assert!((found - expected).abs() * settings.fs < 0.1, "{f0} {depth}");
    }
}

/// Echoes from below the record come after its end.
///
/// A transform's window is periodic: such echoes must not wrap to its beginning.
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
    // The same with a record that is long enough for all of them.
    let long = changed(settings.clone(), |s| s.depth_end = 60e-3);
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
