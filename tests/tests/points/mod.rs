//! Points beside the lines: loss of level with and without sub-lines.

mod tables;

use crate::common::kit::*;
use bonebeam_drive::config::LineKind;
use bonebeam_drive::frame::beamform_channel_data;
use bonebeam_files::Samples;
use ndarray::Axis;

const C: f64 = 1540.0;
const ELEMENTS: usize = 64;
/// The depth of the point, wavelengths, but for [`Geometry::DeepSector`].
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
    /// A sector with the point at a depth of 80 mm.
    DeepSector,
}

impl Geometry {
    fn is_sector(self) -> bool {
        matches!(self, Geometry::Sector | Geometry::DeepSector)
    }
}

const GEOMETRIES: [Geometry; 3] = [Geometry::Linear, Geometry::Sector, Geometry::Curved];

/// A record of one point, `beside` line spacings to the right of the middle line.
#[derive(Clone, Copy)]
struct Point {
    geometry: Geometry,
    f0: f64,
    /// The ratio of the pulse's power at its peak to that of the noise, dB.
    snr: f64,
    lines: usize,
    beside: f64,
    iq: bool,
}

const POINT: Point = Point {
    geometry: Geometry::Linear,
    f0: 5e6,
    snr: 40.0,
    lines: 2 * ELEMENTS - 1,
    beside: 0.0,
    iq: false,
};

impl Point {
    fn wavelength(&self) -> f64 {
        C / self.f0
    }

    fn radius(&self) -> f64 {
        100.0 * self.wavelength()
    }

    fn pitch(&self) -> f64 {
        self.wavelength() * if self.geometry.is_sector() { 0.5 } else { 1.0 }
    }

    /// The depth of the point, m.
    fn depth(&self) -> f64 {
        match self.geometry {
            Geometry::DeepSector => 80e-3,
            _ => DEPTH * self.wavelength(),
        }
    }

    /// The position of the point, m.
    fn position(&self) -> [f64; 2] {
        let depth = self.depth();
        let along = (ELEMENTS - 1) as f64 * self.pitch();
        let steps = (self.lines - 1) as f64;
        match self.geometry {
            Geometry::Linear => [self.beside * along / steps, depth],
            Geometry::Sector | Geometry::DeepSector => {
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
            Geometry::Sector | Geometry::DeepSector => {
                sources(4.0 * self.wavelength(), -20.0 * self.wavelength())
            }
            Geometry::Curved => sources(4.0 * self.wavelength(), -self.radius()),
        }
    }

    fn record(&self) -> ChannelData {
        self.record_of(&[(self.position(), 1.0)])
    }

    /// The record of points with their amplitudes.
    fn record_of(&self, points: &[([f64; 2], f64)]) -> ChannelData {
        let transmits = self.transmits();
        let fs = RATE * self.f0;
        let samples = (3.2 * self.depth() / self.wavelength() * RATE) as usize;
        // 6 dB below its peak at 0.7 and 1.3 f0.
        let a = (PI * self.f0 * 0.6).powi(2) / (4.0 * 10f64.powf(6.0 / 20.0).ln());
        let sent = |t: usize, [x, z]: [f64; 2]| match &transmits {
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
        let shape = (transmits.len(), ELEMENTS, samples);
        let mut echoes = Array3::from_shape_fn(shape, |_| match self.iq {
            true => Complex::new(noise(), noise()),
            false => Complex::new(noise(), 0.0),
        });
        // Beyond 7 standard deviations of the pulse the record is 0.
        let reach = (7.0 / (2.0 * a).sqrt() * fs) as isize;
        for &([x, z], amplitude) in points {
            for ((t, m), mut echoes) in (0..transmits.len())
                .flat_map(|t| (0..ELEMENTS).map(move |m| (t, m)))
                .zip(echoes.rows_mut())
            {
                let [ex, ez] = self.element(m);
                let tau = (sent(t, [x, z]) + (x - ex).hypot(z - ez)) / C;
                let middle = (tau * fs) as isize;
                for n in (middle - reach).max(0)..(middle + reach).min(samples as isize) {
                    let u = n as f64 / fs - tau;
                    let envelope = amplitude * (-a * u * u).exp();
                    echoes[n as usize] += match self.iq {
                        true => Complex::cis(-TAU * self.f0 * tau) * envelope,
                        false => Complex::from(envelope * (TAU * self.f0 * u).cos()),
                    };
                }
            }
        }
        let samples: Samples = match self.iq {
            true => Samples::Iq {
                iq: echoes
                    .mapv(|z| Complex::new(z.re as f32, z.im as f32))
                    .insert_axis(Axis(0)),
                f_demod: self.f0,
            },
            false => echoes.mapv(|z| z.re as f32).into(),
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

    /// Lines with this number of sub-lines; `None` is the default.
    fn lines(&self, section: &Beamform, sub_lines: Option<usize>) -> BeamformedLines {
        self.lines_of(&self.record(), section, sub_lines)
    }

    fn lines_of(
        &self,
        record: &ChannelData,
        section: &Beamform,
        sub_lines: Option<usize>,
    ) -> BeamformedLines {
        let depth = self.depth();
        let section = Beamform {
            line_count: sub_lines.map(|_| self.lines),
            lines: Some(match self.geometry {
                Geometry::Linear => LineKind::Down,
                Geometry::Sector | Geometry::DeepSector => LineKind::Sector,
                Geometry::Curved => LineKind::Normals,
            }),
            sub_lines,
            depth_start: Some(0.93 * depth),
            depth_end: Some(1.05 * depth),
            ..section.clone()
        };
        beamform_channel_data(record, &section, &|_| {}).expect("lines")
    }

    /// The level of the point, dB, and two lateral errors, m.
    ///
    /// They are of its largest sample, and of the vertex of a parabola through that line's level and its neighbours'.
    fn peak(&self, section: &Beamform, sub_lines: Option<usize>) -> [f64; 3] {
        self.peak_of(&self.lines(section, sub_lines))
    }

    fn peak_of(&self, lines: &BeamformedLines) -> [f64; 3] {
        let largest = lines.z.indexed_iter().max_by(|(_, a), (_, b)| {
            let power = |z: &Complex<f32>| z.norm_sqr();
            power(a).total_cmp(&power(b))
        });
        let ((beam, sample), z) = largest.expect("a sample");
        let decibels = |z: &Complex<f32>| 20.0 * f64::from(z.norm()).log10();
        let depth = C * (lines.t0 + sample as f64 / lines.fs) / 2.0;
        let x = |beam: usize| {
            let angle = lines.rays.as_ref().map_or(0.0, |rays| rays.angle[beam]);
            lines.beam_x[beam] + depth * angle.sin()
        };
        let level = |beam: usize| {
            let levels = lines.z.row(beam).into_iter().map(decibels);
            levels.fold(f64::MIN, f64::max)
        };
        let inner = beam.clamp(1, lines.z.nrows() - 2);
        let [left, middle, right] = [inner - 1, inner, inner + 1].map(level);
        let vertex = (left - right) / (left - 2.0 * middle + right) / 2.0;
        let between = x(inner) + vertex * (x(inner + 1) - x(inner - 1)) / 2.0;
        let beside = |x: f64| (x - self.position()[0]).abs();
        [decibels(z), beside(x(beam)), beside(between)]
    }
}

fn section(method: MethodName) -> Beamform {
    changed(Beamform::default(), |b| b.method = method)
}

/// Level of a point beside a line relative to one on the line, dB.
///
/// The other values are the lateral errors of the peak and of the vertex, m.
fn loss(point: &Point, method: MethodName, sub_lines: Option<usize>) -> [f64; 3] {
    let on = changed(*point, |s| s.beside = 0.0);
    let section = section(method);
    let [level, ..] = on.peak(&section, Some(1));
    let [beside, off, vertex] = point.peak(&section, sub_lines);
    [level - beside, off, vertex]
}

/// A point half way between two lines keeps its level with 16 or 32 sub-lines.
///
/// There is one line for each element, or two if lines diverge. Without sub-lines the point is lost, by RF and by
/// I/Q. The nearest of 16 sub-lines is 1/32 of the spacing away, and the nearest of 32 half as far.
#[test]
fn a_point_between_two_lines_keeps_its_level() {
    for geometry in GEOMETRIES {
        for iq in [false, true] {
            let lines = match geometry {
                Geometry::Linear => ELEMENTS - 1,
                // They are two pitches apart at the depth of the point.
                _ => 2 * ELEMENTS - 1,
            };
            let point = Point {
                geometry,
                lines,
                beside: 0.5,
                iq,
                ..POINT
            };
            for method in [MethodName::Mv, MethodName::EsmvRank1] {
                let [alone, ..] = loss(&point, method, Some(1));
                let name = format!("{geometry:?} {method:?} I/Q {iq}");
                assert!(alone > 6.0, "{name}: {alone} dB");
                for (sub_lines, bound) in [(16, 2.5), (32, 1.0)] {
                    let [with, off, _] = loss(&point, method, Some(sub_lines));
                    assert!(with < bound, "{name}, {sub_lines}: {with} dB");
                    assert!(off < 0.02e-3, "{name}, {sub_lines}: {off} m");
                }
            }
            let [das, ..] = loss(&point, MethodName::Das, Some(16));
            // The loss of the transmits, which focus on the line.
            assert!(das.abs() < 0.5, "{geometry:?} DAS: {das} dB");
        }
    }
}

/// A point anywhere, with default lines and sub-lines.
///
/// It is beside one of 127 lines by up to a half of their spacing, and half way between two sub-lines.
#[test]
fn the_default_keeps_a_point_anywhere() {
    for geometry in GEOMETRIES {
        for (f0, beside, iq) in [
            (5e6, 0.5, false),
            (5e6, 0.25, true),
            (5e6, 0.0625, false),
            (15e6, 0.5, false),
        ] {
            let point = Point {
                geometry,
                f0,
                beside,
                iq,
                ..POINT
            };
            for method in [MethodName::Mv, MethodName::EsmvRank1] {
                let [lost, _, off] = loss(&point, method, None);
                let name = format!("{geometry:?} {f0} {beside} {method:?} I/Q {iq}");
                assert!(lost < 2.5, "{name}: {lost} dB");
                assert!(off < 0.02e-3, "{name}: {off} m between lines");
                let lines = point.lines(&section(method), None);
                assert_eq!(lines.sub_lines, 1, "{name}");
                let apart = lines.beam_x[1] - lines.beam_x[0];
                assert!(apart <= 0.1e-3, "{name}: lines are {apart} m apart");
            }
        }
    }
}
