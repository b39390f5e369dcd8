//! What is made of a sample's covariance and data: a file a method.

pub(super) mod das;
pub(super) mod esmv;
pub(super) mod mv;
