//! Coherence of aligned lines: the share of the largest eigenvalue, and short-lag coherence.

use bonebeam::beamform::Sizes;
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
