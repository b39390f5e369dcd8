//! Every kernel on many plans: the bits of the f32 reference, in every way that the catalogue knows.

use crate::common::kit::*;
use bonebeam_drive::beamform::Plan;
use bonebeam_drive::pipeline::Frames;
use bonebeam_drive::source::{LineSource, Recorded};
use bonebeam_drive::threads::pool;
use bonebeam_oracle::reference::f64::coherence::{short_lag_coherence, squared_coherence_factors};
use bonebeam_oracle::reference::plain::Plain;
use bonebeam_tests::draw::Seed;
use bonebeam_tests::kernel::{Kernel, judge, judge_seeds};
use bonebeam_tests::kernels::{
    beamform, coherence, delay, depth_interpolation, frame, image, phase_symmetry, pipeline, scan,
    surface, upsampled,
};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Frames of the host's driver have the bits of single lines, by any number of threads.
///
/// A frame's contents of the memory do not reach the next frame, and each sample is reported once.
#[test]
fn frames_of_the_host() {
    let (mut frames, sets) = (0, InstructionSet::available().collect::<Vec<_>>());
    let pools = [1, 2, 7].map(|threads| pool(threads).expect("threads"));
    for seed in 0..1500 {
        let Ok(mut kernel) = beamform::Lines::draw(&mut Seed(seed)) else {
            continue;
        };
        let (elements, samples) = (kernel.elements, kernel.counts.len());
        let whole = samples * elements;
        kernel.lines.retain(|(x, _)| x.len() == whole);
        let (false, 1) = (kernel.lines.is_empty(), kernel.parameters.sub_lines) else {
            continue;
        };
        let Ok(expected) = judge(&kernel, []) else {
            continue;
        };
        let set = sets[seed as usize % sets.len()];
        let plan = Plan::new(set, kernel.parameters, elements).expect("memory");
        let plan = plan.within(kernel.within.clone());
        let x: Vec<_> = kernel
            .lines
            .iter()
            .flat_map(|(x, _)| x.iter().copied())
            .collect();
        let x = Array3::from_shape_vec((kernel.lines.len(), samples, elements), x).expect("lines");
        let active = |line: usize, sample: usize| kernel.active(line, sample);
        let reported = AtomicUsize::new(0);
        let progress = |outputs: usize| _ = reported.fetch_add(outputs, Ordering::Relaxed);
        let before = x.mapv(|x| Complex::new(0.3, -0.1) - x * 0.5);
        let run = |x: &Array3<_>| plan.run(x.view(), &active, &progress);
        let [_, z] = [before, x].map(|x| pools[frames % 3].install(|| run(&x)).expect("a frame"));
        assert_eq!(reported.into_inner(), 2 * kernel.lines.len() * samples);
        let z = z.into_raw_vec_and_offset().0;
        assert!(bits(&z) == bits(&expected), "seed {seed}: {kernel:?}");
        frames += 1;
    }
    assert!(frames > 400, "{frames}");
}

/// Judges some plans; `exact` asserts the bound of the error beside the reference in f64, if there is one here.
fn check<K: Plain>(plans: u64, exact: impl Fn(&K, &[K::Number])) {
    judge_seeds(plans, |kernel: &K, numbers| {
        exact(kernel, numbers);
        let Some(plain) = kernel.plain() else {
            return;
        };
        let (ours, plain) = (bits(numbers), bits(&plain));
        let at = ours.iter().zip(&plain).position(|(a, b)| a != b);
        assert!(
            at.is_none() && ours.len() == plain.len(),
            "other bits than the reference at {at:?}"
        );
    });
}

/// A test a row: the plans of each kernel, and what else is asserted of a result.
macro_rules! judged {
    ($(#[$test:meta] fn $name:ident() { $($kernel:ty: $plans:literal $($exact:ident)?),* })*) => {$(
        #[$test]
        fn $name() {
            $(judged!(@of $kernel, $plans $(, $exact)?);)*
        }
    )*};
    (@of $kernel:ty, $plans:literal) => { check::<$kernel>($plans, |_, _| {}) };
    (@of $kernel:ty, $plans:literal, $exact:ident) => { check::<$kernel>($plans, $exact) };
}

judged! {
    #[test] fn delayed_lines() { delay::Lines: 6000 }
    #[test] fn upsampled_lines() { upsampled::Waves: 1000 }
    #[test] fn beamformed_lines() { beamform::Lines: 6000 }
    #[test] fn coherence_of_lines() { coherence::Shares: 1000, coherence::ShortLag: 1000 short_lag, coherence::Speeds: 1000 factors }
    #[test] fn images() { image::Image: 3000, depth_interpolation::Envelopes: 1000 }
    #[test] fn bone_maps() { phase_symmetry::Map: 60 }
    #[test] fn surfaces() { surface::Frame: 200 }
    #[test] fn lines_of_a_pipeline() { pipeline::Line: 2000 }
    #[test] fn frames_of_a_pipeline() { frame::Frame: 150 by_the_host }
    #[test] fn apertures_of_scans() { scan::Apertures: 4000 }
}

/// Lines, image and map of the host's threads.
fn pictures<D: Stage + Sync>(
    pipeline: &Pipeline<'_, D>,
    source: &LineSource<'_>,
    pooling: Pooling,
) -> (Array2<Complex<f32>>, Array2<f32>, Array2<f32>) {
    let mut frames = Frames::new(pipeline).expect("memory").with_pooling(pooling);
    let lines = frames.lines(source).expect("lines");
    let image = frames.image(lines.view()).expect("an image");
    let map = frames.run(source).expect("a map");
    (lines, image, map)
}

fn by_the_host(frame: &frame::Frame, numbers: &[f32]) {
    let (parameters, line) = (frame.parameters(0), &frame.line);
    let of_line = &|_: usize| 0..line.transmits.len();
    let transmits: Vec<_> = line.transmits(&()).map(|(transmit, _)| transmit).collect();
    let directions = &mut Vec::new();
    let host = match line.input() {
        Some(input) => line.with_iq(|record| {
            let pipeline = line.gated_frame(Pipeline::of_iq(parameters, input)?, directions)?;
            let source = LineSource::Iq(Recorded {
                pipeline: pipeline.lines().by_reference(),
                transmits: &transmits,
                records: &vec![*record; transmits.len()],
                of_line,
            });
            Ok(pictures(&pipeline, &source, frame.pooling))
        }),
        None => line.with_rf(|record| {
            let pipeline = line.gated_frame(Pipeline::new(parameters)?, directions)?;
            let source = LineSource::Rf(Recorded {
                pipeline: pipeline.lines().by_reference(),
                transmits: &transmits,
                records: &vec![*record; transmits.len()],
                of_line,
            });
            Ok(pictures(&pipeline, &source, frame.pooling))
        }),
    };
    let (host, image, map) = host.expect("a frame");
    let (lines, rest) = numbers.split_at(frame.of_lines());
    // The host's lines are `[sub-line][computed sample]`.
    let (sub_lines, samples) = (line.beamformer.sub_lines, host.ncols());
    for (n, z) in lines.as_chunks::<2>().0.iter().enumerate() {
        let (sample, k) = (n / sub_lines % samples, n % sub_lines);
        let host = host[[n / (sub_lines * samples) * sub_lines + k, sample]];
        assert_eq!(*z, [host.re, host.im], "sample {sample}, sub-line {k}");
    }
    let pictures = image.iter().chain(&map).copied();
    assert!(
        rest.iter()
            .copied()
            .take(2 * frame::SIDE * frame::SIDE)
            .eq(pictures)
    );
}

/// Sums of positive powers err by fewer units in the last place than they have terms, and products no more.
fn short_lag(kernel: &coherence::ShortLag, numbers: &[f32]) {
    let lines = &kernel.0;
    let window = lines.parameters.temporal_half_window;
    let terms = 2.0 * (2 * window + 1) as f64 * lines.elements as f64;
    let mut found = numbers.iter();
    for (line, (x, _)) in lines.lines.iter().enumerate() {
        // Squares within the range of f32.
        let parts = x.iter().flat_map(|x| [x.re.abs(), x.im.abs()]);
        let moderate = parts
            .clone()
            .all(|x| x == 0.0 || (1e-15..1e15).contains(&x));
        for (n, found) in (0..lines.samples(line)).zip(&mut found) {
            let active = |n: usize| lines.active(line, n);
            let expected = short_lag_coherence(x, lines.elements, active, window, n);
            let error = (f64::from(*found) - expected).abs();
            let bound = terms * f64::from(f32::EPSILON);
            assert!(!moderate || error <= bound, "{n}: {found} and {expected}");
        }
    }
}

/// A sum of M values errs by at most M units in the last place of its largest; its square by twice that.
fn factors(kernel: &coherence::Speeds, numbers: &[f32]) {
    let lines = &kernel.0;
    for (line, ((x, _), found)) in lines.lines.iter().zip(numbers).enumerate() {
        let parts = x.iter().flat_map(|x| [x.re.abs(), x.im.abs()]);
        let moderate = parts
            .clone()
            .all(|x| x == 0.0 || (1e-15..1e15).contains(&x));
        let active = |n: usize| lines.active(line, n);
        let block = kernel.block();
        let expected = squared_coherence_factors(x, lines.elements, active, block);
        let error = (f64::from(*found) - expected).abs();
        let blocks = lines.samples(line).div_ceil(block);
        let terms = 8 * blocks * (lines.elements + block) + blocks * blocks;
        let bound = terms as f64 * f64::from(f32::EPSILON);
        assert!(!moderate || error <= bound, "{found} and {expected}");
    }
}
