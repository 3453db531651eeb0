//! Which machines are unlike the others.
//!
//! A machine's p-value is the smallest of its quantities' times their number (Bonferroni). Machines are called
//! unlike by the rule of Benjamini and Hochberg: with the p-values in order, all up to the last k with
//!
//! ```text
//! p_(k) <= 0.01 k / n
//! ```
//!
//! so that of those called unlike 1 % at most are not, on average; in a fleet where none is, one is called so in
//! one fleet of a hundred at most.

use super::quantities::Quantity;
use serde::Serialize;
use std::collections::BTreeMap;

/// Share of machines called unlike that are not, on average and at most.
pub const FALSE_RATE: f64 = 0.01;

/// A quantity in which a machine is unlike the others.
#[derive(Clone, Debug, Serialize)]
pub struct Reason {
    /// Its name.
    pub quantity: String,
    /// The p-value in it.
    pub p: f64,
    /// In words, with numbers.
    pub says: String,
}

/// A machine that is unlike the others.
#[derive(Clone, Debug, Serialize)]
pub struct Unlike {
    /// The machine.
    pub machine: String,
    /// Its p-value, over all of its quantities.
    pub p: f64,
    /// In what, the clearest first.
    pub because: Vec<Reason>,
}

/// The machines that are unlike the others, the clearest first; `says` puts a machine in a quantity into words.
pub(super) fn unlike(
    quantities: &[Quantity],
    says: impl Fn(&Quantity, usize) -> String,
) -> Vec<Unlike> {
    let mut by_machine: BTreeMap<&str, Vec<(f64, &Quantity, usize)>> = BTreeMap::new();
    for q in quantities {
        for (k, v) in q.values.iter().enumerate() {
            if let Some(p) = v.p {
                by_machine.entry(&v.machine).or_default().push((p, q, k));
            }
        }
    }
    let whole = |all: &[(f64, &Quantity, usize)]| {
        (all.len() as f64 * all.iter().fold(1.0, |least: f64, one| least.min(one.0))).min(1.0)
    };
    let mut machines: Vec<(f64, &str)> =
        by_machine.iter().map(|(name, all)| (whole(all), *name)).collect();
    machines.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(b.1)));
    let n = machines.len() as f64;
    let level = |k: usize| FALSE_RATE * (k + 1) as f64 / n;
    let last = (0..machines.len()).rev().find(|&k| machines[k].0 <= level(k));
    let limit = last.map_or(0.0, level);
    let machine = |&(p, name): &(f64, &str)| {
        let all = &by_machine[name];
        let mut out: Vec<_> = all.iter().filter(|one| one.0 * all.len() as f64 <= limit).collect();
        out.sort_by(|a, b| a.0.total_cmp(&b.0));
        let reason = |one: &&(f64, &Quantity, usize)| Reason {
            quantity: one.1.name.clone(),
            p: one.0,
            says: says(one.1, one.2),
        };
        Unlike { machine: name.to_owned(), p, because: out.iter().map(reason).collect() }
    };
    machines[..last.map_or(0, |k| k + 1)].iter().map(machine).collect()
}

#[cfg(test)]
mod tests {
    use super::super::quantities::{Sort, Value};
    use super::*;

    fn quantity(name: &str, p: &[f64]) -> Quantity {
        let value = |(m, &p): (usize, &f64)| {
            let machine = format!("m{m:02}");
            Value { machine, value: 0.0, std: 1.0, found: true, p: Some(p) }
        };
        Quantity {
            sort: Sort::Size,
            name: name.to_owned(),
            unit: String::new(),
            mean: None,
            mean_std: None,
            spread: None,
            values: p.iter().enumerate().map(value).collect(),
        }
    }

    #[test]
    fn machines_are_called_unlike_at_the_rate_that_is_promised() {
        let (mut a, mut b) = (vec![0.5; 20], vec![0.3; 20]);
        (a[3], b[3], b[7]) = (1e-9, 1e-5, 4e-4);
        let found =
            unlike(&[quantity("a", &a), quantity("b", &b)], |q, k| format!("{} {k}", q.name));
        let names: Vec<&str> = found.iter().map(|u| &*u.machine).collect();
        // 2 x 4e-4 is within 0.01 x 2 / 20, though not within 0.01 / 20.
        assert_eq!(names, ["m03", "m07"]);
        let says: Vec<&str> = found[0].because.iter().map(|r| &*r.says).collect();
        assert_eq!((says, found[0].p), (vec!["a 3", "b 3"], 2e-9));
        a[3] = 0.5;
        b[3] = 0.5;
        assert!(unlike(&[quantity("a", &a), quantity("b", &b)], |_, _| String::new()).is_empty());
    }
}
