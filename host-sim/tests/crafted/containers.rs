//! MATLAB and HDF5 files, and files with a changed byte.

use super::*;

/// A MATLAB file of version 5 with these elements.
fn mat5(elements: &[u8]) -> Vec<u8> {
    let mut bytes = b"MATLAB 5.0 MAT-file, written by a test".to_vec();
    bytes.resize(124, b' ');
    bytes.extend([0, 1, b'I', b'M']);
    bytes.extend(elements);
    bytes
}

/// An element of a MATLAB file: its type, its bytes, and the excess of its length.
fn element(kind: u32, contents: &[u8], more: u32) -> Vec<u8> {
    let mut bytes = kind.to_le_bytes().to_vec();
    bytes.extend((contents.len() as u32 + more).to_le_bytes());
    bytes.extend(contents);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    bytes
}

/// An array of doubles: its sides, its numbers, and the excess of its length.
fn mat5_array(name: &str, sides: &[i32], numbers: &[u8], more: u32) -> Vec<u8> {
    const DOUBLE: u32 = 6;
    let flags: Vec<u8> = [DOUBLE, 0].into_iter().flat_map(u32::to_le_bytes).collect();
    let sides: Vec<u8> = sides.iter().flat_map(|side| side.to_le_bytes()).collect();
    let mut contents = element(6, &flags, 0);
    contents.extend(element(5, &sides, 0));
    contents.extend(element(1, name.as_bytes(), 0));
    contents.extend(element(9, numbers, more));
    element(14, &contents, 0)
}

/// The same array, deflated as MATLAB does.
fn deflated(array: &[u8]) -> Vec<u8> {
    let mut deflated = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    deflated.write_all(array).unwrap();
    let contents = deflated.finish().unwrap();
    let mut bytes = 15u32.to_le_bytes().to_vec();
    bytes.extend((contents.len() as u32).to_le_bytes());
    bytes.extend(contents);
    bytes
}

#[test]
fn matlab_files_that_claim_more_than_they_hold() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.mat");
    let beamform = "beamform data.mat -o lines.npz --variable tx_angle=0 --variable fs=40e6 \
         --variable f0=5e6 --variable c=1540 --variable t0=0 --variable pitch=0.3e-3";
    let eight = [0; 64];
    let bomb = mat5_array("rf", &[1, 8, 4_000_000], &vec![0; 8 * 8 * 4_000_000], 0);
    for (elements, part) in [
        (mat5_array("rf", &[1, 8, 1], &eight, 1 << 30), "rf"),
        (mat5_array("rf", &[65_536, 65_536, 8], &[], 0), "rf"),
        (mat5_array("rf", &[1, -8, -1], &eight, 0), "rf"),
        (mat5_array("rf", &[i32::MAX, i32::MAX, 2], &eight, 0), "rf"),
        (mat5_array("rf", &[0, 8, 1], &[], 0), "rf"),
        (element(14, &[0; 64], 1 << 31), "truncated"),
        (element(15, b"no zlib stream", 0), "damaged"),
        (element(14, &[0xff; 40], 0), "has no `rf` or `iq`"),
        (deflated(&bomb), "claims"),
        (deflated(&bomb[..60]), "`rf`"),
        (Vec::new(), "has no `rf` or `iq`"),
    ] {
        fs::write(&path, mat5(&elements)).unwrap();
        refused(&folder, beamform, DATA, &["data.mat", part]);
    }
}

/// HDF5 with the keys of channel data; `make` makes one of them.
fn hdf5(path: &Path, make: impl FnOnce(&rust_hdf5::H5File)) {
    let file = rust_hdf5::H5File::create(path).unwrap();
    let numbers = |name: &str, values: &[f64]| {
        let dataset = file.new_dataset::<f64>().shape([values.len()]);
        dataset.create(name).unwrap().write_raw(values).unwrap();
    };
    for (name, value) in [("fs", 40e6), ("f0", 5e6), ("c", 1540.0), ("t0", 0.0)] {
        numbers(name, &[value]);
    }
    numbers("tx_angle", &[0.0]);
    let x: Vec<f64> = (0..8).map(|m| f64::from(m) * 0.3e-3).collect();
    numbers("element_x", &x);
    make(&file);
    file.close().unwrap();
}

fn small_rf(file: &rust_hdf5::H5File) {
    let rf: Vec<f32> = (0..8 * 300).map(|n| (n % 37) as f32).collect();
    let dataset = file.new_dataset::<f32>().shape([1usize, 8, 300]);
    let dataset = dataset.chunk(&[1, 4, 100]).shuffle_deflate(4);
    let dataset = dataset.create("rf").unwrap();
    dataset.write_raw(&rf).unwrap();
}

/// Events and waves of UFF 0.3 are others than USTB's; its arrays can be named.
#[test]
fn files_of_uff_0_3_name_the_flags_that_open_them() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.h5");
    let group = "channel_data";
    let rate = format!("{group}/unique_events/00000001/receive_setup");
    let file = rust_hdf5::H5File::create(&path).unwrap();
    for (k, _) in rate.match_indices('/').chain([(rate.len(), "")]) {
        file.create_group(&rate[..k]).unwrap();
    }
    let numbers = |name: String, shape: &[usize], values: &[f64]| {
        let dataset = file.new_dataset::<f64>().shape(shape);
        dataset.create(&name).unwrap().write_raw(values).unwrap();
    };
    let rf: Vec<f64> = (0..8 * 300).map(|n| f64::from(n % 37)).collect();
    numbers(format!("{group}/data_real"), &[1, 1, 8, 300], &rf);
    numbers(format!("{rate}/sampling_frequency"), &[1], &[40e6]);
    numbers(format!("{group}/sound_speed"), &[1], &[1540.0]);
    file.close().unwrap();
    let message = folder.ends("info data.h5", 1, "UFF of version 0.3");
    // The flags of the message, with numbers for what the file lacks.
    let flags = message
        .split("the rest: ")
        .nth(1)
        .unwrap()
        .split(", or")
        .next()
        .unwrap();
    let flags = ["HZ=5e6", "METRES=0.3e-3", "SECONDS=0", "RADIANS=0"]
        .iter()
        .fold(flags.to_owned(), |flags, pair| {
            let (word, number) = pair.split_once('=').unwrap();
            flags.replace(&format!("={word}"), &format!("={number}"))
        });
    folder.works(&format!("beamform data.h5 -o lines.npz {flags}"));
}

#[test]
fn hdf5_files_that_claim_more_than_they_hold() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.h5");
    let beamform = "beamform data.h5 -o lines.npz";
    for chunk in [[1usize, 8, 1 << 20], [1, 1, 1 << 30]] {
        hdf5(&path, |file| {
            let dataset = file.new_dataset::<f32>().shape([1usize, 8, 1 << 40]);
            dataset.chunk(&chunk).create("rf").unwrap();
        });
        refused(&folder, beamform, DATA, &["data.h5", "`rf` claims"]);
    }
    hdf5(&path, |file| {
        let dataset = file.new_dataset::<f32>().shape([1usize, 8]);
        dataset.create("rf").unwrap();
    });
    refused(&folder, beamform, DATA, &["data.h5", "shape [1, 8]"]);
    // The rank of f32, with strings as numbers.
    hdf5(&path, |file| {
        file.write_vlen_strings("rf", &["no", "numbers"]).unwrap();
    });
    refused(&folder, beamform, DATA, &["data.h5", "`rf`", "numbers"]);
    hdf5(&path, |file| {
        file.create_soft_link("rf", "/rf").unwrap();
    });
    refused(&folder, beamform, DATA, &["data.h5", "rf"]);
}

/// Whatever leads out of the file is refused, by any way within the file.
#[test]
fn hdf5_files_that_lead_out_of_the_file() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.h5");
    let secret = folder.path().join("secret.h5");
    hdf5(&secret, small_rf);
    // Soft links, and the last link with its target; `x` is a group, `y` is `x`.
    type Links = [[&'static str; 2]];
    let ways: [(&Links, [&str; 2]); 7] = [
        (&[], ["rf", "/rf"]),
        (&[["rf", "/out"]], ["out", "/rf"]),
        (&[["rf", "/a"], ["a", "./b"], ["b", "/out"]], ["out", "/rf"]),
        (&[["rf", "/out/rf"]], ["out", "/"]),
        (&[["rf", "a/rf"], ["a", "/out"]], ["out", "/"]),
        (&[["rf", "/x/out/rf"]], ["x/out", "/"]),
        (&[["rf", "/y/a"], ["x/a", "/y/out/rf"]], ["x/out", "/"]),
    ];
    for (links, [out, end]) in ways {
        hdf5(&path, |file| {
            file.create_group("x").unwrap();
            file.root_group().link("y", "/x").unwrap();
            let at = |name: &str| match name.strip_prefix("x/") {
                Some(name) => (file.root_group().group("x").unwrap(), name.to_owned()),
                None => (file.root_group(), name.to_owned()),
            };
            for [name, to] in links {
                let (group, name) = at(name);
                group.create_soft_link(&name, to).unwrap();
            }
            let (group, name) = at(out);
            group.create_external_link(&name, "secret.h5", end).unwrap();
        });
        for command in [
            "info data.h5",
            "convert data.h5 -o data.npz",
            "beamform data.h5 -o lines.npz",
        ] {
            refused(&folder, command, DATA, &["data.h5", "`rf`", "another file"]);
        }
    }
    // Links within the file are followed, but not in circles.
    for (to, is_read) in [("/own", true), ("/y/own", true), ("/z", false)] {
        hdf5(&path, |file| {
            small_rf(file);
            file.root_group().link("own", "/rf").unwrap();
            let group = file.create_group("x").unwrap();
            group.link("own", "/rf").unwrap();
            file.root_group().link("y", "/x").unwrap();
            file.create_soft_link("z", "/w").unwrap();
            file.create_soft_link("w", "z").unwrap();
            file.create_soft_link("way", to).unwrap();
        });
        let arguments = "info data.h5 --variable rf=way";
        match is_read {
            true => assert_eq!(common::program::run(&folder, arguments).0, 0, "{to}"),
            false => refused(
                &folder,
                arguments,
                DATA,
                &["data.h5", "`way`", "not followed"],
            ),
        }
    }
}

/// A large file without a table of contents at its end is refused at once.
#[test]
fn a_large_file_that_is_no_archive() {
    let folder = tempdir().unwrap();
    let mut file = fs::File::create(folder.path().join("data.npz")).unwrap();
    file.write_all(b"PK\x03\x04").unwrap();
    file.set_len(20 << 30).unwrap();
    refused(
        &folder,
        "info data.npz",
        DATA,
        &["data.npz", "not an .npz archive", "at its end"],
    );
}

/// A file with any changed byte or any end is read or refused, without a panic.
#[test]
fn changed_files_are_read_or_refused() {
    let folder = tempdir().unwrap();
    let changed = folder.path().join("changed");
    let whole = folder.path().join("data.h5");
    hdf5(&whole, small_rf);
    assert!(common::read(&whole).is_ok());
    let numbers: Vec<u8> = (0..8 * 300)
        .flat_map(|n| f64::from(n % 37).to_le_bytes())
        .collect();
    let array = mat5_array("rf", &[1, 8, 300], &numbers, 0);
    let files = [
        fs::read(&whole).unwrap(),
        mat5(&array),
        mat5(&deflated(&array)),
    ];
    // A linear congruential generator: the same changes in every run.
    let mut state = 1u64;
    let mut random = |below: usize| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 33) as usize % below
    };
    let mut refused = 0;
    for bytes in &files {
        for round in 0..400 {
            let mut bytes = bytes.clone();
            if round % 4 == 0 {
                bytes.truncate(random(bytes.len()));
            }
            for _ in 0..1 + round % 3 {
                let position = random(bytes.len().max(1));
                if let Some(byte) = bytes.get_mut(position) {
                    *byte = [0, 0xff, 0x7f, *byte ^ 1 << random(8)][random(4)];
                }
            }
            fs::write(&changed, &bytes).unwrap();
            refused += usize::from(common::read(&changed).is_err());
        }
    }
    assert!(refused > 400, "only {refused} were refused");
}
