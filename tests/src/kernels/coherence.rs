//! Coherence of aligned lines: the share of the largest eigenvalue, short-lag coherence, and that of trial speeds.

use bonebeam::beamform::{Sizes, SpeedTrials};
use bonebeam::prelude::stages::*;

use super::beamform::Lines;
use crate::draw::Draw;
use crate::kernel::Kernel;

/// Shares of the largest eigenvalue in the covariances of lines.
#[derive(Clone, Debug)]
pub struct Shares(pub Lines);

impl Shares {
    fn sizes(&self) -> Result<Sizes, Error> {
        let most = self.0.counts.iter().copied().max();
        Ok(Beamformer::new(self.0.parameters)?.eigenvalue_sizes(most.unwrap_or(0)))
    }
}

impl Kernel for Shares {
    type Number = f32;

    fn draw(draw: &mut impl Draw) -> Result<Self, Error> {
        let mut lines = Lines::draw(draw)?;
        lines.parameters.sub_lines = 1;
        Ok(Shares(lines))
    }

    fn need(&self, _: usize, _: usize) -> [Need; 2] {
        [
            Need::default(),
            self.sizes().map_or(Need::default(), Sizes::need),
        ]
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
        (_, memory): (Scratch<'_>, Scratch<'_, V>),
        out: &mut [f32],
    ) -> Result<(), Error> {
        let beamformer = Beamformer::new(self.0.parameters)?;
        let mut workspace = Workspace::new(zero, self.sizes()?, memory)?;
        for (line, out) in self.0.cut(out).into_iter().enumerate() {
            let active = |n| self.0.active(line, n);
            beamformer.eigenvalue_shares(&mut workspace, self.0.aligned(line)?, active, out)?;
        }
        Ok(())
    }
}

/// Short-lag coherence of lines.
#[derive(Clone, Debug)]
pub struct ShortLag(pub Lines);

impl ShortLag {
    fn stage(&self) -> ShortLagCoherence {
        ShortLagCoherence {
            temporal_half_window: self.0.parameters.temporal_half_window,
        }
    }
}

impl Kernel for ShortLag {
    type Number = f32;

    fn draw(draw: &mut impl Draw) -> Result<Self, Error> {
        let mut lines = Lines::draw(draw)?;
        (lines.parameters.sub_lines, lines.parameters.depth_step) = (1, 1);
        Ok(ShortLag(lines))
    }

    fn need(&self, _: usize, _: usize) -> [Need; 2] {
        [self.stage().need(), Need::default()]
    }

    fn numbers(&self) -> usize {
        self.0.numbers()
    }

    fn is_one_call(&self, _: usize) -> bool {
        self.0.lines.len() == 1
    }

    fn run<V: Vector>(
        &self,
        _: V,
        _: usize,
        (mut memory, _): (Scratch<'_>, Scratch<'_, V>),
        out: &mut [f32],
    ) -> Result<(), Error> {
        for (line, out) in self.0.cut(out).into_iter().enumerate() {
            let active = |n| self.0.active(line, n);
            self.stage()
                .line(self.0.aligned(line)?, active, memory.reborrow(), out)?;
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
