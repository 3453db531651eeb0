//! The shape of a learned curve in words.

use crate::diagnosis::Curve;

/// Share of a curve's energy above which it counts as even, or odd.
const PURE: f64 = 0.9;
/// Share of its largest force below which a curve does not act.
const QUIET: f64 = 0.1;

/// What a curve looks like: where it acts, its symmetry, how it grows, whether it opposes motion.
pub(crate) fn shape(curve: &Curve, over_velocity: bool) -> String {
    let mut words = Vec::new();
    let largest = curve.learned.iter().fold(0.0f64, |a, f| a.max(f.abs()));
    if let Some((a, b)) = local(curve, largest) {
        words.push(format!(
            "it acts only where {} is between {a:.3} and {b:.3} {}",
            curve.variable, curve.variable_unit
        ));
    }
    words.extend(symmetry(curve).map(str::to_owned));
    words.extend(growth(curve).map(str::to_owned));
    if over_velocity {
        let power = || curve.at.iter().zip(&curve.learned).map(|(v, f)| v * f);
        if power().sum::<f64>() < -PURE * power().map(f64::abs).sum::<f64>() {
            words.push("it opposes the motion, as friction does".to_owned());
        }
    }
    if words.is_empty() {
        words.push("it has no simple symmetry".to_owned());
    }
    words.join("; ")
}

/// The part of the range in which the curve acts, where that is less than half of it.
fn local(curve: &Curve, largest: f64) -> Option<(f64, f64)> {
    let acts = || curve.at.iter().zip(&curve.learned).filter(|(_, f)| f.abs() > QUIET * largest);
    let (a, b) = (*acts().next()?.0, *acts().next_back()?.0);
    let range = curve.at[curve.at.len() - 1] - curve.at[0];
    (b - a < 0.5 * range).then_some((a, b))
}

/// Odd or even about zero, where the range covers both signs.
fn symmetry(curve: &Curve) -> Option<&'static str> {
    let (low, high) = (curve.at[0], curve.at[curve.at.len() - 1]);
    let reach = high.min(-low);
    if reach < 0.3 * high.max(-low) {
        return None;
    }
    let at = |x: f64| {
        let place = (x - low) / (high - low) * (curve.at.len() - 1) as f64;
        let k = (place.floor() as usize).min(curve.at.len() - 2);
        let share = place - k as f64;
        curve.learned[k] + share * (curve.learned[k + 1] - curve.learned[k])
    };
    let (mut odd, mut even) = (0.0, 0.0);
    for k in 1..=40 {
        let x = reach * f64::from(k) / 40.0;
        odd += (0.5 * (at(x) - at(-x))).powi(2);
        even += (0.5 * (at(x) + at(-x))).powi(2);
    }
    let all = odd + even;
    if odd > PURE * all {
        Some("odd: it changes its sign with the variable")
    } else if even > PURE * all {
        Some("even: the same on both sides of zero")
    } else {
        None
    }
}

/// Whether it saturates, or grows ever faster, towards the ends of the range.
fn growth(curve: &Curve) -> Option<&'static str> {
    let n = curve.at.len();
    let slope = |from: usize, to: usize| {
        let rise: f64 = (from..to).map(|k| (curve.learned[k + 1] - curve.learned[k]).abs()).sum();
        rise / (curve.at[to] - curve.at[from])
    };
    let inner = slope(3 * n / 8, 5 * n / 8);
    let outer = 0.5 * (slope(0, n / 4) + slope(3 * n / 4, n - 1));
    if outer < 0.25 * inner {
        Some("it saturates")
    } else if outer > 3.0 * inner {
        Some("it grows ever faster away from the middle")
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::shape;
    use crate::diagnosis::Curve;

    fn curve(force: impl Fn(f64) -> f64) -> Curve {
        let at: Vec<f64> = (0..96).map(|k| -1.0 + 2.0 * f64::from(k) / 95.0).collect();
        let learned: Vec<f64> = at.iter().map(|&x| force(x)).collect();
        Curve {
            variable: "q".into(),
            variable_unit: "rad".into(),
            force_unit: "N m".into(),
            std: vec![0.0; at.len()],
            law: learned.clone(),
            at,
            learned,
        }
    }

    #[test]
    fn shapes_are_told_apart() {
        let friction = shape(&curve(|v| -(10.0 * v).tanh()), true);
        assert!(friction.contains("odd") && friction.contains("saturates"), "{friction}");
        assert!(friction.contains("opposes the motion"), "{friction}");
        let bump = shape(&curve(|q| (-(q - 0.5f64).powi(2) / 0.005).exp()), false);
        assert!(bump.contains("acts only where q is between"), "{bump}");
        assert!(shape(&curve(|q| q * q), false).contains("even"));
        assert!(shape(&curve(|q| -q.powi(5)), false).contains("ever faster"));
    }
}
