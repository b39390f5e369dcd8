//! Work of the main loop on a block, under either executor.

use bonebeam::prelude::stages::*;
use cortex_m_semihosting::hprintln;
use stream::scan::{self, BEAMS, ScanBlock};
use stream::{Chain, Probe, Received, Sequence, Stamp};

/// The image and the bone map of a whole frame.
pub struct Maps {
    /// The frame's number.
    pub frame: u32,
    /// Number of missing lines.
    pub missing: usize,
    /// A hash of the bone map.
    pub hash: u64,
}

/// Prints the faults of a block, makes its line, and completes the frame.
///
/// After a frame's last block it makes the frame's maps, if all blocks came.
///
/// # Errors
/// Errors of the chain.
pub fn process<P: Probe<Stage = IqDelay>>(
    chain: &mut Chain<'_, P, BEAMS>,
    sequence: &mut Sequence,
    block: Received<'_, ScanBlock>,
) -> Result<Option<Maps>, Error> {
    let verdict = sequence.check(block.header);
    for fault in verdict.faults.into_iter().flatten() {
        hprintln!("{:?}", fault);
    }
    let Some(line) = verdict.line else {
        return Ok(None);
    };
    let stamp = Stamp {
        time: block.time(),
        saturated: block.saturated(8191),
    };
    chain.line(line.into(), &scan::record(&block)?, stamp)?;
    let frame = block.header.sequence / BEAMS as u32;
    // The block is free for the next acquisition.
    drop(block);
    if !verdict.whole {
        return Ok(None);
    }
    let missing = chain.image()?.missing;
    let hash = scan::hash(chain.map()?);
    Ok(Some(Maps {
        frame,
        missing,
        hash,
    }))
}
