//! Alternatives: the recording as it would be without a mistake that is often made.
//!
//! An alternative is named if echoes agree clearly better with it. Rows of one table.

use std::f64::consts::TAU;

use bonebeam_files::{ChannelData, Samples, Transmits};
use num_complex::Complex;

use crate::base::Base;
use crate::elements::median;
use crate::finding::{Finding, Severity};
use crate::table::{Block, Line, Table, View, Wave, sureness};

/// Gain of the score from which an alternative is named.
const GAIN: f64 = 0.07;
/// Standard deviations by which the phases of transmits must differ from those of the file, and the shares of an
/// alternative's phases that they must have.
const SURE: f64 = 2.5;
const SHARES: std::ops::Range<f64> = 0.5..3.5;
/// Largest phase between transmits that counts, rad.
const STEEP: f64 = 1.5;
/// Cosine of the phase from which neighbouring transmits are of opposite polarity.
const OPPOSITE: f64 = 0.8;
/// Every how many lines are read for it.
const EVERY: usize = 2;
/// Least share of the missing coherence that it brings, but for a small change of the waves.
const SHARE: f64 = 0.15;
/// The same of mirrored beams: if the array is narrow, they lie side by side.
const LITTLE: f64 = 0.03;
const MUCH: f64 = 0.2;
/// Coherence of subapertures from which they agree, and the standard deviations by which it is more.
const FOCUSED: f64 = 0.05;
const SHARPER: f64 = 5.0;
/// The square of the step of a line to the next, over the usual one's, from which it is left out.
const FAR: f64 = 9.0;
/// Share of the usual agreement below which a transmit may be exchanged with another, and that of both once exchanged.
const ODD: f64 = 0.67;
const USUAL: f64 = 0.75;
/// The number of transmits that are tried, and the gain of both by which they are exchanged, if compounded and if not.
const MOST_ODD: usize = 6;
const EXCHANGED: [f64; 2] = [0.15, 0.12];

/// A mistake, the view without it, and its remedy.
type Alternative = (&'static str, Option<View>, &'static str, &'static str);

fn permuted(view: &View, from: impl Fn(usize, usize) -> usize) -> Option<View> {
    let count = view.order.len();
    let order = (0..count).map(|m| view.order[from(m, count)]).collect();
    Some(View {
        order,
        ..view.clone()
    })
}

fn waves(view: &View, change: impl Fn(usize, &Wave) -> Option<Wave>) -> Option<View> {
    let waves: Option<Vec<Wave>> = view
        .waves
        .iter()
        .enumerate()
        .map(|(t, wave)| change(t, wave))
        .collect();
    waves
        .filter(|waves| *waves != view.waves)
        .map(|waves| View {
            waves,
            ..view.clone()
        })
}

fn angles(view: &View, factor: f64) -> Option<View> {
    waves(view, |_, wave| match wave {
        Wave::Plane(angle) => {
            Some(Wave::Plane(angle * factor)).filter(|_| (angle * factor).abs() < 1.2)
        }
        _ => None,
    })
}

/// Each transmit with the wave, or the line, of the one `by` further in the list.
fn shifted(view: &View, by: isize) -> Option<View> {
    let count = view.waves.len();
    let from = |t: usize| (t as isize + by).rem_euclid(count as isize) as usize;
    if count < 4 {
        return None;
    }
    let mut view = view.clone();
    view.waves = (0..count).map(|t| view.waves[from(t)].clone()).collect();
    if view.own {
        view.lines = (0..count).map(|t| view.lines[from(t)]).collect();
    }
    // The list ends there: the transmit without a wave of its own is left out.
    let end = if by > 0 { count - 1 } else { 0 };
    view.signs[end] = 0.0;
    Some(view)
}

fn mirrored(view: &View) -> Option<View> {
    permuted(view, |m, count| count - 1 - m)
}

fn alternatives(view: &View, all_read: bool) -> Vec<Alternative> {
    let halves = |m: usize, count: usize| (m + count / 2) % count;
    // File order 0, n/2, 1, n/2 + 1, …, and the other way.
    let dealt = |m: usize, count: usize| 2 * m % count + 2 * m / count;
    let woven = |m: usize, count: usize| m / 2 + m % 2 * count.div_ceil(2);
    let pairs = |m: usize, count: usize| (m ^ 1).min(count - 1);
    let elements = "elements are in another order than their positions";
    let mut all = vec![
        (
            "mirrored",
            mirrored(view),
            "elements run from right to left, or the transmits do (tx_x, tx_source_x, the sign of tx_angle)",
            "reverse the axis of the elements, or the transmits' positions or angles",
        ),
        (
            "connectors",
            permuted(view, halves),
            "the two halves of the elements are exchanged",
            "exchange the halves of rf",
        ),
        (
            "interleaved",
            permuted(view, dealt),
            elements,
            "take the elements in the order 0, n/2, 1, n/2 + 1, …",
        ),
        (
            "interleaved",
            permuted(view, woven),
            elements,
            "take the elements in the order 0, 2, …, 1, 3, …",
        ),
        (
            "interleaved",
            permuted(view, pairs),
            elements,
            "exchange each two neighbours of rf",
        ),
        (
            "angle-unit",
            angles(view, 1f64.to_radians()),
            "`tx_angle` is in degrees",
            "give tx_angle in radians",
        ),
        (
            "angle-unit",
            angles(view, 1f64.to_degrees()),
            "`tx_angle` was converted to radians twice",
            "give tx_angle in radians",
        ),
        (
            "element-index",
            waves(view, |_, wave| match wave {
                Wave::Element(m) => Some(Wave::Element(m.checked_sub(1)?)),
                _ => None,
            }),
            "`tx_element` counts from 1",
            "subtract 1 from tx_element",
        ),
    ];
    if all_read && !view.own {
        for by in [1, -1] {
            all.push((
                "transmit-order",
                shifted(view, by),
                "records and the list of transmits are shifted by one: a transmit is missing or doubled",
                "take out the doubled record, or the entry of the missing one",
            ));
        }
    }
    all
}

/// Whether the phases between transmits are those of an alternative's waves.
///
/// Echoes beside a line turn them, too: by receiving, it is known how far beside. The share of the alternative's phases
/// is 1 for single points, and 2 for tissue, of which the wrong waves select echoes beside the line. Its variance is
/// that of leaving lines out.
fn moved(view: &View, table: &Table, other: &View) -> bool {
    let mut lines = vec![[0.0; 2]; view.lines.len()];
    let turn = TAU * table.frequency;
    for block in table.blocks.iter().filter(|block| block.total() > 0.0) {
        let line = view.lines[block.line];
        let r = view.c * block.time;
        let (sin, cos) = line.angle.sin_cos();
        // A length in which all phases are linear.
        let aside = 0.05 * view.c / table.frequency;
        let beside = Line {
            from: [line.from[0] + aside * cos, line.from[1] - aside * sin],
            ..line
        };
        let back = |line: &Line| -> Vec<f64> {
            let of = |m| view.receive(line, block.time, m, view.c);
            (0..view.elements.len()).map(of).collect()
        };
        let [here, there] = [back(&line), back(&beside)];
        let mut sums = [0.0; 2];
        for part in block.parts.iter().filter(|part| part.power > 0.0) {
            let by = |first: usize| -> f64 {
                let elements = first..first + part.elements;
                elements.map(|m| there[m] - here[m]).sum::<f64>() / part.elements as f64
            };
            let by = -turn * (by(part.first + part.elements) - by(part.first));
            sums[0] += by * f64::from(part.product.im / part.power);
            sums[1] += by * by * f64::from(part.product.re.max(0.0) / part.power);
        }
        let share = if sums[1] > 0.0 {
            sums[0] / sums[1]
        } else {
            0.0
        };
        let share = share.clamp(-100.0, 100.0);
        let phases = |view: &View, line: &Line| -> Vec<f64> {
            let of = |wave| turn * view.arrival(wave, line, r);
            view.waves.iter().map(of).collect()
        };
        let [own, aside, moved] = [
            phases(view, &line),
            phases(view, &beside),
            phases(other, &line),
        ];
        for (t, (product, power)) in block.transmits.iter().enumerate() {
            let between = |of: &[f64]| (own[t + 1] - own[t]) - (of[t + 1] - of[t]);
            let (by, tilt) = (between(&moved), share * between(&aside));
            if by.abs() < STEEP && *power > 0.0 && other.signs[t] * other.signs[t + 1] != 0.0 {
                let value = Complex::new(f64::from(product.re), f64::from(product.im))
                    * Complex::from_polar(1.0 / f64::from(*power), -tilt);
                lines[block.line][0] += by * by * value.norm();
                lines[block.line][1] += by * value.norm() * value.arg();
            }
        }
    }
    let (share, variance) = jackknife(&lines);
    SHARES.contains(&share) && share * share > SURE * SURE * variance
}

/// The slope of lines' sums of xx and xy, and its variance.
fn jackknife(lines: &[[f64; 2]]) -> (f64, f64) {
    let without = |left: usize| {
        let kept = lines
            .iter()
            .enumerate()
            .filter(|(line, _)| line.abs_diff(left) > 1);
        let [xx, xy] = kept.fold([0.0; 2], |sum, (_, own)| [sum[0] + own[0], sum[1] + own[1]]);
        xy / xx
    };
    let slope = without(usize::MAX);
    // Each line is left out three times.
    let squares = (0..lines.len()).map(|line| (without(line) - slope).powi(2));
    (slope, squares.sum::<f64>() / 3.0)
}

/// The view that echoes agree with best, and a finding if it is not that of the file.
pub(crate) fn check(
    base: &Base,
    view: View,
    table: Table,
    all_read: bool,
) -> (View, Table, Vec<Finding>) {
    let coarse = View {
        every: EVERY,
        ..view.clone()
    };
    let of_file = Table::new(base, &coarse);
    let (own, focused) = (of_file.score(), of_file.focused());
    let most = if table.transmit_coherence().is_some() {
        2.0
    } else {
        1.0
    };
    let mut best: Option<(f64, Alternative)> = None;
    let mut highest = f64::NEG_INFINITY;
    let mut is_one_named = false;
    for alternative in alternatives(&coarse, all_read) {
        let Some(other) = &alternative.1 else {
            continue;
        };
        let table_of_other = Table::new(base, other);
        let score = table_of_other.score();
        let gain = score - own;
        highest = highest.max(score);
        let small = matches!(alternative.0, "element-index" | "transmit-order");
        let missing = gain / (most - own);
        let named = match small {
            true => gain > GAIN || gain > 0.0 && moved(&view, &table, other),
            false if view.own && alternative.0 == "mirrored" => gain > LITTLE && missing > MUCH,
            false => gain > GAIN && missing > SHARE,
        } || !small && gain > LITTLE && is_sharper(&table_of_other.focused(), &focused);
        is_one_named |= named;
        let counts = named || gain > GAIN;
        if counts && best.as_ref().is_none_or(|(best, ..)| score > *best) {
            best = Some((score, alternative));
        }
    }
    let best = best.filter(|_| is_one_named);
    let two = all_read.then(|| exchanged(base, &view, &table)).flatten();
    if let Some((view, [a, b])) = two {
        let table = Table::new(base, &view);
        let coarse = View {
            every: EVERY,
            ..view.clone()
        };
        if Table::new(base, &coarse).score() > highest {
            let text = format!("transmits {a} and {b} have each other's echoes");
            let finding = Finding::new("transmit-order", Severity::Error, text)
                .valued(2.0, "transmits")
                .remedy("exchange their records, or their entries in the list of transmits");
            return (view, table, vec![finding]);
        }
    }
    match best {
        Some((score, (name, Some(other), text, remedy))) => {
            let text = format!(
                "echoes agree better if {text}: neighbours' coherence {score:.2} and not {own:.2}"
            );
            let finding = Finding::new(name, Severity::Error, text).remedy(remedy);
            let view = View { every: 1, ..other };
            let table = Table::new(base, &view);
            (view, table, vec![finding.valued(score - own, "coherence")])
        }
        _ => match listed(&view, &table, all_read) {
            Some((other, finding)) => {
                let table = Table::new(base, &other);
                (other, table, vec![finding])
            }
            None => (view, table, Vec::new()),
        },
    }
}

/// Whether subapertures agree, and on most lines better than otherwise.
fn is_sharper(focused: &[f64], otherwise: &[f64]) -> bool {
    let mean = focused.iter().sum::<f64>() / focused.len() as f64;
    mean > FOCUSED && sureness(focused, otherwise) > SHARPER
}

/// Two transmits that have each other's place in the list: both agree better once exchanged.
fn exchanged(base: &Base, view: &View, table: &Table) -> Option<(View, [usize; 2])> {
    let own = table.agreements(view);
    let usual = median(own.iter().copied());
    let mut odd: Vec<usize> = (0..own.len()).filter(|&t| own[t] < ODD * usual).collect();
    odd.sort_by(|&a, &b| own[a].total_cmp(&own[b]));
    odd.truncate(MOST_ODD);
    odd.sort_unstable();
    let near = if view.own { 0 } else { 1 };
    let pairs = (0..odd.len()).flat_map(|i| (i + 1..odd.len()).map(move |j| [i, j]));
    let of_pair = |[i, j]: [usize; 2]| {
        let [a, b] = [odd[i], odd[j]];
        let mut other = view.clone();
        other.waves.swap(a, b);
        if view.own {
            other.lines.swap(a, b);
        }
        let mut few = other.clone();
        for (t, sign) in few.signs.iter_mut().enumerate() {
            if t.abs_diff(a) > near && t.abs_diff(b) > near {
                *sign = 0.0;
            }
        }
        let new = Table::new(base, &few).agreements(view);
        let gain = (new[a] - own[a]).min(new[b] - own[b]);
        let is_usual = new[a].min(new[b]) > USUAL * usual;
        is_usual.then_some((gain, other, [a, b]))
    };
    let best = pairs
        .filter_map(of_pair)
        .max_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 > EXCHANGED[usize::from(view.own)]).then_some((best.1, best.2))
}

/// Records and a list of transmits that are shifted by one: all echoes then come from the next transmit's line.
///
/// Their phases between neighbouring elements say from where.
fn listed(view: &View, table: &Table, all_read: bool) -> Option<(View, Finding)> {
    if !all_read || !view.own {
        return None;
    }
    [1, -1].into_iter().find_map(|by| {
        let other = shifted(view, by)?;
        let mut lines = vec![[0.0; 2]; view.lines.len()];
        let counts = |block: &&Block| block.total() > 0.0 && other.signs[block.line] != 0.0;
        for block in table.blocks.iter().filter(counts) {
            let (own, next) = (view.lines[block.line], other.lines[block.line]);
            let [along, across] = view.pitch_at(own.from);
            // The path to the next element, less by this.
            let nearer = |line: Line| {
                let at = line.at(view.c * block.time);
                let [x, z] = [at[0] - own.from[0], at[1] - own.from[1]];
                (x * along + z * across) / x.hypot(z)
            };
            let expected = nearer(next) - nearer(own);
            let sum = block.next();
            let found = f64::from(sum.arg()) * view.c / (TAU * table.frequency);
            let weight = (f64::from(sum.norm()) / block.total()).powi(2);
            lines[block.line][0] += weight * expected * expected;
            lines[block.line][1] += weight * expected * found;
        }
        // The list's first and last may stand side by side.
        let usual = median(lines.iter().map(|own| own[0]).filter(|&xx| xx > 0.0));
        let lines: Vec<[f64; 2]> = lines
            .iter()
            .map(|&[xx, xy]| if xx < FAR * usual { [xx, xy] } else { [0.0; 2] })
            .collect();
        let (share, variance) = jackknife(&lines);
        if !(0.65..1.35).contains(&share) || share * share < SURE * SURE * variance {
            return None;
        }
        let text = "records and the list of transmits are shifted by one, a transmit is missing or doubled: all echoes \
                    come from the next transmit's line";
        let finding = Finding::new("transmit-order", Severity::Error, text)
            .valued(share, "lines")
            .remedy("take out the doubled record, or the entry of the missing one");
        Some((other, finding))
    })
}

/// Base band at the frequency, rate and sign of the echoes, and a finding if they are not the file's.
pub(crate) fn band(
    data: &ChannelData,
    chosen: &[usize],
    view: &View,
) -> (Base, View, Vec<Finding>) {
    let own = Base::new(data, chosen, data.f0, data.fs);
    let of = |base: &Base, view: &View| Table::new(base, view);
    if let Samples::Iq { f_demod, .. } = data.samples {
        return iq(data, chosen, view, own, f_demod);
    }
    let table = of(&own, view);
    let mut best = (1.0, table.coherent_power());
    for factor in [2.0, 0.5] {
        if factor * data.f0 < 0.5 * data.fs {
            let base = Base::new(data, chosen, factor * data.f0, data.fs);
            let power = of(&base, view).coherent_power();
            if power > 2.0 * best.1 {
                best = (factor, power);
            }
        }
    }
    if best.0 == 1.0 {
        return (own, view.clone(), Vec::new());
    }
    let (factor, _) = best;
    let harmonic = Base::new(data, chosen, factor * data.f0, data.fs);
    let rate = Base::new(data, chosen, data.f0, data.fs / factor);
    let mhz = |f: f64| format!("{:.3} MHz", f / 1e6);
    if of(&rate, view).score() > of(&harmonic, view).score() {
        let text = format!(
            "echoes lie at {} and their curvature fits half or twice the rate: `fs` is {} and not {}",
            mhz(factor * data.f0),
            mhz(data.fs / factor),
            mhz(data.fs)
        );
        let finding =
            Finding::new("sampling-rate", Severity::Error, text).valued(data.fs / factor, "Hz");
        return (
            rate,
            view.clone(),
            vec![finding.remedy(format!("--variable fs={:e}", data.fs / factor))],
        );
    }
    let found = factor * data.f0;
    let text = format!(
        "echoes lie at {} and not at `f0`, {}: of a harmonic, `f0` is the received frequency",
        mhz(found),
        mhz(data.f0)
    );
    let finding = Finding::new("harmonic", Severity::Error, text).valued(found, "Hz");
    (
        harmonic,
        view.clone(),
        vec![finding.remedy(format!("--variable f0={found:e}"))],
    )
}

fn iq(
    data: &ChannelData,
    chosen: &[usize],
    view: &View,
    own: Base,
    f_demod: f64,
) -> (Base, View, Vec<Finding>) {
    let score = Table::new(&own, view).score();
    let conjugate = View {
        conjugate: true,
        ..view.clone()
    };
    let turned = Table::new(&own, &conjugate).score();
    if turned > score + GAIN {
        let text = format!(
            "I/Q has the other sign of the carrier: neighbours' coherence {turned:.2} and not {score:.2}"
        );
        let finding =
            Finding::new("carrier-sign", Severity::Error, text).valued(turned - score, "coherence");
        return (own, conjugate, vec![finding.remedy("--iq-conjugate")]);
    }
    for factor in [2.0, 0.5] {
        let base = Base::new(data, chosen, f_demod, factor * data.fs);
        let other = Table::new(&base, view).score();
        if other > score + GAIN {
            let text = format!(
                "the curvature of echoes fits an `fs` of {} Hz and not {}",
                factor * data.fs,
                data.fs
            );
            let finding =
                Finding::new("sampling-rate", Severity::Error, text).valued(factor * data.fs, "Hz");
            return (
                base,
                view.clone(),
                vec![finding.remedy(format!("--variable fs={:e}", factor * data.fs))],
            );
        }
    }
    (own, view.clone(), Vec::new())
}

/// Transmits of opposite sign, and records that are there twice.
pub(crate) fn transmits(
    data: &ChannelData,
    base: &Base,
    view: &View,
    table: &Table,
) -> Vec<Finding> {
    let mut findings = Vec::new();
    let negative = |t: usize| {
        let (sum, power) = table.transmits[t];
        sum.norm() > 0.2 * power && sum.re < -OPPOSITE * sum.norm()
    };
    let count = view.waves.len();
    if !view.own && count > 2 && table.coherence() > 0.0 {
        let inverted: Vec<usize> = (0..count)
            .filter(|&t| match t {
                0 => negative(0) && !negative(1),
                t if t + 1 == count => negative(t - 1) && !negative(t - 2),
                t => negative(t - 1) && negative(t),
            })
            .collect();
        if !inverted.is_empty() {
            let text = format!("transmits {inverted:?} have the opposite polarity of the others");
            let finding = Finding::new("polarity", Severity::Error, text)
                .valued(inverted.len() as f64, "transmits");
            findings.push(
                finding.remedy("change the sign of their rf; of pulse inversion, sum the pairs"),
            );
        }
    }
    let same: Vec<usize> = (1..count)
        .filter(|&t| view.waves[t] != view.waves[t - 1] || view.own && differ(data, t))
        .filter(|&t| doubled(base, t))
        .collect();
    if !same.is_empty() {
        let text =
            format!("the records of transmits {same:?} are those of the transmits before them");
        let finding =
            Finding::new("doubled", Severity::Error, text).valued(same.len() as f64, "transmits");
        findings
            .push(finding.remedy("take out the doubled records, or mend the list of transmits"));
    }
    findings
}

fn differ(data: &ChannelData, t: usize) -> bool {
    match &data.transmits {
        Transmits::Focused { x, .. } => x.get(t) != x.get(t - 1),
        _ => true,
    }
}

/// Whether a record is that of the transmit before, but for noise.
fn doubled(base: &Base, t: usize) -> bool {
    let (_, elements, samples) = base.z.dim();
    let (mut same, mut total) = (0.0f64, 0.0f64);
    for m in 0..elements {
        for n in 0..samples {
            let [a, b] = [base.z[[t - 1, m, n]], base.z[[t, m, n]]];
            same += f64::from((a * b.conj()).re);
            total += f64::from(a.norm_sqr() + b.norm_sqr()) / 2.0;
        }
    }
    total > 0.0 && same > 0.999 * total
}
