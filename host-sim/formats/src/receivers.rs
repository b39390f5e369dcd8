//! Elements that recorded an acquisition.
//!
//! Walking and multiplexed apertures, and lists of single acquisitions.

use std::collections::HashMap;

use ndarray::{Array2, Array4, ArrayD, Axis};

use crate::waves::Law;
use bonebeam_files::Samples;
use bonebeam_files::memory::{self, product};

/// Channel of an element that was not recorded.
pub const NONE: usize = usize::MAX;

/// The channel of each element, `[acquisition, element]`.
///
/// `indices` are the elements of the channels.
///
/// # Errors
/// The end of a sentence: an index beyond the elements, or one that an acquisition names twice.
pub fn channels(indices: &ArrayD<f64>, elements: usize) -> Result<Array2<usize>, String> {
    let acquisitions = indices.shape().first().copied().unwrap_or(1);
    memory::check(
        product(&[acquisitions, elements, size_of::<usize>()]),
        "the table",
    )
    .map_err(|e| format!("is too large: {e}"))?;
    let mut channels = Array2::from_elem((acquisitions, elements), NONE);
    let rows = indices.outer_iter().enumerate();
    let each =
        rows.flat_map(|(k, row)| row.into_iter().copied().enumerate().map(move |at| (k, at)));
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

/// A law whose equal waves are one transmit, and each acquisition's transmit.
///
/// Waves with other times of sample 0 or with an element that has recorded the wave already are other transmits.
pub fn merged((law, t0): &Law, channels: &Array2<usize>) -> (Law, Vec<usize>) {
    let (mut firsts, mut of) = (Vec::new(), Vec::new());
    // Of each wave its last transmit, and the elements that recorded it.
    let mut known = HashMap::<String, (usize, Vec<bool>)>::new();
    for (k, row) in channels.outer_iter().enumerate() {
        let new: Vec<bool> = row.iter().map(|channel| *channel != NONE).collect();
        let both = |taken: &[bool]| taken.iter().zip(&new).any(|(a, b)| *a && *b);
        // Text, since the delay of a silent element, NaN, is not equal to itself.
        let wave = known.entry(format!("{:#?} {}", law.only(&[k]), t0[k]));
        let wave = wave.or_insert((usize::MAX, vec![true; new.len()]));
        if both(&wave.1) {
            *wave = (firsts.len(), vec![false; new.len()]);
            firsts.push(k);
        }
        let taken = wave.1.iter_mut().zip(&new);
        taken.for_each(|(taken, new)| *taken |= new);
        of.push(wave.0);
    }
    let t0 = firsts.iter().map(|&k| t0[k]).collect();
    ((law.only(&firsts), t0), of)
}

/// Samples of the elements from those of channels.
///
/// `[frame, transmit, element, sample]`; elements without a channel have 0. `of` has the transmit of each acquisition.
///
/// # Errors
/// The end of a sentence: channels that the samples lack, or too little memory.
pub fn of_elements(
    samples: Samples,
    channels: &Array2<usize>,
    of: &[usize],
) -> Result<Samples, String> {
    let (_, acquisitions, held, _) = samples.dim();
    let more = (channels.ncols() * transmits(of)).div_ceil(held.max(1) * acquisitions.max(1));
    memory::check(samples.bytes().saturating_mul(more), "the samples")
        .map_err(|e| format!("is too large: {e}"))?;
    Ok(match samples {
        Samples::Rf(rf) => Samples::Rf(placed(&rf, channels, of)),
        Samples::Counts(counts) => Samples::Counts(placed(&counts, channels, of)),
        Samples::Stored(_) => return Err("is left in its file".into()),
        Samples::Iq { iq, f_demod } => Samples::Iq {
            iq: placed(&iq, channels, of),
            f_demod,
        },
    })
}

fn transmits(of: &[usize]) -> usize {
    of.iter().max().map_or(0, |last| last + 1)
}

fn placed<T: Copy + Default>(
    values: &Array4<T>,
    channels: &Array2<usize>,
    of: &[usize],
) -> Array4<T> {
    let (frames, _, _, samples) = values.dim();
    let shape = (frames, transmits(of), channels.ncols(), samples);
    let mut placed = Array4::from_elem(shape, T::default());
    for ((acquisition, element), &channel) in channels.indexed_iter() {
        for (to, from) in placed.outer_iter_mut().zip(values.outer_iter()) {
            let mut of_transmit = to.index_axis_move(Axis(0), of[acquisition]);
            let record = from.index_axis_move(Axis(0), acquisition);
            if channel < record.nrows() {
                of_transmit.row_mut(element).assign(&record.row(channel));
            }
        }
    }
    placed
}
