//! Householder reduction of a Hermitian matrix to a real tridiagonal one.
//!
//! `A = Q·D·T·Dᴴ·Qᴴ` with reflections `Q` and unit phases `D`; the matrix is stored in panels.
//!
//! Rows are reduced from the last to the second. In row `m`, with `c_j = A(j,m)` for `j < m`,
//! `α = c_{m−1}` and `t² = Σ_{j<m−1} |c_j|²`, the reflector is `v = c` except for
//! `v_{m−1} = p·(|α| + √(|α|²+t²))`, `p = α/|α|`, and `τ = 2/‖v‖²`; the block before loses `v·qᴴ` and
//! then `q·vᴴ`, `q = τAv − (½τ·vᴴ(τAv))·v`. Where `t²` is below `2⁻¹⁰⁰`, there is no reflection; where
//! `|α|²` is, `p = 1`. Sums over a vector (`t²`, `‖v‖²`, inner products) are partial sums as in
//! [`inner_product`]; those of `Av` ascend one by one.

use super::inner_product::inner_product;
use super::panels::{PanelColumn, TILE, Tile, columns_mut, panel, trace};
use super::tridiagonal::Tridiagonal;
use crate::simd::{ComplexVector, Scalar, Vector, copy};

/// Below this power (of a matrix with trace near 1) a row's tail and an entry count as zero: far
/// below the rounding errors, and far above where a square loses bits, with which reflections and
/// phases would not be of length 1.
const NOTHING: f32 = f32::from_bits((127 - 100) << 23); // 2^-100

/// Workspace and results of a reduction.
pub struct Reduction<'a, 't, S, V> {
    /// The matrix; its lower triangle is overwritten by the reflectors.
    ///
    /// `v_j` is at row `m`, column `j`, and `τ` on the diagonal.
    pub panels: &'a mut [PanelColumn<S>],
    /// Four numbers a row, the padding rows of the last panel included.
    pub vectors: &'a mut [S],
    /// Phases between the entries `m − 1` and `m` of `D`, at index `m`.
    pub phases: &'a mut [S],
    /// The tridiagonal matrix `T`.
    pub tridiagonal: &'a mut Tridiagonal<'t, V>,
}

impl<S: Scalar<V>, V: Vector> Reduction<'_, '_, S, V> {
    /// Reduces the matrix `a` of `n` rows less the mean of its diagonal.
    ///
    /// Returns the mean: the sum of the diagonal, ascending from zero, divided by `n`. The eigenvectors do not
    /// change. Errors are a fraction of the largest entry, so they shrink if the eigenvalues lie close together and
    /// far from zero.
    ///
    /// Each pass over the matrix applies the last reflection and multiplies the result by the next reflector. The
    /// matrix is therefore read and written once per row.
    ///
    /// Cost: `4n³/3` flops real, `16n³/3` complex; `n` roots and divisions.
    #[inline(always)]
    pub fn reduce(&mut self, zero: V, a: &[PanelColumn<S>], n: usize) -> V {
        let columns = panel(n.div_ceil(TILE));
        if let (Some(panels), Some(a)) = (self.panels.get_mut(..columns), a.get(..columns)) {
            copy(a, panels);
        }
        let mean = trace(zero, a, n) / zero.splat(n as f32);
        // The rows that fill up the last panel take no part.
        for i in 0..n.div_ceil(TILE) {
            if let Some((_, tile)) = columns_mut(self.panels, i) {
                for r in 0..TILE {
                    tile[r][r] = S::from_real(tile[r][r].real() - mean);
                }
            }
        }
        self.reflect(zero, n);
        mean
    }

    #[inline(always)]
    fn reflect(&mut self, zero: V, n: usize) {
        let Reduction {
            panels: a,
            vectors,
            phases,
            tridiagonal,
        } = self;
        let Tridiagonal {
            diagonal,
            off_diagonal,
            ..
        } = tridiagonal;
        let padded = n.next_multiple_of(TILE);
        let Some(vectors) = vectors.get_mut(..4 * padded) else {
            return;
        };
        let (Some(diagonal), Some(off_diagonal), Some(phases)) = (
            diagonal.get_mut(..n),
            off_diagonal.get_mut(..n),
            phases.get_mut(..n),
        ) else {
            return;
        };
        // The first two.
        if let Some(vectors) = vectors.get_mut(..2 * padded) {
            vectors.fill(S::from_real(zero));
        }
        let mut vectors = vectors.chunks_exact_mut(padded.max(1));
        let (Some(mut v), Some(mut q), Some(mut u), Some(mut p)) = (
            vectors.next(),
            vectors.next(),
            vectors.next(),
            vectors.next(),
        ) else {
            return;
        };
        for m in (1..n).rev() {
            let panels = m.div_ceil(TILE);
            let end = TILE * panels;
            let (Some(row), Some(entry)) = (row_mut(a, m), diagonal.get_mut(m)) else {
                return;
            };
            if m >= padded || end > padded {
                return;
            }
            let (vm, qm) = (v[m], q[m]);
            let (u_tiles, _) = u.as_chunks_mut::<TILE>();
            let before = v.as_chunks::<TILE>().0.iter().zip(q.as_chunks::<TILE>().0);
            for (columns, (u, (v, q))) in row.iter().zip(u_tiles.iter_mut().zip(before)) {
                for k in 0..TILE {
                    let entry = columns[k][m % TILE] - vm.mul_conj(q[k]);
                    u[k] = (entry - qm.mul_conj(v[k])).conj();
                }
            }
            *entry = u[m].real();
            // The row keeps the reflector from here on.
            (v[m], q[m]) = (S::from_real(zero), S::from_real(zero));
            let alpha = u[m - 1];
            // The reflector ends at m − 1; zeros fill up the panel.
            clear_tile(zero, u, m - 1);
            let (length, phase) = polar(alpha);
            let (tiles, _) = u[..end].as_chunks();
            let tail = inner_product(zero, tiles, tiles).real();
            // A lane whose row is reduced already keeps its block: τ = 0.
            let reduced = tail.less(zero.splat(NOTHING));
            let reach = (length * length + tail).sqrt();
            let first = length + reach;
            u[m - 1] = phase.scale(first);
            let power = V::select(reduced, zero.splat(1.0), tail + first * first);
            let tau = V::select(reduced, zero, zero.splat(2.0) / power);
            off_diagonal[m - 1] = V::select(reduced, length, reach);
            phases[m] = S::select(reduced, phase, S::from_real(zero) - phase);
            for (columns, u) in row.iter_mut().zip(u.as_chunks::<TILE>().0) {
                for k in 0..TILE {
                    columns[k][m % TILE] = u[k];
                }
            }
            if let Some(columns) = row.last_mut() {
                columns[m % TILE][m % TILE] = S::from_real(tau);
            }

            update_and_multiply(zero, a, m, [&*v, &*q, &*u], p);
            // Not the rows that are done.
            if m % TILE > 0 {
                clear_tile(zero, p, m);
            }
            update_vector(tau, u[..end].as_chunks().0, p[..end].as_chunks_mut().0);
            (v, u) = (u, v);
            (q, p) = (p, q);
        }
        if let ([first, ..], [column, ..], [v, ..], [q, ..]) = (diagonal, &**a, &*v, &*q) {
            *first = ((column[0] - v.mul_conj(*q)) - q.mul_conj(*v)).real();
        }
    }

    /// `x ← Q·D·x`.
    #[inline(always)]
    pub fn transform_back(&mut self, zero: V, n: usize) {
        let (Some(x), Some(phases)) = (self.vectors.get_mut(..n), self.phases.get(..n)) else {
            return;
        };
        let mut phase = S::from_real(zero.splat(1.0));
        for m in 1..n {
            let (Some((diagonal, row)), Some((before, [own, ..]))) =
                (row(self.panels, m), x.split_at_mut_checked(m))
            else {
                return;
            };
            let mut sums = [S::from_real(zero); TILE];
            let (tiles, last) = before.as_chunks::<TILE>();
            let (row_tiles, last_row) = row.as_chunks::<TILE>();
            for (tile, x) in row_tiles.iter().zip(tiles) {
                for r in 0..TILE {
                    sums[r] = sums[r] + x[r].mul_conj(tile[r][m % TILE]);
                }
            }
            for (sum, (column, &x)) in sums.iter_mut().zip(last_row.iter().zip(last)) {
                *sum = *sum + x.mul_conj(column[m % TILE]);
            }
            let tau = diagonal[m % TILE].real();
            let along = ((sums[0] + sums[1]) + (sums[2] + sums[3])).scale(tau);
            for (x, column) in before.iter_mut().zip(row) {
                *x = *x - column[m % TILE].mul(along);
            }
            // T(m−1,m) = D(m−1)*·t·D(m) is real and positive.
            phase = phase.mul_conj(phases[m]);
            *own = own.mul(phase);
        }
    }

    /// `x ← Dᴴ·Qᴴ·x` for two vectors of `n` entries.
    ///
    /// The first has the matrix's number type. Each reflector is read once for both.
    #[inline(always)]
    pub fn project(&self, zero: V, n: usize, x: &mut [S], y: &mut [ComplexVector<V>]) {
        let (Some(x), Some(y), Some(phases)) =
            (x.get_mut(..n), y.get_mut(..n), self.phases.get(..n))
        else {
            return;
        };
        for m in (1..n).rev() {
            let (Some((last, row)), Some(x), Some(y)) =
                (tiles(self.panels, m), x.get_mut(..m), y.get_mut(..m))
            else {
                return;
            };
            let tau = last[m % TILE][m % TILE].real();
            let ((x, last_x), (y, last_y)) = (x.as_chunks_mut::<TILE>(), y.as_chunks_mut::<TILE>());
            let mut x_sums = [S::from_real(zero); TILE];
            let mut y_sums = [ComplexVector::from_real(zero); TILE];
            for (tile, (x, y)) in row.iter().zip(x.iter().zip(&*y)) {
                for k in 0..TILE {
                    let entry = tile[k][m % TILE];
                    x_sums[k] = x_sums[k] + x[k].mul_conj(entry);
                    y_sums[k] = y_sums[k] + entry.conj_mul_complex(y[k]);
                }
            }
            for k in 0..TILE {
                if let (Some(&x), Some(&y)) = (last_x.get(k), last_y.get(k)) {
                    let entry = last[k][m % TILE];
                    x_sums[k] = x_sums[k] + x.mul_conj(entry);
                    y_sums[k] = y_sums[k] + entry.conj_mul_complex(y);
                }
            }
            let along_x = ((x_sums[0] + x_sums[1]) + (x_sums[2] + x_sums[3])).scale(tau);
            let along_y = ((y_sums[0] + y_sums[1]) + (y_sums[2] + y_sums[3])).scale(tau);
            for (tile, (x, y)) in row.iter().zip(x.iter_mut().zip(y)) {
                for k in 0..TILE {
                    let entry = tile[k][m % TILE];
                    x[k] = x[k] - entry.mul(along_x);
                    y[k] = y[k] - entry.mul_complex(along_y);
                }
            }
            for k in 0..TILE {
                if let (Some(x), Some(y)) = (last_x.get_mut(k), last_y.get_mut(k)) {
                    let entry = last[k][m % TILE];
                    *x = *x - entry.mul(along_x);
                    *y = *y - entry.mul_complex(along_y);
                }
            }
        }
        let mut phase = S::from_real(zero.splat(1.0));
        for ((x, y), &next) in x.iter_mut().zip(y).zip(phases).skip(1) {
            phase = phase.mul_conj(next);
            *x = x.mul_conj(phase);
            *y = phase.conj_mul_complex(*y);
        }
    }
}

/// Zeros from entry `first` of a vector to the end of its tile.
///
/// No later row reads the entries behind it.
#[inline(always)]
fn clear_tile<S: Scalar<V>, V: Vector>(zero: V, x: &mut [S], first: usize) {
    if let Some(tile) = x.as_chunks_mut::<TILE>().0.get_mut(first / TILE) {
        for (k, entry) in tile.iter_mut().enumerate() {
            if k >= first % TILE {
                *entry = S::from_real(zero);
            }
        }
    }
}

/// Row `m` of the panels up to the diagonal: its entry there, and the columns before.
#[inline(always)]
fn row<S>(a: &[PanelColumn<S>], m: usize) -> Option<(&PanelColumn<S>, &[PanelColumn<S>])> {
    a.get(panel(m / TILE)..)?.get(..=m)?.split_last()
}

/// The panel that row `m` is in: its diagonal tile, and the tiles before.
#[inline(always)]
fn tiles<S>(a: &[PanelColumn<S>], m: usize) -> Option<(&Tile<S>, &[Tile<S>])> {
    let (tiles, _) = a.get(panel(m / TILE)..)?.as_chunks();
    tiles.get(..=m / TILE)?.split_last()
}

/// [`tiles`] to be written, all together.
#[inline(always)]
fn row_mut<S>(a: &mut [PanelColumn<S>], m: usize) -> Option<&mut [Tile<S>]> {
    let (tiles, _) = a.get_mut(panel(m / TILE)..)?.as_chunks_mut();
    tiles.get_mut(..=m / TILE)
}

/// `|α|` and `α/|α|`.
#[inline(always)]
fn polar<S: Scalar<V>, V: Vector>(alpha: S) -> (V, S) {
    let one = alpha.real().splat(1.0);
    if S::PARTS == 1 {
        let negative = alpha.real().less(one.zero());
        (
            alpha.real().abs(),
            S::from_real(V::select(negative, -one, one)),
        )
    } else {
        let power = alpha.norm_sqr();
        let nothing = power.less(one.splat(NOTHING));
        let length = power.sqrt();
        let reciprocal = one / V::select(nothing, one, length);
        (
            length,
            S::select(nothing, S::from_real(one), alpha.scale(reciprocal)),
        )
    }
}

/// Makes `q = τ·p − (τ/2·uᴴ(τ·p))·u` of `p`, the matrix times the reflector `u`: the matrix less `v·qᴴ + q·vᴴ` with
/// `v = u` is the reflected one.
#[inline(always)]
fn update_vector<S: Scalar<V>, V: Vector>(tau: V, u: &[PanelColumn<S>], p: &mut [PanelColumn<S>]) {
    for p in p.as_flattened_mut() {
        *p = p.scale(tau);
    }
    let half = tau.splat(0.5) * tau * inner_product(tau.zero(), u, p).real();
    for (p, u) in p.iter_mut().zip(u) {
        for k in 0..TILE {
            p[k] = p[k] - u[k].scale(half);
        }
    }
}

/// `A ← (A − v·qᴴ) − q·vᴴ`, then `p = A·u`, over the first `rows`: one pass over the lower triangle.
///
/// As many rows go together as keep their entries of `v`, `q` and `u` and their sums in half of the
/// registers; more of them would be read from memory again in every column.
#[inline(always)]
fn update_and_multiply<S: Scalar<V>, V: Vector>(
    zero: V,
    a: &mut [PanelColumn<S>],
    rows: usize,
    vectors: [&[S]; 3],
    p: &mut [S],
) {
    match V::REGISTERS / (8 * S::PARTS) {
        TILE.. => update_and_multiply_rows::<S, V, TILE>(zero, a, rows, vectors, p),
        2..TILE => update_and_multiply_rows::<S, V, 2>(zero, a, rows, vectors, p),
        _ => update_and_multiply_rows::<S, V, 1>(zero, a, rows, vectors, p),
    }
}

#[inline(always)]
fn update_and_multiply_rows<S: Scalar<V>, V: Vector, const ROWS: usize>(
    zero: V,
    a: &mut [PanelColumn<S>],
    rows: usize,
    [v, q, u]: [&[S]; 3],
    p: &mut [S],
) {
    for start in (0..rows).step_by(ROWS) {
        let first = start % TILE;
        let (Some(own_v), Some(own_q), Some(own_u)) = (
            entries::<S, ROWS>(v, start),
            entries::<S, ROWS>(q, start),
            entries::<S, ROWS>(u, start),
        ) else {
            return;
        };
        // The columns before the rows' diagonal block, and those of the block.
        let Some(columns) = a.get_mut(panel(start / TILE)..) else {
            return;
        };
        let columns = columns.get_mut(..start + ROWS).unwrap_or_default();
        let Some((before, diagonal)) = columns.split_last_chunk_mut::<ROWS>() else {
            return;
        };
        let mut sums = [S::from_real(zero); ROWS];
        let columns = before.iter_mut().zip(p.iter_mut());
        for ((column, p), (&v, (&q, &u))) in columns.zip(v.iter().zip(q.iter().zip(u))) {
            let mut mirrored = *p;
            for r in 0..ROWS {
                let entry = (column[first + r] - own_v[r].mul_conj(q)) - own_q[r].mul_conj(v);
                column[first + r] = entry;
                sums[r] = sums[r] + entry.mul(u);
                mirrored = mirrored + own_u[r].mul_conj(entry);
            }
            *p = mirrored;
        }
        for r in 0..ROWS {
            for c in 0..=r {
                let entry = diagonal[c][first + r] - own_v[r].mul_conj(own_q[c]);
                let entry = entry - own_q[r].mul_conj(own_v[c]);
                diagonal[c][first + r] = entry;
                sums[r] = sums[r] + entry.mul(own_u[c]);
                if c < r {
                    sums[c] = sums[c] + own_u[r].mul_conj(entry);
                }
            }
        }
        if let Some(own) = p.get_mut(start..).and_then(|p| p.first_chunk_mut()) {
            *own = sums;
        }
    }
}

/// The entries of a vector from `start` on.
#[inline(always)]
fn entries<S: Copy, const ROWS: usize>(x: &[S], start: usize) -> Option<[S; ROWS]> {
    x.get(start..)?.first_chunk().copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_entry_whose_power_is_below_300_db_has_the_phase_of_one() {
        let least = 1.0 / (1u64 << 50) as f32;
        let entry = |im: f32| ComplexVector::new(0.0, im);
        let (length, phase) = polar(entry(-least));
        assert_eq!((length, phase.re, phase.im), (least, 0.0, -1.0));
        let (_, phase) = polar(entry(-least.next_down()));
        assert_eq!((phase.re, phase.im), (1.0, 0.0));
    }
}
