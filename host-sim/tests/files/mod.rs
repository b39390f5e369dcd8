//! Files: written files are read back, and files of numpy users are accepted.
//!
//! An invalid file is refused with the name of the key, the position and the valid values.

mod refused;

use crate::common;
use crate::common::changed;
use std::fs;
use std::path::Path;

use bonebeam_files::{
    AlignedData, BeamRays, BeamformedLines, ChannelData, Samples, Transmits, atomic, image,
};
use common::{Npz, channel_data_without, column_major_ramp, ramp, scalar, vector};
use ndarray::{Array1, Array2, Array3, Array4, Axis, arr0};
use num_complex::Complex;
use tempfile::tempdir;

fn channel_data(transmits: Transmits) -> ChannelData {
    ChannelData {
        t0: vec![1e-6, 2e-6],
        ..ChannelData::linear(
            ramp(),
            vec![-0.45e-3, -0.15e-3, 0.15e-3, 0.45e-3],
            transmits,
            ([40e6, 5e6], 1540.0),
        )
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
    // The file alone is left in the folder.
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

/// A convex array of four elements with a radius of 60 mm.
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
        let data = changed(curved(plane()), |s| s.samples = samples);
        data.write(&path).unwrap();
        let read = ChannelData::read(&path).unwrap();
        assert_eq!(read, data);
        assert!(!read.is_straight());
    }
    // A frame is a view of the file's samples.
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
    let lines = BeamformedLines::straight(z, vec![0.0, 1e-3], [20e6, 1e-5, 1480.0]);
    lines.write(&path).unwrap();
    assert_eq!(BeamformedLines::read(&path).unwrap(), lines);
    let fan = BeamformedLines {
        rays: Some(BeamRays {
            z: vec![-1e-3, -1e-3],
            angle: vec![-0.1, 0.1],
        }),
        ..lines
    };
    fan.write(&path).unwrap();
    assert_eq!(BeamformedLines::read(&path).unwrap(), fan);
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

    // Formats of other programs: double precision, 32 bits, and 8 bits about 128.
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
    // A double beyond f32 is not a valid sample.
    npz()
        .with("rf", Array3::from_elem((2, 4, 64), 1e300).into_dyn())
        .finish();
    assert_names(&refused(&path), &["`rf` is inf"]);

    // Arrays of length 1 for scalars.
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

    // One t0 for all transmits; unknown keys.
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
    let focused = Transmits::focused(vec![-1e-3, 1e-3], 15e-3);
    assert_eq!(ChannelData::read(&path).unwrap().transmits, focused);
    channel_data_without(&path, &["tx_angle"])
        .with("tx_element", Array1::from_vec(vec![0i32, 3]).into_dyn())
        .finish();
    assert_eq!(
        ChannelData::read(&path).unwrap().transmits,
        Transmits::Element { index: vec![0, 3] }
    );

    // Every integer type.
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
