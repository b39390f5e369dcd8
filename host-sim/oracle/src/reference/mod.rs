//! Two references that share no computation with the core or with each other.
//!
//! They only share the data types of a method, its parameters and a covariance.

/// Plain scalar loops in f32, equal to the core to the bit.
///
/// They have the order of operations that the core documents.
pub mod f32;
/// The equations in f64 with library linear algebra, to bound the error.
pub mod f64;
pub mod plain;
