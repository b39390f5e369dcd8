//! Parameters of a beamformer.

use super::apodization::{Apodization, Window};
use super::compiled::{APODIZATION, FORWARD, POSTFILTERS, SUB_LINES};
use super::methods::Method;
use super::postfilter::{Applied, Postfilter};
use super::sizes::Sizes;
use super::table::{Parameter, Range, range};
use crate::Error;
use crate::covariance::Covariance;
use crate::error::attempt;
use crate::geometry::DepthStep;

/// The fields of [`Parameters`] that are numbers. A row: the documentation, which is the help text; the field
/// with its type, its default, its unit and an example; its range.
macro_rules! parameters {
    ($(
        $(#[doc = $help:literal])*
        $name:ident: $number:ty = $default:literal $unit:literal (or $example:literal), whole $whole:literal,
        $range:expr;
    )*) => {
        /// Parameters of a [`Beamformer`].
        ///
        /// The default is the core's: MV, `K = 0`, `Δ = 0.05`, `L = M/2`. (The command `host-sim beamform` uses
        /// rank 1 by default.)
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        pub struct Parameters {
            /// The beamforming method.
            pub method: Method,
            /// The covariance of all methods but DAS.
            pub covariance: Covariance,
            /// The postfilter, a factor on the output.
            pub postfilter: Postfilter,
            /// The apodization, weights across the active aperture.
            pub apodization: Apodization,
            /// Sub-lines of a line, within [`Parameters::SUB_LINES`].
            ///
            /// [`Beamformer::sub_lines`] computes them.
            pub sub_lines: usize,
            $($(#[doc = $help])* pub $name: $number,)*
        }

        impl Parameters {
            /// The default as a constant.
            pub const DEFAULT: Self = Parameters {
                method: Method::Mv,
                covariance: Covariance::ForwardBackward,
                postfilter: Postfilter::None,
                apodization: Apodization::None,
                sub_lines: 1,
                $($name: $default,)*
            };

            /// Sub-lines of a line: a power of two.
            pub const SUB_LINES: Parameter = Parameter {
                name: "sub_lines",
                unit: "",
                help: "Directions within the cell of each line, from the line's one covariance: 1, 2, 4, 8, 16 or 32",
                default: 1.0,
                example: 4.0,
                whole: true,
                range: Range {
                    text: "1, 2, 4, 8, 16 or 32",
                    ..range!(1 to 32)
                },
            };

            /// The numeric fields that every beamformer function uses.
            pub const TABLE: [Parameter; [$($default as f64),*].len()] = [$(Parameter {
                name: stringify!($name),
                unit: $unit,
                help: concat!($($help),*),
                default: $default as f64,
                example: $example as f64,
                whole: $whole,
                range: $range,
            }),*];

            /// Values of the fields of [`Parameters::TABLE`].
            pub const fn values(&self) -> [f64; Self::TABLE.len()] {
                [$(self.$name as f64),*]
            }

            /// Sets the field of [`Parameters::TABLE`] with this name.
            ///
            /// Returns `None` if there is no such field. [`Beamformer::new`] checks the range.
            pub fn set(&mut self, name: &str, value: f64) -> Option<()> {
                match name {
                    $(stringify!($name) => self.$name = value as $number,)*
                    _ => return None,
                }
                Some(())
            }
        }
    };
}

parameters! {
    /// `K`: the covariance is averaged over the samples `n−K..=n+K`.
    ///
    /// The largest window, 8191 samples, is as long as a whole record: 315 mm at 20 MHz.
    temporal_half_window: usize = 0 "samples" (or 2), whole true, range!(at least 0 and at most 4095);
    /// `Δ`: `Δ/L·tr(R)` is added to the diagonal of the covariance `R`.
    ///
    /// Below about 1e-4 the rounding of f32 dominates. The full eigensolver serves a covariance that is singular in
    /// f32, with eigenvalues of at least `2⁻²⁴` of the trace.
    diagonal_loading: f32 = 0.05 "" (or 0.01), whole false, range!(0 to 1e6);
    /// Length of the subapertures over the number of active elements.
    ///
    /// `L = max(1, floor(ratio·active elements))`.
    subaperture_ratio: f64 = 0.5 "" (or 0.4), whole false, range!(above 0, at most 1);
    /// `M₀`: the highest coherent spatial frequency of the generalized coherence factor.
    ///
    /// In cycles across the active aperture.
    coherence_cutoff: usize = 1 "cycles" (or 2), whole true, range!(at least 0 and at most 64);
    /// Share of the active aperture in the falling ends of a Tukey window.
    ///
    /// It counts both ends together: 1 gives a Hann window.
    tukey_taper: f32 = 0.5 "" (or 0.25), whole false, range!(0 to 1);
    /// Distance of beamformed samples of a line, from the first on.
    ///
    /// Images interpolate between them. A beamformed sample has the same value for every depth step.
    depth_step: usize = 1 "samples" (or 3), whole true, range!(1 to 8);
}

impl Default for Parameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Parameters {
    /// The default with another method.
    pub const fn of(method: Method) -> Self {
        Parameters {
            method,
            ..Self::DEFAULT
        }
    }

    /// Checks all values; a `const` can call it.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a value outside the range of its row in [`Parameters::TABLE`], or for an argument
    /// of the method outside that of [`Method::parameter`]; for sub-lines beyond [`Parameters::SUB_LINES`]. Without
    /// the feature `eigenspace`, for its methods, and for MV with a diagonal loading below 10⁻⁴. Without the feature
    /// `apodization`, `forward`, `postfilters` or `sub-lines`, for any of these.
    pub const fn check(&self) -> Result<(), Error> {
        let method = self.method;
        if let (Some(row), Some(argument)) = (method.parameter(), method.argument()) {
            attempt!(row.check(argument));
        }
        attempt!(method.check_compiled(self.diagonal_loading));
        let (apodization, postfilter) = (self.apodization, self.postfilter);
        let of_features = [
            (
                FORWARD || !matches!(self.covariance, Covariance::Forward),
                "forward",
                "the feature forward",
            ),
            (
                APODIZATION || matches!(apodization, Apodization::None),
                apodization.name(),
                "the feature apodization",
            ),
            (
                POSTFILTERS || matches!(postfilter, Postfilter::None),
                postfilter.name(),
                "the feature postfilters",
            ),
        ];
        let mut k = 0;
        while k < of_features.len() {
            let (compiled, name, expected) = of_features[k];
            if !compiled {
                return Err(Error::parameter(name, 0.0, expected));
            }
            k += 1;
        }
        let sub_lines = self.sub_lines;
        attempt!(Parameters::SUB_LINES.check(sub_lines as f64));
        if !sub_lines.is_power_of_two() || sub_lines > 1 && !SUB_LINES {
            return Err(Error::parameter(
                Parameters::SUB_LINES.name,
                sub_lines as f64,
                match SUB_LINES {
                    true => Parameters::SUB_LINES.range.text,
                    false => "1 without the feature sub-lines",
                },
            ));
        }
        let values = self.values();
        let mut k = 0;
        while k < values.len() {
            attempt!(Parameters::TABLE[k].check(values[k]));
            k += 1;
        }
        Ok(())
    }

    /// The window of the apodization, if it has one.
    pub(super) fn window(&self) -> Option<Window> {
        if !APODIZATION {
            return None;
        }
        Window::new(self.apodization, self.tukey_taper)
    }

    #[inline(always)]
    pub(crate) fn step(&self) -> DepthStep {
        DepthStep::new(self.depth_step)
    }

    /// Number of computed samples of a line of `samples` aligned samples.
    ///
    /// Every [`Parameters::depth_step`]-th sample is computed, from the first on.
    ///
    /// ```
    /// use bonebeam::beamform::Parameters;
    ///
    /// let parameters = Parameters { depth_step: 4, ..Parameters::DEFAULT };
    /// assert_eq!(parameters.line_samples(9), 3); // samples 0, 4 and 8
    /// ```
    pub const fn line_samples(&self, samples: usize) -> usize {
        match samples.checked_div(self.depth_step) {
            None => samples,
            Some(whole) => whole + (!samples.is_multiple_of(self.depth_step)) as usize,
        }
    }

    /// The postfilter and its parameter.
    pub(super) fn postfilter_of_lines(&self) -> Applied {
        Applied {
            postfilter: match POSTFILTERS {
                true => self.postfilter,
                false => Postfilter::None,
            },
            cutoff: self.coherence_cutoff,
        }
    }

    /// Shapes of the workspace for up to `elements` active elements; none for DAS.
    pub const fn sizes(&self, elements: usize) -> Sizes {
        match self.method.direct() {
            Some(_) => Sizes {
                covariance: self.covariance,
                elements: 0,
                subaperture: 0,
                temporal_half_window: 0,
                sub_lines: 1,
            },
            None => Sizes {
                covariance: self.covariance,
                elements,
                subaperture: self.subaperture(elements),
                temporal_half_window: self.temporal_half_window,
                sub_lines: self.sub_lines,
            },
        }
    }

    /// `L` for `count ≥ 1` active elements.
    const fn subaperture(&self, count: usize) -> usize {
        // The cast rounds down. Beyond 2⁵³ the product may round up.
        let length = (self.subaperture_ratio * count as f64) as usize;
        let length = if length < count { length } else { count };
        if length > 1 { length } else { 1 }
    }
}

/// A beamformer with valid parameters.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Beamformer {
    parameters: Parameters,
}

impl Beamformer {
    /// Validates the parameters.
    ///
    /// # Errors
    /// As [`Parameters::check`].
    pub const fn new(parameters: Parameters) -> Result<Self, Error> {
        attempt!(parameters.check());
        Ok(Beamformer { parameters })
    }

    /// A beamformer with parameters that were checked.
    pub(super) fn unchecked(parameters: Parameters) -> Self {
        Beamformer { parameters }
    }

    /// The parameters.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Number of computed samples of a line: [`Parameters::line_samples`].
    pub fn line_samples(&self, samples: usize) -> usize {
        self.parameters().line_samples(samples)
    }

    /// Shapes of the workspace for `elements` active elements: [`Parameters::sizes`].
    pub fn sizes(&self, elements: usize) -> Sizes {
        self.parameters.sizes(elements)
    }

    /// Subaperture length `L` for `count ≥ 1` active elements.
    pub fn subaperture(&self, count: usize) -> usize {
        // As `Parameters::subaperture`. The call of `floor` keeps LLVM from computing the product for DAS, too, which
        // needs none (3 % of its instructions on a Cortex-M7).
        let length = libm::floor(self.parameters.subaperture_ratio * count as f64) as usize;
        length.min(count).max(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The constant subaperture sizes the memory; the beamformer computes the same one.
    #[test]
    fn sizes_have_the_beamformers_subaperture() {
        for ratio in [1e-9, 0.1, 0.25, 1.0 / 3.0, 0.4, 0.5, 0.7, 1.0] {
            let parameters = Parameters {
                subaperture_ratio: ratio,
                ..Parameters::DEFAULT
            };
            let beamformer = Beamformer::new(parameters).unwrap();
            for count in (1..=256).chain([1 << 40, (1 << 53) + 1, usize::MAX]) {
                let expected = beamformer.subaperture(count);
                assert_eq!(
                    beamformer.sizes(count).subaperture,
                    expected,
                    "{count}, {ratio}"
                );
            }
        }
        let das = Parameters::of(Method::Das);
        let none = Sizes {
            sub_lines: 1,
            ..Sizes::default()
        };
        assert_eq!(das.sizes(8), none);
    }
}
