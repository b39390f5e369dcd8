//! The core's beamformers against the f64 reference.

mod common;
use bonebeam::beamform::*;
use common::lines::*;
use host_sim::reference::f64::beamform as reference;
use num_complex::Complex;

#[test]
fn quick() {
    for m in [16, 32, 64, 128] {
        for covariance in COVARIANCES {
            for temporal in [0, 2, 10] {
                let line = Line::noise(m as u64 * 7 + temporal as u64, 48, m);
                let base = Parameters { temporal, ..Parameters::default() };
                let p = exact_parameters(base, covariance);
                let samples: Vec<_> = (0..48).map(|n| reference::Sample::new(line.x.view(), n, (0, m), &p).unwrap().unwrap()).collect();
                let eig: Vec<_> = samples.iter().map(|s| s.eigenspace()).collect();
                for method in METHODS {
                    let z = core(&line, Parameters { method, ..base }, covariance);
                    let mut errs: Vec<(f64, String)> = vec![];
                    let mut largest = 0.0f64;
                    for n in 0..48 {
                        let s = &samples[n];
                        let e = &eig[n];
                        let w = &s.minimum_variance;
                        let l = w.len();
                        let exact: Vec<Complex<f64>> = match method {
                            Method::Das => vec![(0..m).map(|i| { let v = line.x[[n, i]]; Complex::new(v.re as f64, v.im as f64) }).sum::<Complex<f64>>() / m as f64],
                            Method::Mv => vec![s.output(w)],
                            Method::EsmvBeta(b) => e.ranks(b as f64, 1e-3).map(|r| s.output(&e.project(w, 0..r))).collect(),
                            Method::EsmvRank(r) => vec![s.output(&e.project(w, 0..r.min(l)))],
                            Method::EsmvRank1 => vec![s.output(&e.project(w, 0..1))],
                            Method::EsmvExcludeFirst => vec![s.output(&(w - e.project(w, 0..1)))],
                        };
                        let got = Complex::new(z[n].re as f64, z[n].im as f64);
                        let err = exact.iter().map(|x| (x - got).norm()).fold(f64::INFINITY, f64::min);
                        largest = largest.max(exact[0].norm());
                        let rank = match method { Method::EsmvBeta(b) => e.rank(b as f64), Method::EsmvRank(r) => r, _ => 1 };
                        let gap = if rank < l { e.values[rank] / e.values[rank - 1] } else { 0.0 };
                        errs.push((err, format!("n={n} l2/l1={:.5} rank={rank} gap={:.6} cands={}", e.second_to_first(), gap, exact.len())));
                    }
                    let worst = errs.iter().max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
                    println!("M={m} {covariance:?} K={temporal} {method:?} worst {:.2e} {}", worst.0 / largest, worst.1);
                }
            }
        }
    }
}
