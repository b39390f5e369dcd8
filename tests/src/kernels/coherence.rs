//! Coherence of aligned lines: the share of the largest eigenvalue, short-lag coherence, and that of trial speeds.

use bonebeam::beamform::{Sizes, SpeedTrials};
use bonebeam::prelude::stages::*;

use super::beamform::Lines;
use crate::draw::Draw;
use crate::kernel::Kernel;

/// Shares of the largest eigenvalue in lines' covariances, or short-lag coherence.
#[derive(Clone, Debug)]
pub struct Coherence<const SHARES: bool>(pub Lines);

/// Shares of the largest eigenvalue.
pub type Shares = Coherence<true>;
/// Short-lag coherence.
pub type ShortLag = Coherence<false>;

impl<const SHARES: bool> Coherence<SHARES> {
    fn sizes(&self) -> Result<Sizes, Error> {
        let most = self.0.counts.iter().copied().max();
        Ok(Beamformer::new(self.0.parameters)?.eigenvalue_sizes(most.unwrap_or(0)))
    }

    fn short_lag(&self) -> ShortLagCoherence {
        ShortLagCoherence {
            temporal_half_window: self.0.parameters.temporal_half_window,
        }
    }
}

impl<const SHARES: bool> Kernel for Coherence<SHARES> {
    type Number = f32;

    fn draw(draw: &mut impl Draw) -> Result<Self, Error> {
        let mut lines = Lines::draw(draw)?;
        lines.parameters.sub_lines = 1;
        if !SHARES {
            lines.parameters.depth_step = 1;
        }
        Ok(Coherence(lines))
    }

    fn need(&self, _: usize, _: usize) -> [Need; 2] {
        match SHARES {
            true => [Need::default(), self.sizes().unwrap_or_default().need()],
            false => [self.short_lag().need(), Need::default()],
        }
    }

    fn numbers(&self) -> usize {
        self.0.numbers()
    }

    fn is_one_call(&self, _: usize) -> bool {
        self.0.lines.len() == 1
    }

    fn run<V: Vector>(
        &self,
        zero: V,
        _: usize,
        (mut memory, vectors): (Scratch<'_>, Scratch<'_, V>),
        out: &mut [f32],
    ) -> Result<(), Error> {
        let beamformer = Beamformer::new(self.0.parameters)?;
        let sizes = if SHARES {
            self.sizes()?
        } else {
            Sizes::default()
        };
        let mut workspace = Workspace::new(zero, sizes, vectors)?;
        for (line, out) in self.0.cut(out).into_iter().enumerate() {
            let (x, active) = (self.0.aligned(line)?, |n| self.0.active(line, n));
            match SHARES {
                true => beamformer.eigenvalue_shares(&mut workspace, x, active, out)?,
                false => (self.short_lag()).line(x, active, memory.reborrow(), out)?,
            }
        }
        Ok(())
    }
}

/// Squared coherence factors of lines, added up.
#[derive(Clone, Debug)]
pub struct Speeds(pub Lines);

impl Speeds {
    /// Samples of a block.
    pub fn block(&self) -> usize {
        1 + self.0.parameters.temporal_half_window
    }
}

impl Kernel for Speeds {
    type Number = f32;

    fn draw(draw: &mut impl Draw) -> Result<Self, Error> {
        let mut lines = Lines::draw(draw)?;
        (lines.parameters.sub_lines, lines.parameters.depth_step) = (1, 1);
        Ok(Speeds(lines))
    }

    fn need(&self, _: usize, _: usize) -> [Need; 2] {
        [Need::default(); 2]
    }

    fn numbers(&self) -> usize {
        self.0.lines.len()
    }

    fn run<V: Vector>(
        &self,
        _: V,
        _: usize,
        _: (Scratch<'_>, Scratch<'_, V>),
        out: &mut [f32],
    ) -> Result<(), Error> {
        for (line, out) in out.iter_mut().enumerate() {
            let mut trials = SpeedTrials::<3>::new(1500.0, 40.0)?;
            let active = |n| self.0.active(line, n);
            trials.add(line, 1, self.0.aligned(line)?, active, self.block())?;
            *out = trials.coherence(1) as f32;
        }
        Ok(())
    }
}
