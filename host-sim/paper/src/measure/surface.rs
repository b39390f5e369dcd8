//! How well a detector finds a surface that a line meets first, with one answer or none a line.

use serde::{Deserialize, Serialize};

/// Answers of one frame beside the known surface.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// Lines with an answer.
    pub answers: usize,
    /// Lines that meet a surface.
    pub surfaces: usize,
    /// The distance of each hit from the surface, mm.
    pub hits_mm: Vec<f64>,
}

/// Judges answers, depths in m, a line each. A hit lies at most `tolerance` m from the surface that its line meets
/// first; a line without one has no hit.
pub fn judge(answers: &[Option<f64>], surface: &[Option<f64>], tolerance: f64) -> Judged {
    let distances = answers.iter().zip(surface);
    let distances =
        distances.filter_map(|(found, truth)| Some((found.as_ref()? - truth.as_ref()?).abs()));
    Judged {
        answers: answers.iter().flatten().count(),
        surfaces: surface.iter().flatten().count(),
        hits_mm: distances
            .filter(|distance| *distance <= tolerance)
            .map(|distance| 1e3 * distance)
            .collect(),
    }
}

impl Judged {
    /// All frames together.
    pub fn of_all<'a>(frames: impl IntoIterator<Item = &'a Judged>) -> Judged {
        let mut all = Judged::default();
        for frame in frames {
            all.answers += frame.answers;
            all.surfaces += frame.surfaces;
            all.hits_mm.extend(&frame.hits_mm);
        }
        all
    }

    /// The share of the answers that are hits; none without answers.
    pub fn precision(&self) -> Option<f64> {
        share(self.hits_mm.len(), self.answers)
    }

    /// The share of the surfaces that are hit; none without surfaces.
    pub fn recall(&self) -> Option<f64> {
        share(self.hits_mm.len(), self.surfaces)
    }

    /// The harmonic mean of precision and recall; none without answers and surfaces.
    pub fn f1(&self) -> Option<f64> {
        share(2 * self.hits_mm.len(), self.answers + self.surfaces)
    }

    /// The mean distance of hits, mm.
    pub fn mean_mm(&self) -> Option<f64> {
        let count = self.hits_mm.len();
        (count > 0).then(|| self.hits_mm.iter().sum::<f64>() / count as f64)
    }

    /// The distance that 95 of 100 hits do not exceed, mm.
    pub fn p95_mm(&self) -> Option<f64> {
        let mut sorted = self.hits_mm.clone();
        sorted.sort_by(f64::total_cmp);
        let rank = (0.95 * sorted.len() as f64).ceil() as usize;
        sorted.get(rank.checked_sub(1)?).copied()
    }
}

fn share(part: usize, of: usize) -> Option<f64> {
    (of > 0).then(|| part as f64 / of as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_hits_false_or_missing() {
        // A hit, one too deep, one where there is no surface, a surface without an answer, neither.
        let answers = [Some(10.2e-3), Some(20.6e-3), Some(5e-3), None, None];
        let surface = [Some(10e-3), Some(20e-3), None, Some(15e-3), None];
        let judged = judge(&answers, &surface, 0.5e-3);
        assert_eq!((judged.answers, judged.surfaces), (3, 3));
        assert_eq!(judged.precision(), Some(1.0 / 3.0));
        assert_eq!(judged.recall(), Some(1.0 / 3.0));
        assert!((judged.mean_mm().unwrap() - 0.2).abs() < 1e-9);
        let none = judge(&[None; 4], &[None; 4], 0.5e-3);
        assert_eq!(
            (none.precision(), none.recall(), none.f1()),
            (None, None, None)
        );
        let both = Judged::of_all([&judged, &judged, &none]);
        assert_eq!((both.answers, both.surfaces, both.hits_mm.len()), (6, 6, 2));
    }

    #[test]
    fn the_percentile_is_the_nearest_rank() {
        let with = |count: usize| Judged {
            hits_mm: (1..=count).rev().map(|k| k as f64).collect(),
            ..Judged::default()
        };
        assert_eq!(with(100).p95_mm(), Some(95.0));
        assert_eq!(with(20).p95_mm(), Some(19.0));
        assert_eq!(with(1).p95_mm(), Some(1.0));
        assert_eq!(with(0).p95_mm(), None);
    }
}
