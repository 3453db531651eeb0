//! The bytes of a MATLAB file: tags, numbers and texts, whatever the order of their bytes.

use std::io::{ErrorKind, Read, Take};

use super::SAVE_AS;
use crate::error::RecordingError;

/// Bytes of the head.
const HEAD: usize = 128;
/// Bytes that are read at once.
const PIECE: usize = 1 << 16;

/// Types of data elements.
pub(super) mod kind {
    pub const INT8: u32 = 1;
    pub const UINT8: u32 = 2;
    pub const INT16: u32 = 3;
    pub const UINT16: u32 = 4;
    pub const INT32: u32 = 5;
    pub const UINT32: u32 = 6;
    pub const SINGLE: u32 = 7;
    pub const DOUBLE: u32 = 9;
    pub const INT64: u32 = 12;
    pub const UINT64: u32 = 13;
    pub const MATRIX: u32 = 14;
    pub const COMPRESSED: u32 = 15;
    pub const UTF8: u32 = 16;
}

/// What stands before the data of an element.
#[derive(Clone, Copy)]
pub(super) struct Tag {
    pub kind: u32,
    pub size: u64,
    /// Bytes after the data that belong to nothing.
    pub padding: u64,
}

/// How the bytes of a file are told.
#[derive(Clone, Copy)]
pub(super) struct Manner<'f> {
    file: &'f str,
    pub big_endian: bool,
}

impl Manner<'_> {
    pub fn u32(self, bytes: [u8; 4]) -> u32 {
        if self.big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) }
    }

    fn u16(self, bytes: [u8; 2]) -> u16 {
        if self.big_endian { u16::from_be_bytes(bytes) } else { u16::from_le_bytes(bytes) }
    }

    pub fn failed(self, error: &std::io::Error) -> RecordingError {
        match error.kind() {
            ErrorKind::UnexpectedEof => self.broken("it ends too soon"),
            _ => self.broken(&error.to_string()),
        }
    }

    fn broken(self, reason: &str) -> RecordingError {
        RecordingError::Broken { file: self.file.into(), format: "MATLAB", reason: reason.into() }
    }

    fn other_version(self, found: &str) -> RecordingError {
        RecordingError::NotRead {
            file: self.file.into(),
            what: "the version".into(),
            found: found.into(),
            advice: SAVE_AS,
        }
    }
}

/// Bytes that are read from the first to the last.
pub(super) struct Stream<'s> {
    bytes: &'s mut dyn Read,
    manner: Manner<'s>,
    /// Number of bytes before this place.
    pub at: u64,
}

impl<'s> Stream<'s> {
    pub fn new(bytes: &'s mut dyn Read, manner: Manner<'s>) -> Self {
        Self { bytes, manner, at: 0 }
    }

    /// A file, after its head.
    pub fn open(bytes: &'s mut dyn Read, file: &'s str) -> Result<Self, RecordingError> {
        let mut stream = Self::new(bytes, Manner { file, big_endian: false });
        let head: [u8; HEAD] = stream.take()?;
        let manner = &mut stream.manner;
        manner.big_endian = match &head[HEAD - 2..] {
            b"IM" => false,
            b"MI" => true,
            // Version 4 has no head: its first number is less than 5000.
            _ if head[..4].contains(&0) => return Err(manner.other_version("MATLAB 4")),
            _ => return Err(manner.broken("it does not begin as a MATLAB file does")),
        };
        let version = manner.u16([head[HEAD - 4], head[HEAD - 3]]);
        if head.starts_with(b"MATLAB 7.3") || version != 0x100 {
            return Err(manner.other_version("MATLAB 7.3 (HDF5)"));
        }
        Ok(stream)
    }

    pub fn manner(&self) -> Manner<'s> {
        self.manner
    }

    /// The next tag; none at the end.
    pub fn next_tag(&mut self) -> Result<Option<Tag>, RecordingError> {
        let mut first = [0];
        loop {
            match self.bytes.read(&mut first) {
                Ok(0) => return Ok(None),
                Ok(_) => break,
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Err(e) => return Err(self.manner.failed(&e)),
            }
        }
        self.at += 1;
        let [b, c, d] = self.take()?;
        let word = self.manner.u32([first[0], b, c, d]);
        self.rest_of_tag(word).map(Some)
    }

    /// The next tag, where there must be one.
    pub fn tag(&mut self) -> Result<Tag, RecordingError> {
        let word = self.word()?;
        self.rest_of_tag(word)
    }

    /// A tag of one of these kinds.
    pub fn tag_of(&mut self, kinds: &[u32]) -> Result<Tag, RecordingError> {
        let tag = self.tag()?;
        if kinds.contains(&tag.kind) {
            return Ok(tag);
        }
        Err(self.broken(&format!("expected an element of type {kinds:?}, found {}", tag.kind)))
    }

    fn rest_of_tag(&mut self, word: u32) -> Result<Tag, RecordingError> {
        // Few bytes stand in the tag itself.
        if word >> 16 != 0 {
            let size = u64::from(word >> 16);
            let Some(padding) = 4u64.checked_sub(size) else {
                return Err(self.broken(&format!("an element of {size} bytes in four")));
            };
            return Ok(Tag { kind: word & 0xffff, size, padding });
        }
        let size = u64::from(self.word()?);
        let padding = if word == kind::COMPRESSED { 0 } else { size.next_multiple_of(8) - size };
        Ok(Tag { kind: word, size, padding })
    }

    /// The data of a short element, which may hold no more than `most` bytes.
    pub fn data(&mut self, tag: Tag, most: u64) -> Result<Vec<u8>, RecordingError> {
        if tag.size > most {
            return Err(
                self.broken(&format!("an element of {} bytes, where {most} are allowed", tag.size))
            );
        }
        let mut data = vec![0; tag.size as usize];
        self.fill(&mut data)?;
        self.skip(tag.padding)?;
        Ok(data)
    }

    pub fn skip(&mut self, bytes: u64) -> Result<(), RecordingError> {
        let copied = std::io::copy(&mut (&mut *self.bytes).take(bytes), &mut std::io::sink());
        let copied = copied.map_err(|e| self.manner.failed(&e))?;
        self.at += copied;
        if copied < bytes { Err(self.broken("it ends too soon")) } else { Ok(()) }
    }

    /// Hands on the data of an element piece by piece; numbers of up to eight bytes are not torn.
    pub fn pieces(
        &mut self,
        tag: Tag,
        mut sink: impl FnMut(&[u8]) -> Result<(), RecordingError>,
    ) -> Result<(), RecordingError> {
        let mut piece = vec![0; PIECE.min(tag.size as usize)];
        let mut left = tag.size as usize;
        while left > 0 {
            let now = &mut piece[..left.min(PIECE)];
            self.fill(now)?;
            sink(now)?;
            left -= now.len();
        }
        self.skip(tag.padding)
    }

    /// So many bytes, which are not read here.
    pub fn rest(&mut self, bytes: u64) -> Take<&mut (dyn Read + 's)> {
        self.at += bytes;
        (&mut *self.bytes).take(bytes)
    }

    fn word(&mut self) -> Result<u32, RecordingError> {
        let bytes = self.take()?;
        Ok(self.manner.u32(bytes))
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], RecordingError> {
        let mut bytes = [0; N];
        self.fill(&mut bytes)?;
        Ok(bytes)
    }

    fn fill(&mut self, bytes: &mut [u8]) -> Result<(), RecordingError> {
        self.bytes.read_exact(bytes).map_err(|e| self.manner.failed(&e))?;
        self.at += bytes.len() as u64;
        Ok(())
    }

    pub fn broken(&self, reason: &str) -> RecordingError {
        self.manner.broken(reason)
    }
}
