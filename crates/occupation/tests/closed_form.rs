//! Gram matrices and outputs whose integrals have a closed form.
//!
//! How the cases are made: along x(t) = a + b t with a constant input c, the exponential kernel has the expansion
//!
//! exp(x y / mu) = sum_k x^k y^k / (mu^k k!)
//!
//! so that Gamma(x) = sum_k x^k / (mu^k k!) M_k (1, c) with the moments M_k = int phi (a + b t)^k dt, which are
//! elementary, and G_ab = (1 + c_a c_b) sum_k M_ak M_bk / (mu^k k!). Three trajectories, solved by Cramer's rule.

use lacuna_occupation::{
    ExponentialDotProduct, InitialDerivative, Polynomial, Quadrature, Regression, TestFunction,
    TrajectoryData,
};

const MU: f64 = 5.0;
const LAMBDA: f64 = 1e-3;
const DURATION: f64 = 1.0;
const TERMS: i32 = 40;

/// (a, b, c, q): arguments a + b t, input c, coordinate y = q t^2 / 2 so that y' (0) = 0.
const TRAJECTORIES: [(f64, f64, f64, f64); 3] =
    [(-1.0, 1.5, 0.4, 0.7), (0.5, 1.0, -0.8, -1.1), (1.2, -2.0, 1.0, 0.3)];

/// int_0^T (T - t)^(s-1) (a + b t)^k dt for s = 1, 2.
fn moment(order: usize, (a, b): (f64, f64), k: i32) -> f64 {
    let end = a + b * DURATION;
    let first = (end.powi(k + 1) - a.powi(k + 1)) / (b * f64::from(k + 1));
    if order == 1 {
        return first;
    }
    // T - t = (end - x) / b
    let second = (end.powi(k + 2) - a.powi(k + 2)) / (b * f64::from(k + 2));
    (end * first - second) / b
}

/// 1 / (mu^k k!)
fn feature_weight(k: i32) -> f64 {
    (1..=k).map(|factor| 1.0 / (MU * f64::from(factor))).product()
}

fn expected_gram(order: usize) -> [[f64; 3]; 3] {
    let entry = |(a, b, c, _): (f64, f64, f64, f64), (a2, b2, c2, _): (f64, f64, f64, f64)| {
        let term = |k| moment(order, (a, b), k) * moment(order, (a2, b2), k) * feature_weight(k);
        (1.0 + c * c2) * (0..TERMS).map(term).sum::<f64>()
    };
    TRAJECTORIES.map(|p| TRAJECTORIES.map(|q| entry(p, q)))
}

fn determinant(m: &[[f64; 3]; 3]) -> f64 {
    let minor = |i: usize, j: usize| m[1][i] * m[2][j] - m[1][j] * m[2][i];
    m[0][0] * minor(1, 2) - m[0][1] * minor(0, 2) + m[0][2] * minor(0, 1)
}

fn cramer(matrix: [[f64; 3]; 3], right: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|column| {
        let mut replaced = matrix;
        (0..3).for_each(|row| replaced[row][column] = right[row]);
        determinant(&replaced) / determinant(&matrix)
    })
}

/// f(x) and g(x).
fn expected_output(order: usize, x: f64) -> (f64, f64) {
    let mut matrix = expected_gram(order);
    (0..3).for_each(|a| matrix[a][a] += LAMBDA);
    // y(T) - y(0) - T y'(0) = q T^2 / 2, whether the last term counts (order 2) or not (order 1), as y'(0) = 0
    let weights = cramer(matrix, TRAJECTORIES.map(|(.., q)| q * DURATION * DURATION / 2.0));
    let mut output = (0.0, 0.0);
    for ((a, b, c, _), weight) in TRAJECTORIES.into_iter().zip(weights) {
        let kernel: f64 =
            (0..TERMS).map(|k| moment(order, (a, b), k) * x.powi(k) * feature_weight(k)).sum();
        output.0 += weight * kernel;
        output.1 += weight * kernel * c;
    }
    output
}

fn trajectories() -> Vec<TrajectoryData> {
    let times: Vec<f64> = (0..=200).map(|k| DURATION * f64::from(k) / 200.0).collect();
    let make = |(a, b, c, q): (f64, f64, f64, f64)| {
        let arguments = times.iter().map(|t| a + b * t).collect();
        let coordinates = times.iter().map(|t| 0.5 * q * t * t).collect();
        let data = TrajectoryData::new(times.clone(), arguments, vec![c; times.len()], coordinates)
            .unwrap();
        data.with_initial_derivatives(vec![0.0]).unwrap()
    };
    TRAJECTORIES.into_iter().map(make).collect()
}

fn compare(order: usize) {
    let regression = Regression {
        kernel: ExponentialDotProduct { mu: MU }.into(),
        order,
        test_function: TestFunction::Endpoint { order },
        quadrature: Quadrature::Simpson,
        lambda: LAMBDA,
        initial_derivative: InitialDerivative::Given,
        whiten: false,
    };
    let trajectories = trajectories();
    let system = regression.assemble(&trajectories).unwrap();
    let gram = expected_gram(order);
    for (a, row) in gram.iter().enumerate() {
        for (b, expected) in row.iter().enumerate() {
            // Simpson's rule on 200 intervals: 1e-11.
            assert!(
                (system.gram[(a, b)] - expected).abs() < 1e-10 * row[a],
                "order {order}, ({a}, {b})"
            );
        }
    }
    let model = regression.fit(&trajectories).unwrap();
    for x in [-1.0, 0.0, 0.3, 1.7] {
        let (mut f, mut g) = ([0.0], [0.0]);
        model.evaluate(&[x], &mut f, &mut g).unwrap();
        let (expected_f, expected_g) = expected_output(order, x);
        assert!((f[0] - expected_f).abs() < 1e-8, "f({x}) = {}, expected {expected_f}", f[0]);
        assert!((g[0] - expected_g).abs() < 1e-8, "g({x}) = {}, expected {expected_g}", g[0]);
    }
}

#[test]
fn first_order_exponential_kernel() {
    compare(1);
}

#[test]
fn second_order_exponential_kernel() {
    compare(2);
}

/// Compact test function, polynomial kernel (1 + x y)^2 = 1 + 2 x y + x^2 y^2 and arguments x = a + b tau over one
/// window: the moments are int (1 - tau^2)^4 tau^j dtau = 256/315, 0, 256/3465 times half the width of 0.5 s.
#[test]
fn compact_windows_and_a_polynomial_kernel() {
    let moments = |a: f64, b: f64| -> [f64; 3] {
        let (zeroth, second) = (256.0 / 315.0 * 0.5, 256.0 / 3465.0 * 0.5);
        [zeroth, a * zeroth, a * a * zeroth + b * b * second]
    };
    let times: Vec<f64> = (0..=20).map(|k| 0.05 * f64::from(k)).collect();
    let lines = [(0.3, 1.1, 0.5), (-0.7, 0.4, -2.0)];
    let make = |(a, b, c): (f64, f64, f64)| {
        let x: Vec<f64> = times.iter().map(|t| a + b * (2.0 * t - 1.0)).collect();
        TrajectoryData::new(times.clone(), x.clone(), vec![c; 21], x).unwrap()
    };
    let regression = Regression {
        kernel: Polynomial { degree: 2, offset: 1.0, scale: 1.0 }.into(),
        order: 1,
        test_function: TestFunction::Compact { exponent: 4, width: 1.0, stride: 1 },
        quadrature: Quadrature::Trapezoid,
        lambda: LAMBDA,
        initial_derivative: InitialDerivative::default(),
        whiten: false,
    };
    let system = regression.assemble(&lines.map(make)).unwrap();
    for (p, (a, b, c)) in lines.into_iter().enumerate() {
        for (q, (a2, b2, c2)) in lines.into_iter().enumerate() {
            let (left, right) = (moments(a, b), moments(a2, b2));
            let kernel = left[0] * right[0] + 2.0 * left[1] * right[1] + left[2] * right[2];
            let expected = (1.0 + c * c2) * kernel;
            assert!(
                (system.gram[(p, q)] - expected).abs() < 1e-14,
                "{} {expected}",
                system.gram[(p, q)]
            );
        }
        // -int phi' x dt = int phi x' dt, x' = 2 b
        let expected = 2.0 * b * moments(a, b)[0];
        assert!((system.right_hand_sides[(p, 0)] - expected).abs() < 1e-14);
    }
}
