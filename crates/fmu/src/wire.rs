//! What a process that evaluates is asked, and what it answers: little-endian numbers.
//!
//! ```text
//! question: wanted u8, points u32, along u32, entry u32 for each, then for each point
//!           1 u8 where its parameters are those of the point before, or 0 and p; then z, u, t
//! answer:   1 u8 and numbers, or 0; then a text (its length u32) that says what went wrong
//! ```

use crate::{Description, Question, Wanted};
use std::io::{self, Read, Write};

/// Longest text of an answer.
const LONGEST: usize = 10_000;

/// How many numbers there are of everything.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Widths {
    pub parameters: usize,
    /// States, inputs, time.
    pub variables: usize,
    rates: usize,
    outputs: usize,
}

impl Widths {
    pub(crate) fn of(d: &Description) -> Self {
        Self {
            parameters: d.parameters.len(),
            variables: d.states.len() + d.inputs.len() + 1,
            rates: d.states.len(),
            outputs: d.outputs.len(),
        }
    }

    pub(crate) fn values(&self, wanted: Wanted) -> usize {
        match wanted {
            Wanted::Rates => self.rates,
            Wanted::Outputs => self.outputs,
        }
    }
}

/// A question as the evaluator reads it.
#[derive(Debug, Default)]
pub(crate) struct Asked {
    pub wanted: Wanted,
    pub along: Vec<usize>,
    /// Rows of parameters and variables.
    pub points: Vec<f64>,
}

pub(crate) fn write_question(to: &mut Vec<u8>, widths: Widths, question: &Question<'_>) {
    let width = widths.parameters + widths.variables;
    to.clear();
    to.push(u8::from(question.wanted == Wanted::Outputs));
    push_length(to, question.points.len() / width);
    push_length(to, question.along.len());
    question.along.iter().for_each(|&entry| push_length(to, entry));
    let mut before: Option<&[f64]> = None;
    for point in question.points.chunks_exact(width) {
        let (parameters, variables) = point.split_at(widths.parameters);
        // As bits, so that a NaN is itself.
        let bits = |p: &[f64]| p.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        let same = before.is_some_and(|before| bits(before) == bits(parameters));
        to.push(u8::from(same));
        if !same {
            push_numbers(to, parameters);
        }
        push_numbers(to, variables);
        before = Some(parameters);
    }
}

/// The next question; none where nobody asks any more.
pub(crate) fn read_question(
    from: &mut impl Read,
    widths: Widths,
    asked: &mut Asked,
) -> io::Result<bool> {
    let mut wanted = [0];
    if from.read(&mut wanted)? == 0 {
        return Ok(false);
    }
    asked.wanted = if wanted == [1] { Wanted::Outputs } else { Wanted::Rates };
    let (points, along) = (read_length(from)?, read_length(from)?);
    asked.along = (0..along).map(|_| read_length(from)).collect::<io::Result<_>>()?;
    let width = widths.parameters + widths.variables;
    asked.points.clear();
    asked.points.resize(points * width, 0.0);
    for k in 0..points {
        let mut same = [0];
        from.read_exact(&mut same)?;
        let (before, rest) = asked.points.split_at_mut(k * width);
        let (parameters, variables) = rest[..width].split_at_mut(widths.parameters);
        if same == [1] {
            let last = before.len() - width;
            parameters.copy_from_slice(&before[last..last + widths.parameters]);
        } else {
            read_numbers(from, parameters)?;
        }
        read_numbers(from, variables)?;
    }
    Ok(true)
}

/// Numbers, and a text that says what went wrong; empty where nothing did.
pub(crate) fn write_answer(
    to: &mut impl Write,
    numbers: Option<&[f64]>,
    said: &str,
) -> io::Result<()> {
    let mut bytes = vec![u8::from(numbers.is_some())];
    push_numbers(&mut bytes, numbers.unwrap_or_default());
    let said: String = said.chars().take(LONGEST / 4).collect();
    push_length(&mut bytes, said.len());
    bytes.extend(said.as_bytes());
    to.write_all(&bytes)?;
    to.flush()
}

/// Whether there are numbers, and the text.
pub(crate) fn read_answer(
    from: &mut impl Read,
    numbers: [&mut [f64]; 2],
) -> io::Result<(bool, String)> {
    let mut there = [0];
    from.read_exact(&mut there)?;
    if there == [1] {
        for numbers in numbers {
            read_numbers(from, numbers)?;
        }
    }
    let length = read_length(from)?;
    if length > LONGEST {
        return Err(io::Error::from(io::ErrorKind::InvalidData));
    }
    let mut said = vec![0; length];
    from.read_exact(&mut said)?;
    Ok((there == [1], String::from_utf8_lossy(&said).into_owned()))
}

fn push_length(to: &mut Vec<u8>, length: usize) {
    to.extend(u32::try_from(length).unwrap_or(u32::MAX).to_le_bytes());
}

fn push_numbers(to: &mut Vec<u8>, numbers: &[f64]) {
    numbers.iter().for_each(|x| to.extend(x.to_le_bytes()));
}

fn read_length(from: &mut impl Read) -> io::Result<usize> {
    let mut bytes = [0; 4];
    from.read_exact(&mut bytes)?;
    Ok(u32::from_le_bytes(bytes) as usize)
}

fn read_numbers(from: &mut impl Read, numbers: &mut [f64]) -> io::Result<()> {
    for x in numbers {
        let mut bytes = [0; 8];
        from.read_exact(&mut bytes)?;
        *x = f64::from_le_bytes(bytes);
    }
    Ok(())
}
