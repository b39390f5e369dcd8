//! The band of the echoes: carrier, sampling rate and sign.

use bonebeam_files::{ChannelData, Samples};

use crate::base::Base;
use crate::finding::{Finding, Severity};
use crate::order::GAIN;
use crate::table::Table;
use crate::view::View;

/// Base band at the frequency, rate and sign of the echoes, and a finding if they are not the file's.
pub(crate) fn check(
    data: &ChannelData,
    chosen: &[usize],
    view: &View,
) -> (Base, View, Vec<Finding>) {
    let own = Base::new(data, chosen, data.f0, data.fs);
    let of = |base: &Base, view: &View| Table::new(base, view);
    if let Samples::Iq { f_demod, .. } = data.samples {
        return iq(data, chosen, view, own, f_demod);
    }
    let table = of(&own, view);
    let mut best = (1.0, table.coherent_power());
    for factor in [2.0, 0.5] {
        if factor * data.f0 < 0.5 * data.fs {
            let base = Base::new(data, chosen, factor * data.f0, data.fs);
            let power = of(&base, view).coherent_power();
            if power > 2.0 * best.1 {
                best = (factor, power);
            }
        }
    }
    if best.0 == 1.0 {
        return (own, view.clone(), Vec::new());
    }
    let (factor, _) = best;
    let harmonic = Base::new(data, chosen, factor * data.f0, data.fs);
    let rate = Base::new(data, chosen, data.f0, data.fs / factor);
    let mhz = |f: f64| format!("{:.3} MHz", f / 1e6);
    if of(&rate, view).score() > of(&harmonic, view).score() {
        let text = format!(
            "echoes lie at {} and their curvature fits half or twice the rate: `fs` is {} and not {}",
            mhz(factor * data.f0),
            mhz(data.fs / factor),
            mhz(data.fs)
        );
        let finding =
            Finding::new("sampling-rate", Severity::Error, text).valued(data.fs / factor, "Hz");
        return (
            rate,
            view.clone(),
            vec![finding.remedy(format!("--variable fs={:e}", data.fs / factor))],
        );
    }
    let found = factor * data.f0;
    let text = format!(
        "echoes lie at {} and not at `f0`, {}: of a harmonic, `f0` is the received frequency",
        mhz(found),
        mhz(data.f0)
    );
    let finding = Finding::new("harmonic", Severity::Error, text).valued(found, "Hz");
    (
        harmonic,
        view.clone(),
        vec![finding.remedy(format!("--variable f0={found:e}"))],
    )
}

fn iq(
    data: &ChannelData,
    chosen: &[usize],
    view: &View,
    own: Base,
    f_demod: f64,
) -> (Base, View, Vec<Finding>) {
    let score = Table::new(&own, view).score();
    let conjugate = View {
        conjugate: true,
        ..view.clone()
    };
    let turned = Table::new(&own, &conjugate).score();
    if turned > score + GAIN {
        let text = format!(
            "I/Q has the other sign of the carrier: neighbours' coherence {turned:.2} and not {score:.2}"
        );
        let finding =
            Finding::new("carrier-sign", Severity::Error, text).valued(turned - score, "coherence");
        return (own, conjugate, vec![finding.remedy("--iq-conjugate")]);
    }
    for factor in [2.0, 0.5] {
        let base = Base::new(data, chosen, f_demod, factor * data.fs);
        let other = Table::new(&base, view).score();
        if other > score + GAIN {
            let text = format!(
                "the curvature of echoes fits an `fs` of {} Hz and not {}",
                factor * data.fs,
                data.fs
            );
            let finding =
                Finding::new("sampling-rate", Severity::Error, text).valued(factor * data.fs, "Hz");
            return (
                base,
                view.clone(),
                vec![finding.remedy(format!("--variable fs={:e}", factor * data.fs))],
            );
        }
    }
    (own, view.clone(), Vec::new())
}
