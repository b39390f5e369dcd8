//! The search: tree-structured Parzen estimators, by the crate `tpe`.
//!
//! They are described by Bergstra et al., Algorithms for hyper-parameter optimization, 2011. They handle integers as
//! well as real numbers. The interface asks for values and is told their score, so that stored evaluations can replace
//! new ones.

use crate::experiments::study::*;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use tpe::TpeOptimizer;

use super::variables::Variable;

/// Number of detectors tried on the lines of one beamformer.
///
/// Lines take a long time, detectors a short one.
pub const DETECTORS: usize = 8;

/// Evaluated values and their score.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Evaluation {
    /// Values of the variables.
    pub values: Vec<f64>,
    /// Score, which is maximised.
    pub score: f64,
}

/// Runs a number of evaluations, the first at `start`.
///
/// The first evaluation of each beamformer is with the best detector so far.
///
/// # Errors
/// The errors of `score`, and a score that is NaN.
pub fn search(
    variables: &[Variable],
    start: &[f64],
    evaluations: usize,
    seed: u64,
    mut score: impl FnMut(&[f64]) -> Result<f64>,
) -> Result<Vec<Evaluation>> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut optimisers: Vec<TpeOptimizer> =
        variables.iter().map(optimiser).collect::<Result<_>>()?;
    let beamformers = variables.iter().any(Variable::needs_new_lines);
    let mut all: Vec<Evaluation> = Vec::new();
    let mut values = start.to_vec();
    for n in 0..evaluations {
        let next = beamformers && n % DETECTORS == 0;
        if let Some(leader) = best(&all).cloned() {
            let last = all.len().saturating_sub(DETECTORS);
            let of_lines = all.get(last..).and_then(best).map(|e| e.score);
            let each = variables.iter().zip(&mut optimisers).enumerate();
            for (k, (variable, optimiser)) in each {
                if variable.needs_new_lines() && !next {
                    continue;
                }
                if variable.needs_new_lines() {
                    tell(
                        optimiser,
                        variable,
                        values[k],
                        of_lines.unwrap_or(leader.score),
                    )?;
                }
                values[k] = match next && !variable.needs_new_lines() {
                    true => leader.values[k],
                    false => {
                        let Ok(position) = optimiser.ask(&mut random);
                        variable.value(position)
                    }
                };
            }
        }
        let score = score(&values)?;
        for ((variable, optimiser), value) in variables.iter().zip(&mut optimisers).zip(&values) {
            if !variable.needs_new_lines() {
                tell(optimiser, variable, *value, score)?;
            }
        }
        all.push(Evaluation {
            values: values.clone(),
            score,
        });
    }
    Ok(all)
}

/// The first of the best evaluations; `None` if there is none.
pub fn best(all: &[Evaluation]) -> Option<&Evaluation> {
    all.iter().rev().max_by(|a, b| a.score.total_cmp(&b.score))
}

fn optimiser(variable: &Variable) -> Result<TpeOptimizer> {
    let [low, high] = variable.positions();
    let range = tpe::range(low, high).map_err(refused)?;
    Ok(TpeOptimizer::new(tpe::parzen_estimator(), range))
}

/// Tells the optimiser a score; its sign is changed, since the optimiser minimises.
fn tell(optimiser: &mut TpeOptimizer, variable: &Variable, value: f64, score: f64) -> Result<()> {
    optimiser
        .tell(variable.position(value), -score)
        .map_err(refused)
}

fn refused(error: impl std::fmt::Display) -> Error {
    Error::Data(format!("the optimiser refuses a value: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bonebeam_drive::methods::MethodName;

    /// A paraboloid with a known maximum, over the variables' places.
    fn bowl(variables: &[Variable], values: &[f64]) -> f64 {
        let off = variables.iter().zip(values).map(|(variable, value)| {
            let [low, high] = variable.positions();
            let fraction = (variable.position(*value) - low) / (high - low);
            (fraction - 0.3).powi(2)
        });
        1.0 - off.sum::<f64>()
    }

    #[test]
    fn a_known_maximum_is_found_and_lines_are_kept() {
        let variables = Variable::of_method(MethodName::Esmv);
        let middle = |v: &Variable| {
            let [low, high] = v.positions();
            v.value(0.2 * low + 0.8 * high)
        };
        let start: Vec<f64> = variables.iter().map(middle).collect();
        let run = |seed| {
            let score = |values: &[f64]| Ok(bowl(&variables, values));
            search(&variables, &start, 400, seed, score).unwrap()
        };
        let found = run(7);
        assert_eq!(found, run(7));
        assert_ne!(found, run(8));
        assert_eq!(found[0].values, start);
        // The start is off in each variable; less than a fifth of that deviation is left.
        let left = (1.0 - best(&found).unwrap().score) / (1.0 - found[0].score);
        assert!(left < 0.2, "{left}");
        for (n, pair) in found.windows(2).enumerate() {
            let same = (0..6).all(|k| pair[0].values[k] == pair[1].values[k]);
            assert_eq!(same, (n + 1) % DETECTORS != 0, "{n}");
        }
        assert_eq!(best(&[]), None);
    }
}
