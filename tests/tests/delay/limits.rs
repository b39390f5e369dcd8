//! Extreme geometry, and the limits of records and of numbers.

use super::*;

/// At a position of ±2²³ samples on the axis the stage reads nothing.
///
/// That holds although the element's lag, or its lead, brings the position near the record. One sample nearer, it
/// reads. Depths and times are exact: c = 2, fs = 1.
#[test]
fn nothing_is_read_from_2_to_the_23_samples_on() {
    let far = 8_388_608.0;
    let deep = 2.0 * far - 100.0;
    for (x, z, depth, t0, beside) in [
        (4.0, deep, deep, deep - far, -1),
        (2.0 * far, 0.0, 10.0, 10.0 + far, 1),
    ] {
        let p = DelayParameters {
            sound_speed: 2.0,
            output_start: depth - 9.0,
            output_samples: 19,
            ..parameters(1.0, 1.0, 1, 100)
        };
        let elements = [Element::down(x, z)];
        let line = ScanLine {
            transmit: Transmit::new(TransmitLaw::Focused, t0),
            ray: Ray::down(0.0),
            array: Array::at(&elements, 1.0),
            ..line_of(TransmitLaw::Focused, &[0.0])
        };
        let rf = noise(100, 9);
        let ours = rf_line(&p, &line, &rf);
        assert_reference(&ours, &p, &line, &rf, &format!("{depth}"));
        assert!(ours[9].re == 0.0 && ours[(9 + beside) as usize].re != 0.0);
    }
}

/// A line straight towards an element reads one position for every depth.
///
/// The transmit path grows as the receive path shrinks. Depths and times are exact: c = 2, and a halved record's rate
/// is 2.
#[test]
fn a_line_towards_an_element_reads_one_position() {
    let p = DelayParameters {
        sound_speed: 2.0,
        output_start: 20.0,
        output_samples: 32,
        ..parameters(4.0, 1.0, 1, 2500)
    };
    let elements = [Element::down(0.0, 1000.0)];
    let line = ScanLine {
        ray: Ray::down(0.0),
        array: Array::at(&elements, 1.0),
        ..line_of(TransmitLaw::Focused, &[0.0])
    };
    let rf = noise(2500, 13);
    let ours = rf_line(&p, &line, &rf);
    assert_reference(&ours, &p, &line, &rf, "one place");
    assert!(ours.iter().all(|y| y.re == ours[0].re && y.re != 0.0));
}

/// Half of the line is so deep that c·t overflows; the other half is still read.
#[test]
fn depths_beyond_all_numbers_read_0_and_the_others_what_they_are() {
    for fs in [50.0, 200.0] {
        let p = DelayParameters {
            sound_speed: 1e308,
            output_start: 1.0,
            output_samples: 80,
            ..parameters(fs, 50.0, 2, 600)
        };
        let line = line_of(TransmitLaw::Focused, &[0.0, 1.0]);
        let rf = noise(1200, 10);
        let ours = rf_line(&p, &line, &rf);
        assert_reference(&ours, &p, &line, &rf, &format!("{fs}"));
        assert!(ours[..70].iter().all(|y| y.re != 0.0));
        assert!(ours[90..].iter().all(|y| y.re == 0.0));
    }
}
