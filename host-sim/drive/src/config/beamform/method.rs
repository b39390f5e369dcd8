//! The section's method, as the core's and back.

use bonebeam::beamform::Method;

use super::super::core::plain;
use super::Beamform;
use crate::methods::{MethodName, default_beta};

impl Beamform {
    /// The core's method.
    pub fn core_method(&self) -> Method {
        match (self.method, self.rank, self.power_steps) {
            (MethodName::Das, ..) => Method::Das,
            (MethodName::Mv, ..) => Method::Mv,
            (MethodName::Esmv, Some(rank), _) => Method::EsmvRank(rank),
            (MethodName::Esmv, None, _) => {
                Method::EsmvBeta(self.beta.unwrap_or(default_beta()) as f32)
            }
            (MethodName::EsmvRank1, ..) if self.exclude_first => Method::EsmvExcludeFirst,
            (MethodName::EsmvRank1, _, Some(steps)) => Method::EsmvRank1Steps(steps),
            (MethodName::EsmvRank1, _, None) => Method::EsmvRank1,
        }
    }

    /// The default with a method of the core.
    pub fn of_method(method: Method) -> Self {
        let name = match method {
            Method::Das => MethodName::Das,
            Method::Mv => MethodName::Mv,
            Method::EsmvBeta(_) | Method::EsmvRank(_) => MethodName::Esmv,
            _ => MethodName::EsmvRank1,
        };
        let mut section = Beamform {
            method: name,
            ..Beamform::default()
        };
        match method {
            Method::EsmvBeta(beta) => section.beta = Some(plain(beta)),
            Method::EsmvRank(rank) => section.rank = Some(rank),
            Method::EsmvRank1Steps(steps) => section.power_steps = Some(steps),
            Method::EsmvExcludeFirst => section.exclude_first = true,
            Method::Das | Method::Mv | Method::EsmvRank1 => {}
        }
        section
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_of_the_core_can_be_asked_for() {
        for method in Method::EXAMPLES {
            assert_eq!(Beamform::of_method(method).core_method(), method);
        }
    }
}
