//! Linear, phased and convex arrays, RF and I/Q, delay laws, many frames, a lens.
//!
//! A point appears at its position, and I/Q gives the lines of RF.

use crate::common::program::{Folder, program, succeeded};
use std::f64::consts::{PI, TAU};

use bonebeam_drive::config::{Beamform, LineKind};
use bonebeam_drive::delay::DelayStage;
use bonebeam_drive::frame::{RecordingFrames, beamform_channel_data};
use bonebeam_drive::image::{b_mode, grid_of_lines};
use bonebeam_drive::methods::MethodName;
use bonebeam_files::{BeamformedLines, ChannelData, Recording, Samples, Transmits};
use ndarray::{Array2, Array3};
use num_complex::Complex;
use tempfile::tempdir;

const C: f64 = 1540.0;
const ELEMENTS: usize = 48;
const F0: f64 = 4e6;
const FS: f64 = 32e6;
const T0: f64 = -0.8e-6;
/// The pulse's bandwidth at −6 dB.
const BANDWIDTH: f64 = 0.6 * F0;
/// Bound of I/Q against RF with the default reading.
///
/// It is the sum of 9·10⁻⁴ of the pulse's peak at 3.33 times the bandwidth (tests/iq/mod.rs) and the 1.6·10⁻³ of RF
/// recorded at 32 MHz with an output at 20 MHz.
const IQ_AGAINST_RF: f32 = 2.5e-3;

/// An array: its elements' positions and normals.
struct Probe {
    x: Vec<f64>,
    z: Option<Vec<f64>>,
    angle: Option<Vec<f64>>,
}

fn straight(pitch: f64) -> Probe {
    Probe {
        x: (0..ELEMENTS).map(|m| (m as f64 - 23.5) * pitch).collect(),
        z: None,
        angle: None,
    }
}

/// Radius 40 mm, pitch 0.4 mm.
fn convex() -> Probe {
    let angle: Vec<f64> = (0..ELEMENTS).map(|m| (m as f64 - 23.5) * 0.01).collect();
    Probe {
        x: angle.iter().map(|a| 40e-3 * a.sin()).collect(),
        z: Some(angle.iter().map(|a| 40e-3 * (a.cos() - 1.0)).collect()),
        // Computed from the positions.
        angle: None,
    }
}

fn envelope(t: f64) -> f64 {
    let a = (PI * BANDWIDTH).powi(2) / (4.0 * 10f64.powf(6.0 / 20.0).ln());
    (-a * t * t).exp()
}

/// The echo of a point, straight from the arrival times of the contract.
///
/// The wave covers the point's surroundings. For focused transmits `height` gives its level there.
fn recording(
    probe: &Probe,
    transmits: Transmits,
    [x, z]: [f64; 2],
    (iq, lens): (bool, f64),
) -> ChannelData {
    let position = |m: usize| (probe.x[m], probe.z.as_ref().map_or(0.0, |z| z[m]));
    let arrival = |t: usize| match &transmits {
        Transmits::Plane { angle } => (x * angle[t].sin() + z * angle[t].cos()) / C,
        Transmits::Element { index } => {
            let (ex, ez) = position(index[t]);
            (x - ex).hypot(z - ez) / C
        }
        Transmits::VirtualSource { x: sx, z: sz } => {
            let (distance, range) = ((x - sx[t]).hypot(z - sz[t]), sx[t].hypot(sz[t]));
            match sz[t] > 0.0 {
                true => (range + (z - sz[t]).signum() * distance) / C,
                false => (distance - range) / C,
            }
        }
        Transmits::Delays { delay } => {
            let one = |m: usize| {
                let (ex, ez) = position(m);
                delay[(t, m)] + (x - ex).hypot(z - ez) / C
            };
            // `min` ignores NaN.
            (0..ELEMENTS).map(one).fold(f64::INFINITY, f64::min)
        }
        Transmits::Focused { .. } => z / C,
    };
    // Of focused transmits only the one with its focus nearest to the point has the echo.
    let height = |t: usize| match &transmits {
        Transmits::VirtualSource { x: sx, z: sz } if sz[t] > 0.0 => {
            let aside = sx[t].atan2(sz[t]) - x.atan2(z);
            (-(aside / 0.02).powi(2)).exp()
        }
        _ => 1.0,
    };
    let fs = if iq { FS / 4.0 } else { FS };
    let samples = (48e-6 * fs) as usize;
    let shape = (transmits.len(), ELEMENTS, samples);
    let at = |t: usize, m: usize, n: usize| {
        let (ex, ez) = position(m);
        let time = T0 + n as f64 / fs;
        let late = time - arrival(t) - (x - ex).hypot(z - ez) / C - 2.0 * lens;
        (height(t) * envelope(late), late, time)
    };
    let samples = if iq {
        let f_demod = 3.9e6;
        let baseband = |(t, m, n)| {
            let (envelope, late, time) = at(t, m, n);
            let y = Complex::from_polar(envelope, TAU * (F0 * late - f_demod * time));
            Complex::new(y.re as f32, y.im as f32)
        };
        Samples::iq(Array3::from_shape_fn(shape, baseband), f_demod)
    } else {
        let rf = |(t, m, n)| {
            let (envelope, late, _) = at(t, m, n);
            (envelope * (TAU * F0 * late).cos()) as f32
        };
        Array3::from_shape_fn(shape, rf).into()
    };
    ChannelData {
        samples,
        fs,
        t0: vec![T0; shape.0],
        element_x: probe.x.clone(),
        element_z: probe.z.clone(),
        element_angle: probe.angle.clone(),
        c: C,
        f0: F0,
        transmits,
        lens_delay: lens,
    }
}

/// Position of a beam's sample, (x, z) m.
fn position(lines: &BeamformedLines, beam: usize, sample: usize) -> [f64; 2] {
    let r = lines.c * (lines.t0 + sample as f64 / lines.fs) / 2.0;
    lines.point(beam, r)
}

fn brightest(lines: &BeamformedLines) -> [f64; 2] {
    let norms = lines.z.mapv(|z| z.norm());
    let mut best = (0, 0);
    for (position, &norm) in norms.indexed_iter() {
        if norm > norms[best] {
            best = position;
        }
    }
    position(lines, best.0, best.1)
}

fn parameters(method: MethodName) -> Beamform {
    let mut parameters = Beamform {
        method,
        depth_start: Some(24e-3),
        depth_end: Some(33e-3),
        ..Beamform::default()
    };
    parameters.resolve();
    parameters
}

/// The probes, each with a point that lies on a line to within 0.1 mm.
fn scenes() -> [(&'static str, Probe, [f64; 2], Transmits); 7] {
    let foci = |radius: f64, apex: f64, step: f64| {
        let angles = (-20..=20).map(|k| f64::from(k) * step);
        let (x, z) = angles
            .map(|a| (radius * a.sin(), apex + radius * a.cos()))
            .unzip();
        Transmits::VirtualSource { x, z }
    };
    let delays = |probe: &Probe| {
        let behind = |(t, m): (usize, usize)| {
            let (sx, sz) = ((t as f64 - 1.0) * 4e-3, -12e-3);
            match (t, m) {
                (1, 5) => f64::NAN,
                _ => ((probe.x[m] - sx).hypot(sz) - 12e-3) / C,
            }
        };
        Transmits::Delays {
            delay: Array2::from_shape_fn((3, ELEMENTS), behind),
        }
    };
    let diverging = || Transmits::VirtualSource {
        x: vec![-5e-3, 0.0, 5e-3],
        z: vec![-10e-3, -11e-3, -10e-3],
    };
    let (phased, linear) = (|| straight(0.19e-3), || straight(0.3e-3));
    [
        ("linear, sources", linear(), [2e-3, 28e-3], diverging()),
        (
            "linear, delays",
            linear(),
            [-1.5e-3, 28e-3],
            delays(&linear()),
        ),
        ("phased, sources", phased(), [9e-3, 27e-3], diverging()),
        (
            "phased, foci",
            phased(),
            [9e-3, 27e-3],
            foci(30e-3, 0.0, 0.02),
        ),
        (
            "convex, foci",
            convex(),
            [6.73e-3, 27.06e-3],
            foci(70e-3, -40e-3, 0.01),
        ),
        (
            "convex, plane",
            convex(),
            [7e-3, 27e-3],
            Transmits::Plane {
                angle: vec![-0.2, 0.0, 0.2],
            },
        ),
        (
            "convex, elements",
            convex(),
            [-6e-3, 27e-3],
            Transmits::Element {
                index: (0..ELEMENTS).step_by(3).collect(),
            },
        ),
    ]
}

#[test]
fn a_point_lies_where_it_is_and_iq_gives_the_lines_of_rf() {
    for (what, probe, point, transmits) in scenes() {
        // The recording states its lens, so the point does not move.
        for lens in [0.0, 0.3e-6] {
            let rf = recording(&probe, transmits.clone(), point, (false, lens));
            let iq = recording(&probe, transmits.clone(), point, (true, lens));
            let methods = MethodName::ALL;
            for method in methods
                .into_iter()
                .take(if lens == 0.0 { 1 } else { usize::MAX })
            {
                let parameters = parameters(method);
                let lines = beamform_channel_data(&rf, &parameters, &|_| {}).unwrap();
                let [x, z] = brightest(&lines);
                let off = (x - point[0]).hypot(z - point[1]);
                assert!(off < 0.35e-3, "{what}, {method:?}: {x} {z}");
                if method != MethodName::Das {
                    // The weights of the other methods follow the data in pixels with noise only.
                    let of_iq = beamform_channel_data(&iq, &parameters, &|_| {}).unwrap();
                    let [ix, iz] = brightest(&of_iq);
                    assert!((ix - x).hypot(iz - z) < 0.1e-3, "{what}, {method:?}, I/Q");
                    continue;
                }
                let of_iq = beamform_channel_data(&iq, &parameters, &|_| {}).unwrap();
                assert_eq!(of_iq.rays, lines.rays);
                let peak = lines.z.iter().fold(0.0f32, |peak, z| peak.max(z.norm()));
                assert!(peak > 0.02, "{what}: {peak}");
                for ((position, a), b) in lines.z.indexed_iter().zip(&of_iq.z) {
                    let error = (a - b).norm();
                    assert!(error < IQ_AGAINST_RF, "{what} at {position:?}: {a} {b}");
                }
            }
        }
    }
}

#[test]
fn lines_fit_the_array_or_are_those_asked_for() {
    let angles = |lines: &BeamformedLines| lines.rays.as_ref().map(|rays| rays.angle.clone());
    for (what, probe, point, transmits) in scenes() {
        let data = recording(&probe, transmits, point, (true, 0.0));
        let lines = beamform_channel_data(&data, &parameters(MethodName::Das), &|_| {}).unwrap();
        let count = lines.beam_x.len();
        match what {
            "linear, sources" | "linear, delays" => {
                assert_eq!((count, angles(&lines)), (2 * ELEMENTS - 1, None));
            }
            "phased, sources" => {
                let angles = angles(&lines).unwrap();
                assert_eq!((count, angles[0]), (2 * ELEMENTS - 1, -PI / 4.0));
                assert!(lines.beam_x.iter().all(|&x| x.abs() < 1e-12));
            }
            // One line for each focus, through it.
            "phased, foci" | "convex, foci" => {
                let angles = angles(&lines).unwrap();
                assert_eq!(count, 41);
                let step = if what == "phased, foci" { 0.02 } else { 0.01 };
                for (k, angle) in angles.iter().enumerate() {
                    assert!(
                        (angle - (k as f64 - 20.0) * step).abs() < 1e-5,
                        "{what} {k}"
                    );
                }
            }
            _ => {
                let angles = angles(&lines).unwrap();
                assert_eq!(count, 2 * ELEMENTS - 1);
                // The normals, computed from the neighbours' positions.
                assert!((angles[2 * 10] - (10.0 - 23.5) * 0.01).abs() < 1e-9);
                assert!((lines.beam_x[20] - probe.x[10]).abs() < 1e-12);
            }
        }
    }
    let (_, probe, point, transmits) = scenes().into_iter().next().unwrap();
    let data = recording(&probe, transmits, point, (true, 0.0));
    let asked = Beamform {
        lines: Some(LineKind::Sector),
        line_count: Some(31),
        sector: 0.6,
        ..parameters(MethodName::Das)
    };
    let lines = beamform_channel_data(&data, &asked, &|_| {}).unwrap();
    let angles = angles(&lines).unwrap();
    assert_eq!(angles.len(), 31);
    assert!((angles[0] + 0.3).abs() < 1e-12 && (angles[30] - 0.3).abs() < 1e-12);
}

/// Compounded transmits of single elements focus on the aligned line: a point half way to the next loses more than
/// between sub-lines, by as much as is said.
#[test]
fn the_loss_between_lines_counts_the_transmits() {
    let probe = straight(0.45e-3);
    let parameters = parameters(MethodName::Mv);
    let elements = Transmits::Element {
        index: (0..ELEMENTS).collect(),
    };
    let plane = Transmits::Plane { angle: vec![0.0] };
    let lost = |transmits: &Transmits| {
        let level = |x: f64| {
            let data = recording(&probe, transmits.clone(), [x, 27e-3], (false, 0.0));
            let lines = beamform_channel_data(&data, &parameters, &|_| ()).unwrap();
            let recording = Recording::Channel(data);
            let frames = RecordingFrames::new(&recording, &parameters).unwrap();
            let said = frames.stage().unwrap().loss_between().unwrap();
            let largest = lines.z.iter().map(|z| z.norm()).fold(0.0, f32::max);
            (20.0 * f64::from(largest).log10(), said)
        };
        let [(on, said), (between, _)] = [0.225e-3, 0.45e-3].map(level);
        (on - between, said)
    };
    let (of_elements, said) = lost(&elements);
    let (of_plane, said_of_plane) = lost(&plane);
    assert!(
        of_plane < said_of_plane + 0.5,
        "{of_plane}, {said_of_plane}"
    );
    assert!(
        of_elements < said + 0.5 && of_elements > of_plane + 1.0,
        "{of_elements}, {said}"
    );
    assert!(said > said_of_plane + 1.0, "{said}, {said_of_plane}");
}

/// An echo through a lens, by paths of least time over its face, is aligned at all elements once the lens is known.
#[test]
fn refraction_at_a_lens_is_taken_out() {
    const THICKNESS: f64 = 1e-3;
    const SPEED: f64 = 1000.0;
    const MIDDLE: usize = 24;
    for (probe, radius) in [(straight(0.3e-3), None), (convex(), Some(40e-3))] {
        // The direction of the normal, and a place on the face or below it.
        let place = |along: f64, below: f64| match radius {
            Some(radius) => {
                let (sin, cos) = (along / radius).sin_cos();
                [(radius - below) * sin, (radius - below) * cos - radius]
            }
            None => [along, -below],
        };
        let pitch = if radius.is_some() { 0.4e-3 } else { 0.3e-3 };
        let along = |m: usize| (m as f64 - 23.5) * pitch;
        let distance = |[ax, az]: [f64; 2], [bx, bz]: [f64; 2]| (ax - bx).hypot(az - bz);
        let time = |m: usize, point: [f64; 2]| {
            let through = |at: f64| {
                let face = place(at, 0.0);
                distance(place(along(m), THICKNESS), face) / SPEED + distance(face, point) / C
            };
            let [mut low, mut high] = [-2e-3, 2e-3].map(|far| along(m) + far);
            for _ in 0..100 {
                let [a, b] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
                if through(a) < through(b) {
                    high = b;
                } else {
                    low = a;
                }
            }
            through(low)
        };
        let given = Beamform {
            depth_start: Some(5e-3),
            depth_end: Some(7e-3),
            f_number: 1.0,
            lens_thickness: Some(THICKNESS),
            ..parameters(MethodName::Das)
        };
        let recorded = |point: [f64; 2], samples: usize| {
            let late = |m: usize| time(MIDDLE, point) + time(m, point);
            let rf = Array3::from_shape_fn((1, ELEMENTS, samples), |(_, m, n)| {
                let late = n as f64 / FS - late(m);
                (envelope(late) * (TAU * F0 * late).cos()) as f32
            });
            ChannelData {
                element_z: probe.z.clone(),
                lens_delay: THICKNESS / SPEED,
                ..ChannelData::linear(
                    rf,
                    probe.x.clone(),
                    Transmits::Element {
                        index: vec![MIDDLE],
                    },
                    ([FS, F0], C),
                )
            }
        };
        let any = recorded([0.0, 6e-3], 600);
        let stage = DelayStage::new(&any, &given).unwrap();
        let (sample, line) = (stage.samples() / 2, 2 * MIDDLE);
        let depth = stage.depths().first + sample as f64 * stage.depths().step;
        let data = recorded(place(along(MIDDLE), -depth), 600);
        let errors = |parameters: &Beamform| {
            let stage = DelayStage::new(&data, parameters).unwrap();
            let x = stage.delay(line..line + 1).unwrap();
            let active = stage.active(line, sample);
            let from = |m: usize| (f64::from(x[[0, sample, m]].arg()) / TAU / F0).abs();
            (active.first..active.first + active.count)
                .map(from)
                .fold(0.0, f64::max)
        };
        let without = Beamform {
            lens_thickness: None,
            ..given.clone()
        };
        let [known, unknown] = [&given, &without].map(errors);
        assert!(
            known < 3e-9 && unknown > 15e-9,
            "{radius:?}: {known} {unknown}"
        );
    }
}

/// Beams from right to left, in ping-pong, in blocks, and twice give the lines of those from left to right.
#[test]
fn lines_do_not_depend_on_the_order_of_transmits() {
    const BEAMS: usize = 12;
    let probe = straight(0.45e-3);
    let lines = |order: &[usize], method: MethodName| {
        let x = order.iter().map(|&k| (k as f64 - 5.5) * 1e-3).collect();
        let (focus, f_number) = (vec![25e-3; order.len()], None);
        let transmits = Transmits::Focused { x, focus, f_number };
        let data = recording(&probe, transmits, [2e-3, 25e-3], (false, 0.0));
        let lines = beamform_channel_data(&data, &parameters(method), &|_| ()).unwrap();
        (lines.beam_x, lines.z)
    };
    let all: Vec<usize> = (0..BEAMS).collect();
    let ping_pong = all.iter().map(|k| match k % 2 {
        0 => k / 2,
        _ => BEAMS - 1 - k / 2,
    });
    let orders: [Vec<usize>; 4] = [
        all.iter().rev().copied().collect(),
        ping_pong.collect(),
        (0..BEAMS).map(|k| k * 5 % BEAMS).collect(),
        [&all[..], &all].concat(),
    ];
    for method in [MethodName::Das, MethodName::Mv, MethodName::EsmvRank1] {
        let expected = lines(&all, method);
        for order in &orders {
            assert!(lines(order, method) == expected, "{method:?} {order:?}");
        }
    }
}

#[test]
fn a_fan_becomes_an_image_with_the_point_at_its_position() {
    for (what, probe, point, transmits) in scenes() {
        let data = recording(&probe, transmits, point, (true, 0.0));
        let lines = beamform_channel_data(&data, &parameters(MethodName::Das), &|_| {}).unwrap();
        let grid = grid_of_lines(&lines, 300, 300).unwrap();
        let image = b_mode(&lines, 40.0, &grid, false).unwrap();
        let brightest = |best: (usize, usize), (position, &level): ((usize, usize), &f32)| {
            if level > image.pixels[best] {
                position
            } else {
                best
            }
        };
        let (row, column) = image.pixels.indexed_iter().fold((0, 0), brightest);
        let x = grid.x0 + column as f64 * grid.pixel;
        let z = grid.z0 + row as f64 * grid.pixel;
        let off = (x - point[0]).hypot(z - point[1]);
        assert!(off < 0.4e-3, "{what}: {x} {z}");
    }
}

/// The size of the image that `info` gives is that of `beamform`, also of a fan.
#[test]
fn info_has_the_size_of_the_image() {
    let folder = tempdir().unwrap();
    for (what, probe, point, transmits) in scenes() {
        let data = recording(&probe, transmits, point, (false, 0.0));
        data.write(&folder.path().join("data.npz")).unwrap();
        folder.works("beamform data.npz -o lines.npz --image image.npy --method das");
        let (rows, columns) = folder.image("image.npy").dim();
        let [said, _] = succeeded(&mut program(&folder, "info data.npz --method das"));
        let expected = format!("image      {rows} x {columns} pixels");
        assert!(said.contains(&expected), "{what}: {said}");
    }
}

#[test]
fn a_simulated_scene_has_the_same_lines_as_iq() {
    let folder = tempdir().unwrap();
    let scene = "simulate point --beams 5 --first-beam 61 -o";
    folder.works(&format!("{scene} rf.npz"));
    folder.works(&format!("{scene} iq.npz --iq"));
    let iq = ChannelData::read(&folder.path().join("iq.npz")).unwrap();
    assert!(matches!(iq.samples, Samples::Iq { f_demod: 5e6, .. }) && iq.fs == 10e6);
    let lines = ["rf", "iq"].map(|name| {
        let depths = "--depth-start 0.0135 --depth-end 0.0165";
        folder.works(&format!(
            "beamform {name}.npz --method das {depths} -o lines.npz"
        ));
        folder.lines("lines.npz")
    });
    let peak = lines[0].z.iter().fold(0.0f32, |peak, z| peak.max(z.norm()));
    for (a, b) in lines[0].z.iter().zip(&lines[1].z) {
        assert!((a - b).norm() < IQ_AGAINST_RF * peak, "{a} {b} of {peak}");
    }
}
