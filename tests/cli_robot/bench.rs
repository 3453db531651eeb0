//! A robot, what would be recorded of it, and the commands.

use lacuna::excitation::{SinusoidRanges, SumOfSinusoids, add_gaussian_noise, rng};
use lacuna::plants::{Model, SampledInput, System, rk4};
use serde_json::Value;
use std::fmt::Write;
use std::path::PathBuf;
use std::process::{Command, Output};

pub const ARM: &str = r#"<robot name="arm">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0 0 -0.15"/><mass value="1.5"/>
    <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.003"/></inertial></link>
  <link name="lower"><inertial><origin xyz="0 0 -0.1"/><mass value="0.8"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.001"/></inertial></link>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/>
    <axis xyz="0 1 0"/><dynamics damping="0.6"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
    <origin xyz="0 0 -0.3"/><axis xyz="0 1 0"/><dynamics damping="0.3"/></joint>
</robot>
"#;
/// The same arm.
pub const MJCF: &str = r#"<mujoco model="arm">
  <default><joint type="hinge" axis="0 1 0" damping="0.3"/></default>
  <worldbody>
    <body name="upper">
      <joint name="shoulder" damping="0.6"/>
      <inertial pos="0 0 -0.15" mass="1.5" diaginertia="0.02 0.02 0.003"/>
      <body name="lower" pos="0 0 -0.3">
        <joint name="elbow"/>
        <inertial pos="0 0 -0.1" mass="0.8" diaginertia="0.01 0.01 0.001"/>
      </body>
    </body>
  </worldbody>
  <actuator><motor joint="shoulder" gear="50"/><motor joint="elbow" gear="50"/></actuator>
</mujoco>
"#;
pub const FRICTION: &str = "class = \"coulomb_friction\"\nchannel = \"elbow\"\nmagnitude = 0.35\nsmoothing_velocity = 0.01\n";

pub struct Bench {
    folder: tempfile::TempDir,
    /// Standard deviation of what is recorded of the torques, N m.
    torque_noise: f64,
}

impl Bench {
    /// The arm with an effect, if there is any.
    pub fn new(effect: &str) -> Self {
        Self::of(ARM, effect, 0.0)
    }

    /// An arm with an effect, whose torques are recorded with noise.
    pub fn of(arm: &str, effect: &str, torque_noise: f64) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let bench = Self { folder, torque_noise };
        std::fs::write(bench.path("arm.urdf"), arm).expect("a file");
        std::fs::write(bench.path("arm.xml"), MJCF).expect("a file");
        let effect = if effect.is_empty() { "" } else { &format!("[[effect]]\n{effect}") };
        let truth = format!("name = \"truth\"\n[robot]\nfile = \"arm.urdf\"\n{effect}");
        std::fs::write(bench.path("truth.toml"), truth).expect("a file");
        bench
    }

    pub fn path(&self, file: &str) -> PathBuf {
        self.folder.path().join(file)
    }

    /// What encoders and motors would record of the arm with its friction.
    pub fn record(&self, run: u64) -> String {
        let truth = Model::read(&self.path("truth.toml")).expect("a model");
        let mut rng = rng(77, run);
        let ranges = SinusoidRanges {
            amplitude: 0.3..=1.2,
            angular_frequency: 0.7..=7.0,
            phase: 0.0..=std::f64::consts::TAU,
        };
        let times: Vec<f64> = (0..600).map(|k| 0.01 * f64::from(k)).collect();
        let drive = SumOfSinusoids::random(&mut rng, 2, 4, &ranges).expect("ranges");
        let mut torques = drive.sample(&times);
        let input = SampledInput { times: &times, values: &torques, hold: truth.hold };
        let system = System::new(&truth);
        let motion = rk4(&system, &system.at_rest(&[0.1, -0.2, 0.0, 0.0]), &input, &times, 5e-4)
            .expect("it does not diverge");
        let mut columns = vec![];
        for joint in 0..2 {
            let mut angles: Vec<f64> = (0..times.len()).map(|k| motion.state(k)[joint]).collect();
            add_gaussian_noise(&mut angles, 5e-4, &mut rng).expect("a deviation");
            columns.push(angles);
        }
        if self.torque_noise > 0.0 {
            add_gaussian_noise(&mut torques, self.torque_noise, &mut rng).expect("a deviation");
        }
        self.write((&format!("run{run}.csv"), &truth), &times, &columns, &torques)
    }

    /// A recording: angles joint by joint, torques sample by sample.
    fn write(
        &self,
        (name, truth): (&str, &Model),
        times: &[f64],
        angles: &[Vec<f64>],
        torques: &[f64],
    ) -> String {
        let [first, second] = [0, 1].map(|joint| truth.inputs[joint].name.clone());
        let mut text = format!("t,shoulder,elbow,{first},{second}\n");
        for (k, t) in times.iter().enumerate() {
            let (a, b) = (angles[0][k], angles[1][k]);
            writeln!(text, "{t},{a},{b},{},{}", torques[2 * k], torques[2 * k + 1]).expect("text");
        }
        std::fs::write(self.path(name), text).expect("a file");
        name.to_owned()
    }

    /// What would be recorded of the arm held upright, about whose place it moves slowly, by a controller that
    /// knows nothing of its weight: without it the arm falls.
    fn record_upright(&self, run: u64) -> String {
        const STEP: f64 = 0.01;
        let truth = Model::read(&self.path("truth.toml")).expect("a model");
        let mut rng = rng(78, run);
        let ranges = SinusoidRanges {
            amplitude: 0.05..=0.2,
            angular_frequency: 0.7..=4.0,
            phase: 0.0..=std::f64::consts::TAU,
        };
        let times: Vec<f64> = (0..600).map(|k| STEP * f64::from(k)).collect();
        let wanted =
            SumOfSinusoids::random(&mut rng, 2, 3, &ranges).expect("ranges").sample(&times);
        let system = System::new(&truth);
        let mut state = system.at_rest(&[std::f64::consts::PI, 0.0, 0.0, 0.0]);
        let (mut angles, mut torques) = ([vec![], vec![]], vec![]);
        for (k, t) in times.iter().enumerate() {
            let off = |j: usize| wanted[2 * k + j] + [std::f64::consts::PI, 0.0][j] - state[j];
            let torque = |j: usize| [40.0, 8.0][j] * off(j) - [5.0, 0.3][j] * state[2 + j];
            let held = [torque(0), torque(1)];
            (0..2).for_each(|j| angles[j].push(state[j]));
            torques.extend(held);
            let (span, values) = ([*t, *t + STEP], [held, held].concat());
            let input = SampledInput { times: &span, values: &values, hold: truth.hold };
            let step = rk4(&system, &state, &input, &span, 1e-3).expect("it does not diverge");
            state = step.state(1).to_vec();
        }
        for joint in &mut angles {
            add_gaussian_noise(joint, 5e-4, &mut rng).expect("a deviation");
        }
        self.write((&format!("upright{run}.csv"), &truth), &times, &angles, &torques)
    }

    pub fn run(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lacuna"));
        command.args(arguments).current_dir(self.folder.path()).output().expect("it runs")
    }

    /// What `diagnose` writes of three recordings, with a fourth held out.
    pub fn diagnosed(&self) -> Value {
        let runs: Vec<String> = (0..4).map(|run| self.record(run)).collect();
        self.diagnosed_of("arm.urdf", &runs)
    }

    /// The same of the arm held upright, torques as the controller holds them from sample to sample.
    pub fn diagnosed_upright(&self) -> Value {
        let held = "name = \"arm\"\n[robot]\nfile = \"arm.urdf\"\n[recordings]\ninput_hold = \"zero-order\"\n";
        std::fs::write(self.path("held.toml"), held).expect("a file");
        let runs: Vec<String> = (0..4).map(|run| self.record_upright(run)).collect();
        self.diagnosed_of("held.toml", &runs)
    }

    /// The same of recordings of which the last is held out.
    fn diagnosed_of(&self, model: &str, runs: &[String]) -> Value {
        let (held_out, training) = runs.split_last().expect("recordings");
        let mut arguments = vec!["diagnose", model];
        arguments.extend(training.iter().map(String::as_str));
        arguments.extend(["--held-out", held_out, "--out", "found"]);
        self.says(&arguments);
        let text = std::fs::read_to_string(self.path("found/diagnosis.json"));
        serde_json::from_str(&text.expect("it is written")).expect("JSON")
    }

    /// Error of a model at the elbow on a recording, rad.
    pub fn error(&self, model: &str, run: &str) -> f64 {
        let said = self.says(&["simulate", model, "--like", run, "--horizon", "1", "--json"]);
        let said: Value = serde_json::from_str(&said).expect("JSON");
        said["channels"]["elbow"]["rmse"].as_f64().expect("a number")
    }

    /// What was diagnosed predicts what was held out, so many times better than the arm's own file.
    pub fn assert_predicts(&self, times: f64) {
        let error = |model| self.error(model, "run3.csv");
        let (before, after) = (error("arm.urdf"), error("found/augmented.toml"));
        assert!(after < 6e-4 && before > times * after, "{before} {after}");
    }

    pub fn says(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("text")
    }
}
