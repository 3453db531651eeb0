//! Terms as products of an outer and an inner one, in blocks of eight.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use lacuna_realtime::{LANES, Products};

use super::fit::{Fit, Term};

/// Coefficients of one function in blocks.
pub(crate) type Blocks = BTreeMap<[u16; 2], [f64; LANES]>;

/// Where terms stand.
#[derive(Debug, Clone)]
pub(crate) struct Layout {
    /// Highest degree in each argument.
    pub degrees: Vec<u16>,
    pub outer: Vec<Term>,
    /// A multiple of eight; what fills up is empty.
    pub inner: Vec<Term>,
    /// Arguments of outer products, the others being those of inner ones.
    is_outer: Vec<bool>,
    at_outer: HashMap<Term, u16>,
    at_inner: HashMap<Term, u16>,
}

impl Layout {
    /// For all terms of the fits, each of which has as many arguments.
    pub fn new(fits: &[Fit], arguments: usize) -> Self {
        let terms = || fits.iter().flat_map(|fit| &fit.terms);
        let highest = |i: usize| terms().map(|t| u16::from(t[i])).max().unwrap_or(0);
        let degrees: Vec<u16> = (0..arguments).map(highest).collect();
        let used: Vec<usize> = (0..arguments).filter(|&i| degrees[i] > 0).collect();
        let is_outer: Vec<bool> =
            (0..arguments).map(|i| used[..used.len() / 2].contains(&i)).collect();
        let part = |term: &Term, outer: bool| -> Term {
            let entries = term.iter().zip(&is_outer);
            entries.map(|(k, is)| if *is == outer { *k } else { 0 }).collect()
        };
        let table = |outer: bool| {
            let mut parts: BTreeSet<Term> = terms().map(|t| part(t, outer)).collect();
            for term in parts.clone() {
                let mut term = term;
                while let Some((parent, _)) = parent(&term) {
                    parts.insert(parent.clone());
                    term = parent;
                }
            }
            sorted(parts, &degrees)
        };
        let (outer, mut inner) = (table(true), table(false));
        let at = |table: &[Term]| -> HashMap<Term, u16> {
            table.iter().enumerate().map(|(k, t)| (t.clone(), k as u16)).collect()
        };
        let (at_outer, at_inner) = (at(&outer), at(&inner));
        inner.resize(inner.len().next_multiple_of(LANES), Term::new());
        Self { degrees, outer, inner, is_outer, at_outer, at_inner }
    }

    /// Coefficients of one function of a fit.
    pub fn blocks(&self, fit: &Fit, column: usize) -> Blocks {
        let mut blocks = Blocks::new();
        let coefficients = fit.coefficients.chunks_exact(fit.functions.len());
        for (term, coefficients) in fit.terms.iter().zip(coefficients) {
            let (outer, inner) = self.position(term);
            let block = blocks.entry([outer, inner / LANES as u16]).or_insert([0.0; LANES]);
            block[usize::from(inner) % LANES] = coefficients[column];
        }
        blocks
    }

    fn position(&self, term: &Term) -> (u16, u16) {
        let part = |outer: bool| -> Term {
            let entries = term.iter().zip(&self.is_outer);
            entries.map(|(k, is)| if *is == outer { *k } else { 0 }).collect()
        };
        // Every part is in its table, from which the tables were made.
        (self.at_outer[&part(true)], self.at_inner[&part(false)])
    }

    /// Values of the outer and inner products at z.
    pub fn values(&self, z: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let value = |table: &[Term]| {
            let mut values = vec![0.0; table.len()];
            let real = table.iter().take_while(|t| !t.is_empty()).count();
            super::fit::products(&table[..real], z, &mut values[..real]);
            values
        };
        (value(&self.outer), value(&self.inner))
    }

    /// The tables of the evaluator.
    pub fn products(&self) -> [Products<'static>; 2] {
        let table = |terms: &[Term], at: &HashMap<Term, u16>| {
            let one = |term: &Term| match parent(term) {
                Some((parent, argument)) => {
                    let before: u16 = self.degrees[..argument].iter().sum();
                    (at[&parent], before + u16::from(term[argument]) - 1)
                }
                None => (0, 0),
            };
            let (parents, factors): (Vec<u16>, Vec<u16>) = terms.iter().map(one).unzip();
            Products { parents: parents.into(), factors: factors.into() }
        };
        [table(&self.outer, &self.at_outer), table(&self.inner, &self.at_inner)]
    }
}

/// The term without its last polynomial, and that one's argument.
fn parent(term: &Term) -> Option<(Term, usize)> {
    let argument = term.iter().rposition(|k| *k > 0)?;
    let mut parent = term.clone();
    parent[argument] = 0;
    Some((parent, argument))
}

/// By their degree relative to the highest: what is small together stands together.
fn sorted(terms: BTreeSet<Term>, degrees: &[u16]) -> Vec<Term> {
    let weight = |term: &Term| -> f64 {
        let entries = term.iter().zip(degrees).filter(|(_, d)| **d > 0);
        entries.map(|(k, d)| f64::from(*k) / f64::from(*d)).sum()
    };
    let mut sorted: Vec<Term> = terms.into_iter().collect();
    sorted.sort_by(|a, b| weight(a).total_cmp(&weight(b)).then_with(|| a.cmp(b)));
    sorted
}
