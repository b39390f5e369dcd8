//! The delay stage.

use crate::geometry::{arrays, axis, parameters, transmit};
use crate::{opaque, take};
use bonebeam::Complex;
use bonebeam::focus::{Compounding, Delay, DelayParameters, Record, ScanLine, hilbert_taps};
use bonebeam::geometry::{Lines, Scan};

/// Calls all of it.
pub fn all() {
    take(hilbert_taps(opaque(1.0), opaque(1.0)));
    let x = [0.0; 5];
    for array in arrays(&x) {
        if let Ok(scan) = Scan::new(parameters(array, Lines::Even(axis()))) {
            take(line(&scan));
        }
    }
}

fn line(scan: &Scan) -> Result<(), bonebeam::Error> {
    let mut parameters = DelayParameters::of(scan);
    take(opaque(parameters).scratch_len(opaque(1)));
    parameters.hilbert_taps = opaque(1);
    let delay = Delay::new(opaque(parameters))?;
    take(delay.parameters());
    let rf = [0.0; 100];
    let record = Record::new(opaque(&rf[..]), opaque(1))?;
    take((record.elements(), record.samples()));
    let line = ScanLine::of(scan, opaque(1), transmit(), opaque(Compounding::Add));
    let (scratch, out) = (&mut [0.0; 100][..], &mut [Complex::ZERO; 100][..]);
    delay.line(0.0f32, &opaque(line), &record, opaque(scratch), opaque(out))
}
