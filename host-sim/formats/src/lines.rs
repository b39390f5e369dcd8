//! Lines of a scanner: real (RF) or complex, by the key `lines`.

use ndarray::{Array3, Array4, ArrayD, Axis};
use num_complex::Complex;

use crate::aliases::{complete, is_given};
use crate::keyed::{Axes, Keyed};
use crate::values::{NamedArrays, Values};
use crate::variables::{AXES, Given, LINE_KEYS, Variables};
use bonebeam_files::terminal::digits;
use bonebeam_files::{BeamRays, BeamformedLines, LineFrames, Result};

/// Axis of real lines along which I and Q are, or the second of two axes that are one.
const IQ: &str = "iq";
/// Half the number of taps of the Hilbert transformer.
const REACH: usize = 63;
/// Keys of lines, besides those of their own.
const KEYS: [&str; 6] = ["fs", "f0", "c", "t0", "pitch", AXES];

/// Whether a file holds lines.
pub fn is(source: &dyn NamedArrays, variables: &Variables) -> bool {
    let given = |key: &str| is_given(source, variables, key);
    given("lines") && !given("rf") && !given("iq")
}

/// The lines of all frames, and what was assumed.
///
/// Real lines become analytic.
///
/// # Errors
/// A key is missing, has another type or shape, or has no effect; lines that are not valid.
pub fn read(source: &dyn NamedArrays, variables: &Variables) -> Result<(LineFrames, Vec<String>)> {
    let known = |key: &str| KEYS.contains(&key) || LINE_KEYS.contains(&key);
    if let Some(key) = variables.keys().find(|key| !known(key)) {
        let expected = [&KEYS[..], &LINE_KEYS].concat().join(", ");
        return Err(source.error(format!(
            "holds lines, for which `{key}` in [variables] (--variable) has no effect; expected {expected}"
        )));
    }
    let (mut all, mut assumed) = complete(source, variables);
    assumed.retain(|what| what.split(' ').next().is_some_and(known));
    for (key, value, unit) in [("c", 1540.0, " m/s"), ("t0", 0.0, "")] {
        if !is_given(source, &all, key) {
            all.insert(key, Given::Number(value));
            assumed.push(format!(
                "{key} is {value}{unit}, which the file does not give"
            ));
        }
    }
    let keyed = Keyed {
        source,
        variables: &all,
        law: None,
    };
    keyed.check_that_lines_are_given()?;
    let fs = keyed.scalar("fs")?;
    let z = samples(&keyed, fs, &mut assumed)?;
    let beams = z.dim().1;
    let mut lines = BeamformedLines {
        z,
        fs,
        t0: keyed.scalar("t0")?,
        beam_x: match keyed.optional("beam_x")? {
            Some(x) => x,
            None => keyed.centred(beams)?,
        },
        rays: BeamRays::of(
            beams,
            keyed.optional("beam_z")?,
            keyed.optional("beam_angle")?,
        ),
        sub_lines: 1,
        c: keyed.scalar("c")?,
    };
    if lines.beam_x.windows(2).all(|pair| pair[1] < pair[0]) {
        lines.beam_x.reverse();
        lines.z.invert_axis(Axis(1));
        lines.z = lines.z.as_standard_layout().into_owned();
        if let Some(rays) = &mut lines.rays {
            rays.z.reverse();
            rays.angle.reverse();
        }
    }
    lines.check().map_err(|message| source.error(message))?;
    assumed.extend(zigzag(&lines.z));
    Ok((lines, assumed))
}

/// Largest shift that is looked for, samples.
const SHIFTS: i64 = 8;

/// A remark about lines of which every second one is shifted, by the correlation of neighbours in the first frame.
fn zigzag(z: &Array3<Complex<f32>>) -> Option<String> {
    let frame = z.index_axis(Axis(0), 0);
    // From lines of even numbers to the next, and from odd ones.
    let shift = |first: usize| -> Option<i64> {
        let level = |shift: i64| -> f64 {
            let pairs = (first..frame.nrows().saturating_sub(1)).step_by(2);
            let pair = |k: usize| -> f64 {
                let (line, next) = (frame.row(k), frame.row(k + 1));
                let (skip, late) = (shift.max(0) as usize, (-shift).max(0) as usize);
                let both = line.iter().skip(late).zip(next.iter().skip(skip));
                both.map(|(a, b)| f64::from((a * b.conj()).re)).sum()
            };
            pairs.map(pair).sum()
        };
        (-SHIFTS..=SHIFTS).max_by(|&a, &b| level(a).total_cmp(&level(b)))
    };
    let (even, odd) = (shift(0)?, shift(1)?);
    let is_shifted = even != 0 && even == -odd && even.abs() < SHIFTS;
    is_shifted.then(|| {
        let (whose, by) = (["odd", "even"][usize::from(even < 0)], even.abs());
        format!("the lines of {whose} numbers, from 0, lie {by} samples deeper than their neighbours, and are not moved")
    })
}

/// The array `lines` as [frame, beam, sample], analytic.
fn samples(keyed: &Keyed<'_>, fs: f64, assumed: &mut Vec<String>) -> Result<Array3<Complex<f32>>> {
    let source = keyed.source;
    let name = keyed.name("lines").unwrap_or("lines");
    let wrong = |message: String| source.error(format!("`{name}` {message}"));
    let values = source.samples(name, None)?;
    let shape = values.shape();
    let given = keyed.variables.get(AXES);
    let order: Vec<String> = match given {
        Some(Given::Names(names)) => names.clone(),
        _ => {
            let beams = keyed.optional("beam_x")?.map(|x| x.len());
            // Lines have more samples than there are lines.
            let turned = match (&shape[shape.len().saturating_sub(2)..], beams) {
                (&[a, b], Some(beams)) => a != b && b == beams,
                (&[a, b], None) => a > b,
                _ => false,
            };
            let mut order = ["frame", "beam", "sample"];
            if turned {
                order.swap(1, 2);
                let why = "the axes of `lines` are sample, beam, by their lengths; --variable axes=beam,sample";
                assumed.push(why.into());
            }
            let skipped = usize::from(shape.len() < 3);
            order[skipped..]
                .iter()
                .map(|&axis| axis.to_owned())
                .collect()
        }
    };
    // A beam has one record, or one of I and one of Q.
    let role = |axis: &String| match axis.as_str() {
        "beam" => "element".to_owned(),
        IQ => "transmit".to_owned(),
        axis => axis.to_owned(),
    };
    let roles = Given::Names(order.iter().map(role).collect());
    let axes = Axes::new(Some(&roles), None, None, false).ok().filter(|_| {
        !order
            .iter()
            .any(|axis| ["element", "transmit"].contains(&axis.as_str()))
    });
    let axes = axes.ok_or_else(|| {
        let order = order.join(", ");
        wrong(format!(
            "has axes {order}; expected beam, sample, frame if there are several, and iq after beam or sample if I and Q \
             take turns there"
        ))
    })?;
    let in_turn = order.iter().position(|axis| axis == IQ);
    let expected = order.join(", ");
    let misfit = format!("has shape {shape:?}; expected the axes {expected} (--variable axes=…)");
    let misfit = |_: String| wrong(misfit.clone());
    let z = match values {
        Values::Real(parts) if in_turn.is_some() => {
            let parts = in_pairs(parts, order.len(), in_turn.unwrap_or(0)).map_err(wrong)?;
            let parts = axes.arranged(parts).map_err(misfit)?;
            let [i, q] = [0, 1].map(|part| parts.index_axis(Axis(1), part));
            let z = ndarray::Zip::from(i)
                .and(q)
                .map_collect(|&i, &q| Complex::new(i, q));
            z.insert_axis(Axis(1))
        }
        Values::Complex(z) => axes.arranged(z).map_err(misfit)?,
        Values::Real(rf) => {
            if let Some(f0) = keyed
                .optional("f0")?
                .iter()
                .flatten()
                .find(|&&f0| 2.0 * f0 >= fs)
            {
                return Err(wrong(format!(
                    "is real, and `f0` is {} Hz; expected less than half the sampling rate `fs` of {} Hz",
                    digits(*f0),
                    digits(fs)
                )));
            }
            let rf = axes.arranged(rf).map_err(misfit)?;
            let z = analytic(&rf).map_err(wrong)?;
            let share = share_below(&rf);
            if given.is_none() && share > BASE_BAND {
                let order = order.join(",");
                return Err(wrong(format!(
                    "is real, and {:.0} % of its power lie below half its mean frequency, as of I and Q in the base band; \
                     give --variable axes={} if lines of I and of Q take turns, axes={} if samples do, axes={order} if it is RF",
                    100.0 * share,
                    order.replace("beam", "beam,iq"),
                    order.replace("sample", "sample,iq"),
                )));
            }
            z
        }
    };
    Ok(z.index_axis_move(Axis(1), 0))
}

/// An array in which the axis of I and Q, of length 2, is an axis of its own at `axis`.
fn in_pairs(
    parts: ArrayD<f32>,
    rank: usize,
    axis: usize,
) -> std::result::Result<ArrayD<f32>, String> {
    let mut shape = parts.shape().to_vec();
    if shape.len() + 1 == rank && axis > 0 && shape[axis - 1].is_multiple_of(2) {
        shape[axis - 1] /= 2;
        shape.insert(axis, 2);
    }
    let parts = parts.as_standard_layout().into_owned();
    match shape.get(axis) {
        Some(2) => parts
            .into_shape_with_order(shape)
            .map_err(|e| e.to_string()),
        _ => Err(format!(
            "has shape {shape:?}, which is not one of pairs of I and Q"
        )),
    }
}

/// [`share_below`] above which lines are no RF.
const BASE_BAND: f64 = 0.32;
/// Lags of the correlation for [`share_below`], samples.
const LAGS: usize = 128;

/// The share of the power of real lines below half their mean frequency.
///
/// Less than 0.1 for RF, 0.25 for noise, 0.38 for either part of I/Q with a Gaussian spectrum.
fn share_below(rf: &Array4<f32>) -> f64 {
    let (frames, _, beams, samples) = rf.dim();
    let step = (frames * beams).div_ceil(64).max(1);
    let mut correlation = [0.0; LAGS];
    for line in rf.rows().into_iter().step_by(step) {
        let mean = line.iter().copied().map(f64::from).sum::<f64>() / samples.max(1) as f64;
        let line: Vec<f64> = line.iter().map(|&v| f64::from(v) - mean).collect();
        for (lag, sum) in correlation.iter_mut().enumerate() {
            let later = line.iter().skip(lag);
            *sum += line.iter().zip(later).map(|(a, b)| a * b).sum::<f64>();
        }
    }
    let at = |lag: usize| correlation[lag] / correlation[0];
    let edge = 0.5 * at(1).clamp(-1.0, 1.0).acos();
    let term = |lag: usize| {
        let (k, window) = (lag as f64, std::f64::consts::PI * lag as f64 / LAGS as f64);
        at(lag) * (0.5 + 0.5 * window.cos()) * (k * edge).sin() / k
    };
    (edge + 2.0 * (1..LAGS).map(term).sum::<f64>()) / std::f64::consts::PI
}

/// Analytic lines of RF, without its mean.
///
/// # Errors
/// Lines like envelopes, without a sample below 0.
fn analytic(rf: &Array4<f32>) -> std::result::Result<Array4<Complex<f32>>, String> {
    let (.., samples) = rf.dim();
    let count = rf.len() as f64;
    let (sum, squares) = rf.iter().fold((0.0, 0.0), |(sum, squares), &v| {
        (sum + f64::from(v), squares + f64::from(v) * f64::from(v))
    });
    // Offset binary varies little about its zero.
    if rf.iter().all(|&v| v >= 0.0) && squares * count > 1.25 * sum * sum {
        return Err("is real and has no sample below 0, like envelopes; RF oscillates about 0; give envelopes \
                    as complex numbers"
            .into());
    }
    // A Hilbert transformer under a Hann window.
    let half = REACH as f64 + 1.0;
    let taps: Vec<f64> = (1..=REACH)
        .step_by(2)
        .map(|k| {
            let hann = 0.5 + 0.5 * (std::f64::consts::PI * k as f64 / half).cos();
            2.0 / (std::f64::consts::PI * k as f64) * hann
        })
        .collect();
    let mut z = Array4::zeros(rf.dim());
    for (rf, mut z) in rf.rows().into_iter().zip(z.rows_mut()) {
        let mean = rf.iter().copied().map(f64::from).sum::<f64>() / samples.max(1) as f64;
        let at = |n: Option<usize>| {
            n.and_then(|n| rf.get(n))
                .map_or(0.0, |&v| f64::from(v) - mean)
        };
        for (n, z) in z.iter_mut().enumerate() {
            let odd = taps.iter().zip((1..).step_by(2));
            let imaginary: f64 = odd
                .map(|(tap, k)| tap * (at(n.checked_sub(k)) - at(Some(n + k))))
                .sum();
            *z = Complex::new(at(Some(n)) as f32, imaginary as f32);
        }
    }
    Ok(z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::values::Arrays;
    use ndarray::Array2;

    const FS: f64 = 40e6;

    /// Two lines of a burst of 5 MHz at sample 300, on an offset, as sample, beam.
    fn file() -> Arrays {
        let mut file = Arrays::default();
        let rf = |n: usize, beam: usize| {
            let u = (n as f64 - 300.0) / FS;
            let burst = (-(u * 2e6).powi(2)).exp() * (std::f64::consts::TAU * 5e6 * u).cos();
            30.0 + (1.0 + beam as f64) * burst
        };
        let all = Array2::from_shape_fn((800, 2), |(n, beam)| rf(n, beam));
        file.set("lines", &[800, 2], &all.into_raw_vec_and_offset().0);
        for (key, value) in [("fs", FS), ("f0", 5e6), ("pitch", 0.3e-3)] {
            file.set(key, &[], &[value]);
        }
        file
    }

    #[test]
    fn real_lines_become_analytic_in_their_place() {
        let (lines, assumed) = read(&file(), &Variables::default()).unwrap();
        assert_eq!(lines.z.dim(), (1, 2, 800));
        assert_eq!(lines.beam_x, [-0.15e-3, 0.15e-3]);
        for (beam, line) in lines.z.rows().into_iter().enumerate() {
            let level = 1.0 + beam as f32;
            let peak = (0..800).max_by(|&a, &b| line[a].norm().total_cmp(&line[b].norm()));
            assert_eq!(peak, Some(300));
            assert!(
                (line[300].norm() - level).abs() < 0.01 * level,
                "{}",
                line[300]
            );
            // No second peak of the carrier, and nothing left of the offset.
            let envelope =
                |n: usize| level * (-(((n as f64 - 300.0) / FS) * 2e6).powi(2)).exp() as f32;
            assert!((0..800).all(|n| (line[n].norm() - envelope(n)).abs() < 0.02 * level + 0.05));
        }
        let assumed = assumed.join("; ");
        assert!(
            assumed.contains("c is 1540 m/s") && assumed.contains("sample, beam"),
            "{assumed}"
        );
    }

    /// As of a scanner whose receivers take turns.
    #[test]
    fn a_shift_of_every_second_line_is_said() {
        for (shift, word) in [(2, Some("odd")), (-3, Some("even")), (0, None)] {
            let rf = |n: usize, beam: usize| {
                let late = shift * (beam % 2) as i64;
                let u = (n as f64 - 300.0 - 0.4 * beam as f64 - late as f64) / FS;
                (-(u * 2e6).powi(2)).exp() * (std::f64::consts::TAU * 5e6 * u).cos()
            };
            let all = Array2::from_shape_fn((800, 12), |(n, beam)| rf(n, beam));
            let mut shifted = file();
            shifted.set("lines", &[800, 12], &all.into_raw_vec_and_offset().0);
            let assumed = read(&shifted, &Variables::default()).unwrap().1.join("; ");
            let said = word
                .map(|word| format!("the lines of {word} numbers, from 0, lie {}", shift.abs()));
            let fits = match &said {
                Some(said) => assumed.contains(said),
                None => !assumed.contains("deeper"),
            };
            assert!(fits, "{shift}: {assumed}");
        }
    }

    /// As of PLUS.
    #[test]
    fn i_and_q_in_turn_are_lines_or_refused() {
        let z = |beam: usize, n: usize| {
            let u = (n as f64 - 300.0) / FS;
            Complex::from_polar((-(u * 2e6).powi(2)).exp(), 0.9 * beam as f64 + 1e6 * u)
        };
        let mut file = file();
        let part = |(line, n)| {
            if line % 2 == 1 {
                z(line / 2, n).im
            } else {
                z(line / 2, n).re
            }
        };
        let all = Array2::from_shape_fn((24, 800), part);
        file.set("lines", &[24, 800], &all.into_raw_vec_and_offset().0);
        let mut variables = Variables::default();
        let refused = read(&file, &variables).unwrap_err().to_string();
        assert!(
            refused.contains("axes=beam,iq,sample if lines"),
            "{refused}"
        );
        variables.take("axes=beam,iq,sample").unwrap();
        let lines = read(&file, &variables).unwrap().0;
        assert_eq!(lines.z.dim(), (1, 12, 800));
        for ((_, beam, n), found) in lines.z.indexed_iter() {
            let z = z(beam, n);
            assert!((found - Complex::new(z.re as f32, z.im as f32)).norm() < 1e-6);
        }
    }

    #[test]
    fn lines_from_right_to_left_are_turned_and_others_refused() {
        let mut turned = file();
        turned.0.retain(|(name, _)| name != "pitch");
        turned.set("beam_x", &[2], &[1e-3, -1e-3]);
        let (lines, _) = read(&turned, &Variables::default()).unwrap();
        assert_eq!(lines.beam_x, [-1e-3, 1e-3]);
        assert!(lines.z[[0, 0, 300]].norm() > 1.5 && lines.z[[0, 1, 300]].norm() < 1.5);

        let refused = |file: &Arrays, variable: &str| {
            let mut variables = Variables::default();
            if !variable.is_empty() {
                variables.take(variable).unwrap();
            }
            read(file, &variables).unwrap_err().to_string()
        };
        assert!(refused(&file(), "tx_angle=0").contains("`tx_angle`"));
        assert!(refused(&file(), "f0=30e6").contains("less than half"));
        assert!(refused(&file(), "axes=sample,element").contains("expected beam, sample"));
        turned.0.retain(|(name, _)| name != "beam_x");
        assert!(refused(&turned, "").contains("`beam_x` or `pitch`"));
        let mut envelopes = file();
        let levels: Vec<f64> = (0..1600).map(|n| f64::from(n % 100 == 0)).collect();
        envelopes.set("lines", &[800, 2], &levels);
        assert!(refused(&envelopes, "").contains("envelopes"));
    }
}
