//! The arrays of a MATLAB file: those that are wanted with their numbers, the others with their sizes.

use std::collections::BTreeMap;
use std::io::Read;

use flate2::read::ZlibDecoder;

use super::stream::{Stream, Tag, kind};
use crate::error::RecordingError;
use crate::log::Wanted;
use crate::memory::Budget;
use crate::parquet::LONGEST_LIST;

/// Structs within structs; real ones have a handful.
const DEEPEST: usize = 32;
/// Bytes of the longest name, and of the names of a struct's fields.
const LONGEST_NAME: u64 = 1 << 12;
const LONGEST_NAMES: u64 = 1 << 20;
/// Dimensions of an array.
const MOST_DIMS: u64 = 32;
/// Flag of arrays with an imaginary part.
const COMPLEX: u32 = 0x800;

/// Classes of arrays.
mod class {
    pub const CELL: u32 = 1;
    pub const STRUCT: u32 = 2;
    pub const CHAR: u32 = 4;
    pub const SPARSE: u32 = 5;
    pub const DOUBLE: u32 = 6;
    pub const UINT64: u32 = 15;
    pub const OPAQUE: u32 = 17;

    /// What is not read.
    pub fn in_words(class: u32) -> &'static str {
        match class {
            CELL => "a cell array",
            CHAR => "a text",
            SPARSE => "a sparse matrix",
            OPAQUE => "an object (of a timeseries ts save ts.Time and ts.Data)",
            _ => "an object or a function",
        }
    }
}

/// An array of numbers.
pub(super) struct Array {
    pub name: String,
    pub dims: Vec<usize>,
    /// Its entries, the first dimension running fastest; none where nobody wants them.
    pub values: Option<Vec<f64>>,
}

/// What is kept of a file.
pub(super) struct Arrays<'w> {
    wanted: &'w Wanted,
    budget: Budget,
    pub all: Vec<Array>,
    /// Variables that are not read, and why.
    pub not_read: BTreeMap<String, String>,
}

impl<'w> Arrays<'w> {
    pub fn new(wanted: &'w Wanted, budget: Budget) -> Self {
        Self { wanted, budget, all: vec![], not_read: BTreeMap::new() }
    }

    /// Reads all variables.
    pub fn read(&mut self, bytes: &mut dyn Read, file: &str) -> Result<(), RecordingError> {
        let mut stream = Stream::open(bytes, file)?;
        while let Some(tag) = stream.next_tag()? {
            match tag.kind {
                kind::MATRIX => self.matrix(&mut stream, tag, None, 0)?,
                kind::COMPRESSED => self.compressed(&mut stream, tag)?,
                _ => stream.skip(tag.size)?,
            }
            stream.skip(tag.padding)?;
        }
        Ok(())
    }

    fn compressed(&mut self, stream: &mut Stream, tag: Tag) -> Result<(), RecordingError> {
        let manner = stream.manner();
        let mut rest = stream.rest(tag.size);
        let mut decoder = ZlibDecoder::new(&mut rest);
        let mut inner = Stream::new(&mut decoder, manner);
        let own = inner.tag_of(&[kind::MATRIX])?;
        self.matrix(&mut inner, own, None, 0)?;
        // The sum of what was decompressed is checked at its end.
        decoder.read(&mut [0]).map_err(|e| manner.failed(&e))?;
        // The stream goes on where the compressed bytes end, however many of them were needed.
        std::io::copy(&mut rest, &mut std::io::sink()).map_err(|e| manner.failed(&e))?;
        if rest.limit() > 0 { Err(stream.broken("it ends too soon")) } else { Ok(()) }
    }

    /// Reads an array of any class; `above` is what it is called within a struct.
    fn matrix(
        &mut self,
        stream: &mut Stream,
        tag: Tag,
        above: Option<String>,
        depth: usize,
    ) -> Result<(), RecordingError> {
        if tag.size == 0 {
            return Ok(());
        }
        if depth > DEEPEST {
            return Err(stream.broken(&format!("structs in structs, more than {DEEPEST} deep")));
        }
        let end = stream.at + tag.size;
        let flags = self.flags(stream)?;
        let class = flags & 0xff;
        let dims = if class == class::OPAQUE { vec![] } else { dims(stream)? };
        let own = stream.tag_of(&[kind::INT8, kind::UTF8])?;
        let own = text(&stream.data(own, LONGEST_NAME)?);
        let name = above.unwrap_or(own);
        // What has no name is MATLAB's own.
        if !name.is_empty() {
            match class {
                class::STRUCT => self.structs(stream, name, &dims, depth)?,
                class::DOUBLE..=class::UINT64 if flags & COMPLEX != 0 => {
                    self.not_read.insert(name, "complex numbers".into());
                }
                class::DOUBLE..=class::UINT64 => self.numbers(stream, name, dims)?,
                other => {
                    self.not_read.insert(name, class::in_words(other).into());
                }
            }
        }
        let Some(left) = end.checked_sub(stream.at) else {
            return Err(stream.broken("an array is longer than it says"));
        };
        stream.skip(left)
    }

    fn flags(&self, stream: &mut Stream) -> Result<u32, RecordingError> {
        let tag = stream.tag_of(&[kind::UINT32])?;
        match stream.data(tag, 8)?[..] {
            [a, b, c, d, ..] => Ok(stream.manner().u32([a, b, c, d])),
            _ => Err(stream.broken("an array without a class")),
        }
    }

    /// The fields of one struct, or of each of several.
    fn structs(
        &mut self,
        stream: &mut Stream,
        name: String,
        dims: &[usize],
        depth: usize,
    ) -> Result<(), RecordingError> {
        let count = product(stream, dims)?;
        if count > LONGEST_LIST {
            let why = format!("{count} structs, where {LONGEST_LIST} are read at most");
            self.not_read.insert(name, why);
            return Ok(());
        }
        let fields = fields(stream)?;
        for element in 0..count {
            for field in &fields {
                let own = match count {
                    1 => format!("{name}.{field}"),
                    _ => format!("{name}[{element}].{field}"),
                };
                let tag = stream.tag_of(&[kind::MATRIX])?;
                self.matrix(stream, tag, Some(own), depth + 1)?;
                stream.skip(tag.padding)?;
            }
        }
        Ok(())
    }

    fn numbers(
        &mut self,
        stream: &mut Stream,
        name: String,
        dims: Vec<usize>,
    ) -> Result<(), RecordingError> {
        let wanted = self.wanted;
        let is_wanted =
            wanted.time == name || wanted.keeps(&name) || wanted.keeps_some(&format!("{name}["));
        let values = if is_wanted { Some(self.values(stream, &name, &dims)?) } else { None };
        self.all.push(Array { name, dims, values });
        Ok(())
    }

    fn values(
        &mut self,
        stream: &mut Stream,
        name: &str,
        dims: &[usize],
    ) -> Result<Vec<f64>, RecordingError> {
        let expected = product(stream, dims)?;
        let tag = stream.tag()?;
        let Some((width, number)) = number(tag.kind, stream.manner().big_endian) else {
            return Err(stream.broken(&format!("'{name}' has numbers of type {}", tag.kind)));
        };
        if expected.checked_mul(width).is_none_or(|bytes| bytes as u64 != tag.size) {
            return Err(stream.broken(&format!(
                "'{name}' has {} bytes, where {expected} numbers of {width} bytes are expected",
                tag.size
            )));
        }
        let mut values = Vec::new();
        stream.pieces(tag, |piece| {
            self.budget.take_numbers((piece.len() / width) as u64)?;
            values.extend(piece.chunks_exact(width).map(number));
            Ok(())
        })?;
        Ok(values)
    }
}

fn dims(stream: &mut Stream) -> Result<Vec<usize>, RecordingError> {
    let tag = stream.tag_of(&[kind::INT32])?;
    let data = stream.data(tag, 4 * MOST_DIMS)?;
    let dim = |b: &[u8]| {
        let dim = stream.manner().u32([b[0], b[1], b[2], b[3]]) as i32;
        usize::try_from(dim).map_err(|_| stream.broken(&format!("an array of dimension {dim}")))
    };
    data.chunks_exact(4).map(dim).collect()
}

fn product(stream: &Stream, dims: &[usize]) -> Result<usize, RecordingError> {
    let product = dims.iter().try_fold(1usize, |product, dim| product.checked_mul(*dim));
    product.ok_or_else(|| stream.broken("an array of more entries than can be counted"))
}

/// Names of the fields of a struct, each of the same number of bytes.
fn fields(stream: &mut Stream) -> Result<Vec<String>, RecordingError> {
    let tag = stream.tag_of(&[kind::INT32])?;
    let length = match stream.data(tag, 4)?[..] {
        [a, b, c, d] => stream.manner().u32([a, b, c, d]) as usize,
        _ => 0,
    };
    let tag = stream.tag_of(&[kind::INT8, kind::UTF8])?;
    let names = stream.data(tag, LONGEST_NAMES)?;
    if length == 0 && !names.is_empty() {
        return Err(stream.broken("a struct whose fields have no names"));
    }
    Ok(names.chunks(length.max(1)).map(text).collect())
}

/// A text up to the zero that ends it.
fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|b| *b == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}

/// Number of bytes of a number, and how it is made of them.
type Number = (usize, fn(&[u8]) -> f64);

/// A number of this type; none for what is no number.
fn number(kind: u32, big_endian: bool) -> Option<Number> {
    macro_rules! of {
        ($number:ty) => {
            (
                size_of::<$number>(),
                match big_endian {
                    true => {
                        |b: &[u8]| <$number>::from_be_bytes(b.try_into().unwrap_or_default()) as f64
                    }
                    false => {
                        |b: &[u8]| <$number>::from_le_bytes(b.try_into().unwrap_or_default()) as f64
                    }
                },
            )
        };
    }
    Some(match kind {
        kind::INT8 => of!(i8),
        kind::UINT8 => of!(u8),
        kind::INT16 => of!(i16),
        kind::UINT16 => of!(u16),
        kind::INT32 => of!(i32),
        kind::UINT32 => of!(u32),
        kind::SINGLE => of!(f32),
        kind::DOUBLE => of!(f64),
        kind::INT64 => of!(i64),
        kind::UINT64 => of!(u64),
        _ => return None,
    })
}
