//! Images, bone maps and figures.

use super::*;

#[test]
fn an_image_has_the_size_and_the_depths_asked_for() {
    let folder = folder_of_a_point();
    // 10 mm down from 6 mm and 8 mm across, at 0.1 mm a pixel. The point is 5.234 mm below the top and 1.35 mm to the
    // right of the middle.
    let command = "beamform data.npz -o lines.npz --method das --depth-start 0.006 \
                   --image image.npy --rows 101 --columns 81 --depth 0.016 --width 0.008";
    folder.works(command);
    let pixels = folder.image("image.npy");
    assert_eq!(pixels.dim(), (101, 81));
    let (mut best, mut position) = (0.0, (0, 0));
    for (at, &level) in pixels.indexed_iter() {
        if level > best {
            (best, position) = (level, at);
        }
    }
    // Half a line is 1.5 pixels; a depth sample is 0.4 pixels.
    assert!(
        position.0.abs_diff(52) <= 1 && position.1.abs_diff(53) <= 2,
        "{position:?}"
    );
}

/// The map of `beamform` is that of `phase-symmetry` of the f32 image.
///
/// The rounded picture would differ.
#[test]
fn a_bone_map_is_the_phase_symmetry_of_the_image() {
    let folder = folder_of_a_point();
    let beamform = "beamform data.npz -o lines.npz --method das";
    let filter = "--scales 2^-3,2^-4 --threshold 5";
    for (size, flags) in [
        ("--rows 64 --columns 64", filter.to_owned()),
        ("--rows 70 --columns 90", format!("{filter} --pad")),
        (
            "--rows 70 --columns 90",
            format!("{filter} --resize 64x128"),
        ),
    ] {
        let command = format!("{beamform} --image image.npy {size} --bone-map map.npy {flags}");
        folder.works(&command);
        folder.works(&format!("{beamform} {size} --bone-map map.png {flags}"));
        let command = format!("phase-symmetry image.npy -o ps.npy --image ps.png {flags}");
        folder.works(&command);
        assert!(
            folder.bytes("map.npy") == folder.bytes("ps.npy"),
            "{size} {flags}"
        );
        assert!(
            folder.bytes("map.png") == folder.bytes("ps.png"),
            "{size} {flags}"
        );
        let map = folder.image("map.npy");
        assert!(map.iter().any(|&symmetry| symmetry > 0.1), "{size} {flags}");
    }
    image::write(&folder.image("image.npy"), &folder.path().join("image.png")).unwrap();
    folder.works("phase-symmetry image.png -o rounded.npy --config lines.npz.config.toml");
    assert!(folder.bytes("rounded.npy") != folder.bytes("map.npy"));
    let again =
        "beamform data.npz -o lines.npz --bone-map again.npy --config lines.npz.config.toml";
    folder.works(again);
    assert!(folder.bytes("again.npy") == folder.bytes("map.npy"));
    // An image without a requested size is padded.
    folder.works("beamform data.npz -o own.npz --image own.npy --bone-map own-map.npy");
    folder.works("phase-symmetry own.npy -o own-ps.npy --pad");
    assert!(folder.bytes("own-map.npy") == folder.bytes("own-ps.npy"));
}

/// Wavelengths are scales by the size of a pixel, and noise gives a threshold, in both commands.
#[test]
fn a_bone_map_by_wavelengths_and_the_images_noise() {
    let folder = folder_of_a_point();
    let wavelengths = "--pixel-size 0.0001 --wavelengths 0.0004,0.0008";
    let beamform = "beamform data.npz -o lines.npz --method das --image image.npy";
    folder.works(&format!(
        "{beamform} --bone-map map.npy {wavelengths} --noise-deviations 2"
    ));
    let filter = "phase-symmetry image.npy --pad";
    folder.works(&format!(
        "{filter} {wavelengths} --noise-deviations 2 -o ps.npy"
    ));
    assert!(folder.image("map.npy") == folder.image("ps.npy"));
    folder.works(&format!(
        "{filter} --scales 0.25,0.125 --noise-deviations 2 -o scales.npy"
    ));
    assert!(folder.image("map.npy") == folder.image("scales.npy"));
    folder.works(&format!(
        "{filter} {wavelengths} --noise-deviations 2 --noise-by-direction -o own.npy"
    ));
    assert!(folder.image("own.npy") != folder.image("ps.npy"));
    // The written configuration repeats the run; --scales and --threshold replace its keys.
    folder.works("phase-symmetry image.npy --config own.npy.config.toml -o again.npy");
    assert!(folder.image("again.npy") == folder.image("own.npy"));
    let plain = "--scales 0.25,0.125 --threshold 5";
    folder.works(&format!(
        "phase-symmetry image.npy --config own.npy.config.toml {plain} -o a.npy"
    ));
    folder.works(&format!("{filter} {plain} -o b.npy"));
    assert!(folder.image("a.npy") == folder.image("b.npy"));
}

#[test]
fn a_figure_has_axes_in_mm_and_the_image_in_it() {
    let folder = folder_of_a_point();
    let beamform = "beamform data.npz -o lines.npz --method das --depth-start 0.006 --depth 0.016 \
                    --dynamic-range 50";
    folder.works(&format!("{beamform} --image figure.svg"));
    folder.works(&format!("{beamform} --image image.png"));
    let figure = folder.text("figure.svg");
    for part in [
        "lateral, mm",
        "depth, mm",
        ">\n8\n</text>",
        ">\n-50\n</text>",
        "dB",
    ] {
        assert!(figure.contains(part), "no {part:?} in {figure:.3000}");
    }
    // Its pixels are those of the picture without axes.
    let (_, data) = figure.split_once("data:image/png;base64,").unwrap();
    let (data, _) = data.split_once('"').unwrap();
    let bytes = STANDARD.decode(data).unwrap();
    assert!(bytes == folder.bytes("image.png"));
}

#[test]
fn phase_symmetry_marks_a_ridge_alike_for_every_strip() {
    let folder = tempdir().unwrap();
    // A bright line across a grey image, off the middle.
    let picture = Array2::from_shape_fn((128, 64), |(row, _)| {
        let d = (row as f32 - 40.0) / 3.0;
        30.0 + 200.0 * (-d * d).exp()
    });
    image::write(&picture, &folder.path().join("image.npy")).unwrap();
    let command = "phase-symmetry image.npy --scales 2^-4,2^-5 --threshold 5";
    folder.works(&format!("{command} -o all.npy --strip 128 --image all.png"));
    let map = folder.image("all.npy");
    assert_eq!(map.dim(), (128, 64));
    assert!(map.iter().all(|&v| (0.0..1.0).contains(&v)));
    let brightest_row = |map: &Array2<f32>| {
        let rows = map.outer_iter().map(|row| row[10]).enumerate();
        rows.fold(
            (0, 0.0),
            |best, (row, v)| if v > best.1 { (row, v) } else { best },
        )
    };
    let (row, value) = brightest_row(&map);
    assert!(row == 40 && value > 0.0, "row {row}, {value}");
    let (row, level) = brightest_row(&folder.image("all.png"));
    assert_eq!((row, level), (40, 255.0));

    for strip in [1, 7, 64] {
        folder.works(&format!("{command} -o strip.npy --strip {strip}"));
        assert!(
            folder.bytes("strip.npy") == folder.bytes("all.npy"),
            "strip {strip}"
        );
    }
    folder.works("phase-symmetry image.npy -o again.npy --config all.npy.config.toml");
    assert!(folder.bytes("again.npy") == folder.bytes("all.npy"));
    folder.works("phase-symmetry image.npy -o small.npy --resize 64x128");
    assert_eq!(folder.image("small.npy").dim(), (64, 128));
}

/// Another measure of the map changes no surface, which has short-lag coherence.
#[test]
fn a_map_of_the_largest_eigenvalue_beside_the_surface() {
    let folder = folder_of_a_point();
    let beamform = "beamform data.npz --method das -o lines.npz";
    folder.works(&format!("{beamform} --surface a.csv --coherence short.npy"));
    let own = "--coherence own.npy --coherence-of largest-eigenvalue";
    folder.works(&format!("{beamform} --surface b.csv {own}"));
    assert!(folder.bytes("a.csv") == folder.bytes("b.csv"));
    assert_eq!(
        folder.image("own.npy").dim(),
        folder.image("short.npy").dim()
    );
    // Silence has 0, all else at least 1 over the elements.
    let least = 1.0 / 128.0;
    let within = |share: &f32| *share == 0.0 || (least..=1.0).contains(share);
    assert!(folder.image("own.npy").iter().all(within));
    assert!(folder.image("own.npy").iter().any(|share| *share > 0.9));
}

/// Both commands choose the same scales, tell them, and write them down.
#[test]
fn a_bone_map_with_scales_from_the_image() {
    let folder = folder_of_a_point();
    let beamform = "beamform data.npz -o lines.npz --method das --image image.npy";
    folder.works(&format!(
        "{beamform} --bone-map map.npy --scales-from-image"
    ));
    folder.works("phase-symmetry image.npy --pad --scales-from-image -o ps.npy");
    assert!(folder.image("map.npy") == folder.image("ps.npy"));
    let config = folder.path().join("ps.npy.config.toml");
    let config: toml::Value = toml::from_str(&fs::read_to_string(config).unwrap()).unwrap();
    let section = &config["phase_symmetry"];
    assert_eq!(section["scales_from_image"].as_bool(), Some(false));
    let scales = section["scales"].as_array().unwrap();
    let scales: Vec<f64> = scales
        .iter()
        .map(|scale| scale.as_float().unwrap())
        .collect();
    assert!(scales.len() == 3 && scales[0] == 2.0 * scales[1] && scales[1] == 2.0 * scales[2]);
    folder.works("phase-symmetry image.npy --config ps.npy.config.toml -o again.npy");
    assert!(folder.image("again.npy") == folder.image("ps.npy"));
}

/// Lines of RF as PLUS writes them become a picture by way of an archive.
#[test]
fn lines_of_plus_become_a_picture() {
    let folder = tempdir().unwrap();
    let header = "ObjectType = Image\nNDims = 3\nBinaryData = True\nCompressedData = False\nDimSize = 64 40 1\n\
                  ElementType = MET_FLOAT\nUltrasoundImageOrientation = FM\nUltrasoundImageType = RF_REAL\n\
                  ElementDataFile = LOCAL\n";
    let echo = |k: usize| {
        let n = (k % 64) as f32;
        (1.3 * n).sin() * (-(n - 30.0).powi(2) / 40.0).exp()
    };
    let lines: Vec<u8> = (0..64 * 40).flat_map(|k| echo(k).to_le_bytes()).collect();
    let path = folder.path().join("lines.mha");
    fs::write(&path, [header.as_bytes(), &lines].concat()).unwrap();
    let known = "--variable fs=20e6 --variable f0=4e6 --variable pitch=0.3e-3 --variable c=1500";
    folder.works(&format!("convert lines.mha {known} -o l.npz"));
    folder.works("beamform l.npz --image l.npy --rows 64 --columns 64");
    let image = folder.image("l.npy");
    let brightest = (0..64).max_by(|&a, &b| image[[a, 32]].total_cmp(&image[[b, 32]]));
    // Sample 30 is 1.125 mm deep; 39 pitches are 11.7 mm, of 63 pixels.
    assert_eq!(brightest, Some(6));
    let (status, message) = run(
        &folder,
        "surface l.npz --variable axes=beam,sample -o l.csv",
    );
    let words = "shape [1, 40, 64]; expected the axes beam, sample";
    assert!(status == 1 && message.contains(words), "{message}");
    let pictures = header
        .replace("RF_REAL", "BRIGHTNESS")
        .replace("= FM", "= MF");
    fs::write(&path, [pictures.as_bytes(), &lines].concat()).unwrap();
    folder.ends("convert lines.mha -o p.npz", 1, "holds pictures");
}
