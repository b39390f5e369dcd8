//! The command line and the configuration: what they let through, the stages run with.
//!
//! An input is text: the words of a command line, or with `[` somewhere a configuration.

#![no_main]

use std::sync::Once;

use clap::Parser;
use host_sim::config::{BeamformFlags, Config, ImageFlags, PhaseSymmetryFlags, SimulateFlags};
use host_sim::drive::delay::DelayStage;
use host_sim::drive::frame::beamform_channel_data;
use host_sim::files::{ChannelData, Transmits};
use host_sim::simulate::Phantom;
use libfuzzer_sys::fuzz_target;
use ndarray::Array3;

#[derive(Parser, Debug)]
#[command(name = "host-sim", allow_negative_numbers = true)]
enum Command {
    Beamform {
        #[command(flatten)]
        beamform: Box<BeamformFlags>,
        #[command(flatten)]
        image: ImageFlags,
    },
    Simulate {
        #[command(flatten)]
        simulate: SimulateFlags,
        #[arg(long = "config")]
        path: Option<String>,
    },
    PhaseSymmetry {
        #[command(flatten)]
        phase_symmetry: PhaseSymmetryFlags,
    },
}

/// Beyond this many samples a line a run only takes time.
const MOST_SAMPLES: usize = 200;

fuzz_target!(|text: &str| {
    static THREADS: Once = Once::new();
    THREADS.call_once(|| {
        let _ = rayon::ThreadPoolBuilder::new()
            .num_threads(1)
            .build_global();
    });
    let mut config = Config::default();
    if text.contains('[') {
        match toml::from_str(text) {
            Ok(read) => config = read,
            Err(_) => return,
        }
    } else {
        let words = ["host-sim"].into_iter().chain(text.split_whitespace());
        match Command::try_parse_from(words) {
            Ok(Command::Beamform { beamform, image }) => {
                config.beamform.apply(&beamform);
                config.image.apply(&image);
            }
            Ok(Command::Simulate { simulate, .. }) => {
                if config.simulate.apply(&simulate).is_err() {
                    return;
                }
            }
            Ok(Command::PhaseSymmetry { phase_symmetry }) => {
                config.phase_symmetry.apply(&phase_symmetry);
            }
            Err(_) => return,
        }
    }
    config.beamform.resolve();
    if config.validate().is_err() {
        return;
    }
    // What was written is what is read.
    let written = toml::to_string(&config).expect("a valid configuration is written");
    let read: Config = toml::from_str(&written).expect("what was written is read");
    assert_eq!(config, read);
    run(config);
});

fn run(mut config: Config) {
    let scanner = config.simulate.scanner().clone();
    let phantom = Phantom::point(&scanner, config.simulate.offset);
    let _ = phantom.check_within(&scanner);
    let data = recording();
    if config.beamform.temporal_half_window > 1000 {
        return;
    }
    let Ok(stage) = DelayStage::new(&data, &config.beamform) else {
        return;
    };
    if stage.samples() > MOST_SAMPLES {
        return;
    }
    if let Ok(lines) = beamform_channel_data(&data, &config.beamform, &|_| {}) {
        assert!(lines.z.iter().all(|z| z.re.is_finite() && z.im.is_finite()));
    }
}

/// Two plane waves on eight elements.
fn recording() -> ChannelData {
    ChannelData {
        samples: Array3::from_shape_fn((2, 8, 150), |(t, m, n)| {
            ((t * 31 + m * 17 + n * n) % 97) as f32 - 48.0
        })
        .into(),
        fs: 40e6,
        t0: vec![1e-6, 2e-6],
        element_x: (0..8).map(|m| (f64::from(m) - 3.5) * 0.3e-3).collect(),
        element_z: None,
        element_angle: None,
        c: 1540.0,
        f0: 5e6,
        transmits: Transmits::Plane {
            angle: vec![-0.1, 0.1],
        },
        lens_delay: 0.0,
    }
}
