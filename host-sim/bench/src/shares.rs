//! The beamformer against the peak, and with and without a time window.

use bonebeam::beamform::{Method, Parameters};
use ndarray::Array2;

use super::beamformers::{BEAMS, parameters};
use super::core::Core;
use super::operations;
use super::peak::peak;
use super::report::{Quantity, Row, Table, Target};
use super::settings::{LINE, Section, Settings};
use super::snapshots::{Wavefield, snapshots};
use crate::Result;

/// MV's useful operations per second over the peak of the same instruction set.
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
            let mut core = Core::new(set, parameters(Method::Mv, temporal_half_window), &x)?;
            let seconds = core.seconds(&mut z, settings.budget)?;
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
pub fn time_window(settings: &Settings, step: &mut (dyn FnMut(&str) + Send)) -> Result<Table> {
    let set = settings.instruction_set;
    let x = snapshots(Wavefield::Echo, (BEAMS, LINE, 128));
    let mut z = Array2::zeros((BEAMS, LINE));
    let mut rows = Vec::new();
    for (name, method) in [("MV", Method::Mv), ("rank-1 ESMV", Method::EsmvRank1)] {
        step(name);
        let core = |half_window| Core::new(set, parameters(method, half_window), &x);
        let (mut with, mut without, mut other) = (core(10)?, core(0)?, z.clone());
        let times = with.beside(&mut without, [&mut z, &mut other], 4 * settings.budget)?;
        let times = times.map(|seconds| seconds / z.len() as f64);
        let row = Row::slower(
            format!("{name}, 128/64, K = 10"),
            Quantity::microseconds,
            times,
        );
        rows.push(row.target(Target::AtMost(1.25)));
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
                let core = |sub_lines| {
                    let parameters = Parameters {
                        sub_lines,
                        ..parameters(method, half_window)
                    };
                    Core::new(settings.instruction_set, parameters, &x)
                };
                let [mut one, mut all] =
                    [1, count].map(|count| Array2::zeros((BEAMS, settings.samples * count)));
                let (mut several, mut single) = (core(count)?, core(1)?);
                let budget = 4 * settings.budget;
                let times = several.beside(&mut single, [&mut all, &mut one], budget)?;
                let times = times.map(|seconds| seconds / one.len() as f64);
                let row = Row::slower(label, Quantity::microseconds, times);
                rows.push(row.target(Target::AtMost(most)));
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
