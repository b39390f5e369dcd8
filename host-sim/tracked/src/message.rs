//! Messages of OpenIGTLink: header, extended header, content and metadata.

use std::io::{ErrorKind, Read};

use crc::{CRC_64_ECMA_182, Crc, Table};

/// Bytes of the header, and of the extended header of versions 2 and 3.
const HEADER: usize = 58;
const EXTENDED: usize = 12;
/// Most bytes after the header.
const LARGEST: u64 = 64 << 20;
/// IANA's number of UTF-8.
const UTF_8: u16 = 106;

static CRC: Crc<u64, Table<16>> = Crc::<u64, Table<16>>::new(&CRC_64_ECMA_182);

/// A message.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Message {
    /// Version of the header, 1 to 3.
    pub version: u16,
    /// Type, such as `IMAGE`; 12 bytes at most.
    pub kind: String,
    /// Name of the device; 20 bytes at most.
    pub name: String,
    /// Time, s·2³²; 0 if unknown.
    pub time: u64,
    /// Number of the message, from version 2 on.
    pub id: u32,
    /// Content.
    pub content: Vec<u8>,
    /// Texts by their keys, from version 2 on.
    pub metadata: Vec<(String, String)>,
}

/// Reads big-endian numbers one after the other.
pub(crate) struct Numbers<'b>(pub &'b [u8]);

impl<'b> Numbers<'b> {
    /// The next `N` bytes.
    pub fn next<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (own, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(*own)
    }

    /// The next bytes.
    pub fn bytes(&mut self, count: usize) -> Option<&'b [u8]> {
        let (own, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(own)
    }

    /// The next numbers of 16 bits.
    pub fn u16s<const N: usize>(&mut self) -> Option<[u16; N]> {
        let mut own = [0; N];
        for number in &mut own {
            *number = u16::from_be_bytes(self.next()?);
        }
        Some(own)
    }

    /// The next number of 32 bits.
    pub fn u32(&mut self) -> Option<u32> {
        self.next().map(u32::from_be_bytes)
    }

    /// The next floats.
    pub fn f32s<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut own = [0.0; N];
        for number in &mut own {
            *number = f32::from_be_bytes(self.next()?).into();
        }
        Some(own)
    }
}

/// The text before the first 0.
fn text(bytes: &[u8]) -> String {
    let own = bytes.split(|byte| *byte == 0).next().unwrap_or_default();
    String::from_utf8_lossy(own).trim_end().to_owned()
}

/// A text cut or filled to `N` bytes.
pub(crate) fn padded<const N: usize>(text: &str) -> [u8; N] {
    let mut own = [0; N];
    own.iter_mut()
        .zip(text.bytes())
        .for_each(|(to, from)| *to = from);
    own
}

impl Message {
    /// Reads the next message; `None` if the stream ends before it.
    ///
    /// Between messages the stream may be silent for any time. Within one, a read that times out is an error.
    ///
    /// # Errors
    /// A stream that breaks off, sizes that contradict each other or are too large, or a wrong CRC.
    pub fn read(stream: &mut impl Read) -> Result<Option<Self>, String> {
        let within = |e: std::io::Error| match e.kind() {
            ErrorKind::UnexpectedEof => "ended within a message".to_owned(),
            ErrorKind::WouldBlock | ErrorKind::TimedOut => "stopped within a message".to_owned(),
            _ => format!("failed within a message: {e}"),
        };
        let mut header = [0; HEADER];
        loop {
            match stream.read(&mut header[..1]) {
                Ok(0) => return Ok(None),
                Ok(_) => break,
                Err(e) => match e.kind() {
                    ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted => {}
                    _ => return Err(format!("failed: {e}")),
                },
            }
        }
        stream.read_exact(&mut header[1..]).map_err(within)?;
        let fields = || {
            let mut numbers = Numbers(&header);
            let [version] = numbers.u16s()?;
            let [kind, name] = [numbers.bytes(12)?, numbers.bytes(20)?].map(text);
            let [time, size, crc] =
                [numbers.next()?, numbers.next()?, numbers.next()?].map(u64::from_be_bytes);
            Some((version, kind, name, time, size, crc))
        };
        let (version, kind, name, time, size, crc) = fields().unwrap_or_default();
        let is_kind = |byte: u8| byte.is_ascii_uppercase() || byte.is_ascii_digit() || byte == b'_';
        if !(1..=3).contains(&version) || kind.is_empty() || !kind.bytes().all(is_kind) {
            return Err("sends no OpenIGTLink of header version 1 to 3".into());
        }
        if size > LARGEST {
            return Err(format!(
                "claims a message of {size} bytes; expected at most {LARGEST}"
            ));
        }
        // Grows with what arrives: sizes may lie.
        let mut body = Vec::new();
        stream.take(size).read_to_end(&mut body).map_err(within)?;
        if (body.len() as u64) < size {
            return Err("ended within a message".into());
        }
        if CRC.checksum(&body) != crc {
            return Err(format!("sent a {kind} with a wrong CRC"));
        }
        let mut message = Self {
            version,
            kind,
            name,
            time,
            ..Self::default()
        };
        if version == 1 {
            message.content = body;
            return Ok(Some(message));
        }
        let wrong = || format!("sent a {} whose extended header does not fit", message.kind);
        let (id, content, metadata) = extended(&body).ok_or_else(wrong)?;
        message.id = id;
        message.metadata = metadata;
        body.truncate(content.end);
        body.drain(..content.start);
        message.content = body;
        Ok(Some(message))
    }

    /// The bytes of the message.
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(HEADER + EXTENDED + self.content.len());
        bytes.extend(self.version.to_be_bytes());
        bytes.extend(padded::<12>(&self.kind));
        bytes.extend(padded::<20>(&self.name));
        bytes.extend(self.time.to_be_bytes());
        bytes.extend([0; 16]);
        if self.version > 1 {
            let texts: usize = self
                .metadata
                .iter()
                .map(|(key, value)| key.len() + value.len())
                .sum();
            bytes.extend((EXTENDED as u16).to_be_bytes());
            bytes.extend((2 + 8 * self.metadata.len() as u16).to_be_bytes());
            bytes.extend((texts as u32).to_be_bytes());
            bytes.extend(self.id.to_be_bytes());
        }
        bytes.extend(&self.content);
        if self.version > 1 {
            bytes.extend((self.metadata.len() as u16).to_be_bytes());
            for (key, value) in &self.metadata {
                bytes.extend((key.len() as u16).to_be_bytes());
                bytes.extend(UTF_8.to_be_bytes());
                bytes.extend((value.len() as u32).to_be_bytes());
            }
            for (key, value) in &self.metadata {
                bytes.extend([key.as_bytes(), value.as_bytes()].concat());
            }
        }
        let size = (bytes.len() - HEADER) as u64;
        let crc = CRC.checksum(&bytes[HEADER..]);
        bytes[42..50].copy_from_slice(&size.to_be_bytes());
        bytes[50..58].copy_from_slice(&crc.to_be_bytes());
        bytes
    }

    /// The time, s; `None` if the sender gives none.
    pub fn seconds(&self) -> Option<f64> {
        (self.time > 0).then_some(self.time as f64 / 4_294_967_296.0)
    }
}

type Extended = (u32, std::ops::Range<usize>, Vec<(String, String)>);

/// The message's number, the place of its content, and its metadata.
fn extended(body: &[u8]) -> Option<Extended> {
    let mut numbers = Numbers(body);
    let [own, index] = numbers.u16s()?.map(usize::from);
    let [texts, id] = [numbers.u32()?, numbers.u32()?];
    let end = body.len().checked_sub(index)?.checked_sub(texts as usize)?;
    if own < EXTENDED || own > end {
        return None;
    }
    let mut metadata = Vec::new();
    if index > 0 {
        let (index, texts) = body[end..].split_at(index);
        let (mut index, mut texts) = (Numbers(index), Numbers(texts));
        let [count] = index.u16s()?;
        for _ in 0..count {
            let [key, _] = index.u16s()?;
            let value = index.u32()?;
            let [key, value] = [texts.bytes(key.into())?, texts.bytes(value as usize)?].map(text);
            metadata.push((key, value));
        }
    }
    Some((id, own..end, metadata))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(version: u16) -> Message {
        let metadata = match version {
            1 => vec![],
            _ => vec![
                ("TransformStatus".into(), "OK".into()),
                ("ö".into(), String::new()),
            ],
        };
        Message {
            version,
            kind: "STATUS".into(),
            name: "Probe".into(),
            time: 3 << 31,
            id: if version > 1 { 7 } else { 0 },
            content: b"123456789".to_vec(),
            metadata,
        }
    }

    #[test]
    fn messages_are_the_bytes_of_the_specification() {
        let bytes = message(1).bytes();
        let expected = [
            &b"\x00\x01STATUS\0\0\0\0\0\0Probe\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0"[..],
            // 1.5 s, nine bytes, ECMA-182's check value.
            b"\0\0\0\x01\x80\0\0\0\0\0\0\0\0\0\0\x09\x6c\x40\xdf\x5f\x0b\x49\x73\x47",
            b"123456789",
        ];
        assert_eq!(bytes, expected.concat());
        assert_eq!(message(1).seconds(), Some(1.5));
        // Extended header, content, index and texts of the metadata.
        let expected = [
            &b"\0\x0c\0\x12\0\0\0\x13\0\0\0\x07123456789\0\x02"[..],
            b"\0\x0f\0\x6a\0\0\0\x02\0\x02\0\x6a\0\0\0\0TransformStatusOK\xc3\xb6",
        ];
        assert_eq!(message(2).bytes()[HEADER..], expected.concat());
        for version in 1..=3 {
            let bytes = [message(version).bytes(), message(1).bytes()].concat();
            let mut stream = &bytes[..];
            for expected in [Some(message(version)), Some(message(1)), None] {
                assert_eq!(Message::read(&mut stream), Ok(expected));
            }
        }
    }

    #[test]
    fn damaged_messages_are_refused() {
        let refused = |bytes: &[u8]| Message::read(&mut &bytes[..]).unwrap_err();
        for version in [1, 2] {
            let bytes = message(version).bytes();
            for end in 1..bytes.len() {
                assert_eq!(refused(&bytes[..end]), "ended within a message");
            }
        }
        let changed = |version: u16, at: usize, to: u8| {
            let mut bytes = message(version).bytes();
            bytes[at] = to;
            if at >= HEADER {
                let crc = CRC.checksum(&bytes[HEADER..]);
                bytes[50..58].copy_from_slice(&crc.to_be_bytes());
            }
            refused(&bytes)
        };
        assert!(changed(1, 1, 4).contains("version 1 to 3"));
        assert!(changed(1, 3, b' ').contains("version 1 to 3"));
        assert!(changed(1, 42, 1).contains("claims a message of 72057594037927945 bytes"));
        assert!(changed(1, 57, 0).contains("wrong CRC"));
        // The sizes of the extended header, of the metadata's index and texts, their count, and a key's length.
        for (at, to) in [(59, 11), (59, 200), (60, 1), (62, 1), (79, 200), (80, 9)] {
            assert!(changed(2, at, to).contains("does not fit"), "{at}");
        }
    }
}
