//! Single elements, from correlations with those nearby.
//!
//! An element that is aligned right agrees with the sum of the elements nearby. Its amplitude is 1 if it does so as its
//! neighbours do, 0 for a dead one, −1 for an inverted one.

use std::f64::consts::TAU;

use num_complex::Complex;

use crate::base::Base;
use crate::finding::{Finding, Severity};
use crate::samples::listed;
use crate::table::{NEAR, Table};
use crate::view::View;

/// Amplitude below which an element is dead, below which it is weak.
const DEAD: f64 = 0.12;
const WEAK: f64 = 0.5;
/// Power over that of the neighbours above which an element is noisy.
const NOISY: f64 = 2.5;
/// Independent samples of a block.
const INDEPENDENT: f64 = 3.0;
/// Standard deviation of an amplitude above which an element is not judged.
const UNSURE: f64 = 0.25;
/// Share of the blocks of its neighbours that an element must be aligned in to be judged.
const REACHED: f64 = 0.6;
/// Elements at each end that are not judged: few lines reach them.
const ENDS: usize = 2 * NEAR;
/// Standard deviations by which an amplitude must be less than 1.
const SURE: f64 = 4.0;
/// Largest number of exchanged neighbours.
const MOST_SWAPPED: usize = 2;

/// What is known of each element.
pub(crate) struct Elements {
    /// Amplitude relative to the neighbours, with its sign.
    pub amplitude: Vec<f64>,
    /// Its standard deviation.
    deviation: Vec<f64>,
    /// Agreement with one neighbour at any phase, which tissue before the two turns, relative to those nearby.
    tied: Vec<f64>,
    /// Power relative to the neighbours.
    pub power: Vec<f64>,
    /// Elements whose echoes are as expected.
    pub good: Vec<bool>,
}

/// The upper median; 0 of none.
pub(crate) fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

fn near(count: usize, m: usize) -> impl Iterator<Item = usize> {
    (m.saturating_sub(NEAR)..(m + NEAR + 1).min(count)).filter(move |&n| n != m)
}

/// A value over those of its neighbours, by the medians of either side; 1 between the two.
fn relative(values: &[f64], m: usize) -> f64 {
    let side = |of: std::ops::Range<usize>| (!of.is_empty()).then(|| median(of.map(|n| values[n])));
    let sides = [
        side(m.saturating_sub(NEAR)..m),
        side(m + 1..(m + 1 + NEAR).min(values.len())),
    ];
    let [mut least, mut most] = [f64::INFINITY, f64::MIN_POSITIVE];
    for side in sides.into_iter().flatten() {
        (least, most) = (least.min(side.max(f64::MIN_POSITIVE)), most.max(side));
    }
    (values[m] / least).min(1.0).max(values[m] / most)
}

impl Elements {
    /// `power` has the variance of each row's samples.
    pub fn new(power: &[f64], view: &View, table: &Table) -> Self {
        let count = view.elements.len();
        let raw: Vec<f64> = view.order.iter().map(|&row| power[row]).collect();
        let power: Vec<f64> = (0..count).map(|m| relative(&raw, m)).collect();
        let mut sums = vec![[0.0; 2]; count];
        let mut next = vec![Complex::<f64>::default(); count];
        // Blocks that an element is aligned in.
        let mut blocks = vec![0.0; count];
        for block in table.blocks.iter().filter(|block| block.total() > 0.0) {
            let total = block.total();
            let turn = Complex::from_polar(1.0 / total, -f64::from(block.next().arg()));
            for (sum, product) in next.iter_mut().zip(&block.lags[0]) {
                *sum += turn * Complex::new(f64::from(product.re), f64::from(product.im));
            }
            for (blocks, own) in blocks.iter_mut().zip(&block.power) {
                *blocks += f64::from(u8::from(*own > 0.0));
            }
            for ((sum, (product, beam)), own) in sums.iter_mut().zip(block.near()).zip(&block.power)
            {
                sum[0] += f64::from(product.re) / total;
                sum[1] += f64::from(beam) * f64::from(*own) / INDEPENDENT / (total * total);
            }
        }
        let next: Vec<f64> = next.iter().map(|sum| sum.norm()).collect();
        let tied = |m: usize| {
            let usual = median(near(count, m).map(|n| next[n])).max(f64::MIN_POSITIVE);
            next[m].max(next[m.saturating_sub(1)]) / usual
        };
        let usual = |m: usize| median(near(count, m).map(|n| sums[n][0]));
        let is_reached = |m: usize| {
            let most = near(count, m).map(|n| blocks[n]).fold(0.0, f64::max);
            blocks[m] > REACHED * most
        };
        let judge = |m: usize| match usual(m) {
            usual if usual > 0.0 && is_reached(m) => [
                (sums[m][0] / usual).clamp(-2.0, 2.0),
                sums[m][1].sqrt() / usual,
            ],
            _ => [1.0, f64::INFINITY],
        };
        let judged: Vec<[f64; 2]> = (0..count).map(judge).collect();
        let mut found = Elements {
            amplitude: judged.iter().map(|own| own[0]).collect(),
            deviation: judged.iter().map(|own| own[1]).collect(),
            tied: (0..count).map(tied).collect(),
            power,
            good: Vec::new(),
        };
        found.good = (0..count)
            .map(|m| !found.is_weak(m) && (1e-3..NOISY).contains(&found.power[m]))
            .collect();
        found
    }

    /// Whether an element surely has less than a part of its neighbours' amplitude.
    fn is_weak(&self, m: usize) -> bool {
        self.judged(m).is_some_and(|a| {
            let is_tied = a > -WEAK && self.tied[m] > WEAK;
            a < WEAK && 1.0 - a > SURE * self.deviation[m] && !is_tied
        })
    }

    /// The amplitude of an element that can be judged, with neighbours on both sides.
    fn judged(&self, m: usize) -> Option<f64> {
        let within = m >= ENDS && m + ENDS < self.amplitude.len();
        (within && self.deviation[m] < UNSURE).then_some(self.amplitude[m])
    }

    /// Elements that are dead, weak, inverted, noisy or in another's place.
    pub fn check(&self, base: &Base, power: &[f64], view: &View, table: &Table) -> Vec<Finding> {
        let count = self.amplitude.len();
        let mut findings = Vec::new();
        let warning = |name, which: &[usize], text: &str, remedy: &str| {
            let finding =
                Finding::new(name, Severity::Warning, format!("{} {text}", listed(which)));
            finding
                .valued(which.len() as f64, "elements")
                .remedy(remedy)
        };
        let swapped = self.swapped(base, power, view, table);
        let mut kinds: [Vec<usize>; 4] = Default::default();
        for m in (0..count).filter(|m| !swapped.iter().flatten().any(|n| n == m)) {
            let p = self.power[m];
            let kind = match self.judged(m) {
                Some(a) if a < -WEAK && -a > SURE / 2.0 * self.deviation[m] => 2,
                _ if p > NOISY => 3,
                // Records may end before the echoes of the last elements.
                _ if p == 0.0 || p < 1e-3 && self.judged(m).is_some() => 0,
                Some(a) if self.is_weak(m) && p < 1.0 => match a.abs() < DEAD {
                    true if self.deviation[m] < DEAD => 0,
                    _ if p < 0.9 => 1,
                    _ => continue,
                },
                _ => continue,
            };
            kinds[kind].push(m);
        }
        let rows = [
            (
                "dead",
                "recorded no echoes",
                "set their rf to 0, or mend the cable",
            ),
            (
                "weak",
                "recorded less than half of their neighbours' amplitude",
                "scale their rf, or mend the cable",
            ),
            (
                "inverted",
                "recorded with the opposite sign",
                "change the sign of their rf",
            ),
            (
                "noisy",
                "recorded more than their neighbours, without more echoes",
                "set their rf to 0",
            ),
        ];
        for ((name, text, remedy), which) in rows.into_iter().zip(&kinds) {
            if !which.is_empty() {
                findings.push(warning(name, which, text, remedy));
            }
        }
        for [a, b] in swapped {
            let text = format!("elements {a} and {b} have each other's echoes");
            let finding = Finding::new("swapped", Severity::Warning, text);
            findings.push(finding.valued(2.0, "elements").remedy("exchange their rf"));
        }
        findings
    }

    /// Pairs of elements that have each other's records.
    fn swapped(&self, base: &Base, power: &[f64], view: &View, table: &Table) -> Vec<[usize; 2]> {
        let count = self.amplitude.len();
        let neighbours = swapped_neighbours(view, table).into_iter();
        let mut pairs: Vec<[usize; 2]> = neighbours.map(|m| [m, m + 1]).collect();
        let mut odd: Vec<usize> = (0..count)
            .filter(|&m| self.is_weak(m) && (0.25..NOISY).contains(&self.power[m]))
            .filter(|m| !pairs.iter().flatten().any(|n| n == m))
            .collect();
        odd.sort_by(|&a, &b| self.amplitude[a].abs().total_cmp(&self.amplitude[b].abs()));
        odd.truncate(4);
        for i in 0..odd.len() {
            for j in i + 1..odd.len() {
                let [a, b] = [odd[i].min(odd[j]), odd[i].max(odd[j])];
                if pairs.iter().flatten().any(|&n| n == a || n == b) {
                    continue;
                }
                let mut other = view.clone();
                other.order.swap(a, b);
                let exchanged = Elements::new(power, &other, &Table::new(base, &other));
                if [a, b].iter().all(|&m| {
                    exchanged.amplitude[m] > 0.6 && exchanged.amplitude[m] > self.amplitude[m] + 0.3
                }) {
                    pairs.push([a, b]);
                }
            }
        }
        pairs
    }
}

/// Neighbours `m` and `m + 1` that have each other's records.
///
/// Each was aligned by the other's delay: it is turned by the phase between the two, in the direction of the echoes.
fn swapped_neighbours(view: &View, table: &Table) -> Vec<usize> {
    let count = view.elements.len();
    // Agreement with the elements nearby when turned back, by how much it is more than as they are, its variance, and
    // the agreement of any element; echoes count more that arrive at the two at different times.
    let mut sums = vec![[0.0; 4]; count.saturating_sub(1)];
    for block in table.blocks.iter().filter(|block| block.total() > 0.0) {
        let (line, near, total) = (&view.lines[block.line], block.near(), block.total());
        let active = block.power.iter().filter(|power| **power > 0.0).count();
        let usual = near.iter().map(|own| f64::from(own.0.re)).sum::<f64>() / active as f64;
        let tilt = f64::from(block.next().arg());
        let delays: Vec<f64> = (0..count)
            .map(|m| view.receive(line, block.time, m, view.c))
            .collect();
        for (m, sum) in sums.iter_mut().enumerate() {
            if block.lags[0][m] == Complex::default() {
                continue;
            }
            let phase = TAU * table.frequency * (delays[m + 1] - delays[m]) - tilt;
            let weight = 1.0 - phase.cos();
            for (n, phase) in [(m, phase), (m + 1, -phase)] {
                let (value, beam) = near[n];
                let value = Complex::new(f64::from(value.re), f64::from(value.im)) / total;
                let turned = (value * Complex::from_polar(1.0, phase)).re;
                let variance = f64::from(beam) * f64::from(block.power[n]) / INDEPENDENT;
                sum[0] += weight * turned;
                sum[1] += turned - value.re;
                sum[2] += weight * variance / (total * total);
                sum[3] += weight * usual / total;
            }
        }
    }
    let swapped = |m: &usize| {
        let [turned, more, variance, usual] = sums[*m];
        usual > 0.0
            && turned > 0.5 * usual
            && more > 0.2 * usual
            && more + usual > 5.0 * variance.sqrt()
    };
    let found: Vec<usize> = (0..count.saturating_sub(1)).filter(swapped).collect();
    // Many are no exchange of cables.
    if found.len() > MOST_SWAPPED {
        Vec::new()
    } else {
        found
    }
}
