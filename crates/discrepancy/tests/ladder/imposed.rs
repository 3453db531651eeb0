//! Imposed motion: what moves a machine along a recorded path is measured, and tells what it lacks.

use crate::machines::diagnosed;
use lacuna_discrepancy::diagnosis::{ProofOutcome, Verdict};
use lacuna_discrepancy::likelihood::sweep::Run;
use lacuna_discrepancy::likelihood::{Fit, Hypothesis, Problem, STILL};
use lacuna_discrepancy::missing_force::{Belief, MissingForce};
use lacuna_discrepancy::{Dataset, DiagnoseError};
use lacuna_excitation::{add_gaussian_noise, rng};
use lacuna_plants::model::{Measured, Observation};
use lacuna_plants::{Model, Substeps, System};
use lacuna_recordings::{Column, Recording};
use rand::RngExt;
use std::f64::consts::TAU;

const STEP: f64 = 0.01;
const NOISE: f64 = 0.05;

/// A damper in a rig, as it is believed: the cell shows what the damper does to the rig.
const DAMPER: &str = r#"
name = "damper"
[parameters]
c = { value = 40, unit = "N s/m", tolerance = 0.2 }
k = { value = 300, unit = "N/m", tolerance = 0.2 }
F0 = { value = 6, unit = "N", tolerance = 0.2 }
[[coordinate]]
name = "x"
velocity = "dx"
unit = "m"
imposed = true
[mechanics]
mass = [["0.5"]]
force = ["-F0 - c*dx - k*x"]
[[measurement]]
column = "x_mm"
of = "x"
unit = "mm"
[[measurement]]
column = "cell"
of = "-force on x"
unit = "N"
"#;

/// A rod that a rig moves, and a mass that hangs on it by a spring; two cells.
const ISOLATOR: &str = r#"
name = "isolator"
[parameters]
k = { value = 300, unit = "N/m", tolerance = 0.1 }
d = { value = 2, unit = "N s/m", tolerance = 0.1 }
[[coordinate]]
name = "x"
velocity = "dx"
unit = "m"
force_unit = "N"
imposed = true
[[coordinate]]
name = "y"
velocity = "dy"
unit = "m"
[[coordinate]]
name = "w"
velocity = "dw"
unit = "m"
imposed = true
[mechanics]
mass = [["1", "0", "0"], ["0", "0.8", "0"], ["0", "0", "0"]]
force = ["-k*(x - y) - d*(dx - dy)", "k*(x - y) + d*(dx - dy) - 200*(y - w)", "200*(y - w)"]
[[measurement]]
column = "Fx"
of = "force on x"
unit = "kN"
[[measurement]]
column = "Fw"
of = "force on w"
unit = "N"
"#;

fn read(text: &str) -> Model {
    Model::from_text(text, "model.toml").expect("the model is right")
}

/// A path of four sinusoids: position, velocity, acceleration.
struct Path([(f64, f64, f64); 4]);

impl Path {
    fn random(seed: u64, run: u64) -> Self {
        let mut rng = rng(seed, run);
        let frequencies = [0.7, 1.9, 4.3, 9.1];
        Self(frequencies.map(|w| {
            let amplitude = 0.02 / (1.0 + 0.15 * w) * rng.random_range(0.7..1.3);
            (amplitude, w * rng.random_range(0.9..1.1), rng.random_range(0.0..TAU))
        }))
    }

    fn at(&self, t: f64) -> [f64; 3] {
        let sum = |of: &dyn Fn(f64, f64, f64) -> f64| {
            self.0.iter().map(|&(a, w, phase)| of(a, w, w * t + phase)).sum()
        };
        [
            sum(&|a, _, p| a * p.sin()),
            sum(&|a, w, p| a * w * p.cos()),
            sum(&|a, w, p| -a * w * w * p.sin()),
        ]
    }
}

/// What the sensors of a machine record that is moved along a path: a column of every measurement,
/// and of the coordinates that have none.
fn record(truth: &Model, seed: u64, run: u64, samples: usize) -> Recording {
    let paths: Vec<Path> =
        truth.imposed().map(|c| Path::random(seed, 10 * run + c as u64)).collect();
    let time: Vec<f64> = (0..samples).map(|k| STEP * k as f64).collect();
    let rows: Vec<f64> =
        time.iter().flat_map(|&t| paths.iter().flat_map(move |p| p.at(t))).collect();
    let series = (&time[..], &rows[..]);
    let inputs = truth.inputs_along(series, 0..samples, 16);
    let free = (0..truth.machine_states()).filter(|&i| i < truth.coordinates.len());
    let free = free.filter(|&i| !truth.is_imposed_state(i)).map(Measured::State);
    let measured: Vec<Measured> = truth.measurements.iter().map(|m| m.of).chain(free).collect();
    let observation = Observation::of(truth, &measured);
    let system = System::new(truth);
    let mut state = vec![0.0; truth.machine_states()];
    system.impose(inputs.sample(0), &mut state);
    let mut state = system.at_rest(&state);
    let mut workspace = system.workspace();
    let mut values = vec![vec![]; measured.len()];
    let mut y = vec![0.0; measured.len()];
    for k in 0..samples {
        observation.evaluate(&system, time[k], &state, inputs.sample(k), &mut y);
        values.iter_mut().zip(&y).for_each(|(series, y)| series.push(*y));
        if k + 1 < samples {
            let span = (time[k], time[k + 1]);
            system.advance(&mut workspace, span, inputs.step(k), Substeps::even(16), &mut state);
        }
    }
    let mut noise = rng(seed, 1000 + run);
    let mut columns = vec![];
    for (k, (mut values, of)) in values.into_iter().zip(&measured).enumerate() {
        let declared = truth.measurements.get(k);
        let unit = declared.map_or("", |m| m.unit.as_str());
        let factor = if unit == "mm" {
            1e3
        } else if unit == "kN" {
            1e-3
        } else {
            1.0
        };
        let sd = match *of {
            Measured::State(i) if truth.is_imposed_state(i) => 1e-6,
            Measured::State(_) => 2e-5,
            _ => NOISE,
        };
        add_gaussian_noise(&mut values, sd, &mut noise).expect("a deviation");
        let name = match (declared, of) {
            (Some(m), _) => m.column.clone(),
            (None, Measured::State(i)) => truth.state_name(*i).to_owned(),
            (None, _) => panic!("only coordinates are left"),
        };
        columns.push(Column { name, values: values.iter().map(|v| factor * v).collect() });
    }
    for (c, path) in truth.imposed().zip(&paths) {
        let name = truth.state_name(c).to_owned();
        if !measured.contains(&Measured::State(c)) {
            let values = time.iter().map(|&t| path.at(t)[0]).collect();
            columns.push(Column { name, values });
        }
    }
    Recording { name: format!("run{run}"), time, columns }
}

fn recordings(truth: &Model, seed: u64, runs: u64) -> Vec<Recording> {
    (0..runs).map(|run| record(truth, seed, run, 1200)).collect()
}

const HIDDEN: &str = "[[effect]]\nclass = \"coulomb_friction\"\nchannel = \"x\"\nmagnitude = 5\n\
    smoothing_velocity = 0.002\n[[effect]]\nclass = \"hysteresis\"\nchannel = \"x\"\n\
    stiffness = 900\nbeta = 60\ngamma = 30\n";

#[test]
fn dry_friction_and_hysteresis_show_in_the_force() {
    let (model, truth) = (read(DAMPER), read(&format!("{DAMPER}{HIDDEN}")));
    let outcome = diagnosed(&model, &recordings(&truth, 300, 4));
    let d = &outcome.diagnosis;
    assert_eq!((d.verdict, d.proof), (Verdict::MissingPhysics, ProofOutcome::Better), "{d:#?}");
    let hysteresis = d.findings.iter().find(|f| f.class == "hysteresis").expect("it is there");
    let friction = d.findings.iter().find(|f| f.class != "hysteresis").expect("it is there");
    // One magnitude, or one each way.
    let (classes, magnitudes) = (["coulomb_friction", "asymmetric_friction"], [5.0; 2]);
    assert!(classes.contains(&friction.class.as_str()) && d.findings.len() == 2, "{d:#?}");
    let names = ["magnitude", "positive", "negative"].into_iter();
    let names = names.filter(|name| friction.parameters.contains_key(*name));
    let dry = names.zip(magnitudes).map(|(name, expected)| (friction, name, expected));
    let loops = [("stiffness", 900.0), ("beta", 60.0), ("gamma", 30.0)];
    for (finding, name, expected) in dry.chain(loops.map(|(name, e)| (hysteresis, name, e))) {
        let found = &finding.parameters[name];
        let off = (found.value - expected).abs();
        assert!(off < 4.0 * found.std + 0.02 * expected, "{name}: {found:?}");
    }
    let fit = &d.fit.held_out["cell"];
    assert!(fit.rmse_after < 1.2 * NOISE && fit.rmse_before > 20.0 * NOISE, "{fit:?}");
    // The augmented model is read back as it is.
    let text = model.augmented_text(&outcome.augmentation).expect("a text");
    let again = read(&text);
    assert_eq!(again.effects.len(), 2);
    assert!(again.is_imposed(0));
}

/// Windows begin where the rig is, whatever is missing: where it is is known, and nothing to fit.
#[test]
fn windows_begin_where_the_motion_is_imposed() {
    let (model, truth) = (read(DAMPER), read(&format!("{DAMPER}{HIDDEN}")));
    let dataset = Dataset::new(&model, &recordings(&truth, 305, 2)).expect("a dataset");
    let problem = Problem::new(&model, &dataset).expect("a problem");
    let fit = Fit::begin(&problem, Hypothesis::of(&model), 4).expect("a fit");
    assert!(fit.windowed.windows[0].len() > 4 && fit.reduced() > 100.0, "{}", fit.reduced());
    for (path, observed) in fit.paths().expect("a path").iter().zip(&dataset.recordings) {
        let rows = path.chunks_exact(2).zip(observed.commands.chunks_exact(3));
        assert_eq!(rows.len(), observed.len());
        for (k, (state, motion)) in rows.enumerate() {
            let off = (state[0] - motion[0]).abs() + (state[1] - motion[1]).abs();
            assert!(off < 1e-12, "sample {k}: {state:?}, not {motion:?}");
        }
    }
}

/// Bristles slip after a small share of the travel: the spring of the loop is stiff beyond all else, but what it
/// holds is one of the forces of the machine, and no less believed than a wider loop as high.
#[test]
fn loops_of_small_travel_are_believed_too() {
    let model = read(DAMPER);
    let dataset = Dataset::new(&model, &recordings(&model, 340, 1)).expect("a dataset");
    let problem = Problem::new(&model, &dataset).expect("a problem");
    let [wide, narrow] = [60.0, 1500.0].map(|beta| {
        let (stiffness, gamma) = (5.0 * beta, 0.5 * beta);
        let law = read(&format!(
            "{DAMPER}[[effect]]\nclass = \"hysteresis\"\nchannel = \"x\"\n\
             stiffness = {stiffness:.1}\nbeta = {beta:.1}\ngamma = {gamma:.1}\n"
        ));
        let h = Hypothesis::of(&model);
        let h = h.with(law.effects[0].clone(), &problem.scales_of(&law.effects[0]));
        h.penalty(&h.theta())
    });
    // A travel that is three times the deviation of its prior from what is usual costs nine, and the force nothing.
    assert!(wide < 2.0 && narrow < wide + 10.0, "{wide} {narrow}");
}

#[test]
fn where_nothing_is_missing_nothing_is_found() {
    let model = read(DAMPER);
    let d = diagnosed(&model, &recordings(&model, 310, 4)).diagnosis;
    assert_eq!(d.verdict, Verdict::NoMismatch, "{d:#?}");
    let off = read(&DAMPER.replace("value = 40", "value = 52"));
    let d = diagnosed(&model, &recordings(&off, 320, 4)).diagnosis;
    assert_eq!(d.verdict, Verdict::Miscalibrated, "{d:#?}");
    let c = &d.calibration["c"];
    assert!((c.value - 52.0).abs() < 4.0 * c.std + 0.1, "{c:?}");
}

/// What is missing on the coordinate that is free is told by its motion and by both cells.
#[test]
fn one_coordinate_may_be_imposed_and_another_free() {
    let effect = "[[effect]]\nclass = \"cubic_stiffness\"\nchannel = \"y\"\nstiffness = 2e5\n";
    let (model, truth) = (read(ISOLATOR), read(&format!("{ISOLATOR}{effect}")));
    let d = diagnosed(&model, &recordings(&truth, 330, 4)).diagnosis;
    let found: Vec<_> = d.findings.iter().map(|f| (f.class.as_str(), f.channel.as_str())).collect();
    assert_eq!(found, [("cubic_stiffness", "y")], "{d:#?}");
    let channels: Vec<&str> = d.fit.held_out.keys().map(String::as_str).collect();
    assert_eq!(channels, ["Fw", "Fx", "y"]);
    assert_eq!(d.fit.held_out["Fx"].unit, "N");
    for fit in d.fit.held_out.values() {
        assert!(fit.rmse_after < 1.3 * fit.noise, "{:#?}", d.fit.held_out);
    }
}

#[test]
fn derivatives_of_the_force_along_a_recording_agree_with_differences() {
    let text = format!("{DAMPER}{HIDDEN}");
    let truth = read(&text);
    let model = read(DAMPER);
    let dataset = Dataset::new(&model, &[record(&truth, 340, 0, 300)]).expect("a dataset");
    let problem = Problem::new(&model, &dataset).expect("a problem");
    let mut h = Hypothesis::of(&model);
    for effect in &truth.effects {
        h = h.with(effect.clone(), &problem.scales_of(effect));
    }
    let fit = Fit::begin(&problem, h.clone().held(), 1).expect("a fit");
    let fit = fit.refit(h, STILL).expect("a fit");
    let run = |hypothesis: &Hypothesis| {
        Run {
            problem: &problem,
            hypothesis,
            windows: &fit.windowed.windows[0],
            starts: &fit.windowed.starts[0],
            filters: &[],
            substeps: Substeps::even(4),
        }
        .linearise(1)
        .expect("it does not diverge")
    };
    let here = run(&fit.hypothesis);
    let theta = fit.hypothesis.theta();
    let before = model.machine_states() + fit.windowed.starts[0].memory.len();
    assert_eq!((before, theta.len(), here.len()), (3, 8, 2));
    for (j, value) in theta.iter().enumerate() {
        let step = 1e-5 * (1e-3 + value.abs());
        let moved = |by: f64| {
            let mut h = fit.hypothesis.clone();
            let mut theta = theta.clone();
            theta[j] += by;
            h.set(&theta);
            run(&h)
        };
        let (there, back) = (moved(step), moved(-step));
        for (window, columns) in here.iter().enumerate() {
            let largest = columns.by[before + j].iter().fold(0.0f64, |a, b| a.max(b.abs()));
            assert!(largest > 0.0, "entry {j}");
            for (k, by) in columns.by[before + j].iter().enumerate() {
                let residual = |all: &[lacuna_discrepancy::likelihood::sweep::Columns]| {
                    all[window].residual[k]
                };
                let difference = -(residual(&there) - residual(&back)) / (2.0 * step);
                assert!((by - difference).abs() < 2e-3 * largest, "{j} {k}: {by} {difference}");
            }
        }
    }
}

/// The missing force is read off the cell, with no acceleration taken of anything.
#[test]
fn the_missing_force_is_what_the_cell_shows() {
    let effect = "[[effect]]\nclass = \"quadratic_drag\"\nchannel = \"x\"\ncoefficient = 400\n";
    let (model, truth) = (read(DAMPER), read(&format!("{DAMPER}{effect}")));
    let dataset = Dataset::new(&model, &recordings(&truth, 350, 2)).expect("a dataset");
    let problem = Problem::new(&model, &dataset).expect("a problem");
    let missing = MissingForce::of(&problem, &Belief::of(&model, 5.0));
    let found = missing.channel(0).expect("it is told");
    assert!(found.significance > 100.0, "{}", found.significance);
    let curve = &found.curves[0];
    assert_eq!(curve.over, lacuna_discrepancy::screen::Over::Velocity);
    // Of what the tolerances leave open, a straight line, the band tells.
    let law = |v: f64| -400.0 * v * v.abs();
    let largest = curve.at.iter().map(|&v| law(v).abs()).fold(0.0, f64::max);
    for ((&v, force), std) in curve.at.iter().zip(&curve.force).zip(&curve.std) {
        assert!((force - law(v)).abs() < 4.0 * std + 0.05 * largest, "{v}: {force} {}", law(v));
    }
}

#[test]
fn an_imposed_coordinate_must_be_recorded() {
    let model = read(DAMPER);
    let mut unrecorded = record(&model, 360, 0, 200);
    unrecorded.columns.retain(|c| c.name != "x_mm");
    let said = Dataset::new(
        &read(&DAMPER.replace("column = \"x_mm\"", "column = \"s\"")),
        &[unrecorded.clone()],
    );
    assert!(said.expect_err("it is not there").to_string().contains("'s'"));
    let position = "[[measurement]]\ncolumn = \"x_mm\"\nof = \"x\"\nunit = \"mm\"\n";
    let said = Dataset::new(&read(&DAMPER.replace(position, "")), &[unrecorded]);
    match said.expect_err("it is not there") {
        DiagnoseError::NotImposed { recording, columns, channel } => {
            assert_eq!((recording.as_str(), channel.as_str()), ("run0", "x"));
            assert_eq!(columns, ["cell"]);
        }
        other => panic!("{other}"),
    }
}
