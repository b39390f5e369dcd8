//! Parameters, lines and samples that are refused.

use super::*;
use crate::common::kit::*;

/// What a stage of changed parameters is refused for.
pub fn refused_name(p: IqParameters, change: fn(&mut IqParameters)) -> &'static str {
    name(IqDelay::new(changed(p, change)))
}

#[test]
fn what_is_wrong_is_named() {
    let good = parameters(10e6, 100, IqInterpolation::Cubic);
    let name = |change| refused_name(good, change);
    assert_eq!(name(|p| p.sound_speed = 0.0), "sound_speed");
    assert_eq!(name(|p| p.sampling_rate = f64::NAN), "sampling_rate");
    assert_eq!(name(|p| p.output_rate = -1.0), "output_rate");
    assert_eq!(name(|p| p.output_start = f64::INFINITY), "output_start");
    assert_eq!(name(|p| p.output_samples = 0), "output_samples");
    assert_eq!(
        name(|p| p.record_samples = MAX_SAMPLES + 1),
        "record_samples"
    );
    assert_eq!(name(|p| p.elements = 0), "elements");
    assert_eq!(name(|p| p.elements = usize::MAX), "elements");
    let demodulation = "demodulation_frequency";
    assert_eq!(name(|p| p.demodulation_frequency = f64::NAN), demodulation);
    assert_eq!(name(|p| p.demodulation_frequency = 1e14), demodulation);

    let mut iq = noise(ELEMENTS * 100, 1);
    let record = |iq: &[Complex<f32>], elements: usize| {
        Record::iq(IqSamples::Float(iq), IqLayout::Planar, elements).map(|_| ())
    };
    assert_refused(record(&iq, 0), "parameter elements ");
    assert_refused(record(&iq[1..], ELEMENTS), "length iq 2099 ");
    assert_refused(record(&[], 2), "length iq 0 ");
    iq[777].im = 2e29;
    assert_refused(record(&iq, ELEMENTS), "parameter iq ");
    iq[777].im = f32::NAN;
    assert_eq!(refused(record(&iq, ELEMENTS)), "non-finite iq 777");
    for scale in [f32::NAN, 1e25] {
        let counts = IqSamples::Counts(&[[1, 2]], scale);
        let of_scale = Record::iq(counts, IqLayout::Planar, 1);
        assert_refused(of_scale, "parameter iq scale ");
    }

    let convex = convex(ELEMENTS);
    let [line, ..] = lines(&convex);
    let iq = noise(ELEMENTS * 100, 1);
    let delay = IqDelay::new(good).unwrap();
    let of_line = |line: &ScanLine, scratch: usize, out: usize| {
        let mut out = vec![Complex::new(5.0, 6.0); out];
        let scratch = &mut vec![0.0; scratch];
        let result = delay.line(0.0f32, line, &planar(&iq), scratch, &mut out);
        assert!(out.iter().all(|y| *y == Complex::new(5.0, 6.0)));
        result.unwrap_err().to_string()
    };
    let (scratch, out) = (good.need(1).real, good.output_samples * ELEMENTS);
    assert!(of_line(&line, scratch - 1, out).starts_with("scratch"));
    assert!(of_line(&line, scratch, out + 1).starts_with("out"));
    let beyond = changed(line, |l| l.active = Active::new(1, ELEMENTS));
    assert!(of_line(&beyond, scratch, out).starts_with("active"));
    let nowhere = changed(line, |l| l.ray = Ray::new(0.0, f64::NAN, 0.0));
    assert!(of_line(&nowhere, scratch, out).starts_with("line depth"));
}

#[test]
fn a_sample_of_which_both_parts_are_too_large_is_named() {
    let mut iq = noise(ELEMENTS * 10, 1);
    iq[77] = Complex::new(-2e29, 3e29);
    let record = Record::iq(IqSamples::Float(&iq), IqLayout::Planar, ELEMENTS);
    assert_refused(record, &format!("parameter iq {}:", f64::from(-2e29f32)));
}
