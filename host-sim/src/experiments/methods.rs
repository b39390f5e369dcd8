//! The beamformers that the paper's figures compare.

use crate::config::{Beamform, Method};

use super::parameters::Receive;

/// One beamformer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beamformer {
    /// Its name in files and in the report's data.
    pub key: &'static str,
    /// Its name for people.
    pub name: &'static str,
    method: Method,
    beta: Option<f64>,
    exclude_first: bool,
}

/// DAS, MV, ESMV by β from 10 % to 0.001 %, rank-1 ESMV, and ESMV without λ₁, in this order.
pub const BEAMFORMERS: [Beamformer; 7] = [
    plain("das", "DAS", Method::Das),
    plain("mv", "MV", Method::Mv),
    by_beta("esmv-10", "ESMV β = 10 %", 0.1),
    by_beta("esmv-1", "ESMV β = 1 %", 0.01),
    by_beta("esmv-0.001", "ESMV β = 0.001 %", 1e-5),
    plain("esmv-rank1", "ESMV rank 1", Method::EsmvRank1),
    Beamformer {
        exclude_first: true,
        ..plain("esmv-without-first", "ESMV without λ₁", Method::EsmvRank1)
    },
];

const fn plain(key: &'static str, name: &'static str, method: Method) -> Beamformer {
    Beamformer {
        key,
        name,
        method,
        beta: None,
        exclude_first: false,
    }
}

const fn by_beta(key: &'static str, name: &'static str, beta: f64) -> Beamformer {
    Beamformer {
        beta: Some(beta),
        ..plain(key, name, Method::Esmv)
    }
}

impl Beamformer {
    /// The parameters of delay and beamformer.
    pub fn parameters(&self, receive: &Receive) -> Beamform {
        Beamform {
            beta: self.beta,
            exclude_first: self.exclude_first,
            ..receive.beamform(self.method)
        }
    }
}
