//! Simulations against an independent integrator: `Dopri5` of the crate `ode_solvers`.
//!
//! Of that crate (0.6.2) `Dop853` evaluates explicit time dependence at wrong nodes, and the last
//! row of dense output can be wrong: time is carried as one more state, only sparse output is
//! read, and each interval in which the input is smooth is integrated on its own.

use lacuna_plants::model::StepInput;
use lacuna_plants::{Hold, Model, Plant, Substeps, System as Simulated};
use ode_solvers::{DVector, Dopri5, OutputType, System};

/// A driven arm that depends on time explicitly, and a tank whose level nothing else feels.
const MODEL: &str = r#"
name = "bench"
[[input]]
name = "u"
unit = "N m"
[[coordinate]]
name = "a"
velocity = "da"
unit = "rad"
[[coordinate]]
name = "b"
velocity = "db"
unit = "rad"
[mechanics]
mass = [["1.4 + 0.3*cos(b)", "0.2 + 0.15*cos(b)"], ["0.2 + 0.15*cos(b)", "0.2"]]
force = ["u - 0.5*da - 2*sin(a) + 0.7*t*sin(4*t^2)", "-0.1*db - sin(a + b)"]
[[state]]
name = "h"
unit = "m"
derivative = "0.3*cos(5*t) - 0.4*h + 0.1*u"
[[effect]]
class = "viscoelastic"
channel = "a"
stiffness = 1.5
time_constant = 0.2
"#;

const STEP: f64 = 0.05;
const SAMPLES: usize = 60;
const START: [f64; 5] = [0.5, -0.4, 0.0, 1.0, 0.3];

/// The plant over one interval; the last state is the time.
struct WithTime<'a> {
    plant: &'a Simulated,
    from: f64,
    here: f64,
    slope: f64,
}

impl System<f64, DVector<f64>> for WithTime<'_> {
    fn system(&self, _t: f64, y: &DVector<f64>, dy: &mut DVector<f64>) {
        let width = y.len() - 1;
        let t = y[width];
        let u = [self.here + self.slope * (t - self.from)];
        self.plant.derivative(t, &y.as_slice()[..width], &u, &mut dy.as_mut_slice()[..width]);
        dy[width] = 1.0;
    }
}

fn input(k: usize) -> f64 {
    3.0 * (1.3 * k as f64).sin()
}

fn next(k: usize, hold: Hold) -> f64 {
    input(if hold == Hold::Linear { k + 1 } else { k })
}

/// The state at every sample by `Dopri5`.
fn oracle(plant: &Simulated, hold: Hold) -> Vec<Vec<f64>> {
    let mut states = vec![plant.at_rest(&START)];
    for k in 0..SAMPLES {
        let (from, to) = (STEP * k as f64, STEP * (k + 1) as f64);
        let (here, slope) = (input(k), (next(k, hold) - input(k)) / STEP);
        let x = DVector::from_column_slice(&states[k]);
        let start = x.clone().insert_row(x.len(), from);
        let system = WithTime { plant, from, here, slope };
        let mut solver = Dopri5::new(system, from, to, to - from, start, 1e-12, 1e-13);
        solver.set_output(OutputType::Sparse);
        solver.integrate().expect("the oracle integrates");
        let last = solver.y_out().last().expect("an output");
        assert!((last[x.len()] - to).abs() < 1e-12, "it ended at the sample");
        states.push(last.as_slice()[..x.len()].to_vec());
    }
    states
}

/// Largest difference between our steps and the oracle.
fn error(plant: &Simulated, hold: Hold, substeps: usize, oracle: &[Vec<f64>]) -> f64 {
    let (mut x, mut room) = (plant.at_rest(&START), plant.workspace());
    let mut worst = 0.0f64;
    for (k, expected) in oracle[1..].iter().enumerate() {
        let times = (STEP * k as f64, STEP * (k + 1) as f64);
        plant.advance(
            &mut room,
            times,
            StepInput::Line(&[input(k)], &[next(k, hold)]),
            Substeps::even(substeps),
            &mut x,
        );
        for (found, expected) in x.iter().zip(expected) {
            worst = worst.max((found - expected).abs());
        }
    }
    worst
}

#[test]
fn simulations_agree_with_dormand_and_prince_and_converge_in_order_four() {
    let model = Model::from_text(MODEL, "bench.toml").unwrap_or_else(|e| panic!("{e}"));
    let plant = Simulated::new(&model);
    for hold in [Hold::ZeroOrder, Hold::Linear] {
        let oracle = oracle(&plant, hold);
        assert!(oracle[SAMPLES].iter().all(|x| x.abs() > 1e-3), "it moves");
        let (coarse, fine) = (error(&plant, hold, 4, &oracle), error(&plant, hold, 8, &oracle));
        assert!(fine < 1e-7, "{hold:?}: {fine}");
        // Halved steps: a sixteenth of the error.
        assert!((12.0..20.0).contains(&(coarse / fine)), "{hold:?}: {coarse} {fine}");
    }
}
