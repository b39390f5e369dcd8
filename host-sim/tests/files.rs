//! Files: what is written is read back, what numpy users write is accepted, and what is wrong is
//! refused with the name of the key, the place and what would be right.

use crate::common;

use std::fs;
use std::path::Path;

use bonebeam_files::{
    AlignedData, BeamRays, ChannelData, Lines, Samples, Transmits, atomic, image,
};
use common::{Npz, channel_data_without, column_major_ramp, ramp, scalar, vector};
use ndarray::{Array1, Array2, Array3, Array4, ArrayD, Axis, arr0};
use num_complex::Complex;
use tempfile::tempdir;

fn channel_data(transmits: Transmits) -> ChannelData {
    ChannelData {
        samples: ramp().into(),
        fs: 40e6,
        t0: vec![1e-6, 2e-6],
        element_x: vec![-0.45e-3, -0.15e-3, 0.15e-3, 0.45e-3],
        element_z: None,
        element_angle: None,
        c: 1540.0,
        f0: 5e6,
        transmits,
        lens_delay: 0.0,
    }
}

/// Reads a file that must be refused, and returns the one-line error.
fn refused(path: &Path) -> String {
    let error = match common::read(path) {
        Ok(_) => panic!("{} was accepted", path.display()),
        Err(error) => error,
    };
    assert_eq!(error.exit_status(), 1);
    let message = error.to_string();
    assert!(!message.contains('\n'), "more than one line: {message}");
    assert!(
        message.starts_with(&path.display().to_string()),
        "does not name the file: {message}"
    );
    message
}

fn assert_names(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "`{part}` is not in: {message}");
    }
}

#[test]
fn channel_data_of_every_delay_law_return_as_written() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.npz");
    let laws = [
        Transmits::Focused {
            x: vec![-1e-3, 1e-3],
            focus: vec![15e-3, 16e-3],
            f_number: Some(2.8),
        },
        Transmits::Focused {
            x: vec![-1e-3, 1e-3],
            focus: vec![15e-3, 16e-3],
            f_number: None,
        },
        Transmits::Plane {
            angle: vec![-0.2, 0.2],
        },
        Transmits::Element { index: vec![0, 3] },
        Transmits::VirtualSource {
            x: vec![-1e-3, 1e-3],
            z: vec![-5e-3, 20e-3],
        },
        Transmits::Delays {
            delay: Array2::from_shape_fn((2, 4), |(t, m)| 1e-7 * (t + m) as f64),
        },
    ];
    for law in laws {
        let data = channel_data(law);
        data.write(&path).unwrap();
        assert_eq!(ChannelData::read(&path).unwrap(), data);
    }
    // Nothing but the file is left in the folder.
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

/// A convex array of four elements, 60 mm of radius.
fn curved(transmits: Transmits) -> ChannelData {
    let angle: Vec<f64> = (0..4).map(|m| (f64::from(m) - 1.5) * 5e-3).collect();
    ChannelData {
        element_x: angle.iter().map(|a| 60e-3 * a.sin()).collect(),
        element_z: Some(angle.iter().map(|a| 60e-3 * (a.cos() - 1.0)).collect()),
        element_angle: Some(angle),
        lens_delay: 0.4e-6,
        ..channel_data(transmits)
    }
}

#[test]
fn iq_frames_curved_arrays_and_a_lens_return_as_written() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.npz");
    let plane = || Transmits::Plane {
        angle: vec![-0.2, 0.2],
    };
    let iq = ramp().mapv(|v| Complex::new(v, 1.0 - v));
    let frames = |count| {
        let all = Array4::from_shape_fn((count, 2, 4, 64), |(f, t, m, n)| {
            (f * 5000 + t * 1000 + m * 100 + n) as f32
        });
        Samples::Rf(all)
    };
    for samples in [ramp().into(), Samples::iq(iq, 5.2e6), frames(3), frames(1)] {
        let data = ChannelData {
            samples,
            ..curved(plane())
        };
        data.write(&path).unwrap();
        let read = ChannelData::read(&path).unwrap();
        assert_eq!(read, data);
        assert!(!read.is_straight());
    }
    // A frame is where it lies.
    let Samples::Rf(all) = frames(3) else {
        unreachable!()
    };
    let samples = Samples::Rf(all);
    let second = samples.rf(1).unwrap();
    let Samples::Rf(all) = &samples else {
        unreachable!()
    };
    assert_eq!(second.as_ptr(), &raw const all[(1, 0, 0, 0)]);
    assert!(samples.rf(3).is_none());
}

#[test]
fn elements_that_do_not_fire_have_no_delay() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.npz");
    let delay = Array2::from_shape_fn((2, 4), |(t, m)| 1e-7 * (t + m) as f64);
    let active = Array2::from_shape_fn((2, 4), |(t, m)| m != 2 * t);
    let npz =
        || channel_data_without(&path, &["tx_angle"]).with("tx_delay", delay.clone().into_dyn());
    npz().with("tx_active", active.clone().into_dyn()).finish();
    let check = || {
        let Transmits::Delays { delay: read } = ChannelData::read(&path).unwrap().transmits else {
            panic!("another delay law")
        };
        for ((t, m), &read) in read.indexed_iter() {
            match active[(t, m)] {
                true => assert_eq!(read, delay[(t, m)]),
                false => assert!(read.is_nan()),
            }
        }
    };
    check();
    let numbers = active.mapv(|active| i32::from(active) * 3);
    npz().with("tx_active", numbers.into_dyn()).finish();
    check();
    npz()
        .with("tx_active", Array2::<i64>::zeros((2, 4)).into_dyn())
        .finish();
    assert_names(
        &refused(&path),
        &["`tx_delay`", "no element that fires", "transmit 0"],
    );
}

#[test]
fn what_is_wrong_with_geometry_or_iq_is_named() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.npz");
    let zero = |shape: &[usize]| ArrayD::<f64>::zeros(shape);
    type Case<'a> = (&'a [&'a str], &'a [(&'a str, ArrayD<f64>)], &'a [&'a str]);
    let cases: [Case<'_>; 14] = [
        (
            &[],
            &[("element_z", zero(&[3]))],
            &["`element_z` has length 3", "expected 4"],
        ),
        (
            &[],
            &[("element_z", vector(&[0.0, 0.0, 1e-3, 0.0]))],
            &["`element_x` and `element_z` put element 1", "evenly spaced"],
        ),
        (
            &[],
            &[("element_angle", vector(&[0.0, 0.0, 0.0, 15.0]))],
            &["`element_angle` is 15 at element 3", "degrees"],
        ),
        (
            &[],
            &[("lens_delay", scalar(0.5))],
            &["`lens_delay` is 0.5", "probably in µs"],
        ),
        (
            &[],
            &[("tx_source_x", zero(&[2])), ("tx_source_z", scalar(-1e-3))],
            &["several delay laws", "tx_angle, tx_source_x, tx_source_z"],
        ),
        (
            &["tx_angle"],
            &[("tx_source_x", zero(&[2]))],
            &["has no key `tx_source_z`"],
        ),
        (
            &["tx_angle"],
            &[("tx_source_x", zero(&[2])), ("tx_source_z", scalar(-20.0))],
            &["`tx_source_z` at transmit 0 is -20 m", "probably in mm"],
        ),
        (
            &["tx_angle"],
            &[("tx_delay", zero(&[4, 2]))],
            &["`tx_delay` has shape [4, 2]", "[2, 4]"],
        ),
        (
            &["tx_angle"],
            &[("tx_delay", ArrayD::from_elem(vec![2, 4], 1.5))],
            &[
                "`tx_delay` is 1.5 at transmit 0, element 0",
                "probably in µs",
            ],
        ),
        (&["rf"], &[], &["holds neither `rf` or `iq`"]),
        (
            &[],
            &[("f_demod", scalar(5e6)), ("iq", zero(&[2, 4, 64]))],
            &["holds both `rf` and `iq`"],
        ),
        (
            &["rf"],
            &[("f_demod", scalar(5e6)), ("iq", zero(&[2, 4, 64]))],
            &["`iq` has dtype", "complex64"],
        ),
        (
            &["rf"],
            &[("rf", zero(&[5, 3, 2, 4, 64]))],
            &["`rf` has shape [5, 3, 2, 4, 64]", "frame axis"],
        ),
        (
            &["rf"],
            &[("rf", zero(&[3, 2, 64, 4]))],
            &[
                "`rf` has shape [3, 2, 64, 4]",
                "fourth axis",
                "not the third",
                "[frame, transmit",
            ],
        ),
    ];
    for (without, keys, parts) in cases {
        let mut npz = channel_data_without(&path, without);
        for (key, array) in keys {
            npz = npz.with(key, array.clone());
        }
        npz.finish();
        assert_names(&refused(&path), parts);
    }
    let baseband = |f_demod: Option<f64>, iq: Complex<f32>| {
        let mut npz =
            channel_data_without(&path, &["rf"]).with("iq", ArrayD::from_elem(vec![2, 4, 64], iq));
        if let Some(f_demod) = f_demod {
            npz = npz.with("f_demod", scalar(f_demod));
        }
        npz.finish();
        refused(&path)
    };
    let one = Complex::new(1.0, 1.0);
    assert_names(&baseband(None, one), &["has no key `f_demod`"]);
    assert_names(&baseband(Some(0.0), one), &["`f_demod` is 0", "Hz"]);
    assert_names(&baseband(Some(5.2), one), &["`f_demod` is 5.2 Hz", "MHz"]);
    assert_names(
        &baseband(Some(40e6), one),
        &["`f0` is 5000000 Hz", "`f_demod` of 40000000 Hz"],
    );
    let nan = Complex::new(0.0, f32::NAN);
    assert_names(
        &baseband(Some(5e6), nan),
        &["`iq` is", "transmit 0, element 0, sample 0"],
    );
}

#[test]
fn aligned_data_and_lines_return_as_written() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.npz");
    let x = Array3::from_shape_fn((2, 5, 3), |(b, n, m)| {
        Complex::new(b as f32, (n * m) as f32)
    });
    for beam_x in [Some(vec![0.0, 1e-3]), None] {
        let delayed = AlignedData {
            x: x.clone().insert_axis(Axis(0)),
            fs: 20e6,
            t0: -1e-6,
            beam_x,
        };
        delayed.write(&path).unwrap();
        assert_eq!(AlignedData::read(&path).unwrap(), delayed);
    }
    let z = x.index_axis(Axis(2), 1).to_owned();
    let lines = Lines {
        z,
        fs: 20e6,
        t0: 1e-5,
        beam_x: vec![0.0, 1e-3],
        rays: None,
        c: 1480.0,
    };
    lines.write(&path).unwrap();
    assert_eq!(Lines::read(&path).unwrap(), lines);
    let fan = Lines {
        rays: Some(BeamRays {
            z: vec![-1e-3, -1e-3],
            angle: vec![-0.1, 0.1],
        }),
        ..lines
    };
    fan.write(&path).unwrap();
    assert_eq!(Lines::read(&path).unwrap(), fan);
}

#[test]
fn images_return_as_written() {
    let folder = tempdir().unwrap();
    let pixels = Array2::from_shape_fn((16, 8), |(r, c)| (r * 16 + c) as f32);
    for name in ["image.npy", "image.png", "image.PNG"] {
        let path = folder.path().join(name);
        image::write(&pixels, &path).unwrap();
        assert_eq!(image::read(&path).unwrap(), pixels, "{name}");
    }
}

#[test]
fn a_png_holds_the_nearest_grey_level() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("image.png");
    let pixels = Array2::from_shape_vec((1, 5), vec![-3.0, 0.4, 0.6, 254.4, 300.0]).unwrap();
    image::write(&pixels, &path).unwrap();
    let levels = image::read(&path).unwrap().into_raw_vec_and_offset().0;
    assert_eq!(levels, [0.0, 0.0, 1.0, 254.0, 255.0]);
}

#[test]
fn what_numpy_users_write_is_accepted() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.npz");
    let expected = channel_data(Transmits::Plane {
        angle: vec![-0.1, 0.1],
    });

    // 16-bit samples, as digitisers deliver them.
    let counts = ramp().mapv(|v| v as i16).into_dyn();
    channel_data_without(&path, &["rf"])
        .with("rf", counts)
        .finish();
    assert_eq!(ChannelData::read(&path).unwrap(), expected);

    // What other programs write: double precision, 32 bits, and 8 bits about 128.
    let low = |v: f32| v.rem_euclid(200.0) - 100.0;
    let mut expected_low = expected.clone();
    expected_low.samples = ramp().mapv(low).into();
    let npz = || channel_data_without(&path, &["rf"]);
    npz()
        .with("rf", ramp().mapv(|v| f64::from(low(v))).into_dyn())
        .finish();
    assert_eq!(ChannelData::read(&path).unwrap(), expected_low);
    npz()
        .with("rf", ramp().mapv(|v| low(v) as i32).into_dyn())
        .finish();
    assert_eq!(ChannelData::read(&path).unwrap(), expected_low);
    npz()
        .with("rf", ramp().mapv(|v| (low(v) + 128.0) as u8).into_dyn())
        .finish();
    assert_eq!(ChannelData::read(&path).unwrap(), expected_low);
    // A double beyond f32 is no sample.
    npz()
        .with("rf", Array3::from_elem((2, 4, 64), 1e300).into_dyn())
        .finish();
    assert_names(&refused(&path), &["`rf` is inf"]);

    // Arrays of one for scalars.
    channel_data_without(&path, &["fs", "t0"])
        .with("fs", Array2::from_elem((1, 1), 40e6).into_dyn())
        .with("t0", vector(&[1e-6]))
        .finish();
    assert_eq!(ChannelData::read(&path).unwrap().t0, [1e-6; 2]);

    // Column-major order.
    channel_data_without(&path, &["rf"])
        .with("rf", column_major_ramp())
        .finish();
    let data = ChannelData::read(&path).unwrap();
    assert!(data.samples.rf(0).unwrap().is_standard_layout());
    assert_eq!(data, expected);

    // Coordinates in f32, and numbers written without a point.
    let x = Array1::from_vec(vec![-0.45e-3f32, -0.15e-3, 0.15e-3, 0.45e-3]).into_dyn();
    channel_data_without(&path, &["element_x", "c"])
        .with("element_x", x)
        .with("c", arr0(1540i64).into_dyn())
        .finish();
    let data = ChannelData::read(&path).unwrap();
    assert_eq!(data.c, 1540.0);
    assert_eq!(data.element_x[3], f64::from(0.45e-3f32));

    // One t0 for all transmits, keys that mean nothing here.
    channel_data_without(&path, &["t0"])
        .with("t0", scalar(3e-6))
        .with("scatterers_xyz", Array2::<f64>::zeros((3, 3)).into_dyn())
        .finish();
    assert_eq!(ChannelData::read(&path).unwrap().t0, [3e-6, 3e-6]);

    // One focal depth for all transmits; transmitting elements as int32.
    channel_data_without(&path, &["tx_angle"])
        .with("tx_x", vector(&[-1e-3, 1e-3]))
        .with("tx_focus", scalar(15e-3))
        .finish();
    let focused = Transmits::Focused {
        x: vec![-1e-3, 1e-3],
        focus: vec![15e-3; 2],
        f_number: None,
    };
    assert_eq!(ChannelData::read(&path).unwrap().transmits, focused);
    channel_data_without(&path, &["tx_angle"])
        .with("tx_element", Array1::from_vec(vec![0i32, 3]).into_dyn())
        .finish();
    assert_eq!(
        ChannelData::read(&path).unwrap().transmits,
        Transmits::Element { index: vec![0, 3] }
    );

    // Every integer type there is.
    channel_data_without(&path, &["tx_angle", "c"])
        .with("tx_element", Array1::from_vec(vec![0u64, 3]).into_dyn())
        .with("c", arr0(100i8).into_dyn())
        .finish();
    let data = ChannelData::read(&path).unwrap();
    assert_eq!(data.transmits, Transmits::Element { index: vec![0, 3] });
    assert_eq!(data.c, 100.0);

    // Complex samples in double precision.
    let x = Array3::from_elem((1, 2, 3), Complex::new(0.5f64, -2.0)).into_dyn();
    Npz::create(&path)
        .with("x", x)
        .with("fs", scalar(20e6))
        .with("t0", scalar(0.0))
        .finish();
    assert_eq!(
        AlignedData::read(&path).unwrap().x[(0, 0, 1, 2)],
        Complex::new(0.5f32, -2.0)
    );
}

#[test]
fn a_missing_key_is_named() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.npz");
    for key in ["fs", "t0", "element_x", "c", "f0"] {
        channel_data_without(&path, &[key]).finish();
        assert_names(&refused(&path), &[&format!("has no key `{key}`")]);
    }
    channel_data_without(&path, &["rf"]).finish();
    assert_names(&refused(&path), &["neither `rf`", "nor `x`"]);
    channel_data_without(&path, &["tx_angle"]).finish();
    assert_names(
        &refused(&path),
        &["no delay law", "tx_angle", "tx_focus", "tx_element"],
    );
    channel_data_without(&path, &["tx_angle"])
        .with("tx_x", vector(&[0.0, 0.0]))
        .finish();
    assert_names(&refused(&path), &["has no key `tx_focus`"]);
}

#[test]
fn wrong_types_and_ranks_are_named() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.npz");
    channel_data_without(&path, &["rf"])
        .with("rf", ramp().mapv(|v| v as u16).into_dyn())
        .finish();
    assert_names(
        &refused(&path),
        &["`rf` has dtype", "u2", "expected float32, float64, int16"],
    );
    channel_data_without(&path, &["rf"])
        .with("rf", ArrayD::<f32>::zeros(vec![4, 64]))
        .finish();
    assert_names(
        &refused(&path),
        &["`rf` has shape [4, 64]", "[transmit, element, sample]"],
    );
    channel_data_without(&path, &["fs"])
        .with("fs", vector(&[40e6, 40e6]))
        .finish();
    assert_names(&refused(&path), &["`fs` has shape [2]", "scalar"]);
    let complex = arr0(Complex::new(1.0f64, 0.0)).into_dyn();
    channel_data_without(&path, &["c"])
        .with("c", complex)
        .finish();
    assert_names(&refused(&path), &["`c` has dtype", "c16", "float64"]);
    channel_data_without(&path, &["element_x"])
        .with("element_x", vector(&[0.0, 1e-3]))
        .finish();
    assert_names(
        &refused(&path),
        &["`element_x` has length 2", "expected 4", "element"],
    );
    channel_data_without(&path, &["tx_angle"])
        .with("tx_element", vector(&[0.0, 1.0]))
        .finish();
    assert_names(&refused(&path), &["`tx_element` has dtype", "integer"]);
    let real = ArrayD::<f32>::zeros(vec![1, 2, 3]);
    Npz::create(&path)
        .with("x", real)
        .with("fs", scalar(20e6))
        .with("t0", scalar(0.0))
        .finish();
    assert_names(&refused(&path), &["`x` has dtype", "complex64"]);
}

#[test]
fn impossible_values_are_named() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.npz");
    for value in [0.0, -40e6, f64::NAN, f64::INFINITY] {
        for key in ["fs", "c", "f0"] {
            channel_data_without(&path, &[key])
                .with(key, scalar(value))
                .finish();
            assert_names(
                &refused(&path),
                &[&format!("`{key}` is {value}"), "above 0"],
            );
        }
    }
    // Microseconds and megahertz.
    channel_data_without(&path, &["t0"])
        .with("t0", vector(&[0.005, 12.0]))
        .finish();
    assert_names(&refused(&path), &["`t0` is 12 at transmit 1", "seconds"]);
    channel_data_without(&path, &["fs"])
        .with("fs", scalar(40.0))
        .finish();
    assert_names(&refused(&path), &["`fs` is 40 Hz", "MHz"]);
    channel_data_without(&path, &["fs"])
        .with("fs", scalar(8e6))
        .finish();
    assert_names(
        &refused(&path),
        &["`f0` is 5000000 Hz", "half", "8000000 Hz"],
    );
    channel_data_without(&path, &["tx_angle"])
        .with("tx_element", Array1::from_vec(vec![0, u64::MAX]).into_dyn())
        .finish();
    assert_names(&refused(&path), &["`tx_element`", "transmit 1", "0 to 3"]);
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut rf = ramp();
        rf[(1, 2, 33)] = value;
        channel_data_without(&path, &["rf"])
            .with("rf", rf.into_dyn())
            .finish();
        assert_names(
            &refused(&path),
            &[
                &format!("`rf` is {value}"),
                "transmit 1, element 2, sample 33",
            ],
        );
    }
    let mut x = Array3::from_elem((2, 3, 4), Complex::new(0.0f32, 1.0));
    x[(1, 0, 2)].im = f32::NAN;
    Npz::create(&path)
        .with("x", x.into_dyn())
        .with("fs", scalar(20e6))
        .with("t0", scalar(0.0))
        .finish();
    assert_names(&refused(&path), &["`x` is", "beam 1, sample 0, element 2"]);
    channel_data_without(&path, &["element_x"])
        .with("element_x", vector(&[0.0, 1e-3, 2.5e-3, 3e-3]))
        .finish();
    assert_names(
        &refused(&path),
        &["`element_x` is 0.0025 m at element 2", "evenly spaced"],
    );
    channel_data_without(&path, &["tx_angle"])
        .with("tx_element", Array1::from_vec(vec![0i64, 4]).into_dyn())
        .finish();
    assert_names(
        &refused(&path),
        &["`tx_element` is 4 at transmit 1", "0 to 3"],
    );
    channel_data_without(&path, &["tx_angle"])
        .with("tx_angle", vector(&[0.0, 12.0]))
        .finish();
    assert_names(
        &refused(&path),
        &["`tx_angle` is 12 at transmit 1", "radians"],
    );
}

#[test]
fn empty_arrays_are_refused() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.npz");
    for shape in [vec![0, 4, 64], vec![2, 0, 64], vec![2, 4, 0]] {
        let rf = ArrayD::<f32>::zeros(shape.clone());
        let transmits = vector(&vec![0.0; shape[0]]);
        Npz::create(&path)
            .with("rf", rf)
            .with("fs", scalar(40e6))
            .with("t0", transmits.clone())
            .with(
                "element_x",
                vector(&[-1.5e-4, 1.5e-4, 4.5e-4, 7.5e-4][..shape[1]]),
            )
            .with("c", scalar(1540.0))
            .with("f0", scalar(5e6))
            .with("tx_angle", transmits)
            .finish();
        assert_names(&refused(&path), &["`rf` is empty", &format!("{shape:?}")]);
    }
}

#[test]
fn two_delay_laws_at_once_are_refused() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.npz");
    channel_data_without(&path, &[])
        .with("tx_element", Array1::from_vec(vec![0i64, 1]).into_dyn())
        .finish();
    assert_names(
        &refused(&path),
        &["several delay laws", "tx_angle, tx_element", "exactly one"],
    );
    let x = Array3::from_elem((1, 2, 3), Complex::new(0.0f32, 1.0)).into_dyn();
    channel_data_without(&path, &[]).with("x", x).finish();
    assert_names(&refused(&path), &["both `rf`", "`x`"]);
}

#[test]
fn a_truncated_or_damaged_file_is_refused_wherever_the_damage_is() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.npz");
    channel_data_without(&path, &[]).finish();
    let whole = fs::read(&path).unwrap();
    for length in [0, 1, 100, whole.len() / 2, whole.len() - 1] {
        fs::write(&path, &whole[..length]).unwrap();
        assert_names(&refused(&path), &["truncated"]);
    }
    // One flipped bit in the samples: the archive's checksum tells.
    let mut damaged = whole.clone();
    damaged[400] ^= 1;
    fs::write(&path, &damaged).unwrap();
    assert_names(&refused(&path), &["`rf`", "damaged"]);
    assert_names(
        &refused(&folder.path().join("none.npz")),
        &["cannot be opened"],
    );
}

#[test]
fn a_header_that_asks_for_more_data_than_there_are_is_refused() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("image.npy");
    image::write(&Array2::<f32>::zeros((64, 64)), &path).unwrap();
    let bytes = fs::read(&path).unwrap();
    // Behind the magic bytes and the header's length there is plain text.
    let header = std::str::from_utf8(&bytes[10..128]).unwrap();
    // A header of the same length that asks for terabytes; the padding after it has the room.
    let place = header.find("(64, 64)}         ");
    let shape = 10 + place.expect("the header as it is written today");
    let mut damaged = bytes.clone();
    damaged[shape..shape + 17].copy_from_slice(b"(64, 9999999999)}");
    fs::write(&path, &damaged).unwrap();
    let message = image::read(&path).unwrap_err().to_string();
    assert_names(&message, &["truncated", "bytes are missing"]);

    damaged[shape..shape + 17].copy_from_slice(b"(64, {{{{{{{{{{{{");
    fs::write(&path, &damaged).unwrap();
    let message = image::read(&path).unwrap_err().to_string();
    assert_names(&message, &["damaged header"]);
    assert!(!message.contains('\n'), "more than one line: {message}");
}

#[test]
fn an_output_that_cannot_be_written_is_told_beforehand_and_leaves_nothing() {
    let folder = tempdir().unwrap();
    let inside = folder.path().join("none").join("out.npz");
    let message = atomic::check_writable(&inside).unwrap_err().to_string();
    assert_names(&message, &["out.npz", "none", "does not exist"]);

    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    let message = atomic::check_writable(&file.join("out.npz"))
        .unwrap_err()
        .to_string();
    assert_names(&message, &["file", "is not a folder"]);

    let message = atomic::check_writable(folder.path())
        .unwrap_err()
        .to_string();
    assert_names(&message, &["is not a file"]);

    // A check leaves nothing behind, and an output that fails half-way neither; what was there
    // before stays as it was.
    let path = folder.path().join("out.npz");
    atomic::check_writable(&path).unwrap();
    assert!(!path.exists());
    fs::write(&path, "before").unwrap();
    let failed = atomic::write(&path, |sink| {
        std::io::Write::write_all(sink, b"half")?;
        Err("the disk is full".into())
    });
    assert_names(
        &failed.unwrap_err().to_string(),
        &["out.npz", "the disk is full"],
    );
    assert_eq!(fs::read_to_string(&path).unwrap(), "before");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn invalid_data_are_not_written() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.npz");
    let mut data = channel_data(Transmits::Plane {
        angle: vec![-0.1, 0.1],
    });
    let mut rf = ramp();
    rf[(0, 0, 0)] = f32::NAN;
    data.samples = rf.into();
    assert_names(
        &data.write(&path).unwrap_err().to_string(),
        &["`rf` is NaN"],
    );
    assert!(!path.exists());
}
