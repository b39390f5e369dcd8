//! Alternatives: the recording as it would be without a mistake that is often made.
//!
//! An alternative is named if echoes agree clearly better with it. Rows of one table.

use bonebeam_files::ChannelData;

use crate::base::Base;
use crate::finding::{Finding, Severity};
use crate::table::{Table, sureness};
use crate::transmits::{exchanged, listed, moved, shifted};
use crate::view::{View, Wave};

/// Gain of the score from which an alternative is named.
pub(crate) const GAIN: f64 = 0.07;
/// The same of a small change of the waves, which delays of tissue and points beside the lines imitate, with the least
/// share of it that the transmits' phases have, unless they surely have it; the gain that they do not bring; and the
/// gain below which phases count for nothing.
const OF_SMALL: f64 = 0.14;
const LEAST_SHARE: f64 = 0.15;
const MOST_OF_SMALL: f64 = 0.5;
const LEAST: f64 = 0.01;
/// Every how many lines are read for it.
const EVERY: usize = 2;
/// Least share of the missing coherence that it brings, but for a small change of the waves.
const SHARE: f64 = 0.15;
/// The same of mirrored beams: if the array is narrow, they lie side by side.
const LITTLE: f64 = 0.03;
const MUCH: f64 = 0.2;
/// Coherence of subapertures from which they agree, and the standard deviations by which it is more.
const FOCUSED: f64 = 0.05;
const SHARPER: f64 = 5.0;

/// A mistake, the view without it, and its remedy.
type Alternative = (&'static str, Option<View>, &'static str, &'static str);

fn permuted(view: &View, from: impl Fn(usize, usize) -> usize) -> Option<View> {
    let count = view.order.len();
    let order = (0..count).map(|m| view.order[from(m, count)]).collect();
    Some(View {
        order,
        ..view.clone()
    })
}

fn waves(view: &View, change: impl Fn(usize, &Wave) -> Option<Wave>) -> Option<View> {
    let waves: Option<Vec<Wave>> = view
        .waves
        .iter()
        .enumerate()
        .map(|(t, wave)| change(t, wave))
        .collect();
    waves
        .filter(|waves| *waves != view.waves)
        .map(|waves| View {
            waves,
            ..view.clone()
        })
}

fn angles(view: &View, factor: f64) -> Option<View> {
    waves(view, |_, wave| match wave {
        Wave::Plane(angle) => {
            Some(Wave::Plane(angle * factor)).filter(|_| (angle * factor).abs() < 1.2)
        }
        _ => None,
    })
}

fn mirrored(view: &View) -> Option<View> {
    permuted(view, |m, count| count - 1 - m)
}

fn alternatives(source: (&ChannelData, &[usize]), view: &View) -> Vec<Alternative> {
    let halves = |m: usize, count: usize| (m + count / 2) % count;
    // File order 0, n/2, 1, n/2 + 1, …, and the other way.
    let dealt = |m: usize, count: usize| 2 * m % count + 2 * m / count;
    let woven = |m: usize, count: usize| m / 2 + m % 2 * count.div_ceil(2);
    let pairs = |m: usize, count: usize| (m ^ 1).min(count - 1);
    let elements = "elements are in another order than their positions";
    let mut all = vec![
        (
            "mirrored",
            mirrored(view),
            "elements run from right to left, or the transmits do (tx_x, tx_source_x, the sign of tx_angle)",
            "reverse the axis of the elements, or the transmits' positions or angles",
        ),
        (
            "connectors",
            permuted(view, halves),
            "the two halves of the elements are exchanged",
            "exchange the halves of rf",
        ),
        (
            "interleaved",
            permuted(view, dealt),
            elements,
            "take the elements in the order 0, n/2, 1, n/2 + 1, …",
        ),
        (
            "interleaved",
            permuted(view, woven),
            elements,
            "take the elements in the order 0, 2, …, 1, 3, …",
        ),
        (
            "interleaved",
            permuted(view, pairs),
            elements,
            "exchange each two neighbours of rf",
        ),
        (
            "angle-unit",
            angles(view, 1f64.to_radians()),
            "`tx_angle` is in degrees",
            "give tx_angle in radians",
        ),
        (
            "angle-unit",
            angles(view, 1f64.to_degrees()),
            "`tx_angle` was converted to radians twice",
            "give tx_angle in radians",
        ),
        (
            "element-index",
            waves(view, |_, wave| match wave {
                Wave::Element(m) => Some(Wave::Element(m.checked_sub(1)?)),
                _ => None,
            }),
            "`tx_element` counts from 1",
            "subtract 1 from tx_element",
        ),
    ];
    if are_all(source) && !view.own {
        for by in [1, -1] {
            all.push((
                "transmit-order",
                shifted(source, view, by),
                "records and the list of transmits are shifted by one: a transmit is missing or doubled",
                "take out the doubled record, or the entry of the missing one",
            ));
        }
    }
    all
}

/// Whether an alternative changes the waves a little.
fn is_small(name: &str) -> bool {
    matches!(name, "element-index" | "transmit-order")
}

/// Whether all transmits are read.
fn are_all((data, read): (&ChannelData, &[usize])) -> bool {
    read.len() == data.transmits.len()
}

/// The view that echoes agree with best, and a finding if it is not that of the file.
pub(crate) fn check(
    base: &Base,
    source: (&ChannelData, &[usize]),
    view: View,
    table: Table,
) -> (View, Table, Vec<Finding>) {
    let coarse = View {
        every: EVERY,
        ..view.clone()
    };
    let of_file = Table::new(base, &coarse);
    let (own, focused) = (of_file.score(), of_file.focused());
    let most = if table.transmit_coherence().is_some() {
        2.0
    } else {
        1.0
    };
    // Of those named, and of all orders with a gain.
    let [mut best, mut likeliest]: [Option<(f64, Alternative)>; 2] = [None, None];
    let mut highest = f64::NEG_INFINITY;
    for alternative in alternatives(source, &coarse) {
        let Some(other) = &alternative.1 else {
            continue;
        };
        let table_of_other = Table::new(base, other);
        let score = table_of_other.score();
        let gain = score - own;
        highest = highest.max(score);
        let small = is_small(alternative.0);
        let missing = gain / (most - own);
        let named = match small {
            true => gain > GAIN || gain > LEAST && moved(&view, &table, other).1,
            false if view.own && alternative.0 == "mirrored" => gain > LITTLE && missing > MUCH,
            false => gain > GAIN && missing > SHARE,
        } || !small && gain > LITTLE && is_sharper(&table_of_other.focused(), &focused);
        let is_order = gain > OF_SMALL && alternative.0 != "angle-unit";
        for (best, counts) in [(&mut likeliest, is_order), (&mut best, named)] {
            if counts && best.as_ref().is_none_or(|(best, ..)| score > *best) {
                *best = Some((score, alternative.clone()));
            }
        }
    }
    // Any wrong order makes a shifted list a little better, and so do points beside the lines.
    if let Some((score, (name, Some(other), ..))) = &best
        && is_small(name)
    {
        let (share, is_sure) = moved(&view, &table, other);
        let gain = score - own;
        let is_shown = is_sure || gain > OF_SMALL && share > LEAST_SHARE || gain > MOST_OF_SMALL;
        let is_likelier = |(other, _): &(f64, Alternative)| other > score;
        best = likeliest.filter(is_likelier).or(best.filter(|_| is_shown));
    }
    let two = are_all(source).then(|| exchanged(base, &view, &table));
    if let Some((view, [a, b])) = two.flatten() {
        let table = Table::new(base, &view);
        let coarse = View {
            every: EVERY,
            ..view.clone()
        };
        if Table::new(base, &coarse).score() > highest {
            let text = format!("transmits {a} and {b} have each other's echoes");
            let finding = Finding::new("transmit-order", Severity::Error, text)
                .valued(2.0, "transmits")
                .remedy("exchange their records, or their entries in the list of transmits");
            return (view, table, vec![finding]);
        }
    }
    match best {
        Some((score, (name, Some(other), text, remedy))) => {
            let text = format!(
                "echoes agree better if {text}: neighbours' coherence {score:.2} and not {own:.2}"
            );
            let finding = Finding::new(name, Severity::Error, text).remedy(remedy);
            let view = View { every: 1, ..other };
            let table = Table::new(base, &view);
            (view, table, vec![finding.valued(score - own, "coherence")])
        }
        _ => match listed(source, &view, &table) {
            Some((other, finding)) => {
                let table = Table::new(base, &other);
                (other, table, vec![finding])
            }
            None => (view, table, Vec::new()),
        },
    }
}

/// The mean coherence of lines.
pub(crate) fn mean(focused: &[f64]) -> f64 {
    focused.iter().sum::<f64>() / focused.len() as f64
}

/// Whether subapertures agree, and on most lines better than otherwise.
pub(crate) fn is_sharper(focused: &[f64], otherwise: &[f64]) -> bool {
    mean(focused) > FOCUSED && sureness(focused, otherwise) > SHARPER
}
