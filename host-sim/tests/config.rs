//! The configuration: defaults, the written file as input, and errors.

use crate::common::changed;
use bonebeam::beamform::{Apodization, Parameters, Postfilter};
use bonebeam::covariance::Covariance;
use std::fs;

use bonebeam_drive::config::Size;
use bonebeam_files::atomic::Outputs;
use bonebeam_files::section::{Section, Value, number_or_power};
use bonebeam_formats::Variables;
use bonebeam_simulate::Settings;
use bonebeam_simulate::Simulate;
use host_sim::Error;
use host_sim::config::Config;
use host_sim::provenance::Input;
use tempfile::tempdir;

fn read(text: &str) -> Result<Config, Error> {
    let folder = tempdir().unwrap();
    let path = folder.path().join("config.toml");
    fs::write(&path, text).unwrap();
    Config::read(&path)
}

/// Asserts that a file gives the defaults with something changed.
fn assert_read(text: &str, change: impl FnOnce(&mut Config)) {
    let expected = changed(Config::default(), change);
    assert_ne!(expected, Config::default(), "{text}");
    assert_eq!(read(text).unwrap(), expected);
}

fn refused(text: &str) -> String {
    let error = read(text).and_then(|c| c.validate()).expect_err(text);
    assert!(matches!(error, Error::Usage(_)), "{text}");
    let message = error.to_string();
    assert!(!message.contains('\n'), "more than one line: {message}");
    message
}

#[test]
fn the_defaults_are_those_of_the_paper_and_the_contract() {
    let config = Config::default();
    config.validate().unwrap();
    assert_eq!(config.beamform.diagonal_loading, 0.05);
    assert_eq!(config.beamform.subaperture_ratio, 0.5);
    assert_eq!(config.beamform.covariance, Covariance::ForwardBackward);
    assert_eq!(config.beamform.f_number, 1.5);
    assert_eq!(config.beamform.min_elements, 8);
    // Four samples a period at any centre frequency: the paper's 20 MHz at 5 MHz.
    assert_eq!(config.beamform.output_rate, None);
    assert_eq!(config.beamform.rate(5e6, 100e6), 20e6);
    // Square pixels, 512 along the longer side.
    assert_eq!(config.image.sides(0.02, 0.04).unwrap(), [512, 257]);
    assert_eq!(config.image.sides(0.04, 0.02).unwrap(), [257, 512]);
    // 2^-7, 2^-8, 2^-9 and T_n = 15, as for the paper's simulations.
    assert_eq!(
        config.phase_symmetry.scales,
        [1.0 / 128.0, 1.0 / 256.0, 1.0 / 512.0]
    );
    assert_eq!(config.phase_symmetry.threshold, 15.0);
}

/// The core's table defines all keys and ranges.
#[test]
fn every_parameter_of_the_core_is_a_key_with_its_range() {
    for row in Parameters::TABLE {
        let key = row.name;
        assert_read(&format!("[beamform]\n{key} = {}\n", row.example), |c| {
            c.beamform.set(key, &row.example.to_string());
        });
        let message = refused(&format!("[beamform]\n{key} = \"a\"\n"));
        assert!(message.contains("line 2"), "{message}");
        let outside = [row.range.least - 1.0, row.range.most + 1.0];
        for value in outside.into_iter().filter(|v| v.is_finite() && *v > -1.0) {
            let message = refused(&format!("[beamform]\n{key} = {value}\n"));
            assert!(message.contains(row.range.text), "{message}");
        }
    }
    for postfilter in Postfilter::EXAMPLES {
        let text = format!("[beamform]\npostfilter = \"{}\"\n", postfilter.key());
        let expected = changed(Config::default(), |c| c.beamform.postfilter = postfilter);
        assert_eq!(read(&text).unwrap(), expected);
    }
    for apodization in Apodization::EXAMPLES {
        let text = format!("[beamform]\napodization = \"{}\"\n", apodization.key());
        let expected = changed(Config::default(), |c| c.beamform.apodization = apodization);
        assert_eq!(read(&text).unwrap(), expected);
    }
    let message = refused("[beamform]\nf_number = 2.0\npostfilter = \"wiener\"\n");
    assert!(
        message.contains("line 3") && message.contains("coherence-factor"),
        "{message}"
    );
}

#[test]
fn the_written_configuration_is_read_back_as_it_was() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("lines.npz.config.toml");
    let config = Config {
        simulate: Simulate {
            mesh: Some("bone 'a'.ply".into()),
            scanner: Some(changed(Settings::default(), |s| s.noise = Some(-60.0))),
            ..Simulate::default()
        },
        variables: {
            let mut variables = Variables::default();
            for given in [
                "rf=RcvData",
                "c=1480",
                "tx_angle=0,0.1",
                "axes=sample,element",
            ] {
                variables.take(given).unwrap();
            }
            variables
        },
        ..Config::default()
    };
    for config in [config, Config::default()] {
        let mut outputs = Outputs::new();
        // Any text on the command line or in a name stays within the comment.
        let inputs = [Input {
            path: "a\nb.npz".into(),
            xxh128: None,
        }];
        config
            .add_to("beamform 'a\nb.npz'", &inputs, &path, &mut outputs)
            .unwrap();
        outputs.commit().unwrap();
        assert_eq!(Config::read(&path).unwrap(), config);
    }
}

#[test]
fn a_file_may_mention_one_key_only_and_by_its_older_name() {
    assert_read("[beamform]\ndiagonal_loading = 0.2\n", |c| {
        c.beamform.diagonal_loading = 0.2
    });
    let older = "[beamform]\nloading = 0.2\ntemporal = 3\nsubarray_ratio = 0.4\n";
    assert_read(older, |c| {
        c.beamform.diagonal_loading = 0.2;
        c.beamform.temporal_half_window = 3;
        c.beamform.subaperture_ratio = 0.4;
    });
}

#[test]
fn scales_and_sizes_are_read_as_people_write_them() {
    assert_eq!(number_or_power("2^-7"), Ok(1.0 / 128.0));
    assert_eq!(number_or_power("0.0078125"), Ok(1.0 / 128.0));
    assert_eq!(
        Size::read("512x256"),
        Ok(Size {
            rows: 512,
            columns: 256
        })
    );
    for wrong in ["2^", "2^x", "", "a"] {
        assert!(number_or_power(wrong).is_err(), "{wrong}");
    }
    for wrong in ["512", "x", "512x", "512x-1", "512 x 512"] {
        assert!(Size::read(wrong).is_err(), "{wrong}");
    }
}
