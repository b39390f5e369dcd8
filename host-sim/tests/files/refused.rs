//! Files that are refused, and the contents of the message.

use super::*;

#[test]
fn swapped_axes_of_frames_are_named() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.npz");
    let frames = Array4::<f64>::zeros((3, 2, 64, 4)).into_dyn();
    channel_data_without(&path, &["rf"])
        .with("rf", frames)
        .finish();
    let parts = [
        "`rf` has shape [3, 2, 64, 4]",
        "fourth axis",
        "not the third",
        "[frame, transmit",
    ];
    assert_names(&refused(&path), &parts);
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
