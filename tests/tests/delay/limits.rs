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
        let elements = [Element { x, z, angle: 0.0 }];
        let line = ScanLine {
            transmit: Transmit::new(TransmitLaw::Focused, t0),
            ray: Ray::down(0.0),
            array: Array::At {
                elements: &elements,
                pitch: 1.0,
            },
            ..line_of(TransmitLaw::Focused, &[0.0])
        };
        let rf = noise(100, 9);
        let ours = core_line(&p, &line, &rf);
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
    let elements = [Element {
        x: 0.0,
        z: 1000.0,
        angle: 0.0,
    }];
    let line = ScanLine {
        ray: Ray::down(0.0),
        array: Array::At {
            elements: &elements,
            pitch: 1.0,
        },
        ..line_of(TransmitLaw::Focused, &[0.0])
    };
    let rf = noise(2500, 13);
    let ours = core_line(&p, &line, &rf);
    assert_reference(&ours, &p, &line, &rf, "one place");
    assert!(ours.iter().all(|y| y.re == ours[0].re && y.re != 0.0));
}

/// Lines within, before and after a halved record.
///
/// Only the samples that they read are halved. The rest of the memory is NaN. Some elements are beside the line, and
/// in front of its start.
#[test]
fn any_part_of_a_halved_record_has_the_bits_of_the_reference() {
    let samples = 700;
    let rf = noise(3 * samples, 12);
    let level = [-9e-3, 0.4e-3, 14e-3];
    let elements =
        [(-5e-3, 3e-3), (1e-3, 9e-3), (12e-3, -4e-3)].map(|(x, z)| Element { x, z, angle: 0.0 });
    let arrays = [
        Array::LinearAt(&level),
        Array::At {
            elements: &elements,
            pitch: 6e-3,
        },
    ];
    let mut read = 0;
    for (array, fs) in arrays
        .into_iter()
        .flat_map(|a| [50e6, 100e6].map(|fs| (a, fs)))
    {
        let mut p = parameters(fs, 20e6, 3, samples);
        (p.output_samples, p.hilbert_taps) = (32, 4);
        let mut delay = Delay::new(p).unwrap();
        // All residues of their first and last sample, and a depth of 0 at each of the line's samples.
        let starts = (-60..400).step_by(3).map(|k| (k, 0.0));
        let starts = starts.chain((0..130).map(|k| (k, 5.1e-6)));
        for (k, late) in starts.chain((-60..0).map(|k| (k, -6.3e-6))) {
            p.output_start = f64::from(k) / 20e6;
            delay.set(p).unwrap();
            let line = ScanLine {
                transmit: Transmit::new(TransmitLaw::Focused, late),
                array,
                ..line_of(TransmitLaw::Focused, &level)
            };
            let mut ours = vec![ZERO; 3 * 32];
            line_by(&delay, 0.0f32, &line, &rf, &mut ours);
            let what = format!("{array:?} {fs} {k} {late}");
            assert_reference(&ours, &p, &line, &rf, &what);
            read += ours.iter().filter(|y| y.re != 0.0).count();
        }
    }
    assert!(read > 5000, "{read}");
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
        let ours = core_line(&p, &line, &rf);
        assert_reference(&ours, &p, &line, &rf, &format!("{fs}"));
        assert!(ours[..70].iter().all(|y| y.re != 0.0));
        assert!(ours[90..].iter().all(|y| y.re == 0.0));
    }
}
