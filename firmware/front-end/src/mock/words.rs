//! What a receiver sends on its lanes.

/// A part's words on its lanes.
pub trait MockWords {
    /// Bits of a word.
    const BITS: u32;

    /// The word that all channels send at `time`, in samples; `None` for echoes.
    fn word(&self, time: u16) -> Option<u16>;

    /// Starts ramps at `phase`.
    fn start(&self, phase: u16);
}
