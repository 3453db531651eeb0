//! The missing force that is drawn against the one that was concealed.

use crate::machines::PENDULUM;
use lacuna_discrepancy::likelihood::Problem;
use lacuna_discrepancy::missing_force::{Belief, Learned, MissingForce};
use lacuna_discrepancy::screen::Over;
use lacuna_discrepancy::{Dataset, Decision};
use lacuna_excitation::{SinusoidRanges, SumOfSinusoids, add_gaussian_noise, rng};
use lacuna_plants::{Model, SampledInput, System, rk4};
use lacuna_recordings::{Column, Recording};
use rand::RngExt;

const DUFFING: &str = r#"
name = "duffing"
[parameters]
m = { value = 1.0, unit = "kg", tolerance = 0.05 }
c = { value = 0.4, unit = "N s/m", tolerance = 0.1 }
k1 = { value = 2.0, unit = "N/m", tolerance = 0.1 }
k3 = { value = 1.5, unit = "N/m^3", tolerance = 0.1 }
[[input]]
name = "u"
unit = "N"
[[coordinate]]
name = "x"
velocity = "v"
unit = "m"
[mechanics]
mass = [["m"]]
force = ["u - c*v - k1*x - k3*x^3"]
"#;

const TWO_LINK: &str = r#"
name = "two_link"
[parameters]
p1 = { value = 3.473, unit = "kg m^2", tolerance = 0.1 }
p2 = { value = 0.196, unit = "kg m^2", tolerance = 0.1 }
p3 = { value = 0.242, unit = "kg m^2", tolerance = 0.1 }
fd1 = { value = 5.3, unit = "N m s/rad", tolerance = 0.1 }
fd2 = { value = 1.1, unit = "N m s/rad", tolerance = 0.1 }
[[input]]
name = "tau1"
unit = "N m"
[[input]]
name = "tau2"
unit = "N m"
[[coordinate]]
name = "q1"
velocity = "dq1"
unit = "rad"
[[coordinate]]
name = "q2"
velocity = "dq2"
unit = "rad"
[mechanics]
mass = [["p1 + 2*p3*cos(q2)", "p2 + p3*cos(q2)"], ["p2 + p3*cos(q2)", "p2"]]
force = ["tau1 + p3*sin(q2)*dq2*dq1 + p3*sin(q2)*(dq1 + dq2)*dq2 - fd1*dq1",
         "tau2 - p3*sin(q2)*dq1*dq1 - fd2*dq2"]
"#;

/// A plant with what drives it: amplitudes of each input's four sinusoids, their angular
/// frequencies, the sampling step.
struct Plant {
    text: &'static str,
    amplitudes: &'static [[f64; 2]],
    frequencies: [f64; 2],
    step: f64,
}

const PLANTS: [Plant; 3] = [
    Plant { text: PENDULUM, amplitudes: &[[0.03, 0.08]], frequencies: [0.5, 6.0], step: 0.01 },
    Plant { text: DUFFING, amplitudes: &[[0.5, 1.5]], frequencies: [0.3, 4.0], step: 0.02 },
    Plant {
        text: TWO_LINK,
        amplitudes: &[[4.0, 10.0], [0.2, 0.6]],
        frequencies: [2.0, 9.0],
        step: 0.01,
    },
];

const RECORDINGS: u64 = 4;
const SAMPLES: usize = 1000;

const CLASSES: [&str; 7] = [
    "coulomb_friction",
    "linear_stiffness",
    "quadratic_drag",
    "end_stop",
    "constant_force",
    "step_change",
    "cubic_stiffness",
];

/// What is concealed: a force of one channel, as a formula.
#[derive(Clone, Copy, Debug)]
struct Concealed {
    class: &'static str,
    channel: usize,
    force: f64,
    at: f64,
    width: f64,
}

impl Concealed {
    fn at(&self, t: f64, q: f64, v: f64) -> f64 {
        let Self { force: f, at, width, .. } = *self;
        match self.class {
            "coulomb_friction" => -f * (v / width).tanh(),
            "linear_stiffness" => -f * q,
            "quadratic_drag" => -f * v * v.abs(),
            "end_stop" => -f * (q - at).max(0.0),
            "constant_force" => f,
            "step_change" => f * f64::from(u8::from(t >= at)),
            "cubic_stiffness" => -f * q.powi(3),
            _ => 0.0,
        }
    }

    fn toml(&self, model: &Model) -> String {
        let Self { force: f, at, width, .. } = self;
        let parameters = match self.class {
            "coulomb_friction" => format!("magnitude = {f}\nsmoothing_velocity = {width}"),
            "linear_stiffness" | "cubic_stiffness" => format!("stiffness = {f}"),
            "quadratic_drag" => format!("coefficient = {f}"),
            "end_stop" => format!("stiffness = {f}\nposition = {at}\nside = 1"),
            "constant_force" => format!("force = {f}"),
            "step_change" => format!("force = {f}\ntime = {at}"),
            _ => return String::new(),
        };
        let channel = model.channel_name(self.channel);
        format!("[[effect]]\nclass = \"{}\"\nchannel = \"{channel}\"\n{parameters}\n", self.class)
    }
}

struct Case {
    model: Model,
    concealed: Concealed,
    recordings: Vec<Recording>,
    /// Times and true states of every recording, row after row.
    truth: Vec<(Vec<f64>, Vec<Vec<f64>>)>,
}

fn run(truth: &Model, plant: &Plant, seed: u64, run: u64) -> (Vec<f64>, Vec<f64>, Vec<Vec<f64>>) {
    let mut rng = rng(seed, 100 + run);
    let times: Vec<f64> = (0..SAMPLES).map(|k| plant.step * k as f64).collect();
    let m = truth.inputs.len();
    let mut inputs = vec![0.0; SAMPLES * m];
    for (j, [low, high]) in plant.amplitudes.iter().enumerate() {
        let [slow, fast] = plant.frequencies;
        let ranges = SinusoidRanges {
            amplitude: *low..=*high,
            angular_frequency: slow..=fast,
            phase: 0.0..=std::f64::consts::TAU,
        };
        let drive = SumOfSinusoids::random(&mut rng, 1, 4, &ranges).expect("ranges");
        for (k, u) in drive.sample(&times).into_iter().enumerate() {
            inputs[k * m + j] = u;
        }
    }
    let input = SampledInput { times: &times, values: &inputs, hold: truth.hold };
    let n = truth.coordinates.len();
    let mut start: Vec<f64> = (0..n).map(|_| rng.random_range(-0.3..0.3)).collect();
    start.resize(2 * n, 0.0);
    let system = System::new(truth);
    let motion = rk4(&system, &system.at_rest(&start), &input, &times, plant.step / 8.0)
        .expect("the machine does not diverge");
    let states = (0..SAMPLES).map(|k| motion.state(k)[..2 * n].to_vec()).collect();
    (times, inputs, states)
}

fn extent(states: &[Vec<f64>], i: usize) -> (f64, f64) {
    states.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x[i]), b.max(x[i])))
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(s, c), v| (s + v * v, c + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}

/// Case number `k`; nothing is concealed where the class is none.
fn draw(k: usize, class: &'static str) -> Case {
    let seed = 500 + k as u64;
    let mut rng = rng(seed, 0);
    let plant = &PLANTS[k % PLANTS.len()];
    let model = Model::from_text(plant.text, "model.toml").expect("the model is right");
    let n = model.coordinates.len();
    let channel = rng.random_range(0..n);
    // Magnitudes from the motion without the effect.
    let (_, _, scout) = run(&model, plant, seed, 0);
    let (low, high) = extent(&scout, channel);
    let (half, centre) = (0.5 * (high - low), 0.5 * (high + low));
    let v = rms(scout.iter().map(|x| x[channel + n]));
    let drive = plant.amplitudes[channel][1];
    let strength = drive * rng.random_range(0.15..0.4);
    let at = centre + half * rng.random_range(0.3..0.6);
    let duration = plant.step * SAMPLES as f64;
    let (force, at, width) = match class {
        "linear_stiffness" => (strength / half, 0.0, 0.0),
        "cubic_stiffness" => (2.0 * strength / half.powi(3), 0.0, 0.0),
        "quadratic_drag" => (strength / (v * v), 0.0, 0.0),
        "end_stop" => (4.0 * strength / half, at, 0.0),
        "step_change" => (strength, duration * rng.random_range(0.3..0.7), 0.0),
        _ => (strength, 0.0, 0.02 * v),
    };
    let concealed = Concealed { class, channel, force, at, width };
    let text = format!("{}\n{}", plant.text, concealed.toml(&model));
    let mut machine = Model::from_text(&text, "truth.toml").expect("the truth is right");
    for p in &mut machine.parameters {
        p.value *= 1.0 + p.tolerance() * rng.random_range(-1.0..1.0);
    }
    let share = (0.001f64.ln() + rng.random_range(0.0..1.0) * 10f64.ln()).exp();
    let velocities = rng.random_range(0.0..1.0) < 0.4;
    let mut case = Case { model, concealed, recordings: vec![], truth: vec![] };
    for r in 0..RECORDINGS {
        let (time, inputs, states) = run(&machine, plant, seed, r);
        let measured = if velocities { 2 * n } else { n };
        let mut columns: Vec<Column> = (0..measured)
            .map(|i| {
                let (low, high) = extent(&states, i);
                let mut values: Vec<f64> = states.iter().map(|x| x[i]).collect();
                add_gaussian_noise(&mut values, share * (high - low), &mut rng)
                    .expect("a deviation");
                Column { name: case.model.state_name(i).to_owned(), values }
            })
            .collect();
        let m = machine.inputs.len();
        columns.extend(machine.inputs.iter().enumerate().map(|(j, input)| Column {
            name: input.name.clone(),
            values: inputs.iter().skip(j).step_by(m).copied().collect(),
        }));
        case.recordings.push(Recording { name: format!("run{r}"), time: time.clone(), columns });
        case.truth.push((time, states));
    }
    case
}

fn missing(model: &Model, dataset: &Dataset) -> MissingForce {
    let problem = Problem::new(model, dataset).expect("a problem");
    let belief = Belief::of(model, Decision::default().prior_odds);
    MissingForce::of(&problem, &belief)
}

/// The curve at a value, with its deviation.
fn at(curve: &Learned, x: f64) -> (f64, f64) {
    let k = curve.at.partition_point(|a| *a < x).clamp(1, curve.at.len() - 1);
    let share = ((x - curve.at[k - 1]) / (curve.at[k] - curve.at[k - 1])).clamp(0.0, 1.0);
    let between = |v: &[f64]| v[k - 1] + share * (v[k] - v[k - 1]);
    (between(&curve.force), between(&curve.std))
}

/// How a drawn curve compares with the truth along the motion: samples within two of its
/// standard deviations, all samples, the median deviation and the true root mean square.
fn compare(case: &Case, curve: &Learned) -> (f64, f64, f64, f64) {
    let (c, n) = (case.concealed.channel, case.model.coordinates.len());
    let (mut hits, mut sds, mut truths) = (0.0, vec![], vec![]);
    for (times, states) in &case.truth {
        for (t, x) in times.iter().zip(states) {
            let truth = case.concealed.at(*t, x[c], x[c + n]);
            let over = match curve.over {
                Over::Coordinate => x[c],
                Over::Velocity => x[c + n],
                Over::Time => *t,
            };
            let (force, sd) = at(curve, over);
            hits += f64::from(u8::from((force - truth).abs() <= 2.0 * sd));
            sds.push(sd);
            truths.push(truth);
        }
    }
    sds.sort_by(f64::total_cmp);
    (hits, sds.len() as f64, sds[sds.len() / 2], rms(truths.into_iter()))
}

#[test]
fn the_drawn_force_is_the_concealed_one() {
    let (mut inside, mut all, mut doubts, mut drawn) = (0.0, 0.0, vec![], 0);
    for k in 0..21 {
        let case = draw(k, CLASSES[k % CLASSES.len()]);
        let dataset = Dataset::new(&case.model, &case.recordings).expect("a dataset");
        let found = missing(&case.model, &dataset);
        let channel = found.channel(case.concealed.channel).expect("the channel is measured");
        let curve = &channel.curves[0];
        let (hits, count, sd, truth) = compare(&case, curve);
        println!(
            "{k:2} {:9} {:16} over {:10?} {:6.0} nats, within {:.3}, sd/rms {:.3}, rms {:.3} of {:.3}, beside {}",
            case.model.name,
            case.concealed.class,
            curve.over,
            channel.significance,
            hits / count,
            sd / truth,
            channel.rms,
            truth,
            channel.curves.len() - 1,
        );
        // What the parameters can stand for within their tolerances is not drawn.
        if channel.significance < 10.0 {
            continue;
        }
        drawn += 1;
        inside += hits;
        all += count;
        doubts.push(sd / truth);
    }
    doubts.sort_by(f64::total_cmp);
    let (share, doubt) = (inside / all, doubts[doubts.len() / 2]);
    println!("{drawn} drawn, within two deviations {share:.3}, median doubt {doubt:.3}");
    assert!(drawn >= 15, "{drawn} of 21 drawn");
    assert!(share >= 0.9, "within two deviations at {share:.3} of the samples");
    assert!(doubt < 0.3, "deviations of {doubt:.2} of the force");
}

#[test]
fn nothing_is_drawn_where_nothing_is_missing() {
    for k in 0..9 {
        let case = draw(100 + k, "nothing");
        let dataset = Dataset::new(&case.model, &case.recordings).expect("a dataset");
        let found = missing(&case.model, &dataset);
        for c in 0..case.model.channels() {
            let channel = found.channel(c).expect("the channel is measured");
            let (name, nats) = (&case.model.name, channel.significance);
            println!("{name} {nats:.1} nats, rms {:.4}", channel.rms);
            assert!(nats < 10.0, "{name}: {nats} nats");
        }
    }
}

/// `lacuna demo --seed 23`: an arm with asymmetric friction that spins. A model that runs away
/// from its recordings must not make the missing force any larger than it is.
#[test]
fn the_demo_that_runs_away_is_drawn_as_it_is() {
    const ARM: &str = include_str!("../../../../examples/arm/model.toml");
    const FRICTION: &str = "[[effect]]\nclass = \"asymmetric_friction\"\nchannel = \"theta\"\n\
        positive = 0.2811\nnegative = 0.1323\nsmoothing_velocity = 0.02\n";
    let model = Model::from_text(ARM, "model.toml").expect("the model is right");
    let text = format!("{}\n{FRICTION}", ARM.replace("value = 0.9,", "value = 0.9212,"));
    let truth = Model::from_text(&text, "truth.toml").expect("the truth is right");
    let system = System::new(&truth);
    let time: Vec<f64> = (0..2000).map(|k| 0.005 * f64::from(k)).collect();
    let ranges = SinusoidRanges {
        amplitude: 0.3..=0.9,
        angular_frequency: 0.5..=6.0,
        phase: 0.0..=std::f64::consts::TAU,
    };
    let (mut recordings, mut friction) = (vec![], vec![]);
    for k in 0..4 {
        let mut rng = rng(23, 1 + k);
        let drive = SumOfSinusoids::random(&mut rng, 1, 4, &ranges).expect("ranges");
        let values = drive.sample(&time);
        let input = SampledInput { times: &time, values: &values, hold: truth.hold };
        let start = [rng.random_range(-0.3..0.3), 0.0];
        let motion = rk4(&system, &system.at_rest(&start), &input, &time, 0.00125)
            .expect("the arm does not diverge");
        let mut angle: Vec<f64> = (0..time.len()).map(|s| motion.state(s)[0]).collect();
        let force = |v: f64| -(v / 0.02).tanh() * if v > 0.0 { 0.2811 } else { 0.1323 };
        friction.extend((0..time.len()).map(|s| force(motion.state(s)[1])));
        add_gaussian_noise(&mut angle, 0.002, &mut rng).expect("a deviation");
        let columns = vec![
            Column { name: "theta".into(), values: angle },
            Column { name: "tau".into(), values },
        ];
        recordings.push(Recording { name: format!("run{k}"), time: time.clone(), columns });
    }
    let dataset = Dataset::new(&model, &recordings).expect("a dataset");
    let found = missing(&model, &dataset);
    let channel = found.channel(0).expect("the angle is measured");
    let concealed = rms(friction.into_iter());
    println!("rms {:.3} of {concealed:.3}, {:.0} nats", channel.rms, channel.significance);
    assert_eq!(channel.curves[0].over, Over::Velocity);
    assert!(channel.rms < 1.5 * concealed && channel.rms > concealed / 1.5, "{}", channel.rms);
}
