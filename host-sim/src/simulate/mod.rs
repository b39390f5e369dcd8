//! Synthetic channel data.
