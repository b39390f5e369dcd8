//! Gain over depth.

use std::convert::Infallible;

use bonebeam_front_end::{GainCurve, Vcat, VcatRange, block};

/// A converter of 12 bits over 3 V.
struct Dac(Vec<u16>);

impl Vcat for Dac {
    type Error = Infallible;
    const MAX_CODE: u16 = 4095;

    fn full_scale(&self) -> f64 {
        3.0
    }

    async fn load(&mut self, codes: &[u16]) -> Result<(), Infallible> {
        self.0 = codes.to_vec();
        Ok(())
    }
}

/// From −50 dB by 10 dB a step: held at −40 dB, which is 1.5 V, then down to 0 V at full gain.
#[test]
fn gain_follows_depth() {
    let curve = GainCurve {
        start: -50.0,
        slope: 1e6,
        step: 10e-6,
    };
    let mut dac = Dac(vec![]);
    let mut codes = [0; 8];
    curve.codes(&dac, VcatRange::TI, &mut codes);
    block(dac.load(&codes)).unwrap();
    assert_eq!(dac.0, [2048, 2048, 1536, 1024, 512, 0, 0, 0]);
    // A converter that does not reach 1.5 V ends at its largest code.
    let high = VcatRange {
        volts: 6.0,
        ..VcatRange::TI
    };
    curve.codes(&dac, high, &mut codes);
    assert_eq!(codes[0], 4095);
}
