//! The delay stage names the wrong parameter before it writes anything.

use bonebeam::delay::{Compounding, Delay, DelayParameters, MAX_SAMPLES, Record, ScanLine, Stage};
use bonebeam::geometry::{Active, Array, Ray, Transmit, TransmitLaw};
use bonebeam::{Complex, Error};

const GOOD: DelayParameters = DelayParameters {
    output_samples: 50,
    elements: 3,
    record_samples: 100,
    hilbert_taps: 2,
    ..DelayParameters::EXAMPLE
};

/// A size of the parameters: its name, the largest value, and its field.
type Size = (&'static str, usize, fn(&mut DelayParameters) -> &mut usize);
/// A number of the parameters: its name, and its field.
type Number = (&'static str, fn(&mut DelayParameters) -> &mut f64);
/// One field of the line changed, and the name that the error must give.
type LineChange = (&'static str, fn(&mut ScanLine));
/// One field of the parameters changed, and the name that the error must give.
type Change = (&'static str, fn(&mut DelayParameters));

#[test]
fn bad_parameters_are_named() {
    let refused = |name: &str, p: DelayParameters| match Delay::new(p) {
        Err(Error::Parameter { name: n, .. } | Error::Capacity { name: n, .. }) => {
            assert_eq!(n, name);
        }
        other => panic!("{name}: {other:?}"),
    };
    let numbers: [Number; 4] = [
        ("sound_speed", |p| &mut p.sound_speed),
        ("sampling_rate", |p| &mut p.sampling_rate),
        ("output_rate", |p| &mut p.output_rate),
        ("centre_frequency", |p| &mut p.centre_frequency),
    ];
    for (name, number) in numbers {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let mut p = GOOD;
            *number(&mut p) = bad;
            refused(name, p);
        }
    }
    let changes: [Change; 9] = [
        ("hilbert taps", |p| p.hilbert_taps = 0),
        ("hilbert taps", |p| p.hilbert_taps = 65),
        ("output_rate", |p| p.output_rate = 2e6),
        ("output_start", |p| p.output_start = f64::NAN),
        ("elements", |p| p.elements = 0),
        ("elements", |p| p.elements = usize::MAX),
        ("output_samples", |p| p.output_samples = 0),
        ("record_samples", |p| p.record_samples = 0),
        ("record_samples", |p| p.record_samples = 1 << 23),
    ];
    for (name, change) in changes {
        let mut p = GOOD;
        change(&mut p);
        refused(name, p);
    }
}

/// The largest sizes are valid; the next is refused with the largest as capacity.
#[test]
fn sizes_are_refused_from_the_first_that_is_too_large() {
    let [longer, shorter] = [900, 50];
    let elements = usize::MAX / longer;
    let samples = |output_samples, record_samples| DelayParameters {
        output_samples,
        record_samples,
        ..GOOD
    };
    let changes: [(DelayParameters, Size); 4] = [
        (
            samples(longer, shorter),
            ("elements", elements, |p| &mut p.elements),
        ),
        (
            samples(shorter, longer),
            ("elements", elements, |p| &mut p.elements),
        ),
        (
            GOOD,
            ("output_samples", MAX_SAMPLES, |p| &mut p.output_samples),
        ),
        (
            GOOD,
            ("record_samples", MAX_SAMPLES, |p| &mut p.record_samples),
        ),
    ];
    for (mut p, (name, capacity, size)) in changes {
        *size(&mut p) = capacity;
        assert!(Delay::new(p).is_ok(), "{name}");
        *size(&mut p) = capacity + 1;
        let refused = Error::Capacity {
            name,
            actual: capacity + 1,
            capacity,
        };
        assert_eq!(Delay::new(p).unwrap_err(), refused);
    }
}

/// For lines of the length in `DelayParameters::need`.
#[test]
fn the_scratch_has_the_documented_length() {
    let of = |sampling_rate: f64, lanes: usize| {
        let p = DelayParameters {
            sampling_rate,
            output_samples: 70,
            record_samples: 1000,
            hilbert_taps: 16,
            ..GOOD
        };
        p.need(lanes).real
    };
    // 70 up to 96, and 62, up to 160; 32 and 62 for each lane.
    for lanes in [1, 2, 4, 8, 16] {
        assert_eq!(of(40e6, lanes), (3 + lanes) * 160 + lanes * 94 + 15);
    }
    for (sampling_rate, part, streams) in [(50e6, 2, 160), (100e6, 4, 448), (200e6, 8, 992)] {
        let more = |lanes| of(sampling_rate, lanes) - of(40e6, lanes) - streams;
        // The margins of both filters, up to multiples of sixteen.
        let one = more(1);
        assert!(
            (1000 / part..1000 / part + 48).contains(&one),
            "{part} {one}"
        );
        for lanes in [2, 4, 8, 16] {
            assert_eq!(more(lanes), 2 * one, "{part} {lanes}");
        }
    }
}

#[test]
fn bad_calls_are_refused_before_anything_is_written() {
    let delay = Delay::new(GOOD).unwrap();
    let element_x = [-0.3e-3, 0.0, 0.3e-3];
    let rf = vec![1.0; 300];
    let line = ScanLine {
        transmit: Transmit {
            law: TransmitLaw::Focused,
            t0: 0.0,
        },
        ray: Ray::down(0.0),
        array: Array::LinearAt(&element_x),
        active: Active::new(0, 3),
        compounding: Compounding::Replace,
    };
    let refused = |line: &ScanLine, rf: &[f32], scratch: usize, out: usize| {
        let mut out = vec![Complex::new(5.0, 6.0); out];
        let record = Record::new(rf, 3).unwrap();
        let result = delay.line(0.0f32, line, &record, &mut vec![0.0; scratch], &mut out);
        assert!(
            out.iter().all(|y| *y == Complex::new(5.0, 6.0)),
            "written after {result:?}"
        );
        result.unwrap_err()
    };
    let scratch = GOOD.need(1).real;
    let length = |name, actual, expected| Error::Length {
        name,
        actual,
        expected,
    };

    assert_eq!(
        refused(&line, &rf[3..], scratch, 150),
        length("record samples", 99, 100)
    );
    assert_eq!(
        refused(&line, &rf, scratch + 1, 150),
        length("scratch", scratch + 1, scratch)
    );
    assert_eq!(refused(&line, &rf, scratch, 151), length("out", 151, 150));
    let (mut two, record) = ([Complex::ZERO; 6], Record::new(&rf, 3).unwrap());
    let behind = delay.block(
        0.0f32,
        &line,
        &record,
        49,
        &mut vec![0.0; scratch],
        &mut two,
    );
    let (name, actual, capacity) = ("block", 51, 50);
    assert_eq!(
        behind,
        Err(Error::Capacity {
            name,
            actual,
            capacity
        })
    );
    let two = ScanLine {
        array: Array::LinearAt(&element_x[1..]),
        ..line
    };
    assert_eq!(refused(&two, &rf, scratch, 150), length("element_x", 2, 3));

    let parameter = |error| match error {
        Error::Parameter { name, .. } => name,
        other => panic!("{other:?}"),
    };
    let changes: [LineChange; 7] = [
        ("t0", |l| l.transmit.t0 = f64::INFINITY),
        ("line position", |l| l.ray = Ray::down(f64::NAN)),
        ("element_x", |l| {
            l.array = Array::LinearAt(&[-0.3e-3, 0.0, f64::NAN])
        }),
        ("angle", |l| {
            l.transmit.law = TransmitLaw::Plane { angle: 1.6 }
        }),
        ("transmit element x", |l| {
            l.transmit.law = TransmitLaw::Element {
                x: f64::NAN,
                z: 0.0,
            };
        }),
        ("active", |l| l.active.first = 1),
        ("active", |l| l.active = Active::new(usize::MAX, 2)),
    ];
    for (name, change) in changes {
        let mut bad = line;
        change(&mut bad);
        assert_eq!(parameter(refused(&bad, &rf, scratch, 150)), name);
    }

    let add = ScanLine {
        compounding: Compounding::Add,
        ..line
    };
    let record = Record::new(&rf, 3).unwrap();
    // One part or both of a sample, one sample or two.
    let nan = Complex::new(0.0, f32::NAN);
    let infinite = Complex::new(f32::INFINITY, f32::NEG_INFINITY);
    for bad in [&[(9, nan)][..], &[(9, infinite)], &[(9, nan), (30, nan)]] {
        let mut out = vec![Complex::new(0.0, 0.0); 150];
        for &(index, y) in bad {
            out[index] = y;
        }
        let error = delay
            .line(0.0f32, &add, &record, &mut vec![0.0; scratch], &mut out)
            .unwrap_err();
        assert_eq!(
            error,
            Error::NonFinite {
                name: "out",
                index: 9
            }
        );
    }
}

#[test]
fn records_are_checked_once() {
    let rf = vec![1.0; 300];
    assert_eq!(Record::new(&rf, 3).unwrap().samples(), 100);
    let length = |actual, expected| Error::Length {
        name: "rf",
        actual,
        expected,
    };
    assert_eq!(Record::new(&rf[1..], 3).unwrap_err(), length(299, 297));
    assert_eq!(Record::new(&[], 3).unwrap_err(), length(0, 3));
    assert_eq!(Record::new(&rf[..2], 3).unwrap_err(), length(2, 3));
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        // Within a piece, at its ends, and in the last, shorter one.
        for index in [0, 217, 255, 256, 299] {
            let mut rf = rf.clone();
            rf[index] = value;
            let error = Record::new(&rf, 3).unwrap_err();
            assert_eq!(error, Error::NonFinite { name: "rf", index });
        }
    }
    let named = |result: Result<Record, Error>| match result {
        Err(Error::Parameter { name, .. }) => name,
        other => panic!("{other:?}"),
    };
    let mut loud = rf.clone();
    loud[3] = -1.001e29;
    assert_eq!(named(Record::new(&loud, 3)), "rf");
    loud[3] = -1e29;
    assert!(Record::new(&loud, 3).is_ok());
    assert_eq!(named(Record::new(&rf, 0)), "elements");
}
