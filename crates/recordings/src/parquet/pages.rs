//! How large the pages of a column are once they are decompressed, by their headers, before anything is.
//!
//! A page's header is a struct of Thrift's compact protocol: fields 2 and 3 are its sizes without and with
//! compression, fields 5 and 8 structs (of either version) whose field 1 is the number of values.

use std::io::{self, BufRead, BufReader, Error, ErrorKind, Read, Seek, SeekFrom};

/// Fields of the header.
const UNCOMPRESSED: i16 = 2;
const COMPRESSED: i16 = 3;
const DATA: [i16; 2] = [5, 8];
const VALUES: i16 = 1;
/// Structs within structs; headers have three.
const DEEPEST: usize = 16;

/// What the pages of a column say of themselves.
#[derive(Default)]
pub(super) struct Pages {
    /// Bytes of the largest of them, decompressed.
    pub largest: u64,
    /// Number of values in all of them.
    pub values: u64,
}

/// Of the pages in `length` bytes from `start` on.
pub(super) fn pages(file: impl Read + Seek, start: u64, length: u64) -> io::Result<Pages> {
    let mut input = BufReader::new(file);
    input.seek(SeekFrom::Start(start))?;
    let (mut at, end, mut pages) = (start, start.saturating_add(length), Pages::default());
    while at < end {
        let mut header = Header { input: &mut input, bytes: 0, sizes: [None; 2], values: 0 };
        header.fields(None)?;
        let Header { bytes, sizes: [Some(uncompressed), Some(compressed)], values, .. } = header
        else {
            return Err(bad("the header of a page says no size"));
        };
        pages.largest = pages.largest.max(uncompressed);
        pages.values = pages.values.saturating_add(values);
        let step = i64::try_from(compressed).map_err(|_| bad("a page is too long"))?;
        input.seek_relative(step)?;
        at = at.saturating_add(bytes).saturating_add(compressed);
    }
    Ok(pages)
}

fn bad(reason: &'static str) -> Error {
    Error::new(ErrorKind::InvalidData, reason)
}

struct Header<'r, R> {
    input: &'r mut R,
    bytes: u64,
    sizes: [Option<u64>; 2],
    values: u64,
}

/// A struct within another: how deep, and its field there.
type Within = Option<(usize, i16)>;

impl<R: BufRead> Header<'_, R> {
    fn byte(&mut self) -> io::Result<u8> {
        let mut byte = [0];
        self.input.read_exact(&mut byte)?;
        self.bytes += 1;
        Ok(byte[0])
    }

    fn varint(&mut self) -> io::Result<u64> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return Ok(value);
            }
        }
        Err(bad("a number in the header of a page does not end"))
    }

    fn signed(&mut self) -> io::Result<i64> {
        let value = self.varint()?;
        Ok((value >> 1) as i64 ^ -((value & 1) as i64))
    }

    /// The fields of a struct; sizes and numbers of values are kept.
    fn fields(&mut self, within: Within) -> io::Result<()> {
        if within.is_some_and(|(depth, _)| depth > DEEPEST) {
            return Err(bad("the header of a page is nested too deep"));
        }
        let mut field: i16 = 0;
        loop {
            let byte = self.byte()?;
            let (step, kind) = (byte >> 4, byte & 0x0f);
            if kind == 0 {
                return Ok(());
            }
            field = match step {
                0 => i16::try_from(self.signed()?).map_err(|_| bad("a field of no number"))?,
                step => field.saturating_add(step.into()),
            };
            match (within, field, kind) {
                (None, UNCOMPRESSED, 5) => self.sizes[0] = Some(self.size()?),
                (None, COMPRESSED, 5) => self.sizes[1] = Some(self.size()?),
                (Some((1, data)), VALUES, 5) if DATA.contains(&data) => {
                    self.values = self.size()?
                }
                _ => self.skip(kind, (within.map_or(0, |(depth, _)| depth), field))?,
            }
        }
    }

    fn size(&mut self) -> io::Result<u64> {
        u64::try_from(self.signed()?).map_err(|_| bad("a page of negative size"))
    }

    fn skip(&mut self, kind: u8, (depth, field): (usize, i16)) -> io::Result<()> {
        match kind {
            // Booleans are their kind.
            1 | 2 => Ok(()),
            3 => self.byte().map(|_| ()),
            4..=6 => self.varint().map(|_| ()),
            7 => self.skip_bytes(8),
            8 => {
                let length = self.varint()?;
                self.skip_bytes(length)
            }
            9 | 10 => self.skip_list(depth),
            12 => self.fields(Some((depth + 1, field))),
            _ => Err(bad("the header of a page holds what no header does")),
        }
    }

    fn skip_list(&mut self, depth: usize) -> io::Result<()> {
        if depth > DEEPEST {
            return Err(bad("the header of a page is nested too deep"));
        }
        let head = self.byte()?;
        let (length, kind) = (head >> 4, head & 0x0f);
        let length = if length == 15 { self.varint()? } else { length.into() };
        for _ in 0..length {
            // In lists a boolean is a byte.
            self.skip(if kind <= 2 { 3 } else { kind }, (depth + 1, 0))?;
        }
        Ok(())
    }

    fn skip_bytes(&mut self, bytes: u64) -> io::Result<()> {
        let skipped = io::copy(&mut self.input.by_ref().take(bytes), &mut io::sink())?;
        self.bytes += skipped;
        if skipped < bytes { Err(ErrorKind::UnexpectedEof.into()) } else { Ok(()) }
    }
}
