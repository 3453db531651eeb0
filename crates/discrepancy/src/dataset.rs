//! Conditioning: recordings brought into the model's channels and units, with dropped rows
//! marked, angles unwrapped, outliers and sensors at their limits left out, the noise of every
//! output estimated, and imposed motion smoothed.

pub(crate) mod clean;
pub(crate) mod lost;
mod wanted;

use crate::DiagnoseError;
use lacuna_occupation::{InputPath, Names};
use lacuna_plants::model::Measured;
use lacuna_plants::{Hold, Model};
pub use lacuna_recordings::Cleaned;
use lacuna_recordings::{
    Gap, InputHold, NoiseEstimate, Prior, Recording, Sampling, Smoother, Trajectory as Path, Unit,
    Wanted, condition, convert, lost_input_variance, resample_input,
};
pub use lost::LostInput;
use std::ops::Range;

/// A measured output of the machine.
#[derive(Clone, Debug)]
pub struct Output {
    /// Its name: the channel's, or the column's for an expression.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// What it measures.
    pub of: Measured,
}

/// One recording in the model's channels.
#[derive(Clone, Debug)]
pub struct Observed {
    /// The recording's name.
    pub name: String,
    /// Times, dropped rows filled in (s).
    pub times: Vec<f64>,
    /// Commanded inputs and imposed motion, row-major `times.len() x m`
    /// ([`lacuna_plants::Model::input_width`]).
    pub commands: Vec<f64>,
    /// Series of each output; NaN where nothing was measured, or an outlier, or the sensor's limit.
    pub outputs: Vec<Vec<f64>>,
    /// Number of rows that were dropped.
    pub dropped: usize,
    /// Inputs that nobody recorded, because their rows were dropped.
    pub lost: Vec<LostInput>,
    /// Samples with which a run begins anew: what was lost before them moves the machine too far.
    pub anew: Vec<usize>,
    /// What was done to each output; none for recordings that are taken as they are.
    pub cleaned: Vec<Cleaned>,
}

impl Observed {
    /// Number of samples, dropped ones included.
    #[must_use]
    pub fn len(&self) -> usize {
        self.times.len()
    }

    /// Whether there is no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.times.is_empty()
    }

    /// One column of the commands: those to one actuator, or of imposed motion.
    #[must_use]
    pub fn command(&self, input: usize) -> Vec<f64> {
        let m = self.commands.len() / self.len().max(1);
        self.commands.iter().skip(input).step_by(m).copied().collect()
    }

    /// The samples that one run goes through, one stretch after the other: all of them, unless inputs were lost.
    pub fn stretches(&self) -> impl Iterator<Item = Range<usize>> {
        let ends = self.anew.iter().copied().chain([self.len()]);
        [0].into_iter().chain(self.anew.iter().copied()).zip(ends).map(|(from, to)| from..to)
    }

    /// The samples `range` as a recording of their own.
    #[must_use]
    pub fn part(&self, range: Range<usize>) -> Self {
        let m = self.commands.len() / self.len().max(1);
        let seconds = (self.times[range.start], self.times[range.end - 1]);
        let cleaned: Vec<_> = self.cleaned.iter().map(|c| c.part(&range)).collect();
        let left_out = |k: &usize| cleaned.iter().any(|c| c.is_left_out(k - range.start));
        let missing = |k: &usize| self.outputs.iter().all(|y| y[*k].is_nan()) && !left_out(k);
        Self {
            name: format!("{} ({:.3} to {:.3} s)", self.name, seconds.0, seconds.1),
            times: self.times[range.clone()].to_vec(),
            commands: self.commands[range.start * m..range.end * m].to_vec(),
            outputs: self.outputs.iter().map(|y| y[range.clone()].to_vec()).collect(),
            dropped: range.clone().filter(missing).count(),
            lost: self
                .lost
                .iter()
                .filter(|l| range.contains(&l.row))
                .map(|l| LostInput { row: l.row - range.start, ..*l })
                .collect(),
            anew: self
                .anew
                .iter()
                .filter(|k| range.start < **k && **k < range.end)
                .map(|k| k - range.start)
                .collect(),
            cleaned,
        }
    }
}

/// Recordings that belong to one model.
#[derive(Clone, Debug)]
pub struct Dataset {
    /// What is measured.
    pub outputs: Vec<Output>,
    /// The recordings.
    pub recordings: Vec<Observed>,
    /// Noise of each output, pooled over the recordings.
    pub noise: Vec<NoiseEstimate>,
    /// What is to be told of how the recordings were chosen.
    pub notes: Vec<String>,
}

impl Dataset {
    /// Fewest samples a recording must have to be used.
    pub const FEWEST_SAMPLES: usize = 100;

    /// What a model uses of a file: columns of its measurements, else of the names of its channels and inputs. Rows
    /// are at the times of a measurement of what moves freely.
    #[must_use]
    pub fn wanted(model: &Model) -> Wanted {
        wanted::of_equations(model)
    }

    /// What an identified model of this order uses of a file.
    #[must_use]
    pub fn wanted_by_identified(names: &Names, order: usize) -> Wanted {
        wanted::of_identified(names, order)
    }

    /// Bring recordings into the model's channels.
    ///
    /// # Errors
    /// [`DiagnoseError`] naming the recording and column.
    pub fn new(model: &Model, recordings: &[Recording]) -> Result<Self, DiagnoseError> {
        let first = recordings.first().ok_or(DiagnoseError::NoRecordings)?;
        let columns = columns(model, first)?;
        let outputs: Vec<_> = columns
            .iter()
            .filter(|c| !matches!(c.of, Measured::Input(_)))
            .map(|c| Output { name: c.name.clone(), unit: c.unit.clone(), of: c.of })
            .collect();
        check_imposed(model, &outputs, first)?;
        if outputs.iter().all(|o| is_imposed(model, o)) {
            let free = (0..model.machine_states()).filter(|&i| !model.is_imposed_state(i));
            let free = free.map(|i| model.state_name(i).to_owned());
            return Err(DiagnoseError::NothingMeasured {
                recording: first.name.clone(),
                columns: first.columns.iter().map(|c| c.name.clone()).collect(),
                channels: free.chain(model.imposed().map(|c| model.force_name(c))).collect(),
            });
        }
        let hold = match model.hold {
            Hold::ZeroOrder => InputHold::ZeroOrder,
            Hold::Linear | Hold::BandLimited => InputHold::Linear,
        };
        let all = Self::of(&columns, outputs, hold, recordings)?.with_imposed_motion(model)?;
        Ok(all.begun_anew(model))
    }

    /// Bring recordings into the channels of an identified model of this order: its coordinates,
    /// and their rates where the recordings have them. Its units are those of the recordings.
    ///
    /// # Errors
    /// [`DiagnoseError`] naming the recording and column.
    pub fn of_identified(
        names: &Names,
        order: usize,
        recordings: &[Recording],
    ) -> Result<Self, DiagnoseError> {
        let first = recordings.first().ok_or(DiagnoseError::NoRecordings)?;
        let columns = identified_columns(names, order, first);
        let measured = columns.iter().filter(|c| !matches!(c.of, Measured::Input(_)));
        let output = |c: &Used| Output { name: c.name.clone(), unit: c.unit.clone(), of: c.of };
        let outputs = measured.map(output).collect();
        let hold = match names.input_path {
            InputPath::Held => InputHold::ZeroOrder,
            InputPath::Linear | InputPath::Smooth => InputHold::Linear,
        };
        Self::of(&columns, outputs, hold, recordings)
    }

    fn of(
        columns: &[Used],
        outputs: Vec<Output>,
        hold: InputHold,
        recordings: &[Recording],
    ) -> Result<Self, DiagnoseError> {
        let mut observed =
            recordings.iter().map(|r| observe(hold, columns, r)).collect::<Result<Vec<_>, _>>()?;
        let noise = (0..outputs.len())
            .map(|k| conditioned(&mut observed, k, &outputs[k]))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Self { outputs, recordings: observed, noise, notes: vec![] })
    }

    /// The recorded motion of imposed coordinates, smoothed, in the rows of the commands: it is an
    /// input, and no output that could be predicted.
    fn with_imposed_motion(mut self, model: &Model) -> Result<Self, DiagnoseError> {
        if model.imposed().next().is_none() {
            return Ok(self);
        }
        let paths = |observed: &Observed| -> Result<Vec<Path>, DiagnoseError> {
            let of = |c: usize| smoothed(&self, observed, c, Some(c + model.coordinates.len()));
            model.imposed().filter_map(|c| of(c).transpose()).collect()
        };
        let all = self.recordings.iter().map(paths).collect::<Result<Vec<_>, _>>()?;
        let m = model.inputs.len();
        let free: Vec<bool> = self.outputs.iter().map(|o| !is_imposed(model, o)).collect();
        for (observed, paths) in self.recordings.iter_mut().zip(all) {
            let mut rows = Vec::with_capacity(observed.len() * model.input_width());
            for k in 0..observed.len() {
                rows.extend_from_slice(&observed.commands[k * m..(k + 1) * m]);
                rows.extend(paths.iter().flat_map(|p| [p.value[k], p.first[k], p.second[k]]));
            }
            observed.commands = rows;
            retain(&mut observed.outputs, &free);
            retain(&mut observed.cleaned, &free);
        }
        retain(&mut self.outputs, &free);
        retain(&mut self.noise, &free);
        Ok(self)
    }

    /// The same outputs and noise with other recordings.
    #[must_use]
    pub fn with_recordings(&self, recordings: Vec<Observed>) -> Self {
        let (outputs, noise) = (self.outputs.clone(), self.noise.clone());
        Self { outputs, recordings, noise, notes: vec![] }
    }

    /// Recordings kept for proof, with the outputs and the noise of these.
    ///
    /// # Errors
    /// [`DiagnoseError::OtherOutputs`] where they do not measure the same channels.
    pub fn for_proof(&self, held_out: Self) -> Result<Self, DiagnoseError> {
        let names = |d: &Self| d.outputs.iter().map(|o| o.name.clone()).collect::<Vec<_>>();
        let (expected, found) = (names(self), names(&held_out));
        if expected != found {
            let recording = held_out.recordings[0].name.clone();
            return Err(DiagnoseError::OtherOutputs { recording, expected, found });
        }
        Ok(self.with_recordings(held_out.recordings))
    }

    /// Outputs with outliers, and their number in all recordings.
    pub fn outliers(&self) -> impl Iterator<Item = (&Output, usize)> {
        self.cleaned(|c| c.outliers.len())
    }

    /// Outputs that are angles recorded within one turn, and how often they leapt by a turn.
    pub fn leaps(&self) -> impl Iterator<Item = (&Output, usize)> {
        self.cleaned(|c| c.leaps.len())
    }

    /// Outputs whose sensor was at the end of its range, and for how many samples.
    pub fn saturated(&self) -> impl Iterator<Item = (&Output, usize)> {
        self.cleaned(|c| c.saturated.len())
    }

    fn cleaned(&self, count: fn(&Cleaned) -> usize) -> impl Iterator<Item = (&Output, usize)> {
        let all = move |k: usize| {
            self.recordings.iter().filter_map(|r| r.cleaned.get(k)).map(count).sum::<usize>()
        };
        self.outputs.iter().enumerate().map(move |(k, o)| (o, all(k))).filter(|(_, n)| *n > 0)
    }

    /// Noise standard deviation that errors are weighed with: never zero, so that a
    /// noise-free simulation does not divide by nothing.
    #[must_use]
    pub fn noise_sd(&self, output: usize) -> f64 {
        let values = self.recordings.iter().flat_map(|r| &r.outputs[output]);
        let largest = values.filter(|v| v.is_finite()).fold(0.0f64, |m, v| m.max(v.abs()));
        self.noise[output].sd.max(1e-7 * largest).max(f64::MIN_POSITIVE)
    }

    /// An output that never changes.
    #[must_use]
    pub fn constant_output(&self) -> Option<&Output> {
        let constant = |k: &usize| {
            let values = self.recordings.iter().flat_map(|r| &r.outputs[*k]);
            let mut finite = values.filter(|v| v.is_finite());
            let first = finite.next();
            finite.all(|v| Some(v) == first)
        };
        (0..self.outputs.len()).find(constant).map(|k| &self.outputs[k])
    }

    /// Half of the range of an output over all recordings.
    #[must_use]
    pub fn half_range(&self, output: usize) -> f64 {
        let values = self.recordings.iter().flat_map(|r| &r.outputs[output]);
        let (low, high) = values
            .filter(|v| v.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)));
        (0.5 * (high - low)).max(f64::MIN_POSITIVE)
    }

    /// The output that measures an entry of the machine's state directly.
    #[must_use]
    pub fn output_of_state(&self, state: usize) -> Option<usize> {
        self.outputs.iter().position(|o| o.of == Measured::State(state))
    }
}

/// Whether an output is the motion of an imposed coordinate.
fn is_imposed(model: &Model, output: &Output) -> bool {
    matches!(output.of, Measured::State(i) if model.is_imposed_state(i))
}

/// The position of every imposed coordinate must be recorded.
fn check_imposed(
    model: &Model,
    outputs: &[Output],
    recording: &Recording,
) -> Result<(), DiagnoseError> {
    let recorded = |c: &usize| outputs.iter().any(|o| o.of == Measured::State(*c));
    match model.imposed().find(|c| !recorded(c)) {
        Some(c) => Err(DiagnoseError::NotImposed {
            recording: recording.name.clone(),
            columns: recording.columns.iter().map(|c| c.name.clone()).collect(),
            channel: model.channel_name(c).to_owned(),
        }),
        None => Ok(()),
    }
}

/// Keep the entries that are marked.
fn retain<T>(list: &mut Vec<T>, marked: &[bool]) {
    let mut marks = marked.iter();
    list.retain(|_| marks.next().copied().unwrap_or(true));
}

/// The smoothed path of an entry of the machine's state, with its rate where that is another entry
/// that is measured too; none where nothing measures it.
pub(crate) fn smoothed(
    dataset: &Dataset,
    observed: &Observed,
    state: usize,
    rate: Option<usize>,
) -> Result<Option<Path>, DiagnoseError> {
    let Some(output) = dataset.output_of_state(state) else { return Ok(None) };
    let mut smoother = Smoother::new(Prior::WhiteJerk);
    if let Some(rate) = rate.and_then(|rate| dataset.output_of_state(rate)) {
        smoother = smoother.with_derivative(&observed.outputs[rate], dataset.noise_sd(rate));
    }
    let path = smoother
        .smooth(&observed.times, &observed.outputs[output], dataset.noise_sd(output))
        .map_err(|source| DiagnoseError::Signal {
            recording: observed.name.clone(),
            channel: dataset.outputs[output].name.clone(),
            source,
        })?;
    Ok(Some(path.at(&observed.times)))
}

/// A column that is used, and what for.
struct Used {
    column: String,
    name: String,
    of: Measured,
    /// Unit of the channel, and of the column where it differs.
    unit: String,
    column_unit: String,
}

/// The columns of the model's measurements; without any, those with a channel's name.
fn columns(model: &Model, recording: &Recording) -> Result<Vec<Used>, DiagnoseError> {
    // Of several columns that measure one channel each is told by its own name.
    let is_shared = |of| model.measurements.iter().filter(|m| m.of == of).count() > 1;
    let mut used: Vec<Used> = model
        .measurements
        .iter()
        .map(|m| {
            let (name, unit) = match m.of {
                Measured::State(i) if is_shared(m.of) => (m.column.clone(), model.state_unit(i)),
                Measured::State(i) => (model.state_name(i).to_owned(), model.state_unit(i)),
                Measured::Input(j) => (model.inputs[j].name.clone(), model.inputs[j].unit.clone()),
                Measured::Force(c) => (m.column.clone(), unit_of_force(model, c, &m.unit)),
                Measured::Output(_) => (m.column.clone(), m.unit.clone()),
            };
            Used { column: m.column.clone(), name, of: m.of, unit, column_unit: m.unit.clone() }
        })
        .collect();
    let plain = |name: &str, of, unit: String| Used {
        column: name.to_owned(),
        name: name.to_owned(),
        of,
        unit,
        column_unit: String::new(),
    };
    // A column with the name of a channel is that channel, unless it or the column is spoken for.
    for i in 0..model.machine_states() {
        let name = model.state_name(i);
        let taken = used.iter().any(|u| u.of == Measured::State(i) || u.column == name);
        if !taken && recording.columns.iter().any(|c| c.name == name) {
            used.push(plain(name, Measured::State(i), model.state_unit(i)));
        }
    }
    for (j, input) in model.inputs.iter().enumerate() {
        if !used.iter().any(|u| u.of == Measured::Input(j)) {
            used.push(plain(&input.name, Measured::Input(j), input.unit.clone()));
        }
    }
    Ok(used)
}

/// Unit of the force on a coordinate; that of the column where the model's units do not say it.
fn unit_of_force(model: &Model, coordinate: usize, column: &str) -> String {
    let unit = model.force_unit(coordinate);
    if Unit::parse(&unit).is_ok() { unit } else { column.to_owned() }
}

/// Columns of the coordinates, of their rates where the recording has them, and of the inputs.
fn identified_columns(names: &Names, order: usize, recording: &Recording) -> Vec<Used> {
    let n = names.coordinates.len();
    let used = |name: &String, of| Used {
        column: name.clone(),
        name: name.clone(),
        of,
        unit: String::new(),
        column_unit: String::new(),
    };
    let recorded = |name: &&String| recording.columns.iter().any(|c| c.name == **name);
    let coordinates =
        names.coordinates.iter().enumerate().map(|(i, name)| used(name, Measured::State(i)));
    let rates = names.rates.iter().enumerate().filter_map(|(i, rate)| {
        let rate = rate.as_ref().filter(|_| order == 2).filter(recorded)?;
        Some(used(rate, Measured::State(n + i)))
    });
    let inputs = names.inputs.iter().enumerate().map(|(j, name)| used(name, Measured::Input(j)));
    coordinates.chain(rates).chain(inputs).collect()
}

fn observe(hold: InputHold, used: &[Used], r: &Recording) -> Result<Observed, DiagnoseError> {
    let needed = Dataset::FEWEST_SAMPLES;
    if r.len() < needed {
        let (recording, found) = (r.name.clone(), r.len());
        return Err(DiagnoseError::TooShort { recording, found, needed });
    }
    let sampling = Sampling::of(&r.time);
    // Dropped rows are filled in; a leap longer than the recording itself is no dropped row.
    if let Some(leap) = sampling.gaps.iter().find(|g| g.missing > r.len()) {
        let Gap { after_row, from, to, missing } = *leap;
        return Err(DiagnoseError::Leap {
            recording: r.name.clone(),
            after_row,
            from,
            to,
            missing,
        });
    }
    let times = sampling.filled_times(&r.time);
    let rows = sampling.positions(r.len());
    let m = used.iter().filter(|u| matches!(u.of, Measured::Input(_))).count();
    let mut commands = vec![0.0; times.len() * m];
    let (mut outputs, mut lost) = (vec![], vec![]);
    for u in used {
        let values = in_model_units(u, r.column(&u.column)?, &r.name)?;
        let Measured::Input(j) = u.of else {
            let mut series = vec![f64::NAN; times.len()];
            for (&row, value) in rows.iter().zip(values) {
                series[row] = value;
            }
            outputs.push(series);
            continue;
        };
        let failed = |source| {
            let (recording, channel) = (r.name.clone(), u.name.clone());
            DiagnoseError::Signal { recording, channel, source }
        };
        let filled = resample_input(&r.time, &values, &times, hold).map_err(failed)?;
        for (k, value) in filled.into_iter().enumerate() {
            commands[k * m + j] = value;
        }
        let variance = lost_input_variance(&r.time, &values, &times).map_err(failed)?;
        let rows = variance.into_iter().enumerate().filter(|(_, variance)| *variance > 0.0);
        lost.extend(rows.map(|(row, variance)| LostInput { row, input: j, sd: variance.sqrt() }));
    }
    let dropped = times.len() - r.len();
    let cleaned = vec![Cleaned::default(); outputs.len()];
    let (name, anew) = (r.name.clone(), vec![]);
    Ok(Observed { name, times, commands, outputs, dropped, lost, anew, cleaned })
}

/// Conditions an output in all recordings; returns its noise.
fn conditioned(
    observed: &mut [Observed],
    k: usize,
    output: &Output,
) -> Result<NoiseEstimate, DiagnoseError> {
    let mut series: Vec<_> =
        observed.iter_mut().map(|o| (&o.times[..], &mut o.outputs[k][..])).collect();
    let (cleaned, noise) = condition(&mut series, &output.unit).map_err(|source| {
        let (recording, channel) = (observed[0].name.clone(), output.name.clone());
        DiagnoseError::Signal { recording, channel, source }
    })?;
    observed.iter_mut().zip(cleaned).for_each(|(o, cleaned)| o.cleaned[k] = cleaned);
    Ok(noise)
}

fn in_model_units(u: &Used, values: &[f64], recording: &str) -> Result<Vec<f64>, DiagnoseError> {
    if u.column_unit.is_empty() || u.column_unit == u.unit {
        return Ok(values.to_vec());
    }
    let fail = |source| DiagnoseError::Unit {
        recording: recording.to_owned(),
        column: u.column.clone(),
        source: Box::new(source),
    };
    let from = Unit::parse(&u.column_unit).map_err(fail)?;
    let to = Unit::parse(&u.unit).map_err(fail)?;
    convert(values, &from, &to).map_err(fail)
}
