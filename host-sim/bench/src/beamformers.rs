//! The beamformers against naive faer.

use std::hint::black_box;

use bonebeam::beamform::Parameters;
use bonebeam::prelude::stages::*;
use ndarray::{Array2, Array3, Axis};
use num_complex::Complex;

use super::core::Core;
use super::naive::{Naive, Shape};
use super::report::{Quantity, Row, Table, Target};
use super::settings::{Section, Settings};
use super::snapshots::{Wavefield, snapshots};
use super::timing::side_by_side;
use crate::{Error, Result};

/// Number of beams: the lanes of the widest registers.
pub(super) const BEAMS: usize = 16;
/// Samples that faer computes at a time.
const FAER: usize = 8;
/// The largest relative difference between equal results.
const EQUAL: f64 = 1e-3;
const LOADING: f32 = 0.05;

/// One comparison at four sizes.
struct Comparison {
    name: &'static str,
    /// The slowest method counts.
    methods: &'static [Method],
    covariance: Covariance,
    wavefield: Wavefield,
    one_lane: bool,
    /// Smallest ratio of speeds at each of [`SIZES`].
    targets: Option<[f64; 4]>,
}

/// M, L, K.
const SIZES: [(usize, usize, usize); 4] = [(128, 64, 10), (128, 64, 0), (64, 32, 2), (32, 16, 0)];

/// Methods with all eigenvectors: the paper's β, a fixed rank, all but the first.
const ALL_EIGENVECTORS: &[Method] = &[
    Method::EsmvBeta(0.1),
    Method::EsmvBeta(0.01),
    Method::EsmvBeta(1e-5),
    Method::EsmvRank(3),
    Method::EsmvExcludeFirst,
];

/// A comparison forward-backward, of an echo.
const fn comparison(
    name: &'static str,
    methods: &'static [Method],
    targets: [f64; 4],
) -> Comparison {
    Comparison {
        name,
        methods,
        covariance: Covariance::ForwardBackward,
        wavefield: Wavefield::Echo,
        one_lane: false,
        targets: Some(targets),
    }
}

impl Comparison {
    const fn forward(mut self) -> Self {
        self.covariance = Covariance::Forward;
        self
    }

    const fn of_noise(mut self) -> Self {
        self.wavefield = Wavefield::Noise;
        self
    }
}

const MV: &[Method] = &[Method::Mv];
const RANK_1: &[Method] = &[Method::EsmvRank1];
const TARGETS_OF_RANK_1: [f64; 4] = [80.0, 40.0, 50.0, 40.0];
const TARGETS_OF_ALL: [f64; 4] = [45.0, 24.0, 30.0, 25.0];
const TARGETS_OF_ALL_FORWARD: [f64; 4] = [20.0, 11.0, 16.0, 16.0];

const COMPARISONS: [Comparison; 10] = [
    comparison("rank-1 ESMV", RANK_1, TARGETS_OF_RANK_1),
    comparison("rank-1 ESMV, noise alone", RANK_1, TARGETS_OF_RANK_1).of_noise(),
    comparison("MV", MV, [60.0, 15.0, 25.0, 20.0]),
    comparison("MV, forward", MV, [20.0, 5.0, 5.0, 5.0]).forward(),
    comparison("rank-1 ESMV, forward", RANK_1, [20.0, 5.0, 5.0, 5.0]).forward(),
    comparison("ESMV by β and others", ALL_EIGENVECTORS, TARGETS_OF_ALL),
    comparison(
        "ESMV by β and others, noise alone",
        ALL_EIGENVECTORS,
        TARGETS_OF_ALL,
    )
    .of_noise(),
    comparison(
        "ESMV by β and others, forward",
        ALL_EIGENVECTORS,
        TARGETS_OF_ALL_FORWARD,
    )
    .forward(),
    comparison(
        "ESMV by β and others, forward, noise alone",
        ALL_EIGENVECTORS,
        TARGETS_OF_ALL_FORWARD,
    )
    .forward()
    .of_noise(),
    Comparison {
        one_lane: true,
        targets: None,
        ..comparison("MV, one lane", MV, [0.0; 4])
    },
];

/// Every comparison with naive faer.
///
/// # Errors
/// Results of the two sides that are not equal.
pub fn against_faer(settings: &Settings, step: &mut (dyn FnMut(&str) + Send)) -> Result<Table> {
    let mut rows = Vec::new();
    for comparison in &COMPARISONS {
        for (size, &(elements, subaperture, temporal_half_window)) in SIZES.iter().enumerate() {
            let name = format!(
                "{}, {elements}/{subaperture}/{temporal_half_window}",
                comparison.name
            );
            step(&name);
            let shape = Shape {
                elements,
                subaperture,
                temporal_half_window,
                covariance: comparison.covariance,
                diagonal_loading: LOADING,
            };
            let row = comparison.measure(settings, shape, name)?;
            rows.push(match comparison.targets {
                Some(targets) => row.target(Target::AtLeast(targets[size])),
                None => row,
            });
        }
    }
    Ok(Table {
        section: Section::Beamformers.to_string(),
        title: "Beamformers against naive faer, time of one output sample, M/L/K".into(),
        method: format!(
            "One thread, forward-backward unless said. Lines of {} samples, all elements active: an \
             echo from another direction in every beam, whose amplitude fluctuates along the depth \
             like speckle, with white noise 20 dB below it; or that noise alone. faer (c32, run-time \
             dispatch, memory made beforehand): the product of the window's snapshots with its adjoint, \
             then Cholesky, or for ESMV the full eigendecomposition. \"ESMV by β and others\" is the \
             slowest of β = 10 %, 1 % and 0.001 %, rank 3, and all but λ₁.",
            settings.samples
        ),
        yardstick: "faer".into(),
        rows,
    })
}

impl Comparison {
    fn measure(&self, settings: &Settings, shape: Shape, name: String) -> Result<Row> {
        let (set, beams) = match self.one_lane {
            true => (InstructionSet::Scalar, 1),
            false => (settings.instruction_set, BEAMS),
        };
        let x = snapshots(self.wavefield, (beams, settings.samples, shape.elements));
        let mut slowest: Option<Row> = None;
        let mut largest_difference = 0.0f64;
        for &method in self.methods {
            let parameters = Parameters {
                covariance: shape.covariance,
                ..parameters(method, shape.temporal_half_window)
            };
            let core = Core::new(set, parameters, &x)?;
            let row = compare(settings, shape, &name, &x, core)?;
            largest_difference = largest_difference.max(row.difference.unwrap_or(0.0));
            let ratio = |row: &Row| row.result.as_ref().map(|result| result.value);
            if slowest.as_ref().is_none_or(|s| ratio(&row) < ratio(s)) {
                slowest = Some(row);
            }
        }
        let row = slowest.map(|row| row.difference(largest_difference));
        row.ok_or_else(|| Error::Data(format!("{name}: nothing was measured")))
    }
}

/// Compares the results of both sides, then times them.
fn compare(
    settings: &Settings,
    shape: Shape,
    name: &str,
    x: &Array3<Complex<f32>>,
    mut core: Core<'_>,
) -> Result<Row> {
    let (beams, samples, _) = x.dim();
    let mut z = Array2::zeros((beams, samples));
    core.run(&mut z)?;
    let method = core.method();
    let mut naive = Naive::new(shape);
    let mut one = |line, sample| match method {
        Method::Mv => naive.mv(line, sample).map(|z| (z, false)),
        _ => naive.esmv(line, sample, method),
    };
    let mut difference = 0.0f64;
    for (line, z) in x.axis_iter(Axis(0)).zip(z.outer_iter()) {
        let largest = z.iter().map(|z| z.norm()).fold(0.0, f32::max);
        for sample in [0, 1, samples / 2, samples - 1] {
            let (expected, doubtful) = one(line, sample)?;
            let error = f64::from((z[sample] - expected).norm() / largest);
            // A NaN is kept.
            if !doubtful && (error.is_nan() || error > difference) {
                difference = error;
            }
        }
    }
    if difference.is_nan() || difference > EQUAL {
        return Err(Error::Data(format!(
            "{name}, {method:?}: the core and faer differ by {difference:.1e} of the line's largest \
             sample; at most {EQUAL:.0e} is expected"
        )));
    }

    let first = samples / 2;
    let [here, faer] = side_by_side(
        settings.budget,
        [
            // Both have succeeded with these data.
            &mut || drop(black_box(core.run(&mut z))),
            &mut || {
                for sample in first..first + FAER {
                    let _ = black_box(one(x.index_axis(Axis(0), 0), sample));
                }
            },
        ],
    );
    let seconds = [here / (beams * samples) as f64, faer / FAER as f64];
    Ok(Row::faster(name, Quantity::microseconds, seconds).difference(difference))
}

/// Parameters of every comparison.
pub(super) fn parameters(method: Method, temporal_half_window: usize) -> Parameters {
    Parameters {
        temporal_half_window,
        diagonal_loading: LOADING,
        ..Parameters::of(method)
    }
}
