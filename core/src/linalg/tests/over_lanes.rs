//! Bits of a lane do not depend on the others.

use super::*;
use crate::simd::{InstructionSet, Mask, Vector};

/// The Lanczos iteration over lanes, which take the matrices in turn.
///
/// Returns the vectors' bits, and whether they converged.
fn lanczos_in_lanes<V: Vector>(zero: V, matrices: &[Matrix]) -> Vec<(Vec<u32>, bool)> {
    let mut columns: Vec<PanelColumn<V>> = Vec::new();
    for lane in 0..V::LANES {
        let own = panels::<f32>(&matrices[lane % matrices.len()]);
        columns.resize(own.len(), [zero; TILE]);
        for (column, own) in columns.iter_mut().zip(&own) {
            for (entry, own) in column.iter_mut().zip(own) {
                entry.lanes_mut()[lane] = *own;
            }
        }
    }
    let n = matrices[0].nrows();
    let mut v = vec![[zero; TILE]; n.div_ceil(TILE)];
    let mut basis = vec![[zero; TILE]; STEP_LIMIT * v.len()];
    let mut memory = [[zero; N]; 4];
    let memory = lanczos::Memory {
        basis: &mut basis,
        vector: &mut v,
        tridiagonal: &mut Tridiagonal::new(memory.each_mut().map(|x| &mut x[..])),
        kept: &mut [zero; N],
    };
    let (_, done) = lanczos::<_, _, STEP_LIMIT>(zero, &columns, n, memory, zero.less(zero));
    let bits = |lane: usize| {
        let rows = &v.as_flattened()[..n];
        rows.iter().map(|x| x.lanes()[lane].to_bits()).collect()
    };
    let lanes = 0..V::LANES;
    lanes.map(|lane| (bits(lane), done.lane(lane))).collect()
}

/// The first basis ends at once, and that lane is checked.
///
/// The second seems converged then, but is not checked: alone it takes another step. The third has no gap.
#[test]
fn a_lane_is_looked_at_as_if_it_were_alone() {
    let matrices = [[0.9, 0.1, 0.0], [0.9, 0.1, 1.3e-6], [0.5, 0.5, 0.3]].map(|[a, b, c]| {
        Matrix::from_fn(8, 8, |i, k| {
            Complex::from(match (i, k) {
                (0, 0) => a,
                (1, 1) => b,
                (0, 1) | (1, 0) => c,
                _ => 0.0,
            })
        })
    });
    let alone: Vec<_> = matrices
        .each_ref()
        .map(|a| lanczos_in_lanes(0.0_f32, std::slice::from_ref(a)).remove(0))
        .into();
    assert!(alone[0].1 && alone[1].1);
    assert_ne!(alone[0].0, alone[1].0);
    for set in InstructionSet::available() {
        let together = crate::dispatch!(set, zero => lanczos_in_lanes(zero, &matrices));
        for (lane, found) in together.iter().enumerate() {
            assert_eq!(found, &alone[lane % 3], "{set:?}, lane {lane}");
        }
    }
}
