//! The delay stage names the wrong parameter before it writes anything.

use crate::common::kit::*;
use bonebeam::delay::MAX_SAMPLES;

const GOOD: DelayParameters = DelayParameters {
    output_samples: 50,
    elements: 3,
    record_samples: 100,
    hilbert_taps: 2,
    ..DelayParameters::EXAMPLE
};

/// A size of the parameters.
type Size = fn(&mut DelayParameters) -> &mut usize;
/// A number's name and field.
type Number = (&'static str, fn(&mut DelayParameters) -> &mut f64);
/// One field of the line changed, and the name that the refusal gives.
type LineChange = (&'static str, fn(&mut ScanLine));
/// One field of the parameters changed, and the name that the refusal gives.
type Change = (&'static str, fn(&mut DelayParameters));

#[test]
fn bad_parameters_are_named() {
    let named = |name: &str, p: DelayParameters| {
        let words = refused(Delay::new(p));
        let (_, of) = words.split_once(' ').unwrap();
        assert!(of.starts_with(&format!("{name} ")), "{words}");
    };
    let numbers: [Number; 4] = [
        ("sound_speed", |p| &mut p.sound_speed),
        ("sampling_rate", |p| &mut p.sampling_rate),
        ("output_rate", |p| &mut p.output_rate),
        ("centre_frequency", |p| &mut p.centre_frequency),
    ];
    for (name, number) in numbers {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            named(name, changed(GOOD, |p| *number(p) = bad));
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
        named(name, changed(GOOD, change));
    }
}

/// The largest sizes are valid; the next is refused with the largest as capacity.
#[test]
fn sizes_are_refused_from_the_first_that_is_too_large() {
    let samples = |output, record| {
        changed(GOOD, |p| {
            (p.output_samples, p.record_samples) = (output, record)
        })
    };
    let (elements, most) = (usize::MAX / 900, MAX_SAMPLES);
    let rows: [(_, &str, usize, Size); 4] = [
        (samples(900, 50), "elements", elements, |p| &mut p.elements),
        (samples(50, 900), "elements", elements, |p| &mut p.elements),
        (GOOD, "output_samples", most, |p| &mut p.output_samples),
        (GOOD, "record_samples", most, |p| &mut p.record_samples),
    ];
    for (p, name, capacity, size) in rows {
        let of = |count| Delay::new(changed(p, |p| *size(p) = count));
        assert!(of(capacity).is_ok(), "{name}");
        let words = format!("capacity {name} {} over {capacity}", capacity + 1);
        assert_eq!(refused(of(capacity + 1)), words);
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
    let line = ScanLine::new(
        Transmit::new(TransmitLaw::Focused, 0.0),
        Ray::down(0.0),
        Array::LinearAt(&element_x),
    );
    let of = |line: &ScanLine, rf: &[f32], scratch: usize, out: usize| {
        let mut out = vec![Complex::new(5.0, 6.0); out];
        let record = Record::new(rf, 3).unwrap();
        let result = delay.line(0.0f32, line, &record, &mut vec![0.0; scratch], &mut out);
        assert!(
            out.iter().all(|y| *y == Complex::new(5.0, 6.0)),
            "written after {result:?}"
        );
        refused(result)
    };
    let scratch = GOOD.need(1).real;
    let short = of(&line, &rf[3..], scratch, 150);
    assert_eq!(short, "length record samples 99 for 100");
    let more = of(&line, &rf, scratch + 1, 150);
    assert_eq!(
        more,
        format!("length scratch {} for {scratch}", scratch + 1)
    );
    assert_eq!(of(&line, &rf, scratch, 151), "length out 151 for 150");
    let two = changed(line, |l| l.array = Array::LinearAt(&element_x[1..]));
    assert_eq!(of(&two, &rf, scratch, 150), "length element_x 2 for 3");
    let (mut two, record) = ([Complex::ZERO; 6], Record::new(&rf, 3).unwrap());
    let memory = &mut vec![0.0; scratch];
    let behind = delay.block(0.0f32, &line, &record, 49, memory, &mut two);
    assert_eq!(refused(behind), "capacity block 51 over 50");

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
            (l.transmit.law) = TransmitLaw::Element {
                x: f64::NAN,
                z: 0.0,
            }
        }),
        ("active", |l| l.active.first = 1),
        ("active", |l| l.active = Active::new(usize::MAX, 2)),
    ];
    for (name, change) in changes {
        let words = of(&changed(line, change), &rf, scratch, 150);
        assert!(words.starts_with(&format!("parameter {name} ")), "{words}");
    }

    let add = changed(line, |l| l.compounding = Compounding::Add);
    // One part or both of a sample, one sample or two.
    let nan = Complex::new(0.0, f32::NAN);
    let infinite = Complex::new(f32::INFINITY, f32::NEG_INFINITY);
    for bad in [&[(9, nan)][..], &[(9, infinite)], &[(9, nan), (30, nan)]] {
        let mut out = vec![Complex::new(0.0, 0.0); 150];
        bad.iter().for_each(|&(index, y)| out[index] = y);
        let added = delay.line(0.0f32, &add, &record, memory, &mut out);
        assert_eq!(refused(added), "non-finite out 9");
    }
}

#[test]
fn records_are_checked_once() {
    let rf = vec![1.0; 300];
    assert_eq!(Record::new(&rf, 3).unwrap().samples(), 100);
    let of = |rf: &[f32], elements| refused(Record::new(rf, elements).map(|_| ()));
    assert_eq!(of(&rf[1..], 3), "length rf 299 for 297");
    assert_eq!(of(&[], 3), "length rf 0 for 3");
    assert_eq!(of(&rf[..2], 3), "length rf 2 for 3");
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        // Within a piece, at its ends, and in the last, shorter one.
        for index in [0, 217, 255, 256, 299] {
            let bad = changed(rf.clone(), |rf| rf[index] = value);
            assert_eq!(of(&bad, 3), format!("non-finite rf {index}"));
        }
    }
    let loud = |value| changed(rf.clone(), |rf| rf[3] = value);
    assert!(of(&loud(-1.001e29), 3).starts_with("parameter rf "));
    assert!(Record::new(&loud(-1e29), 3).is_ok());
    assert!(of(&rf, 0).starts_with("parameter elements "));
}
