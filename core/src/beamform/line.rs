//! One beam, depth by depth, with an aperture that grows.

use super::aligned_line::AlignedLine;
use super::parameters::Beamformer;
use super::run::{Run, constant_runs};
use super::view::WorkspaceView;
use crate::Error;
use crate::covariance::Averaging;
use crate::error::check_length;
use crate::geometry::Active;
use num_complex::Complex;

impl Beamformer {
    /// Beamforms one beam: `z[n]` from the samples of `line`, with the active set `active(n)`.
    ///
    /// One active set serves the whole time window of a sample. Samples without an active element
    /// are 0. See [`Beamformer::runs`] for scale and cost. `active` is asked twice for each sample:
    /// the whole line is checked before anything is put out.
    ///
    /// # Errors
    /// As [`Beamformer::runs`]; [`Error::Length`] where `z` is not as long as the line.
    #[inline]
    pub fn line<A: Averaging<f32>>(
        &self,
        workspace: &mut WorkspaceView<'_, A>,
        line: AlignedLine<'_>,
        active: impl Fn(usize) -> Active,
        z: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        check_length("z", z.len(), line.samples())?;
        let sizes = workspace.sizes;
        let run = |first_sample, set: Active| Run {
            line,
            first_element: set.first,
            first_sample,
        };
        for (first_sample, samples, set) in constant_runs(line.samples(), &active) {
            self.check_run(&run(first_sample, set), set.count, samples)?;
            if set.count > 0 && self.parameters().method.direct().is_none() {
                self.check_sizes(set.count, sizes)?;
            }
        }
        for (first_sample, samples, set) in constant_runs(line.samples(), &active) {
            let run = run(first_sample, set);
            let out = z.get_mut(first_sample..first_sample + samples);
            let out = out.unwrap_or_default();
            self.runs_within(workspace, sizes, &[run], set.count, &mut [out])?;
        }
        Ok(())
    }
}
