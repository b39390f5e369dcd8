//! Every tolerance of the cross-crate tests, each with its reason.
// Each test file is a crate of its own and uses only some of them.
#![allow(dead_code)]

/// Delayed samples of a 5 MHz, 60 % pulse recorded or put out at 20 MHz, of its peak: the documented
/// errors of the filter (1.3e-3) and of the Hilbert transformer (2.8e-4), added.
pub const DELAYED_PULSE_20_MHZ: f64 = 1.6e-3;
/// The same where both rates are 40 MHz or more: 1.0e-5 and 2.6e-4, and a tenth more for the tail of a
/// second echo.
pub const DELAYED_PULSE_40_MHZ: f64 = 3.0e-4;
/// Moving the record by whole samples and its t0 along moves a position of some 10³ samples by a
/// rounding in f64 (1e-13), which can move the f32 fraction by one step near 10² samples of lag
/// (8e-6 samples); at most π a sample of slope: 3e-5 of the largest sample.
pub const DELAY_SHIFT: f32 = 3e-5;
