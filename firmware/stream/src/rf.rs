//! RF from DMA.

use bonebeam::prelude::stages::*;

/// Converts RF counts of `elements` elements into a record.
///
/// `rf` receives `counts` times `scale`, as `[element][sample]`. `counts` are `[sample][element]`
/// ([`IqLayout::Interleaved`]) or `[element][sample]` ([`IqLayout::Planar`]). `rf` has the length of `counts`.
/// Cost: a pass over the samples.
///
/// # Errors
/// [`Error::Length`] for an `rf` of another length; as [`Record::new`].
pub fn rf_record<'r>(
    counts: &[i16],
    layout: IqLayout,
    elements: usize,
    scale: f32,
    rf: &'r mut [f32],
) -> Result<Record<'r>, Error> {
    if rf.len() != counts.len() {
        return Err(Error::Length {
            name: "rf",
            expected: counts.len(),
            actual: rf.len(),
        });
    }
    match layout {
        IqLayout::Planar => {
            for (x, &count) in rf.iter_mut().zip(counts) {
                *x = scale * f32::from(count);
            }
        }
        IqLayout::Interleaved => {
            let samples = counts.len() / elements.max(1);
            for (element, own) in rf.chunks_exact_mut(samples.max(1)).enumerate() {
                let counts = counts.iter().skip(element).step_by(elements.max(1));
                for (x, &count) in own.iter_mut().zip(counts) {
                    *x = scale * f32::from(count);
                }
            }
        }
    }
    Record::new(rf, elements)
}
