//! Recordings without a fault have no finding; each fault is named.

#[path = "../examples/check_study/faults.rs"]
mod faults;
#[path = "../examples/check_study/scene.rs"]
mod scene;

use bonebeam_check::{Finding, Severity, check, doubt, sound_speed};
use bonebeam_files::{Samples, Transmits};
use bonebeam_simulate::{Layers, Phantom, Scatterer, Settings, Summation, Tissue, channel_data};
use faults::FAULTS;
use ndarray::Axis;
use rand::RngExt;
use scene::{Law, Medium, Scene, Shape};

fn wrong(findings: Vec<Finding>) -> Vec<Finding> {
    findings
        .into_iter()
        .filter(|finding| finding.severity > Severity::Note)
        .collect()
}

#[test]
fn each_fault_is_named_and_none_in_sound_recordings() {
    let curved = Scene {
        shape: Shape::Curved,
        ..Scene::small(Law::Element)
    };
    for scene in [Scene::small(Law::Focused), Scene::small(Law::Plane), curved] {
        let law = scene.law;
        let sound = scene.record();
        let found = wrong(check(&sound));
        assert!(found.is_empty(), "{law:?}: {found:#?}");
        let is_tried = |name: &str| law != Law::Element || name.starts_with("tx_element");
        let faults = FAULTS.iter().enumerate();
        for (index, fault) in faults.filter(|(_, fault)| is_tried(fault.name)) {
            let mut data = sound.clone();
            if (fault.put)(&mut data, &mut faults::random(7, index)) {
                let found = wrong(check(&data));
                let is_named = found
                    .iter()
                    .any(|finding| fault.named.contains(&finding.name));
                assert!(is_named, "{law:?}: {}: {found:#?}", fault.name);
            }
        }
    }
}

/// Elements 1.5 wavelengths apart, with grating lobes.
#[test]
fn faults_of_wide_elements_are_named() {
    let scene = Scene {
        pitch: 1.5,
        ..Scene::small(Law::Plane)
    };
    let sound = scene.record();
    assert_eq!(wrong(check(&sound)), Vec::new());
    let of_speed = ["sound-speed", "pitch", "time-zero", "doubled", "polarity"];
    for (index, fault) in FAULTS.iter().enumerate() {
        let mut data = sound.clone();
        if of_speed.contains(&fault.named[0])
            && (fault.put)(&mut data, &mut faults::random(7, index))
        {
            let found = wrong(check(&data));
            let is_named = found.iter().any(|found| found.name == fault.named[0]);
            assert!(is_named, "{}: {found:#?}", fault.name);
        }
    }
}

/// Three waves and a wide array: at a speed far off even neighbours disagree, and the speed is found by trying many.
#[test]
fn a_speed_far_off_is_found_by_a_wide_array() {
    let scene = Scene {
        elements: 128,
        pitch: 1.0,
        ..Scene::small(Law::Plane)
    };
    let mut data = scene.record();
    let read = [0, data.transmits.len() / 2, data.transmits.len() - 1];
    let Transmits::Plane { angle } = &mut data.transmits else {
        panic!("plane waves");
    };
    *angle = read.iter().map(|&t| angle[t]).collect();
    data.t0.truncate(read.len());
    data.samples = Samples::Rf(scene::rf(&mut data).select(Axis(1), &read));
    data.c *= 1.12;
    let found = check(&data);
    let speed = found.iter().find(|found| found.name == "sound-speed");
    let speed = speed.unwrap_or_else(|| panic!("{found:#?}"));
    assert!((speed.value.expect("m/s") - scene.c).abs() < 6.0, "{speed}");
}

/// A record that is there twice is found where its time is another's, too: I/Q and phases turn with it.
#[test]
fn doubled_records_have_any_time() {
    let mut data = Scene::small(Law::Plane).record();
    data.t0[3] += 0.13e-6;
    let Samples::Rf(rf) = &mut data.samples else {
        panic!("RF");
    };
    let before = rf.index_axis(Axis(1), 2).to_owned();
    rf.index_axis_mut(Axis(1), 3).assign(&before);
    let found = wrong(check(&data));
    assert!(found.iter().any(|f| f.name == "doubled"), "{found:#?}");
}

/// Of 64 lines 24 are read, and the list's next line is known without its record.
#[test]
fn a_shifted_list_of_many_lines_is_named() {
    let settings = Settings {
        elements: 64,
        beams: 64,
        noise: Some(-30.0),
        ..Settings::default()
    };
    let phantom = Phantom::vertebra(0.0, 18e-3).expect("a bone");
    let phantom = phantom.with_tissue(&Tissue {
        density: 20e6,
        amplitude: 1.0,
        layers: Layers::Uniform,
        x: [-13e-3, 13e-3],
        z: [3e-3, 36e-3],
        seed: 5,
    });
    let sound = channel_data(&settings, &phantom, Summation::Cells, &|_| {}).expect("a record");
    assert_eq!(wrong(check(&sound)), Vec::new());
    for by in [1, 63] {
        let mut data = sound.clone();
        let Transmits::Focused { x, .. } = &mut data.transmits else {
            panic!("focused");
        };
        x.rotate_left(by);
        let found = wrong(check(&data));
        assert!(
            found.iter().any(|f| f.name == "transmit-order"),
            "{found:#?}"
        );
    }
}

/// Delays of 35 ns make elements that send agree a little better with each other's place, but not as the others do.
#[test]
fn tissue_before_the_array_exchanges_no_transmits() {
    for seed in [620_014, 620_017] {
        let scene = Scene::draw(seed);
        assert_eq!((scene.law, scene.aberration), (Law::Element, 35e-9));
        let found = wrong(check(&scene.record()));
        assert!(found.is_empty(), "{found:#?}");
    }
}

/// A list that is shifted by one makes mirrored points a little better; the elements' own order makes them much better.
#[test]
fn mirrored_elements_are_not_taken_for_a_shifted_list() {
    let scene = Scene::draw(660_009);
    assert_eq!(
        (scene.shape, scene.law, scene.medium),
        (Shape::Curved, Law::Diverging, Medium::Points)
    );
    let reversed = &FAULTS[0];
    assert_eq!(reversed.name, "elements reversed");
    let mut data = scene.record();
    assert!((reversed.put)(&mut data, &mut faults::random(7, 0)));
    let found = wrong(check(&data));
    assert!(found.iter().any(|f| f.name == "mirrored"), "{found:#?}");
}

/// Few beams reach few elements, and the record ends before the echoes of the last ones.
#[test]
fn a_point_without_noise_blames_no_element() {
    let settings = Settings {
        beams: 5,
        first_beam: 61.0,
        noise: None,
        ..Settings::default()
    };
    let point = Phantom {
        scatterers: vec![Scatterer {
            x: 0.1e-3,
            y: 0.0,
            z: 15e-3,
            amplitude: 1.0,
        }],
        ..Phantom::default()
    };
    let data = channel_data(&settings, &point, Summation::Direct, &|_| {}).expect("a record");
    assert_eq!(wrong(check(&data)), Vec::new());
    assert_eq!(doubt(&data, &data.samples.survey()), None);
}

/// Beams of a narrow array lie near their mirrored places: most coherence is there with either.
#[test]
fn mirrored_beams_of_a_narrow_array_are_named() {
    let mut random = faults::random(9, 0);
    let settings = Settings {
        elements: 64,
        pitch: 0.1e-3,
        kerf: 0.01e-3,
        fs: 40e6,
        beams: 20,
        beam_step: 63.0 / 19.0,
        focus: 18e-3,
        noise: Some(-40.0),
        ..Settings::default()
    };
    let scatterers = (0..30).map(|_| Scatterer {
        x: random.random_range(-3.2e-3..3.2e-3),
        y: 0.0,
        z: random.random_range(6e-3..36e-3),
        amplitude: random.random_range(0.5..1.5),
    });
    let phantom = Phantom {
        scatterers: scatterers.collect(),
        ..Phantom::default()
    };
    let sound = channel_data(&settings, &phantom, Summation::Direct, &|_| {}).expect("a record");
    assert_eq!(wrong(check(&sound)), Vec::new());
    for fault in FAULTS.iter().filter(|f| f.named == ["mirrored"]) {
        let mut data = sound.clone();
        assert!((fault.put)(&mut data, &mut random));
        let found = wrong(check(&data));
        assert!(found.iter().any(|f| f.name == "mirrored"), "{found:#?}");
    }
}

#[test]
fn findings_do_not_depend_on_the_order_of_memory() {
    let mut data = Scene::small(Law::Focused).record();
    let texts = |data: &_| check(data).into_iter().map(|f| f.text).collect::<Vec<_>>();
    let found = texts(&data);
    let Samples::Rf(rf) = &mut data.samples else {
        panic!("RF");
    };
    *rf = rf.t().as_standard_layout().into_owned().reversed_axes();
    assert!(!rf.is_standard_layout());
    assert_eq!(texts(&data), found);
}

#[test]
fn the_sound_speed_is_that_of_the_scene_within_a_percent() {
    for law in [Law::Focused, Law::Plane, Law::Diverging, Law::Element] {
        let scene = Scene::small(law);
        let mut data = scene.record();
        data.c *= 0.97;
        let found = sound_speed(&data).expect("sure");
        assert!(
            (found.value - scene.c).abs() < 0.01 * scene.c,
            "{law:?}: {found:?}"
        );
    }
}

#[test]
fn a_shift_of_time_is_measured_with_its_sign() {
    let sound = Scene::small(Law::Element).record();
    for shift in [-1e-6, 1e-6] {
        let mut data = sound.clone();
        data.t0.iter_mut().for_each(|t| *t += shift);
        let found = check(&data);
        let found = found
            .iter()
            .find(|finding| finding.name == "time-zero")
            .unwrap_or_else(|| panic!("{found:#?}"));
        // The correction of t0, and the error of depth without it.
        let (value, depth) = (found.value.expect("us"), found.shift_mm.expect("mm"));
        assert!((value + 1e6 * shift).abs() < 0.1, "{found}");
        assert!((depth - 1e3 * shift * data.c / 2.0).abs() < 0.1, "{found}");
        let side = if shift < 0.0 {
            "too shallow"
        } else {
            "too deep"
        };
        assert!(found.to_string().contains(side), "{found}");
    }
}
