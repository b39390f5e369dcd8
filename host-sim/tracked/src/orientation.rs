//! PLUS's orientation of a picture: the directions of its axes.

use std::fmt::{self, Display, Formatter};

/// Directions of a picture's axes relative to the transducer.
///
/// The first letter is that of the axis that runs fastest in memory. `M` and `U` point to the marked and to the
/// unmarked side, `F` and `N` away from the transducer and to it. The project's pictures are `MF`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orientation {
    /// Whether the fastest axis runs along the beam, as in lines of RF.
    pub transposed: bool,
    /// Whether the lateral axis points to the unmarked side.
    pub unmarked: bool,
    /// Whether the axial axis points to the transducer.
    pub near: bool,
}

impl Orientation {
    /// Columns to the marked side, rows away from the transducer.
    pub const MF: Self = Self {
        transposed: false,
        unmarked: false,
        near: false,
    };

    /// The orientation by PLUS's two letters; a third is that of slices.
    pub fn of(code: &str) -> Option<Self> {
        let letters: Vec<char> = code.chars().collect();
        let [first, second] = match letters[..] {
            [first, second] | [first, second, 'A' | 'D'] => [first, second],
            _ => return None,
        };
        let transposed = match (first, second) {
            ('M' | 'U', 'F' | 'N') => false,
            ('F' | 'N', 'M' | 'U') => true,
            _ => return None,
        };
        let has = |letter| first == letter || second == letter;
        Some(Self {
            transposed,
            unmarked: has('U'),
            near: has('N'),
        })
    }

    /// The index in the file, [fast, slow], of a pixel of the `MF` picture.
    pub fn place(&self, [column, row]: [usize; 2], [columns, rows]: [usize; 2]) -> [usize; 2] {
        let column = if self.unmarked {
            columns - 1 - column
        } else {
            column
        };
        let row = if self.near { rows - 1 - row } else { row };
        if self.transposed {
            [row, column]
        } else {
            [column, row]
        }
    }
}

impl Display for Orientation {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let lateral = if self.unmarked { 'U' } else { 'M' };
        let axial = if self.near { 'N' } else { 'F' };
        match self.transposed {
            true => write!(f, "{axial}{lateral}"),
            false => write!(f, "{lateral}{axial}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_eight_orientations_and_those_with_three_letters() {
        let mirrored =
            |code: &str| Orientation::of(code).map(|o| (o.transposed, o.unmarked, o.near));
        for (code, expected) in [
            ("MF", (false, false, false)),
            ("UF", (false, true, false)),
            ("MN", (false, false, true)),
            ("UN", (false, true, true)),
            ("FM", (true, false, false)),
            ("FU", (true, true, false)),
            ("NM", (true, false, true)),
            ("NU", (true, true, true)),
        ] {
            assert_eq!(mirrored(code), Some(expected), "{code}");
            assert_eq!(Orientation::of(code).unwrap().to_string(), code);
            for slices in ["A", "D"] {
                assert_eq!(
                    mirrored(&format!("{code}{slices}")),
                    Some(expected),
                    "{code}{slices}"
                );
            }
        }
        for code in ["", "M", "MM", "FN", "AMF", "MFX", "mf", "XX"] {
            assert_eq!(mirrored(code), None, "{code}");
        }
        // Of a picture of 4 columns and 3 rows.
        let at = |code| Orientation::of(code).unwrap().place([1, 0], [4, 3]);
        assert_eq!(
            ["MF", "UF", "MN", "UN"].map(at),
            [[1, 0], [2, 0], [1, 2], [2, 2]]
        );
        assert_eq!(
            ["FM", "FU", "NM", "NU"].map(at),
            [[0, 1], [0, 2], [2, 1], [2, 2]]
        );
    }
}
