//! Vectors of complex numbers, and their type for casts of memory.

/// One complex number in each lane: a register of real and one of imaginary parts.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct ComplexVector<V> {
    /// Real parts.
    pub re: V,
    /// Imaginary parts.
    pub im: V,
}
