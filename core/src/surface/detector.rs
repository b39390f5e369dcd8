//! Plan of a detector: lengths in cells, prices as integers.

use super::learnt::Learnt;
use super::logarithm::NAT;
use super::onset::{Line, RampPlan, SHIFT, Window};
use super::parameters::{Parameters, Prices, Ramp, Settings, Sizes, WHITE, cells_of, window};
use crate::Error;
use crate::error::{attempt, finite};
use crate::memory::Need;

/// Bone surface detector: validated parameters and its plan.
///
/// It finds the bone surface in grey levels of lines. A frame needs `Detector::need` numbers of memory. On a Cortex-M7,
/// scores and path together take about 60 instructions per sample for cells of four samples, the levels of a line 20
/// (`firmware/count`).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Detector {
    parameters: Parameters,
    pub(super) sizes: Sizes,
    pub(super) line: Line,
    pub(super) learnt: Option<Learnt>,
    pub(super) prices: Prices,
}

impl Detector {
    /// Validates the parameters and computes the plan.
    ///
    /// # Errors
    /// As [`Parameters::need`]; [`Error::Parameter`] naming a window, a term or a price that is out of range.
    pub const fn new(parameters: Parameters) -> Result<Self, Error> {
        let sizes = attempt!(parameters.sizes());
        let settings = parameters.settings;
        let line = attempt!(line(&settings, &sizes, parameters.samples.step));
        let prices = attempt!(prices(&parameters, &sizes));
        let learnt = match settings.learnt {
            true => Some(Learnt::new(sizes.stride as f64 * parameters.samples.step)),
            false => None,
        };
        Ok(Detector {
            parameters,
            sizes,
            line,
            learnt,
            prices,
        })
    }

    /// The parameters.
    pub const fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Memory of a [`Tracker`](super::Tracker), and of [`Detector::frame`].
    pub const fn need(&self) -> Need {
        self.sizes.need()
    }

    /// Depth of the middle of a cell of the search, plus a fraction of a cell, m.
    pub(super) fn depth(&self, cell: usize, fraction: f32) -> f32 {
        let Sizes { stride, first, .. } = self.sizes;
        let samples = &self.parameters.samples;
        let cell = (first + cell) as f64 + f64::from(fraction);
        let sample = cell * stride as f64 + (stride - 1) as f64 / 2.0;
        (samples.first + sample * samples.step) as f32
    }
}

/// The plan of a line's scores.
const fn line(settings: &Settings, sizes: &Sizes, step: f64) -> Result<Line, Error> {
    let Settings {
        echo,
        near,
        far,
        above,
        below,
        shadow_from,
        rest_from,
        rest_block,
        onset_floor,
        onset_weight,
        shadow_range,
        margin,
        ..
    } = *settings;
    attempt!(window("rest_from", [0.0, rest_from]));
    attempt!(window("rest_block", [0.0, rest_block]));
    attempt!(within("onset_floor", onset_floor, [1e-7, 1.0], "1e-7 to 1"));
    attempt!(within("onset_weight", onset_weight, [0.0, 4.0], "0 to 4"));
    attempt!(within(
        "shadow_range",
        shadow_range,
        [0.01, 2.0],
        "0.01 to 2"
    ));
    attempt!(within("margin", margin, [0.0, 1.0], "0 to 1"));
    let cell = sizes.stride as f64 * step;
    let white = WHITE as f64;
    let contrast = attempt!(ramp("contrast", &settings.contrast));
    let level = attempt!(ramp("level", &settings.level));
    let coherence = attempt!(ramp("coherence", &settings.coherence));
    let rest = attempt!(ramp("rest", &settings.rest));
    let shadow = attempt!(ramp("shadow", &settings.shadow));
    let block = if signed(rest_block, cell) < 1 {
        1
    } else {
        signed(rest_block, cell)
    };
    Ok(Line {
        echo: Window::new(-signed(echo, cell), signed(echo, cell), sizes.stride),
        near: Window::new(signed(near[0], cell), signed(near[1], cell), sizes.stride),
        far: Window::new(signed(far[0], cell), signed(far[1], cell), sizes.stride),
        above: Window::new(
            -signed(above[1], cell),
            -signed(above[0], cell),
            sizes.stride,
        ),
        below: Window::new(signed(below[0], cell), signed(below[1], cell), sizes.stride),
        floor: (onset_floor * white * white + 0.5) as u32,
        weight: integer(onset_weight * 1024.0),
        contrast: ramp_plan(&settings.contrast, contrast),
        level: ramp_plan(&settings.level, level),
        coherence: ramp_plan(&settings.coherence, coherence),
        rest: ramp_plan(&settings.rest, rest),
        margin: integer(margin * white) << SHIFT,
        rest_from: cells_of(rest_from, cell),
        rest_block: Window::new(0, block - 1, sizes.stride),
        shadow_from: cells_of(shadow_from, cell),
        shadow_centre: integer(settings.shadow.centre * 256.0),
        shadow_gain: integer(shadow),
        shadow_limit: integer(magnitude(settings.shadow.weight) * NAT as f64),
        shadow_range: integer(shadow_range * white),
    })
}

/// The plan of a ramp of differences of grey levels; `slope` is that of [`ramp`].
const fn ramp_plan(ramp: &Ramp, slope: f64) -> RampPlan {
    let white = WHITE as f64;
    RampPlan::new(
        integer(ramp.centre * white),
        integer(slope / white),
        integer(magnitude(ramp.weight) * NAT as f64),
    )
}

/// The slope of a ramp, in 2⁻¹² scores for each unit of `x`.
const fn ramp(name: &'static str, ramp: &Ramp) -> Result<f64, Error> {
    let Ramp {
        weight,
        centre,
        width,
    } = *ramp;
    attempt!(within(name, weight, [-16.0, 16.0], "a weight of -16 to 16"));
    attempt!(within(name, centre, [-2.0, 2.0], "a centre of -2 to 2"));
    let least = magnitude(weight) / 127.0;
    if !(width > 0.0 && width >= least && width < 1e6) {
        let expected = "a width above 0, at least a 127th of the weight, and below 1e6";
        return Err(Error::parameter(name, width, expected));
    }
    Ok(weight / width * (NAT as f64) * 4096.0)
}

const fn prices(parameters: &Parameters, sizes: &Sizes) -> Result<Prices, Error> {
    let Settings {
        absence,
        end,
        jump,
        slope,
        spacing,
        confidence,
        piece,
        step: longest,
        ..
    } = parameters.settings;
    attempt!(within("absence", absence, [-64.0, 64.0], "-64 to 64 nats"));
    attempt!(within("end", end, [0.0, 64.0], "0 to 64 nats"));
    attempt!(within("jump", jump, [0.0, 64.0], "0 to 64 nats"));
    attempt!(finite("slope", slope));
    attempt!(finite("confidence", confidence[0] as f64));
    attempt!(finite("confidence", confidence[1] as f64));
    attempt!(within("step", longest, [0.0, f64::INFINITY], "0 m or more"));
    attempt!(within("piece", piece as f64, [0.0, 1.0], "0 to 1"));
    let factor = parameters.spacing / spacing;
    attempt!(within(
        "line spacing over that of the settings",
        factor,
        [0.02, 4.0],
        "0.02 to 4"
    ));
    let cell = sizes.stride as f64 * parameters.samples.step;
    let nat = NAT as f64;
    let step = integer(slope * cell * nat);
    if step < 1 || step > 1 << 16 {
        let expected = "between 1/1024 nat and 64 nats for a cell";
        return Err(Error::parameter("slope", slope, expected));
    }
    // A longer move costs more than a jump, so that back pointers fit seven bits.
    let (jump, most) = (integer(jump * nat), step * Prices::FARTHEST - 1);
    let jump = if jump < most { jump } else { most };
    let factor = integer(factor * 256.0);
    Ok(Prices {
        absence: integer(absence * nat),
        // The cast saturates.
        most: (longest / cell) as u32,
        absent: (integer(absence * nat) * factor) >> 8,
        end: integer(end * nat),
        jump,
        step,
        factor,
    })
}

const fn within(
    name: &'static str,
    value: f64,
    [least, most]: [f64; 2],
    expected: &'static str,
) -> Result<(), Error> {
    if value >= least && value <= most {
        return Ok(());
    }
    Err(Error::parameter(name, value, expected))
}

const fn magnitude(value: f64) -> f64 {
    if value < 0.0 { -value } else { value }
}

/// The nearest integer.
const fn integer(value: f64) -> i32 {
    // The cast cuts towards 0, and saturates.
    if value < 0.0 {
        (value - 0.5) as i32
    } else {
        (value + 0.5) as i32
    }
}

const fn signed(length: f64, cell: f64) -> isize {
    cells_of(length, cell) as isize
}
