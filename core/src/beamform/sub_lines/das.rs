//! Sub-lines by delay and sum.

use super::steer::{Powers, number};
use crate::beamform::apodization::Window;
use crate::beamform::parameters::Beamformer;
use crate::beamform::postfilter::{Applied, Elements, Postfilter, factor};
use crate::beamform::pushes::SampleIndex;
use crate::beamform::segment::Segment;
use crate::geometry::Steering;
use crate::simd::ComplexVector;
use num_complex::Complex;

impl Beamformer {
    /// The sub-lines of a segment by DAS.
    ///
    /// Order: the samples from the middle outwards, of two at the same distance the right one first, added from zero,
    /// at the line's working scale, times their weights if they are apodized; divided by the sum of the weights, then
    /// turned by `e^{−jφ_c}`.
    pub(super) fn das_sub_lines(
        &self,
        segment: &Segment<'_>,
        steering: Steering<'_>,
        count: usize,
        z: &mut [Complex<f32>],
    ) {
        let parameters = self.parameters();
        let window = parameters.window();
        let line = &segment.line;
        let step = parameters.step();
        let snapshots = segment.snapshots(step);
        z.fill(Complex::new(0.0, 0.0));
        let of_samples = z.chunks_exact_mut(parameters.sub_lines.max(1));
        for (i, (z, snapshot)) in of_samples.zip(snapshots).enumerate() {
            let active = snapshot.get(segment.first_element..);
            let active = active.and_then(|active| active.get(..count));
            let Some(active) = active.filter(|active| !active.is_empty()) else {
                return;
            };
            let sample = SampleIndex::output(i, step).sample(segment).unwrap_or(0);
            for (k, z) in z.iter_mut().enumerate() {
                let [half, phase] = steering.direction(sample, k);
                let steered = Steered {
                    active,
                    scale: line.scale(),
                    half,
                };
                let mean = match &window {
                    None => steered.sum() / count as f32,
                    Some(window) => steered.weighted(window) / window.total(count),
                };
                *z =
                    line.unscale(mean * (phase * steered.factor(parameters.postfilter_of_lines())));
            }
        }
    }
}

/// The active elements of a sample, and `e^{js/2}` of a direction.
struct Steered<'a> {
    active: &'a [Complex<f32>],
    scale: f32,
    half: Complex<f32>,
}

impl Steered<'_> {
    /// The postfilter's factor.
    fn factor(&self, postfilter: Applied) -> f32 {
        match postfilter.postfilter {
            Postfilter::None => 1.0,
            _ => factor(postfilter, (number(self.sum()), self.power()), self),
        }
    }

    fn sum(&self) -> Complex<f32> {
        let mut sum = Complex::new(0.0, 0.0);
        self.each(|_, y| sum += y.lane(0));
        sum
    }

    fn weighted(&self, window: &Window) -> Complex<f32> {
        let mut sum = Complex::new(0.0, 0.0);
        self.each(|m, y| sum += y.lane(0) * window.weight(m, self.active.len()));
        sum
    }

    /// `Σ|x_m|²`, ascending from zero.
    fn power(&self) -> f32 {
        let mut power = 0.0;
        for &x in self.active {
            power += (x * self.scale).norm_sqr();
        }
        power
    }
}

impl Elements<f32> for Steered<'_> {
    fn count(&self) -> usize {
        self.active.len()
    }

    /// With its phase, `e^{−js(m−centre)}·x_m` at the scale, from the middle outwards.
    #[inline(always)]
    fn each(&self, mut take: impl FnMut(usize, ComplexVector<f32>)) {
        let mut take = |m, y| take(m, number(y));
        let &Steered {
            active,
            scale,
            half,
        } = self;
        let mut powers = Powers::new(number(half), active.len());
        let middle = active.len() / 2;
        let (left, right) = active.split_at(middle);
        let mut right = right.iter().enumerate();
        if active.len() % 2 == 1
            && let Some((_, &x)) = right.next()
        {
            take(middle, x * scale);
            powers.next();
        }
        for ((to_right, &right), (to_left, &left)) in right.zip(left.iter().enumerate().rev()) {
            let power = powers.next().lane(0);
            take(middle + to_right, right * scale * power.conj());
            take(to_left, left * scale * power);
        }
    }
}
