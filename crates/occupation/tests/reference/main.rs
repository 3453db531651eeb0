//! The paper's studies beside an independent NumPy solution of its equations (skipped where the data are absent):
//! Gram matrices to 1e-10, outputs to 1e-6, both relative to the largest entry.

mod npz;

use std::fs;
use std::path::Path;

use lacuna_occupation::{
    ExponentialDotProduct, IdentifiedModel, InitialDerivative, Quadrature, Regression,
    TestFunction, TrajectoryData,
};
use npz::{read_npz, reference_folder};

fn regression(settings: &serde_json::Value) -> Regression {
    let order = settings["order"].as_u64().unwrap() as usize;
    Regression {
        kernel: ExponentialDotProduct { mu: settings["mu"].as_f64().unwrap() }.into(),
        order,
        test_function: TestFunction::Endpoint { order },
        quadrature: Quadrature::Simpson,
        lambda: settings["lam"].as_f64().unwrap(),
        initial_derivative: InitialDerivative::ForwardDifference,
        whiten: false,
    }
}

fn trajectories(path: &Path) -> Vec<TrajectoryData> {
    let [x, u, t] = ["X", "U", "t"].map(|name| read_npz(path, name));
    let (states, inputs) = (x.shape[1] * x.shape[2], u.shape[1] * u.shape[2]);
    let pairs = x.values.chunks_exact(states).zip(u.values.chunks_exact(inputs));
    pairs
        .map(|(x, u)| {
            TrajectoryData::new(t.values.clone(), x.to_vec(), u.to_vec(), x.to_vec()).unwrap()
        })
        .collect()
}

/// Largest difference over the largest expected entry.
fn relative_error(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let largest = expected.iter().fold(0.0_f64, |max, value| max.max(value.abs()));
    found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest
}

/// H(x) = [f g] at each point, points x n x (m + 1).
fn outputs(model: &IdentifiedModel, points: &[f64]) -> Vec<f64> {
    let (n, m) = (model.dimension(), model.inputs());
    let (mut f, mut g) = (vec![0.0; n], vec![0.0; n * m]);
    let mut all = Vec::new();
    for point in points.chunks_exact(model.arguments()) {
        model.evaluate(point, &mut f, &mut g).unwrap();
        for i in 0..n {
            all.push(f[i]);
            all.extend_from_slice(&g[i * m..(i + 1) * m]);
        }
    }
    all
}

fn compare(name: &str) {
    let Some(folder) = reference_folder() else { return };
    let index: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(folder.join("index.json")).unwrap()).unwrap();
    let regression = regression(&index[name]);
    let trajectories = trajectories(&folder.join(format!("{name}.npz")));
    let expected =
        |array: &str| read_npz(&folder.join(format!("{name}_expected.npz")), array).values;

    let system = regression.assemble(&trajectories).unwrap();
    let size = system.gram.nrows();
    let gram: Vec<f64> = (0..size * size).map(|k| system.gram[(k / size, k % size)]).collect();
    let gram_error = relative_error(&gram, &expected("G"));
    let output_error = relative_error(
        &outputs(&regression.fit(&trajectories).unwrap(), &expected("P")),
        &expected("H"),
    );
    println!("{name}: Gram {gram_error:.1e}, outputs {output_error:.1e}");
    assert!(gram_error < 1e-10, "{name}: Gram matrix differs by {gram_error:e}");
    assert!(output_error < 1e-6, "{name}: outputs differ by {output_error:e}");
}

#[test]
fn duffing_first_order() {
    compare("duff1");
}

#[test]
fn duffing_second_order_with_the_forward_difference() {
    compare("duff2");
}

#[test]
fn two_link_arm_long_trajectories() {
    compare("robot_a");
}

#[test]
fn two_link_arm_as_in_the_paper() {
    compare("robot_paper");
}
