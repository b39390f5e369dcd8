//! The errors of the beamformer in words, before anything is put out, and its memory.

use crate::common::kit::*;
use bonebeam::beamform::{Parameters, Sizes};
use bonebeam_drive::beamform::Memory;

/// Five samples of eight elements.
fn line() -> AlignedLine<'static> {
    static X: [Complex<f32>; 40] = [Complex::ONE; 40];
    AlignedLine::new(&X, 8).expect("finite")
}

fn beamformer(change: impl FnOnce(&mut Parameters)) -> Beamformer {
    let mut parameters = Parameters::default();
    change(&mut parameters);
    Beamformer::new(parameters).expect("valid")
}

fn set(first: usize, count: usize) -> Active {
    Active::new(first, count)
}

/// `[M, L, K]`.
fn of([elements, subaperture, temporal_half_window]: [usize; 3], covariance: Covariance) -> Sizes {
    Sizes {
        covariance,
        elements,
        subaperture,
        temporal_half_window,
        sub_lines: 1,
    }
}

fn memory(sizes: [usize; 3]) -> Memory<f32> {
    Memory::new(0.0, of(sizes, Covariance::ForwardBackward)).expect("little memory")
}

/// What the beamformer says of parameters that it refuses.
fn message(parameters: Parameters) -> String {
    let refused = Beamformer::new(parameters).map(|_| ());
    refused.expect_err("out of range").to_string()
}

#[test]
fn parameters_out_of_range() {
    const NAN: f64 = f64::NAN;
    let methods: [(_, &[f64], _); 3] = [
        (
            Method::EsmvBeta(0.1),
            &[0.0, -1.0, 1.5, NAN],
            "above 0, at most 1",
        ),
        (Method::EsmvRank(1), &[0.0], "at least 1 and at most 65536"),
        (Method::EsmvRank1Steps(8), &[0.0, 65.0], "1 to 64"),
    ];
    for (method, arguments, expected) in methods {
        let name = method.parameter().expect("a row").name;
        for argument in arguments {
            let parameters = Parameters::of(method.with_argument(*argument));
            let words = format!("{name} is {argument}, expected {expected}");
            assert_eq!(message(parameters), words);
        }
    }
    let most = usize::MAX as f64;
    let numbers: [(_, &[f64]); 3] = [
        ("diagonal_loading", &[-0.05, NAN, f64::INFINITY]),
        // L is above M: the ratio is above 1.
        ("subaperture_ratio", &[1.01, 0.0, -0.5, NAN]),
        // Longer than any record: refused before a record exists.
        ("temporal_half_window", &[4096.0, most]),
    ];
    for (name, values) in numbers {
        for value in values {
            let mut parameters = Parameters::default();
            parameters.set(name, *value).expect("a row's name");
            let message = message(parameters);
            assert!(message.starts_with(&format!("{name} is ")), "{message}");
        }
    }
    for sub_lines in [0, 3, 33, 64, usize::MAX] {
        let parameters = changed(Parameters::default(), |p| p.sub_lines = sub_lines);
        let words = format!(
            "sub_lines is {}, expected 1, 2, 4, 8, 16 or 32",
            sub_lines as f64
        );
        assert_eq!(message(parameters), words);
    }
    beamformer(|p| p.temporal_half_window = 4095);
}

#[test]
fn lines_that_are_empty_or_ragged() {
    let x = [Complex::ONE; 7];
    assert_refused(AlignedLine::new(&x, 0), "parameter elements 0");
    assert_refused(AlignedLine::new(&[], 4), "length aligned samples 0 for 4");
    // Less than one sample: the error expects one sample.
    for elements in [4, 8, usize::MAX] {
        let words = format!("length aligned samples 7 for {elements}");
        assert_refused(AlignedLine::new(&x, elements), &words);
    }
}

#[test]
fn a_subaperture_is_never_longer_than_its_aperture() {
    let beamformer = beamformer(|p| p.subaperture_ratio = 1.0);
    let most = usize::MAX;
    for count in [1, 2, (1 << 53) + 1, most / 2, most - 1, most] {
        let length = beamformer.subaperture(count);
        assert!(length >= 1 && length <= count, "{count}: {length}");
    }
}

/// Through a workspace for 6 elements, L = 4 and K = 1; nothing is put out.
#[test]
fn what_does_not_fit() {
    type Change = fn(&mut Parameters);
    type Aperture = fn(usize) -> Active;
    let run = |change: Change, active: Aperture, length: usize| {
        let mut z = vec![Complex::I; length];
        let done = beamformer(change).line(&mut memory([6, 4, 1]).view(), line(), active, &mut z);
        assert!(done.is_ok() || z.iter().all(|z| *z == Complex::I));
        done
    };
    assert_eq!(
        run(|p| p.temporal_half_window = 1, |_| set(0, 6), 5),
        Ok(())
    );
    for (change, words) in [
        (
            (|p| p.temporal_half_window = 2) as Change,
            "capacity temporal_half_window 2 over 1",
        ),
        // Longer than the record.
        (
            |p| p.temporal_half_window = 5,
            "parameter temporal_half_window 5",
        ),
        (
            |p| p.subaperture_ratio = 1.0,
            "capacity subaperture 6 over 4",
        ),
    ] {
        assert_refused(run(change, |_| set(0, 6), 5), words);
    }
    let rows: [(Aperture, usize, &str); 6] = [
        (|_| set(0, 6), 4, "length z 4 for 5"),
        (|_| set(0, 7), 5, "capacity active elements 7 over 6"),
        (|_| set(3, 6), 5, "parameter first element "),
        (|_| set(usize::MAX, 2), 5, "parameter first element "),
        // The last sample alone.
        (
            |n| set(0, if n == 4 { 7 } else { 6 }),
            5,
            "capacity active elements 7 over 6",
        ),
        (
            |n| if n == 4 { set(4, 5) } else { set(0, 6) },
            5,
            "parameter first element ",
        ),
    ];
    for (active, length, words) in rows {
        assert_refused(run(|_| {}, active, length), words);
    }
}

#[test]
fn segments_that_do_not_fit() {
    let mut workspace = memory([8, 4, 0]);
    let at = |first_sample| Segment::new(line(), 0, first_sample);
    let mut run = |segments: &[Segment<'_>], z: &mut [&mut [Complex<f32>]]| {
        beamformer(|_| {}).segments(&mut workspace.view(), segments, 8, z)
    };
    let mut z = [Complex::I; 5];
    for first in [4, 5, 6, usize::MAX] {
        assert_refused(
            run(&[at(first)], &mut [&mut z[..2]]),
            "parameter first sample ",
        );
    }
    assert_refused(
        run(&[at(0); 2], &mut [&mut z, &mut []]),
        "capacity segments 2 over 1",
    );
    assert_refused(run(&[at(0)], &mut []), "length z 0 for 1");
    assert_eq!(z, [Complex::I; 5]);
    // A segment of no samples ends with its line.
    assert_eq!(run(&[at(5)], &mut [&mut []]), Ok(()));
    // K is refused without segments, too.
    for window in [1, 100, 4095] {
        let beamformer = beamformer(|p| p.temporal_half_window = window);
        let none = beamformer.segments(&mut memory([6, 4, 0]).view(), &[], 4, &mut []);
        assert_refused(
            none,
            &format!("capacity temporal_half_window {window} over 0"),
        );
    }
}

#[test]
fn the_host_names_beam_sample_and_element() {
    let mut x = Array3::from_elem((3, 4, 5), Complex::ONE);
    x[[1, 2, 3]].im = f32::NAN;
    let beamform = bonebeam_drive::beamform::beamform;
    let refused = beamform(x.view(), &|_, _| set(0, 5), Parameters::default(), &|_| {});
    let error = refused.expect_err("a NaN sample");
    assert_eq!(error.exit_status(), 1);
    let words = "aligned sample [beam 1, sample 2, element 3] is NaN or infinite";
    assert_eq!(error.to_string(), words);
}

/// With one active set; each change of the set costs one more call a pass.
#[test]
fn each_sample_is_asked_twice_for_its_active_set() {
    let asked = [const { std::cell::Cell::new(0) }; 5];
    let all = |n: usize| {
        asked[n].set(asked[n].get() + 1);
        set(0, 8)
    };
    let mut z = [Complex::ZERO; 5];
    let done = beamformer(|_| {}).line(&mut memory([8, 4, 0]).view(), line(), all, &mut z);
    assert_eq!((done, asked.map(|asked| asked.get())), (Ok(()), [2; 5]));
}

#[test]
fn memory_is_what_the_documentation_says() {
    let (both, forward) = (Covariance::ForwardBackward, Covariance::Forward);
    for (sizes, covariance, lag_sums, basis) in [
        ([4, 4, 0], both, 6, 0),
        // With L = 8 the Lanczos basis is longer than a factor.
        ([16, 8, 2], both, 20, 8),
        ([32, 16, 2], both, 72, 0),
        ([128, 64, 10], both, 32 * 33, 0),
        ([7, 4, 0], forward, 10, 0),
        ([33, 20, 3], forward, 210, 0),
        ([256, 128, 10], forward, 64 * 129, 0),
    ] {
        let [m, l, k] = sizes;
        let windows = if k == 0 { 1 } else { 2 * k + 2 };
        let scalars = l * l + 10 * l + basis;
        let mut expected = Need::new(5 * l, m + (5 + k) * l + windows * lag_sums);
        match covariance {
            Covariance::Forward => expected.complex += scalars,
            Covariance::ForwardBackward => expected.real += scalars,
        }
        assert_eq!(of(sizes, covariance).need(), expected);
    }
}

#[test]
fn slices_that_are_too_short() {
    let sizes = of([6, 3, 1], Covariance::Forward);
    let need = sizes.need();
    for (by, words) in [
        ((1, 0), "length real memory "),
        ((0, 1), "length complex memory "),
    ] {
        let scratch = Scratch {
            real: &mut vec![0.0; need.real - by.0],
            complex: &mut vec![Complex::ZERO; need.complex - by.1],
        };
        assert_refused(Workspace::new(0.0, sizes, scratch), words);
    }
}

#[test]
fn sizes_that_no_memory_has() {
    let most = usize::MAX;
    for sizes in [
        [most, 4, 0],
        [4, most, 0],
        [4, 4, most],
        [most; 3],
        [1 << 40; 3],
    ] {
        for covariance in COVARIANCES {
            let sizes = of(sizes, covariance);
            let need = sizes.need();
            assert!(need.complex >= 1 << 40, "{sizes:?}: {need:?}");
            let refused = Memory::new(0.0, sizes);
            let error = refused.err().expect("more than there is");
            assert_eq!(error.exit_status(), 2, "{error}");
            assert!(
                error.to_string().contains("temporal_half_window"),
                "{error}"
            );
        }
    }
}

#[test]
fn a_workspace_of_another_covariance_is_refused() {
    let [one, other] = COVARIANCES;
    for (covariance, other) in [(one, other), (other, one)] {
        let mut memory = Memory::new(0.0, of([8, 4, 0], other)).expect("little memory");
        let beamformer = beamformer(|p| p.covariance = covariance);
        let mut z = [Complex::I; 5];
        let done = beamformer.line(&mut memory.view(), line(), |_| set(0, 8), &mut z);
        let value = covariance as u8;
        assert_refused(
            done,
            &format!("parameter covariance {value}: that of the workspace"),
        );
        assert_eq!(z, [Complex::I; 5]);
    }
}

#[test]
fn das_and_samples_without_an_active_element_need_no_memory() {
    let mut memory = memory([0; 3]);
    let mut view = memory.view();
    let das = beamformer(|p| p.method = Method::Das);
    let sub_lines = 1;
    assert_eq!(
        das.sizes(8),
        changed(Sizes::default(), |s| s.sub_lines = sub_lines)
    );
    let mut z = [Complex::I; 5];
    assert_eq!(das.line(&mut view, line(), |_| set(0, 8), &mut z), Ok(()));
    assert_eq!(z, [Complex::ONE; 5]);
    let mut weights = [Complex::ZERO; 8];
    let segment = Segment::new(line(), 0, 2);
    assert_eq!(das.weights(&mut view, &segment, 8, &mut weights), Ok(8));
    assert_eq!(weights, [Complex::new(0.125, 0.0); 8]);
    let mv = beamformer(|p| p.temporal_half_window = 1);
    let refused = beamformer(|_| {}).line(&mut view, line(), |_| set(0, 8), &mut z);
    assert_refused(refused, "capacity active elements 8 over 0");
    // For any start of the empty set.
    for first in [0, 8] {
        let none = |_| set(first, 0);
        z = [Complex::I; 5];
        assert_eq!(mv.line(&mut view, line(), none, &mut z), Ok(()));
        assert_eq!(z, [Complex::ZERO; 5]);
        z = [Complex::I; 5];
        assert_eq!(
            mv.line_within(&mut view, line(), none, 1..4, &mut z),
            Ok(())
        );
        assert_eq!(z, [Complex::ZERO; 5]);
    }
}
