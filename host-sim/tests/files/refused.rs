//! Files that are refused, and the contents of the message.

use super::*;

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
        .with("rf", ramp().mapv(|v| v as u32).into_dyn())
        .finish();
    assert_names(
        &refused(&path),
        &[
            "`rf` has dtype",
            "u4",
            "a float type, int8, int16, int32, int64, uint16 or uint8",
        ],
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
    // Microseconds and megahertz in place of seconds and hertz.
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
    // One flipped bit in the samples: the archive's checksum fails.
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
    // A header of the same length that states terabytes; it fits into the padding.
    let position = header.find("(64, 64)}         ");
    let shape = 10 + position.expect("the header as it is written today");
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
fn an_output_that_cannot_be_written_is_reported_beforehand_and_leaves_nothing() {
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

    // A check leaves nothing behind, and neither does an output that fails half-way. Old files stay unchanged.
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
