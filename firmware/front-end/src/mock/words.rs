//! Words that a mock receiver sends on its lanes.

/// A part's words on its lanes.
pub trait MockWords {
    /// Bits of a word.
    const BITS: u32;

    /// Word of all channels at `time`, in samples; `None` for echoes.
    fn word(&self, time: u16) -> Option<u16>;

    /// Starts ramps at `phase`.
    fn start(&self, phase: u16);
}
