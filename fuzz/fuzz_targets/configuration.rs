//! The command line and the configuration: every valid one runs through the stages.
//!
//! An input is text: the words of a command line, or with `[` somewhere a configuration.

#![no_main]

use std::cell::RefCell;
use std::sync::LazyLock;

use bonebeam::Complex;
use bonebeam::beamform::{AlignedLine, Beamformer};
use bonebeam_drive::beamform::Memory;
use bonebeam_drive::config::{Beamform, Image, PhaseSymmetry};
use bonebeam_drive::delay::DelayStage;
use bonebeam_files::{ChannelData, Transmits};
use bonebeam_simulate::Phantom;
use bonebeam_tests::kernel::bits;
use clap::{CommandFactory, FromArgMatches, Parser};
use host_sim::config::Config;
use host_sim::flags::{Flags, SimulateFlags};
use libfuzzer_sys::fuzz_target;
use ndarray::Array3;

#[derive(Parser, Debug)]
#[command(name = "host-sim", allow_negative_numbers = true)]
enum Command {
    Beamform {
        #[command(flatten)]
        beamform: Box<Flags<Beamform>>,
        #[command(flatten)]
        image: Flags<Image>,
    },
    Simulate {
        #[command(flatten)]
        simulate: SimulateFlags,
        #[arg(long = "config")]
        path: Option<String>,
    },
    PhaseSymmetry {
        #[command(flatten)]
        phase_symmetry: Flags<PhaseSymmetry>,
    },
}

thread_local! {
    /// The flags; clap builds their table once.
    static COMMAND: RefCell<clap::Command> = RefCell::new(Command::command());
}

/// Beyond this number of samples a line, a run only takes time.
const MOST_SAMPLES: usize = 60;

fuzz_target!(init: one_thread(), |text: &str| {
    let mut config = Config::default();
    if text.contains('[') {
        match toml::from_str(text) {
            Ok(read) => config = read,
            Err(_) => return,
        }
    } else {
        let words = ["host-sim"].into_iter().chain(text.split_whitespace());
        let parsed = COMMAND.with_borrow_mut(|command| {
            let mut matches = command.try_get_matches_from_mut(words)?;
            Command::from_arg_matches_mut(&mut matches)
        });
        match parsed {
            Ok(Command::Beamform { beamform, image }) => {
                beamform.apply(&mut config.beamform);
                image.apply(&mut config.image);
            }
            Ok(Command::Simulate { simulate, .. }) => {
                if simulate.apply(&mut config.simulate).is_err() {
                    return;
                }
            }
            Ok(Command::PhaseSymmetry { phase_symmetry }) => {
                phase_symmetry.apply(&mut config.phase_symmetry);
            }
            Err(_) => return,
        }
    }
    config.beamform.resolve();
    if config.validate().is_err() {
        return;
    }
    // The written configuration is read back unchanged.
    let written = toml::to_string(&config).expect("a valid configuration is written");
    let read: Config = toml::from_str(&written).expect("what was written is read");
    assert_eq!(config, read);
    // A line takes as long as many configurations, so only some inputs run one.
    if text.bytes().fold(0, u8::wrapping_add).is_multiple_of(16) {
        run(config);
    }
});

/// Keeps parallel work on this thread.
fn one_thread() {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .use_current_thread();
    pool.build_global().expect("the first to ask for it");
}

/// The first line of a recording, with one lane.
fn run(mut config: Config) {
    let scanner = &config.simulate.scanner().clone();
    let phantom = Phantom::point(scanner, config.simulate.offset);
    let _ = phantom.check_within(scanner);
    let parameters = &config.beamform;
    let Ok(stage) = DelayStage::new(&RECORDING, parameters) else {
        return;
    };
    if stage.samples() > MOST_SAMPLES {
        return;
    }
    let (Ok(x), Ok(adaptive)) = (
        stage.delay(0..1),
        parameters.adaptive_samples(&stage.depths()),
    ) else {
        return;
    };
    let beamformer = Beamformer::new(parameters.parameters()).expect("checked parameters");
    let elements = RECORDING.element_x.len();
    let sizes = beamformer.sizes(elements);
    let x = x.as_slice().expect("as it was made");
    let line = AlignedLine::new(x, elements).expect("finite samples of whole rows");
    let active = |sample| stage.active(0, sample);
    let mut z = vec![Complex::ZERO; stage.samples()];
    let done = Memory::new(0.0, sizes)
        .map(|mut m| beamformer.line_within(&mut m.view(), line, active, adaptive, &mut z));
    if let Ok(Ok(())) = done {
        bits(&z);
    }
}

/// Two plane waves on four elements.
static RECORDING: LazyLock<ChannelData> = LazyLock::new(|| ChannelData {
    t0: vec![1e-6, 1.2e-6],
    ..ChannelData::linear(
        Array3::from_shape_fn((2, 4, 40), |(t, m, n)| {
            ((t * 31 + m * 17 + n * n) % 97) as f32 - 48.0
        }),
        (0..4).map(|m| (f64::from(m) - 1.5) * 0.3e-3).collect(),
        Transmits::Plane {
            angle: vec![-0.1, 0.1],
        },
        ([40e6, 5e6], 1540.0),
    )
});
