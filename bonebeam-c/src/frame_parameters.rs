//! The parameters of a frame.

use crate::beamformer::BeamformParameters;
use crate::bounds::{LENGTH, RANGE, RATE};
use crate::phase_symmetry::PhaseSymmetryParameters;
use crate::scan::Scan;
use crate::status::Refused;
use bonebeam::beamform::ShortLagCoherence;
use bonebeam::pipeline::Input;
use bonebeam::surface::{Detector, Settings};
use bonebeam::{Parameters, geometry};

/// The parameters of a frame.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct FrameParameters {
    /// Records, lines, aperture and depth gate.
    pub scan: Scan,
    /// The beamformer.
    pub beamformer: BeamformParameters,
    /// The image's size, and the filters of the bone map; `strip` is not used.
    pub image: PhaseSymmetryParameters,
    /// Level of black below the largest envelope, dB.
    pub dynamic_range: f32,
    /// Not 0: the image is filtered by a median of 3 × 3 pixels.
    pub median: i32,
    /// Not 0: the image shows the RMS of sub-lines; else the largest.
    pub pool_by_rms: i32,
    /// Not 0: the filters' gains are in tables, for faster maps of the same bits.
    pub gain_tables: i32,
    /// Least depth of the surface, m.
    ///
    /// 0 for both depths means no surface, and no memory for it.
    pub surface_from: f64,
    /// Greatest depth of the surface, m; may be infinite.
    pub surface_to: f64,
    /// Half the time window of the surface's coherence, m; 0: no coherence.
    ///
    /// The detector's settings are for 0.4e-3. It costs one byte of memory per sample of all lines, and time per line.
    pub surface_coherence: f64,
}

impl FrameParameters {
    /// The core's parameters.
    ///
    /// # Safety
    /// As [`BeamformParameters::core`] and [`PhaseSymmetryParameters::core`].
    pub(crate) unsafe fn core(&self, input: Input) -> Result<Parameters<'static>, Refused> {
        // SAFETY: by the caller's promise.
        let (beamformer, image) = unsafe { (self.beamformer.core()?, self.image.core()?) };
        let scan = match input {
            Input::Rf => {
                let frequency = self.scan.delay.frequency;
                RATE.check("frequency", frequency)?;
                self.scan.core(frequency)?
            }
            Input::Iq => self.scan.core_of_iq()?,
        };
        LENGTH.check("surface_from", self.surface_from)?;
        if self.surface_to != f64::INFINITY {
            LENGTH.check("surface_to", self.surface_to)?;
        }
        LENGTH.check("surface_coherence", self.surface_coherence)?;
        RANGE.check("dynamic_range", self.dynamic_range.into())?;
        self.scan.check(geometry::Scan::of_iq(scan)?.samples())?;
        Ok(Parameters {
            scan,
            beamformer,
            rows: self.image.rows,
            columns: self.image.columns,
            dynamic_range: self.dynamic_range,
            median: self.median != 0,
            scales: image.scales,
            threshold: image.threshold,
            // By vectors the highest strip takes the fewest instructions; one lane has no strips.
            strip: usize::MAX,
            block: self.scan.block,
        })
    }

    /// The detector, if there is a surface.
    pub(crate) fn detector(&self, core: &Parameters<'_>) -> Result<Option<Detector>, Refused> {
        let depths = [self.surface_from, self.surface_to];
        if depths == [0.0; 2] {
            return Ok(None);
        }
        let settings = match self.coherence(core)? {
            None => Settings::DEFAULT,
            Some(_) => Settings::COHERENCE,
        };
        let settings = Settings { depths, ..settings };
        Ok(Some(Detector::new(core.surface(settings)?)?))
    }

    /// The coherence with which the surface is found, if there are both.
    pub(crate) fn coherence(
        &self,
        core: &Parameters<'_>,
    ) -> Result<Option<ShortLagCoherence>, Refused> {
        let half_window = self.surface_coherence;
        if [self.surface_from, self.surface_to] == [0.0; 2] || half_window == 0.0 {
            return Ok(None);
        }
        if half_window < 0.0 {
            let expected = "at least 0";
            return Err(Refused::field("surface_coherence", half_window, expected));
        }
        let samples = geometry::Scan::of_iq(core.scan)?.depths();
        Ok(Some(ShortLagCoherence::over(half_window, &samples)))
    }
}
