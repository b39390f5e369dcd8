//! All bit-for-bit checks, with hashes.
