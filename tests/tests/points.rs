//! Points beside the lines: what an adaptive beamformer loses of them, with and without sub-lines.

use bonebeam_drive::config::{Beamform, LineKind};
use bonebeam_drive::frame::beamform_channel_data;
use bonebeam_drive::methods::MethodName;
use bonebeam_files::{BeamformedLines, ChannelData, Samples, Transmits};
use ndarray::{Array3, Array4};
use num_complex::Complex;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use std::f64::consts::{PI, TAU};

const C: f64 = 1540.0;
const ELEMENTS: usize = 64;
/// The depth of the point, wavelengths.
const DEPTH: f64 = 80.0;
/// Samples a period in the records.
const RATE: f64 = 8.0;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Geometry {
    /// Five plane waves, pitch of a wavelength, lines straight down.
    Linear,
    /// Five diverging waves, pitch of half a wavelength, a sector.
    Sector,
    /// Five diverging waves, pitch of a wavelength, lines along the normals.
    Curved,
}

const GEOMETRIES: [Geometry; 3] = [Geometry::Linear, Geometry::Sector, Geometry::Curved];

/// A record of one point, `beside` line spacings to the right of the middle line.
struct Point {
    geometry: Geometry,
    f0: f64,
    /// The ratio of the pulse's power at its peak to that of the noise, dB.
    snr: f64,
    lines: usize,
    beside: f64,
    iq: bool,
}

impl Point {
    fn wavelength(&self) -> f64 {
        C / self.f0
    }

    fn radius(&self) -> f64 {
        100.0 * self.wavelength()
    }

    fn pitch(&self) -> f64 {
        self.wavelength()
            * if self.geometry == Geometry::Sector {
                0.5
            } else {
                1.0
            }
    }

    /// The position of the point, m.
    fn position(&self) -> [f64; 2] {
        let depth = DEPTH * self.wavelength();
        let along = (ELEMENTS - 1) as f64 * self.pitch();
        let steps = (self.lines - 1) as f64;
        match self.geometry {
            Geometry::Linear => [self.beside * along / steps, depth],
            Geometry::Sector => {
                let angle = self.beside * PI / 2.0 / steps;
                [depth * angle.sin(), depth * angle.cos()]
            }
            Geometry::Curved => {
                let angle = self.beside * along / self.radius() / steps;
                let reach = self.radius() + depth;
                [reach * angle.sin(), reach * angle.cos() - self.radius()]
            }
        }
    }

    fn element(&self, m: usize) -> [f64; 2] {
        let along = (m as f64 - (ELEMENTS - 1) as f64 / 2.0) * self.pitch();
        match self.geometry {
            Geometry::Curved => {
                let angle = along / self.radius();
                [
                    self.radius() * angle.sin(),
                    self.radius() * (angle.cos() - 1.0),
                ]
            }
            _ => [along, 0.0],
        }
    }

    fn transmits(&self) -> Transmits {
        let five = [-2.0, -1.0, 0.0, 1.0, 2.0];
        let sources = |step: f64, z: f64| Transmits::VirtualSource {
            x: five.map(|k| k * step).to_vec(),
            z: vec![z; 5],
        };
        match self.geometry {
            Geometry::Linear => Transmits::Plane {
                angle: five.map(|k| k * 0.0524).to_vec(),
            },
            Geometry::Sector => sources(4.0 * self.wavelength(), -20.0 * self.wavelength()),
            Geometry::Curved => sources(4.0 * self.wavelength(), -self.radius()),
        }
    }

    fn record(&self) -> ChannelData {
        let [x, z] = self.position();
        let transmits = self.transmits();
        let fs = RATE * self.f0;
        let samples = (3.2 * DEPTH * RATE) as usize;
        // 6 dB below its peak at 0.7 and 1.3 f0.
        let a = (PI * self.f0 * 0.6).powi(2) / (4.0 * 10f64.powf(6.0 / 20.0).ln());
        let sent = |t: usize| match &transmits {
            Transmits::Plane { angle } => x * angle[t].sin() + z * angle[t].cos(),
            Transmits::VirtualSource { x: sx, z: sz } => {
                (x - sx[t]).hypot(z - sz[t]) - sx[t].hypot(sz[t])
            }
            _ => unreachable!("no other"),
        };
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let sigma = 10f64.powf(-self.snr / 20.0) / 2f64.sqrt();
        let mut noise = || {
            let sum: f64 = (0..12).map(|_| random.random::<f64>()).sum();
            sigma * (sum - 6.0)
        };
        let arrival = |t: usize, m: usize| {
            let [ex, ez] = self.element(m);
            (sent(t) + (x - ex).hypot(z - ez)) / C
        };
        let samples: Samples = if self.iq {
            let shape = (1, transmits.len(), ELEMENTS, samples);
            let iq = Array4::from_shape_fn(shape, |(_, t, m, n)| {
                let tau = arrival(t, m);
                let u = n as f64 / fs - tau;
                let echo = Complex::cis(-TAU * self.f0 * tau) * (-a * u * u).exp();
                let value = echo + Complex::new(noise(), noise());
                Complex::new(value.re as f32, value.im as f32)
            });
            Samples::Iq {
                iq,
                f_demod: self.f0,
            }
        } else {
            let shape = (transmits.len(), ELEMENTS, samples);
            let rf = Array3::from_shape_fn(shape, |(t, m, n)| {
                let u = n as f64 / fs - arrival(t, m);
                let echo = (-a * u * u).exp() * (TAU * self.f0 * u).cos();
                (echo + noise()) as f32
            });
            rf.into()
        };
        let positions: Vec<[f64; 2]> = (0..ELEMENTS).map(|m| self.element(m)).collect();
        let curved = self.geometry == Geometry::Curved;
        ChannelData {
            samples,
            fs,
            t0: vec![0.0; transmits.len()],
            element_x: positions.iter().map(|position| position[0]).collect(),
            element_z: curved.then(|| positions.iter().map(|position| position[1]).collect()),
            element_angle: None,
            c: C,
            f0: self.f0,
            transmits,
            lens_delay: 0.0,
        }
    }

    fn lines(&self, section: &Beamform, sub_lines: usize) -> BeamformedLines {
        let depth = DEPTH * self.wavelength();
        let section = Beamform {
            line_count: Some(self.lines),
            lines: Some(match self.geometry {
                Geometry::Linear => LineKind::Down,
                Geometry::Sector => LineKind::Sector,
                Geometry::Curved => LineKind::Normals,
            }),
            sub_lines,
            depth_start: Some(0.93 * depth),
            depth_end: Some(1.05 * depth),
            ..section.clone()
        };
        beamform_channel_data(&self.record(), &section, &|_| {}).expect("lines")
    }

    /// The level of the point, dB, and how far its peak lies beside it, m.
    fn peak(&self, section: &Beamform, sub_lines: usize) -> [f64; 2] {
        let lines = self.lines(section, sub_lines);
        let largest = lines.z.indexed_iter().max_by(|(_, a), (_, b)| {
            let power = |z: &Complex<f32>| z.norm_sqr();
            power(a).total_cmp(&power(b))
        });
        let ((beam, sample), z) = largest.expect("a sample");
        let depth = C * (lines.t0 + sample as f64 / lines.fs) / 2.0;
        let (begin, angle) = match &lines.rays {
            None => (0.0, 0.0),
            Some(rays) => (rays.z[beam], rays.angle[beam]),
        };
        let x = lines.beam_x[beam] + depth * angle.sin();
        let [point_x, _] = self.position();
        let _ = begin;
        [20.0 * f64::from(z.norm()).log10(), (x - point_x).abs()]
    }
}

fn section(method: MethodName) -> Beamform {
    Beamform {
        method,
        ..Beamform::default()
    }
}

/// What a point loses beside a line, in dB, of its level on the line; and how far beside it the peak lies, m.
fn loss(point: &Point, method: MethodName, sub_lines: usize) -> [f64; 2] {
    let on = Point {
        beside: 0.0,
        ..*point
    };
    let section = section(method);
    let [level, _] = on.peak(&section, 1);
    let [beside, off] = point.peak(&section, sub_lines);
    [level - beside, off]
}

/// A line an element, or two where lines fan out; a point half way between two: without sub-lines it is lost, with 16 and 32 it is there, by RF and
/// I/Q. The nearest of 16 sub-lines lies 1/32 of the spacing away, of 32 half as far.
#[test]
fn a_point_between_two_lines_keeps_its_level() {
    for geometry in GEOMETRIES {
        for iq in [false, true] {
            let point = Point {
                geometry,
                f0: 5e6,
                snr: 40.0,
                lines: match geometry {
                    Geometry::Linear => ELEMENTS - 1,
                    // They are two pitches apart at the depth of the point.
                    _ => 2 * ELEMENTS - 1,
                },
                beside: 0.5,
                iq,
            };
            for method in [MethodName::Mv, MethodName::EsmvRank1] {
                let [alone, _] = loss(&point, method, 1);
                let name = format!("{geometry:?} {method:?} I/Q {iq}");
                assert!(alone > 6.0, "{name}: {alone} dB");
                for (sub_lines, bound) in [(16, 2.5), (32, 1.0)] {
                    let [with, off] = loss(&point, method, sub_lines);
                    assert!(with < bound, "{name}, {sub_lines}: {with} dB");
                    assert!(off < 0.02e-3, "{name}, {sub_lines}: {off} m");
                }
            }
            let [das, _] = loss(&point, MethodName::Das, 16);
            // What the transmits lose, which focus on the line.
            assert!(das.abs() < 0.5, "{geometry:?} DAS: {das} dB");
        }
    }
}

/// For each geometry and frequency the largest loss at a quarter and at a half of the line spacing, and how far beside the
/// point its peak lies at most.
#[test]
#[ignore = "prints a table"]
fn table_of_points_beside_the_lines() {
    println!(
        "| geometry | f0, MHz | SNR, dB | lines, sub-lines | MV, dB | rank 1, dB | beside, mm |"
    );
    println!("|---|---|---|---|---|---|---|");
    for geometry in GEOMETRIES {
        for f0 in [3e6, 5e6, 7.5e6, 10e6, 15e6] {
            for snr in [10.0, 40.0] {
                let point = |lines, beside| Point {
                    geometry,
                    f0,
                    snr,
                    lines,
                    beside,
                    iq: false,
                };
                let methods = [MethodName::Mv, MethodName::EsmvRank1].map(section);
                let on = methods
                    .each_ref()
                    .map(|method| point(127, 0.0).peak(method, 1)[0]);
                for (lines, sub_lines) in [(127, 1), (127, 8), (63, 1), (63, 16), (63, 32)] {
                    let (mut losses, mut off) = ([0.0f64; 2], 0.0f64);
                    for beside in [0.25, 0.5] {
                        let point = point(lines, beside);
                        let methods = methods.iter().zip(&on);
                        for (loss, (method, on)) in losses.iter_mut().zip(methods) {
                            let [level, beside] = point.peak(method, sub_lines);
                            *loss = loss.max(on - level);
                            off = off.max(beside);
                        }
                    }
                    println!(
                        "| {geometry:?} | {} | {snr} | {lines}, {sub_lines} | {:.1} | {:.1} | {:.3} |",
                        f0 / 1e6,
                        losses[0],
                        losses[1],
                        1e3 * off
                    );
                }
            }
        }
    }
}
