//! Power iteration: an approximate dominant eigenpair in a fixed number of steps.
//!
//! The operations do not depend on the matrix: no step is skipped, and no lane waits for another. Power iteration suits
//! hard real time and hardware without branches. The error falls by `λ₂/λ₁` per step; docs/numerics.md lists it over
//! gaps and steps.
//!
//! - **Start**: the unit vector `u` of coordinate 0 or 1 with the larger diagonal entry (as in
//!   [`lanczos`](super::lanczos)), so that the first step's product is a column of the matrix.
//! - **Step**: `v ← A·v/‖A·v‖`, without a shift.
//! - **Result**: after `N` steps `v` is along `Aᴺu`, and the eigenvalue is the last `‖A·v‖`.
//!
//! A loaded matrix maps a unit vector to at least its loading, so no length is 0. A caller with a loading of 0
//! checks that the result is finite. Nothing overflows: the trace is below 2, and the loading at most 10⁶ times
//! that.

use super::inner_product::inner_product;
use super::matrix_vector::times_vector;
use super::panels::{PanelColumn, TILE, panel};
use crate::simd::{Scalar, Vector};

/// Takes `steps` steps (at least one) with the matrix `a` of `n` rows.
///
/// Leaves the unit vector in `vector`, with zeros in the padding rows of the last panel. Returns the eigenvalue;
/// `None` for an empty matrix. `product` is scratch as long as `vector`.
///
/// Cost per step: `2n` flops real (`4n` complex) for the length and `n` (`2n`) for the division; `2n²` (`8n²`) for the
/// product, except in the first step.
#[inline(always)]
pub fn power_iteration<S: Scalar<V>, V: Vector>(
    a: &[PanelColumn<S>],
    n: usize,
    steps: usize,
    vector: &mut [PanelColumn<S>],
    product: &mut [PanelColumn<S>],
) -> Option<V> {
    let zero = a.first()?[0].real().zero();
    start(zero, a, n, product);
    let mut eigenvalue = normalise(zero, product, vector);
    for _ in 1..steps {
        times_vector(a, zero, vector, product);
        eigenvalue = normalise(zero, product, vector);
    }
    Some(eigenvalue)
}

/// `A·u`: the first column, or the second if its diagonal entry is larger.
#[inline(always)]
fn start<S: Scalar<V>, V: Vector>(
    zero: V,
    a: &[PanelColumn<S>],
    n: usize,
    product: &mut [PanelColumn<S>],
) {
    let second = match a {
        [first, next, ..] if n > 1 => first[0].real().less(next[1].real()),
        _ => zero.mask(|_| false),
    };
    for (i, product) in product.iter_mut().enumerate() {
        if let Some([first, next, ..]) = a.get(panel(i)..) {
            for r in 0..TILE {
                product[r] = S::select(second, next[r], first[r]);
            }
        }
    }
}

/// The product as a unit vector; returns its length.
#[inline(always)]
fn normalise<S: Scalar<V>, V: Vector>(
    zero: V,
    product: &[PanelColumn<S>],
    vector: &mut [PanelColumn<S>],
) -> V {
    let length = inner_product(zero, product, product).real().sqrt();
    let reciprocal = zero.splat(1.0) / length;
    for (v, p) in vector.iter_mut().zip(product) {
        for r in 0..TILE {
            v[r] = p[r].scale(reciprocal);
        }
    }
    length
}
