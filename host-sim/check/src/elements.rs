//! Single elements, from correlations with their neighbours.
//!
//! Neighbours m and n of aligned echoes correlate by a_m·a_n·S, with S the median of pairs at their distance nearby.
//! The amplitude a is 1 for an element like its neighbours, 0 for a dead one, −1 for an inverted one.

use std::f64::consts::TAU;

use num_complex::Complex;

use crate::base::Base;
use crate::finding::{Finding, Severity};
use crate::samples::listed;
use crate::table::{LAGS, Table, View};

/// Elements to either side that an element is compared with.
const NEAR: usize = 6;
/// Amplitude below which an element is dead, below which it is weak.
const DEAD: f64 = 0.12;
const WEAK: f64 = 0.5;
/// Power over that of the neighbours above which an element is noisy.
const NOISY: f64 = 2.5;
/// Elements to either side whose pairs give the phase of a pair.
const CLOSE: usize = 3;
/// Independent samples of a block.
const INDEPENDENT: f64 = 5.0;
/// Standard deviation of an amplitude above which an element is not judged.
const UNSURE: f64 = 0.12;
/// Largest number of exchanged neighbours.
const MOST_SWAPPED: usize = 2;
/// Rounds of the amplitudes' iteration.
const ROUNDS: usize = 8;
/// Coherence below which elements cannot be judged.
const LEAST: f64 = 0.1;

/// What is known of each element.
pub(crate) struct Elements {
    /// Amplitude relative to the neighbours, with its sign.
    pub amplitude: Vec<f64>,
    /// Its standard deviation.
    deviation: Vec<f64>,
    /// Power relative to the neighbours.
    pub power: Vec<f64>,
    /// Elements whose echoes are as expected.
    pub good: Vec<bool>,
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

fn near(count: usize, m: usize) -> impl Iterator<Item = usize> {
    (m.saturating_sub(NEAR)..(m + NEAR + 1).min(count)).filter(move |&n| n != m)
}

/// Correlation of two elements over all blocks.
struct Pair {
    /// The part along the phase of the pairs nearby.
    sum: f64,
    /// Median size of pairs nearby.
    usual: f64,
    /// Variance of `sum` without echoes.
    noise: f64,
}

fn pairs(table: &Table, k: usize, count: usize) -> Vec<Pair> {
    let lag = LAGS[k];
    let mut sums = vec![(Complex::<f64>::default(), 0.0); count];
    for block in table.blocks.iter().filter(|block| block.total() > 0.0) {
        let by = block.total().sqrt();
        for m in 0..count - lag.min(count) {
            let v = block.lags[k][m];
            if v != Complex::default() {
                sums[m].0 += Complex::new(f64::from(v.re), f64::from(v.im)) / by;
                let powers = f64::from(block.power[m]) * f64::from(block.power[m + lag]);
                sums[m].1 += powers / INDEPENDENT / (by * by);
            }
        }
    }
    (0..count)
        .map(|m| {
            let within = near(count, m).filter(|&n| n + lag < count);
            let (value, noise) = sums[m];
            let close = (m.saturating_sub(CLOSE)..(m + CLOSE + 1).min(count))
                .filter(|&n| n.abs_diff(m) > 0);
            let phase: Complex<f64> = close.map(|n| sums[n].0).sum();
            let phase = phase / phase.norm().max(f64::MIN_POSITIVE);
            Pair {
                sum: (value * phase.conj()).re,
                usual: median(within.map(|n| sums[n].0.norm())),
                noise,
            }
        })
        .collect()
}

impl Elements {
    pub fn new(base: &Base, view: &View, table: &Table) -> Self {
        let count = view.elements.len();
        let raw: Vec<f64> = (0..count)
            .map(|m| {
                let rows = base.z.index_axis(ndarray::Axis(1), view.order[m]);
                rows.iter().map(|z| f64::from(z.norm_sqr())).sum()
            })
            .collect();
        let power: Vec<f64> = (0..count)
            .map(|m| raw[m] / median(near(count, m).map(|n| raw[n])).max(f64::MIN_POSITIVE))
            .collect();
        let pairs: Vec<Vec<Pair>> = (0..2).map(|k| pairs(table, k, count)).collect();
        let mut amplitude = vec![1.0; count];
        let mut deviation = vec![f64::INFINITY; count];
        for _ in 0..ROUNDS {
            let of = |m: usize| {
                let (mut sum, mut norm, mut noise) = (0.0, 0.0, 0.0);
                for k in 0..2 {
                    let lag = LAGS[k];
                    let neighbours = [
                        (m.checked_sub(lag), m.checked_sub(lag)),
                        (Some(m + lag), Some(m)),
                    ];
                    for (other, pair) in neighbours {
                        if let (Some(other), Some(pair)) = (other, pair)
                            && other < count
                        {
                            let (a, pair): (f64, _) = (amplitude[other], &pairs[k][pair]);
                            sum += a * pair.sum;
                            norm += a * a * pair.usual;
                            noise += a * a * pair.noise;
                        }
                    }
                }
                match norm > 0.0 {
                    true => [(sum / norm).clamp(-2.0, 2.0), noise.sqrt() / norm],
                    false => [1.0, f64::INFINITY],
                }
            };
            let all: Vec<[f64; 2]> = (0..count).map(of).collect();
            amplitude = all.iter().map(|&[a, _]| a).collect();
            deviation = all.iter().map(|&[_, deviation]| deviation).collect();
        }
        let good = (0..count)
            .map(|m| {
                (amplitude[m] > WEAK || deviation[m] > UNSURE) && (1e-3..NOISY).contains(&power[m])
            })
            .collect();
        Elements {
            amplitude,
            deviation,
            power,
            good,
        }
    }

    /// The amplitude of an element that can be judged, with neighbours on both sides.
    fn judged(&self, m: usize) -> Option<f64> {
        let within = m >= NEAR && m + NEAR < self.amplitude.len();
        (within && self.deviation[m] < UNSURE).then_some(self.amplitude[m])
    }

    /// Elements that are dead, weak, inverted, noisy or in another's place.
    pub fn check(&self, base: &Base, view: &View, table: &Table) -> Vec<Finding> {
        let count = self.amplitude.len();
        let mut findings = Vec::new();
        let silent: Vec<usize> = (0..count).filter(|&m| self.power[m] < 1e-3).collect();
        let warning = |name, which: &[usize], text: &str, remedy: &str| {
            let finding =
                Finding::new(name, Severity::Warning, format!("{} {text}", listed(which)));
            finding
                .valued(which.len() as f64, "elements")
                .remedy(remedy)
        };
        if table.coherence() < LEAST {
            if !silent.is_empty() {
                findings.push(warning(
                    "dead",
                    &silent,
                    "recorded no echoes",
                    "leave them out of the aperture",
                ));
            }
            return findings;
        }
        let swapped = self.swapped(base, view, table);
        let mut kinds: [Vec<usize>; 4] = Default::default();
        for m in (0..count).filter(|m| !swapped.iter().flatten().any(|n| n == m)) {
            let p = self.power[m];
            let kind = match self.judged(m) {
                Some(a) if a < -WEAK => 2,
                _ if p > NOISY => 3,
                _ if p < 1e-3 => 0,
                Some(a) if a.abs() < DEAD && p < 1.0 => 0,
                Some(a) if a.abs() < WEAK && p < 0.9 => 1,
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
    fn swapped(&self, base: &Base, view: &View, table: &Table) -> Vec<[usize; 2]> {
        let count = self.amplitude.len();
        let neighbours = swapped_neighbours(view, table).into_iter();
        let mut pairs: Vec<[usize; 2]> = neighbours.map(|m| [m, m + 1]).collect();
        let mut odd: Vec<usize> = (0..count)
            .filter(|&m| {
                self.judged(m).is_some_and(|a| a.abs() < 0.6)
                    && (0.25..NOISY).contains(&self.power[m])
            })
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
                let exchanged = Elements::new(base, &other, &Table::new(base, &other));
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
/// They were aligned by each other's delays: the phase between them is then twice their difference, the other way.
fn swapped_neighbours(view: &View, table: &Table) -> Vec<usize> {
    let count = view.elements.len();
    let mut sums = vec![[0.0; 2]; count - 1];
    for block in table.blocks.iter().filter(|block| block.total() > 0.0) {
        let line = &view.lines[block.line];
        let delays: Vec<f64> = (0..count)
            .map(|m| view.receive(line, block.time, m, view.c))
            .collect();
        for (m, sum) in sums.iter_mut().enumerate() {
            let cycles = table.frequency * (delays[m + 1] - delays[m]);
            // Where the two differ.
            if cycles.abs() >= 0.05 {
                let value = block.lags[0][m];
                let value =
                    Complex::new(f64::from(value.re), f64::from(value.im)) / block.total().sqrt();
                let other = value * Complex::from_polar(1.0, -2.0 * TAU * cycles);
                *sum = [sum[0] + value.re, sum[1] + other.re];
            }
        }
    }
    let usual = |m: usize| median(near(count - 1, m).map(|n| sums[n][0]));
    let swapped = |m: &usize| {
        sums[*m][1] > 0.5 * usual(*m) && sums[*m][0] < 0.25 * usual(*m) && usual(*m) > 0.0
    };
    let found: Vec<usize> = (0..count - 1).filter(swapped).collect();
    // Many are no exchange of cables.
    if found.len() > MOST_SWAPPED {
        Vec::new()
    } else {
        found
    }
}
