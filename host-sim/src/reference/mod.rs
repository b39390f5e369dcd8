//! Two references that share no code with the core or with each other.

/// Plain scalar loops in f32, in the order of operations that the core documents: equal to the bit.
pub mod f32;
/// Straight from the equations in f64, on library linear algebra: bounds the error.
pub mod f64;
