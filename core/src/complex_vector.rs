//! Complex vectors: the type by itself, which the cast of memory needs.

/// As many complex numbers as a register holds real ones, one a lane.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct ComplexVector<V> {
    /// Real parts.
    pub re: V,
    /// Imaginary parts.
    pub im: V,
}
