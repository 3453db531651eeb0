//! Which numbers a Parquet schema holds, and how their columns are called.
//!
//! A field of a group is `group.field`, an entry of a list `list[0]`, a field of an entry `list[0].field`.
//! Lists of lists, maps, texts and bytes are no columns.

use ::parquet::basic::{ConvertedType, LogicalType, Repetition, TimeUnit, Type as Physical};
use ::parquet::schema::types::{ColumnDescriptor, SchemaDescriptor, Type};

/// A leaf of the schema that holds numbers.
pub(super) struct Leaf {
    /// Its place among the leaves.
    pub index: usize,
    /// Its name up to the entry of a list, and from there on; a leaf outside of lists has no second part.
    before: String,
    after: Option<String>,
    /// Definition level from which a list has an entry.
    pub entry_level: i16,
    /// Definition level of a value that is there.
    pub value_level: i16,
    /// What whole numbers are divided by: decimals, parts of a second.
    pub divisor: f64,
    /// What is taken from whole numbers before.
    pub zero: i64,
    /// Whether whole numbers have no sign.
    pub unsigned: bool,
    /// Whether it is a point in time.
    pub is_timestamp: bool,
}

impl Leaf {
    pub fn is_list(&self) -> bool {
        self.after.is_some()
    }

    /// Name of the list, or of the column.
    pub fn name(&self) -> &str {
        &self.before
    }

    /// Name of the column of an entry; of a leaf outside of lists there is but one.
    pub fn column(&self, entry: usize) -> String {
        match &self.after {
            Some(after) => format!("{}[{entry}]{after}", self.before),
            None => self.before.clone(),
        }
    }
}

/// All leaves that hold numbers, in the order of the file.
pub(super) fn leaves(schema: &SchemaDescriptor) -> Vec<Leaf> {
    let mut names = Vec::with_capacity(schema.num_columns());
    let root = Some(Name { before: String::new(), after: None });
    descend(schema.root_schema(), root, &mut names);
    let columns = schema.columns().iter().zip(names).enumerate();
    columns.filter_map(|(index, (column, name))| leaf(index, column, name?)).collect()
}

fn leaf(index: usize, column: &ColumnDescriptor, name: Name) -> Option<Leaf> {
    let physical = column.physical_type();
    let whole = matches!(physical, Physical::INT32 | Physical::INT64);
    if !whole && !matches!(physical, Physical::BOOLEAN | Physical::FLOAT | Physical::DOUBLE) {
        return None;
    }
    let (per_second, is_timestamp) = time(column);
    let scale = 10f64.powi(if whole { column.type_scale().max(0) } else { 0 });
    Some(Leaf {
        index,
        before: name.before,
        after: name.after,
        entry_level: column.repeated_ancestor_def_level(),
        value_level: column.max_def_level(),
        divisor: per_second.unwrap_or(scale),
        zero: 0,
        unsigned: is_unsigned(column),
        is_timestamp,
    })
}

/// Parts of a second that a time is counted in, and whether it is a point in time.
fn time(column: &ColumnDescriptor) -> (Option<f64>, bool) {
    let parts = |unit: &TimeUnit| match unit {
        TimeUnit::MILLIS => 1e3,
        TimeUnit::MICROS => 1e6,
        TimeUnit::NANOS => 1e9,
    };
    match (column.logical_type_ref(), column.converted_type()) {
        (Some(LogicalType::Timestamp(time)), _) => (Some(parts(&time.unit)), true),
        (Some(LogicalType::Time(time)), _) => (Some(parts(&time.unit)), false),
        (None, ConvertedType::TIMESTAMP_MILLIS) => (Some(1e3), true),
        (None, ConvertedType::TIMESTAMP_MICROS) => (Some(1e6), true),
        (None, ConvertedType::TIME_MILLIS) => (Some(1e3), false),
        (None, ConvertedType::TIME_MICROS) => (Some(1e6), false),
        _ => (None, false),
    }
}

fn is_unsigned(column: &ColumnDescriptor) -> bool {
    use ConvertedType::{UINT_8, UINT_16, UINT_32, UINT_64};
    match column.logical_type_ref() {
        Some(LogicalType::Integer(whole)) => !whole.is_signed,
        _ => matches!(column.converted_type(), UINT_8 | UINT_16 | UINT_32 | UINT_64),
    }
}

#[derive(Clone)]
struct Name {
    before: String,
    after: Option<String>,
}

impl Name {
    fn field(mut self, name: &str) -> Self {
        match &mut self.after {
            Some(after) => *after = format!("{after}.{name}"),
            None if self.before.is_empty() => name.clone_into(&mut self.before),
            None => self.before = format!("{}.{name}", self.before),
        }
        self
    }

    /// An entry of a list of this name; none of a list within a list.
    fn entry(self) -> Option<Self> {
        self.after.is_none().then_some(Self { after: Some(String::new()), ..self })
    }
}

/// The names of all leaves below `node`, which is called `name`; none for what is no column.
fn descend(node: &Type, name: Option<Name>, out: &mut Vec<Option<Name>>) {
    if node.is_primitive() {
        out.push(name);
        return;
    }
    let info = node.get_basic_info();
    let annotated = |converted| !node.is_schema() && info.converted_type() == converted;
    let is_list = annotated(ConvertedType::LIST)
        || matches!(info.logical_type_ref(), Some(LogicalType::List));
    if let (true, [repeated]) = (is_list, node.get_fields()) {
        return descend(element(repeated), name.and_then(Name::entry), out);
    }
    let is_map =
        annotated(ConvertedType::MAP) || matches!(info.logical_type_ref(), Some(LogicalType::Map));
    for field in node.get_fields() {
        let own = name.clone().filter(|_| !is_map).map(|n| n.field(field.name()));
        let own = if is_repeated(field) { own.and_then(Name::entry) } else { own };
        descend(field, own, out);
    }
}

/// What a list holds: the one field of its repeated group, but for files of old writers, whose
/// repeated field itself is the entry.
fn element(repeated: &Type) -> &Type {
    let is_old = || repeated.name() == "array" || repeated.name().ends_with("_tuple");
    match repeated {
        Type::GroupType { fields, .. } if fields.len() == 1 && !is_old() => &fields[0],
        _ => repeated,
    }
}

fn is_repeated(node: &Type) -> bool {
    let info = node.get_basic_info();
    info.has_repetition() && info.repetition() == Repetition::REPEATED
}
