//! Rates, depths and interpolations that a recording allows.

use bonebeam::delay::{Delay, MAX_DECIMATION, Upsampled};
use bonebeam::geometry::Depth;

use crate::config::Beamform;
use crate::{Error, Result};
use bonebeam_files::ChannelData;
use bonebeam_files::terminal::{digits, short};

/// Checks that an RF record holds the pulse at an output rate.
pub(super) fn check_rate(rate: f64, data: &ChannelData) -> Result<()> {
    let (lowest, highest) = (2.0 * data.f0, data.fs / MAX_DECIMATION as f64);
    if rate > lowest && rate >= highest {
        return Ok(());
    }
    Err(Error::Usage(format!(
        "--output-rate is {} Hz; expected more than twice the centre frequency of {} \
         Hz and at least 1/{MAX_DECIMATION} of the sampling rate of {} Hz; for lines of fewer samples, give \
         --depth-step",
        short(rate),
        data.f0,
        data.fs
    )))
}

/// Checks that records can be upsampled for compounded lines.
pub(super) fn check_upsampling(delay: Option<&Delay>, own: bool) -> Result<()> {
    let Some(delay) = delay else {
        return Err(Error::Usage(
            "--rf-interpolation upsampled has no effect on I/Q; give --iq-interpolation".into(),
        ));
    };
    if own {
        return Err(Error::Usage(
            "--rf-interpolation upsampled is for compounded transmits; these make one line each"
                .into(),
        ));
    }
    Upsampled::new(delay).map(drop).map_err(|error| {
        Error::Usage(format!(
            "--rf-interpolation upsampled cannot read this record: {error}"
        ))
    })
}

/// Checks that the depths are in order.
pub(super) fn check_depths(start: Depth, end: Depth, c: f64) -> Result<()> {
    let [first, last] = [start, end].map(|depth| depth.seconds(c));
    if last > first {
        return Ok(());
    }
    match (start, end) {
        (Depth::Seconds(_), Depth::Seconds(_)) => Err(Error::Data(format!(
            "the record has no depth; it ends {} s after the transmit and begins at {} s",
            digits(last),
            digits(first)
        ))),
        _ => Err(Error::Usage(format!(
            "there is no depth between {} m and {} m (--depth-start, --depth-end, or the ends \
             of the record)",
            digits(c * first / 2.0),
            digits(c * last / 2.0)
        ))),
    }
}

/// Depths of the lines, m: those asked for, or where the record begins and ends.
pub(super) fn depths_of(data: &ChannelData, parameters: &Beamform) -> [f64; 2] {
    let [first, last] = data.depths(parameters.sound_speed.unwrap_or(data.c));
    [
        parameters.depth_start.unwrap_or(first),
        parameters.depth_end.unwrap_or(last),
    ]
}

/// Two-way times at which every transmit has recorded, from 0 at the earliest.
pub(super) fn record_times(data: &ChannelData) -> (f64, f64) {
    let length = (data.samples.dim().3 - 1) as f64 / data.fs;
    let mut start = 0.0f64;
    let mut end = f64::INFINITY;
    for &t0 in &data.t0 {
        start = start.max(t0);
        end = end.min(t0 + length);
    }
    (start, end)
}
