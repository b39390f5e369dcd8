//! Log-Gabor filters (Eq. 9) from tables that fit a microcontroller.
//!
//! A filter is a radial times an angular factor, each a function of one variable:
//!
//! - The radial factor depends only on `m = (r/r₀)²`: `exp(−½·(½·ln m / ln 0.15)²)`. One table serves every scale.
//!   Its segments are those of a float: 16 an octave of `m`, found from its bits.
//! - The angular factor depends on the angle from the filter's orientation. The direction is given by one of four
//!   faces (right, up, left, down: the nearer axis) and `t = tan` of the angle from that axis, in `[−1, 1]`,
//!   divided into 64 segments. Turns by 90° change the face and reflections the sign of `t`, so the tables of 0 and
//!   −π/6 serve all six orientations.
//!
//! Each segment holds the cubic through four equidistant points of the exact function, evaluated as `c₀ + x·(c₁ +
//! x·(c₂ + x·c₃))`. The gain errs by at most 2.5·10⁻⁷ of the filter's peak. A table per filter over a 512×512 grid
//! would need 1 MiB; these need 17.9 kB for all filters of all sizes.

use super::fft::{LARGE_MAPS, is_supported};
use crate::Error;

/// Segments an octave of `m`; the top bits of a float's mantissa number them.
const RADIAL_SEGMENTS: usize = 1 << RADIAL_BITS;
const RADIAL_BITS: u32 = 4;
/// `m` runs from 2⁻¹⁸ (the lowest frequency, 1/1024, at r₀ = 1/2) to 2¹⁹ (the corner of the
/// spectrum at r₀ = 2⁻¹⁰).
const LOWEST_OCTAVE: i32 = -18;
const OCTAVES: usize = 38;
/// Segments of `t` from −1 to 1.
const ANGULAR_SEGMENTS: usize = 64;

type Cubic = [f32; 4];
type Angular = [[Cubic; ANGULAR_SEGMENTS]; 4];

/// The tables, computed by `tests::record`.
///
/// A microcontroller without f64 in hardware needed 30 million instructions to compute them.
static TABLES: LogGaborTables = LogGaborTables::of(include_bytes!("log_gabor.bin"));

/// Caller-owned memory for the tables of [`LogGabor`].
///
/// ```
/// use bonebeam::phase_symmetry::{LogGabor, LogGaborTables};
///
/// let mut tables = LogGaborTables::new();
/// let filters = LogGabor::new(&mut tables);
/// # let _ = filters;
/// assert_eq!(LogGaborTables::BYTES, 17_920);
/// ```
#[derive(Clone, Debug)]
pub struct LogGaborTables {
    radial: [Cubic; OCTAVES * RADIAL_SEGMENTS],
    angular: [Angular; 2],
}

/// Filters ready for use, with filled tables.
#[derive(Clone, Copy, Debug)]
pub struct LogGabor<'a> {
    tables: &'a LogGaborTables,
}

/// A direction `θ₀` of the bank: 0 is to the right, −π/2 down the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Orientation {
    radians: f64,
    table: usize,
    /// `θ − θ₀` is the table's angle at `face + turn`, `t`, or at `turn − face`, `−t`.
    mirrored: bool,
    turn: usize,
}

/// The bank's orientations: 0 and −π/2 + kπ/6 for k = 2, 1, 0, −1, −2, in the order in which
/// [`super::PhaseSymmetry`] adds them up.
pub(super) const ORIENTATIONS: [Orientation; 6] = {
    use core::f64::consts::PI;
    const fn orientation(radians: f64, table: usize, mirrored: bool, turn: usize) -> Orientation {
        Orientation {
            radians,
            table,
            mirrored,
            turn,
        }
    }
    [
        orientation(0.0, 0, false, 0),
        orientation(-PI / 6.0, 1, false, 0),
        orientation(-PI / 3.0, 1, true, 3),
        orientation(-PI / 2.0, 0, false, 1),
        orientation(-2.0 * PI / 3.0, 1, false, 1),
        orientation(-5.0 * PI / 6.0, 1, true, 2),
    ]
};

/// Number of angular factors in [`super::GainTables`].
///
/// These are [`ORIENTATIONS`], then the mirror images of 0 and −π/2. The mirror image of 0 is not in the bank, and
/// that of −π/2 has other bits than −π/2 itself.
pub(super) const TURNS: usize = ORIENTATIONS.len() + 2;
/// Index of each orientation's mirror image.
pub(super) const MIRROR: [usize; ORIENTATIONS.len()] = [6, 5, 4, 7, 2, 1];

/// A characteristic radius on the frequency grid of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Scale {
    rows: usize,
    columns: usize,
    /// Frequencies are counted in units of 1/max(rows, columns) cycles a pixel, so that they and
    /// the sum of their squares are whole numbers, exact in f32.
    row_step: f32,
    column_step: f32,
    /// `m` per squared unit.
    per_square: f32,
}

/// A frequency of the grid, the vertical axis up: angles are counted that way, rows go down.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bin {
    u: f32,
    v: f32,
}

/// Direction of a frequency: a face, and the tangent of the angle from its axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Direction {
    face: usize,
    t: f32,
}

impl Scale {
    /// The characteristic radius `r0` (cycles per pixel) for images of a size.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a side that is not a power of two in 64..=1024, and for `r0`
    /// outside 2⁻¹⁰..=2⁻¹.
    pub(super) fn new(rows: usize, columns: usize, r0: f64) -> Result<Self, Error> {
        Self::check(rows, columns, r0)?;
        let longest = rows.max(columns);
        let radius = r0 * longest as f64;
        Ok(Scale {
            rows,
            columns,
            row_step: (longest / rows) as f32,
            column_step: (longest / columns) as f32,
            per_square: (1.0 / (radius * radius)) as f32,
        })
    }

    /// Checks what [`Scale::new`] takes.
    pub(super) const fn check(rows: usize, columns: usize, r0: f64) -> Result<(), Error> {
        let sides = [("image rows", rows), ("image columns", columns)];
        let mut k = 0;
        while k < sides.len() {
            let (name, side) = sides[k];
            if !is_supported(side) {
                let expected = match LARGE_MAPS {
                    true => "a power of two: 64, 128, 256, 512 or 1024",
                    false => "64 without the feature large-maps",
                };
                return Err(Error::parameter(name, side as f64, expected));
            }
            k += 1;
        }
        if r0 >= 1.0 / 1024.0 && r0 <= 0.5 {
            return Ok(());
        }
        let expected = "from 2^-10 to 2^-1";
        Err(Error::parameter("scale in cycles per pixel", r0, expected))
    }

    /// The frequency of a bin: `column` k stands for k/N cycles a pixel below N/2 and (k − N)/N
    /// from there on, and so do the rows.
    pub(super) fn bin(&self, row: usize, column: usize) -> Bin {
        Bin {
            u: self.column_step * signed(column, self.columns),
            v: -(self.row_step * signed(row, self.rows)),
        }
    }
}

impl Bin {
    /// The squared distance from the zero frequency.
    fn square(self) -> f32 {
        self.u * self.u + self.v * self.v
    }

    /// `None` at the zero frequency.
    pub(super) fn direction(self) -> Option<Direction> {
        let Bin { u, v } = self;
        if self.square() == 0.0 {
            return None;
        }
        let (face, t) = if v.abs() <= u.abs() {
            (if u > 0.0 { 0 } else { 2 }, v / u)
        } else {
            (if v > 0.0 { 1 } else { 3 }, -(u / v))
        };
        Some(Direction { face, t })
    }
}

impl LogGaborTables {
    /// Size of the tables in bytes.
    pub const BYTES: usize = size_of::<Self>();

    /// From the numbers in memory order, each its bytes from the lowest on.
    const fn of(bytes: &[u8; Self::BYTES]) -> Self {
        let mut tables = Self::new();
        let mut at = 0;
        let mut k = 0;
        while k < tables.radial.len() {
            (tables.radial[k], at) = cubic_at(bytes, at);
            k += 1;
        }
        let mut table = 0;
        while table < tables.angular.len() {
            let mut face = 0;
            while face < tables.angular[table].len() {
                let mut k = 0;
                while k < ANGULAR_SEGMENTS {
                    (tables.angular[table][face][k], at) = cubic_at(bytes, at);
                    k += 1;
                }
                face += 1;
            }
            table += 1;
        }
        tables
    }

    /// Memory for [`LogGabor::new`] to fill.
    pub const fn new() -> Self {
        LogGaborTables {
            radial: [[0.0; 4]; OCTAVES * RADIAL_SEGMENTS],
            angular: [[[[0.0; 4]; ANGULAR_SEGMENTS]; 4]; 2],
        }
    }
}

impl Default for LogGaborTables {
    fn default() -> Self {
        Self::new()
    }
}

impl LogGabor<'static> {
    /// Filters from constants, without memory of their own.
    ///
    /// ```
    /// use bonebeam::phase_symmetry::LogGabor;
    ///
    /// static FILTERS: LogGabor = LogGabor::fixed();
    /// # let _ = FILTERS;
    /// ```
    pub const fn fixed() -> Self {
        LogGabor { tables: &TABLES }
    }
}

impl<'a> LogGabor<'a> {
    /// Fills the tables for every size, scale and orientation.
    ///
    /// The tables are copied from constants to faster memory, such as a microcontroller's RAM beside its flash.
    /// [`LogGabor::fixed`] reads the constants directly.
    pub fn new(tables: &'a mut LogGaborTables) -> Self {
        tables.clone_from(&TABLES);
        LogGabor { tables }
    }

    /// The radial factor of a filter, 0 at the zero frequency.
    pub(super) fn radial(&self, scale: &Scale, bin: Bin) -> f32 {
        const SHIFT: u32 = f32::MANTISSA_DIGITS - 1 - RADIAL_BITS;
        const FIRST: usize = ((127 + LOWEST_OCTAVE) as usize) << RADIAL_BITS;
        const STEP: f32 = 1.0 / (1u32 << SHIFT) as f32;
        let square = bin.square();
        if square == 0.0 {
            return 0.0;
        }
        let bits = (square * scale.per_square).to_bits();
        let segment = ((bits >> SHIFT) as usize).saturating_sub(FIRST);
        let within = (bits & ((1 << SHIFT) - 1)) as f32 * STEP;
        evaluate(&self.tables.radial, segment, within)
    }

    /// The angular factor of an orientation.
    pub(super) fn angular(&self, orientation: &Orientation, direction: Direction) -> f32 {
        let Direction { face, t } = direction;
        let (face, t) = if orientation.mirrored {
            (orientation.turn + 4 - face, -t)
        } else {
            (orientation.turn + face, t)
        };
        let at = (t + 1.0) * (ANGULAR_SEGMENTS / 2) as f32;
        let segment = at as usize;
        // Not by `min`, which makes the compiler take 7 % more instructions for a bank's tables.
        let segment = if segment < ANGULAR_SEGMENTS {
            segment
        } else {
            ANGULAR_SEGMENTS - 1
        };
        let table = &self.tables.angular[orientation.table % 2][face % 4];
        evaluate(table, segment, at - segment as f32)
    }

    /// The gain of a filter at a bin, 0 at the zero frequency.
    pub(super) fn gain(&self, scale: &Scale, orientation: &Orientation, bin: Bin) -> f32 {
        match bin.direction() {
            Some(direction) => self.radial(scale, bin) * self.angular(orientation, direction),
            None => 0.0,
        }
    }
}

/// The signed frequency of bin `k` of `n`; the Nyquist bin counts once, as −n/2.
fn signed(k: usize, n: usize) -> f32 {
    if k < n / 2 {
        k as f32
    } else {
        k as f32 - n as f32
    }
}

/// Four numbers, and where the next begin.
const fn cubic_at(bytes: &[u8], at: usize) -> (Cubic, usize) {
    let mut cubic = [0.0; 4];
    let mut k = 0;
    while k < 4 {
        let from = at + 4 * k;
        let number = [
            bytes[from],
            bytes[from + 1],
            bytes[from + 2],
            bytes[from + 3],
        ];
        cubic[k] = f32::from_le_bytes(number);
        k += 1;
    }
    (cubic, at + 16)
}

fn evaluate(table: &[Cubic], segment: usize, x: f32) -> f32 {
    match table.get(segment) {
        Some([a, b, c, d]) => a + x * (b + x * (c + x * d)),
        None => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::boxed::Box;

    /// `σ_r/r₀`.
    const RADIAL_RATIO: f64 = 0.15;
    /// `σ_α` in radians.
    const ANGULAR_DEVIATION: f64 = core::f64::consts::FRAC_PI_6;

    /// The tables from the functions: 3360 exponentials, 1824 logarithms and 1536 arc tangents in f64.
    fn from_the_functions() -> Box<LogGaborTables> {
        let mut tables = Box::new(LogGaborTables::new());
        for (k, out) in tables.radial.iter_mut().enumerate() {
            let octave = libm::exp2(f64::from(LOWEST_OCTAVE + (k / RADIAL_SEGMENTS) as i32));
            let segment = (k % RADIAL_SEGMENTS) as f64;
            *out =
                cubic(|x| radial_factor(octave * (1.0 + (segment + x) / RADIAL_SEGMENTS as f64)));
        }
        for (angular, orientation) in tables.angular.iter_mut().zip(&ORIENTATIONS) {
            for (face, cubics) in angular.iter_mut().enumerate() {
                for (k, out) in cubics.iter_mut().enumerate() {
                    *out = cubic(|x| {
                        let t = (k as f64 + x) * (2.0 / ANGULAR_SEGMENTS as f64) - 1.0;
                        let theta = face as f64 * core::f64::consts::FRAC_PI_2 + libm::atan(t);
                        angular_factor(theta - orientation.radians)
                    });
                }
            }
        }
        tables
    }

    fn bytes(tables: &LogGaborTables) -> impl Iterator<Item = u8> {
        let angular = tables.angular.as_flattened().as_flattened();
        let cubics = tables.radial.iter().chain(angular);
        cubics.flatten().flat_map(|number| number.to_le_bytes())
    }

    #[test]
    fn the_constants_are_the_functions_values() {
        let tables = from_the_functions();
        assert!(bytes(&tables).eq(bytes(&TABLES)));
        let mut copied = LogGaborTables::new();
        LogGabor::new(&mut copied);
        assert!(bytes(&tables).eq(bytes(&copied)));
        assert_eq!(bytes(&tables).count(), LogGaborTables::BYTES);
    }

    /// Writes the constants anew, after a change of the functions or of the segments:
    /// `cargo test -p bonebeam --lib log_gabor::tests::record -- --ignored`.
    #[test]
    #[ignore = "writes into the source"]
    fn record() {
        let path = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/src/phase_symmetry/log_gabor.bin"
        );
        let bytes: std::vec::Vec<u8> = bytes(&from_the_functions()).collect();
        std::fs::write(path, bytes).unwrap();
    }

    /// The cubic through a function's values at 0, 1/3, 2/3 and 1.
    fn cubic(f: impl Fn(f64) -> f64) -> Cubic {
        let [a, b, c, d] = [f(0.0), f(1.0 / 3.0), f(2.0 / 3.0), f(1.0)];
        // Newton's forward differences, each divided by its factorial.
        let first = b - a;
        let second = (c - 2.0 * b + a) / 2.0;
        let third = (d - 3.0 * c + 3.0 * b - a) / 6.0;
        [
            a as f32,
            (3.0 * (first - second + 2.0 * third)) as f32,
            (9.0 * (second - 3.0 * third)) as f32,
            (27.0 * third) as f32,
        ]
    }

    /// The radial factor at `m = (r/r₀)²`.
    fn radial_factor(m: f64) -> f64 {
        let z = 0.5 * libm::log(m) / libm::log(RADIAL_RATIO);
        libm::exp(-0.5 * z * z)
    }

    /// The angular factor at an angle from the filter's direction, in (−2π, 3π).
    fn angular_factor(angle: f64) -> f64 {
        use core::f64::consts::PI;
        let wrapped = if angle > PI { angle - 2.0 * PI } else { angle };
        let z = wrapped / ANGULAR_DEVIATION;
        libm::exp(-0.5 * z * z)
    }

    /// Every gain of every filter against the definition, Eq. 9, in f64.
    #[test]
    fn gains_follow_equation_9() {
        let mut tables = LogGaborTables::new();
        let filters = LogGabor::new(&mut tables);
        for (rows, columns) in [(64, 64), (1024, 64), (128, 512)] {
            for r0 in [1.0 / 1024.0, 1.0 / 512.0, 0.013, 1.0 / 32.0, 0.5] {
                for orientation in ORIENTATIONS {
                    let scale = Scale::new(rows, columns, r0).unwrap();
                    for column in (0..columns).step_by(crate::step(29)) {
                        for row in (0..rows).step_by(crate::step(61)) {
                            let gain = filters.gain(&scale, &orientation, scale.bin(row, column));
                            let exact = equation_9(row, rows, column, columns, r0, &orientation);
                            let error = (f64::from(gain) - exact).abs();
                            // Roundings at values near 1: of t + 1, of two constant terms, of
                            // two sums, of the product; and twice the cubics' 2e-8.
                            assert!(error < 2.5e-7, "{rows}x{columns} {row} {column}: {error}");
                        }
                    }
                }
            }
        }
    }

    fn equation_9(
        row: usize,
        rows: usize,
        column: usize,
        columns: usize,
        r0: f64,
        orientation: &Orientation,
    ) -> f64 {
        use core::f64::consts::PI;
        let frequency = |k: usize, n: usize| {
            let k = k as f64 / n as f64;
            if k < 0.5 { k } else { k - 1.0 }
        };
        let (fx, fy) = (frequency(column, columns), frequency(row, rows));
        let r = libm::hypot(fx, fy);
        if r == 0.0 {
            return 0.0;
        }
        let turn = libm::atan2(-fy, fx) - orientation.radians;
        let alpha = libm::atan2(libm::sin(turn), libm::cos(turn));
        let z = libm::log(r / r0) / libm::log(0.15);
        libm::exp(-0.5 * z * z) * libm::exp(-0.5 * (alpha / (PI / 6.0)) * (alpha / (PI / 6.0)))
    }
}
