//! The beamformer against the peak, and with and without a time window.

use std::hint::black_box;

use bonebeam::beamform::{Method, Parameters};
use bonebeam::simd::InstructionSet;
use ndarray::{Array2, Array3};
use num_complex::Complex;

use super::beamformers::{BEAMS, parameters};
use super::core::{Then, with_core};
use super::operations;
use super::peak::peak;
use super::report::{Quantity, Row, Table, Target};
use super::settings::{LINE, Section, Settings};
use super::snapshots::{Wavefield, snapshots};
use super::timing::{fastest, side_by_side};
use crate::Result;

/// Times the core alone, forward-backward.
fn alone(
    set: InstructionSet,
    method: Method,
    temporal_half_window: usize,
    lines: &Array3<Complex<f32>>,
    then: &mut Then<'_>,
) -> Result<()> {
    let parameters = parameters(method, temporal_half_window);
    with_core(set, parameters, lines, then)
}

/// MV's useful operations per second over the peak of the same instruction set.
///
/// # Errors
/// The errors of the core.
pub fn share_of_peak(settings: &Settings, step: &mut (dyn FnMut(&str) + Send)) -> Result<Table> {
    let mut rows = Vec::new();
    for &set in &settings.instruction_sets {
        for (elements, subaperture, temporal_half_window) in
            [(128, 64, 0), (64, 32, 2), (32, 16, 0)]
        {
            let name = format!(
                "MV, {elements}/{subaperture}/{temporal_half_window}, {}",
                set.name()
            );
            step(&name);
            let x = snapshots(Wavefield::Echo, (BEAMS, settings.samples, elements));
            let mut z = Array2::zeros((BEAMS, settings.samples));
            let mut seconds = f64::NAN;
            alone(set, Method::Mv, temporal_half_window, &x, &mut |core| {
                core(&mut z)?;
                seconds = fastest(settings.budget, || drop(black_box(core(&mut z))));
                Ok(())
            })?;
            let peak = peak(set, settings.budget);
            let flops =
                operations::mv_forward_backward(elements, subaperture, temporal_half_window);
            let rate = flops * z.len() as f64 / seconds;
            let row = Row::new(name, Quantity::new(1e-9 * rate, "GFLOP/s"))
                .beside(Quantity::new(1e-9 * peak, "GFLOP/s"))
                .result(100.0 * rate / peak, "%");
            rows.push(if elements == 128 {
                row.target(Target::AtLeast(50.0))
            } else {
                row
            });
        }
    }
    Ok(Table {
        section: Section::Fraction.to_string(),
        title: "Share of the peak".into(),
        method: "The operations of the exact route (8LP + 8L² + 4L² + L³/3 + 2L² a sample with \
                 P = M − L + 1, 178 kflop at 128/64/0; 3L²/2 more with a time window) over the time, \
                 beside the peak of the same instruction set."
            .into(),
        yardstick: "peak".into(),
        rows,
    })
}

/// Time windows: `K = 10` against `K = 0`.
///
/// # Errors
/// The errors of the core.
pub fn time_window(settings: &Settings, step: &mut (dyn FnMut(&str) + Send)) -> Result<Table> {
    let set = settings.instruction_set;
    let x = snapshots(Wavefield::Echo, (BEAMS, LINE, 128));
    let mut z = Array2::zeros((BEAMS, LINE));
    let mut rows = Vec::new();
    for (name, method) in [("MV", Method::Mv), ("rank-1 ESMV", Method::EsmvRank1)] {
        step(name);
        let mut times = [f64::NAN; 2];
        alone(set, method, 10, &x, &mut |with| {
            alone(set, method, 0, &x, &mut |without| {
                let mut other = z.clone();
                with(&mut z)?;
                without(&mut other)?;
                times = side_by_side(
                    4 * settings.budget,
                    [&mut || drop(black_box(with(&mut z))), &mut || {
                        drop(black_box(without(&mut other)))
                    }],
                );
                Ok(())
            })
        })?;
        let [with, without] = times.map(|seconds| seconds / z.len() as f64);
        rows.push(
            Row::new(
                format!("{name}, 128/64, K = 10"),
                Quantity::microseconds(with),
            )
            .beside(Quantity::microseconds(without))
            .result(with / without, "×")
            .target(Target::AtMost(1.25)),
        );
    }
    Ok(Table {
        section: Section::TimeWindow.to_string(),
        title: "A time window of 21 samples against none, time of one output sample".into(),
        method: format!(
            "As above; a line of {LINE} samples takes {} covariances with K = 10.",
            LINE + 20
        ),
        yardstick: "K = 0".into(),
        rows,
    })
}

/// Several directions of a line against one.
///
/// # Errors
/// The errors of the core.
pub fn sub_lines(settings: &Settings, step: &mut (dyn FnMut(&str) + Send)) -> Result<Table> {
    let (mut rows, mut by_operations) = (Vec::new(), Vec::new());
    for (name, method) in [("MV", Method::Mv), ("rank-1 ESMV", Method::EsmvRank1)] {
        for (elements, half_window) in [(128, 0), (64, 2)] {
            let x = snapshots(Wavefield::Echo, (BEAMS, settings.samples, elements));
            for (count, most) in [(4, 1.25), (16, 1.8)] {
                let label = format!(
                    "{name}, {elements}/{}/{half_window}, {count} sub-lines",
                    elements / 2
                );
                step(&label);
                if method == Method::Mv {
                    let l = elements / 2;
                    let line = operations::mv_forward_backward(elements, l, half_window);
                    let each = (14 * elements + 20 * l + 2 * l * l) as f64;
                    by_operations.push(format!("{:.2}", 1.0 + count as f64 * each / line));
                }
                let of = |sub_lines| Parameters {
                    sub_lines,
                    ..parameters(method, half_window)
                };
                let core = |sub_lines, then: &mut Then<'_>| {
                    with_core(settings.instruction_set, of(sub_lines), &x, then)
                };
                let [mut one, mut all] =
                    [1, count].map(|count| Array2::zeros((BEAMS, settings.samples * count)));
                let mut times = [f64::NAN; 2];
                core(count, &mut |several| {
                    core(1, &mut |single| {
                        several(&mut all)?;
                        single(&mut one)?;
                        times = side_by_side(
                            4 * settings.budget,
                            [&mut || drop(black_box(several(&mut all))), &mut || {
                                drop(black_box(single(&mut one)))
                            }],
                        );
                        Ok(())
                    })
                })?;
                let [several, single] = times.map(|seconds| seconds / one.len() as f64);
                rows.push(
                    Row::new(label, Quantity::microseconds(several))
                        .beside(Quantity::microseconds(single))
                        .result(several / single, "×")
                        .target(Target::AtMost(most)),
                );
            }
        }
    }
    Ok(Table {
        section: Section::SubLines.to_string(),
        title: "Sub-lines against one line, time of one aligned sample".into(),
        method: format!(
            "As the beamformers, M/L/K; all sub-lines of a sample share its covariance. By operations (those of MV \
             above; 14M + 20L + 2L² more a sub-line) MV takes {} times as many, in the order \
             of its rows.",
            by_operations.join(", ")
        ),
        yardstick: "one line".into(),
        rows,
    })
}

/// The peak of every instruction set.
pub fn peaks(settings: &Settings, step: &mut (dyn FnMut(&str) + Send)) -> Table {
    let rows = settings.instruction_sets.iter().map(|&set| {
        step(set.name());
        Row::new(
            set.name(),
            Quantity::new(1e-9 * peak(set, settings.budget), "GFLOP/s"),
        )
    });
    Table {
        section: Section::Peak.to_string(),
        title: "The peak of one core".into(),
        method:
            "f32, in registers: 12, 13, 14 or 24 independent chains, each a multiplication and an \
                 addition a step and not fused; the best number counts."
                .into(),
        yardstick: String::new(),
        rows: rows.collect(),
    }
}
