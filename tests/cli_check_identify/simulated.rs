//! `lacuna diagnose --simulated`: two sets of recordings and no model.

use crate::bench::{Bench, Run, stdout};
use lacuna::excitation::{SinusoidRanges, SumOfSinusoids, add_gaussian_noise, rng};
use lacuna::plants::integrate::rk4_sampled;
use lacuna::plants::{Hold, Plant};
use serde_json::Value;

const STEP: f64 = 0.02;
const ROWS: usize = 500;

/// Two masses, each on a spring and a damper, a spring between them.
#[derive(Clone, Copy)]
struct Masses {
    /// kg.
    mass: [f64; 2],
    /// Dry friction of the first, N.
    friction: f64,
}

/// What the simulator believes.
const BELIEVED: Masses = Masses { mass: [1.0, 0.7], friction: 0.0 };

impl Plant for Masses {
    fn order(&self) -> usize {
        1
    }

    fn dimension(&self) -> usize {
        4
    }

    fn inputs(&self) -> usize {
        2
    }

    fn derivative(&self, _t: f64, x: &[f64], u: &[f64], derivative: &mut [f64]) {
        let between = 3.0 * (x[1] - x[0]);
        let dry = self.friction * (x[2] / 0.1).tanh();
        derivative[..2].copy_from_slice(&x[2..]);
        derivative[2] = (u[0] - 8.0 * x[0] - 0.8 * x[2] + between - dry) / self.mass[0];
        derivative[3] = (u[1] - 6.0 * x[1] - 0.6 * x[3] - between) / self.mass[1];
    }

    fn drift(&self, x: &[f64], f: &mut [f64]) {
        self.derivative(0.0, x, &[0.0, 0.0], f);
    }

    fn control_effectiveness(&self, _x: &[f64], g: &mut [f64]) {
        let [a, b] = self.mass.map(f64::recip);
        g.copy_from_slice(&[0.0, 0.0, 0.0, 0.0, a, 0.0, 0.0, b]);
    }
}

/// A run, its positions with noise.
fn run(masses: Masses, seed: u64, noise: f64) -> String {
    let mut rng = rng(seed, 0);
    let ranges = |amplitude: f64| SinusoidRanges {
        amplitude: 0.4 * amplitude..=amplitude,
        angular_frequency: 0.5..=6.0,
        phase: 0.0..=std::f64::consts::TAU,
    };
    let t: Vec<f64> = (0..ROWS).map(|k| STEP * k as f64).collect();
    let [one, two] = [3.0, 2.0].map(|amplitude| {
        SumOfSinusoids::random(&mut rng, 1, 5, &ranges(amplitude)).unwrap().sample(&t)
    });
    let u: Vec<f64> = one.iter().zip(&two).flat_map(|(a, b)| [*a, *b]).collect();
    let path = rk4_sampled(&masses, &[0.1, -0.2, 0.0, 0.0], &t, &u, Hold::ZeroOrder, 8).unwrap();
    let [q1, q2] = [0, 1].map(|i| {
        let mut q: Vec<f64> = (0..ROWS).map(|k| path.state(k)[i]).collect();
        add_gaussian_noise(&mut q, noise, &mut rng).unwrap();
        q
    });
    Run::csv(&[("t", &t), ("q1", &q1), ("q2", &q2), ("tau1", &one), ("tau2", &two)])
}

/// The folder with two runs of the simulator and two of a machine.
fn beside(machine: Masses) -> Bench {
    let bench = Bench::new();
    for k in 1..=2 {
        bench.write(&format!("sim{k}.csv"), &run(BELIEVED, k, 0.0));
        bench.write(&format!("run{k}.csv"), &run(machine, 10 + k, 5e-4));
    }
    bench
}

const COMMAND: [&str; 7] =
    ["diagnose", "--simulated", "sim1.csv", "--simulated", "sim2.csv", "run1.csv", "run2.csv"];

fn found(bench: &Bench) -> Value {
    bench.json(&[&COMMAND[..], &["--json", "--out", "found"]].concat())
}

fn differs(found: &Value, name: &str) -> bool {
    let functions = found["functions"].as_array().unwrap();
    let function = functions.iter().find(|f| f["name"] == name).expect(name);
    function["differs"].as_bool().unwrap()
}

#[test]
fn a_concealed_friction_is_named_where_it_acts() {
    let bench = beside(Masses { friction: 1.0, ..BELIEVED });
    let found = found(&bench);
    assert_eq!(
        (&found["verdict"], &found["drift_as"]),
        (&"missing_physics".into(), &"force".into())
    );
    assert!(differs(&found, "force on q1") && !differs(&found, "force on q2"));
    let force = &found["functions"][0];
    assert_eq!(force["depends_on"], serde_json::json!(["dq1"]));
    let findings = found["findings"].as_array().unwrap();
    assert_eq!(
        (&findings[0]["class"], &findings[0]["channel"]),
        (&"coulomb_friction".into(), &"q1".into())
    );
    let magnitude = findings[0]["parameters"]["magnitude"][0].as_f64().unwrap();
    assert!((magnitude - 1.0).abs() < 0.05, "{magnitude}");
    // What is printed is what is written.
    let written = std::fs::read_to_string(bench.path("found/difference.json")).unwrap();
    assert_eq!(serde_json::from_str::<Value>(&written).unwrap(), found);
    let page = std::fs::read_to_string(bench.path("found/difference.html")).unwrap();
    assert!(page.contains("dry (Coulomb) friction") && page.contains("<svg"));
}

#[test]
fn where_nothing_is_concealed_nothing_is_said() {
    let bench = beside(BELIEVED);
    let found = found(&bench);
    assert_eq!(
        (&found["verdict"], &found["findings"]),
        (&"no_mismatch".into(), &serde_json::json!([]))
    );
    let functions = found["functions"].as_array().unwrap();
    assert!(functions.len() == 5 && functions.iter().all(|f| f["differs"] == false), "{found}");
    let quiet = bench.lacuna(&[&COMMAND[..], &["--quiet", "--exit-code"]].concat());
    assert_eq!((quiet.status.code(), stdout(&quiet)), (Some(0), String::new()));
}

#[test]
fn another_inertia_is_told_as_not_separable() {
    let bench = beside(Masses { mass: [1.3, 0.7], ..BELIEVED });
    let output = bench.lacuna(&[&COMMAND[..], &["--exit-code", "--out", "found"]].concat());
    assert_eq!(output.status.code(), Some(1));
    let said = stdout(&output);
    assert!(said.contains("inertia of q1") && said.contains("cannot be separated"), "{said}");
    let written = std::fs::read_to_string(bench.path("found/difference.json")).unwrap();
    let found: Value = serde_json::from_str(&written).unwrap();
    assert_eq!(
        (&found["verdict"], &found["findings"]),
        (&"not_separable".into(), &serde_json::json!([]))
    );
    assert!(differs(&found, "inertia of q1") && !differs(&found, "inertia of q2"));
}

#[test]
fn what_does_not_fit_together_is_refused() {
    let bench = Bench::new();
    bench.write("sim.csv", &run(BELIEVED, 1, 0.0));
    let text = run(BELIEVED, 2, 1e-3);
    bench.write("other.csv", &text.replace("tau2", "torque2"));
    let said = bench.error(&["diagnose", "--simulated", "sim.csv", "other.csv"]);
    assert!(said.contains("other.csv") && said.contains("tau2"), "{said}");
    let said = bench.error(&["diagnose", "--simulated", "sim.csv", "none.csv"]);
    assert!(said.contains("none.csv"), "{said}");
    let said = bench.error(&["diagnose", "model.toml", "sim.csv", "--inputs", "tau1"]);
    assert!(said.contains("--simulated"), "{said}");
    let with_model =
        bench.lacuna(&["diagnose", "--simulated", "sim.csv", "sim.csv", "--learn-remainder"]);
    assert_eq!(with_model.status.code(), Some(2));
}
