//! The golden vectors: consistent intermediates, and errors for changed files.

use std::fs;
use std::path::Path;

use bonebeam_oracle::golden::{Stage, Values, check, stages, write};
use num_complex::Complex;

fn find<'a>(stages: &'a [Stage], name: &str) -> &'a Stage {
    let stage = stages.iter().find(|stage| stage.name == name);
    stage.unwrap_or_else(|| panic!("no stage {name}"))
}

fn complex(stage: &Stage) -> Vec<Complex<f64>> {
    let wide = |z: &Complex<f32>| Complex::new(f64::from(z.re), f64::from(z.im));
    match &stage.values {
        Values::Complex(values) => values.iter().map(wide).collect(),
        Values::Real(values) => values
            .iter()
            .map(|&x| Complex::new(x.into(), 0.0))
            .collect(),
    }
}

/// f32's rounding over sums of eight products.
const ROUNDING: f64 = 1e-5;

/// The intermediates are consistent, and the core's lines come from them.
///
/// The factor's product with its adjoint is the covariance, the eigenvector is an eigenvector of it, and the weights
/// give the line.
#[test]
fn each_stage_follows_from_the_one_before() {
    let stages = stages().expect("stages");
    let focused = complex(find(&stages, "focused"));
    for folder in ["forward", "forward-backward"] {
        let of = |name: &str| complex(find(&stages, &format!("{folder}-{name}")));
        let (matrices, factors) = (of("covariance"), of("cholesky"));
        let (values, vectors) = (of("eigenvalue"), of("eigenvector"));
        for (k, r) in matrices.chunks(64).enumerate() {
            let trace: f64 = (0..8).map(|i| r[9 * i].re).sum();
            let g = |i: usize, j: usize| match i.cmp(&j) {
                std::cmp::Ordering::Equal => 1.0 / factors[64 * k + 9 * i],
                std::cmp::Ordering::Greater => factors[64 * k + 8 * i + j],
                std::cmp::Ordering::Less => Complex::ZERO,
            };
            for i in 0..8 {
                for j in 0..=i {
                    let product: Complex<f64> = (0..8).map(|m| g(i, m) * g(j, m).conj()).sum();
                    assert!((product - r[8 * i + j]).norm() < ROUNDING * trace);
                }
                let row: Complex<f64> = (0..8).map(|j| r[8 * i + j] * vectors[8 * k + j]).sum();
                assert!((row - values[k] * vectors[8 * k + i]).norm() < ROUNDING * trace);
            }
        }
        for method in ["mv", "esmv-rank1"] {
            let weights = of(&format!("weights-{method}"));
            let z = of(&format!("line-{method}"));
            let largest = z.iter().map(|z| z.norm()).fold(0.0, f64::max);
            for (k, w) in weights.chunks(8).enumerate() {
                // The traced lines are the sixth and the seventh, of 96 samples each.
                let sample = 5 * 96 + k;
                let x = &focused[16 * sample..][..16];
                let expected: Complex<f64> = (0..8)
                    .map(|i| w[i].conj() * x[i..i + 9].iter().sum::<Complex<f64>>() / 9.0)
                    .sum();
                assert!(
                    (expected - z[sample]).norm() < 1e-4 * largest,
                    "{folder} {method} {k}"
                );
            }
        }
    }
    let das = complex(find(&stages, "line-das"));
    for (x, z) in focused.chunks(16).zip(&das) {
        assert!((x.iter().sum::<Complex<f64>>() / 16.0 - z).norm() < 1e-6);
    }
}

#[test]
fn what_is_written_is_the_same_and_what_differs_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let manifest = write(folder, &stages().expect("stages")).expect("written");
    for table in ["real_form.hex", "solver.hex", "reciprocals.hex"] {
        let kept = Path::new("../firmware/fpga").join(table);
        let [kept, made] = [kept, folder.join(table)].map(|path| fs::read(path).expect("a table"));
        assert!(
            kept == made,
            "firmware/fpga/{table}: host-sim golden writes it"
        );
    }
    let adaptive = manifest
        .integer
        .iter()
        .filter(|v| v.files[0] != "das.in.hex");
    let errors: Vec<f64> = adaptive
        .filter_map(|vectors| vectors.largest_error)
        .collect();
    assert!(
        errors.len() == 3 && errors.iter().all(|&error| error < 5e-6),
        "{errors:?}"
    );
    let verdicts = check(folder).expect("a check");
    assert!(verdicts.len() > 70, "{}", verdicts.len());
    assert!(verdicts.iter().all(|verdict| verdict.same));

    // One word, then a truncated file, then one of another shape.
    let words = folder.join("das.out.hex");
    let text = fs::read_to_string(&words).expect("text");
    let word = text
        .lines()
        .find(|line| !line.starts_with("//"))
        .expect("a word");
    fs::write(&words, text.replacen(word, "12345678", 1)).expect("written");
    let numbers = folder.join("line-das.npy");
    let mut bytes = fs::read(&numbers).expect("bytes");
    let last = bytes.len() - 8;
    bytes[last..last + 4].copy_from_slice(&2.5f32.to_le_bytes());
    fs::write(&numbers, bytes).expect("written");
    fs::copy(folder.join("image.npy"), folder.join("envelope.npy")).expect("copied");
    fs::write(folder.join("levels.npy"), b"\x93NUMPY").expect("written");

    let verdicts = check(folder).expect("a check");
    let of = |file: &str| {
        let verdict = verdicts.iter().find(|verdict| verdict.file == file);
        verdict.unwrap_or_else(|| panic!("{file} has no verdict"))
    };
    assert!(
        of("das.out.hex")
            .detail
            .starts_with("word 0 is 12345678; expected ")
    );
    assert!(of("das.out.hex").detail.ends_with("1 of 206 words differ"));
    let detail = &of("line-das.npy").detail;
    assert!(detail.starts_with("[line 11, sample 95], real part is 2.5e0 (40200000); expected "));
    assert!(
        of("envelope.npy")
            .detail
            .contains("shape [64, 64]; expected [12, 96]")
    );
    assert!(
        of("levels.npy").detail.contains("its header is not whole"),
        "{}",
        of("levels.npy").detail
    );
    assert_eq!(verdicts.iter().filter(|verdict| !verdict.same).count(), 4);
}
