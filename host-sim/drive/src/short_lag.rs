//! Short-lag coherence of a frame's beams.

use bonebeam::beamform::{CoherenceSums, ShortLagCoherence};
use bonebeam::geometry::Axis;
use ndarray::Array2;
use rayon::prelude::*;

use super::delay::DelayStage;

/// Half the time window of the coherence, m of depth.
const HALF_WINDOW: f64 = 0.4e-3;

/// Short-lag coherence over [`HALF_WINDOW`].
pub fn short_lag(samples: &Axis) -> ShortLagCoherence {
    ShortLagCoherence::over(HALF_WINDOW, samples)
}

/// Short-lag coherence of a frame from the sums of its beams, [beam, sample].
pub fn of_sums(stage: &DelayStage<'_>, sums: &[CoherenceSums]) -> Array2<f32> {
    let (beams, samples) = (stage.rays().len(), stage.samples());
    let coherence = short_lag(&stage.depths());
    let mut map = Array2::zeros((beams, samples));
    let rows = map.as_slice_mut().unwrap_or_default();
    let rows = rows.par_chunks_mut(samples.max(1));
    rows.zip(sums.par_chunks(samples.max(1)))
        .for_each(|(row, sums)| coherence.of_sums(sums, row));
    of_lines(stage, &map)
}

/// Each beam's row of a map for each of its lines.
pub fn of_lines(stage: &DelayStage<'_>, map: &Array2<f32>) -> Array2<f32> {
    let (beams, samples) = map.dim();
    let each = stage.all_rays().len() / beams.max(1);
    let beam_of = |line: usize| line / each.max(1);
    Array2::from_shape_fn((each * beams, samples), |(line, n)| map[[beam_of(line), n]])
}
