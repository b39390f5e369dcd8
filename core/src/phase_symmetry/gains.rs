//! A filter's gains for neighbouring columns: computed on the fly, or from tables.

use super::bank::PhaseSymmetry;
use super::fft::opposite;
use super::lines::load_partial;
use super::log_gabor::{LogGabor, MIRROR, ORIENTATIONS};
use crate::Error;
use crate::error::check_length;
use crate::simd::Vector;
use core::ops::Range;

/// Neighbouring columns of the spectrum, one a lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LaneColumns {
    /// Column of the half spectrum in the first lane.
    ///
    /// Each further lane has the next column.
    pub first: usize,
    /// Number of lanes in use.
    pub lanes: usize,
    /// Whether the lanes hold the opposite frequencies, from `columns − first` down.
    pub mirrored: bool,
}

impl LaneColumns {
    /// The strip of the columns; `None` if no strip has them.
    fn strip(&self, bank: &PhaseSymmetry) -> Option<Range<usize>> {
        let start = self.first.checked_div(bank.strip)? * bank.strip;
        let end = start.saturating_add(bank.strip).min(bank.sizes().half());
        let held = 1..=end.checked_sub(self.first)?;
        held.contains(&self.lanes).then_some(start..end)
    }
}

/// The gains of a bank of filters.
pub trait Gains<V: Vector> {
    /// Checks that the gains belong to this bank and image size.
    ///
    /// # Errors
    /// [`Error::Parameter`] for gains of another bank.
    fn check(&self, bank: &PhaseSymmetry) -> Result<(), Error>;

    /// Computes `gains[row]` of a filter for every row.
    ///
    /// `filter` is an index of [`PhaseSymmetry::filters`]. Unused lanes are undefined afterwards. The gains stay
    /// unchanged if the bank has no such filter, or no strip with these columns.
    fn fill(&self, bank: &PhaseSymmetry, filter: usize, columns: LaneColumns, gains: &mut [V]);
}

/// The positions of a filter's scale and orientation in the bank.
#[inline(always)]
fn scale_and_orientation(filter: usize) -> (usize, usize) {
    (filter / ORIENTATIONS.len(), filter % ORIENTATIONS.len())
}

/// On the fly: a division, two table look-ups and 7 multiplications a bin.
impl<V: Vector> Gains<V> for LogGabor<'_> {
    fn check(&self, _: &PhaseSymmetry) -> Result<(), Error> {
        Ok(())
    }

    fn fill(&self, bank: &PhaseSymmetry, filter: usize, columns: LaneColumns, gains: &mut [V]) {
        let (scale, orientation) = scale_and_orientation(filter);
        let known = bank.scales.iter().take(bank.scale_count).nth(scale);
        let (Some(scale), Some(orientation)) = (known, ORIENTATIONS.get(orientation)) else {
            return;
        };
        if columns.strip(bank).is_none() {
            return;
        }
        for lane in 0..columns.lanes {
            let column = if columns.mirrored {
                bank.columns - columns.first - lane
            } else {
                columns.first + lane
            };
            for (row, gain) in gains.iter_mut().enumerate() {
                if let Some(gain) = gain.lanes_mut().get_mut(lane) {
                    *gain = self.gain(scale, orientation, scale.bin(row, column));
                }
            }
        }
    }
}

/// The gains of a whole bank, computed once for many images.
///
/// The two factors of a gain are stored separately, since each has symmetries that their product lacks. The radial
/// factor is the same for the six orientations and for ±f of rows and columns, so a quarter of the grid suffices.
/// The angular factor is the same for all scales. At −fx it equals the factor of the mirrored orientation at fx, so
/// half of the grid suffices. The gains have the same bits as on the fly.
#[derive(Clone, Copy, Debug)]
pub struct GainTables<M> {
    bank: PhaseSymmetry,
    /// For each scale a quarter of radial factors, rows 0..=R/2 and columns 0..=C/2; then for each
    /// of [`TURNS`] a half of angular factors, all rows and columns 0..=C/2. Each in the bank's
    /// strips of columns, row after row.
    pub(crate) memory: M,
}

impl<M: AsRef<[f32]> + AsMut<[f32]>> GainTables<M> {
    /// Fills `memory`, a slice or a `Vec` of [`PhaseSymmetry::gain_tables_len`] numbers.
    ///
    /// Cost: half a division and less than five table look-ups per pixel.
    ///
    /// ```
    /// use bonebeam::prelude::stages::*;
    /// use bonebeam::phase_symmetry::{Parameters, Sizes};
    ///
    /// const SIZES: Sizes = Sizes { rows: 64, columns: 64, strip: 16 };
    /// const SCALES: [f64; 2] = [1.0 / 8.0, 1.0 / 16.0];
    /// let bank = PhaseSymmetry::new(&Parameters {
    ///     sizes: SIZES,
    ///     scales: &SCALES,
    ///     threshold: 3.0,
    /// })?;
    /// let mut memory = [0.0; SIZES.gain_tables_len(SCALES.len())];
    /// let mut tables = LogGaborTables::new();
    /// let gains = GainTables::new(&LogGabor::new(&mut tables), &bank, &mut memory[..])?;
    /// assert_eq!(gains.bank(), &bank);
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Length`] for memory of another length.
    pub fn new(filters: &LogGabor<'_>, bank: &PhaseSymmetry, mut memory: M) -> Result<Self, Error> {
        let tables = memory.as_mut();
        check_length("gain tables", tables.len(), bank.gain_tables_len())?;
        let half = bank.sizes().half();
        let quarter = half * (bank.rows / 2 + 1);
        let radial = bank.scale_count * quarter;
        let (radial, angular) = tables.split_at_mut_checked(radial).unwrap_or_default();
        let edges = bank.rows / 2 + 1;
        for columns in bank.column_strips() {
            let width = columns.len();
            for (scale, table) in bank
                .scales
                .iter()
                .zip(radial.chunks_exact_mut(quarter.max(1)))
            {
                let table = table.get_mut(edges * columns.start..edges * columns.end);
                let rows = table.unwrap_or_default().chunks_exact_mut(width.max(1));
                for (row, gains) in rows.enumerate() {
                    for (column, gain) in columns.clone().zip(gains) {
                        *gain = filters.radial(scale, scale.bin(row, column));
                    }
                }
            }
            let scale = &bank.scales[0];
            for row in 0..bank.rows {
                for column in columns.clone() {
                    let at = bank.rows * columns.start + row * width + column - columns.start;
                    let bin = scale.bin(row, column).direction();
                    // At the right edge this is the same frequency, and is never used.
                    let opposite = scale.bin(row, opposite(column, bank.columns));
                    let turns = ORIENTATIONS.iter().map(|orientation| (bin, orientation));
                    let mirrored = [0, 3].map(|k| (opposite.direction(), &ORIENTATIONS[k]));
                    let tables = angular.chunks_exact_mut((half * bank.rows).max(1));
                    for (table, (direction, orientation)) in tables.zip(turns.chain(mirrored)) {
                        let Some(gain) = table.get_mut(at) else {
                            break;
                        };
                        *gain = match direction {
                            Some(direction) => filters.angular(orientation, direction),
                            None => 0.0,
                        };
                    }
                }
            }
        }
        Ok(GainTables {
            bank: *bank,
            memory,
        })
    }

    /// The bank of the tables.
    pub fn bank(&self) -> &PhaseSymmetry {
        &self.bank
    }
}

impl<V: Vector, M: AsRef<[f32]>> Gains<V> for GainTables<M> {
    fn check(&self, bank: &PhaseSymmetry) -> Result<(), Error> {
        let of = |bank: &PhaseSymmetry| (bank.scale_count, bank.scales, bank.strip);
        if of(&self.bank) == of(bank) {
            return Ok(());
        }
        Err(Error::parameter(
            "number of scales of the gain tables",
            self.bank.scale_count as f64,
            "tables made for this image size, these scales and this strip height",
        ))
    }

    #[inline(always)]
    fn fill(&self, _: &PhaseSymmetry, filter: usize, columns: LaneColumns, gains: &mut [V]) {
        let (scale, orientation) = scale_and_orientation(filter);
        let (bank, memory) = (&self.bank, self.memory.as_ref());
        let (Some(strip), Some(&mirror)) = (columns.strip(bank), MIRROR.get(orientation)) else {
            return;
        };
        if scale >= bank.scale_count || gains.len() > bank.rows || columns.lanes > V::LANES {
            return;
        }
        let half = bank.sizes().half();
        let (edges, width) = (bank.rows / 2 + 1, strip.len());
        let table = if columns.mirrored {
            mirror
        } else {
            orientation
        };
        let split = memory.split_at_checked(bank.scale_count * half * edges);
        let (radial, angular) = split.unwrap_or_default();
        let radial = part(radial, (scale * half + strip.start) * edges, edges * width);
        let angular = part(
            angular,
            (table * half + strip.start) * bank.rows,
            bank.rows * width,
        );
        let (first, lanes) = (columns.first - strip.start, columns.lanes);
        if V::LANES == 1 && width == 1 {
            // The rows of −fy take the radial factors in reverse, except 0 and Nyquist.
            let (nearer, farther) = gains.split_at_mut(edges.min(gains.len()));
            let (of_nearer, of_farther) = angular.split_at(nearer.len().min(angular.len()));
            multiply::<V, false>(radial, of_nearer, nearer);
            let inner = radial.get(1..edges - 1).unwrap_or_default();
            multiply::<V, true>(inner, of_farther, farther);
            return;
        }
        let rows = angular.chunks_exact(width.max(1)).enumerate();
        for (gain, (row, angular)) in gains.iter_mut().zip(rows) {
            let nearer = row.min(bank.rows - row);
            let at = nearer * width + first;
            if V::LANES == 1 {
                let (Some(radial), Some(angular)) = (radial.get(at), angular.get(first)) else {
                    return;
                };
                *gain = gain.splat(radial * angular);
            } else {
                let radial = load_partial(*gain, radial, at, lanes);
                *gain = radial * load_partial(*gain, angular, first, lanes);
            }
        }
    }
}

/// The products of radial factors, in their order or reversed, and angular ones.
///
/// Four at a time: a loop of single numbers takes three times as many instructions on a Cortex-M7.
#[inline(always)]
fn multiply<V: Vector, const REVERSED: bool>(radial: &[f32], angular: &[f32], gains: &mut [V]) {
    let at = |k: usize, length: usize| if REVERSED { length - 1 - k } else { k };
    let (tiles, rest) = gains.as_chunks_mut::<4>();
    let (of_tiles, of_rest) = angular.as_chunks::<4>();
    let (radial_rest, radial_tiles) = if REVERSED {
        radial.as_rchunks::<4>()
    } else {
        let (tiles, rest) = radial.as_chunks::<4>();
        (rest, tiles)
    };
    for (tile, (gains, angular)) in tiles.iter_mut().zip(of_tiles).enumerate() {
        let Some(radial) = radial_tiles.get(at(tile, radial_tiles.len())) else {
            return;
        };
        for k in 0..4 {
            gains[k] = gains[k].splat(radial[at(k, 4)] * angular[k]);
        }
    }
    for (k, (gain, angular)) in rest.iter_mut().zip(of_rest).enumerate() {
        if let Some(radial) = radial_rest.get(at(k, radial_rest.len())) {
            *gain = gain.splat(radial * angular);
        }
    }
}

/// Gains of either kind, selected at run time, so that one map serves both.
#[allow(
    clippy::large_enum_variant,
    reason = "one in a frame, and there is no heap"
)]
#[derive(Debug)]
pub(crate) enum AnyGains<'m> {
    /// Gains computed on the fly.
    Computed(LogGabor<'m>),
    /// Gains from tables.
    Tables(GainTables<&'m mut [f32]>),
}

impl Gains<f32> for AnyGains<'_> {
    fn check(&self, bank: &PhaseSymmetry) -> Result<(), Error> {
        match self {
            AnyGains::Computed(filters) => Gains::<f32>::check(filters, bank),
            AnyGains::Tables(tables) => Gains::<f32>::check(tables, bank),
        }
    }

    fn fill(&self, bank: &PhaseSymmetry, filter: usize, columns: LaneColumns, gains: &mut [f32]) {
        match self {
            AnyGains::Computed(filters) => filters.fill(bank, filter, columns, gains),
            AnyGains::Tables(tables) => tables.fill(bank, filter, columns, gains),
        }
    }
}

/// The `length` numbers from `first` on, which must exist.
fn part(numbers: &[f32], first: usize, length: usize) -> &[f32] {
    let from = numbers.get(first..).unwrap_or_default();
    from.get(..length).unwrap_or_default()
}
