//! Recordings as MCAP logs: messages of several topics, each with stamps of its own.
//!
//! A column is called `TOPIC.FIELD`: a field of a message within a message `TOPIC.FIELD.FIELD`, an entry of a list
//! `TOPIC.FIELD[0]`, or by the joint's name, where the message has a list of names of the same length
//! (`/joint_states.position[shoulder]`). Messages are read as ROS 2 (CDR), ROS 1 and JSON write
//! them, one at a time; of a topic that nobody wants the first message is looked at for its names, and nothing kept.
//!
//! Rows are the samples of the topic that the name of time names, else of the one with the most samples of
//! those of which a column is measured; time is counted in seconds from the first message of the log. How others are
//! brought onto these times: `clocks`.

mod clocks;
mod definition;
mod json;
mod message;

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fs::File;
use std::io::Read;
use std::rc::Rc;

use ::mcap::records::{Channel, MessageHeader, Record, op};
use ::mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use ::mcap::{McapError, parse_record};
use lacuna_units::names::nearest;

use crate::contained::contained;
use crate::error::RecordingError;
use crate::log::{Clock, Log, Wanted};
use crate::memory::{Budget, LARGEST_PIECE};
use crate::reader::{Reader, open};
use crate::recording::{Column, Recording};
use crate::source::RecordingSource;
use clocks::{Ordered, Times};
use definition::Schema;
use message::{Encoding, Layout, Numbers};

/// Bytes that are read from the file at once.
const PIECE: usize = 1 << 20;
/// Bytes of a message's record before the message.
const MESSAGE_HEAD: usize = 22;
/// Shapes of messages that a topic may have.
const MOST_SHAPES: usize = 1024;
/// Fields of the stamp in a message's header.
const STAMP: [[&str; 2]; 2] =
    [["header.stamp.sec", "header.stamp.secs"], ["header.stamp.nanosec", "header.stamp.nsecs"]];

/// Reads MCAP. Errors: a log that is cut or compressed in a way that is not read, a topic that is not there.
pub struct Mcap;

impl Reader for Mcap {
    fn format(&self) -> &'static str {
        "MCAP"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["mcap"]
    }

    fn recognises(&self, head: &[u8]) -> bool {
        head.starts_with(b"\x89MCAP0\r\n")
    }

    fn read(&self, source: &RecordingSource, wanted: &Wanted) -> Result<Log, RecordingError> {
        let (file, bytes) = open(&source.path)?;
        let name = source.path.display().to_string();
        let mut messages = Messages {
            budget: Budget::of(&name, bytes),
            file: name,
            wanted,
            schemas: HashMap::new(),
            channels: HashMap::new(),
            topics: vec![],
            not_read: BTreeMap::new(),
            zero: i64::MAX,
            found: Numbers::default(),
        };
        messages.read(file, source)?;
        messages.finish(source)
    }
}

/// How the messages of a channel are read.
enum Decoder {
    Ros(Schema, Encoding),
    Json,
}

/// A kind of message of a topic: what of its numbers is kept.
struct Shape {
    /// Numbers that are wanted, and the column of each.
    slots: Vec<(usize, usize)>,
    /// Where seconds and nanoseconds of the stamp are.
    stamp: Option<(usize, usize)>,
}

/// A channel: the topic of its messages and how they are read.
struct Source {
    topic: String,
    /// None for what is not read.
    decoder: Option<Decoder>,
    /// Where the topic is, once it has a message.
    at: Option<usize>,
}

/// What is kept of a topic.
#[derive(Default)]
struct Topic {
    name: String,
    /// Whether a column of it may be wanted.
    is_wanted: bool,
    stamped: bool,
    stamps: Vec<i64>,
    logged: Vec<i64>,
    columns: Vec<Column>,
    others: BTreeSet<String>,
    shapes: HashMap<Vec<u8>, Rc<Shape>>,
    /// How the message before was laid out, and its shape.
    last: Option<(Layout, Rc<Shape>)>,
}

struct Messages<'w> {
    file: String,
    wanted: &'w Wanted,
    budget: Budget,
    schemas: HashMap<u16, (String, String, Vec<u8>)>,
    channels: HashMap<u16, Source>,
    /// In the order of their first messages, at the end by name.
    topics: Vec<Topic>,
    /// Topics whose messages are not read, and why.
    not_read: BTreeMap<String, String>,
    /// When the first message was logged.
    zero: i64,
    found: Numbers,
}

impl Messages<'_> {
    fn read(&mut self, mut file: File, source: &RecordingSource) -> Result<(), RecordingError> {
        let options =
            LinearReaderOptions::default().with_record_length_limit(LARGEST_PIECE as usize / 2);
        let mut reader = LinearReader::new_with_options(options);
        loop {
            let from = &mut reader;
            let event = contained("MCAP", source, move || Ok(from.next_event()))?;
            let Some(event) = event else { return Ok(()) };
            match event.map_err(|e| self.broken(&e))? {
                LinearReadEvent::ReadRequest(_) => {
                    let read = file.read(reader.insert(PIECE)).map_err(|error| {
                        RecordingError::Unreadable { path: source.path.clone(), source: error }
                    })?;
                    reader.notify_read(read);
                }
                LinearReadEvent::Record { opcode: op::MESSAGE, data } => self.message(data)?,
                LinearReadEvent::Record { opcode, data } => {
                    if matches!(opcode, op::SCHEMA | op::CHANNEL) {
                        let record = parse_record(opcode, data).map_err(|e| self.broken(&e))?;
                        self.describe(record);
                    }
                }
            }
        }
    }

    fn describe(&mut self, record: Record) {
        match record {
            Record::Schema { header, data } => {
                let schema = (header.name, header.encoding, data.into_owned());
                self.schemas.insert(header.id, schema);
            }
            Record::Channel(channel) if !self.channels.contains_key(&channel.id) => {
                let decoder = self.decoder(&channel).map_err(|why| {
                    self.not_read.insert(channel.topic.clone(), why);
                });
                let source = Source { topic: channel.topic, decoder: decoder.ok(), at: None };
                self.channels.insert(channel.id, source);
            }
            _ => {}
        }
    }

    fn decoder(&self, channel: &Channel) -> Result<Decoder, String> {
        let encoding = match &*channel.message_encoding {
            "json" => return Ok(Decoder::Json),
            "cdr" => Encoding::Cdr,
            "ros1" => Encoding::Ros1,
            other => return Err(format!("messages encoded as '{other}'")),
        };
        let Some((name, written, data)) = self.schemas.get(&channel.schema_id) else {
            return Err("messages without a schema".into());
        };
        if !matches!(&**written, "ros2msg" | "ros1msg") {
            return Err(format!("a schema written as '{written}'"));
        }
        let text = String::from_utf8_lossy(data);
        let schema = Schema::parse(name, &text).map_err(|e| format!("the schema {name}: {e}"))?;
        Ok(Decoder::Ros(schema, encoding))
    }

    fn message(&mut self, data: &[u8]) -> Result<(), RecordingError> {
        let Some((head, data)) = data.split_at_checked(MESSAGE_HEAD) else {
            return Err(self.broken(&McapError::UnexpectedEof));
        };
        let header = header(head);
        let logged = i64::try_from(header.log_time).unwrap_or(i64::MAX);
        self.zero = self.zero.min(logged);
        let Some(source) = self.channels.get_mut(&header.channel_id) else { return Ok(()) };
        let Some(decoder) = &source.decoder else { return Ok(()) };
        let at = *source
            .at
            .get_or_insert_with(|| topic_of(&source.topic, self.wanted, &mut self.topics));
        let topic = &mut self.topics[at];
        if !topic.is_wanted && !topic.shapes.is_empty() {
            return Ok(());
        }
        if let Some((layout, shape)) = topic.last.take_if(|(layout, _)| layout.fits(data)) {
            let kept = topic.take(&shape, |k| layout.number(data, k), logged);
            topic.last = Some((layout, shape));
            return self.budget.take_numbers(kept);
        }
        let found = &mut self.found;
        found.values.clear();
        found.shape.clear();
        found.names = None;
        let wrong = |reason: String| RecordingError::Broken {
            file: self.file.clone(),
            format: "MCAP",
            reason: format!("topic {}, message {} of it: {reason}", source.topic, header.sequence),
        };
        let read = |found: &mut Numbers| match decoder {
            Decoder::Ros(schema, encoding) => message::read(schema, *encoding, data, found),
            Decoder::Json => json::read(data, found),
        };
        read(found).map_err(wrong)?;
        if !topic.shapes.contains_key(&found.shape) {
            if topic.shapes.len() >= MOST_SHAPES {
                topic.shapes.clear();
            }
            found.values.clear();
            let shape = std::mem::take(&mut found.shape);
            found.names = Some(vec![]);
            read(found).map_err(wrong)?;
            topic.learn(shape, found.names.as_deref().unwrap_or_default(), self.wanted);
        }
        let Some(shape) = topic.shapes.get(&found.shape).cloned() else { return Ok(()) };
        let kept = topic.take(&shape, |k| found.values.get(k).copied(), logged);
        if let Decoder::Ros(..) = decoder {
            let mut layout = topic.last.take().map(|(before, _)| before).unwrap_or_default();
            std::mem::swap(&mut layout, &mut found.layout);
            topic.last = Some((layout, shape));
        }
        self.budget.take_numbers(kept)
    }

    fn finish(mut self, source: &RecordingSource) -> Result<Log, RecordingError> {
        self.topics.sort_by(|a, b| a.name.cmp(&b.name));
        let names = self.all_names();
        if names.is_empty() {
            return Err(self.nothing());
        }
        self.wanted.check(&self.file, &names).map_err(|e| self.why(e))?;
        let mut others = Vec::new();
        for topic in &mut self.topics {
            let kept = topic.columns.iter().map(|c| &c.name);
            kept.for_each(|name| {
                topic.others.remove(name);
            });
            others.extend(std::mem::take(&mut topic.others));
        }
        let rows = self.rows_topic()?;
        self.topics.retain(|topic| !topic.columns.is_empty());
        let times: Vec<Times> = self.topics.iter().map(Topic::times).collect();
        let ordered = clocks::ordered(&times, self.zero);
        let Some(base) = self.topics.iter().position(|topic| topic.name == rows) else {
            return Err(self.nothing());
        };
        let log = self.joined(source, ordered, base)?;
        Ok(Log { others, ..log })
    }

    /// The topic whose samples are the rows.
    fn rows_topic(&self) -> Result<String, RecordingError> {
        let wanted = &self.wanted.time;
        let has_columns =
            |name: &str| self.topics.iter().any(|t| t.name == name && !t.columns.is_empty());
        if has_columns(wanted) {
            return Ok(wanted.clone());
        }
        if wanted.starts_with('/') {
            let available: Vec<String> = self.topics.iter().map(|t| t.name.clone()).collect();
            return Err(RecordingError::NoTimeColumn {
                file: self.file.clone(),
                wanted: wanted.clone(),
                separated: " (here topics of which a column is used)",
                suggestion: nearest(wanted, available.iter().map(String::as_str)).map(Into::into),
                available: available.into_iter().filter(|name| has_columns(name)).collect(),
            });
        }
        let is_measured = |c: &Column| self.wanted.measures(&c.name);
        let measured = self.topics.iter().filter(|t| t.columns.iter().any(is_measured));
        // Of topics with as many samples the first by name.
        let most = measured.rev().max_by_key(|topic| topic.stamps.len());
        most.map(|topic| topic.name.clone()).ok_or_else(|| self.nothing())
    }

    fn joined(
        self,
        source: &RecordingSource,
        mut ordered: Vec<Ordered>,
        base: usize,
    ) -> Result<Log, RecordingError> {
        let all = &ordered[base].times;
        let picked = source.selection.picked(all, &self.file)?;
        let times: Vec<f64> = picked.iter().map(|&k| all[k]).collect();
        let mut columns = vec![Column { name: self.wanted.time.clone(), values: times.clone() }];
        // What was read of a column goes where it is on the rows' times.
        for (k, topic) in self.topics.into_iter().enumerate() {
            for Column { name, values } in topic.columns {
                let values = if k == base {
                    picked.iter().map(|&row| values[ordered[k].samples[row]]).collect()
                } else {
                    ordered[k].at_times(&values, &times, self.wanted.holds(&name))
                };
                columns.push(Column { name, values });
            }
        }
        let mut recording =
            Recording::from_columns(&source.to_string(), columns, &self.wanted.time)?;
        recording.name = source.name();
        ordered.swap(0, base);
        let mut clocks: Vec<Clock> = ordered.into_iter().map(|o| o.clock).collect();
        clocks[1..].sort_by(|a, b| a.topic.cmp(&b.topic));
        Ok(Log { recording, others: vec![], clocks })
    }

    fn all_names(&self) -> Vec<&str> {
        let topics = self.topics.iter();
        let kept = topics.clone().flat_map(|t| t.columns.iter().map(|c| &*c.name));
        kept.chain(topics.flat_map(|t| t.others.iter().map(String::as_str))).collect()
    }

    /// A column that is missing because its topic is not read is answered with the reason.
    fn why(&self, error: RecordingError) -> RecordingError {
        let missing = error.missing_columns();
        let of = |(topic, _): &(&String, &String)| {
            let start = format!("{topic}.");
            missing.iter().any(|name| name.starts_with(&start))
        };
        match self.not_read.iter().find(of) {
            Some((topic, why)) => self.topic_not_read(topic, why),
            None => error,
        }
    }

    /// No column of any topic.
    fn nothing(&self) -> RecordingError {
        if let (true, Some((topic, why))) = (self.topics.is_empty(), self.not_read.iter().next()) {
            return self.topic_not_read(topic, why);
        }
        let names = self.all_names();
        RecordingError::NoMessages {
            file: self.file.clone(),
            available: names.into_iter().map(Into::into).collect(),
        }
    }

    fn topic_not_read(&self, topic: &str, why: &str) -> RecordingError {
        RecordingError::NotRead {
            file: self.file.clone(),
            what: format!("topic {topic}:"),
            found: why.into(),
            advice: "messages of ROS 2 (cdr with ros2msg), ROS 1 and JSON are: record it as one of them",
        }
    }

    fn broken(&self, error: &McapError) -> RecordingError {
        let file = self.file.clone();
        match error {
            McapError::UnsupportedCompression(found) => RecordingError::NotRead {
                file,
                what: "the compression".into(),
                found: found.clone(),
                advice: "write the log with zstd, lz4 or no compression (mcap compress)",
            },
            McapError::RecordTooLarge { len, .. } | McapError::ChunkTooLarge(len) => {
                RecordingError::TooLarge { file, needed: *len, allowed: LARGEST_PIECE / 2 }
            }
            McapError::UnexpectedEof | McapError::UnexpectedEoc | McapError::BadMagic => {
                let reason = format!("{error}; `mcap recover` keeps what can be read");
                RecordingError::Broken { file, format: "MCAP", reason }
            }
            _ => RecordingError::Broken { file, format: "MCAP", reason: error.to_string() },
        }
    }
}

impl Topic {
    /// What the numbers of messages of a new shape are.
    fn learn(&mut self, shape: Vec<u8>, names: &[String], wanted: &Wanted) {
        let at = |of: &[&str]| names.iter().position(|name| of.contains(&name.as_str()));
        let stamp = at(&STAMP[0]).zip(at(&STAMP[1]));
        let is_stamp = |k: usize| stamp.is_some_and(|(s, n)| k == s || k == n);
        let mut slots = Vec::new();
        for (k, name) in names.iter().enumerate().filter(|(k, _)| !is_stamp(*k)) {
            let name = format!("{}.{name}", self.name);
            if wanted.keeps(&name) {
                slots.push((k, self.column(name)));
            } else {
                self.others.insert(name);
            }
        }
        self.shapes.insert(shape, Rc::new(Shape { slots, stamp }));
    }

    /// Where the column of this name is; a new one misses what was before.
    fn column(&mut self, name: String) -> usize {
        self.columns.iter().position(|c| c.name == name).unwrap_or_else(|| {
            let values = vec![f64::NAN; self.stamps.len()];
            self.columns.push(Column { name, values });
            self.columns.len() - 1
        })
    }

    /// Keeps what is wanted of a message, of which `number` gives the `k`-th number; returns how many numbers these are.
    fn take(&mut self, shape: &Shape, number: impl Fn(usize) -> Option<f64>, logged: i64) -> u64 {
        if self.columns.is_empty() {
            return 0;
        }
        let stamp = shape
            .stamp
            .and_then(|(s, n)| Some(number(s)? as i64 * 1_000_000_000 + number(n)? as i64));
        // A stamp of zero is one that nobody set.
        let stamp = stamp.filter(|stamp| *stamp != 0);
        self.stamped |= stamp.is_some();
        self.stamps.push(stamp.unwrap_or(logged));
        self.logged.push(logged);
        self.columns.iter_mut().for_each(|c| c.values.push(f64::NAN));
        for &(k, column) in &shape.slots {
            if let (Some(last), Some(value)) = (self.columns[column].values.last_mut(), number(k)) {
                *last = value;
            }
        }
        self.columns.len() as u64 + 2
    }

    fn times(&self) -> Times<'_> {
        let Self { name, stamped, stamps, logged, .. } = self;
        Times { topic: name, stamped: *stamped, stamps, logged }
    }
}

/// Where the topic of this name is; a new one comes last.
fn topic_of(name: &str, wanted: &Wanted, topics: &mut Vec<Topic>) -> usize {
    topics.iter().position(|topic| topic.name == name).unwrap_or_else(|| {
        let is_wanted = wanted.keeps_some(&format!("{name}."));
        topics.push(Topic { name: name.into(), is_wanted, ..Topic::default() });
        topics.len() - 1
    })
}

/// The head of a message: numbers with the least byte first.
fn header(head: &[u8]) -> MessageHeader {
    let number = |from: usize, bytes: usize| {
        head[from..from + bytes].iter().rev().fold(0, |n, byte| n << 8 | u64::from(*byte))
    };
    MessageHeader {
        channel_id: number(0, 2) as u16,
        sequence: number(2, 4) as u32,
        log_time: number(6, 8),
        publish_time: number(14, 8),
    }
}
