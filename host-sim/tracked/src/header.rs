//! Fields of a sequence's header: those of the file, and those of its frames.

use std::collections::BTreeMap;
use std::io::{BufRead, Read};

/// Longest line, bytes: a transform has some two hundred.
const LONGEST_LINE: u64 = 1 << 20;
/// Longest header, bytes: an hour of frames has some hundred megabytes.
const LONGEST: u64 = 512 << 20;
/// Largest number of frames.
pub const MOST_FRAMES: usize = 1 << 18;

/// Values by their names, as in the file.
pub type Fields = BTreeMap<String, String>;

/// The fields of a header.
#[derive(Debug, Default)]
pub struct Header {
    /// Fields of the file.
    pub fields: Fields,
    /// Fields of the frames, by the frame's index.
    pub frames: BTreeMap<usize, Fields>,
    /// Bytes of the header that were read.
    pub length: u64,
}

impl Header {
    /// The next line without its end; `None` at the end of the file.
    ///
    /// # Errors
    /// A line or a header that is too long, or an error of the system.
    pub fn line(&mut self, reader: &mut impl BufRead) -> Result<Option<String>, String> {
        let mut bytes = Vec::new();
        let mut part = reader.take(LONGEST_LINE);
        let read = part.read_until(b'\n', &mut bytes);
        self.length += read.map_err(|e| format!("cannot be read: {e}"))? as u64;
        if bytes.len() as u64 == LONGEST_LINE || self.length > LONGEST {
            return Err("has a header that does not end".into());
        }
        Ok((!bytes.is_empty()).then(|| String::from_utf8_lossy(&bytes).trim().to_owned()))
    }

    /// Takes a field; `Seq_Frame0012_…`, of any number of digits, is a frame's.
    ///
    /// # Errors
    /// A frame's field without a valid number.
    pub fn take(&mut self, name: &str, value: &str) -> Result<(), String> {
        let [name, value] = [name, value].map(str::trim);
        let Some(rest) = name.strip_prefix("Seq_Frame") else {
            self.fields.insert(name.into(), value.into());
            return Ok(());
        };
        let parts = rest.split_once('_');
        let number = parts.and_then(|(number, of)| Some((number.parse::<usize>().ok()?, of)));
        let Some((frame, of)) = number.filter(|(frame, _)| *frame < MOST_FRAMES) else {
            return Err(format!("has the field {name}, which names no frame"));
        };
        let fields = self.frames.entry(frame).or_default();
        fields.insert(of.into(), value.into());
        Ok(())
    }

    /// The value of a field.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.fields.get(name).map(String::as_str)
    }

    /// The words of a field; none without it.
    pub fn words(&self, name: &str) -> Vec<&str> {
        self.get(name)
            .unwrap_or_default()
            .split_whitespace()
            .collect()
    }

    /// The whole numbers of a field; PLUS pads them with blanks.
    ///
    /// # Errors
    /// A missing field, or text that is no number.
    pub fn sizes(&self, name: &str) -> Result<Vec<usize>, String> {
        let text = self.get(name).ok_or_else(|| format!("has no {name}"))?;
        let numbers: Option<Vec<usize>> = text
            .split_whitespace()
            .map(|word| word.parse().ok())
            .collect();
        let valid = numbers.filter(|numbers| (1..=8).contains(&numbers.len()));
        valid.ok_or_else(|| format!("has {name} = {text}; expected whole numbers"))
    }
}
