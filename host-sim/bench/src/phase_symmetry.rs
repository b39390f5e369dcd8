//! Phase symmetry against rustfft and scipy, in strips, and its tables.

use std::hint::black_box;

use ndarray::Array2;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::naive_phase_symmetry::Naive;
use super::report::{Quantity, Row, Table, Target};
use super::scipy::scipy;
use super::settings::{Section, Settings};
use super::timing::{fastest, side_by_side};
use crate::{Error, Result};
use bonebeam_drive::phase_symmetry::{Parameters, Plan};
use bonebeam_drive::threads::pool;

const SIDE: usize = 512;
const SCALES: [f64; 3] = [1.0 / 128.0, 1.0 / 256.0, 1.0 / 512.0];
const THRESHOLD: f32 = 15.0;
/// The largest difference between equal maps, whose values are 0 to 1.
const EQUAL: f64 = 1e-4;

/// A bright arc over speckle, 0..255.
fn image() -> Array2<f32> {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    Array2::from_shape_fn((SIDE, SIDE), |(row, column)| {
        let across = column as f32 - 300.0;
        let down = row as f32 - (180.0 + 0.002 * across * across);
        40.0 * random.random_range(0.0..1.0) + 200.0 * (-down * down / 50.0).exp()
    })
}

fn difference(a: &Array2<f32>, b: &Array2<f32>) -> f64 {
    let differences = a.iter().zip(b).map(|(a, b)| f64::from((a - b).abs()));
    // A NaN is kept.
    differences.fold(0.0, |largest, d| {
        if d.is_nan() || d > largest {
            d
        } else {
            largest
        }
    })
}

fn equal(name: &str, difference: f64) -> Result<f64> {
    if difference <= EQUAL {
        return Ok(difference);
    }
    Err(Error::Data(format!(
        "phase symmetry by the core and by {name} differ by {difference:.1e}; at most {EQUAL:.0e} \
         is expected"
    )))
}

/// Times frames, strips and tables, and the references.
///
/// # Errors
/// Maps of the two sides that are not equal.
pub fn phase_symmetry(settings: &Settings, step: &mut (dyn FnMut(&str) + Send)) -> Result<Table> {
    pool(1)?.install(|| measure(settings, step))
}

fn plan(strip: usize) -> Result<Plan> {
    let parameters = Parameters {
        scales: SCALES.to_vec(),
        threshold: THRESHOLD,
        strip,
    };
    Plan::new((SIDE, SIDE), &parameters)
}

fn measure(settings: &Settings, step: &mut (dyn FnMut(&str) + Send)) -> Result<Table> {
    let image = image();
    let run = |plan: &mut Plan| plan.run(image.view(), settings.instruction_set, &mut |_, _| {});
    // All matrices are in memory, whatever the number of lines processed at a time.
    let (mut core, mut at_once) = (plan(Parameters::STRIP)?, plan(SIDE)?);
    let budget = 2 * settings.budget;
    let map = run(&mut core)?;

    let label = |beside: &str| format!("16 lines at a time, beside {beside}");
    let milliseconds = Quantity::milliseconds;

    step("rustfft");
    let mut naive = Naive::new(SIDE, &SCALES, THRESHOLD);
    let mut expected = Array2::zeros(image.dim());
    naive.run(image.view(), &mut expected);
    let error = equal("rustfft", difference(&map, &expected))?;
    let [frame, rustfft, whole] = side_by_side(
        budget,
        [
            &mut || drop(black_box(run(&mut core))),
            &mut || naive.run(image.view(), black_box(&mut expected)),
            &mut || drop(black_box(run(&mut at_once))),
        ],
    );
    let mut rows = vec![
        Row::faster(label("rustfft"), milliseconds, [frame, rustfft])
            .target(Target::AtLeast(16.0 / 12.0))
            .difference(error),
        Row::slower(
            label("the whole image at once"),
            milliseconds,
            [frame, whole],
        )
        .target(Target::AtMost(1.3)),
    ];

    step("tables");
    let tables = fastest(settings.budget, || drop(black_box(plan(Parameters::STRIP))));
    let row = Row::slower(
        "filter tables, beside a frame",
        milliseconds,
        [tables, frame],
    );
    rows.push(row.target(Target::AtMost(1.0)));

    step("scipy");
    let mut method = String::from(
        "One thread, 512 × 512 pixels, three scales, T_n = 15, tables ready. rustfft and scipy: \
         dense filters, one complex inverse transform of the whole image a filter, f32; all maps \
         are compared.",
    );
    match scipy(image.view(), budget) {
        Ok(python) => {
            let error = equal("scipy", difference(&map, &python.map))?;
            // As close as possible to the time of Python's run.
            let frame = fastest(settings.budget, || drop(black_box(run(&mut core))));
            for (name, seconds) in python.seconds {
                let row = Row::faster(label(&name), milliseconds, [frame, seconds]);
                rows.push(row.target(Target::AtLeast(2.0)).difference(error));
            }
        }
        Err(reason) => method.push_str(&format!(" scipy was left out: {reason}.")),
    }
    Ok(Table {
        section: Section::PhaseSymmetry.to_string(),
        title: "Phase symmetry, 18 filters".into(),
        method,
        yardstick: "yardstick".into(),
        rows,
    })
}
