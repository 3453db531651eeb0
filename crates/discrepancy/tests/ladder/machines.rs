//! Four machines and what their sensors would record of them.

use lacuna_discrepancy::diagnose::{Options, Outcome, diagnose, split};
use lacuna_discrepancy::{Dataset, Watch};
use lacuna_excitation::{SinusoidRanges, SumOfSinusoids, add_gaussian_noise, rng};
use lacuna_plants::{Hold, Model, SampledInput, System, rk4, rk4_sampled};
use lacuna_recordings::{Column, Recording};
use rand::{Rng, RngExt};

pub const PENDULUM: &str = r#"
name = "pendulum"
[parameters]
J = { value = 0.05, unit = "kg m^2", tolerance = 0.1 }
b = { value = 0.03, unit = "N m s/rad", tolerance = 0.1 }
mgl = { value = 0.4, unit = "N m", tolerance = 0.1 }
[[input]]
name = "tau"
unit = "N m"
[[coordinate]]
name = "q"
velocity = "dq"
unit = "rad"
[mechanics]
mass = [["J"]]
force = ["tau - b*dq - mgl*sin(q)"]
"#;

pub const TWO_MASS: &str = r#"
name = "two_mass"
[parameters]
m1 = { value = 1.0, unit = "kg", tolerance = 0.1 }
m2 = { value = 0.6, unit = "kg", tolerance = 0.1 }
k = { value = 40, unit = "N/m", tolerance = 0.1 }
d = { value = 0.8, unit = "N s/m", tolerance = 0.1 }
[[input]]
name = "u"
unit = "N"
[[coordinate]]
name = "x1"
velocity = "v1"
unit = "m"
[[coordinate]]
name = "x2"
velocity = "v2"
unit = "m"
[mechanics]
mass = [["m1", "0"], ["0", "m2"]]
force = ["u - k*(x1 - x2) - d*(v1 - v2) - 15*x1", "k*(x1 - x2) + d*(v1 - v2)"]
"#;

pub const TANKS: &str = r#"
name = "tanks"
[parameters]
a1 = { value = 0.05, unit = "m^0.5/s", tolerance = 0.1 }
a2 = { value = 0.04, unit = "m^0.5/s" }
kp = { value = 0.02, unit = "m/(s V)", tolerance = 0.1 }
[[input]]
name = "pump"
unit = "V"
[[state]]
name = "h1"
unit = "m"
derivative = "kp*pump - a1*sqrt(max(h1, 0))"
[[state]]
name = "h2"
unit = "m"
derivative = "a1*sqrt(max(h1, 0)) - a2*sqrt(max(h2, 0))"
"#;

/// A servo of a position, with the values of its data sheet.
pub const SERVO: &str = r#"
name = "servo"
[parameters]
J = { value = 0.03, unit = "kg m^2", tolerance = 0.3 }
kp = { value = 17.8, unit = "N m/rad", tolerance = 0.2 }
d = { value = 0.6, unit = "N m s/rad", tolerance = 0.5 }
[[input]]
name = "qc"
unit = "rad"
[[coordinate]]
name = "q"
velocity = "dq"
unit = "rad"
[mechanics]
mass = [["J"]]
force = ["kp*(qc - q) - d*dq"]
"#;

/// A carriage that nothing brings back.
pub const CARRIAGE: &str = r#"
name = "carriage"
[parameters]
m = { value = 1.0, unit = "kg", tolerance = 0.1 }
b = { value = 2.0, unit = "N s/m", tolerance = 0.1 }
[[input]]
name = "u"
unit = "N"
[[coordinate]]
name = "x"
velocity = "v"
unit = "m"
[mechanics]
mass = [["m"]]
force = ["u - b*v"]
"#;

/// How a machine is driven and watched.
#[derive(Clone, Copy)]
pub struct Bench {
    pub text: &'static str,
    pub samples: usize,
    pub step: f64,
    /// Mean of the input, amplitudes and angular frequencies of its four sinusoids.
    pub offset: f64,
    pub amplitude: (f64, f64),
    pub frequency: (f64, f64),
    /// First-order states, or positions, at the beginning.
    pub start: f64,
    pub noise: f64,
}

pub const ON_PENDULUM: Bench = Bench {
    text: PENDULUM,
    samples: 1000,
    step: 0.01,
    offset: 0.0,
    amplitude: (0.1, 0.3),
    frequency: (0.5, 6.0),
    start: 0.2,
    noise: 1e-3,
};

pub const ON_TWO_MASS: Bench = Bench {
    text: TWO_MASS,
    samples: 1000,
    step: 0.01,
    offset: 0.0,
    amplitude: (1.0, 4.0),
    frequency: (0.5, 9.0),
    start: 0.05,
    noise: 3e-4,
};

pub const ON_CARRIAGE: Bench = Bench {
    text: CARRIAGE,
    amplitude: (0.3, 1.2),
    frequency: (1.0, 8.0),
    start: 0.0,
    noise: 3e-4,
    ..ON_PENDULUM
};

pub const ON_TANKS: Bench = Bench {
    text: TANKS,
    samples: 600,
    step: 0.5,
    offset: 2.2,
    amplitude: (0.2, 0.7),
    frequency: (0.02, 0.3),
    start: 0.7,
    noise: 1e-3,
};

pub const ON_SERVO: Bench = Bench {
    text: SERVO,
    samples: 700,
    step: 0.02,
    amplitude: (0.02, 0.08),
    frequency: (0.3, 6.0),
    start: 0.03,
    noise: 4e-4,
    ..ON_PENDULUM
};

impl Bench {
    pub fn model(&self) -> Model {
        Model::from_text(self.text, "model.toml").expect("the model is right")
    }

    /// The model with an effect that the diagnosis is not told of.
    pub fn truth(&self, effect: &str) -> Model {
        let text = format!("{}\n{effect}", self.text);
        Model::from_text(&text, "truth.toml").expect("the truth is right")
    }

    /// `runs` recordings of `truth`; input `j` arrives `late` seconds late.
    pub fn record_late(&self, truth: &Model, seed: u64, runs: u64, late: f64) -> Vec<Recording> {
        (0..runs).map(|run| self.run(truth, seed, run, late)).collect()
    }

    pub fn record(&self, truth: &Model, seed: u64, runs: u64) -> Vec<Recording> {
        self.record_late(truth, seed, runs, 0.0)
    }

    /// Recordings of a drive in steps of so many seconds, each of a size and a sign of its own, that nothing smooths.
    pub fn record_steps(
        &self,
        truth: &Model,
        seed: u64,
        runs: u64,
        seconds: f64,
    ) -> Vec<Recording> {
        let one = |run| {
            let mut rng = rng(seed, run);
            let mut level = || {
                let size = rng.random_range(self.amplitude.0..=self.amplitude.1);
                if rng.random() { size } else { -size }
            };
            let length = (seconds / self.step).round() as usize;
            let steps = (0..self.samples.div_ceil(length)).flat_map(|_| vec![level(); length]);
            let commands = steps.take(self.samples).collect();
            self.recorded(truth, run, (commands, &mut rng), 0.0)
        };
        (0..runs).map(one).collect()
    }

    fn run(&self, truth: &Model, seed: u64, run: u64, late: f64) -> Recording {
        let mut rng = rng(seed, run);
        let ranges = SinusoidRanges {
            amplitude: self.amplitude.0..=self.amplitude.1,
            angular_frequency: self.frequency.0..=self.frequency.1,
            phase: 0.0..=std::f64::consts::TAU,
        };
        let drive = SumOfSinusoids::random(&mut rng, 1, 4, &ranges).expect("ranges");
        let commands = drive.sample(&self.times()).iter().map(|u| self.offset + u).collect();
        self.recorded(truth, run, (commands, &mut rng), late)
    }

    fn times(&self) -> Vec<f64> {
        (0..self.samples).map(|k| self.step * k as f64).collect()
    }

    fn recorded(
        &self,
        truth: &Model,
        run: u64,
        (commands, rng): (Vec<f64>, &mut impl Rng),
        late: f64,
    ) -> Recording {
        let mut start = vec![0.0; truth.machine_states()];
        let mut sensors = vec![];
        for channel in 0..truth.channels() {
            let state = truth.coordinate_index(channel);
            start[state] = self.start;
            sensors.push((truth.channel_name(channel), state, self.noise));
        }
        let driven = Driven { truth, time: &self.times(), commands: &commands, late };
        driven.recorded(run, &start, &sensors, rng)
    }
}

/// A machine and what drives it.
pub struct Driven<'a> {
    pub truth: &'a Model,
    /// From 0 on, evenly spaced.
    pub time: &'a [f64],
    /// Commands to all inputs, sample by sample.
    pub commands: &'a [f64],
    /// By how much they arrive late.
    pub late: f64,
}

impl Driven<'_> {
    /// What is recorded of it where it begins at `start`: commands, and of each sensor the column, the entry of the state
    /// and the standard deviation of the noise.
    pub fn recorded(
        &self,
        run: u64,
        start: &[f64],
        sensors: &[(&str, usize, f64)],
        rng: &mut impl Rng,
    ) -> Recording {
        let Self { truth, time, commands, late } = *self;
        let effective = truth.effective_inputs(time, commands);
        // A command that arrives late jumps between the samples of the sensors.
        let arrival: Vec<f64> = time.iter().map(|t| t + late).collect();
        let input = SampledInput { times: &arrival, values: &effective, hold: truth.hold };
        let system = System::new(truth);
        let motion = rk4(&system, &system.at_rest(start), &input, time, time[1] / 8.0)
            .expect("the machine does not diverge");
        let command = |j: usize| commands.iter().skip(j).step_by(truth.inputs.len()).copied();
        let inputs = truth.inputs.iter().enumerate();
        let mut columns: Vec<Column> = inputs
            .map(|(j, input)| Column { name: input.name.clone(), values: command(j).collect() })
            .collect();
        for &(name, state, noise) in sensors {
            let mut values: Vec<f64> = (0..time.len()).map(|k| motion.state(k)[state]).collect();
            add_gaussian_noise(&mut values, noise, rng).expect("a deviation");
            columns.push(Column { name: name.to_owned(), values });
        }
        Recording { name: format!("run{run}"), time: time.to_vec(), columns }
    }
}

/// Noise of the angle of [`held_upright`], rad.
pub const INVERTED_NOISE: f64 = 0.003;

/// A pendulum upside down, which falls where nobody holds it, with an effect.
pub fn inverted(effect: &str) -> Model {
    let text = "name = \"inverted\"\n[[coordinate]]\nname = \"q\"\nvelocity = \"v\"\nunit = \"rad\"\n\
        [[input]]\nname = \"u\"\nunit = \"N m\"\n[recordings]\ninput_hold = \"zero-order\"\n\
        [mechanics]\nmass = [[\"1\"]]\nforce = [\"40 * sin(q) + u\"]\n";
    Model::from_text(&format!("{text}{effect}"), "model.toml").expect("a model")
}

/// What would be recorded of it as a controller moves it about its place, as far as `reach`, with noise from a seed.
pub fn held_upright(name: &str, truth: &Model, (reach, seed): (f64, u64)) -> Recording {
    const STEP: f64 = 0.005;
    let plant = System::new(truth);
    let (mut x, mut time, mut u) = (plant.at_rest(&[0.2 * reach, 0.0]), vec![], vec![]);
    let mut q = vec![];
    for k in 0..1500 {
        let t = STEP * f64::from(k);
        let goal = reach * ((1.3 * t).sin() + 0.4 * (4.1 * t).sin());
        let held = 120.0 * (goal - x[0]) - 15.0 * x[1];
        time.push(t);
        u.push(held);
        q.push(x[0]);
        let path = rk4_sampled(&plant, &x, &[t, t + STEP], &[held, held], Hold::ZeroOrder, 8);
        x.copy_from_slice(path.expect("it is held").state(1));
    }
    add_gaussian_noise(&mut q, INVERTED_NOISE, &mut rng(seed, 0)).expect("a deviation");
    let column = |name: &str, values: &[f64]| Column { name: name.into(), values: values.into() };
    let columns = vec![column("q", &q), column("u", &u)];
    Recording { name: name.into(), time, columns }
}

/// Diagnose as the command does without `--held-out`.
pub fn diagnosed(model: &Model, recordings: &[Recording]) -> Outcome {
    let dataset = Dataset::new(model, recordings).expect("the recordings fit");
    let (training, held_out) = split(&dataset);
    diagnose(model, &training, &held_out, Options::default(), &Watch::default())
        .expect("the diagnosis is made")
}
