//! Images, bone maps and figures.

use super::*;

#[test]
fn an_image_has_the_size_and_the_depths_asked_for() {
    let folder = folder_of_a_point();
    // 10 mm down from 6 mm and 8 mm across, at 0.1 mm a pixel. The point is 5.234 mm below the top and 1.35 mm to the
    // right of the middle.
    let command = "beamform data.npz -o lines.npz --method das --depth-start 0.006 \
                   --image image.npy --rows 101 --columns 81 --depth 0.016 --width 0.008";
    run(&folder, command);
    let pixels = image::read(&folder.path().join("image.npy")).unwrap();
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
    let bytes = |name: &str| fs::read(folder.path().join(name)).unwrap();
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
        run(&folder, &command);
        run(
            &folder,
            &format!("{beamform} {size} --bone-map map.png {flags}"),
        );
        let command = format!("phase-symmetry image.npy -o ps.npy --image ps.png {flags}");
        run(&folder, &command);
        assert!(bytes("map.npy") == bytes("ps.npy"), "{size} {flags}");
        assert!(bytes("map.png") == bytes("ps.png"), "{size} {flags}");
        let map = image::read(&folder.path().join("map.npy")).unwrap();
        assert!(map.iter().any(|&symmetry| symmetry > 0.1), "{size} {flags}");
    }
    image::write(
        &image::read(&folder.path().join("image.npy")).unwrap(),
        &folder.path().join("image.png"),
    )
    .unwrap();
    run(
        &folder,
        "phase-symmetry image.png -o rounded.npy --config lines.npz.config.toml",
    );
    assert!(bytes("rounded.npy") != bytes("map.npy"));
    let again =
        "beamform data.npz -o lines.npz --bone-map again.npy --config lines.npz.config.toml";
    run(&folder, again);
    assert!(bytes("again.npy") == bytes("map.npy"));
    // An image without a requested size is padded.
    run(
        &folder,
        "beamform data.npz -o own.npz --image own.npy --bone-map own-map.npy",
    );
    run(&folder, "phase-symmetry own.npy -o own-ps.npy --pad");
    assert!(bytes("own-map.npy") == bytes("own-ps.npy"));
}

/// Wavelengths are scales by the size of a pixel, and noise gives a threshold, in both commands.
#[test]
fn a_bone_map_by_wavelengths_and_the_images_noise() {
    let folder = folder_of_a_point();
    let map = |name: &str| image::read(&folder.path().join(name)).unwrap();
    let wavelengths = "--pixel-size 0.0001 --wavelengths 0.0004,0.0008";
    let beamform = "beamform data.npz -o lines.npz --method das --image image.npy";
    run(
        &folder,
        &format!("{beamform} --bone-map map.npy {wavelengths} --noise-deviations 2"),
    );
    let filter = "phase-symmetry image.npy --pad";
    run(
        &folder,
        &format!("{filter} {wavelengths} --noise-deviations 2 -o ps.npy"),
    );
    assert!(map("map.npy") == map("ps.npy"));
    run(
        &folder,
        &format!("{filter} --scales 0.25,0.125 --noise-deviations 2 -o scales.npy"),
    );
    assert!(map("map.npy") == map("scales.npy"));
    run(
        &folder,
        &format!("{filter} {wavelengths} --noise-deviations 2 --noise-by-direction -o own.npy"),
    );
    assert!(map("own.npy") != map("ps.npy"));
    // The written configuration repeats the run; --scales and --threshold replace its keys.
    run(
        &folder,
        "phase-symmetry image.npy --config own.npy.config.toml -o again.npy",
    );
    assert!(map("again.npy") == map("own.npy"));
    let plain = "--scales 0.25,0.125 --threshold 5";
    run(
        &folder,
        &format!("phase-symmetry image.npy --config own.npy.config.toml {plain} -o a.npy"),
    );
    run(&folder, &format!("{filter} {plain} -o b.npy"));
    assert!(map("a.npy") == map("b.npy"));
}

#[test]
fn a_figure_has_axes_in_mm_and_the_image_in_it() {
    let folder = folder_of_a_point();
    let beamform = "beamform data.npz -o lines.npz --method das --depth-start 0.006 --depth 0.016 \
                    --dynamic-range 50";
    run(&folder, &format!("{beamform} --image figure.svg"));
    run(&folder, &format!("{beamform} --image image.png"));
    let figure = fs::read_to_string(folder.path().join("figure.svg")).unwrap();
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
    assert!(bytes == fs::read(folder.path().join("image.png")).unwrap());
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
    run(
        &folder,
        &format!("{command} -o all.npy --strip 128 --image all.png"),
    );
    let map = image::read(&folder.path().join("all.npy")).unwrap();
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
    let (row, level) = brightest_row(&image::read(&folder.path().join("all.png")).unwrap());
    assert_eq!((row, level), (40, 255.0));

    let bytes = |name: &str| fs::read(folder.path().join(name)).unwrap();
    for strip in [1, 7, 64] {
        run(&folder, &format!("{command} -o strip.npy --strip {strip}"));
        assert!(bytes("strip.npy") == bytes("all.npy"), "strip {strip}");
    }
    run(
        &folder,
        "phase-symmetry image.npy -o again.npy --config all.npy.config.toml",
    );
    assert!(bytes("again.npy") == bytes("all.npy"));
    run(
        &folder,
        "phase-symmetry image.npy -o small.npy --resize 64x128",
    );
    assert_eq!(
        image::read(&folder.path().join("small.npy")).unwrap().dim(),
        (64, 128)
    );
}

/// Another measure of the map changes no surface, which has short-lag coherence.
#[test]
fn a_map_of_the_largest_eigenvalue_beside_the_surface() {
    let folder = folder_of_a_point();
    let beamform = "beamform data.npz --method das -o lines.npz";
    let map = |name: &str| image::read(&folder.path().join(name)).unwrap();
    let bytes = |name: &str| fs::read(folder.path().join(name)).unwrap();
    run(
        &folder,
        &format!("{beamform} --surface a.csv --coherence short.npy"),
    );
    let own = "--coherence own.npy --coherence-of largest-eigenvalue";
    run(&folder, &format!("{beamform} --surface b.csv {own}"));
    assert!(bytes("a.csv") == bytes("b.csv"));
    assert_eq!(map("own.npy").dim(), map("short.npy").dim());
    // Silence has 0, all else at least 1 over the elements.
    let least = 1.0 / 128.0;
    let within = |share: &f32| *share == 0.0 || (least..=1.0).contains(share);
    assert!(map("own.npy").iter().all(within));
    assert!(map("own.npy").iter().any(|share| *share > 0.9));
}

/// Both commands choose the same scales, tell them, and write them down.
#[test]
fn a_bone_map_with_scales_from_the_image() {
    let folder = folder_of_a_point();
    let map = |name: &str| image::read(&folder.path().join(name)).unwrap();
    let beamform = "beamform data.npz -o lines.npz --method das --image image.npy";
    run(
        &folder,
        &format!("{beamform} --bone-map map.npy --scales-from-image"),
    );
    run(
        &folder,
        "phase-symmetry image.npy --pad --scales-from-image -o ps.npy",
    );
    assert!(map("map.npy") == map("ps.npy"));
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
    run(
        &folder,
        "phase-symmetry image.npy --config ps.npy.config.toml -o again.npy",
    );
    assert!(map("again.npy") == map("ps.npy"));
}
