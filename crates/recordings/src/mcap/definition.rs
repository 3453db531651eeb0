//! Definitions of ROS messages, as text: `ros2msg` and `ros1msg`.
//!
//! A definition is a line for each field, `TYPE NAME`, after which come those of the messages that are used, each
//! below a line of `=` and one `MSG: PACKAGE/NAME`.

use std::collections::HashMap;

/// A number as it is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Number {
    Unsigned(usize),
    Signed(usize),
    Float(usize),
}

impl Number {
    pub fn bytes(self) -> usize {
        match self {
            Self::Unsigned(bytes) | Self::Signed(bytes) | Self::Float(bytes) => bytes,
        }
    }

    /// The number that these bytes are.
    pub fn read(self, bytes: &[u8], big_endian: bool) -> f64 {
        let mut raw = [0; 8];
        if big_endian {
            raw.iter_mut().zip(bytes.iter().rev()).for_each(|(to, from)| *to = *from);
        } else {
            raw[..bytes.len()].copy_from_slice(bytes);
        }
        let bits = u64::from_le_bytes(raw);
        match self {
            Self::Unsigned(_) => bits as f64,
            Self::Signed(1) => f64::from(bits as i8),
            Self::Signed(2) => f64::from(bits as i16),
            Self::Signed(4) => f64::from(bits as i32),
            Self::Signed(_) => bits as i64 as f64,
            Self::Float(4) => f64::from(f32::from_bits(bits as u32)),
            Self::Float(_) => f64::from_bits(bits),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    Number(Number),
    Text,
    /// A message, by its place in the [`Schema`].
    Message(usize),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Count {
    One,
    Fixed(usize),
    Any,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Field {
    pub name: String,
    pub kind: Kind,
    pub count: Count,
}

/// A message and those that it uses; the first is the outermost.
pub(super) struct Schema {
    pub messages: Vec<Vec<Field>>,
}

/// Messages within messages; real ones have a handful.
const DEEPEST: usize = 32;

impl Schema {
    /// Reads the definition of `name` (`package/msg/Name` or `package/Name`).
    ///
    /// Returns what is wrong with it.
    pub fn parse(name: &str, text: &str) -> Result<Self, String> {
        let mut sections = vec![(plain(name), Vec::new())];
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or_default().trim();
            if let Some(name) = line.strip_prefix("MSG:") {
                sections.push((plain(name.trim()), Vec::new()));
            } else if !line.is_empty() && !line.starts_with("===") {
                sections.last_mut().into_iter().for_each(|(_, lines)| lines.push(line));
            }
        }
        for stamp in ["Time", "Duration"] {
            let name = format!("builtin_interfaces/{stamp}");
            if !sections.iter().any(|(n, _)| *n == name) {
                sections.push((name, vec!["int32 sec", "uint32 nanosec"]));
            }
        }
        sections.push((ROS1_TIME.to_owned(), vec!["uint32 sec", "uint32 nanosec"]));
        let places: HashMap<&str, usize> =
            sections.iter().enumerate().map(|(k, (name, _))| (name.as_str(), k)).collect();
        let fields = |(package, lines): &(String, Vec<&str>)| {
            let package = package.split('/').next().unwrap_or_default();
            lines.iter().filter_map(|line| field(line, package, &places).transpose()).collect()
        };
        let messages = sections.iter().map(fields).collect::<Result<Vec<_>, String>>()?;
        let schema = Self { messages };
        if schema.depth(0, 0) > DEEPEST {
            return Err("its messages hold one another".into());
        }
        Ok(schema)
    }

    fn depth(&self, message: usize, above: usize) -> usize {
        if above > DEEPEST {
            return above;
        }
        let below = self.messages[message].iter().filter_map(|f| match f.kind {
            Kind::Message(k) => Some(self.depth(k, above + 1)),
            _ => None,
        });
        below.max().unwrap_or(above)
    }
}

const ROS1_TIME: &str = "time";

/// Without the folder of messages.
fn plain(name: &str) -> String {
    name.replace("/msg/", "/")
}

/// A line's field; none for a constant.
fn field(
    line: &str,
    package: &str,
    places: &HashMap<&str, usize>,
) -> Result<Option<Field>, String> {
    let (kind, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    let rest = rest.trim_start();
    let end = rest.find(|c: char| c.is_whitespace() || c == '=').unwrap_or(rest.len());
    let (name, after) = rest.split_at(end);
    if name.is_empty() {
        return Err(format!("expected TYPE NAME, found '{line}'"));
    }
    if after.trim_start().starts_with('=') {
        return Ok(None);
    }
    let (kind, count) = match kind.split_once('[') {
        None => (kind, Count::One),
        Some((kind, length)) => {
            let length = length.trim_end_matches(']');
            let fixed = length.parse().map(Count::Fixed);
            let any = length.is_empty() || length.starts_with("<=");
            let count = if any { Ok(Count::Any) } else { fixed };
            (kind, count.map_err(|_| format!("expected the length of a list, found '{line}'"))?)
        }
    };
    let kind = known(kind.split("<=").next().unwrap_or(kind))
        .or_else(|| message(kind, package, places))
        .ok_or_else(|| format!("it does not say what '{kind}' is"))?;
    Ok(Some(Field { name: name.into(), kind, count }))
}

fn known(kind: &str) -> Option<Kind> {
    use Number::{Float, Signed, Unsigned};
    Some(Kind::Number(match kind {
        "bool" | "byte" | "char" | "uint8" => Unsigned(1),
        "int8" => Signed(1),
        "uint16" => Unsigned(2),
        "int16" => Signed(2),
        "uint32" => Unsigned(4),
        "int32" => Signed(4),
        "uint64" => Unsigned(8),
        "int64" => Signed(8),
        "float32" => Float(4),
        "float64" => Float(8),
        "string" => return Some(Kind::Text),
        _ => return None,
    }))
}

fn message(kind: &str, package: &str, places: &HashMap<&str, usize>) -> Option<Kind> {
    let kind = plain(kind);
    let place = match &*kind {
        "Header" => places.get("std_msgs/Header"),
        "time" | "duration" => places.get(ROS1_TIME),
        _ => None,
    };
    let own = format!("{package}/{kind}");
    let found = place.or_else(|| places.get(kind.as_str())).or_else(|| places.get(own.as_str()));
    found.copied().map(Kind::Message)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn definitions_become_fields() {
        let text = "# a joint\nuint8 MODE=3\nstring<=8 label \"a=b\"\nstd_msgs/Header header\n\
                    float64[<=5] x\nfloat32[3] y  # three\nPoint[] p\n\
                    ================\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\n\
                    string frame_id\n====\nMSG: own/Point\nfloat64 z\n";
        let schema = Schema::parse("own/msg/Joint", text).unwrap();
        let field = |name: &str, kind, count| Field { name: name.into(), kind, count };
        let (float64, float32) = (Number::Float(8), Number::Float(4));
        assert_eq!(
            schema.messages[0],
            [
                field("label", Kind::Text, Count::One),
                field("header", Kind::Message(1), Count::One),
                field("x", Kind::Number(float64), Count::Any),
                field("y", Kind::Number(float32), Count::Fixed(3)),
                field("p", Kind::Message(2), Count::Any),
            ]
        );
        assert_eq!(schema.messages[1][0].kind, Kind::Message(3));
        let said = Schema::parse("a/B", "C c").err().unwrap();
        assert_eq!(said, "it does not say what 'C' is");
        let said = Schema::parse("a/B", "B b").err().unwrap();
        assert_eq!(said, "its messages hold one another");
    }
}
