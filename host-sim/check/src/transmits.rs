//! Transmits: their places in the list, their signs, and records that are there twice.

use std::f64::consts::TAU;

use bonebeam_files::{ChannelData, Transmits};
use num_complex::Complex;

use crate::base::Base;
use crate::elements::median;
use crate::finding::{Finding, Severity};
use crate::table::{Block, Table};
use crate::view::{Line, View};

/// Standard deviations by which the phases of transmits must differ from those of the file, and the shares of an
/// alternative's phases that they must have.
const SURE: f64 = 2.5;
const SHARES: std::ops::Range<f64> = 0.5..3.5;
/// Largest phase between transmits that counts, rad.
const STEEP: f64 = 1.5;
/// Cosine of the phase from which neighbouring transmits are of opposite polarity.
const OPPOSITE: f64 = 0.8;
/// The square of the step of a line to the next, over the usual one's, from which it is left out.
const FAR: f64 = 9.0;
/// Share of the usual agreement below which a transmit may be exchanged with another, and that of both once exchanged.
const ODD: f64 = 0.67;
const USUAL: f64 = 0.75;
/// The number of transmits that are tried, and the gain of both by which they are exchanged, if compounded and if not.
const MOST_ODD: usize = 6;
const EXCHANGED: [f64; 2] = [0.15, 0.12];

/// Each transmit with the wave, or the line, of the one `by` further in the whole list, of which some are read.
pub(crate) fn shifted(
    (data, read): (&ChannelData, &[usize]),
    view: &View,
    by: isize,
) -> Option<View> {
    let count = data.transmits.len() as isize;
    if count < 4 {
        return None;
    }
    let next = |t: usize| t as isize + by;
    let from: Vec<usize> = read
        .iter()
        .map(|&t| next(t).rem_euclid(count) as usize)
        .collect();
    let other = View::new(data, &from);
    let mut view = view.clone();
    view.waves = other.waves;
    if view.own {
        view.lines = other.lines;
    }
    // The list ends there: a transmit without a wave of its own is left out.
    for (sign, &t) in view.signs.iter_mut().zip(read) {
        if !(0..count).contains(&next(t)) {
            *sign = 0.0;
        }
    }
    Some(view)
}

/// The share of an alternative's waves in the phases between transmits, and whether they surely have it.
///
/// Echoes beside a line turn them, too: by receiving, it is known how far beside. The share of the alternative's phases
/// is 1 for single points, and 2 for tissue, of which the wrong waves select echoes beside the line. Its variance is
/// that of leaving lines out.
pub(crate) fn moved(view: &View, table: &Table, other: &View) -> (f64, bool) {
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
    let is_sure = SHARES.contains(&share) && share * share > SURE * SURE * variance;
    (share, is_sure)
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

/// Two transmits, not neighbours, that have each other's place in the list: both agree better once exchanged.
pub(crate) fn exchanged(base: &Base, view: &View, table: &Table) -> Option<(View, [usize; 2])> {
    let own = table.agreements(view);
    let usual = median(own.iter().copied());
    let mut odd: Vec<usize> = (0..own.len()).filter(|&t| own[t] < ODD * usual).collect();
    odd.sort_by(|&a, &b| own[a].total_cmp(&own[b]));
    odd.truncate(MOST_ODD);
    odd.sort_unstable();
    let near = if view.own { 0 } else { 1 };
    let pairs = odd.iter().flat_map(|&a| odd.iter().map(move |&b| [a, b]));
    let pairs = pairs.filter(|[a, b]| a < b);
    let of_pair = |[a, b]: [usize; 2]| {
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
    // Delays of tissue make neighbours agree with each other's place, too.
    let [a, b] = best.2;
    (best.0 > EXCHANGED[usize::from(view.own)] && b > a + 1).then_some((best.1, best.2))
}

/// Records and a list of transmits that are shifted by one: all echoes then come from the next transmit's line.
///
/// Their phases between neighbouring elements say from where.
pub(crate) fn listed(
    source: (&ChannelData, &[usize]),
    view: &View,
    table: &Table,
) -> Option<(View, Finding)> {
    if !view.own {
        return None;
    }
    [1, -1].into_iter().find_map(|by| {
        let other = shifted(source, view, by)?;
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

/// Transmits of opposite sign, and records that are there twice.
pub(crate) fn check(data: &ChannelData, base: &Base, view: &View, table: &Table) -> Vec<Finding> {
    let mut findings = Vec::new();
    let negative = |t: usize| {
        let (sum, power) = table.transmits[t];
        sum.norm() > 0.2 * power && sum.re < -OPPOSITE * sum.norm()
    };
    let count = view.waves.len();
    if !view.own && count > 2 {
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

/// Whether a record is that of the transmit before, but for noise and for a phase, as of another `t0`.
fn doubled(base: &Base, t: usize) -> bool {
    let (_, elements, samples) = base.z.dim();
    let (mut same, mut total) = (Complex::<f64>::default(), 0.0f64);
    for m in 0..elements {
        for n in 0..samples {
            let [a, b] = [base.z[[t - 1, m, n]], base.z[[t, m, n]]];
            let product = a * b.conj();
            same += Complex::new(f64::from(product.re), f64::from(product.im));
            total += f64::from(a.norm_sqr() + b.norm_sqr()) / 2.0;
        }
    }
    total > 0.0 && same.norm() > 0.999 * total
}
