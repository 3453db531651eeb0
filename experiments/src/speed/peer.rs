//! The same algorithms in NumPy: a script that reads the same data.

use lacuna_occupation::TrajectoryData;
use serde::Deserialize;
use serde_json::json;
use std::path::Path;
use std::process::Command;

use super::{LAMBDA, MU};

/// Seconds of the peer's work, on one thread.
pub struct Peer {
    /// One kernel value of a sum.
    pub kernel_sums: f64,
    /// A fit of the arm.
    pub fit: f64,
    /// f and g of the arm at one state.
    pub evaluation: f64,
    /// A fit of a Duffing trial by the paper's recipe.
    pub duffing: f64,
}

#[derive(Deserialize)]
struct Answer {
    seconds: Seconds,
}

#[derive(Deserialize)]
struct Seconds {
    kernel_sums: f64,
    fit: f64,
    evaluation: f64,
    duffing: f64,
}

impl Peer {
    /// Runs the script.
    ///
    /// # Errors
    /// Why there is nothing to compare with: no Python, no NumPy, no script.
    pub fn measure(
        script: &Path,
        arm: &[TrajectoryData],
        duffing: &[TrajectoryData],
        states: &[[f64; 4]],
    ) -> Result<Self, String> {
        if !script.is_file() {
            return Err(format!("{}: no such script", script.display()));
        }
        let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
        write(folder.path(), arm, duffing, states).map_err(|e| e.to_string())?;
        let output = Command::new("python3")
            .arg(script)
            .arg(folder.path())
            .output()
            .map_err(|e| format!("python3: {e}"))?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            let last = said.lines().last().unwrap_or("failed").to_owned();
            return Err(format!("{}: {last}", script.display()));
        }
        let answer: Answer =
            serde_json::from_slice(&output.stdout).map_err(|e| format!("its answer: {e}"))?;
        let Seconds { kernel_sums, fit, evaluation, duffing } = answer.seconds;
        Ok(Self { kernel_sums, fit, evaluation, duffing })
    }
}

/// The data, as 64-bit floats, and what they are.
fn write(
    folder: &Path,
    arm: &[TrajectoryData],
    duffing: &[TrajectoryData],
    states: &[[f64; 4]],
) -> std::io::Result<()> {
    let floats = |name: &str, values: Vec<f64>| {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        std::fs::write(folder.join(format!("{name}.f64")), bytes)
    };
    let mut arrays = serde_json::Map::new();
    for (name, data) in [("arm", arm), ("duffing", duffing)] {
        let (count, samples) = (data.len(), data[0].samples());
        let states = data.iter().flat_map(|d| d.arguments()).copied().collect();
        let inputs = data.iter().flat_map(|d| d.inputs()).copied().collect();
        floats(&format!("{name}_states"), states)?;
        floats(&format!("{name}_inputs"), inputs)?;
        let shape = |columns: usize| json!([count, samples, columns]);
        arrays.insert(format!("{name}_states"), shape(data[0].argument_count()));
        arrays.insert(format!("{name}_inputs"), shape(data[0].input_count()));
    }
    floats("at", states.iter().flatten().copied().collect())?;
    arrays.insert("at".to_owned(), json!([states.len(), 4]));
    let step = |data: &TrajectoryData| data.times()[1] - data.times()[0];
    let about = json!({
        "arrays": arrays, "mu": MU, "lambda": LAMBDA,
        "arm_step": step(&arm[0]), "duffing_step": step(&duffing[0]),
    });
    std::fs::write(folder.join("speed.json"), about.to_string())
}
