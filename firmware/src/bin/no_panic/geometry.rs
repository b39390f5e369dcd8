//! Geometry.

use crate::{opaque, take};
use bonebeam::geometry::{Aperture, ApertureParameters, ApertureTable, SteeringTable};
use bonebeam::prelude::stages::*;

/// Calls all functions.
pub fn all() {
    let elements = [Element::convex(opaque(5), opaque(1.0), opaque(1.0), opaque(1)); 5];
    let rays = [Ray::new(opaque(0.0), opaque(0.0), opaque(0.1)); 5];
    let curved = Array::at(opaque(&elements), opaque(1.0));
    let ray = opaque(rays[0]);
    take((ray.angle(), ray.point(opaque(1.0))));
    take((ray.x(), ray.coordinates(opaque([0.0; 2]))));
    for array in arrays(&[0.0; 5]).into_iter().chain([curved]) {
        take((array.elements(), array.x(opaque(1)), array.pitch()));
        take((array.element(opaque(1)), array.normal(opaque(1.0))));
        take(array.aperture_centre(&opaque(Ray::down(1.0))));
        let lines = [
            Lines::Even(axis()),
            Lines::At(opaque(&[0.0; 5])),
            Lines::Rays(opaque(&rays)),
        ];
        for lines in lines {
            take((lines.count(), lines.x(opaque(1)), lines.ray(opaque(1))));
            scan(array, lines);
        }
    }
    take(Element::down(opaque(1.0), opaque(1.0)));
    take((axis().position(opaque(1)), axis().last()));
    take(opaque(Depth::Metres(1.0)).seconds(opaque(1.0)));
    take(Aperture::full(opaque(1)));
    let aperture = Aperture::new(opaque(ApertureParameters {
        elements: 1,
        pitch: 1.0,
        f_number: 1.0,
        min_elements: 1,
    }));
    if let Ok(aperture) = aperture {
        take((
            aperture.elements(),
            aperture.active(opaque(1.0), opaque(1.0)),
        ));
    }
}

fn scan(array: Array<'_>, lines: Lines<'_>) {
    if let Ok(scan) = Scan::new(parameters(array, lines)) {
        take((scan.elements(), scan.lines(), scan.samples(), scan.start()));
        take((scan.time(opaque(1)), scan.depth(opaque(1)), scan.depths()));
        take((scan.active(opaque(1), opaque(1)), scan.widest(opaque(1))));
        take(scan.active_at(opaque(1.0), opaque(1)));
        take((scan.parameters(), scan.aperture()));
        take(
            scan.parameters()
                .lines
                .sub_line(opaque(1), opaque(1), opaque(2)),
        );
        let mut memory = [Complex::ZERO; 5];
        take(SteeringTable::new(&scan, opaque(2), opaque(&mut memory[..])).is_ok());
        if let Ok(table) = SteeringTable::of_step(&scan, opaque((2, 2)), opaque(&mut memory[..]))
            && let Some(steering) = table.line(opaque(1))
        {
            take((steering.samples(), steering.sub_lines()));
            take(steering.direction(opaque(1), opaque(1)));
        }
        take(SteeringTable::of(&scan, opaque((2, 2)), opaque(&memory[..])).is_ok());
        take(Steering::of(opaque(&[Complex::ZERO; 5]), opaque(2)).samples());
        take((
            Steering::need(opaque(1), opaque(2)),
            SteeringTable::need(opaque(1), opaque(1), opaque(2)),
        ));
        if let Ok(table) = ApertureTable::new(&scan, opaque(&mut [0.0; 5])) {
            take(table.active(opaque(ApertureTable::centre(&scan, opaque(1))), opaque(1)));
        }
    }
}

pub fn parameters<'a>(array: Array<'a>, lines: Lines<'a>) -> ScanParameters<'a> {
    let [
        sound_speed,
        centre_frequency,
        sampling_rate,
        output_rate,
        f_number,
    ] = opaque([1.0; 5]);
    ScanParameters {
        array,
        lines,
        sound_speed,
        centre_frequency,
        sampling_rate,
        record_samples: opaque(1),
        output_rate,
        start: opaque(Depth::Metres(0.0)),
        end: opaque(Depth::Seconds(1.0)),
        f_number,
        min_elements: opaque(1),
    }
}

/// Arrays of both kinds.
pub fn arrays(x: &[f64]) -> [Array<'_>; 2] {
    [
        Array::linear(opaque(1), opaque(1.0)),
        Array::LinearAt(opaque(x)),
    ]
}

/// Any axis.
pub fn axis() -> Axis {
    opaque(Axis::centred(opaque(1), opaque(1.0)))
}

/// Any transmit.
pub fn transmit() -> Transmit<'static> {
    opaque(Transmit::new(opaque(TransmitLaw::Focused), opaque(0.0)))
}
