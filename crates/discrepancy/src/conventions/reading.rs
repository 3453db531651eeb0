//! What a recording may mean but what the model reads.

use crate::dataset::{Dataset, Observed};
use lacuna_plants::Model;
use lacuna_recordings::{NoiseEstimate, Unit, convert_factor};

/// Units of angles and of their rates that are taken for another.
const MISTAKEN: [(&str, &str); 7] = [
    ("deg", "rad"),
    ("rad", "deg"),
    ("rev", "rad"),
    ("deg/s", "rad/s"),
    ("rad/s", "deg/s"),
    ("rpm", "rad/s"),
    ("rad/s", "rpm"),
];
/// Of any quantity.
const PREFIXES: [(f64, &str); 2] = [(1e-3, "thousandths"), (1e3, "thousands")];
/// Of times.
const CLOCKS: [(f64, &str); 3] = [(1e-3, "ms"), (1e-6, "us"), (60.0, "minutes")];

/// A column of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Column {
    /// An input of the model.
    Input(usize),
    /// An output of the dataset.
    Output(usize),
}

/// Recordings read otherwise.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Reading {
    change: Change,
    /// It in words, after "with".
    pub words: String,
}

#[derive(Clone, Debug, PartialEq)]
enum Change {
    /// Columns times a factor.
    Times(Vec<Column>, f64),
    /// Two columns in the place of each other.
    Exchanged(Column, Column),
    /// Times times a factor.
    Clock(f64),
}

/// All the ways in which these recordings may be read otherwise: the sign of each column and of each coordinate with its
/// velocity, units that are often taken for each other, columns of one unit exchanged, another clock.
pub(super) fn readings(model: &Model, dataset: &Dataset) -> Vec<Reading> {
    let inputs = model.inputs.iter().enumerate();
    let inputs = inputs.map(|(j, i)| (Column::Input(j), i.name.clone(), i.unit.clone()));
    let outputs = dataset.outputs.iter().enumerate();
    let outputs = outputs.map(|(k, o)| (Column::Output(k), o.name.clone(), o.unit.clone()));
    let columns: Vec<_> = inputs.chain(outputs).collect();
    let mut all: Vec<Reading> = coordinates(model, dataset).collect();
    for (k, (column, name, unit)) in columns.iter().enumerate() {
        all.extend(scaled(*column, name, unit));
        let alike = columns[k + 1..].iter().filter(|other| is_alike((*column, unit), other));
        all.extend(alike.map(|(other, its, _)| Reading {
            change: Change::Exchanged(*column, *other),
            words: format!("{name} and {its} exchanged"),
        }));
    }
    let clock = |(factor, unit): (f64, &str)| Reading {
        change: Change::Clock(factor),
        words: format!("times in {unit} where s are read"),
    };
    all.extend(CLOCKS.map(clock));
    all
}

/// Whether two columns can be taken for each other: inputs, or outputs, of one unit.
fn is_alike((column, unit): (Column, &str), (other, _, its): &(Column, String, String)) -> bool {
    let inputs = [column, *other].map(|c| matches!(c, Column::Input(_)));
    inputs[0] == inputs[1] && unit == its
}

/// The signs of each coordinate that is measured with its velocity.
fn coordinates(model: &Model, dataset: &Dataset) -> impl Iterator<Item = Reading> {
    let n = model.coordinates.len();
    let column = |state| dataset.output_of_state(state).map(Column::Output);
    (0..n).filter_map(move |c| {
        let (position, velocity) = (column(c)?, column(n + c)?);
        let name = |k: Column| match k {
            Column::Output(k) => dataset.outputs[k].name.as_str(),
            Column::Input(j) => model.inputs[j].name.as_str(),
        };
        let words = format!("the signs of {} and {} reversed", name(position), name(velocity));
        Some(Reading { change: Change::Times(vec![position, velocity], -1.0), words })
    })
}

/// One column in other units, and with the other sign.
fn scaled(column: Column, name: &str, unit: &str) -> Vec<Reading> {
    let times = |factor, words| Reading { change: Change::Times(vec![column], factor), words };
    let mut all = vec![times(-1.0, format!("the sign of {name} reversed"))];
    all.extend(PREFIXES.map(|(factor, words)| {
        let unit = if unit.is_empty() { "its unit" } else { unit };
        times(factor, format!("{name} in {words} of {unit}"))
    }));
    let Ok(own) = Unit::parse(unit) else { return all };
    for (is, read) in MISTAKEN {
        let (Ok(is_unit), Ok(read_unit)) = (Unit::parse(is), Unit::parse(read)) else { continue };
        let alike = convert_factor(&own, &read_unit).is_ok();
        if let (true, Ok(factor)) = (alike, convert_factor(&is_unit, &read_unit)) {
            all.push(times(factor, format!("{name} in {is} where {read} is read")));
        }
    }
    all
}

impl Reading {
    /// The recordings, read so.
    pub fn of(&self, dataset: &Dataset) -> Dataset {
        let mut read = dataset.clone();
        match &self.change {
            Change::Times(columns, factor) => {
                columns.iter().for_each(|column| times(&mut read, *column, *factor));
            }
            Change::Exchanged(a, b) => exchange(&mut read, *a, *b),
            Change::Clock(factor) => {
                let times = read.recordings.iter_mut().flat_map(|o| &mut o.times);
                times.for_each(|t| *t *= factor);
            }
        }
        read
    }
}

fn times(dataset: &mut Dataset, column: Column, factor: f64) {
    for observed in &mut dataset.recordings {
        match column {
            Column::Input(j) => commands(observed, j).for_each(|u| *u *= factor),
            Column::Output(k) => observed.outputs[k].iter_mut().for_each(|y| *y *= factor),
        }
    }
    if let Column::Output(k) = column {
        let NoiseEstimate { sd, quantum } = dataset.noise[k];
        let size = factor.abs();
        dataset.noise[k] = NoiseEstimate { sd: sd * size, quantum: quantum.map(|q| q * size) };
    }
}

fn exchange(dataset: &mut Dataset, a: Column, b: Column) {
    match (a, b) {
        (Column::Input(a), Column::Input(b)) => {
            for observed in &mut dataset.recordings {
                let width = observed.commands.len() / observed.len().max(1);
                observed.commands.chunks_exact_mut(width).for_each(|row| row.swap(a, b));
            }
        }
        (Column::Output(a), Column::Output(b)) => {
            dataset.noise.swap(a, b);
            for observed in &mut dataset.recordings {
                observed.outputs.swap(a, b);
                if observed.cleaned.len() > a.max(b) {
                    observed.cleaned.swap(a, b);
                }
            }
        }
        // Nobody takes an input for an output.
        (Column::Input(_), Column::Output(_)) | (Column::Output(_), Column::Input(_)) => {}
    }
}

/// One input's commands.
fn commands(observed: &mut Observed, input: usize) -> impl Iterator<Item = &mut f64> {
    let width = observed.commands.len() / observed.len().max(1);
    observed.commands.iter_mut().skip(input).step_by(width.max(1))
}
