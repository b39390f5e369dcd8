//! The delay stages.

use crate::geometry::{arrays, axis, parameters, transmit};
use crate::{opaque, take};
use bonebeam::delay::hilbert_taps;
use bonebeam::prelude::stages::*;

/// Calls all functions.
pub fn all() {
    take(hilbert_taps(opaque(1.0), opaque(1.0)));
    take(IqInterpolation::for_band(opaque(1.0), opaque(1.0)));
    let x = [0.0; 5];
    for array in arrays(&x) {
        if let Ok(scan) = Scan::new(parameters(array, Lines::Even(axis()))) {
            take(rf(&scan));
            take(upsampled(&scan));
            take(iq(&scan));
        }
    }
}

fn rf(scan: &Scan) -> Result<(), Error> {
    let mut parameters = DelayParameters::of(scan);
    take(opaque(parameters).need(opaque(1)).real);
    take(opaque(parameters).block_need(opaque(1), opaque(1)).real);
    parameters.hilbert_taps = opaque(1);
    let mut delay = Delay::new(opaque(parameters))?;
    take(delay.set(opaque(parameters)));
    take(delay.set_in_f32(opaque(parameters)));
    take(delay.parameters());
    let ray = Ray::down(opaque(1.0));
    take(ScanLine::new(
        transmit(),
        ray,
        opaque(scan.parameters().array),
    ));
    take(delay.record_end(&opaque(line(scan)), opaque(0..1)));
    let rf = [0.0; 100];
    let record = Record::new(opaque(&rf[..]), opaque(1))?;
    take((
        record.elements(),
        record.samples(),
        record.largest_aligned(),
    ));
    let (scratch, out) = (&mut [0.0; 100][..], &mut [Complex::ZERO; 100][..]);
    let (scratch, out) = (opaque(scratch), opaque(out));
    take(delay.line(0.0f32, &opaque(line(scan)), &record, scratch, out));
    delay.block(
        0.0f32,
        &opaque(line(scan)),
        &record,
        opaque(1),
        scratch,
        out,
    )
}

fn upsampled(scan: &Scan) -> Result<(), Error> {
    let delay = Delay::new(opaque(DelayParameters::of(scan)))?;
    let upsampled = Upsampled::new(&delay)?;
    take((upsampled.record_len(), upsampled.need().real));
    take((upsampled.line_len(), upsampled.block_len(opaque(1))));
    let (mut reals, mut places) = ([[0.0; 100]; 4], [[0; 100]; 2]);
    let [samples, scratch, record, values] = opaque(reals.each_mut().map(|x| &mut x[..]));
    let [centre, receive_delays] = opaque(places.each_mut().map(|x| &mut x[..]));
    let line = line(scan);
    take(upsampled.record(0.0f32, samples, scratch, record));
    take(upsampled.centre(&line, centre));
    take(upsampled.receive_delays(0.0f32, &line, opaque(1), receive_delays));
    let contribution = Contribution {
        record,
        centre,
        receive_delays,
    };
    take(upsampled.add(0.0f32, &contribution, values));
    let mut out = [Complex::ZERO; 100];
    upsampled.analytic(0.0f32, &line, values, scratch, opaque(&mut out[..]))
}

fn iq(scan: &Scan) -> Result<(), Error> {
    let mut parameters = IqParameters::of(scan, opaque(1.0));
    take(opaque(parameters).need(opaque(1)).real);
    parameters.interpolation = opaque(IqInterpolation::Cubic);
    let delay = IqDelay::new(opaque(parameters))?;
    take(delay.parameters());
    let samples = [Complex::ZERO; 100];
    let counts = [[0; 2]; 100];
    for samples in [
        IqSamples::Float(opaque(&samples[..])),
        IqSamples::Counts(opaque(&counts[..]), opaque(1.0)),
    ] {
        let record = Record::iq(opaque(samples), opaque(IqLayout::Planar), opaque(1))?;
        let record = record.with_phase(opaque(0.0))?;
        take((record.elements(), record.samples()));
        let (scratch, out) = (&mut [0.0; 100][..], &mut [Complex::ZERO; 100][..]);
        let (scratch, out) = (opaque(scratch), opaque(out));
        take(delay.line(0.0f32, &opaque(line(scan)), &record, scratch, out));
        take(delay.block(
            0.0f32,
            &opaque(line(scan)),
            &record,
            opaque(1),
            scratch,
            out,
        ));
    }
    Ok(())
}

fn line<'a>(scan: &Scan<'a>) -> ScanLine<'a> {
    ScanLine::of(scan, opaque(1), transmit(), opaque(Compounding::Add))
}
