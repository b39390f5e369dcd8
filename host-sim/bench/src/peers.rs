//! Beamformers of other Python packages, if they are installed.

use std::collections::BTreeMap;
use std::fs::File;
use std::hint::black_box;
use std::io::BufWriter;
use std::path::Path;
use std::time::Duration;

use bonebeam::beamform::Parameters;
use bonebeam::prelude::stages::*;
use ndarray::{Array1, Array2, Array3, ArrayView2, arr0};
use num_complex::Complex;
use serde::Deserialize;

use super::report::{Quantity, Row, Table};
use super::scipy::printed;
use super::settings::{Section, Settings};
use super::snapshots::{Wavefield, snapshots};
use super::timing::fastest;
use crate::{Error, Result};
use bonebeam_drive::beamform::Plan;
use bonebeam_drive::config::Beamform;
use bonebeam_drive::delay::DelayStage;
use bonebeam_drive::frame::beamform_channel_data;
use bonebeam_drive::methods::MethodName;
use bonebeam_drive::threads::pool;
use bonebeam_files::{BeamformedLines, ChannelData, Transmits, npy, npz};

const SCRIPT: &str = include_str!("peers.py");
/// Beams, samples, elements: the frame of the GPU's paper.
const FRAME: (usize, usize, usize) = (80, 400, 64);
/// Largest difference between equal frames, f32 against f64 and f32.
///
/// It is relative to the largest value.
const EQUAL: f64 = 1e-5;
const EQUAL_IN_F32: f64 = 1e-3;
/// The same, a windowed sinc against linear interpolation.
const INTERPOLATED: f64 = 2e-3;

/// One package.
struct Peer {
    name: &'static str,
    row: &'static str,
    equal: f64,
}

const PEERS: [Peer; 3] = [
    Peer {
        name: "ustb",
        row: "MV, beside USTB",
        equal: EQUAL,
    },
    Peer {
        name: "zea",
        row: "MV, forward, beside zea",
        equal: EQUAL_IN_F32,
    },
    Peer {
        name: "ultraspy",
        row: "delay and sum from the record, beside ultraspy",
        equal: INTERPOLATED,
    },
];

/// Output of the script for a package.
#[derive(Deserialize)]
struct Told {
    seconds: Option<f64>,
    left_out: Option<String>,
}

/// Times the same frame with each installed package.
///
/// # Errors
/// Frames of the two sides that are not equal.
pub fn peers(settings: &Settings, step: &mut (dyn FnMut(&str) + Send)) -> Result<Table> {
    pool(1)?.install(|| measure(settings, step))
}

fn measure(settings: &Settings, step: &mut (dyn FnMut(&str) + Send)) -> Result<Table> {
    let x = snapshots(Wavefield::Echo, FRAME);
    let recording = Recording::new();
    step("Python");
    let mut method = format!(
        "One thread. MV: {} beams of {} samples, M = {}, L = M/2, K = 1, aligned already; forward-backward \
         beside USTB (numba, f64), forward beside zea (JAX, f32). Delay and sum: {} single-element \
         transmits of {} elements, recorded at {:.0} MHz, onto {} lines of {} samples; ultraspy (numba) \
         reads analytic samples by linear interpolation. What is compiled at run time is not counted, and \
         all frames are compared.",
        FRAME.0,
        FRAME.1,
        FRAME.2,
        recording.data.t0.len(),
        recording.data.element_x.len(),
        recording.data.fs / 1e6,
        recording.lines.beam_x.len(),
        recording.lines.z.ncols(),
    );
    let mut rows = Vec::new();
    let folder = tempfile::tempdir().map_err(|e| Error::Data(e.to_string()))?;
    match python(folder.path(), &x, &recording, settings.budget) {
        Err(reason) => method.push_str(&format!(" All were left out: {reason}.")),
        Ok(results) => {
            for peer in &PEERS {
                step(peer.name);
                let Some(seconds) = results.get(peer.name).and_then(|results| results.seconds)
                else {
                    let reason = results
                        .get(peer.name)
                        .and_then(|results| results.left_out.clone());
                    let reason = reason.unwrap_or_default();
                    method.push_str(&format!(" {} was left out: {reason}.", peer.name));
                    continue;
                };
                let mut work = peer.here(&x, &recording)?;
                let ours = work()?;
                let theirs = folder.path().join(format!("{}.npy", peer.name));
                let theirs: Array2<Complex<f32>> = npy::read_array(&theirs)?
                    .into_dimensionality()
                    .map_err(|e| Error::Data(e.to_string()))?;
                let difference = peer.equal(ours.view(), theirs.view())?;
                // As close as possible to the time of Python's run.
                let here = fastest(settings.budget, || drop(black_box(work())));
                let row = Row::faster(peer.row, Quantity::milliseconds, [here, seconds]);
                rows.push(row.difference(difference));
            }
        }
    }
    Ok(Table {
        section: Section::Peers.to_string(),
        title: "A frame, beside packages for Python".into(),
        method,
        yardstick: "package".into(),
        rows,
    })
}

/// Computes a frame with this project.
type Work<'a> = Box<dyn FnMut() -> Result<Array2<Complex<f32>>> + 'a>;

impl Peer {
    fn here<'a>(&self, x: &'a Array3<Complex<f32>>, recording: &'a Recording) -> Result<Work<'a>> {
        let covariance = match self.name {
            "ustb" => Covariance::ForwardBackward,
            "zea" => Covariance::Forward,
            _ => return Ok(Box::new(|| Ok(recording.beamform()?.z))),
        };
        let all = Active::new(0, FRAME.2);
        let parameters = Parameters {
            covariance,
            temporal_half_window: 1,
            diagonal_loading: 0.05,
            ..Parameters::of(Method::Mv)
        };
        let plan = Plan::new(InstructionSet::detect(), parameters, FRAME.2)?;
        Ok(Box::new(move || plan.run(x.view(), &|_, _| all, &|_| {})))
    }

    fn equal(
        &self,
        ours: ArrayView2<'_, Complex<f32>>,
        theirs: ArrayView2<'_, Complex<f32>>,
    ) -> Result<f64> {
        let mut largest = 0.0f64;
        let mut difference = 0.0f64;
        for (a, b) in ours.iter().zip(theirs) {
            largest = largest.max(f64::from(b.norm()));
            let d = f64::from((a - b).norm());
            // A NaN is kept.
            if d.is_nan() || d > difference {
                difference = d;
            }
        }
        let difference = difference / largest;
        if ours.dim() == theirs.dim() && difference <= self.equal {
            return Ok(difference);
        }
        Err(Error::Data(format!(
            "{}: the frames differ by {difference:.1e} of the largest value; at most {:.0e} is expected",
            self.name, self.equal
        )))
    }
}

/// A recording of single-element transmits, whose delay law is unambiguous.
struct Recording {
    data: ChannelData,
    parameters: Beamform,
    /// The analytic signal of each element, [transmit, element, sample].
    analytic: Array3<Complex<f32>>,
    /// The lines, with the first active element and the number of active elements.
    lines: BeamformedLines,
    active: Array2<i64>,
}

impl Recording {
    /// A recording of echoes of a few points.
    ///
    /// The sampling rate gives linear interpolation an accuracy of a thousandth. The recording is long enough for the
    /// echo of every pixel at every element.
    fn new() -> Self {
        const ELEMENTS: usize = 64;
        const SAMPLES: usize = 11_200;
        let (c, f0, fs) = (1540.0, 5e6, 400e6);
        let index = vec![8, 32, 56];
        let element_x: Vec<f64> = (0..ELEMENTS).map(|m| (m as f64 - 31.5) * 0.3e-3).collect();
        let points: [[f64; 2]; 3] = [[-3e-3, 8e-3], [0.4e-3, 9e-3], [4e-3, 10e-3]];
        let analytic = Array3::from_shape_fn((index.len(), ELEMENTS, SAMPLES), |(t, m, n)| {
            let echo = |[x, z]: [f64; 2]| {
                let arrival =
                    ((element_x[index[t]] - x).hypot(z) + (element_x[m] - x).hypot(z)) / c;
                let late = n as f64 / fs - arrival;
                let envelope = (-(late * 0.5 * f0).powi(2)).exp();
                Complex::from_polar(envelope, std::f64::consts::TAU * f0 * late)
            };
            let sum: Complex<f64> = points.into_iter().map(echo).sum();
            Complex::new(sum.re as f32, sum.im as f32)
        });
        let data = ChannelData::linear(
            analytic.mapv(|z| z.re),
            element_x,
            Transmits::Element { index },
            ([fs, f0], c),
        );
        let parameters = Beamform {
            method: MethodName::Das,
            // The same elements at all depths of a line.
            f_number: 1e-3,
            depth_start: Some(7e-3),
            depth_end: Some(11e-3),
            ..Beamform::default()
        };
        let lines = beamform_channel_data(&data, &parameters, &|_| {});
        let lines = lines.expect("a record as it should be");
        let stage = DelayStage::new(&data, &parameters).expect("a record as it should be");
        let active = Array2::from_shape_fn((lines.beam_x.len(), 2), |(beam, k)| {
            let active = stage.active(beam, 0);
            [active.first, active.count][k] as i64
        });
        Recording {
            lines,
            active,
            data,
            parameters,
            analytic,
        }
    }

    fn beamform(&self) -> Result<BeamformedLines> {
        beamform_channel_data(&self.data, &self.parameters, &|_| {})
    }

    fn write(&self, path: &Path) -> std::result::Result<(), Box<dyn std::error::Error>> {
        let mut npz = npz::Writer::new(File::create(path)?, 0);
        let lines = &self.lines;
        let depth = |n: usize| lines.c * (lines.t0 + n as f64 / lines.fs) / 2.0;
        let Transmits::Element { index } = &self.data.transmits else {
            unreachable!("it was made with these");
        };
        let index: Array1<i64> = index.iter().map(|&i| i as i64).collect();
        npz.add("analytic", &self.analytic)?;
        npz.add("tx_element", &index)?;
        npz.add("active", &self.active)?;
        for (key, values) in [
            ("element_x", self.data.element_x.clone()),
            ("beam_x", lines.beam_x.clone()),
            ("depth", (0..lines.z.ncols()).map(depth).collect()),
        ] {
            npz.add(key, &Array1::from(values))?;
        }
        for (key, value) in [
            ("fs", self.data.fs),
            ("f0", self.data.f0),
            ("t0", 0.0),
            ("c", self.data.c),
        ] {
            npz.add(key, &arr0(value))?;
        }
        npz.finish()?;
        Ok(())
    }
}

/// Runs the script; if it cannot run, returns the reason in one line.
fn python(
    folder: &Path,
    x: &Array3<Complex<f32>>,
    recording: &Recording,
    budget: Duration,
) -> std::result::Result<BTreeMap<String, Told>, String> {
    let file = File::create(folder.join("x.npy")).map_err(|e| e.to_string())?;
    npy::write(x, &mut BufWriter::new(file)).map_err(|e| e.to_string())?;
    let written = recording.write(&folder.join("delay.npz"));
    written.map_err(|e| e.to_string())?;
    printed(SCRIPT, &[folder], budget)
}
