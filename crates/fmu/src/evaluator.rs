//! What the process does that evaluates: it answers questions until nobody asks any more.

use crate::archive::DESCRIPTION;
use crate::foreign::{Failure, Instance, Unit};
use crate::wire::{Asked, Widths, read_question, write_answer};
use crate::{Description, Wanted, library_file};
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::Path;
use std::rc::Rc;

/// Instances that are kept, each with its parameters: derivatives by parameters go back and forth
/// between some, and an initialization may be long.
const KEPT: usize = 64;

/// An FMU with its instances.
struct Evaluator {
    description: Description,
    unit: Rc<Unit>,
    /// Those used last stand last.
    instances: Vec<(Vec<f64>, Instance)>,
    /// The last thing that went wrong since the last answer.
    said: String,
}

/// Answer what is asked of the FMU that is unpacked in `folder`.
pub(crate) fn answer(folder: &Path, from: impl Read, to: impl Write) -> std::io::Result<()> {
    let (mut from, mut to) = (BufReader::new(from), BufWriter::new(to));
    let mut evaluator = match Evaluator::new(folder) {
        Ok(evaluator) => evaluator,
        Err(failure) => return write_answer(&mut to, None, &failure.what),
    };
    write_answer(&mut to, Some(&[]), "")?;
    let widths = Widths::of(&evaluator.description);
    let (mut asked, mut numbers) = (Asked::default(), vec![]);
    while read_question(&mut from, widths, &mut asked)? {
        let fatal = evaluator.evaluate(widths, &asked, &mut numbers).is_err();
        let said = std::mem::take(&mut evaluator.said);
        write_answer(&mut to, Some(&numbers), &said)?;
        if fatal {
            break;
        }
    }
    Ok(())
}

/// Nothing of the library may be called any more.
struct Fatal;

impl Evaluator {
    fn new(folder: &Path) -> Result<Self, Failure> {
        let text = std::fs::read_to_string(folder.join(DESCRIPTION))
            .map_err(|e| Failure::new(format!("{DESCRIPTION}: {e}")))?;
        let description = Description::read(&text).map_err(|e| Failure::new(e.to_string()))?;
        let library = library_file(folder, &description);
        let unit = Unit::load(&library, &folder.join("resources"), &description)?;
        Ok(Self { description, unit, instances: vec![], said: String::new() })
    }

    /// All that was asked, one after the other: values at each point, then derivatives at the first.
    /// What cannot be evaluated is NaN.
    fn evaluate(
        &mut self,
        widths: Widths,
        asked: &Asked,
        numbers: &mut Vec<f64>,
    ) -> Result<(), Fatal> {
        let (point, width) = (widths.parameters + widths.variables, widths.values(asked.wanted));
        let points = asked.points.len() / point;
        numbers.clear();
        numbers.resize((points + asked.along.len()) * width, f64::NAN);
        let (values, slopes) = numbers.split_at_mut(points * width);
        let rows = asked.points.chunks_exact(point).zip(values.chunks_exact_mut(width.max(1)));
        for (k, (row, values)) in rows.enumerate() {
            let along = if k == 0 { &asked.along[..] } else { &[] };
            let result = self.point(row, (asked.wanted, along), values, slopes);
            if let Err(failure) = result {
                values.fill(f64::NAN);
                self.said = failure.what;
                // An instance that failed may not be what it was.
                self.instances.pop();
                if failure.fatal {
                    return Err(Fatal);
                }
            }
        }
        Ok(())
    }

    fn point(
        &mut self,
        row: &[f64],
        (wanted, along): (Wanted, &[usize]),
        values: &mut [f64],
        slopes: &mut [f64],
    ) -> Result<(), Failure> {
        let d = &self.description;
        let (parameters, variables) = row.split_at(d.parameters.len());
        let (states, inputs) = variables.split_at(d.states.len());
        let (inputs, time) = inputs.split_at(d.inputs.len());
        let references: Vec<u32> = d.inputs.iter().map(|u| u.reference).collect();
        let outputs: Vec<u32> = d.outputs.iter().map(|y| y.reference).collect();
        let rates: Vec<u32> = d.states.iter().map(|z| z.derivative).collect();
        let by: Vec<u32> = d
            .states
            .iter()
            .map(|z| z.variable.reference)
            .chain(references.iter().copied())
            .collect();
        let instance = self.instance(parameters)?;
        instance.go(time[0], states)?;
        instance.set(&references, inputs)?;
        match wanted {
            Wanted::Rates => instance.derivatives(values)?,
            Wanted::Outputs => instance.get(&outputs, values)?,
        }
        for (&entry, slopes) in along.iter().zip(slopes.chunks_exact_mut(values.len().max(1))) {
            let Some(&by) = by.get(entry) else { continue };
            let of = if wanted == Wanted::Rates { &rates } else { &outputs };
            instance.along(of, by, slopes)?;
        }
        Ok(())
    }

    /// The instance of these parameters, which is then the last.
    fn instance(&mut self, parameters: &[f64]) -> Result<&mut Instance, Failure> {
        match self.instances.iter().position(|(own, _)| own == parameters) {
            Some(k) => {
                let found = self.instances.remove(k);
                self.instances.push(found);
            }
            None => {
                let kept = if self.description.once { 1 } else { KEPT };
                if self.instances.len() >= kept {
                    self.instances.remove(0);
                }
                // It stands there before anything can fail: what fails is taken away.
                self.instances.push((parameters.to_vec(), Instance::new(&self.unit)?));
                self.initialize(parameters)?;
            }
        }
        let last = self.instances.last_mut().map(|(_, instance)| instance);
        last.ok_or_else(|| Failure::new("it has no instance"))
    }

    /// Initialize the last instance with these parameters; those that are as they are anyway are left alone.
    fn initialize(&mut self, parameters: &[f64]) -> Result<(), Failure> {
        let own = self.description.parameters.iter().zip(parameters);
        let (references, values): (Vec<u32>, Vec<f64>) = own
            .filter(|(p, value)| p.start != **value)
            .map(|(p, value)| (p.reference, *value))
            .unzip();
        let Some((_, instance)) = self.instances.last_mut() else { return Ok(()) };
        instance.set(&references, &values)?;
        instance.initialize()
    }
}
