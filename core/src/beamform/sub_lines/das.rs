//! Sub-lines by delay and sum.

use super::steer::{Powers, number};
use crate::beamform::apodization::Window;
use crate::beamform::parameters::Beamformer;
use crate::beamform::postfilter::{Postfilter, coherence_of, share_of_spectrum};
use crate::beamform::segment::Segment;
use crate::geometry::Steering;
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
        let samples = line.samples_from(segment.first_sample);
        let snapshots = samples.chunks_exact(line.elements());
        z.fill(Complex::new(0.0, 0.0));
        let of_samples = z.chunks_exact_mut(parameters.sub_lines.max(1));
        for (i, (z, snapshot)) in of_samples.zip(snapshots).enumerate() {
            let active = snapshot.get(segment.first_element..);
            let active = active.and_then(|active| active.get(..count));
            let Some(active) = active.filter(|active| !active.is_empty()) else {
                return;
            };
            for (k, z) in z.iter_mut().enumerate() {
                let [half, phase] = steering.direction(segment.first_sample + i, k);
                let steered = Steered {
                    active,
                    scale: line.scale(),
                    half,
                };
                let mean = match &window {
                    None => steered.sum() / count as f32,
                    Some(window) => steered.weighted(window) / window.total(count),
                };
                *z = line.unscale(mean * (phase * self.factor(&steered)));
            }
        }
    }

    /// The postfilter's factor.
    fn factor(&self, steered: &Steered<'_>) -> f32 {
        let (postfilter, cutoff) = self.parameters().postfilter_of_lines();
        let count = steered.active.len();
        match postfilter {
            Postfilter::None => 1.0,
            Postfilter::CoherenceFactor => {
                coherence_of(number(steered.sum()), steered.power(), count)
            }
            Postfilter::GeneralizedCoherenceFactor => {
                let sums = (number(steered.sum()), steered.power());
                share_of_spectrum(sums, (count, cutoff), |frequency| {
                    steered.each(|m, y| frequency.add(m, number(y)));
                })
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
    /// Hands each element `m` with its phase, `e^{−js(m−centre)}·x_m` at the scale, to `take`, from the middle outwards.
    #[inline(always)]
    fn each(&self, mut take: impl FnMut(usize, Complex<f32>)) {
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

    fn sum(&self) -> Complex<f32> {
        let mut sum = Complex::new(0.0, 0.0);
        self.each(|_, y| sum += y);
        sum
    }

    fn weighted(&self, window: &Window) -> Complex<f32> {
        let mut sum = Complex::new(0.0, 0.0);
        self.each(|m, y| sum += y * window.weight(m, self.active.len()));
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
