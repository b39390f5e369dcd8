//! Long results, kept in a folder for the next run.

use std::hash::Hasher;

use fnv::FnvHasher;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::Result;
use crate::experiments::Context;
use bonebeam_files::atomic::Outputs;
use bonebeam_files::input;

/// Longest result to read, bytes.
const MOST: u64 = 100_000_000;

/// Reads a result from the folder of kept ones, or computes it and keeps it.
///
/// `what` begins its file's name; `key` holds all that it depends on.
pub fn kept<T: Serialize + DeserializeOwned>(
    context: &Context<'_>,
    what: &str,
    key: &str,
    compute: impl FnOnce() -> Result<T>,
) -> Result<T> {
    let Some(folder) = context.kept()? else {
        return compute();
    };
    let mut hasher = FnvHasher::default();
    hasher.write(key.as_bytes());
    hasher.write(env!("CARGO_PKG_VERSION").as_bytes());
    let path = folder.join(format!("{what}-{:016x}.json", hasher.finish()));
    if let Ok(text) = input::read(&path, MOST)
        && let Ok(found) = serde_json::from_slice(&text)
    {
        return Ok(found);
    }
    let found = compute()?;
    let mut outputs = Outputs::new();
    outputs.add(&path, |sink| Ok(serde_json::to_writer(sink, &found)?))?;
    outputs.commit()?;
    Ok(found)
}

#[cfg(test)]
mod tests {
    /// Some of these are not by serde_json without its feature `float_roundtrip`.
    #[test]
    fn numbers_are_read_as_they_were_written() {
        let mut value = 0.1f64;
        for _ in 0..10_000 {
            value = (value * 997.0 + 0.123_456_789).fract() + 1e-3;
            let text = serde_json::to_string(&value).unwrap();
            let read: f64 = serde_json::from_str(&text).unwrap();
            assert_eq!(read.to_bits(), value.to_bits(), "{text}");
        }
    }
}
