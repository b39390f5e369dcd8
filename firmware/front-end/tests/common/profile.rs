//! A waveform, and profiles of it.

use bonebeam_front_end::{Profile, Waveform};

/// Two cycles at 5 MHz, of ±50 V.
pub const WAVEFORM: Waveform = Waveform {
    frequency: 5e6,
    half_cycles: 4,
    positive_first: true,
    driven: 0.6,
    volts: 50.0,
    damping: 0.2e-6,
};

/// A profile with these delays.
pub fn profile(delays: &[Option<u16>]) -> Profile<'_> {
    Profile {
        waveform: WAVEFORM,
        delays,
        receive_after: 0.5e-6,
        prf: 4000.0,
    }
}
