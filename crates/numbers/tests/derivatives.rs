//! Derivatives that dual numbers carry against central differences of plain ones.

use lacuna_numbers::{Dual, LANES, Number};

/// A function of one number, in plain and in dual numbers.
macro_rules! function {
    ($name:literal, $x:ident => $formula:expr) => {{
        fn of<T: Number>($x: T) -> T {
            $formula
        }
        ($name, of::<f64> as fn(f64) -> f64, of::<Dual> as fn(Dual) -> Dual)
    }};
}

#[test]
fn functions_of_one_number_carry_their_derivative() {
    let functions = [
        function!("sin", x => x.sin()),
        function!("cos", x => x.cos()),
        function!("tan", x => x.tan()),
        function!("asin", x => x.asin()),
        function!("acos", x => x.acos()),
        function!("atan", x => x.atan()),
        function!("sinh", x => x.sinh()),
        function!("cosh", x => x.cosh()),
        function!("tanh", x => x.tanh()),
        function!("exp", x => x.exp()),
        function!("exp_m1", x => x.exp_m1()),
        function!("ln", x => x.ln()),
        function!("sqrt", x => x.sqrt()),
        function!("powi", x => x.powi(-3)),
        function!("abs", x => (-x).abs()),
        function!("sign", x => x.sign()),
        function!("constants", x => ((x + 1.5) * 3.0 - 0.2) / 0.7),
        function!("clamp", x => (x * 2.0).clamp(T::constant(-1.0), x + 0.1)),
    ];
    let (x, h) = (0.37, 1e-6);
    for (name, plain, dual) in functions {
        let found = dual(Dual::direction(x, 3));
        let difference = (plain(x + h) - plain(x - h)) / (2.0 * h);
        assert_eq!(found.value.to_bits(), plain(x).to_bits(), "{name}");
        assert!((found.tangent[3] - difference).abs() < 1e-8 * difference.abs().max(1.0), "{name}");
        assert!((0..LANES).all(|l| l == 3 || found.tangent[l] == 0.0), "{name}");
    }
}

macro_rules! pair {
    ($name:literal, $a:ident, $b:ident => $formula:expr) => {{
        fn of<T: Number>($a: T, $b: T) -> T {
            $formula
        }
        ($name, of::<f64> as fn(f64, f64) -> f64, of::<Dual> as fn(Dual, Dual) -> Dual)
    }};
}

#[test]
fn functions_of_two_numbers_carry_both_derivatives() {
    let functions = [
        pair!("add", a, b => a + b),
        pair!("subtract", a, b => a - b),
        pair!("multiply", a, b => a * b),
        pair!("divide", a, b => a / b),
        pair!("powf", a, b => a.powf(b)),
        pair!("atan2", a, b => a.atan2(b)),
        pair!("min", a, b => a.min(b)),
        pair!("max", a, b => a.max(b)),
    ];
    let (h, a, b) = (1e-6, 0.8, 1.7);
    for (name, plain, dual) in functions {
        let found = dual(Dual::direction(a, 0), Dual::direction(b, 7));
        let by_a = (plain(a + h, b) - plain(a - h, b)) / (2.0 * h);
        let by_b = (plain(a, b + h) - plain(a, b - h)) / (2.0 * h);
        assert_eq!(found.value, plain(a, b), "{name}");
        assert!((found.tangent[0] - by_a).abs() < 1e-8, "{name}");
        assert!((found.tangent[7] - by_b).abs() < 1e-8, "{name}");
    }
}

/// At a kink the derivative is that to the right; a root at 0 has none.
#[test]
fn kinks_have_the_derivative_to_their_right() {
    let zero = Dual::direction(0.0, 0);
    assert_eq!(zero.abs().tangent[0], 1.0);
    assert_eq!(zero.max(Dual::constant(0.0)).tangent[0], 1.0);
    assert_eq!(zero.sign().value, 0.0);
    assert_eq!(zero.sqrt().tangent[0], 0.0);
    let edge = Dual::direction(1.0, 0);
    assert_eq!(edge.clamp(-edge, edge).tangent[0], 1.0);
    assert_eq!(Dual::constant(2.0).clamp(-edge, edge).tangent[0], 1.0);
    // An exponent that is constant needs no logarithm of a negative base.
    let square = Dual::direction(-1.5, 0).powf(Dual::constant(2.0));
    assert_eq!((square.value, square.tangent[0]), (2.25, -3.0));
}

#[test]
fn a_function_given_by_value_and_slope_obeys_the_chain_rule() {
    let x = Dual { value: 2.0, tangent: std::array::from_fn(|l| l as f64) };
    let y = x.mapped(5.0, -3.0);
    assert_eq!(y.value(), 5.0);
    assert_eq!(y.tangent, std::array::from_fn::<f64, LANES, _>(|l| -3.0 * l as f64));
    assert_eq!(2.0f64.mapped(5.0, -3.0), 5.0);
}
