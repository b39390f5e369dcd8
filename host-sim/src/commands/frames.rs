//! The flag `--frames`.

use std::ops::Range;

use crate::{Error, Result};

/// The frames that `--frames` selects; without an end, up to the last.
#[derive(Clone, Debug)]
pub struct FrameRange {
    first: usize,
    end: Option<usize>,
}

/// Parses `A..B`, `A..` or `A`.
pub fn parse_frames(text: &str) -> std::result::Result<FrameRange, String> {
    let expected = "expected a frame such as 3, or a range such as 0..10 or 5..";
    let number = |text: &str| text.parse::<usize>().map_err(|_| expected.to_owned());
    match text.split_once("..") {
        None => {
            let first = number(text)?;
            Ok(FrameRange {
                first,
                end: Some(first.saturating_add(1)),
            })
        }
        Some((first, "")) => Ok(FrameRange {
            first: number(first)?,
            end: None,
        }),
        Some((first, end)) => Ok(FrameRange {
            first: number(first)?,
            end: Some(number(end)?),
        }),
    }
}

impl FrameRange {
    /// The selected frames of a recording with `frames` frames; all without a range.
    ///
    /// # Errors
    /// A range that selects no frame, or frames beyond the last.
    pub fn of(range: Option<&Self>, frames: usize) -> Result<Range<usize>> {
        let Some(range) = range else {
            return Ok(0..frames);
        };
        let range = range.first..range.end.unwrap_or(frames);
        if !range.is_empty() && range.end <= frames {
            return Ok(range);
        }
        Err(Error::Usage(format!(
            "--frames asks for {} to {}; the recording has frames 0 to {}",
            range.start,
            range.end.saturating_sub(1),
            frames.saturating_sub(1)
        )))
    }
}
