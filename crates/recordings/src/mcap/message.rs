//! The numbers of one message, and what their columns are called.
//!
//! Numbers stand in the order of the message; which column each belongs to depends on the message's shape alone: the
//! lengths of its lists and the names of its joints. So names are made once for every shape, and a message of a shape
//! that is known costs a walk over its bytes; one that is laid out as the message before ([`Layout`]) not even that.

use super::definition::{Count, Kind, Number, Schema};
use crate::parquet::LONGEST_LIST;

/// Fields that name the entries of the lists beside and below them.
pub(super) const NAMING: [&str; 4] = ["name", "names", "joint_names", "joint_name"];
/// Bytes of a message in CDR before what is aligned.
const HEAD: usize = 4;
/// Bytes of the length of a list or a text.
const LENGTH: usize = 4;
/// Numbers of one message: more are a picture or a cloud of points.
const MOST_NUMBERS: usize = 1 << 14;

/// How messages are written.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Encoding {
    /// Common data representation: what is written is aligned, after four bytes that say how.
    Cdr,
    /// As ROS 1 writes: nothing is aligned, the least byte first.
    Ros1,
}

/// What was found in a message.
#[derive(Default)]
pub(super) struct Numbers {
    pub values: Vec<f64>,
    /// What tells one shape from another.
    pub shape: Vec<u8>,
    /// Names of the columns, without the topic; made where asked for.
    pub names: Option<Vec<String>>,
    /// Where all this stood, of what is no text.
    pub layout: Layout,
}

/// Where the numbers of a message stand, and the bytes that make another message the same in this: its representation,
/// the lengths of its lists and texts, the names of its joints.
#[derive(Default)]
pub(super) struct Layout {
    /// Bytes of the message.
    length: usize,
    big_endian: bool,
    /// Where the bytes are that tell, first and behind the last.
    telling: Vec<(usize, usize)>,
    /// What they are, one after another.
    told: Vec<u8>,
    /// Where each number stands, in the order of the message.
    numbers: Vec<(usize, Number)>,
}

impl Layout {
    fn begin(&mut self, cursor: &Cursor<'_>) {
        let head = cursor.head;
        (self.length, self.big_endian) = (head + cursor.data.len(), cursor.big_endian);
        self.telling.clear();
        self.told.clear();
        self.numbers.clear();
        self.telling.push((0, head));
    }

    /// These bytes tell; those that follow one another are one piece.
    fn tells(&mut self, first: usize, behind: usize) {
        match self.telling.last_mut() {
            Some(last) if last.1 == first => last.1 = behind,
            _ => self.telling.push((first, behind)),
        }
    }

    fn end(&mut self, data: &[u8]) {
        let Self { telling, told, .. } = self;
        telling.iter().for_each(|&(first, behind)| told.extend_from_slice(&data[first..behind]));
    }

    /// Whether the numbers of this message stand where those of the other one stood.
    pub fn fits(&self, data: &[u8]) -> bool {
        let mut told = &self.told[..];
        data.len() == self.length
            && self.telling.iter().all(|&(first, behind)| {
                let (own, rest) = told.split_at(behind - first);
                told = rest;
                data[first..behind] == *own
            })
    }

    /// The `k`-th number of a message that fits.
    pub fn number(&self, data: &[u8], k: usize) -> Option<f64> {
        let &(at, number) = self.numbers.get(k)?;
        Some(number.read(&data[at..at + number.bytes()], self.big_endian))
    }
}

/// Reads a message.
///
/// Returns what is wrong with it.
pub(super) fn read(
    schema: &Schema,
    encoding: Encoding,
    data: &[u8],
    found: &mut Numbers,
) -> Result<(), String> {
    let cursor = Cursor::new(encoding, data)?;
    found.layout.begin(&cursor);
    let mut walk =
        Walk { schema, cursor, found, path: String::new(), joints: vec![], muted: false };
    let read = walk.message(0);
    read.ok_or_else(|| format!("a message of {} bytes ends too soon", data.len()))?;
    found.layout.end(data);
    Ok(())
}

struct Walk<'s, 'd> {
    schema: &'s Schema,
    cursor: Cursor<'d>,
    found: &'s mut Numbers,
    path: String,
    joints: Vec<String>,
    /// Within a list that is too long to be columns.
    muted: bool,
}

impl<'d> Walk<'_, 'd> {
    fn message(&mut self, message: usize) -> Option<()> {
        let schema = self.schema;
        let (above, outer) = (self.path.len(), self.joints.len());
        // The representation has no structs of nothing.
        if schema.messages[message].is_empty() && self.cursor.encoding == Encoding::Cdr {
            self.cursor.take(1)?;
        }
        let mut own_joints = None;
        for field in &schema.messages[message] {
            if self.found.names.is_some() {
                self.path.push('.');
                self.path.push_str(&field.name);
            }
            let length = match field.count {
                Count::One => None,
                Count::Fixed(length) => Some(length),
                Count::Any => Some(self.length()?),
            };
            let names = field.kind == Kind::Text && NAMING.contains(&field.name.as_str());
            match length {
                None => self.one(field.kind)?,
                Some(length) if names && length <= LONGEST_LIST => {
                    let joints = self.joint_names(length)?;
                    own_joints.get_or_insert_with(|| std::mem::replace(&mut self.joints, joints));
                }
                Some(length) => self.list(field.kind, length)?,
            }
            self.path.truncate(above);
        }
        if let Some(before) = own_joints {
            self.joints = before;
        }
        debug_assert!(self.muted || outer == self.joints.len());
        Some(())
    }

    fn length(&mut self) -> Option<usize> {
        let length = self.told_length()?;
        if !self.muted {
            self.found.shape.extend_from_slice(&(length as u32).to_le_bytes());
        }
        Some(length)
    }

    /// A length, of which it depends where things stand.
    fn told_length(&mut self) -> Option<usize> {
        let length = self.cursor.length()?;
        self.tells(LENGTH);
        Some(length)
    }

    /// A text, whose length tells.
    fn text(&mut self) -> Option<&'d [u8]> {
        let length = self.told_length()?;
        self.cursor.take(length)
    }

    /// So many bytes that were read last tell.
    fn tells(&mut self, bytes: usize) {
        let behind = self.cursor.behind();
        self.found.layout.tells(behind - bytes, behind);
    }

    fn joint_names(&mut self, length: usize) -> Option<Vec<String>> {
        let mut names = Vec::new();
        for _ in 0..length {
            let text = self.text()?;
            self.tells(text.len());
            let text = text.strip_suffix(b"\0").unwrap_or(text);
            if !self.muted {
                self.found.shape.extend_from_slice(&(text.len() as u32).to_le_bytes());
                self.found.shape.extend_from_slice(text);
            }
            if self.found.names.is_some() {
                names.push(String::from_utf8_lossy(text).into_owned());
            }
        }
        Some(unique(names))
    }

    fn list(&mut self, kind: Kind, length: usize) -> Option<()> {
        let before = self.muted;
        self.muted |= length > LONGEST_LIST;
        if let (Kind::Number(number), true) = (kind, self.muted) {
            self.cursor.skip(number, length)?;
        } else {
            let above = self.path.len();
            for entry in 0..length {
                if self.found.names.is_some() && !self.muted {
                    let name = self.joints.get(entry).filter(|_| self.joints.len() == length);
                    self.path += &name.map_or_else(|| format!("[{entry}]"), |n| format!("[{n}]"));
                }
                let start = self.cursor.at;
                self.one(kind)?;
                self.path.truncate(above);
                // What takes no bytes could be repeated without end.
                if self.cursor.at == start {
                    break;
                }
            }
        }
        self.muted = before;
        Some(())
    }

    fn one(&mut self, kind: Kind) -> Option<()> {
        match kind {
            Kind::Text => self.text().map(|_| ()),
            Kind::Message(message) => self.message(message),
            Kind::Number(number) => {
                let value = self.cursor.number(number)?;
                if !self.muted && self.found.values.len() < MOST_NUMBERS {
                    let at = self.cursor.behind() - number.bytes();
                    self.found.layout.numbers.push((at, number));
                    self.found.values.push(value);
                    if let Some(names) = &mut self.found.names {
                        names.push(self.path[1..].to_owned());
                    }
                }
                Some(())
            }
        }
    }
}

/// Names by which entries can be told apart, else none.
pub(super) fn unique(names: Vec<String>) -> Vec<String> {
    let repeated = |(k, name): (usize, &String)| name.is_empty() || names[..k].contains(name);
    if names.iter().enumerate().any(repeated) { vec![] } else { names }
}

struct Cursor<'d> {
    encoding: Encoding,
    /// Bytes before what is aligned.
    head: usize,
    data: &'d [u8],
    at: usize,
    big_endian: bool,
    /// Numbers are aligned to their size, and to no more than this.
    align: usize,
}

impl<'d> Cursor<'d> {
    fn new(encoding: Encoding, data: &'d [u8]) -> Result<Self, String> {
        if encoding == Encoding::Ros1 {
            return Ok(Self { encoding, head: 0, data, at: 0, big_endian: false, align: 1 });
        }
        let Some((head, data)) = data.split_at_checked(HEAD) else {
            return Err(format!("a message of {} bytes ends too soon", data.len()));
        };
        let (big_endian, align) = match head[1] {
            0 => (true, 8),
            1 => (false, 8),
            6 => (true, 4),
            7 => (false, 4),
            other => return Err(format!("representation {other} of CDR is not read")),
        };
        Ok(Self { encoding, head: HEAD, data, at: 0, big_endian, align })
    }

    /// Bytes of the message that were read.
    fn behind(&self) -> usize {
        self.head + self.at
    }

    fn take(&mut self, bytes: usize) -> Option<&'d [u8]> {
        let end = self.at.checked_add(bytes)?;
        let taken = self.data.get(self.at..end)?;
        self.at = end;
        Some(taken)
    }

    fn align_to(&mut self, bytes: usize) {
        self.at = self.at.next_multiple_of(bytes.min(self.align));
    }

    fn length(&mut self) -> Option<usize> {
        self.number(Number::Unsigned(LENGTH)).map(|length| length as usize)
    }

    fn skip(&mut self, number: Number, length: usize) -> Option<()> {
        self.align_to(number.bytes());
        self.take(number.bytes().checked_mul(length)?).map(|_| ())
    }

    fn number(&mut self, number: Number) -> Option<f64> {
        self.align_to(number.bytes());
        Some(number.read(self.take(number.bytes())?, self.big_endian))
    }
}
