//! Two references that share no computation with the core or with each other.
//!
//! They only share the data types of a method, its parameters and a covariance.

/// Plain scalar loops in f32, in the order of operations that the core documents: equal to the bit.
pub mod f32;
/// Straight from the equations in f64, on library linear algebra: bounds the error.
pub mod f64;
