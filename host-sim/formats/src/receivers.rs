//! Elements that recorded an acquisition: walking and multiplexed apertures, lists of single acquisitions.

use ndarray::{Array2, Array4, ArrayD};

use crate::waves::Law;
use bonebeam_files::{Samples, Transmits};

/// Channel of an element that was not recorded.
pub const NONE: usize = usize::MAX;

/// The channel of each element, [acquisition, element], by the element of each channel.
///
/// # Errors
/// The end of a sentence: an index beyond the elements, or one that an acquisition names twice.
pub fn channels(indices: &ArrayD<f64>, elements: usize) -> Result<Array2<usize>, String> {
    let acquisitions = indices.shape().first().copied().unwrap_or(1);
    let mut channels = Array2::from_elem((acquisitions, elements), NONE);
    let rows = indices.outer_iter().enumerate();
    let each = rows.flat_map(|(k, row)| row.into_iter().copied().enumerate().map(move |at| (k, at)));
    for (acquisition, (channel, element)) in each.collect::<Vec<_>>() {
        // The cast saturates; NaN is 0.
        match channels.get_mut([acquisition, element as usize]) {
            Some(own) if element >= 0.0 && element.fract() == 0.0 && *own == NONE => *own = channel,
            _ => {
                return Err(format!(
                    "is {element} at transmit {acquisition}, channel {channel}; expected each index of the {elements} \
                     elements at most once, from 0"
                ));
            }
        }
    }
    Ok(channels)
}

/// A law of which equal waves are one transmit, and the transmit of each acquisition.
///
/// Waves with other times of sample 0 or with an element that has recorded the wave already are other transmits.
pub fn merged((law, t0): &Law, channels: &Array2<usize>) -> (Law, Vec<usize>) {
    let wave = |k: usize| -> Vec<f64> {
        let own = match law {
            Transmits::Focused { x, focus, .. } => vec![x[k], focus[k]],
            Transmits::Plane { angle } => vec![angle[k]],
            Transmits::Element { index } => vec![index[k] as f64],
            Transmits::VirtualSource { x, z } => vec![x[k], z[k]],
            Transmits::Delays { delay } => delay.row(k).to_vec(),
        };
        own.into_iter().chain([t0[k]]).collect()
    };
    let bits = |k: usize| wave(k).into_iter().map(f64::to_bits).collect::<Vec<_>>();
    // Of each transmit its first acquisition, and the elements that recorded it.
    let mut firsts: Vec<(usize, Vec<bool>)> = Vec::new();
    let mut of = Vec::new();
    let mut known = std::collections::HashMap::<Vec<u64>, usize>::new();
    for (k, row) in channels.outer_iter().enumerate() {
        let records: Vec<bool> = row.iter().map(|channel| *channel != NONE).collect();
        let is_free = |transmit: &usize| {
            let taken = firsts[*transmit].1.iter().zip(&records);
            !taken.into_iter().any(|(a, b)| *a && *b)
        };
        let transmit = known.get(&bits(k)).copied().filter(is_free);
        let transmit = transmit.unwrap_or_else(|| {
            firsts.push((k, vec![false; records.len()]));
            firsts.len() - 1
        });
        known.insert(bits(k), transmit);
        let taken = firsts[transmit].1.iter_mut().zip(&records);
        taken.for_each(|(taken, records)| *taken |= records);
        of.push(transmit);
    }
    let firsts: Vec<usize> = firsts.into_iter().map(|(k, _)| k).collect();
    let kept = |values: &[f64]| firsts.iter().map(|&k| values[k]).collect::<Vec<_>>();
    let law = match law {
        Transmits::Focused { x, focus, f_number } => Transmits::Focused {
            x: kept(x),
            focus: kept(focus),
            f_number: *f_number,
        },
        Transmits::Plane { angle } => Transmits::Plane { angle: kept(angle) },
        Transmits::Element { index } => Transmits::Element {
            index: firsts.iter().map(|&k| index[k]).collect(),
        },
        Transmits::VirtualSource { x, z } => Transmits::VirtualSource { x: kept(x), z: kept(z) },
        Transmits::Delays { delay } => Transmits::Delays {
            delay: delay.select(ndarray::Axis(0), &firsts),
        },
    };
    ((law, kept(t0)), of)
}

/// Samples of the elements, [frame, transmit, element, sample], from those of channels; the others are 0.
///
/// `of` has the transmit of each acquisition.
pub fn of_elements(samples: Samples, channels: &Array2<usize>, of: &[usize]) -> Samples {
    match samples {
        Samples::Rf(rf) => Samples::Rf(placed(&rf, channels, of)),
        Samples::Counts(counts) => Samples::Counts(placed(&counts, channels, of)),
        Samples::Iq { iq, f_demod } => Samples::Iq {
            iq: placed(&iq, channels, of),
            f_demod,
        },
    }
}

fn placed<T: Copy + Default>(
    values: &Array4<T>,
    channels: &Array2<usize>,
    of: &[usize],
) -> Array4<T> {
    let (frames, _, _, samples) = values.dim();
    let transmits = of.iter().max().map_or(0, |last| last + 1);
    let shape = (frames, transmits, channels.ncols(), samples);
    let mut placed = Array4::from_elem(shape, T::default());
    for ((acquisition, element), &channel) in channels.indexed_iter() {
        if channel == NONE {
            continue;
        }
        for frame in 0..frames {
            let from = values.slice(ndarray::s![frame, acquisition, channel, ..]);
            let mut to = placed.slice_mut(ndarray::s![frame, of[acquisition], element, ..]);
            to.assign(&from);
        }
    }
    placed
}
