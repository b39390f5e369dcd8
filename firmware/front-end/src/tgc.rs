//! Gain over depth, by the voltage of the attenuator.

/// A converter whose voltage sets the attenuator between the amplifiers.
///
/// That voltage is VCNTL of TI's front ends. From each transmit on, the converter outputs its codes, one a step of
/// [`GainCurve::step`], and holds the last one.
#[allow(async_fn_in_trait)]
pub trait Vcat {
    /// Reason why a call failed.
    type Error;
    /// The largest code.
    const MAX_CODE: u16;
    /// Voltage of the largest code, V.
    fn full_scale(&self) -> f64;

    /// Loads the codes of the transmits that follow.
    ///
    /// # Errors
    /// The implementation's own: at least for more codes than it holds.
    async fn load(&mut self, codes: &[u16]) -> Result<(), Self::Error>;
}

/// Range of an attenuator.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct VcatRange {
    /// Maximum attenuation, at the highest voltage, dB.
    pub decibels: f64,
    /// The highest voltage, V. At 0 V there is no attenuation.
    pub volts: f64,
}

impl VcatRange {
    /// Range of TI's front ends: 40 dB over 1.5 V.
    ///
    /// The voltage is not verified.
    pub const TI: VcatRange = VcatRange {
        decibels: 40.0,
        volts: 1.5,
    };
}

/// A gain that grows with depth to compensate absorption in tissue.
///
/// The gain is that of the attenuator: 0 dB at most.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GainCurve {
    /// Gain at the transmit, dB: −40 to 0.
    pub start: f64,
    /// Growth of the gain, dB/s.
    ///
    /// Tissue of 0.7 dB/(cm·MHz) at 5 MHz and 1540 m/s needs `0.7·5·154000` = 5.4·10⁵.
    pub slope: f64,
    /// Time from one code to the next, s.
    pub step: f64,
}

impl GainCurve {
    /// Gain at `time` s after the transmit, dB, within `range`.
    pub fn gain(&self, time: f64, range: VcatRange) -> f64 {
        let gain = self.start + self.slope * time;
        if gain > 0.0 {
            0.0
        } else if gain > -range.decibels {
            gain
        } else {
            -range.decibels
        }
    }

    /// Fills `codes` with the codes of `dac` for this curve, one a step.
    pub fn codes<D: Vcat>(&self, dac: &D, range: VcatRange, codes: &mut [u16]) {
        for (index, code) in codes.iter_mut().enumerate() {
            let attenuation = -self.gain(index as f64 * self.step, range);
            let volts = attenuation / range.decibels * range.volts;
            let exact = libm::round(volts / dac.full_scale() * f64::from(D::MAX_CODE));
            // The attenuation is within the range; a converter of a lower voltage ends at its largest code.
            *code = if exact < f64::from(D::MAX_CODE) {
                exact as u16
            } else {
                D::MAX_CODE
            };
        }
    }
}
