//! Homogeneous matrices, and chains of named transforms.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// A homogeneous matrix, rows first, lengths in mm.
pub type Matrix = [[f64; 4]; 4];

/// The product `a·b`: `b` acts first.
pub fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|row| {
        std::array::from_fn(|column| (0..4).map(|k| a[row][k] * b[k][column]).sum())
    })
}

/// Refuses a last row other than 0, 0, 0, 1, such as that of a matrix with columns first.
pub(crate) fn check_last_row(matrix: &Matrix) -> Result<(), String> {
    match matrix[3] == IDENTITY[3] {
        true => Ok(()),
        false => Err(format!(
            "has the last row {:?}; expected 0, 0, 0, 1",
            matrix[3]
        )),
    }
}

/// The position of a point under a matrix.
pub fn apply(matrix: &Matrix, point: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|row| {
        let [a, b, c, d] = matrix[row];
        a * point[0] + b * point[1] + c * point[2] + d
    })
}

/// The inverse of an affine matrix; `None` if it is singular or not affine.
pub fn inverse(matrix: &Matrix) -> Option<Matrix> {
    let m = matrix;
    let cofactor = |row: usize, column: usize| {
        let [a, b] = [(row + 1) % 3, (row + 2) % 3];
        let [c, d] = [(column + 1) % 3, (column + 2) % 3];
        m[a][c] * m[b][d] - m[a][d] * m[b][c]
    };
    let determinant: f64 = (0..3)
        .map(|column| m[0][column] * cofactor(0, column))
        .sum();
    let scale: f64 = (0..3)
        .map(|row| {
            m[row][..3]
                .iter()
                .map(|value| value * value)
                .sum::<f64>()
                .sqrt()
        })
        .product();
    let affine = m[3] == [0.0, 0.0, 0.0, 1.0];
    if !affine || !scale.is_finite() || determinant.abs() <= 1e-9 * scale || scale == 0.0 {
        return None;
    }
    let mut inverse = [[0.0; 4]; 4];
    for (row, values) in inverse.iter_mut().take(3).enumerate() {
        for (column, value) in values.iter_mut().take(3).enumerate() {
            *value = cofactor(column, row) / determinant;
        }
        values[3] = -(0..3).map(|k| values[k] * m[k][3]).sum::<f64>();
    }
    inverse[3][3] = 1.0;
    Some(inverse)
}

/// The frames of a name: `ProbeToTracker` goes from `Probe` to `Tracker`.
pub fn name_parts(name: &str) -> Option<[&str; 2]> {
    let starts = name.match_indices("To").map(|(at, _)| at);
    let parts = starts.map(|at| [&name[..at], &name[at + 2..]]);
    parts
        .filter(|[from, to]| {
            !from.is_empty() && to.starts_with(|first: char| !first.is_lowercase())
        })
        .find(|[_, to]| !to.is_empty())
}

/// A chain of transforms, in the order in which they act.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// The names, and whether the inverse acts.
    pub links: Vec<(String, bool)>,
}

impl Chain {
    /// The shortest chain between two frames by transforms and their inverses.
    ///
    /// # Errors
    /// The missing link, with what there is.
    pub fn of<'n>(
        names: impl IntoIterator<Item = &'n str>,
        from: &str,
        to: &str,
    ) -> Result<Self, String> {
        let names: BTreeSet<&str> = names.into_iter().collect();
        let mut reached: BTreeMap<&str, Option<(&str, &str, bool)>> =
            BTreeMap::from([(from, None)]);
        let mut left = VecDeque::from([from]);
        while let Some(frame) = left.pop_front() {
            for &name in &names {
                let Some([a, b]) = name_parts(name) else {
                    continue;
                };
                for (a, b, inverted) in [(a, b, false), (b, a, true)] {
                    if a == frame && !reached.contains_key(b) {
                        reached.insert(b, Some((frame, name, inverted)));
                        left.push_back(b);
                    }
                }
            }
        }
        let mut links = Vec::new();
        let mut at = to;
        while at != from {
            let Some(&Some((before, name, inverted))) = reached.get(at) else {
                return Err(missing(&names, &reached, from, to));
            };
            links.push((name.to_owned(), inverted));
            at = before;
        }
        links.reverse();
        Ok(Self { links })
    }

    /// The product of the links' matrices.
    ///
    /// # Errors
    /// What `matrix` returns for a link, or `singular` for a matrix without an inverse.
    pub fn product<E>(
        &self,
        mut matrix: impl FnMut(&str) -> Result<Matrix, E>,
        singular: impl Fn(&str) -> E,
    ) -> Result<Matrix, E> {
        let mut all = IDENTITY;
        for (name, inverted) in &self.links {
            let mut link = matrix(name)?;
            if *inverted {
                link = inverse(&link).ok_or_else(|| singular(name))?;
            }
            all = product(&link, &all);
        }
        Ok(all)
    }
}

/// The identity.
pub const IDENTITY: Matrix = [
    [1.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0],
    [0.0, 0.0, 0.0, 1.0],
];

fn missing(
    names: &BTreeSet<&str>,
    reached: &BTreeMap<&str, Option<(&str, &str, bool)>>,
    from: &str,
    to: &str,
) -> String {
    let listed = |mut words: Vec<&str>| {
        words.sort_unstable();
        match words.is_empty() {
            true => "none".to_owned(),
            false => words.join(", "),
        }
    };
    let ends: Vec<&str> = reached.keys().copied().collect();
    format!(
        "has no chain of transforms from {from} to {to}: {} leads no further; there are {}",
        listed(ends),
        listed(names.iter().copied().collect())
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_split_at_the_right_to() {
        for (name, parts) in [
            ("ProbeToTracker", Some(["Probe", "Tracker"])),
            ("ToolToTracker", Some(["Tool", "Tracker"])),
            ("ProbeToTorso", Some(["Probe", "Torso"])),
            ("StylusTipToTool", Some(["StylusTip", "Tool"])),
            ("ImageToCT2", Some(["Image", "CT2"])),
            ("Tomato", None),
            ("ProbeTo", None),
        ] {
            assert_eq!(name_parts(name), parts, "{name}");
        }
    }

    #[test]
    fn a_chain_uses_inverses_and_names_a_missing_link() {
        let names = [
            "ProbeToTracker",
            "ReferenceToTracker",
            "ImageToProbe",
            "StylusToTracker",
        ];
        let chain = Chain::of(names, "Image", "Reference").unwrap();
        let links: Vec<(&str, bool)> = chain
            .links
            .iter()
            .map(|(name, inverted)| (&name[..], *inverted))
            .collect();
        assert_eq!(
            links,
            [
                ("ImageToProbe", false),
                ("ProbeToTracker", false),
                ("ReferenceToTracker", true)
            ]
        );
        let shift = |x: f64| {
            let mut matrix = IDENTITY;
            matrix[0] = [0.0, -2.0, 0.0, x];
            matrix[1] = [2.0, 0.0, 0.0, 0.0];
            matrix
        };
        let of = |name: &str| Ok(shift(name.len() as f64));
        let all = chain.product(of, |_| "singular").unwrap();
        let [x, y, z] = apply(&all, [1.0, 2.0, 3.0]);
        // By hand: turned by a right angle and doubled twice, then once back.
        let by = |p: [f64; 3], x: f64| [x - 2.0 * p[1], 2.0 * p[0], p[2]];
        let p = by(by([1.0, 2.0, 3.0], 12.0), 14.0);
        assert!((x - p[1] / 2.0).abs() < 1e-12 && (y + (p[0] - 18.0) / 2.0).abs() < 1e-12);
        assert_eq!(z, 3.0);

        let message = Chain::of(names, "Image", "Phantom").unwrap_err();
        for part in [
            "from Image to Phantom",
            "ReferenceToTracker, StylusToTracker",
        ] {
            assert!(message.contains(part), "{message}");
        }
        let without = Chain::of(names[..2].iter().copied(), "Image", "Tracker")
            .map_err(|e| e.contains("Image leads"));
        assert_eq!(without, Err(true));
        let flat = |_: &str| Ok([[0.0; 4]; 4]);
        let singular = chain.product(flat, |name| name.to_owned());
        assert_eq!(singular, Err("ReferenceToTracker".to_owned()));
    }
}
