//! Counts a line of a multiplexed probe, as small open ones are: each of 16 elements hears its own echo.
//!
//! A record has 400 samples of 16 bits at 8 MHz. Prints `multiplexed LINE DENSE BYTES STACK`: instructions of a line from
//! records of one element and from records with zeros for the others, the bytes of the former, and the line's stack;
//! ends with a failure beyond a bound, or where the two lines differ.

#![no_std]
#![no_main]

#[path = "count/counter.rs"]
mod counter;

use bonebeam::prelude::stages::*;
use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;
use counter::Counter;
use firmware::arrays;
use static_cell::ConstStaticCell;

const ELEMENTS: usize = 16;
const SAMPLES: usize = 400;
const RATE: f64 = 8e6;
/// At most this many bytes of records.
const BYTES: usize = 40_000;
/// At most this many instructions a line, 4 % above the count of Rust 1.95; 0.8 million are the beamformer's.
const BOUND: u32 = 6_000_000;

const PARAMETERS: Parameters<'static> = Parameters {
    scan: ScanParameters {
        array: Array::linear(ELEMENTS, 0.4e-3),
        lines: Lines::Even(Axis::centred(ELEMENTS, 0.4e-3)),
        centre_frequency: 2.25e6,
        sampling_rate: RATE,
        record_samples: SAMPLES,
        output_rate: RATE,
        start: Depth::Metres(5e-3),
        end: Depth::Metres(35e-3),
        ..ScanParameters::EXAMPLE
    },
    beamformer: beamform::Parameters::of(Method::Mv),
    ..Parameters::EXAMPLE
};
const SCAN: Scan<'static> = valid!(Scan::new(PARAMETERS.scan));
static DELAY: Delay = valid!(Delay::new(DelayParameters::of(&SCAN)));
const NEED: Need = valid!(PARAMETERS.need(Input::Rf, 1));

type Channel = [f32; SAMPLES];

static MEMORY: ConstStaticCell<Workspaces> = ConstStaticCell::new(Workspaces::new());

arrays! {
    /// Counts, their records, records with zeros, and a frame.
    struct Workspaces {
        counts: [[i16; SAMPLES]; ELEMENTS] = [[0; SAMPLES]; ELEMENTS],
        own: [Channel; ELEMENTS] = [[0.0; SAMPLES]; ELEMENTS],
        dense: [[Channel; ELEMENTS]; ELEMENTS] = [[[0.0; SAMPLES]; ELEMENTS]; ELEMENTS],
        frame: Memory<{ NEED.real }, { NEED.complex }> = Memory::new(),
    }
}

#[entry]
fn main() -> ! {
    counter::run("multiplexed.rs", |counter| run(counter, MEMORY.take()))
}

fn run(counter: &mut Counter, workspaces: &mut Workspaces) -> Result<bool, Error> {
    let Workspaces {
        counts,
        own,
        dense,
        frame,
    } = workspaces;
    // An echo of 3 cycles at about 20 mm, in noise.
    let mut noise = 1u32;
    for (n, count) in counts.as_flattened_mut().iter_mut().enumerate() {
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let echo = match n % SAMPLES {
            200..211 => [0, 900, -600, -500][n % 4],
            _ => 0,
        };
        *count = echo + (noise >> 28) as i16;
    }
    let plan = Pipeline::by(&DELAY, PARAMETERS)?;
    let mut frame = Frame::new(&plan, frame.scratch())?;
    let (mut parts, mut all) = ([None; ELEMENTS], [None; ELEMENTS]);
    let bytes = size_of_val(counts) + size_of_val(own) + size_of_val(&parts);
    let own = counts.iter().zip(own.iter_mut()).zip(dense).enumerate();
    for ((m, ((counts, own), dense)), (part, all)) in own.zip(parts.iter_mut().zip(&mut all)) {
        for rf in [&mut *own, &mut dense[m]] {
            stream::rf_record(counts, IqLayout::Planar, 1, 1e-3, rf)?;
        }
        *part = Some(Record::new(own, 1)?.part_of(ELEMENTS, m)?);
        *all = Some(Record::new(dense.as_flattened(), ELEMENTS)?);
    }
    let mut line = |records: &[Option<Record<'_>>]| {
        let laws = (0..ELEMENTS).map(|m| TransmitLaw::Element {
            x: PARAMETERS.scan.array.x(m),
            z: 0.0,
        });
        let transmits = laws.map(|law| Transmit::new(law, 0.0));
        let waves = || transmits.clone().zip(records.iter().flatten());
        let mut sum = 0;
        let cost = counter.cost(|| {
            let sizes = const { PARAMETERS.beamformer.sizes(ELEMENTS) };
            let z = frame.line_by(sizes, ELEMENTS / 2, waves())?;
            let bits = |z: &Complex<f32>| [z.re, z.im].map(f32::to_bits);
            let word = |sum: u32, bits: u32| sum.rotate_left(5) ^ bits;
            sum = z.iter().flat_map(bits).fold(0, word);
            Ok(())
        })?;
        Ok::<_, Error>((cost, sum))
    };
    let (dense, expected) = line(&all)?;
    let (sparse, sum) = line(&parts)?;
    let (instructions, dense) = (sparse.instructions, dense.instructions);
    hprintln!(
        "multiplexed {instructions} {dense} {bytes} {}",
        sparse.stack
    );
    Ok(instructions <= BOUND && bytes <= BYTES && sum == expected)
}
