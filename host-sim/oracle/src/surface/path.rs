//! The path of at most one sample per line with the best sum of scores less prices.

use ndarray::ArrayView2;

/// Prices of a path, in the unit of the scores.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prices {
    /// The score of a line without a surface.
    pub absence: f64,
    /// Price of each start and of each end within the frame.
    pub end: f64,
    /// Price of a jump to any other depth.
    pub jump: f64,
    /// Price of a change in depth, per m.
    pub slope: f64,
    /// Largest change in depth that is free, m.
    pub reach: f64,
}

impl Prices {
    /// Prices of the reference detector.
    pub const YARDSTICK: Prices = Prices {
        absence: -3.0,
        end: 3.0,
        jump: 6.0,
        slope: 0.25 / 0.15e-3,
        reach: 0.9e-3,
    };
}

/// The best path (Viterbi): a sample or `None` for each line.
///
/// `scores` is `[line, sample]`, with samples `step` m apart. Surfaces that reach the first or the last line have no start
/// or end there.
pub fn path(scores: ArrayView2<f64>, step: f64, prices: &Prices) -> Vec<Option<usize>> {
    let (lines, samples) = scores.dim();
    if lines == 0 || samples == 0 {
        return vec![None; lines];
    }
    let reach = (prices.reach / step + 1e-9).min(samples as f64) as usize;
    let mut values = scores.row(0).to_vec();
    let mut absent = prices.absence;
    let mut origins: Vec<(Vec<Option<usize>>, Option<usize>)> = Vec::new();
    for line in scores.rows().into_iter().skip(1) {
        let best = largest(&values);
        let (jumped, started) = (values[best] - prices.jump, absent - prices.end);
        let other = match started > jumped {
            true => (started, None),
            false => (jumped, Some(best)),
        };
        let mut from = Vec::with_capacity(samples);
        let next = line.iter().enumerate().map(|(n, score)| {
            let mut found = other;
            for m in n.saturating_sub(reach)..=(n + reach).min(samples - 1) {
                let moved = values[m] - prices.slope * step * n.abs_diff(m) as f64;
                if moved > found.0 {
                    found = (moved, Some(m));
                }
            }
            from.push(found.1);
            score + found.0
        });
        let next: Vec<f64> = next.collect();
        let ended = values[best] - prices.end;
        origins.push((from, (ended > absent).then_some(best)));
        absent = absent.max(ended) + prices.absence;
        values = next;
    }
    let best = largest(&values);
    let mut at = (values[best] > absent).then_some(best);
    let mut found = vec![at];
    for (from, from_absence) in origins.iter().rev() {
        at = at.map_or(*from_absence, |n| from[n]);
        found.push(at);
    }
    found.reverse();
    found
}

/// The index of the largest value, the first of several.
fn largest(values: &[f64]) -> usize {
    let mut best = 0;
    for (n, value) in values.iter().enumerate() {
        if *value > values[best] {
            best = n;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    const PRICES: Prices = Prices {
        absence: -1.0,
        end: 2.0,
        jump: 4.0,
        slope: 1.0,
        reach: 2.0,
    };

    /// The sum of a path's scores less its prices, by the definition.
    fn value(scores: &Array2<f64>, path: &[Option<usize>]) -> f64 {
        let own = |(line, at): (usize, &Option<usize>)| match at {
            Some(n) => scores[[line, *n]],
            None => PRICES.absence,
        };
        let price = |pair: &[Option<usize>]| match (pair[0], pair[1]) {
            (None, None) => 0.0,
            (Some(a), Some(b)) => {
                let far = a.abs_diff(b) as f64;
                let moved = PRICES.slope * far;
                if far <= PRICES.reach {
                    moved.min(PRICES.jump)
                } else {
                    PRICES.jump
                }
            }
            _ => PRICES.end,
        };
        let prices: f64 = path.windows(2).map(price).sum();
        path.iter().enumerate().map(own).sum::<f64>() - prices
    }

    #[test]
    fn no_path_is_better_than_the_one_that_is_found() {
        use rand::rngs::ChaCha8Rng;
        use rand::{RngExt, SeedableRng};
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let (lines, samples) = (5, 4);
        for _ in 0..60 {
            let score = |_| 6.0 * random.random::<f64>() - 4.0;
            let scores = Array2::from_shape_simple_fn((lines, samples), {
                let mut score = score;
                move || score(())
            });
            let found = value(&scores, &path(scores.view(), 1.0, &PRICES));
            // All paths: none or any sample for each line.
            let choices = samples + 1;
            let best = (0..choices.pow(lines as u32))
                .map(|mut code| {
                    let all: Vec<Option<usize>> = (0..lines)
                        .map(|_| {
                            let at = code % choices;
                            code /= choices;
                            at.checked_sub(1)
                        })
                        .collect();
                    value(&scores, &all)
                })
                .fold(f64::NEG_INFINITY, f64::max);
            assert!((found - best).abs() < 1e-9, "{found} beside {best}");
        }
    }
}
